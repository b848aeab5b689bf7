"""The viewer's units: labels are not Hounsfield units, whatever their values."""

import array
import os
import random
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


def setUpModule():
    global folder, viewer
    folder = make_folder()
    raw = f"--dims {SIDE}x{SIDE}x{SIDE} --type uint16"
    write_words("labels.raw", labels())
    write_words("body.raw", body())
    run(folder.name, f"cvol compress labels.raw labels.cvol {raw}")
    run(folder.name, f"cvol compress labels.raw lossy.cvol {raw} --psnr 50 --labels no")
    run(folder.name, "cvol decompress labels.cvol labels.nrrd")
    run(folder.name, f"cvol compress body.raw body.cvol {raw} --psnr 50")
    viewer = Viewer(folder.name, "labels.cvol", "lossy.cvol", "labels.nrrd", "body.cvol")
    viewer.__enter__()


def tearDownModule():
    viewer.__exit__()
    folder.cleanup()
    assert viewer.status == 0, f"the viewer ended with {viewer.status}"


class Units(unittest.TestCase):
    def setUp(self):
        self.volumes = {v["name"]: v for v in viewer.get("volumes").json["volumes"]}
        self.assertEqual(len(self.volumes), 4)
        self.assertFalse(self.volumes["lossy.cvol"]["exact"])

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
