#!/bin/sh
# Attributes: a JSON text that cvol stores with a volume, byte for byte.
. "$(dirname "$0")/lib.sh"

make_volume in.raw uint8 21x18x9
raw='--dims 21x18x9 --type uint8'
printf '{"patient": "M\303\274ller",\n  "dose": 1.50, "runs": [1, 2]}\n' >in.json
expect_done cvol compress in.raw plain.cvol $raw --ratio 6 --force
expect_done cvol compress in.raw out.cvol $raw --ratio 6 --force --attributes in.json
expect_done cvol info out.cvol --json
expect_equal "$(value_of attributes.runs.1)" 2
expect_field attributes.patient string
expect_done cvol info out.cvol
grep -q '"dose": 1.50, "runs": \[1, 2\]}' "$out" || fail 'must print the attributes unchanged'
expect_done cvol info plain.cvol --json
expect_equal "$(value_of attributes)" null
expect_done cvol verify out.cvol

# Compressing a .cvol again keeps its attributes, unless others are given; results of arithmetic have none.
expect_done cvol compress out.cvol again.cvol --ratio 8 --force
expect_done cvol info again.cvol --json
expect_equal "$(value_of attributes.runs.0)" 1
echo '[3]' >other.json
expect_done cvol compress out.cvol again.cvol --ratio 8 --force --attributes other.json
expect_done cvol info again.cvol --json
expect_equal "$(value_of attributes.0)" 3
expect_done cvol compress in.raw whole.cvol $raw --block 0 --keep 3,9 --attributes other.json
expect_done cvol info whole.cvol --json
expect_equal "$(value_of attributes.0)" 3
expect_done cvol scale out.cvol -o scaled.cvol --factor 2
expect_done cvol info scaled.cvol --json
expect_equal "$(value_of attributes)" null

echo '{"a": }' >bad.json
expect_failure 1 'bad.json: is not valid JSON: line 1, column ' \
    cvol compress in.raw bad.cvol $raw --attributes bad.json
printf '{"a": 1}\0' >bad.json
expect_failure 1 'bad.json: is not a text file' cvol compress in.raw bad.cvol $raw --attributes bad.json
expect_failure 1 'none.json: No such file' cvol compress in.raw bad.cvol $raw --attributes none.json

# The ratio is that of the file, with its attributes.
i=0
while [ $i -lt 99 ]; do printf "%s " $((i * i * i)); i=$((i + 1)); done | sed "s/ \(.\)/, \1/g; s/^/[/; s/$/]/" >long.json
make_volume sized.raw uint8 40x36x30
expect_done cvol compress sized.raw sized.cvol --dims 40x36x30 --type uint8 --psnr 30 --attributes long.json --json
expect_near "$(value_of ratio)" "$(awk "BEGIN { printf \"%.9f\", 43200 / $(wc -c <sized.cvol) }")" 1e-6

# A size counts the attributes.
expect_done cvol compress sized.raw sized.cvol --dims 40x36x30 --type uint8 --bpv 0.6 --attributes long.json --json --force
expect_equal "$(value_of target_met)" true
[ "$(wc -c <sized.cvol)" -le 3240 ] || fail "$(wc -c <sized.cvol) bytes, at most 3240 were asked for"
[ "$(wc -c <sized.cvol)" -ge 3170 ] || fail "only $(wc -c <sized.cvol) bytes of 3240"
