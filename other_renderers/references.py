# SPDX-License-Identifier: Apache-2.0

"""Renders the stored ground truth of all scenes anew, or checks it.

    python3 other_renderers/references.py make PLUMB [SCENE...]    (which is 'make references')
    python3 other_renderers/references.py check PLUMB              ('make check-references')

'make' has every installed program render every scene at its best, compares all pairs and writes
reference_scenes/<scene>/*.exr, card.json and the tables of docs/agreement.md. It takes an hour on
two cores, and goes on where it was stopped; with scenes it renders these alone. 'check' compares what the installed programs draw today with what is stored; exit code 1
says that it differs. 'tables' renders nothing and makes the tables of what is there.
"""

import hashlib
import itertools
import json
import os
import pathlib
import subprocess
import sys
import time

ROOT = pathlib.Path(__file__).resolve().parent.parent
sys.path[:0] = [str(ROOT / "images"), str(ROOT / "python" / "plumbline")]
import cluster  # noqa: E402
import study_command  # noqa: E402
from exr import provenance  # noqa: E402
from study_command import STORED  # noqa: E402

OUT = ROOT / "out" / "references"
DOCUMENT = ROOT / "docs" / "agreement.md"
PLAN = json.loads((ROOT / "reference_scenes" / "references.json").read_text(encoding="utf-8"))
SCENES = list(PLAN)

# In per cent, for the whole and for the worst region (of objects, but of what the whole lamp shines
# on for direct light). Pictures without samples have no noise, but bias.
GOALS = {
    ("all bounces", "cornell", "cycles"): (0.05, 0.2),
    ("all bounces", "seed", "cycles"): (0.1, 0.5),
    ("all bounces", "spheres", "cycles"): (0.05, 0.3),
    ("all bounces", "metals", "cycles"): (0.05, 0.3),
    ("all bounces", "goral", "cycles"): (0.05, 0.2),
    ("all bounces", "shadows", "cycles"): (0.05, 0.3),
    ("all bounces", "furnace", "cycles"): (0.05, 0.3),
    ("all bounces", "cornell", "mitsuba"): (0.05, None),
    ("all bounces", "seed", "mitsuba"): (0.05, None),
    ("all bounces", "spheres", "mitsuba"): (0.05, 0.3),
    ("all bounces", "metals", "mitsuba"): (0.05, 0.3),
    ("all bounces", "goral", "mitsuba"): (0.05, 0.2),
    ("all bounces", "shadows", "mitsuba"): (0.05, 0.3),
    ("all bounces", "furnace", "mitsuba"): (0.05, 0.3),
    ("all bounces", "veach", "mitsuba"): (0.05, 0.3),
    ("all bounces", "cornell", "povray"): (0.5, None),
    ("all bounces", "seed", "povray"): (0.5, None),
    ("all bounces", "spheres", "povray"): (1.0, None),
    ("all bounces", "metals", "povray"): (1.0, None),
    ("all bounces", "goral", "povray"): (0.5, None),
    ("all bounces", "shadows", "povray"): (0.5, None),
    ("direct", "cornell", "cycles"): (None, 0.1),
    ("direct", "cornell", "povray"): (None, 0.1),
    ("one bounce", "cornell", "cycles"): (0.3, None),
    ("one bounce", "cornell", "povray"): (0.3, None),
}
BOUNCES = {"direct": "0:1", "one bounce": "2:2"}
NO_GOAL = (None, None)


def plumb(*arguments, accept=(0,)):
    """Runs `plumb`; returns whether it could."""
    begin = time.perf_counter()
    command = [PLUMB, *map(str, arguments)]
    result = subprocess.run(command, capture_output=True, text=True, check=False)
    if result.returncode not in accept:
        print(f"  {result.stderr.strip()}")
        return False
    print(f"  {time.perf_counter() - begin:6.1f} s  plumb {' '.join(command[1:])}", flush=True)
    return True


def scene_file(scene):
    return (ROOT / "reference_scenes" / scene / "scene.xml").relative_to(pathlib.Path.cwd())


def picture(scene, name):
    folder = ROOT / "reference_scenes" if name in STORED else OUT
    return folder / scene / f"{name}.exr"


def stored_renderers():
    return [other for other in OTHERS if other["word"] in STORED]


def stored_pictures(scene):
    """Names of those that there are: not every program can draw every scene."""
    return [name for name in STORED if picture(scene, name).exists()]


def pairs():
    """What is compared: a title, a scene, two pictures, the goals for the whole and the worst region."""
    def ours(title, scene, other):
        return (title, scene, f"plumbline{suffix(title)}", f"{other['word']}{suffix(title)}",
                *GOALS.get((title, scene, other["word"]), NO_GOAL))
    stored = stored_renderers()
    found = [ours("all bounces", scene, other) for other in OTHERS for scene in SCENES]
    found += [("all bounces", scene, first["word"], second["word"], *NO_GOAL)
              for first, second in itertools.combinations(stored, 2) for scene in SCENES]
    found += [ours(title, "cornell", other) for title in BOUNCES for other in stored]
    return found


