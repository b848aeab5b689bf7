"""Transfer functions: from sample values to colour and opacity."""

from __future__ import annotations

import ctypes as c
import math
import os
from typing import Any, Optional

import numpy as np
from numpy.typing import NDArray

from . import _abi
from ._call import ArgumentError, Call, Handle, out_pointer, path_bytes
from ._store import info_of


def names() -> list[str]:
    """Names for `render(transfer=...)`; those that begin with ct- are in Hounsfield units."""
    text: bytes = _abi.functions["transfer_names"]() + b" " + _abi.functions["transfer_ct_names"]()
    return text.decode().split()


def histogram_of(array: int) -> Any:
    histogram = _abi.Histogram()
    with Call() as call:
        call("array_compute_histogram", c.byref(histogram), array)
    return histogram


def _is_exact(array: int) -> bool:
    return bool(info_of(array).psnr_db == math.inf)


def is_file(transfer: Any) -> bool:
    """True for a path, False for a name or points."""
    return isinstance(transfer, os.PathLike) or isinstance(transfer, str) and ("." in transfer or "/" in transfer)


def _hounsfield(array: int, histogram: Any) -> tuple[float, float]:
    """The rescale to Hounsfield units, guessed from the values."""
    rescale = _abi.Double2()
    grid = _abi.functions["array_grid"](array)
    if not _abi.functions["hounsfield_guess"](rescale, c.byref(histogram), grid):
        raise ArgumentError(
            f"values {histogram.min:g} to {histogram.max:g} are not Hounsfield units (air -1000, water 0), which "
            "transfer functions ct-... need: give rescale=(slope, intercept), or another transfer function"
        )
    return rescale[0], rescale[1]


def _read(array: int, path: Any) -> Handle:
    """The transfer function of a file, of the values that samples mean."""
    out, values = out_pointer(), out_pointer()
    grid = _abi.functions["array_grid"](array).contents
    means = _abi.Double2(grid.value_scale, grid.value_offset)
    with Call() as call:
        call("transfer_read", c.byref(values), path_bytes(path), path=os.fspath(path))
    with Handle(values.value or 0, "transfer_free", "the transfer function") as pointer, Call() as call:
        call("transfer_create_rescaled", c.byref(out), pointer, means)
        return Handle(out.value or 0, "transfer_free", "the transfer function")


def _create(array: int, transfer: Any, rescale: Optional[tuple[float, float]]) -> Handle:
    out = out_pointer()
    if isinstance(transfer, (str, os.PathLike)):
        if is_file(transfer):
            return _read(array, transfer)
        assert isinstance(transfer, str)
        if transfer not in names():
            raise ArgumentError(f"no transfer function is named {transfer}; there are: {' '.join(names())}")
        histogram = histogram_of(array)
        name = transfer.encode()
        with Call() as call:
            if transfer == "auto":
                grid = _abi.functions["array_grid"](array)
                call("transfer_create_auto", c.byref(out), None, None, c.byref(histogram), grid, _is_exact(array))
            elif _abi.functions["transfer_is_ct"](name):
                means = _abi.Double2(*(rescale or _hounsfield(array, histogram)))
                call("transfer_create_ct", c.byref(out), name, means)
            else:
                call("transfer_create_named", c.byref(out), name, c.byref(histogram))
            return Handle(out.value or 0, "transfer_free", "the transfer function")
    rows = np.ascontiguousarray(transfer, float)
    if rows.ndim != 2 or rows.shape[1] != 5:
        raise ValueError(f"transfer points have shape {rows.shape}, must have (n, 5): value, r, g, b, opacity")
    with Call() as call:
        call("transfer_create", c.byref(out), rows.ctypes.data, len(rows))
        return Handle(out.value or 0, "transfer_free", "the transfer function")


def make(
    array: int,
    transfer: Any,
    window: Optional[tuple[float, float]] = None,
    opacity_scale: float = 1,
    rescale: Optional[tuple[float, float]] = None,
) -> Handle:
    """Makes a transfer function for an array from a name, a file, or points (value, r, g, b, opacity)."""
    plain = _create(array, transfer, rescale)
    if window is None and opacity_scale == 1:
        return plain
    out = out_pointer()
    ends = None if window is None else _abi.Double2(*window)
    with plain as pointer, Call() as call:
        call("transfer_create_adjusted", c.byref(out), pointer, ends, opacity_scale)
        return Handle(out.value or 0, "transfer_free", "the transfer function")


def points_of(transfer: Handle) -> NDArray[Any]:
    """The points of a transfer function, (n, 5): value, r, g, b, opacity."""
    with transfer as pointer:
        count = _abi.functions["transfer_count"](pointer)
        points = [_abi.functions["transfer_point_at"](pointer, i) for i in range(count)]
    return np.array([[p.value, p.r, p.g, p.b, p.opacity] for p in points])
