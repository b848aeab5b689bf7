#!/bin/sh
# Builds the fuzzers with clang's libFuzzer and the sanitizers and runs each for a while, in parallel on all
# processors. Prints a row of a table for each (fuzz/RECORD.md collects them). If a fuzzer finds an error, the script
# fails and prints the file.
# usage: fuzz/run.sh [SECONDS_EACH [NAME...]]     from the project's root; needs clang and its runtime
# (Debian: clang libclang-rt-dev). NAME is one reader of volumes, such as volume:NIfTI, 'volume:VTK XML' or
# volume:raw; `volume`, all of them in one fuzzer; `zarr`, folders of Zarr; `readers`, each of these but
# volume:HDF5; or `all` (default), these and the readers of .cvol, transfer functions and PNG. HDF5's library has
# known crashes (doc/decisions/0009): volume:HDF5 continues after a crash and keeps its files.
# Environment: CVOL_FUZZ_SEED, the seed of the random numbers (default 1); JOBS, the number of parallel fuzzers;
# PART, which fuzzers run: 2/3 is every third one, from the second.
# Each fuzzer keeps its corpus in build-fuzz/NAME; the next run continues from it.
# shellcheck disable=SC2086,SC2100 # flags are many words
set -eu
cd "$(dirname "$0")/.."
if [ "${1:-}" = --one ]; then # NAME SECONDS: called by xargs below
    shift
    name=$1 seconds=$2 build=build-fuzz
    fuzzer=${name%%:*}
    CVOL_FUZZ_FORMAT=
    [ "$fuzzer" = "$name" ] || CVOL_FUZZ_FORMAT=${name#*:}
    export CVOL_FUZZ_FORMAT
    export LSAN_OPTIONS=suppressions=fuzz/leaks.supp:print_suppressions=0
    unset ASAN_OPTIONS UBSAN_OPTIONS
    hdf5_options=
    if [ "$name" = volume:HDF5 ]; then # it allocates the sizes of headers; malloc may return NULL
        export ASAN_OPTIONS=allocator_may_return_null=1:max_allocation_size_mb=1024
        hdf5_options='-malloc_limit_mb=2048 -fork=1 -ignore_crashes=1 -ignore_timeouts=1 -ignore_ooms=1'
    fi
    found=$build/$(echo "$name" | tr ': ' '--')
    mkdir -p "$found"
    code=0
    timeout -k 10 $((seconds + 90)) "$build/fuzz_$fuzzer" -max_total_time="$seconds" -seed="${CVOL_FUZZ_SEED:-1}" \
        -rss_limit_mb=512 -timeout=20 -print_final_stats=1 -artifact_prefix="$found-" $hdf5_options \
        "$found" "fuzz/corpus/$fuzzer" >"$found.log" 2>&1 || code=$?
    if [ $code -ne 0 ]; then
        tail -n 60 "$found.log"
        echo "fuzz/run.sh: $name failed ($code): $(sed -n 's/^Test unit written to //p' "$found.log")"
        exit 1
    fi
    inputs=$(sed -n 's/^stat::number_of_executed_units: *//p; s/^#\([0-9]*\): .*/\1/p' "$found.log" | tail -n 1)
    ran=$(sed -n 's/^Done [0-9]* runs in \([0-9]*\) second.*/\1/p' "$found.log" | tail -n 1)
    edges=$(sed -n 's/^#.*cov: \([0-9]*\) .*/\1/p' "$found.log" | tail -n 1)
    stops=$(sed -n 's/^#.*oom.timeout.crash: \([^ ]*\).*/\1/p' "$found.log" | tail -n 1)
    echo "| $(date -u +%Y-%m-%d) | $name | $inputs | ${ran:-$seconds} | $edges | ${stops:-0/0/0} |"
    exit 0
fi

seconds=${1:-60}
[ $# -eq 0 ] || shift
readers='volume:DICOM
volume:TIFF
volume:VTK XML
volume:VTK
volume:MRC
volume:MGH
volume:Analyze
volume:NumPy
volume:NIfTI
volume:NRRD
volume:MetaImage
volume:OpenVDB
volume:MATLAB
volume:raw'
case "$*" in
'' | all) names=$(printf '%s\nzarr\ncvol\ntransfer\npng' "$readers") ;;
readers) names=$(printf '%s\nzarr' "$readers") ;;
*) names=$(printf '%s\n' "$@") ;;
esac
part=${PART:-1/1}
names=$(echo "$names" | awk -v part="${part%/*}" -v parts="${part#*/}" 'NR % parts == part % parts')
[ -n "$names" ] || {
    echo "fuzz/run.sh: no fuzzer is in part $part"
    exit 0
}
jobs=${JOBS:-$(nproc 2>/dev/null || echo 2)}
build=build-fuzz
rm -rf $build/objects
mkdir -p $build/objects
# No floating-point contraction, as in cmake/flags.cmake: a contracting build would encode other files.
address="-std=gnu11 -g1 -O1 -ffp-contract=off -Iinclude -Isrc -Ifuzz -isystem third_party/stb -isystem third_party/inter
    -Wno-psabi
    -Wno-unknown-pragmas -DCVOL_WITHOUT_AVX2 -fsanitize=address"
flags="$address -fsanitize=undefined -fno-sanitize-recover=all"
object='-fsanitize=fuzzer-no-link -c'

