"""usage: checked.py CVOL FOLDER [options]

Runs the commands of commands.py once each under a checker of memory or of threads; one of:

  --valgrind       under memcheck of valgrind, with CVOL_CPU=avx2 (valgrind knows no AVX-512): no use of memory that was
                   not allocated or not written, and no leak
  --races          cvol is built with the thread sanitizer (-DCVOL_SANITIZE=thread): no race
  --uninitialised  cvol is built with the memory sanitizer (scripts/uninitialised.sh): no use of memory that was not
                   written. Such a build lacks libraries: commands that need one are left out
  --made-by CVOL   the cvol that makes the inputs (default: CVOL), if CVOL lacks a library
  --only TEXT      commands whose name contains TEXT; several: separated by commas
  --threads N      threads of the commands (default 1; with --races 3)
  --jobs N         commands at once (default 1)
  --limit SECONDS  time limit of one run (default 300)

Each must succeed without a report of the checker. Under valgrind it must also write the bytes and the text that it
writes without it."""
import argparse
import concurrent.futures
import os
import re
import shutil
import sys

import commands
import failures
import inputs

VALGRIND = ["valgrind", "-q", "--error-exitcode=99", "--leak-check=full", "--errors-for-leak-kinds=definite",
            "--show-leak-kinds=definite", "--num-callers=20"]


LEFT_OUT = "left out: the build lacks a library"


def find_report(text):
    """The report of a checker in a command's messages, or nothing."""
    found = re.search(r"^(==\d+== |WARNING: ThreadSanitizer|Uninitialized bytes).*", text, re.MULTILINE | re.DOTALL)
    return found.group(0) if found else ""


def lacks_library(status, err):
    """1 if a command failed because the build lacks a library."""
    return status == 1 and re.search("built without|needs a build with", err)


def check(runner, name, command, options):
    """The text of what is wrong; empty: nothing."""
    words = runner.words(command)
    status, out, err, files, _ = runner.execute((VALGRIND if options.valgrind else []) + words, {}, {})
    report = find_report(err)
    if status is None:
        return "takes longer than %g s" % options.limit
    if options.uninitialised and not report and lacks_library(status, err):
        return LEFT_OUT
    if status or report:
        return "exit %d\n%s" % (status, report or err)
    if options.valgrind:
        _, plain_out, plain_err, plain_files, _ = runner.execute(words, {}, {})
        if files != plain_files or err != plain_err or failures.without_times(out) != failures.without_times(plain_out):
            return "writes other files or text than without valgrind"
    return ""


def parse(arguments):
    parser = argparse.ArgumentParser(usage=__doc__.split("\n")[0][7:])
    for name in ("cvol", "folder"):
        parser.add_argument(name, type=os.path.abspath)
    parser.add_argument("--valgrind", action="store_true")
    parser.add_argument("--races", action="store_true")
    parser.add_argument("--uninitialised", action="store_true")
    parser.add_argument("--made-by", type=os.path.abspath)
    parser.add_argument("--only", default="")
    parser.add_argument("--threads", type=int)
    parser.add_argument("--jobs", type=int, default=1)
    parser.add_argument("--limit", type=float, default=300)
    options = parser.parse_args(arguments)
    if options.valgrind + options.races + options.uninitialised != 1:
        parser.error("give --valgrind, --races or --uninitialised")
    if options.threads is None:
        options.threads = 3 if options.races else 1
    options.python = None
    return options


def main():
    options = parse(sys.argv[1:])
    if options.valgrind:
        os.environ.setdefault("CVOL_CPU", "avx2")
    shutil.rmtree(options.folder, ignore_errors=True)
    os.makedirs(os.path.join(options.folder, "in"))
    os.chdir(os.path.join(options.folder, "in"))
    inputs.make(options.made_by or options.cvol)
    runner = failures.Runner(options)
    chosen = [(name, command) for name, command in commands.COMMANDS.items()
              if any(text in name for text in options.only.split(",")) and not command.startswith("PYTHON ")
              and ("a.h5" not in command or os.path.exists("a.h5"))]
    findings = left_out = 0
    with concurrent.futures.ThreadPoolExecutor(options.jobs) as pool:
        jobs = [(name, pool.submit(check, runner, name, command, options)) for name, command in chosen]
        for name, job in jobs:
            wrong = job.result()
            left_out += wrong == LEFT_OUT
            findings += bool(wrong) and wrong != LEFT_OUT
            print("%-26s %s" % (name, wrong or "ok"), flush=True)
    print("%d commands, %d findings" % (len(chosen) - left_out, findings))
    if not findings:
        shutil.rmtree(options.folder, ignore_errors=True)
    return 1 if findings or left_out == len(chosen) else 0


if __name__ == "__main__":
    sys.exit(main())
