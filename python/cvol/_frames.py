"""Arrays (time, z, y, x) of volumes: `Series`, which `compress` makes of arrays of four axes."""

from __future__ import annotations

import math
import os
from collections.abc import Callable, Sequence
from typing import TYPE_CHECKING, Any, Optional, Union

import numpy as np
from numpy.typing import NDArray

from ._geometry import Geometry

if TYPE_CHECKING:
    from ._levels import Level
    from ._volume import Volume

At = Callable[[int], Union["Volume", "Level"]]


def all_frames(at: At, count: int, dtype: Any = None) -> NDArray[Any]:
    """All samples of the volumes at(0), ..., at(count - 1)."""
    samples: NDArray[Any] = np.stack([at(t)[...] for t in range(count)])
    return samples if dtype is None else samples.astype(dtype, copy=False)


def frames_at(index: Any, at: At, shape: tuple[int, ...]) -> Any:
    """The samples that an index of NumPy selects from (time, z, y, x). Integers, slices and an ellipsis decode only the
    selected times and samples; any other index decodes all of them."""
    parts = (index or (Ellipsis,)) if isinstance(index, tuple) else (index,)
    simple = all(p is Ellipsis or isinstance(p, (int, np.integer, slice)) for p in parts)
    if not simple or any(isinstance(p, bool) for p in parts):
        return all_frames(at, shape[0])[index]
    np.broadcast_to(np.int8(0), shape)[index]  # pylint: disable=expression-not-assigned  # raises NumPy's errors
    if Ellipsis in parts:
        k = parts.index(Ellipsis)
        parts = parts[:k] + (slice(None),) * (len(shape) + 1 - len(parts)) + parts[k + 1 :]
    times = np.arange(shape[0])[parts[0]]
    if np.ndim(times) == 0:
        return at(int(times))[parts[1:]]
    if not len(times):
        first = at(0)[parts[1:]]
        return np.empty((0, *np.shape(first)), first.dtype)
    return np.stack([at(int(t))[parts[1:]] for t in times])


class Series:
    """Volumes of one shape, type and position at several times: an array (time, z, y, x) that decodes when it is
    sliced, by any index of NumPy.

    volumes: the `Volume` of each time. ValueError: there is none, or they differ in shape, type or position.
    """

    def __init__(self, volumes: Sequence["Volume"]) -> None:
        self.volumes = tuple(volumes)
        if not self.volumes:
            raise ValueError("a series has no volume, must have at least one")
        first = self.volumes[0]
        for k, v in enumerate(self.volumes):
            if (v.shape, v.dtype, v.geometry) != (first.shape, first.dtype, first.geometry):
                raise ValueError(f"volume {k} differs from volume 0 in its shape, type or position")

    @property
    def shape(self) -> tuple[int, ...]:
        """Times, and samples along each axis: (time, z, y, x)."""
        return (len(self.volumes), *self.volumes[0].shape)

    @property
    def ndim(self) -> int:
        """4."""
        return len(self.shape)

    @property
    def size(self) -> int:
        """Number of samples."""
        return math.prod(self.shape)

    @property
    def dtype(self) -> np.dtype[Any]:
        """Sample type."""
        return self.volumes[0].dtype

    @property
    def nbytes(self) -> int:
        """Bytes of the samples without compression."""
        return self.size * self.dtype.itemsize

    @property
    def geometry(self) -> Geometry:
        """Spacing, origin, directions and unit of each volume."""
        return self.volumes[0].geometry

    def __len__(self) -> int:
        return len(self.volumes)

    def __repr__(self) -> str:
        return f"<cvol.Series {' x '.join(map(str, self.shape))} {self.dtype}>"

    def __getitem__(self, index: Any) -> Any:
        return frames_at(index, self.volumes.__getitem__, self.shape)

    def __array__(self, dtype: Any = None, copy: Optional[bool] = None) -> NDArray[Any]:
        if copy is False:
            raise ValueError("a series always returns a copy of its samples")
        return all_frames(self.volumes.__getitem__, len(self), dtype)

    def to_numpy(self) -> NDArray[Any]:
        """All samples, (time, z, y, x)."""
        return np.asarray(self)

    def save(
        self,
        path: Union[str, "os.PathLike[str]"],
        *,
        time_values: Optional[Sequence[float]] = None,
        time_unit: str = "",
    ) -> int:
        """Writes one .cvol file, see `save_series`. Returns its bytes. time_values: one for each time (default 0, 1,
        2, ...), in time_unit."""
        from ._series import save_series  # circular import

        return save_series(path, self.volumes, times=len(self), time_values=time_values, time_unit=time_unit)

    def close(self) -> None:
        """Closes the volumes."""
        for volume in self.volumes:
            volume.close()

    def __enter__(self) -> "Series":
        return self

    def __exit__(self, *_: object) -> None:
        self.close()
