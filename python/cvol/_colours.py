"""Volumes of colours: red, green and blue, and perhaps alpha, drawn together."""

from __future__ import annotations

import ctypes as c
import os
from collections.abc import Mapping, Sequence
from contextlib import ExitStack
from typing import Any, Literal, Optional, Union

import numpy as np
from numpy.typing import NDArray

from . import _abi, _look, _transfer
from ._call import ArgumentError, Call, Handle, out_pointer, path_bytes
from ._files import open as open_volume
from ._frames import Series
from ._geometry import Geometry
from ._picture import encode_png
from ._reader import count_volumes, has_colours
from ._render import Renderer
from ._series import contents, save_series
from ._volume import Volume

_COMPOSITE = 1
Window = Optional[tuple[float, float]]


class _ColourRenderer(Renderer):
    """Draws the shape of the components, a sum or alpha, and gives its pixels the colours of the samples
    (cvol_image_colour_components)."""

    colours_pixels = True

    def __init__(self, volumes: Sequence[Volume], window: Window) -> None:
        self._components = [volume._store.whole() for volume in volumes]
        with ExitStack() as stack:
            arrays = [stack.enter_context(component) for component in self._components]
            histogram = _transfer.histogram_of(arrays[3]) if len(arrays) == 4 else None
            if histogram is not None and not histogram.max > histogram.min:
                arrays.pop()  # an alpha that is the same everywhere does not count
            shape, self._colours = _make_colours(arrays, window)
        super().__init__(Volume(shape))

    def _set_transfer(self, renderer: int, transfer: Any, window: Any, opacity_scale: float, rescale: Any) -> None:
        plain, out = out_pointer(), out_pointer()
        with self._colours as colours, Call() as call:
            call("colours_create_transfer", c.byref(plain), colours)
            with Handle(plain.value or 0, "transfer_free", "the transfer function") as pointer:
                call("transfer_create_adjusted", c.byref(out), pointer, None, opacity_scale)
            self._transfer = Handle(out.value or 0, "transfer_free", "the transfer function")
            with self._transfer as made:
                call("renderer_set_transfer", renderer, made)

    def _draw(self, renderer: int, image: Any, options: Any, budget_ms: Optional[float]) -> int:
        depth = np.full((options.height, options.width), np.inf, np.float32)
        own = not image.depth
        if own:
            image.depth = depth.ctypes.data
        assert self._transfer is not None
        with ExitStack() as stack:
            for component in self._components:
                stack.enter_context(component)
            colours, transfer = stack.enter_context(self._colours), stack.enter_context(self._transfer)
            options.level = super()._draw(renderer, image, options, budget_ms)
            with Call() as call:
                call("image_colour_components", c.byref(image), colours, transfer, c.byref(options))
        if own:
            image.depth = None
        return int(options.level)


def _make_colours(arrays: list[int], window: Window) -> tuple[Any, Handle]:
    """The store of the shape of these arrays, and their colours."""
    from ._store import Store

    grid = _abi.functions["array_grid"](arrays[0]).contents
    ends = _abi.Double2(*(window or (0, 0)))
    if window is None:
        _abi.functions["component_get_range"](ends, grid.type)
    rgb = (c.c_double * 12)(1, 0, 0, 0, 1, 0, 0, 0, 1)
    pointers = (c.c_void_p * len(arrays))(*arrays)
    source = _abi.ColourSource(arrays=c.addressof(pointers), rgb=c.addressof(rgb), count=len(arrays),
                               has_alpha=len(arrays) == 4, range=ends)  # fmt: skip
    made, array, volume = out_pointer(), out_pointer(), out_pointer()
    with Call() as call:
        call("colours_create", c.byref(made), c.byref(array), c.byref(volume), c.byref(source))
        colours = Handle(made.value or 0, "colours_free", "the colours")
        return Store(Handle(array.value or 0, "array_free", "the shape")), colours


