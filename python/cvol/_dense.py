"""Volumes of other formats: read densely, or compressed in memory when samples are first needed."""

from __future__ import annotations

import contextlib
import os
import threading
from collections.abc import Mapping
from typing import Any, Optional

import numpy as np
from numpy.typing import NDArray

from ._call import Handle
from ._compress import compress, missing_value
from ._geometry import Geometry
from ._reader import Reading, read_grid, read_samples
from ._store import Store, identity


class DenseVolume(np.ndarray):  # type: ignore[type-arg]
    """A NumPy array (z, y, x) with the geometry of its file. Arrays made of it have no geometry (None)."""

    geometry: Optional[Geometry]

    @classmethod
    def of(cls, samples: NDArray[Any], geometry: Geometry) -> "DenseVolume":
        """The same samples, with a geometry."""
        self = samples.view(cls)
        self.geometry = geometry
        return self

    def __array_finalize__(self, other: Any) -> None:
        self.geometry = None

    @property
    def spacing(self) -> tuple[float, ...]:
        """Distance of neighbours along each axis, in the order of `shape`."""
        return self._placed().spacing

    @property
    def affine(self) -> NDArray[np.float64]:
        """4 x 4: from an index (z, y, x, 1) to the world (X, Y, Z, 1)."""
        return self._placed().affine()

    def _placed(self) -> Geometry:
        if self.geometry is None:
            raise AttributeError("this array was made of a volume and has no geometry: take it from the volume")
        return self.geometry


class DenseStore(Store):
    """The coefficients of a file of another format; the first use of samples reads and compresses it."""

    def __init__(
        self, path: str, reading: Reading, options: Mapping[str, object], found: Optional[tuple[int, ...]] = None
    ) -> None:
        # pylint: disable=super-init-not-called
        self.path, self.place, self.changed = path, (0, 0), False
        self._reading, self._options = reading, dict(options)
        self._lock = threading.Lock()
        self._closed = False
        self._whole = self._part = self._part_box = None
        self._levels = {}
        self._info: Any = None
        self.grid = read_grid(path, reading)
        self._found = identity(path) if os.path.exists(path) else ()  # none for datasets in HDF5 files
        if found is not None:
            self._check_same(found)
        self.attributes = None
        self.rank, self.transform, self.block = 3, 1, 16

    @property
    def info(self) -> Any:
        """Properties of the array."""
        if self._info is None:
            self.whole()
        return self._info

    @info.setter
    def info(self, value: Any) -> None:
        self._info = value

    def whole(self) -> Handle:
        with self._lock:
            self._check()
            if self._whole is None:
                if self._found:
                    self._check_file()
                samples, geometry = read_samples(self.path or "", self._reading)
                options = dict(self._options)
                options.setdefault("fill", missing_value(samples))
                store = compress(samples, geometry=geometry, **options)._store  # type: ignore[arg-type]
                self._whole, self._info, self.grid, self.block = store._whole, store.info, store.grid, store.block
                self.rank, self.transform, self.attributes = store.rank, store.transform, store.attributes
            assert self._whole is not None
            return self._whole

    def for_box(
        self, begin: tuple[int, int, int], end: tuple[int, int, int]
    ) -> contextlib.AbstractContextManager[int]:
        return self.whole().hold()

    def at_level(self, level: int) -> Handle:
        return self.whole()

    def recipe(self) -> tuple[Any, ...]:
        if self.changed or self.path is None:
            return Store.from_bytes, self.to_bytes(), "the pickled volume"
        return DenseStore, os.path.abspath(self.path), self._reading, self._options, self._found[2:]
