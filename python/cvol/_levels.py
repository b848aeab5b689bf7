"""Coarser versions of a volume: level k has one sample for each box of 2^k x 2^k x 2^k samples."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any, Optional

import numpy as np
from numpy.typing import NDArray

from . import _abi
from ._call import Call
from ._geometry import address
from ._index import select

if TYPE_CHECKING:
    from ._volume import Volume

COARSEST = 3


def _means(samples: NDArray[np.float32], factor: int) -> NDArray[np.float32]:
    """Means over boxes of factor^3 samples; boxes at the end may be smaller."""
    for axis, n in enumerate(samples.shape):
        begins = np.arange(0, n, factor)
        counts = np.diff(np.append(begins, n)).astype(np.float32)
        shape = [-1 if a == axis else 1 for a in range(samples.ndim)]
        samples = np.add.reduceat(samples, begins, axis) / counts.reshape(shape)
    return samples


class Level:
    """One of `Volume.levels`: an array that decodes when it is sliced, by any index of NumPy.

    Sample i of an axis is the mean of samples 2^level i ... 2^level (i + 1) - 1 of the volume, evaluated from its
    lowest 1/2^level frequencies, and rounded to the sample type. From a lossy file only these frequencies are read.
    Samples without a value do not count; a mean of none has none, and is the fill of its first sample.
    Means of labels are no labels: take ``v[::2, ::2, ::2]`` of these.
    """

    def __init__(self, volume: "Volume", level: int) -> None:
        self._volume, self.level = volume, level
        self._factor = 2**level

    @property
    def shape(self) -> tuple[int, ...]:
        """Samples along each axis: (z, y, x)."""
        return tuple(-(-n // self._factor) for n in self._volume.shape)

    @property
    def ndim(self) -> int:
        """3."""
        return self._volume.ndim

    @property
    def size(self) -> int:
        """Number of samples."""
        return int(np.prod(self.shape, dtype=object))

    @property
    def nbytes(self) -> int:
        """Bytes of the samples without compression."""
        return self.size * self.dtype.itemsize

    @property
    def dtype(self) -> np.dtype[Any]:
        """The sample type of the volume."""
        return self._volume.dtype

    @property
    def chunks(self) -> tuple[int, ...]:
        """Sides of the boxes that decode independently, in samples of the level."""
        return tuple(max(n // self._factor, 1) for n in self._volume.chunks)

    @property
    def spacing(self) -> tuple[float, ...]:
        """Distance of neighbours along each axis, in the order of `shape`."""
        return tuple(s * self._factor for s in self._volume.spacing)

    @property
    def affine(self) -> NDArray[np.float64]:
        """4 x 4: from an index (z, y, x, 1) of the level to the world (X, Y, Z, 1)."""
        to_volume = np.diag([self._factor] * 3 + [1.0])
        to_volume[:3, 3] = (self._factor - 1) / 2
        return self._volume.affine @ to_volume  # type: ignore[no-any-return]

    def __len__(self) -> int:
        return self.shape[0]

    def __repr__(self) -> str:
        return f"<level {self.level} of {self._volume!r}: {' x '.join(map(str, self.shape))}>"

    def __getitem__(self, index: Any) -> Any:
        if self._volume.closed:
            raise ValueError("the volume is closed")
        chosen = select(index, self.shape)
        if chosen.empty:
            return np.empty(chosen.shape, self.dtype)
        packed = np.empty(chosen.packed, self.dtype)
        for box in chosen.boxes():
            begin = [b * self._factor for b in box.begin]
            end = [min(e * self._factor, n) for e, n in zip(box.end, self._volume.shape)]
            packed[box.place] = self._box(begin, end)
        return packed[chosen.rest]

    def _box(self, begin: list[int], end: list[int]) -> NDArray[Any]:
        """The samples of the level that are made of samples begin .. end - 1 of the volume."""
        shape = [e - b for b, e in zip(begin, end)]
        samples, which = np.empty(shape, np.float32), np.empty(shape, np.uint8)
        stored = None
        box = _abi.Size3(*begin[::-1]), _abi.Size3(*end[::-1])
        with self._volume._store.at_level(self.level) as array, Call() as call:
            call("array_evaluate_real", address(samples), array, *box)
            if _abi.functions["array_evaluate_mask"](address(which), array, *box):
                stored = np.empty(shape, self.dtype)
                call("array_evaluate_box", address(stored), array, *box)
        if stored is None:
            return self._rounded(_means(samples, self._factor))
        share = _means((which == 0).astype(np.float32), self._factor)
        sums = _means(np.where(which == 0, samples, np.float32(0)), self._factor)
        every = slice(None, None, self._factor)
        means = self._rounded(sums / np.where(share > 0, share, np.float32(1)))
        return np.where(share > 0, means, stored[every, every, every])

    def _rounded(self, means: NDArray[np.float32]) -> NDArray[Any]:
        if self.dtype.kind == "f":
            return means
        limits = np.iinfo(self.dtype)
        return np.clip(np.rint(means.astype(np.float64)), limits.min, limits.max)

    def __array__(self, dtype: Any = None, copy: Optional[bool] = None) -> NDArray[Any]:
        if copy is False:
            raise ValueError("a level always returns a copy of its samples")
        samples: NDArray[Any] = self[...]
        return samples if dtype is None else samples.astype(dtype, copy=False)
