"""NumPy's protocols: functions, ufuncs, comparisons and methods of arrays that take a volume.

Sums, differences, products and factors work on coefficients and give a volume (`Algebra`). Reductions work on
coefficients where that is possible. All else decodes the samples and gives what NumPy gives for them.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from typing import TYPE_CHECKING, Any, Optional

import numpy as np
from numpy.typing import DTypeLike, NDArray

from ._reduce import Axes, on_coefficients, reduce

if TYPE_CHECKING:
    from ._volume import Volume

# Operators on coefficients: the method for a volume on the left, and for one on the right.
_COEFFICIENTS = {
    np.add: ("__add__", "__radd__"), np.subtract: ("__sub__", "__rsub__"), np.multiply: ("__mul__", "__rmul__"),
    np.true_divide: ("__truediv__", "__rtruediv__"), np.negative: ("__neg__", ""), np.positive: ("__pos__", ""),
}  # fmt: skip


def decoded(value: Any) -> Any:
    """The value with arrays instead of volumes, also inside lists, tuples and dictionaries."""
    if isinstance(value, NumpyArray):
        return value.to_numpy()
    if type(value) in (list, tuple):
        return type(value)(decoded(v) for v in value)
    if type(value) is dict:
        return {key: decoded(v) for key, v in value.items()}
    return value


class NumpyArray:
    """What makes a `Volume` an array for NumPy."""

    if TYPE_CHECKING:  # what Volume has

        @property
        def shape(self) -> tuple[int, ...]: ...
        @property
        def ndim(self) -> int: ...
        @property
        def size(self) -> int: ...
        @property
        def dtype(self) -> np.dtype[Any]: ...
        def to_numpy(self) -> NDArray[Any]: ...
        def __getitem__(self, index: Any) -> Any: ...

    __hash__ = None  # type: ignore[assignment]

    # ---- protocols --------------------------------------------------------------------------------

    def __array__(self, dtype: Any = None, copy: Optional[bool] = None) -> NDArray[Any]:
        if copy is False:
            raise ValueError("a compressed volume always returns a copy of its samples")
        samples = self.to_numpy()
        return samples if dtype is None else samples.astype(dtype, copy=False)

    def __array_ufunc__(self, ufunc: Any, method: str, *inputs: Any, **keywords: Any) -> Any:
        if method == "__call__" and not keywords and ufunc in _COEFFICIENTS:
            left, right = _COEFFICIENTS[ufunc]
            numbers = [v[()] if isinstance(v, np.ndarray) and not v.ndim else v for v in inputs]
            if isinstance(numbers[0], NumpyArray):
                result = getattr(numbers[0], left)(*numbers[1:])
            else:
                result = getattr(numbers[1], right)(numbers[0])
            if result is NotImplemented:
                raise TypeError(f"{ufunc.__name__} of a volume takes numbers and volumes: compress the other operand, "
                                "or use to_numpy()")  # fmt: skip
            return result
        if any(isinstance(v, NumpyArray) for v in keywords.get("out", ())):
            raise TypeError("out is a cvol.Volume: NumPy cannot write into a compressed volume")
        return getattr(ufunc, method)(*map(decoded, inputs), **decoded(keywords))

    def __array_function__(self, function: Any, types: Any, arguments: Any, keywords: Any) -> Any:
        special = _FUNCTIONS.get(function)
        if special is not None and arguments and isinstance(arguments[0], NumpyArray):
            try:
                return special(*arguments, **keywords)
            except _Decode:
                pass
        if any(isinstance(v, NumpyArray) for v in (keywords.get("out"), *(arguments[:1] * (function in _WRITES)))):
            raise TypeError(f"{function.__name__}: NumPy cannot write into a compressed volume")
        return function(*decoded(arguments), **decoded(keywords))

    # ---- methods of arrays ------------------------------------------------------------------------

    def sum(self, axis: Axes = None, dtype: DTypeLike = None, out: Optional[NDArray[Any]] = None,
            keepdims: bool = False) -> Any:  # fmt: skip
        """Sum of the samples; over all of a lossy volume it is that of the coefficients (`stats` bounds its error)."""
        return reduce(self, "sum", axis, dtype, out, keepdims)  # type: ignore[arg-type]

    def mean(self, axis: Axes = None, dtype: DTypeLike = None, out: Optional[NDArray[Any]] = None,
             keepdims: bool = False) -> Any:  # fmt: skip
        """Mean of the samples; over all of a lossy volume it is that of the coefficients (`stats` bounds its error)."""
        return reduce(self, "mean", axis, dtype, out, keepdims)  # type: ignore[arg-type]

    def std(self, axis: Axes = None, dtype: DTypeLike = None, out: Optional[NDArray[Any]] = None, ddof: float = 0,
            keepdims: bool = False) -> Any:  # fmt: skip
        """Standard deviation of the samples; see `mean`."""
        return reduce(self, "std", axis, dtype, out, keepdims, ddof)  # type: ignore[arg-type]

    def var(self, axis: Axes = None, dtype: DTypeLike = None, out: Optional[NDArray[Any]] = None, ddof: float = 0,
            keepdims: bool = False) -> Any:  # fmt: skip
        """Variance of the samples; see `mean`."""
        return reduce(self, "var", axis, dtype, out, keepdims, ddof)  # type: ignore[arg-type]

    def min(self, axis: Axes = None, out: Optional[NDArray[Any]] = None, keepdims: bool = False) -> Any:
        """Least decoded sample."""
        return reduce(self, "min", axis, None, out, keepdims)  # type: ignore[arg-type]

    def max(self, axis: Axes = None, out: Optional[NDArray[Any]] = None, keepdims: bool = False) -> Any:
        """Largest decoded sample."""
        return reduce(self, "max", axis, None, out, keepdims)  # type: ignore[arg-type]

    def clip(self, min: Any = None, max: Any = None) -> NDArray[Any]:  # pylint: disable=redefined-builtin
        """The decoded samples, clamped to `min` and `max`."""
        return self.to_numpy().clip(min, max)

    @property
    def T(self) -> NDArray[Any]:  # pylint: disable=invalid-name
        """The decoded samples, with reversed axes (x, y, z)."""
        return self.to_numpy().T

    def to_dask(self, chunks: Optional[tuple[int, ...]] = None) -> Any:
        """A dask.array.Array that decodes its chunks when they are computed, in other processes as well.

        chunks: sides of chunks (z, y, x); None: whole bricks (`chunks`), several up to 64 MiB, because a chunk also
        reads the bricks next to it. Volumes in files go to other processes by path, others by their bytes.
        """
        from ._dask import to_dask

        return to_dask(self, chunks)  # type: ignore[arg-type]

    def _slabs(self) -> Iterator[NDArray[Any]]:
        """The decoded samples, some slices of the first axis at a time."""
        self._store.whole()  # type: ignore[attr-defined]
        thick = 64 if self.ndim == 3 else self.shape[0]
        for first in range(0, self.shape[0], thick):
            yield self[first : first + thick]

    def __iter__(self) -> Iterator[Any]:
        for first in range(0, self.shape[0], self.chunks[0]):  # type: ignore[attr-defined]
            yield from self[first : first + self.chunks[0]]  # type: ignore[attr-defined]

    def __contains__(self, value: object) -> bool:
        return any(bool((slab == value).any()) for slab in self._slabs())

    def __bool__(self) -> bool:
        if self.size > 1:
            raise ValueError("the truth of a volume with more than one sample is ambiguous: use np.any or np.all")
        return bool(self.to_numpy())

    # ---- operators that decode --------------------------------------------------------------------

    def __eq__(self, other: object) -> Any:
        return np.equal(self, other)  # type: ignore[call-overload]

    def __ne__(self, other: object) -> Any:
        return np.not_equal(self, other)  # type: ignore[call-overload]

    def __lt__(self, other: Any) -> Any:
        return np.less(self, other)

    def __le__(self, other: Any) -> Any:
        return np.less_equal(self, other)

    def __gt__(self, other: Any) -> Any:
        return np.greater(self, other)

    def __ge__(self, other: Any) -> Any:
        return np.greater_equal(self, other)

    def __abs__(self) -> NDArray[Any]:
        return np.absolute(self)

    def __pow__(self, other: Any) -> NDArray[Any]:
        return np.power(self, other)

    def __floordiv__(self, other: Any) -> NDArray[Any]:
        return np.floor_divide(self, other)

    def __mod__(self, other: Any) -> NDArray[Any]:
        return np.remainder(self, other)

    def __and__(self, other: Any) -> NDArray[Any]:
        return np.bitwise_and(self, other)

    def __or__(self, other: Any) -> NDArray[Any]:
        return np.bitwise_or(self, other)


class _Decode(Exception):
    """A function has to decode: its arguments are not those of a method."""


def _reduction(name: str) -> Callable[..., Any]:
    def call(volume: Any, *arguments: Any, **keywords: Any) -> Any:
        given = {key: v for key, v in keywords.items() if v is not np._NoValue}  # type: ignore[attr-defined]
        if any(key in given for key in ("where", "initial")):
            raise _Decode
        return getattr(volume, name)(*arguments, **given)

    return call


def _like(function: Callable[..., Any]) -> Callable[..., Any]:
    """zeros_like and its kin: of the shape and type, without samples."""

    def call(volume: Any, *arguments: Any, **keywords: Any) -> Any:
        return function(np.broadcast_to(np.zeros((), volume.dtype), volume.shape), *arguments, **keywords)

    return call


def _norm(volume: Any, *options: Any, **keywords: Any) -> Any:
    if options or keywords or not on_coefficients(volume):
        raise _Decode
    return volume.norm()


def _size(volume: Any, axis: Optional[int] = None) -> int:
    return volume.size if axis is None else volume.shape[axis]  # type: ignore[no-any-return]


_FUNCTIONS: dict[Any, Callable[..., Any]] = {
    np.shape: lambda volume: volume.shape, np.ndim: lambda volume: volume.ndim, np.size: _size,
    np.linalg.norm: _norm, np.clip: lambda volume, *a, **k: np.clip(volume.to_numpy(), *a, **k),
    **{getattr(np, name): _reduction(name) for name in ("sum", "mean", "std", "var", "min", "max")},
    np.amin: _reduction("min"), np.amax: _reduction("max"),
    **{getattr(np, name): _like(getattr(np, name)) for name in ("zeros_like", "ones_like", "empty_like", "full_like")},
}  # fmt: skip
_WRITES = (np.copyto, np.put, np.place, np.putmask, np.fill_diagonal)
