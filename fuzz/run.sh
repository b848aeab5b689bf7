#!/bin/sh
# Builds every fuzzer with clang's libFuzzer and the sanitizers and runs each for a while.
# usage: fuzz/run.sh [SECONDS_EACH [NAME...]]     from the project's root; needs clang and its runtime
# (Debian: clang libclang-rt-14-dev). What is found is left in build-fuzz/NAME/. Of volumes' readers one
# alone is volume:NIfTI, 'volume:VTK XML', volume:raw; `readers` stands for all of these but volume:HDF5,
# whose library has crashes of its own (doc/decisions/0009): it goes on behind them, and what they were lies there.
set -eu
cd "$(dirname "$0")/.."
seconds=${1:-60}
[ $# -eq 0 ] || shift
[ $# -gt 0 ] || set -- cvol volume transfer png
[ "$*" != readers ] || set -- volume:DICOM volume:TIFF 'volume:VTK XML' volume:VTK volume:MRC volume:NumPy \
    volume:NIfTI volume:NRRD volume:MetaImage volume:raw
build=build-fuzz
mkdir -p $build
flags="-std=gnu11 -g -O1 -Iinclude -Isrc -Ifuzz -isystem /usr/include/nifti
    -fsanitize=address,undefined -fno-sanitize-recover=all -Wno-psabi -Wno-unknown-pragmas"

# Libraries of volume formats, where they are.
formats=
if pkg-config --exists 'libtiff-4 >= 4.5'; then
    flags="$flags -DCVOL_HAVE_TIFF $(pkg-config --cflags libtiff-4)"
    formats="$formats $(pkg-config --libs libtiff-4)"
fi

for folder in /usr/include/gdcm-3*; do
    [ -d "$folder" ] || continue
    clang++ -std=c++11 -g -O1 -Isrc -isystem "$folder" -fsanitize=address \
        -fsanitize=fuzzer-no-link -c src/volume/modules/dicom_codec.cpp -o $build/dicom_codec.o
    flags="$flags -DCVOL_DICOM_CODEC_LINKED"
    formats="$formats $build/dicom_codec.o -lgdcmMSFF -lgdcmDSED -lgdcmCommon -lstdc++"
done

if pkg-config --exists hdf5; then
    hdf5=$(pkg-config --cflags hdf5 | sed 's/-I/-isystem /g')
    flags="$flags -DCVOL_HDF5_LINKED"
    # shellcheck disable=SC2086
    clang $flags $hdf5 -fsanitize=fuzzer-no-link -c src/volume/modules/hdf5_module.c -o $build/hdf5_module.o
    formats="$formats $build/hdf5_module.o $(pkg-config --libs hdf5)"
fi

# Without OpenMP: one thread, and no runtime that the sanitizers do not know.
# Readers of volumes need two rooms, which compile in a twentieth of the time.
sources='src/base/*.c src/volume/*.c'
for name in "$@"; do
    case $name in volume*) ;; *) sources='src/*/*.c' ;; esac
done
objects=
for source in $sources; do
    name=$(basename "$(dirname "$source")")-$(basename "$source" .c) # rooms may share names
    case $source in
    *_simd.c)
        for set in base avx2 avx512; do
            case $set in
            base) machine= ;;
            avx2) machine='-mavx2 -mfma -mf16c' ;;
            avx512) machine='-mavx512f -mavx512bw -mavx512dq -mavx512vl -mfma -mf16c' ;;
            esac
            object=$build/$name-$set.o
            clang $flags $machine -fsanitize=fuzzer-no-link -DCVOL_SIMD_SET=$set -c "$source" \
                -o "$object"
            objects="$objects $object"
        done
        ;;
    *)
        clang $flags -fsanitize=fuzzer-no-link -c "$source" -o "$build/$name.o"
        objects="$objects $build/$name.o"
        ;;
    esac
done

export LSAN_OPTIONS=suppressions=fuzz/leaks.supp:print_suppressions=0
for name in "$@"; do
    fuzzer=${name%%:*}
    CVOL_FUZZ_FORMAT=
    [ "$fuzzer" = "$name" ] || CVOL_FUZZ_FORMAT=${name#*:}
    export CVOL_FUZZ_FORMAT
    found=$build/$(echo "$name" | tr ': ' '--')
    clang $flags -fsanitize=fuzzer "fuzz/fuzz_$fuzzer.c" $objects -o "$build/fuzz_$fuzzer" \
        $formats -lnifti2 -lznz -lz -lfftw3f -lpng -lgif -lzstd -ljansson -lpthread -lm
    mkdir -p "$found"
    corpus=$found
    [ -d "fuzz/corpus/$fuzzer" ] && corpus="$corpus fuzz/corpus/$fuzzer"
    behind=
    unset ASAN_OPTIONS
    if [ "$name" = volume:HDF5 ]; then # which asks for what headers claim, and can be told that there is none
        export ASAN_OPTIONS=allocator_may_return_null=1:max_allocation_size_mb=1024
        behind='-malloc_limit_mb=2048 -fork=1 -ignore_crashes=1 -ignore_timeouts=1 -ignore_ooms=1'
    fi
    echo "== $name, $seconds s"
    # shellcheck disable=SC2086
    "$build/fuzz_$fuzzer" -max_total_time="$seconds" -rss_limit_mb=512 -timeout=20 \
        -print_final_stats=1 -artifact_prefix="$found-" $behind $corpus 2>&1 | tail -12
    rm -f /dev/shm/cvol-fuzz-*
done
