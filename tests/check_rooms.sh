#!/bin/sh
# Holds the includes of the code against the rooms and arrows of doc/architecture.md.
# A room may include its own headers, those of the rooms named here, and the public ones.
set -eu
cd "$(dirname "$0")/.."

failed=0
check() { # FOLDER 'ALLOWED ROOMS'
    for file in "$1"/*.c "$1"/*.h; do
        [ -e "$file" ] || continue
        for header in $(sed -n 's/^#include "\(.*\)"/\1/p' "$file"); do
            room=${header%%/*}
            case " $2 cvol " in
            *" $room "*) ;;
            *)
                if [ "$room" = "$header" ] && [ -e "$1/$header" ]; then
                    continue
                fi
                echo "$file includes $header: ${1#src/} may know only: ${2:-nothing}"
                failed=1
                ;;
            esac
        done
    done
}

check src/base 'base'
check src/transform 'transform base'
check src/array 'array transform base'
check src/codec 'codec array transform base'
check src/volume 'volume base'
check src/image 'image codec array base'
check src/render 'render codec array transform volume image base'
check tools 'viewer'
check viewer ''
check plugin ''
[ "$failed" = 0 ] && echo 'rooms: every include follows an arrow'
exit "$failed"
