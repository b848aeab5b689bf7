#!/usr/bin/env python3
"""Sends random and mutated requests. Every request gets a valid HTTP answer other than 500, and the viewer ends well.

usage: fuzz.py [COUNT [SEED]], with CVOL the command and CVOL_HELPERS the folder of make_volume.
"""

import copy
import http.client
import json
import random
import socket
import sys
import threading
import time
from urllib.parse import quote

from viewer_strict import Folder, Viewer

CLIENTS = 6
PIXELS_MAX = 200 * 200  # per rendered picture; larger ones only take time
GOOD = {200, 202, 400, 403, 404, 405, 409, 413, 414, 429, 431, 501, 505}
NUMBERS = [0, -0.0, 1, -1, 2, 0.5, 1e-320, 1e-9, 1e9, 1e18, -1e18, 2**31, 2**31 - 1, -2**31, 2**32, 2**53 + 1, 2**63 - 1, 1e38, 1e39, 1e300, -1e300, 255, 4096, 8192, 8193]
TEXTS = ["", "0", "1", "7", "f0", "f1", "auto", "bone", "no such", "x" * 63, "x" * 64, "x" * 3000, "\0", "../../etc/passwd", "%s%n%d", "\u202e\U0001f600", "still", "motion", "png",
         "jpeg", "composite", "xray", "mip", "min", "iso", "gif", "webp", "mp4", "nan", "a b", "'; ls", '"', "\\"]
RAW = ["NaN", "Infinity", "-Infinity", "1e999", "-1e999", "9" * 400, "0x10", "1.", "01", "tru", "'a'", "[,]", "{,}", "\\u0000", '"\\ud800"', '"\\u0000"', "99999999999999999999"]

VIEW = {"volume": "0", "time": 0, "channels": [{"volume": "0", "colour": [1, 0.5, 0], "transfer": "microscopy", "opacity_scale": 1, "window": [0, 200]}],
        "width": 40, "height": 30, "mode": "composite",
        "camera": {"azimuth": 30, "elevation": 10, "roll": 5, "zoom": 1.2, "fov": 20, "look_at": [0, 0, 0]}, "mirror": False,
        "transfer": [[0, 0, 0, 0, 0], [120, 1, 0.5, 0, 0.4], [255, 1, 1, 1, 1]], "opacity_scale": 1, "window": [0, 200],
        "light": {"on": True, "direction": [0, 0, 1], "ambient": 0.1, "diffuse": 0.7, "specular": 0.2, "shininess": 10, "gradient_opacity": 0},
        "surface": {"value": 100, "colour": [1, 1, 1]}, "clip": {"box": [1, 30, None, None, 2, 30], "planes": [[1, 0, 0, 3]]},
        "overlays": [{"on": True, "opacity": 0.7, "depth": 9, "transfer": "hot", "window": [20, 200]},
                     {"on": True, "opacity": 0.5, "depth": 5, "labels": [3, 70]}],
        "background": [0, 0, 0], "step": 0, "oversample": 1, "footprint": "b-spline"}
