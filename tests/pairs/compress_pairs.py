"""usage: compress_pairs.py CVOL FOLDER [SEED [PARTS]]

Tests every pair of choices of type, kind of volume, target and options of `cvol compress`: the command writes a
file that meets its target and is no larger than the lossless file, or prints one sentence and writes no file.
PARTS: one of PARTS rows is tested; the variable CVOL_TURN decides which (scripts/check.sh)."""
import json
import math
import os
import subprocess
import sys

import pairwise
import volumes

AXES = {
    "type": list(volumes.TYPES),
    "kind": list(volumes.KINDS),
    "target": ["", "--ratio 4", "--ratio 40", "--bpv 3", "--psnr 30", "--psnr 60", "--max-error 0.5",
               "--max-error 3 --psnr 50", "--lossless"],
    "fill": ["", "--fill %d" % volumes.FILL, "--fill nan"],
    "background": ["", "--background none", "--background 0"],
    "block": ["", "--block 8", "--block 32"],
    "lap": ["", "--no-lap"],
    "effort": ["", "--effort fast", "--effort max"],
    "labels": ["", "--labels no"],
    "bricks": ["", "--bricks 32"],
    "force": ["", "--force"],
}


class Failure(Exception):
    pass


def run(arguments):
    done = subprocess.run(arguments, capture_output=True, text=True, timeout=300)
    return done.returncode, done.stdout, done.stderr


def check_refusal(code, text, path):
    """Expects one sentence that begins with the command's name, and no new file."""
    sentences = [line for line in text.strip().split("\n") if line]
    if code not in (1, 2) or len(sentences) != 1 or not sentences[0].startswith("cvol: ") or len(sentences[0]) < 15:
        raise Failure("exit %d with %r" % (code, text))
    if os.path.exists(path):
        raise Failure("a file in spite of %r" % text)


def errors(original, decoded, spared):
    """Returns the largest error, and the PSNR relative to the range, over samples that have a value."""
    most = squares = 0.0
    lo, hi, count = math.inf, -math.inf, 0
    for a, b in zip(original, decoded):
        if spared(a):
            if not (a == b or (a != a and b != b)):
                raise Failure("a sample without a value, %r, came back as %r" % (a, b))
            continue
        off = abs(a - b)
        if not off < math.inf:
            raise Failure("%r came back as %r" % (a, b))
        most, lo, hi, count = max(most, off), min(lo, a), max(hi, a), count + 1
    span = hi - lo if count else 0
    if most == 0 or span == 0:
        return most, math.inf
    for a, b in zip(original, decoded):
        if not spared(a):
            squares += ((a - b) / span) ** 2
    return most, -10 * math.log10(squares / len(original)) if squares else math.inf


def check_file(cvol, row, path, report, original, folder):
    back = os.path.join(folder, "back.raw")
    code, _, text = run([cvol, "decompress", path, back])
    if code:
        raise Failure("decompress: %s" % text)
    decoded = type(original)(original.typecode)
    with open(back, "rb") as file:
        decoded.frombytes(file.read())
    if len(decoded) != len(original):
        raise Failure("%d samples of %d came back" % (len(decoded), len(original)))
    fill = float(row["fill"].split()[1]) if row["fill"] else None
    spared = lambda v: v != v or (fill is not None and v == fill)
    if fill is not None and fill == fill:  # the fill value replaces NaN too
        original = type(original)(original.typecode, [fill if v != v else v for v in original])
    most, psnr = errors(original, decoded, spared)
    exact = report["exact"]
    if exact and decoded.tobytes() != original.tobytes():
        raise Failure("reported as exact, but the largest error is %g" % most)
    if not exact and abs(most - report["max_error"]) > 1e-6 * most:
        raise Failure("largest error %g, reported as %g" % (most, report["max_error"]))
    words = row["target"].split()
    asked = dict(zip(words[::2], words[1::2]))
    if row["target"] == "--lossless" and not exact:
        raise Failure("not lossless")
    if not (row["force"] or exact or "--psnr" in asked or "--max-error" in asked) and psnr < 25 - 1e-3:
        raise Failure("%.3f dB, without --force" % psnr)
    if "--psnr" in asked and psnr < float(asked["--psnr"]) - 1e-3 and report["target_met"]:
        raise Failure("%.3f dB" % psnr)
    if "--max-error" in asked and most > float(asked["--max-error"]):
        raise Failure("largest error %g" % most)
    if "--ratio" in asked and report["target_met"] and report["ratio"] < float(asked["--ratio"]):
        raise Failure("ratio %g" % report["ratio"])
    return os.path.getsize(path)


def allowed(row):
    """Returns whether the row has no options that exclude each other according to the command's help."""
    bounded = "--max-error" in row["target"] or row["target"] == "--lossless"
    if row["kind"] == "nan" and not volumes.is_float(row["type"]):
        return False
    if row["background"] == "--background 0" and (row["fill"] or bounded or row["type"] not in ("uint8", "float32")):
        return False
    return row["effort"] != "--effort max" or not (bounded or row["fill"] or row["block"])


def try_row(cvol, row, folder):
    """Returns whether the command wrote a file."""
    original = volumes.samples(row["type"], row["kind"], 5)
    raw, path = os.path.join(folder, "v.raw"), os.path.join(folder, "v.cvol")
    with open(raw, "wb") as file:
        file.write(original.tobytes())
    if os.path.exists(path):
        os.remove(path)
    shape = ["--dims", "x".join(map(str, volumes.SHAPE)), "--type", row["type"]]
    options = [w for axis in AXES if axis not in ("type", "kind") for w in row[axis].split()]
    code, text, complaint = run([cvol, "compress", raw, path, "--json"] + shape + options)
    if code:
        check_refusal(code, complaint, path)
        return 0
    size = check_file(cvol, row, path, json.loads(text), original, folder)
    plain = [w for axis in ("fill", "block", "lap", "bricks") for w in row[axis].split()]
    plain += row["effort"].split() if row["effort"] == "--effort fast" else []
    lossless = os.path.join(folder, "lossless.cvol")
    code, _, complaint = run([cvol, "compress", raw, lossless, "--json", "--lossless"] + shape + plain)
    if code:
        check_refusal(code, complaint, path + "-")
    elif size > os.path.getsize(lossless):
        raise Failure("%d bytes, lossless %d" % (size, os.path.getsize(lossless)))
    return 1


def main():
    cvol, folder = sys.argv[1:3]
    seed = int(sys.argv[3]) if len(sys.argv) > 3 else 1
    os.makedirs(folder, exist_ok=True)
    made, left_out = pairwise.rows(AXES, seed, allowed)
    parts = int(sys.argv[4]) if len(sys.argv) > 4 else 1
    part = int(os.environ.get("CVOL_TURN", "0")) % parts
    made = made[part::parts]
    files = failures = 0
    for row in made:
        try:
            files += try_row(cvol, row, folder)
        except (Failure, subprocess.TimeoutExpired, OverflowError) as failure:
            failures += 1
            print("FAILED: %s: %s" % (" ".join(v or "-" for v in row.values()), failure))
    print("seed %d, part %d of %d: %d rows, %d files, %d refusals, %d failures; %d pairs that cannot be" %
          (seed, part + 1, parts, len(made), files, len(made) - files - failures, failures, len(left_out)))
    many = len(made) >= 20  # of a few rows most may be refused
    return failures > 0 or (many and files < len(made) / 3)


if __name__ == "__main__":
    sys.exit(main())
