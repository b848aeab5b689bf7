"""usage: failures.py CVOL SHIM FOLDER [options]

Runs commands of cvol under faults.so (tests/helpers/faults.c), each many times. Each time one call of a family fails:
one allocation, one read, and so on. Every run must end in one of two ways:

    exit 0   with the outputs of a run without a failure, to the byte
    exit 1   with one sentence that states the reason, no new file, old files as they were, and not all text of success

Options:
  --all            whole call stacks, each at its first, second and last call (default: the last 6 frames, the first call)
  --modes          also short transfers, interrupted calls, and disks that become full
  --named          the file system has no files without a name (O_TMPFILE), and does not exchange names
  --part I/N       one of N parts of the fault points; I from 1, or the word turn: by the variable CVOL_TURN
  --only TEXT      commands whose name contains TEXT; several: separated by commas
  --family NAME    one family of calls
  --threads N      threads of the commands (default 1)
  --jobs N         commands at once (default 1)
  --limit SECONDS  time limit of one run (default 20)
  --depth N        frames that make a call stack (default: 6; with --all 48)
  --verbose        every finding with the stack of the call

A fault point is a family of calls at one call stack. "once": one call fails; "from": all later ones fail too. Calls by
libgomp are not counted (see faults.c)."""
import argparse
import collections
import concurrent.futures
import os
import re
import shutil
import signal
import struct
import subprocess
import sys
import threading
import time

import commands
import inputs

# Each family of calls with the errors that its calls return, and the words of the sentence. "once" is one call, "from"
# that call and all later ones.
IO = "Input/output error"
FAMILIES = {
    "memory": (("ENOMEM", ("once", "from"), "memory"),),
    "read": (("EIO", ("once",), IO),),
    "write": (("ENOSPC", ("once", "from"), "No space left on device|standard output"),),
    "sync": (("EIO", ("once",), IO),),
    "name": (("EACCES", ("once",), "Permission denied"),),
    "map": (("ENOMEM", ("once", "from"), "memory"),),
    "open": (("EMFILE", ("once", "from"), "Too many open files"),),
    "close": (("EIO", ("once",), IO),),
    "size": (("EIO", ("once",), IO),),
    "status": (("EIO", ("once",), IO),),
    "thread": (("EAGAIN", ("once", "from"), "thread|Resource temporarily"),),
}
NAMES = list(FAMILIES)  # in the order of faults.c

Fault = collections.namedtuple("Fault", "family call how error")


HERE = os.path.dirname(os.path.abspath(__file__))


def find_python(library):
    """A Python with NumPy, for the package; None: there is none, or no shared library."""
    for python in (sys.executable, "/usr/bin/python3"):
        if os.path.exists(library) and os.path.exists(python) and not subprocess.run(
                [python, "-c", "import numpy"], capture_output=True, check=False).returncode:
            return python
    return None


