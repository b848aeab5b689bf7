"""Every request but frames, compared with the output of the command for the same file, and with geometry."""

import io
import json
import math
import os
import random
import re
import stat
import struct
import tarfile
import time
import unittest

from viewer_client import Viewer, make_folder, read_floats, read_png, run, write_floats

DIMS, SPACING = (35, 41, 28), (1, 1, 1.25)
MIDDLE, RADIUS = (17.3, 20.9, 16.2), 12  # a ball in world coordinates; samples hold the depth below its surface
POINTS = [[0, 0.1, 0.2, 0.9, 0], [3.3333333333333335, 0.9, 0.5, 0.1, 0.2], [15, 1, 1, 1, 0.9]]
# src/render/look/studio.c
STUDIO = {"on": True, "direction": [-0.55, 0.65, 0.9], "ambient": 0.3, "diffuse": 0.6, "specular": 0.1,
          "shininess": 24, "fill": 0.2, "occlusion": 0.75, "shadows": 0.6, "in_view": True, "keeps_brightness": True}
SMALL = {"width": 64, "height": 48}


def ball():
    for z in range(DIMS[2]):
        for y in range(DIMS[1]):
            for x in range(DIMS[0]):
                place = (x, y, SPACING[2] * z)
                yield RADIUS - math.dist(place, MIDDLE)


def setUpModule():
    global folder, viewer
    folder = make_folder()
    write_floats(os.path.join(folder.name, "ball.raw"), ball())
    raw = "--dims 35x41x28 --type float32 --spacing 1,1,1.25"
    run(folder.name, f"cvol compress ball.raw ball.cvol {raw} --psnr 70")
    run(folder.name, "cvol decompress ball.cvol back.raw")
    run(folder.name, f"cvol decompress ball.cvol 'it'\\''s a ball.nrrd'")
    os.mkdir(os.path.join(folder.name, "bin"))
    program = os.path.join(folder.name, "bin", "ffmpeg")
    with open(program, "w") as file:
        file.write('#!/bin/sh\nfor last; do :; done\nexec cat >"$last"\n')
    os.chmod(program, stat.S_IRWXU)
    viewer = Viewer(folder.name, "ball.cvol", "it's a ball.nrrd", path=os.path.dirname(program))
    viewer.__enter__()


def tearDownModule():
    viewer.__exit__()
    left = [name for name in os.listdir(folder.name) if name.startswith("cvol-view-")]
    folder.cleanup()
    assert viewer.status == 0, f"the viewer ended with {viewer.status}"
    assert not left, f"{left} stayed behind"


