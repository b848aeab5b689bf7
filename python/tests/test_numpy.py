"""Idioms of NumPy with volumes: each gives NumPy's result for the samples, or a clear error."""

import copy
import pickle
import warnings
from concurrent.futures import ThreadPoolExecutor

import cvol
import numpy as np
import pytest
from conftest import make_array

# name: the expression, for an array or a volume a of shape (70, 24, 80). The results must agree.
IDIOMS = {
    "asarray": lambda a: np.asarray(a),
    "asarray of a type": lambda a: np.asarray(a, np.float32),
    "array": lambda a: np.array(a),
    "array of a type": lambda a: np.array(a, dtype="f8"),
    "ascontiguousarray": lambda a: np.ascontiguousarray(a),
    "sum": lambda a: np.sum(a),
    "sum over one axis": lambda a: np.sum(a, axis=1),
    "sum over two axes": lambda a: np.sum(a, axis=(0, -1), keepdims=True),
    "sum in a type": lambda a: np.sum(a, dtype=np.float64),
    "mean": lambda a: np.mean(a),
    "mean of slices": lambda a: np.mean(a, axis=(1, 2)),
    "mean, as a method": lambda a: a.mean(0),
    "min": lambda a: np.min(a),
    "max along z": lambda a: np.max(a, axis=0),
    "maximum projection": lambda a: a.max(axis=0),
    "std": lambda a: np.std(a),
    "std with ddof": lambda a: np.std(a, ddof=1),
    "var": lambda a: np.var(a, axis=2),
    "ptp": lambda a: np.ptp(a),
    "mean where": lambda a: np.mean(a, where=np.asarray(a) > 100),
    "clip": lambda a: np.clip(a, 0, 100),
    "clip, as a method": lambda a: a.clip(0, 100),
    "percentile": lambda a: np.percentile(a, [5, 95]),
    "median": lambda a: np.median(a, axis=0),
    "histogram": lambda a: np.histogram(a, bins=16, range=(-200, 600))[0],
    "argmax": lambda a: np.unravel_index(np.argmax(a), a.shape),
    "unique": lambda a: np.unique(a),
    "count_nonzero": lambda a: np.count_nonzero(a > 300),
    "any and all": lambda a: (np.any(a > 300), np.all(a > 300)),
    "where": lambda a: np.where(a > 300, a, 0),
    "isfinite": lambda a: np.isfinite(a).all(),
    "greater": lambda a: a > 100,
    "equal": lambda a: a == 100,
    "not equal to itself": lambda a: a != a,
    "array_equal": lambda a: np.array_equal(a, np.asarray(a)),
    "allclose": lambda a: np.allclose(a, np.asarray(a)),
    "sqrt": lambda a: np.sqrt(np.abs(a)),
    "abs": lambda a: abs(a),
    "square": lambda a: a**2,
    "remainder": lambda a: a % 7,
    "floor division": lambda a: a // 7,
    "maximum": lambda a: np.maximum(a, 50),
    "add.reduce": lambda a: np.add.reduce(a, axis=0),
    "stack": lambda a: np.stack([a[0], a[1]]),
    "concatenate": lambda a: np.concatenate([a, a], axis=2),
    "pad": lambda a: np.pad(a, 1),
    "flip": lambda a: np.flip(a, 0),
    "transpose": lambda a: np.transpose(a, (2, 0, 1)),
    "T": lambda a: a.T,
    "gradient": lambda a: np.gradient(a, axis=1),
    "diff": lambda a: np.diff(a, axis=0),
    "zeros_like": lambda a: np.zeros_like(a, dtype=np.float32),
    "shape, ndim, size": lambda a: (np.shape(a), np.ndim(a), np.size(a), np.size(a, 1), len(a), a.nbytes),
    "iteration": lambda a: [int(plane.sum()) for plane in a],
    "enumerate": lambda a: [k for k, plane in enumerate(a) if plane.max() > 400],
    "in": lambda a: (100 in a, 30000 in a),
    "negative steps": lambda a: a[::-2, ::-1, 60:10:-7],
    "long steps": lambda a: a[::30, :, ::-25],
    "newaxis": lambda a: a[np.newaxis, 3, ..., None],
    "ellipsis": lambda a: a[..., 5],
    "list": lambda a: a[[3, 60, -1]],
    "list inside": lambda a: a[:, [0, 5], 3],
    "int and list, apart": lambda a: a[2, :, [1, 70]],
    "points": lambda a: a[[0, 69, 3], [1, 2, 3], [79, 4, 4]],
    "open mesh": lambda a: a[np.ix_([0, 69], [3, 1], [79, 0, 40])],
    "mask": lambda a: a[a > 300],
    "mask of an axis": lambda a: a[np.arange(70) % 9 == 0, 2],
    "mask of two axes": lambda a: a[:, np.asarray(a[0]) > 100],
    "empty": lambda a: (a[5:5].shape, a[[]].shape, a[:, 30:].shape),
    "take": lambda a: np.take(a, [1, 5], axis=2),
    "one sample": lambda a: int(a[1, 2, 3]),
    "einsum": lambda a: np.einsum("zyx->z", a),
    "meshgrid of slices": lambda a: a[np.s_[10:12, :2]].tolist(),
}
ERRORS = {
    "beyond the end": (lambda a: a[70], IndexError, "index 70 is out of bounds for axis 0 with size 70"),
    "beyond, in a list": (lambda a: a[:, [24]], IndexError, "index 24 is out of bounds for axis 1 with size 24"),
    "many indices": (lambda a: a[1, 2, 3, 4], IndexError, "too many indices"),
    "a float": (lambda a: a[1.5], IndexError, "only integers, slices"),
    "a mask of another shape": (lambda a: a[np.ones(3, bool)], IndexError, "boolean index did not match"),
    "an axis": (lambda a: np.sum(a, axis=3), getattr(np, "exceptions", np).AxisError, "axis 3 is out of bounds"),
    "truth": (lambda a: bool(a), ValueError, "truth"),
    "a step of 0": (lambda a: a[::0], ValueError, "step cannot be zero"),
}
ERRORS_OF_VOLUMES = {
    "writing": (lambda v: v.__setitem__(0, 1), AttributeError, "__setitem__"),
    "out": (lambda v: np.add(np.zeros(v.shape), 1, out=v), TypeError, "cannot write"),
    "copyto": (lambda v: np.copyto(v, 0), TypeError, "cannot write"),
    "no copy": (lambda v: v.__array__(copy=False), ValueError, "always returns a copy"),
    "an array in a sum": (lambda v: np.ones(v.shape) + v, TypeError, "compress it"),
    "a quotient": (lambda v: 1 / v, TypeError, "to_numpy"),
    "a bool": (lambda v: v[True], IndexError, "one bool"),
}


