#!/bin/sh
# Runs the blocks of the documents, one by one: commands (```sh), C programs (```c, compiled with the public
# headers) and Python (```python), in an empty folder with the samples, folders of slices, stand-ins for the
# readers' own files, and the outputs of earlier blocks. Last it runs the demo. The tests of the Python package run
# the Python code of the two READMEs.
#
# A block of output (```text) must agree, number by number (check_figures.py), with the output of the last command
# before it for the whole scan. To save time the other blocks and the demo use a scan of the same size that is empty
# above its lowest 80 slices. Other measured figures of README.md, guide.md and pictures.md must be in a
# section that names the program in bench/ that measures them. Links between documents must lead to existing headings.
# usage: tests/check_docs.sh SOURCE_FOLDER CVOL LIBRARY_SO COMPILER [DOCUMENT...]
set -eu
source=$(cd "$1" && pwd)
PATH=$(cd "$(dirname "$2")" && pwd):$PATH
library=$3
compiler=$4
python=/usr/bin/python3 # the system's Python has the packages of the other programs
[ -x "$python" ] || python=python3
CVOL_LIBRARY=$library
PYTHONPATH=$source/python
PYTHONDONTWRITEBYTECODE=1
OMP_WAIT_POLICY=passive
[ "$python" = python3 ] || PATH=${PATH%%:*}:/usr/bin:$PATH # python3 in commands
export PATH CVOL_LIBRARY PYTHONPATH PYTHONDONTWRITEBYTECODE OMP_WAIT_POLICY

HDF5_PLUGIN_PATH=$(cd "$(dirname "$2")" && pwd)/hdf5-plugins
export HDF5_PLUGIN_PATH

shift 4
if [ $# -eq 0 ]; then
    set -- README.md doc/guide.md doc/pictures.md doc/recipes.md doc/method.md doc/reference/main.md
    if [ -d "$HDF5_PLUGIN_PATH" ] && command -v h5repack >/dev/null && "$python" -c 'import h5py' 2>/dev/null; then
        set -- "$@" doc/hdf5.md
    else
        echo 'doc/hdf5.md: skipped: there is no filter, no h5repack or no h5py'
    fi
    if "$python" -c 'import zarr' 2>/dev/null; then
        set -- "$@" doc/zarr.md
    else
        echo 'doc/zarr.md: skipped: there is no zarr'
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
"$python" "$source/tests/make_standins.py"
for name in head tooth; do cvol compress $name.nrrd $name.cvol >output; done
ln -s "$source/bench" bench
"$python" "$source/tests/check_links.py" "$source"
for document in README.md doc/guide.md doc/pictures.md; do
    "$python" "$source/tests/check_figures.py" prose "$source/$document"
done
folders=yes # folders of slices; their writers are Python packages
"$python" "$source/tests/make_formats.py" folders || folders=

# run WHAT COMMAND...: prints the output if the command fails. Python code that lacks a module is skipped.
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

# Several documents begin with the same compression: it runs once, until another one writes the same file.
: >compressed
runs_again() { # COMMAND
    case $1 in
    'cvol compress '*' '*)
        grep -qxF -- "$1" compressed && return 0
        output_name=$(echo "$1" | cut -d' ' -f4)
        awk -v name="$output_name" '$4 != name' compressed >kept
        mv kept compressed
        echo "$1" >>compressed
        ;;
    esac
    return 1
}

run_commands() { # FILE
    while IFS= read -r command; do
        if runs_again "$command"; then
            echo "= $command"
            continue
        fi
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

# Prints the output of a command for the whole scan, in a folder with brain.cvol and the outputs of such commands.
expect_output() { # FILE COMMAND
    if [ ! -d whole ]; then
        mkdir -p whole/samples
        ln -s ../../all.nii.gz whole/samples/ch2better.nii.gz
    fi
    case $2 in
    *' brain.cvol') ;; # makes it
    *) [ -e whole/brain.cvol ] || (cd whole && cvol compress samples/ch2better.nii.gz brain.cvol >/dev/null) ;;
    esac
    echo "+ on the whole scan: $2"
    (cd whole && sh -c "$2") >printed 2>/dev/null || {
        echo "$document: '$2' fails on the whole scan" >&2
        exit 1
    }
    "$python" "$source/tests/check_figures.py" output "$1" printed || {
        echo "$document: put the printed text into the block after '$2', rounded as you like" >&2
        exit 1
    }
}

for document in $documents; do
    rm -f blocks/*
    awk '/^```(sh|c|python|text)$/ { on = 1; name = sprintf("blocks/%03d.%s", ++n, substr($0, 4)); next }
         /^```$/ { on = 0 } on { print > name }' "$source/$document"
    set -- blocks/*
    [ -s "$1" ] || { echo "$document has no block that can run" >&2; exit 1; }
    for block in "$@"; do
        case $block in
        *.sh)
            run_commands "$block"
            last=$(tail -1 "$block")
            ;;
        *.text) expect_output "$block" "$last" ;;
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
            [ -s brain.png ] || { echo "$document: the C program wrote no picture" >&2; exit 1; }
            ;;
        esac
    done
done

echo '+ the demo'
sh "$source/scripts/demo.sh" cvol
[ -s demo/brain.png ] || { echo 'the demo wrote no picture' >&2; exit 1; }
cvol render demo/brain.cvol -o default.png >/dev/null
cmp default.png demo/brain.png || { echo 'the demo must show the default picture, whole' >&2; exit 1; }
