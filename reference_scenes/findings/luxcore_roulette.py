# SPDX-License-Identifier: Apache-2.0

"""LuxCore: light that is reflected three times and more is too bright, if lamps reflect.

A closed room whose walls all have radiance L and reflect a part a, evenly. So from everywhere the same
radiance comes, which is a geometric series.

    python3 luxcore_roulette.py        (with the module pyluxcore)

Expected: L (1 - a^n) / (1 - a) with light of up to n - 1 bounces, whatever Russian roulette does.

Measured with 2.11.2, L = 0.05, a = 0.9, samples independent:

    2 bounces, roulette from    3: 0.13550 +- 0.00005, expected 0.13550, -0.00 % +- 0.04 %
    2 bounces, roulette from 1000: 0.13558 +- 0.00003, expected 0.13550, +0.06 % +- 0.02 %
    3 bounces, roulette from    3: 0.17887 +- 0.00004, expected 0.17195, +4.03 % +- 0.02 %
    3 bounces, roulette from 1000: 0.17203 +- 0.00002, expected 0.17195, +0.05 % +- 0.01 %
    4 bounces, roulette from    3: 0.21782 +- 0.00002, expected 0.20476, +6.38 % +- 0.01 %

The cause seems to be in pathtracer.cpp: from the third bounce on the weight of a sampled lamp takes the
density of the BSDF times the probability of survival (DirectLightSampling), while the weight of a lamp that
was met takes it without (DirectHitFiniteLight). Both together are more than 1.
"""
import array
import math
import statistics
import time

import pyluxcore

RADIANCE, ALBEDO, SIDE, SEEDS = 0.05, 0.9, 8, 4
SQUARE = [(-1.0, -1.0), (1.0, -1.0), (1.0, 1.0), (-1.0, 1.0)]


def properties(values):
    result = pyluxcore.Properties()
    for key, value in values.items():
        result.Set(pyluxcore.Property(key, value))
    return result


def room():
    scene = pyluxcore.Scene()
    values = {"scene.camera.lookat.orig": [0.1, 0.2, -0.3], "scene.camera.lookat.target": [0.4, -0.3, 0.9],
              "scene.camera.up": [0.0, 1.0, 0.0],
              "scene.materials.wall.type": "matte", "scene.materials.wall.kd": [ALBEDO] * 3,
              "scene.materials.wall.emission": [RADIANCE] * 3}
    for axis in range(3):
        for side in (-1.0, 1.0):
            corners = [tuple([*corner[:axis], side, *corner[axis:]]) for corner in SQUARE]
            if (side > 0.0) != (axis == 1):
                corners.reverse()  # fronts look inwards
            name = f"wall{axis}{'ab'[side > 0.0]}"
            scene.DefineMesh(name, corners, [(0, 1, 2), (0, 2, 3)], None, None, None, None)
            values |= {f"scene.objects.{name}.shape": name, f"scene.objects.{name}.material": "wall"}
    scene.Parse(properties(values))
    return scene


def render(scene, depth, roulette, seed):
    config = pyluxcore.RenderConfig(properties({
        "renderengine.type": "PATHCPU", "renderengine.seed": seed, "sampler.type": "RANDOM",
        "film.width": SIDE, "film.height": SIDE, "film.filter.type": "NONE", "batch.haltspp": 1024,
        "path.russianroulette.depth": roulette, "path.pathdepth.total": depth, "path.pathdepth.diffuse": depth}),
        scene)
    session = pyluxcore.RenderSession(config)
    session.Start()
    while not session.HasDone():
        time.sleep(0.01)
        session.UpdateStats()
    session.Stop()
    values = array.array("f", bytes(12 * SIDE * SIDE))
    session.GetFilm().GetOutputFloat(pyluxcore.FilmOutputType.RGB, values)
    return statistics.fmean(values)


pyluxcore.Init()
scene = room()
for depth in (3, 4, 5):
    exact = RADIANCE * (1.0 - ALBEDO ** depth) / (1.0 - ALBEDO)
    for roulette in (3, 1000):
        means = [render(scene, depth, roulette, seed) for seed in range(1, SEEDS + 1)]
        mean, error = statistics.fmean(means), statistics.stdev(means) / math.sqrt(SEEDS)
        print(f"{depth - 1} bounces, roulette from {roulette:4}: {mean:.5f} +- {error:.5f}, expected {exact:.5f}, "
              f"{100 * (mean / exact - 1):+.2f} % +- {100 * error / exact:.2f} %", flush=True)
