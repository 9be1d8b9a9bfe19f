#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0

"""Writes what is said in docs/diagnose.md of pictures by other programs with settings of their own.

    python3 bench/diagnose_others.py PLUMB    (which is 'make diagnose-others')

Draws the Cornell box and the seed scene with Blender's Cycles, Mitsuba 3 and POV-Ray, which have to be installed, and
has PLUMB diagnose them. What was diagnosed is kept in out/diagnose_study/others.json, so that a run that was interrupted
goes on; without that file it begins anew.
"""

import importlib.util
import shutil
import subprocess
import sys

from diagnose_study import FOLDER, ROOT, SCENES, Study, scene_file, share

DOCUMENT = ROOT / "docs" / "diagnose.md"
BEGIN, END = "<!-- tables: made by 'make diagnose-others' -->\n", "<!-- end of others -->"
SIDE = 128
CYCLES_SAMPLES, MITSUBA_SAMPLES = 4096, 256  # the first is Blender's default, the other one usual

DIRECT = ("Ambient=0", "Diffuse_part=1", "Lamp=2")
FLOATS = ("+FE", "+A")
# Of a picture: the program, what is its own, and how it is told so.
PICTURES = (
    ("Stored", "by Plumbline", ("plumbline.exr",)),
    ("Stored", "by Cycles, our settings", ("cycles.exr",)),
    ("Stored", "by POV-Ray, our settings", ("povray.exr",)),
    ("Cycles", "4 diffuse bounces, clamped at 10, Blackman-Harris filter of 1.5 pixels",
     ("max_bounces=12", "diffuse_bounces=4", "glossy_bounces=4", "sample_clamp_indirect=10",
      'pixel_filter_type="BLACKMAN_HARRIS"', "filter_width=1.5")),
    ("Mitsuba", "Gaussian filter of 0.5 pixels", ()),
    ("POV-Ray", "no radiosity", (*FLOATS, *DIRECT)),
    ("POV-Ray", "no radiosity, one ray in a pixel", ("+FE", *DIRECT)),
    ("POV-Ray", "no radiosity, ambient light", (*FLOATS, *DIRECT[1:])),
    ("POV-Ray", "no radiosity, old gamma", (*FLOATS, *DIRECT, "Gamma=2.2")),
    ("POV-Ray", "`radiosity {}`", (*FLOATS, *DIRECT, "Radiosity=1")),
    ("POV-Ray", "`radiosity {}`, one light that fades with distance and angle, PNG",
     ("+A", "Ambient=0", "Diffuse_part=1", "Lamp=1", "Radiosity=1")),
    ("POV-Ray", "all defaults", ()),
    ("POV-Ray", "all defaults, with `radiosity {}`", ("Radiosity=1",)),
    ("POV-Ray", "all defaults, with old gamma", ("Gamma=2.2",)),
)


def run(*words, folder=FOLDER):
    done = subprocess.run([str(word) for word in words], cwd=folder, text=True, check=False,
                          stdout=subprocess.PIPE, stderr=subprocess.STDOUT)
    if done.returncode:
        raise SystemExit(f"{words}: {done.stdout[-2000:]}")


def by_cycles(study, scene, settings, picture):
    script = FOLDER / "others.py"
    study.run("export", scene_file(scene), "--to", "cycles", "-o", script)
    sets = [word for setting in settings for word in ("--set", setting)]
    run("blender", "-b", "--factory-startup", "--python", script, "--", "-o", picture, "--spp",
        CYCLES_SAMPLES, "--size", f"{SIDE}x{SIDE}", *sets)


def by_mitsuba(_, scene, __, picture):
    original = scene_file(scene)
    copy = original.with_name("diagnose_others.xml")  # beside its meshes
    before, after = original.read_text("utf-8").split('<rfilter type="box"/>')
    copy.write_text(before + after, "utf-8")
    try:
        run(sys.executable, ROOT / "other_renderers/plumbline_mitsuba.py", copy, "-o", picture, "--spp",
            MITSUBA_SAMPLES, "--size", f"{SIDE}x{SIDE}")
    finally:
        copy.unlink()


def by_povray(study, scene, settings, picture):
    folder = FOLDER / f"povray_{scene}"
    folder.mkdir(exist_ok=True)
    study.run("export", scene_file(scene), "--to", "povray", "-o", folder / "box.pov")
    shutil.copy(ROOT / "bench/povray_by_hand.inc", folder / "plumbline.inc")
    words = [word if word.startswith("+") else f"Declare={word}" for word in settings]
    drawn = folder / f"box{picture.suffix}"
    run("povray", "box.pov", f"+O{drawn}", f"+W{SIDE}", f"+H{SIDE}", "-D", *words, folder=folder)
    shutil.copy(drawn, picture)


def stored(_, scene, file, picture):
    shutil.copy(scene_file(scene).with_name(*file), picture)


DRAW = {"Stored": stored, "Cycles": by_cycles, "Mitsuba": by_mitsuba, "POV-Ray": by_povray}


def said_of(study, scene, program, name, settings):
    """The verdict, and what the likeliest suspect explains."""
    is_png = program == "POV-Ray" and "+FE" not in settings
    said = study.diagnose(f"{program} {scene} {name}", scene_file(scene),
                          lambda picture: DRAW[program](study, scene, settings, picture),
                          FOLDER / ("other.png" if is_png else "other.exr"))
    verdict, line = (said + "\n").splitlines()[:2]
    noise = "; noise shared" if "\nneighbouring pixels share noise" in said else ""
    if not verdict.startswith("different"):
        return verdict + noise
    return (line if " explains " in line else f"{line}; explains {share(said)}") + noise


def main():
    study = Study(sys.argv[1], "others.json")
    missing = [program for program in ("blender", "povray") if not shutil.which(program)]
    if not importlib.util.find_spec("mitsuba"):
        missing.append("mitsuba")
    if missing:
        sys.exit(f"not installed: {', '.join(missing)}")
    rows = ["| picture | " + " | ".join(f"`{scene}`" for scene in SCENES) + " |\n", "|---" * 3 + "|\n"]
    for program, name, settings in PICTURES:
        said = [said_of(study, scene, program, name, settings) for scene in SCENES]
        rows.append(f"| {program}: {name} | {' | '.join(said)} |\n")
    before, rest = DOCUMENT.read_text("utf-8").split(BEGIN)
    DOCUMENT.write_text(f"{before}{BEGIN}{''.join(rows)}{END}{rest.split(END)[1]}", "utf-8")


if __name__ == "__main__":
    if len(sys.argv) != 2:
        sys.exit(__doc__)
    main()
