# SPDX-License-Identifier: Apache-2.0

"""Renders a plain scene (docs/plain-scene.md) with Radiance, whose programs oconv and rtrace must be on the PATH.

    python3 radiance_scene.py SCENE.json -o OUT.pfm --spp N
"""

import argparse
import json
import math
import pathlib
import subprocess
import sys
import threading
import time

import numpy

# All that makes rtrace quicker by being wrong is off: no cache of irradiance (-aa 0), one ray for each reflection
# (-ad 1), any number of bounces, which Russian roulette ends (-lr 0) where less than a fifth is left (-lw). A lamp has one
# shadow ray (-ds 0), to any place of it (-dj 1), and none is left out or guessed (-dt 0 -dc 1).
EXACT = ["-u+", "-aa", "0", "-ad", "1", "-as", "0", "-ab", "100000", "-lr", "0", "-lw", "0.2",
         "-ds", "0", "-dj", "1", "-dt", "0", "-dc", "1", "-dp", "0", "-st", "0"]
RELAYS = 8  # lamps are sampled by way of so many flat mirrors
GLOW = 2.0 ** -10  # the share of a lamp that reflects which shines

# Backs are black. Fresnel's reflectance of a metal is that of docs/plain-scene.md.
PATTERNS = """void brightfunc front_only
2 if(Rdot,1,0) .
0
0
"""
FRESNEL = """fp(n,k) = n*n - k*k - 1 + Rdot*Rdot;
fq(n,k) = sqrt(fp(n,k)*fp(n,k) + 4*n*n*k*k);
fa(n,k) = sqrt(.5*(fq(n,k) + fp(n,k)));
fs(n,k) = (fq(n,k) + Rdot*Rdot - 2*fa(n,k)*Rdot) / (fq(n,k) + Rdot*Rdot + 2*fa(n,k)*Rdot);
fr(q,x,y) = (q + x - y) / (q + x + y);
sine2 = 1 - Rdot*Rdot;
ft(n,k) = fr(Rdot*Rdot*fq(n,k), sine2*sine2, 2*fa(n,k)*Rdot*sine2);
fresnel(n,k) = .5*fs(n,k)*(1 + ft(n,k));
"""


def numbers(values):
    return " ".join(repr(float(value)) for value in values)


def record(modifier, kind, name, words=(), values=()):
    return f"{modifier} {kind} {name}\n{len(words)} {' '.join(words)}\n0\n{len(values)} {numbers(values)}\n"


def matte(name, material, share=1.0):
    reflectance = [value / share for value in material["reflectance"]]
    side = "void" if material["two_sided"] else "front_only"
    return record(side, "plastic", name, values=[*reflectance, 0, 0])


def lamp(name, shape, is_sampled):
    radiance, material = shape["radiance"], shape["material"]
    if not any(material["reflectance"]):
        return record("void", "light", name, values=radiance) if is_sampled else \
            record("void", "glow", name, values=[*radiance, 0])
    return (record("void", "glow", f"{name}_glow", values=[*(value / GLOW for value in radiance), 0])
            + matte(f"{name}_matte", material, 1.0 - GLOW)
            + record("void", "mixfunc", name, [f"{name}_glow", f"{name}_matte", repr(GLOW), "."]))


def metal(name, material):
    if "eta" not in material:
        return record("void", "mirror", name, values=material["reflectance"])
    reflectances = [f"fresnel({float(eta)!r},{float(k)!r})" for eta, k in zip(material["eta"], material["k"])]
    return (record("void", "colorfunc", f"{name}_fresnel", [*reflectances, "./fresnel.cal"])
            + record(f"{name}_fresnel", "mirror", name, values=material["reflectance"]))


def material_of(name, shape, is_sampled):
    material = shape["material"]
    if "radiance" in shape:
        return lamp(name, shape, is_sampled)
    if material["kind"] == "matte":
        return matte(name, material)
    if material["kind"] == "glass":
        if any(value != 1 for value in [*material["reflectance"], *material["transmittance"]]):
            sys.exit("tinted glass is not supported")
        return record("void", "dielectric", name, values=[1, 1, 1, material["ior"], 0])
    return metal(name, material)


def polygons_of(triangles):
    """The triangles, of which two that are a parallelogram become one: Radiance samples these evenly."""
    polygons = []
    for triangle in triangles:
        before = polygons[-1] if polygons and len(polygons[-1]) == 3 else []
        shared = [corner for corner in triangle if corner in before]
        if len(shared) == 2:
            alone = next(corner for corner in before if corner not in triangle)
            other = next(corner for corner in triangle if corner not in before)
            at = before.index(alone)
            one, two = before[(at + 1) % 3], before[(at + 2) % 3]
            if numpy.allclose(numpy.add(one, two), numpy.add(alone, other), rtol=1e-12):
                polygons[-1] = [alone, one, other, two]
                continue
        polygons.append(triangle)
    return polygons


