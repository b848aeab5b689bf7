"""Small volumes for pictures, and their compressed files."""
import array
import math
import os
import random
import re
import subprocess

SHAPE = (37, 29, 21)  # x, y, z: no side is a multiple of 16
SPACING = (1.0, 1.3, 1.7)
NONE = 1e35
# Name: the samples' type, the largest value, noise, compression options, and the marker of missing samples.
FILES = {
    "exact-float": ("f", 1000, 0, "--lossless", None),
    "exact-uint8": ("B", 250, 0, "--lossless --block 8", None),
    "exact-bricks": ("h", 1000, 0.01, "--lossless --bricks 32 --no-lap", None),
    "bounded": ("h", 1000, 0.03, "--max-error 2", None),
    "lossy-float": ("f", 1000, 0, "--psnr 75", None),
    "lossy-block-8": ("f", 1000, 0.01, "--psnr 75 --block 8 --no-lap", None),
    "lossy-int16": ("h", 1000, 0.03, "--psnr 60 --fast", None),
    "smallest": ("f", 1000, 0, "--psnr 70 --smallest", None),
    "masked-exact": ("f", 1000, 0, "--lossless --fill %g" % NONE, NONE),
    "masked-nan": ("f", 1000, 0.01, "--psnr 75 --fill nan", math.nan),
    "masked-int16": ("h", 1000, 0, "--lossless --fill -5", -5),
}
EXACT = [name for name in FILES if "--lossless" in FILES[name][3]]
# The least PSNR of lossy files, relative to the range 0 to the largest value.
CODED = {name: float(FILES[name][3].split()[1]) for name in FILES if "--psnr" in FILES[name][3]}
CODED["bounded"] = 54  # an error of 2 in 1000
NRRD = {"f": "float", "h": "short", "B": "uchar"}


def scaled(text, name):
    """Returns the options of a file; values in braces are on a scale of 0 to 1000."""
    return re.sub(r"\{(\d+)\}", lambda m: "%g" % (int(m.group(1)) * FILES[name][1] / 1000), text)


def _tubes():
    """Returns the distance of samples from the nearest of three curves, if it is less than three."""
    nx, ny, nz = SHAPE
    near = {}
    for k in range(3):
        for i in range(80):
            t = i / 79
            at = 2 + 32 * t, 14 + 11 * math.sin(3 * t + 2 * k), 10 + 8 * math.cos(4 * t + k)
            low = [max(0, math.ceil(c) - 2) for c in at]
            for z in range(low[2], min(nz, low[2] + 4)):
                for y in range(low[1], min(ny, low[1] + 4)):
                    for x in range(low[0], min(nx, low[0] + 4)):
                        place = x + nx * (y + ny * z)
                        near[place] = min(near.get(place, 9), math.dist((x, y, z), at))
    return near


def samples(kind, most, noise, hole):
    """Three vessels two samples wide, two smooth balls, and a wavy slab, on an empty or noisy background. x
    fastest."""
    nx, ny, nz = SHAPE
    draw = random.Random(7)
    values = []
    for z in range(nz):
        for y in range(ny):
            for x in range(nx):
                ball = 0.45 * math.exp(-((x - 11) ** 2 + (y - 10) ** 2 + 2 * (z - 9) ** 2) / 30)
                ball += 0.8 * math.exp(-((x - 27) ** 2 + (y - 20) ** 2 + (z - 13) ** 2) / 18)
                slab = 0.15 + 0.08 * math.sin(x / 3) * math.cos(y / 4) if z < 3 and x > 8 else 0
                value = max(ball, slab)
                values.append((value if value > 0.02 else 0) + noise * draw.random())
    for place, distance in _tubes().items():
        values[place] = max(values[place], 0.95 * math.exp(-distance * distance / 1.6) - 0.02)
    values = [most * v for v in values]
    if kind != "f":
        values = [round(v) for v in values]
    if hole is not None:  # a ball, and a corner with a complete block of side 8
        for z in range(nz):
            for y in range(ny):
                for x in range(nx):
                    if (x - 20) ** 2 + (y - 12) ** 2 + (z - 14) ** 2 < 40 or (x > 26 and y < 10 and z < 11):
                        values[x + nx * (y + ny * z)] = hole
    return array.array(kind, values)


def write_nrrd(path, kind, data, shape=SHAPE):
    with open(path, "wb") as file:
        file.write(("NRRD0004\ntype: %s\ndimension: 3\nsizes: %d %d %d\nspacings: %g %g %g\nendian: little\n"
                    "encoding: raw\n\n" % ((NRRD[kind],) + shape + SPACING)).encode())
        file.write(data.tobytes())


def make(cvol, folder, name):
    """Writes NAME.nrrd; its compressed NAME.cvol; NAME-L.nrrd, decompressed at levels 0 and up; and, losslessly,
    NAME-again.cvol of NAME-0.nrrd (with another block side if NAME.cvol is exact) and NAME-original.cvol of
    NAME.nrrd; if NAME.cvol is exact, also NAME-bricks.cvol, in other bricks."""
    kind, most, noise, options, hole = FILES[name]
    path = os.path.join(folder, name)
    write_nrrd(path + ".nrrd", kind, samples(kind, most, noise, hole))
    fill = [] if hole is None else ["--fill", "%g" % hole]
    block = ["--block", "8"] if "--block 8" in options else []
    lap = ["--no-lap"] if "--no-lap" in options else []
    other = (["--block", "16"] if block else ["--block", "8"]) if name in EXACT else block + lap
    commands = [["compress", path + ".nrrd", path + ".cvol", "--labels", "no"] + options.split()]
    for level in "0123":
        commands.append(["decompress", path + ".cvol", "%s-%s.nrrd" % (path, level), "--level", level])
    commands += [["compress", path + "-0.nrrd", path + "-again.cvol", "--lossless"] + other + fill,
                 ["compress", path + ".nrrd", path + "-original.cvol", "--lossless"] + block + lap + fill]
    if name in EXACT:
        commands.append(["compress", path + ".nrrd", path + "-bricks.cvol", "--labels", "no"] + options.split()
                        + ["--bricks", "32" if "--bricks" not in options else "64"])
    for command in commands:
        subprocess.run([cvol] + command + ["--threads", "1"], check=True, capture_output=True, timeout=120)


def make_tiny(cvol, folder):
    """Writes tiny.nrrd and tiny.cvol for refused options, and overlay.nrrd, which covers a part of all volumes."""
    shape = (11, 10, 9)
    data = array.array("f", [500 + 400 * math.sin(i) for i in range(11 * 10 * 9)])
    path = os.path.join(folder, "tiny")
    write_nrrd(path + ".nrrd", "f", data, shape)
    subprocess.run([cvol, "compress", path + ".nrrd", path + ".cvol", "--lossless"], check=True, capture_output=True)
    shape = (20, 18, 12)
    data = array.array("f", [max(0, 9 - math.dist((x, y, z), (8, 9, 5))) for z in range(12) for y in range(18)
                             for x in range(20)])
    write_nrrd(os.path.join(folder, "overlay.nrrd"), "f", data, shape)
