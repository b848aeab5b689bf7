"""Distances, angles and regions, compared with the geometry that the file states and with the original samples."""

import array
import math
import os
import random
import sys
import unittest

from viewer_client import Viewer, make_folder, run, write_floats

DIMS = (30, 26, 22)
SPACING = (0.5, 0.8, 2.5)
BLOCK = (4, 14, 6, 16, 3, 9)  # a box of one value


def rotation():
    """Unit vectors of the axes: turned by 30 degrees about z, then by 40 about x."""
    a, b = math.radians(30), math.radians(40)
    return ((math.cos(a), math.sin(a) * math.cos(b), math.sin(a) * math.sin(b)),
            (-math.sin(a), math.cos(a) * math.cos(b), math.cos(a) * math.sin(b)),
            (0.0, -math.sin(b), math.cos(b)))


def places():
    for z in range(DIMS[2]):
        for y in range(DIMS[1]):
            for x in range(DIMS[0]):
                yield x, y, z


def within(box, place):
    return all(box[2 * a] <= place[a] < box[2 * a + 1] for a in range(3))


def in_ellipsoid(box, place):
    return within(box, place) and sum(
        ((2 * place[a] + 1 - box[2 * a] - box[2 * a + 1]) / (box[2 * a + 1] - box[2 * a]))**2 for a in range(3)) <= 1 + 1e-9


def blocks():
    """-700 in BLOCK, else other numbers."""
    for x, y, z in places():
        yield -700 if within(BLOCK, (x, y, z)) else 3 * x - 40 * y + 11 * z


def waves():
    numbers = random.Random(5)
    for x, y, z in places():
        yield 100 + 40 * math.sin(x / 4) * math.cos(y / 5) + 20 * math.sin(z / 3) + 4 * numbers.random()


def write_nrrd(name, more, directions, values):
    words = array.array("h", values)
    if sys.byteorder == "big":
        words.byteswap()
    columns = " ".join("(" + ",".join(f"{SPACING[a] * part:.17g}" for part in directions[a]) + ")" for a in range(3))
    with open(os.path.join(folder.name, name), "wb") as file:
        file.write(f"NRRD0004\ntype: short\ndimension: 3\nsizes: {DIMS[0]} {DIMS[1]} {DIMS[2]}\nencoding: raw\n"
                   f"endian: little\nspace: left-posterior-superior\nspace directions: {columns}\n"
                   f"space origin: (7,-3,50)\n{more}\n".encode())
        file.write(words.tobytes())


def setUpModule():
    global folder, viewer, volumes
    folder = make_folder()
    write_nrrd("tilted.nrrd", 'space units: "um" "um" "um"\n', rotation(), blocks())
    write_nrrd("unitless.nrrd", "", rotation(), blocks())
    run(folder.name, "cvol compress tilted.nrrd tilted.cvol --lossless")
    run(folder.name, "cvol compress unitless.nrrd unitless.cvol --lossless")
    write_floats(os.path.join(folder.name, "first.raw"), waves())
    write_floats(os.path.join(folder.name, "second.raw"), (2 * value for value in waves()))
    raw = f"--dims {DIMS[0]}x{DIMS[1]}x{DIMS[2]} --type float32"
    run(folder.name, f"cvol compress first.raw waves.cvol {raw} --psnr 40")
    run(folder.name, f"cvol compress first.raw second.raw -o run.cvol {raw} --psnr 40")
    viewer = Viewer(folder.name, "tilted.cvol", "unitless.cvol", "waves.cvol", "run.cvol")
    viewer.__enter__()
    volumes = {v["name"]: v for v in viewer.get("volumes").json["volumes"]}


def tearDownModule():
    viewer.__exit__()
    folder.cleanup()
    assert viewer.status == 0, f"the viewer ended with {viewer.status}"


def measure(name, **body):
    return viewer.post(f"volumes/{volumes[name]['id']}/measure", body)


class Geometry(unittest.TestCase):
    def world(self, sample):
        return [sum(SPACING[a] * rotation()[a][i] * sample[a] for a in range(3)) for i in range(3)]

    def test_distances(self):
        numbers = random.Random(1)
        for _ in range(20):
            points = [[numbers.uniform(-0.5, n - 0.5) for n in DIMS] for _ in range(2)]
            reply = measure("tilted.cvol", kind="distance", points=points).json
            self.assertAlmostEqual(reply["length"], math.dist(*map(self.world, points)), delta=1e-5)
            self.assertEqual((reply["unit"], reply["unit_assumed"]), ("um", False))
        along = [[3, 2, 4], [3, 2, 14]]
        self.assertAlmostEqual(measure("tilted.cvol", kind="distance", points=along).json["length"], 25, delta=1e-5)

    def test_distances_agree_with_positions(self):
        corners = [(1, 2, 3), (20, 25, 19)]
        ends = [viewer.get(f"volumes/{volumes['tilted.cvol']['id']}/value?x={x}&y={y}&z={z}").json["world"]
                for x, y, z in corners]
        reply = measure("tilted.cvol", kind="distance", points=corners).json
        self.assertAlmostEqual(reply["length"], math.dist(*ends), delta=1e-5)

    def test_angles(self):
        middle = [10, 10, 10]
        for one, other, degrees in (
                ([15, 10, 10], [10, 17, 10], 90), ([15, 10, 10], [20, 10, 10], 0), ([15, 10, 10], [2, 10, 10], 180),
                # 8 steps of 0.5 and 5 steps of 0.8: 4 each
                ([18, 15, 10], [18, 10, 10], 45)):
            reply = measure("tilted.cvol", kind="angle", points=[one, middle, other]).json
            self.assertAlmostEqual(reply["degrees"], degrees, delta=1e-5)

    def test_units(self):
        points = [[0, 0, 0], [1, 0, 0]]
        reply = measure("unitless.cvol", kind="distance", points=points).json
        self.assertEqual((reply["unit"], reply["unit_assumed"]), ("mm", True))
        reply = measure("waves.cvol", kind="distance", points=points).json
        self.assertEqual((reply["unit"], reply["unit_assumed"]), ("", False))


