#!/bin/sh
# Files with several volumes: cvol compress of several files, or of one file with several volumes; --time and
# --channel in all commands that read a .cvol; printed information; errors.
. "$(dirname "$0")/lib.sh"

# Twelve volumes in NRRD; their numeric order differs from their alphabetic order.
make_volume part.raw uint8 24x18x10
for i in 0 1 2 10 11; do
    printf 'NRRD0004\ntype: uint8\ndimension: 3\nsizes: 24 18 10\nspacings: 1 1 2\nencoding: raw\n\n' >run_$i.nrrd
    poke part.raw $((100 + i)) xor 37
    cat part.raw >>run_$i.nrrd
done

# ---- several files to one file -------------------------------------------------------------------

expect_done cvol compress run_*.nrrd -o run.cvol --psnr 40 --time-step 2.5
grep -q '^run.cvol: 5 times, [0-9]* bytes, 1/' "$out" || fail 'must print the number of times'
expect_done cvol compress 'run_*.nrrd' -o again.cvol --psnr 40 --time-step 2.5 --json
cmp -s run.cvol again.cvol || fail 'a pattern must expand as in the shell'
expect_equal "$(value_of times)" 5
expect_equal "$(value_of volumes.2.input)" run_2.nrrd
expect_equal "$(value_of volumes.3.input)" run_10.nrrd
expect_equal "$(value_of file_bytes)" "$(wc -c <run.cvol)"
# The order of the arguments is kept.
expect_done cvol compress run_2.nrrd run_0.nrrd -o two.cvol --psnr 40 --json
expect_equal "$(value_of volumes.0.input)" run_2.nrrd
# Names of channels follow the order of the files, which must be clear.
for option in '--channel-names two,ten' '--channel-colors red,green'; do
    expect_failure 2 "${option% *}: the order is not clear, as run_10.nrrd is given before run_2.nrrd" \
        cvol compress run_10.nrrd run_2.nrrd -o x.cvol --psnr 40 --as channels $option
done
for inputs in 'run_2.nrrd run_10.nrrd' 'run_[12]*.nrrd'; do
    names=two,ten
    [ "$inputs" = 'run_2.nrrd run_10.nrrd' ] || names=one,two,ten,eleven
    set -f
    expect_done cvol compress $inputs -o named.cvol --psnr 40 --as channels --channel-names $names
    set +f
    expect_done cvol info named.cvol --json
    expect_equal "$(value_of channel.0.name)" ${names%%,*}
done

expect_done cvol info run.cvol --json
expect_equal "$(value_of kind)" series
expect_equal "$(value_of times)" 5
expect_equal "$(value_of channels)" 1
expect_equal "$(value_of time_values.4)" 10.0
expect_equal "$(value_of time_unit)" s
expect_equal "$(value_of dims.0)" 24
expect_done cvol verify run.cvol
expect_equal "$(cat "$out")" "run.cvol: whole, 7 sections, $(wc -c <run.cvol) bytes"
expect_done cvol info run.cvol --layout
expect_equal "$(awk 'NR > 2 { printf "%s ", $1 }' "$out")" 'LIST VOLM VOLM VOLM VOLM VOLM ENDS '

# ---- one volume of a series ----------------------------------------------------------------------

expect_done cvol compress run_10.nrrd alone.cvol --psnr 40
expect_done cvol transcode run.cvol copy.cvol --time 3
cmp -s alone.cvol copy.cvol || fail 'a volume of a series must equal the same volume compressed alone'
expect_done cvol decompress alone.cvol alone.raw
expect_done cvol decompress run.cvol three.raw --time 3
cmp -s alone.raw three.raw || fail 'decompress must read the selected volume'
expect_done cvol transcode run.cvol smaller.cvol --time 3 --ratio 100 --force
expect_done cvol compare run_10.nrrd run.cvol --time 3 --json
first=$(value_of psnr_db)
expect_done cvol compare run_10.nrrd alone.cvol --json
expect_equal "$(value_of psnr_db)" "$first"
expect_done cvol info run.cvol --time 3 --json
expect_equal "$(value_of file_bytes)" "$(wc -c <alone.cvol)"
expect_done cvol stats alone.cvol --json
cp "$out" alone.json
expect_done cvol stats run.cvol --time 3 --json
expect_same_file "$out" alone.json
expect_done cvol add run.cvol alone.cvol -o zero.cvol --time 3 --beta -1
expect_failure 2 'hold one time each: leave out --time' cvol add alone.cvol alone.cvol -o x.cvol --time 3
for options in '' '--mode mip' '--engine ray'; do
    expect_done cvol render alone.cvol -o alone.png --size 40 $options
    expect_done cvol render run.cvol --time 3 -o three.png --size 40 $options
    cmp -s alone.png three.png || fail "render $options must render the selected volume"
