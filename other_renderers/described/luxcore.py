# SPDX-License-Identifier: Apache-2.0

"""Renders a plain scene (docs/plain-scene.md) with LuxCore, whose module pyluxcore `pip install` brings.

    python3 luxcore.py SCENE.json -o OUT.pfm --spp N --seed N --depth N --threads N --engine PATHCPU
"""

import argparse
import array
import json
import math
import pathlib
import time

import pyluxcore

FULL_TURN = 4.0 * math.pi  # LuxCore spreads a point lamp's power over the sphere


def camera_of(camera):
    right_up_back = camera["camera_to_world"]
    place = [row[3] for row in right_up_back[:3]]
    width, height = camera["half_width"], camera["half_height"]
    row = 2.0 * height / camera["height"]  # that LuxCore's pictures are too low, see findings/luxcore_row.py
    return {"type": "perspective",
            "lookat.orig": place,
            "lookat.target": [row[3] - row[2] for row in right_up_back[:3]],
            "up": [row[1] for row in right_up_back[:3]],
            "fieldofview": 90.0,  # so that the window is at distance 1
            "screenwindow": [-width, width, -height - row, height - row],
            "cliphither": 1e-6}


def material_of(material):
    if material["kind"] == "matte":
        return {"type": "matte", "kd": material["reflectance"]}
    if material["kind"] == "glass":
        return {"type": "glass", "kr": material["reflectance"], "kt": material["transmittance"],
                "interiorior": material["ior"], "exteriorior": 1.0}
    return {"type": "mirror", "kr": material["reflectance"]}


def properties_of(scene):
    """All but the meshes, as names with values."""
    values = {}

    def put(prefix, entries):
        for key, value in entries.items():
            values[f"scene.{prefix}.{key}"] = value

    put("camera", camera_of(scene["camera"]))
    put("materials.back", {"type": "matte", "kd": [0.0, 0.0, 0.0]})
    for index, shape in enumerate(scene["shapes"]):
        material = shape["material"]
        front = material_of(material)
        if "radiance" in shape:
            front["emission"] = shape["radiance"]
        put(f"materials.front{index}", front)
        is_one_sided = material["kind"] != "glass" and not material["two_sided"]
        if is_one_sided:
            put(f"materials.shape{index}",
                {"type": "twosided", "frontmaterial": f"front{index}", "backmaterial": "back"})
        put(f"objects.object{index}", {"shape": f"mesh{index}",
                                       "material": f"{'shape' if is_one_sided else 'front'}{index}"})
    for index, point in enumerate(scene["points"]):
        put(f"lights.point{index}", {"type": "point", "position": point["position"],
                                     "color": point["intensity"], "gain": [FULL_TURN] * 3})
    if any(scene["sky"]):
        put("lights.sky", {"type": "constantinfinite", "color": scene["sky"]})
    return values


def to_properties(values):
    properties = pyluxcore.Properties()
    for key, value in values.items():
        properties.Set(pyluxcore.Property(key, value))
    return properties


def read_scene(file):
    plain = json.loads(file.read_text(encoding="utf-8"))
    scene = pyluxcore.Scene()
    for index, shape in enumerate(plain["shapes"]):
        corners = [tuple(corner) for triangle in shape["triangles"] for corner in triangle]
        triangles = [(i, i + 1, i + 2) for i in range(0, len(corners), 3)]
        scene.DefineMesh(f"mesh{index}", corners, triangles, None, None, None, None)
    scene.Parse(to_properties(properties_of(plain)))
    return plain["camera"], scene


def render(camera, scene, arguments):
    config = pyluxcore.RenderConfig(to_properties({
        "renderengine.type": arguments.engine,
        "renderengine.seed": arguments.seed,
        "sampler.type": "RANDOM",
        "sampler.random.adaptive.strength": 0.0,
        "native.threads.count": arguments.threads,
        "film.width": camera["width"],
        "film.height": camera["height"],
        "film.filter.type": "NONE",
        "path.maxdepth": arguments.depth,
        "path.pathdepth.total": arguments.depth,
        "path.pathdepth.diffuse": arguments.depth,
        "path.pathdepth.glossy": arguments.depth,
        "path.pathdepth.specular": arguments.depth,
        "light.maxdepth": arguments.depth,
        "batch.haltspp": arguments.spp}), scene)
    session = pyluxcore.RenderSession(config)
    begin = time.perf_counter()
    session.Start()
    while not session.HasDone():
        time.sleep(0.01)
        session.UpdateStats()
    seconds = time.perf_counter() - begin
    session.Stop()
    values = array.array("f", bytes(12 * camera["width"] * camera["height"]))
    session.GetFilm().GetOutputFloat(pyluxcore.FilmOutputType.RGB, values)
    return values, seconds


def main():
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("scene", type=pathlib.Path)
    parser.add_argument("-o", dest="output", type=pathlib.Path, required=True)
    for name in ("spp", "seed", "depth", "threads"):
        parser.add_argument(f"--{name}", type=int, required=True)
    parser.add_argument("--engine", default="PATHCPU")
    arguments = parser.parse_args()
    pyluxcore.Init()
    camera, scene = read_scene(arguments.scene)
    values, seconds = render(camera, scene, arguments)
    header = f"PF\n{camera['width']} {camera['height']}\n-1.0\n"
    arguments.output.write_bytes(header.encode() + values.tobytes())  # both from the lowest row on
    print("plumbline: " + json.dumps({"version": pyluxcore.Version(), "seconds": seconds}))


if __name__ == "__main__":
    main()
