#!/bin/sh
# Names and colours of labels that files state themselves: extensions of NIfTI by AFNI and Connectome Workbench, and the
# colour table of MGH. nibabel writes the files; without it the test prints 'skipped'.
# shellcheck disable=SC1091,SC2154
. "${0%/*}/lib.sh"

python=/usr/bin/python3 # the system's Python has the packages
[ -x "$python" ] || python=python3
"$python" -c 'import nibabel' 2>/dev/null || {
    echo 'skipped: no nibabel'
    exit 0
}
cat >make.py <<'END'
"""One volume of labels, with the table in several forms, sound and damaged."""
import struct

import nibabel
import numpy as np

labels = np.zeros((20, 22, 24), "i2")
labels[2:8, 2:20, 2:22], labels[9:18, 3:9, 4:20], labels[9:18, 12:20, 5:19] = 1, 2, 17
names = {0: "Unknown", 1: "Left & <deep>", 2: "Nucleus α", 17: "Hippocampus"}
colours = {0: (0, 0, 0), 1: (255, 0, 0), 2: (0, 128, 255), 17: (20, 200, 40)}


def save(name, code, text, compress=True):
    image = nibabel.Nifti1Image(labels, np.eye(4))
    if text is not None:
        image.header.extensions.append(nibabel.nifti1.Nifti1Extension(code, text))
    nibabel.save(image, name)


def escape(text):
    return text.replace("&", "&amp;").replace("<", "&lt;").replace(">", "&gt;").replace('"', "&quot;")


pairs = "\n".join(f' "{value}" "{escape(name)}"' for value, name in names.items())
table = f'<VALUE_LABEL_DTABLE\n ni_type="2*String"\n ni_dimen="{len(names)}" >\n{pairs}</VALUE_LABEL_DTABLE>'
afni = ('<?xml version="1.0" ?>\n<AFNI_attributes ni_form="ni_group" >\n<AFNI_atr ni_type="String" ni_dimen="1" '
        f'atr_name="VALUE_LABEL_DTABLE" >\n "{escape(table)}"</AFNI_atr>\n</AFNI_attributes>\n')
save("afni.nii.gz", 4, afni.encode())
save("afni.nii", 4, afni.encode())
save("afni_cut.nii.gz", 4, afni[: len(afni) // 2].encode())
rows = "".join(
    f'<Label Key="{v}" Red="{colours[v][0] / 255}" Green="{colours[v][1] / 255}" Blue="{colours[v][2] / 255}" Alpha="1">'
    + (f"<![CDATA[{n}]]>" if v != 2 else escape(n)) + "</Label>" for v, n in names.items())
caret = (f'<?xml version="1.0"?><CaretExtension><VolumeInformation Index="0"><LabelTable>{rows}</LabelTable>'
         '</VolumeInformation><VolumeInformation Index="1"><LabelTable><Label Key="1" Red="0" Green="0" Blue="0" '
         'Alpha="1">other</Label></LabelTable></VolumeInformation></CaretExtension>')
save("caret.nii.gz", 30, caret.encode())
empty = '<LabelTable><Label Key="1" Red="1" Green="0" Blue="0" Alpha="1"/><Label Key="2" Red="0" Green="1" ' \
        'Blue="0" Alpha="1">two</Label><Label Key="17" Red="0" Green="1" Blue="0" Alpha="1">no end'
save("empty.nii.gz", 30, empty.encode())
save("other.nii.gz", 6, b"a remark")
save("none.nii.gz", 0, None)


def text(word):
    word = word.encode() + b"\0"
    return struct.pack(">i", len(word)) + word


def rgb(value):
    return struct.pack(">4i", *colours[value], 0)


nibabel.save(nibabel.MGHImage(labels, np.eye(4)), "plain.mgh")
plain = open("plain.mgh", "rb").read()[: 284 + labels.nbytes]
end = struct.pack(">5f", 2000, 0.1, 3, 4, 256)
skipped = struct.pack(">iq", 3, 5) + b"12345" + struct.pack(">i", 2)
table2 = struct.pack(">iii", 1, -2, 18) + text("table.txt") + struct.pack(">i", len(names))
table2 += b"".join(struct.pack(">i", v) + text(n) + rgb(v) for v, n in names.items())
table1 = struct.pack(">ii", 1, 3) + text("table.txt") + b"".join(text(names[v]) + rgb(v) for v in (0, 1, 2))
import gzip

with gzip.open("two.mgz", "wb") as file:
    file.write(plain + end + skipped + table2)
open("one.mgh", "wb").write(plain + end + table1)
open("cut.mgh", "wb").write(plain + end + table2[:-30])
open("lies.mgh", "wb").write(plain + end + struct.pack(">iii", 1, -2, 18) + struct.pack(">i", 2**31 - 1))
END
"$python" make.py || fail 'make.py'

# names FILE: value=name of the labels that cvol info lists, but for 0.
names() {
    expect_done cvol info "$1" --json
    "$python" -c '
import json, sys
for label in json.load(open(sys.argv[1]))["labels"]:
    if label["value"]:
        print(label["value"], label.get("name") or "None", sep="=")
' "$out"
}
all='1=Left & <deep>
2=Nucleus α
17=Hippocampus'
for file in caret.nii.gz two.mgz afni.nii.gz afni.nii; do
    expect_equal "$(names $file)" "$all"
done
expect_equal "$(names one.mgh | head -2)" "$(echo "$all" | head -2)"
for file in other.nii.gz none.nii.gz lies.mgh afni_cut.nii.gz; do
    expect_equal "$(names $file | cut -d= -f2 | sort -u)" None
done
expect_equal "$(names empty.nii.gz)" '1=None
2=two
17=None'
names cut.mgh | grep >cut.txt '^2=Nucleus α' || fail 'cut.mgh: labels before the damage must have their names'

# Compressed files keep names and colours.
for file in caret.nii.gz two.mgz; do
    expect_done cvol compress "$file" kept.cvol
    expect_equal "$(names kept.cvol)" "$all"
    "$python" -c '
import json, sys
labels = json.load(open(sys.argv[1]))["attributes"]["labels"]
print([(label["value"], [round(255 * c) for c in label["colour"]]) for label in labels])
' "$out" >colours.txt
    expect_equal "$(cat colours.txt)" '[(0, [0, 0, 0]), (1, [255, 0, 0]), (2, [0, 128, 255]), (17, [20, 200, 40])]'
done

# Pictures choose labels by these names.
expect_done cvol render two.mgz -o two.png --labels 'Hippocampus,2'
expect_failure 2 "two.mgz: " cvol render two.mgz -o x.png --labels Thalamus
