"""Compressing, opening, slicing, closing; compared with NumPy on the decoded samples."""

import importlib.util
import itertools
import math
import os
import signal
import threading
import warnings
from pathlib import Path

import cvol
import numpy as np
import pytest
from conftest import make_array


@pytest.mark.parametrize("dtype", ["u1", "i1", "u2", "i2", "u4", "i4", "f4", "f8", ">i2"])
def test_lossless_round_trip(dtype):
    array = make_array((17, 20, 33), "i1").astype(dtype)
    volume = cvol.compress(array, lossless=True)
    back = volume.to_numpy()
    assert back.dtype == np.dtype(dtype).newbyteorder("=")
    assert np.array_equal(back, array)
    assert volume.info.max_error == 0


def test_max_error_zero_with_a_psnr_is_lossless(array):
    few = array[:20, :20, :20]
    volume = cvol.compress(few, psnr=30, max_error=0)
    assert volume.info.exact and np.array_equal(volume.to_numpy(), few)
    for options in ({"max_error": 0}, {"max_error": 2}):
        with pytest.raises(ValueError, match="max_error, bits and lossless need three axes"):
            cvol.compress(few[0], psnr=30, **options)


def test_constant_arrays():
    for constant in (np.full((64, 64), 7, np.int16), np.full(50, -3.5, "f4"), np.array([3.0]), np.full((3, 4, 5), 9)):
        for options in ({"psnr": 40}, {"psnr": 40, "transform": "dft"}, {"psnr": 40, "block": 0}):
            volume = cvol.compress(constant, **options)
            assert volume.info.exact and np.array_equal(volume.to_numpy(), constant), options
    with pytest.warns(UserWarning, match="compressed to 35 dB instead"):  # too few samples for the ratio
        assert np.array_equal(cvol.compress([3.0]).to_numpy(), [3.0])
    with pytest.raises(ValueError, match="the array has 0 axes, must have 1 to 4"):
        cvol.compress(5)


def test_spacing_of_read_is_positive(tmp_path, array):
    path = tmp_path / "a.npy"
    np.save(path, array[:3])
    assert cvol.read(path, spacing=(3, 2, 1))[1].spacing == (3, 2, 1)
    for spacing in ((0, 2, 3), (1, 2, 0), (1, -1, 1), (1, math.inf, 1), (1, 2), 0):
        with pytest.raises(cvol.ArgumentError, match="spacing is .*, must be three numbers above 0"):
            cvol.read(path, spacing=spacing)


def test_geometry_fits_the_array(array):
    few, G = array[:4, :5, :6], cvol.Geometry
    for wrong, samples, words in (
        (G(spacing=(3, 4)), few, "spacing of 2 axes, and the array has 3"),
        (G(spacing=(3, 4, 5)), few[0].astype("f4"), "spacing of 3 axes, and the array has 2"),
        (G(direction=np.zeros((3, 3))), few, "unit vectors"),
        (G(direction=5 * np.eye(3)), few, "unit vectors"),
        (G(direction=np.eye(3)[:2]), few, r"shape \(2, 3\), must be a vector \(X, Y, Z\) for each of 3 axes"),
        (G(direction=[[1, 0], [0, 1], [1, 1]]), few, r"shape \(3, 2\)"),
    ):
        with pytest.raises(cvol.ArgumentError, match=words):
            cvol.compress(samples, psnr=40, geometry=wrong)
    with pytest.raises(TypeError, match="must be a cvol.Geometry"):
        cvol.compress(few, psnr=40, geometry=3)
    with pytest.raises(TypeError, match="must be a cvol.Volume"):
        cvol.transcode(3, 40)
    plane = cvol.compress(few[0].astype("f4"), psnr=40, geometry=G(spacing=(3, 4), direction=np.eye(3)[:2]))
    assert plane.spacing == (3, 4)
    assert cvol.compress(few[0].astype("f4"), psnr=40, geometry=G(unit="mm")).spacing == (1, 1)
    turned = G(spacing=(3, 4, 5), direction=np.eye(3)[[1, 0, 2]])
    assert np.allclose(cvol.compress(few, psnr=40, geometry=turned).affine, turned.affine())


