"""Access control, invalid requests, cancelled frames, and the end of the viewer."""

import contextlib
import json
import os
import signal
import socket
import subprocess
import threading
import time
import unittest

from viewer_client import CVOL, read_png
from viewer_strict import Folder, Viewer, environment, render

folder = None
shared = None  # the viewer that most tests use


def setUpModule():
    global folder, shared
    folder = Folder()
    try:
        shared = Viewer(folder.volume("a"), folder.volume("b", ratio=30))
        for identity in "01":
            assert shared.wait(identity)["state"] == "ready"
    except BaseException:
        folder.remove()
        raise


def tearDownModule():
    try:
        status = shared.end()
        assert status == 0, f"status {status}: {shared.stderr()}"
    finally:
        folder.remove()


class Test(unittest.TestCase):
    def refuse(self, status, answer, *words):
        """Expects this status and one sentence with these words."""
        self.assertEqual(answer.status, status, answer.body[:200])
        self.assertEqual(answer.headers.get_content_type(), "application/json")
        self.assertEqual(list(answer.json), ["error"])
        self.assertNotIn("\n", answer.error)
        self.assertGreater(len(answer.error), 8)
        for word in words:
            self.assertIn(word, answer.error)


class AccessControl(Test):
    def test_requests_without_token_are_refused(self):
        token = shared.root.strip("/")
        self.assertRegex(token, "^[0-9a-f]{32}$")
        wrong = ["/", "//", "/" + "0" * 32 + "/", "/" + token[:-1] + "/", "/" + token[:-1] + "g/", "/" + token.upper() + "0/",
                 "/" + token[1:] + token[0] + "/", "/api/1/", "/x/" + token + "/", "/%00" + token + "/", "/../" + token + "/"]
        for root in wrong:
            for path in ("", "api/1", "api/1/volumes", "app.js", "api/1/nothing"):
                answer = shared.get(path, root=root)
                self.refuse(403, answer)
                self.assertNotIn(token, answer.body.decode())
            self.refuse(403, shared.post("api/1/frame", "{", root=root))
            self.refuse(403, shared.ask("DELETE", "api/1/volumes/0", root=root))
            self.refuse(403, shared.post("api/1/end", root=root))

    def test_foreign_hosts_are_refused(self):
        good = ["localhost", "localhost:80", "LOCALHOST:1", "127.0.0.1", "127.0.0.1:99", "[::1]", "[::1]:5"]
        bad = ["example.org", "example.org:80", "127.0.0.1.example.org", "localhost.example.org", "127.0.0.1@example.org", "",
               "localhost:x", "localhost:", "[::1", "::1", "[::1]x", "127.0.0.2", "0.0.0.0", "localhost:80:80", "localhost x", "a" * 300]
        for host in good:
            self.assertEqual(shared.get("api/1", headers={"Host": host}).status, 200, host)
        for host in bad:
            self.refuse(403, shared.get("api/1", headers={"Host": host}), "Host")
            self.refuse(403, shared.get("", headers={"Host": host}), "Host")
            self.refuse(403, shared.post("api/1/frame", {}, headers={"Host": host}), "Host")

    def test_repeated_host_headers(self):
        for twice in ("Host: localhost\r\nHost: localhost", "Host: localhost\r\nHost: evil.example",
                      f"Host: localhost:{shared.port}\r\nOrigin: http://localhost:{shared.port}\r\nOrigin: http://evil.example"):
            with socket.create_connection((shared.host, shared.port), timeout=60) as s:
                s.sendall(f"GET {shared.root}api/1 HTTP/1.1\r\n{twice}\r\nConnection: close\r\n\r\n".encode())
                self.assertIn(b" 403 ", s.recv(100), twice)

    def test_missing_host_header(self):
        with socket.create_connection((shared.host, shared.port), timeout=60) as s:
            s.sendall(f"GET {shared.root}api/1 HTTP/1.0\r\n\r\n".encode())
            self.assertIn(s.recv(4096).split()[1], (b"400", b"403"))

    def test_foreign_origins_are_refused(self):
        here = f"{shared.host}:{shared.port}"
        self.assertEqual(shared.get("api/1", headers={"Origin": f"http://{here}"}).status, 200)
        for origin in ["null", "http://example.org", "https://example.org", f"http://{shared.host}", f"ftp://{here}",
                       f"http://{shared.host}:{shared.port + 1}", f"http://{here}.example.org", f"http://example.org/{here}",
                       f"http://{here}@example.org", ""]:
            self.refuse(403, shared.get("api/1", headers={"Origin": origin}), "Origin")
            self.refuse(403, shared.post("api/1/frame", {}, headers={"Origin": origin}), "Origin")
        self.refuse(403, shared.get("api/1", headers={"Sec-Fetch-Site": "cross-site"}))
        forwarded = {"Host": "localhost:8080", "Origin": "http://localhost:8080"}
        self.assertEqual(shared.get("api/1", headers=forwarded).status, 200)

    def test_option_host(self):
        with Viewer(folder / "a.cvol", "--host", "node7") as viewer:
            self.assertEqual(viewer.get("api/1", headers={"Host": "node7:8080"}).status, 200)
            self.refuse(403, viewer.get("api/1", headers={"Host": "node8:8080"}), "Host")
            self.assertNotEqual(viewer.root, shared.root)
            self.refuse(403, viewer.get("api/1", root=shared.root))

    def test_security_headers_and_path_traversal(self):
        answer = shared.get("")
        self.assertEqual(answer.status, 200)
        self.assertEqual(answer.headers.get_content_type(), "text/html")
        policy = answer.headers["Content-Security-Policy"]
        for word in ("default-src 'none'", "script-src 'self'", "frame-ancestors 'none'"):
            self.assertIn(word, policy)
        self.assertEqual(answer.headers["X-Content-Type-Options"], "nosniff")
        self.assertEqual(answer.headers["Referrer-Policy"], "no-referrer")
        self.assertNotIn("Access-Control-Allow-Origin", answer.headers)
        for path in ("../etc/passwd", "..%2f..%2fetc/passwd", "%2e%2e/%2e%2e/etc/passwd", "/etc/passwd", "page/../app.js",
                     "api/1/volumes/..%2f..%2fetc%2fpasswd", "api/1/volumes/0/../1", "app.js/"):
            self.refuse(404, shared.get(path))


