#!/usr/bin/env python3
"""Fingerprints of cvol's behaviour: the CRC-32C of files and pictures from many commands.

usage: tests/fingerprint.py CVOL > before.txt        prints a line for each command
       tests/fingerprint.py CVOL before.txt          compares; exit 1 if a line differs

A change that must not alter results prints the same lines before and after. The lines depend on the
instruction set where cvol states that results may (pictures and algebra); compare on one machine.
"""
import array
import gzip
import math
import os
import subprocess
import sys
import tempfile

TABLE = []
for byte in range(256):
    for _ in range(8):
        byte = byte >> 1 ^ (0x82F63B78 if byte & 1 else 0)
    TABLE.append(byte)


def crc32c(data):
    crc = 0xFFFFFFFF
    for byte in data:
        crc = crc >> 8 ^ TABLE[(crc ^ byte) & 255]
    return crc ^ 0xFFFFFFFF


def brain(folder, root):
    """Crops the sample scan to 96x112x80 voxels."""
    with gzip.open(os.path.join(root, "samples", "ch2better.nii.gz")) as f:
        data = f.read()[352:]
    nx, ny = 301, 370
    out = bytearray()
    for z in range(120, 200):
        for y in range(80, 192):
            start = 60 + nx * (y + ny * z)
            out += data[start : start + 96]
    with open(os.path.join(folder, "head.raw"), "wb") as f:
        f.write(out)
    return out


def synthetic(folder):
    """Writes a smooth int16 field with noise, a float32 field with NaN, and labels."""
    state = 12345
    ints, floats, labels = array.array("h"), array.array("f"), bytearray()
    for z in range(40):
        for y in range(52):
            for x in range(60):
                state = (state * 1103515245 + 12345) & 0x7FFFFFFF
                r = math.hypot(x - 30, y - 26, (z - 20) * 1.3)
                value = 900 * math.exp(-r * r / 300) + 80 * math.sin(x / 5) * math.cos(y / 7)
                ints.append(int(value) + (state >> 16) % 7 - 1000)
                floats.append(math.nan if r > 33 else value * 1e-3)
                labels.append(3 if r < 9 else 7 if r < 15 and x < 30 else 0)
    for name, data in (("ct", ints.tobytes()), ("field", floats.tobytes()), ("labels", bytes(labels))):
        with open(os.path.join(folder, name + ".raw"), "wb") as f:
            f.write(data)


HEAD = "head.raw --dims 96x112x80 --type uint8"
CT = "ct.raw --dims 60x52x40 --type int16 --spacing 1,1,1.3"
FIELD = "field.raw --dims 60x52x40 --type float32"

COMPRESS = {
    "head": HEAD,
    "head-bpv": HEAD + " --bpv 0.5",
    "head-psnr": HEAD + " --psnr 45",
    "head-psnr-fast": HEAD + " --psnr 45 --effort fast",
    "head-error": HEAD + " --max-error 3",
    "head-lossless": HEAD + " --lossless",
    "head-small": HEAD + " --psnr 40 --effort max",
    "head-no-lap": HEAD + " --no-lap --ratio 20",
    "head-background": HEAD + " --background 0 --psnr 42",
    "head-plain": HEAD + " --background none --ratio 10",
    "head-bricks": HEAD + " --bricks 32,32,16 --psnr 44",
    "head-stream": HEAD + " --stream --ratio 30 --force",
    "head-block-8": HEAD + " --block 8 --no-lap --ratio 12",
    "head-block-32": HEAD + " --block 32 --no-lap --ratio 12",
    "ct": CT,
    "ct-b": CT + " --psnr 55 --no-lap",
    "ct-error": CT + " --max-error 2 --psnr 60",
    "ct-lossless": CT + " --lossless",
    "ct-whole": CT + " --block 0 --transform dct --keep 12,4000",
    "ct-whole-dft": CT + " --block 0 --transform dft --keep 8,3000",
    "ct-whole-dht": CT + " --block 0 --transform dht --keep 8,3000",
    "ct-dht-blocks": CT + " --transform dht --ratio 8",
    "field": FIELD + " --fill nan --psnr 50",
    "field-error": FIELD + " --fill nan --max-error 0.001",
    "field-lossless": FIELD + " --fill nan --lossless",
    "labels": "labels.raw --dims 60x52x40 --type uint8",
}
VIEW = " --size 160 --azimuth 35 --elevation 20"
SHEET = {
    "front": " --size 160",
    "auto": VIEW,
    "object-order": VIEW + " --ray-order object",
    "image-order": VIEW + " --ray-order image",
    "opaque": VIEW + " --opacity-scale 5",
    "clear": VIEW + " --opacity-scale 0.1",
    "lit": VIEW + " --shade",
    "lit-lattice": VIEW + " --shade --ray-order object --light 1,-1,1",
    "lit-gradient": VIEW + " --shade --gradient-opacity 4",
    "bone": VIEW + " --transfer bone --shade",
    "iso": VIEW + " --mode iso --iso 90",
    "mip": VIEW + " --mode mip",
    "min": VIEW + " --mode min",
    "xray": VIEW + " --mode xray",
    "perspective": " --size 160 --perspective 60 --azimuth 200 --zoom 1.4",
    "inside": " --size 160 --perspective 80 --eye 5,-10,3 --look-at 0,20,0 --up 0,0,1 --shade",
    "clip": VIEW + " --clip ,50%:,",
    "clip-plane": VIEW + " --clip-plane 1,1,0,0 --shade",
    "zoomed": VIEW + " --zoom 5",
    "small": " --size 40 --azimuth 10",
    "level-1": VIEW + " --level 1",
    "level-3": VIEW + " --level 3 --shade",
    "b-spline": VIEW + " --footprint b-spline",
    "catmull-rom": VIEW + " --footprint catmull-rom",
    "gaussian": VIEW + " --footprint gaussian",
    "step": VIEW + " --step 0.5",
    "oversample": VIEW + " --oversample 2",
    "bits-16": VIEW + " --bits 16",
}
OTHER = {
    "ray": VIEW + " --engine ray --shade",
    "ray-iso": VIEW + " --engine ray --mode iso --iso 90",
    "splat": VIEW + " --engine splat",
    "splat-lit": VIEW + " --engine splat --shade --footprint sinc",
    "fourier": VIEW + " --engine fourier --mode xray",
    "fourier-cue": VIEW + " --engine fourier --mode xray --depth-cue 0.7 --rho 0.05",
    "spectral": " --size 96 --engine transform",
    "spectral-literal": " --size 64 --engine transform --schedule literal --tile 0",
    "spectral-dht": " --size 64 --engine transform --tile 0 --spectrum dht",
    "annotate": VIEW + " --annotate",
}
ALGEBRA = {
    "add": "add ct.cvol ct-b.cvol --alpha 0.5 --beta -2",
    "add-blocks": "add ct-b.cvol ct-b.cvol",
    "multiply": "multiply ct.cvol ct.cvol",
    "multiply-no-lap": "multiply ct-b.cvol ct-b.cvol",
    "multiply-whole": "multiply ct-whole.cvol ct-whole.cvol",
    "multiply-grid": "multiply ct-whole-dft.cvol ct-whole-dft.cvol --plan grid",
    "multiply-direct": "multiply ct-whole-dht.cvol ct-whole-dht.cvol --plan direct --keep 6,100",
    "multiply-sparse": "multiply ct-whole-dft.cvol ct-whole-dft.cvol --plan sparse --keep 2,200",
    "convolve": "convolve ct.cvol --kernel gaussian:1.5",
    "convolve-no-lap": "convolve ct-b.cvol --kernel unsharp:1.5,0.7",
    "convolve-whole": "convolve ct-whole.cvol --kernel box:3",
    "derivative": "convolve ct-b.cvol --kernel derivative:x",
    "scale": "scale ct.cvol --factor 2 --offset 3",
    "gradient": "gradient ct-b.cvol",
    "gradient-whole": "gradient ct-whole.cvol",
    "gradient-lapped": "gradient ct.cvol",
}


