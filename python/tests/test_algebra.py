"""Operations against NumPy on the original samples, within the certified bound."""

import math

import cvol
import numpy as np
import pytest


@pytest.fixture(scope="module")
def pair(array):
    a = array[:32, :24, :48].astype("f4")
    b = np.roll(a, 5, axis=2) / 100 + 2
    return a, b, cvol.compress(a, 8, lap=False), cvol.compress(b, 8, lap=False)


def check(result, exact):
    error = np.sqrt(((result.evaluate().astype(float) - exact) ** 2).sum())
    assert error <= result.error_bound * (1 + 1e-6) + 1e-3
    assert error < 0.25 * np.sqrt((exact.astype(float) ** 2).sum())
    assert result.dtype == np.float32


CASES = {
    "a + b": lambda a, b: a + b, "a - b": lambda a, b: a - b, "a * b": lambda a, b: a * b, "-a": lambda a, b: -a,
    "2 a": lambda a, b: 2 * a, "a 2": lambda a, b: a * np.float64(2), "a / 4": lambda a, b: a / 4,
    "a + 1": lambda a, b: a + 1, "1 - a": lambda a, b: 1 - a, "a - 3": lambda a, b: a - 3,
    "a b + a / 2 - 1": lambda a, b: a * b + a / 2 - 1, "np 2 a": lambda a, b: np.float32(2) * a,
}  # fmt: skip


@pytest.mark.parametrize("case", CASES)
def test_operators(pair, case):
    a, b, va, vb = pair
    check(CASES[case](va, vb), CASES[case](a, b))


def test_resample_missing(pair):
    a = pair[0].copy()
    a[3, 4, 5] = a[10:20, 3:9, 30:40] = np.nan
    half = cvol.compress(a, 8).resample(-2)
    means = a.reshape(16, 2, 12, 2, 24, 2).mean(axis=(1, 3, 5))
    assert np.array_equal(np.isnan(np.asarray(half)), np.isnan(means))
    assert half.info.missing_samples == np.isnan(means).sum() > 0


def test_convolve(pair):
    a, _, va, _ = pair
    wide = np.pad(a, 1, mode="symmetric").astype(float)
    exact = sum(wide[1 + d : 33 + d, 1:-1, 1:-1] for d in (-1, 0, 1)) / 3
    one = va.convolve([1 / 3] * 3)
    for axis in (1, 2):
        exact = np.pad(exact, [(1, 1) if k == axis else (0, 0) for k in range(3)], mode="symmetric")
        exact = sum(np.take(exact, np.arange(a.shape[axis]) + d, axis) for d in range(3)) / 3
    check(one, exact)
    check(va.convolve("box:3"), exact)
    assert va.convolve("gaussian:1.5").stats().mean == pytest.approx(va.stats().mean, rel=1e-4)
    with pytest.raises(cvol.ArgumentError, match="unknown"):
        va.convolve("nothing")


