#!/bin/sh
# Writes the completions of bash, zsh and fish for cvol's commands and options, from the output of --help.
# usage: scripts/help_to_completion.sh CVOL FOLDER      writes cvol.bash, _cvol and cvol.fish there
set -eu
cvol=$1
folder=$2
mkdir -p "$folder"
# Prints lines of command, option, argument or '-', and help, separated by tabs. The command itself has option '-'.
"$cvol" --help | sed -n '/^Commands:/,/^$/s/^  \([a-z]*\)  *\(.*\)/\1	-	-	\2/p' >"$folder/.table"
for command in $(cut -f 1 "$folder/.table"); do
    "$cvol" "$command" --help | awk -v command="$command" '
        /^Examples:/ { exit }
        /^  -/ {
            text = substr($0, 3)
            at = match(text, /   *[^ ]/)
            help = substr(text, at)
            sub(/^ +/, "", help)
            count = split(substr(text, 1, at - 1), words, " ")
            print command "\t" words[1] "\t" (count > 1 ? words[2] : "-") "\t" help
        }' >>"$folder/.table"
done

# Prints the values of an option whose help lists them, as in "dct (default), dht or dft".
choices='
    function choices(argument, help,    words, n, i, found, count) {
        if (argument !~ /^(TYPE|MODE|NAME|ENGINE|EFFORT|ORDER|PLANE|WHAT)$/)
            return ""
        gsub(/ ?\([^)]*\)/, "", help)
        n = split(help, words, /[,;] +(or +)?| or /)
        # The list may follow a colon, as in "splat, transform: order of slices: front or back".
        for (i = 1; i < n && words[i] !~ /: /; i++)
            ;
        if (words[i] !~ /: /)
            i = 1
        for (; i <= n; i++) {
            sub(/^.*: /, "", words[i])
            if (words[i] !~ /^[a-z][a-z0-9-]*$/)
                break
            if (index(" " found " ", " " words[i] " "))
                continue
            found = (count++ ? found " " : "") words[i]
        }
        return count > 1 ? found : ""
    }'

awk -F '\t' "$choices"'
    $2 == "-" { commands = commands " " $1; next }
    {
        options[$1] = options[$1] " " $2
        if ($3 != "-") takes[$1] = takes[$1] "|" $2
        list = choices($3, $4)
        if (list != "") words = words "    " $1 "\\ " $2 ") COMPREPLY=($(compgen -W \"" list "\" -- \"$word\")); return ;;\n"
    }
    END {
        print "# bash completion of cvol; made from its --help."
        print "_cvol()\n{\n    local word=${COMP_WORDS[COMP_CWORD]} before=${COMP_WORDS[COMP_CWORD-1]} command=${COMP_WORDS[1]} options="
        print "    COMPREPLY=()\n    if [ \"$COMP_CWORD\" -eq 1 ]; then"
        print "        COMPREPLY=($(compgen -W \"" substr(commands, 2) " --help --version\" -- \"$word\"))\n        return\n    fi"
        print "    case $command\\ $before in"
        printf "%s", words
        print "    esac\n    case $command in"
        n = split(substr(commands, 2), names, " ")
        for (i = 1; i <= n; i++)
            print "    " names[i] ") options=\"" substr(options[names[i]], 2) "\" ;;"
        print "    esac\n    case $word in"
        print "    -*) COMPREPLY=($(compgen -W \"$options\" -- \"$word\")) ;;"
        print "    *) compopt -o filenames 2>/dev/null; COMPREPLY=($(compgen -f -- \"$word\")) ;;\n    esac\n}"
        print "complete -F _cvol cvol"
    }' "$folder/.table" >"$folder/cvol.bash"

awk -F '\t' "$choices"'
    function quote(text) {
        gsub(/\047/, "\047\\\047\047", text)
        gsub(/\\/, "\\\\", text)
        gsub(/\[/, "\\[", text)
        gsub(/\]/, "\\]", text)
        gsub(/:/, "\\:", text)
        return text
    }
    BEGIN { print "#compdef cvol\n# zsh completion of cvol; made from its --help.\n\n_cvol()\n{\n    local -a commands"; print "    commands=(" }
    $2 == "-" { print "        \047" $1 ":" quote($4) "\047"; order[++n] = $1; next }
    {
        list = choices($3, $4)
        value = $3 == "-" ? "" : ":" quote($3) ":" (list != "" ? "(" list ")" : "_files")
        lines[$1] = lines[$1] " \\\n            \047" $2 "[" quote($4) "]" value "\047"
    }
    END {
        print "    )\n    if ((CURRENT == 2)); then\n        _describe command commands\n        return\n    fi"
        print "    local command=$words[2]\n    shift words\n    ((CURRENT--))\n    case $command in"
        for (i = 1; i <= n; i++)
            print "    " order[i] ")\n        _arguments" lines[order[i]] " \\\n            \047*:file:_files\047\n        ;;"
        print "    esac\n}\n\n_cvol \"$@\""
    }' "$folder/.table" >"$folder/_cvol"

awk -F '\t' "$choices"'
    function quote(text) {
        gsub(/\\/, "\\\\", text)
        gsub(/\047/, "\\\047", text)
        return text
    }
    BEGIN { print "# fish completion of cvol; made from its --help." }
    $2 == "-" { print "complete -c cvol -f -n __fish_use_subcommand -a " $1 " -d \047" quote($4) "\047"; next }
    {
        name = $2
        sub(/^-+/, "", name)
        list = choices($3, $4)
        print "complete -c cvol -n \047__fish_seen_subcommand_from " $1 "\047 " (length(name) > 1 ? "-l " : "-s ") name \
            ($3 == "-" ? "" : " -r") (list == "" ? "" : " -f -a \047" list "\047") " -d \047" quote($4) "\047"
    }' "$folder/.table" >"$folder/cvol.fish"
rm -f "$folder/.table"
