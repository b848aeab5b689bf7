"""xarray's backend and dask arrays, with the installed packages."""

import pickle
import re
import subprocess
import sys
from pathlib import Path

import cvol
import numpy as np
import pytest
from conftest import installed, make_array

PLACE = cvol.Geometry((2, 1, 0.5), (10, 20, 30), ((0, 0, 1), (0, -1, 0), (1, 0, 0)), "LPS", "mm")


@pytest.fixture(scope="module")
def xr():
    return pytest.importorskip("xarray", reason="xarray is not installed: its backend is not tested")


@pytest.fixture(scope="module")
def dask():
    return pytest.importorskip("dask.array", reason="dask is not installed: its arrays are not tested")


@pytest.fixture(scope="module")
def engine(xr):
    from cvol.xarray_backend import CvolBackend

    return CvolBackend


@pytest.fixture(scope="module")
def run(tmp_path_factory):
    """A file of 3 times and 2 channels, and its samples."""
    samples = np.stack([np.stack([np.roll(make_array((20, 24, 30)), k, axis=c) for c in range(2)]) for k in range(3)])
    name = tmp_path_factory.mktemp("run") / "run.cvol"
    volumes = (cvol.compress(a, lossless=True, geometry=PLACE) for a in samples.reshape(6, 20, 24, 30))
    cvol.save_series(name, volumes, times=3, channels=2, time_values=(0, 0.5, 2), time_unit="s",
                     channel_names=("DAPI", "GFP"))  # fmt: skip
    return name, samples


def test_one_volume(xr, engine, path, volume):
    with xr.open_dataset(path, engine=engine) as ds:
        v = ds["volume"]
        assert v.dims == ("z", "y", "x") and v.shape == volume.shape and v.dtype == volume.dtype
        assert v.attrs["of"] == "a test" and np.array_equal(v.attrs["affine"], volume.affine)
        assert np.allclose(ds.z, np.arange(70) * 2) and np.allclose(ds.x, np.arange(80) * 0.5)
        whole = volume.to_numpy()
        assert "volume" in repr(ds)
        for got, expected in (
            (v[3], whole[3]), (v[::-2, 4:9, -1], whole[::-2, 4:9, -1]), (v.sel(z=20), whole[10]),
            (v.isel(z=[3, 60], x=[1, 5, 2]), whole[np.ix_([3, 60], range(24), [1, 5, 2])]),
            (v.isel(z=[3, 60], y=4, x=[1, 5]), whole[np.ix_([3, 60], [4], [1, 5])][:, 0]),
            (v.isel(z=4, y=slice(2, 5), x=[7]), whole[4, 2:5, [7]].T),
            (v.isel(z=xr.DataArray([1, 2], dims="p"), y=xr.DataArray([3, 4], dims="p")), whole[[1, 2], [3, 4]]),
            (v.where(v > 100, 0), np.where(whole > 100, whole, 0)), (v[0:0], whole[0:0]),
        ):  # fmt: skip
            assert got.dtype == expected.dtype and np.array_equal(got, expected)
        assert np.array_equal(pickle.loads(pickle.dumps(ds))["volume"][5], whole[5])


def test_random_selections(xr, engine, run):
    """They are those of an array in memory."""
    rng = np.random.default_rng(3)
    with xr.open_dataset(run[0], engine=engine, cache=False) as ds:
        lazy, dense = ds["volume"], xr.DataArray(run[1], dims=ds["volume"].dims)
        for _ in range(40):
            index = {}
            for name, n in zip(dense.dims, dense.shape):
                kinds = [int(rng.integers(-n, n)), slice(None, None, [1, 2, -1, -2, -3][rng.integers(5)]), slice(1, -1),
                         rng.integers(-n, n, rng.integers(4)), rng.random(n) < 0.5, slice(None)]  # fmt: skip
                index[name] = kinds[rng.integers(6)]
            got, expected = lazy.isel(index), dense.isel(index)
            assert got.dims == expected.dims and np.array_equal(got.values, expected.values), index
        points = {name: xr.DataArray([[0, 1], [1, 0]], dims=("p", "q")) for name in dense.dims}
        for names in (dense.dims, ("time", "z", "x"), ("y", "x"), ("channel", "y")):
            index = {name: points[name] for name in names}
            for more in ({}, {"z": slice(None, None, -3)}):
                both = {**more, **index}
                got, expected = lazy.isel(both), dense.isel(both)
                assert got.dims == expected.dims and np.array_equal(got.values, expected.values), both


def test_it_is_lazy(xr, engine, array, path, tmp_path):
    """A slice reads its bricks only: the last ones are damaged."""
    volume = cvol.compress(array, 20, effort="fast", bricks=16)
    data = bytearray(volume.to_bytes())
    data[-200:-100] = bytes(100)  # finest coefficients of the last bricks
    (tmp_path / "damaged.cvol").write_bytes(data)
    with xr.open_dataset(tmp_path / "damaged.cvol", engine=engine) as ds:
        assert np.array_equal(ds["volume"][3], volume[3])
        with pytest.raises(cvol.CorruptError):
            ds["volume"].load()
    with xr.open_dataset(path, engine=engine) as ds:
        pass
    with pytest.raises(ValueError, match="closed"):
        ds["volume"].load()


