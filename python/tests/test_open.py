"""cvol.open of other formats and of objects with bytes."""

import io
import os
import pickle

import cvol
import numpy as np
import pytest
from conftest import make_array

PLACE = cvol.Geometry(spacing=(2, 1, 0.5), origin=(1, 2, 3), space="RAS", unit="mm")


@pytest.fixture(scope="module")
def small():
    return make_array((12, 20, 24))


@pytest.mark.parametrize("name", ["a.nii", "a.nii.gz", "a.nrrd", "a.mha", "a.npy", "a.vti"])
def test_formats(tmp_path, small, name):
    cvol.write(tmp_path / name, small, geometry=PLACE)
    v = cvol.open(tmp_path / name)
    assert v.shape == small.shape and v.dtype == small.dtype and "a." in repr(v)
    assert v._store._whole is None  # nothing is read yet
    assert np.array_equal(v[3:5, ::-1], small[3:5, ::-1]) and v.info.exact
    assert np.array_equal(pickle.loads(pickle.dumps(v)), small)
    dense = cvol.open(tmp_path / name, compress=False)
    assert isinstance(dense, np.ndarray) and np.array_equal(dense, small)
    assert dense.geometry == v.geometry and np.array_equal(dense.affine, v.affine)
    if name != "a.npy":
        assert v.spacing == (2, 1, 0.5)


def test_unknown_files_and_names(tmp_path, small):
    path = tmp_path / "notes.txt"
    path.write_text("no volume")
    with pytest.raises(cvol.FormatError, match=r"notes.txt: is not a .cvol file, and no volume .* cvol.read\(path"):
        cvol.open(path)
    with cvol.compress(small, lossless=True) as v:
        with pytest.raises(cvol.ArgumentError, match="no transfer function is named bones; .* bone .* ct-bone"):
            v.render(transfer="bones", size=16)


def test_save_keeps_files_of_other_formats(tmp_path, small):
    """save() writes .cvol: it refuses names of other formats, such as that of the opened file."""
    path = tmp_path / "a.nii.gz"
    cvol.write(path, small)
    data = path.read_bytes()
    v = cvol.open(path)
    for save in (v.save, lambda name: cvol.save_series(name, [v, v])):
        with pytest.raises(cvol.ArgumentError, match=r"a\.nii\.gz: a \.cvol file .* \.nii\.gz: give another name"):
            save(path)
    assert path.read_bytes() == data
    assert v.save(tmp_path / "without_ending") > 0


@pytest.mark.skipif(".tif" not in cvol.formats(), reason="built without TIFF")
def test_units_of_ome(tmp_path, small):
    """Each axis has a unit; spacings are converted to that of x."""
    path = tmp_path / "a.ome.tif"
    cvol.write(path, small, geometry=cvol.Geometry(spacing=(2, 1, 0.5), unit="um"))
    data = path.read_bytes()
    old = 'PhysicalSizeZUnit="\u00b5m"'.encode()
    assert data.count(old) == 1 and cvol.read(path)[1].spacing == (2, 1, 0.5)
    path.write_bytes(data.replace(old, b'PhysicalSizeZUnit="mm" '))
    found = cvol.read(path)[1]
    assert found.spacing == (2000, 1, 0.5) and found.unit == "um"
    path.write_bytes(data.replace(old, b'PhysicalSizeZUnit="px" '))
    with pytest.raises(cvol.UnsupportedError, match="do not convert into each other: give spacing="):
        cvol.read(path)
    assert cvol.read(path, spacing=(5, 1, 1))[1].spacing == (5, 1, 1)


def test_options_of_compress(tmp_path, small):
    cvol.write(tmp_path / "a.nrrd", small, geometry=PLACE)
    v = cvol.open(tmp_path / "a.nrrd", compress={"psnr": 40})
    assert 40 <= v.info.psnr_db < 45 and v.spacing == (2, 1, 0.5) and v.chunks == small.shape
    assert pickle.loads(pickle.dumps(v)).info.psnr_db == v.info.psnr_db
    with pytest.raises(TypeError, match="nothing"):
        cvol.open(tmp_path / "a.nrrd", compress={"nothing": 1}).to_numpy()
    v = cvol.open(tmp_path / "a.nrrd")
    cvol.write(tmp_path / "a.nrrd", small[:5])
    with pytest.raises(cvol.Error, match="was changed after it was opened"):
        v[0]


