# SPDX-License-Identifier: Apache-2.0

"""Mitsuba's volpathmis: light that is reflected often is too dark, if lamps reflect.

A closed room whose walls all have radiance L and reflect a part a, evenly. So from everywhere the same
radiance comes, which is a geometric series. No medium is in it.

    python3 mitsuba_volpathmis_roulette.py        (with the module mitsuba)

Expected: L (1 - a^n) / (1 - a) with light of up to n - 1 bounces, whatever Russian roulette does.

Measured with 3.9.0, L = 0.05, a = 0.9, scalar_rgb:

    path       roulette from    5: 0.44475 +- 0.00050, expected 0.44529, -0.12 % +- 0.11 %
    path       roulette from 1000: 0.44528 +- 0.00005, expected 0.44529, -0.00 % +- 0.01 %
    volpath    roulette from    5: 0.44557 +- 0.00040, expected 0.44529, +0.06 % +- 0.09 %
    volpath    roulette from 1000: 0.44540 +- 0.00004, expected 0.44529, +0.02 % +- 0.01 %
    volpathmis roulette from    5: 0.43902 +- 0.00038, expected 0.44529, -1.41 % +- 0.09 %
    volpathmis roulette from 1000: 0.44535 +- 0.00003, expected 0.44529, +0.01 % +- 0.01 %

The cause seems to be in volpathmis.cpp: a path's probability of survival goes into the weight of its own
density (p_over_f), but not into the one that a sampled lamp would have had there (p_over_f_nee), while a
sampled lamp's two weights both have it.
"""
import math
import statistics

import mitsuba as mi
import numpy as np

mi.set_variant("scalar_rgb")
RADIANCE, ALBEDO, SIDE, SEEDS = 0.05, 0.9, 8, 8
look = mi.ScalarTransform4f().look_at


def room(integrator, depth, roulette):
    scene = {"type": "scene",
             "integrator": {"type": integrator, "max_depth": depth, "rr_depth": roulette},
             "sensor": {"type": "perspective", "fov": 60,
                        "to_world": look(origin=[0.1, 0.2, -0.3], target=[0.4, -0.3, 0.9], up=[0, 1, 0]),
                        "film": {"type": "hdrfilm", "width": SIDE, "height": SIDE, "rfilter": {"type": "box"}},
                        "sampler": {"type": "independent", "sample_count": 1024}}}
    for axis in range(3):
        for side in (-1.0, 1.0):
            middle, up = [0.0] * 3, [0.0] * 3
            middle[axis], up[(axis + 1) % 3] = side, 1.0
            scene[f"wall{axis}{'ab'[side > 0.0]}"] = {
                "type": "rectangle", "to_world": look(origin=middle, target=[0, 0, 0], up=up),
                "bsdf": {"type": "diffuse", "reflectance": {"type": "rgb", "value": ALBEDO}},
                "emitter": {"type": "area", "radiance": {"type": "rgb", "value": RADIANCE}}}
    return mi.load_dict(scene)


for integrator in ("path", "volpath", "volpathmis"):
    for bounces, roulette in ((20, 5), (20, 1000)):
        exact = RADIANCE * (1.0 - ALBEDO ** (bounces + 1)) / (1.0 - ALBEDO)
        scene = room(integrator, bounces + 1, roulette)
        means = [float(np.mean(mi.render(scene, seed=seed))) for seed in range(SEEDS)]
        mean, error = statistics.fmean(means), statistics.stdev(means) / math.sqrt(SEEDS)
        print(f"    {integrator:10} roulette from {roulette:4}: {mean:.5f} +- {error:.5f}, expected {exact:.5f}, "
              f"{100 * (mean / exact - 1):+.2f} % +- {100 * error / exact:.2f} %", flush=True)
