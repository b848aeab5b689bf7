#!/usr/bin/python3
"""Writes inter.inc: the letters of the font Inter Medium that pictures need, as a TrueType font in bytes of C.

Outlines become quadratic splines, within a thousandth of the height of a letter. Figures all have one width, and
pairs of letters keep their distances. Needs Debian's fonts-inter and python3-fonttools; no build runs it.
usage: third_party/inter/subset.py [FONT.otf] > third_party/inter/inter.inc
"""
import io
import sys

from fontTools import subset
from fontTools.pens.cu2quPen import Cu2QuPen
from fontTools.pens.ttGlyphPen import TTGlyphPen
from fontTools.ttLib import TTFont, newTable

FONT = "/usr/share/fonts/opentype/inter/Inter-Medium.otf"
ERROR = 1.5  # units, of 2816 in an em
RANGES = ((0x20, 0x7e), (0xa0, 0x17f), (0x370, 0x3ff), (0x2010, 0x2015), (0x2018, 0x201e), (0x2020, 0x2022),
          (0x2026, 0x2026), (0x2030, 0x2033), (0x2070, 0x208e), (0x20ac, 0x20ac), (0x2103, 0x2103), (0x2126, 0x2126),
          (0x212b, 0x212b), (0x2190, 0x2193), (0x2202, 0x2202), (0x2206, 0x2206), (0x2212, 0x2212), (0x221a, 0x221a),
          (0x221e, 0x221e), (0x2248, 0x2248), (0x2260, 0x2260), (0x2264, 0x2265))


def figures_of_one_width(font):
    """Maps the figures to those of feature tnum; one of these differs by 2 units."""
    table = font["GSUB"].table
    lookups = {i for record in table.FeatureList.FeatureRecord if record.FeatureTag == "tnum"
               for i in record.Feature.LookupListIndex}
    swap = {}
    for i in lookups:
        for part in table.LookupList.Lookup[i].SubTable:
            swap.update(getattr(part, "ExtSubTable", part).mapping)
    for cmap in font["cmap"].tables:
        for code in range(ord("0"), ord("9") + 1):
            if code in cmap.cmap:
                cmap.cmap[code] = swap.get(cmap.cmap[code], cmap.cmap[code])
    names, metrics = font.getBestCmap(), font["hmtx"].metrics
    for code in range(ord("0"), ord("9") + 1):
        metrics[names[code]] = metrics[names[ord("0")]][0], metrics[names[code]][1]


def to_quadratic(font):
    """Replaces the table CFF by glyf."""
    shapes, order = font.getGlyphSet(), font.getGlyphOrder()
    glyphs = {}
    for name in order:
        pen = TTGlyphPen(shapes)
        shapes[name].draw(Cu2QuPen(pen, ERROR, reverse_direction=True))
        glyphs[name] = pen.glyph()
    font["loca"] = newTable("loca")
    font["glyf"] = glyf = newTable("glyf")
    glyf.glyphOrder, glyf.glyphs = order, glyphs
    del font["CFF "]
    maxp = font["maxp"]
    maxp.tableVersion = 0x10000
    for field in ("maxZones", "maxTwilightPoints", "maxStorage", "maxFunctionDefs", "maxInstructionDefs",
                  "maxStackElements", "maxSizeOfInstructions", "maxComponentElements"):
        setattr(maxp, field, 0)
    font["post"].formatType = 3.0
    font.sfntVersion = "\0\1\0\0"


def main():
    font = TTFont(sys.argv[1] if len(sys.argv) > 1 else FONT, recalcTimestamp=False)
    figures_of_one_width(font)
    options = subset.Options(layout_features=["kern"], hinting=False, notdef_outline=True, name_IDs=[0, 13],
                             drop_tables=["GDEF", "GSUB", "STAT", "DSIG"])
    subsetter = subset.Subsetter(options)
    subsetter.populate(unicodes=[code for first, last in RANGES for code in range(first, last + 1)])
    subsetter.subset(font)
    to_quadratic(font)
    file = io.BytesIO()
    font.save(file, reorderTables=False)
    data = file.getvalue()
    print("/* Inter Medium, (c) The Inter Project Authors, SIL Open Font License 1.1; made by subset.py. */")
    for at in range(0, len(data), 20):
        print("".join("%d," % byte for byte in data[at:at + 20]))


main()
