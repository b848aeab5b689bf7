"""A viewer for tests that send any header and path and check its exit status; also makes small volumes."""

import http.client
import json
import os
import shutil
import signal
import subprocess
import tempfile
import time

from viewer_client import CVOL, read_png

HELPERS = os.environ.get("CVOL_HELPERS", os.path.join(os.path.dirname(CVOL), "tests/helpers"))
TIMEOUT_S = 120  # a generous limit: only a missing event fails


def environment():
    """Returns the environment. A sanitizer error must not look like a failure of the command itself."""
    env = dict(os.environ, OMP_WAIT_POLICY="passive")
    for name in ("ASAN_OPTIONS", "UBSAN_OPTIONS"):
        env[name] = ":".join(filter(None, [env.get(name), "exitcode=99"]))
    env.pop("DISPLAY", None)
    env.pop("WAYLAND_DISPLAY", None)
    return env


def run(*command):
    done = subprocess.run([str(word) for word in command], capture_output=True, text=True, env=environment(),
                          stdin=subprocess.DEVNULL)
    if done.returncode:
        raise AssertionError(f"{' '.join(map(str, command))}: status {done.returncode}\n{done.stderr}")
    return done.stdout


class Folder:
    """A folder with volumes, deleted when the tests end."""

    def __init__(self):
        self.path = tempfile.mkdtemp(prefix="cvol-view-")

    def __truediv__(self, name):
        return os.path.join(self.path, name)

    def samples(self, name, kind="uint8", dims=(40, 36, 34)):
        """Writes an NRRD of synthetic samples."""
        raw = self / (name + ".raw")
        run(os.path.join(HELPERS, "make_volume"), raw, kind, "x".join(map(str, dims)))
        path = self / (name + ".nrrd")
        names = {"float32": "float", "float64": "double"}
        with open(path, "wb") as out, open(raw, "rb") as data:
            out.write(b"NRRD0004\ntype: %s\ndimension: 3\nsizes: %d %d %d\nencoding: raw\nendian: little\n\n"
                      % (names.get(kind, kind).encode(), *dims))
            shutil.copyfileobj(data, out)
        os.remove(raw)
        return path

    def volume(self, name, kind="uint8", dims=(40, 36, 34), ratio=8):
        samples = self.samples(name, kind, dims)
        path = self / (name + ".cvol")
        run(CVOL, "compress", samples, path, "--ratio", ratio)
        os.remove(samples)
        return path

    def remove(self):
        shutil.rmtree(self.path, ignore_errors=True)


class Answer:
    def __init__(self, response):
        self.status = response.status
        self.headers = response.headers
        self.body = response.read()

    @property
    def json(self):
        return json.loads(self.body)

    @property
    def error(self):
        return self.json["error"]

    @property
    def frame(self):
        return json.loads(self.headers["Cvol-Frame"])


class Viewer:
    """`cvol view` of files, for a `with` block; checks the exit status."""

    def __init__(self, *arguments, expect=0):
        self.expect = expect
        self.errors = tempfile.TemporaryFile()
        self.process = subprocess.Popen([CVOL, "view", "--no-browser", "--json", *map(str, arguments)],
                                        stdout=subprocess.PIPE, stderr=self.errors, stdin=subprocess.DEVNULL,
                                        env=environment())
        text = ""
        while not text.endswith("}\n"):
            line = self.process.stdout.readline().decode()
            if not line:
                raise AssertionError(f"no address; status {self.process.wait()}: {self.stderr()}")
            text += line
        self.address = json.loads(text)["address"]
        host, path = self.address.removeprefix("http://").split("/", 1)
        self.host, port = host.rsplit(":", 1)
        self.port = int(port)
        self.root = "/" + path

    def __enter__(self):
        return self

    def __exit__(self, kind, *_):
        status = self.end()
        if kind is None:
            assert status == self.expect, f"status {status}: {self.stderr()}"

    def stderr(self):
        """Returns the standard error so far; complete after the end."""
        if not self.errors.closed:
            self.errors.seek(0)
            self.text = self.errors.read().decode(errors="replace")
        return self.text

    def end(self, how=signal.SIGINT):
        if self.process.poll() is None:
            self.process.send_signal(how)
        try:
            status = self.process.wait(TIMEOUT_S)
        except subprocess.TimeoutExpired:
            self.process.kill()
            raise AssertionError("the viewer did not end") from None
        self.process.stdout.close()
        self.stderr()
        self.errors.close()
        return status

    def connect(self):
        return http.client.HTTPConnection(self.host, self.port, timeout=TIMEOUT_S)

    def ask(self, method, path, body=None, headers=None, root=None):
        if isinstance(body, (dict, list)):
            body = json.dumps(body)
        connection = self.connect()
        try:
            connection.request(method, (self.root if root is None else root) + path, body, headers or {})
            return Answer(connection.getresponse())
        finally:
            connection.close()

    def get(self, path, **more):
        return self.ask("GET", path, **more)

    def post(self, path, body=None, **more):
        return self.ask("POST", path, body, **more)

    def frame(self, view=None, **more):
        view = {"volume": "0", "width": 96, "height": 80, **(view or {})}
        return self.post("api/1/frame", {"view": view, **more})

    def wait(self, identity="0", states=("ready", "failed")):
        """Waits until the volume is in one of these states."""
        until = time.monotonic() + TIMEOUT_S
        while time.monotonic() < until:
            volume = self.get(f"api/1/volumes/{identity}").json
            if volume["state"] in states:
                return volume
            time.sleep(0.02)
        raise AssertionError(f"volume {identity} is {volume}")


def render(volume, width, height, *options):
    """Returns the picture that `cvol render` writes."""
    folder = tempfile.mkdtemp()
    try:
        run(CVOL, "render", volume, "-o", os.path.join(folder, "a.png"), "--size", f"{width}x{height}", *options)
        with open(os.path.join(folder, "a.png"), "rb") as file:
            return read_png(file.read())
    finally:
        shutil.rmtree(folder)