@pytest.fixture(scope="module")
def exact(array):
    return cvol.compress(array, lossless=True, effort="fast")


def same(got, expected):
    if isinstance(expected, (tuple, list)):
        assert len(got) == len(expected) and all(same(g, e) for g, e in zip(got, expected))
        return True
    assert np.shape(got) == np.shape(expected)
    if isinstance(expected, (np.ndarray, np.generic)):
        assert type(got) is type(expected) and got.dtype == expected.dtype
    if np.asarray(expected).dtype.kind == "f":
        return np.allclose(got, expected, rtol=1e-12, atol=1e-9)
    return np.array_equal(got, expected)


@pytest.mark.parametrize("name", IDIOMS)
def test_idioms_of_a_lossless_volume(exact, array, name):
    assert same(IDIOMS[name](exact), IDIOMS[name](array))


DECODED = [name for name in IDIOMS if name not in ("sum", "sum in a type", "mean", "std", "std with ddof")]


@pytest.mark.parametrize("name", DECODED)
def test_idioms_of_a_lossy_volume(volume, name):
    """They are those of the decoded samples."""
    assert same(IDIOMS[name](volume), IDIOMS[name](volume.to_numpy()))


@pytest.mark.parametrize("name", ERRORS)
def test_errors(exact, array, name):
    idiom, kind, text = ERRORS[name]
    for a in (array, exact):
        with pytest.raises(kind, match=text):
            idiom(a)


@pytest.mark.parametrize("name", ERRORS_OF_VOLUMES)
def test_errors_of_volumes(exact, name):
    idiom, kind, text = ERRORS_OF_VOLUMES[name]
    with pytest.raises(kind, match=text):
        idiom(exact)