@pytest.mark.parametrize("transform", ["dct", "dft", "dht"])
def test_chirp(transform):
    a = np.random.default_rng(5).normal(size=(9, 12)).astype("f4")
    v = cvol.compress(a, keep=cvol.Keep.all(), transform=transform, block=0)
    start, step, count = (0.3, -1.25), (0.7, 1.1), (5, 7)
    at = [start[k] + step[k] * np.arange(count[k]) for k in range(2)]

    def functions(x, n):  # the direct sum of the interpolant, as a matrix on the samples
        samples, u = np.arange(n), np.arange(n)
        if transform == "dct":
            scale = np.where(u == 0, 1, 2) / n
            return (np.cos(np.pi * np.outer(x + 0.5, u) / n) * scale) @ np.cos(np.pi * np.outer(u, samples + 0.5) / n)
        u = np.arange(-(n // 2), n // 2 + 1)
        weight = np.where((n % 2 == 0) & (2 * abs(u) == n), 0.5, 1) / n
        return (np.exp(2j * np.pi * np.outer(x, u) / n) * weight) @ np.exp(-2j * np.pi * np.outer(u, samples) / n)

    exact = (functions(at[0], 9) @ a.astype(float) @ functions(at[1], 12).T).real
    assert np.allclose(v.evaluate_chirp(start, step, count), exact, atol=1e-4)
    with pytest.raises(ValueError, match="start has 1 numbers, must have 2"):
        v.evaluate_chirp((0,), step, count)
    with pytest.raises(ValueError, match="at least 1"):
        v.evaluate_chirp(start, step, (0, 7))
    with pytest.raises(cvol.UnsupportedError):
        cvol.compress(np.zeros((16, 16, 16), "f4"), 8).evaluate_chirp((0, 0, 0), (1, 1, 1), (2, 2, 2))


def test_shift_and_circular_convolution():
    rng = np.random.default_rng(2)
    a = np.cumsum(rng.normal(size=(6, 8, 10)), axis=2).astype("f4")
    va = cvol.compress(a, keep=cvol.Keep.all(), transform="dft", block=0)
    assert np.allclose(va.shift((1, 0, 3)).evaluate(), np.roll(a, (1, 0, 3), (0, 1, 2)), atol=1e-2)
    spike = np.zeros_like(a)
    spike[0, 2, 1] = 1
    vs = cvol.compress(spike, keep=cvol.Keep.all(), transform="dft", block=0)
    assert np.allclose(va.convolve(vs).evaluate(), np.roll(a, (0, 2, 1), (0, 1, 2)), atol=1e-2)


def test_statistics(pair):
    a, b, va, vb = pair
    s = va.stats()
    assert abs(s.mean - a.mean(dtype=float)) <= s.mean_error + 1e-6
    assert abs(s.standard_deviation - a.std(dtype=float)) <= s.standard_deviation_error + 1e-6
    assert va.mean() == s.mean and va.std() == s.standard_deviation and va.norm() == s.l2_norm
    c = va.compare(vb)
    assert c.inner_product == pytest.approx(va.dot(vb))
    assert abs(va.dot(vb) - (a.astype(float) * b).sum()) <= c.inner_product_error
    assert va.rms_error_bound() == pytest.approx(va.error_bound / np.sqrt(a.size))


def test_regions(array):
    v = cvol.compress(array, psnr=45)
    exact = cvol.compress(array, lossless=True)
    for least, largest, begin, end in ((100, math.inf, None, None), (60.5, 120, (1, 2, 3), (9, 20, 14))):
        box = array if begin is None else array[tuple(slice(i, j) for i, j in zip(begin, end))]
        inside = int(((box >= least) & (box <= largest)).sum())
        r = v.region(least, largest, begin, end)
        assert r.samples == box.size and r.inside_least <= inside <= r.inside_most
        assert abs(r.mean - box.mean()) <= r.mean_error
        r = exact.region(least, largest, begin, end)
        assert r.inside_least == r.inside == r.inside_most == inside and r.mean_error == 0
    for begin, end in ((None, None), ((1, 2, 3), (9, 20, 14)), ((4, 2, 3), (5, 20, 14))):
        slices = tuple(slice(*ends) for ends in zip(begin or (0, 0, 0), end or array.shape))
        box = array[slices].astype(float)
        u = np.meshgrid(*[(2 * np.arange(n) + 1 - n) / n for n in box.shape], indexing="ij")
        for ellipsoid in (False, True):
            samples = box[sum(x * x for x in u) <= 1 + 1e-9] if ellipsoid else box
            for volume in (v, exact):
                r = volume.region_statistics(begin, end, ellipsoid)
                assert r.samples == samples.size
                assert abs(r.mean - samples.mean()) <= r.mean_error + 1e-6
                assert abs(r.standard_deviation - samples.std()) <= r.standard_deviation_error + 1e-5
                assert abs(r.least - samples.min()) <= r.least_error
                assert abs(r.largest - samples.max()) <= r.largest_error
            assert r.mean_error == r.largest_error == 0
    with pytest.raises(cvol.ArgumentError, match="does not lie within"):
        v.region_statistics(end=(1, 1, 1000))
    with pytest.raises(cvol.ArgumentError, match="least value is 3"):
        v.region(3, 2)
    with pytest.raises(cvol.ArgumentError, match="does not lie within"):
        v.region(end=(1, 1, 1000))
    with pytest.raises(ValueError, match="begin has 2 numbers"):
        v.region(begin=(1, 1))
    with pytest.raises(ValueError, match="must not be negative"):
        v.region(begin=(1, 1, -1))


def test_keep_type_and_transcode(pair, volume, array):
    a, _, va, vb = pair
    few = va.multiply(vb, keep=cvol.Keep.rho(0.01))
    assert few.info.rho <= 0.0101 < va.multiply(vb).info.rho
    assert va.truncate(cvol.Keep.rho(0.01)).error_bound > va.error_bound
    whole = volume.astype(np.float32)
    assert whole.dtype == np.float32 and volume.dtype == np.int16
    assert np.abs(whole.evaluate() - volume.evaluate()).max() < 1e-2
    with pytest.raises(cvol.DataError):
        volume.astype(np.uint8)
    coarse = cvol.transcode(volume, 40)
    assert coarse.error_bound > volume.error_bound and coarse.shape == array.shape
    assert "rho(0.01)" in repr(cvol.Keep.rho(0.01))


def test_sums_keep_a_background(array):
    a = np.where(array > 200, array, 0).astype(np.int16)
    v = cvol.compress(a, psnr=40, background=0)
    assert v.info.background == 0
    check(v + v, 2 * a)
    assert (v + v).info.background == 0 and (v + v).info.background_samples == v.info.background_samples


def test_refusals(pair, volume):
    a, _, va, _ = pair
    for call in (lambda: va + a, lambda: a + va, lambda: va * a, lambda: va + "a", lambda: va / va, lambda: va @ va):
        with pytest.raises(TypeError):
            call()
    with pytest.raises(cvol.ArgumentError, match="dims"):
        va + volume
    with pytest.raises(TypeError, match="Keep"):
        va.truncate(3)
    with pytest.raises(TypeError, match="keep is 'all', must be a cvol.Keep"):
        cvol.compress(a, keep="all")
    for factor in (1.5, 3, "2"):
        with pytest.raises(ValueError, match="must be 2 or -2"):
            va.resample(factor)
    with pytest.raises(cvol.DataError, match="dtype=u?int|dtype=float"):
        (va * va).astype(np.uint8)


def test_regions_of_clamped_samples():
    a = np.zeros((17, 7, 2))
    a[[0, 2, 3, 4, 7, 11, 12, 12, 16], [1, 3, 0, 6, 2, 5, 4, 1, 3], [0, 1, 1, 0, 0, 1, 0, 0, 1]] = 4.7
    v = cvol.compress(a, psnr=31, background=0.0, effort="fast", labels=False)
    assert v.info.max_error < 1e-6 < np.abs(v.evaluate() - a).max()  # clamped, but not before
    r = v.region()
    assert abs(r.mean - a.mean()) <= r.mean_error
    r = v.region_statistics()
    assert abs(r.mean - a.mean()) <= r.mean_error
    assert abs(r.standard_deviation - a.std()) <= r.standard_deviation_error + 1e-12
