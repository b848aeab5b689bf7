#!/bin/sh
# --turntable: numbered pictures and films; ffmpeg works, is missing, or fails.
. "$(dirname "$0")/lib.sh"

dims=32x30x28
make_volume in.raw uint8 $dims
expect_done cvol compress in.raw a.cvol --dims $dims --type uint8 --psnr 45
turn='cvol render a.cvol --size 40x34 --fit box --turntable'

# ---- numbered pictures ---------------------------------------------------------------------------

expect_done $turn 10 -o 't-{n}.png' --azimuth 20 --json
for field in frames:integer frame_ms:number total_ms:number film_bytes:integer; do
    expect_field "${field%:*}" "${field#*:}"
done
expect_equal "$(value_of frames)" 10
expect_equal "$(ls t-*.png | tr '\n' ' ')" \
    't-01.png t-02.png t-03.png t-04.png t-05.png t-06.png t-07.png t-08.png t-09.png t-10.png '
expect_done cvol render a.cvol --size 40x34 --fit box -o one.png --azimuth 56
expect_same_file one.png t-02.png
expect_done $turn 2 -o '{name}-{n}.pfm' --mode mip
expect_equal "$(ls a-*.pfm | tr '\n' ' ')" 'a-1.pfm a-2.pfm '
expect_done $turn 2 -o 'v-{n}.png' --view front --bits 16
rm t-* a-* v-*

# More files than the tries for a hidden name: all get their names at the end.
mkdir many
make_volume tiny.raw uint8 4x4x4
expect_done cvol compress tiny.raw tiny.cvol --dims 4x4x4 --type uint8 --psnr 45
expect_done cvol render tiny.cvol -o 'many/t-{n}.png' --size 4 --turntable 1001 --threads 1
expect_equal "$(ls -A many | wc -l)" 1001
expect_equal "$(ls many | sed -n '$p')" t-1001.png
rm -r many tiny.*

# ---- films ---------------------------------------------------------------------------------------

# count FILE TEXT: prints the number of occurrences.
count() { LC_ALL=C grep -a -o -F "$2" "$1" | wc -l; }

echo old >a.gif
expect_done $turn 6 -o a.gif --json
expect_equal "$(value_of film_bytes)" "$(wc -c <a.gif)"
expect_equal "$(head -c 6 a.gif)" GIF89a
expect_done $turn 6 -o b.gif --threads 1
expect_same_file a.gif b.gif
expect_equal "$(wc -l <"$out")" 1
case $(cvol render --help) in
*.webp*) ;;
*) fail 'the help must name .webp' ;;
esac
run $turn 6 -o a.webp --background transparent
if [ $status = 0 ]; then
    expect_equal "$(head -c 4 a.webp)" RIFF
    expect_equal "$(count a.webp ANMF)" 6
else
    expect_sentence 'has no WebP'
fi

expect_failure 2 'give --turntable' cvol render a.cvol -o x.gif
expect_failure 2 'put {n}' $turn 3 -o x.png
expect_failure 2 'must end in' $turn 3 -o 'x-{n}.bmp'
expect_failure 2 'must be a whole number, at least 1' $turn 0 -o x.gif
expect_failure 2 'must be 1 to 100000' $turn 100001 -o x.gif
expect_failure 2 'cannot be combined with --progressive' $turn 3 -o x.gif --progressive
expect_failure 2 '--fps works only with --turntable' cvol render a.cvol -o x.png --fps 3
expect_failure 2 '--fps works only with animations' $turn 3 -o 'x-{n}.png' --fps 3
expect_failure 2 'at most 50' $turn 3 -o x.gif --fps 60
expect_failure 2 '--fps is 0' $turn 3 -o x.gif --fps 0
expect_failure 2 '--quality is 101' $turn 3 -o x.webp --quality 101
expect_failure 2 '--background transparent works only with PNG and WebP' $turn 3 -o x.gif --background transparent
expect_failure 2 '--background transparent works only with PNG and WebP' $turn 3 -o x.mp4 --background transparent
expect_failure 2 'does not write compressed pictures' $turn 3 -o 'x-{n}.cvi' --engine transform
expect_failure 2 '--bits 16' $turn 3 -o x.gif --bits 16
expect_failure 1 'cannot be written' $turn 3 -o none/x.gif

# ---- ffmpeg --------------------------------------------------------------------------------------

# A fake ffmpeg that stores its input and its arguments.
mkdir tools empty
cat >tools/ffmpeg <<'END'
#!/bin/sh
for last; do :; done
echo "$*" >"$FFMPEG_LOG"
[ -z "${FFMPEG_FAILS:-}" ] || { echo 'a line' >&2; echo 'no such codec' >&2; exit 1; }
cat >"$last"
END
chmod +x tools/ffmpeg
FFMPEG_LOG=$PWD/log
export FFMPEG_LOG
with_path() {
    lib_path=$1
    shift
    PATH=$lib_path "$CVOL" "$@"
}
turn='render a.cvol --size 40x34 --turntable'
: >log
expect_done with_path "$PWD/tools:$PATH" $turn 5 -o a.mp4 --fps 12.5 --json
expect_equal "$(wc -c <a.mp4)" $((5 * 40 * 34 * 3))
grep -q -- '-s 40x34 -r 12.5 .*libx264' log || fail 'ffmpeg must receive size, rate and codec'
expect_done with_path "$PWD/tools:$PATH" $turn 5 -o a.webm
grep -q 'libvpx-vp9' log || fail 'ffmpeg must receive the codec of .webm'
cp a.mp4 old.mp4
FFMPEG_FAILS=1
export FFMPEG_FAILS
expect_failure 1 'a.mp4: ffmpeg failed: no such codec' with_path "$PWD/tools:$PATH" $turn 40 -o a.mp4
expect_same_file a.mp4 old.mp4
unset FFMPEG_FAILS
expect_failure 1 'ffmpeg, which is not installed' with_path "$PWD/empty" $turn 5 -o b.mp4

# ---- an interrupt leaves no file -----------------------------------------------------------------

# interrupt FILE SECONDS: interrupts a render of FILE after SECONDS.
interrupt() {
    command_run="cvol $turn 20000 -o $1 (with SIGINT after $2 s)"
    status=0
    (
        trap '' INT
        PATH=$PWD/tools:$PATH exec "$CVOL" $turn 20000 -o "$1" >"$out" 2>"$err" </dev/null
    ) &
    child=$!
    sleep "$2"
    left=100
    while [ $left -gt 0 ] && kill -s INT "$child" 2>/dev/null; do
        sleep 0.1
        left=$((left - 1))
    done
    wait "$child" || status=$?
    expect_equal "$status" 1
    expect_sentence 'cancelled'
}
ls -A >"$top/before"
for film in x.gif x.mp4 'x-{n}.png'; do
    interrupt "$film" 1
    ls -A >"$top/after"
    cmp -s "$top/before" "$top/after" || fail "$film must leave no file: $(ls -A | tr '\n' ' ')"
done
