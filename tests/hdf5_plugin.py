"""Datasets of compressed chunks, by h5py and without cvol, in plugin.h5 of the current folder: `write` creates
them, `read` compares them in another process, `damage` changes one. usage: hdf5_plugin.py write|read|damage"""

import struct
import sys

try:
    import h5py
    import numpy as np
except ImportError as error:
    print(f"skipped: {error}")
    sys.exit(77)

CVOL = 444
TYPES = "u1 i1 u2 i2 u4 i4 f4 f8 >i2 >f4".split()
RATIO, PSNR, MAX_ERROR, BITS, LOSSLESS = 1, 2, 3, 4, 5


def options(mode, value):
    return (mode, *struct.unpack("<II", struct.pack("<d", value)))


def samples(kind, shape=(20, 28, 36)):
    places = np.indices(shape)
    smooth = sum(np.sin(place / (5 + i)) for i, place in enumerate(places))
    noise = np.random.default_rng(3).normal(size=shape)
    return (60 + 15 * smooth + 2 * noise).astype(np.dtype(kind))


def write():
    with h5py.File("plugin.h5", "w") as file:

        def put(name, array, chunks, *words):
            file.create_dataset(name, data=array, chunks=chunks, compression=CVOL, compression_opts=words)

        for kind in TYPES:  # chunks of 16 x 24 x 36; HDF5 pads those at the edges
            put(f"lossless/{kind}", samples(kind), (16, 24, 36), LOSSLESS)
            put(f"bound/{kind}", samples(kind), (16, 24, 36), *options(MAX_ERROR, 1.5))
        put("ratio", samples("u2"), (20, 28, 36), RATIO, 8)
        put("psnr", samples("f4"), (20, 28, 36), *options(PSNR, 40.0))
        put("bits", samples("u1"), (20, 28, 36), *options(BITS, 0.9))
        put("default", samples("i2"), (20, 28, 36))
        put("one", samples("i2", (300,)), (100,), LOSSLESS)
        put("two", samples("i2", (30, 40)), (16, 40), LOSSLESS)
        put("five", samples("i2", (2, 3, 8, 9, 10)), (1, 1, 8, 9, 10), LOSSLESS)
        put("tiny", samples("u1", (3, 3, 3)), (1, 2, 3), LOSSLESS)
        put("empty", np.zeros((20, 28, 36), "f4"), (16, 16, 16), *options(PSNR, 40.0))
        holes = samples("f4")
        holes[3, 4, 5:9] = np.nan
        put("holes", holes, (20, 28, 36), *options(MAX_ERROR, 1.5))
        put("wide", samples("f8").astype("i8"), (20, 28, 36), LOSSLESS)  # cvol lacks this type: stored uncompressed
        try:
            put("wrong", samples("u1"), (20, 28, 36), 9, 1)
        except (ValueError, OSError) as error:
            assert "mode is 9" in str(error), error
        else:
            raise SystemExit("mode 9 was not refused")


def difference(a, b):
    return np.abs(a.astype(float) - b.astype(float)).max()


def read():
    assert "cvol" not in sys.modules
    with h5py.File("plugin.h5") as file:

        def size(name):
            return file[name].id.get_storage_size()

        for kind in TYPES:
            original = samples(kind)
            exact, bound = file[f"lossless/{kind}"][...], file[f"bound/{kind}"][...]
            assert exact.dtype == np.dtype(kind) and np.array_equal(exact, original), kind
            assert 0 < difference(bound, original) <= 1.5, kind
            padded = 2 * 2 * 16 * 24 * 36 * original.itemsize
            assert size(f"bound/{kind}") < size(f"lossless/{kind}") < padded, kind
        raw = samples("u2").nbytes
        assert 8 <= raw / size("ratio") <= 8 * 1.02, raw / size("ratio")
        original = samples("f4")
        peak = float(original.max() - original.min())
        error = np.sqrt(np.mean((file["psnr"][...].astype(float) - original) ** 2))
        assert 40 <= 20 * np.log10(peak / error) < 41
        assert 8 * size("bits") / original.size <= 0.9
        assert 25 < raw / size("default") < 32, raw / size("default")
        for name, shape in (("one", (300,)), ("two", (30, 40)), ("five", (2, 3, 8, 9, 10))):
            assert np.array_equal(file[name][...], samples("i2", shape)), name
        assert np.array_equal(file["tiny"][...], samples("u1", (3, 3, 3)))
        assert not file["empty"][...].any()
        holes = file["holes"][...]
        assert np.isnan(holes[3, 4, 5:9]).all() and np.isnan(holes).sum() == 4
        assert np.array_equal(file["wide"][...], samples("f8").astype("i8"))
        assert np.array_equal(file["lossless/u2"][7:19, 3, ::5], samples("u2")[7:19, 3, ::5])


def damage():
    with h5py.File("plugin.h5", "r+") as file:
        data = file["psnr"].id
        _, chunk = data.read_direct_chunk((0, 0, 0))
        for name, bad in (("cut", chunk[: len(chunk) // 2]), ("changed", chunk[:-40] + b"?" + chunk[-39:])):
            plan = data.get_create_plist()
            copy = h5py.h5d.create(file.id, name.encode(), data.get_type(), data.get_space(), plan)
            copy.write_direct_chunk((0, 0, 0), bad)
        plan = file["ratio"].id.get_create_plist()  # settings of another dataset
        other = h5py.h5d.create(file.id, b"other", h5py.h5t.NATIVE_UINT16, data.get_space(), plan)
        other.write_direct_chunk((0, 0, 0), chunk)
    with h5py.File("plugin.h5") as file:
        for name in ("cut", "changed", "other"):
            try:
                file[name][...]
            except OSError as error:
                assert "cvol: a chunk" in str(error), error
                print(f"{name}: {error}")
            else:
                raise SystemExit(f"{name} was read")


{"write": write, "read": read, "damage": damage}[sys.argv[1]]()
