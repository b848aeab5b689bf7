#!/usr/bin/env python3
"""Makes a wheel that needs no library but glibc, from the objects of a build.

usage: bundle.py BUILD_FOLDER WHEEL_FOLDER

It links libcvol.a of the build into the wheel's libcvol.so.0, with the static libraries of the system. Those that
cannot be linked statically are copied to cvol.libs/, with a name of their own, so that they are never mistaken for
the system's or another package's. The libraries that a wheel may contain, and why, are in LIBRARIES. The platform tag
names the oldest glibc that has all symbols in use.
"""

import hashlib
import re
import shutil
import subprocess
import sys
import tempfile
from pathlib import Path

HERE = Path(__file__).resolve().parent
CHECKOUT = HERE.parents[1]
sys.path.insert(0, str(CHECKOUT / "python" / "backend"))
sys.dont_write_bytecode = True

import cvol_wheel  # noqa: E402

# The licences of what may be in the wheel. Static libraries, in the order in which they need each other:
STATIC = {
    "libtiff": "libtiff licence; without libjbig, which is GPL (replacements.c)",
    "libblosc": "BSD",
    "liblz4": "BSD: the library; its programs are GPL",
    "libzstd": "BSD, or GPL at the user's choice",
    "libjansson": "MIT",
    "libgif": "MIT",
    "libwebpmux": "BSD",
    "libwebp": "BSD",
    "libjpeg": "IJG and BSD",
    "libpng16": "libpng licence",
    "liblzma": "public domain: the library; the scripts of xz are GPL",
    "libdeflate": "MIT",
    "libz": "zlib licence",
}
# Parts that the compiler adds:
RUNTIME = {
    "libgcc": "GPL with the exception for what GCC compiles",
    "libc_nonshared": "LGPL with the exception for what is linked with it",
}
# Shared: libturbojpeg.a and libgomp.a have variables of threads that only a program can link.
SHARED = {
    "libturbojpeg": "IJG and BSD",
    "libgomp": "GPL with the exception for what GCC compiles",
}
LIBRARIES = {**STATIC, **RUNTIME, **SHARED}
GLIBC = {"libc.so.6", "libm.so.6", "libpthread.so.0", "libdl.so.2", "librt.so.1", "ld-linux-x86-64.so.2"}


class Refused(Exception):
    """No wheel can be made; the message says why."""


class Missing(Refused):
    """This system lacks a library or a program."""


def run(*words):
    done = subprocess.run([str(word) for word in words], capture_output=True, text=True)
    if done.returncode:
        beginning = "\n".join(done.stderr.splitlines()[:6])
        raise Refused(f"{Path(words[0]).name} failed: {beginning}")
    return done.stdout


def find(name):
    """Returns the path of a library in the compiler's folders."""
    path = Path(run("cc", f"-print-file-name={name}").strip())
    if not path.is_absolute():
        raise Missing(f"there is no {name}: scripts/dependencies.sh build wheel installs it on Debian")
    return path.resolve()


def check_allowed(path):
    """Refuses a library whose licence nobody has looked at."""
    name = re.split(r"[-.]", Path(path).name)[0]
    if name not in LIBRARIES:
        raise Refused(f"{Path(path).name} is not in the list of libraries that the wheel may contain (bundle.py)")


def copy_shared(name, folder):
    """Copies a shared library under a name that holds its hash; returns its path."""
    source = find(f"{name}.so")
    soname = re.search(r"SONAME.*\[(.+)\]", run("readelf", "-d", source))[1]
    digest = hashlib.sha256(source.read_bytes()).hexdigest()[:8]
    copy = folder / soname.replace(".so", f"-{digest}.so")
    shutil.copyfile(source, copy)
    run("patchelf", "--set-soname", copy.name, copy)
    return copy


