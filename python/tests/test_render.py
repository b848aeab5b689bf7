"""Pictures: shape, type and content; renderers keep their state."""

import json
import signal
import struct
import zlib

import cvol
import numpy as np
import pytest
from cvol import _abi


def test_shapes(volume):
    assert volume.render(30, 20, size=(40, 30)).shape == (30, 40, 3)
    assert volume.render(30, 20, size=np.int64(24)).shape == (24, 24, 3)
    for size in ((3,), 24.5, "24", (1, 2, 3), None):
        with pytest.raises(ValueError, match="size is .*must be pixels"):
            volume.render(size=size)
    clear = volume.render(30, 20, size=32, background="transparent")
    assert clear.shape == (32, 32, 4) and clear.dtype == np.uint8
    assert clear[0, 0, 3] == 0 < clear[16, 16, 3]
    assert (volume.render(size=32, background="white")[0, 0] == 255).all()
    assert volume.render(size=32, annotate=True, mode="mip").shape == (32, 32, 3)


def test_it_shows_the_ball(volume, array):
    """Along -Y (azimuth 0) a picture's columns are x and its rows are -z."""
    picture = volume.render(0, 0, fit="box", mode="mip", size=256, window=(0, 500))[..., 0]
    rows, columns = np.nonzero(picture > 180)
    assert abs(rows.mean() - 127.5) < 3 and abs(columns.mean() - 127.5) < 3
    # The ball has equal radii in samples, 2 and 0.5 apart.
    assert (rows.max() - rows.min()) / (columns.max() - columns.min()) == pytest.approx(4, rel=0.2)
    lower = volume.render(0, 0, fit="box", mode="mip", size=256, window=(0, 500), clip=np.s_[:35])[..., 0]
    assert not (lower[:120] > 180).any() and (lower[140:] > 180).any()


def test_engines_agree(volume):
    look = dict(azimuth=30, elevation=20, fit="box", light="flat", size=64, transfer="gray")
    sheet = volume.render(**look).astype(float)
    for engine in ("ray", "splat", "transform"):
        other = volume.render(engine=engine, **look).astype(float)
        assert np.sqrt(((sheet - other) ** 2).mean()) < 25, engine
    assert volume.render(engine="fourier", size=64).max() > 0


def test_ray_order(volume):
    look = {"size": 60, "azimuth": 30}
    image, object_ = volume.render(ray_order="image", **look), volume.render(ray_order="object", **look)
    chosen = volume.render(**look)
    assert (chosen == volume.render(ray_order="auto", **look)).all()
    assert (chosen == image).all() or (chosen == object_).all()
    difference = np.abs(image.astype(int) - object_)
    assert 0 < difference.max() and difference.mean() < 10
    with pytest.raises(ValueError, match="ray_order is"):
        volume.render(ray_order="curved", **look)


def test_kept_blocks(volume):
    look = {"size": 60, "azimuth": 30}
    plain = volume.render(**look)
    with cvol.Renderer(volume) as renderer:
        for _ in range(2):
            assert (renderer.render(keep_mb=50, **look) == plain).all()
    with pytest.raises(Exception, match="keep_mb"):
        volume.render(keep_mb=-1, **look)


def test_footprints(volume):
    look = dict(azimuth=30, elevation=20, size=64, zoom=3)
    plain = volume.render(**look)
    assert (volume.render(footprint="linear", **look) == plain).all()
    for footprint in ("catmull-rom", "b-spline", "gaussian"):
        assert (volume.render(footprint=footprint, **look) != plain).any(), footprint
    for engine, footprint in (("sheet", "box"), ("splat", "linear")):
        with pytest.raises(ValueError, match="footprint is"):
            volume.render(engine=engine, footprint=footprint, **look)


def test_looks_differ(volume):
    plain = volume.render(30, 20, size=48)
    for look in (
        dict(shade=True), dict(iso=300), dict(zoom=2), dict(perspective=60), dict(level=2), dict(roll=40),
        dict(view="top"), dict(opacity_scale=3), dict(clip_planes=[(0, 1, 0, 0)]), dict(mode="xray"),
        dict(perspective=60, eye=(0, -90, 0)), dict(look_at=(3, 0, -2)), dict(transfer="hot"),
        dict(transfer=[[0, 0, 0, 0, 0], [400, 1, 0, 0, 0.5]]),
        dict(light="flat"), dict(light=(1, 0, 0)), dict(occlusion=0), dict(shadows=1), dict(fill_light=1), dict(fit="box"),
    ):  # fmt: skip
        assert not np.array_equal(volume.render(30, 20, size=48, **look), plain), look
    assert volume.render(30, 20, size=48, budget_ms=1e5).shape == plain.shape