class Paths(Test):
    def test_known_paths(self):
        about = shared.get("api/1").json
        self.assertEqual((about["api"], about["once"]), (1, False))
        self.assertIn("auto", about["transfers"])
        both = shared.get("api/1/volumes").json["volumes"]
        self.assertEqual([v["id"] for v in both], ["0", "1"])
        self.assertEqual([v["name"] for v in both], ["a.cvol", "b.cvol"])
        self.assertEqual(both[0], shared.get("api/1/volumes/0").json)
        self.assertEqual(both[0]["dims"], [40, 36, 34])
        self.assertEqual(both[0]["raw_bytes"], 40 * 36 * 34)
        self.assertEqual(both[0]["compressed_bytes"], os.path.getsize(folder / "a.cvol"))
        self.assertEqual(sorted(both[0]["views"]), ["back", "bottom", "front", "left", "right", "top"])

    def test_unknown_paths(self):
        for path in ("api", "api/", "api/2", "api/1/", "api/1/volumes/", "api/1/volumes/7", "api/1/volumes/0/x",
                     "api/1/volumes/0/histogram/", "api/1/films/f9", "api/1/films/f9/file", "nothing.js", "api/1/volumes/" + "0" * 5000):
            self.refuse(404, shared.get(path))
        self.refuse(404, shared.ask("DELETE", "api/1/volumes/9"))
        self.refuse(404, shared.frame({"volume": "9"}), "'9'")

    def test_names_with_zero_bytes(self):
        for path in ("api/1%00", "api/1%00/x", "api/1/volumes/0%00", "index.html%00.png"):
            self.refuse(404, shared.get(path))
        self.refuse(400, shared.get("api/1/volumes/0/transfer?name=auto%00x"))
        self.refuse(400, shared.get("api/1/volumes/0/value?x=1%00&y=1&z=1"))

    def test_allow_header_lists_all_methods(self):
        self.assertEqual(shared.ask("PUT", "api/1/films/f1").headers["Allow"], "GET, DELETE")

    def test_wrong_methods(self):
        for method, path, right in (("POST", "api/1/volumes", "GET"), ("GET", "api/1/frame", "POST"), ("PUT", "api/1/frame", "POST"),
                                    ("DELETE", "api/1", "GET"), ("OPTIONS", "api/1/frame", "POST"), ("POST", "", "GET")):
            answer = shared.ask(method, path)
            self.refuse(405, answer, method)
            self.assertIn(right, answer.headers["Allow"])

    def test_given_volumes_cannot_be_deleted(self):
        answer = shared.ask("DELETE", "api/1/volumes/0")
        self.assertIn(answer.status, (400, 403, 405, 409))
        self.assertEqual(shared.get("api/1/volumes/0").status, 200)

    def test_end_needs_option_once(self):
        self.refuse(403, shared.post("api/1/end", {}), "--once")


