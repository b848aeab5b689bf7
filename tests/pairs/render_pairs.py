"""usage: render_pairs.py CVOL FOLDER [SEED [PARTS]]

Tests every pair of choices of file and options of `cvol render`, for each engine. The picture of the file must
agree with the picture of the volume that it decompresses to, and the pictures of engines sheet and ray must agree.
Options that exclude each other are refused, for file and volume alike. PARTS: one of PARTS rows is tested; the variable
CVOL_TURN decides which (scripts/check.sh).
`Job.least` gives the least PSNR."""
import concurrent.futures
import json
import math
import multiprocessing
import os
import random
import subprocess
import sys

import pairwise
import pictures
import render_volumes

LIGHT = ["--shade", "--shade --light 1,-2,3 --specular 0.5 --shininess 30", "--shade --gradient-opacity {60}"]
COMPOSITE = ["--mode composite", "--opacity-scale 3"] + LIGHT
STUDIO = ["--light flat", "--light studio --occlusion 1 --shadows 1", "--light cinematic --samples 7",
          "--light 2,1,-1 --fill-light 0.4 --shadows 0.7"]
LOOK = COMPOSITE + STUDIO + ["--mode xray", "--mode mip", "--mode min", "--mode iso --iso {420}",
                    "--mode iso --iso {300} --light 1,-2,3"]  # values in braces are on a scale of 0 to 1000
VALUES = ["--transfer own", "", "--transfer hot", "--transfer own --window {500},{900}",
          "--transfer ct-bone --rescale 2,-1000", "--transfer thin"]
PARALLEL = ["", "--azimuth 30 --elevation 20", "--azimuth 90 --zoom 3", "--view left --look-at 6,-3,4",
            "--view top --roll 15 --mirror", "--azimuth 45 --zoom 0.6"]
CAMERA = PARALLEL + ["--azimuth 225 --elevation -60 --roll 100 --perspective 40",
                     "--perspective 70 --eye 3,-30,5 --look-at 0,40,0",
                     "--perspective 100 --eye 0,0,5 --look-at 10,20,-3 --up 0,1,1 --mirror"]
CLIP = ["", "--clip ,50%:,", "--clip 5.5:20,3:,:15.2", "--clip-plane 1,1,-1,0",
        "--clip-plane 1,0.2,0.3,-9 --clip-plane -1,0,0.4,-8 --clip :30,,"]
OUTPUT = ["pfm", "pfm --background 0.2,0.4,0.6", "png --background transparent", "png --bits 16 --background white",
          "png --annotate"]
MAPS = ["", "--depth", "--opacity", "--depth --opacity"]
OVERLAY = ["", "--overlay OVERLAY", "--overlay OVERLAY --overlay-transfer viridis --overlay-depth 4",
           "--overlay OVERLAY --overlay-opacity 0.4 --overlay-window 5,8"]
