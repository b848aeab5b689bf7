"""Volumes of red, green, blue and alpha: their pictures are those of the command, their samples those of NumPy."""

import gc
import signal
import subprocess
import warnings

import cvol
import numpy as np
import pytest
from cvol import _abi
from cvol._view import _command

LOOKS = [
    ({}, []),
    ({"azimuth": 40, "elevation": 15, "roll": 10, "light": "flat", "background": "white"},
     ["--azimuth", "40", "--elevation", "15", "--roll", "10", "--light", "flat", "--background", "white"]),
    ({"view": "left", "opacity_scale": 0.5, "background": "transparent"},
     ["--view", "left", "--opacity-scale", "0.5", "--background", "transparent"]),
    ({"window": (20, 180), "size": (90, 60)}, ["--window", "100,160", "--size", "90x60"]),
    ({"annotate": True, "fit": "box"}, ["--annotate", "--fit", "box"]),
    ({"clip": np.s_[5:30, :, :25]}, ["--clip", "0:24,,5:29"]),
]  # fmt: skip


def samples():
    """A ball of several colours, and its opacity."""
    z, y, x = np.mgrid[-1:1:40j, -1:1:48j, -1:1:44j]
    ball = z * z + y * y + x * x < 0.7
    noise = np.random.default_rng(1).normal(2, 1, (4, *ball.shape))
    components = ball * [200 + 20 * x, 100 + 60 * y, 40 + 100 * (z > 0), 250 - 100 * (x > 0.2)] + noise
    return np.moveaxis(np.clip(components, 0, 255).astype("u1"), 0, -1)


def compressed(array):
    components = (np.ascontiguousarray(component) for component in np.moveaxis(array, -1, 0))
    return cvol.Colours([cvol.compress(component, psnr=45) for component in components])


def command_picture(folder, path, options):
    """The pixels of `cvol render`."""
    pil = pytest.importorskip("PIL.Image", reason="Pillow is not installed: the command's pictures are not read")
    command = _command()
    if command is None:
        pytest.skip("the command cvol is not there: its pictures are not compared")
    size = () if "--size" in options else ("--size", "96")
    words = [command, "render", path, "-o", folder / "picture.png", *size, *options]
    done = subprocess.run(words, capture_output=True, text=True, timeout=60)
    assert done.returncode == 0, done.stderr
    return np.asarray(pil.open(folder / "picture.png"))


def test_ctrl_c_frees_the_colours(monkeypatch):
    """Ctrl-C at the end of the call that makes the colours: they are freed."""
    freed, functions = [], dict(_abi.functions)

    def create(*arguments):
        code = functions["colours_create"](*arguments)
        signal.raise_signal(signal.SIGINT)
        return code

    def free(pointer):
        freed.append(pointer)
        functions["colours_free"](pointer)

    with compressed(samples()[..., :3]) as colours:
        monkeypatch.setitem(_abi.functions, "colours_create", create)
        monkeypatch.setitem(_abi.functions, "colours_free", free)
        with pytest.raises(KeyboardInterrupt):
            colours.render(size=16)
        gc.collect()
        assert len(freed) == 1 and freed[0]


def test_windows_that_change():
    """window may be an array, and a list that the caller changes between two pictures."""
    with compressed(samples()[..., :3]) as colours:
        first, second = (colours.render(size=48, window=w) for w in ((20, 180), (0, 90)))
        assert not np.array_equal(first, second)
        for window in (np.array([20, 180]), [20, 180]):
            assert np.array_equal(colours.render(size=48, window=window), first)
            assert np.array_equal(colours.render(size=48, window=window), first)
            window[:] = (0, 90)
            assert np.array_equal(colours.render(size=48, window=window), second)