class Runner:
    def __init__(self, options):
        self.o = options
        self.inputs = os.path.join(options.folder, "in")
        self.lock = threading.Lock()
        self.free = []
        self.made = 0

    def place(self):
        with self.lock:
            if self.free:
                return self.free.pop()
            self.made += 1
            return os.path.join(self.o.folder, "run-%d" % self.made)

    def execute(self, words, settings, old):
        """Runs a command in a folder with the old files: status (None: too long), stdout, stderr, files, report."""
        place = self.place()
        work = os.path.join(place, "work")
        shutil.rmtree(place, ignore_errors=True)
        os.makedirs(work)
        os.mkdir(os.path.join(place, "tmp"))
        for name, data in old.items():
            with open(os.path.join(work, name), "wb") as file:
                file.write(data)
        report = os.path.join(place, "report")
        environment = dict(os.environ, LC_ALL="C", OMP_WAIT_POLICY="passive", TMPDIR=os.path.join(place, "tmp"),
                           CVOL_FAULT_REPORT=report, **settings)
        environment.update(PYTHONPATH=os.path.join(HERE, "..", "..", "python"),
                           CVOL_LIBRARY=os.path.join(os.path.dirname(self.o.cvol), "libcvol.so.0"))
        if settings:
            environment["LD_PRELOAD"] = self.o.shim
            environment["ASAN_OPTIONS"] = ("verify_asan_link_order=0:exitcode=99:allocator_may_return_null=1:"
                                           "detect_leaks=1:" + os.environ.get("ASAN_OPTIONS", ""))
            if any(word.endswith("a.h5") for word in words):  # libhdf5 itself crashes, or never ends, without memory
                environment["CVOL_FAULT_ONLY"] = "cvol"
            if words[0] == self.o.python:
                environment.update(CVOL_FAULT_LATE="1", CVOL_FAULT_ONLY="libcvol")
            environment["UBSAN_OPTIONS"] = "exitcode=99:print_stacktrace=1"
        with subprocess.Popen(words, cwd=work, env=environment, stdin=subprocess.DEVNULL, stdout=subprocess.PIPE,
                              stderr=subprocess.PIPE, start_new_session=True) as process:
            try:
                out, err = process.communicate(timeout=self.o.limit)
                status = process.returncode
            except subprocess.TimeoutExpired:
                os.killpg(process.pid, signal.SIGKILL)
                out, err = process.communicate()
                status = None
        files = {}
        for top, folders, names in os.walk(work):
            for name in names + folders:
                path = os.path.join(top, name)
                inner = os.path.relpath(path, work)
                files[inner] = None if os.path.isdir(path) else open(path, "rb").read()
        for name in os.listdir(os.path.join(place, "tmp")):
            files["tmp/" + name] = b""
        text = b""
        if os.path.exists(report):
            with open(report, "rb") as file:
                text = file.read()
        with self.lock:
            self.free.append(place)
        return status, out, err.decode(errors="replace"), files, text

    def words(self, command):
        if command.startswith("PYTHON "):
            return [self.o.python, "-B", os.path.join(HERE, "python_open.py"), command[7:].replace("IN/", self.inputs + "/")]
        cvol = self.o.cvol
        if command.startswith("ALONE "):
            cvol, command = os.path.join(self.inputs, "alone", "cvol"), command[6:]
        words = [w.replace("IN/", self.inputs + "/") for w in command.split()]
        return [cvol] + words + ["--threads", str(self.o.threads)]


def without_times(text):
    """The text with T for durations."""
    text = re.sub(rb'("[a-z_]*(_ms|seconds)": )[-0-9.e+]+', rb"\1T", text)
    return re.sub(rb"[0-9.e+]+ (ms|s)\b", rb"T \1", text)


def reached(report):
    return report.startswith(b"fault ")


def is_of_libtiff(result):
    """libtiff 4.5 itself crashes if an allocation fails while it reads a directory (TIFFVSetField counts an entry that
    it could not add)."""
    frames = [f for f in result[4].decode(errors="replace").split()[3:] if "faults.so" not in f]
    return result[0] == -signal.SIGSEGV and frames and "libtiff" in frames[0]


def is_mixture(files, old, new):
    """Each file is the old one or the complete new one."""
    return set(files) == set(old) and all(files[name] in (old[name], new.get(name, 0)) for name in files)


def judge(fault, result, normal, old, name=""):
    """None, or what is wrong."""
    status, out, err, files, report = result
    _, normal_out, normal_err, normal_files, _ = normal
    if status is None:
        return "hangs"
    if is_of_libtiff(result):
        return None
    if status < 0:
        return "ends by signal %d" % -status
    if "Sanitizer" in err or "runtime error" in err or status == 99:
        return "sanitizer: " + next((x for x in err.split("\n") if "ERROR" in x or "runtime error" in x), err[:200])
    hidden = [file for file in set(files) - set(normal_files) if os.path.basename(file).startswith(".") or file.startswith("tmp/")]
    if hidden:
        return "leaves " + " ".join(hidden)
    if status == 0:
        for file in sorted(set(files) | set(normal_files)):
            if files.get(file, 0) != normal_files.get(file, 0):
                return "exit 0 with another %s" % file
        if without_times(out) != without_times(normal_out):
            return "exit 0 with other text on stdout"
        if err != normal_err:
            return "exit 0 with other text on stderr: %r" % err[:200]
        return None
    if status != 1:
        return "exit %d: %r" % (status, err[:200])
    lines = err.split("\n")
    for note in normal_err.split("\n"):
        if note in lines:
            lines.remove(note)
    lines = [line for line in lines if line]
    if name in commands.SEPARATE:
        lines = [line for line in lines if not re.search(r"of \d+ volumes failed", line)]
        if lines and all(line.startswith("cvol: ") for line in lines):
            lines = lines[:1]  # one for each file
    if len(lines) != 1 or not lines[0].startswith("cvol: "):
        return "must print one sentence: %r" % err[:300]
    if "(null)" in lines[0] or not re.search(fault.words, lines[0]):
        return "must state the reason: %r" % lines[0]
    if re.search("standard output|for the JSON output|whole description|was written", lines[0]) and files == normal_files:
        return None  # the file is complete; the report of it is not
    if normal_out and name not in commands.SEPARATE and without_times(out) == without_times(normal_out):
        return "exit 1 after the text of success"
    if files != old and not (name in commands.SEPARATE and is_mixture(files, old, normal_files)):
        wrong = [file for file in sorted(set(files) | set(old)) if files.get(file, 0) != old.get(file, 0)]
        return "exit 1 changes files: " + " ".join(wrong)
    return None


