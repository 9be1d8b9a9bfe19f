# SPDX-License-Identifier: Apache-2.0

"""Cycles: a rectangle that emits is too dark at grazing angles if it is a mesh.

A rectangular lamp of radiance 1 faces down; a white vertical wall 2.27 in front of it starts below
the lamp's plane. An orthographic camera looks at one point of the wall, a little below that plane.
The same rectangle is rendered as an area light and as an emissive mesh; only direct light counts.

    blender -b --factory-startup --python cycles_mesh_lamp.py        (or: python, with bpy)

Expected: the irradiance of a polygon in closed form (Lambert 1760), divided by pi, for both.

Measured, relative to that (+- is the standard error of 8 seeds):

                        3.4.1                       5.2.3
    below  exact        area      mesh                  area      mesh
    0.03   .0006169    -0.10 %   -1.07 +- 0.01 %       -0.03 %   -0.56 +- 0.01 %
    0.088  .0018062    -0.01 %   -1.11 +- 0.01 %       -0.01 %   -0.19 +- 0.00 %
    0.3    .0060190    -0.00 %   -1.40 +- 0.01 %       +0.00 %   -0.06 +- 0.00 %
    1.0    .0158750    +0.00 %   -0.87 +- 0.01 %       -0.00 %   -0.02 +- 0.00 %
    3.0    .0126431    -0.00 %   -0.00 +- 0.00 %       -0.00 %   -0.00 +- 0.00 %
"""
import math
import os
import statistics
import tempfile

import bpy
from mathutils import Matrix

X, NEAR, FAR = 0.65, 2.27, 3.32  # the lamp: |x| <= X, NEAR <= y <= FAR, z = 0; the wall is y = 0
SEEDS, SIDE, SPP = 8, 32, 64


def lambert(below):
    """Radiance of the white wall at (0, 0, -below): half the sum of angle * (edge's normal . y)."""
    corners = [(x, y, below) for x, y in ((-X, NEAR), (-X, FAR), (X, FAR), (X, NEAR))]
    total = 0.0
    for a, b in zip(corners, corners[1:] + corners[:1]):
        cross = (a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0])
        angle = math.atan2(math.hypot(*cross), sum(map(math.prod, zip(a, b))))
        total += angle * cross[1] / math.hypot(*cross)
    return abs(total) / 2 / math.pi


def material(emits):
    made = bpy.data.materials.new("emission" if emits else "wall")
    if made.node_tree is None:  # before 5.0
        made.use_nodes = True
    nodes = made.node_tree.nodes
    nodes.clear()
    shader = nodes.new("ShaderNodeEmission" if emits else "ShaderNodeBsdfDiffuse")
    shader.inputs["Color"].default_value = (1, 1, 1, 1)
    made.node_tree.links.new(shader.outputs[0],
                             nodes.new("ShaderNodeOutputMaterial").inputs["Surface"])
    return made


def add(data):
    thing = bpy.data.objects.new("thing", data)
    bpy.context.scene.collection.objects.link(thing)
    return thing


def rectangle(corners, emits):
    mesh = bpy.data.meshes.new("rectangle")
    mesh.from_pydata(corners, [], [range(4)])
    mesh.materials.append(material(emits))
    add(mesh)


def set_up(lamp, below):
    bpy.ops.wm.read_factory_settings(use_empty=True)
    scene = bpy.context.scene
    scene.render.engine = "CYCLES"
    scene.render.resolution_x = scene.render.resolution_y = SIDE
    scene.render.image_settings.file_format = "OPEN_EXR"
    scene.render.image_settings.color_depth = "32"
    for name, value in (("samples", SPP), ("max_bounces", 0), ("use_adaptive_sampling", False),
                        ("use_denoising", False), ("sample_clamp_indirect", 0),
                        ("light_sampling_threshold", 0)):
        setattr(scene.cycles, name, value)
    rectangle([(-9, 0, -9), (9, 0, -9), (9, 0, 0), (-9, 0, 0)], emits=False)
    if lamp == "mesh":
        rectangle([(-X, NEAR, 0), (-X, FAR, 0), (X, FAR, 0), (X, NEAR, 0)], emits=True)
    else:
        light = bpy.data.lights.new("lamp", "AREA")
        light.shape, light.size, light.size_y = "RECTANGLE", 2 * X, FAR - NEAR
        # Radiance 1 is 4 watts per area in old versions of Blender and pi in new ones.
        watts = math.pi if bpy.app.version >= (4, 0, 0) else 4
        light.energy = watts * light.size * light.size_y
        add(light).location = (0, (NEAR + FAR) / 2, 0)  # it faces down
    camera = bpy.data.cameras.new("camera")
    camera.type, camera.ortho_scale, camera.clip_start = "ORTHO", 1e-4, 0.01
    scene.camera = add(camera)
    scene.camera.matrix_world = (Matrix.Translation((0, 1, -below))
                                 @ Matrix.Rotation(math.pi / 2, 4, "X")
                                 @ Matrix.Rotation(math.pi, 4, "Y"))
    return scene


def render(scene, seed):
    """The picture's mean."""
    scene.cycles.seed = seed
    scene.render.filepath = os.path.join(tempfile.gettempdir(), f"cycles_{os.getpid()}.exr")
    bpy.ops.render.render(write_still=True)
    image = bpy.data.images.load(scene.render.filepath)
    mean = statistics.fmean(image.pixels[:][0::4])
    bpy.data.images.remove(image)
    os.remove(scene.render.filepath)
    return mean


rows = []
for depth in (0.03, 0.088, 0.3, 1.0, 3.0):
    for kind in ("area light", "mesh"):
        the_scene = set_up(kind, depth)
        means = [render(the_scene, seed) for seed in range(SEEDS)]
        error = statistics.stdev(means) / math.sqrt(SEEDS)
        exact, mean = lambert(depth), statistics.fmean(means)
        rows.append(f"{depth:5} below, {kind:10}: exact {exact:.7f}, measured {mean:.7f}, "
                    f"{100 * (mean / exact - 1):+.3f} % +- {100 * error / exact:.3f} %")
print("Blender " + bpy.app.version_string, *rows, sep="\n")
