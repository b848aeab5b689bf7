#!/bin/sh
# Builds cvol without optional libraries for several compilers and processors and for Windows, and compares each build
# with that of gcc on this machine: the same tests pass, the golden files decode to the same bits, a sample compresses to
# the same bytes, and pictures by the base set of kernels, which all processors have, differ by at most 1 of 255. The
# table also shows how far they are from pictures by this machine's widest set, which has no bound here. Other processors
# and Windows are emulated. Prints one table; exit status 1 if a build or a comparison fails. A platform whose compiler is
# missing gets a line that says so.
# usage: scripts/portability.sh FOLDER JOBS [PLATFORM...]
# The sources of zlib and cmocka for other processors come from Debian's source packages, unless ZLIB_SOURCE and
# CMOCKA_SOURCE name folders that have them. CVOL_REFERENCE may name a cvol of this machine to compare with; gcc's build
# is not made then. TESTS is a regular expression of the tests to run: where qemu runs them, all take hours.
set -eu
here=$(cd "$(dirname "$0")/.." && pwd)
mkdir -p "$1"
folder=$(cd "$1" && pwd)
jobs=$2
shift 2
export OMP_WAIT_POLICY=passive
command -v ninja >/dev/null 2>&1 && export CMAKE_GENERATOR="${CMAKE_GENERATOR:-Ninja}"
. "$here/scripts/source_package.sh"

# Tests of files, of the folders below the codec, of the codec and of the formats that take seconds, also when they are emulated.
tests='test_options test_files test_elementary test_block test_cell test_chirp test_fft test_lap test_whole test_exact test_split
    test_array_file test_brick_code test_container_parts test_container_sections test_label_code test_tables
    test_true_length test_neural test_metaimage test_nifti test_nrrd test_raw test_volume test_volume_stream'
# shellcheck disable=SC2086  # names are words
tests=$(printf '%s\n' $tests | grep -E "${TESTS:-.}")

# Emulated and further builds: kernels compile in a third of the time of -O3.
fast='-DCMAKE_BUILD_TYPE=RelWithDebInfo -DCMAKE_C_FLAGS_RELWITHDEBINFO=-O1'

# platform NAME: sets what a build needs. `compiler`: the command; `packages`: Debian's, for the message if it is
# missing; `run`: the emulator; `own_zlib`: the system's zlib is of another processor; `ending`: of programs.
platform() {
    compiler=gcc options=$fast packages= run= own_zlib= system= processor= flags= archiver=ar ending=
    case $1 in
    gcc) options= ;; # -O3
    gcc-O0) options='-DCMAKE_BUILD_TYPE=Debug -DCMAKE_C_FLAGS_DEBUG=-O0' ;;
    clang) compiler=clang packages=clang ;;
    i386) # 32 bits, which most kernels run themselves
        compiler=i686-linux-gnu-gcc archiver=i686-linux-gnu-ar own_zlib=yes system=Linux
        run='/usr/i686-linux-gnu/lib/ld-linux.so.2 --library-path /usr/i686-linux-gnu/lib' processor=i686
        packages='gcc-i686-linux-gnu libc6-dev-i386-cross qemu-user-static'
        $run --version >/dev/null 2>&1 || run='qemu-i386-static -L /usr/i686-linux-gnu'
        ;;
    aarch64 | s390x)
        compiler=$1-linux-gnu-gcc archiver=$1-linux-gnu-ar own_zlib=yes system=Linux processor=$1
        run="qemu-$1-static -L /usr/$1-linux-gnu"
        packages="gcc-$1-linux-gnu libc6-dev-$(echo "$1" | sed s/aarch64/arm64/)-cross qemu-user-static"
        ;;
    mingw) # Windows, by the threads of POSIX
        compiler=x86_64-w64-mingw32-gcc-posix archiver=x86_64-w64-mingw32-ar own_zlib=yes system=Windows
        run=wine processor=x86_64 ending=.exe packages='gcc-mingw-w64-x86-64 wine64 wine'
        export WINEPREFIX="$folder/wine" WINEDEBUG=-all
        ;;
    *)
        echo "portability.sh: no such platform: $1 (there are: gcc gcc-O0 clang i386 aarch64 s390x mingw)" >&2
        exit 2
        ;;
    esac
}

