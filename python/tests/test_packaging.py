"""The wheel, and the recipes of packaging/: syntax, version, dependencies, and that what they name exists."""

import importlib
import os
import re
import shutil
import subprocess
import sys
import zipfile
from configparser import ConfigParser
from pathlib import Path

import cvol
import pytest

ROOT = Path(cvol.__file__).resolve().parents[2]
PACKAGING = ROOT / "packaging"
if not PACKAGING.is_dir():
    pytest.skip("the package is not in a checkout: the recipes are not tested", allow_module_level=True)


def needed():
    """The Debian packages that the build needs."""
    text = (ROOT / "scripts" / "dependencies.sh").read_text()
    return set(re.search(r"^build='(.*)'$", text, re.M)[1].split())


def test_the_wheel(tmp_path, monkeypatch):
    """The unpacked wheel works without the checkout, and its entry points name what exists."""
    from cvol._library import load

    monkeypatch.syspath_prepend(str(ROOT / "python" / "backend"))
    monkeypatch.setenv("CVOL_LIBRARY", load()._name)
    name = importlib.import_module("cvol_wheel").build_wheel(str(tmp_path))
    assert re.fullmatch(rf"cvol-{re.escape(cvol.__version__)}-py3-none-\w+\.whl", name)
    with zipfile.ZipFile(tmp_path / name) as archive:
        assert archive.testzip() is None
        archive.extractall(tmp_path / "site")
        record = archive.read(f"cvol-{cvol.__version__}.dist-info/RECORD").decode()
        assert {line.split(",")[0] for line in record.split()} == set(archive.namelist())
    site = tmp_path / "site"
    entries = ConfigParser()
    entries.read(site / f"cvol-{cvol.__version__}.dist-info" / "entry_points.txt")
    for section in entries.sections():
        for target in entries[section].values():
            module, _, member = target.partition(":")
            path = site.joinpath(*module.split("."))
            if section == "napari.manifest":
                assert (path / member).is_file()
            else:
                assert re.search(rf"^(class|def) {member}\b", path.with_suffix(".py").read_text(), re.M)
    code = "import numpy, cvol; print(cvol.__file__, cvol.compress(numpy.zeros((8, 8, 8), 'u1'), lossless=True).shape)"
    environment = {key: value for key, value in os.environ.items() if key not in ("CVOL_LIBRARY", "PYTHONPATH")}
    run = subprocess.run([sys.executable, "-c", code], cwd=tmp_path, env={**environment, "PYTHONPATH": str(site)},
                         capture_output=True, text=True, timeout=60)  # fmt: skip
    assert run.stdout == f"{site / 'cvol' / '__init__.py'} (8, 8, 8)\n", run.stderr


def test_make_wheel():
    assert re.search(r"^wheel:", (ROOT / "Makefile").read_text(), re.M)


def test_dockerfile():
    text = (PACKAGING / "docker" / "Dockerfile").read_text()
    joined = re.sub(r"\\\n\s*", " ", text)
    words = {line.split()[0] for line in joined.splitlines() if line and not line.startswith("#")}
    assert words == {"FROM", "RUN", "COPY", "WORKDIR", "ENTRYPOINT"}
    installed = set(re.search(r"--no-install-recommends (.*?)$", joined, re.M)[1].split())
    assert needed() - installed == set(), "packages of scripts/dependencies.sh are missing"
    assert "cpack" in (ROOT / "cmake" / "install.cmake").read_text()
    if shutil.which("sh"):
        for command in re.findall(r"^RUN (.*)$", joined, re.M):
            subprocess.run(["sh", "-n", "-c", command], check=True)


def test_conda_recipe():
    yaml = pytest.importorskip("yaml", reason="yaml is not installed: the recipe for conda is not read")
    text = (PACKAGING / "conda" / "meta.yaml").read_text()
    recipe = yaml.safe_load(re.sub(r"\{\{ compiler\('c'\) \}\}", "gcc", text))
    assert recipe["package"] == {"name": "cvol", "version": cvol.__version__}
    assert (PACKAGING / "conda" / recipe["source"]["path"] / "CMakeLists.txt").is_file()
    assert (ROOT / recipe["about"]["license_file"]).is_file()
    assert {"zlib", "libpng", "zstd", "jansson", "giflib"} <= set(recipe["requirements"]["host"])
    assert "numpy" in recipe["requirements"]["run"]
    for command in recipe["build"]["script"]:
        subprocess.run(["sh", "-n", "-c", command], check=True)
    check_options(text)


def check_options(text):
    """The options of CMake exist."""
    listed = (ROOT / "CMakeLists.txt").read_text()
    used = set(re.findall(r"-D(CVOL_\w+)=", text))
    assert used and all(re.search(rf"\b(option|set)\({name} ", listed) for name in used)


def test_homebrew_formula():
    path = PACKAGING / "homebrew" / "cvol.rb"
    text = path.read_text()
    assert text.count("\n  def ") + text.count(" do\n") + 1 == len(re.findall(r"^\s*end$", text, re.M))
    assert f'"{cvol.__version__}"' in text and re.search(r"^class Cvol < Formula$", text, re.M)
    runtime = re.findall(r'^  depends_on "(\w+)"$', text, re.M)
    assert runtime == sorted(runtime) and {"giflib", "jansson", "libpng", "zstd"} <= set(runtime)
    check_options(text)
    if shutil.which("ruby"):
        subprocess.run(["ruby", "-c", path], check=True, stdout=subprocess.DEVNULL)


def test_workflow():
    yaml = pytest.importorskip("yaml", reason="yaml is not installed: the workflow is not read")
    text = (PACKAGING / "github" / "check.yml").read_text()
    workflow = yaml.safe_load(text)
    assert workflow["name"] == "check" and workflow[True] == ["push", "pull_request"]  # "on" is True in YAML 1.1
    targets = re.findall(r"^([a-z-]+):", (ROOT / "Makefile").read_text(), re.M)
    for job in workflow["jobs"].values():
        assert re.fullmatch(r"(ubuntu|macos)-[\d.]+", job["runs-on"])
        assert job["steps"][0]["uses"].startswith("actions/checkout@")
        for step in job["steps"][1:]:
            subprocess.run(["sh", "-n", "-c", step["run"]], check=True)
            for script in re.findall(r"scripts/\w+\.sh", step["run"]):
                assert os.access(ROOT / script, os.X_OK)
            assert all(target in targets for target in re.findall(r"\bmake (\w+)", step["run"]))
    check_options(text)
