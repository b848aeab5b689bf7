#!/usr/bin/env python3
"""Converts a public header for Doxygen, to standard output: `doxygen doc/reference/Doxyfile` calls it for each.

The headers' comments are plain text. A comment before declarations describes all of them up to the next comment or
empty line; a comment after a field or a constant describes that line. names.txt, in this folder, describes
parameters unless the comment has its own @param. The description of a result is the comment's first sentence, or
that the function returns a code. A name of cvol in a comment must exist.

usage: filter.py HEADER
"""

import re
import sys
from pathlib import Path

HERE = Path(__file__).resolve().parent
INCLUDE = HERE.parents[1] / "include" / "cvol"
STATUS = "#CVOL_OK, or the code of what went wrong, and then the context has a sentence for people."


def said_once():
    """Returns {name or cvol_thing.name: description}."""
    table = {}
    for line in (HERE / "names.txt").read_text().splitlines():
        if line and not line.startswith("#"):
            key, text = line.split(": ", 1)
            table[key] = text
    return table


def known_names():
    code = "".join(re.sub(r"/\*.*?\*/", " ", path.read_text(), flags=re.S) for path in INCLUDE.glob("*.h"))
    return set(re.findall(r"\b(?:cvol|CVOL)_\w+", code))


def text_of(comment):
    """Returns the lines of a comment without its frame."""
    lines = [re.sub(r"^\s*\*? ?", "", line, count=1) for line in comment[2:-2].split("\n")]
    lines[0] = comment[2:-2].split("\n")[0].strip()
    return "\n".join(line.rstrip() for line in lines).strip("\n").rstrip()


def marked(text, names, where):
    """Escapes text for Doxygen: only indented formulas are markup; names of cvol become links."""
    done = []
    for line in text.split("\n"):
        if line.startswith("    "):
            if done and done[-1] and not done[-1].startswith("    "):
                done.append("")
            done.append(line)
            continue
        line = re.sub(r'([\\@<>&#%"])', r"\\\1", line).replace("*", r"\*").replace("|", r"\|").replace("`", r"\`")
        for word in re.findall(r"\b(?:cvol|CVOL)_\w+(?![\w.]*\.h)", line):
            if word not in names and not any(name.startswith(word) for name in names):
                sys.exit(f"{where}: a comment speaks of {word}, which is not there")
        line = re.sub(r"(?<![\w#])((?:cvol|CVOL)_\w+)(?:\(\))?", lambda m: ("#" if m[1] in names else "") + m[1], line)
        done.append(line.replace(r"\@param", "@param"))
    return "\n".join(done)


def first_sentence(text):
    return re.split(r"(?<=[.])\s+(?=[A-Z])|\n\s*\n|\n(?=    )", text, maxsplit=1)[0]


def block(text, behind=False):
    return ("/**< " if behind else "/** ") + text.replace("*/", "* /") + " */"