LABELS = ["--labels 1", "--labels 2-9"]  # refused: the volumes have no labels
SIZES = ["", "--footprint-size 3", "--footprint-size 9"]
LOOKS = {"output": OUTPUT, "size": ["--size 64", "--size 72x50"], "threads": ["--threads 1", "--threads 3"]}
AXES = {
    "sheet": {"look": LOOK, "values": VALUES, "camera": CAMERA, "clip": CLIP, "maps": MAPS,
              "level": ["", "--level 0", "--level 1", "--level 2", "--level 3"],
              "oversample": ["", "--oversample 0.5", "--oversample 2", "--oversample 3.3"],
              "step": ["", "--step 0.4", "--step 1.3", "--step 4"],
              "rays": ["", "--ray-order image", "--ray-order object"],
              "footprint": ["", "--footprint catmull-rom", "--footprint b-spline", "--footprint gaussian --sigma 0.6"],
              "overlay": OVERLAY, "keep": ["", "--keep-mb 20", "--budget-ms 1e9"]},
    "ray": {"look": LOOK, "values": VALUES, "camera": CAMERA, "clip": CLIP, "maps": MAPS,
            "overlay": OVERLAY, "level": ["", "--level 1", "--level 3"], "step": ["", "--step 0.3", "--step 2"]},
    "splat": {"look": COMPOSITE, "values": VALUES, "camera": PARALLEL, "maps": ["", "--opacity"],
              "level": ["", "--level 1"], "footprint size": SIZES,
              "footprint": ["", "--footprint cone", "--footprint sinc", "--footprint box", "--sigma 0.6"],
              "order": ["", "--order back"],
              "plane": ["", "--footprint-plane view", "--footprint-plane slices"]},
    "transform": {"look": COMPOSITE, "values": VALUES, "camera": PARALLEL, "maps": ["", "--opacity"],
                  "level": ["", "--level 1"], "footprint size": SIZES,
                  "footprint": ["", "--footprint sinc", "--footprint box", "--sigma 0.6"],
                  "order": ["", "--order back"],
                  "spectrum": ["", "--spectrum dft", "--spectrum dht", "--tile 0", "--tile 8", "--tile 32"],
                  "rho": ["", "--rho 1", "--rho 0.03"], "schedule": ["", "--schedule literal"]},
    "fourier": {"values": ["--window {500},{900}", "", "--window auto"], "camera": PARALLEL,
                "maps": ["", "--opacity"], "level": ["", "--level 1"], "rho": ["", "--rho 0.2", "--rho 1"],
                "cue": ["", "--depth-cue 0.7"]},
}
TRANSFERS = {  # for values from 0 to 1
    "own": [[0, 0, 0, 0, 0], [0.1, 0.8, 0.2, 0.1, 0], [0.4, 1, 0.7, 0.4, 0.15], [1, 1, 1, 0.9, 0.5]],
    "thin": [[0.3, 0, 0, 1, 0], [0.35, 0, 1, 0, 0.9], [0.4, 0, 0, 1, 0], [0.6, 1, 0.6, 0.2, 0], [0.8, 1, 1, 1, 1]],
}


# The least PSNR of two pictures in dB.
SAME = 80  # equal samples but for float32 rounding, which transfer function and light amplify 100 times
AMPLIFIED = 30  # lower than the samples' PSNR: the slope of transfer functions is up to 10, of light 3
TRUNCATED = 40  # the same with truncation, where nearly equal terms may be exchanged
SHEET = 40  # engine sheet alone; block skipping uses other bounds: up to 4 / 255 in a pixel
ENGINES = 22  # samples in the middle of a vessel, or half a sample away
ALONE_LEAST = 16  # pairs that are tried alone: some are refused and some are not
BRICKS = 40  # the encoder chooses terms within a brick
COARSE = 15  # every other sample or fewer: half of a vessel may be missing
INSIDE = 8  # the same with the eye in the volume, where samples are many pixels wide
# At edges of light or of a surface nearby pixels differ, even for nearly equal samples; this share of pixels is not
# counted.
SPARED = 1 / 200
ALONE = 200  # number of pairs of options that are tested separately


class Failure(Exception):
    pass


def allowed(engine, row):
    """Returns whether the row has no options that exclude each other according to the command's help."""
    look, maps = row.get("look", ""), row["maps"]
    grey = engine == "fourier" or any(mode in look for mode in ("xray", "mip", "min"))
    overlay = row.get("overlay", "")
    return not ((grey and "--depth" in maps) or
                (overlay and ("--depth" in maps or "--budget" in row.get("keep", ""))) or
                (grey and engine == "sheet" and row["step"] == "--step 0.4") or
                ("--annotate" in row["output"] and "--opacity" in maps))


def words_of(engine, row, **others):
    """Returns the options of a row; `others` replaces those of its axes."""
    row = dict(row, **others)
    words = ["--engine", engine] + row["output"].split()[1:]
    for axis, choice in row.items():
        if axis not in ("file", "maps", "output"):
            words += choice.split()
    return words


