# SPDX-License-Identifier: Apache-2.0

"""Radiance: of a lamp with three corners, only a square about its middle is sampled.

A square lamp at height 0.5 above a point whose irradiance is asked for; the same as two triangles, and one of these.
One shadow ray goes to any place of each lamp (-ds 0 -dj 1), from uncorrelated numbers; then lamps are cut into parts of a
twentieth of their distance (-ds 0.05), without jitter and with it; and last they are `glow`, not sampled but met by chance.

    python3 radiance_triangle.py        (with oconv and rtrace on the PATH, and RAYPATH)

Expected: Lambert's formula for a polygon, in all cases.

Measured with RADIANCE 6.0a, of pyradiance 1.3.1:

    square: expected 2.6108
        -ds 0 -dj 1   : 2.6106 +- 0.0070 (-0.01 %)
        -ds 0.05 -dj 0: 2.6169 +- 0.0000 (+0.24 %)
        -ds 0.05 -dj 1: 2.6108 +- 0.0002 (+0.00 %)
        glow          : 2.6163 +- 0.0026 (+0.21 %)
    two triangles: expected 2.6108
        -ds 0 -dj 1   : 4.5615 +- 0.0060 (+74.72 %)
        -ds 0.05 -dj 0: 4.5694 +- 0.0000 (+75.02 %)
        -ds 0.05 -dj 1: 4.5591 +- 0.0001 (+74.63 %)
        glow          : 2.6086 +- 0.0026 (-0.08 %)
    one triangle: expected 1.3054
        -ds 0 -dj 1   : 2.2826 +- 0.0043 (+74.86 %)
        -ds 0.05 -dj 0: 2.2847 +- 0.0000 (+75.02 %)
        -ds 0.05 -dj 1: 2.2795 +- 0.0001 (+74.62 %)
        glow          : 1.3066 +- 0.0035 (+0.09 %)

after +- stands the standard error.

The cause seems to be in srcsupp.c: fsetsrc() gives lamps of four corners their own sides to be sampled along, but those of
three a square about the middle whose half side is the distance to the nearest edge. All light of the lamp then comes from
there, as if it were bunched in the middle. That square alone, integrated aside, gives 2.279 for one triangle.
"""
import math
import pathlib
import subprocess
import tempfile

RAYS = 200_000
HEIGHT = 0.5
SQUARE = [(-1, -1), (-1, 1), (1, 1), (1, -1)]  # faces down
LAMPS = {"square": [SQUARE], "two triangles": [SQUARE[:3], [SQUARE[2], SQUARE[3], SQUARE[0]]],
         "one triangle": [SQUARE[:3]]}
UNBIASED = ["-u+", "-I+", "-h-", "-aa", "0", "-ad", "1", "-as", "0", "-dt", "0", "-dc", "1"]
WAYS = {"-ds 0 -dj 1": ("light", ["-ab", "0", "-ds", "0", "-dj", "1"]),
        "-ds 0.05 -dj 0": ("light", ["-ab", "0", "-ds", "0.05", "-dj", "0"]),
        "-ds 0.05 -dj 1": ("light", ["-ab", "0", "-ds", "0.05", "-dj", "1"]),
        "glow": ("glow", ["-ab", "1"])}


def lambert(corners):
    """Irradiance at the origin, looking up, under a polygon of radiance 1."""
    rays = [(x, y, HEIGHT) for x, y in corners]
    total = 0.0
    for a, b in zip(rays, rays[1:] + rays[:1]):
        cross = (a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0])
        angle = math.atan2(math.hypot(*cross), sum(p * q for p, q in zip(a, b)))
        total -= 0.5 * angle * cross[2] / math.hypot(*cross)
    return total


def irradiance(polygons, material, options):
    """Mean and standard error."""
    text = f"void {material} lamp\n0\n0\n{'3 1 1 1' if material == 'light' else '4 1 1 1 0'}\n"
    for index, polygon in enumerate(polygons):
        text += f"lamp polygon lamp{index}\n0\n0\n{3 * len(polygon)}\n"
        text += "".join(f"{x} {y} {HEIGHT}\n" for x, y in polygon)
    rays = "0 0 0 0 0 1\n" * RAYS
    with tempfile.TemporaryDirectory() as folder:
        path = pathlib.Path(folder)
        (path / "scene.rad").write_text(text)
        (path / "scene.oct").write_bytes(subprocess.run(
            ["oconv", path / "scene.rad"], stdout=subprocess.PIPE, check=True).stdout)
        lines = subprocess.run(["rtrace", *UNBIASED, *options, path / "scene.oct"], input=rays, text=True,
                               stdout=subprocess.PIPE, stderr=subprocess.DEVNULL, check=True).stdout.splitlines()
    values = [float(line.split()[0]) for line in lines]
    mean = sum(values) / RAYS
    return mean, math.sqrt(sum((value - mean) ** 2 for value in values) / (RAYS - 1) / RAYS)


for lamp, polygons in LAMPS.items():
    expected = sum(lambert(polygon) for polygon in polygons)
    print(f"{lamp}: expected {expected:.4f}")
    for way, (material, options) in WAYS.items():
        mean, error = irradiance(polygons, material, options)
        print(f"    {way:14}: {mean:.4f} +- {error:.4f} ({100.0 * (mean / expected - 1.0):+.2f} %)", flush=True)
