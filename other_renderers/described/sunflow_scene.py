# SPDX-License-Identifier: Apache-2.0

"""Renders a plain scene (docs/plain-scene.md) with sunflow, as Debian's package brings it, by SunflowSampler.java.

    python3 sunflow_scene.py SCENE.json -o OUT.pfm --spp N --seed N --bounces N --threads N
"""

import argparse
import json
import math
import pathlib
import subprocess
import sys

LIBRARY = "/usr/share/java/sunflow.jar"
SPECULAR_DEPTH = 60


def numbers(values):
    return " ".join(repr(float(value)) for value in values)


def parameter(kind, name, values):
    text = " ".join(map(str, values)) if kind in ("int", "string") else numbers(values)
    return f"{kind} {name} {len(values)} {text}\n"


def camera_of(camera):
    """sunflow divides places in the picture by one pixel less than there are."""
    _, up, back, place = zip(*camera["camera_to_world"][:3])
    width = camera["half_width"] * (1.0 - 1.0 / camera["width"])
    height = camera["half_height"] * (1.0 - 1.0 / camera["height"])
    target = [p - b for p, b in zip(place, back)]
    return (parameter("look_at", "transform", [*place, *target, *up])
            + parameter("float", "fov", [2.0 * math.degrees(math.atan(width))])
            + parameter("float", "aspect", [width / height])
            + parameter("float", "shift.x", [-camera["half_width"] / camera["width"]])
            + parameter("float", "shift.y", [-camera["half_height"] / camera["height"]])
            + "camera camera pinhole\n"
            + parameter("string", "camera", ["camera"]))


def options_of(camera, bounces):
    values = {"resolutionX": camera["width"], "resolutionY": camera["height"], "gi.path.samples": 1,
              "depths.diffuse": bounces - 1, "depths.reflection": SPECULAR_DEPTH, "depths.refraction": SPECULAR_DEPTH}
    return (parameter("string", "gi.engine", ["path"])
            + "".join(parameter("int", name, [value]) for name, value in values.items()) + "options\n")


def shader_of(name, material):
    reflectance = material["reflectance"]
    if material["kind"] == "matte":
        kind = "diffuse" if material["two_sided"] else "one_sided"
        return parameter("color", "diffuse", reflectance) + f"shader {name} {kind}\n"
    if material["kind"] == "metal":
        return parameter("color", "color", reflectance) + f"shader {name} mirror\n"
    if reflectance != material["transmittance"]:
        sys.exit("glass whose reflectance is not its transmittance is not supported")
    return (parameter("color", "color", reflectance) + parameter("float", "eta", [material["ior"]])
            + f"shader {name} glass\n")


def mesh_of(triangles):
    corners = [corner for triangle in triangles for corner in triangle]
    return (parameter("points", "points", [x for corner in corners for x in corner])
            + parameter("int", "triangles", range(len(corners))))


def lamp_of(name, shape):
    text = parameter("color", "radiance", shape["radiance"]) + parameter("int", "samples", [1])
    if "sphere" not in shape:
        text += mesh_of(shape["triangles"])
        if not any(shape["material"]["reflectance"]):
            return text + f"light {name} triangle_mesh\n"
        return text + parameter("color", "diffuse", shape["material"]["reflectance"]) + f"light {name} reflecting_lamp\n"
    if any(shape["material"]["reflectance"]):
        sys.exit("round lamps that reflect are not supported")
    ball = shape["sphere"]
    return (text + parameter("point", "center", ball["center"]) + parameter("float", "radius", [ball["radius"]])
            + f"light {name} sphere\n")


def shape_of(name, shape):
    if "radiance" in shape:
        return lamp_of(name, shape)
    text = shader_of(f"{name}_shader", shape["material"])
    if "sphere" in shape:
        text += f"geometry {name} sphere\n"
        text += parameter("ball", "transform", [*shape["sphere"]["center"], shape["sphere"]["radius"]])
    else:
        text += mesh_of(shape["triangles"]) + f"geometry {name} triangle_mesh\n"
    return text + parameter("string", "shaders", [f"{name}_shader"]) + f"instance {name}_instance {name}\n"


def point_of(name, point):
    power = [4.0 * math.pi * value for value in point["intensity"]]
    return parameter("color", "power", power) + parameter("point", "center", point["position"]) + f"light {name} point\n"


def main():
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("scene", type=pathlib.Path)
    parser.add_argument("-o", dest="output", type=pathlib.Path, required=True)
    for name in ("spp", "seed", "bounces", "threads"):
        parser.add_argument(f"--{name}", type=int, required=True)
    arguments = parser.parse_args()
    plain = json.loads(arguments.scene.read_text(encoding="utf-8"))
    text = "".join(shape_of(f"shape{index}", shape) for index, shape in enumerate(plain["shapes"]))
    text += "".join(point_of(f"point{index}", point) for index, point in enumerate(plain["points"]))
    text += camera_of(plain["camera"]) + options_of(plain["camera"], arguments.bounces)
    pathlib.Path("scene.txt").write_text(text, encoding="utf-8")
    sampler = pathlib.Path(__file__).with_name("SunflowSampler.java")
    helpers = arguments.threads - 1  # beside the main thread
    subprocess.run(["java", f"-Djava.util.concurrent.ForkJoinPool.common.parallelism={helpers}",
                    "-Djava.awt.headless=true", "-cp", LIBRARY, sampler, "scene.txt", arguments.output,
                    str(arguments.spp), str(arguments.seed)], check=True)


if __name__ == "__main__":
    main()
