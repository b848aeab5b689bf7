#!/bin/sh
# Runs what the documents show, block by block: commands (```sh), C programs (```c, compiled against the
# public headers) and Python (```python), and the demo, in an empty folder that has the samples, folders of
# slices, and what the blocks before have made. The demo sees all of the scan; for the rest it is as large, but
# empty above its lowest 80 slices, which takes less time. Python of the two READMEs is run by the tests of the
# package.
# usage: tests/check_docs.sh SOURCE_FOLDER CVOL LIBRARY_SO COMPILER [DOCUMENT...]
set -eu
source=$(cd "$1" && pwd)
PATH=$(cd "$(dirname "$2")" && pwd):$PATH
library=$3
compiler=$4
python=/usr/bin/python3 # the system's, which has the other programs' packages
[ -x "$python" ] || python=python3
CVOL_LIBRARY=$library
PYTHONPATH=$source/python
PYTHONDONTWRITEBYTECODE=1
OMP_WAIT_POLICY=passive
[ "$python" = python3 ] || PATH=${PATH%%:*}:/usr/bin:$PATH # what commands call python3
export PATH CVOL_LIBRARY PYTHONPATH PYTHONDONTWRITEBYTECODE OMP_WAIT_POLICY

HDF5_PLUGIN_PATH=$(cd "$(dirname "$2")" && pwd)/hdf5-plugins
export HDF5_PLUGIN_PATH

shift 4
if [ $# -eq 0 ]; then
    set -- README.md doc/guide.md doc/recipes.md doc/method.md doc/reference/main.md
    if [ -d "$HDF5_PLUGIN_PATH" ] && command -v h5repack >/dev/null && "$python" -c 'import h5py' 2>/dev/null; then
        set -- "$@" doc/hdf5.md
    else
        echo 'doc/hdf5.md: skipped: there is no filter, no h5repack or no h5py'
    fi
fi
documents=$*

work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
cd "$work"
mkdir samples blocks
cp "$source"/samples/* samples
slice=$((301 * 370))
{
    gzip -dc "$source/samples/ch2better.nii.gz" | head -c $((352 + slice * 80))
    head -c $((slice * 236)) /dev/zero
} | gzip -1 >empty.nii.gz
mv samples/ch2better.nii.gz all.nii.gz
mv empty.nii.gz samples/ch2better.nii.gz
folders=yes # of slices, for which Python's packages are needed
"$python" "$source/tests/make_formats.py" folders || folders=

# run WHAT COMMAND...: shows what it said if it fails. Python that lacks another's module is skipped.
run() {
    what=$1
    shift
    if "$@" >output 2>&1 </dev/null; then return 0; fi
    case $(tail -1 output) in
    "ModuleNotFoundError: No module named 'cvol'"*) ;;
    "ModuleNotFoundError: "*)
        echo "  skipped: $(tail -1 output)"
        return 0
        ;;
    esac
    echo "$document: $what failed:" >&2
    cat output >&2
    exit 1
}

run_commands() { # FILE
    while IFS= read -r command; do
        case $command in
        *' slices '* | *' dicom '*)
            if [ -z "$folders" ]; then
                echo "  skipped: $command"
                continue
            fi
            ;;
        esac
        echo "+ $command"
        run "'$command'" sh -c "$command"
    done <"$1"
}

for document in $documents; do
    rm -f blocks/*
    awk '/^```(sh|c|python)$/ { on = 1; name = sprintf("blocks/%03d.%s", ++n, substr($0, 4)); next }
         /^```$/ { on = 0 } on { print > name }' "$source/$document"
    set -- blocks/*
    [ -s "$1" ] || { echo "$document shows nothing" >&2; exit 1; }
    for block in "$@"; do
        case $block in
        *.sh) run_commands "$block" ;;
        *.py*)
            [ "$document" != README.md ] || continue
            echo "+ python: $(grep -v '^$' "$block" | head -1)"
            run "Python '$(cat "$block")'" "$python" -W error::SyntaxWarning "$block"
            ;;
        *.c)
            if [ ! -e "$library" ]; then
                echo '  skipped: a C program; this build has no shared library'
                continue
            fi
            echo '+ a C program'
            rm -f brain.png
            run 'compiling the C program' "$compiler" -std=c11 -O1 -Wall -Wextra -Wpedantic -Werror -I"$source/include" \
                "$block" "$library" "-Wl,-rpath,$(dirname "$library")" -lm -o program
            run 'the C program' ./program
            [ -s brain.png ] || { echo "$document: the C program left no picture" >&2; exit 1; }
            ;;
        esac
    done
done

mv all.nii.gz samples/ch2better.nii.gz
echo '+ the demo'
sh "$source/scripts/demo.sh" cvol
[ -s demo/brain.png ] || { echo 'the demo left no picture' >&2; exit 1; }
