# SPDX-License-Identifier: Apache-2.0

"""Cycles: the first sample of every pixel goes through the pixel's middle, whatever the seed.

A half-plane of radiance 1 on black, its edge parallel to the columns of pixels. An orthographic
camera places the edge so that one column is covered to a quarter and, in a second picture, to three
quarters. The filter is a box of one pixel. What is printed is the mean of that column.

    blender -b --factory-startup --python cycles_first_sample.py        (or: python, with bpy)

Expected: means of 0.25 and 0.75 over many seeds, for every number of samples and every offset.

Measured, over 64 seeds, with 3.4.1 and with 5.2.3:

    covered  samples     3.4.1               5.2.3
    0.25     0           0.0000 +- 0.0000    0.0000 +- 0.0000
    0.25     1           0.2583 +- 0.0068    0.2561 +- 0.0062
    0.25     0 to 15     0.2345 +- 0.0005    0.2338 +- 0.0004
    0.25     16 to 31    0.2500 +- 0.0001    0.2500 +- 0.0001
    0.75     0           1.0000 +- 0.0000    1.0000 +- 0.0000
    0.75     1           0.7664 +- 0.0073    0.7578 +- 0.0062
    0.75     0 to 15     0.7654 +- 0.0005    0.7651 +- 0.0004
    0.75     16 to 31    0.7496 +- 0.0001    0.7500 +- 0.0001

One of 16 samples in the middle makes 0.25 * 15 / 16 = 0.2344: a bias at edges that falls as 1/spp
only, and that no comparison of seeds can show. Without sample 0 it is gone.
"""
import math
import os
import statistics
import tempfile

import bpy

SEEDS, WIDTH, HEIGHT = 64, 8, 64  # Blender takes no picture of one column


def set_up(coverage):
    bpy.ops.wm.read_factory_settings(use_empty=True)
    scene = bpy.context.scene
    scene.render.engine = "CYCLES"
    scene.render.resolution_x, scene.render.resolution_y = WIDTH, HEIGHT
    scene.render.image_settings.file_format = "OPEN_EXR"
    scene.render.image_settings.color_depth = "32"
    for name, value in (("use_adaptive_sampling", False), ("use_denoising", False),
                        ("pixel_filter_type", "BOX"), ("filter_width", 1.0)):
        setattr(scene.cycles, name, value)

    emission = bpy.data.materials.new("emission")
    if emission.node_tree is None:  # before 5.0
        emission.use_nodes = True
    nodes = emission.node_tree.nodes
    nodes.clear()
    shader = nodes.new("ShaderNodeEmission")
    shader.inputs["Color"].default_value = (1, 1, 1, 1)
    emission.node_tree.links.new(shader.outputs[0],
                                 nodes.new("ShaderNodeOutputMaterial").inputs["Surface"])
    # A pixel is a unit wide. Column WIDTH / 2, counted from 0, is 0 < x < 1.
    mesh = bpy.data.meshes.new("half-plane")
    corners = [(-99, -99, 0), (coverage, -99, 0), (coverage, 99, 0), (-99, 99, 0)]
    mesh.from_pydata(corners, [], [range(4)])
    mesh.materials.append(emission)
    scene.collection.objects.link(bpy.data.objects.new("half-plane", mesh))

    camera = bpy.data.cameras.new("camera")
    camera.type, camera.sensor_fit, camera.ortho_scale = "ORTHO", "HORIZONTAL", WIDTH
    scene.camera = bpy.data.objects.new("camera", camera)
    scene.camera.location = (0, 0, 1)  # it looks down
    scene.collection.objects.link(scene.camera)
    return scene


def render(scene, samples, offset, seed):
    """The mean of the column at the edge."""
    # Up to 4.3 the offset comes on top of the samples, since 4.4 a subset of them is rendered.
    if hasattr(scene.cycles, "use_sample_subset"):
        scene.cycles.use_sample_subset = True
        scene.cycles.sample_subset_length = samples
        scene.cycles.samples = offset + samples
    else:
        scene.cycles.samples = samples
    scene.cycles.sample_offset = offset
    scene.cycles.seed = seed
    scene.render.filepath = os.path.join(tempfile.gettempdir(), f"cycles_{os.getpid()}.exr")
    bpy.ops.render.render(write_still=True)
    image = bpy.data.images.load(scene.render.filepath)
    mean = statistics.fmean(image.pixels[:][4 * (WIDTH // 2)::4 * WIDTH])
    bpy.data.images.remove(image)
    os.remove(scene.render.filepath)
    return mean


rows = []
for covered in (0.25, 0.75):
    the_scene = set_up(covered)
    for count, first in ((1, 0), (1, 1), (16, 0), (16, 16)):
        means = [render(the_scene, count, first, seed) for seed in range(SEEDS)]
        error = statistics.stdev(means) / math.sqrt(SEEDS)
        rows.append(f"expected {covered}, {count:2} samples from sample {first:2} on: "
                    f"{statistics.fmean(means):.4f} +- {error:.4f}")
print("Blender " + bpy.app.version_string, *rows, sep="\n")
