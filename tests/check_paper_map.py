#!/usr/bin/env python3
"""Checks doc/paper-map.md: every file, function, test, program and picture that it names exists.

`folder/file.c:function` is in src/ and defines the function; `test_name.c` and `test_name.c:test` are anywhere in
tests/; `bench/name.py`, `tests/name.py`, `src/...` are paths from the root; `name.png` is in doc/images.
usage: check_paper_map.py SOURCE_FOLDER
"""
import pathlib
import re
import sys

ENTRY = re.compile(r"`([\w/.-]+\.(?:c|h|py|png|webp))(?::(\w+))?`")
LEAST = 40  # the least number of functions; fewer means that the map's form has changed


def defines(path, function):
    """A pattern of a definition: the name and its parameters, then a brace. Prototypes end in a semicolon."""
    return re.search(rf"(?m)^[A-Za-z_][^;={{}}()]*\b{function}\([^;{{}}]*\)\s*\{{", path.read_text(encoding="utf-8"))


def find(root, name):
    if name.endswith((".png", ".webp")):
        return [root / "doc/images" / name]
    if name.startswith("test_"):
        return sorted((root / "tests").rglob(name))
    if name.split("/")[0] in ("bench", "tests", "src", "doc"):
        return [root / name]
    return [root / "src" / name]


def check(root):
    failures, functions = [], 0
    for number, line in enumerate((root / "doc/paper-map.md").read_text(encoding="utf-8").splitlines(), 1):
        for name, function in ENTRY.findall(line):
            paths = [path for path in find(root, name) if path.is_file()]
            if not paths:
                failures.append(f"doc/paper-map.md:{number}: there is no {name}")
            elif function:
                functions += 1
                if not any(defines(path, function) for path in paths):
                    failures.append(f"doc/paper-map.md:{number}: {name} defines no {function}")
    if functions < LEAST:
        failures.append(f"doc/paper-map.md names {functions} functions; at least {LEAST} are expected")
    return failures, functions


def main():
    failures, functions = check(pathlib.Path(sys.argv[1]))
    print("\n".join(failures) or f"the map of the paper: {functions} functions exist")
    return 1 if failures else 0


sys.exit(main())
