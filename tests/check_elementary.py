#!/usr/bin/env python3
"""Checks that what files and decoded samples depend on calls no function of the C library whose last bit differs from
one library to another: src/base/elementary.h has these functions.

usage: check_elementary.py FOLDER
"""
import pathlib
import re
import sys

# Functions that are exact or correctly rounded, such as sqrt, rint and ldexp, are the same everywhere.
NAMES = "a?(?:sin|cos|tan)h?|atan2|exp|exp2|exp10|expm1|log|log2|log10|log1p|pow|cbrt|hypot|erfc?|[lt]gamma|fma|sincos|arg|csqrt|cabs"
CALL = re.compile(rf"(?<![\w.>])c?(?:{NAMES})[fl]?\(")
FOLDERS = ["base", "transform", "array", "codec", "volume"]
ALLOWED = {
    "base/elementary.c": {"pow", "hypot"},  # of special values
    "transform/whole_reference.c": {"sin", "cos"},  # tests compare with it
    "array/evaluate/interpolate_pencil.c": {"carg"},  # rounded to an integer
    "array/evaluate/small_matrix.c": {"hypot", "csqrt", "cabs"},  # for that file alone
}


def calls(path):
    """The calls outside comments, with their lines."""
    text = re.sub(r"/\*.*?\*/|//[^\n]*", lambda m: re.sub(r"[^\n]", " ", m.group()), path.read_text(), flags=re.S)
    for match in CALL.finditer(text):
        yield match.group()[:-1], text.count("\n", 0, match.start()) + 1


def main():
    source = pathlib.Path(sys.argv[1]) / "src"
    found = checked = 0
    for folder in FOLDERS:
        for path in sorted((source / folder).rglob("*.[ch]")):
            name = path.relative_to(source).as_posix()
            checked += 1
            for function, line in calls(path):
                if function not in ALLOWED.get(name, ()):
                    print(f"src/{name}:{line}: {function} differs in its last bit between C libraries: "
                          f"use cvol_{function} of base/elementary.h")
                    found += 1
    if not found:
        print(f"elementary functions: none of the C library in {checked} files")
    sys.exit(found > 0)


main()