class InvalidRequests(unittest.TestCase):
    def expect(self, status, word, answer):
        self.assertEqual(answer.status, status, answer.content)
        self.assertIn(word, answer.error)

    def test_parameters(self):
        for path, status, word in (
                ("transfer?name=nothing", 400, "nothing"),
                ("transfer", 400, "name is ''"),
                ("transfer?name=bone&nam=x", 400, "unknown parameter nam"),
                ("slice?axis=w&index=1", 400, "axis is 'w'"),
                ("slice?axis=xy&index=1", 400, "axis is 'xy'"),
                ("slice?index=1", 400, "axis is ''"),
                ("slice?axis=z", 400, "index is missing"),
                ("slice?axis=z&index=28", 400, "index is 28, must be 0 to 27"),
                ("slice?axis=z&index=-1", 400, "index is '-1'"),
                ("slice?axis=z&index=99999999999999999999999", 400, "index"),
                ("slice?axis=z&index=1&window=2", 400, "window is '2'"),
                ("slice?axis=z&index=1&window=2,1", 400, "second value must be larger"),
                ("slice?axis=z&index=1&window=nan,1", 400, "window"),
                ("slice?axis=z&index=1&windw=1,2", 400, "unknown parameter windw"),
                ("value?x=1&y=1", 400, "z is missing"),
                ("value?x=1.5&y=1&z=1", 400, "x is '1.5', must be a whole number"),
                ("value?x=1&y=41&z=1", 400, "y is 41, must be 0 to 40"),
                ("value?x=1&y=1&z=", 400, "z is ''")):
            with self.subTest(path):
                self.expect(status, word, viewer.get("volumes/0/" + path))

    def test_bodies(self):
        view = {"volume": "0"}
        for path, body, status, word in (
                ("pick", {}, 400, "view is missing"),
                ("pick", {"view": view, "x": 0.5}, 400, "give x and y"),
                ("pick", {"view": view, "x": 0.5, "y": 1.5}, 400, "y is 1.5, must be 0 to 1"),
                ("pick", {"view": {**view, "mode": "mip"}, "x": 0, "y": 0}, 400, "composite or iso"),
                ("pick", {"view": {**view, "colour": 1}, "x": 0, "y": 0}, 400, "unknown field view.colour"),
                ("pick", {"view": {"volume": "5"}, "x": 0, "y": 0}, 404, "no such volume"),
                ("pick", b"nonsense", 400, "not JSON"),
                ("difference", {"view": view}, 400, "other is missing"),
                ("difference", {"view": view, "other": "5"}, 404, "no such volume"),
                ("difference", {"view": view, "other": "1", "gain": -1}, 400, "gain is -1"),
                ("difference", {"view": view, "other": "1", "gian": 1}, 400, "unknown field gian"),
                ("command", {"view": {**view, "zoom": 2}}, 400, "unknown field view.zoom"),
                ("command", {"view": view, "file": "/etc/passwd"}, 400, "unknown field file"),
                ("command", [], 400, "must be a JSON object"),
                ("volumes/0/copy", {}, 400, "give ratio or psnr"),
                ("volumes/0/copy", {"ratio": 60, "psnr": 30}, 400, "not both"),
                ("volumes/0/copy", {"ratio": "60"}, 400, "ratio must be a number"),
                ("volumes/0/copy", {"ratio": 60, "path": "x"}, 400, "unknown field path"),
                ("volumes/77/copy", {"ratio": 60}, 404, "no volume '77'"),
                ("volumes/0/transfer", b"", 400, "is empty"),
                ("volumes/0/transfer", b'{"points": [[1, 2', 400, "line 1"),
                ("volumes/0/transfer", b'{"points": [[1, 2, 3]]}', 400, "transfer function"),
                ("films", {"view": view, "frames": 0}, 400, "frames is 0, must be 1 to 3600"),
                ("films", {"view": view, "frames": 2.5}, 400, "whole number"),
                ("films", {"view": view, "format": "avi"}, 400, "gif webp png mp4"),
                ("films", {"view": view, "fps": 0}, 400, "fps is 0"),
                ("films", {"view": view, "name": "/tmp/x"}, 400, "unknown field name"),
                ("films", {"view": {"volume": "5"}}, 404, "no such volume")):
            with self.subTest(f"{path} {body}"):
                self.expect(status, word, viewer.post(path, body))

    def test_unknown_names_and_wrong_methods(self):
        self.expect(404, "no animation 'f77'", viewer.get("films/f77"))
        self.expect(404, "no animation 'f77'", viewer.get("films/f77/file"))
        self.expect(404, "no animation 'f77'", viewer.delete("films/f77"))
        self.expect(403, "not a copy", viewer.delete("volumes/0"))
        self.expect(404, "no volume '77'", viewer.delete("volumes/77"))
        for path in "transfer?name=bone", "slice?axis=z&index=1", "value?x=1&y=1&z=1", "histogram":
            self.expect(404, "no volume '77'", viewer.get("volumes/77/" + path))
        self.expect(405, "pick", viewer.get("pick"))
        self.expect(404, "unknown path", viewer.get("volumes/0/../../films"))


