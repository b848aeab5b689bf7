#!/usr/bin/python3
"""Compares the decoder of the library with doc/decoder_ref.py, which is written from the format's description alone, on
random small files, and on these with damages and recomputed checksums. Both must give the same samples or both must
refuse the file. Each file and its samples are also made with the other instruction sets, and must have the same bytes.

usage: fuzz/differential.py BUILD_FOLDER [FIRST_SEED [COUNT [SECONDS [FOLDER]]]]    a file and its damages for each seed
       fuzz/differential.py BUILD_FOLDER FILE...                                    these files only

SECONDS 0 (default): no limit. Prints each disagreement with its seed, and keeps its file in FOLDER (default: the
temporary folder); then the number of files by kind. Exits with 1 after a disagreement. The build folder has the command
cvol and the programs make_terms and decode_planes of the tests. Needs NumPy.
"""
import collections
import json
import os
import random
import signal
import struct
import subprocess
import sys
import tempfile
import time
import zlib

import numpy as np

sys.dont_write_bytecode = True
sys.path[:0] = [os.path.join(os.path.dirname(os.path.abspath(__file__)), "..", "doc"),
                os.path.dirname(os.path.abspath(__file__))]
import damage  # noqa: E402  (both are found by the path above)
import decoder_ref as ref  # noqa: E402

TYPES = {"uint8": "u1", "int8": "i1", "uint16": "<u2", "int16": "<i2", "uint32": "<u4", "int32": "<i4",
         "float32": "<f4", "float64": "<f8"}
DAMAGES = 8  # of each file
SAMPLES = 20000  # of a file; damaged files that state more are not decoded
PRECISION = 1e-5  # of evaluated samples, relative to their largest magnitude (tests/cli/test_decoder_ref.sh)
LEAST = 1e-36  # smaller magnitudes lose digits in single precision
INSTRUCTIONS = "base", "avx2", "avx512"  # values of CVOL_CPU; a processor without one of them takes the next best
REFERENCE_SECONDS, COMMAND_SECONDS = 60, 60


class Refused(Exception):
    """The command refuses the options; there is no file."""


# ---- random volumes and options --------------------------------------------------------------------------------------

