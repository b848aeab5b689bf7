#!/bin/sh
# Pictures: engines, modes, sizes, printed output; the number of threads does not change pixels.
. "$(dirname "$0")/lib.sh"

dims=44x40x36
raw="--dims $dims --type uint8"
make_volume in.raw uint8 $dims
expect_done cvol compress in.raw a.cvol $raw --psnr 55

# ---- printed fields ------------------------------------------------------------------------------

expect_done cvol render a.cvol -o a.png --size 96x64 --json
for field in width:integer height:integer engine:string load_ms:number render_ms:number \
    threads:integer; do
    expect_field "${field%:*}" "${field#*:}"
done
expect_equal "$(value_of width)" 96
expect_equal "$(value_of height)" 64
expect_equal "$(value_of engine)" sheet
expect_number "$(value_of load_ms)" '>' 0
expect_number "$(value_of render_ms)" '>' 0
expect_done cvol render a.cvol -o a.png --size 64 --threads 2 --json
expect_equal "$(value_of height)" 64
expect_equal "$(value_of threads)" 2
# Black and white are values, like those of --window.
expect_done cvol render a.cvol -o mip.png --size 32 --mode mip --json
black=$(value_of grey.0)
white=$(value_of grey.1)
expect_done cvol render a.cvol -o mip.png --size 32 --mode mip --json --rescale 2,10
expect_near "$(value_of grey.0)" "$(echo "$black" | awk '{ print 2 * $1 + 10 }')" 0.001
expect_near "$(value_of grey.1)" "$(echo "$white" | awk '{ print 2 * $1 + 10 }')" 0.001
expect_done cvol render a.cvol -o mip.png --size 32 --mode mip --json --rescale 2,10 --window 200,100
expect_equal "$(value_of grey.0) $(value_of grey.1)" '150.0 250.0'
expect_done cvol render a.cvol -o default.png --json
expect_equal "$(value_of width)x$(value_of height)" 512x512
expect_done cvol render a.cvol -o a.png --size 64
expect_equal "$(wc -l <"$out")" 1

# ---- levels, and --budget-ms ---------------------------------------------------------------------

for level in 0 1 2 3; do
    expect_done cvol render a.cvol -o "level$level.png" --size 64 --level $level --json
    expect_equal "$(value_of level)" $level
done
expect_done cvol render a.cvol -o budget.png --size 64 --budget-ms 1e-6 --json
expect_equal "$(value_of level)" 3
expect_done cvol render a.cvol -o budget.png --size 64 --budget-ms 1e9 --json
expect_equal "$(value_of level)" 0
expect_same_file budget.png level0.png
expect_failure 2 '--budget-ms is 0, must be above 0' cvol render a.cvol -o b.png --budget-ms 0
expect_failure 2 '--budget-ms works only with engine sheet' cvol render a.cvol -o b.png --budget-ms 5 --engine ray
expect_failure 2 'give only one of --budget-ms and --progressive' \
    cvol render a.cvol -o b.png --budget-ms 5 --progressive

# Without --level, the level of a large volume is chosen by the size of the picture.
if [ -z "${CVOL_FEWER:-}" ]; then
    gzip -dc "$CVOL_SAMPLES/ch2better.nii.gz" | tail -c +353 >large.raw
    truncate -s $((301 * 370 * 1206)) large.raw
    expect_done cvol compress large.raw large.cvol --dims 301x370x1206 --type uint8 --fast
    rm large.raw
    expect_done cvol render large.cvol -o large.png --size 64 --json
    expect_equal "$(value_of level)/$(value_of file_level)" 0/1
    expect_done cvol render large.cvol -o large.png --size 64 --level 0 --json
    expect_equal "$(value_of level)/$(value_of file_level)" 0/0
    expect_done cvol render large.cvol -o large.png --size 64
    expect_equal "$(grep -c 'level 1, fine enough for this size' "$out")" 1
fi
expect_done cvol render a.cvol -o b.png --size 16 --json
expect_equal "$(value_of file_level)" 0

