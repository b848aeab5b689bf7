"""OME-Zarr 0.4 and 0.5 (OME-NGFF): images of a folder of Zarr arrays, with levels, spacing and units (doc/zarr.md).

`cvol.open` and `cvol.read` read such folders, and single Zarr arrays, through this module. Folders of Zarr
format 2 (OME-Zarr 0.4) need the package zarr; those of format 3 (OME-Zarr 0.5) do not.
"""

from __future__ import annotations

import json
import os
import warnings
from collections.abc import Callable, Mapping
from typing import Any, Literal, NamedTuple, Optional, Union

import numpy as np
from numpy.typing import NDArray

from . import _zarr3
from ._call import ArgumentError, FormatError, UnsupportedError
from ._geometry import Geometry
from ._volume import Volume

_UNITS = {"nanometer": "nm", "micrometer": "um", "millimeter": "mm", "centimeter": "cm", "meter": "m", "angstrom": "A"}
_NAMES = {short: name for name, short in _UNITS.items()}
_AXES = ("t", "c", "z", "y", "x")


class Image(NamedTuple):
    """An array, the names of its axes, and the position of the samples along these: scale and translation.

    scale, translation: one number for each axis. unit: of z, y and x."""

    array: Any
    axes: tuple[str, ...]
    scale: tuple[float, ...]
    translation: tuple[float, ...]
    unit: str
    channel_names: tuple[str, ...]

    def count(self, axis: str) -> int:
        """Length of an axis; 1 if there is none."""
        return int(self.array.shape[self.axes.index(axis)]) if axis in self.axes else 1

    def geometry(self) -> Geometry:
        """Spacing and origin of a volume."""
        at = {name: (s, t) for name, s, t in zip(self.axes, self.scale, self.translation)}
        places = [at.get(name, (1.0, 0.0)) for name in ("z", "y", "x")]
        return Geometry(
            spacing=tuple(abs(s) for s, _ in places), origin=(places[2][1], places[1][1], places[0][1]), unit=self.unit
        )

    def check(self, time: Optional[int], channel: Optional[int]) -> None:
        """ArgumentError: there is no such time or channel, or several and none is chosen."""
        for axis, word, given in (("t", "time", time), ("c", "channel", channel)):
            n = self.count(axis)
            if given is None and n > 1:
                raise ArgumentError(f"{self.array.store.path}: has {n} {word}s: choose one with {word}=, from 0")
            if not 0 <= (given or 0) < n:
                raise ArgumentError(f"{self.array.store.path}: has {n} {word}s, from 0; number {given} was requested")

    def samples(self, time: Optional[int], channel: Optional[int]) -> NDArray[Any]:
        """The samples (z, y, x) of a time and a channel."""
        self.check(time, channel)
        chosen: dict[str, Any] = {"t": time or 0, "c": channel or 0}
        samples = np.asarray(self.array[tuple(chosen.get(axis, slice(None)) for axis in self.axes)])
        return samples.reshape((1,) * (3 - samples.ndim) + samples.shape)


def _json(path: str) -> Any:
    try:
        with open(path, encoding="utf-8") as file:
            return json.load(file)
    except FileNotFoundError:
        return {}
    except ValueError as error:
        raise FormatError(f"{path}: is not JSON: {error}") from None


