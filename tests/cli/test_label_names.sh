#!/bin/sh
# Labels by name: --labels, --label-table, the list of cvol info, and volumes of many labels.
# shellcheck disable=SC1091,SC2086,SC2154
. "${0%/*}/lib.sh"

make_field labels.nii.gz labels 70x70x70 2.5 0 0,0,0
make_field atlas.nii.gz atlas 60x60x60 3 0 0,0,0
expect_status 0 cvol compress labels.nii.gz labels.cvol --labels yes
expect_status 0 cvol compress atlas.nii.gz atlas.cvol
cat >snap.txt <<'END'
################################################
# ITK-SnAP Label Description File
    0     0    0    0        0  0  0    "Clear Label"
    1   255    0    0        1  1  1    "Deep spot"
    2     0  255    0        1  1  1    "Near, to the skin"
    3     0    0  255        0.5  1  0  "Outer"
END
cat >free.txt <<'END'
#$Id: colours
#No. Label Name:       R   G   B   A

0   Unknown            0   0   0   0
1   Deep-Spot        255   0   0   0
2   Near-Skin          0 255   0   0
3   Outer              0   0 255   0
4   Elsewhere          9   9   9   0
END
cat >slicer.ctbl <<'END'
# Color table file
# 4 values
0 background 0 0 0 0
1 "Deep spot" 255 0 0 255
3 Outer 0 0 255 255
END

# draw IN OUT OPTIONS...; stderr may say that the samples were compressed.
draw() {
    lib_in=$1
    lib_out=$2
    shift 2
    expect_status 0 cvol render "$lib_in" -o "$lib_out" --size 128 "$@"
}

# ---- choice and colours --------------------------------------------------------------------------

expect_done cvol render labels.cvol -o all.png --size 128
draw labels.nii.gz one.png --labels 1 --json
expect_equal "$(value_of labels.0.value)" 1
expect_equal "$(json_get labels.1 <"$out" 2>/dev/null)" ''
draw labels.nii.gz some.png --labels 1,3 --fit box --view front
draw labels.nii.gz range.png --labels 1,3-9 --fit box --view front
expect_same_file some.png range.png
draw labels.cvol file.png --labels 1,3 --fit box --view front
expect_same_file some.png file.png
expect_other_file some.png one.png
for table in snap.txt free.txt slicer.ctbl; do
    draw labels.nii.gz $table.png --label-table $table --labels 'outer,1' --fit box --view front --json
    expect_number "$(value_of labels.0.colour.0)" '==' 1
    expect_equal "$(value_of labels.1.name)" Outer
    expect_number "$(value_of labels.1.colour.2)" '==' 1
    expect_number "$(value_of labels.1.colour.0)" '==' 0
    expect_other_file some.png $table.png
done
expect_same_file snap.txt.png free.txt.png
expect_same_file snap.txt.png slicer.ctbl.png
draw labels.nii.gz quoted.png --label-table snap.txt --labels 'Deep spot,3' --fit box --view front
expect_same_file snap.txt.png quoted.png
draw labels.nii.gz ray.png --label-table snap.txt --labels 1,3 --engine ray --fit box --view front
expect_done cvol compare ray.png quoted.png --json
expect_number "$(value_of psnr_db)" '>' 25

# ---- the header of segments ----------------------------------------------------------------------

expect_done cvol decompress labels.cvol plain.nrrd
awk 'BEGIN { RS = "\n\n"; ORS = "" } NR == 1 { print $0 "\n"
    print "Segment0_LabelValue:=1\nSegment0_Name:=Deep spot\nSegment0_Color:=1 0 0\n"
    print "Segment1_Name:=Outer\nSegment1_LabelValue:=3\nSegment1_Color:=0 0 1\nSegment1_Extent:=0 1\n\n"; exit }' \
    plain.nrrd >head.txt
lib_bytes=$((70 * 70 * 70))
{
    cat head.txt
    tail -c $lib_bytes plain.nrrd
} >spots.seg.nrrd
expect_done cvol decompress labels.cvol labels.raw
sed 's/^encoding:.*/encoding: raw/' head.txt >raw.txt
cat raw.txt labels.raw >spots.seg.nrrd
draw spots.seg.nrrd segments.png --labels 1,outer --fit box --view front --json
expect_equal "$(value_of labels.0.name)" 'Deep spot'
expect_same_file segments.png quoted.png
# Compressed files keep names and colours, or get those of a table.
expect_done cvol compress spots.seg.nrrd spots.cvol --labels yes
draw spots.cvol stored.png --labels 1,outer --fit box --view front --json
expect_equal "$(value_of labels.0.name)" 'Deep spot'
expect_same_file stored.png segments.png
expect_done cvol compress spots.cvol again.cvol --label-table snap.txt
expect_done cvol compress labels.nii.gz table.cvol --label-table snap.txt
for file in again table; do
    draw $file.cvol $file.png --labels 'Deep spot,3' --fit box --view front
    expect_same_file $file.png quoted.png
