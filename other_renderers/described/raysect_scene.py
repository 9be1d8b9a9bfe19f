# SPDX-License-Identifier: Apache-2.0

"""Renders a plain scene (docs/plain-scene.md) with Raysect, whose module raysect `pip install` brings.

    python3 raysect_scene.py SCENE.json -o OUT.pfm --spp N --seed N --depth N
"""

import argparse
import json
import math
import pathlib
import time

import numpy
import raysect
from raysect.core.math.random import seed
from raysect.core.workflow import SerialEngine
from raysect.optical import AffineMatrix3D, World
from raysect.optical.material import Conductor, Dielectric, Lambert, UniformSurfaceEmitter
from raysect.optical.material.debug import PerfectReflectingSurface
from raysect.optical.observer import FullFrameSampler2D, PinholeCamera, SpectralRadiancePipeline2D
from raysect.optical.spectralfunction import ConstantSF, InterpolatedSF
from raysect.primitive import Mesh, Sphere

SHORTEST, LONGEST = 400.0, 700.0  # three bins of wavelengths are the three channels


def spectrum(channels):
    edges = numpy.linspace(SHORTEST, LONGEST, 4)
    margin = 1e-6
    wavelengths = [place for low, high in zip(edges, edges[1:]) for place in (low + margin, high - margin)]
    return InterpolatedSF(wavelengths, numpy.repeat(channels, 2))


class Lamp(Lambert):
    """A matte surface whose front shines."""

    def __init__(self, reflectance, radiance):
        super().__init__(spectrum(reflectance))
        self.is_black = not any(reflectance)
        self.radiance = numpy.array(radiance)
        self.importance = 1.0  # directions to its bounding sphere are sampled

    def evaluate_surface(self, world, ray, primitive, hit_point, exiting, *places):
        light = ray.new_spectrum() if self.is_black else super().evaluate_surface(
            world, ray, primitive, hit_point, exiting, *places)
        if not exiting:
            light.samples[:] += self.radiance
        return light


def tinted(base):
    """A mirror of that kind which shows a part of what comes."""

    class Tinted(base):
        def __init__(self, reflectance, *numbers):
            super().__init__(*numbers)
            self.reflectance = numpy.array(reflectance)

        def evaluate_surface(self, *places):
            light = super().evaluate_surface(*places)
            light.samples[:] *= self.reflectance
            return light

    return Tinted


Mirror, Metal = tinted(PerfectReflectingSurface), tinted(Conductor)


def material_of(shape):
    material = shape["material"]
    if "radiance" in shape:
        return Lamp(material["reflectance"], shape["radiance"])
    if material["kind"] == "matte":
        return Lambert(spectrum(material["reflectance"]))
    if material["kind"] == "glass":
        return Dielectric(ConstantSF(material["ior"]), ConstantSF(1.0))
    if "eta" in material:
        return Metal(material["reflectance"], spectrum(material["eta"]), spectrum(material["k"]))
    return Mirror(material["reflectance"])


def add(shape, world):
    if "sphere" in shape:
        ball = shape["sphere"]
        transform = AffineMatrix3D([[1, 0, 0, ball["center"][0]], [0, 1, 0, ball["center"][1]],
                                    [0, 0, 1, ball["center"][2]], [0, 0, 0, 1]])
        return Sphere(ball["radius"], world, transform, material_of(shape))
    corners = [corner for triangle in shape["triangles"] for corner in triangle]
    triangles = numpy.arange(len(corners)).reshape(-1, 3)
    return Mesh(corners, triangles, smoothing=False, closed=False, parent=world, material=material_of(shape))


def camera_of(camera, world, pipeline):
    columns = numpy.array(camera["camera_to_world"], float)
    columns[:, 0] *= -1.0  # Raysect looks along z, and x is to the left
    columns[:, 2] *= -1.0
    largest = max(camera["half_width"], camera["half_height"])
    return PinholeCamera((camera["width"], camera["height"]), fov=math.degrees(2.0 * math.atan(largest)),
                         frame_sampler=FullFrameSampler2D(), pipelines=[pipeline], parent=world,
                         transform=AffineMatrix3D(columns.tolist()))


def cosines(camera):
    """Of pixels' middles to the camera's axis, by which Raysect weights what a pixel sees."""
    x, y = (half * (numpy.arange(0.5, count) * 2.0 / count - 1.0) for half, count in (
        (camera["half_width"], camera["width"]), (camera["half_height"], camera["height"])))
    return 1.0 / numpy.sqrt(1.0 + x[None, :] ** 2 + y[:, None] ** 2)


def main():
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("scene", type=pathlib.Path)
    parser.add_argument("-o", dest="output", type=pathlib.Path, required=True)
    for name in ("spp", "seed", "depth"):
        parser.add_argument(f"--{name}", type=int, required=True)
    arguments = parser.parse_args()
    plain = json.loads(arguments.scene.read_text(encoding="utf-8"))
    world = World()
    parts = [add(shape, world) for shape in plain["shapes"]]
    if any(plain["sky"]):
        parts.append(Sphere(1e6, world, material=UniformSurfaceEmitter(spectrum(plain["sky"]))))
    pipeline = SpectralRadiancePipeline2D()
    camera = camera_of(plain["camera"], world, pipeline)
    camera.render_engine = SerialEngine()
    camera.quiet = True
    camera.spectral_rays, camera.spectral_bins = 1, 3
    camera.min_wavelength, camera.max_wavelength = SHORTEST, LONGEST
    camera.pixel_samples = arguments.spp
    camera.ray_max_depth = arguments.depth
    camera.ray_importance_sampling = True
    seed(arguments.seed)
    begin = time.perf_counter()
    camera.observe()
    seconds = time.perf_counter() - begin
    radiance = pipeline.frame.mean.transpose(1, 0, 2) / cosines(plain["camera"])[:, :, None]
    rows = radiance[::-1].astype("<f4")  # from the lowest on
    header = f"PF\n{plain['camera']['width']} {plain['camera']['height']}\n-1.0\n"
    arguments.output.write_bytes(header.encode() + rows.tobytes())
    print("plumbline: " + json.dumps({"version": raysect.__version__, "seconds": seconds}))


if __name__ == "__main__":
    main()
