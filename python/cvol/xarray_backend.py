# mypy: allow-untyped-calls
"""Backend "cvol" of xarray: ``xr.open_dataset("scan.cvol", engine="cvol")`` (python/README.md).

The dataset has one variable, "volume", whose samples are decoded when they are used.
"""

from __future__ import annotations

import os
import threading
from collections.abc import Iterable
from typing import Any, Optional, Union

import numpy as np
import xarray as xr
from numpy.typing import NDArray
from xarray.backends import BackendArray, BackendEntrypoint
from xarray.core import indexing
from xarray.core.nputils import NumpyVIndexAdapter

from . import _abi
from ._call import path_bytes
from ._dask import chunk_shape
from ._files import open as open_volume
from ._geometry import Geometry
from ._index import select
from ._reader import count_volumes
from ._series import Contents, contents
from ._volume import Volume

_AXES = ("z", "y", "x")
_SERIES = 4  # cvol_file_kind


class _Samples(BackendArray):
    """The samples of a file: (time, channel, z, y, x), without the axes of time and channel that it does not have.
    Volumes are opened when they are first needed."""

    def __init__(self, path: str, times: int, channels: int) -> None:
        self.path = path
        self._times, self._channels = times, channels
        self._lock = threading.Lock()
        self._open: dict[tuple[int, int], Volume] = {}
        first = self.volume(0, 0)
        if first.ndim != 3:
            raise ValueError(f"{path}: has {first.ndim} axes, must have 3")
        self._leading = tuple(n for n in (self._times, self._channels) if n > 1)
        self.shape = (*self._leading, *first.shape)
        self.dtype = first.dtype

    def __getstate__(self) -> dict[str, Any]:
        return {key: value for key, value in self.__dict__.items() if key != "_lock"}

    def __setstate__(self, state: dict[str, Any]) -> None:
        self.__dict__.update(state, _lock=threading.Lock())

    def volume(self, time: int, channel: int) -> Volume:
        """One volume of the file."""
        with self._lock:
            if (time, channel) not in self._open:
                self._open[time, channel] = open_volume(
                    self.path, time=time if self._times > 1 else None, channel=channel if self._channels > 1 else None
                )
            return self._open[time, channel]

    def __getitem__(self, key: Any) -> NDArray[Any]:
        # Not by xarray's explicit_indexing_adapter: that of 2022.12 selects wrong samples for steps of -3 and below.
        if not isinstance(key, indexing.VectorizedIndexer):
            return self._get(key.tuple)
        outer, rest = [], []
        for part in key.tuple:
            values, places = (part, slice(None)) if isinstance(part, slice) else np.unique(part, return_inverse=True)
            outer.append(values)
            rest.append(places if isinstance(part, slice) else places.reshape(np.shape(part)))
        return np.asarray(NumpyVIndexAdapter(self._get(tuple(outer)))[tuple(rest)])

    def _get(self, key: tuple[Any, ...]) -> NDArray[Any]:
        """Samples of an outer index: integers, slices and integer arrays, each for its axis."""
        leading = len(self._leading)
        chosen = [np.arange(n)[part] for n, part in zip(self._leading, key)]
        inner = _outer(key[leading:], self.shape[leading:])
        out = np.empty([*map(np.size, chosen), *select(inner, self.shape[leading:]).shape], self.dtype)
        for place in np.ndindex(*out.shape[:leading]):
            wanted = [int(np.ravel(c)[k]) for c, k in zip(chosen, place)]
            time = wanted[0] if self._times > 1 else 0
            out[place] = self.volume(time, wanted[-1] if self._channels > 1 else 0)[inner]
        return out.reshape([n for c in chosen for n in c.shape] + list(out.shape[leading:]))

    def close(self) -> None:
        """Closes the volumes that were opened."""
        with self._lock:
            for volume in self._open.values():
                volume.close()


