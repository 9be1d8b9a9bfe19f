#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0

"""Writes the tables of docs/diagnose.md on how well diagnosing works.

    python3 bench/diagnose_study.py PLUMB    (which is 'make diagnose-study')

Has PLUMB diagnose pictures of the Cornell box and the seed scene: with each of its own faults, right
ones, and ones with faults that it does not know. What was diagnosed is kept in out/diagnose_study,
so that a study that was interrupted goes on.
"""

import collections
import json
import pathlib
import re
import subprocess
import sys

ROOT = pathlib.Path(__file__).resolve().parent.parent
FOLDER = ROOT / "out" / "diagnose_study"
DOCUMENT = ROOT / "docs" / "diagnose.md"
BEGIN, END = "<!-- tables: made by 'make diagnose-study' -->\n", "<!-- end of tables -->"

SCENES = ("cornell", "seed")
SAMPLES = (256, 64, 1024)  # in the order of diagnosing
SIZE = "64x64"
VISIBLE = 0.005  # of a region, the least change that has to be found

# Right pictures: how many of each number of samples.
RIGHT = ((16, 50), (64, 50), (256, 50), (1024, 50))

# Faults that no row of the table is: an edit of the scene file, or an operation on the picture.
UNKNOWN = {
    "a block turned by 12 degrees": ("seed", r'y="1" angle="-10"', 'y="1" angle="2"'),
    "the matte sphere moved by 40": ("seed", r'x="142" y="240"', 'x="182" y="240"'),
    "the steel sphere matte": ("seed", r'<float name="radius" value="95"/>\s*<ref id="steel"/>',
                               '<float name="radius" value="95"/><ref id="white"/>'),
    "the red wall green": ("cornell", r'(left_wall.obj"/>[^<]*<boolean[^<]*/>[^<]*)<ref id="red"/>',
                           r'\1<ref id="green"/>'),
    "the camera 20 to the left": ("cornell", r'origin="278, 273, -800" target="278,',
                                  'origin="298, 273, -800" target="298,'),
    "the lamp moved by 60": ("cornell", r'x="278" y="548.3" z="279.5"',
                             'x="338" y="548.3" z="279.5"'),
    "a fall of brightness from left to right": ("cornell", None, [
        "--pattern", "fill:left=0.9,0.9,0.9:right=1.1,1.1,1.1", SIZE, "3", "--mul"]),
    "the red channel a tenth brighter": ("seed", None, ["--mulc", "1.1,1,1"]),
}


class Study:
    def __init__(self, plumb, log="said.json"):
        self.plumb = pathlib.Path(plumb).resolve()
        FOLDER.mkdir(parents=True, exist_ok=True)
        self.log = FOLDER / log
        self.said = json.loads(self.log.read_text("utf-8")) if self.log.exists() else {}

    def run(self, *words):
        result = subprocess.run([str(self.plumb), *map(str, words)], cwd=ROOT, text=True,
                                stdout=subprocess.PIPE, stderr=subprocess.PIPE, check=False)
        if result.returncode not in (0, 1, 3):
            raise SystemExit(f"{words}: {result.stderr}")
        return result.stdout

    def diagnose(self, name, scene, make, picture=FOLDER / "picture.exr"):
        """What is said of a picture, which `make` draws into a file."""
        if name not in self.said:
            make(picture)
            self.said[name] = self.run("diagnose", picture, scene)
            self.log.write_text(json.dumps(self.said, indent=1), "utf-8")
            print(name, self.said[name].splitlines()[:2], flush=True)
        return self.said[name]

    def change(self, scene, fault):
        """By how much, as a part of itself, the fault changes the region that it changes most."""
        name = f"change {scene} {fault}"
        if name not in self.said:
            mask, healthy = FOLDER / f"{scene}.png", FOLDER / f"{scene}.exr"
            faulty = FOLDER / "faulty.exr"
            if not healthy.exists():
                self.run("render", scene_file(scene), "--aov", "side", "-o", mask)
                self.run("render", scene_file(scene), "--spp", 256, "-o", healthy)
            # The same samples: what differs is the fault alone.
            self.run("render", scene_file(scene), "--spp", 256, "--fault", fault, "-o", faulty)
            said = json.loads(self.run("compare", faulty, healthy, "--regions", mask, "--json", "-",
                                       "--negative"))
            self.said[name] = max(abs(f["difference"] / f["reference"]) for f in said["regions"]
                                  if f["channel"] == "all" and f["reference"] > 0)
            self.log.write_text(json.dumps(self.said, indent=1), "utf-8")
        return self.said[name]


def scene_file(scene):
    return ROOT / "reference_scenes" / scene / "scene.xml"


def same_as(said):
    """The names of what a picture is claimed to be the same as the reference with; or none."""
    found = re.search(r"^same as the reference with (.*), to [\d.]+ % everywhere", said, re.MULTILINE)
    return found.group(1) if found else None


def first(said):
    """What comes first in the ranked table."""
    found = re.search(r"\| suspect .*\n\|-.*\n\| (.*?) +\|", said)
    return found.group(1) if found else None