class Regions(unittest.TestCase):
    def test_a_box_of_one_value(self):
        reply = measure("tilted.cvol", kind="box", box=BLOCK).json
        self.assertEqual(reply["samples"], 600)
        self.assertAlmostEqual(reply["volume"], 600, delta=1e-3)  # a sample has 0.5 x 0.8 x 2.5
        self.assertEqual([reply[name] for name in ("mean", "min", "max", "standard_deviation")], [-700, -700, -700, 0])
        self.assertEqual([reply[name + "_error"] for name in ("mean", "min", "max", "standard_deviation")], [0] * 4)
        larger = measure("tilted.cvol", kind="box", box=[4, 15, 6, 16, 3, 9]).json
        self.assertNotEqual(larger["mean"], -700)

    def check(self, name, values, kind, box, **more):
        """Compares with the original samples in double precision; returns the largest error of a mean as promised."""
        inside = in_ellipsoid if kind == "ellipsoid" else within
        numbers = [value for place, value in zip(places(), values) if inside(box, place)]
        mean = math.fsum(numbers) / len(numbers)
        deviation = math.sqrt(math.fsum((value - mean)**2 for value in numbers) / len(numbers))
        reply = measure(name, kind=kind, box=box, **more).json
        self.assertEqual(reply["samples"], len(numbers))
        self.assertEqual(reply["volume"], len(numbers))
        for key, value in (("mean", mean), ("standard_deviation", deviation), ("min", min(numbers)), ("max", max(numbers))):
            self.assertLessEqual(abs(reply[key] - value), reply[key + "_error"] + 1e-6, (key, reply))
        return reply

    def test_lossy_regions_stay_within_their_bounds(self):
        values = list(waves())
        self.assertFalse(volumes["waves.cvol"]["exact"])
        numbers = random.Random(2)
        for kind in ("box", "ellipsoid") * 10:
            box = [end for n in DIMS for end in sorted(numbers.sample(range(n + 1), 2))]
            self.check("waves.cvol", values, kind, box)
        whole = self.check("waves.cvol", values, "box", [0, DIMS[0], 0, DIMS[1], 0, DIMS[2]])
        # 40 dB: the errors of the whole have a root mean square of a hundredth of the range
        self.assertLess(whole["mean_error"], 0.012 * (max(values) - min(values)))
        self.assertGreater(whole["max_error"], 0)

    def test_times(self):
        box = [3, 20, 5, 18, 7, 8]
        first = self.check("run.cvol", waves(), "ellipsoid", box)
        second = self.check("run.cvol", (2 * value for value in waves()), "ellipsoid", box, time=1)
        self.assertGreater(second["mean"] - first["mean"], 50)


class Invalid(unittest.TestCase):
    def test_fields(self):
        point = [1, 2, 3]
        for body, word in (
                ({}, "kind is ''"), ({"kind": "volume"}, "kind is 'volume'"), (b"nonsense", "not JSON"),
                ({"kind": "distance"}, "points is missing"),
                ({"kind": "distance", "points": [point]}, "points must be 2 points"),
                ({"kind": "angle", "points": [point, point]}, "points must be 3 points"),
                ({"kind": "angle", "points": [[0, 0, 0], point, point]}, "points[2] is points[1]"),
                ({"kind": "distance", "points": [point, [1, 2]]}, "points[1] must be three numbers"),
                ({"kind": "distance", "points": [point, [1, 2, "3"]]}, "points[1] must be three numbers"),
                ({"kind": "distance", "points": [point, [1, 2, 22]]}, "points[1] has 22 along z, must have -0.5 to 21.5"),
                ({"kind": "distance", "points": [point, point], "box": BLOCK}, "unknown field box"),
                ({"kind": "box"}, "box is missing"), ({"kind": "box", "box": [1, 2, 3]}, "box must be 6 numbers"),
                ({"kind": "box", "box": [4, 4, 1, 2, 1, 2]}, "box has 4 to 4 along x"),
                ({"kind": "box", "box": [4, 31, 1, 2, 1, 2]}, "box has 4 to 31 along x, must lie within 0 to 30"),
                ({"kind": "ellipsoid", "box": [4, 5, 1, 2.5, 1, 2]}, "along y, must have whole numbers"),
                ({"kind": "box", "box": BLOCK, "time": 1}, "time is 1")):
            with self.subTest(str(body)):
                answer = viewer.post("volumes/0/measure", body)
                self.assertEqual(answer.status, 400, answer.content)
                self.assertIn(word, answer.error)
        self.assertEqual(viewer.post("volumes/77/measure", {}).status, 404)
        self.assertEqual(viewer.get("volumes/0/measure").status, 405)


if __name__ == "__main__":
    unittest.main()