expect_done cvol bench render a.cvol --views 3 --repeat 2 --size 64 --threads 1 --json
for field in frame_ms:object frame_ms.min:number frame_ms.median:number frame_ms.all:array \
    frame_ms.all.5:number load_ms:number peak_rss_mb:number voxels:integer ns_per_voxel:number cpu_ms:number; do
    expect_field "${field%:*}" "${field#*:}"
done
expect_equal "$(value_of voxels)" $((44 * 40 * 36))
expect_number "$(value_of frame_ms.min)" '>' 0
expect_number "$(value_of frame_ms.min)" '<=' "$(value_of frame_ms.median)"
expect_number "$(value_of peak_rss_mb)" '>' 1
median=$(value_of frame_ms.median)
expect_near "$(value_of ns_per_voxel)" "$(awk "BEGIN { print 1e6 * $median / 63360 }")" 0.01
if json_get frame_ms.all.6 <"$out" >"$top/json" 2>&1; then fail 'must be 3 x 2 frames'; fi
expect_done cvol bench render a.cvol --views 2 --repeat 1 --size 64 --engine ray --mode mip --json
expect_equal "$(value_of engine)" ray
expect_done cvol bench render a.cvol --size 32 --json
expect_field frame_ms.all.11 number
expect_done cvol bench render a.cvol --views 1 --repeat 1 --size 32
expect_equal "$(wc -l <"$out")" 1

expect_done cvol info a.cvol --json
for field in dims:array spacing:array origin:array type:string min:number max:number \
    transform:string block:integer coefficients:integer rho:number ratio:number \
    bits_per_voxel:number file_bytes:integer resident_bytes:integer psnr_db:decibels \
    max_error:number; do
    expect_field "${field%:*}" "${field#*:}"
done
expect_equal "$(value_of transform)" dct
expect_equal "$(value_of type)" uint8
expect_done cvol info a.cvol
for field in dims spacing origin type min max transform block coefficients rho ratio \
    bits_per_voxel file_bytes resident_bytes psnr_db max_error; do
    grep -q "^  $field " "$out" || fail "must print $field"
done
expect_done cvol info in.raw $raw --json
for field in dims:array spacing:array origin:array type:string min:number max:number \
    file_bytes:integer; do
    expect_field "${field%:*}" "${field#*:}"
done
expect_done cvol info --build --json
expect_field formats string

# ---- engines and modes ---------------------------------------------------------------------------

# Decode the volume, so that all engines render the same samples.
expect_done cvol decompress a.cvol dense.nrrd
view='--size 128 --azimuth 30 --elevation 20 --fit box'
for mode in composite xray mip; do
    expect_done cvol render a.cvol -o sheet.png --mode $mode $view --light flat --engine sheet
    expect_done cvol render a.cvol -o array.png --mode $mode $view --light flat --engine ray --step 0.25
    expect_done cvol render dense.nrrd -o ray.png --mode $mode $view --light flat --engine ray --step 0.25
    [ $mode = composite ] || expect_same_file array.png ray.png # auto is fitted to each input's own range
    expect_done cvol compare array.png sheet.png --json
    for field in psnr_db:decibels psnr_foreground_db:decibels ssim:number; do
        expect_field "${field%:*}" "${field#*:}"
    done
    # Without classification, pictures differ at the outline of the box, by a fraction of a pixel.
    case $mode in
    composite) least=35 ;;
    *) least=28 ;;
    esac
    expect_number "$(value_of psnr_foreground_db)" '>=' $least
    expect_number "$(value_of psnr_foreground_db)" '<=' "$(value_of psnr_db)"
    expect_number "$(value_of ssim)" '>' 0.9
    expect_number "$(value_of ssim)" '<=' 1
    cp sheet.png $mode.png
done
expect_other_file composite.png xray.png
expect_other_file mip.png xray.png
expect_done cvol compare mip.png mip.png --json
expect_field psnr_db null
expect_equal "$(value_of exact)" true
expect_equal "$(value_of ssim)" 1.0
expect_done cvol compare mip.png xray.png
expect_equal "$(wc -l <"$out")" 1

