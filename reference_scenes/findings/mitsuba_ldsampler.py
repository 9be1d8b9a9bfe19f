# SPDX-License-Identifier: Apache-2.0

"""Mitsuba: the sampler 'ldsampler' gives a wrong mean, at any number of samples.

A lamp of radiance 1 hangs parallel above a white floor of the same size; the picture is one pixel
that is exactly the floor. So the result is an integral over a point of the floor and one of the
lamp. Their random numbers must be independent, but with ldsampler they are correlated: of what it
returns in its k-th and its (k + 2)-th call. The camera's shutter time makes it so that pixel and
lamp are two calls apart. Without it, a BSDF's sample and the next sample of the lamp still are:
light reflected twice came out 7.4 +- 0.5 % too dark in a corridor whose lamp is one of the walls.

    python3 mitsuba_ldsampler.py [VARIANT]        (scalar_rgb if none is named)

Expected: the form factor of two parallel rectangles for all samplers, and correlations of 0.

Measured with 3.9.1, scalar_rgb (llvm_ad_rgb gives the same with ldsampler):

      64 samples, independent: 0.557530 +- 0.002757, -0.86 % +- 0.49 %
      64 samples, multijitter: 0.560618 +- 0.001915, -0.31 % +- 0.34 %
      64 samples, ldsampler  : 0.524562 +- 0.002858, -6.72 % +- 0.51 %
    1024 samples, independent: 0.562651 +- 0.000742, +0.05 % +- 0.13 %
    1024 samples, multijitter: 0.561543 +- 0.000424, -0.14 % +- 0.08 %
    1024 samples, ldsampler  : 0.525369 +- 0.001634, -6.58 % +- 0.29 %
    2 rounds of TEA: next call -0.002, the one after that -0.228, all +- 0.006
    4 rounds of TEA: next call +0.008, the one after that -0.003, all +- 0.006

The cause seems to be permute() in random.h: it hashes with two rounds of TEA unless told otherwise,
and ldsampler gives it seeds that differ by 1 from one call to the next. Four rounds are enough.
"""
import math
import random
import statistics
import sys

import mitsuba as mi

mi.set_variant(sys.argv[1] if len(sys.argv) > 1 else "scalar_rgb")
mi.set_log_level(mi.LogLevel.Error)
from mitsuba import ScalarTransform4f as T  # noqa: E402

SEEDS = 400
A, B, C = 4.0, 1.0, 0.5  # sides and distance of the two rectangles


def form_factor():
    x, y = A / C, B / C
    p, q = math.sqrt(1 + x * x), math.sqrt(1 + y * y)
    return 2 / (math.pi * x * y) * (
        math.log(p * q / math.sqrt(1 + x * x + y * y)) + x * q * math.atan(x / q)
        + y * p * math.atan(y / p) - x * math.atan(x) - y * math.atan(y))


def render(sampler, spp):
    half = T().scale([A / 2, B / 2, 1])
    scene = mi.load_dict({
        "type": "scene",
        "sensor": {
            "type": "orthographic",
            "near_clip": 1e-3,
            "shutter_close": 1.0,  # one more random number between those for pixel and lamp
            "to_world": T().look_at([0, 0, C / 2], [0, 0, 0], [0, 1, 0]) @ half,
            "film": {"type": "hdrfilm", "width": 1, "height": 1, "rfilter": {"type": "box"}},
            "sampler": {"type": sampler, "sample_count": spp},
        },
        "floor": {"type": "rectangle", "to_world": half,
                  "bsdf": {"type": "diffuse", "reflectance": {"type": "rgb", "value": 1.0}}},
        "lamp": {"type": "rectangle",
                 "to_world": T().translate([0, 0, C]).rotate([1, 0, 0], 180) @ half,
                 "bsdf": {"type": "diffuse", "reflectance": {"type": "rgb", "value": 0.0}},
                 "emitter": {"type": "area", "radiance": {"type": "rgb", "value": 1.0}}},
    })
    integrator = mi.load_dict({"type": "path", "max_depth": 2})
    means = []
    for seed in range(SEEDS):
        image = mi.render(scene, integrator=integrator, spp=spp, seed=seed)
        means.append(float(image.array[0]))
    return statistics.fmean(means), statistics.stdev(means) / math.sqrt(SEEDS)


def correlation(distance, rounds):
    """Of two shuffled van der Corput sequences, as ldsampler makes them in two of its calls."""
    values = [], []
    generator = random.Random(1)
    for _ in range(500):
        seed = generator.randrange(1 << 31)
        for i in range(64):
            for k in (0, 1):
                shuffled = mi.permute(i, 64, seed + k * distance, rounds)
                values[k].append(mi.radical_inverse_2(shuffled, 0))
    return statistics.correlation(*values)


exact = form_factor()
print(f"Mitsuba {mi.__version__}, {mi.variant()}; exact {exact:.6f}")
for spp in (64, 1024):
    for sampler in ("independent", "multijitter", "ldsampler"):
        mean, error = render(sampler, spp)
        print(f"{spp:4} samples, {sampler:11}: {mean:.6f} +- {error:.6f}, "
              f"{100 * (mean / exact - 1):+.2f} % +- {100 * error / exact:.2f} %")
for rounds in (2, 4):
    print(f"{rounds} rounds of TEA: correlation with next call {correlation(1, rounds):+.3f}, "
          f"the one after {correlation(2, rounds):+.3f}, all +- 0.006")