done
expect_done cvol compress spots.seg.nrrd spots.seg.nrrd -o times.cvol --labels yes --label-table snap.txt
expect_done cvol info times.cvol --time 1 --json
expect_equal "$(value_of attributes.labels.1.name)" 'Deep spot'
echo '{"by": "someone", "labels": "three"}' >own.json # stays
expect_done cvol compress spots.seg.nrrd own.cvol --attributes own.json --labels yes
expect_done cvol info own.cvol --json
expect_equal "$(value_of attributes.labels)" three
echo '{"by": "someone"}' >own.json # gets labels
expect_done cvol compress spots.seg.nrrd own.cvol --attributes own.json --labels yes
expect_done cvol info own.cvol --json
expect_equal "$(value_of attributes.by)" someone
expect_equal "$(value_of attributes.labels.1.name)" Outer
echo '[1, 2]' >own.json # is no object: stays
expect_done cvol compress spots.seg.nrrd own.cvol --attributes own.json --labels yes
expect_done cvol info own.cvol --json
expect_equal "$(value_of attributes.1)" 2
draw spots.seg.nrrd coloured.png --json
expect_equal "$(value_of labels.2.name)" Outer

# ---- segmentations of 3D Slicer --------------------------------------------------------------------

# Each label is a segment; those without a name or a colour get one.
expect_done cvol decompress spots.cvol written.seg.nrrd
for line in 'Segment0_Name:=Deep spot' 'Segment0_Color:=1 0 0' 'Segment0_LabelValue:=1' 'Segment1_Name:=Segment 2' \
    'Segment2_Name:=Outer' 'Segment2_Extent:=0 69 0 69 0 69' 'Segmentation_MasterRepresentation:=Binary labelmap'; do
    grep -aqx "$line" written.seg.nrrd || fail "written.seg.nrrd must have the line $line"
done
if grep -aq 'LabelValue:=0' written.seg.nrrd; then fail 'the background is no segment'; fi
expect_done cvol compress written.seg.nrrd written.cvol --labels yes
expect_done cvol decompress written.cvol written.raw
expect_done cvol decompress spots.cvol spots.raw
expect_same_file spots.raw written.raw
expect_done cvol info written.cvol --json
expect_equal "$(value_of attributes.labels.0.name)" 'Deep spot'
expect_equal "$(value_of attributes.labels.1.name)" 'Segment 2'
expect_number "$(value_of attributes.labels.2.colour.2)" '==' 1
printf '%s\n' '1 a\\b 0 0 255 255' '2 b 9 9 9 255' >slash.ctbl
expect_done cvol compress labels.nii.gz slash.cvol --label-table slash.ctbl
expect_done cvol info slash.cvol --json
slash=$(value_of attributes.labels.0.name)
expect_done cvol decompress slash.cvol slash.seg.nrrd
expect_done cvol compress slash.seg.nrrd slashes.cvol --labels yes
expect_done cvol info slashes.cvol --json
expect_equal "$(value_of attributes.labels.0.name)" "$slash"
case $slash in *\\*) ;; *) fail 'the name must have a backslash' ;; esac
expect_done cvol decompress spots.cvol box.seg.nrrd --box 30:50,25:45,30:36
grep -aqx 'Segment0_Extent:=0 19 0 19 0 5' box.seg.nrrd || fail 'the segments of a box have its extent'
make_field spots.nii.gz spots 40x40x40 2 0 0,0,0
expect_done cvol compress spots.nii.gz lossy.cvol --psnr 40
expect_failure 1 'lossy.cvol: is not lossless' cvol decompress lossy.cvol lossy.seg.nrrd

# ---- levels and budgets --------------------------------------------------------------------------

