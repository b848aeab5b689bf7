"""From the options of Renderer.render to cvol_render_options."""

from __future__ import annotations

import ctypes as c
import math
import operator
from typing import Any, Optional

import numpy as np

from . import _abi

_MODES = {"composite": 1, "xray": 2, "mean": 2, "mip": 3, "min": 4, "iso": 5}
_FOOTPRINTS = {"gaussian": 1, "cone": 2, "sinc": 3, "box": 4}
_SHEET_FOOTPRINTS = {"linear": 0, "catmull-rom": 1, "b-spline": 2, "gaussian": 3}
_COLOURS = {"black": (0.0, 0.0, 0.0), "white": (1.0, 1.0, 1.0), "transparent": (0.0, 0.0, 0.0)}


def _one_of(value: Any, choices: dict[str, int], name: str) -> int:
    if value not in choices:
        raise ValueError(f"{name} is {value!r}, must be one of {', '.join(choices)}")
    return int(choices[value])


def numbers(value: Any, count: int, name: str) -> tuple[float, ...]:
    try:
        out = tuple(float(v) for v in value)
    except (TypeError, ValueError):
        raise TypeError(f"{name} is {value!r}, must be {count} finite numbers") from None
    if len(out) != count or not all(math.isfinite(v) for v in out):
        raise ValueError(f"{name} is {value!r}, must be {count} finite numbers")
    return out


def pair(value: Any, name: str) -> Optional[tuple[float, float]]:
    """A copy, which compares by its numbers and does not change with `value`."""
    if value is None:
        return None
    first, second = numbers(value, 2, name)
    return first, second


def colour(value: Any, name: str) -> tuple[float, ...]:
    if isinstance(value, str):
        if value not in _COLOURS:
            raise ValueError(f"{name} is {value!r}, must be R, G, B in 0 to 1, or {', '.join(_COLOURS)}")
        return _COLOURS[value]
    out = numbers(value, 3, name)
    if not all(0 <= v <= 1 for v in out):
        raise ValueError(f"{name} is {value!r}, each must be 0 to 1")
    return out


def picture_size(size: Any) -> tuple[int, int]:
    """(width, height)."""
    try:
        sides = (size, size) if np.ndim(size) == 0 else tuple(size)
        width, height = (operator.index(v) for v in sides)
    except (TypeError, ValueError):
        raise ValueError(f"size is {size!r}, must be pixels, or (width, height)") from None
    return width, height


def _clip(options: Any, clip: Any, planes: Any, shape: tuple[int, ...]) -> None:
    """clip: a slice for each axis of the array (z, y, x)."""
    box = options.clip
    if clip is not None:
        parts = clip if isinstance(clip, tuple) else (clip,)
        parts = tuple(parts) + (slice(None),) * (3 - len(parts))
        if len(parts) > 3 or not all(isinstance(p, slice) and p.step in (None, 1) for p in parts):
            raise ValueError("clip must be slices without steps, one for each axis, as numpy.s_[10:90, :, 20:]")
        for axis, part in enumerate(parts):
            if part.start is None and part.stop is None:
                continue
            low, high, _ = part.indices(shape[axis])
            if low >= high:
                raise ValueError(f"clip is empty along axis {axis}")
            getattr(box, "from")[2 - axis], box.to[2 - axis] = low, high - 1
            box.axes |= 1 << (2 - axis)
    planes = [] if planes is None else list(planes)
    if len(planes) > 6:
        raise ValueError(f"clip_planes has {len(planes)} planes, must have at most 6")
    for k, plane in enumerate(planes):
        box.plane[k][:] = numbers(plane, 4, f"clip_planes[{k}]")
    box.planes = len(planes)


