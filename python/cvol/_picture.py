"""PNG files of pictures, without other packages."""

from __future__ import annotations

import os
import struct
import zlib
from typing import Union

import numpy as np
from numpy.typing import ArrayLike


def _chunk(kind: bytes, data: bytes) -> bytes:
    return struct.pack(">I", len(data)) + kind + data + struct.pack(">I", zlib.crc32(kind + data))


def encode_png(picture: ArrayLike) -> bytes:
    """Encodes a picture as PNG: uint8, (height, width) grey, (..., 3) colours or (..., 4) with opacity."""
    picture = np.asarray(picture)
    kinds = {1: 0, 3: 2, 4: 6}
    channels = 1 if picture.ndim == 2 else picture.shape[-1] if picture.ndim == 3 else 0
    if picture.dtype != np.uint8 or channels not in kinds or not picture.size:
        raise ValueError(
            f"the picture is {picture.dtype} {picture.shape}, must be uint8 (h, w), (h, w, 3) or (h, w, 4)"
        )
    height, width = picture.shape[:2]
    rows = np.zeros((height, 1 + width * channels), np.uint8)  # filter 2: the difference to the row above
    rows[:, 0] = 2
    flat = picture.reshape(height, -1)
    rows[0, 1:] = flat[0]
    rows[1:, 1:] = flat[1:] - flat[:-1]
    header = struct.pack(">IIBBBBB", width, height, 8, kinds[channels], 0, 0, 0)
    return (
        b"\x89PNG\r\n\x1a\n"
        + _chunk(b"IHDR", header)
        + _chunk(b"IDAT", zlib.compress(rows.tobytes(), 6))
        + _chunk(b"IEND", b"")
    )


def save_png(path: Union[str, os.PathLike[str]], picture: ArrayLike) -> None:
    """Writes a picture, as from `Volume.render`, to a PNG file."""
    data = encode_png(picture)
    with open(path, "wb") as file:
        file.write(data)