def test_samples_without_a_value_and_several_volumes(tmp_path, small):
    nibabel = pytest.importorskip("nibabel", reason="nibabel is not installed: its files are not read")
    holes = small.astype("f4")
    holes[2, 3:9] = np.nan
    nibabel.Nifti1Image(np.stack([holes.T, holes.T + 1], -1), np.eye(4)).to_filename(tmp_path / "run.nii")
    for time in range(2):
        assert np.array_equal(cvol.open(tmp_path / "run.nii", time=time), holes + time, equal_nan=True)
        assert cvol.open(tmp_path / "run.nii", time=time, compress=False).shape == small.shape
    with pytest.raises(cvol.Error, match="2 volumes"):
        cvol.open(tmp_path / "run.nii")


def test_dense_volumes(path, volume):
    dense = cvol.open(path, compress=False)
    assert np.array_equal(dense, volume) and dense.spacing == (2.0, 1.0, 0.5) and dense.geometry == volume.geometry
    assert dense[3].geometry is None and (dense + 1).geometry is None
    with pytest.raises(AttributeError, match="take it from the volume"):
        dense[3].spacing  # pylint: disable=expression-not-assigned


def test_objects(path, volume, tmp_path, small):
    data = path.read_bytes()
    assert np.array_equal(cvol.open(io.BytesIO(data)), volume)
    with path.open("rb") as file:
        assert np.array_equal(cvol.open(file)[5], volume[5])
    kept = io.BytesIO()
    assert volume.save(kept) == len(kept.getvalue()) == len(volume.to_bytes())
    assert kept.getvalue() == data
    cvol.write(tmp_path / "a.nii.gz", small, geometry=PLACE)
    with open(tmp_path / "a.nii.gz", "rb") as file:
        v = cvol.open(file)
        dense = cvol.open(io.BytesIO((tmp_path / "a.nii.gz").read_bytes()), compress=False)
    os.unlink(tmp_path / "a.nii.gz")
    assert np.array_equal(v, small) and v.spacing == (2, 1, 0.5) and np.array_equal(dense, small)
    assert np.array_equal(pickle.loads(pickle.dumps(v)), small)
    cvol.save_series(tmp_path / "run.cvol", [cvol.compress(small + k, lossless=True) for k in range(2)])
    run = io.BytesIO((tmp_path / "run.cvol").read_bytes())
    assert np.array_equal(cvol.open(run, time=1), small + 1)


def test_an_object_that_opens(path, volume):
    class Remote:
        path = "server/volume.cvol"

        def open(self):
            return path.open("rb")

    assert np.array_equal(cvol.open(Remote())[5], volume[5])


def test_fsspec(path, volume):
    fsspec = pytest.importorskip("fsspec", reason="fsspec is not installed: its files are not tested")
    memory = fsspec.filesystem("memory")
    with memory.open("/scan.cvol", "wb") as file:
        volume.save(file)
    with memory.open("/scan.cvol", "rb") as file:
        assert np.array_equal(cvol.open(file), volume)
    assert np.array_equal(cvol.open(fsspec.open("memory:///scan.cvol")), volume)


def test_what_cannot_be_opened(tmp_path):
    for source, kind, text in (
        (io.StringIO("text"), TypeError, "open the file in binary mode"), (5, TypeError, "give a path"),
        (io.BytesIO(b"no volume"), cvol.FormatError, "the object: is not a .cvol file"),
        (tmp_path / "none.nii", FileNotFoundError, "none.nii"),
    ):  # fmt: skip
        with pytest.raises(kind, match=text):
            cvol.open(source)


def test_nibabel_agrees(tmp_path, small):
    nibabel = pytest.importorskip("nibabel", reason="nibabel is not installed: its affine is not compared")
    turned = cvol.Geometry((2, 1, 0.5), (1, 2, 3), ((0, 0.6, 0.8), (0, 0.8, -0.6), (1, 0, 0)), "LPS", "mm")
    for place in (PLACE, turned):
        cvol.write(tmp_path / "a.nii", small, geometry=place)
        image = nibabel.load(tmp_path / "a.nii")
        assert np.allclose(image.affine, cvol.open(tmp_path / "a.nii").geometry.nibabel_affine(), atol=1e-6)
        assert np.allclose(image.affine, place.nibabel_affine(), atol=1e-6)
        assert np.array_equal(np.asarray(image.dataobj).T, small)


def test_options_in_messages(tmp_path):
    from cvol._call import _in_python  # pylint: disable=import-outside-toplevel

    assert _in_python("a.nii: choose one with --time 0 to 2") == "a.nii: choose one with time= 0 to 2"
    assert _in_python("night--time/x--type.nii: is empty") == "night--time/x--type.nii: is empty"
    with pytest.raises(cvol.ArgumentError, match="only one of time and index"):
        cvol.read(tmp_path / "a.nii", time=1, index=1)
