# SPDX-License-Identifier: Apache-2.0

"""Scenes, and what draws them."""

from __future__ import annotations

import os
import pathlib
from collections.abc import Sequence
from typing import Literal

import numpy as np
import numpy.typing as npt

from . import _core
from ._words import Progress, joined, shown, span, warn_of_notices, words
from .errors import ArgumentError
from .pictures import PathLike, Picture

SCENES = pathlib.Path(__file__).parent / "share" / "plumbline"
"""The reference scenes, a folder each: SCENES / "cornell" / "scene.xml"."""


class Mask:
    """Which part of a scene each pixel sees: mask["left_wall"] is true for its pixels."""

    def __init__(self, names: list[str], labels: npt.NDArray[np.int32], place: tuple[int, int, int, int],
                 held: _core.Picture) -> None:
        self.names = names
        self.labels = labels
        """Height x width numbers of names, of a crop those of its pixels; -1 for an edge or nothing."""
        self._place = place
        self._held = held

    def __getitem__(self, name: str) -> npt.NDArray[np.bool_]:
        if name not in self.names:
            raise ArgumentError(f"no region {name}, but {', '.join(self.names)}")
        return np.asarray(self.labels == self.names.index(name))

    def write(self, file: PathLike) -> None:
        """As a picture with a colour for each region, which knows their names."""
        self._held.write(os.fspath(file), 0.0)

    def __repr__(self) -> str:
        return f"<plumbline.Mask {', '.join(self.names)}>"


class Scene:
    """A scene, as its file has it."""

    def __init__(self, held: _core.Scene, file: str) -> None:
        self._held = held
        self.file = file

    @property
    def name(self) -> str:
        return self._held.name

    @property
    def hash(self) -> str:
        """Of the bytes of all its files."""
        return self._held.hash

    @property
    def notes(self) -> list[str]:
        """What of the file was taken how, a line each."""
        return self._held.notes

    @property
    def camera(self) -> _core.Camera:
        return self._held.camera

    @property
    def shapes(self) -> dict[str, _core.Shape]:
        """By their ids; what has none is called by its place, as "#3"."""
        return {shape.id: shape for shape in self._held.shapes}

    def mask(self, kind: Literal["object", "side", "shadow"] = "object", *, size: tuple[int, int] | str | None = None,
             crop: tuple[int, int, int, int] | str | None = None) -> Mask:
        """The regions of its pictures: a shape each, a side of a shape each (front, left, ...), or
        what is lit, in penumbra and in umbra. `size` and `crop` are render()'s; a crop has the colours
        that the whole mask has there."""
        return Mask(*_core.mask(self._held, kind, words(size=joined(size, "x"), crop=joined(crop, ","))))

    def __repr__(self) -> str:
        return f"<plumbline.Scene {self.name}: {self.camera.width}x{self.camera.height}, {', '.join(self.shapes)}>"


def load(file: PathLike) -> Scene:
    """Reads a scene in the subset of Mitsuba 3's XML that docs/scenes.md describes. Raises
    SceneError, which says all that is wrong or not supported; warns of what was taken how."""
    name = os.fspath(file)
    scene = Scene(_core.load(name), name)
    warn_of_notices()
    return scene


def _scene(scene: Scene | PathLike) -> Scene:
    if isinstance(scene, Scene):
        return scene
    name = os.fspath(scene)
    return Scene(_core.load(name), name)


def render(scene: Scene | PathLike, *, spp: int | None = None, time: float | None = None,
           error: float | str | None = None, samples: tuple[int, int] | str | None = None,
           crop: tuple[int, int, int, int] | str | None = None, seed: int | None = None,
           bounces: tuple[int, int | None] | str | None = None, size: tuple[int, int] | str | None = None,
           method: Literal["bsdf", "nee", "mis", "plain"] | None = None,
           sampler: Literal["sobol", "independent"] | None = None,
           precision: Literal["float", "double"] | None = None, threads: int | None = None,
           from_: Sequence[str] | str | None = None, by: Sequence[str] | str | None = None, fault: str | None = None, progress: Progress = False) -> Picture:
    """Renders a scene, which may be the name of its file, with the path tracer.

    The first of the limits spp (samples per pixel), time (seconds) and error (relative, as 0.01 or
    "1%") to be reached ends the render. bounces=(2, 5) lets only light of so many bounces reach the
    picture, (2, None) that of 2 and more. The same scene, seed and samples give the same bits on any
    number of threads; a default seed is 1. from_="left_wall" leaves only light that came straight from
    that shape (or several) to what is seen, by= what it has reflected. crop=(x, y, width, height)
    draws these pixels alone, with the bits that they have in the whole picture: its arrays have them,
    and its file says where they lie. `plumb render --help` says what the words mean.

    `progress` is True for a line on standard error, or gets such lines. Ctrl-C ends the render
    within a second. Warns of what was chosen to fit the scene."""
    own = _scene(scene)
    said = words(spp=spp, time=time, error=error, samples=span(samples), crop=joined(crop, ","), seed=seed,
                 bounces=span(bounces), size=joined(size, "x"), method=method, sampler=sampler,
                 precision=precision, threads=threads, from_=joined(from_, ","), by=joined(by, ","), fault=fault)
    with shown(progress) as show:
        held, summary = _core.render(own._held, said, show)
    warn_of_notices()
    return Picture(held, own.name, summary=summary)


def radiosity(scene: Scene | PathLike, *, error: float | str | None = None,
              bounces: tuple[int, int | None] | str | None = None, size: tuple[int, int] | str | None = None,
              from_: Sequence[str] | str | None = None, by: Sequence[str] | str | None = None,
              elements: Literal["linear", "constant"] | None = None, threads: int | None = None,
              progress: Progress = False) -> Picture:
    """Computes a picture of matte polygons without noise, in closed form. Its provenance tells by how
    much it may be wrong, which compare() takes as its floor. `error` is how far two resolutions may
    differ, as 0.0001 or "0.01%"; from_ and by are render()'s; elements="constant" shows flat patches."""
    own = _scene(scene)
    said = words(error=error, bounces=span(bounces), size=joined(size, "x"), from_=joined(from_, ","),
                 by=joined(by, ","), elements=elements, threads=threads)
    with shown(progress) as show:
        held, summary = _core.radiosity(own._held, said, show)
    warn_of_notices()
    return Picture(held, own.name, summary=summary)
