#!/bin/sh
# Makes the wheel of `make wheel` from the objects of a build and tests it, by the first Python that has NumPy. Skipped
# (77) without one, or without patchelf and the static libraries.
# usage: tests/check_wheel.sh SOURCE_FOLDER BUILD_FOLDER
set -eu
for python in /usr/bin/python3 python3; do
    if "$python" -c 'import numpy' 2>/dev/null; then
        export OMP_WAIT_POLICY=passive PYTHONDONTWRITEBYTECODE=1
        exec "$python" "$1/tests/wheel/test_wheel.py" "$1" "$2" "$2/wheel-test"
    fi
done
echo 'skipped: no Python with NumPy'
exit 77
