"""Structs and functions of the library for ctypes, from cvol/_headers.py, which is generated from the public
headers."""

from __future__ import annotations

import ctypes as c
from functools import partial
from typing import Any

from ._headers import CODES, FUNCTIONS, STRUCTS
from ._library import load

OK = CODES["OK"]
ERRORS = {name: number for name, number in CODES.items() if number}

ProgressFunction = c.CFUNCTYPE(c.c_int, c.c_void_p, c.c_char_p, c.c_double)
PictureFunction = c.CFUNCTYPE(c.c_int, c.c_void_p, c.c_void_p, c.c_int)

Size3 = c.c_size_t * 3
Double2 = c.c_double * 2
Double3 = c.c_double * 3

_kinds: dict[str, Any] = {
    "*": c.c_void_p, "i": c.c_int, "d": c.c_double, "f": c.c_float, "z": c.c_size_t, "u": c.c_uint64,
    "l": c.c_int64, "I": c.c_uint32, "B": c.c_uint8, "c": c.c_char, "s": c.c_char_p, "v": None,
    "cvol_progress_fn": ProgressFunction, "cvol_picture_fn": PictureFunction}  # fmt: skip


class _Struct(c.Structure):
    """A struct whose errors name the field."""

    def __setattr__(self, field: str, value: Any) -> None:
        try:
            super().__setattr__(field, value)
        except TypeError:
            name = field[:-4] if field.endswith("_deg") else field
            raise TypeError(f"{name} is {value!r}, must be a number") from None


def _struct(name: str) -> Any:
    """Makes a struct of the headers, after the structs inside it."""
    if name not in _kinds:
        fields = []
        for field, kind, sizes in STRUCTS[name]:
            made = _struct(kind)
            for size in reversed(sizes):
                made = made * size
            fields.append((field, made))
        _kinds[name] = type(name, (_Struct,), {"_fields_": fields})
    return _kinds[name]


structs = {name: _struct(name) for name in STRUCTS}
_kinds["g"] = c.POINTER(structs["cvol_grid"])


def _sized(name: str) -> Any:
    """Makes a struct that begins with its size."""
    return partial(structs[name], size=c.sizeof(structs[name]))


Grid = structs["cvol_grid"]
ArrayInfo = structs["cvol_array_info"]
FilePart = _sized("cvol_file_part")
Kernel = structs["cvol_kernel"]
Statistics = structs["cvol_array_statistics"]
Comparison = structs["cvol_array_comparison"]
Region = structs["cvol_region"]
RegionStatistics = structs["cvol_region_statistics"]
Volume = structs["cvol_volume"]
Source = _sized("cvol_source")
Image = structs["cvol_image"]
Histogram = structs["cvol_histogram"]
Annotation = _sized("cvol_annotation")
ColourSource = _sized("cvol_colour_source")
RefineReport = structs["cvol_refine_report"]
CompressReport = structs["cvol_compress_report"]

library = load()
functions: dict[str, Any] = {}
for _name, _text in FUNCTIONS.items():
    # A build without some formats lacks functions; their callers report it.
    _function = getattr(library, "cvol_" + _name, None)
    if _function is not None:
        _words = _text.split()
        _function.restype = _kinds[_words[0]]
        _function.argtypes = [_kinds[_word] for _word in _words[1:]]
        functions[_name] = _function


def defaults(name: str) -> Any:
    """An option struct, such as "compress_options", with the defaults of the library."""
    out = structs["cvol_" + name]()
    functions[name + "_set_defaults"](c.byref(out), c.sizeof(out))
    return out