# Every camera and appearance option changes the picture.
cp composite.png before.png
for option in '--azimuth 31' '--elevation 21' '--roll 10' '--zoom 1.5' '--background 1,0.5,0' \
    '--transfer hot' '--size 128x100'; do
    expect_done cvol render a.cvol -o after.png $view $option
    expect_other_file before.png after.png
done
expect_done cvol render a.cvol -o after.png --size=128 --azimuth=30 --elevation=20 --fit=box --light=flat
expect_same_file before.png after.png
expect_done cvol render a.cvol -o before.png --size 64 --transfer hot
for option in '--light headlight' '--light 1,0,1' '--light flat' '--shade' '--occlusion 0' '--shadows 0' \
    '--fill-light 2' '--ambient 2' '--shininess 2' '--fit box' '--fit turn' '--azimuth 0 --elevation 0' '--view left'; do
    expect_done cvol render a.cvol -o after.png --size 64 --transfer hot $option
    expect_other_file before.png after.png
done
expect_done cvol render a.cvol -o after.png --size 64 --transfer hot --light studio --fit object
expect_same_file before.png after.png
expect_done cvol render a.cvol -o before.png --size 64 --light headlight
expect_done cvol render a.cvol -o after.png --size 64 --shade
expect_same_file before.png after.png
expect_done cvol render a.cvol -o after.png --size 64 --light headlight --keep-brightness
expect_other_file before.png after.png
for engine in splat transform; do # they have no studio light
    expect_done cvol render a.cvol -o before.png --size 64 --engine $engine
    expect_done cvol render a.cvol -o after.png --size 64 --engine $engine --light flat
    expect_same_file before.png after.png
done

# Transfer functions: names, files, ParaView files.
for name in auto gray bone skin-bone mri hot viridis; do
    expect_done cvol render a.cvol -o after.png $view --transfer $name
done
cat >own.json <<'END'
{"points": [[0, 0, 0, 0, 0], [100, 1, 0.5, 0.2, 0.05], [255, 1, 1, 1, 1]]}
END
expect_done cvol render a.cvol -o after.png $view --transfer own.json
expect_other_file before.png after.png

# ---- oversampling --------------------------------------------------------------------------------

expect_done cvol render a.cvol -o ray.png $view --shade --engine ray --step 0.25
for look in '' '--step 0.4' '--oversample 2' '--step 0.4 --oversample 2'; do
    expect_done cvol render a.cvol -o more.png $view --shade $look
    expect_done cvol compare ray.png more.png --json
    expect_number "$(value_of psnr_db)" '>=' 30
done
expect_failure 2 "along x it goes from 5 to 3" cvol render a.cvol -o x.png --clip 5:3,,

# ---- depth and opacity ---------------------------------------------------------------------------

expect_done cvol render a.cvol -o plain.png $view
expect_done cvol render a.cvol -o after.png $view --depth depth.pfm --opacity opacity.pfm --json
expect_same_file plain.png after.png
expect_equal "$(value_of depth)" depth.pfm
expect_equal "$(value_of opacity)" opacity.pfm
for map in depth opacity; do
    expect_equal "$(head -n 1 $map.pfm)" Pf
    expect_equal "$(wc -c <$map.pfm)" $((16 + 128 * 128 * 4))
