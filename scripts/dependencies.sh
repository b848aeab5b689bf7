#!/bin/sh
# Installs the Debian packages that cvol needs and that are missing.
# usage: scripts/dependencies.sh [build] [test] [bench] [web] [memory] [portability] [wheel]
set -eu

build='gcc libc6-dev make cmake ninja-build pkg-config zlib1g-dev libpng-dev libzstd-dev libjansson-dev libgif-dev libwebp-dev libtiff-dev libblosc-dev g++ libgdcm-dev libhdf5-dev libmicrohttpd-dev libturbojpeg0-dev'
test='libcmocka-dev python3-numpy python3-tifffile python3-pydicom libgdcm-tools python3-mrcfile python3-h5py python3-openvdb hdf5-tools'
bench='g++ libfftw3-dev libzfp-dev python3-matplotlib python3-vtk9 python3-numpy python3-pil xvfb python3-zarr python3-numcodecs python3-zfpy'
test="$test libopenmpi-dev openmpi-bin" # for cvol-mpi
test="$test python3-pytest python3-pil" # for the Python package
# The packages that the Python package works with
test="$test python3-zarr python3-numcodecs python3-xarray python3-dask python3-nibabel"
test="$test libinsighttoolkit5-dev" # for the plugin of ITK
# For VTK's files, and the recipe of doc/recipes.md. ParaView has its own VTK, which apt-get would remove for this one.
command -v pvbatch >/dev/null 2>&1 || test="$test python3-vtk9"
test="$test locales"        # for a decimal comma
test="$test doxygen"        # for the reference
test="$test clang libclang-rt-dev libomp-dev" # for the fuzzers and scripts/races.sh
test="$test clang-format clang-tidy" # for scripts/lint.sh
# For the tests of the viewer's page: they need two packages of npm's registry. Debian's npm depends on 350 other
# packages, so any installed npm is used.
test="$test chromium"
command -v node >/dev/null 2>&1 || test="$test nodejs"
command -v npm >/dev/null 2>&1 || test="$test npm"

web='cmake make emscripten node-acorn xz-utils bzip2 patch' # for the page of cvol export
command -v node >/dev/null 2>&1 || web="$web nodejs"

memory='valgrind' # for scripts/memory.sh

wheel='patchelf liblz4-dev' # for make wheel
test="$test $wheel"

# The compilers and the emulators of scripts/portability.sh
portability='cmake ninja-build gcc zlib1g-dev python3 clang gcc-aarch64-linux-gnu libc6-dev-arm64-cross gcc-s390x-linux-gnu
    libc6-dev-s390x-cross gcc-i686-linux-gnu libc6-dev-i386-cross qemu-user-static gcc-mingw-w64-x86-64 wine64
    wine xz-utils patch'

wanted=
for set in "${@:-build}"; do
    case $set in
    build) wanted="$wanted $build" ;;
    test) wanted="$wanted $test" ;;
    bench) wanted="$wanted $bench" ;;
    web) wanted="$wanted $web" ;;
    memory) wanted="$wanted $memory" ;;
    portability) wanted="$wanted $portability" ;;
    wheel) wanted="$wanted $wheel" ;;
    *)
        echo "dependencies.sh: no such set: $set" >&2
        exit 2
        ;;
    esac
done

if ! command -v apt-get >/dev/null 2>&1 || ! command -v dpkg-query >/dev/null 2>&1; then
    for tool in cc cmake; do
        if ! command -v $tool >/dev/null 2>&1; then
            echo "cvol requires a C11 compiler, cmake 3.18 and the development files of zlib."
            echo "It uses other libraries if pkg-config and their development files are installed;"
            echo "cmake prints a table of them, with what a build without each lacks."
            echo "On Debian these are the packages:$wanted"
            exit 1
        fi
    done
    exit 0
fi

missing=
for package in $wanted; do
    status=$(dpkg-query -W -f '${Status}' "$package" 2>/dev/null || true)
    case $status in
    *' installed') ;;
    *) missing="$missing $package" ;;
    esac
done
[ -n "$missing" ] || exit 0

if [ "$(id -u)" = 0 ]; then
    as_root=
elif command -v sudo >/dev/null 2>&1; then
    as_root=sudo
else
    echo "cvol needs these Debian packages; ask an administrator to install them:$missing"
    exit 1
fi
echo "Installing Debian packages:$missing"
export DEBIAN_FRONTEND=noninteractive
# shellcheck disable=SC2086
$as_root apt-get install -y -qq --no-install-recommends $missing >/dev/null 2>&1 || {
    $as_root apt-get update -qq
    $as_root apt-get install -y -qq --no-install-recommends $missing >/dev/null
}
