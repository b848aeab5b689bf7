"""Files of several volumes: the viewer lists each channel, with all its times."""

import os
import struct
import subprocess
import tempfile
import unittest

from viewer_client import CVOL, Viewer

SHAPE = 40, 36, 30


def ball(middle):
    x, y, z = SHAPE
    return bytes(200 if (i - middle) ** 2 + (j - 18) ** 2 + (k - 15) ** 2 < 120 else 0
                 for k in range(z) for j in range(y) for i in range(x))


def write_nifti(path, volumes):
    header = bytearray(352)
    struct.pack_into("<i", header, 0, 348)
    struct.pack_into("<8h", header, 40, 4, *SHAPE, len(volumes), 1, 1, 1)
    struct.pack_into("<2h", header, 70, 2, 8)
    struct.pack_into("<8f", header, 76, 1, 1, 1, 1, 2, 0, 0, 0)
    struct.pack_into("<f", header, 108, 352)
    header[123] = 10  # mm, s
    header[344:348] = b"n+1\0"
    with open(path, "wb") as file:
        file.write(bytes(header) + b"".join(volumes))


class SeveralTest(unittest.TestCase):
    def setUp(self):
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.folder = folder.name
        write_nifti(os.path.join(self.folder, "four.nii"), [ball(12), ball(20), ball(28)])

    def names(self, viewer):
        return [volume["name"] for volume in viewer.get("volumes").json["volumes"]]

    def test_times(self):
        with Viewer(self.folder, "four.nii") as viewer:
            self.assertEqual(self.names(viewer), ["four.nii"])
            self.assertEqual(viewer.get("volumes/0").json["times"], 3)
            for time, middle in enumerate([12, 20, 28]):
                value = viewer.get("volumes/0/value?x=%d&y=18&z=15&time=%d" % (middle, time)).json["value"]
                self.assertGreater(value, 150)
            command = viewer.post("command", {"view": {"volume": "0", "time": 2}}).json["command"]
            self.assertIn("cvol render four.nii --time 2 -o four.png", command)

    def test_choice(self):
        with Viewer(self.folder, "four.nii", "--time", "1") as viewer:
            self.assertEqual(self.names(viewer), ["four.nii"])

    def test_series(self):
        subprocess.run([CVOL, "compress", "four.nii", "-o", "four.cvol", "--lossless"], cwd=self.folder, check=True,
                       capture_output=True)
        with Viewer(self.folder, "four.cvol") as viewer:
            self.assertEqual(self.names(viewer), ["four.cvol"])
            self.assertEqual(viewer.get("volumes/0").json["times"], 3)
        done = subprocess.run([CVOL, "view", "four.cvol", "--time", "7", "--no-browser"], cwd=self.folder,
                              capture_output=True, text=True, timeout=60)
        self.assertEqual(done.returncode, 2)
        self.assertIn("has no time 7", done.stderr)


if __name__ == "__main__":
    unittest.main()
