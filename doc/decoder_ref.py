#!/usr/bin/python3
"""Decodes .cvol and .cvi files. Written from doc/format.md alone: simple and slow, to be read along with it.

usage: decoder_ref.py FILE OUT.raw [--level L] [--time I] [--channel I]

Writes the samples, x fastest, in the file's type, little-endian (for a picture its pixels: red, green, blue, alpha;
for a baked volume its planes as float32), and prints the file's properties as JSON. --level 1, 2, 3: a volume's
coarser levels; the file may then end early.

Needs NumPy, and libzstd only to decompress frames. The built-in codes and the weights of the networks are read from
src/codec/tables.
"""
import argparse
import bisect
import ctypes
import ctypes.util
import itertools
import json
import math
import os
import re
import struct
import sys

import numpy as np

TYPES = {1: "u1", 2: "i1", 3: "<u2", 4: "<i2", 5: "<u4", 6: "<i4", 7: "<f4", 8: "<f8"}
NAMES = {1: "uint8", 2: "int8", 3: "uint16", 4: "int16", 5: "uint32", 6: "int32", 7: "float32",
         8: "float64"}
FLOAT32_MAX = float(np.finfo(np.float32).max)
VALUE_LIMIT = 2 ** 30


class Damaged(Exception):
    """The file violates the format."""


def need(condition, what):
    if not condition:
        raise Damaged(what)


# ---- 1. the file: checksums and sections ---------------------------------------------------------

def crc_table():
    table = []
    for byte in range(256):
        crc = byte
        for _ in range(8):
            crc = crc >> 1 ^ (0x82F63B78 if crc & 1 else 0)
        table.append(crc)
    return table


CRC_TABLE = crc_table()


def crc32c(data):
    crc = 0xFFFFFFFF
    for byte in data:
        crc = crc >> 8 ^ CRC_TABLE[(crc ^ byte) & 255]
    return crc ^ 0xFFFFFFFF


ORDER = ["HEAD", "GEOM", "ATTR", "ERRS", "MODE", "BRKS", "TRUE", "SMAL", "SUMM", "RNGE", "TABL", "INDX", "MASK", "SHL0",
         "SHL1", "SHL2", "SHL3", "CORR", "TERM", "SPEC", "PICT", "BAKE", "PLNS",
         "ENDS"]
OPTIONAL = {"ATTR", "SUMM", "RNGE"}
SHELLS = ["SHL0", "SHL1", "SHL2", "SHL3"]
# The sections with the terms of an array; no other kind of array has these.
OF_VOLUMES = ["MODE", "BRKS", "TRUE", "SMAL", "SUMM", "RNGE", "TABL", "INDX", "MASK", *SHELLS, "CORR"]


def read_sections(data, last):
    """Returns {tag: (content, checksum)} of the sections up to and including `last`."""
    if data[12:16] == b"PACK":
        data = unpack_file(data)
    need(data[:8] == b"\x8bCVL\r\n\x1a\n", "is no .cvol file")
    need(len(data) >= 12, "is cut off in its version")
    version, = struct.unpack_from("<I", data, 8)
    need(version == 1, f"has version {version}, this decoder reads 1")
    sections, at = {}, 12
    while last not in sections:
        need(len(data) - at >= 24, f"is cut off at byte {at}, in a section's header")
        tag, flags, length, checksum, own = struct.unpack_from("<4sIQII", data, at)
        tag = tag.decode("latin1")
        need(own == crc32c(data[at:at + 20]), f"{tag}: its header's checksum does not hold")
        need(len(data) - at - 24 >= length, f"is cut off in {tag}")
        content = data[at + 24:at + 24 + length]
        at += 24 + length
        if tag not in ORDER:
            need(not flags & 1, f"{tag} must be known, and is not")
            need(last != "ENDS" or checksum == crc32c(content), f"{tag}: the checksum does not hold")
            continue
        need(not flags & 1 or flags == 1, f"{tag} has unknown flags")
        need(flags & 1 or tag in OPTIONAL, f"{tag} is not flagged as required")
        need(all(ORDER.index(before) < ORDER.index(tag) for before in sections),
             f"{tag} stands in a wrong place")
        if tag not in SHELLS and tag not in ("MASK", "CORR"):
            need(checksum == crc32c(content), f"{tag}: the checksum does not hold")
        sections[tag] = content, checksum
    if last == "ENDS":
        need(at == len(data), "goes on behind its end")
    return sections


def check_kind(sections, own):
    """Checks that a file has no sections of another kind of file; own: those that its kind may have."""
    for tag in sections:
        need(tag in own or tag == "ENDS", f"{tag} stands in a file of another kind")


# ---- 2. to 4. HEAD, GEOM, ERRS -------------------------------------------------------------------

