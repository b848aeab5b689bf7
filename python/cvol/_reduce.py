"""Sums, means, deviations and extremes: on coefficients where that is possible, else on decoded slabs."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Any, Optional, Union

import numpy as np
from numpy.typing import NDArray

if TYPE_CHECKING:
    from ._volume import Volume

Axes = Union[int, tuple[int, ...], None]


_AxisError = getattr(np, "exceptions", np).AxisError  # its place differs between NumPy 1 and 2


def _axes(axis: Axes, rank: int) -> tuple[int, ...]:
    """The axes, from 0. AxisError: as NumPy's."""
    given = tuple(range(rank)) if axis is None else axis if isinstance(axis, tuple) else (axis,)
    for a in given:
        if not -rank <= a < rank:
            raise _AxisError(a, rank)
    out = tuple(a % rank for a in given)
    if len(set(out)) < len(out):
        raise ValueError("duplicate value in 'axis'")
    return out


def on_coefficients(volume: "Volume") -> bool:
    """Whether statistics of the coefficients stand for those of the samples: not for lossless volumes, whose exact
    answer needs the samples, and not for volumes with samples without a value."""
    return not volume.info.exact and not volume._has_mask()


def _from_statistics(volume: "Volume", name: str, ddof: float) -> float:
    s = volume.stats()
    if name in ("sum", "mean"):
        return s.sum if name == "sum" else s.mean
    rest = volume.size - ddof
    variance = s.variance * volume.size / rest if rest > 0 else math.nan
    return variance if name == "var" else math.sqrt(variance)


def _joined(volume: "Volume", axes: tuple[int, ...], function: Any, join: Any) -> NDArray[Any]:
    """Reduces slab by slab, with the reduced axes of length 1. join: adds the next slab's result to that of the slabs
    before it."""
    if 0 not in axes:
        return np.concatenate([function(slab) for slab in volume._slabs()])
    out: Any = None
    for slab in volume._slabs():
        part = function(slab)
        out = part if out is None else join(out, part)
    return out  # type: ignore[no-any-return]


def _sums(volume: "Volume", axes: tuple[int, ...], dtype: Any) -> NDArray[Any]:
    return _joined(volume, axes, lambda slab: slab.sum(axes, dtype=dtype, keepdims=True), np.add)


def _variances(volume: "Volume", axes: tuple[int, ...], ddof: float) -> NDArray[Any]:
    """Two passes over the samples: the means, then the squares of the differences."""
    count = math.prod(volume.shape[a] for a in axes)
    means = _sums(volume, axes, np.float64) / count
    at = 0
    out: Any = 0
    parts = []
    for slab in volume._slabs():
        mean = means if 0 in axes else means[at : at + len(slab)]
        part = np.square(slab - mean).sum(axes, keepdims=True)
        at += len(slab)
        if 0 in axes:
            out = out + part
        else:
            parts.append(part)
    total: NDArray[Any] = out if 0 in axes else np.concatenate(parts)
    return total / (count - ddof) if count > ddof else np.full_like(total, math.nan)


def reduce(
    volume: "Volume", name: str, axis: Axes = None, dtype: Any = None, out: Optional[NDArray[Any]] = None,
    keepdims: bool = False, ddof: float = 0,
) -> Any:  # fmt: skip
    """The method `name` of arrays: "sum", "mean", "std", "var", "min" or "max"."""
    axes = _axes(axis, volume.ndim)
    number = name not in ("min", "max")
    whole = len(axes) == volume.ndim
    result: Any
    if number and whole and dtype is None and on_coefficients(volume):
        result = np.full((1,) * volume.ndim, _from_statistics(volume, name, ddof))
    elif name in ("min", "max"):
        join = np.minimum if name == "min" else np.maximum
        result = _joined(volume, axes, lambda slab: getattr(slab, name)(axes, keepdims=True), join)
    elif name in ("sum", "mean"):
        floats = volume.dtype.kind == "f" or name == "mean"
        result = _sums(volume, axes, np.float64 if floats and dtype is None else dtype)
        result = result / math.prod(volume.shape[a] for a in axes) if name == "mean" else result
    else:
        result = _variances(volume, axes, ddof)
        result = np.sqrt(result) if name == "std" else result
    if number and (dtype is not None or (volume.dtype == np.float32 and not whole)):
        result = result.astype(np.float32 if dtype is None else dtype)
    if not keepdims:
        result = result.reshape([n for a, n in enumerate(volume.shape) if a not in axes])
    if out is not None:
        np.copyto(out, result, casting="same_kind")
        return out
    return result[()]