class Requests(Test):
    def test_invalid_json(self):
        for body in ("", "{", "nonsense", "[]", "1", '"text"', "null", "{}x", '{"view": NaN}', '{"view": {"volume": "0"}, "view": 1}',
                     '{"view": {"volume": "0", "width": Infinity}}', '{"view": {"volume": "0", "width": 1e999}}', "\0", b"\xff\xfe{}",
                     '{"view": {"volume": "\\u0000"}}', "[" * 100000, '{"view":' * 50000, '{"view": {"volume": "\\ud800"}}'):
            for path in ("frame", "pick", "difference", "films", "command", "volumes/0/copy"):
                self.refuse(400, shared.post("api/1/" + path, body))
        self.refuse(400, shared.post("api/1/volumes/0/transfer", "{"))

    def test_unknown_fields(self):
        view = {"volume": "0"}
        for name, value, where in (("widht", 5, "view.widht"), ("camera", {"azimut": 1}, "view.camera.azimut"), ("light", {"off": 1}, "view.light.off"),
                                   ("clip", {"cube": []}, "view.clip.cube"), ("surface", {"color": []}, "view.surface.color")):
            for path in ("frame", "pick", "films", "command"):
                more = {"x": 0.5, "y": 0.5} if path == "pick" else {}
                self.refuse(400, shared.post("api/1/" + path, {"view": {**view, name: value}, **more}), where)
        for path in ("frame", "pick", "films", "command", "difference"):
            more = {"x": 0.5, "y": 0.5} if path == "pick" else {"other": "1"} if path == "difference" else {}
            self.refuse(400, shared.post("api/1/" + path, {"view": view, "nothing": 1, **more}), "nothing")
        self.refuse(400, shared.post("api/1/volumes/0/copy", {"ratios": 4}))
        self.refuse(400, shared.get("api/1/volumes/0/slice?axis=z&index=4&indx=4"), "indx")
        self.refuse(400, shared.get("api/1/volumes/0/value?x=4&y=4&z=4&w=1"), "w")

    def test_invalid_values(self):
        long = "x" * 5000
        wrong = {
            "volume": [0, None, {}, [], True, "", long],
            "width": [0, -1, 8193, 1.5, 1e300, "5", None, [], True],
            "height": [0, -1, 8193, 1e19, "512", {}],
            "mode": ["Composite", "", 1, None, long],
            "camera": [1, [], "front", None, {"zoom": 0}, {"zoom": -1}, {"zoom": 1e30}, {"fov": 151}, {"fov": 0.5}, {"fov": -3}, {"azimuth": "1"},
                       {"azimuth": 1e300}, {"look_at": [1, 2]}, {"look_at": [1, 2, 3, 4]}, {"look_at": [1, 2, "3"]}, {"roll": None}],
            "mirror": [1, "true", None],
            "transfer": ["", "no such", long, 1, {}, [], [[1, 2]], [[0, 0, 0, 0, 2]], [[0, -1, 0, 0, 0]], [[0, 0, 0, 0, "1"]], [1], [[0, 0, 0, 0, 0]] * 50000],
            "opacity_scale": [-1, "1", 1e300, None],
            "window": [[1], [2, 1], [1, 1], "1,2", {}, [None, 1]],
            "light": [1, True, {"on": 1}, {"ambient": -1}, {"shininess": 0}, {"shininess": 2.5}, {"direction": [1]}, {"specular": "a"}],
            "surface": [{"value": "a"}, {"colour": [2, 0, 0]}, {"colour": [0, 0]}, 4],
            "clip": [{"box": [1, 2]}, {"box": "all"}, {"planes": 1}, {"planes": [[1, 2, 3]]}, {"planes": [[0, 0, 1, 0]] * 7}, {"planes": [[1, 0, 0, "a"]]}, 1],
            "background": [[1, 1], [2, 0, 0], "black", [0, 0, -1], None],
            "step": [-1, "a", 1e9], "oversample": [0, 1e9, "a"],
            "footprint": ["", "Linear", "box", 1, None, long],
        }
        for name, values in wrong.items():
            for value in values:
                answer = shared.frame({name: value, "width": 8} if name != "width" else {name: value})
                status = 404 if name == "volume" and value == "" else 400
                self.assertIn(answer.status, (400, status), (name, str(value)[:60], answer.body[:100]))
                self.refuse(answer.status, answer)
        self.refuse(400, shared.frame({"width": 8192, "height": 8192}))
        self.refuse(400, shared.frame({"width": 4097}, quality="motion"))
        for name, values in {"quality": ["good", 1, None], "format": ["gif", 1], "jpeg_quality": [0, 101, "a", 1.5], "budget_ms": [0, -1, 1e9, "a"],
                             "viewer": ["v" * 100, 1], "sequence": [-2, 1e300, "1"], "view": [None, 1, "0", []]}.items():
            for value in values:
                self.refuse(400, shared.frame(**({name: value, "quality": "motion"} if name not in ("quality", "view") else {name: value}))
                            if name != "view" else shared.post("api/1/frame", {"view": value}))
        self.refuse(400, shared.post("api/1/frame", {}), "view")
        self.refuse(400, shared.post("api/1/frame", {"view": {}}), "volume")

    def test_invalid_parameters(self):
        for query in ("", "axis=w&index=1", "axis=z", "axis=z&index=34", "axis=z&index=-1", "axis=z&index=1e9", "axis=z&index=99999999999999999999",
                      "axis=z&index=a", "axis=xy&index=1", "axis=z&index=1&window=2,1", "axis=z&index=1&window=a,b", "axis=z&index=1&window=nan,1",
                      "axis=z&index=1&window=1", "axis=z&index=1&window=1,2,3", "axis=z&index=1&window=inf,-inf", "axis=%00&index=1"):
            self.refuse(400, shared.get("api/1/volumes/0/slice?" + query))
        for query in ("", "x=1&y=1", "x=40&y=0&z=0", "x=-1&y=0&z=0", "x=a&y=0&z=0", "x=nan&y=0&z=0", "x=1&y=1&z=18446744073709551617"):
            self.refuse(400, shared.get("api/1/volumes/0/value?" + query))
        for more in ({}, {"x": 0.5}, {"x": -0.1, "y": 0}, {"x": 2, "y": 0}, {"x": "0", "y": 0}, {"x": None, "y": 0.5}):
            self.refuse(400, shared.post("api/1/pick", {"view": {"volume": "0"}, **more}))
        self.refuse(400, shared.get("api/1/volumes/0/transfer?name="))
        self.refuse(400, shared.get("api/1/volumes/0/transfer?name=nothing"))
        for body in ({}, {"ratio": 0}, {"ratio": -4}, {"ratio": "a"}, {"psnr": 1e9}, {"ratio": 4, "psnr": 40}, {"ratio": None}, {"ratio": 1e300}):
            self.refuse(400, shared.post("api/1/volumes/0/copy", body))
        for more in ({"frames": 0}, {"frames": 1e9}, {"frames": 2.5}, {"fps": 0}, {"fps": 1e9}, {"degrees": "a"}, {"format": "avi"}, {"quality": 101}):
            self.refuse(400, shared.post("api/1/films", {"view": {"volume": "0"}, **more}))

    def test_too_long_bodies(self):
        body = json.dumps({"view": {"volume": "0", "width": 8}}).encode()
        self.assertEqual(shared.post("api/1/frame", body.ljust(1 << 20)).status, 200)
        for length in ("1048577", "99999999999", "9" * 40):  # the server refuses without waiting for the body
            with socket.create_connection((shared.host, shared.port), timeout=60) as s:
                s.sendall(f"POST {shared.root}api/1/frame HTTP/1.1\r\nHost: localhost\r\nContent-Length: {length}\r\n\r\n".encode())
                self.assertIn(s.recv(4096).split()[1], (b"400", b"413") if len(length) == 40 else (b"413",))

        def chunks():
            for _ in range(40):
                yield b" " * 65536
        try:
            self.refuse(413, shared.post("api/1/frame", chunks()))
        except (BrokenPipeError, ConnectionResetError):
            pass  # the server may close before the end of the body
        self.assertEqual(shared.get("api/1").status, 200)


