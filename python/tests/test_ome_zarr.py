"""OME-Zarr 0.4 and plain Zarr arrays, with the installed zarr."""

import json
import pickle

import cvol
import numpy as np
import pytest
from conftest import make_array

zarr = pytest.importorskip("zarr", reason="zarr is not installed: OME-Zarr is not tested")
from cvol import ome_zarr  # noqa: E402

PLACE = cvol.Geometry(spacing=(2, 1, 0.5), origin=(5, 6, 7), unit="um")


@pytest.fixture(scope="module")
def small():
    return make_array((40, 24, 32))


@pytest.fixture(scope="module")
def image(tmp_path_factory, small):
    """As other programs write it: times, channels, two levels, blosc and zlib."""
    name = str(tmp_path_factory.mktemp("ome") / "image.ome.zarr")
    group = zarr.open_group(name, mode="w")
    samples = np.stack([np.stack([small + 10 * t + c for c in range(3)]) for t in range(2)])
    group.create_dataset("0", data=samples, chunks=(1, 1, 16, 24, 16), dimension_separator="/")
    group.create_dataset("1", data=samples[..., ::2, ::2, ::2], compressor=zarr.Zlib(), dimension_separator="/")
    axes = [{"name": "t", "type": "time", "unit": "second"}, {"name": "c", "type": "channel"},
            *({"name": a, "type": "space", "unit": "micrometer"} for a in "zyx")]  # fmt: skip
    datasets = [{"path": str(k), "coordinateTransformations": [
        {"type": "scale", "scale": [1, 1, 2 * 2**k, 2**k, 0.5 * 2**k]},
        {"type": "translation", "translation": [0, 0, 3, 4, 5]}]} for k in range(2)]  # fmt: skip
    whole = [{"type": "scale", "scale": [1, 1, 10, 10, 10]}]
    scales = [{"version": "0.4", "axes": axes, "datasets": datasets, "coordinateTransformations": whole}]
    group.attrs.update({"multiscales": scales, "omero": {"channels": [{"label": f"dye {c}"} for c in range(3)]}})
    return name, samples


def test_reading(image):
    name, samples = image
    v = cvol.open(name, time=1, channel=2)
    assert v.shape == (40, 24, 32) and v._store._whole is None and np.array_equal(v, samples[1, 2])
    assert v.geometry.unit == "um" and v.spacing == (20, 10, 5) and v.geometry.origin == (50, 40, 30)
    assert np.array_equal(pickle.loads(pickle.dumps(v)), samples[1, 2])
    coarse = cvol.open(name + "/1", time=0, channel=0)
    assert coarse.spacing == (40, 20, 10) and np.array_equal(coarse, samples[0, 0, ::2, ::2, ::2])
    read, geometry = cvol.read(name, time=1, channel=0)
    assert np.array_equal(read, cvol.read(name, index=1, channel=0)[0])
    assert np.array_equal(read, samples[1, 0]) and geometry == cvol.open(name, time=1, channel=2).geometry
    assert ome_zarr.open_image(name, level=1).channel_names == ("dye 0", "dye 1", "dye 2")
    for options, text in (({}, "has 3 channels; choose one with channel= 0 to 2"),
                          ({"channel": 0}, "has 2 volumes; choose one with time= 0 to 1"),
                          ({"channel": 0, "time": 2}, "has 2 volumes, 0 to 1; number 2 was requested")):  # fmt: skip
        with pytest.raises(cvol.ArgumentError, match=text):
            cvol.open(name, **options)


def test_xarray_reads_it(image):
    xr = pytest.importorskip("xarray", reason="xarray is not installed: it does not read OME-Zarr here")
    from cvol.xarray_backend import CvolBackend

    with xr.open_dataset(image[0], engine=CvolBackend) as ds:
        assert ds["volume"].dims == ("time", "channel", "z", "y", "x")
        assert np.array_equal(ds["volume"][1, ::-1, 3], image[1][1, ::-1, 3]) and ds.x[1] == 55


@pytest.mark.parametrize("compressor", ["cvol", None, zarr.Blosc("zstd")], ids=str)
def test_writing(tmp_path, small, compressor):
    v = cvol.compress(small, lossless=True, effort="fast", geometry=PLACE)
    name = tmp_path / "mine.ome.zarr"
    ome_zarr.write(name, v, compressor=compressor, chunks=(32, 32, 16), attributes={"omero": {"channels": []}})
    group = zarr.open_group(str(name), mode="r")
    (scales,) = group.attrs["multiscales"]
    assert scales["version"] == "0.4" and scales["name"] == "mine" and group.attrs["omero"] == {"channels": []}
    assert scales["axes"] == [{"name": a, "type": "space", "unit": "micrometer"} for a in "zyx"]
    assert [d["path"] for d in scales["datasets"]] == ["0", "1", "2"] == sorted(group.array_keys())
    assert np.array_equal(group["0"], small) and group["0"].chunks == (32, 24, 16)
    assert all(np.array_equal(group[str(k)], v.levels[k]) for k in range(3))
    assert json.loads((name / "0" / ".zarray").read_text())["dimension_separator"] == "/"
    back = cvol.open(name)
    assert np.array_equal(back, small) and back.spacing == v.spacing and back.geometry.origin == v.geometry.origin
    for k in (1, 2):
        assert np.allclose(cvol.open(name / str(k)).affine, v.levels[k].affine)
    with pytest.raises(FileExistsError, match="remove it first"):
        ome_zarr.write(name, v)


