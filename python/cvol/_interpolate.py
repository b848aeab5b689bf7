"""Whole arrays from values at points: interpolation on a grid, at chirp points, and with unknown places."""

from __future__ import annotations

import ctypes as c
from collections.abc import Sequence
from typing import Any, Optional, Union

import numpy as np
from numpy.typing import ArrayLike, NDArray

from . import _abi
from ._call import Call, out_pointer
from ._geometry import address, make_grid
from ._keep import Keep
from ._volume import Volume


def _values(values: ArrayLike, name: str, axes: Sequence[int]) -> NDArray[np.float32]:
    array = np.ascontiguousarray(values, np.float32)
    if array.ndim not in axes or not array.size:
        raise ValueError(f"{name} have shape {array.shape}, must have {' to '.join(map(str, axes))} axes and a value")
    return array


def _transform(name: str) -> int:
    number: int = _abi.functions["transform_from_name"](name.encode())
    if not number:
        raise ValueError(f"transform is {name!r}, must be 'dct', 'dft' or 'dht'")
    return number


def _line(size: int) -> Any:
    if size < 1:
        raise ValueError(f"size is {size}, must be at least 1")
    return make_grid((size,), np.dtype(np.float32), None, None)


def interpolate(
    values: ArrayLike,
    shape: Sequence[int],
    transform: str = "dct",
    keep: Optional[Keep] = None,
    spacing: Union[float, Sequence[float], None] = None,
) -> Volume:
    """Makes a whole array of `shape` from values on a coarser (or the same) grid; it passes through them.

    values: of one to three axes, at most as many per axis as `shape` has. They lie where `evaluate` of a coarser grid
    has them: under "dft" and "dht" value p of P at n p / P, under "dct" at n (p + 1/2) / P - 1/2. The result has the
    frequencies that these points resolve; then `keep` truncates it (None: all). spacing: of the result. Exact for
    spectra within these frequencies. Cost: O(N log N).
    """
    array = _values(values, "values", (1, 2, 3))
    number = _transform(transform)
    if len(shape) != array.ndim:
        raise ValueError(f"shape has {len(shape)} numbers, must have {array.ndim}, as values have axes")
    if any(points > n for points, n in zip(array.shape, shape)):
        raise ValueError(f"values have shape {array.shape}, must have at most {tuple(shape)}, the shape of the result")
    grid = make_grid(tuple(shape), np.dtype(np.float32), None, spacing)
    pad = 3 - array.ndim
    out = out_pointer()
    with Call() as call:
        call("array_interpolate_grid", c.byref(out), address(array), _abi.Size3(*array.shape[::-1], *[1] * pad),
             c.byref(grid), array.ndim, number, c.byref(keep._value) if keep else None)  # fmt: skip
        return Volume._take(out)


def interpolate_chirp(
    values: ArrayLike, start: float, step: float, places: ArrayLike, size: int, transform: str = "dft"
) -> tuple[Volume, float]:
    """Fits terms at known places to values at start + i step: (a whole array of `size` samples, the residual's norm).

    places: of the terms, 0 <= place < size; under "dft" both places of a pair. There must be at least as many values
    as places. Least squares, by conjugate gradients. Raises TargetError if the points do not determine the terms.
    """
    array = _values(values, "values", (1,))
    at = np.ascontiguousarray(places)
    if at.ndim != 1 or at.dtype.kind not in "iu" or not at.size or at.min() < 0 or at.max() >= size:
        raise ValueError(f"places are {places!r}, must be integers from 0 to {size - 1}")
    at = at.astype(np.uint32)
    number, grid = _transform(transform), _line(size)
    out, residual = out_pointer(), c.c_double()
    with Call() as call:
        call("array_interpolate_chirp", c.byref(out), c.byref(residual), address(array), len(array), float(start),
             float(step), address(at), len(at), c.byref(grid), number)  # fmt: skip
        return Volume._take(out), residual.value


def interpolate_pencil(values: ArrayLike, size: int, transform: str = "dft") -> tuple[Volume, float]:
    """Finds the few terms that pass through values at 0, 1, 2, ...: (a whole array of `size` samples, the residual's
    norm), by the matrix pencil method.

    2 m values determine at most m terms, m <= 64; both places of a pair count. transform: "dft" or "dht". Raises
    TargetError if no m terms pass through the values within 1e-4 of their norm.
    """
    array = _values(values, "values", (1,))
    if len(array) % 2:
        raise ValueError(f"there are {len(array)} values, must be an even number")
    number, grid = _transform(transform), _line(size)
    out, residual = out_pointer(), c.c_double()
    with Call() as call:
        call("array_interpolate_pencil", c.byref(out), c.byref(residual), address(array), len(array) // 2,
             c.byref(grid), number)  # fmt: skip
        return Volume._take(out), residual.value
