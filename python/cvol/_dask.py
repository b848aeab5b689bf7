"""Dask arrays whose chunks are whole bricks."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Any, Optional

if TYPE_CHECKING:
    from ._volume import Volume

_BYTES = 2**26


def chunk_shape(bricks: tuple[int, ...], shape: tuple[int, ...], itemsize: int) -> tuple[int, ...]:
    """Sides of chunks of whole bricks: the shortest side doubles, as long as a chunk takes at most 64 MiB."""
    sides = list(bricks)
    while True:
        growing = [k for k, side in enumerate(sides) if side < shape[k]]
        if not growing:
            return tuple(sides)
        k = min(growing, key=lambda axis: sides[axis])
        longer = min(2 * sides[k], shape[k])
        if math.prod(sides) // sides[k] * longer * itemsize > _BYTES:
            return tuple(sides)
        sides[k] = longer


def to_dask(volume: "Volume", chunks: Optional[tuple[int, ...]] = None) -> Any:
    """See `Volume.to_dask`."""
    try:
        import dask.array
    except ImportError:
        raise ImportError("to_dask needs the package dask, which is not installed") from None
    sides = chunks or chunk_shape(volume.chunks, volume.shape, volume.dtype.itemsize)
    return dask.array.from_array(volume, chunks=sides)  # type: ignore[attr-defined]
