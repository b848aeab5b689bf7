"""A scan from all sides: one renderer, whose pictures share what they can; Ctrl-C stops it.

usage: turn.py SCAN [FOLDER]      SCAN: a .cvol file, or a dense volume; writes turn-0.png, turn-1.png, ...
"""

import sys
from pathlib import Path

import cvol

if len(sys.argv) < 2:
    sys.exit(__doc__.split("\n\n")[1].strip())
scan = sys.argv[1]
folder = Path(sys.argv[2] if len(sys.argv) > 2 else ".")


def print_progress(what, share):
    print(f"\r{what} {100 * share:3.0f} %", end="", file=sys.stderr)


if scan.endswith(".cvol"):
    volume = cvol.open(scan)
else:
    samples, geometry = cvol.read(scan)
    volume = cvol.compress(samples, geometry=geometry, effort="fast", progress=print_progress)

with cvol.Renderer(volume) as renderer:
    for i in range(4):
        picture = renderer.render(azimuth=90 * i, view="front", size=256, background="white", annotate=True)
        cvol.save_png(folder / f"turn-{i}.png", picture)
print(f"\n4 pictures of {volume}")
