"""NumPy's indexing: integers, slices of any step, an ellipsis, new axes, integer arrays and boolean masks.

An index selects samples along each axis. `select` finds the ranges of samples that it needs, and the NumPy index that
makes the result from these ranges, packed one after the other. So every rule of NumPy holds, such as the order of
the result's axes after integer arrays.
"""

from __future__ import annotations

import itertools
import math
import operator
from collections.abc import Iterator
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

_GAP = 16  # samples along an axis that nobody needs: a longer run of them is not decoded
_MOST_BOXES = 64  # more boxes than these cost more than the samples between them

Ranges = tuple[tuple[int, int], ...]


class Box(NamedTuple):
    """A box of samples to decode: `begin` to `end`, and its place in the packed samples."""

    begin: tuple[int, ...]
    end: tuple[int, ...]
    place: tuple[slice, ...]


class Selection(NamedTuple):
    """`ranges`: the samples along each axis to decode, in rising order. `rest`: the index that selects the result
    from the packed samples. `shape`: of the result. `empty`: no sample is selected."""

    ranges: tuple[Ranges, ...]
    rest: tuple[Any, ...]
    shape: tuple[int, ...]
    empty: bool

    @property
    def packed(self) -> tuple[int, ...]:
        """Shape of the packed samples."""
        return tuple(sum(end - begin for begin, end in axis) for axis in self.ranges)

    def boxes(self) -> Iterator[Box]:
        """The boxes of samples that fill the packed samples."""
        places = []
        for axis in self.ranges:
            ends = list(itertools.accumulate(end - begin for begin, end in axis))
            places.append([(begin, end, slice(last - (end - begin), last))
                           for (begin, end), last in zip(axis, ends)])  # fmt: skip
        for parts in itertools.product(*places):
            yield Box(tuple(p[0] for p in parts), tuple(p[1] for p in parts), tuple(p[2] for p in parts))


def _arrays(part: Any) -> list[Any]:
    """The parts of a tuple that one part of an index stands for: a mask of several axes is one array for each."""
    if part is None or part is Ellipsis or isinstance(part, slice):
        return [part]
    if isinstance(part, (bool, np.bool_)):
        raise IndexError("the index is one bool: index with an array of bool, of the shape of the volume, or with None")
    if hasattr(part, "__index__") and not getattr(part, "ndim", 0):
        return [operator.index(part)]
    array = np.asarray(part)
    if array.dtype == np.bool_:
        return list(array.nonzero())
    return [array.astype(np.intp) if not array.size else array]


def _spread(index: Any, rank: int) -> list[Any]:
    """One part for each axis, None for new axes, and an ellipsis that stands for no axis: as a slice does, it separates
    the integer arrays around it."""
    parts = [p for part in (index if isinstance(index, tuple) else (index,)) for p in _arrays(part)]
    given = sum(part is not None and part is not Ellipsis for part in parts)
    place = next((i for i, part in enumerate(parts) if part is Ellipsis), len(parts))
    free: list[Any] = [slice(None)] * (rank - given) or parts[place : place + 1]
    return parts[:place] + free + parts[place + 1 :]


def _runs(needed: NDArray[np.intp]) -> Ranges:
    """Ranges that hold the needed samples (sorted, distinct) and no long gap."""
    cuts = np.flatnonzero(np.diff(needed) > _GAP) + 1
    return tuple((int(run[0]), int(run[-1]) + 1) for run in np.split(needed, cuts))


def _packed_place(index: NDArray[np.intp], ranges: Ranges) -> NDArray[np.intp]:
    """Places in the packed samples of an axis."""
    begins = np.array([begin for begin, _ in ranges])
    before = np.concatenate([[0], np.cumsum([end - begin for begin, end in ranges])[:-1]])
    run = np.searchsorted(begins, index, side="right") - 1
    return index - begins[run] + before[run]  # type: ignore[no-any-return]


def _needs(part: Any, n: int) -> NDArray[np.intp]:
    """The samples of an axis that a part of the index needs, sorted and distinct."""
    if isinstance(part, slice):
        chosen = range(*part.indices(n))
        return np.sort(np.arange(chosen.start, chosen.stop, chosen.step))
    return np.unique(np.asarray(part) % n)  # type: ignore[no-any-return]


def _rest(part: Any, n: int, ranges: Ranges) -> Any:
    """The part of the index for the packed samples."""
    if not isinstance(part, slice):
        place = _packed_place(np.asarray(part) % n, ranges)
        return place if np.ndim(part) else int(place)
    chosen = range(*part.indices(n))
    if len(ranges) == 1:  # A negative step begins at the last sample of the range, a positive one at its first.
        return slice(None, None, chosen.step)
    # Steps above the gap: every range has one sample.
    return slice(None, None, 1 if chosen.step > 0 else -1)


def select(index: Any, shape: tuple[int, ...]) -> Selection:
    """The samples that an index selects from an array. IndexError: as NumPy's."""
    spread = _spread_checked(index, shape)
    result = np.broadcast_to(np.int8(0), shape)[index].shape
    if 0 in result or 0 in shape:
        return Selection((), (), result, True)
    parts = [part for part in spread if part is not None and part is not Ellipsis]
    needs = [_needs(part, n) for part, n in zip(parts, shape)]
    ranges = [_runs(needed) for needed in needs]
    while math.prod(len(axis) for axis in ranges) > _MOST_BOXES:  # join the axis of most ranges
        most = max(range(len(ranges)), key=lambda a: len(ranges[a]))
        ranges[most] = ((ranges[most][0][0], ranges[most][-1][1]),)
    rests = iter([_rest(*three) for three in zip(parts, shape, ranges)])
    rest = tuple(part if part is None or part is Ellipsis else next(rests) for part in spread)
    return Selection(tuple(ranges), rest, result, False)


def _spread_checked(index: Any, shape: tuple[int, ...]) -> list[Any]:
    """`_spread`, after NumPy has checked the index on an array without memory."""
    for part in index if isinstance(index, tuple) else (index,):
        if isinstance(part, (bool, np.bool_)):
            _arrays(part)
    np.broadcast_to(np.int8(0), shape)[index]  # pylint: disable=expression-not-assigned
    return _spread(index, len(shape))
