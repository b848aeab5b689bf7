"""The viewer's units: labels are not Hounsfield units, whatever their values."""

import array
import json
import math
import os
import random
import struct
import sys
import unittest

from viewer_client import Viewer, make_folder, run

SIDE = 32
COUNT = SIDE**3


def write_words(name, values):
    words = array.array("H", values)
    assert len(words) == COUNT
    if sys.byteorder == "big":
        words.byteswap()
    with open(os.path.join(folder.name, name), "wb") as file:
        words.tofile(file)


def labels():
    """101 labels from 1000 to 3000, in boxes of 8 x 4 x 4 samples; half of the boxes are 0."""
    for i in range(COUNT):
        x, y, z = i % SIDE // 8, i // SIDE % SIDE // 4, i // SIDE**2 // 4
        yield 0 if (x + y + z) % 2 else 1000 + 20 * ((x + 4 * y + 32 * z) * 37 % 101)


def body():
    """Air, fat, muscle and bone: Hounsfield units plus 1024."""
    numbers = random.Random(1)
    for i in range(COUNT):
        if i % 2:
            yield numbers.randrange(50)
        elif i % 20:
            yield 930 + numbers.randrange(180)
        else:
            yield 1300 + numbers.randrange(900)


def far():
    """From a billion to a billion and one."""
    for i in range(COUNT):
        yield 1e9 + i / COUNT


def setUpModule():
    global folder, viewer
    folder = make_folder()
    with open(os.path.join(folder.name, "far.raw"), "wb") as file:
        file.write(struct.pack(f"<{COUNT}d", *far()))
    run(folder.name, f"cvol compress far.raw far.cvol --dims {SIDE}x{SIDE}x{SIDE} --type float64 --lossless")
    raw = f"--dims {SIDE}x{SIDE}x{SIDE} --type uint16"
    write_words("labels.raw", labels())
    write_words("body.raw", body())
    run(folder.name, f"cvol compress labels.raw labels.cvol {raw}")
    run(folder.name, f"cvol compress labels.raw lossy.cvol {raw} --psnr 50 --labels no")
    run(folder.name, "cvol decompress labels.cvol labels.nrrd")
    run(folder.name, f"cvol compress body.raw body.cvol {raw} --psnr 50")
    viewer = Viewer(folder.name, "labels.cvol", "lossy.cvol", "labels.nrrd", "body.cvol", "far.cvol")
    viewer.__enter__()


def tearDownModule():
    viewer.__exit__()
    folder.cleanup()
    assert viewer.status == 0, f"the viewer ended with {viewer.status}"


def checksum(content):
    """CRC-32C, as in .cvol files."""
    rest = 0xffffffff
    for byte in content:
        rest ^= byte
        for _ in range(8):
            rest = rest >> 1 ^ (0x82f63b78 if rest & 1 else 0)
    return (rest ^ 0xffffffff).to_bytes(4, "little")


class Texts(unittest.TestCase):
    """Units in files need not be UTF-8; answers are."""

    def setUp(self):
        self.header = (f"NRRD0004\ntype: uint16\ndimension: 3\nsizes: {SIDE} {SIDE} {SIDE}\nencoding: raw\nendian: little\n"
                       "space dimension: 3\nspace directions: (1,0,0) (0,1,0) (0,0,1)\n").encode()
        with open(os.path.join(folder.name, "labels.raw"), "rb") as file:
            self.samples = file.read()

    def write(self, name, unit):
        line = b'space units: "%s" "%s" "%s"\n\n' % (unit, unit, unit)
        with open(os.path.join(folder.name, name), "wb") as file:
            file.write(self.header + line + self.samples)

    def test_unit_of_a_text_in_latin_1(self):
        self.write("latin.nrrd", b"\xb5V")
        with Viewer(folder.name, "latin.nrrd") as other:
            volume = other.wait_for("0")
            self.assertEqual((volume["unit"], volume["dims"]), ("\u00b5V", [SIDE] * 3))
            reply = other.post("volumes/0/measure", {"kind": "distance", "points": [[0, 0, 0], [3, 4, 0]]}).json
            self.assertEqual((reply["unit"], reply["length"]), ("\u00b5V", 5))

    def test_unit_of_a_compressed_file_that_is_not_utf_8(self):
        """Units in .cvol files may be any bytes (doc/format.md)."""
        self.samples = random.Random(2).randbytes(len(self.samples) * 4)  # too large for a packed file
        self.header = self.header.replace(f"sizes: {SIDE}".encode(), f"sizes: {4 * SIDE}".encode())
        self.write("odd.nrrd", b"unit?")
        run(folder.name, "cvol compress odd.nrrd odd.cvol --lossless")
        path = os.path.join(folder.name, "odd.cvol")
        with open(path, "rb") as file:
            content = bytearray(file.read())
        begin = content.index(b"GEOM")
        unit = begin + 24 + 124
        self.assertEqual(content[unit:unit + 6], b"unit?\0")
        content[unit + 4] = 0xff
        content[begin + 16:begin + 20] = checksum(content[begin + 24:begin + 24 + 156])
        content[begin + 20:begin + 24] = checksum(content[begin:begin + 20])
        with open(path, "wb") as file:
            file.write(content)
        with Viewer(folder.name, "odd.cvol") as other:
            volume = other.wait_for("0")
            self.assertEqual((volume["unit"], volume["dims"]), ("unit?", [4 * SIDE, SIDE, SIDE]))
            reply = other.post("volumes/0/measure", {"kind": "distance", "points": [[0, 0, 0], [3, 4, 0]]}).json
            self.assertEqual((reply["unit"], reply["length"]), ("unit?", 5))


