"""Damages .cvol and .cvi files and recomputes all of their checksums, so that decoders reach what lies behind these.
fuzz/differential.py uses this module. It reads and writes sections by doc/decoder_ref.py."""
import ctypes
import math
import struct

NUMBERS = [0, 1, 2, 3, 4, 7, 8, 15, 16, 17, 31, 32, 48, 64, 255, 2 ** 16, 2 ** 31 - 1, 2 ** 31, 2 ** 32 - 1]
REALS = [0.0, -0.0, 1.0, -1.0, 0.5, 255.0, 1e-300, 5e-324, 1e30, 1e300, -1e300, math.nan, math.inf, -math.inf]
UNKNOWN = b"ABCD"


# ---- files and their sections ----------------------------------------------------------------------------------------

def parse(data):
    """Returns the sections [tag, flags, content] of a sound file."""
    sections, at = [], 12
    while at < len(data):
        tag, flags, length = struct.unpack_from("<4sIQ", data, at)
        sections.append([tag, flags, data[at + 24:at + 24 + length]])
        at += 24 + length
    return sections


def put_length(number):
    out = bytearray()
    while True:
        out.append(number & 127 | (128 if number > 127 else 0))
        number >>= 7
        if not number:
            return bytes(out)


class Index:
    """INDX: the lengths of the bricks in each stream. Raises ValueError if it is damaged beyond that."""

    def __init__(self, ref, sections):
        content = {tag: content for tag, _, content in sections}
        if not {b"HEAD", b"INDX"} <= content.keys() or len(content[b"HEAD"]) < 24:
            raise ValueError("no index")
        shape = struct.unpack("<3Q", content[b"HEAD"][:24])
        *sides, self.run = (struct.unpack("<4I", content[b"BRKS"][:16]) if len(content.get(b"BRKS", b"")) >= 16
                            else (64, 64, 64, 16))
        if not min(sides) or not self.run:
            raise ValueError("no bricks")
        bricks = math.prod(-(-n // side) for n, side in zip(shape, sides))
        if not 0 < bricks <= len(content[b"INDX"]):
            raise ValueError("too many bricks")
        others = [tag for tag in (b"MASK", b"CORR") if tag in content and not (
            tag == b"CORR" and content.get(b"MODE", b"")[:4] == b"\3\0\0\0")]
        self.streams = [b"SHL0", b"SHL1", b"SHL2", b"SHL3"] + others
        self.lengths, at = [], 0
        runs = -(-bricks // self.run)
        try:
            for count in [4] + [1] * len(others):
                for _ in range(count):
                    numbers, at = ref.read_lengths(content[b"INDX"], at, bricks)
                    self.lengths.append(numbers)
                at += sum(4 * sum(self.run > 1 or n[r] > 0 for r in range(runs)) for n in self.lengths[-count:])
        except ref.Damaged as error:
            raise ValueError("lengths") from error

    def sums(self, ref, lengths, content):
        out, at = [], 0
        for begin in range(0, len(lengths), self.run):
            size = sum(lengths[begin:begin + self.run])
            out.append(ref.crc32c(content[at:at + size]))
            at += size
        return out

    def content(self, ref, sections):
        """Returns the content of INDX and {tag: checksum of its section}."""
        found = {tag: content for tag, _, content in sections}
        out, totals, done = b"", {}, 0
        for count in [4] + [1] * (len(self.streams) - 4):
            group = range(done, done + count)
            done += count
            out += b"".join(put_length(n) for s in group for n in self.lengths[s])
            for s in group:
                sums = self.sums(ref, self.lengths[s], found.get(self.streams[s], b""))
                out += b"".join(struct.pack("<I", x) for r, x in enumerate(sums)
                                if self.run > 1 or self.lengths[s][r] > 0)
                totals[self.streams[s]] = ref.crc32c(struct.pack(f"<{len(sums)}I", *sums))
        return out, totals


def join(ref, sections, repair_index=True):
    """Returns a file of sections, with correct checksums."""
    totals = {}
    if repair_index:
        try:
            index = Index(ref, sections)
            content, totals = index.content(ref, sections)
            sections = [[tag, flags, content if tag == b"INDX" else old] for tag, flags, old in sections]
        except ValueError:
            pass
    out = b"\x8bCVL\r\n\x1a\n\1\0\0\0"
    for tag, flags, content in sections:
        start = struct.pack("<4sIQI", tag, flags, len(content), totals.get(tag, ref.crc32c(content)))
        out += start + struct.pack("<I", ref.crc32c(start)) + content
    return out


def join_series(ref, sections, change_list):
    """Returns a file of many volumes, with their positions; change_list(content) damages LIST after that."""
    content = bytearray(sections[0][2])
    times, channels = struct.unpack_from("<2I", content)
    at, number = 36 + len(content), 24 + 88 * channels + 8 * times
    for _, _, volume in sections[1:1 + times * channels]:
        struct.pack_into("<2Q", content, number, at + 24, len(volume))
        at, number = at + 24 + len(volume), number + 16
    return join(ref, [[b"LIST", 1, change_list(bytes(content))]] + sections[1:])


# ---- damages of bytes ------------------------------------------------------------------------------------------------

def flip(random, content):
    """Changes one to four bytes."""
    out = bytearray(content)
    for _ in range(random.choice((1, 1, 1, 2, 4)) if out else 0):
        at = random.randrange(len(out))
        out[at] = random.choice((out[at] ^ 1 << random.randrange(8), random.randrange(256), 0, 255))
    return bytes(out)


def set_number(random, content):
    """Sets a number at a multiple of four bytes."""
    new = random.choice((struct.pack("<I", random.choice(NUMBERS)), struct.pack("<Q", random.choice(NUMBERS)),
                         struct.pack("<d", random.choice(REALS))))
    if len(content) < len(new):
        return flip(random, content)
    at = 4 * random.randrange((len(content) - len(new)) // 4 + 1)
    return content[:at] + new + content[at + len(new):]


def resize(random, content):
    """Cuts or extends the content, or inserts or deletes bytes."""
    at, count = random.randrange(len(content) + 1), random.choice((1, 1, 2, 4, 8))
    return random.choice((content[:at], content[:-count], content + random.randbytes(count), b"",
                          content[:at] + random.randbytes(count) + content[at:], content[:at] + content[at + count:]))


def change(random, content):
    return random.choice((flip, flip, flip, set_number, resize))(random, content)


def zstd():
    library = ctypes.CDLL(ctypes.util.find_library("zstd") or "libzstd.so.1")
    for name in ("ZSTD_compress", "ZSTD_compressBound", "ZSTD_decompress"):
        getattr(library, name).restype = ctypes.c_size_t
    library.ZSTD_getFrameContentSize.restype = ctypes.c_uint64
    return library


def change_frame(ref, random, frame):
    """Changes the bytes within a zstd frame."""
    library = zstd()
    size = library.ZSTD_getFrameContentSize(frame, ctypes.c_size_t(len(frame)))
    try:
        raw = change(random, ref.unpack(frame, size))
    except ref.Damaged:  # by an earlier change
        return change(random, frame)
    most = library.ZSTD_compressBound(ctypes.c_size_t(len(raw)))
    out = ctypes.create_string_buffer(most)
    size = library.ZSTD_compress(out, ctypes.c_size_t(most), raw, ctypes.c_size_t(len(raw)), 3)
    return out.raw[:size]


# ---- damages of files ------------------------------------------------------------------------------------------------

WEIGHTS = {b"SHL0": 6, b"SHL1": 3, b"SHL2": 3, b"SHL3": 3, b"INDX": 3, b"HEAD": 4, b"MODE": 4, b"MASK": 5, b"CORR": 5,
           b"TERM": 8, b"SPEC": 8, b"PLNS": 8, b"PICT": 6, b"BAKE": 6, b"TABL": 2, b"TRUE": 2, b"BRKS": 2, b"SUMM": 2,
           b"RNGE": 2, b"ENDS": 0}
FRAMES = {b"TERM": 0, b"SPEC": 32, b"RNGE": 16}  # where the frame begins


def change_content(ref, random, sections):
    """Changes the content of one section."""
    weights = [WEIGHTS.get(tag, 1) if content else 0 for tag, _, content in sections]
    if not any(weights):
        return sections
    number = random.choices(range(len(sections)), weights)[0]
    tag, flags, content = sections[number]
    mode = next((content for name, _, content in sections if name == b"MODE"), b"")
    begin = 0 if tag == b"CORR" and mode[:4] == b"\3\0\0\0" else FRAMES.get(tag)
    if begin is not None and len(content) > begin and random.random() < 0.7:
        content = content[:begin] + change_frame(ref, random, content[begin:])
    else:
        content = change(random, content)
    return sections[:number] + [[tag, flags, content]] + sections[number + 1:]


def change_sections(ref, random, sections):
    """Deletes, doubles, exchanges, adds or renames a section, or changes its flags."""
    number, other = random.randrange(len(sections)), random.randrange(len(sections))
    tag, flags, content = sections[number]
    before, after = sections[:number], sections[number + 1:]
    kind = random.randrange(6)
    if kind == 0:
        return before + after
    if kind == 1:
        return before + [sections[number], sections[number]] + after
    if kind == 2:
        out = list(sections)
        out[number], out[other] = out[other], out[number]
        return out
    if kind == 3:
        return before + [[UNKNOWN, random.choice((0, 0, 1, 2)), random.randbytes(5)]] + sections[number:]
    if kind == 4:
        return before + [[random.choice((UNKNOWN, sections[other][0])), flags, content]] + after
    return before + [[tag, random.choice((0, 1, 2, 3, 2 ** 31)), content]] + after


def move_bytes(ref, random, sections):
    """Moves bytes from a brick to another, or from a stream to nowhere."""
    try:
        index = Index(ref, sections)
    except ValueError:
        return None
    lengths = random.choice(index.lengths)
    count = random.choice((1, 1, 2, 4, 16))
    a, b = random.randrange(len(lengths)), random.randrange(len(lengths))
    lengths[a] = max(0, lengths[a] - count)
    lengths[b] += random.choice((0, count, count))
    content, _ = index.content(ref, sections)
    return [[tag, flags, content if tag == b"INDX" else old] for tag, flags, old in sections]


def change_volume(ref, random, data):
    """Damages a file without PACK or LIST."""
    sections = parse(data)
    for _ in range(random.choice((1, 1, 1, 2))):
        how = random.choices((change_content, change_sections, move_bytes), (16, 3, 3))[0]
        sections = how(ref, random, sections) or sections
    return join(ref, sections, random.random() < 0.95)


def change_front(ref, random, data):
    """Damages the front of a packed file, or its length."""
    size, begin = data[36], 37
    if size > 127:
        size, begin = size & 127 | data[37] << 7, 38
    front = flip(random, data[begin:begin + size])
    length, = struct.unpack_from("<Q", data, 16)
    length += random.choice((0, 0, 0, 0, 1, -1))
    checksum = ref.crc32c(data[36:begin] + front)
    start = struct.pack("<4sIQI", b"PACK", random.choice((1, 1, 1, 1, 1, 0, 3)), max(0, length), checksum)
    return data[:12] + start + struct.pack("<I", ref.crc32c(start)) + front.join((data[36:begin], data[begin + size:]))


def change_series(ref, random, data):
    sections = parse(data)
    if random.random() < 0.3:
        return join_series(ref, sections, lambda content: change(random, content))
    if random.random() < 0.2:
        return join(ref, change_sections(ref, random, sections))
    number = random.randrange(1, len(sections) - 1)
    sections[number][2] = damage(ref, random, sections[number][2])
    return join_series(ref, sections, lambda content: content)


def damage(ref, random, data):
    """Returns a damaged file. Most have correct checksums."""
    kind = random.random()
    if kind < 0.04:
        return flip(random, data)
    if kind < 0.10:
        return data[:random.randrange(len(data))]
    if data[12:16] == b"LIST":
        return change_series(ref, random, data)
    if data[12:16] == b"PACK":
        return change_front(ref, random, data) if kind < 0.3 else change_volume(ref, random, ref.unpack_file(data))
    return change_volume(ref, random, data)
