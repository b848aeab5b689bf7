"""Small volumes of every type and kind, as raw files; uses only Python's standard library."""
import array
import math
import random

SHAPE = (37, 22, 19)  # x, y, z: no side is a multiple of 16
TYPES = {"uint8": "B", "int8": "b", "uint16": "H", "int16": "h", "uint32": "I", "int32": "i",
         "float32": "f", "float64": "d"}
RANGES = {"uint8": (0, 255), "int8": (-128, 127), "uint16": (0, 65535), "int16": (-32768, 32767),
          "uint32": (0, 4e9), "int32": (-2e9, 2e9)}
KINDS = ("smooth", "noise", "sparse", "labels", "constant", "outlier", "tiny", "huge", "nan", "half masked")
FILL = 100  # marker in half-masked volumes


def is_float(kind_of):
    return kind_of.startswith("float")


def _value(kind, draw, x, y, z):
    """Returns one sample, about -1 .. 1."""
    wave = 0.6 * math.sin(x / 5 + y / 7) * math.cos(z / 6) + 0.02 * y
    if kind in ("noise",):
        return draw.uniform(-1, 1)
    if kind == "sparse":
        return draw.uniform(0.3, 1) if draw.random() < 0.02 else 0
    if kind == "labels":
        return ((x // 9) + 5 * (y // 8) + 15 * (z // 10)) / 60
    if kind == "constant":
        return 0.25
    return wave


def samples(kind_of, kind, seed):
    """Returns the samples as an array.array, x fastest; None if the type lacks this kind."""
    if kind == "nan" and not is_float(kind_of):
        return None
    draw = random.Random(seed)
    nx, ny, nz = SHAPE
    values = [_value(kind, draw, x, y, z) for z in range(nz) for y in range(ny) for x in range(nx)]
    if is_float(kind_of):
        double = kind_of == "float64"
        scale = {"tiny": 1e-60 if double else 1e-39, "huge": 1e60 if double else 1e37}.get(kind, 50)
        values = [scale * v for v in values]
        if kind == "outlier":
            values[4321] = 1e6
        if kind == "nan":
            values = [math.nan if i % nx > 25 else v for i, v in enumerate(values)]
    else:
        lo, hi = RANGES[kind_of]
        if kind == "tiny":
            lo, hi = max(lo, -1), 1
        elif kind != "huge":
            lo, hi = max(lo, -120), min(hi, 120)
        low = 0 if lo == 0 else -1
        values = [int(round(lo + (hi - lo) * (v - low) / (1 - low))) if v >= low else int(lo) for v in values]
        values = [min(max(v, int(lo)), int(hi)) for v in values]
        if kind == "outlier":
            values[4321] = int(RANGES[kind_of][1])
    if kind == "half masked":
        values = [FILL if i % nx < nx // 2 else v for i, v in enumerate(values)]
    return array.array(TYPES[kind_of], values)