def as_asked(options):
    """A request has these angles, the whole volume and no light unless it says otherwise."""
    angles = [] if "--azimuth" in options else ["--azimuth", "0"]
    lit = "--light" in options or "iso" in options or "--mode" in options
    return ["--fit", "box", *angles, *([] if lit else ["--light", "flat"])]


class Frames(Test):
    def test_frames_equal_pictures_of_render(self):
        cases = [
            ({}, ()),
            ({"camera": {"azimuth": 33, "elevation": -20, "roll": 15, "zoom": 1.7}}, "--azimuth 33 --elevation -20 --roll 15 --zoom 1.7"),
            ({"camera": {"fov": 30, "azimuth": 200, "look_at": [3, 1, -2]}}, "--azimuth 200 --perspective 30 --look-at 3,1,-2"),
            ({"mirror": True, "background": [0.2, 0.4, 1]}, "--mirror --background 0.2,0.4,1"),
            ({"mode": "mip", "window": [20, 180]}, "--mode mip --window 100,160"),
            ({"mode": "xray"}, "--mode xray"),
            ({"mode": "mean"}, "--mode xray"),
            ({"mode": "min", "camera": {"azimuth": 90}}, "--mode min --azimuth 90"),
            ({"mode": "iso", "surface": {"value": 90, "colour": [1, 0.5, 0]}}, "--mode iso --iso 90 --iso-colour 1,0.5,0 --light headlight"),
            ({"light": {"on": True, "direction": [1, 2, 3], "ambient": 0.2}}, "--light 1,2,3 --ambient 0.2"),
            ({"clip": {"box": [5, None, None, 20, 3, 30]}, "opacity_scale": 2}, "--clip 5:,:20,3:30 --opacity-scale 2"),
            ({"clip": {"planes": [[1, 1, 0, 4]]}}, "--clip-plane 1,1,0,4"),
            ({"step": 2, "oversample": 2}, "--step 2 --oversample 2"),
            ({"footprint": "catmull-rom"}, "--footprint catmull-rom"),
        ]
        for view, options in cases:
            options = options if isinstance(options, tuple) else tuple(options.split())
            answer = shared.frame(view)
            self.assertEqual(answer.status, 200, answer.body[:200])
            self.assertEqual(answer.headers.get_content_type(), "image/png")
            mine, theirs = read_png(answer.body), render(folder / "a.cvol", 96, 80, *options, *as_asked(options))
            self.assertGreater(len(set(mine.rgb)), 10)
            self.assertTrue(mine == theirs, f"{view} must be what {options} draws")
            reply = answer.frame
            self.assertEqual((reply["level"], reply["quality"], reply["bytes"]), (0, "full", len(answer.body)))

    def test_formats(self):
        for quality, given, kind in (("still", None, "png"), ("still", "jpeg", "jpeg"), ("motion", None, "jpeg"), ("motion", "png", "png")):
            answer = shared.frame(quality=quality, **({"format": given} if given else {}))
            self.assertEqual(answer.headers.get_content_type(), "image/" + kind)
            self.assertTrue(answer.body.startswith(b"\x89PNG" if kind == "png" else b"\xff\xd8\xff"))
            self.assertIn("render;dur=", answer.headers["Server-Timing"])
        small, large = (len(shared.frame(format="jpeg", jpeg_quality=q).body) for q in (10, 100))
        self.assertLess(small, large)

    def test_smallest_picture(self):
        self.assertEqual(read_png(shared.frame({"width": 1, "height": 1}).body).width, 1)

    def test_newest_request_wins(self):
        """Within one viewer the last request is answered; earlier ones are answered or end with status 409."""
        count, answers, gate = 24, {}, threading.Barrier(8)

        def ask(first):
            gate.wait()
            for sequence in range(first, count, 8):
                answers[sequence] = shared.frame({"width": 300, "height": 300, "camera": {"azimuth": sequence}}, viewer="same", sequence=sequence)

        threads = [threading.Thread(target=ask, args=(first,)) for first in range(8)]
        for thread in threads:
            thread.start()
        for thread in threads:
            thread.join()
        self.assertEqual(answers[count - 1].status, 200)
        for sequence, answer in answers.items():
            if answer.status == 200:
                self.assertEqual(answer.frame["sequence"], sequence)
            else:
                self.refuse(409, answer)
        self.refuse(409, shared.frame(viewer="same", sequence=3), str(count - 1))
        self.assertEqual(shared.frame(viewer="same", sequence=count).status, 200)

    def test_small_frames_pass_large_ones(self):
        large, answers = {"width": 8000, "height": 4000}, []
        with Viewer(folder / "a.cvol", "--threads", 2) as viewer:
            viewer.wait()
            asking = [threading.Thread(target=lambda: answers.append(viewer.frame(large).status)) for _ in range(4)]
            for thread in asking:
                thread.start()
            for _ in range(6000):
                if viewer.get("api/1/status").json["waiting"] == 3:
                    break
                time.sleep(0.01)
            for i in range(5):
                self.assertEqual(viewer.frame(viewer="small").status, 200)
            self.assertEqual(viewer.end(), 0, viewer.stderr())
            for thread in asking:
                thread.join()
        self.assertIn(503, answers)  # the viewer ends without rendering them

    def test_viewers_do_not_cancel_each_other(self):
        for sequence in range(5):
            for viewer in ("left", "right"):
                self.assertEqual(shared.frame(viewer=viewer, sequence=9 - sequence if viewer == "left" and not sequence else 10 + sequence).status, 200)
        status = shared.get("api/1/status").json
        self.assertGreaterEqual(status["viewers"], 2)
        self.assertEqual(status["waiting"], 0)
        self.assertGreater(status["jobs"], 0)

    def test_two_viewers_at_once(self):
        answers = []

        def turn(viewer):
            for sequence in range(12):
                answers.append(shared.frame({"volume": viewer, "camera": {"azimuth": 7 * sequence}}, quality="motion", viewer=viewer, sequence=sequence))

        threads = [threading.Thread(target=turn, args=(viewer,)) for viewer in "01"]
        for thread in threads:
            thread.start()
        for thread in threads:
            thread.join()
        self.assertEqual({answer.status for answer in answers}, {200})
        self.assertEqual(len(answers), 24)


