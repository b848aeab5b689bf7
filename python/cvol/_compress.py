"""Compression and transcoding."""

from __future__ import annotations

import ctypes as c
import math
import os
import warnings
from collections.abc import Sequence
from typing import Any, Optional, Union

import numpy as np
from numpy.typing import ArrayLike, NDArray

from . import _abi
from ._call import Call, Progress, TargetError, options, out_pointer, path_bytes
from ._frames import Series
from ._geometry import Geometry, address, make_grid, samples_of
from ._keep import Keep
from ._volume import Volume, attributes_text

_RATIO, _PSNR, _MAX_ERROR, _BITS = 1, 2, 3, 4
EFFORTS = {"default": 0, "fast": 1, "max": 2}
_LEAST_PSNR, PSNR_INSTEAD = 25, 35  # where a ratio leaves less than the first, the default becomes the second


def _named(ratio: Any, psnr: Any, max_error: Any, bits: Any, lossless: bool, keep: Any) -> list[str]:
    """The targets that were given."""
    return [name for name, value in (
        ("ratio", ratio), ("psnr", psnr), ("max_error", max_error), ("bits", bits), ("keep", keep),
        ("lossless", lossless or None)) if value is not None]  # fmt: skip


def _number(value: Any, name: str) -> float:
    try:
        return float(value)
    except (TypeError, ValueError):
        raise TypeError(f"{name} is {value!r}, must be a number") from None


def _target(ratio: Any, psnr: Any, max_error: Any, bits: Any, lossless: bool, keep: Any) -> tuple[int, float]:
    given = _named(ratio, psnr, max_error, bits, lossless, keep)
    if len(given) > 1 and given != ["psnr", "max_error"]:
        raise ValueError(f"give only one of {' and '.join(given)} (only psnr and max_error can be combined)")
    if psnr is not None:
        return _PSNR, _number(psnr, "psnr")
    if max_error is not None:
        return _MAX_ERROR, _number(max_error, "max_error")
    if bits is not None:
        return _BITS, _number(bits, "bits")
    return _RATIO, 30.0 if ratio is None else _number(ratio, "ratio")


def is_labels(array: ArrayLike, path: Optional[Union[str, "os.PathLike[str]"]] = None) -> bool:
    """Returns whether samples are labels: numbers that name regions, so that the mean of two labels has no meaning.

    array: three axes of bool, which are labels, or of integers; of any other array the answer is False.
    path: the file of the samples. The result is True if the file says so: NIfTI's intent code 1002, or a name that
        ends in .seg.nrrd. Otherwise the samples decide: at most 4,096 values that are constant over regions and
        jump between them.
    """
    samples = samples_of(array)
    if samples.ndim != 3 or not samples.size:
        return False
    if np.asanyarray(array).dtype == np.bool_:
        return True
    volume = _abi.Volume(make_grid(samples.shape, samples.dtype), address(samples))
    name = None if path is None else path_bytes(path)
    out = c.c_int()
    with Call() as call:
        call("volume_compute_is_labels", c.byref(out), c.byref(volume), name)
    return bool(out.value)


def _keep_labels(labels: Any, array: Any, named: list[str], of_blocks: bool) -> bool:
    """Returns whether `labels` makes the result lossless. named: the given targets; of_blocks: lossless is
    possible."""
    if labels is not None and not isinstance(labels, (bool, np.bool_)):
        raise TypeError(f"labels is {labels!r}, must be True, False or None")
    if labels is None:
        return of_blocks and not named and is_labels(array)
    if labels and named not in ([], ["lossless"]):
        raise ValueError(f"labels=True is lossless: leave out {' and '.join(named)}")
    if labels and not of_blocks:
        raise ValueError("labels=True is lossless, which needs three axes in DCT blocks")
    return bool(labels)


def _mark(samples: NDArray[Any], grid: Any) -> Optional[float]:
    """The value that marks missing samples: one far from all others, such as 1e35. None: there is none."""
    histogram = _abi.Histogram()
    with Call() as call:
        call("volume_compute_histogram", c.byref(histogram), c.byref(_abi.Volume(grid, address(samples))))
    return float(histogram.mark) if histogram.mark_count and not is_labels(samples) else None


def missing_value(samples: NDArray[Any]) -> Optional[float]:
    """The value to give `compress` as `fill`: the mark of missing samples; else NaN, if samples are NaN or infinite;
    else None."""
    if samples.ndim != 3 or not samples.size or samples.dtype.kind not in "iuf":
        return None
    stored = samples_of(samples)
    if (mark := _mark(stored, make_grid(stored.shape, stored.dtype))) is not None:
        return mark
    return math.nan if stored.dtype.kind == "f" and not np.isfinite(stored).all() else None