POSTS = {
    "api/1/frame": {"view": VIEW, "quality": "still", "format": "png", "viewer": "a", "sequence": 5},
    "api/1/pick": {"view": VIEW, "x": 0.5, "y": 0.5},
    "api/1/difference": {"view": VIEW, "other": "1", "gain": 8, "quality": "motion", "viewer": "d", "sequence": 3, "budget_ms": 20, "jpeg_quality": 80},
    "api/1/command": {"view": VIEW},
    "api/1/films": {"view": VIEW, "frames": 3, "fps": 10, "degrees": 90, "format": "gif", "quality": 50},
    "api/1/volumes/0/copy": {"ratio": 40, "viewer": "a"},
    "api/1/volumes/0/transfer": {"points": [[0, 0, 0, 0, 0], [255, 1, 1, 1, 1]]},
    "api/1/volumes/0/open": {"time": 0},
    "api/1/volumes/0/measure": {"kind": "ellipsoid", "box": [2, 20, 3, 21, 4, 22], "time": 0},
    "api/1/volumes/1/measure": {"kind": "angle", "points": [[1, 2, 3], [4, 5.5, 6], [7, 8, 9]], "time": 0},
    "api/1/end": {},
}
GETS = ["", "app.js", "api/1", "api/1/volumes", "api/1/volumes/{id}", "api/1/volumes/{id}/histogram", "api/1/volumes/{id}/transfer?name={text}",
        "api/1/volumes/{id}/transfer?overlay={number}&name={text}&window={number},{number}",
        "api/1/volumes/{id}/slice?axis=y&index=3&overlays={overlays}",
        "api/1/volumes/{id}/slice?axis={axis}&index={number}&window={number},{number}", "api/1/volumes/{id}/slice?axis=z&index=3&time={number}",
        "api/1/volumes/{id}/value?x={number}&y={number}&z=1", "api/1/films/{film}", "api/1/films/{film}/file", "api/1/status"]


def is_number(value):
    return isinstance(value, (int, float)) and not isinstance(value, bool)