def test_labels_and_directions(tmp_path, small):
    labels = (small > 200).astype("u1") * 7
    turned = cvol.Geometry(direction=((0, 1, 0), (0, 0, 1), (1, 0, 0)))
    v = cvol.compress(labels, lossless=True, geometry=turned)
    with pytest.warns(UserWarning, match="no field for directions"):
        ome_zarr.write(tmp_path / "labels.ome.zarr", v, labels=True)
    assert np.array_equal(cvol.open(tmp_path / "labels.ome.zarr" / "1"), labels[::2, ::2, ::2])


def test_plain_arrays(tmp_path, small):
    for name, samples, kwargs in (("a", small, {}), ("b", small[3], {}), ("c", small[None].astype("i8"), {}),
                                  ("d", np.stack([small] * 2), {"channel": 1})):  # fmt: skip
        zarr.save(str(tmp_path / name), samples)
        v = cvol.open(tmp_path / name, **kwargs)
        assert np.array_equal(np.squeeze(v), samples[1] if kwargs else np.squeeze(samples))
        assert v.dtype == (np.int32 if name == "c" else np.int16)


def test_groups_with_attributes_only(tmp_path, small):
    """A folder with .zattrs and without .zgroup, whose codec only Python has."""
    name = tmp_path / "image.ome.zarr"
    ome_zarr.write(name, cvol.compress(small, lossless=True, spacing=(3, 2, 1)), compressor=zarr.LZMA())
    with_group = cvol.open(name)
    (name / ".zgroup").unlink()
    v = cvol.open(name)
    assert np.array_equal(v, small) and v.geometry == with_group.geometry and v.spacing == (3, 2, 1)
    assert np.array_equal(cvol.read(name)[0], small)


def test_what_is_wrong(tmp_path, image):
    def check(text, kind=cvol.FormatError):
        with pytest.raises(kind, match=text):
            ome_zarr.open_image(str(tmp_path / "x.zarr"))
        with pytest.raises(cvol.Error):
            cvol.open(tmp_path / "x.zarr", time=0, channel=0)

    group = zarr.open_group(str(tmp_path / "x.zarr"), mode="w")
    check("without multiscales")
    group.create_dataset("0", data=np.zeros((4, 4), "u1"))
    axes = [{"name": "y", "type": "space"}, {"name": "x", "type": "space"}]

    def describe(axes, *transformations):
        datasets = [{"path": "0", "coordinateTransformations": list(transformations)}]
        group.attrs["multiscales"] = [{"axes": axes, "datasets": datasets}]

    describe(axes, {"type": "scale", "scale": [1, 2, 3]})
    check("must be a scale or a translation of 2 numbers")
    describe(axes, {"type": "scale", "scale": [1, -2]})
    check("must be positive")
    describe(axes[::-1], {"type": "scale", "scale": [1, 1]})
    check("must be of t, c, z, y, x in this order", cvol.UnsupportedError)
    describe([{"name": "z"}, *axes], {"type": "scale", "scale": [1, 1, 1]})
    check("has 2 axes, its description 3")
    (tmp_path / "x.zarr" / ".zattrs").write_text("{")
    check("is not JSON")
    (tmp_path / "x.zarr" / "zarr.json").write_text("{}")
    check("Zarr format 3", cvol.UnsupportedError)


def test_without_zarr(tmp_path, image, small, monkeypatch):
    """The library reads and writes folders; only what it does not know needs the package zarr."""
    zarr.save(str(tmp_path / "long"), small.astype("i8"))
    zarr.save(str(tmp_path / "turning"), small.astype("c8"))

    def refuse(path, level=0):
        raise ImportError("no zarr")

    monkeypatch.setattr(ome_zarr, "open_image", refuse)
    name, samples = image
    assert np.array_equal(cvol.open(name + "/1", time=1, channel=2), samples[1, 2, ::2, ::2, ::2])
    with pytest.raises(cvol.UnsupportedError, match="'dtype' is \"<c8\", which is not supported"):
        cvol.open(tmp_path / "turning")
    assert np.array_equal(cvol.open(tmp_path / "long", compress=False), small)
    with pytest.raises(cvol.ArgumentError, match="has 3 channels; choose one .*0: dye 0, 1: dye 1, 2: dye 2"):
        cvol.open(name)
    cvol.write(tmp_path / "mine.ome.zarr", small, geometry=PLACE)
    v = cvol.open(tmp_path / "mine.ome.zarr")
    assert np.array_equal(v, small) and v.spacing == (2, 1, 0.5)
    assert v.geometry.origin == PLACE.origin and v.geometry.unit == "um"