def _sides(bricks: Any) -> tuple[int, int, int]:
    """Sides of bricks along x, y, z; 0: the default."""
    if bricks is None:
        return 0, 0, 0
    sides = tuple(bricks) if hasattr(bricks, "__len__") else (bricks,) * 3
    if len(sides) != 3 or not all(side in (16, 32, 48, 64) for side in sides):
        raise ValueError(f"bricks are {bricks!r}, must be 16, 32, 48 or 64, or three of these")
    return int(sides[2]), int(sides[1]), int(sides[0])


def _by_codec(samples: NDArray[Any], grid: Any, o: Any) -> tuple[Volume, Any]:
    """The volume and a cvol_compress_report."""
    out, report = out_pointer(), _abi.CompressReport()
    with Call() as call:
        call("compress", c.byref(out), c.byref(report), address(samples), c.byref(grid), c.byref(o))
        return Volume._take(out), report


def _report_miss(o: Any, report: Any, nbytes: int, size: int) -> None:
    """Warns that a target by size was missed, as cvol compress prints it. nbytes, size: of the samples."""
    if report.target_met or o.lossless or o.target not in (_RATIO, _BITS):
        return
    ratio, bits = nbytes / report.file_bytes, 8 * report.file_bytes / size
    by_ratio = o.target == _RATIO
    finer = ratio >= o.target_value if by_ratio else bits <= o.target_value
    why = ("the volume is lossless, and lossy ones are not smaller" if report.lossless and not finer
           else "the finest lossy volume is smaller" if finer else "this is the smallest possible volume")  # fmt: skip
    asked = f"ratio {o.target_value:g}" if by_ratio else f"{o.target_value:g} bits a sample"
    warnings.warn(f"{asked} is out of reach: {why}, 1/{ratio:.4g} of the raw samples, {bits:.3g} bits each",
                  stacklevel=3)  # fmt: skip


def _yielding(ratio: float, says: str) -> None:
    """Warns that a PSNR replaces the default ratio."""
    warnings.warn(f"{says}; compressed to {PSNR_INSTEAD} dB instead (ratio={ratio:g}, force=True: keep to the ratio)",
                  stacklevel=3)  # fmt: skip


def _refusal(says: str) -> TargetError:
    return TargetError(f"{says}; give psnr={PSNR_INSTEAD} for more quality, or force=True to accept this")


def _by_truncation(samples: NDArray[Any], grid: Any, transform: int, block: int, keep: Any) -> Volume:
    out = out_pointer()
    with Call() as call:
        call("array_compress", c.byref(out), address(samples), c.byref(grid), samples.ndim, transform, block,
             c.byref(keep))  # fmt: skip
        volume = Volume._take(out)
        with volume._store.whole() as array:
            call("array_measure", array, address(samples))
        volume._store.refresh()
        return volume