def suffix(title):
    """Of the names of pictures of some bounces alone."""
    return f"-{title.split()[-1]}" if title in BOUNCES else ""


def render_masks(scene):
    (OUT / scene).mkdir(parents=True, exist_ok=True)
    for kind in ("object", "side", "shadow"):
        for size, more in (("", []), ("-128", ["--size", "128x128"])):
            plumb("render", scene_file(scene), "--aov", kind, *more,
                  "-o", OUT / scene / f"{kind}{size}.png")


def quality(other, scene):
    """Good is enough where noise is known, and allowed for."""
    return "good" if other["hasSamples"] else PLAN[scene]["quality"]


def is_noiseless(name):
    return any(name.split("-")[0] == other["word"] and not other["hasSamples"] for other in OTHERS)


def compare(pair, kind):
    """What 'plumb compare' says of a pair and the regions of this kind; nothing if one is missing."""
    title, scene, test, reference, *_ = pair
    files = picture(scene, test), picture(scene, reference)
    if not all(file.exists() for file in files):
        return None
    size = "-128" if title == "one bounce" else ""
    mask = OUT / scene / f"{kind}{size}.png"
    report = OUT / scene / f"{test}-{reference}-{kind}.json"
    # A picture without noise has bias: stated as a floor of nothing, to see all of it.
    floor = ["--floor", "0"] if is_noiseless(reference) else []
    if not plumb("compare", *files, "--regions", mask, "--tolerance", "1%", "--negative", *floor,
                 "--json", report, accept=(0, 1, 3)):
        return None
    return json.loads(report.read_text(encoding="utf-8"))


def in_all_channels(entries):
    return [entry for entry in entries if entry["channel"] == "all"]


def percent(entry):
    """The difference and its standard error, both in per cent of the reference."""
    whole = abs(entry["reference"]) or 1.0
    return 100 * entry["difference"] / whole, 100 * (entry["standardError"] or 0.0) / whole


def verdict(goal, difference, error):
    """Whether a difference is within the goal, its noise of two standard errors allowed for."""
    if goal is None:
        return ""
    if abs(difference) + 2 * error <= goal:
        return f"<= {goal} %: yes"
    return f"<= {goal} %: {'no' if abs(difference) - 2 * error > goal else 'within noise'}"


def pair_row(pair, report):
    title, scene, test, reference, goal, region_goal = pair
    image = percent(in_all_channels(report["channels"])[0])
    regions = [(*percent(entry), entry["region"]) for entry in in_all_channels(report["regions"])
               if title != "direct" or entry["region"] == "lit"]
    worst = max(regions, key=lambda entry: abs(entry[0]))
    blocks = next(level for level in report["levels"] if level["level"] == "block")
    bounces = f", `--bounces {BOUNCES[title]}`" if title in BOUNCES else ""
    cells = [
        scene + bounces, f"{test.split('-')[0]} - {reference.split('-')[0]}",
        f"{image[0]:+.3f} ± {image[1]:.3f} %", verdict(goal, *image),
        f"{worst[0]:+.3f} ± {worst[1]:.3f} % ({worst[2]})", verdict(region_goal, *worst[:2]),
        f"{blocks['different']} of {blocks['units']}",
    ]
    return "| " + " | ".join(cells) + " |"


def region_rows(scene, reports):
    """A row for each region, a column for each pair of whole pictures."""
    pairs = [(pair, report) for pair, report in reports
             if pair[0] == "all bounces" and pair[1] == scene]
    rows = ["| region | " + " | ".join(f"{p[2]} - {p[3]}" for p, _ in pairs) + " |",
            "|---|" + "---|" * len(pairs)]
    names = [entry["region"] for entry in in_all_channels(pairs[0][1]["regions"])]
    for name in names:
        cells = []
        for _, report in pairs:
            entry = next(e for e in in_all_channels(report["regions"]) if e["region"] == name)
            cells.append("{:+.3f} ± {:.3f} %".format(*percent(entry)))
        rows.append(f"| {name} | " + " | ".join(cells) + " |")
    return rows


def write_tables(reports, by_side):
    rows = ["| scene | pair | whole | goal | worst region | goal | blocks off by > 1 % |",
            "|---|---|---|---|---|---|---|"]
    rows += [pair_row(pair, report) for pair, report in reports]
    for scene in SCENES:
        rows += ["", f"Sides of things in `{scene}`, all bounces:", ""]
        rows += region_rows(scene, by_side)
    begin, end = "<!-- tables: made by 'make references' -->", "<!-- end of tables -->"
    text = DOCUMENT.read_text(encoding="utf-8")
    before, after = text.split(begin)[0], text.split(end)[1]
    DOCUMENT.write_text("\n".join([before + begin, "", *rows, "", end]) + after, encoding="utf-8")


