"""cvol/_headers.py equals the declarations of the headers, and its structs have the memory layout of the C
compiler."""

import ctypes
import importlib.util
import shutil
import subprocess
from pathlib import Path

import pytest
from cvol import _abi, _headers

ROOT = Path(__file__).resolve().parents[1]
INCLUDE = ROOT.parent / "include"


def test_it_is_made_from_these_headers():
    spec = importlib.util.spec_from_file_location("read_headers", ROOT / "backend" / "read_headers.py")
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    assert module.generate() == Path(_headers.__file__).read_text(), "run python/backend/read_headers.py"
    assert _headers.CODES["ERROR_CANCELLED"] == -10 and len(_headers.FUNCTIONS) > 150
    assert set(_headers.FUNCTIONS) == set(_abi.functions)


@pytest.mark.skipif(not shutil.which("cc"), reason="no C compiler")
def test_structs_lie_as_the_headers_say(tmp_path):
    lines = ["#include <stdio.h>", "#include <cvol/cvol.h>", "int main(void) {"]
    wanted = []
    assert len(_abi.structs) > 30
    for name, struct in _abi.structs.items():
        lines.append(f'printf("%zu ", sizeof({name}));')
        wanted.append((name, ctypes.sizeof(struct)))
        for field, _ in struct._fields_:
            lines.append(f'printf("%zu %zu ", offsetof({name}, {field}), sizeof((({name} *)0)->{field}));')
            place = getattr(struct, field)
            wanted += [(f"{name}.{field}", place.offset), (f"{name}.{field} size", place.size)]
    source = tmp_path / "layout.c"
    source.write_text("\n".join([*lines, "return 0; }"]))
    subprocess.run(["cc", "-std=c11", f"-I{INCLUDE}", source, "-o", tmp_path / "layout"], check=True)
    numbers = subprocess.run([tmp_path / "layout"], check=True, capture_output=True, text=True).stdout.split()
    assert [(name, int(number)) for (name, _), number in zip(wanted, numbers)] == wanted
    assert len(numbers) == len(wanted)