class Samples(unittest.TestCase):
    def setUp(self):
        samples = read_floats(os.path.join(folder.name, "back.raw"))
        self.sample = lambda x, y, z: samples[x + DIMS[0] * (y + DIMS[1] * z)]

    def test_values(self):
        for place in ((0, 0, 0), (17, 20, 13), (34, 40, 27), (5, 33, 8)):
            reply = viewer.get("volumes/0/value?x={}&y={}&z={}".format(*place)).json
            self.assertEqual(reply["sample"], list(place))
            self.assertAlmostEqual(reply["value"], self.sample(*place), delta=1e-6)
            self.assertIsNone(reply["meaning"])
            self.assertEqual(reply["world"], [p * s for p, s in zip(place, SPACING)])

    def test_slices(self):
        low, high = -10, 11
        views = {"x": (9, 41, 28, lambda i, j: (9, i, 27 - j)), "y": (30, 35, 28, lambda i, j: (i, 30, 27 - j)),
                 "z": (13, 35, 41, lambda i, j: (i, j, 13))}
        for axis, (index, width, height, place) in views.items():
            answer = viewer.get(f"volumes/0/slice?axis={axis}&index={index}&window={low},{high}")
            self.assertEqual(answer.headers["Content-Type"], "image/png")
            picture = answer.picture
            self.assertEqual((picture.width, picture.height), (width, height))
            for j in range(height):
                for i in range(width):
                    share = (self.sample(*place(i, j)) - low) / (high - low)
                    grey = min(max(255 * share, 0), 255)
                    self.assertEqual(len(set(picture.at(i, j))), 1)
                    self.assertLess(abs(picture.at(i, j)[0] - grey), 0.51)

    def test_window_of_all_values(self):
        histogram = viewer.get("volumes/0/histogram").json
        window = "{min},{max}".format(**histogram)
        usual = viewer.get("volumes/0/slice?axis=y&index=20").picture
        self.assertEqual(usual, viewer.get("volumes/0/slice?axis=y&index=20&window=" + window).picture)
        # 64 counts of four bins each, rounded to quarters of octaves.
        share = sum(histogram["bins"]) / 4 / (DIMS[0] * DIMS[1] * DIMS[2])
        self.assertLess(abs(share - 1), 0.125)


class Transfers(unittest.TestCase):
    def test_names(self):
        about = viewer.get("").json
        for name in about["transfers"] + about["ct_transfers"]:
            points = viewer.get("volumes/0/transfer?name=" + name).json["points"]
            by_name = viewer.frame(volume="0", transfer=name, **SMALL)
            self.assertEqual(by_name, viewer.frame(volume="0", transfer=points, **SMALL), name)

    def test_files(self):
        own = json.dumps({"points": POINTS}).encode()
        self.assertEqual(viewer.post("volumes/0/transfer", own).json, {"points": POINTS})
        paraview = b'[{"Name": "x", "RGBPoints": [0, 1, 0, 0, 9, 0, 0, 1], "Points": [0, 0, 0.5, 0, 9, 1, 0.5, 0]}]'
        points = viewer.post("volumes/0/transfer", paraview).json["points"]
        self.assertEqual((points[0], points[-1]), ([0, 1, 0, 0, 0], [9, 0, 0, 1, 1]))

    def test_files_have_values_after_the_rescale(self):
        """A volume whose samples mean 2 s - 100, and the command with points of samples."""
        header = ("NDims = 3\nDimSize = 12 12 12\nElementType = MET_UCHAR\nElementToIntensityFunctionSlope = 2\n"
                  "ElementToIntensityFunctionOffset = -100\nElementDataFile = LOCAL\n")
        with open(os.path.join(folder.name, "meant.mha"), "wb") as file:
            file.write(header.encode() + bytes(20 * (i % 12) for i in range(12**3)))
        samples = [[100, 1, 0, 0, 0], [200, 0, 1, 0, 0.5]]
        values = json.dumps({"points": [[100, 1, 0, 0, 0], [300, 0, 1, 0, 0.5]]}).encode()
        with Viewer(folder.name, "meant.mha") as other:
            other.wait_for("0")
            # At a ratio of 30 so few samples would be noise: cvol render and cvol view choose a PSNR.
            self.assertLess(other.get("volumes/0").json["max_error"], 20)
            self.assertEqual(other.post("volumes/0/transfer", values).json["points"], samples)
            view = {"volume": "0", "transfer": samples, "camera": {"azimuth": 30}, **SMALL}
            reply = other.post("command", {"view": view}).json
            for name, content in reply["files"].items():
                with open(os.path.join(folder.name, name), "w") as file:
                    json.dump(content, file)
            run(folder.name, reply["command"])
            with open(os.path.join(folder.name, re.search(r" -o (\S+)", reply["command"])[1]), "rb") as file:
                self.assertEqual(read_png(file.read()), other.frame(**view), reply["command"])


