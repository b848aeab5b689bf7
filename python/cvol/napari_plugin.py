"""Reader and writers of .cvol files for napari (npe2; the manifest is napari.yaml).

A layer for each channel, whose levels and times are decoded when napari shows them.
"""

from __future__ import annotations

import math
import os
import threading
from collections import OrderedDict
from collections.abc import Callable, Mapping, Sequence
from typing import Any, Optional, Union

import numpy as np
from numpy.typing import NDArray

from . import _abi
from ._call import path_bytes
from ._compress import compress, is_labels
from ._files import open as open_volume
from ._frames import all_frames, frames_at
from ._geometry import Geometry
from ._levels import Level
from ._series import Colour, Contents, contents, save_series
from ._volume import Volume

LayerData = tuple[Any, dict[str, Any], str]  # of napari: data, options of the layer, its type
_SERIES = 4  # cvol_file_kind
_OPEN = 8  # volumes of a file that stay open


class _File:
    """The volumes of a file; the ones used last stay open."""

    def __init__(self, path: str) -> None:
        self.path = path
        self.listed: Contents = contents(path)
        self._lock = threading.Lock()
        self._open: OrderedDict[tuple[int, int], Volume] = OrderedDict()

    def volume(self, time: int, channel: int) -> Volume:
        """The volume of a time and a channel."""
        place = (time, channel)
        with self._lock:
            if place not in self._open:
                self._open[place] = open_volume(self.path, time=time, channel=channel)
            self._open.move_to_end(place)
            while len(self._open) > _OPEN:
                self._open.popitem(last=False)  # not closed: another thread may use it
            return self._open[place]


class Run:
    """A lazy array (time, z, y, x) of a channel at a level. An index decodes the times and samples that it selects."""

    def __init__(self, file: _File, channel: int, level: int) -> None:
        self._file, self._channel, self._level = file, channel, level
        first = self._at(0)
        self.shape: tuple[int, ...] = (file.listed.times, *first.shape)
        self.dtype: np.dtype[Any] = first.dtype
        self.ndim = 4
        self.size = math.prod(self.shape)
        self.nbytes = self.size * self.dtype.itemsize

    def _at(self, time: int) -> Union[Volume, Level]:
        return self._file.volume(time, self._channel).levels[self._level]

    def __len__(self) -> int:
        return self.shape[0]

    def __getitem__(self, index: Any) -> Any:
        return frames_at(index, self._at, self.shape)

    def __array__(self, dtype: Any = None, copy: Optional[bool] = None) -> NDArray[Any]:
        if copy is False:
            raise ValueError("a series always returns a copy of its samples")
        return all_frames(self._at, self.shape[0], dtype)


def get_reader(path: Union[str, Sequence[str]]) -> Optional[Callable[[Union[str, Sequence[str]]], list[LayerData]]]:
    """npe2's command of readers: `read`, if each path is a .cvol file of arrays; else None."""
    paths = [path] if isinstance(path, (str, os.PathLike)) else list(path)
    kinds = [_abi.functions["file_kind_of"](path_bytes(p)) if os.path.isfile(p) else 0 for p in paths]
    return read if paths and all(kind in (1, _SERIES) for kind in kinds) else None


def read(path: Union[str, Sequence[str]]) -> list[LayerData]:
    """The layers of one or several files, in the order of their channels.

    Images are multiscale, with the levels of the file. Labels are layers of labels: files with a table of labels, and
    lossless files of integers whose middle looks like labels. Several times are the first axis.
    """
    paths = [path] if isinstance(path, (str, os.PathLike)) else list(path)
    return [layer for p in paths for layer in _layers(os.path.abspath(p))]


def _layers(path: str) -> list[LayerData]:
    file = _File(path)
    channels = range(file.listed.channels)
    if file.listed.colours:  # the fourth channel is opacity
        channels = channels[:3]
    return [_layer(file, channel) for channel in channels]