class Header:
    def __init__(self, head, geom, errs):
        need(len(head) >= 88 and len(geom) >= 156 and len(errs) >= 76, "a record is too short")
        (nx, ny, nz, self.type, self.transform, self.rank, self.block, self.lapped,
         self.trellis, self.step, self.offset, self.value_min, self.value_max,
         self.coefficients) = struct.unpack_from("<3Q6I4dQ", head)
        self.dims = nx, ny, nz
        geometry = struct.unpack_from("<I15d16s2d", geom)
        self.space, self.spacing, self.origin = geometry[0], geometry[1:4], geometry[4:7]
        self.direction = [geometry[7:10], geometry[10:13], geometry[13:16]]
        need(geometry[16][15] == 0, "GEOM: the unit has no end")
        self.unit = geometry[16].split(b"\0")[0].decode("latin1")
        self.value_scale, self.value_offset = geometry[17:19]
        (self.psnr, self.max_error, self.l2_error, self.max_abs, self.threshold, *self.shell_norm,
         self.measured) = struct.unpack_from("<9dI", errs)
        point = struct.unpack_from("<d", errs, 84)[0] if len(errs) >= 92 else 0
        self.point_error = point if 0 < point <= self.l2_error else self.l2_error
        self.check()

    def check(self):
        finite = [self.step, self.offset, self.value_min, self.value_max, *self.spacing,
                  *self.origin, *sum(map(list, self.direction), []), self.value_scale,
                  self.value_offset, self.max_error, self.l2_error, self.max_abs, self.threshold,
                  *self.shell_norm]
        need(all(math.isfinite(x) for x in finite) and not math.isnan(self.psnr),
             "a number is none")
        need(min(self.dims) > 0 and self.type in TYPES and self.space <= 2, "HEAD or GEOM")
        need(self.transform in (1, 2, 3) and self.rank in (1, 2, 3), "transform or rank")
        need(self.block in (0, 8, 16, 32) and max(self.dims[self.rank:], default=1) == 1,
             "block or dims")
        need(self.lapped == 0 or (self.lapped == 1 and self.is_volume() and self.block == 16),
             "lapped")
        need(self.trellis == 0 or (self.trellis == 1 and self.is_volume() and self.block == 16),
             "trellis")
        need(self.step > 0 if self.block else self.step == 0 == self.offset, "step")
        need(self.value_min <= self.value_max and min(self.spacing) > 0, "value_min or spacing")
        need(self.value_scale != 0, "GEOM: value_scale is 0")
        least, most = self.type_range()
        need(all(least <= value <= most and (self.type > 6 or value == int(value))
                 for value in (self.value_min, self.value_max)), "value_min or value_max is no value of the type")
        need(min(self.max_error, self.l2_error, self.max_abs, self.threshold, *self.shell_norm) >= 0
             and self.measured <= 1, "ERRS")

    def type_range(self):
        kind = np.dtype(TYPES[self.type])
        limits = np.finfo(kind) if self.type > 6 else np.iinfo(kind)
        return float(limits.min), float(limits.max)

    def is_volume(self):
        return self.rank == 3 and self.transform == 1 and self.block != 0

    def blocks(self):
        """Returns the number of blocks along each axis."""
        return [-(-n // self.block) if a < self.rank else 1 for a, n in enumerate(self.dims)]


# ---- zstd frames and planes ----------------------------------------------------------------------

def unpack(frame, size):
    """Returns the `size` bytes of a zstd frame."""
    need(size <= 32768 * len(frame), "a frame cannot hold so much")
    library = ctypes.CDLL(ctypes.util.find_library("zstd") or "libzstd.so.1")
    library.ZSTD_decompress.restype = ctypes.c_size_t
    out = ctypes.create_string_buffer(max(size, 1))
    got = library.ZSTD_decompress(out, ctypes.c_size_t(size), bytes(frame),
                                  ctypes.c_size_t(len(frame)))
    need(got == size, "a zstd frame is damaged")
    return out.raw[:size]


def planes(raw, at, count, width):
    """Reads `count` numbers of `width` bytes, stored byte plane by byte plane from `at`; returns them and the
    end."""
    numbers = np.zeros(count, np.uint32)
    for plane in range(width):
        part = np.frombuffer(raw, np.uint8, count, at + plane * count)
        numbers |= part.astype(np.uint32) << np.uint32(8 * plane)
    return numbers, at + width * count


# ---- 5. RNGE -------------------------------------------------------------------------------------

def check_ranges(header, content):
    """Checks RNGE; a decoder of samples does not use it."""
    need(len(content) >= 16, "RNGE is too short")
    lo, hi = struct.unpack_from("<2d", content)
    need(math.isfinite(lo) and lo <= hi and math.isfinite(hi - lo), "RNGE: its ends")
    per = 2 if header.block == 8 else 1
    cells = math.prod(-(-n // per) for n in header.blocks())
    codes = np.frombuffer(unpack(content[16:], 2 * cells), np.uint8).astype(int)
    need((codes[:cells] + codes[cells:] <= 255).all(), "RNGE: a range is too wide")


# ---- 6. INDX and the shells ----------------------------------------------------------------------

def read_lengths(content, at, bricks):
    lengths = []
    for _ in range(bricks):
        value = shift = 0
        while True:
            need(at < len(content) and shift < 64, "INDX: a length")
            byte = content[at]
            at += 1
            value |= (byte & 127) << shift
            shift += 7
            if byte < 128:
                break
        need(value < 2 ** 32, "INDX: a length")
        lengths.append(value)
    return lengths, at


def read_shape(header, content):
    """Returns the sides of bricks, and the number of bricks per checksum; content: of BRKS, None without it."""
    if content is None:
        return (64, 64, 64), 16
    need(len(content) >= 16 and header.is_volume(), "BRKS: not of a volume, or too short")
    *sides, run = struct.unpack_from("<4I", content)
    need(all(side in (16, 32, 48, 64) and side % header.block == 0 for side in sides), "BRKS: a side")
    need(run in (1, 2, 4, 8, 16), "BRKS: a run")
    return tuple(sides), run


def read_true_length(header, content, modes):
    """Returns the bits by which coefficients are finer than the step, if blocks have true length (TRUE); else 0."""
    if content is None:
        return 0
    need(len(content) >= 4 and header.is_volume() and header.block == 16 and modes.kind == 0,
         "TRUE: not of such a volume, or too short")
    bits, = struct.unpack_from("<I", content)
    need(1 <= bits <= 8, "TRUE: bits")
    return bits


def read_index(content, bricks, run, others):
    """Returns lengths [stream][brick] and checksums [stream][run]: of the shells, then of `others` further
    streams."""
    at, lengths, sums, runs = 0, [], [], -(-bricks // run)
    for streams in [4] + [1] * others:
        for _ in range(streams):
            numbers, at = read_lengths(content, at, bricks)
            lengths.append(numbers)
        for numbers in lengths[len(lengths) - streams:]:
            there = [run > 1 or numbers[r] > 0 for r in range(runs)]
            need(len(content) - at >= 4 * sum(there), "INDX is too short")
            stored = iter(struct.unpack_from(f"<{sum(there)}I", content, at))
            sums.append([next(stored) if is_there else 0 for is_there in there])
            at += 4 * sum(there)
    need(len(content) == at, "INDX is too long")
    return lengths, sums


def cut_bricks(content, checksum, lengths, sums, in_run, tag):
    """Returns the bricks' bytes in one shell; checks every run."""
    need(sum(lengths) == len(content), f"{tag}: its length")
    need(crc32c(struct.pack(f"<{len(sums)}I", *sums)) == checksum, f"{tag}: its checksum")
    out, at = [], 0
    for length in lengths:
        out.append(content[at:at + length])
        at += length
    for run, stored in enumerate(sums):
        need(crc32c(b"".join(out[in_run * run:in_run * run + in_run])) == stored, f"{tag}: run {run}")
    return out


# ---- 7. streams of tokens ------------------------------------------------------------------------

ROW_LAST, ROW_ESCAPE, ROW_DC, ROW_LENGTH = 1584, 1672, 1694, 1742
ROW_MORE, ROW_SPLIT, ROW_OCTANTS = 2014, 2078, 2089
ROW_INDEX, ROW_LAST_INDEX, ROW_INDEX_ESCAPE, ROWS = 2140, 4948, 5104, 5130


def table(name):
    """Returns the numbers of src/codec/tables/NAME.inc, in order."""
    path = os.path.join(os.path.dirname(os.path.abspath(__file__)), "..", "src", "codec", "tables", name + ".inc")
    with open(path, encoding="ascii") as file:
        text = re.sub(r"/\*.*?\*/", "", file.read(), flags=re.DOTALL)
    return np.array([int(x) for x in re.findall(r"-?\d+", text)], np.int64)


def codes_in(name, count):
    return table(name).reshape(count, 15).tolist()


def default_codes():
    return codes_in("token_codes", ROWS)


def neural_codes():
    """Returns the token codes for maximum effort: those from the DC to the octants differ."""
    codes, end = default_codes(), ROW_OCTANTS + 2
    codes[ROW_DC:end] = codes_in("neural_rows", end - ROW_DC)
    return codes


PROBABILITY = [math.floor(2 ** 16 / (1 + math.exp((127.5 - j) / 12.75)) + 0.5) for j in range(256)]


class Row:
    """The numbers first[t] .. first[t + 1] - 1 of the 2^14 stand for token t; token[n] is the token of n."""

    def __init__(self, codes):
        left, self.first, self.token = 2 ** 14, [0], []
        for t in range(16):
            f = left
            if t < 15:
                f = (left * PROBABILITY[codes[t]] + 2 ** 15) >> 16
                f = max(1, min(f, left - (15 - t)))
            left -= f
            self.first.append(self.first[-1] + f)
            self.token += [t] * f


class Rows:
    """Rows are built on first use: a file needs few of them."""

    def __init__(self, codes):
        self.codes, self.rows = codes, {}

    def __getitem__(self, number):
        if number not in self.rows:
            self.rows[number] = Row(self.codes[number])
        return self.rows[number]


class Stream:
    def __init__(self, data, rows):
        self.data, self.rows = data, rows
        self.state = int.from_bytes(data[:4], "little") if data else 2 ** 16
        self.at = 4 if data else 0  # bytes read from the front
        self.bits = 0  # raw bits read from the back

    def token(self, number):
        row = self.rows[number]
        n = self.state & (2 ** 14 - 1)
        t = row.token[n]
        first = row.first[t]
        x = (row.first[t + 1] - first) * (self.state >> 14) + n - first
        if x < 2 ** 16:
            x = x << 16 | int.from_bytes(self.data[self.at:self.at + 2], "little")
            self.at += 2
        self.state = x
        return t

    def raw(self, count):
        value = 0
        for i in range(count):
            byte = len(self.data) - 1 - (self.bits >> 3)
            if byte >= 0:
                value |= (self.data[byte] >> (self.bits & 7) & 1) << i
            self.bits += 1
        return value

    def check_end(self):
        need(self.state == 2 ** 16 and self.at + (self.bits + 7) // 8 == len(self.data),
             "a brick's stream is damaged")


# ---- 8. bricks -----------------------------------------------------------------------------------

LEVEL_BOUNDS = [0, 1, 2, 3, 4, 6, 8, 11, 15, 20, 28, 40, 60, 100, 200, 400, 800, 1600, 3200, 6400,
                12800]


FINE_BOUNDS = [0, 1, 2, 3, 4, 5, 6, 8, 10, 12, 16, 22, 30, 40, 56, 80, 120, 200, 400, 800, 1600,
               3200, 6400, 12800, 25600]
STATE_AFTER = [(0, 2), (5, 7), (1, 3), (6, 4), (2, 0), (4, 6), (3, 1), (7, 5)]


def levels_of(bounds):
    return [sum(bound < total for bound in bounds) for total in range(48001)]  # the largest sum


LEVELS, FINE_LEVELS = levels_of(LEVEL_BOUNDS), levels_of(FINE_BOUNDS)


class Scan:
    """The order of the coefficients of a sub-block of side M: places, bands, and indices of sums. Arrays of sums
    have side M + 2, so that additions beyond the sub-block need no test. A sub-block of true length has n of M
    places along each axis; `index` holds each place's index in the complete sub-block."""

    def __init__(self, M, n):
        order = []
        for w in range(M):
            for v in range(M):
                for u in range(M):
                    cube = max(u, v, w).bit_length()
                    order.append((cube, u + v + w, u + M * v + M * M * w, u, v, w))
        self.M, self.side = M, M + 2
        self.places, self.bands, self.sums, self.index = [], [], [], []
        for index, (_, norm, _, u, v, w) in enumerate(sorted(order)):
            if u >= n[0] or v >= n[1] or w >= n[2]:
                continue
            c = sum(bound * M < 32 * norm for bound in (5, 11, 19, 29, 43))
            z = min(2, (u == 0) + (v == 0) + (w == 0))
            self.index.append(index)
            self.places.append((u, v, w))
            self.bands.append(3 * c + z)
            self.sums.append(u + self.side * (v + self.side * w))

    def scatter(self, sums, at, c):
        y, z = self.side, self.side * self.side
        for step in (1, y, z):
            sums[at + step] += 2 * c
        for step in (2, 2 * y, 2 * z, 1 + y, 1 + z, y + z):
            sums[at + step] += c


SCANS = {}


def scan_of(M, n):
    if (M, n) not in SCANS:
        SCANS[M, n] = Scan(M, n)
    return SCANS[M, n]


def sub_blocks_of(split):
    """Returns (side, first sample) of the sub-blocks of a block; split: 0, or 1 and eight bits of octants."""
    if not split & 1:
        return [(16, (0, 0, 0))]
    sub_blocks = []
    for octant in range(8):
        begin = [8 * (octant >> a & 1) for a in range(3)]
        if not split >> (1 + octant) & 1:
            sub_blocks.append((8, tuple(begin)))
            continue
        for i in range(8):
            sub_blocks.append((4, tuple(begin[a] + 4 * (i >> a & 1) for a in range(3))))
    return sub_blocks


class Brick:
    """Decodes one brick: for each sub-block (block, side, first sample in it, values[w, v, u])."""

    def __init__(self, streams, counts, header, length_bits=0, inside=(64, 64, 64)):
        self.streams, self.counts, self.block = streams, counts, header.block
        self.trellis, self.length_bits, self.inside = header.trellis, length_bits, inside
        self.mean, self.length, self.tokens = {}, {}, {}  # by cubes of 4^3, and by blocks

    def decode(self):
        sub_blocks = []
        bx, by, bz = self.counts
        for number in range(bx * by * bz):
            place = number % bx, number // bx % by, number // bx // by
            split = self.split(place) if self.block == 16 else None
            for side, begin in sub_blocks_of(split) if split is not None else [(self.block, (0, 0, 0))]:
                first = [self.block * place[a] + begin[a] for a in range(3)]
                n = tuple(min(side, self.inside[a] - first[a]) for a in range(3))
                if not self.length_bits:
                    values = self.sub_block(side, first, (side, side, side))
                else:
                    filled = tuple(m if m > 0 else side for m in n)
                    values = to_terms(self.sub_block(side, first, n) if filled == n else
                                      self.dont_care(side, first, filled), filled, self.length_bits)
                need(np.abs(values).max() <= VALUE_LIMIT, "a term")
                sub_blocks.append((place, side, begin, values))
        for stream in self.streams:
            stream.check_end()
        return sub_blocks

    def split(self, place):
        near = [self.tokens[before] for before in neighbours_before(place, 1) if before in self.tokens]
        n = len(near)
        around = 1 + (3 * sum(near) + n // 2) // n if n else 0
        token = self.tokens[place] = self.streams[0].token(ROW_SPLIT + around)
        need(token < 4, "the split of a block")
        if token < 2:
            return token
        if token == 3:
            return 0x1FF
        low, high = self.streams[0].token(ROW_OCTANTS), self.streams[0].token(ROW_OCTANTS + 1)
        return 1 | low << 1 | high << 5

    def context(self, k, cube, W):
        near = [before for before in neighbours_before(cube, 1) if before in self.mean]
        n = len(near)
        if not n:
            return 0, 0, 0
        means = [self.mean[c] for c in near]
        lengths = [max(1, self.length[c] - 3 * (3 - k)) if self.length[c] else 0 for c in near]
        prediction = (2 * sum(means) + n * W) // (2 * n * W)
        prediction = max(1 - VALUE_LIMIT, min(VALUE_LIMIT - 1, prediction))
        spread = 1 if n == 1 else 2 + min(9, ((max(means) - min(means)) // W).bit_length())
        return prediction, spread, 1 + (sum(lengths) + n // 2) // n

    @staticmethod
    def weight(n):
        return math.floor(2 ** 16 / math.sqrt(math.prod(n)) + 0.5)

    def dont_care(self, M, first, n):
        """A sub-block of don't-care samples: the prediction of its neighbours."""
        cube = tuple(x // 4 for x in first)
        limit, W = VALUE_LIMIT >> self.trellis + self.length_bits, self.weight(n)
        means = [self.mean[c] for c in neighbours_before(cube, 1) if c in self.mean]
        size = (2 * abs(sum(means)) + len(means) * W) // (2 * len(means) * W) if means else 0
        dc = min(limit, size) * (-1 if sum(means) < 0 else 1)
        self.note(M, cube, dc * W, 0)
        values = np.zeros((M, M, M), np.int64)
        values[0, 0, 0] = dc << self.trellis
        return values

    def note(self, M, cube, mean, length):
        for z in range(M // 4):
            for y in range(M // 4):
                for x in range(M // 4):
                    at = cube[0] + x, cube[1] + y, cube[2] + z
                    self.mean[at], self.length[at] = mean, length

    def sub_block(self, M, first, n):
        k = {4: 0, 8: 1, 16: 2, 32: 3}[M]
        cube = tuple(x // 4 for x in first)
        W = self.weight(n)
        prediction, spread, around = self.context(k, cube, W)
        stream = self.streams[0]
        d = self.number(stream, ROW_DC + 12 * k + spread)
        dc = prediction + (-d if d and stream.raw(1) else d)
        need(abs(dc) <= VALUE_LIMIT >> self.trellis, "a DC")
        kind = 0 if d == 0 else 1 if d == 1 else 2 if d < 4 else 3
        L = stream.token(ROW_LENGTH + 4 * (17 * k + around) + kind)
        values = np.zeros((M, M, M), np.int64)
        values[0, 0, 0] = dc << self.trellis
        if L:
            scan = scan_of(M, n)
            need(2 ** (L - 1) <= scan.index[-1], "a last index")
            self.coefficients(values, scan, k, L, dc)
        self.note(M, cube, dc * W, L + 3 * (3 - k) if L else 0)
        return values

    @staticmethod
    def number(stream, row):
        t = stream.token(row)
        if t < 4:
            return t
        length = t - 1 if t < 15 else max(1, stream.raw(5))
        return 2 ** (length - 1) | stream.raw(length - 1)

    def coefficients(self, values, scan, k, L, dc):
        sums = [0] * (scan.side ** 3 + 2 * scan.side ** 2)
        scan.scatter(sums, 0, min(abs(dc), 2))
        begin, state = 1, 0
        for s, stream in enumerate(self.streams):
            shell_end, last = 8 ** max(0, k + s - 1), None
            end = sum(index < shell_end for index in scan.index)
            if end <= begin:
                continue
            if 2 ** (L - 1) < shell_end:
                last = self.last(stream, k, L)
                need(last in scan.index, "a last index")
                last = scan.index.index(last)
                end = last + 1
            for i in range(begin, end):
                odd = state % 2
                m = self.magnitude(stream, k, scan.bands[i], sums[scan.sums[i]], odd, i == last)
                need(m <= VALUE_LIMIT >> self.trellis, "a coefficient")
                if self.trellis:
                    state = STATE_AFTER[state][m % 2]
                    m = 2 * m - odd if m else 0
                if m:
                    u, v, w = scan.places[i]
                    values[w, v, u] = -m if stream.raw(1) else m
                    scan.scatter(sums, scan.sums[i], min(m, 4000))
            begin = end
            if last is not None:
                break

    @staticmethod
    def last(stream, k, L):
        if L == 1:
            return 1
        t = stream.token(ROW_MORE + 16 * k + L)
        if L == 2:
            return 2 + t % 2
        return (4 + t % 4) << (L - 3) | stream.raw(L - 3)

    def magnitude(self, stream, k, band, total, odd, is_last):
        if self.trellis:
            level, k, escape = FINE_LEVELS[total], k + 3 * odd, ROW_INDEX_ESCAPE
            row = (ROW_LAST_INDEX + 26 * k if is_last else ROW_INDEX + (18 * k + band) * 26) + level
            shift = min(8, max(0, level - 16))
        else:
            level, escape = LEVELS[total], ROW_ESCAPE
            row = (ROW_LAST + 22 * k if is_last else (18 * k + band) * 22) + level
            shift = max(0, level - 13)
        high = stream.token(row)
        if high == 15:
            r = stream.token(escape + level)
            if r == 15:
                r += stream.raw(4)
            high = 2 ** r + stream.raw(r) + 14
        return (high << shift | stream.raw(shift)) + (1 if is_last else 0)


def neighbours_before(at, step):
    x, y, z = at
    return (x - step, y, z), (x, y - step, z), (x, y, z - step)


# ---- 9. TABL -------------------------------------------------------------------------------------

def update(context, bit):
    """Moves a context towards a bit."""
    fast, slow = context
    if bit:
        context[:] = fast - (fast >> 4), slow - (slow >> 7)
    else:
        context[:] = fast + (65535 - fast >> 4), slow + (65535 - slow >> 7)


class RangeDecoder:
    def __init__(self, data):
        self.data, self.at = data, 0
        self.range = 2 ** 64 - 1
        self.code = self.take(8)

    def take(self, count):
        part = self.data[self.at:self.at + count]
        self.at += count
        return int.from_bytes(part + bytes(count - len(part)), "big")

    def bit(self, context):
        fast, slow = context
        bit = self.likely(2 ** 16 - ((fast + slow) >> 1))
        update(context, bit)
        return bit

    def likely(self, p):
        """Decodes a bit that is 1 with probability p / 2^16."""
        bound = (self.range >> 16) * (2 ** 16 - p)
        bit = int(self.code >= bound)
        if bit:
            self.code -= bound
            self.range -= bound
        else:
            self.range = bound
        self.go_on()
        return bit

    def token(self, row):
        unit = self.range >> 14
        n = self.code // unit
        t = row.token[n] if n < 2 ** 14 else 15
        self.code -= unit * row.first[t]
        self.range = unit * (row.first[t + 1] - row.first[t])
        self.go_on()
        return t

    def go_on(self):
        if self.range < 2 ** 32:
            self.range <<= 32
            self.code = self.code << 32 | self.take(4)


def contexts(count, start=2 ** 15):
    return [[start, start] for _ in range(count)]


def read_tables(content):
    codes, decoder = default_codes(), RangeDecoder(content)
    row, zero, sign, unary = contexts(2), contexts(4), contexts(2), contexts(24)
    before = 0
    for r in range(ROWS):
        before = decoder.bit(row[before])
        s = 0
        for t in range(15 if before else 0):
            if not decoder.bit(zero[min(t, 3)]):
                continue
            s = decoder.bit(sign[s])
            m = 1
            while m < 256 and decoder.bit(unary[min(m, 24) - 1]):
                m += 1
            codes[r][t] += -2 * m if s else 2 * m
            need(0 <= codes[r][t] <= 255, "TABL: a code")
    need(decoder.at - 7 <= len(content), "TABL is too short")
    return Rows(codes)


# ---- 21. SMAL ------------------------------------------------------------------------------------

class NeuralStream:
    """Decodes one shell of a brick."""

    def __init__(self, data, rows):
        self.coded, self.raws, self.rows, self.used = RangeDecoder(data), Stream(data, None), rows, False

    def token(self, number):
        self.used = True
        return self.coded.token(self.rows[number])

    def raw(self, count):
        self.used = self.used or count > 0
        return self.raws.raw(count)

    def bit(self, context):
        self.used = True
        return self.coded.bit(context)

    def by_logit(self, curve, o):
        self.used = True
        a = o + 2048
        i, f = a >> 7, a & 127
        seen = (curve[i] * (128 - f) + curve[i + 1] * f) >> 7
        bit = self.coded.likely(max(48, min(65488, (LIKELIHOOD[a] + 3 * seen) >> 2)))
        j = i + (f >= 64)
        curve[j] += ((65535 if bit else 0) - curve[j]) >> 7
        return bit

    def check_end(self):
        taken = self.coded.at - 7 + (self.raws.bits + 7) // 8
        length = len(self.coded.data)
        need(taken <= length if self.used else length == 0, "a brick's stream is damaged")


LIKELIHOOD = [math.floor(2 ** 16 / (1 + math.exp((2048 - a) / 256)) + 0.5) for a in range(4096)]
CLASSES = [math.floor(10 * math.log2(1 + m) + 0.5) for m in range(4096)]
NEAR = [(1, 0, 0), (0, 1, 0), (0, 0, 1), (2, 0, 0), (0, 2, 0), (0, 0, 2), (1, 1, 0), (1, 0, 1),
        (0, 1, 1), (1, 1, 1), (3, 0, 0), (0, 3, 0), (0, 0, 3), (2, 1, 0), (1, 2, 0), (2, 0, 1),
        (1, 0, 2), (0, 2, 1), (0, 1, 2), (-1, 1, 0), (-1, 0, 1), (0, -1, 1), (-1, 1, 1), (1, -1, 1),
        (1, 1, -1)]
TURNED = [(-1, 2, 0), (2, -1, 0), (-1, 0, 2), (2, 0, -1), (0, -1, 2), (0, 2, -1)]
FAR = [(2, 1, 1), (1, 2, 1), (1, 1, 2)]


def size_class(m):
    return CLASSES[min(int(m), 4095)]


def face_class(z):
    return size_class(abs(z) >> 2)


def signed_face(z):
    return -face_class(z) if z < 0 else face_class(z)


def wrap(a):
    """Wraps a number or an array to 32 bits."""
    return (a + 2 ** 31) % 2 ** 32 - 2 ** 31


def towards_zero(a, b):
    return a // b if a >= 0 else -(-a // b)


def shift_round(a):
    return wrap(a + 512) >> 10


def cut_basis(n):
    """E[n][u][x]"""
    return np.floor(1024 * dct_matrix(n) + 0.5).astype(np.int64)


class Network:
    def __init__(self, name):
        numbers = table(name)
        self.layers = []
        for units, count, shift, low, high in ((96, 80, 11, 0, 255), (48, 96, 12, 0, 255),
                                               (16, 48, 10, -2047, 2047)):
            weights, numbers = numbers[:units * count].reshape(units, count), numbers[units * count:]
            self.layers.append((weights, numbers[:units], shift, low, high))
            numbers = numbers[units:]
        need(not len(numbers), f"{name}: too many numbers")

    def __call__(self, x):
        for weights, biases, shift, low, high in self.layers:
            x = np.clip((biases + weights @ x) >> shift, low, high)
        return [int(o) for o in x]


class NeuralSubBlock:
    def __init__(self, block, M, begin, first, n):
        self.block, self.M, self.begin, self.first, self.n = block, M, begin, first, n
        self.k = {4: 0, 8: 1, 16: 2}[M]
        self.K = np.zeros((M, M, M), np.int64)  # [w, v, u]
        self.blur = np.zeros((M, M, M), np.int64)
        self.has_samples, self.finished = True, False
        self.L = self.d = self.around = self.state = 0
        self.next = 1


class NeuralBrick(Brick):
    networks, bases = None, {}

    def __init__(self, streams, counts, header, length_bits, inside):
        super().__init__(streams, counts, header, length_bits, inside)
        if not NeuralBrick.networks:
            NeuralBrick.networks = Network("neural_magnitudes"), Network("neural_signs")
            NeuralBrick.bases = {n: cut_basis(n) for n in range(1, 17)}
        self.lapped = header.lapped
        fresh = [LIKELIHOOD[min(128 * i, 4095)] for i in range(33)]
        self.above = [[list(fresh) for _ in range(3)] for _ in range(16)]
        self.agrees = [[list(fresh) for _ in range(2)] for _ in range(3)]
        self.escape = contexts(31)
        self.samples = np.zeros([16 * c for c in reversed(counts)], np.int64)
        self.at = {}  # sub-blocks by cubes of 4^3
        self.means = np.zeros((3, 16, 16, 16), int)  # [k, w, v, u]
        self.met = np.zeros((3, 4), int)

    def decode(self):
        bx, by, bz = self.counts
        blocks = [(i % bx, i // bx % by, i // bx // by) for i in range(bx * by * bz)]
        splits = [self.split(block) for block in blocks]
        sub_blocks = []
        for block, split in zip(blocks, splits):
            for side, begin in sub_blocks_of(split):
                first = [16 * block[a] + begin[a] for a in range(3)]
                n = [min(side, self.inside[a] - first[a]) if self.length_bits else side for a in range(3)]
                sub_block = NeuralSubBlock(block, side, begin, first, tuple(m if m > 0 else side for m in n))
                sub_block.has_samples = min(n) > 0
                sub_blocks.append(sub_block)
                for place in itertools.product(range(side // 4), repeat=3) if sub_block.has_samples else ():
                    self.at[tuple(first[a] // 4 + place[a] for a in range(3))] = sub_block
        for sub_block in sub_blocks:
            self.head(sub_block)
        for s in range(len(self.streams)):
            for sub_block in sub_blocks:
                if sub_block.has_samples and sub_block.L and not sub_block.finished:
                    self.shell(sub_block, s)
        for stream in self.streams:
            stream.check_end()
        out = []
        for sub_block in sub_blocks:
            values = to_terms(sub_block.K, sub_block.n, self.length_bits) if self.length_bits else sub_block.K
            need(np.abs(values).max() <= VALUE_LIMIT, "a term")
            out.append((sub_block.block, sub_block.M, sub_block.begin, values))
        return out

    def head(self, sub_block):
        if not sub_block.has_samples:
            sub_block.K[:] = self.dont_care(sub_block.M, sub_block.first, sub_block.n)
            return
        stream, cube, W = self.streams[0], tuple(x // 4 for x in sub_block.first), self.weight(sub_block.n)
        prediction, spread, sub_block.around = self.context(sub_block.k, cube, W)
        d = sub_block.d = self.number(stream, ROW_DC + 12 * sub_block.k + spread)
        dc = prediction + (-d if d and stream.raw(1) else d)
        need(abs(dc) <= VALUE_LIMIT >> 1, "a DC")
        kind = 0 if d == 0 else 1 if d == 1 else 2 if d < 4 else 3
        sub_block.L = stream.token(ROW_LENGTH + 4 * (17 * sub_block.k + sub_block.around) + kind)
        need(not sub_block.L or 2 ** (sub_block.L - 1) <= scan_of(sub_block.M, sub_block.n).index[-1], "a last index")
        sub_block.K[0, 0, 0] = 2 * dc
        self.note(sub_block.M, cube, dc * W, sub_block.L + 3 * (3 - sub_block.k) if sub_block.L else 0)
        self.show(sub_block, 1)

    def show(self, sub_block, cube):
        """Updates the samples and the blur of the decoded coefficients."""
        x, y, z = sub_block.first
        nx, ny, nz = sub_block.n
        v = wrap(16 * sub_block.K[:nz, :ny, :nx])
        for n, axis in ((nx, 2), (ny, 1), (nz, 0)):
            v = np.moveaxis(shift_round(wrap(np.moveaxis(v, axis, -1) @ self.bases[n])), -1, axis)
        self.samples[z:z + nz, y:y + ny, x:x + nx] = v
        c = np.zeros((sub_block.M + 2,) * 3, int)
        there = np.zeros_like(c)
        for w, v, u in itertools.product(*(range(min(cube, n)) for n in reversed(sub_block.n))):
            c[w + 1, v + 1, u + 1] = size_class(abs(sub_block.K[w, v, u]))
            there[w + 1, v + 1, u + 1] = 1
        c[1, 1, 1] = 0
        for w, v, u in itertools.product(*(range(min(cube, n)) for n in reversed(sub_block.n))):
            neighbours = [(w, v + 1, u + 1), (w + 2, v + 1, u + 1), (w + 1, v, u + 1), (w + 1, v + 2, u + 1),
                      (w + 1, v + 1, u), (w + 1, v + 1, u + 2)]
            total = 2 * c[w + 1, v + 1, u + 1] + sum(c[b] for b in neighbours)
            sub_block.blur[w, v, u] = total * (65535 // (2 + sum(there[b] for b in neighbours))) >> 16
        sub_block.blur[0, 0, 0] = 0

    def face_neighbours(self, sub_block):
        """Returns the sub-blocks at its six faces, or None."""
        cube, out = [x // 4 for x in sub_block.first], []
        for k in range(6):
            at = list(cube)
            at[k % 3] += -1 if k < 3 else sub_block.M // 4
            out.append(self.at.get(tuple(at)) if k < 3 or sub_block.n[k % 3] == sub_block.M else None)
        return out

    def edge_neighbours(self, sub_block):
        """Returns the sub-blocks across its edges between faces 0 and 1, 0 and 2, 1 and 2, or None."""
        cube, out = [x // 4 for x in sub_block.first], []
        for edge in ((0, 1), (0, 2), (1, 2)):
            out.append(self.at.get(tuple(cube[a] - (a in edge) for a in range(3))))
        return out

    def average(self, sub_block, s):
        cube = sub_block.M >> (3 - s)
        known = cube // 2 if cube > 2 else 1
        means, met = self.means[sub_block.k], self.met[sub_block.k]
        for w, v, u in itertools.product(*(range(min(cube, n)) for n in reversed(sub_block.n))):
            if max(u, v, w) >= known:
                means[w, v, u] += (16 * size_class(abs(sub_block.K[w, v, u])) - means[w, v, u]) >> met[s]
        met[s] = min(3, met[s] + 1)

    def waves(self, sub_block, k, e):
        """Returns edge(e), inner(e)."""
        n = sub_block.n[k % 3]
        E, turn = self.bases[n][e], -1 if k >= 3 and e % 2 else 1
        return turn * int(E[0]), turn * int(E[1] - E[0]) if n > 1 else 0

    def faces(self, sub_block, near):
        """Returns [level, slope] of each face, by the other two frequencies [w, v]."""
        out, known = [], np.argwhere(sub_block.K)
        for k, other in enumerate(near):
            if other is None:
                out.append(None)
                continue
            a = k % 3
            box = [slice(sub_block.first[b], sub_block.first[b] + sub_block.n[b]) for b in range(3)]
            planes, at = [], sub_block.first[a] + (sub_block.M if k >= 3 else -1)
            step = 0 if k >= 3 and other.n[a] == 1 else 1 if k >= 3 else -1
            for place in (at, at + step):
                box[a] = place
                planes.append(self.samples[box[2], box[1], box[0]])  # [j, i]
            n1, n2 = [sub_block.n[b] for b in range(3) if b != a]
            face = []
            for plane in (planes[0], wrap(planes[0] - planes[1])):
                P = shift_round(wrap(plane @ self.bases[n1].T))
                face.append(wrap(shift_round(wrap(self.bases[n2] @ P)) << 8))
            out.append(face)
        for w, v, u in known:
            self.take_off(sub_block, out, (u, v, w), int(sub_block.K[w, v, u]))
        return out

    def take_off(self, sub_block, faces, at, value):
        for k, face in enumerate(faces):
            if face is None:
                continue
            others = tuple(reversed([at[b] for b in range(3) if b != k % 3]))
            for plane, wave in zip(face, self.waves(sub_block, k, at[k % 3])):
                plane[others] = wrap(int(plane[others]) - 4 * value * wave)

    @staticmethod
    def place_in(sub_block, M, at):
        """Returns the position of a frequency of a sub-block of side M in another sub-block."""
        if sub_block.M < M:
            at = [f // (M // sub_block.M) for f in at]
        elif sub_block.M > M:
            at = [f * (sub_block.M // M) + sub_block.M // M // 2 for f in at]
        return tuple(min(f, n - 1) for f, n in zip(at, sub_block.n))[::-1]

    def blur_at(self, sub_block, M, at):
        return 0 if sub_block is None else int(sub_block.blur[self.place_in(sub_block, M, at)])

    def class_at(self, sub_block, M, at):
        place = (0, 0, 0) if sub_block is None or not any(at) else self.place_in(sub_block, M, at)
        return size_class(abs(sub_block.K[place])) if any(place) else 0

    def shell(self, sub_block, s):
        scan, stream = scan_of(sub_block.M, sub_block.n), self.streams[s]
        shell_end, last = 8 ** max(0, sub_block.k + s - 1), None
        end = sum(index < shell_end for index in scan.index)
        if end <= sub_block.next:
            return
        if 2 ** (sub_block.L - 1) < shell_end:
            last = self.last(stream, sub_block.k, sub_block.L)
            need(last in scan.index and scan.index.index(last) >= sub_block.next, "a last index")
            last = scan.index.index(last)
            end = last + 1
        near, edges = self.face_neighbours(sub_block), self.edge_neighbours(sub_block)
        faces = self.faces(sub_block, near)
        sizes = np.zeros((sub_block.M + 6,) * 3, int)  # of K[w, v, u] at [w + 3, v + 3, u + 3]
        sizes[3:-3, 3:-3, 3:-3] = np.minimum(np.abs(sub_block.K), 4095)
        sizes[3, 3, 3] = min(2, sizes[3, 3, 3])
        run = slow = 0
        for i in range(sub_block.next, end):
            at = scan.places[i]
            x, shift, predicted = self.look(sub_block, s, i, at, last, (run, slow), sizes, near, edges, faces)
            m = self.size(stream, sub_block, x, shift, i == last)
            need(m <= VALUE_LIMIT >> 1 and (m or i != last), "a coefficient")
            odd = sub_block.state % 2
            sub_block.state = STATE_AFTER[sub_block.state][m % 2]
            m = 2 * m - odd if m else 0
            run += towards_zero(16 * size_class(m) - run, 8)
            slow += towards_zero(64 * size_class(m) - slow, 32)
            if m:
                value = -m if self.is_negative(stream, sub_block, x, m, near, predicted) else m
                u, v, w = at
                sub_block.K[w, v, u] = value
                sizes[w + 3, v + 3, u + 3] = min(m, 4095)
                self.take_off(sub_block, faces, at, value)
        sub_block.next = end
        sub_block.finished = last is not None
        self.show(sub_block, sub_block.M >> (3 - s))
        self.average(sub_block, s)

    def look(self, sub_block, s, i, at, last, runs, sizes, near, edges, faces):
        """Returns the inputs, the shift, and the predictions of faces: (l, d, their sum)."""
        u, v, w = at

        def m(offset):
            return int(sizes[w + 3 - offset[2], v + 3 - offset[1], u + 3 - offset[0]])

        total = 2 * sum(map(m, NEAR[:3])) + sum(map(m, NEAR[3:9]))
        shift = 0
        while total >> shift >= 192:
            shift += 1
        l, d = [0] * 6, [0] * 6
        for k, face in enumerate(faces):
            if face is not None:
                others = tuple(reversed([at[b] for b in range(3) if b != k % 3]))
                edge, inner = self.waves(sub_block, k, at[k % 3])
                l[k] = wrap((int(face[0][others]) >> 8) * edge) >> 10
                d[k] = wrap((int(face[1][others]) >> 8) * inner) >> 10
        F = wrap(sum(l))
        x = [size_class(m(offset)) for offset in NEAR]
        x.append(min(127, sum(size_class(m(offset)) for offset in TURNED) // 3))
        x.append(min(127, sum(size_class(m(offset)) for offset in FAR) // 2))
        x += [runs[0] // 16, size_class(total // 4)]
        x += [self.blur_at(p, sub_block.M, at) for p in near[:3]]
        x += [self.blur_at(p, sub_block.M, [f // 2 for f in at]) for p in near[3:]]
        x += [10 * shift, 127 if last is None else size_class(last - i), 8 * sub_block.L,
              64 * (i == last), 64 * (sub_block.state % 2), 64 * (sub_block.state >= 4), 64 * (sub_block.k == 0),
              64 * (sub_block.k == 1)]
        x += [128 * f // n for f, n in zip(at, sub_block.n)] + [64 * (f == 0) for f in at]
        x += [face_class(z) for z in l] + [face_class(F)]
        x += [127 if p is None else 32 * (p.k - sub_block.k) for p in near[:3]]
        x += [7 * sub_block.around, 64 * self.lapped, 32 * s, size_class(sub_block.d), sum(x[29:32]) // 3]
        x += [face_class(z) for z in d] + [self.class_at(p, sub_block.M, at) for p in near[:3]]
        x += [self.blur_at(p, sub_block.M, at) for p in edges]
        x += [size_class(m((u - u // 2, v - v // 2, w - w // 2))),
              int(self.means[sub_block.k, w, v, u]) // 16, face_class(wrap(sum(d))), runs[1] // 64]
        return x, shift, (l, d, F)

    def size(self, stream, sub_block, x, shift, is_last):
        o = self.networks[0](np.array(x, np.int64))
        t = 1 if is_last and not shift else 0
        while t < 16 and stream.by_logit(self.above[t][sub_block.k], o[t]):
            t += 1
        if t == 16:
            r = 0
            while r < 30 and stream.bit(self.escape[r]):
                r += 1
            t += 2 ** r + stream.raw(r) - 1
        return t << shift | stream.raw(shift)

    def is_negative(self, stream, sub_block, x, m, near, predicted):
        if near == [None] * 6:
            return stream.raw(1)
        l, d, F = predicted
        turn, y = -1 if F < 0 else 1, []
        for k in range(6):
            y += [turn * signed_face(l[k]), turn * signed_face(d[k])]
        y += [size_class(m), x[28]] + x[43:49] + [x[41], x[42], x[60], x[61], x[55]]
        y += [64 * (self.lapped and b % 16 == 0) for b in sub_block.first]
        y += [64 * (self.lapped and (b + sub_block.M) % 16 == 0) for b in sub_block.first]
        y += [x[63]] + [0] * 48
        o = self.networks[1](np.array(y, np.int64))
        agrees = stream.by_logit(self.agrees[sub_block.k][self.lapped], o[0])
        return int((turn < 0) == bool(agrees))


# ---- 2. from coefficients to samples -------------------------------------------------------------

def dct_matrix(n):
    """D[u][x]"""
    u, x = np.arange(n)[:, None], np.arange(n)[None, :]
    D = np.sqrt(2 / n) * np.cos(np.pi * u * (x + 0.5) / n)
    D[0] = np.sqrt(1 / n)
    return D


def inverse_dct(A):
    """The inverse along all axes."""
    for axis, n in enumerate(A.shape):
        A = np.moveaxis(np.tensordot(dct_matrix(n), A, (0, axis)), 0, axis)
    return A


def to_terms(values, n, bits):
    """Converts the coefficients of a sub-block with n samples inside the volume to those of its complete side."""
    M, terms = len(values), values * 2.0 ** bits
    for axis in (2, 1, 0):  # first along x
        length = n[2 - axis]
        if length < M:
            k, x = np.arange(length)[:, None], np.arange(M)[None, :]
            D = np.sqrt(np.where(k > 0, 2, 1) / length) * np.cos(np.pi * k * (x + 0.5) / length)
            both = dct_matrix(M) @ D.T  # [u][k]
            terms = np.moveaxis(np.tensordot(both, terms.take(range(length), axis), (1, axis)),
                                0, axis)
    return np.rint(terms - np.copysign(2.0 ** -10, terms)).astype(np.int64)


def mirror(slots):
    """slots[-p]"""
    for axis in range(slots.ndim):
        slots = np.roll(np.flip(slots, axis), 1, axis)
    return slots


def pair_order(shape):
    """+1 where a place is the first of its pair, -1 where it is the second, 0 without a pair. Axes z, y, x."""
    order = np.zeros(shape, int)
    for axis, n in enumerate(shape):  # x is last and decides
        u = np.arange(n)
        own = np.where((u == 0) | (2 * u == n), 0, np.where(2 * u < n, 1, -1))
        own = own.reshape([n if a == axis else 1 for a in range(len(shape))])
        order = np.where(own != 0, own, order)
    return order


def inverse(transform, slots):
    """Returns the samples of slots[w, v, u]."""
    N = slots.size
    if transform == 1:
        return inverse_dct(slots)
    if transform == 2:
        F = np.fft.fftn(slots) / np.sqrt(N)
        return F.real - F.imag
    order, other = pair_order(slots.shape), mirror(slots)
    A = np.where(order == 0, slots + 0j, np.where(order > 0, slots + 1j * other,
                                                 other - 1j * slots) / np.sqrt(2))
    return (np.fft.ifftn(A) * np.sqrt(N)).real


def post_filter(samples, axis):
    """Filters across the faces of blocks of 16, in place."""
    h = -0.07768840068963345, -0.2309698831278217, 0.09567085809127243, -0.1337310918356290
    a = np.moveaxis(samples, axis, 0)
    for e in range(16, len(a) - 1, 16):
        inner, outer = a[e - 1] - a[e], a[e - 2] - a[e + 1]
        d0, d1 = h[0] * inner + h[1] * outer, h[2] * inner + h[3] * outer
        a[e - 1] += d0
        a[e] -= d0
        a[e - 2] += d1
        a[e + 1] -= d1


def finish(header, samples):
    """Adds the offset, rounds and clamps."""
    samples = samples + header.offset
    if header.type < 7:
        samples = np.floor(samples + 0.5)
    return np.clip(samples, header.value_min, header.value_max).astype(TYPES[header.type])


def crop(header, samples):
    nx, ny, nz = header.dims
    return samples[:nz, :ny, :nx]


# ---- 22. SUMM ------------------------------------------------------------------------------------

def read_summary(content, samples):
    """Returns the levels of all bins; a decoder of samples only checks SUMM."""
    def leb128(at):
        number, shift = 0, 0
        while True:
            need(at < len(content) and shift < 64, "SUMM: a number")
            number |= (content[at] & 127) << shift
            shift += 7
            at += 1
            if content[at - 1] < 128:
                return number, at

    need(len(content) >= 2 and not content[0] & 8 and content[0] >> 4 <= 4, "SUMM: flags")
    distinct, at = leb128(1)
    need(distinct <= 256, "SUMM: distinct")
    if content[0] & 2:
        need(len(content) >= at + 16, "SUMM: its range")
        lo, hi = struct.unpack_from("<2d", content, at)
        need(math.isfinite(lo) and math.isfinite(hi) and lo <= hi, "SUMM: its range")
        at += 16
    if content[0] & 4:
        need(len(content) >= at + 8 and math.isfinite(struct.unpack_from("<d", content, at)[0]), "SUMM: its mark")
        count, at = leb128(at + 8)
        need(0 < count <= samples, "SUMM: its mark")
    decoder = RangeDecoder(content[at:])

    def contexts(*shape):
        return [contexts(*shape[1:]) for _ in range(shape[0])] if shape else [2 ** 15, 2 ** 15]

    empty, change, sign, more = contexts(3), contexts(3), contexts(2), contexts(3, 12)
    levels, last, lately, down = [1, 1], 0, 16, 0
    for _ in range(2 ** (4 + (content[0] >> 4))):
        if decoder.bit(empty[(levels[-1] == 0) + (levels[-2] == 0)]):
            levels.append(0)
            continue
        c, m = (lately >= 8) + (lately >= 24), 0
        if decoder.bit(change[c]):
            down, m = decoder.bit(sign[down]), 1
            while m < 253 and decoder.bit(more[c][min(m, 12) - 1]):
                m += 1
            lately += int((8 * m - lately) / 4)
        else:
            lately -= lately // 4
        last += -m if down else m
        need(1 <= last <= 253, "SUMM: a level")
        levels.append(last)
    need(decoder.at - 7 <= len(content) - at, "SUMM is too short")
    return levels[2:]


# ---- 12. MODE ------------------------------------------------------------------------------------

BOUNDED, EXACT, PACKED, LABELS = 1, 2, 3, 4
ROW_NUMBER, ROW_MORE_NUMBER, ROW_DEEP = 2091, 2115, 2139


class Modes:
    def __init__(self, header, content=None):
        """content: of MODE, None without it."""
        self.kind, self.fraction, self.fills, self.background = 0, 0, (), 0
        if content is None:
            return
        need(len(content) >= 32 and header.is_volume(), "MODE: not of a volume, or too short")
        self.kind, self.fraction, self.quantum, self.unit, self.grain, count, self.background = (
            struct.unpack_from("<IIdii2I", content))
        need(self.kind <= 4 and self.fraction <= 10 and count <= (0 if self.kind == LABELS else 7), "MODE")
        need(len(content) >= 32 + 8 * count, "MODE is too short")
        self.fills = struct.unpack_from(f"<{count}Q", content, 32)
        self.check_fills(header)
        self.check_rule(header)

    def check_fills(self, header):
        kind = np.dtype(TYPES[header.type])
        need(len(set(self.fills)) == len(self.fills) and all(bits < 256 ** kind.itemsize for bits in self.fills),
             "MODE: a fill")
        need(self.background <= (len(self.fills) == 1), "MODE: background")
        if self.background:
            value = np.frombuffer(struct.pack("<Q", self.fills[0]), kind, 1)[0]
            need(header.value_min <= value <= header.value_max, "MODE: the fill of the background")

    def check_rule(self, header):
        lo, hi, quantum = header.value_min, header.value_max, self.quantum
        if self.kind == LABELS:
            need(header.type <= 6 and lo <= quantum <= hi and quantum == int(quantum), "MODE: quantum")
        elif self.kind in (BOUNDED, EXACT) and header.type <= 6:
            need(1 <= quantum < 2 ** 34 and quantum % 2 == 1, "MODE: quantum")
        elif self.kind == BOUNDED:
            need(0 < quantum < math.inf, "MODE: quantum")
        elif self.kind == EXACT:
            largest, (lowest, least, most) = max(abs(lo), abs(hi)), {7: (-149, -126, 120), 8: (-1074, -1022, 1000)}[
                header.type]
            need(least <= self.unit <= most and lowest <= self.grain <= self.unit, "MODE: unit or grain")
            need(largest == 0 or self.unit >= math.frexp(largest)[1] - 1 - 48, "MODE: unit")


# ---- 13. MASK ------------------------------------------------------------------------------------

# dx, dy, dz of the first and the number of the neighbours in each window.
WINDOWS = ([(-1, dy, -2, 3) for dy in (-1, 0, 1)] + [(-2, dy, -1, 5) for dy in (-2, -1, 0, 1, 2)]
           + [(-2, -2, 0, 5), (-3, -1, 0, 7), (-4, 0, 0, 4)])
LEVEL_STARTS = [max(71, min(65465, math.floor(2 ** 16 / (1 + math.exp((level - 64) / 8)) + 0.5)))
                for level in range(129)]
PAD = 8  # padding of rows, at both ends


class Predictor:
    def __init__(self):
        numbers = table("mask_network")
        self.weights = numbers[:800].reshape(50, 16)
        self.biases, self.outs, self.bias = numbers[800:816], numbers[816:832], int(numbers[832])

    def level(self, neighbours):
        hidden = np.maximum(0, self.biases + neighbours @ self.weights)
        output = self.bias + int(hidden @ self.outs)
        return 64 + max(-64, min(64, (output + 2 ** 9) // 2 ** 10))


class MaskReader:
    def __init__(self, data, shape, fills):
        self.decoder, self.shape, self.fills = RangeDecoder(data), shape, fills
        self.predictor, self.last = Predictor(), 0
        self.mixed = {key: [2 ** 15] * 2 for key in itertools.product(range(4), (0, 1), (0, 1))}
        self.whole = {key: [2 ** 15] * 2 for key in itertools.product((0, 1), (0, 1))}
        self.stretches = [contexts(2, 64225) for _ in range(17)]
        self.samples = {key: [[start, start] for start in LEVEL_STARTS]
                        for key in itertools.product((0, 1), (0, 1))}
        self.fill_bits = [contexts(8) for _ in range(8)]

    def fill(self):
        bits, node = (self.fills - 1).bit_length(), 1
        for _ in range(bits):
            node = 2 * node | self.decoder.bit(self.fill_bits[self.last][node])
        self.last = node - 2 ** bits
        need(self.last < self.fills, "MASK: a fill")
        return 1 + self.last

    def cells(self):
        """Returns the common value of the block's samples, or None if they differ."""
        cells = {}
        for z, y, x in itertools.product(*(range(-(-n // 16)) for n in self.shape)):
            near = [cells[at] for at in ((z, y, x - 1), (z, y - 1, x), (z - 1, y, x)) if at in cells]
            masked, clear = int(any(near)), int(0 in near)
            if self.decoder.bit(self.mixed[near.count(None), masked, clear]):
                cells[z, y, x] = None
            else:
                cells[z, y, x] = self.fill() if self.decoder.bit(self.whole[masked, clear]) else 0
        return cells

    def row(self, line, above, width):
        """Appends a mixed block's row to line; above: the rows of the windows except the last."""
        end = len(line) + width
        while len(line) < end:
            at, left = len(line), line[-1]
            stretch = 0
            while at + stretch < end and all(row[x] == left for row in above[4:7] + above[9:]
                                             for x in range(at + stretch - 1, at + stretch + 2)):
                stretch += 1
            if stretch < 2:
                line.append(self.sample(line, above))
            elif not self.decoder.bit(self.stretches[stretch][left]):
                line += [left] * stretch
            else:
                while line[-1] == left:
                    line.append(self.sample(line, above) if len(line) < at + stretch - 1
                                else 1 - left)

    def sample(self, line, above):
        at = len(line)
        neighbours = [bit for row, (dx, _, _, count) in zip(above + [line], WINDOWS)
                      for bit in row[at + dx:at + dx + count]]
        level = self.predictor.level(np.array(neighbours))
        return self.decoder.bit(self.samples[above[9][at], line[-1]][level])

    def read(self):
        nz, ny, nx = self.shape
        which = np.zeros(self.shape, int)
        outside, cells = self.decoder.bit([2 ** 15] * 2), self.cells()
        # Slices of rows from y = -2 to ny + 1, from z = -2 on.
        sheets = [[[outside] * (nx + 2 * PAD)] * (ny + 4) for _ in range(2)]
        for z in range(nz):
            second, before = sheets[z], sheets[z + 1]
            sheet = [before[2], before[2]]
            sheets.append(sheet)
            for y in range(ny):
                line = [sheet[y + 1][PAD]] * PAD
                for x in range(0, nx, 16):
                    cell, width = cells[z // 16, y // 16, x // 16], min(16, nx - x)
                    if cell is not None:
                        line += [int(cell > 0)] * width
                        which[z, y, x:x + width] = cell
                        continue
                    self.row(line, second[y + 1:y + 4] + before[y:y + 5] + sheet[y:y + 2], width)
                    for i in range(x, x + width):
                        if line[PAD + i]:
                            which[z, y, i] = self.fill()
                sheet.append([line[PAD]] * PAD + line[PAD:] + [line[-1]] * PAD)
            sheet[:2] = [sheet[2]] * 2
            sheet += [sheet[-1]] * 2
        need(self.decoder.at - 7 <= len(self.decoder.data), "MASK: a brick's stream is damaged")
        return which


def read_mask(data, shape, fills):
    """0 if a sample has a value, else 1 + the number of its fill; [z][y][x]."""
    return MaskReader(data, shape, fills).read() if data else np.zeros(shape, int)


# ---- 14. CORR: the base --------------------------------------------------------------------------

def rounded(a):
    return a + 2 ** 19 >> 20


def exact_inverse(values):
    """Inverse transform of a sub-block's integers 2^F q[w, v, u]: along x, then y, then z."""
    for axis in (2, 1, 0):
        C = np.rint(2 ** 20 * dct_matrix(values.shape[axis])).astype(np.int64)
        values = rounded(np.moveaxis(np.tensordot(C, values, (0, axis)), 0, axis))
    return values


def exact_filter(v, axis):
    h = -81462, -242189, 100318, -140227
    a = np.moveaxis(v, axis, 0)
    for e in range(16, len(a) - 1, 16):
        inner, outer = a[e - 1] - a[e], a[e - 2] - a[e + 1]
        d0, d1 = rounded(h[0] * inner + h[1] * outer), rounded(h[2] * inner + h[3] * outer)
        a[e - 1] += d0
        a[e] -= d0
        a[e - 2] += d1
        a[e + 1] -= d1


def base_of(header, modes, v):
    base = header.offset + header.step * 2.0 ** -modes.fraction * v.astype(float)
    base = np.where(base < header.value_min, header.value_min, base)  # 0 is not below -0, and stays
    base = np.where(base > header.value_max, header.value_max, base)
    if header.type < 7:
        return np.floor(base + 0.5)
    return base.astype(np.float32).astype(float) if header.type == 7 else base


# ---- 15. CORR: the residual ----------------------------------------------------------------------

NUMBER_BOUNDS = [0, 1, 2, 3, 4, 6, 8, 11, 15, 20, 28, 40, 56, 80, 112]


def number_of(stream, total):
    """Decodes |k| in the context of a sum."""
    if total <= 160:
        level = sum(bound < total for bound in NUMBER_BOUNDS)
    else:
        e = total.bit_length() - 1
        level = 2 + 2 * e + (total >> e - 1 & 1)
    shift = 0 if level < 14 else 1 if level < 16 else (level - 2) // 2 - 5
    row = level if level < 24 else 22 + level % 2
    high = stream.token(ROW_NUMBER + row)
    if high == 15:
        r = stream.token(ROW_MORE_NUMBER + row)
        if r == 15:
            r += stream.raw(6)
        need(r <= 50, "CORR: a number")
        high = 2 ** r + stream.raw(r) + 14
    number = high << shift | stream.raw(shift)
    need(number < 2 ** 50, "CORR: a number")
    return number


class Reals:
    """Returns exact floats."""

    def __init__(self, header, modes):
        self.P, self.bias, self.lowest = (24, 127, -149) if header.type == 7 else (53, 1023, -1074)
        self.unit, self.grain = modes.unit, modes.grain

    def widening(self, base):
        if base == 0:
            return 0
        exponent = max(math.frexp(base)[1] - 1, -1023)
        return max(0, exponent - (self.P - 1) - self.unit)

    @staticmethod
    def cell(value, t):
        n = math.floor(math.ldexp(abs(value), -t))
        return -1 - n if math.copysign(1, value) < 0 else n

    def value(self, stream, cell, t):
        a = -1 - cell if cell < 0 else cell
        magnitude = self.far(stream, a, t) if a else self.near(stream, t)
        return -magnitude if cell < 0 else magnitude

    def far(self, stream, a, t):
        last = max(a.bit_length() - 1 + t - (self.P - 1), self.lowest, self.grain)
        return math.ldexp(a, t) + math.ldexp(stream.raw(max(0, t - last)), last)

    def near(self, stream, t):
        j = stream.token(ROW_DEEP)
        if j == 14:
            return 0.0
        field = t + self.bias - (1 + j if j < 14 else 15 + stream.raw(11))
        need(field >= 0, "CORR: an exponent")
        lowest = max(1, field) - self.bias - (self.P - 1)
        unused = min(self.P - 1, max(0, self.grain - lowest))
        mantissa = stream.raw(self.P - 1 - unused) << unused
        return math.ldexp(mantissa + (2 ** (self.P - 1) if field else 0), lowest)


def correct(header, modes, stream, base, which):
    """Returns a brick's samples; masked samples keep the base."""
    exact = modes.kind == EXACT and header.type >= 7
    samples = base.copy()
    lo, hi = header.value_min, header.value_max
    if not stream.data and not exact:
        return samples
    nz, ny, nx = base.shape
    reals = Reals(header, modes)
    W = [[[0] * (nx + 2) for _ in range(ny + 2)] for _ in range(nz + 1)]
    for z in range(nz):
        front = W[z]
        for y in range(ny):
            line, up, f = W[z + 1][y + 1], W[z + 1][y], front[y + 1]
            for x in range(nx):
                total = (2 * (line[x] + up[x + 1] + f[x + 1]) + up[x] + up[x + 2] + f[x] + f[x + 2]
                         + front[y][x + 1] + front[y + 2][x + 1])
                if z == 0:
                    total = min(2 * total, 2 ** 32 - 1)
                if which[z, y, x]:
                    line[x + 1] = min(total // 12, 2 ** 28 - 1)
                    continue
                here = float(base[z, y, x])
                s = reals.widening(here) if exact else 0
                k = number_of(stream, total >> s)
                line[x + 1] = min(k << s, 2 ** 28 - 1)
                k = -k if k and stream.raw(1) else k
                if exact:
                    t = reals.unit + s
                    value = reals.value(stream, reals.cell(here, t) + k, t)
                    need(lo <= value <= hi, "CORR: a sample")
                else:
                    value = min(max(here + modes.quantum * k, lo), hi)
                samples[z, y, x] = value
    stream.check_end()
    return samples


# ---- 24. CORR: labels ----------------------------------------------------------------------------

LOGITS = [bisect.bisect_left(LIKELIHOOD, 16 * z + 8) - 2048 for z in range(4096)]  # of a probability / 16


class LabelReader:
    def __init__(self, data, shape, most):
        self.decoder, self.raw = RangeDecoder(data), Stream(data, None)
        self.predictor, self.shape, self.most = Predictor(), shape, most
        self.list, self.recent = [], []
        self.stretches = contexts(7, 64225)
        self.likely = {key: [[start, start] for start in LEVEL_STARTS] for key in itertools.product((0, 1), (0, 1))}
        self.patterns = {}
        self.others = [[start, start] for start in LEVEL_STARTS]
        self.last, self.new, self.lengths = contexts(6, 60000), [2 ** 15] * 2, contexts(16)

    def new_label(self):
        number = self.raw.raw(self.most.bit_length())
        need(number <= self.most and len(self.list) < 4096, "CORR: a label")
        self.list.append(number)
        self.recent.append(len(self.list) - 1)
        return len(self.list) - 1

    def known_label(self, candidates):
        j = 0
        while self.decoder.bit(self.lengths[j]):
            j += 1
            need(j < 16, "CORR: a rank")
        rank = 2 ** j + self.raw.raw(j) - 1
        others = [label for label in self.recent if label not in candidates]
        need(rank < len(others), "CORR: a rank")
        return others[rank]

    def level(self, line, above, label):
        at = len(line)
        neighbours = [int(near == label) for row, (dx, _, _, count) in zip(above + [line], WINDOWS)
                      for near in row[at + dx:at + dx + count]]
        return self.predictor.level(np.array(neighbours))

    def likely_bit(self, line, above, label):
        at, level = len(line), self.level(line, above, label)
        near = (line[at - 2], line[at - 1], *above[9][at - 1:at + 2], *above[5][at - 1:at + 2], above[4][at],
                above[6][at], above[8][at], above[1][at])
        pattern = tuple(int(other == label) for other in near)
        first = self.likely[pattern[3], pattern[1]][level]
        second = self.patterns.setdefault(pattern, [LEVEL_STARTS[level]] * 2)
        logits = [LOGITS[sum(context) >> 5] for context in (first, second)]
        logit = max(-2048, min(2047, (45 * logits[0] + 26 * logits[1]) >> 6))
        bit = self.decoder.likely(2 ** 16 - LIKELIHOOD[logit + 2048])
        for context in (first, second):
            update(context, bit)
        return bit

    def choose(self, line, above, differs):
        """Returns the label of the next sample; above: the rows of the windows except the last."""
        at, left = len(line), line[-1]
        upper, before, lower, up = above[4], above[5], above[6], above[9]
        candidates = [up[at] if left not in (up[at], before[at]) and up[at] == before[at] else left]
        for label in (up[at], before[at], left, up[at + 1], before[at + 1], lower[at], up[at - 1], upper[at],
                      lower[at + 1]):
            if label not in candidates:
                candidates.append(label)
        n = len(candidates)
        if not differs and self.likely_bit(line, above, candidates[0]):
            return candidates[0]
        for label in candidates[1:-1]:
            if self.decoder.bit(self.others[self.level(line, above, label)]):
                return label
        if n > 1 and not self.decoder.bit(self.last[min(n, 5)]):
            return candidates[-1]
        if len(self.list) == n or self.decoder.bit(self.new):
            return self.new_label()
        return self.known_label(candidates)

    def sample(self, line, above, differs=False):
        label = self.choose(line, above, differs)
        self.recent.remove(label)
        self.recent.insert(0, label)
        line.append(label)

    def row(self, line, above, end):
        """Appends samples to the line until it has `end`."""
        while len(line) < end:
            at, left, stretch = len(line), line[-1], 0
            while at + stretch < end and all(row[x] == left for row in above[4:7] + above[9:]
                                             for x in range(at + stretch - 1, at + stretch + 2)):
                stretch += 1
            if stretch < 2:
                self.sample(line, above)
            elif not self.decoder.bit(self.stretches[stretch.bit_length() - 1]):
                line += [left] * stretch
            else:
                while line[-1] == left and len(line) < at + stretch:
                    self.sample(line, above, len(line) == at + stretch - 1)

    def read(self):
        nz, ny, nx = self.shape
        out = np.zeros(self.shape, np.int64)
        outside = self.new_label()
        # Slices of rows from y = -2 to ny + 1, from z = -2 on.
        sheets = [[[outside] * (nx + 2 * PAD)] * (ny + 4) for _ in range(2)]
        for z in range(nz):
            second, before = sheets[z], sheets[z + 1]
            sheet = [before[2], before[2]]
            sheets.append(sheet)
            for y in range(ny):
                line = [sheet[y + 1][PAD]] * PAD
                self.row(line, second[y + 1:y + 4] + before[y:y + 5] + sheet[y:y + 2], PAD + nx)
                out[z, y] = [self.list[label] for label in line[PAD:]]
                sheet.append([line[PAD]] * PAD + line[PAD:] + [line[-1]] * PAD)
            sheet[:2] = [sheet[2]] * 2
            sheet += [sheet[-1]] * 2
        used = self.decoder.at - 7 + (self.raw.bits + 7) // 8
        need(used <= len(self.decoder.data), "CORR: a brick's stream is damaged")
        return out


def box_of(sides, place, dims):
    """Returns the samples of a brick, as slices of z, y, x."""
    return tuple(slice(sides[a] * place[a], min(sides[a] * (place[a] + 1), dims[a])) for a in (2, 1, 0))


def corrected(header, modes, sections, bricks, sides, data, rows, v):
    """Returns all samples of a volume, in its type, from the integers of the base; data: the bricks of CORR, and
    the mask."""
    kind = TYPES[header.type]
    nx, ny, nz = header.dims
    if modes.kind == PACKED:
        content, checksum = sections["CORR"]
        need(checksum == crc32c(content), "CORR: the checksum does not hold")
        size = nx * ny * nz * np.dtype(kind).itemsize
        need(size <= 2 ** 26, "CORR packs too much")
        return np.frombuffer(unpack(content, size), kind).reshape(nz, ny, nx).copy()
    out = np.zeros((nz, ny, nx), kind)
    if modes.kind == LABELS:
        lo, hi = int(header.value_min), int(header.value_max)
    else:
        base = base_of(header, modes, v)
    for number in range(math.prod(bricks)):
        at = number % bricks[0], number // bricks[0] % bricks[1], number // bricks[0] // bricks[1]
        box = box_of(sides, at, header.dims)
        if modes.kind == LABELS:
            bytes_of_it = data["CORR"][number]
            out[box] = (lo + LabelReader(bytes_of_it, out[box].shape, hi - lo).read() if bytes_of_it
                        else modes.quantum)
            continue
        which = data["which"][box]
        out[box] = correct(header, modes, Stream(data["CORR"][number], rows), base[box],
                           which).astype(kind)
    return out


# ---- 23. PACK ------------------------------------------------------------------------------------

ONE, FOUR = 0x3FF0 << 48, 0x4010 << 48
BEFORE = None  # the default is the value of the field before
# (tag, usually present, default length, fields); a field: (bytes, class, default value).
FRONT = (
    ("HEAD", 1, 88, ((8, 1, 0), (8, 1, BEFORE), (8, 1, BEFORE), (4, 1, 1), (4, 0, 1), (4, 0, 3), (4, 0, 16), (4, 1, 0),
                     (4, 0, 1), (8, 3, FOUR), (8, 3, 0), (8, 2, BEFORE), (8, 3, FOUR), (8, 1, 0))),
    ("GEOM", 1, 156, ((4, 0, 0), (8, 2, ONE), (8, 2, BEFORE), (8, 2, BEFORE), *[(8, 2, 0)] * 3,
                      *[(8, 2, 0 if i % 4 else ONE) for i in range(9)], (8, 0, 0), (8, 0, 0), (8, 2, ONE), (8, 2, 0))),
    ("ATTR", 0, 0, ()),
    ("ERRS", 1, 76, (*[(8, 3, FOUR)] * 4, (8, 2, 0), (8, 3, FOUR), *[(8, 3, 0)] * 3, (4, 0, 1))),
    ("MODE", 0, 32, ((4, 1, 0), (4, 1, 0), (8, 3, ONE), *[(4, 1, 0)] * 4)),
    ("BRKS", 0, 16, ((4, 1, 64), (4, 1, BEFORE), (4, 1, BEFORE), (4, 1, 1))),
    ("TRUE", 1, 4, ((4, 0, 2),)),
    ("SMAL", 0, 4, ((4, 0, 1),)),
    ("SUMM", 1, 14, ()),
    ("RNGE", 0, 0, ()),
    ("TABL", 1, 9, ()),
    ("INDX", 1, 20, ()),
    ("CORR", 0, 12, ((8, 1, 0), (4, 1, 0))))


class FrontReader:
    def __init__(self, front):
        self.coded, self.raw, self.size = RangeDecoder(front), Stream(front, None), len(front)
        self.there, self.length = [57344] * 2, [2 ** 15] * 2
        self.differs = [[start] * 2 for start in (64512, 2 ** 15, 64512, 16384)]
        self.count, self.top = [contexts(8) for _ in range(4)], [contexts(256) for _ in range(4)]
        self.other, self.value = [[57344] * 2, [16384] * 2], contexts(256)

    def tree(self, nodes, bits):
        node = 1
        for _ in range(bits):
            node = 2 * node + self.coded.bit(nodes[node])
        return node - 2 ** bits

    def difference(self, kind):
        if not self.coded.bit(self.differs[kind]):
            return 0
        m = 1 + self.tree(self.count[kind], 3)
        number = self.tree(self.top[kind], 8)
        for _ in range(m - 1):
            number = number << 8 | self.raw.raw(8)
        return number << 8 * (8 - m) if kind >= 2 else number

    def content(self, length, fields):
        out, value = bytearray(), 0
        for width, kind, usual in fields:
            value = (value if usual is BEFORE else usual) ^ self.difference(kind)
            value &= 2 ** (8 * width) - 1
            out += value.to_bytes(width, "little")
        other = 1
        while len(out) < length:
            other = self.coded.bit(self.other[other])
            out.append(self.tree(self.value, 8) if other else 0)
        return bytes(out)

    def sections(self):
        """Returns {tag: content}."""
        found, total = {}, 0
        for tag, usual, usual_length, fields in FRONT:
            if self.coded.bit(self.there) == usual:
                continue
            length = usual_length
            if self.coded.bit(self.length):
                bits = self.raw.raw(5)
                length = 2 ** bits + self.raw.raw(bits) - 1
            total += length
            need(total <= 2 ** 17, "PACK: a section is too long")
            found[tag] = self.content(length, fields if length >= usual_length else ())
        need(self.coded.at - 7 + -(-self.raw.bits // 8) <= self.size, "PACK is too short")
        return found


def put_section(tag, content, length=None, checksum=None):
    """Returns the section as in an unpacked file; `content` may be shorter than `length`."""
    checksum = crc32c(content) if checksum is None else checksum
    start = struct.pack("<4sIQI", tag.encode(), 0 if tag in OPTIONAL else 1,
                        len(content) if length is None else length, checksum)
    return start + struct.pack("<I", crc32c(start)) + content


def unpack_file(data):
    """Returns the file without PACK; truncated if the file is."""
    need(len(data) >= 36, "is cut off in PACK's header")
    tag, flags, length, checksum, own = struct.unpack_from("<4sIQII", data, 12)
    need(flags == 1 and own == crc32c(data[12:32]), "PACK: its header")
    need(len(data) <= 36 + length, "goes on behind its end")
    size, at, shift = 0, 36, 0
    while at == 36 or data[at - 1] >= 128:
        need(at < len(data) and shift < 64, "is cut off in PACK")
        size |= (data[at] & 127) << shift
        at, shift = at + 1, shift + 7
    end = at + size
    need(end <= len(data), "is cut off in PACK")
    need(checksum == crc32c(data[36:end]), "PACK: the checksum does not hold")
    found = FrontReader(data[at:end]).sections()
    out = data[:12] + b"".join(put_section(tag, content) for tag, content in found.items() if tag != "CORR")
    header = Header(found["HEAD"], found["GEOM"], found["ERRS"])
    modes = Modes(header, found.get("MODE"))
    need(header.is_volume(), "PACK is for volumes")
    sides, run = read_shape(header, found.get("BRKS"))
    bricks = math.prod(-(-n // side) for n, side in zip(header.dims, sides))
    others = ["MASK"] * (len(modes.fills) > 0) + ["CORR"] * (modes.kind in (BOUNDED, EXACT, LABELS))
    lengths, sums = read_index(found["INDX"], bricks, run, len(others))
    streams = {tag: (sum(n), crc32c(struct.pack(f"<{len(s)}I", *s)))
               for tag, n, s in zip(SHELLS + others, lengths, sums)}
    need((modes.kind == PACKED) == ("CORR" in found), "PACK: CORR")
    if modes.kind == PACKED:
        need(len(found["CORR"]) == 12, "PACK: CORR")
        streams["CORR"] = struct.unpack("<QI", found["CORR"])
    need(end - 36 + sum(size for size, _ in streams.values()) == length, "PACK: its length")
    for tag in ["MASK"] + SHELLS + ["CORR"]:
        if tag in streams:
            size, checksum = streams[tag]
            out += put_section(tag, data[end:end + size], size, checksum)
            if end + size > len(data):
                return out
            end += size
    return out + put_section("ENDS", b"")


# ---- the three kinds of files --------------------------------------------------------------------

def read_volume(header, sections, shells):
    """Returns the final samples."""
    B, dims = header.block, header.dims
    check_kind(sections, ["HEAD", "GEOM", "ATTR", "ERRS", *OF_VOLUMES])
    modes = Modes(header, sections["MODE"][0] if "MODE" in sections else None)
    length_bits = read_true_length(header, sections["TRUE"][0] if "TRUE" in sections else None, modes)
    step = header.step / 2 ** length_bits
    streams = ["MASK"] * (len(modes.fills) > 0) + ["CORR"] * (modes.kind in (BOUNDED, EXACT, LABELS))
    if shells < 4:
        modes.kind = 0
    sides, run = read_shape(header, sections["BRKS"][0] if "BRKS" in sections else None)
    bricks = [-(-n // side) for n, side in zip(dims, sides)]
    rows = read_tables(sections["TABL"][0])
    neural_rows = Rows(neural_codes())
    if "SMAL" in sections:
        content = sections["SMAL"][0]
        need(len(content) >= 4 and header.trellis, "SMAL: not of such a volume, or too short")
        need(content[:4] == b"\1\0\0\0", "SMAL: the networks")
    lengths, sums = read_index(sections["INDX"][0], math.prod(bricks), run, len(streams))
    data = [cut_bricks(*sections[tag], lengths[s], sums[s], run, tag)
            for s, tag in enumerate(SHELLS[:shells])]
    others = {tag: cut_bricks(*sections[tag], lengths[4 + s], sums[4 + s], run, tag)
              for s, tag in enumerate(streams) if tag in sections}
    if "SUMM" in sections:
        read_summary(sections["SUMM"][0], math.prod(dims))
    if "RNGE" in sections and shells == 4:
        check_ranges(header, sections["RNGE"][0])
    blocks = header.blocks()
    samples, terms = np.zeros([B * n for n in reversed(blocks)]), 0
    integers = np.zeros(samples.shape if modes.kind in (BOUNDED, EXACT) else (0, 0, 0), np.int64)
    which = np.zeros(dims[::-1], int)
    for number in range(math.prod(bricks)):
        place = number % bricks[0], number // bricks[0] % bricks[1], number // bricks[0] // bricks[1]
        first = [sides[a] // B * place[a] for a in range(3)]
        counts = [min(sides[a] // B, blocks[a] - first[a]) for a in range(3)]
        weight = {}
        coded = [shell[number] for shell in data]
        inside = [dims[a] - B * first[a] for a in range(3)]
        if "SMAL" in sections:
            brick = NeuralBrick([NeuralStream(shell, neural_rows) for shell in coded], counts, header, length_bits,
                                inside)
        else:
            brick = Brick([Stream(shell, rows) for shell in coded], counts, header, length_bits, inside)
        for block, side, begin, values in brick.decode():
            x, y, z = (B * (first[a] + block[a]) + begin[a] for a in range(3))
            samples[z:z + side, y:y + side, x:x + side] = inverse_dct(step * values)
            if integers.size:
                integers[z:z + side, y:y + side, x:x + side] = exact_inverse(
                    values << modes.fraction)
            terms += np.count_nonzero(values)
            weight[block] = weight.get(block, 0) + int(np.abs(values).sum())
        need(max(weight.values()) * step < FLOAT32_MAX, "terms are too large")
        need(not integers.size or max(weight.values()) << modes.fraction <= 2 ** 31, "MODE: fraction")
        if modes.fills:
            box = box_of(sides, place, dims)
            which[box] = read_mask(others["MASK"][number], which[box].shape, len(modes.fills))
    need(shells < 4 or terms == header.coefficients, "the number of coefficients")
    samples = np.ascontiguousarray(crop(header, samples))
    for axis in (2, 1, 0) if header.lapped else ():
        post_filter(samples, axis)
    samples = finish(header, samples)
    if modes.kind:
        integers = np.ascontiguousarray(crop(header, integers))
        for axis in (2, 1, 0) if header.lapped and integers.size else ():
            exact_filter(integers, axis)
        samples = corrected(header, modes, sections, bricks, sides, {**others, "which": which}, rows,
                            integers)
    for fill, bits in enumerate(modes.fills):
        value = np.frombuffer(struct.pack("<Q", bits), samples.dtype.str, 1)
        samples[which == fill + 1] = value[0]
    return samples


def read_blocks(header, content):
    """Decodes TERM."""
    B, rank, blocks = header.block, header.rank, header.blocks()
    count, terms = math.prod(blocks), header.coefficients
    raw = unpack(content, 4 * count + 6 * terms)
    counts, at = planes(raw, 0, count, 4)
    places, at = planes(raw, at, terms, 2)
    folded, at = planes(raw, at, terms, 4)
    need(int(counts.astype(np.uint64).sum()) == terms, "TERM: the number of terms")
    values = [-(int(v) // 2) - 1 if v & 1 else int(v) // 2 for v in folded]
    shape = [B if a < rank else 1 for a in (2, 1, 0)]
    samples, t = np.zeros([n * s for n, s in zip(reversed(blocks), shape)]), 0
    for b in range(count):
        slots, place, total = np.zeros(B ** rank), -1, 0
        for _ in range(counts[b]):
            place += int(places[t]) + 1
            need(place < B ** rank and 0 < abs(values[t]) <= VALUE_LIMIT, "TERM: a term")
            slots[place] = values[t]
            total += abs(values[t])
            t += 1
        need(total * header.step < FLOAT32_MAX, "terms are too large")
        i, j, l = b % blocks[0], b // blocks[0] % blocks[1], b // blocks[0] // blocks[1]
        z, y, x = l * shape[0], j * shape[1], i * shape[2]
        samples[z:z + shape[0], y:y + shape[1], x:x + shape[2]] = inverse(
            header.transform, header.step * slots.reshape(shape))
    return crop(header, samples)


def read_whole(header, content):
    """Decodes SPEC."""
    dims = header.dims
    need(len(content) >= 32, "SPEC is too short")
    k = struct.unpack_from("<3Q", content)
    s, = struct.unpack_from("<Q", content, 24)
    widths = [k[a] if header.transform == 1 else min(2 * k[a] - 1, dims[a]) if k[a] else 0
              for a in range(3)]
    for a in range(3):
        most = dims[a] if header.transform == 1 else dims[a] // 2 + 1
        need(k[a] <= most and (k[a] == 0) == (k[0] == 0), "SPEC: k")
    low = math.prod(widths)
    need(low + s == header.coefficients, "the number of coefficients")
    need(s <= math.prod(dims) - low, "SPEC: s")
    raw = unpack(content[32:], 4 * low + 8 * s)
    box, at = planes(raw, 0, low, 4)
    gaps, at = planes(raw, at, s, 4)
    others, at = planes(raw, at, s, 4)
    slots = np.zeros(math.prod(dims))
    index = [[i if i < k[a] else dims[a] - widths[a] + i for i in range(widths[a])]
             for a in range(3)]
    inside = np.array([u + dims[0] * (v + dims[1] * w) for w in index[2] for v in index[1]
                       for u in index[0]], int)
    places = np.cumsum(gaps.astype(np.int64) + 1) - 1
    need(s == 0 or places[-1] < slots.size, "SPEC: a place")
    need(not np.isin(places, inside).any(), "SPEC: a place in the low box")
    slots[inside] = box.view("<f4")
    slots[places] = others.view("<f4")
    need(np.abs(slots).sum() < FLOAT32_MAX / 16, "terms are too large")
    return inverse(header.transform, slots.reshape(dims[::-1]))


# ---- 17. and 18. pictures ------------------------------------------------------------------------

class PlaneReader:
    """Decodes the numbers of planes, tile by tile."""

    THRESHOLDS = 0, 1, 2, 3, 4, 6, 8, 11, 15, 20, 28, 40, 60, 100, 200
    BANDS = 0, 1, 2, 4, 8, 14, 22, 32, 48

    def __init__(self, content, transform, classes):
        self.coded, self.raw, self.length = RangeDecoder(content), Stream(content, None), len(content)
        self.transform = transform

        def contexts(*shape):
            return ([contexts(*shape[1:]) for _ in range(shape[0])] if shape
                    else [2 ** 15, 2 ** 15])
        self.classes = [{"empty": contexts(4), "zero": contexts(10, 16), "more": contexts(16, 15),
                         "length": contexts(24), "rows": contexts(32), "columns": contexts(32)}
                        for _ in range(classes)]

    def number(self, context, band, level):
        if not self.coded.bit(context["zero"][band][level]):
            return 0
        m = 1
        while m <= 15 and self.coded.bit(context["more"][level][m - 1]):
            m += 1
        if m == 16:
            n = 0
            while n < 30 and self.coded.bit(context["length"][min(n, 23)]):
                n += 1
            m = 15 + 2 ** n + self.raw.raw(n)
        return -m if self.raw.raw(1) else m

    def frequency(self, i, n):
        return 64 * i // n if self.transform == 1 else 128 * min(i, n - i) // n

    def reach(self, contexts, count):
        node, bit = 1, count // 2
        while bit:
            node = 2 * node + self.coded.bit(contexts[node])
            bit //= 2
        return node - count + 1

    def tile(self, context, w, h, left, above, whole, before):
        """Returns q[j, i]; left, above, before: neighbouring tiles, or None."""
        known = [int(t[0, 0]) for t in (left, above) if t is not None]
        prediction = sum(known) // len(known) if known else 0
        busy = [int(t is not None and np.count_nonzero(t.ravel()[1:]) > 0) for t in (left, above)]
        q = np.zeros((h, w), np.int64)
        if self.coded.bit(context["empty"][busy[0] + 2 * busy[1]]):
            across = [self.frequency(i, w) for i in range(w)]
            sizes = np.zeros((h + 2, w + 3), int)  # of q[j, i] at [j + 2, i + 2]
            neighbours = np.zeros((h, w), int)
            for t in (left, above):
                if t is not None:
                    neighbours += np.minimum(np.abs(t), 4095)
            neighbours[0, 0] = 0
            if before is not None:
                neighbours += 2 * np.minimum(np.abs(before), 4095)
            columns = w if whole else self.reach(context["columns"], w)
            rows = h if whole else self.reach(context["rows"], h)
            neighbours, sizes = neighbours.tolist(), sizes.tolist()
            for j in range(rows):
                down = self.frequency(j, h)
                row, up, upper = sizes[j + 2], sizes[j + 1], sizes[j]
                for i in range(columns):
                    total = (2 * (row[i + 1] + up[i + 2]) + row[i] + upper[i + 2] + up[i + 1]
                             + up[i + 3] + neighbours[j][i])
                    if whole and self.transform != 1:
                        other = -i % w, -j % h
                        if other[0] + w * other[1] < i + w * j:
                            total += 2 * sizes[other[1] + 2][other[0] + 2]
                    level = sum(bound < total for bound in self.THRESHOLDS)
                    band = sum(bound < across[i] + down for bound in self.BANDS)
                    value = self.number(context, band, level)
                    need(abs(value) <= 2 ** (29 if i + j else 30), "PLNS: a number")
                    q[j, i] = value
                    row[i + 2] = min(abs(value), 4095)
        q[0, 0] += prediction
        need(abs(q[0, 0]) <= 2 ** 29, "PLNS: a number")
        return q

    def plane(self, kind, dims, block, step, before=None):
        """Returns samples [q, p] of a plane of the class `kind`, and its tiles."""
        w, h = (block, block) if block else dims
        across, down = -(-dims[0] // w), -(-dims[1] // h)
        tiles, samples = {}, np.zeros((down * h, across * w))
        for j in range(down):
            for i in range(across):
                tiles[i, j] = self.tile(self.classes[kind], w, h, tiles.get((i - 1, j)),
                                        tiles.get((i, j - 1)), not block,
                                        before[i, j] if before else None)
        used = max(self.coded.at - 7, 0) + (self.raw.bits + 7) // 8
        need(used <= self.length, "PLNS is too short")
        total = sum(int(np.abs(q).sum()) for q in tiles.values())
        need(total * step < FLOAT32_MAX / 16, "terms are too large")
        for (i, j), q in tiles.items():
            samples[h * j:h * j + h, w * i:w * i + w] = inverse(self.transform, step * q[None])[0]
        return samples[:dims[1], :dims[0]], tiles


def spline_filter(s, axis):
    z = -0.26794919
    c = np.moveaxis(np.array(s), axis, 0)
    carry = np.zeros_like(c[0])
    for i in range(len(c)):
        c[i] = carry = 6 * c[i] + z * carry
    carry = carry * z * z / (z * z - 1)
    for i in reversed(range(len(c))):
        c[i] = carry = z * (carry - c[i])
    return np.moveaxis(c, 0, axis)


def spline_values(c, u, v):
    """Interpolates at positions (u, v), arrays of one shape; c[q, p, channel] is zero outside."""
    def basis(t):
        t = np.abs(t)
        return np.where(t <= 1, (4 - 6 * t ** 2 + 3 * t ** 3) / 6,
                        np.where(t <= 2, (2 - t) ** 3 / 6, 0))

    i0, j0 = np.floor(u).astype(int), np.floor(v).astype(int)
    out = np.zeros(u.shape + c.shape[2:])
    for dj in range(-1, 3):
        for di in range(-1, 3):
            i, j = i0 + di, j0 + dj
            inside = (i >= 0) & (i < c.shape[1]) & (j >= 0) & (j < c.shape[0])
            values = c[np.clip(j, 0, c.shape[0] - 1), np.clip(i, 0, c.shape[1] - 1)]
            out += (inside * basis(u - i) * basis(v - j))[..., None] * values
    return out


def read_picture(data):
    """Returns (properties, pixels[y, x, channel])."""
    sections = read_sections(data, "ENDS")
    head = sections["PICT"][0]
    need(len(head) >= 112, "PICT is too short")
    width, height, P, Q, transform, block, count, over = struct.unpack_from("<8I", head)
    m, background = struct.unpack_from("<6d", head, 32), struct.unpack_from("<3d", head, 80)
    psnr, = struct.unpack_from("<d", head, 104)
    need(0 < width <= 32768 and 0 < height <= 32768 and 0 < P <= 65536 and 0 < Q <= 65536
         and transform in (1, 2, 3) and block in (0, 8, 16, 32) and count in (3, 4)
         and over in ((0, 1) if count == 4 else (0,)) and (over or (P, Q) == (width, height))
         and all(map(math.isfinite, m)) and all(0 <= b <= 1 for b in background)
         and len(head) >= 112 + 32 * count, "PICT: a field")
    reader = PlaneReader(sections["PLNS"][0], transform, 3)
    mixed = []
    for c in range(count):
        step, l2_error, least, most = struct.unpack_from("<4d", head, 112 + 32 * c)
        need(0 < step <= 1e30 and 0 <= l2_error <= 1e30 and -1e30 <= least <= most <= 1e30,
             "PICT: a plane")
        mixed.append(reader.plane((0, 1, 1, 2)[c], (P, Q), block, step)[0])
    a, b, c = mixed[0] / math.sqrt(3), mixed[1] / math.sqrt(2), mixed[2] / math.sqrt(6)
    levels = np.stack([a + b + c, a - 2 * c, a - b + c] + mixed[3:], 2)
    if over:
        coefficients = spline_filter(spline_filter(levels, 1), 0)
        x, y = np.meshgrid(np.arange(width), np.arange(height))
        values = spline_values(coefficients, m[0] * x + m[1] * y + m[2], m[3] * x + m[4] * y + m[5])
        through = 1 - np.clip(values[..., 3:], 0, 1)
        levels = np.maximum(values[..., :3], 0) + through * np.array(background)
    if levels.shape[2] == 3:
        levels = np.concatenate([levels, np.ones((height, width, 1))], 2)
    pixels = np.floor(255 * np.clip(levels, 0, 1) + 0.5).astype(np.uint8)
    return {"width": width, "height": height, "lattice": [P, Q], "over": over,
            "psnr_db": min(psnr, 999)}, pixels


# ---- 19. baked volumes ---------------------------------------------------------------------------

def read_baked(data):
    """Returns (properties, planes[slice, opacity or channel, y, x])."""
    sections = read_sections(data, "ENDS")
    head, content = sections["BAKE"][0], sections["PLNS"][0]
    need(len(head) >= 160, "BAKE is too short")
    dims, spacing = struct.unpack_from("<3I", head), struct.unpack_from("<3d", head, 16)
    axis, transform, block, channels, lit, footprint, size, points = struct.unpack_from("<8I", head,
                                                                                        40)
    distance, rho, step, sigma, *light = struct.unpack_from("<7d", head, 72)
    name = head[128:160].split(b"\0")[0].decode("latin1")
    need(head[159] == 0 and all("!" <= c <= "~" for c in name), "BAKE: the name")
    need(all(0 < n <= 65536 for n in dims) and 1 <= struct.unpack_from("<I", head, 12)[0] <= 8
         and all(1e-30 < s < 1e30 for s in spacing) and axis < 3 and transform == 1
         and block in (0, 8, 16, 32) and channels in (1, 3) and lit < 2 and footprint in (1, 3, 4)
         and 3 <= size <= 31 and 0 < points <= 65536 and len(head) >= 160 + 40 * points
         and 1e-6 < distance < 1e6 and 0 < rho <= 1 and 0 < step <= 1e30
         and (sigma == 0 or 0.2 <= sigma <= 31) and all(abs(x) <= 1e30 for x in light),
         "BAKE: a field")
    transfer = np.frombuffer(head, "<f8", 5 * points, 160).reshape(points, 5)
    need(np.isfinite(transfer).all() and (np.diff(transfer[:, 0]) >= 0).all()
         and ((transfer[:, 1:] >= 0) & (transfer[:, 1:] <= 1)).all(), "BAKE: a point")
    plane_dims = [n for a, n in enumerate(dims) if a != axis]
    slices, planes = dims[axis], channels + 1
    runs = -(-slices // 16)
    need(len(content) >= 4 * (slices * planes + runs), "PLNS is too short")
    bounds = np.frombuffer(content, "<f4", slices * planes).reshape(slices, planes)
    need(((bounds >= -1) & (bounds <= 1e30)).all(), "PLNS: a bound")
    need(((bounds < 0) == (bounds[:, :1] < 0)).all(), "PLNS: a bound")
    lengths = struct.unpack_from(f"<{runs}I", content, 4 * slices * planes)
    at = 4 * (slices * planes + runs)
    need(at + sum(lengths) == len(content), "PLNS: a run's length")
    out = np.zeros((slices, planes, plane_dims[1], plane_dims[0]), "<f4")
    terms = 0
    for run, length in enumerate(lengths):
        reader = PlaneReader(content[at:at + length], transform, 2)
        at += length
        for k in range(16 * run, min(16 * run + 16, slices)):
            before = None
            for i in range(planes if bounds[k, 0] >= 0 else 0):
                out[k, i], before = reader.plane(int(i > 0), plane_dims, block, step, before)
                terms += sum(np.count_nonzero(q) for q in before.values())
    return {"dims": dims, "axis": "xyz"[axis], "slices": slices, "planes": planes, "transfer": name,
            "rho": rho, "lit": lit, "coefficients": int(terms)}, out


def read_attributes(content):
    """Returns the attributes; a decoder of samples only needs them to be text."""
    try:
        text = content.decode()
    except UnicodeDecodeError:
        raise Damaged("ATTR is no text") from None
    need("\0" not in text and len(content) <= 2 ** 24, "ATTR is no text, or too long")
    try:
        return json.loads(text)
    except ValueError:
        return None


def decode(data, level=0):
    """Returns (header, attributes, samples[z, y, x])."""
    shells = 4 - level
    sections = read_sections(data, SHELLS[shells - 1] if level else "ENDS")
    header = Header(*(sections[tag][0] for tag in ("HEAD", "GEOM", "ERRS")))
    if level and "MODE" in sections and Modes(header, sections["MODE"][0]).kind == LABELS:
        return decode(data)  # labels have no coarse levels
    attributes = read_attributes(sections["ATTR"][0]) if "ATTR" in sections else None
    if header.is_volume():
        return header, attributes, read_volume(header, sections, shells)
    terms, read = ("TERM", read_blocks) if header.block else ("SPEC", read_whole)
    check_kind(sections, ["HEAD", "GEOM", "ATTR", "ERRS", terms])
    return header, attributes, finish(header, read(header, sections[terms][0]))


# ---- 20. files of many volumes -------------------------------------------------------------------

def text_of(padded, what):
    text, zero, rest = padded.partition(b"\0")
    need(zero and not rest.strip(b"\0"), f"LIST: {what} has no end")
    return text.decode(errors="replace")


def read_volume_of(data, time, channel, level=0):
    """Returns the file of one volume, and the properties of its time and channel. For a coarse level the file of many
    volumes may end within this volume."""
    need(len(data) >= 36, "is cut off in its list's header")
    tag, flags, length, checksum, own = struct.unpack_from("<4sIQII", data, 12)
    need(tag == b"LIST" and flags == 1 and own == crc32c(data[12:32]), "LIST: its header")
    content = data[36:36 + length]
    need(len(content) == length and checksum == crc32c(content), "LIST: the checksum does not hold")
    need(length >= 24, "LIST is too short")
    times, channels = struct.unpack_from("<2I", content)
    count = times * channels
    need(0 < count <= 2 ** 20, "LIST: times or channels")
    need(length >= 24 + 88 * channels + 8 * times + 16 * count, "LIST is too short")
    unit = text_of(content[8:24], "the unit")
    colours, names, at = [], [], 24
    for _ in range(channels):
        colours.append(struct.unpack_from("<3d", content, at))
        names.append(text_of(content[at + 24:at + 88], "a name"))
        need(all(0 <= part <= 1 for part in colours[-1]), "LIST: a colour")
        at += 88
    values = struct.unpack_from(f"<{times}d", content, at)
    need(all(map(math.isfinite, values)), "LIST: a time")
    extents = struct.unpack_from(f"<{2 * count}Q", content, at + 8 * times)
    end = 36 + length
    for offset, size in zip(extents[::2], extents[1::2]):
        need(offset >= end + 24, "LIST: volumes overlap")
        end = offset + size
    need(0 <= time < times and 0 <= channel < channels, "there is no such time or channel")
    number = 2 * (channel + channels * time)
    offset, size = extents[number:number + 2]
    need(offset + size <= len(data) or (level and offset < len(data)), "is cut off in the volume")
    tag, flags, length, checksum, own = struct.unpack_from("<4sIQII", data, offset - 24)
    volume = data[offset:offset + size]
    need(tag == b"VOLM" and flags == 1 and length == size and
         own == crc32c(data[offset - 24:offset - 4]), "LIST: there is no such volume")
    need(len(volume) < size or checksum == crc32c(volume), "VOLM: the checksum does not hold")
    need(volume[12:16] not in (b"LIST", b"PICT", b"BAKE"), "VOLM is no volume")
    return volume, {"times": times, "channels": channels, "time": values[time], "time_unit": unit,
                    "channel_name": names[channel], "channel_colour": colours[channel]}


def main():
    parser = argparse.ArgumentParser(description="Decodes a .cvol file (doc/format.md).")
    parser.add_argument("file")
    parser.add_argument("out")
    parser.add_argument("--level", type=int, default=0, choices=range(4))
    parser.add_argument("--time", type=int, default=0)
    parser.add_argument("--channel", type=int, default=0)
    arguments = parser.parse_args()
    place = {}
    with open(arguments.file, "rb") as file:
        data = file.read()
    try:
        if data[12:16] == b"PICT":
            says, pixels = read_picture(data)
            pixels.tofile(arguments.out)
            print(json.dumps(says))
            return
        if data[12:16] == b"BAKE":
            says, samples = read_baked(data)
            samples.tofile(arguments.out)
            print(json.dumps(says))
            return
        if data[12:16] == b"LIST":
            data, place = read_volume_of(data, arguments.time, arguments.channel, arguments.level)
        header, attributes, samples = decode(data, arguments.level)
    except (Damaged, KeyError) as error:
        sys.exit(f"decoder_ref: {arguments.file}: {error}")
    samples.tofile(arguments.out)
    print(json.dumps({"dims": header.dims, "type": NAMES[header.type], "spacing": header.spacing,
                      "origin": header.origin, "directions": header.direction,
                      "space": ["unknown", "LPS", "RAS"][header.space], "unit": header.unit,
                      "value_min": header.value_min, "value_max": header.value_max,
                      "l2_error": header.l2_error, "point_error": header.point_error, "max_abs": header.max_abs,
                      "coefficients": header.coefficients, "attributes": attributes, **place}))


if __name__ == "__main__":
    main()