def floor(scene, name, reports):
    """How far a picture is from the others: the largest difference of whole and of any region that
    is known, with two standard errors, in per cent. The bias of a noiseless one is its own alone."""
    whole, regions = 0.0, {}
    for (title, of_scene, test, reference, *_), report in reports:
        is_measure = is_noiseless(name) or not (is_noiseless(test) or is_noiseless(reference))
        if title != "all bounces" or of_scene != scene or name not in (test, reference):
            continue
        if not is_measure:
            continue
        difference, error = percent(in_all_channels(report["channels"])[0])
        whole = max(whole, abs(difference) + 2 * error)
        for entry in in_all_channels(report["regions"]):
            difference, error = percent(entry)
            region = entry["region"]
            regions[region] = max(regions.get(region, 0.0), abs(difference) + 2 * error)
    return {"wholePercent": round(whole, 4),
            "regionsPercent": {name: round(value, 4) for name, value in regions.items()}}


def write_card(scene, reports):
    pictures = []
    for name in stored_pictures(scene):
        card = {"file": f"{name}.exr", **provenance(picture(scene, name))}
        card["floor"] = floor(scene, name, reports)
        pictures.append(card)
    text = json.dumps({"scene": scene, "pictures": pictures}, indent=1)
    (ROOT / "reference_scenes" / scene / "card.json").write_text(text + "\n", encoding="utf-8")


def write_picture():
    """A row for each scene that all can draw, a column for each program whose pictures are stored."""
    scenes = [scene for scene in SCENES if stored_pictures(scene) == STORED]
    files = [str(picture(scene, program)) for scene in scenes for program in STORED]
    each = "--ch", "R,G,B", "--mulc", "1.5", "--colorconvert", "linear", "sRGB"
    command = ["oiiotool"]
    for file in files:
        command += [file, *each]
    size = f"--mosaic:pad=4 {len(STORED)}x{len(scenes)}".split()
    command += [*size, "-d", "uint8", "-o", ROOT / "docs" / "pictures" / "three_programs.png"]
    subprocess.run(command, check=True)


def tabulate():
    for scene in SCENES:
        render_masks(scene)

    def reports(of_pairs, kind):
        found = [(pair, compare(pair, "shadow" if pair[0] == "direct" else kind))
                 for pair in of_pairs]
        return [(pair, report) for pair, report in found if report]

    by_side = reports([pair for pair in pairs() if pair[0] == "all bounces"], "side")
    for scene in SCENES:
        write_card(scene, by_side)
    write_tables(reports(pairs(), "object"), by_side)
    write_picture()
    print(f"wrote {DOCUMENT.relative_to(ROOT)} and the scenes' card.json")


def make(scenes):
    """Returns 2 if a picture could not be made."""
    # Code that changes has no other version.
    build = hashlib.sha256(pathlib.Path(PLUMB).read_bytes()).hexdigest()[:12]
    wanted = [word for scene in scenes for word in ("--scene", scene)]
    code = study_command.main(["study", "references", "--folder", str(ROOT / "reference_scenes"),
                               "--output", str(OUT), "--store", str(ROOT / "out" / "study" / build), *wanted])
    tabulate()
    return code


def check():
    """Whether today's pictures are close enough to the stored ones.

    Each of the two may be off by its floor: also without samples, threads may share what they gather
    in another order every time. Of noise three standard errors are allowed for.
    """
    is_good = True
    for scene in SCENES:
        render_masks(scene)
        card = json.loads((ROOT / "reference_scenes" / scene / "card.json").read_text("utf-8"))
        for other in stored_renderers():
            program = other["word"]
            if program not in stored_pictures(scene):
                continue
            floors = next(p for p in card["pictures"] if p["file"] == f"{program}.exr")["floor"]
            name = f"{program}-today"
            if not plumb("reference", scene_file(scene), "--with", program, "--quality",
                         quality(other, scene), "-o", picture(scene, name)):
                continue
            report = compare(("check", scene, name, program), "side")
            found = {"the whole": (in_all_channels(report["channels"])[0], floors["wholePercent"])}
            for entry in in_all_channels(report["regions"]):
                found[entry["region"]] = (entry, floors["regionsPercent"][entry["region"]])
            for region, (entry, most) in found.items():
                difference, error = percent(entry)
                if abs(difference) > 2 * most + 3 * error:
                    is_good = False
                    print(f"  {scene}, {program}: {region} differs by {difference:+.3f} "
                          f"± {error:.3f} %, floor {most} %")
    print("the programs draw what is stored" if is_good else "not all is as it was")
    return 0 if is_good else 1


if __name__ == "__main__":
    _, job, PLUMB, *wanted = [*sys.argv, "", ""][:max(3, len(sys.argv))]
    if job not in ("make", "tables", "check") or not PLUMB or set(wanted) - set(SCENES):
        sys.exit(__doc__)
    os.environ["PLUMB"] = str(pathlib.Path(PLUMB).resolve())
    OTHERS = sorted(cluster.programs().values(), key=lambda other: other["word"])
    sys.exit({"make": lambda: make(wanted or SCENES), "tables": tabulate, "check": check}[job]())