def commands():
    for name, options in COMPRESS.items():
        first, _, rest = options.partition(" ")
        yield "compress " + name, f"compress {first} {name}.cvol {rest}", name + ".cvol", {}
    for name in COMPRESS:
        yield "decompress " + name, f"decompress {name}.cvol {name}.npy", name + ".npy", {}
    for name, target in (("ratio", "--ratio 90 --force"), ("psnr", "--psnr 38"), ("bricks", "--bricks 32")):
        yield "transcode " + name, f"transcode head-psnr.cvol t-{name}.cvol {target}", f"t-{name}.cvol", {}
    for name, line in ALGEBRA.items():
        yield "algebra " + name, f"{line} -o a-{name}.cvol", f"a-{name}.cvol", {}
    for cpu in ("base", "avx2", "avx512"):
        for source in ("head-psnr", "ct-lossless", "head-no-lap"):
            for name, options in SHEET.items():
                if source != "head-psnr" and name not in ("auto", "lit", "mip", "lit-lattice", "xray"):
                    continue
                out = f"{cpu}-{source}-{name}.png"
                options = options.replace("--iso 90", "--iso -300") if source.startswith("ct") else options
                yield f"render {cpu} {source} {name}", f"render {source}.cvol -o {out}{options}", out, {"CVOL_CPU": cpu}
        for name, options in OTHER.items():
            out = f"{cpu}-{name}.png"
            yield f"render {cpu} {name}", f"render head-psnr.cvol -o {out}{options}", out, {"CVOL_CPU": cpu}
        yield f"compress {cpu}", f"compress {HEAD.replace(' ', f' {cpu}.cvol ', 1)}", f"{cpu}.cvol", {"CVOL_CPU": cpu}
    yield "render times", "render field-error.cvol -o depth.png --size 96 --depth depth.pfm", "depth.pfm", {}
    yield "render masked", "render field.cvol -o masked.png --size 128 --azimuth 20", "masked.png", {}
    yield "render labels", "render labels.cvol -o labels.png --size 128 --azimuth 20", "labels.png", {}


def main():
    cvol = os.path.abspath(sys.argv[1])
    root = os.path.join(os.path.dirname(os.path.abspath(__file__)), "..")
    before = {}
    if len(sys.argv) > 2:
        with open(sys.argv[2]) as f:
            before = dict(line.rstrip("\n").split("\t") for line in f)
    differ = []
    with tempfile.TemporaryDirectory() as folder:
        brain(folder, root)
        synthetic(folder)
        for name, line, out, settings in commands():
            done = subprocess.run([cvol, *line.split()], cwd=folder, capture_output=True, text=True,
                                  env={**os.environ, **settings})
            path = os.path.join(folder, out)
            if os.path.exists(path):
                with open(path, "rb") as f:
                    data = f.read()
                result = f"{crc32c(data):08x} {len(data)}"
            else:
                result = "none: " + (done.stderr.strip().split("\n")[-1])
            print(f"{name}\t{result}")
            if before and before.get(name) != result:
                differ.append(f"{name}: {before.get(name)} before, {result} now")
    if before:
        print("\n".join(differ) or "the same", file=sys.stderr)
    return 1 if differ else 0


if __name__ == "__main__":
    sys.exit(main())
