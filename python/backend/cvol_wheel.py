"""Makes the wheel of the package: its Python files and libcvol (PEP 517, PEP 660; standard library only).

The library is, in this order: the file in CVOL_LIBRARY; the build in the checkout around this folder (build/); an
installed library; a new build by CMake, which takes some minutes.
"""

import base64
import hashlib
import os
import re
import subprocess
import sys
import sysconfig
import tarfile
import zipfile
from pathlib import Path

ROOT = Path(__file__).resolve().parents[1]
CHECKOUT = ROOT.parent
SONAME = "libcvol.so.0"
REQUIRES_PYTHON = ">=3.9"
DEPENDENCIES = ["numpy>=1.21"]


def _version():
    text = (ROOT / "cvol" / "_library.py").read_text()
    return re.search(r'^VERSION = "(.+)"$', text, re.M).group(1)


def _metadata():
    lines = [
        "Metadata-Version: 2.1", "Name: cvol", f"Version: {_version()}",
        "Summary: Volumes that stay compressed while they are sliced, rendered and computed with",
        "License: BSD-3-Clause", f"Requires-Python: {REQUIRES_PYTHON}",
        *[f"Requires-Dist: {name}" for name in DEPENDENCIES], "Description-Content-Type: text/markdown",
    ]  # fmt: skip
    return "\n".join(lines) + "\n\n" + (ROOT / "README.md").read_text()


def _installed():
    """Returns the path of an installed libcvol, from pkg-config."""
    try:
        run = subprocess.run(["pkg-config", "--variable=libdir", "cvol"], capture_output=True, text=True, check=True)
    except (OSError, subprocess.CalledProcessError):
        return None
    return Path(run.stdout.strip()) / SONAME


def _build():
    """Builds the library in the build folder of the checkout."""
    folder = CHECKOUT / "build"
    print("libcvol is neither built nor installed: building it", file=sys.stderr)
    subprocess.run(["cmake", "-S", str(CHECKOUT), "-B", str(folder), "-DCVOL_TESTS=OFF"], check=True)
    jobs = str(os.cpu_count() or 2)
    subprocess.run(["cmake", "--build", str(folder), "-j", jobs, "--target", "cvol_shared"], check=True)
    return folder / SONAME


def _library():
    named = os.environ.get("CVOL_LIBRARY")
    if named:
        if not Path(named).is_file():
            raise FileNotFoundError(f"CVOL_LIBRARY names {named}, which is not there")
        return Path(named)
    for path in (CHECKOUT / "build" / SONAME, _installed()):
        if path is not None and path.is_file():
            return path
    return _build()


def _on_demand(library):
    """Returns the shared objects that the library loads on demand, next to it or in a separate folder."""
    for folder in (library.parent, library.parent / "cvol"):
        yield from sorted(folder.glob("cvol_*.so"))


def _tag():
    platform = re.sub(r"[-.]", "_", sysconfig.get_platform())
    return f"py3-none-{platform}"


def write_wheel(folder, files, tag, licences=()):
    """files: (name in the wheel, bytes, mode); licences: (name, bytes). Returns the wheel's name."""
    info = f"cvol-{_version()}.dist-info"
    wheel = f"Wheel-Version: 1.0\nGenerator: cvol_wheel\nRoot-Is-Purelib: false\nTag: {tag}\n"
    files = [
        *files, *((f"{info}/licenses/{name}", text, 0o644) for name, text in licences),
        (f"{info}/METADATA", _metadata().encode(), 0o644), (f"{info}/WHEEL", wheel.encode(), 0o644),
        (f"{info}/entry_points.txt", (ROOT / "entry_points.txt").read_bytes(), 0o644),
    ]  # fmt: skip
    name = f"cvol-{_version()}-{tag}.whl"
    record = []
    with zipfile.ZipFile(Path(folder) / name, "w", zipfile.ZIP_DEFLATED) as archive:
        for place, data, mode in files:
            entry = zipfile.ZipInfo(place, (1980, 1, 1, 0, 0, 0))
            entry.external_attr = (0o100000 | mode) << 16
            entry.compress_type = zipfile.ZIP_DEFLATED
            archive.writestr(entry, data)
            digest = base64.urlsafe_b64encode(hashlib.sha256(data).digest()).rstrip(b"=").decode()
            record.append(f"{place},sha256={digest},{len(data)}")
        archive.writestr(f"{info}/RECORD", "\n".join([*record, f"{info}/RECORD,,", ""]))
    return name


def modules():
    """Returns the files of the package in Python, as write_wheel wants them."""
    paths = sorted((ROOT / "cvol").iterdir())
    return [
        (f"cvol/{path.name}", path.read_bytes(), 0o644)
        for path in paths
        if path.suffix in (".py", ".yaml") or path.name == "py.typed"
    ]


def build_wheel(wheel_directory, config_settings=None, metadata_directory=None):
    library = _library().absolute()
    files = [*modules(), (f"cvol/{SONAME}", library.read_bytes(), 0o755)]
    files += [(f"cvol/{path.name}", path.read_bytes(), 0o755) for path in _on_demand(library)]
    return write_wheel(wheel_directory, files, _tag())


def build_editable(wheel_directory, config_settings=None, metadata_directory=None):
    """Makes an editable wheel: the package in place; it finds the library in the build folder of the checkout."""
    return write_wheel(wheel_directory, [("cvol.pth", f"{ROOT}\n".encode(), 0o644)], _tag())


def build_sdist(sdist_directory, config_settings=None):
    """The Python part only: makes a wheel if libcvol is installed."""
    base = f"cvol-{_version()}"
    with tarfile.open(Path(sdist_directory) / f"{base}.tar.gz", "w:gz") as archive:
        for folder in ("backend", "cvol", "tests", "examples", "README.md", "entry_points.txt", "pyproject.toml"):
            archive.add(
                ROOT / folder,
                f"{base}/{folder}",
                filter=lambda entry: None if "__pycache__" in entry.name or ".so" in entry.name else entry,
            )
    return f"{base}.tar.gz"