done
expect_status 0 cvol render run.cvol -o first.png --size 40
grep -q 'run.cvol: using time 0 of 5; --time chooses another' "$err" || fail 'must print which time it renders'
expect_failure 2 'run.cvol: has 5 times, 0 to 4; number 5 was requested' cvol render run.cvol --time 5 -o x.png
expect_failure 2 'run.cvol: has one channel, number 0; number 1' cvol decompress run.cvol x.raw --channel 1
expect_failure 2 'alone.cvol: holds one volume: leave out --time' cvol info alone.cvol --time 0

# ---- over time -----------------------------------------------------------------------------------

expect_done cvol render run.cvol -o 'time-{n}.png' --over-time --size 40 --mode mip --json
expect_equal "$(value_of frames)" 5
expect_equal "$(echo time-*.png)" 'time-1.png time-2.png time-3.png time-4.png time-5.png'
# All times share one grey scale: 100 and 200, each with one other sample (155 and 55).
i=1
for level in d '\310'; do
    printf 'NRRD0004\ntype: uint8\ndimension: 3\nsizes: 16 16 16\nencoding: raw\n\n' >level_$i.nrrd
    head -c 4096 /dev/zero | tr '\000' "$level" >level.raw
    poke level.raw 0 xor 255
    cat level.raw >>level_$i.nrrd
    i=$((i + 1))
done
expect_done cvol compress level_1.nrrd level_2.nrrd -o level.cvol --lossless
expect_done cvol render level.cvol -o 'level-{n}.pfm' --over-time --size 16 --mode mip
expect_done cvol render level.cvol -o level.gif --over-time --size 16
expect_failure 2 'alone.cvol: has one time' cvol render alone.cvol -o x.gif --over-time
expect_failure 2 '--time cannot be combined with --over-time' cvol render run.cvol -o x.gif --over-time --time 1
expect_failure 2 'cannot be combined with --over-time' cvol render run.cvol -o x.gif --over-time --turntable 4

# ---- inputs with several volumes -----------------------------------------------------------------

python=/usr/bin/python3
if $python -c 'import numpy' 2>/dev/null; then
    command_run='compare grey levels of two times'
    $python - <<'END' >"$out" 2>"$err" || fail 'grey levels must be comparable between times'
import numpy as np
levels = [np.median(p[p > 0]) for p in
          (np.frombuffer(open(f"level-{n}.pfm", "rb").read()[-1024:], "<f4") for n in (1, 2))]
assert abs(levels[0] - 45 / 145) < 0.03 and levels[1] > 0.95, levels
END
    $python - <<'END'