def _transforms(parts: Any, rank: int, path: str) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Scale and translation of a list of coordinateTransformations."""
    scale, translation = np.ones(rank), np.zeros(rank)
    for part in parts or ():
        kind = part.get("type")
        numbers = part.get(kind) if kind in ("scale", "translation") else np.zeros(rank) if kind == "identity" else None
        if numbers is None or len(numbers) != rank:
            raise FormatError(f"{path}: a transformation is {part!r}, must be a scale or a translation of {rank} "
                              "numbers")  # fmt: skip
        if kind == "scale" and not (np.isfinite(numbers).all() and np.min(numbers) > 0):
            raise FormatError(f"{path}: a scale is {numbers!r}, must be positive numbers")
        if kind == "scale":
            scale, translation = scale * numbers, translation * numbers
        else:
            translation = translation + numbers
    return scale, translation


def _place(multiscale: Any, dataset: Any, path: str) -> tuple[tuple[str, ...], list[float], list[float], str]:
    axes = tuple(a["name"] if isinstance(a, dict) else a for a in multiscale.get("axes", _AXES))
    if not set(axes) <= set(_AXES) or axes != tuple(a for a in _AXES if a in axes) or not {"y", "x"} <= set(axes):
        named = ", ".join(map(str, axes))
        raise UnsupportedError(f"{path}: has the axes {named}, must be of t, c, z, y, x in this order")
    inner = _transforms(dataset.get("coordinateTransformations"), len(axes), path)
    outer = _transforms(multiscale.get("coordinateTransformations"), len(axes), path)
    spatial = [a for a in multiscale.get("axes", ()) if isinstance(a, dict) and a["name"] in ("z", "y", "x")]
    units = [a.get("unit", "") for a in spatial]
    unit = _UNITS.get(units[0], "") if len(set(units)) == 1 else ""
    return axes, list(inner[0] * outer[0]), list(inner[1] * outer[0] + outer[1]), unit


def open_image(path: str, level: int = 0) -> Image:
    """An image of a folder: a group with multiscales, one of its arrays, or an array without them (axes t, c, z, y, x,
    from the last one).

    level: of a group, from 0, the finest. FormatError: not such a folder; ImportError: zarr is not installed.
    """
    path = os.path.abspath(path)
    found_3 = _zarr3.read_metadata(path)
    if found_3 is not None:
        return _open_image_3(path, found_3, level)
    try:
        import zarr  # type: ignore[import]

        from . import codecs  # noqa: F401  registers the codec
    except ImportError:
        raise ImportError(f"{path}: reading Zarr needs the package zarr, which is not installed") from None
    group, name = (path, None) if not os.path.exists(os.path.join(path, ".zarray")) else os.path.split(path)
    return _choose(path, group, name, _json(os.path.join(group, ".zattrs")), level,
                   lambda folder: zarr.open(folder, mode="r"))  # fmt: skip


def _open_image_3(path: str, metadata: Mapping[str, Any], level: int) -> Image:
    """An image of Zarr format 3; attributes of OME-Zarr 0.5 stand under "ome"."""

    def open_array(folder: str) -> _zarr3.Array:
        found = _zarr3.read_metadata(folder)
        if found is None or found.get("node_type") != "array":
            raise FormatError(f"{folder}: is not an array of Zarr format 3")
        return _zarr3.Array(folder, found)

    is_array = metadata.get("node_type") == "array"
    group, name = os.path.split(path) if is_array else (path, None)
    above = _zarr3.read_metadata(group) if is_array else metadata
    attributes = ((above or {}).get("attributes") or {}).get("ome") or {}
    return _choose(path, group, name, attributes, level, open_array)


def _choose(
    path: str, group: str, name: Optional[str], attributes: Mapping[str, Any], level: int,
    open_array: Callable[[str], Any],
) -> Image:
    """The image of a level of a group, or of its array `name`."""
    scales = attributes.get("multiscales") or [{}]
    datasets = scales[0].get("datasets") or []
    if name is None and not datasets:
        raise FormatError(f"{path}: is a group of Zarr without multiscales: open one of its arrays")
    if name is None and not 0 <= level < len(datasets):
        raise ArgumentError(f"{path}: has {len(datasets)} levels, number {level} was requested")
    found = [d for d in datasets if d["path"] == name] if name is not None else [datasets[level]]
    array = open_array(os.path.join(group, found[0]["path"]) if found else path)
    names = tuple(str(c.get("label", "")) for c in attributes.get("omero", {}).get("channels", ()))
    if not found:
        if not 1 <= array.ndim <= 5:
            raise UnsupportedError(f"{path}: has {array.ndim} axes, must have 1 to 5")
        return Image(array, _AXES[5 - array.ndim :], (1.0,) * array.ndim, (0.0,) * array.ndim, "", ())
    axes, scale, translation, unit = _place(scales[0], found[0], path)
    if len(axes) != array.ndim:
        raise FormatError(f"{path}: the array {found[0]['path']} has {array.ndim} axes, its description {len(axes)}")
    return Image(array, axes, tuple(scale), tuple(translation), unit, names)


def _position(volume: Volume) -> tuple[tuple[float, ...], tuple[float, ...]]:
    """Spacing and origin (z, y, x). Warns of directions, for which the format has no field."""
    g = volume.geometry
    straight = np.allclose(g.affine()[:3, :3], np.diag(g.spacing)[::-1], atol=1e-6 * max(g.spacing))
    if not straight:
        warnings.warn("OME-Zarr 0.4 has no field for directions: the axes are written as if they ran along Z, Y and X",
                      stacklevel=3)  # fmt: skip
    return g.spacing, g.origin[::-1]


def write(
    path: Union[str, "os.PathLike[str]"],
    volume: Volume,
    *,
    compressor: Any = "cvol",
    chunks: tuple[int, int, int] = (64, 64, 64),
    labels: bool = False,
    attributes: Optional[Mapping[str, object]] = None,
    version: Literal["0.4", "0.5"] = "0.4",
) -> None:
    """Writes a volume as OME-Zarr: its `levels`, each as an array "0", "1", ..., with scale and translation.

    path: a new folder, by convention NAME.ome.zarr. compressor: a codec of numcodecs, "cvol" for this package's
    without loss, or None; version 0.5 takes cvol, gzip, zstd and blosc. chunks: sides (z, y, x). labels: coarser levels
    take every second sample instead of means. attributes: further entries next to "multiscales", such as "omero".
    version: "0.4" writes Zarr format 2 and needs the package zarr; "0.5" writes Zarr format 3.
    """
    if version not in ("0.4", "0.5"):
        raise ValueError(f"version is {version!r}, must be '0.4' or '0.5'")
    if volume.ndim != 3:
        raise ValueError(f"the volume has {volume.ndim} axes, must have 3")
    name = os.fspath(path)
    if os.path.exists(name):
        raise FileExistsError(f"{name}: exists: remove it first")
    spacing, origin = _position(volume)
    writer = _arrays_2(name, compressor) if version == "0.4" else _arrays_3(name, compressor)
    datasets = []
    for k, level in enumerate(volume.levels):
        factor = 2**k
        sides = tuple(min(c, n) for c, n in zip(chunks, level.shape))
        put = writer(str(k), level, sides)
        for i, z in enumerate(range(0, level.shape[0], sides[0])):
            end = z + sides[0]
            put(i, volume[z * factor : end * factor : factor, ::factor, ::factor] if labels else level[z:end])
        shift = 0.0 if labels else (factor - 1) / 2
        datasets.append({"path": str(k), "coordinateTransformations": [
            {"type": "scale", "scale": [s * factor for s in spacing]},
            {"type": "translation", "translation": [o + shift * s for o, s in zip(origin, spacing)]},
        ]})  # fmt: skip
    unit = _NAMES.get(volume.geometry.unit)
    axes = [{"name": a, "type": "space", **({"unit": unit} if unit else {})} for a in ("z", "y", "x")]
    title = os.path.basename(name.rstrip(os.sep)).split(".")[0]
    scales: dict[str, object] = {"name": title, "axes": axes, "datasets": datasets}
    if version == "0.5":
        ome: dict[str, object] = {**(attributes or {}), "version": "0.5", "multiscales": [scales]}
        _zarr3.write_metadata(name, {"zarr_format": 3, "node_type": "group", "attributes": {"ome": ome}})
        return
    import zarr

    entries: Any = {"multiscales": [{**scales, "version": "0.4"}], **(attributes or {})}
    zarr.open_group(name, mode="r+").attrs.update(entries)


_Put = Callable[[int, NDArray[Any]], None]  # writes the samples of a layer of chunks, by its number along z


def _arrays_2(folder: str, compressor: Any) -> Callable[[str, Any, tuple[int, ...]], _Put]:
    """Makes a group of Zarr format 2; the result makes its arrays."""
    import zarr

    from .codecs import Cvol

    codec = Cvol() if isinstance(compressor, str) and compressor == "cvol" else compressor
    group = zarr.open_group(folder, mode="w")

    def make(name: str, level: Any, sides: tuple[int, ...]) -> _Put:
        array = group.create_dataset(name, shape=level.shape, chunks=sides, dtype=level.dtype, compressor=codec,
                                     dimension_separator="/")  # fmt: skip

        def put(i: int, samples: NDArray[Any]) -> None:
            array[i * sides[0] : i * sides[0] + len(samples)] = samples

        return put

    return make


def _arrays_3(folder: str, compressor: Any) -> Callable[[str, Any, tuple[int, ...]], _Put]:
    """Makes arrays of Zarr format 3."""
    codecs = _zarr3.codec_metadata(compressor)

    def make(name: str, level: Any, sides: tuple[int, ...]) -> _Put:
        return _zarr3.Writer(os.path.join(folder, name), level.shape, sides, level.dtype, codecs).write

    return make
