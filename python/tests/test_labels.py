"""Labels: compress stores them losslessly without a target; detection by file and by samples."""

import cvol
import numpy as np
import pytest

SHAPE = (40, 44, 48)


def make_labels(seed=0, most=101):
    """Up to `most` labels of uint16, in boxes of 1 x 2 x 8 samples; lossless, they take more than a thirtieth."""
    numbers = np.random.default_rng(seed).permutation(np.arange(40 * 22 * 6) % most).reshape(40, 22, 6)
    return (numbers.repeat(2, 1).repeat(8, 2) * 7).astype(np.uint16)


def test_labels_come_back_without_any_option(tmp_path):
    labels = make_labels()
    assert labels.shape == SHAPE and len(np.unique(labels)) == 101
    volume = cvol.compress(labels)
    back = volume.to_numpy()
    assert back.dtype == np.uint16 and np.array_equal(back, labels)
    assert volume.info.exact and volume.info.max_error == 0
    asked = cvol.compress(labels, lossless=True).save(tmp_path / "lossless.cvol")
    assert volume.save(tmp_path / "labels.cvol") <= asked
    assert np.array_equal(cvol.open(tmp_path / "labels.cvol")[3:9, 5], labels[3:9, 5])


def test_a_target_or_no_labels_is_what_is_done():
    labels = make_labels()
    for options in ({"labels": False}, {"ratio": 30}, {"psnr": 20, "labels": False}, {"psnr": 20}):
        volume = cvol.compress(labels, **options)
        assert not volume.info.exact and not np.array_equal(volume.to_numpy(), labels), options
    assert cvol.compress(labels, labels=False, lossless=True).info.exact


def test_transcode_keeps_labels_and_the_least_psnr(array):
    labels = make_labels()
    volume = cvol.compress(labels)
    for options in ({"ratio": 400}, {"psnr": 30}, {"bits": 0.01}):
        with pytest.raises(cvol.TargetError, match="are labels"):
            cvol.transcode(volume, **options)
    assert not cvol.transcode(volume, psnr=30, force=True).info.exact
    scan = cvol.compress(array, psnr=40, effort="fast")
    for options in ({"ratio": 1000}, {"bits": 0.01}):
        with pytest.raises(cvol.TargetError, match="less than 25 dB; give psnr=35 for more quality, or force=True"):
            cvol.transcode(scan, **options)
        assert cvol.transcode(scan, **options, force=True).info.psnr_db < 25
    assert cvol.transcode(scan, psnr=20).info.psnr_db < 25


def test_labels_are_what_one_says_they_are(array):
    few = np.zeros((12, 10, 9), np.int32)
    few[2, 3, 4], few[7, 1, 1:3] = 70000, 3
    assert np.array_equal(cvol.compress(few, labels=True).to_numpy(), few)
    scan = array[:20, :20, :20]
    assert not cvol.compress(scan).info.exact
    assert np.array_equal(cvol.compress(scan, labels=True).to_numpy(), scan)
    assert np.array_equal(cvol.compress(scan, labels=np.True_, lossless=True).to_numpy(), scan)


def test_masks_and_other_options():
    z, y, x = np.ogrid[:24, :20, :30]
    mask = (z - 12) ** 2 + (y - 10) ** 2 + (x - 15) ** 2 < 80
    assert cvol.is_labels(mask) and not cvol.is_labels(mask.astype("u1"))  # too few samples to decide
    assert np.array_equal(cvol.compress(mask).to_numpy(), mask)
    labels = make_labels()
    for options in ({"effort": "max"}, {"effort": "fast"}, {"background": 0}, {"lap": False}, {"fill": 0}):
        assert np.array_equal(cvol.compress(labels, **options).to_numpy(), labels), options
    plane = np.tile(labels[0], (8, 8))  # truncation does not detect labels
    assert not np.array_equal(cvol.compress(plane).to_numpy(), plane)


def test_a_series_of_labels(tmp_path):
    path, times = tmp_path / "labels.cvol", [make_labels(seed, 40) for seed in range(3)]
    cvol.save_series(path, (cvol.compress(labels) for labels in times), times=3)
    for i, labels in enumerate(times):
        with cvol.open(path, time=i) as volume:
            assert volume.info.exact and np.array_equal(volume.to_numpy(), labels)


def test_what_does_not_go_together():
    labels = make_labels()
    for options in ({"ratio": 30}, {"psnr": 40}, {"max_error": 1}, {"bits": 1}, {"keep": cvol.Keep.all()}):
        with pytest.raises(ValueError, match=f"labels=True is lossless: leave out {next(iter(options))}"):
            cvol.compress(labels, labels=True, **options)
    for options in ({"block": 0}, {"transform": "dht"}):
        with pytest.raises(ValueError, match="labels=True is lossless, which needs three axes"):
            cvol.compress(labels, labels=True, **options)
    with pytest.raises(ValueError, match="needs three axes in DCT blocks"):
        cvol.compress(labels[0], labels=True)
    with pytest.raises(TypeError, match="labels is 'yes', must be True, False or None"):
        cvol.compress(labels, labels="yes")


def test_is_labels(tmp_path, array):
    assert cvol.is_labels(make_labels()) and cvol.is_labels(make_labels().astype(">i4"))
    scan = array[:20, :20, :20]
    assert not cvol.is_labels(scan) and not cvol.is_labels(make_labels().astype("f4"))
    assert not cvol.is_labels(make_labels()[0]) and not cvol.is_labels(np.zeros((0, 2, 2), "u1"))
    assert cvol.is_labels(scan, "mine.seg.nrrd") and not cvol.is_labels(scan, tmp_path / "mine.nrrd")
    name = tmp_path / "mine.nii"
    cvol.write(name, scan)
    assert not cvol.is_labels(cvol.read(name)[0], name)
    data = bytearray(name.read_bytes())
    data[68:70] = (1002).to_bytes(2, "little")  # intent code: label
    name.write_bytes(data)
    samples, geometry = cvol.read(name)
    kept = cvol.compress(samples, geometry=geometry, labels=cvol.is_labels(samples, name))
    assert np.array_equal(kept.to_numpy(), scan)


def test_efforts(tmp_path):
    """Each effort changes the size of the file; invalid combinations of options are refused."""
    rng = np.random.default_rng(4)
    smooth = (100 + 60 * np.sin(np.indices((40, 36, 44)).sum(0) / 7) + rng.normal(0, 1, (40, 36, 44))).astype("u1")
    sizes = {}
    for effort in ("fast", "default", "max"):
        cvol.compress(smooth, psnr=44, effort=effort).save(tmp_path / effort)
        sizes[effort] = (tmp_path / effort).stat().st_size
    assert sizes["fast"] > sizes["default"] > sizes["max"], sizes
    with pytest.raises(ValueError, match="effort is 'smallest', must be 'fast', 'default' or 'max'"):
        cvol.compress(smooth, effort="smallest")
    for options in ({"max_error": 1}, {"lossless": True}):
        with pytest.raises(ValueError, match="maximum effort cannot be combined with"):
            cvol.compress(smooth, effort="max", **options)
