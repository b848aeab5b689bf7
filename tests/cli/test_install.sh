#!/bin/sh
# Installs into an empty prefix and checks the command with its manual and completions. Builds the examples against
# the installed library with pkg-config and with CMake's find_package, shared and static.
. "$(dirname "$0")/lib.sh"
source=$(dirname "$CVOL_DOC")
prefix=$top/prefix

expect_done cmake --install "$CVOL_BUILD" --prefix "$prefix"
expect_done "$prefix/bin/cvol" --version
for command in '' -render -compress -stats; do
    [ -s "$prefix/share/man/man1/cvol$command.1" ] || fail "must install the manual page cvol$command(1)"
done
if command -v groff >/dev/null; then
    for page in "$prefix"/share/man/man1/*.1; do
        expect_done groff -man -ww -z "$page"
    done
    groff -man -Tascii -P-cbou "$prefix/share/man/man1/cvol-render.1" >page 2>"$err"
    for word in SYNOPSIS azimuth EXAMPLES 'SEE ALSO'; do
        grep -q -e "$word" page || fail "cvol-render(1) must have '$word'"
    done
fi

# Completion knows every command, the options of each, and the values of options.
if command -v bash >/dev/null; then
    cat >complete.bash <<'END'
source "$1"
shift
COMP_WORDS=("$@")
COMP_CWORD=$(($# - 1))
_cvol
echo "${COMPREPLY[@]}"
END
    file=$prefix/share/bash-completion/completions/cvol
    expect_done bash complete.bash "$file" cvol re
    expect_equal "$(cat "$out")" render
    expect_done bash complete.bash "$file" cvol render x.cvol --az
    expect_equal "$(cat "$out")" --azimuth
    expect_done bash complete.bash "$file" cvol compress x.nii.gz --transform d
    expect_equal "$(cat "$out")" 'dct dht dft'
fi
for shell in zsh:zsh/site-functions/_cvol fish:fish/vendor_completions.d/cvol.fish; do
    [ -s "$prefix/share/${shell#*:}" ] || fail "must install a completion for ${shell%%:*}"
    ! command -v "${shell%%:*}" >/dev/null || expect_done "${shell%%:*}" -n "$prefix/share/${shell#*:}"
done

# With pkg-config.
PKG_CONFIG_PATH=$(dirname "$(find "$prefix" -name cvol.pc)")
export PKG_CONFIG_PATH
library=$(pkg-config --variable=libdir cvol)
expect_equal "$(pkg-config --modversion cvol)" "$("$CVOL" --version | sed 's/cvol //')"
for kind in shared static; do
    flags=
    [ $kind = shared ] || flags=--static
    mkdir $kind
    libraries=$(pkg-config $flags --libs cvol)
    [ $kind = shared ] || libraries=$(echo "$libraries" | sed 's/-lcvol/-l:libcvol.a/')
    # shellcheck disable=SC2046,SC2086
    expect_done "${CC:-cc}" -std=c11 "$source/examples/speech.c" -o $kind/speech $(pkg-config --cflags cvol) \
        $libraries -lm
    (cd $kind && LD_LIBRARY_PATH=$library expect_status 0 ./speech)
done
if command -v readelf >/dev/null; then
    expect_done readelf -d shared/speech
    grep -q 'NEEDED.*libcvol.so.0' "$out" || fail 'speech must need libcvol.so.0'
    expect_done readelf -d static/speech
    ! grep -q 'NEEDED.*libcvol' "$out" || fail 'speech must not need libcvol'
    expect_done readelf --dyn-syms -W "$library/libcvol.so.0"
    ! awk '$7 ~ /^[0-9]+$/ && $8 !~ /^cvol_/ && $5 != "LOCAL" { print $8; found = 1 } END { exit !found }' "$out" ||
        fail 'the library must export only cvol_...'
fi

# The installed HDF5 filter finds the installed library.
if [ -e "$CVOL_BUILD/hdf5-plugins/libH5Zcvol.so" ] && command -v ldd >/dev/null; then
    filter=$(find "$prefix" -name libH5Zcvol.so)
    expect_done ldd "$filter"
    grep -q "libcvol.so.0 => $prefix" "$out" || fail "$filter must find libcvol.so.0 below the prefix"
fi

# With find_package: all examples, one of them static.
expect_status 0 cmake -S "$source/examples" -B by-cmake -DCMAKE_PREFIX_PATH="$prefix"
expect_status 0 cmake --build by-cmake
(cd by-cmake && expect_status 0 ./speech)
expect_status 0 cmake by-cmake -DCVOL_STATIC=ON
expect_status 0 cmake --build by-cmake --target speech
(cd by-cmake && expect_status 0 ./speech)