def test_a_size_out_of_reach_is_a_warning(array):
    few, (z, y, x) = array[:16, :16, :20], np.ogrid[:32, :30, :30]
    smooth = np.sin(x / 7.3) * np.cos(y / 5.1) + np.cos(z / 9.7)
    with pytest.warns(UserWarning, match=r"ratio 100000 is out of reach: this is the smallest .*, 1/\d+"):
        cvol.compress(few, ratio=100000, force=True)
    with pytest.warns(UserWarning, match="0.0001 bits a sample is out of reach: this is the smallest"):
        cvol.transcode(cvol.compress(few, psnr=40), bits=0.0001, force=True)
    with pytest.warns(UserWarning, match="20 bits a sample is out of reach: the finest lossy volume is smaller"):
        volume = cvol.compress(smooth, bits=20)
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        cvol.compress(few, ratio=8, force=True)
        cvol.compress(few, psnr=40), cvol.compress(np.zeros((3, 4, 5)), lossless=True)
    assert not volume.info.exact


def test_a_size_counts_attributes(tmp_path, array):
    path, text = str(tmp_path / "a.cvol"), "".join(np.random.default_rng(3).choice(list("abcdefgh"), 2000))
    volume = cvol.compress(array, bits=1.5, attributes={"text": text}, force=True)
    volume.save(path)
    assert volume.attributes == cvol.open(path).attributes == {"text": text}
    assert os.path.getsize(path) <= 1.5 * array.size / 8


def test_what_it_is(array, volume, path):
    for v in (volume, cvol.open(path)):
        assert v.shape == array.shape == (70, 24, 80) and len(v) == 70 and v.ndim == 3
        assert v.size == array.size and v.nbytes == array.nbytes and v.dtype == np.int16
        assert v.spacing == (2.0, 1.0, 0.5)
        assert v.attributes == {"of": "a test"}
        assert "70 x 24 x 80 int16" in repr(v)
    error = volume.to_numpy().astype(float) - array
    assert 0 < np.sqrt((error**2).sum()) <= volume.error_bound * 1.02 + np.sqrt(array.size) / 2
    assert np.abs(error).max() == volume.info.max_error
    assert np.abs(error).max() - 0.5 <= volume.sample_error_bound < volume.error_bound / 10
    assert os.path.getsize(path) <= array.nbytes / 20 * 1.02 + 100


INDICES = [
    np.s_[10:20, :, 5], np.s_[3], np.s_[-1, ..., 0], np.s_[..., -1], np.s_[::-7, 5:20:9, ::-1], np.s_[4, 5, 6],
    np.s_[5:5], np.s_[60:70, 20:, 60:70], np.s_[...], np.s_[100:], np.s_[:, 7:1:-2], np.s_[np.int64(2), 0:1],
    np.s_[:, :, 64:65:3], np.s_[69::-68], None, [1, 2], (None, 3, [[0], [5]], slice(None, None, -20)),
]  # fmt: skip


@pytest.mark.parametrize("index", INDICES, ids=str)
def test_slices_are_numpys(volume, path, index):
    whole = volume.to_numpy()
    for v in (volume, cvol.open(path)):
        got = v[index]
        assert np.shape(got) == np.shape(whole[index]) and got.dtype == whole.dtype
        assert np.array_equal(got, whole[index])
        real = np.clip(v.evaluate(index), volume.info.value_min, volume.info.value_max)
        assert np.allclose(real, got, atol=0.51)


REFUSED = [(1, 2, 3, 4), 70, -71, [70], (0, [-25]), np.array([True]), 1.5, (..., ...), "a", True]


@pytest.mark.parametrize("index", REFUSED)
def test_other_indices_are_refused(volume, index):
    with pytest.raises(IndexError):
        volume[index]