class Colours:
    """Samples of red, green and blue, or of red, green, blue and alpha: an array (z, y, x, component).

    volumes: the `Volume` of each component. ValueError: they are not 3 or 4, or differ in shape, type or position.
    `open_colours` opens those of a file.
    """

    def __init__(self, volumes: Sequence[Volume]) -> None:
        self.volumes = tuple(volumes)
        if len(self.volumes) not in (3, 4):
            raise ValueError(f"{len(self.volumes)} components are given, must be 3 or 4: red, green, blue, alpha")
        Series(self.volumes)  # compares them
        self._renderer: Optional[tuple[Window, _ColourRenderer]] = None

    @property
    def shape(self) -> tuple[int, ...]:
        """Samples along each axis, and components: (z, y, x, component)."""
        return (*self.volumes[0].shape, len(self.volumes))

    @property
    def ndim(self) -> int:
        """4."""
        return len(self.shape)

    @property
    def dtype(self) -> np.dtype[Any]:
        """Sample type."""
        return self.volumes[0].dtype

    @property
    def geometry(self) -> Geometry:
        """Spacing, origin, directions and unit."""
        return self.volumes[0].geometry

    def __repr__(self) -> str:
        return f"<cvol.Colours {' x '.join(map(str, self.shape))} {self.dtype}>"

    def to_numpy(self) -> NDArray[Any]:
        """All samples, (z, y, x, component)."""
        return np.stack([volume.to_numpy() for volume in self.volumes], axis=-1)

    def __array__(self, dtype: Any = None, copy: Optional[bool] = None) -> NDArray[Any]:
        if copy is False:
            raise ValueError("volumes of colours always return a copy of their samples")
        samples = self.to_numpy()
        return samples if dtype is None else samples.astype(dtype, copy=False)

    def render(
        self, azimuth: Optional[float] = None, elevation: Optional[float] = None, **look: Any
    ) -> NDArray[Any]:
        """Draws a picture in the colours of the samples, as `cvol render` does: uint8, (height, width, 3), or
        (..., 4) with background="transparent".

        An opaque object hides what is behind it in all components. Options: those of `Renderer.render` for engine sheet
        and mode composite, without transfer and rescale. window: the values of black and of full colour; otherwise
        those of the sample type, or 0 to 1 of floats. Data that pictures share stay in memory until `close`.
        """
        for name, usual in (("engine", "sheet"), ("mode", "composite"), ("transfer", "auto"), ("rescale", None)):
            given = look.pop(name, usual)
            if given is not None and (not isinstance(given, str) or given != usual):
                raise ArgumentError(f"{name}: volumes of colours are drawn without it; draw one of .volumes with it")
        if look.get("iso") is not None:
            raise ArgumentError("iso: volumes of colours are drawn without it; draw one of .volumes with it")
        window = _look.pair(look.pop("window", None), "window")
        if self._renderer is None or self._renderer[0] != window:
            self._drop_renderer()
            self._renderer = (window, _ColourRenderer(self.volumes, window))
        return self._renderer[1].render(azimuth, elevation, **look)

    def save(self, path: Union[str, "os.PathLike[str]"]) -> int:
        """Writes a .cvol file of colours. Returns its bytes."""
        return save_series(path, self.volumes, channels=len(self.volumes), colours=True)

    def _repr_png_(self) -> bytes:
        return encode_png(self.render(size=384))

    def _drop_renderer(self) -> None:
        if self._renderer is not None:
            self._renderer[1].close()
            self._renderer = None

    def close(self) -> None:
        """Closes the volumes."""
        self._drop_renderer()
        for volume in self.volumes:
            volume.close()

    def __enter__(self) -> "Colours":
        return self

    def __exit__(self, *_: object) -> None:
        self.close()


def open_colours(
    path: Union[str, "os.PathLike[str]"],
    *,
    time: int = 0,
    compress: Union[Literal[True], Mapping[str, object]] = True,
) -> Colours:
    """Opens the components of a file of colours: a .cvol file (`Contents.colours`), or RGB or RGBA samples of another
    format that `read` reads (TIFF, NIfTI, NRRD, ...).

    time: of a series, from 0. compress: for other formats; see `open`. ArgumentError: the file has no colours.
    """
    name = os.fspath(path)
    if _abi.functions["file_is_cvol"](path_bytes(name)):
        listed = contents(path)
        channels, is_colour = listed.channels, listed.colours
    else:
        channels, is_colour = count_volumes(name)[1], has_colours(name)
    if not is_colour:
        raise ArgumentError(f"{name}: has no colours: open its volumes, cvol.open(path, channel=0)")
    return Colours([open_volume(path, time=time, channel=channel, compress=compress) for channel in range(channels)])