@pytest.mark.parametrize("count", [3, 4])
def test_pictures_are_the_commands(tmp_path, count):
    path = tmp_path / "ball.cvol"
    colours = compressed(samples()[..., :count])
    colours.save(path)
    with cvol.open_colours(path) as opened:
        for look, options in LOOKS:
            look = {"size": 96, **look}
            picture = opened.render(**look)
            assert np.array_equal(picture, command_picture(tmp_path, path, options)), look
            assert np.array_equal(picture, colours.render(**look)), look
        middle = opened.render(size=96, view="front", light="flat")[48, 48].astype(int)
        assert middle[0] > middle[1] + 40 > middle[2]  # red prevails


def test_alpha_that_is_the_same_everywhere(tmp_path):
    array = samples()
    array[..., 3] = 255
    path = tmp_path / "opaque.cvol"
    compressed(array).save(path)
    picture = cvol.open_colours(path).render(size=96)
    assert np.array_equal(picture, command_picture(tmp_path, path, []))
    assert np.array_equal(picture, compressed(array[..., :3]).render(size=96))


def test_samples_and_series(tmp_path):
    array = samples()
    lossless = [cvol.compress(np.ascontiguousarray(array[..., k % 3]), lossless=True) for k in range(6)]
    cvol.save_series(tmp_path / "run.cvol", lossless, channels=3, colours=True)
    colours = cvol.open_colours(tmp_path / "run.cvol", time=1)
    assert colours.shape == (40, 48, 44, 3) and colours.ndim == 4 and colours.dtype == np.uint8
    assert np.array_equal(colours, array[..., :3]) and repr(colours) == "<cvol.Colours 40 x 48 x 44 x 3 uint8>"
    assert colours._repr_png_().startswith(b"\x89PNG") and colours.geometry == lossless[0].geometry
    colours.close()
    with pytest.raises(ValueError, match="closed"):
        colours.render()


@pytest.mark.parametrize("count", [3, 4])
def test_other_formats(tmp_path, count):
    array = samples()[..., :count]
    np.save(tmp_path / "ball.npy", array)
    with cvol.open_colours(tmp_path / "ball.npy") as colours:
        assert np.array_equal(colours, array)
    lossy = cvol.open_colours(tmp_path / "ball.npy", compress={"effort": "fast", "labels": False})  # as the command
    assert np.array_equal(lossy.render(size=96), command_picture(tmp_path, tmp_path / "ball.npy", []))
    np.save(tmp_path / "grey.npy", array[..., 0])
    with pytest.raises(cvol.ArgumentError, match="grey.npy: has no colours"):
        cvol.open_colours(tmp_path / "grey.npy")


def test_one_component_comes_with_a_warning(tmp_path):
    compressed(samples()[..., :3]).save(tmp_path / "ball.cvol")
    with pytest.warns(UserWarning, match="ball.cvol: has colours, and this is its first component"):
        first = cvol.open(tmp_path / "ball.cvol")
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        again = cvol.open(tmp_path / "ball.cvol", channel=0)
        cvol.open_colours(tmp_path / "ball.cvol")
    assert np.array_equal(first, again)


def test_budget():
    colours = compressed(samples()[..., :3])
    assert np.array_equal(colours.render(size=64, budget_ms=1e6), colours.render(size=64))


def test_what_is_wrong(tmp_path):
    volume = cvol.compress(np.ascontiguousarray(samples()[..., 0]), lossless=True)
    with pytest.raises(ValueError, match="2 components are given, must be 3 or 4"):
        cvol.Colours([volume] * 2)
    with pytest.raises(ValueError, match="volume 2 differs from volume 0"):
        cvol.Colours([volume, volume, cvol.compress(samples()[:9, :, :, 0].copy())])
    volume.save(tmp_path / "grey.cvol")
    with pytest.raises(cvol.ArgumentError, match="grey.cvol: has no colours"):
        cvol.open_colours(tmp_path / "grey.cvol")
    for look in ({"mode": "mip"}, {"engine": "ray"}, {"transfer": "bone"}, {"iso": 3}, {"rescale": (1, 2)}):
        with pytest.raises(cvol.ArgumentError, match="drawn without it"):
            cvol.Colours([volume] * 3).render(**look)
    with pytest.raises(TypeError, match="unexpected keyword"):
        cvol.Colours([volume] * 3).render(nothing=1)
