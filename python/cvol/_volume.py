"""Volume: a compressed array, its properties and its samples."""

from __future__ import annotations

import ctypes as c
import hashlib
import json
import math
import os
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any, BinaryIO, Optional, Union

import numpy as np
from numpy.typing import ArrayLike, DTypeLike, NDArray

from . import _abi
from ._algebra import Algebra
from ._call import Call, Handle, Progress, options
from ._geometry import TYPES, Geometry, address, grid_geometry, grid_shape, samples_of, type_number
from ._index import select
from ._levels import COARSEST, Level
from ._numpy import NumpyArray
from ._picture import encode_png
from ._store import Store, info_of, output_bytes
from ._view import View, picture_html

_TRANSFORMS = {1: "dct", 2: "dht", 3: "dft"}


@dataclass(frozen=True)
class Info:
    """Properties of a volume. Values per axis are in the order of the array.

    transform, block: "dct", "dht" or "dft", and the side of the blocks; 0: of the whole array.
    terms: number of coefficients. rho: terms divided by samples. step: quantizer step; 0: not quantized.
    resident_bytes: memory of the array.
    value_min, value_max: bounds of the exact samples. max_abs: bound of |evaluated sample|.
    error_bound: certified bound of the L2 norm of (exact - evaluated) over all samples.
    sample_error_bound: certified bound of |exact - evaluated| of every sample.
    measured: psnr_db and max_error (largest |original - decoded|) were measured by compression; otherwise they
        follow from error_bound and sample_error_bound, as bounds.
    exact: slices equal the original samples; psnr_db is then infinite.
    background: the value of a separately stored background, or None.
    missing_samples: number of samples without a value; psnr_db and errors leave them out.
    bricks: sides of the boxes that a file decodes independently (None: not a volume in DCT blocks).
    """

    rank: int
    transform: str
    block: int
    terms: int
    rho: float
    step: float
    resident_bytes: int
    value_min: float
    value_max: float
    max_abs: float
    error_bound: float
    sample_error_bound: float
    measured: bool
    psnr_db: float
    exact: bool
    max_error: float
    background: Optional[float]
    background_samples: int
    missing_samples: int
    bricks: Optional[tuple[int, int, int]]


