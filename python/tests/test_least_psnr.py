"""A ratio that leaves less than 25 dB is an error; without a target there is a warning, and 35 dB instead."""

import cvol
import numpy as np
import pytest


def noise(*shape):
    return np.random.default_rng(5).standard_normal(shape).astype(np.float32)


@pytest.mark.parametrize("shape, options", [
    ((20, 21, 22), {}), ((500, 400), {}), ((200, 400), {"block": 0}), ((20, 21, 22), {"transform": "dht"}),
])  # fmt: skip
def test_the_default_yields(shape, options):
    samples = noise(*shape)
    with pytest.warns(UserWarning, match="ratio 30 leaves a PSNR of .* 35 dB instead") as noted:
        volume = cvol.compress(samples, **options)
    assert noted[0].filename == __file__
    assert volume.info.psnr_db >= 35
    with pytest.raises(cvol.TargetError, match="less than 25 dB.*force=True"):
        cvol.compress(samples, 30, **options)
    assert cvol.compress(samples, 30, force=True, **options).info.psnr_db < 25
    assert cvol.compress(samples, force=True, **options).info.psnr_db < 25


def test_few_samples_that_no_ratio_fits():
    for samples in (noise(50, 40), noise(2000)):
        with pytest.warns(UserWarning, match="35 dB instead"):
            assert cvol.compress(samples).info.psnr_db >= 35
        with pytest.raises(cvol.TargetError):
            cvol.compress(samples, 30)


def test_what_is_asked_for_in_decibels_or_terms_holds():
    samples = noise(20, 21, 22)
    assert 12 <= cvol.compress(samples, psnr=12).info.psnr_db < 25
    assert cvol.compress(samples, keep=cvol.Keep.ratio(30)).info.psnr_db < 25
    with pytest.raises(cvol.TargetError, match="bits a sample leave"):
        cvol.compress(samples, bits=0.5)
