"""A client of the viewer: starts it, sends requests, ends it. Uses only Python's standard library."""

import array
import json
import os
import signal
import struct
import subprocess
import tempfile
import time
import urllib.error
import urllib.request
import zlib

CVOL = os.environ["CVOL"]


class Answer:
    def __init__(self, status, headers, content):
        self.status, self.headers, self.content = status, headers, content

    @property
    def json(self):
        return json.loads(self.content)

    @property
    def error(self):
        return self.json["error"]

    @property
    def picture(self):
        return read_png(self.content)


class Viewer:
    """`with Viewer(folder, "a.cvol") as v:` starts the viewer and waits until its volumes are ready."""

    def __init__(self, folder, *arguments, path=None):
        self.folder = folder
        environment = dict(os.environ, OMP_WAIT_POLICY="passive", TMPDIR=folder)
        if path:
            environment["PATH"] = path + ":" + environment["PATH"]
        self.process = subprocess.Popen(
            [CVOL, "view", *arguments, "--no-browser", "--json", "--threads", "2"],
            cwd=folder, env=environment, stdout=subprocess.PIPE)
        text = b""
        while b"}" not in text:
            more = os.read(self.process.stdout.fileno(), 4096)
            assert more, "the viewer ended before it printed its address"
            text += more
        self.address = json.loads(text)["address"]

    def __enter__(self):
        for volume in self.get("volumes").json["volumes"]:
            self.wait_for(volume["id"])
        return self

    def __exit__(self, *_):
        self.process.send_signal(signal.SIGINT)
        self.status = self.process.wait(60)
        self.process.stdout.close()

    def ask(self, method, path, content=None):
        request = urllib.request.Request(self.address + ("api/1/" + path).rstrip("/"), content, method=method)
        try:
            with urllib.request.urlopen(request, timeout=60) as answer:
                return Answer(answer.status, answer.headers, answer.read())
        except urllib.error.HTTPError as refusal:
            with refusal:
                return Answer(refusal.code, refusal.headers, refusal.read())

    def get(self, path):
        return self.ask("GET", path)

    def post(self, path, body):
        return self.ask("POST", path, body if isinstance(body, bytes) else json.dumps(body).encode())

    def delete(self, path):
        return self.ask("DELETE", path)

    def frame(self, **view):
        answer = self.post("frame", {"view": view})
        assert answer.status == 200, answer.content
        return answer.picture

    def wait_for(self, volume):
        for _ in range(600):
            state = self.get("volumes/" + volume).json
            if state["state"] in ("ready", "failed"):
                return state
            time.sleep(0.05)
        raise AssertionError(f"volume {volume} is not ready: {state}")

    def wait_for_film(self, film):
        for _ in range(600):
            state = self.get("films/" + film).json
            if state["state"] != "running":
                return state
            time.sleep(0.05)
        raise AssertionError(f"film {film} is not done: {state}")


def run(folder, command):
    """Runs a command line as a user would paste it; "cvol" is the tested command."""
    environment = dict(os.environ, PATH=os.path.dirname(os.path.abspath(CVOL)) + ":" + os.environ["PATH"])
    done = subprocess.run(command, shell=True, cwd=folder, env=environment, capture_output=True, text=True)
    assert done.returncode == 0, (command, done.stderr)


class Picture:
    """width, height, and rgb: three bytes per pixel, the top row first."""

    def __init__(self, width, height, rgb):
        self.width, self.height, self.rgb = width, height, rgb

    def __eq__(self, other):
        return (self.width, self.height, self.rgb) == (other.width, other.height, other.rgb)

    def at(self, x, y):
        start = 3 * (y * self.width + x)
        return tuple(self.rgb[start:start + 3])


def _predict(kind, left, up, corner):
    if kind == 4:
        estimate = left + up - corner
        return min((left, up, corner), key=lambda v: abs(estimate - v))
    return (0, left, up, (left + up) // 2)[kind]


def read_png(content):
    """Reads an RGB picture of 8 bits per channel, the format of pictures without opacity."""
    assert content[:8] == b"\x89PNG\r\n\x1a\n", content[:200]
    at, packed = 8, b""
    while at < len(content):
        size, kind = struct.unpack_from(">I4s", content, at)
        part = content[at + 8:at + 8 + size]
        assert struct.unpack_from(">I", content, at + 8 + size)[0] == zlib.crc32(kind + part)
        if kind == b"IHDR":
            width, height, bits, colours = struct.unpack_from(">IIBB", part)
            assert (bits, colours) == (8, 2)
        packed += part if kind == b"IDAT" else b""
        at += 12 + size
    data, above, rows, line = zlib.decompress(packed), bytes(3 * width), [], 3 * width + 1
    for y in range(height):
        kind, row = data[y * line], bytearray(data[y * line + 1:(y + 1) * line])
        for i in range(len(row) if kind else 0):
            left, corner = (row[i - 3], above[i - 3]) if i >= 3 else (0, 0)
            row[i] = (row[i] + _predict(kind, left, above[i], corner)) & 255
        rows.append(bytes(row))
        above = row
    return Picture(width, height, b"".join(rows))


def make_folder():
    return tempfile.TemporaryDirectory(prefix="cvol-viewer-")


def write_floats(path, values):
    samples = array.array("f", values)
    if struct.pack("=H", 1) != struct.pack("<H", 1):
        samples.byteswap()
    with open(path, "wb") as file:
        samples.tofile(file)


def read_floats(path):
    samples = array.array("f")
    with open(path, "rb") as file:
        samples.frombytes(file.read())
    if struct.pack("=H", 1) != struct.pack("<H", 1):
        samples.byteswap()
    return samples