import struct
import numpy as np
volumes = np.arange(4 * 6 * 7 * 8).reshape(4, 6, 7, 8) % 251
np.save("four.npy", volumes.astype(np.int16))
head = bytearray(352)
struct.pack_into("<i", head, 0, 348)
struct.pack_into("<8h", head, 40, 4, 8, 7, 6, 4, 1, 1, 1)
struct.pack_into("<2h", head, 70, 4, 16)
struct.pack_into("<8f", head, 76, 1, 2, 2, 3, 1.5, 0, 0, 0)
struct.pack_into("<f", head, 108, 352)
head[344:348] = b"n+1\0"
open("four.nii", "wb").write(bytes(head) + volumes.astype("<i2").tobytes())
END
    for file in four.nii four.npy; do
        expect_done cvol compress $file -o four.cvol --lossless
        expect_done cvol info four.cvol --json
        expect_equal "$(value_of times)" 4
        for t in 0 3; do
            expect_done cvol compare $file four.cvol --time $t --json
            expect_equal "$(value_of max_abs_error)" 0.0
        done
    done
    # Channels keep the times of their files.
    expect_done cvol info four.nii --json
    expect_equal "$(value_of time_values.3)" 4.5
    expect_done cvol compress four.nii four.nii -o pair.cvol --as channels --lossless
    expect_done cvol info pair.cvol --json
    expect_equal "$(value_of times) $(value_of channels) $(value_of time_values.3)" '4 2 4.5'
    # Of two operands, each that has several volumes is read at the chosen time, whatever its format.
    raw_three='--dims 8x7x6 --spacing 2,2,3'
    expect_done cvol compress four.nii -o four.cvol --lossless
    expect_done cvol decompress four.cvol three.raw --time 3
    for pair in 'four.nii four.cvol' 'four.cvol four.nii' 'four.nii four.nii' 'three.raw four.nii' 'four.cvol three.raw'; do
        raw_options=
        [ "$pair" = "${pair#*raw}" ] || raw_options="$raw_three --raw-type int16"
        expect_status 0 cvol stats $pair --time 3 --json $raw_options
        a_mean=$(value_of a.mean)
        expect_near "$(value_of b.mean)" "$a_mean" 9
        [ -z "$raw_options" ] || raw_options='--dims 8x7x6 --type int16'
        expect_done cvol compare $pair --time 3 --json $raw_options
        expect_equal "$(value_of max_abs_error)" 0.0
    done
    expect_failure 2 'four.nii and four.cvol hold one channel each: leave out --channel' \
        cvol add four.nii four.cvol -o x.cvol --time 1 --channel 1
    expect_done cvol compress four.nii three.cvol --time 3 --lossless
    expect_done cvol transcode four.cvol copy.cvol --time 3
    expect_done cvol decompress three.cvol a.raw
    expect_done cvol decompress copy.cvol b.raw
    cmp -s a.raw b.raw || fail 'a fourth volume read alone must equal the fourth of the series'

    expect_done $python "$CVOL_DOC/decoder_ref.py" four.cvol c.raw --time 3
    cmp -s a.raw c.raw || fail 'the reference decoder must give the same'
    expect_equal "$(value_of times)" 4
fi

# The list in front is written last.
mkfifo pipe.cvol
cat pipe.cvol >piped &
expect_status 1 cvol compress run_0.nrrd run_1.nrrd -o pipe.cvol --psnr 40
expect_sentence 'pipe.cvol: a file of many volumes cannot go through a pipe'
wait
rm pipe.cvol piped

# ---- channels ------------------------------------------------------------------------------------

expect_done cvol compress run_0.nrrd run_10.nrrd -o cell.cvol --psnr 40 --as channels --channel-names DAPI,GFP \
    --channel-colors 'blue,#00ff80'
expect_done cvol info cell.cvol --json
expect_equal "$(value_of channels)" 2
expect_equal "$(value_of channel.1.name)" GFP
expect_equal "$(value_of channel.0.colour.2)" 1.0
expect_done cvol transcode cell.cvol second.cvol --channel 1

# The picture of two channels is the sum of the pictures of each channel.
for mode in composite mip xray; do
    for colours in 'red,#0080ff' 'red,#000000' '#000000,#0080ff'; do
        expect_done cvol render cell.cvol -o "$mode-$colours.pfm" --mode $mode --size 24 --azimuth 30 \
            --channel-colors "$colours"
    done
    if $python -c 'import numpy' 2>/dev/null; then
        command_run="add pictures of mode $mode"
        $python - $mode <<'END' >"$out" 2>"$err" || fail 'channels must be added'
import sys
import numpy as np
pictures = [np.frombuffer(open(f"{sys.argv[1]}-{c}.pfm", "rb").read()[-24 * 24 * 12:], "<f4")
            for c in ("red,#0080ff", "red,#000000", "#000000,#0080ff")]
assert pictures[1].max() > 0.05 and pictures[2].max() > 0.05, [p.max() for p in pictures]
assert np.abs(np.minimum(pictures[1] + pictures[2], 1) - pictures[0]).max() < 1e-6
END
    fi
