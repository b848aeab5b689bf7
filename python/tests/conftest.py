"""Shared by the tests: a small smooth volume with a ball and a sharp edge, and its file."""

import os
import sys
from pathlib import Path

import numpy as np
import pytest

sys.path.insert(0, str(Path(__file__).resolve().parents[1]))

import cvol  # noqa: E402


def installed(folder):
    """Environment of a child process in which the package is as if installed: with its entry points."""
    package = Path(cvol.__file__).resolve().parents[1]
    info = folder / "cvol-0.1.0.dist-info"
    info.mkdir(parents=True)
    (info / "METADATA").write_text("Metadata-Version: 2.1\nName: cvol\nVersion: 0.1.0\n")
    (info / "entry_points.txt").write_text((package / "entry_points.txt").read_text())
    return {**os.environ, "PYTHONPATH": os.pathsep.join([str(folder), str(package)])}


def make_array(shape=(70, 24, 80), dtype=np.int16):
    z, y, x = np.meshgrid(*[np.arange(n) for n in shape], indexing="ij")
    ball = (z - shape[0] / 2) ** 2 + (y - shape[1] / 2) ** 2 + (x - shape[2] / 2) ** 2 < (min(shape) / 3) ** 2
    wave = 100 * np.sin(x / 17.0) * np.cos(y / 11.0) + z
    noise = np.random.default_rng(0).normal(0, 12, shape)
    return (wave + 400 * ball + noise).astype(dtype)


@pytest.fixture(scope="session")
def array():
    return make_array()


@pytest.fixture(scope="session")
def volume(array):
    return cvol.compress(array, 20, spacing=(2.0, 1.0, 0.5), background=None, effort="fast", attributes={"of": "a test"})


@pytest.fixture(scope="session")
def path(volume, tmp_path_factory):
    name = tmp_path_factory.mktemp("cvol") / "volume.cvol"
    volume.save(name)
    return name
