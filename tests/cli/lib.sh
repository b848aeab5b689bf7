# Shared by the tests of the command; each test sources it first. Environment:
#   CVOL            the command
#   CVOL_HELPERS    the folder of make_volume, make_terms, json_get, poke, unpack and decode_planes
#   CVOL_DOC        the folder of the documents
#   CVOL_SAMPLES    the folder of the sample scan
#   CVOL_TEST_DATA  the folder of larger real volumes; it may be missing
# Each test runs in an empty folder, which is deleted when the test ends. A check that fails prints its command and
# the result; the test continues, and fails at its end. Variables that begin with lib_ are private to this file.
# shellcheck shell=sh
set -eu
PATH=$CVOL_HELPERS:$PATH
LC_ALL=C
# A sanitizer error must not look like a failure of the command itself.
ASAN_OPTIONS=${ASAN_OPTIONS:+$ASAN_OPTIONS:}exitcode=99
UBSAN_OPTIONS=${UBSAN_OPTIONS:+$UBSAN_OPTIONS:}exitcode=99
# Waiting threads sleep, so that parallel tests do not slow each other down.
OMP_WAIT_POLICY=passive
export OMP_WAIT_POLICY PATH LC_ALL ASAN_OPTIONS UBSAN_OPTIONS

top=$(mktemp -d "${TMPDIR:-/tmp}/cvol-cli-XXXXXX")
out=$top/stdout
err=$top/stderr
mounted=
mkdir "$top/work"
: >"$out"
: >"$err"
: >"$top/failures"
cd "$top/work"

at_exit() {
    lib_end=$?
    trap - EXIT
    cd /
    [ -z "$mounted" ] || umount "$mounted" 2>/dev/null || :
    if [ -s "$top/failures" ]; then
        echo "$(wc -l <"$top/failures") checks failed"
        lib_end=1
    elif [ "$lib_end" -ne 0 ]; then
        echo "ended early, with status $lib_end; the last command was: $command_run"
    fi
    rm -rf "$top"
    exit "$lib_end"
}
trap at_exit EXIT
trap 'exit 1' HUP INT TERM

# The command, under the name that users type.
cvol() {
    "$CVOL" "$@"
}

command_run='(none)'
status=0

# run COMMAND...: writes its output to $out and $err, its status to $status.
run() {
    command_run=$*
    status=0
    "$@" >"$out" 2>"$err" </dev/null || status=$?
}

# fail MESSAGE: records a failure and prints the last command.
fail() {
    echo "$1" >>"$top/failures"
    printf 'FAILED: %s\n  command: %s\n  status:  %s\n' "$1" "$command_run" "$status"
    sed -n '1,20s/^/  stdout:  /p' "$out"
    sed -n '1,20s/^/  stderr:  /p' "$err"
}

# expect_status N COMMAND...
expect_status() {
    lib_status=$1
    shift
    run "$@"
    [ "$status" -eq "$lib_status" ] || fail "status must be $lib_status"
}

# expect_sentence PATTERN: stderr has exactly one line. It begins with 'cvol: ' and contains PATTERN (a shell
# pattern, as in case).
expect_sentence() {
    sentence=
    lib_more=
    lib_lines=0
    {
        if IFS= read -r sentence; then lib_lines=1; fi
        if IFS= read -r lib_more || [ -n "$lib_more" ]; then lib_lines=2; fi
    } <"$err"
    case $lib_lines$sentence in
    "1cvol: "*$1*) ;;
    *) fail "stderr must be one sentence of cvol with: $1" ;;
    esac
}

# stderr, or stdout, is empty.
expect_quiet() {
    [ ! -s "$err" ] || fail 'stderr must be empty'
}
expect_no_output() {
    [ ! -s "$out" ] || fail 'stdout must be empty'
}

# Sets $names to the names in the folder, with hidden ones.
list_names() {
    set -- * .[!.]*
    names=$*
}

# expect_done COMMAND...: the status is 0 and stderr is empty.
expect_done() {
    expect_status 0 "$@"
    expect_quiet
}

# expect_failure STATUS PATTERN COMMAND...: the command fails with one sentence, prints nothing on stdout, and
# creates no file. With CVOL_FEWER one in five checks runs, also in loops of two, three or four.
lib_failures=0
expect_failure() {
    lib_failures=$((lib_failures + 1))
    if [ -n "${CVOL_FEWER-}" ] && [ $((lib_failures % 5)) != 1 ]; then return 0; fi
    lib_failure=$1
    lib_pattern=$2
    shift 2
    list_names
    lib_names=$names
    expect_status "$lib_failure" "$@"
    expect_sentence "$lib_pattern"
    expect_no_output
    list_names
    [ "$names" = "$lib_names" ] || fail "the folder must not change; it has: $names"
}

expect_no_file() {
    if [ -e "$1" ] || [ -L "$1" ]; then fail "$1 must not exist"; fi
}
expect_same_file() {
    cmp -s "$1" "$2" || fail "$1 and $2 must have the same bytes"
}
expect_other_file() {
    if cmp -s "$1" "$2"; then fail "$1 and $2 must differ"; fi
}

# expect_number A OPERATOR B: the OPERATOR is one of awk: < <= == >= >
expect_number() {
    are_numbers "$1" "$3" || return 0
    awk "BEGIN { exit !(($1) $2 ($3)) }" || fail "$1 $2 $3 must hold"
}
# expect_near A B TOLERANCE
expect_near() {
    are_numbers "$1" "$2" || return 0
    awk "BEGIN { d = ($1) - ($2); exit !(d <= $3 && d >= -($3)) }" ||
        fail "$1 must be within $3 of $2"
}
are_numbers() {
    for lib_number; do
        case $lib_number in
        '' | *[!0-9.eE+-]*)
            fail "'$lib_number' must be a number"
            return 1
            ;;
        esac
    done
}
expect_equal() {
    [ "$1" = "$2" ] || fail "'$1' must be '$2'"
}

# value_of KEY [KIND]: prints the value of KEY in the JSON object on stdout. The PSNR of equal data is null there;
# it prints 999.
value_of() {
    case $1 in
    *psnr*_db) set -- "$1" decibels ;;
    esac
    lib_value=$(json_get "$@" <"$out" 2>"$top/json") || {
        fail "stdout must be one JSON object with ${2:-a value} at $1: $(cat "$top/json")" >&2
        lib_value=0
    }
    [ "${2-}$lib_value" != decibelsnull ] || lib_value=999
    printf '%s\n' "$lib_value"
}
# expect_field KEY KIND
expect_field() {
    json_get "$1" "$2" <"$out" >/dev/null 2>"$top/json" ||
        fail "stdout must be one JSON object with $2 at $1: $(cat "$top/json")"
}

# make_nrrd OUT RAW TYPE NX NY NZ [LINE...]: writes an attached NRRD of the raw samples, with additional header
# lines.
make_nrrd() {
    lib_nrrd=$1
    lib_raw=$2
    printf 'NRRD0004\ntype: %s\ndimension: 3\nsizes: %s %s %s\nencoding: raw\nendian: little\n' \
        "$3" "$4" "$5" "$6" >"$lib_nrrd"
    shift 6
    {
        for lib_line; do printf '%s\n' "$lib_line"; done
        echo
        cat "$lib_raw"
    } >>"$lib_nrrd"
}