class Volumes(Test):
    def test_histogram(self):
        reply = shared.get("api/1/volumes/0/histogram").json
        self.assertEqual(len(reply["bins"]), 256)
        self.assertGreater(sum(reply["bins"]), 0)
        self.assertLess(reply["min"], reply["max"])

    def test_dense_volume_is_compressed(self):
        samples = folder.samples("raw", "int16")
        with Viewer(samples) as viewer:
            seen = viewer.get("api/1/volumes/0").json
            self.assertIn(seen["state"], ("reading", "compressing", "ready"))
            volume = viewer.wait()
            self.assertEqual(volume["state"], "ready", volume)
            self.assertEqual(volume["type"], "int16")
            self.assertGreater(volume["ratio"], 1)
            self.assertEqual(viewer.frame().status, 200)

    def test_damaged_file(self):
        bad = folder / "bad.cvol"
        with open(folder / "a.cvol", "rb") as good, open(bad, "wb") as out:
            data = bytearray(good.read())
            out.write(data[:100])
        with Viewer(bad, folder / "a.cvol") as viewer:
            volume = viewer.wait("0")
            self.assertEqual(volume["state"], "failed")
            self.assertIn("bad.cvol", volume["error"])
            self.refuse(409, viewer.frame({"volume": "0"}))
            for path in ("histogram", "slice?axis=z&index=0", "value?x=0&y=0&z=0", "transfer?name=auto"):
                self.refuse(409, viewer.get("api/1/volumes/0/" + path))
            self.assertEqual(viewer.wait("1")["state"], "ready")
            self.assertEqual(viewer.frame({"volume": "1"}).status, 200)

    def test_missing_file(self):
        done = subprocess.run([CVOL, "view", "--no-browser", folder / "none.cvol"], capture_output=True, text=True, env=environment(), timeout=60)
        self.assertEqual(done.returncode, 1)
        self.assertRegex(done.stderr, r"^cvol: .*none\.cvol: .*\n$")
        self.assertEqual(done.stdout, "")

    def test_unknown_file_types(self):
        text, none, raw = folder / "text.txt", folder / "nothing", folder / "samples.raw"
        os.makedirs(none)
        for path in (text, raw):
            with open(path, "w") as out:
                out.write("no volume at all\n")
        for path in (text, none, raw):
            reply = subprocess.run([CVOL, "info", path], capture_output=True, text=True, env=environment(), timeout=60)
            done = subprocess.run([CVOL, "view", "--no-browser", folder / "a.cvol", path], capture_output=True, text=True,
                                  env=environment(), timeout=60)
            self.assertEqual((done.returncode, done.stdout, done.stderr), (1, "", reply.stderr), path)

    def test_too_many_volumes(self):
        done = subprocess.run([CVOL, "view", "--no-browser", *[folder / "a.cvol"] * 300], capture_output=True, text=True,
                              env=environment(), timeout=60)
        self.assertEqual((done.returncode, done.stdout), (1, ""))
        self.assertIn("300 volumes", done.stderr)