def test_random_slices(volume, path):
    rng = np.random.default_rng(5)
    whole, opened = volume.to_numpy(), cvol.open(path)
    for _ in range(60):
        index = tuple(
            slice(*sorted(rng.integers(-n, 2 * n, 2).tolist()), int(rng.integers(1, 9))) for n in whole.shape
        )
        assert np.array_equal(opened[index], whole[index]), index


def test_bricks(tmp_path, array):
    volume = cvol.compress(array, 20, effort="fast", bricks=(32, 16, 48))
    assert volume.info.bricks == (32, 16, 48)
    volume.save(tmp_path / "b.cvol")
    whole, opened = volume.to_numpy(), cvol.open(tmp_path / "b.cvol")
    for k in (0, 15, 16, 31, 32, 63, 69):
        assert np.array_equal(opened[k], whole[k])
        assert np.array_equal(opened[:, k % 24], whole[:, k % 24])
        assert np.array_equal(opened[:, :, k], whole[:, :, k])
    assert cvol.transcode(volume, 50).info.bricks == (32, 16, 48)
    assert cvol.transcode(volume, 50, bricks=16).info.bricks == (16, 16, 16)
    assert cvol.compress(array, 20, effort="fast").info.bricks == (64, 64, 64)
    for bricks in (17, 0, (16, 16), (16, 16, 128)):
        with pytest.raises(ValueError, match="bricks are"):
            cvol.compress(array, bricks=bricks)
    with pytest.raises(ValueError, match="DCT blocks"):
        cvol.compress(array, keep=cvol.Keep.all(), bricks=32)