class Units(unittest.TestCase):
    def setUp(self):
        self.volumes = {v["name"]: v for v in viewer.get("volumes").json["volumes"]}
        self.assertEqual(len(self.volumes), 5)
        self.assertFalse(self.volumes["lossy.cvol"]["exact"])

    def test_samples_far_from_0_keep_their_digits(self):
        volume = self.volumes["far.cvol"]
        last = 1e9 + (COUNT - 1) / COUNT
        self.assertAlmostEqual(volume["min"], 1e9, delta=1e-5)
        self.assertAlmostEqual(volume["max"], last, delta=1e-5)
        reply = viewer.get(f"volumes/{volume['id']}/value?x=5&y=4&z=3").json
        self.assertAlmostEqual(reply["value"], 1e9 + (5 + SIDE * (4 + SIDE * 3)) / COUNT, delta=1e-5)

    def test_volumes_of_one_value_or_none(self):
        """Slices are grey, a picture of samples without values is empty, and the description says why."""
        for name, value in ("one.raw", 7.5), ("none.raw", math.nan):
            with open(os.path.join(folder.name, name), "wb") as file:
                file.write(struct.pack("<60f", *[value] * 60))
            run(folder.name, f"cvol compress {name} {name}.cvol --dims 3x4x5 --type float32 --fill nan")
        with Viewer(folder.name, "one.raw.cvol", "none.raw.cvol") as other:
            for volume, grey, found in ("0", 128, True), ("1", 0, False):
                self.assertIs(other.get(f"volumes/{volume}").json["has_values"], found)
                for window in "", "&window=7.5,7.5":
                    picture = other.get(f"volumes/{volume}/slice?axis=z&index=1{window}").picture
                    self.assertEqual({picture.at(i, j)[0] for i in range(3) for j in range(4)}, {grey})
                answer = other.post("frame", {"view": {"volume": volume, "width": 40, "height": 40}})
                self.assertIs(json.loads(answer.headers["Cvol-Frame"])["empty"], not found)

    def test_labels_have_no_units(self):
        for name in "labels.cvol", "lossy.cvol", "labels.nrrd":
            with self.subTest(name):
                reply = self.volumes[name]
                self.assertEqual(reply["state"], "ready", reply["error"])
                self.assertLess(abs(reply["max"] - 3000), 400)
                self.assertIsNone(reply["rescale"])  # the page then shows no "HU" and no CT presets
                self.assertEqual((reply["value_scale"], reply["value_offset"]), (1, 0))
                self.assertIsNone(viewer.get(f"volumes/{reply['id']}").json["rescale"])
                self.assertIsNone(viewer.get(f"volumes/{reply['id']}/value?x=1&y=1&z=1").json["meaning"])

    def test_labels_are_exact(self):
        reply = self.volumes["labels.cvol"]
        self.assertTrue(reply["exact"])
        expected = list(labels())
        for x, y, z in (0, 0, 0), (9, 13, 21), (31, 31, 31), (16, 8, 12):
            value = viewer.get(f"volumes/{reply['id']}/value?x={x}&y={y}&z={z}").json["value"]
            self.assertEqual(value, expected[x + SIDE * (y + SIDE * z)])

    def test_ct_scan_has_hounsfield_units(self):
        reply = self.volumes["body.cvol"]
        self.assertEqual(reply["rescale"], [1, -1024])
        at = viewer.get(f"volumes/{reply['id']}/value?x=2&y=3&z=4").json
        self.assertAlmostEqual(at["meaning"], at["value"] - 1024)

    def test_ct_presets_are_listed_separately(self):
        about = viewer.get("").json
        self.assertIn("auto", about["transfers"])
        self.assertTrue(about["ct_transfers"])
        auto = [viewer.get(f"volumes/{self.volumes[name]['id']}/transfer?name=auto").json["points"]
                for name in ("labels.cvol", "labels.nrrd")]
        self.assertEqual(auto[0], auto[1])
        self.assertTrue(all(0 <= point[0] <= 3000 for point in auto[0]), auto[0])


if __name__ == "__main__":
    unittest.main()
