#!/bin/sh
# Fails if clang-format would change a C source or header, or if clang-tidy reports an error (.clang-tidy) in a
# source that is not a kernel. A missing tool is skipped with a message.
# usage: scripts/lint.sh BUILD_FOLDER JOBS     the folder has compile_commands.json
set -eu
build=$1
jobs=$2
cd "$(dirname "$0")/.."

# list PATTERN...: prints the files of a checkout, or of an unpacked archive.
list() { # PATTERN...
    git ls-files -- "$@" 2>/dev/null | grep . || find . -path './build*' -prune -o -type f -name "$1" -print
}

if command -v clang-format >/dev/null 2>&1; then
    { list '*.c'; list '*.h'; } | xargs -P "$jobs" -n 40 clang-format --dry-run -Werror || {
        echo 'lint: clang-format would change the files above: run make format' >&2
        exit 1
    }
    echo 'lint: clang-format changes nothing'
else
    echo 'skipped: no clang-format'
fi

if command -v clang-tidy >/dev/null 2>&1; then
    sed -n 's/^ *"file": "\(.*\)",*$/\1/p' "$build/compile_commands.json" | grep '\.c$' | grep -v '_simd\.c$' |
        grep -v -e "^$(cd "$build" && pwd)/" -e /third_party/ | sort -u >"$build/lint.txt"
    xargs -P "$jobs" -n 20 clang-tidy -p "$build" --quiet --extra-arg=-Wno-error <"$build/lint.txt" >"$build/lint.log" 2>/dev/null || {
        grep -A 6 -E '(warning|error):' "$build/lint.log" >&2
        echo 'lint: clang-tidy reports the errors above' >&2
        exit 1
    }
    echo "lint: clang-tidy finds no error in $(wc -l <"$build/lint.txt") files"
else
    echo 'skipped: no clang-tidy'
fi