def _outer(key: tuple[Any, ...], shape: tuple[int, ...]) -> tuple[Any, ...]:
    """An outer index as NumPy's: arrays of several axes become an open mesh; slices stay if there is one array."""
    arrays = [k for k, part in enumerate(key) if isinstance(part, np.ndarray)]
    if len(arrays) < 2 and not (arrays and any(isinstance(p, (int, np.integer)) for p in key)):
        return key
    axes = [part if not isinstance(part, slice) else np.arange(n)[part] for part, n in zip(key, shape)]
    free = [k for k, part in enumerate(axes) if isinstance(part, np.ndarray)]
    return tuple(part.reshape([-1 if k == f else 1 for f in free]) if isinstance(part, np.ndarray) else part
                 for k, part in enumerate(axes))  # fmt: skip


def _coordinates(geometry: Geometry, shape: tuple[int, ...]) -> dict[str, Any]:
    """Positions along each axis: in the world if x, y and z run along X, Y and Z, forwards or backwards; else
    distances from the first sample."""
    matrix = geometry.affine()[:3, :3][:, ::-1]  # columns x, y, z
    straight = np.allclose(matrix, np.diag(np.diag(matrix)), atol=1e-6 * max(geometry.spacing))
    out = {}
    for k, name in enumerate(_AXES):
        world = 2 - k
        step = matrix[world, world] if straight else geometry.spacing[k]
        begin = geometry.origin[world] if straight else 0.0
        attrs = {"units": geometry.unit} if geometry.unit else {}
        out[name] = xr.Variable((name,), begin + step * np.arange(shape[k]), attrs)
    return out


def _attributes(volume: Volume) -> dict[str, Any]:
    """Those of the file, and its geometry."""
    g = volume.geometry
    out: dict[str, Any] = {**volume.attrs, "affine": g.affine()}
    if g.space:
        out["space"] = g.space
    if (g.value_scale, g.value_offset) != (1, 0):
        out["value_scale"], out["value_offset"] = g.value_scale, g.value_offset
    return out


def _listed(path: str) -> Contents:
    """The times and channels of a file of any format."""
    if _abi.functions["file_is_cvol"](path_bytes(path)):
        return contents(path)
    times, channels = count_volumes(path)
    rows = ((0,) * channels,) * times
    return Contents(times, channels, tuple(map(float, range(times))), "", ("",) * channels, (), False, rows)


class CvolBackend(BackendEntrypoint):
    """Opens .cvol files, and with engine="cvol" the other formats of `cvol.open`."""

    description = "Open compressed volumes (.cvol)"
    url = ""

    def guess_can_open(self, filename_or_obj: Any) -> bool:
        """Whether the file is one of arrays in .cvol."""
        if not isinstance(filename_or_obj, (str, os.PathLike)):
            return False
        return _abi.functions["file_kind_of"](path_bytes(filename_or_obj)) in (1, _SERIES)

    def open_dataset(  # type: ignore[override]
        self, filename_or_obj: Any, *, drop_variables: Union[str, Iterable[str], None] = None
    ) -> xr.Dataset:
        """A dataset of the variable "volume"."""
        path = os.path.abspath(os.fspath(filename_or_obj))
        listed = _listed(path)
        samples = _Samples(path, listed.times, listed.channels)
        first = samples.volume(0, 0)
        dims = list(_AXES)
        coordinates = _coordinates(first.geometry, first.shape)
        if listed.channels > 1:
            dims.insert(0, "channel")
            if any(listed.channel_names):
                coordinates["channel"] = xr.Variable(("channel",), list(listed.channel_names))
        if listed.times > 1:
            dims.insert(0, "time")
            units = {"units": listed.time_unit} if listed.time_unit else {}
            coordinates["time"] = xr.Variable(("time",), np.array(listed.time_values), units)
        chunks = (1,) * (len(dims) - 3) + chunk_shape(first.chunks, first.shape, first.dtype.itemsize)
        variable = xr.Variable(dims, indexing.LazilyIndexedArray(samples), _attributes(first))
        variable.encoding = {"source": path, "preferred_chunks": dict(zip(dims, chunks))}
        dropped = {drop_variables} if isinstance(drop_variables, str) else set(drop_variables or ())
        variables = {} if "volume" in dropped else {"volume": variable}
        dataset = xr.Dataset(variables, coords={k: v for k, v in coordinates.items() if k not in dropped})
        dataset.set_close(samples.close)
        return dataset