# Prints why a platform cannot be checked here, or nothing.
missing() {
    command -v "$compiler" >/dev/null 2>&1 || {
        echo "there is no $compiler (Debian: $packages)"
        return
    }
    for emulator in $run; do
        command -v "$emulator" >/dev/null 2>&1 || echo "there is no $emulator (Debian: $packages)"
        break
    done
    echo '#include <stdio.h>
int main(void) { return 0; }' >"$folder/hello.c"
    # shellcheck disable=SC2086  # flags are words
    $compiler $flags "$folder/hello.c" -o "$folder/hello" 2>"$folder/hello.log" ||
        echo "$compiler $flags cannot compile (Debian: $packages)"
}

build_zlib() { # NAME: zlib for its processor, in $folder/NAME-zlib
    [ ! -e "$folder/$1-zlib/libz.a" ] || return 0
    source=${ZLIB_SOURCE:-$folder/zlib}
    [ -e "$source/zlib.h" ] || fetch zlib
    mkdir -p "$folder/$1-zlib"
    cp "$source/zlib.h" "$source/zconf.h" "$folder/$1-zlib"
    # shellcheck disable=SC2086
    (cd "$folder/$1-zlib" && $compiler $flags -O2 -fPIC -w -DHAVE_UNISTD_H -c "$source"/*.c && $archiver rcs libz.a ./*.o)
}

build() { # NAME
    set -- "$1" -DCVOL_MINIMAL=ON -DCVOL_WERROR=ON -DCVOL_SHARED=OFF -DCVOL_EXAMPLES=OFF -DCVOL_SETS=machine \
        -DCMAKE_C_COMPILER="$compiler" -DCMAKE_C_FLAGS="$flags" -DCVOL_CMOCKA="$cmocka" \
        ${CCACHE:+-DCMAKE_C_COMPILER_LAUNCHER="$CCACHE"}
    if [ -n "$own_zlib" ]; then
        build_zlib "$1" || return 1
        set -- "$@" -DZLIB_LIBRARY="$folder/$1-zlib/libz.a" -DZLIB_INCLUDE_DIR="$folder/$1-zlib" \
            -DCMAKE_SYSTEM_NAME=$system -DCMAKE_SYSTEM_PROCESSOR=$processor
    fi
    name=$1
    shift
    # shellcheck disable=SC2086
    cmake -S "$here" -B "$folder/$name" "$@" $options && cmake --build "$folder/$name" -j "$jobs" --target cvol_command decode_planes \
        $tests
}

run_tests() { # NAME: prints PASSED/ALL
    passed=0 all=0
    for test in $tests; do
        all=$((all + 1))
        # shellcheck disable=SC2086
        if (cd "$folder/$1" && timeout 1200 $run "tests/$test$ending") >"$folder/$1/$test.log" 2>&1; then
            passed=$((passed + 1))
        else
            echo "portability: $1: $test failed, see $folder/$1/$test.log" >&2
        fi
    done
    echo "$passed/$all"
}

check_golden() { # NAME: prints EQUAL/ALL
    equal=0 all=0
    while read -r sum file more; do
        all=$((all + 1))
        # shellcheck disable=SC2086
        case $file in
        *.*) $run "$folder/$1/tests/helpers/decode_planes$ending" "$here/tests/golden/$file" "$work/out.raw" ;;
        *) $run "$folder/$1/cvol$ending" decompress "$here/tests/golden/$file.cvol" "$work/out.raw" $more >/dev/null ;;
        esac || true
        case $(sha256sum "$work/out.raw") in
        "$sum "*) equal=$((equal + 1)) ;;
        *) echo "portability: $1: $file $more decodes to other samples" >&2 ;;
        esac
        rm -f "$work/out.raw"
    done <"$here/tests/golden/CHECKSUMS"
    echo "$equal/$all"
}

# The options of each file that must have the same bytes, and of each picture.
list_files() {
    cat <<-END
		default
		fast --effort fast
		bounded --max-error 2
		lossless --lossless
		max --effort max --bpv 0.2
		whole --block 0 --keep 12,2000
	END
}
list_pictures() {
    cat <<-END
		lit
		flat --light flat --view left
		surface --mode iso --iso 70
		mip --mode mip
	END
}

make_files() { # NAME: prints EQUAL/ALL
    equal=0 all=0
    list_files >"$work/files"
    while read -r file more; do
        all=$((all + 1))
        # shellcheck disable=SC2086
        $run "$folder/$1/cvol$ending" compress "$work/sample.nrrd" "$work/$1-$file.cvol" --threads 1 $more >/dev/null || true
        if cmp -s "$work/reference-$file.cvol" "$work/$1-$file.cvol"; then
            equal=$((equal + 1))
        else
            echo "portability: $1: compress $more makes other bytes than gcc's build" >&2
        fi
    done <"$work/files"
    echo "$equal/$all"
}

draw() { # NAME: prints the largest differences from pictures by the base set, and by the widest
    largest=0 widest=0
    list_pictures >"$work/pictures"
    while read -r picture more; do
        # shellcheck disable=SC2086
        CVOL_CPU=base $run "$folder/$1/cvol$ending" render "$work/reference-default.cvol" -o "$work/$1-$picture.png" --size 128 \
            --threads 1 $more >/dev/null || true
        difference=$(python3 "$here/scripts/picture_difference.py" "$work/base-$picture.png" "$work/$1-$picture.png") || difference=999
        other=$(python3 "$here/scripts/picture_difference.py" "$work/widest-$picture.png" "$work/$1-$picture.png") || other=999
        [ "$difference" -le 1 ] || echo "portability: $1: render $more differs by $difference of 255 from gcc's build" >&2
        [ "$difference" -le "$largest" ] || largest=$difference
        [ "$other" -le "$widest" ] || widest=$other
    done <"$work/pictures"
    echo "$largest|$widest"
}

# The sample, its files and their pictures, with which other builds are compared.
make_reference() { # COMMAND
    "$1" compress "$here/samples/ch2better.nii.gz" "$work/scan.cvol" >/dev/null
    "$1" decompress "$work/scan.cvol" "$work/sample.nrrd" --box 100:180,150:230,100:164 >/dev/null
    list_files >"$work/files"
    while read -r file more; do
        # shellcheck disable=SC2086
        "$1" compress "$work/sample.nrrd" "$work/reference-$file.cvol" $more >/dev/null
    done <"$work/files"
    list_pictures >"$work/pictures"
    while read -r picture more; do
        # shellcheck disable=SC2086
        CVOL_CPU=base "$1" render "$work/reference-default.cvol" -o "$work/base-$picture.png" --size 128 $more >/dev/null
        # shellcheck disable=SC2086
        "$1" render "$work/reference-default.cvol" -o "$work/widest-$picture.png" --size 128 $more >/dev/null
    done <"$work/pictures"
}

check() { # NAME: adds its row to the table
    platform "$1"
    why=$(missing)
    version=$($compiler -dumpfullversion 2>/dev/null || $compiler -dumpversion 2>/dev/null) || version=
    if [ -n "$why" ]; then
        echo "$1|not checked: $why" >>"$table"
        return 0
    fi
    if ! (build "$1") >"$folder/$1.log" 2>&1; then
        grep -E 'error|Error' "$folder/$1.log" | head -n 20 >&2
        echo "$1|$compiler $version|does not build: see $folder/$1.log" >>"$table"
        failed=1
        return 0
    fi
    [ "$1" != gcc ] || make_reference "$folder/gcc/cvol"
    passed=$(run_tests "$1")
    golden=$(check_golden "$1")
    bytes=$(make_files "$1")
    difference=$(draw "$1")
    echo "$1|$compiler $version|$passed|$golden|$bytes|$difference" >>"$table"
    for fraction in "$passed" "$golden" "$bytes"; do
        [ "${fraction%/*}" = "${fraction#*/}" ] || failed=1
    done
    [ "${difference%|*}" -le 1 ] || failed=1
}

cmocka=${CMOCKA_SOURCE:-$folder/cmocka}
[ -e "$cmocka/src/cmocka.c" ] || fetch cmocka
work=$folder/work
table=$folder/table
mkdir -p "$work"
failed=0
echo 'platform|compiler|tests passed|golden files equal|bytes equal|pictures, base set|pictures, widest set' >"$table"
[ $# -gt 0 ] || set -- gcc-O0 clang i386 aarch64 s390x mingw
if [ -n "${CVOL_REFERENCE:-}" ]; then
    make_reference "$CVOL_REFERENCE"
else
    check gcc
fi
for name in "$@"; do
    [ "$name" = gcc ] || check "$name"
done
awk -F '|' '{ printf "%-9s %-32s", $1, $2; for (i = 3; i <= NF; i++) printf " %-20s", $i; print "" }' "$table"
exit $failed