class Point(Fault):
    words = ""


def plan(records, options):
    """The faults of a recorded run: for each stack its first call; with --all also its second and last one."""
    at = collections.defaultdict(lambda: collections.defaultdict(list))
    counts = collections.Counter()
    for family, stack in struct.iter_unpack("=IxxxxQ", records):
        counts[NAMES[family]] += 1
        at[NAMES[family]][stack].append(counts[NAMES[family]])
    faults = []
    for family, stacks in at.items():
        if options.family and family not in options.family.split(","):
            continue
        for error, ways, words in FAMILIES[family]:
            for calls in stacks.values():
                chosen = [calls[0]]
                if options.all:
                    chosen += calls[1:2] + calls[-1:]
                for how in ways:
                    for call in sorted(set(chosen)) if how == "once" else calls[:1]:
                        point = Point(family, call, how, error)
                        point.words = words
                        faults.append(point)
    return faults, counts, sum(len(s) for f, s in at.items() if not options.family or f in options.family.split(","))


def name_frames(report):
    """The functions of a stack, by addr2line."""
    names = []
    for frame in report.decode(errors="replace").split("\n")[0].split()[3:]:
        path, _, offset = frame.rpartition("+")
        if "faults.so" in path or not os.path.exists(path):
            continue
        if "/cvol" not in path and "libcvol" not in path:
            names.append(os.path.basename(path))
            continue
        found = subprocess.run(["addr2line", "-f", "-s", "-e", path, hex(int(offset, 16) - 1)], capture_output=True,
                               text=True, check=False).stdout.split("\n")
        names.append("%s (%s)" % (found[0], found[1]) if len(found) > 1 and "?" not in found[1] else found[0])
    return names


def settings_of(fault, options):
    settings = {"CVOL_FAULT": "%s:%d%s:%s" % (fault.family, fault.call, "+" if fault.how == "from" else "", fault.error)}
    if options.named:
        settings["CVOL_FAULT_NAMED"] = "1"
    return settings


def check_modes(runner, words, normal, old, findings, name):
    """Short transfers, interruptions, and a disk that becomes full after each of a number of bytes."""
    runs = 0
    ways = [{"CVOL_FAULT_SHORT": "1"}, {"CVOL_FAULT_SHORT": "1000"}, {"CVOL_FAULT_EINTR": "2"}, {"CVOL_FAULT_EINTR": "3"},
            {"CVOL_FAULT_SHORT": "7", "CVOL_FAULT_EINTR": "5", "CVOL_FAULT_NAMED": "1"}]
    for settings in ways:
        result = runner.execute(words, settings, old)
        runs += 1
        wrong = judge(None, result, normal, old, name) if result[0] == 0 else \
            "must succeed: exit %s: %r" % (result[0], result[2][:200])
        if wrong:
            findings.append((name, str(settings), wrong, b""))
    written = sum(len(data or b"") for data in normal[3].values()) + len(normal[1])
    full = Point("write", 0, "from", "ENOSPC")
    full.words = FAMILIES["write"][0][2]
    most = 4000 if runner.o.all else 6
    for k in range(most):
        space = written * k // most if written > most else k
        if k and written <= most and k > written:
            break
        result = runner.execute(words, {"CVOL_FAULT_SPACE": str(space)}, old)
        runs += 1
        wrong = judge(full, result, normal, old, name)
        if wrong:
            findings.append((name, "ENOSPC after %d bytes" % space, wrong, b""))
    return runs