class Clients(Test):
    def test_slow_clients_do_not_block_others(self):
        slow = []
        try:
            for i in range(50):
                s = socket.create_connection((shared.host, shared.port), timeout=60)
                slow.append(s)
                if i % 2:
                    s.sendall(f"POST {shared.root}api/1/frame HTTP/1.1\r\nHost: localhost\r\nContent-Length: 1000\r\n\r\n".encode())
            for _ in range(6):
                for s in slow:
                    with contextlib.suppress(OSError):  # connections without the token are closed after five seconds
                        s.sendall(b"G")
                answer = shared.frame(viewer="quick")
                self.assertEqual(answer.status, 200)
        finally:
            for s in slow:
                s.close()

    def test_clients_that_disconnect(self):
        for i in range(20):
            with socket.create_connection((shared.host, shared.port), timeout=60) as s:
                body = json.dumps({"view": {"volume": "0", "width": 700, "height": 700}, "viewer": f"gone {i % 3}"})
                s.sendall(f"POST {shared.root}api/1/frame HTTP/1.1\r\nHost: localhost\r\nContent-Length: {len(body)}\r\n\r\n{body}".encode())
        self.assertEqual(shared.frame(viewer="stays").status, 200)

    def test_keep_alive(self):
        connection = shared.connect()
        for i in range(10):
            connection.request("POST", shared.root + "api/1/frame", json.dumps({"view": {"volume": "0", "width": 9, "height": 9}}))
            response = connection.getresponse()
            self.assertEqual((response.status, response.read()[:4]), (200, b"\x89PNG"), i)
        connection.close()

    def test_invalid_http(self):
        for request in (b"\0" * 100, b"\x16\x03\x01\x02\0\x01\0\x01\xfc\x03\x03", b"GET\r\n\r\n", b"GET / HTTP/9.9\r\n\r\n", b"\r\n" * 50,
                     b"GET /" + b"a" * 100000 + b" HTTP/1.1\r\n\r\n", b"GET / HTTP/1.1\r\n" + b"A: b\r\n" * 20000 + b"\r\n",
                     b"POST / HTTP/1.1\r\nHost: localhost\r\nContent-Length: -1\r\n\r\n",
                     b"POST / HTTP/1.1\r\nHost: localhost\r\nTransfer-Encoding: chunked\r\n\r\nffffffffffffffff\r\n"):
            with socket.create_connection((shared.host, shared.port), timeout=60) as s:
                try:
                    s.sendall(request)
                    s.settimeout(0.2)  # the server waits for the rest of an incomplete request
                    s.recv(4096)
                except OSError:
                    pass
            self.assertEqual(shared.get("api/1").status, 200)


