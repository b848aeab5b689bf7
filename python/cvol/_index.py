"""NumPy's basic indexing: integers, slices of any step, an ellipsis."""

from __future__ import annotations

import operator
from typing import Any, NamedTuple


class Selection(NamedTuple):
    """`begin`, `end`: the box that holds all selected samples, in the order of the array. `rest`: the index that
    selects the result from the box. `empty`: no sample is selected."""

    begin: tuple[int, ...]
    end: tuple[int, ...]
    rest: tuple[Any, ...]
    shape: tuple[int, ...]
    empty: bool


def _spread(index: Any, rank: int) -> list[Any]:
    parts = list(index) if isinstance(index, tuple) else [index]
    for part in parts:
        if part is None:
            raise IndexError("a compressed volume does not support new axes: index the array that slicing returns")
        if not isinstance(part, slice) and part is not Ellipsis:
            if isinstance(part, bool) or not hasattr(part, "__index__") or bool(getattr(part, "ndim", 0)):
                raise IndexError(
                    "a compressed volume supports integers, slices and '...': use evaluate_points for single "
                    "places, or index to_numpy()"
                )
    dots = sum(part is Ellipsis for part in parts)
    if dots > 1:
        raise IndexError("an index can only have a single ellipsis ('...')")
    if len(parts) - dots > rank:
        raise IndexError(f"too many indices: the volume has {rank} axes, {len(parts) - dots} were indexed")
    place = next((i for i, part in enumerate(parts) if part is Ellipsis), len(parts))
    fill = [slice(None)] * (rank - (len(parts) - dots))
    return parts[:place] + fill + parts[place + dots :]


def select(index: Any, shape: tuple[int, ...]) -> Selection:
    begin, end, out = [], [], []
    rest: list[Any] = []
    for axis, (part, n) in enumerate(zip(_spread(index, len(shape)), shape)):
        if isinstance(part, slice):
            chosen = range(*part.indices(n))
            out.append(len(chosen))
            low = min(chosen[0], chosen[-1]) if chosen else 0
            high = max(chosen[0], chosen[-1]) + 1 if chosen else 0
            step = chosen.step
            # A negative step begins at the last sample of the box, a positive one at its first.
            rest.append(slice(None, None, step))
        else:
            place = operator.index(part)
            if not -n <= place < n:
                raise IndexError(f"index {place} is out of bounds for axis {axis} with size {n}")
            low = place % n
            high = low + 1
            rest.append(0)
        begin.append(low)
        end.append(high)
    return Selection(tuple(begin), tuple(end), tuple(rest), tuple(out), 0 in out)
