"""Checks that links between the documents lead to existing files and headings. usage: check_links.py SOURCE_FOLDER"""

import os
import re
import sys


def documents(top):
    for folder, folders, files in os.walk(top):
        folders[:] = sorted(f for f in folders if not f.startswith((".", "build")) and f not in ("node_modules", "third_party"))
        yield from (os.path.join(folder, name) for name in sorted(files) if name.endswith(".md"))


def read(path):
    """The text without blocks of code."""
    with open(path, encoding="utf-8") as file:
        return re.sub(r"^```.*?^```", "", file.read(), flags=re.MULTILINE | re.DOTALL)


def anchors(path):
    """The anchors of the headings, as GitHub makes them."""
    found = {}
    for heading in re.findall(r"^#{1,6} +(.+?) *$", read(path), re.MULTILINE):
        text = re.sub(r"\[([^]]*)\]\([^)]*\)", r"\1", heading).lower()
        anchor = re.sub(r"[^\w\- ]", "", text).replace(" ", "-")
        count = found[anchor] = found.get(anchor, -1) + 1
        yield f"{anchor}-{count}" if count else anchor


def main():
    top, count, dead = sys.argv[1], 0, []
    for path in documents(top):
        for link in re.findall(r"\]\(([^)\s]+)\)", read(path)):
            if re.match(r"[a-z]+:", link):
                continue
            count += 1
            name, _, anchor = link.partition("#")
            target = os.path.join(os.path.dirname(path), name) if name else path
            if not os.path.exists(target) or (anchor and target.endswith(".md") and anchor not in anchors(target)):
                dead.append(f"{os.path.relpath(path, top)}: leads nowhere: {link}")
    print("\n".join(dead) or f"links: {count}, all lead to a file and a heading")
    sys.exit(bool(dead))


main()