class Volume(NumpyArray, Algebra):
    """A compressed array of 1 to 3 axes; volumes are indexed (z, y, x).

    `compress`, `open`, and operations such as ``+ - *`` and `convolve` make volumes. Slicing decodes only the
    necessary blocks. Several threads may use a volume. `close` (or a ``with`` block) frees it early; after that
    it raises ValueError.
    """

    def __init__(self, store: Store) -> None:
        self._store = store
        self._renderer: Any = None
        self._masked: Optional[bool] = None

    @classmethod
    def _take(cls, pointer: c.c_void_p) -> "Volume":
        """Makes a volume that owns an array of the library."""
        return cls(Store(Handle(pointer.value or 0, "array_free", "the volume")))

    # ---- properties -----------------------------------------------------------------------------

    @property
    def shape(self) -> tuple[int, ...]:
        """Samples along each axis: (z, y, x)."""
        return grid_shape(self._store.grid, self._store.rank)

    @property
    def ndim(self) -> int:
        """1, 2 or 3."""
        return int(self._store.rank)

    @property
    def size(self) -> int:
        """Number of samples."""
        return int(np.prod(self.shape, dtype=object))

    @property
    def dtype(self) -> np.dtype[Any]:
        """Sample type of slices and `to_numpy`."""
        return TYPES[self._store.grid.type]

    @property
    def nbytes(self) -> int:
        """Bytes of the samples without compression."""
        return self.size * self.dtype.itemsize

    @property
    def geometry(self) -> Geometry:
        """Spacing, origin, directions, unit."""
        return grid_geometry(self._store.grid, self._store.rank)

    @property
    def spacing(self) -> tuple[float, ...]:
        """Distance of neighbours along each axis, in the order of `shape`."""
        return self.geometry.spacing

    @property
    def chunks(self) -> tuple[int, ...]:
        """Samples along each axis of the boxes that decode independently: bricks, cut to the shape."""
        brick = self._store.info.brick if self._store.info.brick[0] else self._store.grid.dims
        return tuple(min(int(b), n) for b, n in zip(reversed(brick[: self.ndim]), self.shape))

    @property
    def levels(self) -> tuple[Union["Volume", Level], ...]:
        """The volume, and coarser `Level` arrays of 1/2, 1/4 and 1/8 of its samples along each axis, as far as 8
        samples are left along the longest one. From a lossy file a level reads only its frequencies."""
        pyramid = self.ndim == 3 and self._store.transform == 1 and self._store.block != 0
        found = [k for k in range(1, COARSEST + 1) if pyramid and max(self.shape) >> k >= 8]
        return (self, *(Level(self, k) for k in found))

    @property
    def affine(self) -> NDArray[np.float64]:
        """4 x 4: from an index (z, y, x, 1) to the world (X, Y, Z, 1), see `Geometry.affine`; of rank 3 only."""
        return self.geometry.affine()

    @property
    def attrs(self) -> dict[str, Any]:
        """A copy of `attributes` as a dictionary; attributes that are no JSON object stand under "attributes"."""
        value = self.attributes
        return {} if value is None else value if isinstance(value, dict) else {"attributes": value}

    @property
    def attributes(self) -> Any:
        """The attributes of the file, a JSON value; None: none. May be set."""
        text = self._store.attributes
        return None if text is None else json.loads(text)

    @attributes.setter
    def attributes(self, value: Any) -> None:
        text = attributes_text(value)
        with Call() as call, self._store.whole() as array:
            call("array_set_attributes", array, text)
            self._store.attributes = None if text is None else text.decode()
            self._store.changed = True

    @property
    def info(self) -> Info:
        """Properties of the volume (reads the whole file)."""
        with self._store.whole() as array:
            i = info_of(array)
        return Info(
            rank=i.rank, transform=_TRANSFORMS[i.transform], block=i.block, terms=i.coefficients, rho=i.rho,
            step=i.step, resident_bytes=i.resident_bytes, value_min=i.value_min, value_max=i.value_max,
            max_abs=i.max_abs, error_bound=i.l2_error, sample_error_bound=i.point_error, measured=bool(i.measured), psnr_db=i.psnr_db,
            exact=i.psnr_db == math.inf,
            max_error=i.max_error, background=i.background if i.background_samples else None,
            background_samples=i.background_samples, missing_samples=i.missing_samples,
            bricks=(i.brick[2], i.brick[1], i.brick[0]) if i.brick[0] else None,
        )  # fmt: skip

    @property
    def error_bound(self) -> float:
        """Certified bound of the L2 distance, over all samples, from the exact result of the same operations on the
        original samples. Divided by sqrt(size): bound of the root mean square error."""
        return float(self._store.info.l2_error)

    @property
    def sample_error_bound(self) -> float:
        """Certified bound of the error of every single sample, before rounding and clamping, from the exact result of
        the same operations on the original samples. Never larger than `error_bound`."""
        return float(self._store.info.point_error)

    def __len__(self) -> int:
        return self.shape[0]

    def __repr__(self) -> str:
        where = f" of {os.path.basename(self._store.name)!r}" if self._store.path else ""
        state = " closed" if self.closed else ""
        return f"<cvol.Volume{where}{state} {' x '.join(map(str, self.shape))} {self.dtype}>"

    # ---- samples ----------------------------------------------------------------------------------

    def __getitem__(self, index: Any) -> Any:
        """Samples as a new NumPy array (or one number), by any index of NumPy: integers, slices of any step, '...',
        None, integer arrays, and arrays of bool.

        Decodes only the blocks that touch the boxes of the index; from an open file it reads only their bricks.
        """
        return self._slice(index, self.dtype, "array_evaluate_box")

    def evaluate(self, index: Any = ...) -> Any:
        """Samples as float32, neither rounded nor clamped to the sample type; `error_bound` refers to these. Samples
        without a value are their fill."""
        return self._slice(index, np.dtype(np.float32), "array_evaluate_real")

    def _slice(self, index: Any, dtype: np.dtype[Any], function: str) -> Any:
        def evaluate(out: NDArray[Any], begin: Any, end: Any, array: int) -> None:
            with Call() as call:
                call(function, address(out), array, begin, end)

        return self._gather(index, dtype, evaluate)

    def _gather(self, index: Any, dtype: np.dtype[Any], fill: Callable[..., None]) -> Any:
        """The result of an index; fill(out, begin, end, array) sets a box."""
        if self.closed:
            raise ValueError("the volume is closed")
        chosen = select(index, self.shape)
        if chosen.empty:
            return np.empty(chosen.shape, dtype)
        packed = np.empty(chosen.packed, dtype)
        for box in chosen.boxes():
            out = packed[box.place]
            part = out if out.flags.c_contiguous else np.empty(out.shape, dtype)
            begin, end = self._box(box.begin, box.end)
            with self._store.for_box(tuple(begin), tuple(end)) as array:
                fill(part, begin, end, array)
            if part is not out:
                out[...] = part
        result = packed[chosen.rest]
        # A view would keep the larger box alive.
        if isinstance(result, np.ndarray) and result.size * 2 < packed.size:
            result = result.copy()
        return result

    def _box(self, begin: tuple[int, ...], end: tuple[int, ...]) -> tuple[Any, Any]:
        more = 3 - self.ndim
        return _abi.Size3(*begin[::-1], *[0] * more), _abi.Size3(*end[::-1], *[1] * more)

    def to_numpy(self, *, progress: Optional[Progress] = None) -> NDArray[Any]:
        """All samples, in the type of the volume."""
        with options(progress=progress):
            self._store.whole()
            return self[...]  # type: ignore[no-any-return]

    def evaluate_points(self, points: ArrayLike) -> NDArray[Any]:
        """Values between samples, float32, (count,). points: (count, ndim), positions in samples, in the order of
        `shape`.

        Volumes in blocks use the interpolant of the block with the nearest sample, or its background or fill; whole
        arrays use that of the array. The corrections that make samples exact, or keep max_error, are left out:
        `sample_error_bound` bounds the difference at samples.
        Cost: O(terms) per point.
        """
        points = np.asarray(points, float)
        if points.ndim != 2 or points.shape[1] != self.ndim:
            raise ValueError(f"points have shape {points.shape}, must have (count, {self.ndim})")
        turned = np.ascontiguousarray(points[:, ::-1])
        out = np.empty(len(points), np.float32)
        with self._store.whole() as array, Call() as call:
            call("array_evaluate_points", address(out), array, address(turned), len(points))
        return out

    def evaluate_chirp(self, start: Sequence[float], step: Sequence[float], count: Sequence[int]) -> NDArray[Any]:
        """Values at the points start + i step of every axis, i < count: float32, of shape `count`. start and step in
        samples, all in the order of `shape`. Whole arrays. Cost: O((k + count) log (k + count)) per line."""
        for name, numbers in (("start", start), ("step", step), ("count", count)):
            if len(numbers) != self.ndim:
                raise ValueError(f"{name} has {len(numbers)} numbers, must have {self.ndim}")
        if min(count) < 1:
            raise ValueError(f"count is {tuple(count)}, must be at least 1 on every axis")
        pad = 3 - self.ndim
        out = np.empty(tuple(count), np.float32)
        with self._store.whole() as array, Call() as call:
            call("array_evaluate_chirp", address(out), array, _abi.Double3(*start[::-1], *[0.0] * pad),
                 _abi.Double3(*step[::-1], *[1.0] * pad), _abi.Size3(*count[::-1], *[1] * pad))  # fmt: skip
        return out

    def mask(self, index: Any = ...) -> Any:
        """The samples without a value (compress(..., fill=...)): bool, for an index as in slicing."""

        def evaluate(out: NDArray[Any], begin: Any, end: Any, array: int) -> None:
            _abi.functions["array_evaluate_mask"](address(out), array, begin, end)

        return self._gather(index, np.dtype(np.uint8), evaluate) != 0

    def _has_mask(self) -> bool:
        """Whether a sample has no value."""
        if self._masked is None:
            self._masked = any(bool(self.mask(np.s_[z : z + 64]).any()) for z in range(0, self.shape[0], 64))
        return self._masked

    def astype(self, dtype: DTypeLike) -> "Volume":
        """The volume with another sample type and the same terms. The bound grows only if a separate background is
        rounded. DataError: values do not fit."""
        result = self.scale(1, 0)
        with result._store.whole() as array, Call() as call:
            call("array_set_type", array, type_number(dtype))
            result._store.grid.type = type_number(dtype)
        return result

    def measure(self, original: ArrayLike) -> Info:
        """Measures psnr_db and max_error against the original samples."""
        samples = samples_of(original)
        if samples.shape != self.shape or samples.dtype != self.dtype:
            raise ValueError(f"the original is {samples.shape} {samples.dtype}, must be {self.shape} {self.dtype}")
        with self._store.whole() as array, Call() as call:
            call("array_measure", array, address(samples))
            self._store.refresh()
        return self.info

    # ---- files --------------------------------------------------------------------------------------

    def save(self, path: Union[str, os.PathLike[str], BinaryIO]) -> int:
        """Writes a .cvol file, which gets its name only when it is complete; or writes its bytes to an object with
        write(), such as io.BytesIO. Returns the bytes of the file. `cvol.write` writes other formats."""
        if hasattr(path, "write"):
            data = self.to_bytes()
            path.write(data)
            return len(data)
        count, name = c.c_uint64(), output_bytes(path)
        with self._store.whole() as array, Call() as call:
            call("array_write", array, name, c.byref(count))
        return count.value

    def to_bytes(self) -> bytes:
        """The bytes of a .cvol file with this volume. ``cvol.open(io.BytesIO(data))`` reads them."""
        data: bytes = self._store.to_bytes()
        return data

    def __reduce__(self) -> tuple[Any, ...]:
        """Pickles an opened file by its path, and a volume in memory by its bytes."""
        if self.closed:
            raise ValueError("the volume is closed")
        return _unpickle, self._store.recipe()

    def __dask_tokenize__(self) -> tuple[Any, ...]:
        """What dask names arrays by: the file, or a digest of the bytes."""
        _, *recipe = self._store.recipe()
        return ("cvol.Volume", *(hashlib.sha256(v).hexdigest() if isinstance(v, bytes) else v for v in recipe))

    def close(self) -> None:
        """Frees the memory. Pictures and arrays made before stay valid; later calls raise ValueError."""
        if self._renderer is not None:
            self._renderer.close()
            self._renderer = None
        self._store.close()

    @property
    def closed(self) -> bool:
        """True after `close`."""
        return bool(self._store.closed)

    def __enter__(self) -> "Volume":
        return self

    def __exit__(self, *_: Any) -> None:
        self.close()

    # ---- pictures -----------------------------------------------------------------------------------

    def render(
        self, azimuth: Optional[float] = None, elevation: Optional[float] = None, **look: Any
    ) -> NDArray[Any]:
        """Draws a picture: uint8, (height, width, 3), or (..., 4) with background="transparent".

        Options: see `Renderer.render`. Data that pictures share stay in memory until the volume is closed.
        """
        from ._render import Renderer  # circular import

        engine = look.pop("engine", "sheet")
        rho = look.pop("rho", None)
        if self._renderer is None or self._renderer.key != (engine, rho):
            renderer = Renderer(self, engine=engine, rho=rho)
            if self._renderer is not None:
                self._renderer.close()
            self._renderer = renderer
        return self._renderer.render(azimuth, elevation, **look)  # type: ignore[no-any-return]

    def view(self, *, height: int = 480, title: str = "volume") -> View:
        """An interactive view for notebooks: the page of ``cvol export --html``, which draws the volume itself.

        height: of the view, in CSS pixels. title: of the page. The page contains the compressed file, at most 200 MB.
        Without the command cvol, or without its page (``make web``), the view is a picture and a sentence that says
        so. Cost: writes the file to a temporary folder. ValueError: the volume is closed, or has not three axes.
        """
        if self.closed:
            raise ValueError("the volume is closed")
        if self.ndim != 3:
            raise ValueError(f"the volume has {self.ndim} axes, must have 3")
        return View(self, height, title)

    def _repr_html_(self) -> Optional[str]:
        return None if self.closed else picture_html(self)

    def _repr_png_(self) -> Optional[bytes]:
        if self.closed or self.ndim == 1:
            return None
        if self.ndim == 3:
            return encode_png(self.render(size=384))
        values = self.evaluate()
        low, high = float(values.min()), float(values.max())
        grey = (values - low) * (255 / (high - low) if high > low else 0)
        return encode_png(np.repeat(np.rint(grey)[..., None], 3, 2).astype(np.uint8))


def attributes_text(value: Any) -> Optional[bytes]:
    """Attributes as JSON text; None stays None."""
    return None if value is None else json.dumps(value, ensure_ascii=False).encode()


def _unpickle(make: Callable[..., Store], *arguments: Any) -> Volume:
    return Volume(make(*arguments))
