"""Whole arrays from values: they pass through the values, and restore terms that the points determine."""

import cvol
import numpy as np
import pytest


@pytest.mark.parametrize("transform", ["dct", "dft", "dht"])
@pytest.mark.parametrize("points,shape", [((7,), (16,)), ((6, 5), (12, 9)), ((4, 5, 6), (9, 5, 16))])
def test_grid(transform, points, shape):
    values = np.random.default_rng(3).normal(size=points).astype("f4")
    if transform != "dct":  # at half of an even number of points only the cosine is determined
        values = values - values.mean()
    v = cvol.interpolate(values, shape, transform, spacing=2)
    assert v.shape == shape and v.spacing == (2,) * len(shape)
    axes = [
        (np.arange(p) + 0.5) * n / p - 0.5 if transform == "dct" else np.arange(p) * n / p
        for p, n in zip(points, shape)
    ]
    at = np.stack(np.meshgrid(*axes, indexing="ij"), -1).reshape(-1, len(shape))
    assert np.allclose(v.evaluate_points(at), values.ravel(), atol=1e-5)
    fewer = cvol.interpolate(values, shape, transform, cvol.Keep.terms(0, 3))
    assert fewer.error_bound > 0.01 and fewer.info.terms < v.info.terms


def smooth(size, places, transform, seed=4):
    """Samples with terms at these places alone."""
    rng, x = np.random.default_rng(seed), np.arange(size)
    out = np.zeros(size)
    for u in places:
        if transform == "dct":
            out += rng.normal() * np.cos(np.pi * u * (x + 0.5) / size)
        else:
            out += rng.normal() * np.cos(2 * np.pi * u * x / size) + rng.normal() * np.sin(2 * np.pi * u * x / size)
    return out


@pytest.mark.parametrize("transform", ["dct", "dft", "dht"])
def test_chirp(transform):
    exact = smooth(40, (1, 3, 7), transform)
    known = cvol.compress(exact.astype("f4"), keep=cvol.Keep.all(), transform=transform, block=0)
    start, step = 0.3, 2.9
    values = known.evaluate_points((start + step * np.arange(13))[:, None])
    places = [1, 3, 7] if transform == "dct" else [1, 3, 7, 33, 37, 39]
    v, residual = cvol.interpolate_chirp(values, start, step, places, 40, transform)
    assert np.allclose(v.to_numpy(), exact, atol=1e-4) and residual < 1e-4
    values[5] += 1
    assert cvol.interpolate_chirp(values, start, step, places, 40, transform)[1] > 0.1
    with pytest.raises(cvol.TargetError, match="do not determine"):
        cvol.interpolate_chirp(values, start, 0.001, places, 40, transform)
    with pytest.raises(cvol.ArgumentError):
        cvol.interpolate_chirp(values[:2], start, step, places, 40, transform)
    with pytest.raises(ValueError, match="must be integers from 0 to 39"):
        cvol.interpolate_chirp(values, start, step, [40], 40, transform)


@pytest.mark.parametrize("transform", ["dft", "dht"])
def test_pencil(transform):
    exact = smooth(500, (17, 60, 141), transform)
    v, residual = cvol.interpolate_pencil(exact[:12], 500, transform)
    assert np.allclose(v.to_numpy(), exact, atol=1e-3 * abs(exact).max()) and residual < 1e-4
    with pytest.raises(cvol.TargetError):
        cvol.interpolate_pencil(np.random.default_rng(1).normal(size=12), 500, transform)
    with pytest.raises(cvol.UnsupportedError):
        cvol.interpolate_pencil(exact[:12], 500, "dct")
    with pytest.raises(ValueError, match="even number"):
        cvol.interpolate_pencil(exact[:11], 500, transform)


def test_misuse():
    with pytest.raises(ValueError, match="at most \\(4, 5\\)"):
        cvol.interpolate(np.zeros((5, 5)), (4, 5))
    with pytest.raises(ValueError, match="shape has 1 numbers, must have 2"):
        cvol.interpolate(np.zeros((5, 5)), (5,))
    with pytest.raises(ValueError, match="'dct', 'dft' or 'dht'"):
        cvol.interpolate(np.zeros(5), (5,), "fft")
    with pytest.raises(cvol.DataError):
        cvol.interpolate(np.array([1, np.nan]), (5,))
    with pytest.raises(ValueError, match="size is 0"):
        cvol.interpolate_pencil(np.zeros(4), 0)
