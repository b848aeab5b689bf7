#!/bin/sh
# Runs the tests of the Python package with the built library, by the first Python that has NumPy and pytest;
# without one they are skipped (77).
# usage: tests/check_python.sh SOURCE_FOLDER LIBRARY
set -eu
for python in python3 /usr/bin/python3; do
    if "$python" -c 'import numpy, pytest' 2>/dev/null; then
        cd "$1/python"
        export CVOL_LIBRARY="$2" PYTHONDONTWRITEBYTECODE=1 OMP_WAIT_POLICY=passive
        exec "$python" -m pytest -q -p no:cacheprovider --durations=5 -rs tests
    fi
done
echo 'skipped: no Python with NumPy and pytest'
exit 77