done
# All pictures of a turn show both channels, also if the first one shows them one behind the other.
for k in 1 2; do
    for row in $(seq 256); do
        [ $k = 1 ] || head -c 56 /dev/zero
        head -c 8 /dev/zero | tr '\0' '\310'
        [ $k = 2 ] || head -c 56 /dev/zero
    done >end_$k.raw
    make_nrrd end_$k.nrrd end_$k.raw uint8 64 16 16
done
expect_done cvol compress end_1.nrrd end_2.nrrd -o ends.cvol --as channels --lossless
for colours in red,blue '#000000,blue' 'red,#000000'; do
    expect_done cvol render ends.cvol -o "$colours-{n}.png" --size 24 --turntable 4 --azimuth 90 --elevation 0 \
        --channel-colors "$colours"
done
for n in 2 4; do
    expect_other_file red,blue-$n.png "#000000,blue-$n.png"
    expect_other_file red,blue-$n.png "red,#000000-$n.png"
done
expect_done cvol render cell.cvol -o all.png --size 24
expect_done cvol render cell.cvol -o given.png --size 24 --channel-colors 'blue,#00ff80'
cmp -s all.png given.png || fail 'colours must equal those of the file'
expect_done cvol render cell.cvol -o turn-{n}.png --size 24 --turntable 2 --mode mip
expect_status 0 cvol render cell.cvol -o iso.png --size 24 --mode iso --iso 60
grep -q 'cell.cvol: using channel 0 of 2; --channel chooses another' "$err" || fail 'must print the rendered channel'
# The message names only what no option chooses; a picture of all channels chooses none.
expect_done cvol compress cell.cvol cell.cvol -o both.cvol --lossless
while IFS='|' read -r options using; do
    expect_status 0 cvol render both.cvol -o both.png --size 24 $options
    expect_equal "$(cat "$err")" "cvol: both.cvol: using $using another"
done <<END
|time 0 of 2; --time chooses
--channel 1|time 0 of 2; --time chooses
--mode iso --iso 60 --time 1|channel 0 of 2; --channel chooses
--mode iso --iso 60|time 0 of 2, channel 0 of 2; --time and --channel choose
END
expect_failure 2 'run.cvol: --channel-colors needs several channels' \
    cvol render run.cvol -o x.png --channel-colors red
expect_failure 2 '--channel-colors has 3 colours, must have 2' \
    cvol render cell.cvol -o x.png --channel-colors red,green,blue

# ---- errors --------------------------------------------------------------------------------------

head -c 4000 part.raw >short.raw
{ printf 'NRRD0004\ntype: uint8\ndimension: 3\nsizes: 20 20 10\nencoding: raw\n\n'; cat short.raw; } >other.nrrd
expect_failure 2 'other.nrrd: has 20 x 20 x 10 samples of uint8, the volumes before it 24 x 18 x 10 of uint8' \
    cvol compress run_0.nrrd other.nrrd -o x.cvol
expect_failure 1 'run_9.nrrd: No such file' cvol compress run_0.nrrd run_9.nrrd -o x.cvol
expect_failure 1 'none_\*.nrrd: no file matches this pattern' cvol compress 'none_*.nrrd' -o x.cvol
expect_failure 2 'too many arguments' cvol compress run_0.nrrd run_1.nrrd run_2.nrrd
expect_failure 2 "--channel-names is 'A', must have 2 names" \
    cvol compress run_0.nrrd run_1.nrrd -o x.cvol --as channels --channel-names A
expect_failure 2 "--channel-colors is 'pink,red', must be names" \
    cvol compress run_0.nrrd run_1.nrrd -o x.cvol --as channels --channel-colors pink,red
expect_failure 2 'run_0.nrrd: is one volume: leave out --as' cvol compress run_0.nrrd -o x.cvol --time-step 2
expect_failure 1 'input and output are the same' cvol compress run_0.nrrd alone.cvol -o alone.cvol
[ ! -e x.cvol ] || fail 'must not create a file'
expect_equal "$(find . -name '.cvol-*' | wc -l)" 0
cp run.cvol bad.cvol
poke bad.cvol $(($(wc -c <run.cvol) - 60)) xor 1
expect_failure 1 'bad.cvol, time 4, channel 0 (from byte ' cvol verify bad.cvol
expect_done cvol decompress bad.cvol x.raw --time 3
