# SPDX-License-Identifier: Apache-2.0

"""Renders the plot and the pictures of docs/lessons/noise.md, and prints its table.

    python3 bench/noise_lesson.py PLUMB    (which is 'make lessons'; four minutes on two cores)

The seed scene with 16 to 4096 samples per pixel, by random numbers of four kinds, against the stored
reference, which has 65536 samples.
"""

import json
import pathlib
import subprocess
import sys

ROOT = pathlib.Path(__file__).resolve().parent.parent
OUT = ROOT / "out" / "lessons"
PICTURES = ROOT / "docs" / "pictures"
SCENE = ROOT / "reference_scenes" / "seed"
SAMPLES = [16 << i for i in range(9)]
KINDS = {
    "sobol": ["--sampler", "sobol"],
    "independent": ["--sampler", "independent"],
    "webgl-random": ["--fault", "webgl-random"],
    "webgl-demo": ["--fault", "webgl-demo"],
}


def plumb(*arguments, accept=(0,)):
    result = subprocess.run([PLUMB, *map(str, arguments)], capture_output=True, text=True,
                            check=False)
    if result.returncode not in accept:
        sys.exit(result.stderr)


def picture(kind, samples):
    return OUT / f"{kind}-{samples}.exr"


def render(kind):
    """Each picture is the one before and as many samples again."""
    before = 0
    for samples in SAMPLES:
        part = OUT / "part.exr"
        plumb("render", SCENE / "scene.xml", *KINDS[kind], "--seed", 1,
              "--samples", f"{before}:{samples}", "-o", part)
        if before:
            plumb("merge", picture(kind, before), part, "-o", picture(kind, samples))
        else:
            part.rename(picture(kind, samples))
        before = samples


def converge():
    """The plot; a row of errors for each series, and what is said of them."""
    report = OUT / "noise.json"
    pictures = [picture(kind, samples) for kind in KINDS for samples in SAMPLES]
    plumb("converge", *pictures, "--reference", SCENE / "plumbline.exr", "-o",
          PICTURES / "noise.svg", "--json", report)
    found = json.loads(report.read_text(encoding="utf-8"))
    return [[point["relMse"]["all"][0] for point in series["points"]]
            for series in found["series"]], found["sentences"]


def show(file):
    """The healthy picture and the two others, and three times as large what a part of them is."""
    command = ["oiiotool"]
    for more in ([], ["--cut", "84x84+86+40", "--resize:filter=box", "256x256"]):
        for kind in list(KINDS)[1:]:
            command += [picture(kind, SAMPLES[-1]), "--ch", "R,G,B", *more, "--mulc", "1.5",
                        "--colorconvert", "linear", "sRGB"]
    subprocess.run([*command, "--mosaic:pad=4", "3x2", "-d", "uint8", "-o", file], check=True)


def main():
    OUT.mkdir(parents=True, exist_ok=True)
    for kind in KINDS:
        render(kind)
    show(PICTURES / "noise.png")
    errors, sentences = converge()
    print("| samples per pixel | " + " | ".join(KINDS) + " |\n|---|" + "---|" * len(KINDS))
    for samples, *row in zip(SAMPLES, *errors):
        print(f"| {samples} | " + " | ".join(f"{value:.2e}" for value in row) + " |")
    print("\n" + "\n".join(sentences))


if __name__ == "__main__":
    if len(sys.argv) != 2:
        sys.exit(__doc__)
    PLUMB = sys.argv[1]
    main()