def has_own_frame(row):
    """Returns whether the frame around what is visible may differ between a file and what it is compared with: unless
    their samples are the same."""
    return (row["file"] not in render_volumes.EXACT or render_volumes.FILES[row["file"]][-1] is not None or
            row["level"] not in ("", "--level 0"))


def is_fitted(engine, row):
    """Returns whether colours or grey levels are fitted to the histogram of the samples."""
    look = row.get("look", "")
    if look in COMPOSITE + STUDIO:
        return row["values"] in ("", "--transfer hot")
    return "--window {" not in row["values"]


def is_coarse(row):
    """Returns whether engine sheet uses fewer samples than the volume has."""
    return (row["level"] not in ("", "--level 0") or row["step"] == "--step 4" or "0.5" in row["oversample"] or
            "--zoom 0.6" in row["camera"])


class Job:
    """One row, and its pictures."""

    def __init__(self, cvol, folder, engine, row, number):
        self.cvol, self.engine, self.row, self.folder = cvol, engine, row, folder
        self.stem = os.path.join(folder, "picture-%s-%d" % (engine, number))
        self.commands, self.measurements, self.wrong, self.failure, self.empty = [], [], [], None, False

    def words(self, engine, **others):
        words = []
        for word in words_of(engine, self.row, **others):
            word = render_volumes.scaled(word, self.row["file"])
            if word == "2,-1000":  # Hounsfield units for values from 0 to 1000
                word = "%g,-1000" % (2000 / render_volumes.FILES[self.row["file"]][1])
            if word == "OVERLAY":
                word = os.path.join(self.folder, "overlay.nrrd")
            if word in TRANSFERS:
                word = os.path.join(self.folder, "%s-%d.json" % (word, render_volumes.FILES[self.row["file"]][1]))
            words.append(word)
        return words + (["--fit", "box"] if has_own_frame(self.row) else [])

    def draw(self, name, tag, words):
        """Renders; returns the files of the picture and of its maps, by name."""
        made = {"picture": "%s-%s.%s" % (self.stem, tag, self.row["output"].split()[0])}
        for option in self.row["maps"].split():
            made[option[2:]] = "%s-%s-%s.pfm" % (self.stem, tag, option[2:])
            words = words + [option, made[option[2:]]]
        command = [self.cvol, "render", os.path.join(self.folder, name), "-o", made["picture"]] + words
        self.commands.append(" ".join(command[1:]))
        done = subprocess.run(command, capture_output=True, text=True, timeout=120)
        if done.returncode:
            raise Failure("exit %d: %s" % (done.returncode, done.stderr.strip()))
        out = {}
        for name, path in made.items():
            with open(path, "rb") as file:
                out[name] = file.read()
            os.remove(path)
        return out

    def least(self, what):
        """Returns the least PSNR of a picture and the reference `what`: of the decompressed volume by the same
        engine, dense or compressed again; of the original, if values are fitted to its histogram, which the file
        stores; or of engine ray."""
        name, engine = self.row["file"], self.engine
        coding = min(render_volumes.CODED.get(name, 70), 70)  # 70 dB: integers up to 1000, rounded
        coded = coding - (TRUNCATED if engine == "transform" else AMPLIFIED)
        if "coarse" in what:
            return INSIDE if "--eye" in self.row["camera"] else COARSE
        if what == "ray":
            return ENGINES
        if what == "original":
            return min(coded, SHEET) if engine == "sheet" else coded
        if engine == "sheet":
            return SHEET
        full = self.row["level"] == ""
        if what == "bricks":
            return BRICKS
        return SAME if engine == "ray" or (name in render_volumes.EXACT and full) else coded

    def compare(self, what, mine, others):
        coarse, ray = "coarse" in what, what.startswith("ray")
        for name in mine:
            if name == "depth":
                self.compare_depth(what, mine[name], others[name])
                continue
            least, decibels = self.least(what), math.inf
            if mine[name] != others[name]:
                pair = [pictures.parse(mine[name]), pictures.parse(others[name])]
                if coarse or ray:
                    pair = [pictures.blurred(picture) for picture in pair]
                decibels = pictures.psnr(*pair)
                if decibels < least:
                    decibels = pictures.psnr(*pair, spared=SPARED)
            self.measurements.append((what, name, decibels, least))
            if not decibels >= least:
                self.wrong.append("%s: %s %.1f dB, not %g" % (what, name, decibels, least))

    def compare_depth(self, what, mine, other):
        coarse, ray = "coarse" in what, what.startswith("ray")
        share = pictures.share_apart(pictures.parse(mine), pictures.parse(other), 1 if ray or coarse else 0.2)
        most = 0.5 if coarse else 0.1 if ray else 0.02
        self.measurements.append((what, "depth", share, most))
        if not share <= most:
            self.wrong.append("%s: %.0f %% of depths differ" % (what, 100 * share))

    def run(self):
        row, engine, name = self.row, self.engine, self.row["file"]
        level = int(row["level"].split()[1]) if row["level"] else 0
        mine = self.draw(name + ".cvol", "a", self.words(engine))
        self.empty = row["output"].startswith("pfm") and pictures.spread(pictures.parse(mine["picture"])) == 0
        hole = render_volumes.FILES[name][-1]
        exact, fitted = name in render_volumes.EXACT, is_fitted(engine, row)
        # Without a mask, only NaN and 1e35 mark missing samples of a dense volume, which is then compressed.
        dense = engine != "sheet" and (hole is None or (engine == "ray" and hole != -5))
        if fitted and not exact:
            what, path, words = "original", name + "-original.cvol", self.words(engine)
        elif dense and not (fitted and level):
            # At a level, engine transform also draws on a coarser lattice.
            terms_only = {} if engine == "transform" else {"level": ""}
            what, path, words = "dense", "%s-%d.nrrd" % (name, level), self.words(engine, **terms_only)
        elif exact and level and engine == "ray":  # levels are those of the terms, which depend on the block side
            what, path, words = "bricks", name + "-bricks.cvol", self.words(engine)
        else:
            what, path, words = "again", name + "-again.cvol", self.words(engine)
        coarse = is_coarse(row) if engine == "sheet" else level and what not in ("dense", "bricks")
        self.compare(what + (" coarse" if coarse else ""), mine, self.draw(path, "b", words))
        if engine == "sheet" and level < 2:
            free = dict(oversample="", rays="", footprint="", keep="", step="--step 0.25")
            ray = self.draw(name + ".cvol", "c", self.words("ray", **free))
            self.compare("ray" + (" coarse" if coarse else ""), mine, ray)
        if self.wrong:
            raise Failure("; ".join(self.wrong))