class BlockCache(unittest.TestCase):
    """The renderer keeps decoded blocks for the next pictures, which do not change."""

    def render_all_axes(self, keep_mb):
        """Renders pictures along all axes, twice; returns the pictures and the kept bytes."""
        with Viewer(folder.name, "ball.cvol", "--keep-mb", keep_mb) as v:
            self.assertEqual(v.get("status").json["kept_bytes"], 0)
            views = [{"camera": {"azimuth": angle, "elevation": angle / 2}, "transfer": POINTS, "light": {"on": angle > 90}, **more}
                     for angle in (10, 100, 170) for more in ({}, {"mode": "mip"})]
            pictures = [v.frame(volume="0", **view, **SMALL) for view in views * 2]
            kept = v.get("status").json["kept_bytes"]
        self.assertEqual(v.status, 0)
        return pictures, kept

    def test_pictures_do_not_depend_on_the_cache(self):
        plain, nothing = self.render_all_axes("0")
        self.assertEqual(nothing, 0)
        pictures, all_of_them = self.render_all_axes("100")
        self.assertEqual(pictures, plain)
        # The ball's blocks as 16-bit samples, along each axis.
        self.assertGreater(all_of_them, 3 * 2 * RADIUS ** 3)
        pictures, some = self.render_all_axes("0.02")
        self.assertEqual(pictures, plain)
        self.assertGreater(some, 0)
        self.assertLessEqual(some, 20000)


class Pick(unittest.TestCase):
    """Picks hit the ball's surface at the place given by the camera's formula."""

    def ray_of(self, camera, x, y):
        """Returns the ray's start and direction in the world, relative to the volume's centre, the direction of
        depth, and the volume's extent."""
        a, e, r = (math.radians(camera.get(name, 0)) for name in ("azimuth", "elevation", "roll"))
        eye = (math.cos(e) * math.sin(a), -math.cos(e) * math.cos(a), math.sin(e))
        right = (math.cos(a), math.sin(a), 0)
        up = (-math.sin(e) * math.sin(a), math.sin(e) * math.cos(a), math.cos(e))
        right, up = ([p * math.cos(r) + q * math.sin(r) for p, q in zip(right, up)],
                     [q * math.cos(r) - p * math.sin(r) for p, q in zip(right, up)])
        extent = [(d - 1) * s for d, s in zip(DIMS, SPACING)]
        diagonal = math.hypot(*extent)
        height = diagonal / camera.get("zoom", 1)
        u, v = (x - 0.5) * height * SMALL["width"] / SMALL["height"], (0.5 - y) * height
        at = [c + u * p + v * q for c, p, q in zip(camera.get("look_at", (0, 0, 0)), right, up)]
        if not camera.get("fov"):
            ahead = diagonal / 2 - sum(p * q for p, q in zip(at, eye))
            start = [p + ahead * q for p, q in zip(at, eye)]
            return start, [-q for q in eye], [-q for q in eye], extent
        distance = height / 2 / math.tan(math.radians(camera["fov"] / 2))
        start = [c + distance * q for c, q in zip(camera.get("look_at", (0, 0, 0)), eye)]
        along = [p - q for p, q in zip(at, start)]
        length = math.hypot(*along)
        return start, [p / length for p in along], [-q for q in eye], extent

    def check(self, camera, x, y, mirror):
        """Checks the reply of pick; returns whether the ray hits the ball."""
        start, along, towards, extent = self.ray_of(camera, 1 - x if mirror else x, y)
        centre = [m - s / 2 for m, s in zip(MIDDLE, extent)]
        off = [p - q for p, q in zip(start, centre)]
        b = sum(p * q for p, q in zip(off, along))
        inside = lambda radius: b * b - sum(p * p for p in off) + radius * radius
        view = {"volume": "0", "mode": "iso", "surface": {"value": 0}, "camera": camera, "mirror": mirror, **SMALL}
        reply = viewer.post("pick", {"view": view, "x": x, "y": y}).json
        if inside(RADIUS - 1.5) < 0 < inside(RADIUS + 0.5):
            return False  # near the silhouette a hit depends on rounding
        self.assertEqual(reply["hit"], inside(RADIUS) > 0, (camera, x, y))
        if not reply["hit"]:
            return False
        t = -b - math.sqrt(inside(RADIUS))
        place = [(p + t * q + s / 2) for p, q, s in zip(start, along, extent)]
        self.assertLess(math.dist(reply["world"], place), 0.5, (camera, x, y))
        self.assertAlmostEqual(reply["depth"], t * sum(p * q for p, q in zip(along, towards)), delta=0.5)
        for a in range(3):
            self.assertAlmostEqual(reply["sample"][a] * SPACING[a], reply["world"][a], delta=1e-6)
        nearest = viewer.get("volumes/0/value?x={}&y={}&z={}".format(*(math.floor(s + 0.5) for s in reply["sample"])))
        self.assertEqual(reply["value"], nearest.json["value"])
        return True

    def test_ball(self):
        cameras = ({}, {"azimuth": 30, "elevation": 20, "roll": 40, "zoom": 1.7, "look_at": [3, -2, 5]},
                   {"azimuth": 250, "elevation": -40, "fov": 60}, {"fov": 100, "zoom": 1.5, "look_at": [-4, 1, 2]})
        for camera in cameras:
            met = sum(self.check(camera, (i + 0.5) / 12, (j + 0.5) / 9, (i + j) % 2 == 1)
                      for i in range(12) for j in range(9))
            self.assertGreater(met, 4, camera)