def _camera(options: Any, look: dict[str, Any], azimuth: Optional[float], elevation: Optional[float]) -> None:
    camera = options.camera
    camera.azimuth_deg, camera.elevation_deg = azimuth or 0, elevation or 0
    camera.roll_deg, camera.zoom = look["roll"], look["zoom"]
    camera.fov_deg = look["perspective"] or 0
    camera.look_at[:] = numbers(look["look_at"] or (0, 0, 0), 3, "look_at")
    if look["eye"] is not None:
        if not look["perspective"]:
            raise ValueError("eye needs perspective=DEGREES")
        camera.placed = 1
        camera.eye[:] = numbers(look["eye"], 3, "eye")
        camera.up[:] = numbers(look["up"], 3, "up")


LIGHT_OPTIONS = ("ambient", "diffuse", "specular", "shininess", "gradient_opacity", "fill_light", "occlusion", "shadows",
                 "samples")  # fmt: skip
_LIGHTS = ("studio", "cinematic", "headlight", "flat")


def _light(look: dict[str, Any], engine: str, mode: int) -> Any:
    """The light: a name, or a direction; without one, studio light where the engine has it."""
    light = look["light"]
    if isinstance(light, str) and light not in _LIGHTS:
        raise ValueError(f"light is {light!r}, must be {', '.join(_LIGHTS)}, or (X, Y, Z)")
    if light is not None:
        return light
    if look["shade"]:
        return "headlight"
    if engine in ("sheet", "ray") and mode in (1, 5):
        return "studio"
    return "headlight" if mode == 5 else "flat"


def _shading(options: Any, look: dict[str, Any], engine: str) -> None:
    shading, illumination = options.shading, options.illumination
    light = _light(look, engine, options.mode)
    if isinstance(light, str) and light == "studio":
        _abi.functions["render_options_set_studio"](c.byref(options))
    if isinstance(light, str) and light == "cinematic":
        _abi.functions["render_options_set_cinematic"](c.byref(options), 0)
    shading.on = int(options.mode == 1 and not (isinstance(light, str) and light == "flat"))
    if not isinstance(light, str):
        shading.light[:] = numbers(light, 3, "light")
    for name in ("ambient", "diffuse", "specular", "shininess", "gradient_opacity"):
        if look[name] is not None:
            setattr(shading, name, look[name])
    for name, field in (("fill_light", "fill"), ("occlusion", "occlusion"), ("shadows", "shadows"),
                        ("samples", "samples")):
        if look[name] is not None:
            setattr(illumination, field, look[name])


def make_options(
    azimuth: Optional[float], elevation: Optional[float], look: dict[str, Any], engine: str, shape: tuple[int, ...]
) -> Any:
    """cvol_render_options; `look` has every option (Renderer.render)."""
    options = _abi.defaults("render_options")
    options.width, options.height = picture_size(look["size"])
    mode = look["mode"] or ("iso" if look["iso"] is not None else "xray" if engine == "fourier" else "composite")
    options.mode = _one_of(mode, _MODES, "mode")
    if options.mode == 5:
        if look["iso"] is None:
            raise ValueError("mode iso needs iso=VALUE")
        options.surface.value = float(look["iso"])
    options.surface.colour[:] = colour(look["iso_colour"], "iso_colour")
    _camera(options, look, azimuth, elevation)
    _shading(options, look, engine)
    _clip(options, look["clip"], look["clip_planes"], shape)
    options.level = look["level"]
    options.step_voxels = look["step"]
    options.background[:] = colour(look["background"], "background")
    if look["window"] is not None and options.mode in (2, 3, 4):
        options.window[:] = numbers(look["window"], 2, "window")
    if look["footprint"] is not None and engine == "sheet":
        options.sheet.footprint = _one_of(look["footprint"], _SHEET_FOOTPRINTS, "footprint")
    elif look["footprint"] is not None:
        options.splat.footprint = _one_of(look["footprint"], _FOOTPRINTS, "footprint")
    options.splat.size = look["footprint_size"]
    options.sheet.ray_order = _one_of(look["ray_order"], {"auto": 0, "image": 1, "object": 2}, "ray_order")
    options.keep_mb = float(look["keep_mb"])
    options.fourier.depth_cue = look["depth_cue"]
    return options