def attempt(job):
    """Returns None or the failure, and whether the picture has one colour."""
    try:
        job.run()
    except (Failure, subprocess.TimeoutExpired) as failure:
        job.failure = failure
    return job


def refusal(cvol, path, words, out):
    """Returns '' or the sentence by which the command refuses to render."""
    done = subprocess.run([cvol, "render", path, "-o", out, "--size", "16", "--json"] + words, capture_output=True,
                          text=True, timeout=120)
    if not done.returncode:
        return ""
    sentences = [line for line in done.stderr.strip().split("\n") if line]
    sentence = sentences[-1] if sentences else ""
    if done.returncode != 2 or len(sentences) != 1 or not sentence.startswith("cvol: ") or len(sentence) < 15:
        raise Failure("exit %d with %r" % (done.returncode, done.stderr))
    return sentence.replace(path, "IN").replace(os.path.basename(path), "IN")


def try_alone(task):
    """Tests two options alone: the command renders both file and volume, or refuses both with the same words."""
    cvol, folder, number, words = task
    words = [os.path.join(folder, word + "-1000.json") if word in TRANSFERS else
             os.path.join(folder, "overlay.nrrd") if word == "OVERLAY" else
             render_volumes.scaled(word, "exact-float") for word in words]
    words = [w for word in words for w in ([word, os.path.join(folder, "map-%d-%s.pfm" % (number, word[2:]))]
                                           if word in ("--depth", "--opacity") else [word])]
    try:
        sentences = [refusal(cvol, os.path.join(folder, name), words, os.path.join(folder, "alone-%d.png" % number))
                for name in ("tiny.cvol", "tiny.nrrd")]
        if sentences[0] != sentences[1]:
            raise Failure("of the file %r, of the volume %r" % tuple(sentences))
    except Failure as failure:
        return " ".join(words), str(failure), False
    return " ".join(words), "", sentences[0] != ""