class RequestGenerator:
    """Generates the requests of one seed."""

    def __init__(self, seed):
        self.random = random.Random(seed)

    def value(self):
        r = self.random
        kind = r.randrange(8)
        if kind < 3:
            return r.choice(NUMBERS)
        if kind == 3:
            return r.uniform(-300, 300)
        if kind == 4:
            return r.choice(TEXTS)
        if kind == 5:
            return r.choice([None, True, False, [], {}])
        return [self.value() for _ in range(r.randrange(6))] if kind == 6 else {r.choice(TEXTS): self.value()}

    def mutate(self, tree):
        """Changes one value in the tree."""
        r = self.random
        at = tree
        while True:
            keys = list(at) if isinstance(at, dict) else list(range(len(at)))
            if not keys:
                return
            key = r.choice(keys)
            if isinstance(at[key], (dict, list)) and r.random() < 0.8:
                at = at[key]
                continue
            how = r.randrange(6)
            if how == 0:
                del at[key]
            elif how == 1 and isinstance(at, dict):
                at[r.choice(TEXTS)] = self.value()
            elif how == 1:
                at.append(self.value())
            elif how == 2 and is_number(at[key]):
                at[key] = at[key] * r.choice([-1, 0.1, 3, 1000]) + r.choice([0, 0.5, 1])
            else:
                at[key] = self.value()
            return

    def mutated(self, tree):
        tree = copy.deepcopy(tree)
        self.mutate(tree)
        return tree

    def bounded(self, body):
        """Limits sizes that would only take time."""
        view = body.get("view")
        if isinstance(view, dict):
            width, height = view.get("width", 512), view.get("height", 512)
            sizes = [w for w in (width, height) if is_number(w) and 1 <= w <= 8192]
            if len(sizes) == 2 and width * height > PIXELS_MAX:
                view["width"], view["height"] = 40, 30
        if "frames" in body or (body.get("format") in ("gif", "webp", "mp4")):
            frames = body.get("frames", 72)
            if is_number(frames) and 4 < frames <= 1e6:
                body["frames"] = 3
        return body

    def body(self, path):
        r = self.random
        tree = copy.deepcopy(POSTS[path])
        if "view" in tree:  # fewer fields: more requests stay valid
            for key in list(tree["view"]):
                if key not in ("volume", "width", "height") and r.random() < 0.4:
                    del tree["view"][key]
            tree["view"]["mode"] = r.choice(["composite", "composite", "xray", "mip", "min", "iso"])
        if "sequence" in tree:
            tree["sequence"] = r.randrange(100000)
            tree["viewer"] = r.choice("abcdefgh")
        for _ in range(r.choice([0, 0, 1, 1, 1, 2, 5])):
            self.mutate(tree)
        text = json.dumps(self.bounded(tree))
        if r.random() < 0.1:
            at = r.randrange(len(text))
            text = text[:at] + r.choice(RAW) + text[at + r.randrange(8):]
        data = bytearray(text.encode("utf-8", "surrogatepass"))
        if r.random() < 0.1:
            for _ in range(r.randrange(1, 6)):
                data[r.randrange(len(data))] = r.randrange(256)
            # JSON that is still valid may ask for a large picture
            try:
                read = json.loads(data)
                data = bytearray(json.dumps(self.bounded(read)).encode()) if isinstance(read, dict) else data
            except (ValueError, RecursionError):
                pass
        if r.random() < 0.03:
            data = data[:r.randrange(len(data))]
        return bytes(data)

    def path(self):
        r = self.random
        pattern = r.choice(GETS)
        while "{" in pattern:
            name = pattern[pattern.index("{") + 1:pattern.index("}")]
            value = {"id": lambda: r.choice(["0", "0", "1", "2", "3", "9", "../0", "%00", "x" * 100]), "film": lambda: "f%d" % r.randrange(6),
                     "text": lambda: r.choice(TEXTS), "axis": lambda: r.choice(["x", "y", "z", "w", "", "xy"]),
                     "overlays": lambda: json.dumps(self.mutated(VIEW["overlays"])),
                     "number": lambda: r.choice([*map(str, NUMBERS), "3", "7", "nan", "inf", "-inf", "", "a", "0x3", " 3", "3 "])}[name]()
            pattern = pattern.replace("{" + name + "}", quote(value, safe="%./-+"), 1)
        if r.random() < 0.1:
            at = r.randrange(len(pattern) + 1)
            pattern = pattern[:at] + r.choice(["/", "//", "..", "%2f", "%00", "%", "?", "&", "=", "%ff%fe", "+", "#", ";"]) + pattern[at:]
        return pattern

    def request(self):
        """Returns (method, path below the token, body, headers, whether the token is correct)."""
        r = self.random
        headers = {}
        if r.random() < 0.55:
            path = r.choice(["api/1/frame"] * 4 + list(POSTS))
            method, body = "POST", self.body(path)
        else:
            path, method, body = self.path(), "GET", None
            if r.random() < 0.1:
                method, path = "DELETE", r.choice(["api/1/volumes/%d" % r.randrange(8), "api/1/films/f%d" % r.randrange(8)])
        if r.random() < 0.03:
            method = r.choice(["PUT", "OPTIONS", "HEAD", "PATCH", "TRACE", "get", "X" * 50])
        if r.random() < 0.05:
            headers[r.choice(["Host", "Origin", "Content-Type", "Range", "Expect", "Accept-Encoding", "Sec-Fetch-Site", "Connection"])] = r.choice(
                ["localhost", "example.org", "null", "", "bytes=0-1", "bytes=9-1", "100-continue", "gzip", "cross-site", "close", "x" * 2000])
        return method, path, body, headers, r.random() > 0.03

    def noise(self, root):
        """Returns bytes that are rarely valid HTTP."""
        r = self.random
        method, path, body, _, _ = self.request()
        body = body or b""
        length = r.choice([len(body), len(body), len(body) + 9, max(0, len(body) - 9), -1, 10**30, "a"])
        data = bytearray(f"{method} {root}{path.encode('ascii', 'ignore').decode()} HTTP/1.1\r\nHost: localhost\r\nContent-Length: {length}\r\n\r\n".encode() + body)
        for _ in range(r.randrange(4)):
            data[r.randrange(min(len(data), 200))] = r.randrange(256)
        return bytes(data[:r.randrange(1, len(data) + 1)] if r.random() < 0.5 else data)