def compress(
    array: ArrayLike,
    ratio: Optional[float] = None,
    *,
    psnr: Optional[float] = None,
    max_error: Optional[float] = None,
    bits: Optional[float] = None,
    lossless: bool = False,
    labels: Optional[bool] = None,
    keep: Optional[Keep] = None,
    spacing: Union[float, Sequence[float], None] = None,
    geometry: Optional[Geometry] = None,
    transform: str = "dct",
    block: int = 16,
    fill: Optional[float] = None,
    background: Union[str, float, None] = "auto",
    lap: bool = True,
    effort: str = "default",
    bricks: Union[int, tuple[int, int, int], None] = None,
    force: bool = False,
    attributes: object = None,
    progress: Optional[Progress] = None,
) -> Volume:
    """Compresses an array of 1 to 3 axes, indexed (z, y, x). An array of 4 axes, (time, z, y, x), gives the `Series` of
    `compress_series`, the function that type checkers know for it.

    array: uint8, int8, uint16, int16, uint32, int32, float32 or float64. Others become one of these: bool uint8,
        float16 float32, int64 and uint64 int32, or else uint32; `DataError` if values do not fit.
    One of
        ratio: raw bytes / file bytes, at least and at most 2 % more (the default, 30).
        psnr: decibels over the value range of the samples, at least; can be combined with max_error.
        max_error: largest |original - decoded|, at most; 0: lossless.
        bits: bits per sample in the file, at most.
        lossless: every sample decodes to its original bits.
        keep: a `Keep`: number of terms instead of bytes; keeps the largest terms of a transform.
    labels: True: samples are labels, so the file is lossless. False: they are not, and the target holds. None:
        without a target, `is_labels` decides.
    spacing: distance of neighbours: one number, or one for each axis in the order of the array.
    geometry: the whole geometry; spacing, if given, replaces its spacing.
    transform, block: "dct", "dht" or "dft" of blocks of 8, 16 or 32 samples a side, or (block 0) of the whole
        array. Everything but DCT blocks of rank 3 is compressed by truncation; ratio then refers to memory.
    fill: samples that are equal to it, NaN or infinite have no value (NaN: only the latter); they decode to their
        original bits. None: a value far from all others, such as 1e35, with a warning, and NaN.
    background: a constant value to store separately and without loss; "auto": find one; None: no.
    lap: blocks overlap through filters; False: multiplying and convolving are faster.
    effort: "fast", "default" or "max". fast takes less than half the time and 3 to 9 % more bits. max gives 0.1 to
        1.8 dB more at the same size; compressing and reading take about 20 times as long.
    bricks: sides of the boxes that decode independently, when a part of a file is sliced: 16, 32, 48 or 64 samples,
        one number, or one for each axis in the order of the array. None: 64, and less for files of 2 MB and more that
        are made to a ratio or to bits. Smaller bricks take more bits.
    A ratio, or bits, that no file of the volume meets gives a warning with those that were reached.
    force: keep to ratio or bits even below 25 dB. Without it that is a `TargetError`; without a target, a PSNR of
        35 dB replaces the default ratio, with a warning.
    attributes: any JSON value, which the file stores.

    For a volume (three axes, DCT blocks) the error is measured by decoding the coded bytes.
    """
    if isinstance(array, (str, bytes, os.PathLike)):
        raise TypeError(f"{array!r} is a name, not an array: read the file with samples, geometry = cvol.read(name)")
    if not 1 <= np.ndim(array) <= 4:
        raise ValueError(f"the array has {np.ndim(array)} axes, must have 1 to 4")
    if keep is not None and not isinstance(keep, Keep):
        raise TypeError(f"keep is {keep!r}, must be a cvol.Keep or None")
    if np.ndim(array) == 4:
        settings = dict(psnr=psnr, max_error=max_error, bits=bits, lossless=lossless, labels=labels, keep=keep,
                        spacing=spacing, geometry=geometry, transform=transform, block=block, fill=fill,
                        background=background, lap=lap, effort=effort, bricks=bricks, force=force,
                        attributes=attributes, progress=progress)  # fmt: skip
        return compress_series(array, ratio, **settings)  # type: ignore[return-value]
    samples = samples_of(array)
    if not samples.size:
        raise ValueError(f"the array has shape {samples.shape}, must have at least one sample")
    grid = make_grid(samples.shape, samples.dtype, geometry, spacing)
    number = _abi.functions["transform_from_name"](transform.encode())
    if not number:
        raise ValueError(f"transform is {transform!r}, must be 'dct', 'dht' or 'dft'")
    if effort not in EFFORTS:
        raise ValueError(f"effort is {effort!r}, must be 'fast', 'default' or 'max'")
    target, value = _target(ratio, psnr, max_error, bits, lossless, keep)
    if background is not None and not isinstance(background, str):
        background = _number(background, "background")
    of_blocks = keep is None and number == 1 and block != 0 and samples.ndim == 3
    named = _named(ratio, psnr, max_error, bits, lossless, keep)
    if _keep_labels(labels, array, named, of_blocks) and not lossless:
        lossless = True
        if labels is None:  # options of lossy files
            effort = "default" if effort == "max" else effort
            background = None if isinstance(background, (int, float)) else background
    with options(progress=progress):
        if of_blocks:
            o = _abi.defaults("compress_options")
            o.block, o.target, o.target_value = block, target, value
            o.max_error = _number(max_error, "max_error") if target == _PSNR and max_error is not None else 0
            exact = lossless or max_error is not None and float(max_error) == 0  # with a PSNR, max_error 0 means: none
            o.lossless, o.lapped, o.effort = exact, lap, EFFORTS[effort]
            o.brick[:] = _sides(bricks)
            if fill is None and not (labels or isinstance(background, (int, float))):
                fill = _mark(samples, grid)
                if fill is not None and not exact:
                    warnings.warn(f"samples of {fill:g}, far from all others, are treated as missing; give fill=nan if "
                                  "they are values", stacklevel=2)  # fmt: skip
            if fill is not None:
                o.has_fill, o.fill = 1, _number(fill, "fill")
            if background == "auto":
                o.background = int(lap)  # 1: find
            elif isinstance(background, str):
                raise ValueError(f"background is {background!r}, must be 'auto', a number or None")
            elif background is not None:
                o.background, o.background_value = 2, float(background)
            o.attributes = attributes_text(attributes)  # a size counts them
            if target in (_RATIO, _BITS) and not force:
                o.least_psnr = _LEAST_PSNR
            try:
                volume, report = _by_codec(samples, grid, o)
                if named:
                    _report_miss(o, report, samples.nbytes, samples.size)
            except TargetError as error:
                if not o.least_psnr:
                    raise
                if named:
                    raise _refusal(str(error)) from None
                _yielding(value, str(error))
                o.target, o.target_value = _PSNR, PSNR_INSTEAD
                volume, _ = _by_codec(samples, grid, o)
        else:
            if keep is None and (max_error is not None or target == _BITS or lossless):
                raise ValueError("max_error, bits and lossless need three axes and DCT blocks")
            if bricks is not None:
                raise ValueError("bricks need three axes and DCT blocks, and cannot be combined with keep")
            if fill is not None or isinstance(background, (int, float)):
                raise ValueError("fill and background need three axes and DCT blocks")
            terms = keep or (Keep.psnr(value) if target == _PSNR else Keep.ratio(value))
            says = ""
            try:
                volume = _by_truncation(samples, grid, number, block, terms._value)
                if keep is None and target == _RATIO and not force and volume.info.psnr_db < _LEAST_PSNR:
                    says = f"ratio {value:g} leaves a PSNR of {volume.info.psnr_db:.2f} dB, less than {_LEAST_PSNR} dB"
                    if named:
                        raise _refusal(says)
            except TargetError as error:  # few samples: even an array without terms is too large
                if named or force:
                    raise
                says = str(error)
            if says:
                _yielding(value, says)
                volume = _by_truncation(samples, grid, number, block, Keep.psnr(PSNR_INSTEAD)._value)
            if attributes is not None:
                volume.attributes = attributes
    return volume


