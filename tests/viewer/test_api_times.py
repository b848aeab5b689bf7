"""Volumes of several times: one volume in the list, and the view chooses its time."""

import concurrent.futures
import io
import json
import os
import subprocess
import tarfile
import unittest

from test_api_several import SHAPE, ball, write_nifti
from viewer_client import CVOL, Viewer, make_folder, read_png, run

TIMES = 6


def soft_ball(middle):
    """Values fall from 200 at the centre to 0, so that these are no labels."""
    x, y, z = SHAPE
    return bytes(max(0, 200 - 3 * ((i - middle) ** 2 + (j - 18) ** 2 + (k - 15) ** 2) // 2)
                 for k in range(z) for j in range(y) for i in range(x))


def two_labels(middle):
    inside = ball(middle)
    return bytes((1 if i // (SHAPE[0] * SHAPE[1]) < 15 else 2) if value else 0 for i, value in enumerate(inside))


BALLS = [soft_ball(10 + 2 * t) for t in range(TIMES)]


class TimesTest(unittest.TestCase):
    """run.nii, and run.cvol made of it."""

    @classmethod
    def setUpClass(cls):
        folder = make_folder()
        cls.addClassCleanup(folder.cleanup)
        cls.folder = folder.name
        write_nifti(os.path.join(cls.folder, "run.nii"), BALLS)
        subprocess.run([CVOL, "compress", "run.nii", "-o", "run.cvol", "--fast", "--ratio", "20"], cwd=cls.folder,
                       check=True, capture_output=True)
        cls.viewers = {name: Viewer(cls.folder, name) for name in ["run.nii", "run.cvol"]}
        for viewer in cls.viewers.values():
            cls.addClassCleanup(viewer.__exit__)
            viewer.__enter__()

    def test_description(self):
        for name, viewer in self.viewers.items():
            listed = [v for v in viewer.get("volumes").json["volumes"] if v["parent"] is None]
            self.assertEqual([v["name"] for v in listed], [name])
            self.assertEqual(listed[0]["times"], TIMES)
            self.assertEqual(listed[0]["time_values"], [2 * t for t in range(TIMES)])
            self.assertEqual(listed[0]["time_unit"], "s")

    def test_pictures(self):
        """Each time has its own picture; a time that is shown again has the same one."""
        mip = {"width": 64, "height": 48, "mode": "mip", "window": [0, 200]}
        for name, viewer in self.viewers.items():
            shown = {t: viewer.frame(volume="0", time=t, width=64, height=48) for t in [0, 2, 5]}
            self.assertNotEqual(shown[0], shown[2])
            self.assertNotEqual(shown[2], shown[5])
            for t, picture in shown.items():
                self.assertEqual(viewer.frame(volume="0", time=t, width=64, height=48), picture)
            with Viewer(self.folder, name, "--time", "2") as one:
                self.assertEqual(one.get("volumes/0").json["times"], 1)
                self.assertEqual(one.frame(volume="0", **mip), viewer.frame(volume="0", time=2, **mip))

    def test_samples(self):
        for viewer in self.viewers.values():
            for t in [0, 3, 5]:
                at = "x=%d&y=18&z=15" % (10 + 2 * t)
                self.assertGreater(viewer.get("volumes/0/value?%s&time=%d" % (at, t)).json["value"], 150)
                self.assertLess(viewer.get("volumes/0/value?%s&time=%d" % (at, (t + 3) % 6)).json["value"], 150)
            slices = {viewer.get("volumes/0/slice?axis=z&index=15&time=%d" % t).content for t in range(TIMES)}
            self.assertEqual(len(slices), TIMES)
            view = {"volume": "0", "time": 5, "camera": {"azimuth": 0, "elevation": 0}, "width": 64, "height": 64}
            self.assertTrue(viewer.post("pick", {"view": view, "x": 0.5, "y": 0.5}).json["hit"])
            self.assertFalse(viewer.post("pick", {"view": dict(view, time=0), "x": 0.7, "y": 0.5}).json["hit"])

    def test_colours_are_those_of_all_times(self):
        """A bright time in the middle of the file does not change the colours of the others."""
        dim = bytes(value // 4 for value in BALLS[2])
        write_nifti(os.path.join(self.folder, "rise.nii"), [dim, BALLS[2], dim])
        with Viewer(self.folder, "rise.nii") as viewer:
            volume = viewer.get("volumes/0").json
            self.assertEqual((volume["min"], volume["max"]), (0, 200))
            last = viewer.get("volumes/0/transfer?name=viridis").json["points"][-1]
            self.assertAlmostEqual(last[0], 200, delta=4)
            mip = [max(viewer.frame(volume="0", time=t, mode="mip", width=32, height=32).rgb) for t in range(3)]
            self.assertLess(mip[0], mip[1] / 2)
            self.assertEqual(mip[0], mip[2])

    def test_labels(self):
        """Labels keep their colours in all times."""
        write_nifti(os.path.join(self.folder, "atlas.nii"), [two_labels(12), two_labels(24)])
        with Viewer(self.folder, "atlas.nii") as viewer:
            colours = [tuple(round(255 * c) for c in entry["colour"])
                       for entry in viewer.get("volumes/0").json["labels"]]
            self.assertEqual(len(colours), 2)
            for time in range(2):
                picture = viewer.frame(volume="0", time=time, width=64, height=48)
                seen = {picture.at(x, y) for x in range(64) for y in range(48)}
                for colour in colours:
                    self.assertIn(colour, seen)

    def test_memory_is_bounded(self):
        """The viewer keeps a few times, not all of them."""
        for options, count in [(["--times-mb", "0"], 2), ([], TIMES - 1)]:
            with Viewer(self.folder, "run.cvol", *options) as viewer:
                first = viewer.get("status").json["resident_bytes"]
                for t in range(TIMES):
                    viewer.frame(volume="0", time=t, width=16, height=16)
                status = viewer.get("status").json
                self.assertEqual(status["open_times"], count)
                self.assertLess(status["resident_bytes"], (count + 1.5) * first)

    def test_several_viewers_at_once(self):
        """Times that others draw are released only afterwards."""
        wanted = [5, 1, 3, 5, 2, 4, 1, 5, 3, 2, 4, 0] * 2
        with Viewer(self.folder, "run.cvol", "--times-mb", "0") as viewer:
            def picture(t):
                return viewer.frame(volume="0", time=t, width=24, height=16)
            with concurrent.futures.ThreadPoolExecutor(6) as pool:
                shown = list(pool.map(picture, wanted))
            alone = {t: picture(t) for t in range(TIMES)}
            self.assertEqual(shown, [alone[t] for t in wanted])
            self.assertEqual(viewer.get("status").json["open_times"], 2)
        self.assertEqual(viewer.status, 0)

    def test_a_time_can_be_opened_before_it_is_shown(self):
        with Viewer(self.folder, "run.cvol") as viewer:
            answer = viewer.post("volumes/0/open", {"time": 4})
            self.assertEqual((answer.status, answer.json), (200, {"time": 4}))
            self.assertEqual(viewer.get("status").json["open_times"], 1)
            self.assertEqual(viewer.post("volumes/0/open", {"time": TIMES}).status, 400)
            self.assertIn("time is missing", viewer.post("volumes/0/open", {}).error)

    def check_command(self, viewer, view):
        """The command of a view makes the same picture."""
        answer = viewer.post("command", {"view": view}).json
        for name, content in answer["files"].items():
            with open(os.path.join(self.folder, name), "w") as file:
                json.dump(content, file)
        run(self.folder, answer["command"])
        with open(os.path.join(self.folder, "run.png"), "rb") as file:
            self.assertEqual(read_png(file.read()), viewer.frame(**view))
        return answer["command"]

    def test_command(self):
        for name, modes in [("run.cvol", [{}, {"mode": "iso"}, {"mode": "mip"}]), ("run.nii", [{}])]:
            viewer = self.viewers[name]
            for more in modes:
                view = dict(volume="0", time=4, width=60, height=50, **more)
                self.assertIn("--time 4", self.check_command(viewer, view))

    def test_film_and_difference(self):
        viewer = self.viewers["run.cvol"]
        view = {"volume": "0", "time": 3, "width": 32, "height": 32}
        film = viewer.post("films", {"view": view, "frames": 2, "format": "gif"}).json
        self.assertEqual(viewer.wait_for_film(film["id"])["state"], "done")
        film = viewer.post("films", {"view": dict(view, time=0), "over_time": True, "format": "png"}).json
        self.assertEqual(viewer.wait_for_film(film["id"])["state"], "done")
        tar = viewer.get("films/%s/file" % film["id"]).content
        with tarfile.open(fileobj=io.BytesIO(tar)) as pictures:
            shown = [read_png(pictures.extractfile(name).read()) for name in sorted(pictures.getnames())]
        self.assertEqual(shown, [viewer.frame(**dict(view, time=t)) for t in range(TIMES)])
        answer = viewer.post("films", {"view": view, "over_time": True, "frames": 3})
        self.assertIn("frames must be left out", answer.error)
        for more, exact in [({}, True), ({"other_time": 3}, True), ({"other_time": 5}, False)]:
            answer = viewer.post("difference", {"view": view, "other": "0", **more})
            self.assertEqual(json.loads(answer.headers["Cvol-Frame"])["exact"], exact, more)
        answer = viewer.post("difference", {"view": view, "other": "0", "other_time": TIMES})
        self.assertIn("other_time is 6, must be 0 to 5", answer.error)

    def test_copy(self):
        """A copy has the time that it was made of."""
        for viewer in self.viewers.values():
            copy = viewer.post("volumes/0/copy", {"ratio": 30, "time": 4}).json
            copy = viewer.wait_for(copy["id"])
            self.assertEqual((copy["state"], copy["times"]), ("ready", 1))
            at = "x=18&y=18&z=15"
            self.assertGreater(viewer.get("volumes/%s/value?%s" % (copy["id"], at)).json["value"], 150)
            command = self.check_command(viewer, {"volume": copy["id"], "width": 40, "height": 40})
            self.assertIn("--time 4", command)
            viewer.delete("volumes/" + copy["id"])

    def test_bad_times(self):
        viewer = self.viewers["run.nii"]
        for time in [-1, TIMES, 1.5, "3"]:
            answer = viewer.post("frame", {"view": {"volume": "0", "time": time}})
            self.assertEqual(answer.status, 400, time)
            self.assertIn("view.time", answer.error)
        self.assertIn("must be 0 to 5", viewer.get("volumes/0/value?x=0&y=0&z=0&time=6").error)
        self.assertEqual(viewer.get("volumes/0/slice?axis=z&index=0&time=x").status, 400)
        self.assertEqual(viewer.post("volumes/0/copy", {"ratio": 9, "time": 6}).status, 400)

    def test_a_damaged_time_leaves_the_others(self):
        with open(os.path.join(self.folder, "run.cvol"), "rb") as file:
            content = bytearray(file.read())
        content[-60:-20] = bytes(40)
        with open(os.path.join(self.folder, "damaged.cvol"), "wb") as file:
            file.write(content)
        with Viewer(self.folder, "damaged.cvol") as viewer:
            self.assertEqual(viewer.get("volumes/0").json["state"], "ready")
            viewer.frame(volume="0", time=3, width=16, height=16)
            answer = viewer.post("frame", {"view": {"volume": "0", "time": TIMES - 1}})
            self.assertEqual(answer.status, 500)
            self.assertIn("damaged.cvol", answer.error)
            viewer.frame(volume="0", time=2, width=16, height=16)


if __name__ == "__main__":
    unittest.main()