done
expect_done cvol render a.cvol -o after.png $view --engine splat --opacity splat.pfm --shade
# Cut faces show values in the window; by default nearly all values are between black and white.
expect_done cvol render a.cvol -o cut.png --size 64 --mode iso --iso 100 --clip ,50%:,
expect_done cvol render a.cvol -o same.png --size 64 --mode iso --iso 100 --clip ,50%:, --window auto
expect_status 0 cvol render a.cvol -o dark.png --size 64 --mode iso --iso 100 --clip ,50%:, --window 99999,1
cmp cut.png same.png || fail 'the window of cut faces must be that of --window auto'
expect_done cvol compare cut.png dark.png --json
expect_number "$(value_of psnr_db)" '<' 40
expect_done cvol render a.cvol -o '{name}.png' $view --mode iso --iso 100 --depth '{name}-depth.pfm' --budget-ms 1e9
expect_equal "$(wc -c <a-depth.pfm)" $((16 + 128 * 128 * 4))
depth='cvol render a.cvol -o x.png --depth x.pfm'
expect_failure 2 'works only with engines sheet and ray' $depth --engine splat
expect_failure 2 'works only in modes composite and iso, not in mip' $depth --mode mip
expect_failure 2 'must end in .pfm' cvol render a.cvol -o x.png --depth y.png
expect_failure 2 'is given for both' $depth --opacity x.pfm
expect_failure 2 'is the name of the picture' cvol render a.cvol -o x.pfm --depth x.pfm
mkdir maps
for name in ./x.pfm maps/../x.pfm; do
    expect_failure 2 'is the name of the picture' cvol render a.cvol -o x.pfm --depth $name
    expect_failure 2 'is given for both' cvol render a.cvol -o x.png --depth x.pfm --opacity $name
done
expect_done cvol render a.cvol -o x.pfm --size 16 --depth maps/x.pfm
rm -r maps x.pfm
expect_failure 2 'cannot be combined with --turntable' cvol render a.cvol -o 'x-{n}.png' --turntable 2 --opacity x.pfm
expect_failure 2 'put {name}' cvol render a.cvol in.raw -o '{name}.png' --depth x.pfm
expect_failure 2 'cannot be combined with --annotate' cvol render a.cvol -o x.png --annotate --opacity x.pfm
expect_failure 2 'cannot be combined with --opacity' cvol render a.cvol -o x.cvi --engine transform --opacity x.pfm
expect_failure 1 'No such file' cvol render a.cvol -o x.png --depth nowhere/x.pfm

# ---- light ---------------------------------------------------------------------------------------

# Both engines shade alike. Ambient light alone gives the unshaded picture.
for look in '--shade' '--shade --light 1,-2,3 --specular 0.5 --shininess 30' '--mode iso --iso 100 --light headlight' '--mode min'; do
    case $look in *iso*) least=27 ;; *) least=30 ;; esac # the surface has sharp outlines
    expect_done cvol render a.cvol -o lit.png $view $look
    expect_done cvol render a.cvol -o lit_ray.png $view --engine ray --step 0.25 $look
    expect_done cvol compare lit.png lit_ray.png --json
    expect_number "$(value_of psnr_db)" '>=' $least
done
expect_done cvol render a.cvol -o lit.png $view --shade --ambient 1 --diffuse 0 --specular 0
expect_done cvol render a.cvol -o unlit.png $view --light flat
expect_done cvol compare lit.png unlit.png --json
expect_number "$(value_of psnr_db)" '>=' 50

# ---- splats --------------------------------------------------------------------------------------

# Splats classify the samples before interpolation, the ray engine after it.
cp composite.png sheet.png
expect_done cvol render a.cvol -o splat.png $view --engine splat
expect_done cvol render a.cvol -o back.png $view --engine splat --order back
expect_done cvol compare splat.png back.png --json
expect_number "$(value_of psnr_db)" '>=' 70
expect_done cvol compare sheet.png splat.png --json
expect_number "$(value_of psnr_db)" '>=' 25
for file in a.cvol dense.nrrd; do
    expect_done cvol render $file -o $file.png $view --engine splat --transfer own.json --json
    expect_equal "$(value_of engine)" splat
done
expect_done cvol compare a.cvol.png dense.nrrd.png --json
expect_number "$(value_of psnr_db)" '>=' 40
for option in '--footprint cone' '--footprint sinc' '--footprint box' '--footprint-size 9' '--sigma 0.6' \
    --shade '--shade --light 1,-2,3'; do
    expect_done cvol render a.cvol -o after.png $view --engine splat $option
    expect_other_file splat.png after.png
done
expect_done cvol render a.cvol -o linear.png $view --light flat --footprint linear
expect_same_file linear.png sheet.png
for option in catmull-rom b-spline gaussian 'gaussian --sigma 0.6'; do
    expect_done cvol render a.cvol -o after.png $view --light flat --footprint $option --json
    expect_other_file sheet.png after.png
    expect_done cvol compare sheet.png after.png --json
    expect_number "$(value_of psnr_db)" '>=' 25