def test_renderer(volume):
    with cvol.Renderer(volume) as renderer:
        points = renderer.transfer_points("auto")
        assert points.shape[1] == 5
        first = renderer.render(30, 20, size=64)
        assert np.array_equal(renderer.render(30, 20, size=64, transfer=points), first)
        points[:, 1:4] = (1, 0, 0)
        red = renderer.render(30, 20, size=64, transfer=points, light="flat")
        assert red[..., 0].max() > 0 == red[..., 1:].max()
        with cvol.options(threads=1):
            assert np.array_equal(renderer.render(30, 20, size=64), first)
    assert "auto" in cvol.transfer_names() and "ct-bone" in cvol.transfer_names()


@pytest.mark.parametrize("name, before, after, transfer", [
    ("window", (0, 300), (0, 900), "auto"), ("rescale", (1, 0), (3, -300), "ct-bone"),
])  # fmt: skip
def test_pairs_of_numbers(volume, name, before, after, transfer):
    """window and rescale may be arrays, and lists that the caller changes between two pictures."""
    first, second = (volume.render(30, 20, size=48, transfer=transfer, **{name: p}) for p in (before, after))
    assert not np.array_equal(first, second)
    with cvol.Renderer(volume) as renderer:
        for given in (np.array(before), list(before)):
            for _ in range(2):
                picture = renderer.render(30, 20, size=48, transfer=transfer, **{name: given})
                assert np.array_equal(picture, first)
            given[:] = after
            assert np.array_equal(renderer.render(30, 20, size=48, transfer=transfer, **{name: given}), second)
        assert np.array_equal(renderer.transfer_points(transfer, **{name: np.array(before)}),
                              renderer.transfer_points(transfer, **{name: before}))  # fmt: skip
        with pytest.raises(ValueError, match=f"{name} is .* must be 2 finite numbers"):
            renderer.render(size=16, transfer=transfer, **{name: (1, 2, 3)})


def test_points_that_change(volume):
    points = [[0, 0, 0, 0, 0], [500, 1, 1, 1, 1]]
    with cvol.Renderer(volume) as renderer:
        first = renderer.render(30, 20, size=48, transfer=points)
        with pytest.raises(ValueError, match="must have"):  # the same bytes in another shape
            renderer.render(30, 20, size=48, transfer=sum(points, []))
        points[1][1:4] = (1, 0, 0)
        assert not np.array_equal(renderer.render(30, 20, size=48, transfer=points), first)


def test_ctrl_c_while_the_transfer_function_is_set(volume, monkeypatch):
    """The next picture has the transfer function that it asks for, not that of the call that was stopped."""
    set_transfer = _abi.functions["renderer_set_transfer"]

    def interrupted(*arguments):
        code = set_transfer(*arguments)
        signal.raise_signal(signal.SIGINT)
        return code

    with cvol.Renderer(volume) as renderer:
        first = renderer.render(30, 20, size=48, window=(0, 300))
        with monkeypatch.context() as patch, pytest.raises(KeyboardInterrupt):
            patch.setitem(_abi.functions, "renderer_set_transfer", interrupted)
            renderer.render(30, 20, size=48, window=(0, 900))
        assert np.array_equal(renderer.render(30, 20, size=48, window=(0, 300)), first)


def test_default_look(volume, array):
    """The ball fills the picture, from a three-quarter view; a turn has one frame for all views."""
    visible = volume.render(size=100).max(axis=2) > 12
    rows, columns = np.nonzero(visible)
    assert max(np.ptp(rows), np.ptp(columns)) == pytest.approx(88, abs=9)
    assert np.array_equal(volume.render(size=48, transfer="dense"), volume.render(size=48, transfer="dense", light="flat"))
    assert not np.array_equal(volume.render(size=48, light="cinematic"), volume.render(size=48))
    assert not np.array_equal(volume.render(size=48, light="cinematic", samples=2), volume.render(size=48, light="cinematic"))
    assert np.array_equal(volume.render(size=48, light="studio", fit="object"), volume.render(size=48))
    turned = [volume.render(a, 10, size=100, fit="turn").max(axis=2) > 40 for a in (0, 60, 120)]
    assert all(not p[0].any() and not p[:, 0].any() and p[50, 50] for p in turned)
    with pytest.raises(ValueError, match="fit is"):
        volume.render(fit="all")
    with pytest.raises(ValueError, match="light is"):
        volume.render(light="dim")
    with pytest.raises(ValueError, match="fit='object' cannot"):
        volume.render(fit="object", perspective=40, eye=(0, -50, 0))
    with pytest.raises(ValueError, match="occlusion is 2"):
        volume.render(occlusion=2)
    with pytest.raises(ValueError, match="shadows"):
        volume.render(engine="splat", shade=True, shadows=1)


