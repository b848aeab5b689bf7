"""Volumes of objects with seek() and read(), such as files of fsspec: only the needed ranges of bytes are read.

The ranges are copied to their places in a sparse file in memory, from which the library reads. doc/format.md, sections
1, 6 and 20, says where the bricks stand.
"""

from __future__ import annotations

import io
import itertools
import os
import struct
import threading
from collections.abc import Iterator
from typing import Any, Protocol

from . import _abi
from ._call import CorruptError, FormatError, UnsupportedError
from ._store import REACH, Store

_SECTION = struct.Struct("<4sIQII")  # tag, flags, length, checksums of the content and of the header
_STREAMS = (b"SHL0", b"SHL1", b"SHL2", b"SHL3", b"MASK", b"CORR")
Range = tuple[int, int]


class Seekable(Protocol):
    """An object whose ranges of bytes can be read."""

    def read(self, size: int = -1, /) -> bytes: ...

    def seek(self, offset: int, whence: int = 0, /) -> int: ...

    def close(self) -> None: ...


class _Copy:
    """A sparse file in memory, with the bytes of the object that were read. `bytes_read` counts these."""

    def __init__(self, file: Seekable, name: str) -> None:
        if not hasattr(os, "memfd_create"):
            raise UnsupportedError("ranges=True needs Linux: leave it out")
        self.file, self.name = file, name
        self.size = file.seek(0, os.SEEK_END)
        self.bytes_read = 0
        self._known: list[Range] = []  # sorted, apart
        self._descriptor = os.memfd_create("cvol-ranges")
        os.ftruncate(self._descriptor, self.size)
        self.path = f"/proc/self/fd/{self._descriptor}"

    def need(self, ranges: list[Range]) -> None:
        """Reads what is missing of the ranges [begin, end)."""
        for begin, end in ranges:
            for low, high in self._missing(begin, min(end, self.size)):
                self.file.seek(low)
                data = b""
                while len(data) < high - low:
                    part = self.file.read(high - low - len(data))
                    if not part:
                        raise CorruptError(f"{self.name}: ended at byte {low + len(data)} of {self.size}")
                    data += part
                os.pwrite(self._descriptor, data, low)
                self.bytes_read += len(data)
        merged: list[Range] = []
        for begin, end in sorted([*self._known, *ranges]):
            if merged and begin <= merged[-1][1]:
                merged[-1] = (merged[-1][0], max(end, merged[-1][1]))
            elif begin < end:
                merged.append((begin, end))
        self._known = merged

    def _missing(self, begin: int, end: int) -> Iterator[Range]:
        for low, high in self._known:
            if high > begin and low < end:
                if begin < low:
                    yield begin, low
                begin = max(begin, high)
        if begin < end:
            yield begin, end

    def get(self, begin: int, end: int) -> bytes:
        """The bytes of a range."""
        self.need([(begin, end)])
        return os.pread(self._descriptor, max(end - begin, 0), begin)

    def close(self) -> None:
        """Frees the memory."""
        if self._descriptor >= 0:
            os.close(self._descriptor)
            self._descriptor = -1

    def __del__(self) -> None:
        if getattr(self, "_descriptor", -1) >= 0:
            os.close(self._descriptor)


