"""Views of several channels: each in its colour, added as cvol render adds them."""

import os
import subprocess
import unittest

from test_api_several import ball, write_nifti
from viewer_client import CVOL, Viewer, make_folder, read_png, run

SIZE = {"width": 60, "height": 50}
GREEN, MAGENTA = [0, 1, 0], [1, 0, 1]


class ChannelsTest(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        folder = make_folder()
        cls.addClassCleanup(folder.cleanup)
        cls.folder = folder.name
        for number, middle in enumerate([12, 26]):
            write_nifti(os.path.join(cls.folder, "c%d.nii" % number), [ball(middle)])
        subprocess.run([CVOL, "compress", "c0.nii", "c1.nii", "-o", "cell.cvol", "--as", "channels",
                        "--channel-names", "DAPI,GFP", "--fast"], cwd=cls.folder, check=True, capture_output=True)
        cls.viewer = Viewer(cls.folder, "cell.cvol")
        cls.addClassCleanup(cls.viewer.__exit__)
        cls.viewer.__enter__()

    def both(self, **more):
        return dict({"volume": "0", "channels": [{"volume": "0", "colour": GREEN}, {"volume": "1", "colour": MAGENTA}]},
                    **SIZE, **more)

    def test_description(self):
        first, second = [v["channel"] for v in self.viewer.get("volumes").json["volumes"]]
        self.assertEqual(first, {"first": "0", "number": 0, "count": 2, "name": "DAPI", "colour": GREEN,
                                 "component": False})
        self.assertEqual((second["first"], second["number"], second["colour"]), ("0", 1, MAGENTA))
        with Viewer(self.folder, "cell.cvol", "--channel", "1") as one:
            self.assertIsNone(one.get("volumes/0").json["channel"])

    def test_channels_add_up(self):
        picture = self.viewer.frame(**self.both())
        alone = [self.viewer.frame(**dict(self.both(), channels=[channel])) for channel in self.both()["channels"]]
        total = bytes(min(255, a + b) for a, b in zip(alone[0].rgb, alone[1].rgb))
        self.assertLessEqual(max(abs(a - b) for a, b in zip(picture.rgb, total)), 1)
        colours = [{alone[k].at(x, y) for x in range(60) for y in range(50)} for k in range(2)]
        self.assertTrue(all(r == b == 0 for r, g, b in colours[0]))
        self.assertTrue(all(g == 0 and r == b for r, g, b in colours[1]))
        self.assertGreater(max(g for r, g, b in colours[0]), 40)

    def test_command(self):
        """cvol render makes the same picture."""
        view = self.both()
        answer = self.viewer.post("command", {"view": view}).json
        self.assertNotIn("--channel", answer["command"])
        run(self.folder, answer["command"])
        with open(os.path.join(self.folder, "cell.png"), "rb") as file:
            self.assertEqual(read_png(file.read()), self.viewer.frame(**view))
        view["channels"][1]["colour"] = [1, 0, 0]
        command = self.viewer.post("command", {"view": view}).json["command"]
        self.assertIn("--channel-colors '#00ff00,#ff0000'", command)
        run(self.folder, command)
        with open(os.path.join(self.folder, "cell.png"), "rb") as file:
            self.assertEqual(read_png(file.read()), self.viewer.frame(**view))
        for channels in [view["channels"][:1], [dict(view["channels"][0], transfer="hot"), view["channels"][1]]]:
            answer = self.viewer.post("command", {"view": dict(view, channels=channels)})
            self.assertEqual(answer.status, 400)
            self.assertIn("cvol render draws all channels", answer.error)

    def test_own_settings(self):
        base = self.viewer.frame(**self.both())
        for setting in [{"transfer": "hot"}, {"transfer": [[0, 0, 0, 0, 0], [200, 1, 1, 1, 1]]}, {"opacity_scale": 9}]:
            view = self.both()
            view["channels"][1].update(setting)
            self.assertNotEqual(self.viewer.frame(**view), base, setting)
        grey = self.both(mode="mip")
        picture = self.viewer.frame(**grey)
        self.assertEqual(max(picture.rgb), 255)
        grey["channels"][1]["window"] = [0, 2000]
        self.assertNotEqual(self.viewer.frame(**grey), picture)

    def test_film_and_pick(self):
        film = self.viewer.post("films", {"view": self.both(), "frames": 2, "format": "gif"}).json
        self.assertEqual(self.viewer.wait_for_film(film["id"])["state"], "done")
        self.assertEqual(self.viewer.post("pick", {"view": self.both(), "x": 0.5, "y": 0.5}).status, 200)

    def test_components(self):
        """Red, green and blue of one colour, and alpha."""
        for count in 3, 4:
            samples = bytes(v for i in range(4096) for v in ((200, 40, 40, 255) if i % 16 > 4 else (0, 0, 0, 0))[:count])
            header = b"\x93NUMPY\x01\x00" + (118).to_bytes(2, "little")
            shape = f"{{'descr': '|u1', 'fortran_order': False, 'shape': (16, 16, 16, {count})}}"
            header += (shape.ljust(117) + "\n").encode()
            with open(os.path.join(self.folder, "rgb.npy"), "wb") as file:
                file.write(header + samples)
            with Viewer(self.folder, "rgb.npy") as viewer:
                listed = viewer.get("volumes").json["volumes"]
                self.assertEqual([v["channel"]["component"] for v in listed], [True] * count)
                channels = [{"volume": v["id"], "colour": v["channel"]["colour"], "transfer": "component"} for v in listed]
                view = {"volume": "0", "channels": channels, **SIZE}
                picture = viewer.frame(**view)
                r, g, b = picture.at(30, 25)
                self.assertGreater(r, 3 * g)
                self.assertEqual(viewer.frame(**view), picture)
                run(self.folder, viewer.post("command", {"view": view}).json["command"])
                with open(os.path.join(self.folder, "rgb.png"), "rb") as file:
                    self.assertEqual(read_png(file.read()), picture)
                # A window of all components changes the colours, and has no command.
                narrow = [{**channel, "window": [0, 100]} for channel in channels]
                bright = viewer.frame(**{**view, "channels": narrow})
                self.assertGreater(bright.at(30, 25)[1], 1.5 * g)
                self.assertEqual(viewer.post("command", {"view": {**view, "channels": narrow}}).status, 400)
                # Fewer components, other colours, and other modes.
                cyan = [{**channel, "colour": [0, 1, 1]} for channel in channels[:1]]
                r, g, b = viewer.frame(**{**view, "channels": cyan}).at(30, 25)
                self.assertTrue(r < 5 < 60 < g == b, (r, g, b))
                self.assertEqual(viewer.frame(**view), picture)
                self.assertEqual(viewer.frame(mode="mip", **view), viewer.frame(mode="mip", **{**view, "channels": channels[:3]}))

    def test_bad_channels(self):
        for channels, message in [([], "1 to 16"), (7, "1 to 16"), ([3], "channels[0] must be an object"),
                                  ([{}], "view.channels[0].volume is missing"),
                                  ([{"volume": "0", "colour": [2, 0, 0]}], "view.channels[0].colour"),
                                  ([{"volume": "0", "color": GREEN}], "color")]:
            answer = self.viewer.post("frame", {"view": {"volume": "0", "channels": channels}})
            self.assertEqual(answer.status, 400, channels)
            self.assertIn(message, answer.error)
        self.assertEqual(self.viewer.post("frame", {"view": {"volume": "0", "channels": [{"volume": "9"}]}}).status, 404)
        self.assertIn("mode composite", self.viewer.post("frame", {"view": self.both(mode="iso")}).error)
        self.assertIn("one volume", self.viewer.post("difference", {"view": self.both(), "other": "1"}).error)


if __name__ == "__main__":
    unittest.main()
