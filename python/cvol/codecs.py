"""Codec "cvol" of numcodecs, for the chunks of Zarr arrays (doc/zarr.md).

>>> import zarr
>>> from cvol.codecs import Cvol
>>> a = zarr.array(samples, chunks=(64, 64, 64), compressor=Cvol(max_error=4), store="scan.zarr")

An installed package makes the codec known to numcodecs. Without installation, importing this module does.
"""

from __future__ import annotations

from typing import Any, Optional, Union

import numpy as np
from numcodecs.abc import Codec  # type: ignore[import]
from numcodecs.compat import ensure_bytes, ensure_ndarray  # type: ignore[import]
from numcodecs.registry import register_codec  # type: ignore[import]
from numpy.typing import NDArray

from . import _chunks


class Cvol(Codec):  # type: ignore[misc]
    """Compresses each chunk as a volume (z, y, x); of more axes, each combination of the first ones as a volume.

    One of
        ratio: raw bytes / compressed bytes, at least.
        psnr: decibels over the value range of the chunk, at least.
        max_error: largest |original - decoded|, at most; 0: lossless.
        lossless: every sample decodes to its original bits; the default.
    effort: "default", "fast" or "max"; see `cvol.compress`.

    A chunk whose ratio or PSNR cannot be met, or that would fall below 25 dB, is stored with 35 dB, or without loss.
    """

    codec_id = "cvol"

    def __init__(
        self,
        ratio: Optional[float] = None,
        psnr: Optional[float] = None,
        max_error: Optional[float] = None,
        lossless: bool = False,
        effort: str = "default",
    ) -> None:
        self._target = _chunks.target_of(effort, ratio=ratio, psnr=psnr, max_error=max_error, lossless=bool(lossless))
        self.effort = effort

    def encode(self, buf: Any) -> bytes:
        """The bytes of a chunk."""
        return _chunks.encode(ensure_ndarray(buf), {**self._target, "effort": self.effort})

    def decode(self, buf: Any, out: Optional[Any] = None) -> Union[NDArray[Any], Any]:
        """The chunk, or `out`, which holds it then."""
        chunk = _chunks.decode(ensure_bytes(buf))
        if out is None:
            return chunk
        place = ensure_ndarray(out)
        if place.shape != chunk.shape:
            if place.nbytes != chunk.nbytes or not place.flags.c_contiguous:
                raise ValueError(f"out has {place.nbytes} bytes, the chunk {chunk.nbytes}")
            place, chunk = place.reshape(-1).view(np.uint8), chunk.reshape(-1).view(np.uint8)
        elif place.dtype != chunk.dtype:
            chunk = chunk.view(place.dtype)
        np.copyto(place, chunk)
        return out

    def get_config(self) -> dict[str, Any]:
        """The options, from which numcodecs makes the codec again."""
        effort = {} if self.effort == "default" else {"effort": self.effort}
        return {"id": self.codec_id, **self._target, **effort}

    def __repr__(self) -> str:
        options = {key: value for key, value in self.get_config().items() if key != "id"}
        return f"Cvol({', '.join(f'{key}={value!r}' for key, value in options.items())})"


register_codec(Cvol)
