# SPDX-License-Identifier: Apache-2.0

"""Renders a plain scene (docs/plain-scene.md) with toyray, a path tracer of a course (github.com/111116/toyray).

    python3 toyray.py SCENE.json -o OUT.exr --spp N --bounces N
"""

import argparse
import json
import math
import os
import pathlib
import subprocess

BLACK = {"type": "lambert", "albedo": [0.0, 0.0, 0.0]}


def camera_of(camera):
    columns = list(zip(*camera["camera_to_world"]))
    right, up, back, place = (column[:3] for column in columns)
    return {"type": "pinhole",
            "resolution": [camera["width"], camera["height"]],
            "fov": math.degrees(2.0 * math.atan(camera["half_width"])),
            "transform": {"position": place, "up": up,
                          "look_at": [p - b for p, b in zip(place, back)]}}


def material_of(material):
    if material["kind"] == "matte":
        return {"type": "lambert", "albedo": material["reflectance"]}
    if material["kind"] == "glass":
        return {"type": "dielectric", "ior": material["ior"]}
    return {"type": "mirror", "albedo": material["reflectance"]}


def primitives_of(shape):
    common = {"bsdf": material_of(shape["material"])}
    if "radiance" in shape:
        common |= {"emission": shape["radiance"], "sampled_side": -1}  # the front alone
    if "sphere" in shape:
        return [common | {"type": "sphere", "origin": shape["sphere"]["center"],
                          "radius": shape["sphere"]["radius"]}]
    return [common | {"type": "triangle", "vertices": triangle} for triangle in shape["triangles"]]


def main():
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("scene", type=pathlib.Path)
    parser.add_argument("-o", dest="output", required=True)
    parser.add_argument("--spp", type=int, required=True)
    parser.add_argument("--bounces", type=int, required=True)
    arguments = parser.parse_args()
    plain = json.loads(arguments.scene.read_text(encoding="utf-8"))
    emissions = [{"type": "point"} | point for point in plain["points"]]
    if any(plain["sky"]):
        emissions.append({"type": "constant", "radiance": plain["sky"]})
    scene = {"camera": camera_of(plain["camera"]),
             "primitives": [p for shape in plain["shapes"] for p in primitives_of(shape)],
             "emissions": emissions,
             "integrator": {"max_bounces": arguments.bounces},
             "renderer": {"spp": arguments.spp, "output_file": arguments.output}}
    pathlib.Path("toyray.json").write_text(json.dumps(scene), encoding="utf-8")
    program = os.environ.get("TOYRAY", "toyray")
    subprocess.run([program, "--quiet", "toyray.json"], check=True)


if __name__ == "__main__":
    main()