def _is_labels(volume: Volume) -> bool:
    if volume.ndim != 3 or volume.dtype.kind not in "iu":
        return False
    if isinstance(volume.attrs.get("labels"), list):
        return True
    if volume._store.info.psnr_db != math.inf:
        return False
    middle = max(volume.shape[0] // 2 - 32, 0)
    return is_labels(volume[middle : middle + 64])


def _layer(file: _File, channel: int) -> LayerData:
    listed, first = file.listed, file.volume(0, channel)
    stem = os.path.splitext(os.path.basename(file.path))[0]
    word = listed.channel_names[channel] or ("red", "green", "blue", "")[channel] * listed.colours or str(channel)
    name = stem if listed.channels == 1 else f"{stem} {word}"
    options: dict[str, Any] = {"name": name, "metadata": {"path": file.path, "unit": first.geometry.unit,
                               "time_unit": listed.time_unit, "attributes": first.attrs}}  # fmt: skip
    options.update(_place(first, listed))
    levels: list[Any] = list(first.levels)
    if listed.times > 1:
        levels = [Run(file, channel, k) for k in range(len(levels))]
    if _is_labels(first):  # means of labels are no labels: no levels
        table = [row for row in first.attrs.get("labels") or () if isinstance(row, dict) and "value" in row]
        if table:
            options["features"] = {"index": [row["value"] for row in table], "name": [row.get("name") for row in table]}
        return levels[0], options, "labels"
    low, high = first._store.info.value_min, first._store.info.value_max
    if math.isfinite(low) and math.isfinite(high) and low < high:
        options["contrast_limits"] = (low, high)
    if listed.channels > 1:
        rgb = listed.channel_colours[channel]
        options["blending"] = "additive"
        options["colormap"] = {"name": f"cvol {name}", "colors": [[0.0, 0.0, 0.0, 1.0], [*rgb, 1.0]]}
    options["multiscale"] = len(levels) > 1
    return levels if len(levels) > 1 else levels[0], options, "image"


def _place(volume: Volume, listed: Contents) -> dict[str, Any]:
    """scale and translate of a layer, or affine if the axes do not run along Z, Y and X. Times at equal distances have
    these; others count from 0."""
    steps = np.diff(listed.time_values)
    even = listed.times > 1 and np.ptp(steps) <= 1e-6 * abs(steps).max() and steps[0] > 0
    time = [float(steps[0]) if even else 1.0] if listed.times > 1 else []
    begin = [listed.time_values[0] if even else 0.0] if listed.times > 1 else []
    n = volume.ndim
    if n < 3:
        return {"scale": [*time, *volume.spacing[:n]]}
    matrix = volume.affine[[2, 1, 0, 3]]  # from (z, y, x, 1) to (Z, Y, X, 1)
    if np.allclose(matrix[:3, :3], np.diag(volume.spacing), atol=1e-6 * max(volume.spacing)):
        return {"scale": [*time, *volume.spacing], "translate": [*begin, *map(float, matrix[:3, 3])]}
    whole = np.eye(4 + len(time))
    whole[len(time) :, len(time) :] = matrix
    if time:
        whole[0, 0], whole[0, -1] = time[0], begin[0]
    return {"affine": whole}


# ---- writers ---------------------------------------------------------------------------------------


def _samples(data: Any) -> NDArray[Any]:
    """The samples of a layer, of its finest level if it has several."""
    finest = data[0] if isinstance(data, (list, tuple)) or type(data).__name__ == "MultiScaleData" else data
    return np.asarray(finest)


def _geometry(meta: Mapping[str, Any], ndim: int) -> tuple[Geometry, float, float]:
    """The geometry of the last three axes, and the step and the begin of times."""
    scale = np.asarray(meta.get("scale", np.ones(ndim)), float)
    linear = np.asarray(meta.get("rotate", np.eye(ndim)), float)
    linear = (linear if linear.shape == (ndim, ndim) else np.eye(ndim)) * scale
    matrix = np.eye(ndim + 1)
    matrix[:ndim, :ndim] = linear
    matrix[:ndim, ndim] = meta.get("translate", np.zeros(ndim))
    affine = meta.get("affine")
    if affine is not None:
        matrix = np.asarray(getattr(affine, "affine_matrix", affine), float) @ matrix
    first = ndim - 3
    axes = matrix[first:ndim, first:ndim]
    spacing = np.sqrt((axes**2).sum(0))
    if not (np.isfinite(spacing).all() and spacing.min() > 0):
        raise ValueError(f"the layer has the scale {scale.tolist()}, must be positive numbers")
    direction = (axes / spacing).T[:, ::-1]  # a row (X, Y, Z) for each axis
    if not np.allclose(direction @ direction.T, np.eye(3), atol=1e-4):
        raise ValueError("the layer is sheared, for which a .cvol file has no field: remove the shear first")
    straight = np.allclose(direction, np.eye(3)[::-1], atol=1e-6)
    z, y, x = matrix[first:ndim, ndim]
    kept = meta.get("metadata") or {}
    geometry = Geometry(spacing=tuple(spacing.tolist()), origin=(float(x), float(y), float(z)),
                        direction=None if straight else direction.tolist(), unit=str(kept.get("unit", "")))  # fmt: skip
    return geometry, float(matrix[0, 0]) if first else 1.0, float(matrix[0, ndim]) if first else 0.0


def _write(path: str, layers: Sequence[tuple[Any, Mapping[str, Any]]], labels: Optional[bool]) -> list[str]:
    arrays = [_samples(data) for data, _ in layers]
    first = arrays[0]
    if any(a.shape != first.shape or a.dtype != first.dtype for a in arrays):
        found = ", ".join(f"{a.shape} {a.dtype}" for a in arrays)
        raise ValueError(f"the layers are {found}: channels of one file must have the same shape and type")
    if first.ndim not in (3, 4):
        raise ValueError(f"the layer has {first.ndim} axes, must have 3 (z, y, x) or 4 (time, z, y, x)")
    geometry, step, begin = _geometry(layers[0][1], first.ndim)
    frames = [a[None] if a.ndim == 3 else a for a in arrays]
    times = len(frames[0])
    if times * len(layers) == 1:
        compress(frames[0][0], geometry=geometry, labels=labels, attributes=_attributes(layers[0][1])).save(path)
        return [path]
    volumes = (compress(f[t], geometry=geometry, labels=labels, attributes=_attributes(meta))
               for t in range(times) for f, (_, meta) in zip(frames, layers))  # fmt: skip
    several = len(layers) > 1
    save_series(
        path, volumes, times=times, channels=len(layers), time_values=[begin + step * t for t in range(times)],
        time_unit=str((layers[0][1].get("metadata") or {}).get("time_unit", "")),
        channel_names=[str(meta.get("name", k)) for k, (_, meta) in enumerate(layers)] if several else None,
        channel_colours=[_colour(meta) for _, meta in layers] if several else None,
    )  # fmt: skip
    return [path]


def _attributes(meta: Mapping[str, Any]) -> Optional[dict[str, Any]]:
    return (meta.get("metadata") or {}).get("attributes") or None


def _colour(meta: Mapping[str, Any]) -> Colour:
    """The last colour of the colormap of a layer; white if it has none."""
    colormap = meta.get("colormap")
    colours = colormap.get("colors") if isinstance(colormap, dict) else getattr(colormap, "colors", None)
    if colours is None:
        return (1.0, 1.0, 1.0)
    red, green, blue = np.clip(np.asarray(colours, float)[-1, :3], 0, 1).tolist()
    return (red, green, blue)


def write_image(path: str, data: Any, meta: dict[str, Any]) -> list[str]:
    """npe2's command for one image, (z, y, x) or (time, z, y, x): at the default ratio of `compress`. Returns the
    paths written. ValueError: another number of axes, or a sheared layer."""
    if meta.get("rgb"):
        raise ValueError("the layer has colours (rgb): split it into channels, by a right click on the layer, first")
    return _write(path, [(data, meta)], False)


def write_labels(path: str, data: Any, meta: dict[str, Any]) -> list[str]:
    """npe2's command for labels: without loss."""
    return _write(path, [(data, meta)], True)


def write_channels(path: str, layers: list[tuple[Any, dict[str, Any], str]]) -> list[str]:
    """npe2's command for several images of the same shape and type: as channels, with their names and colours."""
    return _write(path, [(data, meta) for data, meta, _ in layers], False)