def compress_series(array: ArrayLike, ratio: Optional[float] = None, **settings: object) -> Series:
    """Compresses an array (time, z, y, x), each time as a volume of its own, to a `Series`.

    ratio, settings: those of `compress`; a target holds for each volume. spacing: of the three axes z, y and x.
    Labels are recognized at the first time. ValueError: the array has not four axes, or no sample.
    """
    samples = np.asanyarray(array)
    if samples.ndim != 4 or not samples.size:
        raise ValueError(f"the array has shape {samples.shape}, must have four axes (time, z, y, x) and a sample")
    if samples.dtype.kind in "iu" and samples.dtype.itemsize == 8:
        samples = samples_of(samples)  # one type for all times
    targets = ("psnr", "max_error", "bits", "lossless", "keep")
    if settings.get("labels") is None and ratio is None and not any(settings.get(name) for name in targets):
        settings["labels"] = is_labels(samples[0])
    return Series([compress(volume, ratio, **settings) for volume in samples])  # type: ignore[arg-type]


def transcode(
    volume: Volume,
    ratio: Optional[float] = None,
    *,
    psnr: Optional[float] = None,
    bits: Optional[float] = None,
    bricks: Union[int, tuple[int, int, int], None] = None,
    force: bool = False,
) -> Volume:
    """Makes a coarser volume (DCT blocks) from a compressed one, without decoding samples. Its error is certified,
    not measured. bricks: see `compress` (None: those of the volume). force: make labels lossy, which are stored
    without loss, and keep to ratio or bits even below 25 dB; without it both are a `TargetError`."""
    if not isinstance(volume, Volume):
        raise TypeError(f"the volume is {volume!r}, must be a cvol.Volume")
    out, report = out_pointer(), _abi.CompressReport()
    o = _abi.defaults("compress_options")
    o.least_psnr = 0 if force else _LEAST_PSNR
    o.target, o.target_value = _target(ratio, psnr, None, bits, False, None)
    o.brick[:] = _sides(bricks)
    if not math.isfinite(o.target_value):
        raise ValueError(f"the target is {o.target_value}, must be finite")
    exact = volume.info.exact and volume.dtype.kind in "iu"
    if exact and not force and is_labels(volume.to_numpy()):
        raise TargetError("the samples are labels, which transcoding would change; force=True makes them lossy")
    with volume._store.whole() as array, Call() as call:
        try:
            call("array_transcode", c.byref(out), c.byref(report), array, c.byref(o))
        except TargetError as error:
            if o.target != _PSNR and " PSNR of " in str(error):  # the least one
                raise _refusal(str(error)) from None
            raise
        made = Volume._take(out)
    _report_miss(o, report, volume.nbytes, volume.size)
    return made