def test_depth(volume):
    with cvol.Renderer(volume) as renderer:
        depth = renderer.depth(0, 0, fit="box", iso=330, size=64)
        assert depth.shape == (64, 64) and depth.dtype == np.float32 and np.isinf(depth[0, 0])
        # The ball's radius is 8; its centre is half the box's diagonal behind the plane.
        half = np.linalg.norm((np.array(volume.shape) - 1) * volume.spacing) / 2
        assert half - 9 < depth[32, 32] < half
        with pytest.raises(TypeError, match="nothing"):
            renderer.depth(nothing=1)


def test_certify():
    z, y, x = np.indices((24, 26, 28))
    samples = (100 + 60 * np.sin(x / 4) * np.cos(y / 5) + 40 * np.cos(z / 3)).astype(np.uint8)
    points = [[60, 0.1, 0.2, 0.9, 0], [140, 0.9, 0.5, 0.2, 0.05], [200, 1, 0.9, 0.7, 0.3]]
    file, original = cvol.compress(samples, max_error=2), cvol.compress(samples, lossless=True)
    with cvol.Renderer(file, engine="ray") as drawn, cvol.Renderer(original, engine="ray") as exact:
        for look in (dict(transfer=points), dict(transfer=points, shade=True), dict(mode="mip")):
            lower, upper = drawn.certify(30, 20, size=40, **look)
            for renderer in (drawn, exact):
                picture = renderer.render(30, 20, fit="box", size=40, **{"light": None if look.get("shade") else "flat", **look})
                assert picture.shape == lower.shape and (lower <= picture).all() and (picture <= upper).all()
            assert (lower < upper).any()
        lower, upper = exact.certify(30, 20, size=40, transfer=points)
        assert np.array_equal(lower, upper)
        for wrong in (dict(annotate=True), dict(background="transparent"), dict(iso=100)):
            with pytest.raises((ValueError, NotImplementedError)):
                drawn.certify(size=16, **wrong)
        with pytest.raises(TypeError, match="nothing"):
            drawn.certify(nothing=1)
    with cvol.Renderer(file) as sheet, pytest.raises(ValueError, match="only engine ray"):
        sheet.certify(size=16)


def test_refusals(volume, tmp_path):
    for look in (
        dict(mode="nix"), dict(transfer="nix"), dict(background="nix"), dict(size=0), dict(view="nix"),
        dict(clip=np.s_[5:5]), dict(zoom=-1), dict(engine="nix"), dict(eye=(1, 2, 3)), dict(transfer="ct-bone"),
        dict(mode="iso"), dict(transfer=[1, 2]), dict(transfer=tmp_path / "nix.json"),
    ):  # fmt: skip
        with pytest.raises((ValueError, OSError)):
            volume.render(**{"size": 16, **look})
    with pytest.raises(TypeError):
        volume.render(nothing=1)
    flat = cvol.compress(np.ones((20, 20), "f4"), keep=cvol.Keep.all())
    with pytest.raises(ValueError, match="2 axes"):
        flat.render()
    assert flat._repr_png_()[:4] == b"\x89PNG"


def test_notebooks_and_png(volume, tmp_path):
    data = volume._repr_png_()
    assert data[:8] == b"\x89PNG\r\n\x1a\n" and struct.unpack(">II", data[16:24]) == (384, 384)
    picture = volume.render(size=(9, 7))
    cvol.save_png(tmp_path / "a.png", picture)
    data = (tmp_path / "a.png").read_bytes()
    length = struct.unpack(">I", data[33:37])[0]
    rows = np.frombuffer(zlib.decompress(data[41 : 41 + length]), np.uint8).reshape(7, 28)[:, 1:]
    assert np.array_equal(np.cumsum(rows, axis=0, dtype=np.uint8).reshape(7, 9, 3), picture)
    with pytest.raises(ValueError):
        cvol.save_png(tmp_path / "b.png", picture.astype(float))


def test_files_of_transfer_functions_have_the_values_that_samples_mean(array, tmp_path):
    samples = [[0, 1, 0, 0, 0], [300, 1, 1, 0, 0.1], [500, 0, 1, 1, 0.4]]
    values = [[3 * sample - 50, *colour] for sample, *colour in samples]
    (tmp_path / "own.json").write_text(json.dumps({"points": values}))
    rescaled = cvol.compress(array, 20, effort="fast", geometry=cvol.Geometry(value_scale=3.0, value_offset=-50.0))
    with cvol.Renderer(rescaled) as renderer:
        from_file = renderer.transfer_points(tmp_path / "own.json")
    assert np.allclose(from_file, samples)
    look = dict(azimuth=30, elevation=20, size=32, light="flat")
    assert np.array_equal(rescaled.render(transfer=tmp_path / "own.json", **look), rescaled.render(transfer=from_file, **look))
