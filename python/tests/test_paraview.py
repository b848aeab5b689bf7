"""The reader for ParaView, in the installed ParaView without a window."""

import json
import os
import shutil
import subprocess
from pathlib import Path

import cvol
import numpy as np
import pytest
from conftest import make_array

HERE = Path(__file__).resolve().parent
PVBATCH = shutil.which("pvbatch")
TURNED = cvol.Geometry(
    spacing=(3, 2, 1.5), origin=(10, -20, 30), direction=((0, 0, 1), (0, -1, 0), (-1, 0, 0)), space="LPS", unit="mm"
)
pytestmark = pytest.mark.skipif(PVBATCH is None, reason="ParaView (pvbatch) is not installed: its reader is not tested")


def run(folder, *picture):
    """Runs the script; returns its output."""
    reader = Path(cvol.__file__).with_name("paraview_reader.py")
    words = ["xvfb-run", "-a"] if picture else []
    words += map(str, [PVBATCH, HERE / "paraview_script.py", reader, folder, *picture])
    environment = {key: value for key, value in os.environ.items() if key != "PYTHONPATH"}
    done = subprocess.run(words, env=environment, capture_output=True, text=True, timeout=200)
    assert done.returncode == 0, done.stdout + done.stderr
    return done.stdout + done.stderr


@pytest.fixture(scope="module")
def found(tmp_path_factory):
    folder = tmp_path_factory.mktemp("paraview")
    scan = cvol.compress(make_array((70, 24, 80)), 8, effort="fast", geometry=TURNED)
    scan.save(folder / "scan.cvol")
    frames = [np.roll(make_array((9, 12, 20), "u1"), k, axis=2) for k in range(6)]
    volumes = [cvol.compress(a, lossless=True) for a in frames]
    cvol.save_series(folder / "run.cvol", volumes, channels=2, time_values=(0, 0.5, 2), time_unit="s",
                     channel_names=("DAPI", "GFP"))  # fmt: skip
    cvol.save_series(folder / "colours.cvol", volumes[:3], channels=3, colours=True)
    (folder / "damaged.cvol").write_bytes((folder / "scan.cvol").read_bytes()[:100])
    cvol.compress(make_array((9, 12, 20))[0], psnr=40).save(folder / "plane.cvol")
    text = run(folder)
    return folder, frames, json.loads((folder / "results.json").read_text()), text


def samples(folder, name):
    return np.load(folder / f"{name}.npy")


def test_volume(found):
    folder, _, results, _ = found
    with cvol.open(folder / "scan.cvol") as v:
        scan = results["scan"]
        assert scan["extent"] == [0, 79, 0, 23, 0, 69] and scan["spacing"] == [1.5, 2, 3] and scan["active"] == "scan"
        assert np.allclose(scan["origin"], v.geometry.origin)
        assert np.allclose(scan["corner"], (v.affine @ (69, 23, 79, 1))[:3]) and scan["times"] == []
        assert np.array_equal(samples(folder, "scan-scan"), v)
        part = samples(folder, "part-scan")
        assert part.dtype == v.dtype and np.array_equal(part, v[40:61, 5:10, 10:31])
        for name, level in (("coarse", v.levels[1]), ("coarsest", v.levels[-1])):
            assert np.array_equal(samples(folder, f"{name}-scan"), level)
            end = (*(n - 1 for n in level.shape), 1)
            assert np.allclose(results[name]["corner"], (level.affine @ end)[:3])


def test_series(found):
    folder, frames, results, _ = found
    assert results["run0"]["times"] == [0, 0.5, 2]
    for name, time in (("run0", 0), ("run0.7", 1), ("run9", 2)):
        for channel, word in enumerate(("DAPI", "GFP")):
            assert np.array_equal(samples(folder, f"{name}-run {word}"), frames[2 * time + channel])
    assert np.array_equal(samples(folder, "chosen-run GFP"), frames[5])
    assert not (folder / "chosen-run DAPI.npy").exists()
    assert np.array_equal(samples(folder, "colours-colours"), np.stack(frames[:3], -1))


def test_messages(found):
    text = found[3]
    assert "cvol: " in text and "damaged.cvol" in text
    assert "plane.cvol: has 2 axes, must have 3" in text and "Traceback" not in text


def test_picture(tmp_path):
    if not shutil.which("xvfb-run"):
        pytest.skip("xvfb-run is not installed: ParaView draws no picture")
    pil = pytest.importorskip("PIL.Image", reason="Pillow is not installed: the picture is not read")
    z, y, x = np.mgrid[-1:1:40j, -1:1:40j, -1:1:40j]
    cvol.compress((200 * np.exp(-4 * (z * z + y * y + x * x))).astype("u1"), psnr=40).save(tmp_path / "head.cvol")
    for attempt in range(3):  # the display of xvfb-run is sometimes not ready
        try:
            run(tmp_path, tmp_path / "picture.png")
            break
        except AssertionError:
            if attempt == 2:
                raise
    picture = np.asarray(pil.open(tmp_path / "picture.png"))[..., :3].astype(int)
    middle, corner = picture[180:220, 180:220], picture[:20, :20]
    assert np.abs(middle.mean((0, 1)) - corner.mean((0, 1))).max() > 20
