#!/bin/sh
# The checks of lib.sh themselves: what is right passes, what is wrong fails, and says so.
lib=$(cd "$(dirname "$0")" && pwd)/lib.sh
. "$lib"

# A stand-in for the command.
cat >says <<'END'
#!/bin/sh
# says STATUS STDOUT STDERR [FILE]
printf "$2"
printf "$3" >&2
[ $# -lt 4 ] || : >"$4"
exit "$1"
END
chmod +x says
says=$PWD/says

# passes CHECKS, fails CHECKS: these lines as a test of their own.
passes() {
    expect_status 0 sh -c ". '$lib'; $1"
}
fails() {
    run sh -c ". '$lib'; $1"
    [ "$status" -ne 0 ] || fail 'this must fail'
    cat "$out" "$err" | grep -q -e '^FAILED: ' -e '^ended early' || fail 'must say what failed'
}

passes 'expect_status 3 '"$says"' 3 "" ""'
fails 'expect_status 0 '"$says"' 3 "" ""'
fails 'expect_status 1 '"$says"' 0 "" ""'
fails 'expect_status 1 sh -c "kill -SEGV \$\$"'
fails 'false'
fails 'no_such_check 1'

passes 'run '"$says"' 1 "" "cvol: a file: broken\n"; expect_sentence "file*broken"'
fails 'run '"$says"' 1 "" "cvol: a file: broken\n"; expect_sentence "whole"'
fails 'run '"$says"' 1 "" "cvol: a file: broken"; expect_sentence "broken"'
fails 'run '"$says"' 1 "" "cvol: broken\nmore\n"; expect_sentence "broken"'
fails 'run '"$says"' 1 "" "cvol: broken\nmore"; expect_sentence "broken"'
fails 'run '"$says"' 1 "" "cvol: broken\n\n"; expect_sentence "broken"'
fails 'run '"$says"' 1 "" "broken\n"; expect_sentence "broken"'
fails 'run '"$says"' 1 "" ""; expect_sentence ""'

passes 'expect_done '"$says"' 0 "text\n" ""'
fails 'expect_done '"$says"' 0 "text\n" "progress"'
passes 'expect_failure 2 broken '"$says"' 2 "" "cvol: broken\n"'
fails 'expect_failure 1 broken '"$says"' 2 "" "cvol: broken\n"'
fails 'expect_failure 2 broken '"$says"' 2 "text" "cvol: broken\n"'
fails 'expect_failure 2 broken '"$says"' 2 "" "cvol: broken\n" left'
fails 'expect_failure 2 broken '"$says"' 2 "" "cvol: broken\n" .left'

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

passes 'run '"$says"' 0 "{\"a\": {\"b\": [1, 2.5]}}" ""; expect_equal "$(value_of a.b.1 number)" 2.5'
passes 'run '"$says"' 0 "{\"a\": 1}" ""; expect_field a integer; expect_field a number'
fails 'run '"$says"' 0 "{\"a\": 1.5}" ""; expect_field a integer'
fails 'run '"$says"' 0 "{\"a\": 1}" ""; expect_field b integer'
fails 'run '"$says"' 0 "{\"a\": 1}" ""; value_of b >/dev/null'
fails 'run '"$says"' 0 "{\"a\": 1} more" ""; expect_field a integer'
fails 'run '"$says"' 0 "{\"a\": 1}{}" ""; expect_field a integer'
fails 'run '"$says"' 0 "more {\"a\": 1}" ""; expect_field a integer'
fails 'run '"$says"' 0 "[1]" ""; expect_field 0 integer'
fails 'run '"$says"' 0 "" ""; expect_field a integer'