def check(request, answer, body):
    method, path, sent, headers, with_token = request
    context = f"{method} {path[:300]!r}\n{headers}\n{(sent or b'')[:3000]!r}\n-> {answer.status} {body[:300]!r}"
    assert answer.status in GOOD, context
    if not with_token:
        assert answer.status in (400, 403, 414, 431, 501, 505), "without a token\n" + context
    if method != "HEAD" and answer.status >= 400 and answer.headers.get_content_type() == "application/json":
        sentence = json.loads(body)["error"]
        assert sentence and "\n" not in sentence, context
    if answer.status == 200 and answer.headers.get_content_type() == "application/json" and method != "HEAD":
        def refuse(word):
            raise AssertionError(f"{word} is no JSON\n{context}")
        json.loads(body, parse_constant=refuse)


def main():
    count = int(sys.argv[1]) if len(sys.argv) > 1 else 500
    seed = int(sys.argv[2]) if len(sys.argv) > 2 else random.SystemRandom().randrange(2**32)
    print(f"{count} requests, seed {seed}", flush=True)
    folder = Folder()
    failures, statuses, lock = [], {}, threading.Lock()
    try:
        labels = folder / "labels.seg.nrrd"
        with open(labels, "wb") as file:
            file.write(b"NRRD0004\ntype: uchar\ndimension: 3\nsizes: 30 28 26\nencoding: raw\n\n")
            file.write(bytes((0, 3, 70)[i // 4000 % 3] for i in range(30 * 28 * 26)))
        with Viewer(folder.volume("a", dims=(30, 28, 26)), folder.volume("b", dims=(30, 28, 26), ratio=20),
                    "--overlay", folder.volume("c", dims=(15, 14, 13), ratio=4), "--overlay", labels) as viewer:
            for identity in "01":
                assert viewer.wait(identity)["state"] == "ready"

            def work(number):
                generator = RequestGenerator(f"{seed} {number}")
                for i in range(number, count, CLIENTS):
                    if failures or viewer.process.poll() is not None:
                        return
                    if generator.random.random() < 0.06:
                        try:
                            with socket.create_connection((viewer.host, viewer.port), timeout=60) as s:
                                s.sendall(generator.noise(viewer.root))
                                s.settimeout(0.5)  # the server waits longer for incomplete requests
                                answer = s.recv(64)
                                assert not answer or answer.startswith(b"HTTP/1."), answer
                        except OSError:
                            pass
                        continue
                    request = generator.request()
                    method, path, body, headers, with_token = request
                    root = viewer.root if with_token else "/" + "0" * 32 + "/"
                    connection = viewer.connect()
                    try:
                        path = "".join(c for c in path if " " < c < "\x7f")
                        connection.request(method, root + path, body, headers)
                        answer = connection.getresponse()
                        check(request, answer, answer.read())
                        with lock:
                            statuses[answer.status] = statuses.get(answer.status, 0) + 1
                    except (AssertionError, OSError, ValueError, KeyError, http.client.HTTPException) as e:
                        with lock:
                            failures.append(f"request {i}: {type(e).__name__}: {e}\n{method} {path[:200]!r} {headers} {(body or b'')[:2000]!r}")
                    finally:
                        connection.close()

            threads = [threading.Thread(target=work, args=(number,)) for number in range(CLIENTS)]
            for thread in threads:
                thread.start()
            for thread in threads:
                thread.join()
            if not failures and viewer.process.poll() is None:
                assert viewer.frame({"width": 20, "height": 20}).status == 200
                until = time.monotonic() + 60
                while viewer.get("api/1/status").json["waiting"] and time.monotonic() < until:
                    time.sleep(0.05)
                print("resident:", viewer.get("api/1/status").json["resident_bytes"], "bytes")
    except AssertionError as e:
        failures.append(str(e))
    finally:
        folder.remove()
    print("answers:", dict(sorted(statuses.items())))
    for failure in failures:
        print("FAILED:", failure)
    sys.exit(bool(failures))


if __name__ == "__main__":
    main()
