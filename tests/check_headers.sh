#!/bin/sh
# Every public header compiles alone, as C11 and, if there is a C++ compiler, as C++.
set -eu
cd "$(dirname "$0")/.."
for header in include/cvol/*.h; do
    if [ "$header" = include/cvol/mpi.h ]; then
        if command -v mpicc >/dev/null 2>&1; then
            mpicc -std=c11 -Wall -Wextra -Werror -Iinclude -fsyntax-only -x c "$header"
        fi
        continue
    fi
    ${CC:-cc} -std=c11 -Wall -Wextra -Wpedantic -Werror -Iinclude -fsyntax-only -x c "$header"
    if command -v "${CXX:-c++}" >/dev/null 2>&1; then
        "${CXX:-c++}" -Wall -Wextra -Wpedantic -Werror -Iinclude -fsyntax-only -x c++ "$header"
    fi
done
echo 'headers: each compiles alone'
