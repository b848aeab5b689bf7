#!/usr/bin/env python3
"""Checks figures in documents: commands print them, or a named program measures them.

check_figures.py output EXPECTED ACTUAL  every line of EXPECTED is a line of ACTUAL, in this order. A number of a
                                         document agrees if the printed one rounds to it: 1170000 agrees with
                                         1171466, 50.9 with 50.86. "..." stands for anything.
check_figures.py prose DOCUMENT...       a measured figure in prose (in bytes, dB, seconds, or
                                         as a factor) is in a section that names the program in bench/ that measures
                                         it, or shows it in a ```text block.
"""
import re
import sys

NUMBER = re.compile(r"(?<![\w.])-?\d+(?:\.\d+)?(?:e[-+]?\d+)?(?![\d])")
MEASURED = re.compile(
    r"(?<![\w./-])\d[\d.,]*\s*(?:dB|MB|kB|GB|bytes|ms|s|seconds|milliseconds|minutes|times)(?![\w-])")


def half_unit(text):
    """Half of the last digit of a number; zeros at the end of a whole number do not count as digits."""
    digits, _, power = text.lstrip("-").partition("e")
    whole, _, part = digits.partition(".")
    zeros = len(whole) - len(whole.rstrip("0")) if not part and len(whole) > 3 else 0
    return 0.5 * 10.0 ** (zeros - len(part) + int(power or 0))


def agrees(shown, printed):
    return abs(float(shown) - float(printed)) <= half_unit(shown) * (1 + 1e-9)


def pattern_of(line):
    """Returns the line as a pattern with one group per number, and the numbers."""
    numbers, parts, end = [], [], 0
    for match in NUMBER.finditer(line):
        parts += [re.escape(line[end : match.start()]), r"(-?\d[\d.]*(?:e[-+]?\d+)?)"]
        numbers.append(match.group())
        end = match.end()
    text = "".join(parts + [re.escape(line[end:])])
    return re.compile(text.replace(r"\.\.\.", ".*?") + r"\s*\Z"), numbers


def is_line(shown, printed):
    pattern, numbers = pattern_of(shown)
    match = pattern.match(printed)
    return bool(match) and all(map(agrees, numbers, match.groups()))


def check_output(expected_path, actual_path):
    with open(expected_path, encoding="utf-8") as expected, open(actual_path, encoding="utf-8") as actual:
        shown, printed = expected.read().splitlines(), actual.read().splitlines()
    at = 0
    for line in shown:
        while at < len(printed) and not is_line(line, printed[at]):
            at += 1
        if at == len(printed):
            print(f"the document shows\n    {line}\nwhich is no line of what is printed:")
            print("\n".join("    " + p for p in printed))
            return 1
        at += 1
    return 0


def check_prose(paths):
    failures = 0
    for path in paths:
        with open(path, encoding="utf-8") as file:
            text = file.read()
        for section in re.split(r"(?m)^(?=#+ )", text):
            if re.search(r"bench/\w+\.(py|sh|c)\b", section):
                continue
            shown = " ".join(re.findall(r"(?ms)^```text\n(.*?)^```", section))
            prose = re.sub(r"(?ms)^```.*?^```|`[^`]*`|^ {4,}.*?$", " ", section)
            for match in MEASURED.finditer(prose):
                number = match.group().split()[0].rstrip(".,")
                if not any(is_shown(number, printed) for printed in NUMBER.findall(shown)):
                    print(f"{path}, {section.splitlines()[0]}: '{match.group()}' is measured by no program that the "
                          "section names, and shown by no output")
                    failures += 1
    return failures != 0


def is_shown(number, printed):
    """Compares two figures in the same unit, or in millions."""
    number = number.replace(",", "")
    return any(agrees(number, str(float(printed) / scale)) for scale in (1, 1e6))


def main():
    what, *paths = sys.argv[1:]
    return check_output(*paths) if what == "output" else check_prose(paths)


sys.exit(main())