class Exit(Test):
    def test_signals(self):
        for how in (signal.SIGINT, signal.SIGTERM, signal.SIGHUP):
            viewer = Viewer(folder / "a.cvol")
            viewer.wait()
            self.assertEqual(viewer.frame().status, 200)
            with socket.create_connection((viewer.host, viewer.port), timeout=60) as s:  # an idle connection
                status = viewer.end(how)
                with contextlib.suppress(ConnectionResetError):  # the connection ends, either way
                    s.recv(1)
            self.assertEqual(status, 0, (how, viewer.stderr()))
            with self.assertRaises(OSError):
                socket.create_connection((viewer.host, viewer.port), timeout=5)

    def test_signal_during_work(self):
        samples = folder.samples("large", "int16", (180, 180, 120))
        viewer = Viewer(samples)
        self.assertEqual(viewer.end(signal.SIGINT), 0, viewer.stderr())
        os.remove(samples)
        viewer = Viewer(folder / "a.cvol")
        viewer.wait()
        body = json.dumps({"view": {"volume": "0", "width": 4000, "height": 4000}})
        with socket.create_connection((viewer.host, viewer.port), timeout=60) as s:
            s.sendall(f"POST {viewer.root}api/1/frame HTTP/1.1\r\nHost: localhost\r\nContent-Length: {len(body)}\r\n\r\n{body}".encode())
            viewer.post("api/1/films", {"view": {"volume": "0"}, "frames": 500})
            self.assertEqual(viewer.end(signal.SIGTERM), 0, viewer.stderr())

    def test_option_once(self):
        with Viewer(folder / "a.cvol", "--once") as viewer:
            self.assertIs(viewer.get("api/1").json["once"], True)
            self.assertEqual(viewer.post("api/1/end", {}).status, 200)
            self.assertEqual(viewer.process.wait(60), 0)

    def test_option_once_with_unless_asked_ms(self):
        with Viewer(folder / "a.cvol", "--once") as viewer:
            self.refuse(400, viewer.post("api/1/end", {"unless_asked_ms": -1}), "unless_asked_ms")
            self.refuse(400, viewer.post("api/1/end", {"unless": 1}), "unless")
            self.assertEqual(viewer.post("api/1/end", {"unless_asked_ms": 4000}).status, 200)
            time.sleep(0.3)
            self.assertEqual(viewer.get("api/1").status, 200)
            time.sleep(4)
            self.assertEqual(viewer.get("api/1").status, 200, "a request must keep it alive")
            self.assertEqual(viewer.post("api/1/end", {"unless_asked_ms": 1}).status, 200)
            self.assertEqual(viewer.process.wait(60), 0)

    def test_temporary_files_are_deleted(self):
        place = folder / "left"
        os.makedirs(place)
        os.environ["TMPDIR"], before = place, os.environ.get("TMPDIR")
        try:
            with Viewer(folder / "a.cvol") as viewer:
                viewer.wait()
                viewer.post("api/1/films", {"view": {"volume": "0", "width": 16, "height": 16}, "frames": 2})
                time.sleep(0.2)
        finally:
            if before is None:
                del os.environ["TMPDIR"]
            else:
                os.environ["TMPDIR"] = before
        self.assertEqual(os.listdir(place), [])

    def test_hanging_ffmpeg(self):
        program = folder / "ffmpeg"
        with open(program, "w") as file:
            file.write("#!/bin/sh\nsleep 1000\n")
        os.chmod(program, 0o755)
        path = os.environ["PATH"]
        os.environ["PATH"] = folder.path + ":" + path
        try:
            with Viewer(folder / "a.cvol") as viewer:
                viewer.wait()
                film = viewer.post("api/1/films", {"view": {"volume": "0"}, "frames": 500, "format": "mp4"})
                self.assertEqual(film.status, 202)
                time.sleep(0.5)  # fills the pipe
        finally:
            os.environ["PATH"] = path
            os.remove(program)

    def test_port_in_use(self):
        done = subprocess.run([CVOL, "view", "--no-browser", "--port", str(shared.port), folder / "a.cvol"], capture_output=True, text=True,
                              env=environment(), timeout=60)
        self.assertEqual(done.returncode, 1)
        self.assertIn(str(shared.port), done.stderr)


if __name__ == "__main__":
    unittest.main()
