#!/usr/bin/env python3
"""Writes cvol/_headers.py: the declarations of the public headers, for ctypes. Run it after a change of a header;
tests/test_abi.py fails until then.

Records the fields of each struct, and one letter for the result and each parameter of each function:
    i int or enum   d double   z size_t   u uint64_t   s char *   v nothing   * any other pointer
    g a pointer to cvol_grid as a result   NAME a struct by value, or a function
"""

import re
import sys
from pathlib import Path

ROOT = Path(__file__).resolve().parents[1]
INCLUDE = ROOT.parent / "include" / "cvol"
LETTERS = {"int": "i", "double": "d", "size_t": "z", "uint64_t": "u", "uint32_t": "I", "int64_t": "l", "float": "f",
           "uint8_t": "B", "void": "v"}  # fmt: skip


class Headers:
    def __init__(self):
        text = "".join(path.read_text() + "\n" for path in sorted(INCLUDE.glob("*.h"))
                       if path.name != "mpi.h")
        self.text = re.sub(r"/\*.*?\*/", " ", text, flags=re.S)
        self.numbers = {name: int(value) for name, value in re.findall(r"#define (CVOL_\w+) (\d+)\s", self.text)}
        for body in re.findall(r"\benum\s*\w*\s*\{([^}]*)\}", self.text):
            value = -1
            for name, given in re.findall(r"(CVOL_\w+)\s*(?:=\s*(-?\d+))?", body):
                value = int(given) if given else value + 1
                self.numbers[name] = value
        self.enums = set(re.findall(r"typedef enum (\w+)", self.text))
        self.functions = set(re.findall(r"typedef \w+ \(\*(\w+)\)", self.text))

    def letter(self, text, result=False):
        """Returns the type letter of a parameter, a field or a result, without arrays."""
        text = re.sub(r"\b(const|CVOL_API|struct)\b", " ", text)
        if "*" in text or "[" in text:
            if re.search(r"\bchar\b", text) and text.count("*") < 2:
                return "s"
            return "g" if result and "cvol_grid" in text else "*"
        word = text.split()[0]
        return "i" if word in self.enums else LETTERS.get(word, word)

    def structs(self):
        found = {}
        for name, body in re.findall(r"typedef struct (\w+) \{([^{}]*)\} \1;", self.text):
            fields = []
            for line in filter(str.strip, body.split(";")):
                if "(" in line:  # a pointer to a function
                    fields.append((re.search(r"\(\*(\w+)\)", line).group(1), "*", ()))
                    continue
                kind, first = re.match(r"\s*(\w+)\s+(.*)", re.sub(r"\bconst\b", "", line), re.S).groups()
                for place in first.split(","):
                    word = re.search(r"\w+", place).group()
                    sizes = tuple(eval(n, {}, self.numbers) for n in re.findall(r"\[([^]]*)\]", place))
                    letter = self.letter(kind + " " + place.split("[")[0])
                    fields.append((word, "c" if letter == "char" else letter, sizes))
            found[name] = fields
        return found

    def prototypes(self):
        found = {}
        pattern = r"CVOL_API\s+([\w\s\*]+?)\bcvol_(\w+)\(([^;]*)\);"
        for result, name, parameters in re.findall(pattern, self.text):
            letters = [self.letter(result, True)]
            if parameters.strip() != "void":
                # (A parameter in parentheses is a pointer to an array.)
                letters += ["*" if "(" in p else self.letter(p) for p in parameters.split(",")]
            found[name] = " ".join(letters)
        return found


def generate():
    headers = Headers()
    codes = {k[5:]: v for k, v in sorted(headers.numbers.items()) if k == "CVOL_OK" or k.startswith("CVOL_ERROR_")}
    lines = ['"""Made from include/cvol/ by backend/read_headers.py: change the headers, not this."""', ""]
    lines += ["from typing import Any, Dict, List, Tuple", ""]
    lines += ["STRUCTS: Dict[str, List[Tuple[str, str, Tuple[Any, ...]]]] = {"]
    for name, fields in headers.structs().items():
        lines.append(f'    "{name}": [')
        lines += [f'        ("{field}", "{letter}", {sizes}),' for field, letter, sizes in fields]
        lines.append("    ],")
    lines += ["}", "", "FUNCTIONS = {"]
    lines += [f'    "{name}": "{letters}",' for name, letters in headers.prototypes().items()]
    lines += ["}", "", "CODES = {", *[f'    "{name}": {value},' for name, value in codes.items()], "}"]
    return "\n".join(lines) + "\n"


if __name__ == "__main__":
    (ROOT / "cvol" / "_headers.py").write_text(generate())
    sys.exit(0)
