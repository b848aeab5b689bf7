#!/bin/sh
# Writes a manual page for cvol and for each of its subcommands, from the output of --help.
# usage: scripts/help_to_man.sh CVOL FOLDER
set -eu
cvol=$1
folder=$2
mkdir -p "$folder"
version=$("$cvol" --version)
"$cvol" --help >"$folder/.help"
# "  name    summary" of every command.
sed -n '/^Commands:/,/^$/s/^  \([a-z]*\)  *\(.*\)/\1 \2/p' "$folder/.help" >"$folder/.commands"

# page NAME SUMMARY HELP_FILE: prints the page as roff.
page() {
    awk -v name="$1" -v summary="$2" -v version="$version" '
    function roff(text) {
        gsub(/\\/, "\\e", text)
        gsub(/-/, "\\-", text)
        if (text ~ /^[.\047]/)
            text = "\\&" text
        return text
    }
    # Words of options and commands are bold; arguments are unchanged.
    function entry(text,    word, rest) {
        word = text
        sub(/ .*/, "", word)
        rest = substr(text, length(word) + 1)
        print ".TP"
        print "\\fB" roff(word) "\\fR" roff(rest)
    }
    function section(title) {
        if (title != current)
            print ".SH " title
        current = title
    }
    BEGIN {
        printf ".TH %s 1 \"\" \"%s\" \"User Commands\"\n", toupper(roff(name)), roff(version)
        print ".nh\n.ad l"
        print ".SH NAME\n" roff(name) " \\- " roff(summary)
    }
    NR == 1 {
        sub(/^usage: /, "")
        section("SYNOPSIS")
        print ".B " roff($0)
        next
    }
    examples { if ($0 != "") print roff($0); next }
    /^Examples:$/ { examples = 1; section("EXAMPLES"); print ".nf"; next }
    $0 == "" { blank = 1; next }
    /^  [^ ]/ {
        if (heading == "" && current != "OPTIONS" && current != "COMMANDS")
            section(/^  -/ ? "OPTIONS" : "COMMANDS")
        text = substr($0, 3)
        at = match(text, /   *[^ ]/)
        if (current == "DESCRIPTION" || !at) {
            print ".PP\n.EX\n" roff(text) "\n.EE"
            next
        }
        entry(substr(text, 1, at - 1))
        help = substr(text, at)
        sub(/^ +/, "", help)
        print roff(help)
        next
    }
    /^Commands:$/ { section("COMMANDS"); heading = $0; next }
    /:$/ && !/\. / && NR > 3 && blank {
        section("OPTIONS")
        heading = $0
        print ".SS " roff(substr($0, 1, length($0) - 1))
        blank = 0
        next
    }
    {
        if (current != "COMMANDS")
            section("DESCRIPTION")
        if (blank)
            print ".PP"
        blank = 0
        print roff($0)
    }
    END { if (examples) print ".fi" }' "$3"
    printf '.SH EXIT STATUS\n0: done; 1: failed, with one sentence why; 2: misused.\n.SH SEE ALSO\n'
    printf '\\fBcvol\\fR(1)'
    while read -r other _; do printf ', \\fBcvol\\-%s\\fR(1)' "$other"; done <"$folder/.commands"
    echo
}

page cvol 'volume data that stays compressed' "$folder/.help" >"$folder/cvol.1"
while read -r command summary; do
    "$cvol" "$command" --help >"$folder/.help"
    page "cvol-$command" "$summary" "$folder/.help" >"$folder/cvol-$command.1"
done <"$folder/.commands"
rm -f "$folder/.help" "$folder/.commands"
