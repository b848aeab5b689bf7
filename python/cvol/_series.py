"""Series: files of several volumes, by time and channel."""

from __future__ import annotations

import ctypes as c
import os
from dataclasses import dataclass
from typing import Any, Iterable, Optional, Sequence, Union

from . import _abi
from ._call import ArgumentError, Call, Handle, out_pointer, path_bytes
from ._store import output_bytes
from ._volume import Volume

Path = Union[str, "os.PathLike[str]"]
Colour = tuple[float, float, float]


@dataclass(frozen=True)
class Contents:
    """The list of a .cvol file: times x channels volumes of the same shape; a file of one volume has one of each.

    time_values: one for each time, in time_unit ("s"; "": numbers without a unit).
    channel_names ("": none), channel_colours (red, green, blue, 0 to 1): one for each channel.
    colours: channels 0, 1 and 2 are red, green and blue of one colour, and channel 3, if there is one, its alpha.
    file_bytes[time][channel]: bytes of each volume.
    """

    times: int
    channels: int
    time_values: tuple[float, ...]
    time_unit: str
    channel_names: tuple[str, ...]
    channel_colours: tuple[Colour, ...]
    colours: bool
    file_bytes: tuple[tuple[int, ...], ...]


def _colour(pointer: int, channel: int) -> Colour:
    rgb = _abi.Double3()
    _abi.functions["series_get_channel_colour"](c.addressof(rgb), pointer, channel)
    return (rgb[0], rgb[1], rgb[2])


def contents(path: Path) -> Contents:
    """Reads the list of a .cvol file, and no volume. `open` reads one: ``cvol.open(path, time=3)``."""
    out = out_pointer()
    f = _abi.functions
    with Call() as call:
        call("series_read", c.byref(out), path_bytes(path), path=os.fspath(path))
        handle = Handle(out.value or 0, "series_free", "the list")
    with handle as p:
        times, channels = range(f["series_times"](p)), range(f["series_channels"](p))
        found = Contents(
            times=len(times),
            channels=len(channels),
            time_values=tuple(f["series_time"](p, t) for t in times),
            time_unit=f["series_time_unit"](p).decode(errors="replace"),
            channel_names=tuple(f["series_channel_name"](p, i).decode(errors="replace") for i in channels),
            channel_colours=tuple(_colour(p, i) for i in channels),
            colours=bool(f["series_has_colours"](p)),
            file_bytes=tuple(tuple(f["series_volume_bytes"](p, t, i) for i in channels) for t in times),
        )
    handle.close()
    return found


def save_series(
    path: Path,
    volumes: Iterable[Volume],
    *,
    times: Optional[int] = None,
    channels: int = 1,
    time_values: Optional[Sequence[float]] = None,
    time_unit: str = "",
    channel_names: Optional[Sequence[str]] = None,
    channel_colours: Optional[Sequence[Colour]] = None,
    colours: bool = False,
) -> int:
    """Writes several volumes of the same shape, type and position into one .cvol file, which gets its name only when
    it is complete. Returns its bytes.

    volumes: all channels of time 0, then those of time 1, ...; with `times` they may come from a generator, so that
        only one is in memory: ``save_series("run.cvol", (cvol.compress(a) for a in arrays), times=20)``.
    time_values: one for each time (default 0, 1, 2, ...), in time_unit.
    channel_names, channel_colours (red, green, blue, 0 to 1): one for each channel.
    colours: the 3 or 4 channels are red, green, blue (and alpha) of one colour; see `Contents`.
    """
    if times is None:
        volumes = list(volumes)
        times, rest = divmod(len(volumes), channels)
        if rest:
            raise ValueError(f"{len(volumes)} volumes are given, must be a multiple of {channels} channels")
    o: Any = _abi.defaults("series_options")
    o.times, o.channels, o.time_unit, o.colours = times, channels, time_unit.encode(), int(colours)
    if colours and channel_colours is None:
        channel_colours = [(1, 0, 0), (0, 1, 0), (0, 0, 1), (0, 0, 0)][:channels]
    kept = []
    names = None if channel_names is None else [n.encode() for n in channel_names]
    shares = None if channel_colours is None else [v for rgb in channel_colours for v in rgb]
    lists: list[tuple[str, Any, int, Any]] = [
        ("time_values", time_values, times, c.c_double), ("channel_names", names, channels, c.c_char_p),
        ("channel_colours", shares, 3 * channels, c.c_double),
    ]  # fmt: skip
    for name, values, count, kind in lists:
        if values is not None:
            if len(values) != count:
                raise ValueError(f"{name} has {len(values)} values, must have {count}")
            kept.append((kind * count)(*values))
            setattr(o, name, c.addressof(kept[-1]))
    writer, total = out_pointer(), c.c_uint64()
    # One call for each step: in between, as in the code of a generator, Ctrl-C stops Python at once.
    try:
        with Call() as call:
            call("series_writer_open", c.byref(writer), output_bytes(path), c.byref(o))
        added = 0
        for added, volume in enumerate(volumes, 1):
            with volume._store.whole() as array, Call() as call:
                call("series_add", writer, array, None)
        if added < times * channels:
            raise ArgumentError(f"{os.fspath(path)}: got {added} volumes, must be {times * channels}")
    except BaseException:
        _abi.functions["series_writer_abandon"](writer)
        raise
    with Call() as call:
        call("series_writer_commit", writer, c.byref(total))
    return total.value