def check(runner, name, command, options, counted):
    """Runs all faults of a command. Returns its row of the table, and its findings."""
    words = runner.words(command)
    findings = []
    normal = runner.execute(words, {}, {})
    if normal[0] != 0:
        return (name, 0, 0, 0), [(name, "without a failure", "exit %s: %s" % (normal[0], normal[2]), b"")]
    old = {} if name in commands.FOLDERS else {file: b"old %s\n" % file.encode() for file in normal[3]}
    depth = options.depth or (48 if options.all else 6)
    settings = {"CVOL_FAULT_RECORD": str(depth)}
    if options.named:
        settings["CVOL_FAULT_NAMED"] = "1"
    recorded = runner.execute(words, settings, old)
    wrong = judge(None, recorded, normal, old, name) if recorded[0] == 0 else "exit %s: %s" % (recorded[0], recorded[2])
    if wrong:
        findings.append((name, "under faults.so", wrong, b""))
    faults, _, points = plan(recorded[4], options)
    part, parts = options.part
    mine = []
    for fault in faults:
        with runner.lock:
            counted[0] += 1
            if counted[0] % parts == part - 1:
                mine.append(fault)
    runs = 0
    for fault in mine:
        result = runner.execute(words, settings_of(fault, options), old)
        runs += 1
        wrong = judge(fault, result, normal, old, name)
        if not wrong and result[0] == 1 and not reached(result[4]):
            wrong = "fails without a fault: %r" % result[2][:200]
        if wrong:
            findings.append((name, "%s %d %s %s" % fault, wrong, result[4]))
    if options.modes and not options.family:
        runs += check_modes(runner, words, normal, old, findings, name)
    return (name, runs, points, len(findings)), findings


def parse(arguments):
    parser = argparse.ArgumentParser(usage=__doc__.split("\n")[0][7:])
    for name in ("cvol", "shim", "folder"):
        parser.add_argument(name, type=os.path.abspath)
    parser.add_argument("--all", action="store_true")
    parser.add_argument("--modes", action="store_true")
    parser.add_argument("--named", action="store_true")
    parser.add_argument("--part", default="1/1")
    parser.add_argument("--only", default="")
    parser.add_argument("--family", default="")
    parser.add_argument("--threads", type=int, default=1)
    parser.add_argument("--jobs", type=int, default=1)
    parser.add_argument("--limit", type=float, default=20)
    parser.add_argument("--depth", type=int, default=0)
    parser.add_argument("--verbose", action="store_true")
    options = parser.parse_args(arguments)
    first, count = options.part.split("/")
    turn = int(os.environ.get("CVOL_TURN", "0"))
    options.part = turn % int(count) + 1 if first == "turn" else int(first), int(count)
    options.python = find_python(os.path.join(os.path.dirname(options.cvol), "libcvol.so.0"))
    return options


def main():
    options = parse(sys.argv[1:])
    begin = time.monotonic()
    shutil.rmtree(options.folder, ignore_errors=True)
    os.makedirs(os.path.join(options.folder, "in"))
    os.chdir(os.path.join(options.folder, "in"))
    inputs.make(options.cvol)
    runner = Runner(options)
    counted = [0]
    chosen = [(name, command) for name, command in commands.COMMANDS.items()
              if any(text in name for text in options.only.split(","))
              and ("a.h5" not in command or os.path.exists("a.h5"))
              and (options.python or not command.startswith("PYTHON "))]
    print("failures: part %d of %d of the fault points" % options.part, flush=True)
    rows, findings = [], []
    with concurrent.futures.ThreadPoolExecutor(options.jobs) as pool:
        jobs = [pool.submit(check, runner, name, command, options, counted) for name, command in chosen]
        for job in jobs:
            row, found = job.result()
            rows.append(row)
            print("%-26s %6d runs %6d points %5d findings" % row, flush=True)
            for name, where, what, report in found:
                findings.append(what)
                print("  %s: %s" % (where, what))
                if options.verbose and report:
                    print("      " + " < ".join(name_frames(report)[:14]), flush=True)
    print("%d runs, %d fault points, %d findings, %.0f s" %
          (sum(r[1] for r in rows), sum(r[2] for r in rows), len(findings), time.monotonic() - begin))
    if not findings:
        shutil.rmtree(options.folder, ignore_errors=True)
    return 1 if findings else 0


if __name__ == "__main__":
    sys.exit(main())