def test_geometry(xr, engine, run, tmp_path):
    ds = xr.open_dataset(run[0], engine=engine)
    assert np.allclose(ds.y, 20 - np.arange(24)) and np.allclose(ds.x, 10 + np.arange(30) / 2)
    assert ds.z.attrs["units"] == "mm" and ds["volume"].attrs["space"] == "LPS"
    oblique = cvol.Geometry((2, 1, 0.5), (10, 20, 30), ((0, 0.6, 0.8), (0, 0.8, -0.6), (1, 0, 0)))
    cvol.compress(make_array((8, 8, 8)), lossless=True, geometry=oblique).save(tmp_path / "oblique.cvol")
    ds = xr.open_dataset(tmp_path / "oblique.cvol", engine=engine)
    assert np.allclose(ds.z, np.arange(8) * 2) and np.allclose(ds["volume"].attrs["affine"], oblique.affine())


def test_times_and_channels(xr, engine, run):
    name, samples = run
    with xr.open_dataset(name, engine=engine) as ds:
        v = ds["volume"]
        assert v.dims == ("time", "channel", "z", "y", "x") and v.shape == samples.shape
        assert list(ds.time.values) == [0, 0.5, 2] and ds.time.attrs["units"] == "s"
        assert np.array_equal(v.sel(time=0.5, channel="GFP"), samples[1, 1])
        assert np.array_equal(v[[2, 0], 1, 3, [1, 4]], samples[[2, 0], 1, 3][:, [1, 4]])
        assert np.array_equal(v[::-1, :, 5], samples[::-1, :, 5]) and v[3:, :, 5].shape == (0, 2, 24, 30)
        assert np.array_equal(v, samples)
        assert set(xr.open_dataset(name, engine=engine, drop_variables="time").coords) == {"channel", "z", "y", "x"}


def test_other_formats(xr, engine, tmp_path):
    cvol.write(tmp_path / "a.nii.gz", make_array((8, 9, 10)), spacing=(3, 2, 1))
    with xr.open_dataset(tmp_path / "a.nii.gz", engine=engine) as ds:
        assert np.array_equal(ds["volume"], make_array((8, 9, 10))) and ds.z[1] == 3
    nibabel = pytest.importorskip("nibabel", reason="nibabel is not installed: a series of NIfTI is not tested")
    run = np.stack([make_array((8, 9, 10)).T + k for k in range(3)], -1)
    nibabel.Nifti1Image(run, np.eye(4)).to_filename(tmp_path / "run.nii")
    with xr.open_dataset(tmp_path / "run.nii", engine=engine) as ds:
        assert ds["volume"].dims == ("time", "z", "y", "x") and np.array_equal(ds["volume"], run.T)
    assert not engine().guess_can_open(tmp_path / "a.nii.gz") and not engine().guess_can_open(3)


def test_chunks_are_bricks(xr, engine, dask, run, path):
    with xr.open_dataset(run[0], engine=engine, chunks={}) as ds:
        assert ds["volume"].chunks == ((1, 1, 1), (1, 1), (20,), (24,), (30,))
        assert float(ds["volume"].mean()) == pytest.approx(run[1].mean())
    a = cvol.open(path).to_dask()
    assert a.chunks == ((70,), (24,), (80,))
    assert dask.from_array(cvol.open(path), chunks=(64, 24, 64)).chunks == ((64, 6), (24,), (64, 16))
    from cvol._dask import chunk_shape

    assert chunk_shape((64, 64, 64), (512, 512, 300), 2) == (512, 256, 256)
    assert chunk_shape((16, 48, 48), (234, 512, 512), 1) == (234, 512, 512)


def test_dask_arrays(dask, path, volume):
    whole = volume.to_numpy()
    for v in (volume, cvol.open(path)):
        a = v.to_dask(chunks=(32, 24, 64))
        assert a.dtype == v.dtype and np.array_equal(a, whole)
        assert np.array_equal((a[::3, 5] * 2).compute(), whole[::3, 5] * 2)
        assert int(a.max()) == whole.max() and float(a.mean()) == pytest.approx(whole.mean())
        assert a.name == v.to_dask(chunks=(32, 24, 64)).name
    assert cvol.open(path).to_dask().name != volume.to_dask().name
    with cvol.open(path) as v:
        a = v.to_dask()
    with pytest.raises(ValueError, match="closed"):
        a.compute()


def test_dask_in_other_processes(dask, path, volume, tmp_path):
    """The program of doc/cluster.md."""
    document = Path(cvol.__file__).resolve().parents[2] / "doc" / "cluster.md"
    if not document.exists():
        pytest.skip("there is no doc/cluster.md: the package is outside its checkout")
    (program,) = re.findall(r"^```python\n(.*?)^```", document.read_text(), re.M | re.S)
    (tmp_path / "work.py").write_text(program.replace("to_dask()", "to_dask(chunks=(64, 24, 64))"))
    (tmp_path / "big.cvol").write_bytes(path.read_bytes())
    run = subprocess.run([sys.executable, "work.py"], env=installed(tmp_path / "site"), cwd=tmp_path, text=True,
                         capture_output=True, timeout=60)  # fmt: skip
    whole = volume.to_numpy()
    expected = f"((64, 6), (24,), (64, 16))\n{(whole > 100).sum()} {whole.mean((1, 2)).argmax()}\n"
    assert run.stdout == expected, run.stderr


def test_xarray_finds_the_backend_of_an_installed_package(xr, path, tmp_path):
    """By its entry point, and by the content of the file."""
    code = "import sys, xarray as xr\nfor e in (None, 'cvol'): print(xr.open_dataset(sys.argv[1], engine=e).sizes)"
    run = subprocess.run([sys.executable, "-c", code, path], env=installed(tmp_path), capture_output=True, text=True,
                         timeout=60)  # fmt: skip
    assert run.stdout.count("'z': 70, 'y': 24, 'x': 80") == 2, run.stdout + run.stderr