class _Layout:
    """Where the streams of one volume stand. ranges(): those of the bricks of a box."""

    def __init__(self, copy: _Copy, place: tuple[int, int]) -> None:
        self._copy = copy
        begin, end = 0, copy.size
        copy.need([(0, min(4096, copy.size))])
        if copy.get(12, 16) == b"LIST":
            begin, end = self._volume(place)
        self.streams: dict[bytes, Range] = {}
        self._contents: dict[bytes, bytes] = {}
        at = begin + 12
        while at + _SECTION.size <= end:
            tag, _, length, _, _ = _SECTION.unpack(copy.get(at, at + _SECTION.size))
            content = (at + _SECTION.size, at + _SECTION.size + length)
            if tag in _STREAMS:
                self.streams[tag] = content
            else:
                copy.need([content])
                if tag in (b"HEAD", b"INDX", b"BRKS"):
                    self._contents[tag] = copy.get(*content)
            at = content[1]
        self.whole = b"INDX" not in self._contents  # read it as a whole: it is small, or has no bricks
        if not self.whole:
            try:
                self._index()
            except (IndexError, KeyError, struct.error, ZeroDivisionError):  # damaged: the library has the message
                self.whole = True

    def _volume(self, place: tuple[int, int]) -> Range:
        """The volume of a time and channel in a file of many."""
        copy = self._copy
        times, channels = struct.unpack("<II", copy.get(36, 44))
        copy.need([(12, 36 + 24 + 88 * channels + 8 * times + 16 * times * channels + 4)])
        number = place[1] + channels * place[0]
        if place[1] >= channels or number >= times * channels:
            return 0, 0  # the library has the message
        at = 36 + 24 + 88 * channels + 8 * times + 16 * number
        offset, length = struct.unpack("<QQ", copy.get(at, at + 16))
        if not at <= offset <= offset + length <= copy.size:
            return 0, 0
        copy.need([(offset - _SECTION.size, offset + 12)])
        return offset, offset + length

    def _index(self) -> None:
        """The offsets of the bricks in each stream."""
        dims = struct.unpack_from("<3Q", self._contents[b"HEAD"])
        bricks = self._contents.get(b"BRKS")
        *self.sides, self.run = struct.unpack_from("<4I", bricks) if bricks else (64, 64, 64, 16)
        self.dims = dims
        self.counts = [-(-n // side) for n, side in zip(dims, self.sides)]
        total = self.counts[0] * self.counts[1] * self.counts[2]
        data, at = self._contents[b"INDX"], 0
        self.offsets: dict[bytes, list[int]] = {}
        shells = [tag for tag in _STREAMS[:4] if tag in self.streams]
        groups = [shells, *[[tag] for tag in _STREAMS[4:] if tag in self.streams]]
        for group in groups:
            if at >= len(data):
                break  # CORR in one piece has no lengths
            for tag in group:
                lengths = []
                for _ in range(total):
                    value = shift = 0
                    while data[at] & 128:
                        value, shift, at = value | (data[at] & 127) << shift, shift + 7, at + 1
                    lengths.append(value | data[at] << shift)
                    at += 1
                self.offsets[tag] = [0, *itertools.accumulate(lengths)]
            for tag in group:
                o = self.offsets[tag]
                runs = sum(o[k + 1] > o[k] for k in range(total)) if self.run == 1 else -(-total // self.run)
                at += 4 * runs

    def ranges(self, begin: tuple[int, ...], end: tuple[int, ...]) -> list[Range]:
        """The ranges of the runs of the bricks of a box of samples (x, y, z)."""
        axes = [range(max(low - REACH, 0) // side, min((high - 1 + REACH) // side + 1, count))
                for low, high, side, count in zip(begin, end, self.sides, self.counts)]  # fmt: skip
        nx, ny, nz = self.counts
        runs = sorted({(x + nx * (y + ny * z)) // self.run for z in axes[2] for y in axes[1] for x in axes[0]})
        found = []
        for tag, (at, stop) in self.streams.items():
            if tag not in self.offsets:
                found.append((at, stop))
                continue
            o = self.offsets[tag]
            found += [(at + o[r * self.run], at + o[min((r + 1) * self.run, nx * ny * nz)]) for r in runs]
        return found

    def level(self, level: int) -> list[Range]:
        """The ranges of a level."""
        return [self.streams[tag] for tag in (*_STREAMS[: 4 - level], b"MASK") if tag in self.streams]


class RangedStore(Store):
    """The coefficients of an object; a box or a level reads only its ranges. The object must stay open."""

    def __init__(self, file: Seekable, name: str, place: tuple[int, int], owned: bool = False) -> None:
        """owned: `close` closes the object."""
        # pylint: disable=super-init-not-called
        self._reading, self._owned = threading.Lock(), owned
        self.copy = _Copy(file, name)
        try:
            self._layout = _Layout(self.copy, place)
            if self._layout.whole:
                self.copy.need([(0, self.copy.size)])
            else:
                self.copy.need(self._layout.ranges((0, 0, 0), (1, 1, 1)))
            opened = self._retried(lambda: Store.open(self.copy.path, place))
        except BaseException:
            self.copy.close()
            raise
        self.__dict__.update(opened.__dict__)

    def _retried(self, read: Any) -> Any:
        """Reads; if bytes are missing that this module did not foresee, the whole object, and again."""
        try:
            return read()
        except FormatError:
            try:
                self.copy.need([(0, self.copy.size)])
                return read()
            except FormatError as error:
                raise type(error)(str(error).replace(self.copy.path, self.copy.name)) from None

    def _check_file(self) -> None:
        """Nothing: the copy grows while it is read."""

    def _read(self, part: Any) -> Any:
        with self._reading:
            if self._layout.whole:
                pass  # read at once
            elif part.begin:
                begin, end = _abi.Size3.from_address(part.begin), _abi.Size3.from_address(part.end)
                self.copy.need(self._layout.ranges(tuple(begin), tuple(end)))
            elif part.level:
                self.copy.need(self._layout.level(part.level))
            else:
                self.copy.need([(0, self.copy.size)])
            return self._retried(lambda: super(RangedStore, self)._read(part))

    @property
    def name(self) -> str:
        return self.copy.name

    def recipe(self) -> tuple[Any, ...]:
        return Store.from_bytes, self.to_bytes(), "the pickled volume"

    def close(self) -> None:
        super().close()
        self.copy.close()
        if self._owned:
            self.copy.file.close()


def is_seekable(file: object) -> bool:
    """Whether ranges of it can be read."""
    seekable = getattr(file, "seekable", None)
    return hasattr(file, "seek") and not isinstance(file, io.TextIOBase) and (seekable is None or bool(seekable()))