def surfaces_of(name, shape):
    """A mirror's back is black: one of two sides is two mirrors."""
    material = shape["material"]
    is_twofold = material["kind"] == "metal" and material["two_sided"]
    if "sphere" in shape:
        ball = [*shape["sphere"]["center"], shape["sphere"]["radius"]]
        return "".join(record(name, kind, f"{name}_{kind}", values=ball)
                       for kind in ("sphere", "bubble")[:1 + is_twofold])
    polygons = polygons_of(shape["triangles"])
    if is_twofold:
        polygons += [polygon[::-1] for polygon in polygons]
    return "".join(record(name, "polygon", f"{name}_{index}", values=[x for corner in polygon for x in corner])
                   for index, polygon in enumerate(polygons))


def points_of(points, extent):
    """Points are small balls."""
    radius = 1e-4 * extent
    text = ""
    for index, point in enumerate(points):
        name = f"point{index}"
        radiance = [value / (math.pi * radius ** 2) for value in point["intensity"]]
        text += record("void", "light", name, values=radiance)
        text += record(name, "sphere", f"{name}_ball", values=[*point["position"], radius])
    return text


def is_bent(shape):
    """Light on its way to lamps is refracted, or reflected by a round mirror."""
    return shape["material"]["kind"] == "glass" or (shape["material"]["kind"] == "metal" and "sphere" in shape)


def scene_of(plain):
    """The scene as Radiance reads it, and whether its mirrors relay lamps."""
    is_sampled = not any(is_bent(shape) for shape in plain["shapes"])
    text = PATTERNS
    for index, shape in enumerate(plain["shapes"]):
        text += material_of(f"shape{index}", shape, is_sampled) + surfaces_of(f"shape{index}", shape)
    place = [row[3] for row in plain["camera"]["camera_to_world"][:3]]
    extent = max((math.dist(place, point["position"]) for point in plain["points"]), default=0.0)
    text += points_of(plain["points"], extent)
    if any(plain["sky"]):
        text += record("void", "glow", "sky", values=[*plain["sky"], 0])
        text += record("sky", "source", "sky_all", values=[0, 0, 1, 360])
    return text, is_sampled


def rays_of(camera, generator):
    """One ray to anywhere in each pixel: places and directions, height x width x 6."""
    right, up, back, place = numpy.array(camera["camera_to_world"], float)[:3].T
    height, width = camera["height"], camera["width"]
    places = generator.random((2, height, width))
    x = camera["half_width"] * (2.0 * (numpy.arange(width)[None, :] + places[0]) / width - 1.0)
    y = camera["half_height"] * (1.0 - 2.0 * (numpy.arange(height)[:, None] + places[1]) / height)
    directions = x[..., None] * right + y[..., None] * up - back
    return numpy.concatenate([numpy.broadcast_to(place, directions.shape), directions], axis=2)


def render(camera, options, spp):
    generator = numpy.random.default_rng()
    command = ["rtrace", "-h-", "-fdf", *options, "scene.oct"]
    with subprocess.Popen(command, stdin=subprocess.PIPE, stdout=subprocess.PIPE) as process:
        def write():
            with process.stdin as pipe:
                for _ in range(spp):
                    pipe.write(rays_of(camera, generator).tobytes())
        writer = threading.Thread(target=write)
        writer.start()
        total = numpy.zeros((camera["height"], camera["width"], 3))
        for _ in range(spp):
            values = process.stdout.read(4 * total.size)
            if len(values) < 4 * total.size:
                sys.exit("rtrace ended early")
            total += numpy.frombuffer(values, "<f4").reshape(total.shape)
        writer.join()
    if process.returncode != 0:
        raise SystemExit(process.returncode)
    return total / spp


def main():
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("scene", type=pathlib.Path)
    parser.add_argument("-o", dest="output", type=pathlib.Path, required=True)
    parser.add_argument("--spp", type=int, required=True)
    arguments = parser.parse_args()
    plain = json.loads(arguments.scene.read_text(encoding="utf-8"))
    text, is_sampled = scene_of(plain)
    pathlib.Path("fresnel.cal").write_text(FRESNEL, encoding="utf-8")
    pathlib.Path("scene.rad").write_text(text, encoding="utf-8")
    with open("scene.oct", "wb") as file:
        subprocess.run(["oconv", "scene.rad"], stdout=file, check=True)
    time.sleep(1.0 - time.time() % 1.0)  # rtrace's seed is the second: no two runs have the same
    begin = time.perf_counter()
    options = [*EXACT, "-dr", str(RELAYS if is_sampled else 0)]
    picture = render(plain["camera"], options, arguments.spp)
    seconds = time.perf_counter() - begin
    header = f"PF\n{plain['camera']['width']} {plain['camera']['height']}\n-1.0\n"
    arguments.output.write_bytes(header.encode() + picture[::-1].astype("<f4").tobytes())
    print("plumbline: " + json.dumps({"seconds": seconds}))


if __name__ == "__main__":
    main()
