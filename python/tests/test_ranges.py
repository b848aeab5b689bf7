"""cvol.open(object, ranges=True): slices and levels read only some bytes of the object."""

import io
import os
import pickle

import cvol
import numpy as np
import pytest
from conftest import make_array

pytestmark = pytest.mark.skipif(not hasattr(os, "memfd_create"), reason="no files in memory: ranges need Linux")


class Counted(io.BytesIO):
    """Bytes that count how many of them are read."""

    count = 0

    def read(self, size=-1, /):
        data = super().read(size)
        self.count += len(data)
        return data


@pytest.fixture(scope="module")
def large():
    return make_array((160, 96, 144))


def files(large):
    holes = large.astype("f4")
    holes[20:60, 30:50] = np.nan
    labels = (large > 300).astype("u1") * 9
    return {
        "small bricks": cvol.compress(large, psnr=45, bricks=16, effort="fast"),
        "default bricks": cvol.compress(large, psnr=45, effort="fast"),
        "lossless": cvol.compress(large, lossless=True, bricks=32, effort="fast"),
        "greatest error": cvol.compress(large, max_error=3, bricks=(16, 48, 32), effort="fast"),
        "holes": cvol.compress(holes, psnr=45, fill=np.nan, bricks=32, effort="fast"),
        "labels": cvol.compress(labels),
        "packed": cvol.compress(large[:20, :20, :20], psnr=40),
        "not in blocks": cvol.compress(large[:20], psnr=40, block=0),
    }


def test_every_kind_of_file(large, tmp_path):
    for kind, made in files(large[:112, :64, :96]).items():
        path = tmp_path / "a.cvol"
        size = made.save(path)
        file = Counted(path.read_bytes())
        v, known = cvol.open(file, ranges=True), cvol.open(path)
        for box in (np.s_[5], np.s_[:, 9], np.s_[17:19, 3:19, 15:17], np.s_[-1, ::7, -1]):
            assert np.array_equal(v[box], known[box], equal_nan=True), kind
        if kind in ("small bricks", "holes", "greatest error"):
            assert file.count < size / 1.2, (kind, file.count, size)
        for mine, its in zip(v.levels, known.levels):
            assert np.array_equal(mine[:9, 4], its[:9, 4], equal_nan=True), kind
        assert np.array_equal(v, known, equal_nan=True) and file.count <= size + 8, kind
        assert np.array_equal(pickle.loads(pickle.dumps(v)), known, equal_nan=True)


def test_bytes_read(large, tmp_path):
    size = cvol.compress(large, psnr=45, bricks=16, effort="fast").save(tmp_path / "a.cvol")
    file = Counted((tmp_path / "a.cvol").read_bytes())
    v = cvol.open(file, ranges=True)
    opened = file.count
    assert opened < size / 5 and v.shape == large.shape
    before = v[40:42, 40:42, 40:42]
    assert file.count - opened < size / 50
    again = file.count
    assert np.array_equal(v[40:42, 40:42, 40:42], before) and file.count == again
    coarse = Counted(file.getvalue())
    assert cvol.open(coarse, ranges=True).levels[3][...].shape == (20, 12, 18)
    assert coarse.count < size / 3


def test_series_and_objects_that_open(large, tmp_path):
    frames = [np.roll(large, 5 * k, axis=2) for k in range(3)]
    volumes = [cvol.compress(a, psnr=45, bricks=16, effort="fast") for a in frames]
    size = cvol.save_series(tmp_path / "run.cvol", volumes, times=3)
    file = Counted((tmp_path / "run.cvol").read_bytes())
    v = cvol.open(file, time=2, ranges=True)
    assert np.array_equal(v[8], volumes[2][8]) and file.count < size / 5 and "'the object'" in repr(v)
    with pytest.raises(cvol.ArgumentError, match="number 3 was requested"):
        cvol.open(file, time=3, ranges=True)

    class Remote:
        def open(self):
            return (tmp_path / "run.cvol").open("rb")

    with cvol.open(Remote(), ranges=True) as v:
        assert np.array_equal(v[8], volumes[0][8]) and repr(v).startswith("<cvol.Volume of 'run.cvol' 160 x")
        assert np.array_equal(cvol.open(Remote(), ranges=True, compress=False), volumes[0])
    with pytest.raises(ValueError, match="closed"):
        v[8]


def test_what_is_wrong(large, tmp_path):
    data = cvol.compress(large, psnr=45, bricks=16, effort="fast").to_bytes()
    for source, kind, text in (
        (io.StringIO("text"), TypeError, "needs a binary object with seek"),
        (io.BytesIO(b"no volume"), cvol.FormatError, "leave ranges=True out"),
        (io.BytesIO(data[:5000]), cvol.FormatError, "^the object: "),
    ):
        with pytest.raises(kind, match=text):
            cvol.open(source, ranges=True)
    rng = np.random.default_rng(0)
    for _ in range(60):  # damage is a message or harmless, never another exception
        damaged = bytearray(data)
        damaged[rng.integers(8, 6000)] ^= 1 << rng.integers(8)
        try:
            cvol.open(io.BytesIO(bytes(damaged)), ranges=True)[3, 4]
        except cvol.Error as error:
            assert "/proc/" not in str(error)
