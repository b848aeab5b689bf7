"""Finds and loads libcvol.

It tries in order: the file in CVOL_LIBRARY; the file in the package; the build in the checkout of the package; the
library that the system's loader finds.
"""

from __future__ import annotations

import ctypes
import ctypes.util
import os
from pathlib import Path

SONAME = "libcvol.so.0"
# The version whose headers cvol/_abi.py mirrors; structs may differ in any other.
VERSION = "0.1.0"


def candidates() -> list[str]:
    """Files to try, in order; names without a folder are for the loader."""
    here = Path(__file__).resolve().parent
    named = os.environ.get("CVOL_LIBRARY")
    if named:
        return [named]
    found = [str(here / SONAME)]
    if (here.parents[1] / "include" / "cvol").is_dir():
        found.append(str(here.parents[1] / "build" / SONAME))
    found.append(ctypes.util.find_library("cvol") or SONAME)
    return found


def load() -> ctypes.CDLL:
    """Loads the library. ImportError lists the files it tried, or names a wrong version."""
    problems = []
    for name in candidates():
        if os.sep in name and not os.path.exists(name):
            problems.append(f"{name}: not there")
            continue
        try:
            library = ctypes.CDLL(name)
        except OSError as error:
            problems.append(str(error))
            continue
        library.cvol_version.restype = ctypes.c_char_p
        found = library.cvol_version().decode()
        if found != VERSION:
            raise ImportError(f"{name} is libcvol {found}, but this package needs {VERSION}")
        return library
    raise ImportError(
        "cannot find libcvol: build it (cmake --build build), install it (make install), or name the file in "
        "CVOL_LIBRARY. Tried: " + "; ".join(problems)
    )