def link(build, folder, shared):
    """Links libcvol.so.0; returns its path and the static libraries that are in it."""
    archives = []
    for name in STATIC:
        archives.append(folder / f"{name}.a")
        streams = [f"--redefine-sym={stream}=cvol_wheel_{stream}" for stream in ("stdin", "stdout", "stderr")]
        run("objcopy", *streams, find(f"{name}.a"), archives[-1])
    library, replacements, map_file = (folder / name for name in (cvol_wheel.SONAME, "replacements.o", "map"))
    run("cc", "-O2", "-fPIC", "-Wall", "-Wextra", "-Werror", "-c", HERE / "replacements.c", "-o", replacements)
    run("cc", "-shared", "-s", "-o", library, f"-Wl,-soname,{cvol_wheel.SONAME}", "-Wl,-rpath,$ORIGIN/../cvol.libs",
        f"-Wl,--version-script={CHECKOUT / 'src' / 'libcvol.map'}", "-Wl,--wrap=hypot", "-Wl,--no-undefined",
        "-Wl,--as-needed", "-Wl,--gc-sections", "-Wl,-z,text", f"-Wl,-Map={map_file}", "-Wl,--whole-archive",
        build / "libcvol.a", "-Wl,--no-whole-archive", replacements, *archives, *shared, "-static-libgcc", "-lm",
        "-ldl", "-lpthread")  # fmt: skip
    used = set(re.findall(r"^(\S*/lib[^/\s(]+\.a)\(", map_file.read_text(), re.M)) - {str(build / "libcvol.a")}
    return library, sorted(used)


def check_needs(paths):
    """Refuses libraries that need another one than glibc and themselves."""
    names = {path.name for path in paths}
    for path in paths:
        for needed in re.findall(r"NEEDED.*\[(.+)\]", run("readelf", "-d", path)):
            if needed not in GLIBC | names:
                raise Refused(f"{path.name} needs {needed}, which is neither glibc nor in the wheel")


def platform_tag(paths):
    """Returns the platform of the oldest glibc that has all symbols of these libraries."""
    newest = (0, 0)
    for path in paths:
        if "X86-64" not in run("readelf", "-h", path):
            raise Refused(f"{path.name} is not for x86-64: use pip wheel ./python")
        needs = run("readelf", "-V", "-W", path).partition("Version needs section")[2]
        for version in re.findall(r"Name: (GLIBC\w+(?:\.\d+)*)", needs):
            number = re.fullmatch(r"GLIBC_(\d+)\.(\d+)(?:\.\d+)?", version)
            if not number:
                raise Refused(f"{path.name} needs {version}: no platform tag says which glibc has it")
            newest = max(newest, (int(number[1]), int(number[2])))
    return f"manylinux_{newest[0]}_{newest[1]}_x86_64"


def licences(paths):
    """Yields (name, bytes) of the licences of cvol, of its copies in third_party, and of these libraries."""
    for path in (CHECKOUT / "LICENSE", CHECKOUT / "LICENSE-NOTES.md"):
        yield path.name, path.read_bytes()
    for path in sorted((CHECKOUT / "third_party").glob("*/LICENSE")):
        yield f"{path.parent.name}/LICENSE", path.read_bytes()
    for path in paths:
        package = run("dpkg-query", "--search", path).split(":")[0]
        text = Path("/usr/share/doc") / package / "copyright"
        if not text.is_file():
            raise Refused(f"there is no {text}: the wheel must contain the licence of {path.name}")
        yield f"{path.name.split('.')[0]}/copyright", text.read_bytes()


def make(build, out):
    """Writes the wheel; returns its path."""
    if shutil.which("patchelf") is None:
        raise Missing("there is no patchelf: scripts/dependencies.sh wheel installs it on Debian")
    if not (build / "libcvol.a").is_file():
        raise Refused(f"there is no {build / 'libcvol.a'}: build it first")
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        shared = [copy_shared(library, folder) for library in SHARED]
        library, static = link(build, folder, shared)
        elf = [library, *shared]
        for path in (*static, *shared):
            check_allowed(path)
        check_needs(elf)
        tag = f"py3-none-{platform_tag(elf)}"
        sources = [find(Path(path).name) for path in static] + [find(f"{library}.so") for library in SHARED]
        files = [(f"cvol/{library.name}", library.read_bytes(), 0o755)]
        files += [(f"cvol.libs/{path.name}", path.read_bytes(), 0o755) for path in shared]
        out.mkdir(parents=True, exist_ok=True)
        return out / cvol_wheel.write_wheel(out, cvol_wheel.modules() + files, tag, licences(sources))


def main():
    if len(sys.argv) != 3:
        print("usage: bundle.py BUILD_FOLDER WHEEL_FOLDER", file=sys.stderr)
        sys.exit(2)
    try:
        wheel = make(Path(sys.argv[1]).resolve(), Path(sys.argv[2]))
    except Refused as error:
        print(f"bundle.py: {error}", file=sys.stderr)
        sys.exit(1)
    print(f"{wheel}: {wheel.stat().st_size / 1e6:.1f} MB")


if __name__ == "__main__":
    main()
