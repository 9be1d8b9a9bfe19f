"""Renders the stored ground truth of all scenes anew, or checks it.

    python3 reference_scenes/references.py make PLUMB    (which is 'make references')
    python3 reference_scenes/references.py check PLUMB   ('make check-references')

'make' has every installed program render every scene at its best, compares all pairs and writes
reference_scenes/<scene>/*.exr, card.json and the tables of docs/agreement.md. It takes 40 minutes on
two cores. 'check' compares what the installed programs draw today with what is stored; exit code 1
says that it differs. 'tables' renders nothing and makes the tables of what is there.
"""

import json
import pathlib
import subprocess
import sys
import time

ROOT = pathlib.Path(__file__).resolve().parent.parent
sys.path.insert(0, str(ROOT / "images"))
from exr import provenance  # noqa: E402

OUT = ROOT / "out" / "references"
DOCUMENT = ROOT / "docs" / "agreement.md"
SCENES = ["cornell", "seed"]
SAMPLES = {"cornell": 16384, "seed": 65536}

# What is compared: a title, a scene, two pictures, the goals for the whole and for the worst region
# in per cent (of objects, but of what the whole lamp shines on for direct light).
PAIRS = [
    ("all bounces", "cornell", "plumbline", "cycles", 0.05, 0.2),
    ("all bounces", "seed", "plumbline", "cycles", 0.1, 0.5),
    ("all bounces", "cornell", "plumbline", "mitsuba", 0.05, None),
    ("all bounces", "seed", "plumbline", "mitsuba", 0.05, None),
    ("all bounces", "cornell", "plumbline", "povray", 0.5, None),
    ("all bounces", "seed", "plumbline", "povray", 0.5, None),
    ("all bounces", "cornell", "cycles", "povray", None, None),
    ("all bounces", "seed", "cycles", "povray", None, None),
    ("direct", "cornell", "plumbline-direct", "cycles-direct", None, 0.1),
    ("direct", "cornell", "plumbline-direct", "povray-direct", None, 0.1),
    ("one bounce", "cornell", "plumbline-bounce", "cycles-bounce", 0.3, None),
    ("one bounce", "cornell", "plumbline-bounce", "povray-bounce", 0.3, None),
]


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
    """Whole pictures by the programs that everybody can install are stored with the scene."""
    is_stored = name in ("plumbline", "cycles", "povray")
    folder = ROOT / "reference_scenes" / scene if is_stored else OUT / scene
    return folder / f"{name}.exr"


def render_masks(scene):
    (OUT / scene).mkdir(parents=True, exist_ok=True)
    for kind in ("object", "side", "shadow"):
        for size, more in (("", []), ("-128", ["--size", "128x128"])):
            plumb("render", scene_file(scene), "--aov", kind, *more,
                  "-o", OUT / scene / f"{kind}{size}.png")


def render_all(scene):
    file = scene_file(scene)
    plumb("render", file, "--spp", SAMPLES[scene], "-o", picture(scene, "plumbline"))
    # Mitsuba holds all samples in memory at once.
    for program, more in (("mitsuba", ["--spp", 256, "--seeds", 16]), ("povray", []),
                          ("cycles", [])):
        plumb("reference", file, "--with", program, "--quality", "best", *more,
              "-o", picture(scene, program))


def render_by_bounces(scene):
    file = scene_file(scene)
    for name, bounces, more in (("direct", "0:1", []), ("bounce", "2:2", ["--size", "128x128"])):
        plumb("render", file, "--bounces", bounces, "--spp", 16384, *more,
              "-o", picture(scene, f"plumbline-{name}"))
        for program, quality in (("cycles", "good"), ("povray", "best")):
            plumb("reference", file, "--with", program, "--quality", quality, "--bounces", bounces,
                  *more, "-o", picture(scene, f"{program}-{name}"))


