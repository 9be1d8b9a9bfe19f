# SPDX-License-Identifier: Apache-2.0

"""Raysect: a mesh shadows itself where its coordinates are large.

A floor of two triangles, tilted, under a sky of radiance 1. It reflects a half, so it shows 0.5 from wherever it is
seen. The same scene is drawn larger and larger, and with a ball in place of the floor.

    python3 raysect_mesh_shadow.py        (with the module raysect)

Expected: 0.5, whatever the size.

Measured with 0.9.1, 8 x 8 pixels, of which the 0.2 % that both lack are noise:

    size       1: mesh 0.4991 (-0.2 %), ball 0.4991
    size      10: mesh 0.4542 (-9.2 %), ball 0.4991
    size     100: mesh 0.2896 (-42.1 %), ball 0.4991
    size    1000: mesh 0.2561 (-48.8 %), ball 0.4991
    size   10000: mesh 0.2560 (-48.8 %), ball 0.4991

The cause seems to be in mesh.pyx: corners and distances are single precision numbers, and a reflected ray starts
1e-6 off the surface, whatever its coordinates are. Half of the rays then start behind it.
"""
from raysect.core.math.random import seed
from raysect.core.workflow import SerialEngine
from raysect.optical import ConstantSF, World, rotate, translate
from raysect.optical.material import Lambert, UniformSurfaceEmitter
from raysect.optical.observer import FullFrameSampler2D, PinholeCamera, SpectralRadiancePipeline2D
from raysect.primitive import Mesh, Sphere

SAMPLES = 256


def radiance(size, is_mesh):
    """The picture's mean."""
    world = World()
    matte = Lambert(ConstantSF(0.5))
    corners = [(x * size, (0.3 * x + 0.2 * z) * size, z * size) for x, z in ((-1, -1), (-1, 1), (1, 1), (1, -1))]
    thing = Mesh(corners, [(0, 1, 2), (0, 2, 3)], smoothing=False, closed=False, material=matte) if is_mesh else \
        Sphere(size, transform=translate(0.0, -size, 0.0), material=matte)
    thing.parent = world
    Sphere(100.0 * size, world, material=UniformSurfaceEmitter(ConstantSF(1.0)))
    pipeline = SpectralRadiancePipeline2D()
    camera = PinholeCamera((8, 8), fov=1.0, frame_sampler=FullFrameSampler2D(), pipelines=[pipeline], parent=world,
                           transform=translate(0.1 * size, size, 0.1 * size) * rotate(0, -90, 0))
    camera.render_engine, camera.quiet = SerialEngine(), True
    camera.spectral_rays = camera.spectral_bins = 1
    camera.pixel_samples = SAMPLES
    seed(1)
    camera.observe()
    return pipeline.frame.mean.mean()


for size in (1.0, 10.0, 100.0, 1000.0, 10000.0):
    mesh, ball = radiance(size, True), radiance(size, False)
    print(f"size {size:7g}: mesh {mesh:.4f} ({200.0 * mesh - 100.0:+.1f} %), ball {ball:.4f}", flush=True)
