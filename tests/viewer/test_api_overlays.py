"""Overlays in the viewer are drawn as cvol render draws them."""

import json
import math
import os
import re
import struct
import subprocess
import unittest
import urllib.parse
from concurrent.futures import ThreadPoolExecutor

from viewer_client import CVOL, Viewer, make_folder, read_png, run

SIDE = 40
VIEW = {"volume": "0", "width": 90, "height": 80, "camera": {"azimuth": 30, "elevation": 20, "zoom": 1.3}}


def ball(x, y, z, centre, radius):
    return math.dist((x, y, z), centre) < radius


def head_at(x, y, z):
    return 200 if ball(x, y, z, (0, 0, 0), 70) else 0


def spots_at(x, y, z):
    return int(4000 * math.exp(-((x - 20) ** 2 + (y + 40) ** 2 + (z - 10) ** 2) / 900))


def labels_at(x, y, z):
    for value, centre in (3, (20, -40, 10)), (9, (-40, -30, 10)), (70, (5, -10, 60)):
        if ball(x, y, z, centre, 24):
            return value
    return 0


def write(name, value, side, spacing, kind="short", space="right-anterior-superior", shift=0, more=""):
    first = -(side - 1) / 2 * spacing
    samples = [value(*(first + spacing * ((i // side**a) % side) for a in range(3))) for i in range(side**3)]
    origin = ",".join(str(first + shift) for _ in range(3))
    place = f"space: {space}\nspace directions: ({spacing},0,0) (0,{spacing},0) (0,0,{spacing})\nspace origin: ({origin})\n"
    header = f"NRRD0004\ntype: {kind}\ndimension: 3\nsizes: {side} {side} {side}\nencoding: raw\nendian: little\n"
    with open(os.path.join(folder.name, name), "wb") as file:
        file.write((header + (place if space else "") + more + "\n").encode())
        file.write(b"".join(sample.to_bytes(2, "little") for sample in samples))


def setUpModule():
    global folder, scalar, both
    folder = make_folder()
    write("head.nrrd", head_at, SIDE, 4)
    write("spots.nrrd", spots_at, 24, 6)
    names = "Segment0_LabelValue:=9\nSegment0_Name:=Left part\nSegment0_Color:=0 0.5 1\n"
    write("parts.seg.nrrd", labels_at, 36, 4.4, "uint16", more=names)
    run(folder.name, "cvol compress head.nrrd head.cvol --psnr 50")
    scalar = Viewer(folder.name, "head.cvol", "--overlay", "spots.nrrd")
    scalar.__enter__()
    both = Viewer(folder.name, "head.nrrd", "--overlay", "spots.nrrd", "--overlay-opacity", "0.75",
                  "--overlay-transfer", "viridis", "--overlay", "parts.seg.nrrd", "--overlay-depth", "20")
    both.__enter__()


def tearDownModule():
    for viewer in scalar, both:
        viewer.__exit__()
        assert viewer.status == 0, f"the viewer ended with {viewer.status}"
    folder.cleanup()


class Overlays(unittest.TestCase):
    def test_name_of_a_folder(self):
        write("plain.nrrd", head_at, SIDE, 4, space="")
        run(folder.name, "cvol compress plain.nrrd plain.cvol && cvol decompress plain.cvol plain.zarr")
        path = os.path.join(folder.name, "plain.zarr/")
        with Viewer(folder.name, "plain.nrrd", "--overlay", path) as viewer:
            overlay, = viewer.wait_for("0")["overlays"]
            self.assertEqual((overlay["name"], overlay["path"]), ("plain.zarr/", path))

    def as_command(self, viewer, view):
        """The picture of the command line that the viewer names, and that line."""
        command = viewer.post("command", {"view": view}).json["command"]
        run(folder.name, command)
        with open(os.path.join(folder.name, re.search(r" -o (\S+)", command)[1]), "rb") as file:
            return read_png(file.read()), command

    def test_pictures_are_those_of_the_command(self):
        for viewer in scalar, both:
            for more in {}, {"mode": "iso"}, {"mode": "mip"}, {"light": {"on": False}}, {
                    "clip": {"box": [None, None, 8, 30, None, None]}}, {"background": [1, 1, 1]}, {"mirror": True}:
                drawn, command = self.as_command(viewer, {**VIEW, **more})
                self.assertIn(" --overlay spots.nrrd", command)
                picture = viewer.frame(**VIEW, **more)
                self.assertEqual(picture, drawn, command)
                self.assertNotEqual(viewer.frame(**VIEW, **more, overlays=[]), picture, command)

    def test_pictures_are_those_of_written_options(self):
        """Not by way of the command line that the viewer names."""
        look = "--size 90x80 --fit box --azimuth 30 --elevation 20 --zoom 1.3"
        run(folder.name, f"cvol render head.cvol -o one.png --overlay spots.nrrd {look}")
        run(folder.name, f"cvol render head.nrrd -o two.png --overlay spots.nrrd --overlay-opacity 0.75 --overlay-transfer "
            f"viridis --overlay parts.seg.nrrd --overlay-depth 20 {look}")
        for viewer, name in (scalar, "one.png"), (both, "two.png"):
            studio = {"light": self.studio()}
            with open(os.path.join(folder.name, name), "rb") as file:
                self.assertEqual(viewer.frame(**VIEW, **studio), read_png(file.read()), name)

    @staticmethod
    def studio():
        return {"on": True, "direction": [-0.55, 0.65, 0.9], "ambient": 0.3, "diffuse": 0.6, "specular": 0.1,
                "shininess": 24, "fill": 0.2, "occlusion": 0.75, "shadows": 0.6, "in_view": True, "keeps_brightness": True}

    def test_settings_are_options_of_the_command(self):
        settings = [
            (scalar, [{"opacity": 0.3}], "--overlay-opacity 0.3"),
            (scalar, [{"depth": 5}], "--overlay-depth 5"),
            (scalar, [{"transfer": "magma"}], "--overlay-transfer magma"),
            (scalar, [{"window": [500, 3000]}], "--overlay-window 1750,2500"),
            (both, [{"on": False}, {"labels": [3, 70]}], "--overlay-labels 3,70"),
            (both, [{"transfer": "viridis"}], "--overlay-transfer viridis"),
        ]
        for viewer, overlays, option in settings:
            view = {**VIEW, "overlays": overlays}
            drawn, command = self.as_command(viewer, view)
            self.assertIn(option, command)
            picture = viewer.frame(**view)
            self.assertEqual(picture, drawn, command)
            self.assertNotEqual(picture, viewer.frame(**VIEW), option)

    def test_nothing_is_drawn_that_is_off(self):
        plain = both.frame(**VIEW, overlays=[])
        for overlays in [{"on": False}, {"on": False}], [{"opacity": 0}, {"labels": []}]:
            view = {**VIEW, "overlays": overlays}
            self.assertEqual(both.frame(**view), plain)
            self.assertNotIn("--overlay", both.post("command", {"view": view}).json["command"])

    def test_description(self):
        values, labels = both.get("volumes/0").json["overlays"]
        self.assertEqual((values["name"], values["labels"], values["opacity"]), ("spots.nrrd", None, 0.75))
        self.assertEqual((values["values"]["transfer"], values["values"]["window"]), ("viridis", None))
        self.assertEqual(labels["depth"], 20)
        self.assertIsNone(labels["values"])
        self.assertEqual([label["value"] for label in labels["labels"]], [3, 9, 70])
        self.assertEqual(labels["labels"][1], {"value": 9, "name": "Left part", "colour": [0, 0.5, 1]})

    def test_copies_and_motion_have_the_overlays(self):
        copy = scalar.post("volumes/0/copy", {"ratio": 200}).json["id"]
        self.assertEqual(scalar.wait_for(copy)["state"], "ready")
        view = {**VIEW, "volume": copy}
        self.assertNotEqual(scalar.frame(**view), scalar.frame(**view, overlays=[]))
        motion = [scalar.post("frame", {"view": {**VIEW, **more}, "quality": "motion", "format": "png"}).picture
                  for more in ({}, {"overlays": []})]
        self.assertNotEqual(*motion)
        scalar.delete("volumes/" + copy)

    def test_films_have_the_overlays(self):
        sizes = []
        for more in {}, {"overlays": []}:
            film = scalar.post("films", {"view": {**VIEW, **more}, "frames": 2, "format": "gif"}).json["id"]
            self.assertEqual(scalar.wait_for_film(film)["state"], "done")
            sizes.append(scalar.get(f"films/{film}/file").content)
        self.assertNotEqual(*sizes)

    def slice(self, axis, index, overlays=None, viewer=None):
        more = "" if overlays is None else "&overlays=" + urllib.parse.quote(json.dumps(overlays))
        answer = (viewer or both).get(f"volumes/0/slice?axis={axis}&index={index}{more}")
        self.assertEqual(answer.status, 200, answer.content)
        return answer.picture

    def test_slices_have_the_overlays(self):
        """The middle of the spot and of a label, on a slice across each axis."""
        spot, part = (20, -40, 10), (-40, -30, 10)
        for axis in range(3):
            for centre, overlays, of in (spot, [{}], "spot"), (part, [{"on": False}, {}], "part"):
                at = [round(c / 4 + (SIDE - 1) / 2) for c in centre]
                across = [a for a in range(3) if a != axis]
                x, row = at[across[0]], at[across[1]]
                y = row if axis == 2 else SIDE - 1 - row
                plain = self.slice("xyz"[axis], at[axis])
                self.assertEqual(plain, self.slice("xyz"[axis], at[axis], []))
                self.assertEqual(len(set(plain.at(x, y))), 1, "grey")
                painted = self.slice("xyz"[axis], at[axis], overlays)
                if of == "part":  # 0 0.5 1 with opacity 0.6 on this grey
                    expected = [0.4 * plain.at(x, y)[0] + 0.6 * 255 * c for c in (0, 0.5, 1)]
                    self.assertLess(max(abs(a - b) for a, b in zip(painted.at(x, y), expected)), 2)
                else:  # the end of viridis
                    self.assertGreater(painted.at(x, y)[1], painted.at(x, y)[2] + 80)
                far = (SIDE - 1, y)
                self.assertEqual(painted.at(*far), plain.at(*far))

    def test_slices_obey_the_settings(self):
        shown = self.slice("z", 22, [{}, {}])
        for other in [{"opacity": 0.2}, {}], [{"transfer": "hot"}, {}], [{"window": [3000, 4000]}, {}], [{}], [
                {}, {"labels": [9]}], [{}, {"opacity": 0.5}]:
            self.assertNotEqual(self.slice("z", 22, other), shown, other)
        answer = both.get("volumes/0/slice?axis=z&index=3&overlays=%5B1%5D")
        self.assertEqual((answer.status, answer.error), (400, "overlays[0] must be an object"))
        self.assertEqual(both.get("volumes/0/slice?axis=z&index=3&overlays=%5B").status, 400)

    def test_values_at_a_place(self):
        spot, part = ((c / 4 + (SIDE - 1) / 2 for c in centre) for centre in ((20, -40, 10), (-40, -30, 10)))
        for place, label in (spot, {"value": 3, "label": None}), (part, {"value": 9, "label": "Left part"}):
            at = [round(c) for c in place]
            reply = both.get("volumes/0/value?x={}&y={}&z={}".format(*at)).json
            self.assertEqual(reply["overlays"][1], label)
            world = [4 * (a - (SIDE - 1) / 2) for a in at]
            self.assertLess(abs(reply["overlays"][0]["value"] - spots_at(*world)), 120)
            self.assertIsNone(reply["overlays"][0]["label"])
        reply = both.get("volumes/0/value?x=39&y=39&z=39").json["overlays"]
        self.assertEqual(reply[1], {"value": None, "label": None})

    def test_a_picked_place_is_on_the_labels_in_front(self):
        """Label 70 sticks out of the head at its top."""
        view = {**VIEW, "overlays": [{"on": False}, {}]}
        picture = both.frame(**view, light={"on": False})
        label = both.get("volumes/0").json["overlays"][1]["labels"][2]
        shown = [255 * c for c in label["colour"]]
        found = 0
        for x in range(1, 90, 4):
            for y in range(1, 80, 4):
                place = {"x": (x + 0.5) / 90, "y": (y + 0.5) / 80}
                if max(abs(a - b) for a, b in zip(picture.at(x, y), shown)) < 3:
                    reply = both.post("pick", {"view": view, **place}).json
                    self.assertEqual(reply["overlays"][1]["value"], 70, (x, y))
                    found += 1
        self.assertGreater(found, 3)
        place = {"x": 0.5, "y": 0.5}
        depths = [both.post("pick", {"view": {**VIEW, "overlays": overlays}, **place}).json["depth"]
                  for overlays in ([], [{}, {"labels": []}], [{}, {}])]
        self.assertEqual(depths[0], depths[1])
        self.assertLessEqual(depths[2], depths[0])

    def test_colours_of_an_overlay(self):
        points = scalar.get("volumes/0/transfer?overlay=0").json["points"]
        self.assertEqual(points, scalar.get("volumes/0/transfer?overlay=0&name=hot").json["points"])
        self.assertGreater(points[-1][0], 3000)
        points = scalar.get("volumes/0/transfer?overlay=0&name=viridis&window=100,200").json["points"]
        self.assertEqual((points[0][0], points[-1][0]), (100, 200))
        for query, message in [("overlay=1", "overlay is '1': the volume has 1 overlays"), ("overlay=x", "overlay is 'x'"),
                               ("overlay=0&window=2,1", "window is '2,1'"), ("overlay=0&name=rainbow", "is named")]:
            answer = scalar.get("volumes/0/transfer?" + query)
            self.assertEqual(answer.status, 400, query)
            self.assertIn(message, answer.error)

    def test_files_of_transfer_functions_and_values_of_labels(self):
        points = [[0, 0, 0, 0, 0], [1000, 0, 1, 0, 0.1], [4000, 1, 0, 1, 0.2]]
        with open(os.path.join(folder.name, "own.json"), "w") as file:
            json.dump({"points": points}, file)
        with Viewer(folder.name, "head.cvol", "--overlay", "spots.nrrd", "--overlay-transfer", "own.json", "--overlay",
                    "parts.seg.nrrd", "--overlay-transfer", "auto") as viewer:
            first, second = viewer.get("volumes/0").json["overlays"]
            self.assertEqual((first["values"]["transfer"], second["values"]["transfer"]), ("own.json", "auto"))
            self.assertIsNone(second["labels"])
            for overlays in None, [{"transfer": "own.json"}, {}], [{"transfer": "hot"}, {"opacity": 0.5}]:
                view = {**VIEW, "overlays": overlays}
                drawn, command = self.as_command(viewer, view)
                self.assertEqual(viewer.frame(**view), drawn, command)
            self.assertEqual(viewer.get("volumes/0/transfer?overlay=0&name=own.json").json["points"], points)

    def test_windows_are_values_after_the_rescale(self):
        """NIfTI, whose samples mean 0.5 s - 20."""
        side, spacing = 24, 6
        first = -(side - 1) / 2 * spacing
        header = struct.pack("<i36x8h14x2h2x8f3f4x", 348, 3, side, side, side, 1, 1, 1, 1, 4, 16, 1, *[spacing] * 3, 1, 1, 1, 1,
                             352, 0.5, -20)
        header = header.ljust(252, b"\0") + struct.pack("<2h24x", 0, 1)
        for axis in range(3):
            header += struct.pack("<4f", *(spacing * (axis == a) for a in range(3)), first)
        samples = [spots_at(*(first + spacing * ((i // side**a) % side) for a in range(3))) for i in range(side**3)]
        with open(os.path.join(folder.name, "scaled.nii"), "wb") as file:
            file.write(header.ljust(344, b"\0") + b"n+1\0" + bytes(4) + struct.pack(f"<{side**3}h", *samples))
        with Viewer(folder.name, "head.cvol", "--overlay", "scaled.nii") as viewer:
            values = viewer.get("volumes/0").json["overlays"][0]["values"]
            self.assertEqual((values["value_scale"], values["value_offset"]), (0.5, -20))
            view = {**VIEW, "overlays": [{"window": [600, 3000]}]}
            drawn, command = self.as_command(viewer, view)
            self.assertIn("--overlay-window 880,1200", command)
            self.assertEqual(viewer.frame(**view), drawn)
            same = {**VIEW, "overlays": [{"window": [600, 3000]}]}
            self.assertEqual(scalar.frame(**same), drawn, "the same samples without a rescale")
        # Files of transfer functions have these values too.
        with open(os.path.join(folder.name, "meant.json"), "w") as file:
            json.dump({"points": [[280, 0, 0, 0, 0], [880, 0, 1, 0, 0.1], [1480, 1, 0, 1, 0.2]]}, file)
        with Viewer(folder.name, "head.cvol", "--overlay", "scaled.nii", "--overlay-transfer", "meant.json") as viewer:
            drawn, command = self.as_command(viewer, VIEW)
            self.assertEqual(viewer.frame(**VIEW), drawn, command)
            points = viewer.get("volumes/0/transfer?overlay=0&name=meant.json").json["points"]
            self.assertEqual([point[0] for point in points], [600, 1800, 3000])

    def test_times_have_the_overlays(self):
        run(folder.name, "cvol compress head.nrrd head.nrrd -o run.cvol --time-step 1 --fast")
        with Viewer(folder.name, "run.cvol", "--overlay", "spots.nrrd") as viewer:
            pictures = [viewer.frame(**VIEW, time=time) for time in (0, 1)]
            self.assertNotEqual(pictures[1], viewer.frame(**VIEW, time=1, overlays=[]))
            self.assertEqual(pictures[0], pictures[1])
            films = []
            for more in {}, {"overlays": []}:
                request = {"view": {**VIEW, **more}, "over_time": True, "format": "gif"}
                film = viewer.post("films", request).json["id"]
                self.assertEqual(viewer.wait_for_film(film)["state"], "done")
                films.append(viewer.get(f"films/{film}/file").content)
            self.assertNotEqual(*films)

    def test_refused_settings(self):
        for overlays, message in [
                ([{}, {}, {}], "overlays must be a list of at most 2"),
                ([1], "overlays[0] must be an object"),
                ([{"opacity": 2}], "overlays[0].opacity is 2, must be 0 to 1"),
                ([{"window": [2, 1]}], "the second value must be larger"),
                ([{"window": [-1e308, 1e308]}], "the difference of the values must be finite"),
                ([{"transfer": "rainbow"}], "view.overlays[0].transfer: spots.nrrd: no transfer function is named"),
                ([{"transfer": "ct-bone"}], "view.overlays[0].transfer: spots.nrrd: values 0 to 3"),
                ([{"labels": [1]}], "unknown field view.overlays[0].labels"),
                ([{}, {"labels": [5]}], "overlays[1].labels must be different values of labels of the overlay"),
                ([{}, {"labels": [3, 3]}], "overlays[1].labels must be different"),
                ([{"transfer": ""}], "transfer is empty")]:
            answer = both.post("frame", {"view": {**VIEW, "overlays": overlays}})
            self.assertEqual(answer.status, 400, overlays)
            self.assertIn(message, answer.error)
            self.assertNotIn("--", answer.error)
        answer = both.post("frame", {"view": {**VIEW, "overlays": [{"transfer": "rainbow"}]}})
        self.assertIn(answer.status, (400, 500))
        self.assertIn("no transfer function is named", answer.error)

    def test_one_value_is_not_drawn(self):
        write("zeros.nrrd", lambda *_: 0, 20, 8)
        with Viewer(folder.name, "head.cvol", "--overlay", "zeros.nrrd") as viewer:
            plain = viewer.frame(**VIEW, overlays=[])
            for more in {}, {"transfer": "auto"}, {"transfer": "dense"}:
                self.assertEqual(viewer.frame(**VIEW, overlays=[more]), plain, more)
                self.assertEqual(self.slice("z", 22, [more], viewer), self.slice("z", 22, [], viewer), more)
            points = viewer.get("volumes/0/transfer?overlay=0").json["points"]
            self.assertEqual([point[4] for point in points], [0])
            self.assertNotEqual(viewer.frame(**VIEW, overlays=[{"window": [-1, 1]}]), plain)

    def test_new_choices_of_labels_at_once(self):
        """More choices than stay in memory, each by several requests that come together."""
        choices = [[{"on": False}, {"labels": labels}] for labels in ([3], [9], [70], [3, 9])]
        alone = [(both.frame(**VIEW, overlays=choice), self.slice("z", 22, choice)) for choice in choices]

        def ask(i):
            choice = choices[i // 4 % len(choices)]
            return self.slice("z", 22, choice) if i % 4 else both.frame(**VIEW, overlays=choice)

        with ThreadPoolExecutor(8) as pool:
            for i, picture in enumerate(pool.map(ask, range(32))):
                self.assertEqual(picture, alone[i // 4 % len(choices)][i % 4 > 0], i)

    def test_refused_files(self):
        write("away.nrrd", spots_at, 12, 6, shift=900)
        write("no_space.nrrd", spots_at, 12, 6, space=None)
        with open(os.path.join(folder.name, "colours.nrrd"), "wb") as file:
            file.write(b"NRRD0004\ntype: uchar\ndimension: 4\nsizes: 3 8 8 8\nkinds: RGB-color space space space\n"
                       b"encoding: raw\n\n" + bytes(3 * 8**3))
        for status, options, message in [
                (1, ["missing.nii"], "missing.nii: "),
                (1, ["away.nrrd"], "away.nrrd: lies outside of head.cvol: they have no place in common"),
                (2, ["no_space.nrrd"], "no_space.nrrd: the two grids have no common space"),
                (2, ["colours.nrrd"], "colours.nrrd: "),
                (2, ["spots.nrrd", "--overlay-opacity", "3"], "--overlay-opacity is '3', must be 0 to 1"),
                (2, ["spots.nrrd", "--overlay-transfer", "rainbow"], "no transfer function is named"),
                (2, ["parts.seg.nrrd", "--overlay-window", "3,4"], "--overlay-window does not work with labels")]:
            done = subprocess.run([CVOL, "view", "head.cvol", "--no-browser", "--overlay", *options], cwd=folder.name,
                                  capture_output=True, text=True, timeout=60)
            self.assertEqual((done.returncode, done.stdout), (status, ""), options)
            self.assertEqual(len(done.stderr.strip().splitlines()), 1, done.stderr)
            self.assertIn(message, done.stderr)


if __name__ == "__main__":
    unittest.main()
