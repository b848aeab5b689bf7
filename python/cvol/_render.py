"""Renderers: pictures of a volume, with data that pictures share."""

from __future__ import annotations

import ctypes as c
import inspect
import threading
from typing import Any, Optional, Union

import numpy as np
from numpy.typing import NDArray

from . import _abi, _look, _transfer
from ._call import Call, Handle, out_pointer
from ._store import info_of
from ._volume import Volume

_ENGINES = ("sheet", "ray", "splat", "transform", "fourier")  # from 1, as cvol_engine counts
_GREY = (2, 3, 4)


class Renderer:
    """Draws pictures of one volume, and keeps data that they share: bounds of blocks, transfer function, samples of
    engine ray. Pictures have the same bits for any number of threads.

    engine: "sheet", from the compressed form; "ray", from all samples, the reference; "splat", "transform", or
        "fourier" (X-rays only).
    rho: share of coefficients to keep, for engines transform and fourier.

    Several threads may use it; it draws one picture at a time. It works even after its volume is closed.
    """

    colours_pixels = False  # _draw gives the pixels their colours: they are floats, and the picture has no colour bar

    def __init__(self, volume: Volume, engine: str = "sheet", rho: Optional[float] = None) -> None:
        if engine not in _ENGINES:
            raise ValueError(f"engine is {engine!r}, must be one of {', '.join(_ENGINES)}")
        if volume.ndim != 3:
            raise ValueError(f"the volume has {volume.ndim} axes: pictures need 3")
        self.key = (engine, rho)
        self.engine, self._rho = engine, rho
        self._shape = volume.shape
        self._lock = threading.RLock()
        self._volume = volume._store.whole()
        self._samples: Optional[NDArray[Any]] = None  # for engine ray
        self._mask: Optional[NDArray[Any]] = None
        self._transfer: Optional[Handle] = None
        self._transfer_key: Any = None
        # The renderer of the library uses the array: hold it until the renderer is freed.
        self._array = self._volume.acquire()
        try:
            self._handle = self._create(volume, self._array)
        except BaseException:
            self._volume.release()
            raise

    def _create(self, volume: Volume, array: int) -> Handle:
        out = out_pointer()
        if self.engine == "ray":
            self._hold_samples(volume, array)
        with Call() as call:
            source = _abi.Source(rho=self._rho or 0)
            if self.engine == "ray":
                source.volume = c.addressof(self._dense)
                source.mask = None if self._mask is None else self._mask.ctypes.data
            else:
                source.array = array
            call("renderer_create", c.byref(out), 1 + _ENGINES.index(self.engine), c.byref(source))
            return Handle(out.value or 0, "renderer_free", "the renderer")

    def _hold_samples(self, volume: Volume, array: int) -> None:
        """Decodes all samples, aligned to 64 bytes, and the mask of samples without a value."""
        grid = volume._store.grid
        memory = np.empty(volume.nbytes + 64, np.uint8)
        start = -memory.ctypes.data % 64
        self._samples = memory[start : start + volume.nbytes]
        self._dense = _abi.Volume(grid=grid, data=self._samples.ctypes.data)
        begin, end = _abi.Size3(0, 0, 0), _abi.Size3(*grid.dims)
        with Call() as call:
            call("array_evaluate_box", self._samples.ctypes.data, array, begin, end)
        mask = np.empty(volume.size, np.uint8)
        if _abi.functions["array_evaluate_mask"](mask.ctypes.data, array, begin, end):
            self._mask = mask

    # ---- transfer functions -------------------------------------------------------------------------

    def _set_transfer(self, renderer: int, transfer: Any, window: Any, opacity_scale: float, rescale: Any) -> None:
        window, rescale = _look.pair(window, "window"), _look.pair(rescale, "rescale")
        kept: Any = transfer
        if _transfer.is_file(transfer):
            kept = None  # a file may have changed
        elif not isinstance(transfer, str):
            transfer = np.array(transfer, float)
            kept = (transfer.shape, transfer.tobytes())
        key = None if kept is None else (kept, window, float(opacity_scale), rescale)
        if key is not None and key == self._transfer_key:
            return
        made = _transfer.make(self._array, transfer, window, opacity_scale, rescale)
        with made as pointer, Call() as call:
            self._transfer_key = None  # a call that fails may have changed the renderer
            call("renderer_set_transfer", renderer, pointer)
            self._transfer, self._transfer_key = made, key

    def transfer_points(
        self,
        transfer: Any = "auto",
        *,
        window: Optional[tuple[float, float]] = None,
        opacity_scale: float = 1,
        rescale: Optional[tuple[float, float]] = None,
    ) -> NDArray[Any]:
        """The points of a transfer function for this volume: (n, 5), rows of value, red, green, blue and opacity.
        Change them and give them back as ``transfer``."""
        window, rescale = _look.pair(window, "window"), _look.pair(rescale, "rescale")
        with self._lock, self._handle:
            return _transfer.points_of(_transfer.make(self._array, transfer, window, opacity_scale, rescale))

    # ---- pictures -------------------------------------------------------------------------------------

    def render(
        self,
        azimuth: Optional[float] = None,
        elevation: Optional[float] = None,
        *,
        view: Optional[str] = None,
        roll: float = 0,
        zoom: float = 1,
        fit: Optional[str] = None,
        size: Union[int, tuple[int, int]] = 512,
        mode: Optional[str] = None,
        transfer: Any = "auto",
        window: Optional[tuple[float, float]] = None,
        opacity_scale: float = 1,
        rescale: Optional[tuple[float, float]] = None,
        background: Any = "black",
        shade: bool = False,
        light: Any = None,
        ambient: Optional[float] = None,
        diffuse: Optional[float] = None,
        specular: Optional[float] = None,
        shininess: Optional[int] = None,
        gradient_opacity: Optional[float] = None,
        fill_light: Optional[float] = None,
        occlusion: Optional[float] = None,
        shadows: Optional[float] = None,
        samples: Optional[int] = None,
        iso: Optional[float] = None,
        iso_colour: Any = (0.9, 0.85, 0.75),
        perspective: Optional[float] = None,
        eye: Optional[tuple[float, float, float]] = None,
        look_at: Optional[tuple[float, float, float]] = None,
        up: tuple[float, float, float] = (0, 0, 0),
        clip: Any = None,
        clip_planes: Any = None,
        level: int = 0,
        budget_ms: Optional[float] = None,
        annotate: bool = False,
        step: float = 0,
        footprint: Optional[str] = None,
        footprint_size: int = 5,
        ray_order: str = "auto",
        keep_mb: float = 0,
        depth_cue: float = 0,
    ) -> NDArray[Any]:
        """Draws a picture: uint8, (height, width, 3), top row first; (..., 4) with background="transparent".

        azimuth, elevation, roll: degrees. The eye is in direction (cos e sin a, -cos e cos a, sin e) of the
            centre of the volume, in world X, Y, Z; +Z is up. Without angles and view: a three-quarter view, of the
            patient if the file has an orientation; slabs are seen across their thin axis.
        view: "front", "back", "left", "right", "top" or "bottom", of the patient if the file has an orientation;
            azimuth then turns it.
        fit: what fills the picture at zoom 1: "object" (default without look_at and eye): what is visible; "turn": the
            same, from all azimuths, as films need it; "box": the picture is as high as the diagonal of the volume.
        zoom: magnification. size: pixels, or (width, height).
        mode: "composite" (default), "xray", "mip", "min", or "iso" (default with iso=): the lit surface of value
            iso, in iso_colour.
        transfer: a name (`transfer_names`), a JSON file of the values that samples mean (`value_scale` and
            `value_offset` of the geometry), or points of samples (n, 5): sample, red, green, blue, opacity.
        window: (lower, upper) values of the full range of colours, or greys. opacity_scale: factor of the
            density. rescale: a sample s means rescale[0] s + rescale[1] Hounsfield units (transfer "ct-...").
        background: "black", "white", "transparent" or (R, G, B) in 0 to 1.
        light: "studio" (default of engines sheet and ray): a key light from the upper left with soft shadows, a fill
            light and ambient occlusion, as bright as without light (none where only faces are visible); "cinematic": a
            sky and a soft key light, scattered once in translucent matter; "headlight": from the eye (also shade=True);
            "flat": none; or (X, Y, Z), the direction of a single light.
        ambient, diffuse, specular, shininess, gradient_opacity: Phong's model. fill_light: a second light, from the
            eye. occlusion, shadows: their strength, 0 to 1. samples: the number of directions of scattered light
            ("cinematic": 64). (The last four: engines sheet and ray.)
        look_at: centre of the picture, in world lengths from the centre of the volume. perspective: vertical field of
            view in degrees; eye, up: position of the eye, like look_at, and its up direction.
        clip: the part to draw, as slices (z, y, x). clip_planes: at most 6 of (X, Y, Z, D): draw only points at least
            D from the centre in direction (X, Y, Z).
        level: 1, 2, 3: every 2nd, 4th, 8th sample, for fast pictures. budget_ms: draw the finest level that takes at
            most this time. (Engine sheet.)
        annotate: draw a scale bar, axes, and a bar of colours or greys.
        step: distance of samples along rays, in samples. footprint: engine sheet: "linear" (default),
            "catmull-rom", "b-spline" or "gaussian"; engines splat and transform: "gaussian" (default), "sinc", "box"
            or, splat only, "cone". footprint_size: width of the footprint of these two.
        ray_order: engine sheet: "image" order, "object" order (faster and softer), or "auto": object order where
            the difference is hardly visible.
        keep_mb: engine sheet: block cache size in MB; 0: off. Changes speed, never pixels.
        depth_cue: engine fourier: darkening of the far end, 0 to 1.
        """
        look = {name: value for name, value in locals().items() if name not in ("self", "azimuth", "elevation")}
        return self._picture(azimuth, elevation, look, None)

    def depth(
        self, azimuth: Optional[float] = None, elevation: Optional[float] = None, **look: Any
    ) -> NDArray[Any]:
        """The depth of each pixel: float32, (height, width), with the options of `render`.

        It is the distance along the viewing direction, in world length, to the place where the opacity of the ray
        reaches one half, or to the surface (iso); infinity if there is none. In parallel projection it is from the
        plane that touches the sphere around the volume's box, else from the eye. Engines sheet and ray.
        """
        given = self._complete(look)
        width, height = _look.picture_size(given["size"])
        out = np.full((max(height, 0), max(width, 0)), np.inf, np.float32)
        self._picture(azimuth, elevation, {**given, "annotate": False}, out)
        return out

    def certify(
        self, azimuth: Optional[float] = None, elevation: Optional[float] = None, **look: Any
    ) -> tuple[NDArray[Any], NDArray[Any]]:
        """Bounds (lower, upper) of the picture of the original samples: two of uint8, (height, width, 3), with the
        options of `render`, but flat light and fit="box" if none is given. Engine ray, all modes but iso.

        The picture that engine ray makes of the samples that the file was compressed from, with the same options and
        the same transfer function, lies between them in every pixel and channel. This is proved from the largest error
        of the file (cvol_renderer_certify).
        """
        given = self._complete({"light": None if look.get("shade") else "flat", "fit": "box", **look})
        if given["fit"] != "box":
            raise ValueError("certify() needs fit='box': another frame depends on the samples")
        with self._lock, self._handle as renderer:
            options = _look.make_options(azimuth, elevation, given, self.engine, self._shape)
            if given["annotate"] or str(given["background"]) == "transparent" or given["budget_ms"] is not None:
                raise ValueError("certify() draws without annotate, budget_ms and background='transparent'")
            info = info_of(self._array)
            if not info.brick[0]:
                raise ValueError("certify() needs a volume in DCT blocks")
            if options.mode == 1:
                self._set_transfer(renderer, *(given[k] for k in ("transfer", "window", "opacity_scale", "rescale")))
            mirrored = self._aim(options, given, azimuth, elevation)
            pixels = [np.zeros((max(options.height, 0), max(options.width, 0), 4), np.uint8) for _ in range(2)]
            images = [_abi.Image(width=options.width, height=options.height, rgba=p.ctypes.data) for p in pixels]
            with Call() as call:
                call("renderer_certify", renderer, c.byref(images[0]), c.byref(images[1]), c.byref(options),
                     info.max_error, _abi.Double2(info.value_min, info.value_max))  # fmt: skip
            for image in images:
                if mirrored:
                    _abi.functions["image_mirror"](c.byref(image))
            lower, upper = (np.ascontiguousarray(p[..., :3]) for p in pixels)
            return lower, upper

    @staticmethod
    def _complete(look: dict[str, Any]) -> dict[str, Any]:
        """These options of `render`, and the defaults of the others."""
        known = inspect.signature(Renderer.render).parameters
        wrong = set(look) - {name for name, p in known.items() if p.kind is p.KEYWORD_ONLY}
        if wrong:
            raise TypeError(f"render() has no option {', '.join(sorted(wrong))}")
        return {name: look.get(name, p.default) for name, p in known.items() if p.kind is p.KEYWORD_ONLY}

    def _picture(
        self,
        azimuth: Optional[float],
        elevation: Optional[float],
        look: dict[str, Any],
        depth: Optional[NDArray[Any]],
    ) -> NDArray[Any]:
        with self._lock, self._handle as renderer:
            options = _look.make_options(azimuth, elevation, look, self.engine, self._shape)
            if self.engine == "transform" and self._rho is not None:
                options.transform.rho = self._rho
            if options.mode == 1:
                self._set_transfer(renderer, look["transfer"], look["window"], look["opacity_scale"], look["rescale"])
                self._drop_default_light(options, look)
            mirrored = self._aim(options, look, azimuth, elevation)
            transparent = isinstance(look["background"], str) and look["background"] == "transparent"
            as_floats = transparent or look["annotate"] or self.colours_pixels
            height, width = options.height, options.width
            pixels = np.zeros((max(height, 0), max(width, 0), 4), np.float32 if as_floats else np.uint8)
            image = _abi.Image(width=width, height=height, depth=None if depth is None else depth.ctypes.data)
            setattr(image, "values" if as_floats else "rgba", pixels.ctypes.data)
            self._draw(renderer, image, options, look["budget_ms"])
            if mirrored:
                _abi.functions["image_mirror"](c.byref(image))
            if look["annotate"]:
                self._annotate(renderer, image, options, mirrored, transparent)
            if as_floats:
                pixels = self._flatten(image, options, transparent)
            return pixels if transparent else np.ascontiguousarray(pixels[..., :3])

    def _drop_default_light(self, options: Any, look: dict[str, Any]) -> None:
        """No light where only faces are visible, unless the options ask for one."""
        if look["light"] is not None or look["shade"] or any(look[name] is not None for name in _look.LIGHT_OPTIONS):
            return
        assert self._transfer is not None
        with self._transfer as pointer:
            if _abi.functions["transfer_is_opaque"](pointer):
                options.shading.on = 0
                options.illumination = type(options.illumination)()

    def _aim(
        self, options: Any, look: dict[str, Any], azimuth: Optional[float], elevation: Optional[float]
    ) -> bool:
        """Sets the angles and the frame; True: the picture must be mirrored."""
        camera, mirrored, roll = options.camera, c.c_int(), look["roll"]
        grid = _abi.functions["array_grid"](self._array)
        is_default = look["view"] is None and azimuth is None and elevation is None and look["eye"] is None
        if look["view"] is not None:
            with Call() as call:
                call("camera_set_view", c.byref(camera), c.byref(mirrored), look["view"].encode(), grid, azimuth or 0)
        elif is_default:
            _abi.functions["camera_set_default"](c.byref(camera), c.byref(mirrored), grid, 0)
        if look["view"] is not None or is_default:
            camera.roll_deg += -roll if mirrored else roll
        if options.illumination.in_view:
            options.illumination.in_view = -1 if mirrored else 1
        self._fit(options, look)
        return bool(mirrored)

    def _fit(self, options: Any, look: dict[str, Any]) -> None:
        fit = look["fit"] or ("object" if look["look_at"] is None and look["eye"] is None else "box")
        if fit not in ("object", "turn", "box"):
            raise ValueError(f"fit is {fit!r}, must be object, turn or box")
        if fit == "box":
            return
        if look["eye"] is not None:
            raise ValueError(f"fit={fit!r} cannot be combined with eye")
        zoom = options.camera.zoom
        source = _abi.Source(array=self._array)
        turns = 12 if fit == "turn" else 1
        with Call() as call:
            if options.mode == 1 and self._transfer is not None:
                with self._transfer as transfer:
                    call("camera_fit", c.byref(options), c.byref(source), transfer, turns)
            else:
                call("camera_fit", c.byref(options), c.byref(source), None, turns)
        options.camera.zoom *= zoom

    def _draw(self, renderer: int, image: Any, options: Any, budget_ms: Optional[float]) -> int:
        """Returns the level of the picture."""
        report = _abi.RefineReport(level=options.level)
        with Call() as call:
            if budget_ms is None:
                call("renderer_render", renderer, c.byref(image), c.byref(options))
            else:
                call("renderer_refine", renderer, c.byref(image), c.byref(options), budget_ms,
                     c.cast(0, _abi.PictureFunction), None, c.byref(report))  # fmt: skip
        return int(report.level)

    def _annotate(self, renderer: int, image: Any, options: Any, mirrored: bool, transparent: bool) -> None:
        note = _abi.Annotation(
            grid=c.addressof(_abi.functions["array_grid"](self._array).contents), options=c.addressof(options), mirrored=mirrored,
            transparent=transparent, rescale=_abi.Double2(1, 0), value_unit=b"")  # fmt: skip
        with Call() as call:
            if options.mode in _GREY:
                note.range[:] = options.window[:]
                if not note.range[0] < note.range[1]:
                    call("renderer_get_range", note.range, renderer)
            if options.mode == 1 and self._transfer is not None and not self.colours_pixels:
                with self._transfer as transfer:
                    note.transfer = transfer
                    call("image_annotate", c.byref(image), c.byref(note))
            else:
                call("image_annotate", c.byref(image), c.byref(note))

    def _flatten(self, image: Any, options: Any, transparent: bool) -> NDArray[Any]:
        out = np.empty((options.height, options.width, 4), np.uint8)
        flat = _abi.Image(width=options.width, height=options.height, rgba=out.ctypes.data)
        with Call() as call:
            call("image_flatten", c.byref(flat), c.byref(image), None if transparent else options.background)
        return out

    def close(self) -> None:
        """Frees the memory; further pictures raise ValueError."""
        with self._lock:
            if not self._handle.closed:
                self._handle.close()
                self._volume.release()
                self._samples = self._mask = None

    def __enter__(self) -> "Renderer":
        return self

    def __exit__(self, *_: Any) -> None:
        self.close()

    def __del__(self) -> None:
        if hasattr(self, "_handle"):
            self.close()