def random_part(rng, n):
    """One part of an index, for an axis of n samples; some are beyond its end."""
    parts = [
        lambda: int(rng.integers(-n - 1, n + 1)), lambda: np.int16(rng.integers(-n, n)), lambda: None, lambda: ...,
        lambda: slice(*(None if rng.random() < 0.3 else int(k) for k in rng.integers(-2 * n, 2 * n, 2)),
                      [None, 1, 2, -1, -3, 17, -40, 25][rng.integers(8)]),
        lambda: rng.integers(-n, n, rng.integers(4)).tolist(), lambda: rng.random(n) < 0.1,
        lambda: rng.integers(-n, n, (2, 1)), lambda: slice(None),
    ]  # fmt: skip
    return parts[rng.integers(len(parts))]()


@pytest.mark.parametrize("seed", range(2))
def test_random_indices(exact, array, seed):
    rng = np.random.default_rng(seed)
    right = 0
    for _ in range(300):
        index = tuple(random_part(rng, array.shape[min(k, 2)]) for k in range(rng.integers(1, 6)))
        try:
            expected = array[index]
        except IndexError:
            with pytest.raises(IndexError):
                exact[index]
            continue
        assert same(exact[index], expected), index
        right += 1
    assert right > 150


def test_statistics_of_a_lossy_volume_are_those_of_its_coefficients(volume, array):
    s = volume.stats()
    assert np.mean(volume) == s.mean and abs(s.mean - array.mean()) <= s.mean_error
    assert np.sum(volume) == s.sum and abs(s.sum - array.sum(dtype=float)) <= s.sum_error
    assert np.std(volume) == pytest.approx(s.standard_deviation)
    assert abs(np.std(volume) - array.std()) <= s.standard_deviation_error
    assert np.linalg.norm(volume) == volume.norm()
    assert np.var(volume, ddof=1) == pytest.approx(s.variance * array.size / (array.size - 1))


def test_samples_without_a_value_decode():
    array = make_array((20, 16, 24), "f4")
    array[3, :2] = np.nan
    v = cvol.compress(array, psnr=50, fill=np.nan)
    assert np.isnan(np.mean(v)) and np.isnan(np.max(v))
    assert np.nanmean(v) == pytest.approx(np.nanmean(array), abs=0.5)


@pytest.mark.parametrize("others", [(), (np.nan,), (np.nan, -np.inf)])
def test_marks_of_missing_samples(others, tmp_path):
    """A value far from all others has no value, as in the command, also next to NaN."""
    array = make_array((20, 16, 24), "f4")
    array[3, :2] = np.float32(1e35)
    for i, value in enumerate(others):
        array[9, 0, i] = value
    missing = ~(np.abs(array) < 1e30)
    np.save(tmp_path / "a.npy", array)
    with pytest.warns(UserWarning, match=r"samples of 1e\+35, far from all others, are treated as missing"):
        v = cvol.compress(array, psnr=50)
    for volume in v, cvol.compress(array, psnr=50, fill=1e35), cvol.open(tmp_path / "a.npy", compress={"psnr": 50}):
        back = volume.to_numpy()
        assert np.array_equal(back[missing], array[missing], equal_nan=True)
        assert np.abs(back - array, where=~missing, out=np.zeros_like(array)).max() < np.ptp(array[~missing]) / 50
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        assert np.array_equal(cvol.compress(array, lossless=True).to_numpy(), array, equal_nan=True)


def test_arithmetic_of_ufuncs_stays_compressed(volume):
    for v in (np.add(volume, 1), np.multiply(2, volume), np.subtract(volume, volume), np.negative(volume),
              np.float32(2) * volume, np.array(2) * volume, np.true_divide(volume, 4)):  # fmt: skip
        assert isinstance(v, cvol.Volume) and v.shape == volume.shape


@pytest.mark.parametrize("dtype", [np.int64, np.uint64, np.bool_, np.float16])
def test_types_that_become_others(dtype):
    array = (make_array((16, 16, 16)) % 2000).astype(dtype)
    v = cvol.compress(array, lossless=True)
    assert np.array_equal(v.to_numpy().astype(dtype), array)
    assert v.dtype == {np.int64: np.int32, np.uint64: np.int32, np.bool_: np.uint8, np.float16: np.float32}[dtype]


def test_integers_that_do_not_fit():
    array = np.arange(512).reshape(8, 8, 8)
    assert cvol.compress(array + 2**31, lossless=True).dtype == np.uint32
    with pytest.raises(cvol.DataError, match="int64 from 4294967296 to 4294967807, which neither int32 nor uint32"):
        cvol.compress(array + 2**32)
    with pytest.raises(cvol.DataError, match="from -1 to 4294967295"):
        cvol.compress(np.where(array > 0, 2**32 - 1, -1))
    with pytest.raises(TypeError, match="complex128"):
        cvol.compress(array.astype(complex))