def compare(pair, kind):
    """What 'plumb compare' says of a pair and the regions of this kind; nothing if one is missing."""
    title, scene, test, reference, *_ = pair
    files = picture(scene, test), picture(scene, reference)
    if not all(file.exists() for file in files):
        return None
    size = "-128" if title == "one bounce" else ""
    mask = OUT / scene / f"{kind}{size}.png"
    report = OUT / scene / f"{test}-{reference}-{kind}.json"
    # A picture by POV-Ray has no noise, but bias: stated as a floor of nothing, to see all of it.
    floor = ["--floor", "0"] if "povray" in reference else []
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
    bounces = {"all bounces": "", "direct": ", `--bounces 0:1`", "one bounce": ", `--bounces 2:2`"}
    cells = [
        scene + bounces[title], f"{test.split('-')[0]} - {reference.split('-')[0]}",
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
    is known, with two standard errors, in per cent. POV-Ray's is measured by the others only."""
    whole, regions = 0.0, {}
    for (title, of_scene, test, reference, *_), report in reports:
        is_measure = "povray" not in (test, reference) or name == "povray"
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
    for name in ("plumbline", "cycles", "povray"):
        if not picture(scene, name).exists():
            continue
        card = {"file": f"{name}.exr", **provenance(picture(scene, name))}
        card["floor"] = floor(scene, name, reports)
        pictures.append(card)
    text = json.dumps({"scene": scene, "pictures": pictures}, indent=1)
    (ROOT / "reference_scenes" / scene / "card.json").write_text(text + "\n", encoding="utf-8")


def write_picture():
    """All stored pictures side by side: a row for each scene, a column for each program."""
    programs = ["plumbline", "cycles", "povray"]
    files = [str(picture(scene, program)) for scene in SCENES for program in programs]
    each = "--ch", "R,G,B", "--mulc", "1.5", "--colorconvert", "linear", "sRGB"
    command = ["oiiotool"]
    for file in files:
        command += [file, *each]
    size = f"--mosaic:pad=4 {len(programs)}x{len(SCENES)}".split()
    command += [*size, "-d", "uint8", "-o", ROOT / "docs" / "pictures" / "three_programs.png"]
    subprocess.run(command, check=True)


def tabulate():
    for scene in SCENES:
        render_masks(scene)

    def reports(pairs, kind):
        found = [(pair, compare(pair, "shadow" if pair[0] == "direct" else kind)) for pair in pairs]
        return [(pair, report) for pair, report in found if report]

    by_side = reports([pair for pair in PAIRS if pair[0] == "all bounces"], "side")
    for scene in SCENES:
        write_card(scene, by_side)
    write_tables(reports(PAIRS, "object"), by_side)
    write_picture()
    print(f"wrote {DOCUMENT.relative_to(ROOT)} and the scenes' card.json")


def make():
    for scene in SCENES:
        print(scene, flush=True)
        render_all(scene)
    render_by_bounces("cornell")
    tabulate()


def check():
    """Whether today's pictures are close enough to the stored ones.

    Each of the two may be off by its floor: POV-Ray's threads share what they gather in another
    order every time. Cycles has noise, of which three standard errors are allowed for.
    """
    is_good = True
    for scene in SCENES:
        render_masks(scene)
        card = json.loads((ROOT / "reference_scenes" / scene / "card.json").read_text("utf-8"))
        for program, quality in (("cycles", "good"), ("povray", "best")):
            floors = next(p for p in card["pictures"] if p["file"] == f"{program}.exr")["floor"]
            name = f"{program}-today"
            if not plumb("reference", scene_file(scene), "--with", program, "--quality", quality,
                         "-o", picture(scene, name)):
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
    if len(sys.argv) != 3 or sys.argv[1] not in ("make", "tables", "check"):
        sys.exit(__doc__)
    PLUMB = sys.argv[2]
    sys.exit({"make": make, "tables": tabulate, "check": check}[sys.argv[1]]())
