"""Labels in the viewer are drawn as cvol render draws them: by their shape, thin ones too."""

import json
import os
import re
import unittest

from viewer_client import Viewer, make_folder, read_png, run

SIDE = 40
VIEW = {"width": 80, "height": 80, "camera": {"azimuth": 30, "elevation": 20, "zoom": 1.5}, "light": {"on": False}}
PLATE, BALL, ROD = 7, 900, 31


def label_at(x, y, z):
    """A plate and a rod of one sample, and a ball."""
    if z == 10 and 6 <= x < 34 and 6 <= y < 34:
        return PLATE
    if x == 20 and y == 20 and z < 36:
        return ROD
    return BALL if (x - 20) ** 2 + (y - 12) ** 2 + (z - 25) ** 2 < 36 else 0


def planes():
    return (i // SIDE**2 for i in range(SIDE**3))


def setUpModule():
    global folder, viewer
    folder = make_folder()
    samples = [label_at(i % SIDE, i // SIDE % SIDE, i // SIDE**2) for i in range(SIDE**3)]
    header = f"NRRD0004\ntype: uint16\ndimension: 3\nsizes: {SIDE} {SIDE} {SIDE}\nencoding: raw\nendian: little\n"
    header += f"Segment0_LabelValue:={PLATE}\nSegment0_Name:=Base plate\nSegment0_Color:=1 0.5 0\n\n"
    with open(os.path.join(folder.name, "labels.seg.nrrd"), "wb") as file:
        file.write(header.encode())
        file.write(b"".join(sample.to_bytes(2, "little") for sample in samples))
    run(folder.name, "cvol compress labels.seg.nrrd labels.cvol")
    far = header.split("Segment0")[0].replace("uint16", "int32") + "\n"
    with open(os.path.join(folder.name, "missing.nrrd"), "wb") as file:
        file.write(far.encode())
        file.write(b"".join((s if z < 30 else 2 * 10**9).to_bytes(4, "little") for s, z in zip(samples, planes())))
    run(folder.name, "cvol compress missing.nrrd missing.cvol --fill 2000000000 --lossless")
    viewer = Viewer(folder.name, "labels.cvol", "labels.seg.nrrd")
    viewer.__enter__()


def tearDownModule():
    viewer.__exit__()
    folder.cleanup()
    assert viewer.status == 0, f"the viewer ended with {viewer.status}"


class Labels(unittest.TestCase):
    def setUp(self):
        self.volumes = {v["name"]: v["id"] for v in viewer.get("volumes").json["volumes"]}
        self.assertEqual(len(self.volumes), 2)

    def test_picture_is_that_of_the_command(self):
        for name, volume in self.volumes.items():
            view = {"volume": volume, **VIEW}
            command = viewer.post("command", {"view": view}).json["command"]
            run(folder.name, command)
            out = re.search(r" -o (\S+)", command)[1]
            with open(os.path.join(folder.name, out), "rb") as file:
                self.assertEqual(viewer.frame(**view), read_png(file.read()), command)

    def test_missing_samples_are_no_label(self):
        """Their value may lie far from all labels."""
        with Viewer(folder.name, "missing.cvol") as other:
            volume = other.get("volumes").json["volumes"][0]
            self.assertEqual([label["value"] for label in volume["labels"]], [PLATE, ROD, BALL])
            other.frame(volume=volume["id"], **VIEW)

    def test_each_label_has_its_colour(self):
        run(folder.name, "cvol render labels.cvol -o scene.png --json > scene.json")
        with open(os.path.join(folder.name, "scene.json")) as file:
            labels = json.load(file)["labels"]
        self.assertEqual([label["value"] for label in labels], [PLATE, ROD, BALL])
        picture = viewer.frame(volume=self.volumes["labels.cvol"], **VIEW)
        found = {picture.at(x, y) for x in range(80) for y in range(80)}
        for label in labels:
            rgb = [255 * c for c in label["colour"]]
            self.assertTrue(any(max(abs(a - b) for a, b in zip(rgb, of)) < 3 for of in found), label)

    def test_names_and_colours_of_the_file(self):
        volume = self.volumes["labels.seg.nrrd"]
        labels = viewer.get(f"volumes/{volume}").json["labels"]
        self.assertEqual([label["value"] for label in labels], [PLATE, ROD, BALL])
        self.assertEqual(labels[0], {"value": PLATE, "name": "Base plate", "colour": [1, 0.5, 0]})
        self.assertIsNone(labels[1]["name"])
        for place, name in ("x=8&y=8&z=10", "Base plate"), ("x=20&y=20&z=5", None):
            self.assertEqual(viewer.get(f"volumes/{volume}/value?{place}").json["label"], name)

    def test_slices_have_the_colours_of_labels(self):
        volume = self.volumes["labels.seg.nrrd"]
        colours = {v["value"]: tuple(int(255 * c + 0.5) for c in v["colour"])
                   for v in viewer.get(f"volumes/{volume}").json["labels"]}
        colours[0] = (0, 0, 0)
        places = {"x": lambda i, j: (20, i, SIDE - 1 - j), "y": lambda i, j: (i, 12, SIDE - 1 - j), "z": lambda i, j: (i, j, 10)}
        for axis, index in ("x", 20), ("y", 12), ("z", 10):
            path = f"volumes/{volume}/slice?axis={axis}&index={index}"
            picture = viewer.get(path).picture
            for j in range(SIDE):
                for i in range(SIDE):
                    self.assertEqual(tuple(picture.at(i, j)), colours[label_at(*places[axis](i, j))], (axis, i, j))
            grey = viewer.get(path + "&window=0,900").picture
            self.assertTrue(all(len(set(grey.at(i, j))) == 1 for i in range(SIDE) for j in range(SIDE)))

    def test_copies_with_loss_are_refused(self):
        """cvol transcode refuses them, too."""
        for volume in self.volumes.values():
            reply = viewer.post(f"volumes/{volume}/copy", {"ratio": 60})
            self.assertEqual(reply.status, 400)
            self.assertIn("has labels: a copy with loss would have other values", reply.json["error"])

    def test_the_default_view_has_thin_labels(self):
        """The rod alone is 35 samples high, and the plate 28 wide; the ball 12."""
        home = viewer.get("volumes/" + self.volumes["labels.cvol"]).json["home"]
        self.assertGreater(min(home["size"]), 30)

    def test_a_table_of_labels(self):
        with open(os.path.join(folder.name, "table.txt"), "w") as file:
            file.write(f'{ROD} 0 0 255 1 1 1 "A rod"\n')
        with Viewer(folder.name, "labels.cvol", "--label-table", "table.txt") as other:
            labels = other.wait_for("0")["labels"]
        self.assertEqual(labels[1], {"value": ROD, "name": "A rod", "colour": [0, 0, 1]})

    def test_names_that_are_not_utf_8(self):
        """Answers have '?' in place of other letters, for labels of the volume and of an overlay."""
        table, segments = (os.path.join(folder.name, name) for name in ("latin.txt", "latin.seg.nrrd"))
        with open(table, "wb") as file:
            file.write(f'{ROD} 0 0 255 1 1 1 "A r\xf6d"\n'.encode("latin-1"))
        with open(os.path.join(folder.name, "labels.seg.nrrd"), "rb") as whole, open(segments, "wb") as file:
            file.write(whole.read().replace(b"Base plate", b"Base pl\xe4te"))
        with Viewer(folder.name, "labels.cvol", "--label-table", table, "--overlay", segments) as other:
            volume = other.wait_for("0")
            self.assertEqual(volume["labels"][1], {"value": ROD, "name": "A r?d", "colour": [0, 0, 1]})
            self.assertEqual(volume["overlays"][0]["labels"][0]["name"], "Base pl?te")
            rod = other.get("volumes/0/value?x=20&y=20&z=5").json
            self.assertEqual((rod["value"], rod["label"]), (ROD, "A r?d"))
            self.assertEqual(other.get("volumes/0/value?x=8&y=8&z=10").json["overlays"],
                             [{"value": PLATE, "label": "Base pl?te"}])

    def test_colours_by_value_remain(self):
        """An own transfer function, or another opacity, is by value."""
        volume = self.volumes["labels.cvol"]
        shape = viewer.frame(volume=volume, **VIEW)
        self.assertNotEqual(viewer.frame(volume=volume, opacity_scale=0.1, **VIEW), shape)
        points = [[0, 0, 0, 0, 0], [900, 1, 0, 0, 1]]
        self.assertNotEqual(viewer.frame(volume=volume, transfer=points, **VIEW), shape)

    def test_a_place_is_found_on_a_thin_label(self):
        volume = self.volumes["labels.cvol"]
        picture = viewer.frame(volume=volume, **VIEW)
        hits = 0
        for x in range(4, 80, 8):
            for y in range(4, 80, 8):
                place = {"view": {"volume": volume, **VIEW}, "x": (x + 0.5) / 80, "y": (y + 0.5) / 80}
                reply = viewer.post("pick", place).json
                hits += reply["hit"]
                if max(picture.at(x, y)) > 200:
                    self.assertTrue(reply["hit"], (x, y))
                    self.assertIn(reply["value"], (PLATE, BALL, ROD))
        self.assertGreater(hits, 10)


if __name__ == "__main__":
    unittest.main()