def left_for_plane(data, axis, k):
    """Returns the file with zeros in the shells, except in the bricks that hold sample k of an axis (x: 0) or touch it
    through filters; also the remaining shares of bytes and of samples. Parses the file as doc/decoder_ref.py does."""
    reference = Path(__file__).resolve().parents[2] / "doc" / "decoder_ref.py"
    spec = importlib.util.spec_from_file_location("decoder_ref", reference)
    ref = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(ref)
    sections = ref.read_sections(data, "ENDS")
    header = ref.Header(*(sections[tag][0] for tag in ("HEAD", "GEOM", "ERRS")))
    sides, run = ref.read_shape(header, sections["BRKS"][0])
    assert run == 1 and "MASK" not in sections and "CORR" not in sections
    grid = [-(-n // side) for n, side in zip(header.dims, sides)]
    lengths, _ = ref.read_index(sections["INDX"][0], math.prod(grid), run, 0)
    first, last = max(k - 2, 0) // sides[axis], (k + 2) // sides[axis]
    kept, gone = bytearray(data), 0
    for shell, tag in enumerate(ref.SHELLS):
        at = data.index(sections[tag][0])
        for brick, place in enumerate(itertools.product(*map(range, reversed(grid)))):
            if brick > 0 and not first <= place[2 - axis] <= last:  # opening reads the first brick
                kept[at : at + lengths[shell][brick]] = bytes(lengths[shell][brick])
                gone += lengths[shell][brick]
            at += lengths[shell][brick]
    return bytes(kept), 1 - gone / len(data), (last + 1 - first) * sides[axis] / header.dims[axis]


def test_planes_of_a_large_volume(tmp_path):
    """Reading a plane uses less than an eighth of a file compressed to a ratio. It reads no other byte, because
    their checksums are wrong."""
    cube = make_array((117, 128, 128))
    array = np.tile(np.concatenate([cube, cube[::-1]]), (1, 4, 4))
    assert array.shape == (234, 512, 512)
    volume = cvol.compress(array, effort="fast")
    assert volume.info.bricks == (16, 48, 48)
    path = tmp_path / "large.cvol"
    volume.save(path)
    data = path.read_bytes()
    with cvol.open(path) as v:
        planes = [v[100], v[:, 100], v[:, :, 100]]
    for axis in range(3):
        kept, share, samples = left_for_plane(data, 2 - axis, 100)
        assert share < 1 / 8 and samples < 1 / 8
        path.write_bytes(kept)
        with cvol.open(path) as v:
            assert np.array_equal(v[(slice(None),) * axis + (100,)], planes[axis])
            with pytest.raises(cvol.Error, match="damaged"):
                v[(slice(None),) * axis + (160,)]


def test_ranks_and_transforms():
    for shape in ((300,), (40, 50), (12, 20, 16)):
        array = np.cumsum(np.random.default_rng(1).normal(size=shape), axis=-1).astype("f4")
        for transform, block in (("dct", 0), ("dht", 16), ("dft", 0)):
            volume = cvol.compress(array, keep=cvol.Keep.all(), transform=transform, block=block, spacing=2)
            assert volume.shape == shape and volume.spacing == (2.0,) * len(shape)
            assert (volume.info.transform, volume.info.block) == (transform, block)
            assert np.allclose(volume.to_numpy(), array, atol=1e-3)
            assert np.allclose(volume[..., 3:7], array[..., 3:7], atol=1e-3)
            point = [n // 2 for n in shape]
            assert np.allclose(volume.evaluate_points([point]), array[tuple(point)], atol=1e-3)


def test_values_between_samples(array):
    volume = cvol.compress(array.astype("f4"), keep=cvol.Keep.all(), block=0)
    points = np.array([[3, 20, 20], [60, 2, 70]], float)
    assert np.allclose(volume.evaluate_points(points), [array[3, 20, 20], array[60, 2, 70]], atol=0.5)


def test_fill_and_mask():
    array = make_array((40, 40, 40), "f4")
    array[:10] = np.nan
    volume = cvol.compress(array, psnr=50, fill=np.nan)
    assert np.array_equal(np.isnan(volume.to_numpy()), np.isnan(array))
    assert np.array_equal(volume.mask(np.s_[8:12, 0]), np.isnan(array[8:12, 0]))
    assert np.array_equal(np.isnan(volume.evaluate()), np.isnan(array))
    assert np.array_equal(np.isnan(cvol.compress(array, lossless=True).evaluate()), np.isnan(array))


@pytest.mark.parametrize("kind, fill", [("f4", np.nan), ("f4", 1e35), ("i2", -9999)])
def test_fill_in_levels(kind, fill):
    array = make_array((40, 40, 37), kind)
    missing = np.zeros(array.shape, bool)
    missing[:10, 3:] = missing[20, 20, 20] = missing[:, :, 36] = True
    array[missing] = fill
    level = cvol.compress(array, psnr=50, fill=fill).levels[1]
    parts = np.pad(np.where(missing, np.nan, array), [(0, 0), (0, 0), (0, 1)], constant_values=np.nan)
    parts = parts.reshape(20, 2, 20, 2, 19, 2)
    none = np.isnan(parts).all(axis=(1, 3, 5))
    got = level[...]
    assert none.sum() > 1000 and np.array_equal(got[none], np.full(none.sum(), fill, kind), equal_nan=kind == "f4")
    means = np.nansum(parts, axis=(1, 3, 5)) / np.maximum((~np.isnan(parts)).sum(axis=(1, 3, 5)), 1)
    assert np.abs(got[~none] - means[~none]).max() < 10
    assert np.array_equal(level[3:9, 5], got[3:9, 5], equal_nan=kind == "f4")


def test_geometry(tmp_path):
    place = cvol.Geometry(
        spacing=(3, 2, 1), origin=(10, 20, 30), direction=((0, 0, 1), (0, -1, 0), (1, 0, 0)), space="LPS", unit="mm"
    )
    array = make_array((9, 10, 11))
    volume = cvol.compress(array, lossless=True, geometry=place)
    assert volume.geometry == cvol.Geometry(
        (3.0, 2.0, 1.0), (10.0, 20.0, 30.0), ((0.0, 0.0, 1.0), (0.0, -1.0, 0.0), (1.0, 0.0, 0.0)), "LPS", "mm"
    )
    assert np.allclose(place.affine() @ [1, 1, 1, 1], [11, 18, 33, 1])
    cvol.write(tmp_path / "a.nrrd", volume)
    samples, read = cvol.read(tmp_path / "a.nrrd")
    assert np.array_equal(samples, array) and np.allclose(read.affine(), place.affine())
    samples.tofile(tmp_path / "a.raw")
    again, _ = cvol.read(tmp_path / "a.raw", shape=(9, 10, 11), dtype="i2")
    assert np.array_equal(again, array)


def test_closed(path):
    with cvol.open(path) as v:
        part, renderer = v[:5], cvol.Renderer(v)
    assert v.closed and part.sum() is not None and "closed" in repr(v)
    assert renderer.render(size=16).shape == (16, 16, 3)
    renderer.close()
    calls = [
        lambda: v[0], lambda: v.to_numpy(), lambda: v + 1, lambda: v + v, lambda: v.stats(), lambda: v.info,
        lambda: v.render(), lambda: v.save("x.cvol"), lambda: v.evaluate(), lambda: v.mask(),
        lambda: v.convolve("box:3"), lambda: renderer.render(), lambda: cvol.Renderer(v), lambda: v[5:5],
    ]  # fmt: skip
    for call in calls:
        with pytest.raises(ValueError, match="closed"):
            call()
    v.close()
    assert v.shape == (70, 24, 80)


def test_errors(tmp_path, array, path):
    with pytest.raises(FileNotFoundError, match="nix.cvol"):
        cvol.open(tmp_path / "nix.cvol")
    (tmp_path / "bad.cvol").write_bytes(path.read_bytes()[:-500])
    with pytest.raises(cvol.CorruptError, match="bad.cvol"):
        cvol.open(tmp_path / "bad.cvol").to_numpy()
    (tmp_path / "text.cvol").write_text("no volume")
    with pytest.raises(cvol.FormatError, match="is not a .cvol file"):
        cvol.open(tmp_path / "text.cvol")
    with pytest.raises(cvol.DataError, match="infinite"):
        cvol.compress(np.full((4, 4, 4), np.inf))
    with pytest.raises(cvol.DataError, match="int64"):
        cvol.compress(array.astype(np.int64) << 40)
    with pytest.raises(TypeError, match="cvol.read"):
        cvol.compress(str(tmp_path / "text.cvol"))
    with pytest.raises(cvol.TargetError, match="4096 samples take .* of ratio"):
        cvol.compress(np.zeros((64, 64), np.uint8), 30)
    with pytest.raises(ValueError, match="only one of"):
        cvol.compress(array, 3, psnr=40)
    with pytest.raises(ValueError, match="5 axes, must have 1 to 4"):
        cvol.compress(np.zeros((1, 1, 1, 1, 1)))
    with pytest.raises(ValueError, match="must have at least one sample"):
        cvol.compress(np.zeros((0, 4, 4)))
    with pytest.raises(cvol.FileError):
        cvol.compress(array[:20], effort="fast").save(tmp_path / "no folder" / "x.cvol")
    with cvol.options(memory_limit=1000), pytest.raises(MemoryError):
        cvol.open(path)
    (tmp_path / "other.raw").write_bytes(bytes(8))
    header = tmp_path / "header.nhdr"
    header.write_text("NRRD0004\ntype: uint8\ndimension: 3\nsizes: 2 2 2\nencoding: raw\ndata file: other.raw\n")
    assert cvol.read(header)[0].shape == (2, 2, 2)
    with cvol.options(external=False), pytest.raises(cvol.UnsupportedError, match="other files may not be opened"):
        cvol.read(header)


def test_a_file_that_changes(tmp_path, array, path):
    name = tmp_path / "v.cvol"
    name.write_bytes(path.read_bytes())
    v = cvol.open(name)
    v[0]
    cvol.compress(array[:66], 20, effort="fast").save(name)
    with pytest.raises(cvol.Error, match="was changed"):
        v[66:]


def test_wrong_types_are_named(array, path):
    v = cvol.open(path)
    for name in ("ratio", "psnr", "max_error", "bits", "fill", "background", "spacing", "block"):
        with pytest.raises((TypeError, ValueError), match=f"{name} is .x.*must be"):
            cvol.compress(array, **{name: "x"})
    for name in ("azimuth", "zoom", "window"):
        with pytest.raises(TypeError, match=f"{name} is .x., must be"):
            v.render(size=16, **{name: "x"})
    with pytest.raises(TypeError, match="'x' is no argument of cvol_array_scale: it must be a number"):
        v.scale("x", 0)

    class Image:
        dataobj, ndim = array, array.ndim

    with pytest.raises(TypeError, match="image.dataobj"):
        cvol.compress(Image())


def test_progress_cancels_and_raises(array):
    reports = []
    cvol.compress(array, effort="fast", progress=lambda what, share: reports.append((what, share)))
    assert reports and all(isinstance(what, str) and 0 <= share <= 1 for what, share in reports)
    with pytest.raises(cvol.Cancelled):
        cvol.compress(array, effort="fast", progress=lambda what, share: True)

    def fail(what, share):
        raise ZeroDivisionError("mine")

    with pytest.raises(ZeroDivisionError, match="mine"):
        cvol.compress(array, effort="fast", progress=fail)


def test_ctrl_c(array):
    before = signal.getsignal(signal.SIGINT)
    with pytest.raises(KeyboardInterrupt):
        cvol.compress(array, effort="fast", progress=lambda what, share: signal.raise_signal(signal.SIGINT))
    assert signal.getsignal(signal.SIGINT) is before


def test_ctrl_c_in_nested_calls(array):
    """A callback compresses: Ctrl-C stops that compression at its next report, not at its end."""
    before = signal.getsignal(signal.SIGINT)
    reports = {"inner": 0, "outer": 0}

    def inner(what, share):
        reports["inner"] += 1
        if reports["inner"] == 1:
            os.kill(os.getpid(), signal.SIGINT)

    def outer(what, share):
        reports["outer"] += 1
        cvol.compress(array, effort="fast", progress=inner)

    with pytest.raises(KeyboardInterrupt):
        cvol.compress(array, effort="fast", progress=outer)
    assert reports == {"inner": 1, "outer": 1}
    assert signal.getsignal(signal.SIGINT) is before
    cvol.compress(array, effort="fast")  # no flag remains


def test_progress_function_may_compress(array):
    """Calls of the function itself do not report to it: it would call itself without end."""
    calls = []

    def compress_again(what, share):
        calls.append(what)
        if len(calls) > 1000:
            raise AssertionError("the function calls itself")
        if len(calls) < 3:
            assert cvol.compress(array[:8], effort="fast").shape == array[:8].shape

    cvol.compress(array, effort="fast", progress=compress_again)
    assert 3 <= len(calls) <= 1000


def test_threads(path):
    """Several threads slice while one closes the volume."""
    v = cvol.open(path)
    whole = v.to_numpy()
    wrong = []

    def work(seed):
        rng = np.random.default_rng(seed)
        try:
            for _ in range(30):
                z = int(rng.integers(0, 70))
                if not np.array_equal(v[z], whole[z]):
                    wrong.append(z)
        except ValueError as error:
            if "closed" not in str(error):
                wrong.append(error)

    threads = [threading.Thread(target=work, args=(i,)) for i in range(4)]
    for thread in threads:
        thread.start()
    v.close()
    for thread in threads:
        thread.join()
    assert not wrong
    assert v.closed


@pytest.mark.skipif(not hasattr(os, "fork"), reason="no fork")
def test_children_that_are_forked(path):
    """A child process reads and renders after its parent did; earlier versions hung."""
    volume = cvol.open(path)
    expected = volume[3:40].copy()
    volume.render(size=64)
    for _ in range(3):
        child = os.fork()
        if not child:
            signal.signal(signal.SIGALRM, signal.SIG_DFL)
            signal.alarm(60)
            status = 1
            try:
                same = np.array_equal(volume[3:40], expected) and np.array_equal(cvol.open(path)[3:40], expected)
                volume.render(size=64)
                status = 0 if same else 2
            finally:
                os._exit(status)
        assert os.waitstatus_to_exitcode(os.waitpid(child, 0)[1]) == 0
        assert np.array_equal(volume[3:40], expected)