# Labels have no coarse levels: all of a file is read, and the last picture is that without these options.
draw labels.cvol whole.png
draw labels.cvol within.png --budget-ms 60000
expect_same_file whole.png within.png
draw labels.cvol stages.png --progressive
expect_same_file whole.png stages.png
draw labels.cvol stages.png --level 1 --json
expect_equal "$(value_of labels.2.value)" 3
expect_done cvol compare whole.png stages.png --json
expect_number "$(value_of psnr_db)" '>' 20
expect_done cvol decompress labels.cvol coarse.raw --level 2
expect_done cvol decompress labels.cvol fine.raw
expect_same_file coarse.raw fine.raw

# ---- many labels ---------------------------------------------------------------------------------

draw atlas.nii.gz atlas.png --json
expect_equal "$(value_of kind)" 'labels: a colour for each'
expect_equal "$(value_of labels.0.value)" 500
expect_equal "$(value_of labels.55.name)" ''
draw atlas.cvol same.png
expect_same_file atlas.png same.png
draw atlas.nii.gz part.png --labels 513-700
expect_other_file atlas.png part.png

# ---- cvol info -----------------------------------------------------------------------------------

for volume in labels.nii.gz spots.seg.nrrd; do
    expect_done cvol info $volume --label-table snap.txt --json
    expect_equal "$(value_of labels.1.name)" 'Deep spot'
    expect_equal "$(value_of labels.1.value)" 1
    # a ball of radius 14
    expect_near "$(value_of labels.1.volume)" 11494 500
    expect_near "$(value_of labels.1.samples)" 735 40
done
expect_done cvol info labels.nii.gz --json
expect_number "$(value_of labels.3.samples)" '>' 100
expect_done cvol info spots.seg.nrrd
grep -q '3 *Outer, [0-9]* samples' "$out" || fail 'must list the names of segments'
expect_done cvol info atlas.cvol
grep -q 'labels  *65' "$out" || fail 'must count the labels of a .cvol file'
make_field head.nii.gz head 20x20x20 9 0 0,0,0
make_field spots.nii.gz spots 20x20x20 9 0 0,0,0
expect_done cvol info spots.nii.gz
grep -q labels "$out" && fail 'must list no labels of other volumes'

# ---- overlays of labels --------------------------------------------------------------------------

draw head.nii.gz over.png --overlay labels.nii.gz --overlay-labels 'outer' --overlay-label-table snap.txt --json
expect_equal "$(value_of overlays.0.drawn.0.name)" Outer
draw head.nii.gz over.png --overlay atlas.cvol --json
expect_equal "$(value_of overlays.0.drawn.0.value)" 500

# ---- refusals ------------------------------------------------------------------------------------

no() { # STATUS PATTERN OPTIONS...
    lib_status=$1
    lib_pattern=$2
    shift 2
    expect_failure "$lib_status" "$lib_pattern" cvol render labels.nii.gz -o x.png "$@"
}
no 2 'no sample has label 9; labels are 0 to 3' --labels 9
no 2 'no sample has a label of 7 to 9' --labels 1,7-9
no 2 "--labels has 'outer', but labels.nii.gz has no names" --labels outer
no 2 "no label has the name 'inner'; cvol info lists them" --labels inner --label-table snap.txt
no 2 "no sample has the label 'elsewhere'" --labels elsewhere --label-table free.txt
no 2 "--labels is '1,,2', must be numbers or names" --labels 1,,2
no 1 'missing.txt: cannot be read' --label-table missing.txt
no 1 'atlas.cvol, line 1: is no label of' --label-table atlas.cvol
# a long name is cut between characters, not within one
name=$(printf '%062d' 7)
printf '1 255 0 0 1 1 1 "%s\303\251"\n' "$name" >long.txt
draw labels.nii.gz long.png --label-table long.txt --labels 1 --json
expect_equal "$(value_of labels.0.name)" "$name"
echo '# empty' >empty.txt
no 1 'empty.txt: has no label' --label-table empty.txt
no 2 '--labels cannot be combined with --transfer' --labels 1 --transfer hot
no 2 '--label-table works only with --mode composite' --label-table snap.txt --mode mip
no 2 '--overlay-labels cannot be combined with --overlay-transfer' \
    --overlay labels.nii.gz --overlay-labels 1 --overlay-transfer hot
expect_failure 2 'its samples are not whole numbers' cvol render spots.nii.gz -o x.png --labels 1
make_volume noisy.raw uint8 40x36x30
expect_done cvol compress noisy.raw head.cvol --dims 40x36x30 --type uint8 --psnr 30
expect_failure 2 'its samples are not exact, so no labels: compress the original with --labels yes' \
    cvol render head.cvol -o x.png --labels 1
expect_failure 2 'its samples are not exact' cvol info head.cvol --label-table snap.txt