def pairs_alone(seed):
    """Tests some pairs of options of all engines, with and without an engine."""
    choices = sorted({choice for axes in AXES.values() for axis, some in axes.items() for choice in some if choice} |
                     set(LABELS))
    draw = random.Random(seed)
    for _ in range(ALONE):
        pair = draw.sample(choices, 2)
        engine = draw.choice(["", "--engine " + draw.choice(list(AXES))])
        yield (engine + " " + " ".join(pair)).split()


def print_measurements(done):
    """Prints the PSNR of pictures, the worst first in each kind."""
    measurements = {}
    for job in done:
        for what, name, value, least in job.measurements:
            measurements.setdefault((job.engine, what, name, least), []).append(value)
    for kind in sorted(measurements):
        values = sorted(measurements[kind], reverse=kind[2] == "depth")
        print(*kind, " ".join("%.3g" % v for v in values[:12]), "of", len(values))


def main():
    cvol, folder = sys.argv[1:3]
    seed = int(sys.argv[3]) if len(sys.argv) > 3 else 1
    parts = int(sys.argv[4]) if len(sys.argv) > 4 else 1
    turn = int(os.environ.get("CVOL_TURN", "0"))
    part = (seed + turn) % parts
    os.makedirs(folder, exist_ok=True)
    for name, points in TRANSFERS.items():
        for most in (250, 1000):
            with open(os.path.join(folder, "%s-%d.json" % (name, most)), "w") as file:
                json.dump({"points": [[most * p[0]] + p[1:] for p in points]}, file)
    jobs, left_out = [], 0
    with concurrent.futures.ProcessPoolExecutor(2, multiprocessing.get_context("fork")) as pool:
        makers = [pool.submit(render_volumes.make, cvol, folder, name) for name in render_volumes.FILES]
        for engine, axes in AXES.items():
            made, without = pairwise.rows({"file": list(render_volumes.FILES), **axes, **LOOKS}, seed,
                                          lambda row: allowed(engine, row))
            jobs += [Job(cvol, folder, engine, row, i) for i, row in enumerate(made)]
            left_out += len(without)
        for maker in makers:
            maker.result()
        render_volumes.make_tiny(cvol, folder)
        done = list(pool.map(attempt, jobs[part::parts]))
        tasks = [(cvol, folder, i, words) for i, words in enumerate(pairs_alone(seed))]
        step = min(parts, len(tasks) // ALONE_LEAST)
        alone = list(pool.map(try_alone, tasks[turn % step::step]))
    failures = 0
    for job in done:
        if job.failure:
            failures += 1
            print("FAILED: %s: %s\n    %s" % (" | ".join(v or "-" for v in job.row.values()), job.failure,
                                           "\n    ".join(job.commands)))
    for words, wrong, _ in alone:
        if wrong:
            failures += 1
            print("FAILED: render %s: %s" % (words, wrong))
    empty, refused = sum(job.empty for job in done), sum(no for _, _, no in alone)
    print("seed %d, part %d of %d: %d rows, %d pictures, %d of one colour; %d pairs alone, %d refused; %d failures; "
          "%d pairs that cannot be" % (seed, part + 1, parts, len(done), sum(len(job.commands) for job in done), empty,
                                        len(alone), refused, failures, left_out))
    if os.environ.get("CVOL_TEST_VERBOSE"):
        print_measurements(done)
    many = len(done) >= 40  # of a few rows many may be empty
    return failures > 0 or (many and empty > len(done) / 10) or not 0 < refused < len(alone)


if __name__ == "__main__":
    sys.exit(main())
