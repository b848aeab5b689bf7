"""Files of several volumes: writing, listing, and reading single volumes."""

import os
import signal

import cvol
import numpy as np
import pytest
from conftest import make_array


def arrays():
    return [np.roll(make_array((9, 12, 20), "u1"), i, axis=2) for i in range(6)]


def test_one_of_many(tmp_path):
    path = tmp_path / "run.cvol"
    volumes = [cvol.compress(a, lossless=True) for a in arrays()]
    size = cvol.save_series(path, volumes, channels=2, time_values=(0, 0.5, 2), time_unit="s",
                            channel_names=("DAPI", "GFP"), channel_colours=((0, 0, 1), (0, 1, 0.5)))  # fmt: skip
    assert size == os.path.getsize(path)
    found = cvol.contents(path)
    assert (found.times, found.channels, found.time_values, found.time_unit) == (3, 2, (0, 0.5, 2), "s")
    assert found.channel_names == ("DAPI", "GFP") and found.channel_colours[1] == (0, 1, 0.5)
    alone = volumes[3].save(tmp_path / "alone.cvol")
    assert found.file_bytes[1][1] == alone
    for i, a in enumerate(arrays()):
        with cvol.open(path, time=i // 2, channel=i % 2) as v:
            assert np.array_equal(v[3:5, 2], a[3:5, 2])
            assert np.array_equal(v.to_numpy(), a)
    assert np.array_equal(cvol.open(path).to_numpy(), arrays()[0])
    with pytest.raises(cvol.ArgumentError, match="has 3 times, 0 to 2; number 3 was requested"):
        cvol.open(path, time=3)


def test_generators_and_what_is_wrong(tmp_path):
    path = tmp_path / "run.cvol"
    cvol.save_series(path, (cvol.compress(a, psnr=40) for a in arrays()), times=6)
    assert cvol.contents(path).times == 6
    before = path.read_bytes()
    with pytest.raises(cvol.ArgumentError, match="got 1 volumes, must be 6"):
        cvol.save_series(path, (cvol.compress(a) for a in arrays()[:1]), times=6)
    with pytest.raises(cvol.ArgumentError, match="has 19 x 12 x 9 samples of uint8, the volumes before it 20"):
        cvol.save_series(path, [cvol.compress(a) for a in (arrays()[0], arrays()[0][:, :, 1:])])
    with pytest.raises(ValueError, match="time_values has 1 values, must have 6"):
        cvol.save_series(path, (cvol.compress(a) for a in arrays()), times=6, time_values=[1])
    with pytest.raises(ValueError, match="must be a multiple of 2 channels"):
        cvol.save_series(path, [cvol.compress(arrays()[0])], channels=2)
    assert path.read_bytes() == before and os.listdir(tmp_path) == ["run.cvol"]
    single = tmp_path / "one.cvol"
    cvol.compress(arrays()[0]).save(single)
    assert cvol.contents(single).times == 1 and cvol.contents(single).file_bytes == ((single.stat().st_size,),)
    with pytest.raises(cvol.ArgumentError, match="has one time, number 0; number 1"):
        cvol.open(single, time=1)


@pytest.mark.parametrize("where", ["the generator", "the compression"])
def test_ctrl_c(tmp_path, where):
    """Ctrl-C stops the code of a generator at once, and its compression at the next report."""
    before, made, reports, passed = signal.getsignal(signal.SIGINT), [], [], []

    def report(what, share):
        reports.append(share)
        if where == "the compression" and len(reports) == 1:
            os.kill(os.getpid(), signal.SIGINT)

    def volumes():
        for samples in arrays():
            made.append(cvol.compress(samples, psnr=40, progress=report))
            if where == "the generator":
                os.kill(os.getpid(), signal.SIGINT)
            passed.append(1)
            yield made[-1]

    with pytest.raises(KeyboardInterrupt):
        cvol.save_series(tmp_path / "run.cvol", volumes(), times=6)
    assert not passed and os.listdir(tmp_path) == []
    assert len(made) == 1 if where == "the generator" else not made and len(reports) == 1
    assert signal.getsignal(signal.SIGINT) is before


def test_arrays_of_four_axes(tmp_path):
    frames = np.stack(arrays())
    series = cvol.compress(frames, lossless=True, effort="fast", spacing=(3, 2, 1))
    assert isinstance(series, cvol.Series) and series.shape == frames.shape and len(series) == 6
    assert (series.ndim, series.size, series.nbytes, series.dtype) == (4, frames.size, frames.nbytes, np.uint8)
    assert np.array_equal(series, frames) and np.array_equal(series.to_numpy(), frames)
    for index in (2, -1, np.s_[1:3, 4], np.s_[::-2, ..., 3], np.s_[..., 0, 0, 0], np.s_[0, 1, 2, 3], np.s_[9:],
                  [0, 5], frames > 40, None, ()):  # fmt: skip
        assert np.array_equal(series[index], frames[index]) and np.shape(series[index]) == frames[index].shape
    for wrong in (6, np.s_[0, 0, 0, 0, 0], np.s_[..., ...], np.s_[0, 99]):
        with pytest.raises(IndexError):
            series[wrong]
    series.save(tmp_path / "run.cvol", time_values=range(0, 12, 2), time_unit="s")
    found = cvol.contents(tmp_path / "run.cvol")
    assert found.times == 6 and found.time_values[5] == 10 and found.time_unit == "s"
    with cvol.open(tmp_path / "run.cvol", time=4) as v:
        assert np.array_equal(v, frames[4]) and v.spacing == (3, 2, 1) and v.geometry == series.geometry
    lossy = cvol.compress_series(frames, 4, force=True)
    assert lossy.volumes[2].info.max_error > 0 and repr(lossy) == "<cvol.Series 6 x 9 x 12 x 20 uint8>"
    with lossy:
        pass
    with pytest.raises(ValueError, match="closed"):
        lossy[0]


def test_arrays_of_four_axes_of_other_types_and_labels():
    z, y, x = np.mgrid[:40, :48, :56]
    organs = ((z // 14 + y // 17 + x // 20) * 3).astype(np.int64)
    assert all(v.info.exact for v in cvol.compress(np.stack([organs, organs[::-1]])).volumes)
    large = np.stack([organs, organs + 2**31])  # the second time needs uint32
    assert np.array_equal(cvol.compress(large, lossless=True), large)
    assert np.array_equal(cvol.compress(np.stack([organs > 3] * 2)), np.stack([organs > 3] * 2))
    for array in (np.zeros((0, 2, 2, 2)), np.zeros((2, 2, 2))):
        with pytest.raises(ValueError, match="must have four axes"):
            cvol.compress_series(array)
    with pytest.raises(ValueError, match="has no volume"):
        cvol.Series([])
    two = [cvol.compress(a, keep=cvol.Keep.all()) for a in (np.zeros((4, 4, 4), "f4"), np.zeros((4, 4, 5), "f4"))]
    with pytest.raises(ValueError, match="volume 1 differs from volume 0"):
        cvol.Series(two)
    with pytest.raises(ValueError, match="5 axes"):
        cvol.compress(np.zeros((2, 2, 2, 2, 2)))
