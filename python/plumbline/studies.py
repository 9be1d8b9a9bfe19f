# SPDX-License-Identifier: Apache-2.0

"""What several pictures tell: how error falls with samples, and what is wrong with a picture."""

from __future__ import annotations

import json
import os
import pathlib
import tempfile
from collections.abc import Sequence
from typing import Any

import numpy.typing as npt

from . import _core
from ._words import Progress, joined, shown, span, warn_of_notices, words
from .pictures import PathLike, PictureLike, picture
from .scenes import Scene, _scene


class Diagnosis:
    """What is wrong with a picture; printed it is what `plumb diagnose` says."""

    def __init__(self, held: _core.Diagnosis) -> None:
        self._held = held

    @property
    def verdict(self) -> str:
        """"same" as the right picture, "different" or "inconclusive"."""
        return self._held.verdict

    @property
    def suspects(self) -> list[_core.Suspect]:
        """What may have been done to it, the likeliest first: the name, the part of the squared
        difference that this explains, whether a difference is left (`is_refuted`, `rest`), and if
        not, within which part of what is judged the two agree (`within`)."""
        return self._held.suspects

    @property
    def tried(self) -> int:
        """How many suspects there were."""
        return self._held.tried

    def __str__(self) -> str:
        return str(self._held)

    def __repr__(self) -> str:
        return f"<plumbline.Diagnosis {self.verdict}: {', '.join(one.name for one in self.suspects[:3])}>"


def diagnose(test: PictureLike, scene: Scene | PathLike, *, tolerance: float | str = "1%",
             variance: npt.ArrayLike | None = None, replicates: Sequence[PictureLike] = (),
             progress: Progress = False) -> Diagnosis:
    """Looks for what a picture of the scene may have gone through that it differs from the right one:
    classic bugs of renderers and differences of set-up, alone and in pairs. Takes seconds to minutes.

    `tolerance` is the relative difference that doesn't matter, as 0.01 or "1%"."""
    held = picture(test, variance=variance, replicates=replicates, name="test")._held
    with shown(progress) as show:
        found = _core.diagnose(held, _scene(scene)._held, str(tolerance), show)
    warn_of_notices()
    return Diagnosis(found)


class Convergence:
    """How error falls; printed it is what `plumb converge` says."""

    def __init__(self, held: _core.Exhibit) -> None:
        self._held = held
        self.numbers: dict[str, Any] = json.loads(held.json)
        """Every point and the fits, as `plumb converge --json` has them."""

    @property
    def sentences(self) -> list[str]:
        """A line for each series: its law, and where it stops."""
        return list(self.numbers["sentences"])

    def plot(self, file: PathLike) -> None:
        """Draws error against samples, as .svg or .png; by gnuplot."""
        self._held.write_plot(os.fspath(file))

    def __str__(self) -> str:
        return str(self._held)

    def _repr_svg_(self) -> str:
        with tempfile.TemporaryDirectory() as folder:
            file = pathlib.Path(folder) / "plot.svg"
            self.plot(file)
            return file.read_text("utf-8")


def _files(pictures: Sequence[PictureLike], folder: str) -> list[str]:
    """The files of pictures, written where there are none yet."""
    found = []
    for i, one in enumerate(pictures):
        if isinstance(one, (str, os.PathLike)):
            found.append(os.fspath(one))
            continue
        made = picture(one)
        if made.file is None:
            made.write(f"{folder}/{i}.exr")
        found.append(made.file or f"{folder}/{i}.exr")
    return found


def converge(what: Scene | PathLike | Sequence[PictureLike], *, reference: PictureLike,
             methods: Sequence[str] | str | None = None, samplers: Sequence[str] | str | None = None,
             spp: tuple[int, int] | str | None = None, runs: int | None = None,
             renderers: Sequence[str] | str | None = None, bounces: tuple[int, int | None] | str | None = None,
             size: tuple[int, int] | str | None = None, threads: int | None = None, keep: PathLike | None = None,
             other_scene: bool = False, progress: Progress = False) -> Convergence:
    """Fits relMSE(N) = a N^-p + c to each series of pictures.

    `what` is a scene, which is rendered with spp[0], 2 spp[0], ... up to spp[1] samples per pixel,
    `runs` times each with other seeds, by each of the methods and samplers, and by other programs
    (`renderers`, which is `--with`); or pictures, which say themselves what made them, or are called
    "FILE=SERIES,SPP,SECONDS". `reference` is a converged picture. `keep` is a folder that keeps the
    renders. `plumb converge --help` says what the words mean."""
    with tempfile.TemporaryDirectory() as folder, shown(progress) as show:
        judged_by = _files([reference], folder)[0]
        if isinstance(what, (Scene, str, os.PathLike)):
            pictures = [what.file if isinstance(what, Scene) else os.fspath(what)]
        else:
            os.mkdir(f"{folder}/tests")
            pictures = _files(what, f"{folder}/tests")
        said = words(methods=joined(methods, ","), samplers=joined(samplers, ","), spp=span(spp), runs=runs,
                     bounces=span(bounces), size=joined(size, "x"), threads=threads,
                     keep=None if keep is None else os.fspath(keep), other_scene=other_scene, reference=judged_by)
        if renderers is not None:
            said += ["--with", str(joined(renderers, ","))]
        held = _core.converge([*pictures, *said], show)
    warn_of_notices()
    return Convergence(held)


__all__ = ["Convergence", "Diagnosis", "converge", "diagnose"]