class Header:
    def __init__(self, path):
        self.path, self.name = path, path.name
        self.names, self.table = known_names(), said_once()
        self.out = []

    def marked(self, text):
        return marked(text, self.names, self.name)

    def described(self, text):
        """Marks the first sentence as the brief description of lists."""
        first = first_sentence(text)
        return f"@brief {self.marked(first)}\n\n{self.marked(text[len(first):].strip(chr(10)))}"

    def function(self, text, code):
        """Returns the comment of a prototype, with its parameters and result."""
        match = re.search(r"([\w\s\*]+?)\b(cvol_\w+)\(([^;]*)\)\s*;", code.replace("CVOL_API", ""))
        result, name, arguments = match.group(1).split(), match.group(2), match.group(3)
        lines = [self.described(text), ""]
        for argument in [] if arguments.strip() == "void" else arguments.split(","):
            word = re.search(r"\(\*(\w+)\)", argument) or re.search(r"(\w+)\s*(\[[^]]*\]\s*)*$", argument)
            word = word.group(1)
            what = self.table.get(f"{name}.{word}") or "**out" in argument and self.table["**out"] or self.table.get(word)
            if what and f"@param {word} " not in text:
                lines.append(f"@param {word} {self.marked(what)}")
        if result == ["int"] and "cvol_context *context" in arguments:
            lines.append(f"@return {STATUS}")
        elif result != ["void"]:
            lines.append(f"@return {self.marked(' '.join(first_sentence(text).split()))}")
        return block("\n".join(lines))

    def declared(self, text, code):
        """Converts a declaration at file level, with its comment."""
        pieces = re.findall(r"#[^\n]*(?:\\\n[^\n]*)*\n?|[^;#]*;\n?|[^;#]+", code)
        for piece in pieces:
            if not piece.strip():
                self.out.append(piece)
            elif re.search(r"\bcvol_\w+\([^;]*\)\s*;", piece) and "typedef" not in piece:
                self.out.append((self.function(text, piece) if text else "") + "\n" + piece)
            else:
                constant = re.match(r"#define \w+(\([^)]*\))? \S", piece.strip())
                wanted = text and (constant or "typedef" in piece or "enum" in piece)
                self.out.append((block(self.described(text)) + "\n" if wanted else "") + piece)

    def fields(self, name_of, body, enum):
        """Converts the body of a struct or enum: one line for each name, each with its description."""
        separator = "," if enum else ";"
        entries = []  # [declaration, description]
        line = []  # entries of the current line
        before, code, column_behind, at = "", "", None, 0

        def flush():
            nonlocal code
            parts = [" ".join(code.split())]
            if not enum and "(" not in parts[0]:
                parts = self.declarators(parts[0])
            for part in filter(None, parts):
                entries.append([part, before])
                line.append(entries[-1])
            code = ""

        for match in re.finditer(r"/\*.*?\*/|\n[ \t]*\n|.", body, flags=re.S):
            token = match.group()
            column = match.start() - body.rfind("\n", 0, match.start())
            if token.startswith("/*"):
                if enum and code.strip():  # the last constant
                    flush()
                text = text_of(token)
                if column == column_behind and not line:  # continues the previous comment
                    entries[-1][1] += " " + text
                elif line and not code.strip():
                    for entry in line:
                        entry[1] = text
                    column_behind = column
                else:
                    before, column_behind = text, None
            elif token == separator:
                flush()
            elif token.startswith("\n"):
                line = []
                if token.count("\n") > 1:
                    before = ""
                code += " "
            else:
                code += token
        if code.strip():
            flush()
        for name, text in entries:
            word = re.match(r"(\w+)", name) if enum else re.search(r"\(\*(\w+)\)|(\w+)\s*(?:\[|$)", name)
            word = [None, word[1] or word[2]] if not enum else word
            text = text or self.table.get(f"{name_of}.{word[1]}") or self.table.get(word[1])
            if not text:
                sys.exit(f"{self.name}: {name_of}: nothing says what {word[1]} is: no comment, no line of names.txt")
            said = block(self.marked(text)) if text else ""
            self.out.append(f"{said}\n{name}{separator}\n")

    @staticmethod
    def declarators(part):
        """Splits `double a, *b` into two declarations."""
        match = re.match(r"((?:const\s+)?\w+)\s+(.*)", part)
        return [f"{match[1]} {one.strip()}" for one in match[2].split(",")] if match else []

    def run(self):
        text = self.path.read_text()
        # The reference shows inline functions as prototypes.
        text = re.sub(r"static inline ([^;{]*\))\n\{.*?\n\}", r"CVOL_API \1;", text, flags=re.S)
        head = re.match(r"/\*.*?\*/", text, flags=re.S).group()
        self.out.append(block("@file\n" + self.described(text_of(head).split(" - ", 1)[1])) + "\n")
        rest = text[len(head):]
        said = ""
        pattern = r"(?P<comment>/\*.*?\*/)|(?P<body>typedef (?:struct|enum) \w+ \{|(?<=\n)enum \w*\s*\{)"
        at = 0
        while True:
            match = re.compile(pattern, flags=re.S).search(rest, at)
            code = rest[at:match.start() if match else len(rest)]
            parts = re.split(r"(\n[ \t]*\n)", code)  # an empty line ends the scope of a comment
            for i, part in enumerate(parts):
                if i % 2:
                    said, part = "", part
                if part:
                    self.declared(said, part)
            if not match:
                break
            at = match.end()
            if match["comment"]:
                words = text_of(match["comment"])
                if words.startswith("----"):
                    title, _, more = words.strip("- \n").partition("\n")
                    if more:
                        self.out.append(block(f"@file\n\n<b>{title.strip('- ').capitalize()}</b>\n\n" + self.marked(more)))
                    said = ""
                elif "\n" not in rest[at - len(match["comment"]) - 30:match.start()].rsplit(";", 1)[-1] and said == "":
                    # after a declaration, on its line
                    self.out.append(block(self.marked(words), True))
                else:
                    said = words
            else:
                enum = "enum" in match["body"]
                struct = match["body"].split()[2].strip("{") if "typedef" in match["body"] else ""
                blank = re.sub(r"/\*.*?\*/", lambda m: "." * len(m.group()), rest[at:], flags=re.S)
                end = at + blank.index("}")
                if said:
                    self.out.append(block(self.described(said)) + "\n")
                self.out.append(match["body"] + "\n")
                self.fields(struct, rest[at:end], enum)
                close = rest.index(";", end) + 1
                self.out.append(rest[end:close])
                said, at = "", close
        sys.stdout.write("".join(self.out))


if __name__ == "__main__":
    Header(Path(sys.argv[1])).run()