done
for threads in 1 2 3; do
    expect_done cvol render a.cvol -o threads$threads.png $view --engine splat --shade --threads $threads
done
expect_same_file threads1.png threads2.png
expect_same_file threads1.png threads3.png
expect_done cvol bench render a.cvol --views 2 --repeat 1 --size 64 --engine splat --footprint-size 9 --json
expect_equal "$(value_of engine)" splat

# ---- engine transform ----------------------------------------------------------------------------

# A bound that says nothing is left out: many dropped terms, footprints with negative weights. A
# level has a coarser lattice, of the same slices.
for option in '--rho 0.005' '--rho 1 --footprint sinc'; do
    expect_done cvol render a.cvol -o after.png $view --engine transform $option --json
    expect_equal "$(value_of transform.error_bound)" null
done
for level in 0 1 2 3; do
    expect_done cvol render a.cvol -o after.png $view --engine transform --level $level --json
    expect_equal "$(value_of transform.step)" "$((1 << level)).0"
done

# With all terms the picture equals that of engine splat; with fewer terms the bound grows.
expect_done cvol render a.cvol -o slices.png $view --engine splat --footprint-plane slices
for option in '' '--order back' '--spectrum dht' '--tile 0' '--schedule literal'; do
    expect_done cvol render a.cvol -o after.png $view --engine transform --rho 1 $option --json
    expect_equal "$(value_of engine)" transform
    expect_number "$(value_of transform.error_bound)" '<=' 0.1
    expect_done cvol compare splat.png after.png --json
    expect_number "$(value_of psnr_db)" '>=' 35
    expect_done cvol compare slices.png after.png --json
    expect_number "$(value_of psnr_db)" '>=' 60
done
for schedule in deferred literal; do
    expect_done cvol render a.cvol -o coarse.png $view --engine transform --rho 0.1 --schedule $schedule --json
    expect_number "$(value_of transform.rho)" '<=' 0.1
    expect_done cvol compare after.png coarse.png --json
    expect_number "$(value_of psnr_db)" '>=' 20
done
for file in a.cvol dense.nrrd; do
    expect_done cvol render $file -o $file.png $view --engine transform --rho 1 --transfer own.json
done
expect_done cvol compare a.cvol.png dense.nrrd.png --json
expect_number "$(value_of psnr_db)" '>=' 40
expect_done cvol bench render a.cvol --views 2 --repeat 1 --size 64 --engine transform

# ---- threads do not change pixels ----------------------------------------------------------------

for engine in sheet ray; do
    for mode in composite xray mip; do
        for threads in 1 2 3; do
            expect_done cvol render a.cvol -o threads$threads.png --size 90x70 --azimuth 77 \
                --elevation -35 --engine $engine --mode $mode --threads $threads
        done
        expect_same_file threads1.png threads2.png
        expect_same_file threads1.png threads3.png
    done
done

# ---- dense inputs, and output streams ------------------------------------------------------------

expect_status 0 cvol render in.raw $raw -o b.png --size 64 --json
expect_sentence 'in.raw: was compressed in memory first, at 1/'
expect_field render_ms number
expect_status 0 cvol render dense.nrrd -o b.png --size 64
expect_sentence 'dense.nrrd: was compressed in memory first, at 1/'
expect_status 0 cvol bench render dense.nrrd --views 1 --repeat 1 --size 64 --json
expect_sentence 'compressed in memory first'
expect_field frame_ms.all.0 number
expect_done cvol render dense.nrrd -o b.png --size 64 --engine ray

# Progress is shown only on terminals, not in a pipe.
(cvol render a.cvol -o big.png --size 1000 --engine ray 2>&1 || echo failed) | cat >text
expect_equal "$(wc -l <text)" 1
case $(cat text) in
big.png:*) ;;
*) fail "must be one line about big.png: $(cat text)" ;;
esac