def test_properties(volume, path, array):
    for v in (volume, cvol.open(path)):
        assert v.chunks == (64, 24, 64) and v.attrs == {"of": "a test"}
        assert np.allclose(v.affine @ [1, 1, 1, 1], [0.5, 1, 2, 1])
        assert np.allclose(v.geometry.nibabel_affine() @ [3, 2, 1, 1], [1.5, 2, 2, 1])
        assert [level.shape for level in v.levels] == [(70, 24, 80), (35, 12, 40), (18, 6, 20), (9, 3, 10)]
        level = v.levels[1]
        assert level.dtype == v.dtype and level.chunks == (32, 12, 32) and level.spacing == (4, 2, 1)
        assert np.allclose(level.affine @ [0, 0, 0, 1], v.affine @ [0.5, 0.5, 0.5, 1])
        assert np.abs(level[...] - array.reshape(35, 2, 12, 2, 40, 2).mean((1, 3, 5))).std() < 8
        assert np.array_equal(level[3, ::-1, [2, 30]], np.asarray(level)[3, ::-1, [2, 30]])
    v.close()
    with pytest.raises(ValueError, match="closed"):
        v.levels[1][0]


@pytest.mark.parametrize("options", [{"psnr": 60}, {"lossless": True}, {"psnr": 60, "fill": 0.0}])
def test_deviation_far_from_zero(array, options):
    far = 1e9 + array / 1000
    assert np.std(cvol.compress(far, **options)) == pytest.approx(np.std(far), rel=1e-3)


def test_levels_of_a_lossless_file(exact, array, tmp_path):
    exact.save(tmp_path / "exact.cvol")
    means = array[:70, :24].reshape(35, 2, 12, 2, 40, 2).mean((1, 3, 5))
    assert np.abs(cvol.open(tmp_path / "exact.cvol").levels[1][...] - means).max() <= 0.51


def test_pickles(volume, path, tmp_path):
    samples = volume.to_numpy()
    assert np.array_equal(pickle.loads(pickle.dumps(volume)), samples)
    by_path = pickle.dumps(cvol.open(path))
    assert len(by_path) < 1000 and np.array_equal(pickle.loads(by_path)[5], samples[5])
    assert pickle.loads(by_path).attributes == {"of": "a test"}
    other = cvol.open(path)
    other.attributes = {"of": "another"}
    assert pickle.loads(pickle.dumps(other)).attributes == copy.copy(other).attributes == {"of": "another"}
    moved = tmp_path / "moved.cvol"
    moved.write_bytes(path.read_bytes())
    by_path = pickle.dumps(cvol.open(moved))
    cvol.transcode(volume, 40).save(moved)
    with pytest.raises(cvol.Error, match="was changed after the volume was pickled"):
        pickle.loads(by_path)
    with cvol.open(path) as closed:
        pass
    with pytest.raises(ValueError, match="closed"):
        pickle.dumps(closed)


def test_threads_that_read_different_bricks(array, tmp_path):
    """Each replaces the bricks that others use."""
    volume = cvol.compress(array, 20, effort="fast", bricks=16)
    volume.save(tmp_path / "bricks.cvol")
    whole = volume.to_numpy()
    jobs = [np.s_[k % 70, :, (13 * k) % 80] for k in range(400)]
    with cvol.open(tmp_path / "bricks.cvol") as v, ThreadPoolExecutor(8) as pool:
        assert all(np.array_equal(got, whole[job]) for job, got in zip(jobs, pool.map(v.__getitem__, jobs)))


def test_threads_share_a_volume(path, volume):
    whole = volume.to_numpy()
    jobs = [np.s_[k : k + 9, ::-1, [3, 70]] for k in range(40)]
    with cvol.open(path) as v, ThreadPoolExecutor(8) as pool:
        for job, got in zip(jobs, pool.map(v.__getitem__, jobs)):
            assert np.array_equal(got, whole[job])
        assert len(set(pool.map(lambda _: float(np.mean(v)), range(16)))) == 1
        expected = v.levels[2][...]
        assert all(np.array_equal(got, expected) for got in pool.map(lambda _: v.levels[2][...], range(8)))
