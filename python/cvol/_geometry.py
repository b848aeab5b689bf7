"""Shapes, sample types and geometry, between NumPy's order of axes (z, y, x) and the library's (x, y, z)."""

from __future__ import annotations

import ctypes as c
import math
from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import Any, Optional, Union

import numpy as np
from numpy.typing import NDArray

from . import _abi
from ._call import ArgumentError, DataError

TYPES: dict[int, np.dtype[Any]] = {
    1: np.dtype(np.uint8), 2: np.dtype(np.int8), 3: np.dtype(np.uint16), 4: np.dtype(np.int16),
    5: np.dtype(np.uint32), 6: np.dtype(np.int32), 7: np.dtype(np.float32), 8: np.dtype(np.float64)}  # fmt: skip
_NUMBERS = {dtype: number for number, dtype in TYPES.items()}
_SPACES = ("", "LPS", "RAS")


def type_number(dtype: Any) -> int:
    """The library's number of a sample type."""
    try:
        return _NUMBERS[np.dtype(dtype).newbyteorder("=")]
    except KeyError:
        names = ", ".join(str(known) for known in TYPES.values())
        raise TypeError(f"samples are {np.dtype(dtype)}, must be one of {names}: convert them first") from None


@dataclass(frozen=True)
class Geometry:
    """Positions of samples in the world, and the scale of their values.

    Sample ``a[i]`` with index i = (z, y, x) is at ``origin + (i * spacing) @ direction``, a position (X, Y, Z) in
    the world, in `unit`.

    spacing: distance of neighbours along each axis, in the order of the array.
    origin: position (X, Y, Z) of the first sample.
    direction: a unit vector (X, Y, Z) for each axis, in the order of the array; None: z, y and x run along Z, Y
        and X.
    space: "LPS", "RAS" or "" (unknown): directions of X, Y and Z in a patient.
    unit: "mm", "um", ...; "": unknown.
    value_scale, value_offset: a sample s means value_scale s + value_offset. Arrays have s; results of +, -, * and
        of filters have the scale and offset with which they mean the same operation on those values. Products of
        samples with an offset, and sums of samples with different scales, are computed on the values.
    """

    spacing: tuple[float, ...] = (1.0, 1.0, 1.0)
    origin: tuple[float, float, float] = (0.0, 0.0, 0.0)
    direction: Optional[Sequence[Sequence[float]]] = field(default=None)
    space: str = ""
    unit: str = ""
    value_scale: float = 1.0
    value_offset: float = 0.0

    def affine(self) -> NDArray[np.float64]:
        """4 x 4: from an index (z, y, x, 1) to the world (X, Y, Z, 1). Rank 3 only."""
        matrix = np.eye(4)
        rows = self.direction if self.direction is not None else np.eye(3)[::-1]
        matrix[:3, :3] = (np.asarray(rows, float) * np.asarray(self.spacing, float)[:, None]).T
        matrix[:3, 3] = self.origin
        return matrix

    def nibabel_affine(self) -> NDArray[np.float64]:
        """4 x 4 as nibabel and NIfTI define it: from an index in the order (x, y, z, 1) to right, anterior, superior.
        A geometry in LPS is turned; one without a space is taken as it is."""
        turn = np.diag([-1.0, -1.0, 1.0, 1.0]) if self.space == "LPS" else np.eye(4)
        return turn @ self.affine()[:, [2, 1, 0, 3]]  # type: ignore[no-any-return]


def _numbers(values: Union[float, Sequence[float]], count: int, name: str) -> list[float]:
    try:
        out = [float(v) for v in np.atleast_1d(np.asarray(values, float))]
    except (TypeError, ValueError):
        raise TypeError(f"{name} is {values!r}, must be a number, or one for each axis") from None
    if np.ndim(values) == 0:
        out = out * count
    if len(out) != count:
        raise ValueError(f"{name} has {len(out)} numbers, must have {count}, one for each axis")
    return out


def _directions(direction: Sequence[Sequence[float]], rank: int) -> NDArray[np.float64]:
    """Unit vectors in the order of the library. Of an array of fewer axes, the others may be left out."""
    try:
        rows = np.asarray(direction, float)
    except (TypeError, ValueError):
        rows = np.empty(0)
    if rows.ndim != 2 or rows.shape[1] != 3 or not rank <= len(rows) <= 3:
        raise ArgumentError(f"direction has shape {rows.shape}, must be a vector (X, Y, Z) for each of {rank} axes")
    if not np.allclose(np.linalg.norm(rows, axis=1), 1, rtol=0, atol=1e-3):
        raise ArgumentError("direction must have unit vectors; lengths belong to spacing")
    return rows[::-1]


