# SPDX-License-Identifier: Apache-2.0

"""Puts the live page together: python3 web/make_page.py build-web/plumbline.wasm out/plumbline.html"""

import base64
import gzip
import json
import pathlib
import re
import subprocess
import sys

HERE = pathlib.Path(__file__).resolve().parent
ROOT = HERE.parent
sys.dont_write_bytecode = True  # nothing but sources in the folders
sys.path[:0] = [str(ROOT / "images"), str(ROOT)]
import exr  # noqa: E402
from report import page  # noqa: E402

SCENES = ("seed", "cornell", "spheres")
PROGRAMS = {"plumbline": "the converged picture", "cycles": "Blender Cycles", "povray": "POV-Ray"}
MANTISSA_BITS = 7  # kept of the stored pictures: an error of 0.1 %, less than their own noise


def bundle(name):
    """A module and what it imports as one script that says nothing that would end its element."""
    return subprocess.run(
        ["esbuild", HERE / name, "--bundle", "--minify", "--format=iife", "--charset=utf8",
         "--log-level=warning"], check=True, capture_output=True, text=True).stdout


def packed(core):
    return base64.b64encode(gzip.compress(core.read_bytes(), 9, mtime=0)).decode("ascii")


def halved(plane, width):
    """Means over 2 x 2 pixels."""
    rows = [plane[i:i + width] for i in range(0, len(plane), width)]
    return [(a[x] + a[x + 1] + b[x] + b[x + 1]) / 4
            for a, b in zip(rows[::2], rows[1::2]) for x in range(0, width, 2)]


def picture(file, title, is_halved):
    width, height, planes = exr.planes(file, ["R", "G", "B"])
    if is_halved:
        planes = [halved(plane, width) for plane in planes]
        width, height = width // 2, height // 2
    return {"title": title, "width": width, "height": height,
            "values": page.encode_picture(planes, MANTISSA_BITS)}


def pictures(folder):
    """Those that are stored; none without ours, whose size is the others'."""
    if not (folder / "plumbline.exr").exists():
        return {}
    return {word: picture(folder / f"{word}.exr", title, word != "plumbline")
            for word, title in PROGRAMS.items() if (folder / f"{word}.exr").exists()}


def scene(name):
    folder = ROOT / "reference_scenes" / name
    files = {file.name: file.read_text("utf-8") for file in sorted(folder.iterdir())
             if file.suffix in (".xml", ".obj")}
    return {"title": page.title_of(name), "files": files, "pictures": pictures(folder)}


def main():
    core, file = map(pathlib.Path, sys.argv[1:])
    data = {"core": packed(core), "scenes": {name: scene(name) for name in SCENES}}
    parts = {"style": (HERE / "page.css").read_text("utf-8"),
             "data": json.dumps(data, separators=(",", ":")).replace("<", "\\u003c"),
             "worker": bundle("worker.js"), "script": bundle("page.js"),
             "lessons": page.link_to_lessons(file)}
    text = re.sub("{{([a-z]+)}}", lambda match: parts[match[1]], (HERE / "page.html").read_text("utf-8"))
    file.parent.mkdir(parents=True, exist_ok=True)
    unfinished = file.with_name(file.name + ".part")
    unfinished.write_text(text, "utf-8")
    unfinished.replace(file)
    print(f"{file}: {len(text.encode()) / 1e6:.2f} MB")


if __name__ == "__main__":
    main()