class Commands(unittest.TestCase):
    def check(self, view, asked=None):
        asked = asked or viewer
        reply = asked.post("command", {"view": view}).json
        for name, content in reply["files"].items():
            with open(os.path.join(folder.name, name), "w") as file:
                json.dump(content, file)
        run(folder.name, reply["command"])
        name = re.search(r" -o ('(?:[^']|'\\'')*'|\S+)", reply["command"])[1]
        name = name.strip("'").replace("'\\''", "'")
        with open(os.path.join(folder.name, name), "rb") as file:
            self.assertEqual(read_png(file.read()), asked.frame(**view), reply["command"])
        return reply

    def test_pictures(self):
        lit = {"on": True, "direction": [-1, 2, 3], "ambient": 0.3, "shininess": 30, "gradient_opacity": 0.5}
        clip = {"box": [None, 20.5, 3, None, None, None], "planes": [[1, 0, 0.5, -8], [-1, 1, 0, -9]]}
        camera = {"azimuth": -30.123456789, "elevation": 20, "roll": 7, "zoom": 1.7, "look_at": [-5, 3.3, 4]}
        for view in ({"camera": camera, "transfer": POINTS, "opacity_scale": 0.3, "mirror": True,
                      "background": [0.1, 0.2, 1]},
                     {"camera": {"fov": 50}, "transfer": "bone", "light": lit, "clip": clip},
                     {"transfer": "ct-bone", "step": 0.5},
                     {"mode": "iso", "surface": {"value": 1.5, "colour": [1, 0, 0]}, "light": {"specular": 0.9}},
                     {"light": STUDIO}, {"light": {**STUDIO, "occlusion": 0.5}, "mirror": True, "camera": camera},
                     {"light": {**STUDIO, "direction": [0, 0, 0]}, "transfer": "bone"},
                     {"light": {**STUDIO, "samples": 64, "occlusion": 1}}, {"light": {**STUDIO, "samples": 9}},
                     {"light": {**lit, "samples": 5, "shadows": 0.5}},
                     {"light": {**lit, "fill": 0.3, "shadows": 0.5}},
                     {"mode": "mip", "window": [-3.1, 9.7], "oversample": 2}, {"mode": "xray"}):
            for volume in "0", "1":
                self.check({"volume": volume, **view, **SMALL})

    def test_default_values_are_left_out(self):
        reply = self.check({"volume": "0", "oversample": 1, "camera": {"zoom": 1, "look_at": [0, 0, 0]}})
        self.assertEqual(reply, {"command": "cvol render ball.cvol -o ball.png --size 512x512 --fit box --azimuth 0 "
                                 "--elevation 0 --light flat", "files": {}})

    def test_other_input_files(self):
        raw = "--dims 35x41x28 --type float32"
        write_floats(os.path.join(folder.name, "hole.raw"), (v if v > -9 else 1e35 for v in ball()))
        run(folder.name, f"cvol compress ball.raw hole.raw -o both.cvol --as channels --fill 1e35 {raw}")
        with open(os.path.join(folder.name, "ball.cvol"), "rb") as file:
            whole = file.read()
        with open(os.path.join(folder.name, "cut.cvol"), "wb") as file:
            file.write(whole[:len(whole) // 2])  # the viewer renders the complete level, as the command does
        with Viewer(folder.name, "both.cvol", "cut.cvol", "hole.raw", *raw.split()) as other:
            for volume in "0", "1", "2", "3":  # both.cvol has two
                self.check({"volume": volume, "transfer": "bone", **SMALL}, other)
            self.assertEqual(other.get("volumes/0").json["whole_level"], 0)
            self.assertGreater(other.get("volumes/2").json["whole_level"], 0)
            copy = other.post("volumes/3/copy", {"ratio": 50}).json["id"]
            other.wait_for(copy)
            self.check({"volume": copy, "transfer": "bone", **SMALL}, other)
            self.assertIsNone(other.get(f"volumes/{copy}/value?x=0&y=0&z=0").json["value"])
        with Viewer(folder.name, "both.cvol", "--channel", "1") as other:
            self.check({"volume": "0", **SMALL}, other)

    def test_noise(self):
        """A ratio of 30 would leave less than 25 dB."""
        numbers = random.Random(2)
        write_floats(os.path.join(folder.name, "noise.raw"), (numbers.gauss(0, 1) for _ in range(math.prod(DIMS))))
        with Viewer(folder.name, "noise.raw", "--dims", "35x41x28", "--type", "float32") as other:
            self.assertGreater(other.wait_for("0")["psnr_db"], 35)
            self.check({"volume": "0", "transfer": "bone", **SMALL}, other)

    def test_copies(self):
        for parent, wanted in ("0", {"ratio": 90}), ("1", {"psnr": 45.5}):
            copy = viewer.post(f"volumes/{parent}/copy", wanted).json["id"]
            state = viewer.wait_for(copy)
            self.assertEqual((state["state"], state["error"]), ("ready", None))
            self.check({"volume": copy, "transfer": POINTS, **SMALL})
            viewer.delete("volumes/" + copy)

    def test_copy_without_background(self):
        grains = random.Random(1)  # scattered: the mask of the background takes one bit per sample
        values = (grains.choice((0, grains.uniform(5, 9))) for _ in range(math.prod(DIMS)))
        write_floats(os.path.join(folder.name, "grains.raw"), values)
        run(folder.name, "cvol compress grains.raw grains.cvol --dims 35x41x28 --type float32 --psnr 40 --background 0")
        with Viewer(folder.name, "grains.cvol") as asked:
            copy = asked.wait_for(asked.post("volumes/0/copy", {"ratio": 60}).json["id"])
            self.assertGreater(copy["ratio"], 55, copy)
            reply = self.check({"volume": copy["id"], "transfer": POINTS, **SMALL}, asked)
            self.assertIn("--background none", reply["command"])


class Copies(unittest.TestCase):
    def test_create_and_delete(self):
        answer = viewer.post("volumes/0/copy", {"ratio": 90})
        self.assertEqual(answer.status, 202)
        self.assertEqual((answer.json["parent"], answer.json["name"]), ("0", "ball.cvol"))
        copy = viewer.wait_for(answer.json["id"])
        self.assertEqual(copy["state"], "ready", copy["error"])
        self.assertGreater(copy["ratio"], 80)
        self.assertEqual(copy["dims"], list(DIMS))
        self.assertEqual(viewer.delete("volumes/" + copy["id"]).status, 200)
        self.assertEqual(viewer.get("volumes/" + copy["id"]).status, 404)

    def test_new_copy_replaces_old_one_of_a_client(self):
        first = viewer.post("volumes/0/copy", {"ratio": 90, "viewer": "me"}).json["id"]
        second = viewer.post("volumes/0/copy", {"psnr": 40, "viewer": "me"}).json["id"]
        other = viewer.post("volumes/0/copy", {"psnr": 40, "viewer": "another"}).json["id"]
        ids = [v["id"] for v in viewer.get("volumes").json["volumes"]]
        self.assertNotIn(first, ids)
        for copy in second, other:
            self.assertIn(copy, ids)
            self.assertEqual(viewer.wait_for(copy)["state"], "ready")
            viewer.delete("volumes/" + copy)

    def test_limit_of_copies(self):
        made = ["0"]
        for _ in range(40):
            answer = viewer.post(f"volumes/{made[-1]}/copy", {"ratio": 90})
            if answer.status != 202:
                break
            made.append(answer.json["id"])
            self.assertEqual(viewer.wait_for(made[-1])["state"], "ready")
            if len(made) > 2:
                self.assertEqual(viewer.delete("volumes/" + made[-2]).status, 200)
        self.assertEqual(answer.status, 429)
        self.assertLessEqual(len(made), 33)
        self.assertEqual(viewer.delete("volumes/" + made[-1]).status, 200)
        for _ in range(600):  # the server deletes the copies when the last thread ends
            answer = viewer.post("volumes/0/copy", {"ratio": 50})
            if answer.status == 202:
                break
            time.sleep(0.05)
        self.assertEqual(answer.status, 202)
        self.assertEqual(viewer.delete("volumes/" + answer.json["id"]).status, 200)

    def test_unreachable_target(self):
        copy = viewer.post("volumes/0/copy", {"psnr": 150}).json["id"]
        state = viewer.wait_for(copy)
        self.assertEqual(state["state"], "failed")
        self.assertTrue(state["error"])
        self.assertEqual(viewer.get(f"volumes/{copy}/histogram").status, 409)
        viewer.delete("volumes/" + copy)


class Differences(unittest.TestCase):
    def test_difference_of_a_volume_with_itself(self):
        answer = viewer.post("difference", {"view": {"volume": "0", **SMALL}, "other": "0"})
        self.assertEqual(set(answer.picture.rgb), {0})
        reply = json.loads(answer.headers["Cvol-Frame"])
        self.assertEqual((reply["psnr_db"], reply["ssim"]), (None, 1))

    def test_difference_of_a_copy(self):
        copy = viewer.post("volumes/0/copy", {"ratio": 150}).json["id"]
        viewer.wait_for(copy)
        for view, gain in ({"transfer": POINTS, "mirror": True}, 20), ({"mode": "xray", "window": [-5, 10]}, 3):
            answer = viewer.post("difference", {"view": {"volume": "0", **view, **SMALL}, "other": copy, "gain": gain})
            reply = json.loads(answer.headers["Cvol-Frame"])
            a, b = (viewer.frame(volume=volume, **view, **SMALL).rgb for volume in ("0", copy))
            self.assertEqual(answer.picture.rgb, bytes(min(255, gain * abs(p - q)) for p, q in zip(a, b)))
            mean = sum((p - q) ** 2 for p, q in zip(a, b)) / len(a)
            self.assertGreater(mean, 0)
            self.assertAlmostEqual(reply["psnr_db"], 10 * math.log10(255 ** 2 / mean), delta=0.001)
        # Automatic colours and windows come from the first volume.
        points = viewer.get("volumes/0/transfer?name=bone").json["points"]
        by_name = viewer.post("difference", {"view": {"volume": "0", "transfer": "bone", **SMALL}, "other": copy})
        a, b = (viewer.frame(volume=volume, transfer=points, **SMALL).rgb for volume in ("0", copy))
        self.assertEqual(by_name.picture.rgb, bytes(min(255, 8 * abs(p - q)) for p, q in zip(a, b)))
        viewer.delete("volumes/" + copy)


class Films(unittest.TestCase):
    def make(self, kind, **more):
        view = {"volume": "0", "transfer": "bone", "camera": {"azimuth": 10}, **SMALL}
        answer = viewer.post("films", {"view": view, "frames": 6, "format": kind, **more})
        self.assertEqual(answer.status, 202)
        film = answer.json["id"]
        state = viewer.wait_for_film(film)
        self.assertEqual((state["state"], state["error"], state["fraction"]), ("done", None, 1))
        answer = viewer.get(f"films/{film}/file")
        self.assertEqual(len(answer.content), state["bytes"])
        self.assertIn("ball.", answer.headers["Content-Disposition"])
        self.assertEqual(viewer.delete("films/" + film).status, 200)
        self.assertEqual(viewer.get(f"films/{film}/file").status, 404)
        return answer

    def test_pictures(self):
        answer = self.make("png", degrees=180)
        self.assertEqual(answer.headers["Content-Type"], "application/x-tar")
        with tarfile.open(fileobj=io.BytesIO(answer.content)) as archive:
            names = archive.getnames()
            pictures = [read_png(archive.extractfile(name).read()) for name in names]
        self.assertEqual(names, [f"{i:04}.png" for i in range(1, 7)])
        for i in 0, 1, 5:
            view = {"volume": "0", "transfer": "bone", "camera": {"azimuth": 10 + 30 * i}, **SMALL}
            self.assertEqual(pictures[i], viewer.frame(**view))

    def test_formats(self):
        formats = viewer.get("").json["film_formats"]
        self.assertIn("gif", formats)
        gif = self.make("gif", fps=10)
        self.assertEqual(gif.content[:6], b"GIF89a")
        self.assertEqual(struct.unpack("<HH", gif.content[6:10]), (64, 48))
        if "webp" in formats:
            webp = self.make("webp")
            self.assertEqual((webp.content[:4], webp.content[8:12]), (b"RIFF", b"WEBP"))
        movie = self.make("mp4")  # by a fake ffmpeg that stores its input
        self.assertEqual(movie.headers["Content-Type"], "video/mp4")
        view = {"volume": "0", "transfer": "bone", "camera": {"azimuth": 10}, **SMALL}
        self.assertEqual(len(movie.content), 6 * 64 * 48 * 3)
        self.assertEqual(movie.content[:64 * 48 * 3], viewer.frame(**view).rgb)

    def test_limit_of_film_size(self):
        answer = viewer.post("films", {"view": {"volume": "0", "width": 4096, "height": 4096}, "frames": 3600})
        self.assertEqual(answer.status, 400)
        self.assertIn("frames", answer.error)

    def test_at_most_four_films(self):
        large = {"view": {"volume": "0", "width": 1500, "height": 1500}, "frames": 3600, "format": "png"}
        answers = [viewer.post("films", large) for _ in range(5)]
        self.assertEqual([a.status for a in answers], [202] * 4 + [429])
        film = answers[0].json["id"]
        self.assertEqual(viewer.get(f"films/{film}/file").status, 409)
        for answer in answers[:4]:
            self.assertEqual(viewer.delete("films/" + answer.json["id"]).status, 200)
        for _ in range(600):  # the files are deleted when their threads end
            left = [files for _, _, files in os.walk(folder.name) if any(f.endswith(".tar") for f in files)]
            if not left:
                break
            time.sleep(0.05)
        self.assertFalse(left)


if __name__ == "__main__":
    unittest.main()