def make_grid(
    shape: Sequence[int], dtype: Any, geometry: Optional[Geometry] = None,
    spacing: Union[float, Sequence[float], None] = None,
) -> _abi.Grid:
    """The library's grid of an array of 1 to 3 axes."""
    rank = len(shape)
    if not 1 <= rank <= 3:
        hint = ": cvol.save_series writes several volumes into one file" if rank > 3 else ""
        raise ValueError(f"the array has {rank} axes, must have 1 to 3{hint}")
    dims = list(shape[::-1]) + [1] * (3 - rank)
    grid = _abi.functions["grid_make"](*dims, type_number(dtype))
    if geometry is not None:
        if not isinstance(geometry, Geometry):
            raise TypeError(f"geometry is {geometry!r}, must be a cvol.Geometry")
        if not math.isfinite(geometry.value_scale + geometry.value_offset):
            raise ValueError("value_scale and value_offset must be finite")
        if geometry.space not in _SPACES:
            raise ValueError(f"space is {geometry.space!r}, must be 'LPS', 'RAS' or ''")
        unit = geometry.unit.encode()
        if len(unit) > 15:
            raise ValueError(f"unit is {geometry.unit!r}, must have at most 15 bytes")
        grid.space, grid.unit = _SPACES.index(geometry.space), unit
        grid.value_scale, grid.value_offset = geometry.value_scale, geometry.value_offset
        for a, value in enumerate(_numbers(geometry.origin, 3, "origin")):
            grid.origin[a] = value
        if geometry.direction is not None:
            for a, row in enumerate(_directions(geometry.direction, rank)):
                grid.direction[a][:] = row.tolist()
        own = np.asarray(geometry.spacing, float)
        if spacing is None and own.tolist() != list(Geometry.spacing):  # the default is for any number of axes
            spacing = own.tolist()
            if own.ndim and len(own) != rank:
                raise ArgumentError(f"geometry has a spacing of {len(own)} axes, and the array has {rank}")
    if spacing is not None:
        for a, value in enumerate(reversed(_numbers(spacing, rank, "spacing"))):
            grid.spacing[a] = value
    return grid


def copy_grid(grid: Any) -> _abi.Grid:
    """Copies a grid that the library owns."""
    out = _abi.Grid()
    c.pointer(out)[0] = grid
    return out


def grid_shape(grid: _abi.Grid, rank: int = 3) -> tuple[int, ...]:
    return tuple(int(n) for n in grid.dims[:rank][::-1])


def grid_geometry(grid: _abi.Grid, rank: int = 3) -> Geometry:
    return Geometry(
        spacing=tuple(grid.spacing[:rank][::-1]),
        origin=(grid.origin[0], grid.origin[1], grid.origin[2]),
        direction=tuple(tuple(grid.direction[a]) for a in range(rank - 1, -1, -1)),
        space=_SPACES[grid.space] if 0 <= grid.space < 3 else "",
        unit=grid.unit.decode(errors="replace"),
        value_scale=grid.value_scale,
        value_offset=grid.value_offset,
    )


def _narrowed(array: NDArray[Any]) -> NDArray[Any]:
    """Integers of 64 bits as int32, or as uint32. DataError: they do not fit."""
    low, high = (int(array.min()), int(array.max())) if array.size else (0, 0)
    for dtype in (np.int32, np.uint32):
        if np.iinfo(dtype).min <= low and high <= np.iinfo(dtype).max:
            return array.astype(dtype)
    raise DataError(f"samples are {array.dtype} from {low} to {high}, which neither int32 nor uint32 can hold: "
                    "scale them, or convert them to float64")  # fmt: skip


def samples_of(array: Any) -> NDArray[Any]:
    """Samples for the library: x fastest, in the byte order of the machine."""
    if hasattr(array, "dataobj"):  # an image of nibabel
        raise TypeError("the array is an image: give its samples, image.dataobj, or read the file by cvol.read")
    array = np.asanyarray(array)
    if isinstance(array, np.ma.MaskedArray):
        raise TypeError("the array is masked: fill it with a value, then give fill=value")
    if array.dtype == np.bool_:
        array = array.astype(np.uint8)
    elif array.dtype == np.float16:
        array = array.astype(np.float32)
    elif array.dtype.kind in "iu" and array.dtype.itemsize == 8:
        array = _narrowed(array)
    type_number(array.dtype)
    return np.ascontiguousarray(array, array.dtype.newbyteorder("="))


def address(array: NDArray[Any]) -> int:
    return array.ctypes.data
