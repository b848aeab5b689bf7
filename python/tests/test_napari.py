"""The reader and writers for napari. The manifest is checked against the rules of npe2 that it uses, and against npe2
itself where it is installed (Debian has no package of it); napari is not needed."""

import importlib
import re
from configparser import ConfigParser
from pathlib import Path

import cvol
import numpy as np
import pytest
from conftest import make_array
from cvol import napari_plugin

PACKAGE = Path(cvol.__file__).parent
TURNED = cvol.Geometry(spacing=(3, 2, 1.5), origin=(10, -20, 30), direction=((0, 0, 1), (0, -1, 0), (-1, 0, 0)))


def read(path):
    reader = napari_plugin.get_reader(str(path))
    assert reader is not None
    return reader(str(path))


def test_manifest():
    yaml = pytest.importorskip("yaml", reason="yaml is not installed: the manifest for napari is not read")
    manifest = yaml.safe_load((PACKAGE / "napari.yaml").read_text())
    assert set(manifest) == {"name", "display_name", "contributions"}
    assert re.fullmatch(r"[^\W_][\w -~]{1,38}[^\W_]", manifest["display_name"])
    points = manifest["contributions"]
    assert set(points) == {"commands", "readers", "writers"}
    for command in points["commands"]:
        assert set(command) == {"id", "title", "python_name"} and re.fullmatch(r"cvol\.[a-z_]+", command["id"])
        module, _, function = command["python_name"].partition(":")
        assert callable(getattr(importlib.import_module(module), function))
    known = {command["id"] for command in points["commands"]}
    used = [entry["command"] for kind in ("readers", "writers") for entry in points[kind]]
    assert len(used) == len(set(used)) and set(used) == known
    for reader in points["readers"]:
        assert set(reader) == {"command", "filename_patterns", "accepts_directories"}
    for writer in points["writers"]:
        assert set(writer) == {"command", "layer_types", "filename_extensions", "display_name"}
        assert all(re.fullmatch(r"(image|labels)(\{\d+,\d+\})?", kind) for kind in writer["layer_types"])
        assert writer["filename_extensions"] == [".cvol"]
    entries = ConfigParser()
    entries.read(PACKAGE.parent / "entry_points.txt")
    assert entries["napari.manifest"]["cvol"] == "cvol:napari.yaml" and manifest["name"] == "cvol"


def test_npe2_accepts_the_manifest():
    npe2 = pytest.importorskip("npe2", reason="npe2 is not installed: it does not check the manifest")
    npe2.PluginManifest.from_file(PACKAGE / "napari.yaml")


def test_the_wheel_has_the_manifest(monkeypatch):
    monkeypatch.syspath_prepend(str(PACKAGE.parent / "backend"))
    names = {name for name, _, _ in importlib.import_module("cvol_wheel").modules()}
    assert {f"cvol/{n}" for n in ("napari.yaml", "napari_plugin.py", "paraview_reader.py", "py.typed")} <= names


def test_an_image(volume, path):
    ((data, options, kind),) = read(path)
    assert kind == "image" and options["multiscale"] and options["name"] == "volume"
    assert [level.shape for level in data] == [level.shape for level in volume.levels]
    assert all(np.array_equal(level[3, ::2], mine[3, ::2]) for level, mine in zip(data, cvol.open(path).levels))
    assert options["scale"] == [2, 1, 0.5] and options["translate"] == [0, 0, 0]
    low, high = options["contrast_limits"]
    assert low <= volume[...].min() and volume[...].max() <= high
    assert napari_plugin.get_reader([str(path), str(path)]) and len(napari_plugin.read([str(path)] * 2)) == 2


def test_what_it_does_not_read(tmp_path):
    (tmp_path / "no.cvol").write_bytes(b"nothing")
    for name in ("no.cvol", "missing.cvol"):
        assert napari_plugin.get_reader(str(tmp_path / name)) is None
    assert napari_plugin.get_reader([]) is None