# Libraries of volume formats, if installed.
formats=
tiff=
commands=$build/commands # one compiler command per line
: >$commands
if pkg-config --exists 'libtiff-4 >= 4.5'; then
    flags="$flags -DCVOL_HAVE_TIFF $(pkg-config --cflags libtiff-4)"
    tiff=yes
    formats="$formats $(pkg-config --libs libtiff-4)"
fi
blosc=
if pkg-config --exists blosc; then
    blosc=yes
    formats="$formats $(pkg-config --libs blosc)"
fi

for folder in /usr/include/gdcm-3*; do
    [ -d "$folder" ] || continue
    echo clang++ -std=c++11 -g1 -O1 -Isrc -isystem "$folder" -fsanitize=address $object \
        src/volume/formats/dicom/codec_module.cpp -o $build/dicom_codec.o >>$commands
    flags="$flags -DCVOL_DICOM_CODEC_LINKED"
    formats="$formats $build/dicom_codec.o -lgdcmMSFF -lgdcmDSED -lgdcmCommon -lstdc++"
done

if pkg-config --exists hdf5; then
    hdf5=$(pkg-config --cflags hdf5 | sed 's/-I/-isystem /g')
    flags="$flags -DCVOL_HDF5_LINKED"
    for source in hdf5_module hdf5_minc_module hdf5_common_module; do
        echo clang $flags $hdf5 $object src/volume/formats/$source.c -o $build/$source.o >>$commands
        formats="$formats $build/$source.o"
    done
    formats="$formats $(pkg-config --libs hdf5)"
fi

# Without OpenMP: one thread, and no runtime that the sanitizers do not know. The library has only the folders that
# the readers need. Kernels are built for the base set and AVX-512 only, without the undefined-behaviour sanitizer,
# which would take minutes of compile time; the tests cover it.
folders='src/base src/volume'
codec=
if echo "$names" | grep -qv '^volume\|^zarr'; then
    codec=yes
    folders="$folders src/transform src/array src/codec src/image src/render/transfer*"
fi
# Pictures are read by libpng, but no JPEG, WebP or film is written: NAME_missing.c takes the place of NAME.c.
for source in $(find $folders -name '*.c' ! -name '*_module.c' ! -path 'src/image/png*_missing.c' | sort); do
    case $source in
    */cvol_chunk_missing.c) [ -z "$codec" ] || continue ;;
    */zarr/cvol_chunk.c) [ -n "$codec" ] || continue ;;
    */unpack_blosc_missing.c) [ -z "$blosc" ] || continue ;;
    */unpack_blosc.c) [ -n "$blosc" ] || continue ;;
    */tiff_missing.c) [ -z "$tiff" ] || continue ;;
    */tiff/tiff.c | */tiff/page.c) [ -n "$tiff" ] || continue ;;
    */pictures/png.c | */pictures/jpeg.c) continue ;; # a folder is no input of a fuzzer
    */base/png_library.c) [ -n "$codec" ] || continue ;;
    */photo_jpeg.c | */photo_webp.c | */webp_film.c | */gif_film.c) continue ;;
    esac
    name=$(echo "${source#src/}" | tr / -) # folders may share names
    name=${name%.c}
    case $source in
    *_simd.c)
        echo clang $address $object -DCVOL_SIMD_SET=base "$source" -o $build/objects/$name-base.o
        [ "$(uname -m)" != x86_64 ] ||
            echo clang $address $object -DCVOL_SIMD_SET=avx512 -mavx512f -mavx512bw -mavx512dq -mavx512vl -mfma -mf16c \
                "$source" -o $build/objects/$name-avx512.o
        ;;
    */fft_fftw.c) ;; # the other transform backend
    # Each read builds a thousand tables; tracing their comparisons takes half of the run and finds nothing.
    */token_tables.c) echo clang $flags $object -fno-sanitize-coverage=trace-cmp "$source" -o $build/objects/$name.o ;;
    *) echo clang $flags $object "$source" -o $build/objects/$name.o ;;
    esac
done >>$commands
fuzzers=$(echo "$names" | sed 's/:.*//' | sort -u)
for fuzzer in $fuzzers; do
    echo clang $flags $object fuzz/fuzz_$fuzzer.c -o $build/fuzz_$fuzzer.o >>$commands
done
tr '\n' '\0' <$commands | xargs -0 -P "$jobs" -n 1 sh -c
rm -f $build/libcvol.a
ar rcs $build/libcvol.a $build/objects/*.o
for fuzzer in $fuzzers; do
    clang -fsanitize=fuzzer,address,undefined $build/fuzz_$fuzzer.o $build/libcvol.a -o $build/fuzz_$fuzzer \
        $formats -lz -lpng -lzstd -ljansson -lpthread -lm
done

echo "Fuzzing for $seconds s each, $jobs at once, seed ${CVOL_FUZZ_SEED:-1}:"
echo '| date | target | inputs | seconds | edges reached | out of memory/timeouts/crashes |'
echo '|---|---|---:|---:|---:|---:|'
code=0
echo "$names" | tr '\n' '\0' | xargs -0 -P "$jobs" -I NAME fuzz/run.sh --one NAME "$seconds" || code=1
rm -rf /dev/shm/cvol-fuzz-*
exit $code
