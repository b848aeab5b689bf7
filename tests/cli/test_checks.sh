#!/bin/sh
# Tests the checks of lib.sh: correct results pass; wrong results fail and print why.
lib=$(cd "$(dirname "$0")" && pwd)/lib.sh
. "$lib"

# A stand-in for the command.
cat >fake_command <<'END'
#!/bin/sh
# fake_command STATUS STDOUT STDERR [FILE]
printf "$2"
printf "$3" >&2
[ $# -lt 4 ] || : >"$4"
exit "$1"
END
chmod +x fake_command
fake_command=$PWD/fake_command

# passes CHECKS, fails CHECKS: runs these lines as a separate test.
passes() {
    expect_status 0 sh -c ". '$lib'; $1"
}
fails() {
    run sh -c ". '$lib'; $1"
    [ "$status" -ne 0 ] || fail 'the checks must fail'
    cat "$out" "$err" | grep -q -e '^FAILED: ' -e '^ended early' || fail 'must print the failed check'
}

passes 'expect_status 3 '"$fake_command"' 3 "" ""'
fails 'expect_status 0 '"$fake_command"' 3 "" ""'
fails 'expect_status 1 '"$fake_command"' 0 "" ""'
fails 'expect_status 1 sh -c "kill -SEGV \$\$"'
fails 'false'
fails 'no_such_check 1'

passes 'run '"$fake_command"' 1 "" "cvol: a file: broken\n"; expect_sentence "file*broken"'
fails 'run '"$fake_command"' 1 "" "cvol: a file: broken\n"; expect_sentence "whole"'
fails 'run '"$fake_command"' 1 "" "cvol: a file: broken"; expect_sentence "broken"'
fails 'run '"$fake_command"' 1 "" "cvol: broken\nmore\n"; expect_sentence "broken"'
fails 'run '"$fake_command"' 1 "" "cvol: broken\nmore"; expect_sentence "broken"'
fails 'run '"$fake_command"' 1 "" "cvol: broken\n\n"; expect_sentence "broken"'
fails 'run '"$fake_command"' 1 "" "broken\n"; expect_sentence "broken"'
fails 'run '"$fake_command"' 1 "" ""; expect_sentence ""'

passes 'expect_done '"$fake_command"' 0 "text\n" ""'
fails 'expect_done '"$fake_command"' 0 "text\n" "progress"'
passes 'expect_failure 2 broken '"$fake_command"' 2 "" "cvol: broken\n"'
fails 'expect_failure 1 broken '"$fake_command"' 2 "" "cvol: broken\n"'
fails 'expect_failure 2 broken '"$fake_command"' 2 "text" "cvol: broken\n"'
fails 'expect_failure 2 broken '"$fake_command"' 2 "" "cvol: broken\n" left'
fails 'expect_failure 2 broken '"$fake_command"' 2 "" "cvol: broken\n" .left'

passes 'expect_no_file a'
fails 'echo > a; expect_no_file a'
fails 'ln -s nowhere a; expect_no_file a'
passes 'echo > a; echo > b; expect_same_file a b'
fails 'echo > a; expect_same_file a b'
fails 'echo > a; echo b > b; expect_same_file a b'
fails 'echo > a; echo > b; expect_other_file a b'

passes 'expect_number 2.5e1 ">=" 25; expect_near 1.01 1 0.02; expect_equal a a'
fails 'expect_number 2.5e1 "<" 25'
fails 'expect_number "" "==" 0'
fails 'expect_number null "==" 0'
fails 'expect_near 1.01 1 0.001'
fails 'expect_near 0.99 1 0.001'
fails 'expect_equal a b'

passes 'run '"$fake_command"' 0 "{\"a\": {\"b\": [1, 2.5]}}" ""; expect_equal "$(value_of a.b.1 number)" 2.5'
passes 'run '"$fake_command"' 0 "{\"a\": 1}" ""; expect_field a integer; expect_field a number'
fails 'run '"$fake_command"' 0 "{\"a\": 1.5}" ""; expect_field a integer'
fails 'run '"$fake_command"' 0 "{\"a\": 1}" ""; expect_field b integer'
fails 'run '"$fake_command"' 0 "{\"a\": 1}" ""; value_of b >/dev/null'
fails 'run '"$fake_command"' 0 "{\"a\": 1} more" ""; expect_field a integer'
fails 'run '"$fake_command"' 0 "{\"a\": 1}{}" ""; expect_field a integer'
fails 'run '"$fake_command"' 0 "more {\"a\": 1}" ""; expect_field a integer'
fails 'run '"$fake_command"' 0 "[1]" ""; expect_field 0 integer'
fails 'run '"$fake_command"' 0 "" ""; expect_field a integer'
