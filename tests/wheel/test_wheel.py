"""Makes a wheel (python/wheel/bundle.py), unpacks it alone, and uses it without the libraries of the system.

The oracles: objdump for the oldest glibc, /proc/self/maps for the libraries in use, and the build's libcvol.so, whose
files and pictures must be the same bytes.

usage: test_wheel.py SOURCE_FOLDER BUILD_FOLDER FOLDER
"""

import importlib.util
import os
import re
import shutil
import subprocess
import sys
import zipfile
from pathlib import Path

SOURCE, BUILD, FOLDER = (Path(word).resolve() for word in sys.argv[1:])
sys.path.insert(0, str(SOURCE / "python" / "wheel"))

import bundle  # noqa: E402

HERE = Path(__file__).resolve().parent


def check_refusals():
    """A library that is GPL or unknown, one that is not in the wheel, a symbol of an unknown glibc."""
    for name in ("libjbig.a", "libfftw3f-0123abcd.so.3", "libgsl.so.27", "libz2.a"):
        refuse(lambda: bundle.check_allowed(name), name, "not in the list")
    refuse(lambda: bundle.check_needs([BUILD / "libcvol.so.0"]), "libcvol.so.0 needs", "neither glibc nor in the wheel")
    refuse(lambda: bundle.platform_tag([bundle.find("libm.so.6")]), "libm.so.6 needs GLIBC_PRIVATE", "no platform tag")
    refuse(lambda: bundle.find("libabsent.a"), "there is no libabsent.a")


def refuse(call, *words):
    try:
        call()
    except bundle.Refused as error:
        assert all(word in str(error) for word in words) and "\n" not in str(error), error
    else:
        raise AssertionError(f"not refused: {words}")


def check_contents(wheel, site):
    """The wheel's names, its licences, and the symbols that its libraries want of glibc and show to others."""
    info = next(site.glob("cvol-*.dist-info"))
    tag = re.search(r"^Tag: py3-none-(manylinux_2_(\d+)_x86_64)$", (info / "WHEEL").read_text(), re.M)
    assert wheel.name.endswith(f"-{tag[1]}.whl")
    shared = sorted((site / "cvol.libs").iterdir())
    assert [re.sub(r"-[0-9a-f]{8}\.", ".", path.name) for path in shared] == ["libgomp.so.1", "libturbojpeg.so.0"]
    assert all(re.search(r"-[0-9a-f]{8}\.so", path.name) for path in shared)
    assert [path.name for path in (site / "cvol").glob("*.so*")] == ["libcvol.so.0"]
    newest = 0
    for path in (site / "cvol" / "libcvol.so.0", *shared):
        symbols = subprocess.run(["objdump", "-T", path], capture_output=True, text=True, check=True).stdout
        newest = max(newest, *(int(n) for n in re.findall(r"\*UND\*.*\(GLIBC_2\.(\d+)", symbols)))
        if path.name == "libcvol.so.0":
            shown = re.findall(r"^\S+ g.* (\S+)$", symbols, re.M)
            assert len(shown) > 200 and all(name.startswith("cvol_") for name in shown)
    assert int(tag[2]) == newest
    names = {path.name for path in (info / "licenses").iterdir()}
    assert {"LICENSE", "LICENSE-NOTES.md", "libtiff", "libz", "libgomp", "libturbojpeg"} <= names
    assert not names & {"libjbig", "libLerc", "libsnappy", "libstdc++"}


def use(site, library, folder):
    """Runs use_wheel.py with the wheel, or with the build's library and the checkout's package."""
    folder.mkdir()
    environment = {name: value for name, value in os.environ.items() if not name.startswith(("CVOL_", "LD_"))}
    if library:
        environment["CVOL_LIBRARY"] = str(library)
    environment["PYTHONPATH"] = str(site)
    words = [sys.executable, HERE / "use_wheel.py", SOURCE / "samples" / "ch2better.nii.gz"]
    if not library:
        words.append(site)
    done = subprocess.run(words, cwd=folder, env=environment, capture_output=True, text=True, timeout=200)
    assert done.returncode == 0, done.stdout + done.stderr
    return done.stdout


shutil.rmtree(FOLDER, ignore_errors=True)
check_refusals()
try:
    wheel = bundle.make(BUILD, FOLDER)
except bundle.Missing as error:
    print(f"skipped: {error}")
    sys.exit(77)
site = FOLDER / "site"
if importlib.util.find_spec("pip"):
    subprocess.run([sys.executable, "-m", "pip", "install", "-q", "--no-index", "--no-deps", "--target", site,
                    "--disable-pip-version-check", "--root-user-action", "ignore", wheel], check=True)  # fmt: skip
else:
    print("there is no pip: the wheel was only unpacked")
    with zipfile.ZipFile(wheel) as archive:
        archive.extractall(site)
check_contents(wheel, site)
report = use(site, None, FOLDER / "alone")
print(report, end="")
assert report == use(SOURCE / "python", BUILD / "libcvol.so.0", FOLDER / "build")
made = sorted(path.relative_to(FOLDER / "alone") for path in (FOLDER / "alone").rglob("*") if path.is_file())
assert len(made) > 8
for name in made:
    assert (FOLDER / "alone" / name).read_bytes() == (FOLDER / "build" / name).read_bytes(), name
print(f"{wheel.name}: {wheel.stat().st_size / 1e6:.1f} MB; {len(made)} files are the same as the build's library makes")
