# SPDX-License-Identifier: Apache-2.0

"""Plumbline: a reference renderer that knows how wrong its pictures are, and tells whether yours
differ by more than noise.

    import plumbline
    scene = plumbline.load("scene.xml")
    picture = plumbline.render(scene, spp=256, seed=3)
    verdict = plumbline.compare(picture, "cycles.exr", tolerance="0.5%", regions=scene.mask())
    print(verdict)

The words are those of the command `plumb`, whose help says more about each."""

from ._core import Camera, Shape
from ._core import version as __version__
from .errors import ArgumentError, Error, Notice, PictureError, SceneError
from .pictures import Picture, picture, read
from .scenes import SCENES, Mask, Scene, load, radiosity, render
from .studies import Convergence, Diagnosis, converge, diagnose
from .verdicts import Channels, Errors, Estimate, Verdict, compare

__all__ = [
    "SCENES", "ArgumentError", "Camera", "Channels", "Convergence", "Diagnosis", "Error", "Errors", "Estimate",
    "Mask", "Notice", "Picture", "PictureError", "Scene", "SceneError", "Shape", "Verdict", "__version__",
    "compare", "converge", "diagnose", "load", "picture", "radiosity", "read", "render"]