def share(said):
    """What the first of the ranked table explains."""
    found = re.search(r"\| suspect .*\n\|-.*\n\| .*? +\| (.*?) +\|", said)
    return found.group(1) if found else None


def is_named(fault, suspect):
    """Whether the suspect is this fault, its number the usual one."""
    names = re.findall(r"`([^`]*)`(?: \(([\d.]+))?", suspect or "")
    if fault == "exposure":
        return len(names) == 1 and names[0][0] == fault and abs(float(names[0][1]) - 3.1416) < 0.02
    return len(names) == 1 and names[0][0] == fault


def diagnose_fault(study, scene, fault, spp):
    return study.diagnose(f"{scene} {fault} {spp}", scene_file(scene), lambda file: study.run(
        "render", scene_file(scene), "--size", SIZE, "--spp", spp, "--seed", 77, "--fault", fault,
        "-o", file))


def percent(part):
    value = 100 * part
    return f"{value:.2g} %" if value < 99.5 else f"{value:.0f} %"


def own_faults(study):
    faults = re.findall(r"^\| `([\w-]+)` ", study.run("faults"), re.MULTILINE)
    # A fault that changes nothing is a right picture, of which there are others.
    changes = {(scene, fault): study.change(scene, fault) for scene in SCENES for fault in faults}
    shown = [place for place, change in changes.items() if change > 0]
    cells, right = {}, collections.Counter()
    for spp in SAMPLES:
        for scene, fault in shown:
            said = diagnose_fault(study, scene, fault, spp)
            suspect = first(said)
            is_right = is_named(fault, suspect)
            cells[scene, fault, spp] = ("nothing seen" if suspect is None else suspect if not is_right
                                        else "same" if same_as(said) else "first")
            if changes[scene, fault] >= VISIBLE:
                right[spp, is_right] += 1
    yield "| scene | fault | changes a region by | " + " | ".join(f"{n} spp" for n in sorted(SAMPLES)) + " |\n"
    yield "|---" * (3 + len(SAMPLES)) + "|\n"
    for scene, fault in shown:
        row = " | ".join(cells[scene, fault, spp] for spp in sorted(SAMPLES))
        yield f"| {scene} | `{fault}` | {percent(changes[scene, fault])} | {row} |\n"
    yield "\n"
    for spp in sorted(SAMPLES):
        yes, no = right[spp, True], right[spp, False]
        yield (f"{spp} samples: the right name comes first for {yes} of {yes + no} faults that "
               f"change a region by {100 * VISIBLE:g} % or more.\n")


def right_pictures(study):
    yield "\n| right pictures | samples | same | inconclusive | diagnosed |\n|---|---|---|---|---|\n"
    for spp, count in RIGHT:
        words = collections.Counter()
        for i in range(count):
            scene = SCENES[i % 2]
            said = study.diagnose(
                f"right {scene} {spp} {i}", scene_file(scene),
                lambda file, scene=scene, seed=1000 + i, spp=spp: study.run(
                    "render", scene_file(scene), "--size", SIZE, "--spp", spp, "--seed", seed,
                    "-o", file))
            words[said.split()[0].rstrip(":")] += 1
        yield (f"| {count} | {spp} | {words['same']} | {words['inconclusive']} | "
               f"{words['different']} |\n")


def edited(study, scene, pattern, change, file):
    """Renders the scene file with an edit, or has oiiotool edit the picture, which loses its noise."""
    original = scene_file(scene)
    if pattern is None:
        healthy = FOLDER / "healthy.exr"
        study.run("render", original, "--size", SIZE, "--spp", 1024, "--seed", 77, "-o", healthy)
        subprocess.run(["oiiotool", healthy, "--ch", "R,G,B", *change, "-o", file], check=True)
        return
    xml, count = re.subn(pattern, change, original.read_text("utf-8"))
    if count != 1:
        raise SystemExit(f"{pattern}: {count} places in {original}")
    copy = original.with_name("diagnose_study.xml")  # beside its meshes
    copy.write_text(xml, "utf-8")
    study.run("render", copy, "--size", SIZE, "--spp", 1024, "--seed", 77, "-o", file)
    copy.unlink()


def unknown_faults(study):
    yield "\n| fault that is in no table | scene | what is said |\n|---|---|---|\n"
    for name, (scene, pattern, text) in UNKNOWN.items():
        said = study.diagnose(f"unknown {name}", scene_file(scene),
                              lambda file, s=scene, p=pattern, t=text: edited(study, s, p, t, file))
        line = said.splitlines()[1]
        yield f"| {name} | {scene} | {line} |\n"


def main():
    study = Study(sys.argv[1])
    text = DOCUMENT.read_text("utf-8")
    before, rest = text.split(BEGIN)
    tables = "".join([*unknown_faults(study), *right_pictures(study), "\n", *own_faults(study)])
    DOCUMENT.write_text(f"{before}{BEGIN}{tables}{END}{rest.split(END)[1]}", "utf-8")


if __name__ == "__main__":
    if len(sys.argv) != 2:
        sys.exit(__doc__)
    main()
