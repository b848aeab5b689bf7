"""Codec "cvol" with the installed numcodecs and Zarr."""

import json
import subprocess
import sys

import cvol
import numpy as np
import pytest
from conftest import installed, make_array

numcodecs = pytest.importorskip("numcodecs", reason="numcodecs is not installed: the codec is not tested")
from cvol.codecs import Cvol  # noqa: E402

TYPES = ["?", "i1", "u2", "i4", "i8", "u8", "f2", "f4", "f8", ">i2", ">f4"]
SHAPES = [(), (7,), (5, 9), (2, 6, 7), (2, 3, 4, 5), (2, 1, 3, 4, 5), (3, 0, 4)]


@pytest.fixture(scope="module")
def zarr():
    return pytest.importorskip("zarr", reason="zarr is not installed: its arrays are not tested")


@pytest.mark.parametrize("dtype", TYPES)
def test_every_type_and_shape_comes_back(dtype):
    for shape in SHAPES:
        chunk = (np.arange(np.prod(shape, dtype=int)) % 100).reshape(shape).astype(dtype)
        for ordered in (chunk, np.array(chunk, order="F")) if dtype in ("i4", ">i2", "f8") else (chunk,):
            back = Cvol().decode(Cvol(effort="fast").encode(ordered))
            assert back.dtype == chunk.dtype and back.shape == shape and np.array_equal(back, chunk)
            assert back.ravel("A").tobytes() == ordered.ravel("A").tobytes()


def test_a_chunk_of_three_axes_is_a_file(array, tmp_path):
    data = Cvol(max_error=5).encode(array)
    (tmp_path / "chunk.cvol").write_bytes(data)
    with cvol.open(tmp_path / "chunk.cvol") as v:
        assert v.shape == array.shape and v.info.max_error <= 5


def test_targets(array):
    array = array[:40]
    difference = lambda codec: Cvol().decode(codec.encode(array)).astype(float) - array  # noqa: E731
    assert np.abs(difference(Cvol(max_error=6))).max() <= 6
    assert 20 * np.log10(np.ptp(array) / difference(Cvol(psnr=40)).std()) >= 39.99
    assert array.nbytes / len(Cvol(ratio=12).encode(array)) >= 12
    assert len(Cvol(max_error=6).encode(array)) * 2 < len(numcodecs.Blosc("zstd").encode(array))
    series = np.stack([array, array[::-1]])
    assert np.abs(Cvol().decode(Cvol(max_error=6).encode(series)).astype(float) - series).max() <= 6


def test_chunks_that_miss_their_target():
    noise = np.random.default_rng(1).integers(0, 2000, (16, 16, 16)).astype("u2")
    back = Cvol().decode(Cvol(ratio=50).encode(noise)).astype(float)
    assert 20 * np.log10(2000 / np.sqrt(np.mean((back - noise) ** 2))) > 34.9
    holes = make_array((16, 16, 16), "f4")
    holes[:3], holes[5, 5, 5] = np.nan, np.inf
    assert np.array_equal(np.isfinite(Cvol().decode(Cvol(psnr=45).encode(holes))), np.isfinite(holes))
    assert np.array_equal(Cvol().decode(Cvol(ratio=9).encode(np.full((4, 4, 4), 7, "u1"))), np.full((4, 4, 4), 7))


def test_out(array):
    data = Cvol().encode(array)
    for out in (np.empty_like(array), np.empty(array.size, "i2"), np.empty(array.nbytes, "u1"),
                np.empty_like(array, order="F")):  # fmt: skip
        assert Cvol().decode(data, out) is out and out.ravel("K").nbytes == array.nbytes
        got = out if out.shape == array.shape else out.view("i2").reshape(array.shape)
        assert np.array_equal(got, array)
    with pytest.raises(ValueError, match="out has 10 bytes"):
        Cvol().decode(data, np.empty(10, "u1"))


def test_options():
    assert Cvol().get_config() == {"id": "cvol", "lossless": True}
    assert Cvol(psnr=40, effort="fast").get_config() == {"id": "cvol", "psnr": 40, "effort": "fast"}
    for codec in (Cvol(), Cvol(ratio=20), Cvol(max_error=0.5, effort="fast")):
        assert numcodecs.get_codec(codec.get_config()) == codec and repr(eval(repr(codec))) == repr(codec)
    for options in ({"ratio": 3, "psnr": 40}, {"psnr": float("nan")}, {"max_error": -1}, {"effort": "none"}):
        with pytest.raises(ValueError):
            Cvol(**options)


def test_what_it_refuses(array):
    for chunk in (np.array(["a"]), np.zeros(3, complex), np.zeros(3, "M8[s]")):
        with pytest.raises(TypeError, match="cvol compresses bool, integers, and floats"):
            Cvol().encode(chunk)
    with pytest.raises(cvol.DataError, match="neither int32 nor uint32"):
        Cvol().encode(np.array([2**40]))
    data = Cvol().encode(np.stack([array[:9, :9, :9]] * 2))
    for k in (*range(0, 60), 200, len(data) - 1):
        damaged = bytearray(data)
        damaged[k] ^= 0x55
        with pytest.raises(cvol.FormatError):
            Cvol().decode(damaged)
        with pytest.raises(cvol.FormatError):
            Cvol().decode(data[:k])
    with pytest.raises(cvol.FormatError, match="not one that cvol made"):
        Cvol().decode(b"")


@pytest.mark.parametrize("order", ["C", "F"])
def test_zarr_arrays(zarr, array, tmp_path, order):
    array = array[:48]
    name = str(tmp_path / "a.zarr")
    zarr.array(array, store=name, chunks=(32, 24, 48), order=order, compressor=Cvol(max_error=4, effort="fast"))
    z = zarr.open(name, "r")
    codec = {"id": "cvol", "max_error": 4, "effort": "fast"}
    assert json.loads((tmp_path / "a.zarr" / ".zarray").read_text())["compressor"] == codec
    whole = z[:].astype(int)
    assert 0 < np.abs(whole - array).max() <= 4 and z.nbytes_stored < array.nbytes / 2
    assert np.array_equal(z[10:40, 3, ::5], whole[10:40, 3, ::5])
    series = zarr.array(np.stack([array[:20]] * 3)[:, None], chunks=(2, 1, 20, 24, 80), compressor=Cvol(), order=order)
    assert np.array_equal(series[2, 0], array[:20]) and np.array_equal(series[:, 0, 3], [array[3]] * 3)


def test_numcodecs_finds_the_codec_of_an_installed_package(tmp_path):
    """By its entry point, without an import of cvol."""
    code = "import numcodecs; print(numcodecs.get_codec({'id': 'cvol', 'psnr': 40}))"
    run = subprocess.run([sys.executable, "-c", code], env=installed(tmp_path), capture_output=True, text=True,
                         timeout=60)  # fmt: skip
    assert run.stdout == "Cvol(psnr=40)\n", run.stderr