def test_times_and_channels(tmp_path):
    frames = np.stack([np.roll(make_array((9, 12, 20), "u1"), k, axis=2) for k in range(6)]).reshape(3, 2, 9, 12, 20)
    volumes = [cvol.compress(a, lossless=True, geometry=TURNED) for pair in frames for a in pair]
    cvol.save_series(tmp_path / "run.cvol", volumes, channels=2, time_values=(1, 1.5, 2), channel_names=("DAPI", ""),
                     channel_colours=((0, 0, 1), (0, 1, 0)))  # fmt: skip
    layers = read(tmp_path / "run.cvol")
    assert [options["name"] for _, options, _ in layers] == ["run DAPI", "run 1"]
    for channel, (data, options, kind) in enumerate(layers):
        assert kind == "image" and options["blending"] == "additive" and "scale" not in options
        assert options["colormap"]["colors"][1] == ([0, 0, 1, 1], [0, 1, 0, 1])[channel]
        fine, mine = data[0], frames[:, channel]
        assert fine.shape == mine.shape and fine.dtype == mine.dtype and len(fine) == 3 and fine.ndim == 4
        for index in (1, -1, np.s_[:, 3], np.s_[::-1, 2:5, ..., 7], np.s_[2, ..., ::2], np.s_[1:1], ..., np.int64(2),
                      np.s_[[0, 2], 1]):  # fmt: skip
            assert np.array_equal(fine[index], mine[index]) and fine[index].shape == mine[index].shape
        assert np.array_equal(np.asarray(data[1])[2], volumes[4 + channel].levels[1])
        with pytest.raises(IndexError):
            fine[3]
        corner = options["affine"] @ (2, 8, 11, 19, 1)
        assert np.allclose(corner[1:4][::-1], (volumes[0].affine @ (8, 11, 19, 1))[:3]) and corner[0] == 2


def test_labels(tmp_path):
    z, y, x = np.mgrid[:40, :48, :56]
    organs = ((z // 14 + y // 17 + x // 20) * 3).astype(np.int32)
    table = [{"value": 3, "name": "Caudate", "colour": None}]
    cvol.compress(organs, labels=True).save(tmp_path / "plain.cvol")
    cvol.compress(organs, labels=True, attributes={"labels": table}).save(tmp_path / "named.cvol")
    for name in ("plain", "named"):
        ((data, options, kind),) = read(tmp_path / f"{name}.cvol")
        assert kind == "labels" and np.issubdtype(data.dtype, np.integer) and np.array_equal(data, organs)
        assert "multiscale" not in options and "contrast_limits" not in options
    assert options["features"] == {"index": [3], "name": ["Caudate"]}


def test_writing(tmp_path, array):
    path = str(tmp_path / "a.cvol")
    place = {"scale": [2, 1, 0.5], "translate": [7, 8, 9], "metadata": {"unit": "um", "attributes": {"of": "napari"}}}
    assert napari_plugin.write_image(path, [array, array[::2, ::2, ::2]], place) == [path]
    with cvol.open(path) as v:
        assert v.shape == array.shape and v.spacing == (2, 1, 0.5) and v.geometry.origin == (9, 8, 7)
        assert v.geometry.unit == "um" and v.attrs == {"of": "napari"} and not v.info.exact
    noise = np.random.default_rng(0).integers(0, 90, (9, 10, 11)).astype("u1")
    napari_plugin.write_labels(path, noise, {})
    assert np.array_equal(cvol.open(path), noise) and cvol.open(path).info.exact


def test_reading_what_was_written(tmp_path):
    """Times, channels, names, colours and directions come back."""
    path, again = tmp_path / "run.cvol", tmp_path / "again.cvol"
    frames = [make_array((9, 12, 20), "u1") + np.uint8(k) for k in range(6)]
    cvol.save_series(path, [cvol.compress(a, psnr=45, geometry=TURNED) for a in frames], channels=2,
                     time_values=(0, 2, 4), time_unit="s", channel_names=("red one", "other"),
                     channel_colours=((1, 0, 0), (0, 0.5, 1)))  # fmt: skip
    layers = read(path)
    napari_plugin.write_channels(str(again), layers)
    found = cvol.contents(again)
    assert (found.times, found.channels, found.time_values, found.time_unit) == (3, 2, (0, 2, 4), "s")
    assert found.channel_names == ("run red one", "run other")
    assert found.channel_colours == ((1, 0, 0), (0, 0.5, 1))
    assert np.allclose(cvol.open(again, time=1, channel=1).affine, TURNED.affine())


def test_what_it_does_not_write(tmp_path, array):
    path = str(tmp_path / "no.cvol")
    sheared = np.eye(4)
    sheared[0, 1] = 0.5
    for data, options, text in ((array[0], {}, "has 2 axes, must have 3"), (array, {"rgb": True}, "split it into"),
                                (array, {"affine": sheared}, "is sheared"), (array, {"scale": [0, 1, 1]}, "positive")):
        with pytest.raises(ValueError, match=text):
            napari_plugin.write_image(path, data, options)
    with pytest.raises(ValueError, match="must have the same shape and type"):
        napari_plugin.write_channels(path, [(array, {}, "image"), (array[1:], {}, "image")])
    assert not (tmp_path / "no.cvol").exists()