def random_shape(r, most):
    shape = [r.choice((r.randint(1, 40), r.choice((1, 2, 8, 15, 16, 17, 31, 32, 33)))) for _ in range(3)]
    while shape[0] * shape[1] * shape[2] > most:
        a = r.randrange(3)
        shape[a] = max(1, shape[a] * 2 // 3)
    return shape


def random_samples(r, shape, kind):
    """Returns samples [z, y, x] of a type."""
    numbers = np.random.default_rng(r.randrange(2 ** 32))
    z, y, x = np.indices(shape[::-1], dtype=float)
    noise = numbers.uniform(-1, 1, x.shape)
    ball = np.hypot(np.hypot(x - 9, y - 7), z - 8) < r.uniform(4, 14)
    values = r.choice((lambda: 0 * x + r.choice((0, 1)), lambda: noise, lambda: noise ** 9,
                       lambda: np.sin(r.uniform(0, 1) * x) * np.cos(r.uniform(0, 0.5) * (y + z)),
                       lambda: np.sin(r.uniform(0, 1) * x) + 0.02 * noise, lambda: ball - 0.05 * noise,
                       lambda: ball * (0.5 + 0.3 * noise), lambda: np.where(x + y < 20, -1, 1) * 1.0))()
    values = np.clip(values, -1, 1)
    if kind.startswith("float"):
        values = values * 10 ** r.uniform(-20, 20) + r.choice((0, 0, 1e3))
    else:
        least, most = np.iinfo(TYPES[kind]).min, np.iinfo(TYPES[kind]).max
        scale = 10 ** r.uniform(-2.4, 0)
        values = np.rint((least + most) / 2 * r.choice((1, scale)) + (most / 2 - least / 2) * scale * values)
        values = np.clip(values, least, most)
    return values.astype(TYPES[kind])


def spoil_floats(r, samples):
    flat = samples.reshape(-1)
    for _ in range(r.randint(1, 4)):
        flat[r.randrange(flat.size)] = r.choice((np.nan, np.inf, -np.inf, -0.0, 1e-42, 1e35))


def random_target(r, spread):
    return r.choice((lambda: ["--ratio", f"{10 ** r.uniform(0.2, 2):.4g}", "--force"],
                     lambda: ["--psnr", f"{r.uniform(15, 70):.4g}"],
                     lambda: ["--bpv", f"{10 ** r.uniform(-1, 1):.4g}", "--force"],
                     lambda: ["--max-error", f"{max(spread, 1e-37) * 10 ** r.uniform(-3, -1):.6g}"],
                     lambda: ["--max-error", f"{max(spread, 1e-37) * 10 ** r.uniform(-2, -1):.6g}",
                              "--psnr", f"{r.uniform(15, 50):.4g}"],
                     lambda: ["--lossless"]))()


def random_volume_options(r, samples):
    finite = samples[np.isfinite(samples)].astype(float)
    spread = float(finite.max() - finite.min()) if finite.size else 1
    options = random_target(r, spread) + ["--labels", "no"]
    block = r.choice((16, 16, 16, 8, 32))
    options += ["--block", str(block)] if block != 16 else []
    lossy = not {"--lossless", "--max-error"} & set(options)
    options += r.choice((["--effort", "fast"], [], ["--effort", "max"] if lossy and block == 16 else []))
    options += ["--no-lap"] if r.random() < 0.4 else []
    if r.random() < 0.4:
        sides = [side for side in (16, 32, 48, 64) if side % block == 0]
        options += ["--bricks", ",".join(str(r.choice(sides)) for _ in range(3))]
    if r.random() < 0.3:
        options += ["--fill", r.choice((repr(samples.reshape(-1)[r.randrange(samples.size)].item()), "nan"))]
    else:
        background = repr(samples.reshape(-1)[r.randrange(samples.size)].item())
        options += ["--background", r.choice(("auto", "none", background))]
    return options


# ---- random files ----------------------------------------------------------------------------------------------------

class Maker:
    """Makes files in a folder with the command."""

    def __init__(self, build, folder):
        self.cvol = os.path.join(build, "cvol")
        self.helpers = os.path.join(build, "tests", "helpers")
        self.folder = folder
        self.commands, self.made, self.refused = [], [], 0

    def path(self, name):
        return os.path.join(self.folder, name)

    def call(self, *command, instructions=None):
        self.commands.append(command)
        self.made = [os.path.basename(command[0]), *command[1:]]
        done = subprocess.run(command, capture_output=True, text=True, timeout=COMMAND_SECONDS,
                              env=environment(instructions))
        if done.returncode in (1, 2) and done.stderr.strip():
            raise Refused(done.stderr)
        if done.returncode:
            raise RuntimeError(f"{' '.join(self.made)}: status {done.returncode}: {done.stderr}")

    def raw(self, samples, name="in.raw"):
        samples.tofile(self.path(name))
        return self.path(name)

    def compress(self, samples, options, count=1, output="file.cvol"):
        nz, ny, nx = samples.shape
        kind = next(name for name, numpy_type in TYPES.items() if samples.dtype == np.dtype(numpy_type))
        names = [self.raw(samples if i == 0 else np.roll(samples, i, 1), f"in{i}.raw") for i in range(count)]
        self.call(self.cvol, "compress", *names, "-o", self.path(output), "--dims", f"{nx}x{ny}x{nz}", "--type", kind,
                  *options)

    def volume(self, r):
        kind = r.choice(list(TYPES))
        samples = random_samples(r, random_shape(r, 8000), kind)
        if kind.startswith("float") and r.random() < 0.3:
            spoil_floats(r, samples)
        options = random_volume_options(r, samples)
        if r.random() < 0.2:
            with open(self.path("in.json"), "w", encoding="utf-8") as file:
                json.dump({"text": "\u00e4" * r.randint(0, 9), "n": [1.5, None, True]}, file)
            options += ["--attributes", self.path("in.json")]
        if r.random() < 0.3:
            options += ["--spacing", "0.5,1,2.25"]
        self.compress(samples, options)

    def labels(self, r):
        kind = r.choice([name for name in TYPES if not name.startswith("float")])
        shape, numbers = random_shape(r, 6000), np.random.default_rng(r.randrange(2 ** 32))
        at = np.stack(np.meshgrid(*(np.arange(n) for n in shape[::-1]), indexing="ij"), -1)
        places = numbers.integers(0, shape[::-1], (r.randint(1, 30), 3))
        labels = np.argmin([((at - place) ** 2).sum(-1) for place in places], 0)
        labels[numbers.random(labels.shape) < r.choice((0, 0.01, 0.2))] = r.randrange(9)
        scale = r.choice((1, 3 if kind.endswith("8") else 1000))
        bricks = ["--bricks", ",".join(str(r.choice((16, 32, 48, 64))) for _ in range(3))]
        self.compress((scale * labels).astype(TYPES[kind]),
                      ["--labels", "yes"] + r.choice(([], bricks)))

    def array(self, r):
        """Arrays that are no volumes: terms of a transform."""
        kind = r.choice(list(TYPES))
        shape = random_shape(r, 6000)
        rank = r.choice((1, 2, 3, 3))
        shape[rank:] = [1] * (3 - rank)
        transform, block = r.choice(("dct", "dht", "dft")), r.choice((0, 8, 16, 32))
        keep = [f"{r.randint(0, 4)},{r.randint(0, 40)}"]
        how = ["--keep", *keep] if block == 0 or transform == "dct" or r.random() < 0.5 else ["--psnr", "40"]
        self.compress(random_samples(r, shape, kind), ["--transform", transform, "--block", str(block), *how])

    def series(self, r):
        samples = random_samples(r, random_shape(r, 2000), r.choice(list(TYPES)))
        count = r.randint(2, 3)
        how = r.choice((["--time-step", "2.5"], ["--as", "channels"]))
        self.compress(samples, ["--psnr", f"{r.uniform(20, 60):.3g}", "--labels", "no", *how], count)

    def terms(self, r):
        """Random coefficients, also of the largest magnitudes."""
        nx, ny, nz = random_shape(r, 6000)
        block = r.choice((8, 16, 16, 16, 32))
        split, lapped = (r.randint(0, 1), r.randint(0, 1)) if block == 16 else (0, 0)
        self.call(os.path.join(self.helpers, "make_terms"), self.path("file.cvol"), f"{nx}x{ny}x{nz}",
                  *map(str, (block, split, lapped, r.randint(0, 1), r.randrange(10 ** 6))))

    def picture(self, r):
        width, height = r.randint(1, 60), r.randint(1, 60)
        colours = np.stack([random_samples(r, (width, height, 1), "uint8")[0] for _ in range(4)], 2)
        count = r.choice((3, 4))
        with open(self.path("in.png"), "wb") as file:
            file.write(png(colours[:, :, :count]))
        if r.random() < 0.5:
            colours[:, :, 1:3] = colours[:, :, :1]  # grey
        self.call(self.cvol, "compress", self.path("in.png"), self.path("file.cvi"), "--transform",
                  r.choice(("dct", "dht", "dft")), "--block", str(r.choice((0, 8, 16, 32))),
                  *r.choice((["--psnr", f"{r.uniform(15, 60):.3g}"], ["--ratio", f"{10 ** r.uniform(0.3, 1.5):.3g}"])))

    def source(self, r):
        """A volume for pictures and baking."""
        nx, ny, nz = (r.randint(6, 26) for _ in range(3))
        z, y, x = np.indices((nz, ny, nx))
        samples = (200 * (np.hypot(x - nx / 2, np.hypot(y - ny / 2, z - nz / 2)) < nx / 3) + 9 * (x % 3)).astype("u1")
        self.compress(samples, ["--psnr", "40", "--labels", "no"], output="source.cvol")
        return self.path("source.cvol")

    def rendered(self, r):
        source = self.source(r)
        self.call(self.cvol, "render", source, "-o", self.path("file.cvi"), "--engine", "transform", "--size",
                  f"{r.randint(1, 40)}x{r.randint(1, 40)}", "--azimuth", str(r.randint(0, 360)), "--elevation",
                  str(r.randint(-90, 90)), "--psnr", f"{r.uniform(20, 50):.3g}", "--background",
                  ",".join(f"{r.random():.2f}" for _ in range(3)))

    def baked(self, r):
        source = self.source(r)
        self.call(self.cvol, "bake", source, "-o", self.path("file.cvol"), "--axis", r.choice("xyz"), "--tile",
                  str(r.choice((0, 8, 16, 32))), "--rho", f"{r.uniform(0.02, 1):.3g}", "--transfer",
                  r.choice(("gray", "bone", "hot", "viridis")), "--footprint", r.choice(("gaussian", "sinc", "box")),
                  "--footprint-size", str(r.choice((3, 5))), *r.choice(([], ["--shade"])))

    KINDS = {"volume": 12, "labels": 2, "array": 4, "series": 2, "terms": 3, "picture": 3, "rendered": 1, "baked": 2}

    def make(self, r):
        """Returns the kind and the bytes of a random file."""
        kind = r.choices(list(self.KINDS), list(self.KINDS.values()))[0]
        while True:
            for name in os.listdir(self.folder):
                os.remove(self.path(name))
            self.commands = []
            try:
                getattr(self, kind)(r)
                return kind, self.made_file()
            except Refused:
                self.refused += 1

    def make_again(self, instructions):
        """Returns the bytes of the same file, made with another instruction set."""
        commands, self.commands = self.commands, []
        for command in commands:
            self.call(*command, instructions=instructions)
        return self.made_file()

    def made_file(self):
        """Returns the bytes of the output of the last command."""
        name = next(name for name in ("file.cvi", "file.cvol") if os.path.exists(self.path(name)))
        with open(self.path(name), "rb") as file:
            return file.read()


def environment(instructions):
    return {**os.environ, "CVOL_CPU": instructions} if instructions else None


def png(pixels):
    height, width, count = pixels.shape
    rows = b"".join(b"\0" + row.tobytes() for row in pixels)

    def chunk(tag, data):
        return struct.pack(">I", len(data)) + tag + data + struct.pack(">I", zlib.crc32(tag + data))
    head = struct.pack(">2I5B", width, height, 8, 2 if count == 3 else 6, 0, 0, 0)
    return (b"\x89PNG\r\n\x1a\n" + chunk(b"IHDR", head) + chunk(b"IDAT", zlib.compress(rows))
            + chunk(b"IEND", b""))


# ---- the reference decoder -------------------------------------------------------------------------------------------

class Recorder:
    """Notes what the reference decoder does not return: the samples before rounding, and the largest ones."""

    def __init__(self):
        self.real, self.is_exact, self.peak, self.header = None, False, 0.0, None
        self.functions = {name: getattr(ref, name) for name in ("finish", "corrected", "inverse")}
        ref.finish, ref.corrected, ref.inverse = self.finish, self.corrected, self.inverse

    def start(self):
        self.real, self.is_exact, self.peak = None, False, 0.0

    def finish(self, header, samples):
        self.header, self.real = header, samples + header.offset
        self.peak = max(float(np.abs(samples).max()), abs(header.offset))
        return self.functions["finish"](header, samples)

    def corrected(self, *arguments):
        self.is_exact = True
        return self.functions["corrected"](*arguments)

    def inverse(self, transform, slots):
        out = self.functions["inverse"](transform, slots)
        self.peak = max(self.peak, float(np.abs(out).max()))
        return out

    def bounds(self):
        """Returns the least and largest samples that rounding errors explain."""
        header, error = self.header, PRECISION * self.peak + LEAST
        finish = self.functions["finish"]
        return [finish(header, self.real - header.offset + way * error) for way in (-1, 1)]


class Late(Exception):
    """The reference decoder takes too long."""


def on_alarm(_signal, _frame):
    raise Late()


class Place(collections.namedtuple("Place", "level time channel", defaults=(0, 0, 0))):
    """What is decoded of a file."""

    def options(self, data):
        """Returns the options of the command; those of series only for a series."""
        names = self._fields if data[12:16] == b"LIST" else self._fields[:1]
        return [word for name, number in zip(names, self) if number for word in ("--" + name, str(number))]


def decode_reference(recorder, data, place):
    """Returns the samples, or None if the file is refused."""
    recorder.start()
    signal.alarm(REFERENCE_SECONDS)
    try:
        with np.errstate(all="ignore"):
            if data[12:16] == b"PICT":
                return ref.read_picture(data)[1]
            if data[12:16] == b"BAKE":
                return ref.read_baked(data)[1]
            if data[12:16] == b"LIST":
                data, _ = ref.read_volume_of(data, place.time, place.channel, place.level)
            return ref.decode(data, place.level)[2]
    except (ref.Damaged, KeyError) as error:
        return str(error) or "damaged"
    finally:
        signal.alarm(0)


def decode_library(maker, data, place, instructions=None):
    """Returns the bytes of the samples, or a sentence if the file is refused."""
    path, out = maker.path("in.cvol"), maker.path("out.raw")
    with open(path, "wb") as file:
        file.write(data)
    if os.path.exists(out):
        os.remove(out)
    planes = data[12:16] in (b"PICT", b"BAKE")
    command = ([os.path.join(maker.helpers, "decode_planes"), path, out] if planes else
               [maker.cvol, "decompress", path, out, "--threads", "1", *place.options(data)])
    done = subprocess.run(command, capture_output=True, text=True, timeout=COMMAND_SECONDS,
                          env=environment(instructions))
    if done.returncode == 0:
        with open(out, "rb") as file:
            return file.read()
    if done.returncode != 1 or not done.stderr.strip() or os.path.exists(out):
        raise RuntimeError(f"status {done.returncode}: {done.stderr}")
    return done.stderr.strip()


# ---- comparison ------------------------------------------------------------------------------------------------------

def differences(recorder, data, wanted, found):
    """Returns a sentence if the samples differ."""
    found = np.frombuffer(found, np.uint8)
    if found.size != wanted.nbytes:
        return f"{found.size} bytes instead of {wanted.nbytes}"
    same = (found.reshape(-1, wanted.itemsize) ==
            np.ascontiguousarray(wanted).view(np.uint8).reshape(-1, wanted.itemsize)).all(1)
    found, wanted = found.view(wanted.dtype), wanted.reshape(-1)
    if data[12:16] == b"PICT":
        error = 1 + 255 * PRECISION * recorder.peak
        same |= np.abs(found.astype(float) - wanted) <= error
    elif data[12:16] == b"BAKE":
        same |= np.abs(found.astype(float) - wanted) <= PRECISION * recorder.peak
    elif not recorder.is_exact:
        least, most = (bound.reshape(-1) for bound in recorder.bounds())
        same |= (least <= found) & (found <= most)
    if same.all():
        return None
    at = int(np.argmin(same))
    return f"{np.count_nonzero(~same)} samples differ; sample {at} is {found[at]} instead of {wanted[at]}"


def is_large(data):
    """Tests if a file states more samples than the reference decoder can decode in seconds."""
    try:
        sections = {tag: content for tag, _, content in damage.parse(data)}
        if b"PACK" in sections:
            sections = {tag: content for tag, _, content in damage.parse(ref.unpack_file(data))}
        if b"PICT" in sections:
            width, height, p, q = struct.unpack_from("<4I", sections[b"PICT"])
            return max(width * height, p * q) > SAMPLES
        x, y, z = struct.unpack_from("<3I", sections[b"BAKE"]) if b"BAKE" in sections else struct.unpack_from(
            "<3Q", sections[b"HEAD"])
        return x * y * z > SAMPLES
    except (ref.Damaged, struct.error, KeyError):
        return False  # both decoders must refuse it early


class Comparison:
    def __init__(self, build, folder, keep):
        self.maker, self.keep = Maker(build, folder), keep
        self.recorder = Recorder()
        self.counts = collections.defaultdict(collections.Counter)
        self.disagreements = 0

    def report(self, name, data, what):
        self.disagreements += 1
        path = os.path.join(self.keep, "differs-" + name.removesuffix(".cvol") + ".cvol")
        with open(path, "wb") as file:
            file.write(data)
        print(f"{name}: {what}; {path}; made by: {' '.join(self.maker.made)}", flush=True)

    def compare(self, name, kind, data, place, is_damaged):
        count = self.counts[kind]
        if is_large(data):
            count["not compared"] += 1
            return
        try:
            wanted = decode_reference(self.recorder, data, place)
        except Late:
            count["not compared"] += 1
            return
        except Exception as error:  # pylint: disable=broad-except
            self.report(name, data, f"{' '.join(place.options(data))}: the reference decoder stops with {error!r}")
            return
        try:
            found = decode_library(self.maker, data, place)
        except (RuntimeError, subprocess.TimeoutExpired) as error:
            self.report(name, data, f"{' '.join(place.options(data))}: the command stops: {error}")
            return
        refused = [isinstance(x, str) for x in (wanted, found)]
        what = None
        if refused == [True, True]:
            count["refused"] += 1
        elif refused == [True, False]:
            what = f"only the reference decoder refuses it: {wanted}"
        elif refused == [False, True]:
            what = f"only the library refuses it: {found}"
        else:
            what = differences(self.recorder, data, wanted, found)
            count["damaged, decoded" if is_damaged else "decoded"] += 1
        if what is None and not is_damaged and refused[0]:
            what = f"both refuse it: {found}"
        if what:
            self.report(name, data, f"{' '.join(place.options(data))}: {what}")

    def compare_instructions(self, name, kind, data, place):
        """Compares the instruction sets: the bytes of the file, and its samples."""
        wanted = decode_library(self.maker, data, place)
        for instructions in INSTRUCTIONS:
            what = None
            if self.maker.make_again(instructions) != data:
                what = "another file"
            elif decode_library(self.maker, data, place, instructions) != wanted:
                what = "other samples"
            if what:
                self.report(f"{name}-{instructions}", data, f"{kind}: CVOL_CPU={instructions} gives {what}")
            self.counts[kind]["by instruction sets"] += 1

    def compare_all(self, name, data):
        """Compares a file at full resolution and at coarse levels, and its last volume."""
        for level in (0,) if data[12:16] in (b"PICT", b"BAKE") else (0, 1, 3):
            self.compare(name, "file", data, Place(level), True)
        if data[12:16] == b"LIST":
            times, channels = struct.unpack_from("<2I", data, 36)
            self.compare(name, "file", data, Place(3, times - 1, channels - 1), True)

    def place(self, r, kind, data):
        level = r.choice((0, 0, 1, 2, 3)) if kind in ("volume", "labels", "terms", "series") else 0
        if data[12:16] != b"LIST":
            return Place(level)
        times, channels = struct.unpack_from("<2I", data, 36)
        return Place(level, r.randrange(times), r.randrange(channels))

    def try_seed(self, seed):
        r = random.Random(seed)
        try:
            kind, data = self.maker.make(r)
        except (RuntimeError, subprocess.TimeoutExpired) as error:
            self.report(f"{seed}", b"", f"no file: {error}")
            return
        self.counts[kind]["files"] += 1
        place = self.place(r, kind, data)
        self.compare(f"{seed}", kind, data, place._replace(level=0), False)
        if place.level:
            self.compare(f"{seed}-level", kind, data, place, False)
        if data[12:16] == b"PACK":
            self.compare(f"{seed}-unpacked", kind, ref.unpack_file(data), place, False)
        self.compare_instructions(f"{seed}", kind, data, place)
        for i in range(DAMAGES):
            self.compare(f"{seed}-damage{i}", kind, damage.damage(ref, r, data), self.place(r, kind, data), True)

    def print_counts(self):
        columns = "files", "by instruction sets", "decoded", "damaged, decoded", "refused", "not compared"
        print("| " + " | ".join(("kind", *columns)) + " |")
        print("|---" + "|---:" * len(columns) + "|")
        total = collections.Counter()
        for kind, count in sorted(self.counts.items()):
            total += count
            print("| " + " | ".join([kind] + [str(count[column]) for column in columns]) + " |")
        print("| " + " | ".join(["all"] + [str(total[column]) for column in columns]) + " |")


def main():
    if len(sys.argv) < 2:
        sys.exit(__doc__)
    build, arguments = os.path.abspath(sys.argv[1]), sys.argv[2:]
    os.environ["OMP_WAIT_POLICY"] = "passive"
    signal.signal(signal.SIGALRM, on_alarm)
    with tempfile.TemporaryDirectory(prefix="cvol-differential-") as folder:
        if arguments and os.path.exists(arguments[0]):
            comparison = Comparison(build, folder, tempfile.gettempdir())
            for path in arguments:
                with open(path, "rb") as file:
                    comparison.compare_all(os.path.basename(path), file.read())
        else:
            first, count, seconds = (int(x) for x in (arguments + ["1", "100", "0"][len(arguments):])[:3])
            keep = arguments[3] if len(arguments) > 3 else tempfile.gettempdir()
            comparison, begin, seed = Comparison(build, folder, keep), time.monotonic(), first
            while seed < first + count and not (seconds and time.monotonic() - begin >= seconds):
                comparison.try_seed(seed)
                seed += 1
            print(f"differential: seeds {first} to {seed - 1}, {time.monotonic() - begin:.0f} s, "
                  f"{comparison.disagreements} disagreements; "
                  f"{comparison.maker.refused} invalid options")
        comparison.print_counts()
    sys.exit(1 if comparison.disagreements else 0)


if __name__ == "__main__":
    main()
