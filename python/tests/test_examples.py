"""The examples and the code of README.md run and give the described results."""

import os
import re
import subprocess
import sys
from importlib.util import find_spec
from pathlib import Path

import pytest
from conftest import installed

HERE = Path(__file__).resolve().parents[1]


def run(*words, cwd, environment=None):
    environment = environment or {**os.environ, "PYTHONPATH": str(Path(sys.modules["cvol"].__file__).parents[1])}
    run = subprocess.run(
        [sys.executable, *map(str, words)], cwd=cwd, env=environment, capture_output=True, text=True, timeout=120
    )
    assert run.returncode == 0, run.stderr
    return run.stdout


def test_change(tmp_path):
    text = run(HERE / "examples" / "change.py", tmp_path, cwd=tmp_path)
    assert "a slice: (96, 96) uint8" in text
    names = sorted(path.name for path in tmp_path.iterdir())
    assert names == ["before.png", "change.cvol", "change.png"]


def test_turn(tmp_path, path):
    assert "4 pictures" in run(HERE / "examples" / "turn.py", path, tmp_path, cwd=tmp_path)
    assert len(list(tmp_path.glob("turn-?.png"))) == 4


def test_planes(tmp_path, path):
    text = run(HERE / "examples" / "planes.py", path, tmp_path, cwd=tmp_path)
    assert " in bricks of (64, 64, 64) " in text
    assert "z = 40: decodes 3 of 15 bricks (1/5); in those of 64 2 of 4" in text
    assert sorted(file.name for file in tmp_path.iterdir()) == ["planes.cvol", "planes.png"]


@pytest.mark.parametrize("readme", [HERE / "README.md", HERE.parent / "README.md"], ids=["package", "project"])
def test_readme(readme, tmp_path, path):
    """Runs all Python blocks, one after the other, without those that import a package that is not installed."""
    blocks = re.findall(r"^```python\n(.*?)^```", readme.read_text(), re.M | re.S)
    assert blocks
    imports = [re.findall(r"^import (\w+)", block, re.M) for block in blocks]
    blocks = [b for b, names in zip(blocks, imports) if all(name == "cvol" or find_spec(name) for name in names)]
    (tmp_path / "brain.cvol").write_bytes(path.read_bytes())
    (tmp_path / "readme.py").write_text("\n".join(blocks))
    run("readme.py", cwd=tmp_path, environment=installed(tmp_path / "site"))
