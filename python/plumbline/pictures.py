# SPDX-License-Identifier: Apache-2.0

"""Pictures: from files, renders and arrays."""

from __future__ import annotations

import base64
import json
import os
import pathlib
import tempfile
from collections.abc import Sequence
from typing import Any, Union

import numpy as np
import numpy.typing as npt

from . import _core
from .errors import ArgumentError

Floats = npt.NDArray[np.float32]
PathLike = Union[str, "os.PathLike[str]"]
# A picture, the file of one, or height x width (x channels) numbers.
PictureLike = Union["Picture", PathLike, npt.ArrayLike]

_CHANNELS = {1: ["Y"], 2: ["Y", "A"], 3: ["R", "G", "B"], 4: ["R", "G", "B", "A"]}


class Picture:
    """Linear radiance with the primaries of Rec. 709, rows from the top, and what is known of its
    noise and of how it was made.

    Its arrays are views of the picture's own memory: nothing is copied, and nothing can be written.
    np.asarray(picture) is its radiance."""

    def __init__(self, held: _core.Picture, name: str, file: str | None = None, summary: str = "") -> None:
        self._held = held
        self.name = name
        self.file = file
        """Where it was read, if it was."""
        self.summary = summary
        """What its render took and gave, a line."""

    @property
    def width(self) -> int:
        return self._held.width

    @property
    def height(self) -> int:
        return self._held.height

    @property
    def channels(self) -> list[str]:
        """The names of all channels, in the order in which `values` has them."""
        return self._held.channels

    @property
    def values(self) -> Floats:
        """All channels, height x width x channels."""
        return self._held.values

    @property
    def radiance(self) -> Floats:
        """R, G and B, height x width x 3; of a picture without colours its first channel, three
        times."""
        return self._rgb(self.values, "")

    @property
    def variance(self) -> Floats | None:
        """The variance of each value of `radiance` as the mean that it is; None if it is not known."""
        of_several = self._held.variances
        if of_several is not None:
            return self._rgb(of_several, "")
        known = [name for name in self.channels if name.startswith("variance.")]
        return self._rgb(self.values, "variance.") if known else None

    def channel(self, name: str) -> Floats:
        """One channel, height x width."""
        return self.values[:, :, self._place(name)]

    @property
    def provenance(self) -> dict[str, Any]:
        """What the picture says of itself, such as "seed" and "wallSeconds", by the names that its
        file has."""
        prefix = "plumbline:"
        told: dict[str, Any] = {name[len(prefix):]: value for name, value in self._held.provenance}
        if "runs" in told:
            told["runs"] = json.loads(told["runs"])
        return told

    @property
    def samples_per_pixel(self) -> float:
        """0 if the picture doesn't tell."""
        return self._held.samples_per_pixel

    @property
    def notes(self) -> list[str]:
        """What was converted or assumed when it was read, a sentence each."""
        return self._held.notes

    def write(self, file: PathLike, exposure: float = 0.0) -> None:
        """Writes a linear .exr with all that is known, or an sRGB .png, brightened by so many stops."""
        self._held.write(os.fspath(file), exposure)

    def png(self, exposure: float = 0.0) -> bytes:
        """The picture as it is displayed, as the bytes of a PNG."""
        with tempfile.TemporaryDirectory() as folder:
            file = pathlib.Path(folder) / "picture.png"
            self.write(file, exposure)
            return file.read_bytes()

    def __array__(self, dtype: Any = None, copy: bool | None = None) -> npt.NDArray[Any]:
        return np.array(self.radiance, dtype=dtype) if copy else np.asarray(self.radiance, dtype=dtype)

    def __repr__(self) -> str:
        noise = "noise known" if self.variance is not None else "noise not known"
        samples = f", {self.samples_per_pixel:g} spp" if self.samples_per_pixel else ""
        return f"<plumbline.Picture {self.name}: {self.width}x{self.height} {' '.join(self.channels[:3])}{samples}, {noise}>"

    def _repr_png_(self) -> bytes:
        return self.png()

    def _place(self, name: str) -> int:
        if name not in self.channels:
            raise ArgumentError(f"{self.name} has no channel {name}, but {' '.join(self.channels)}")
        return self.channels.index(name)

    def _rgb(self, values: Floats, prefix: str) -> Floats:
        names = self.channels
        if prefix + "R" not in names:
            first = names.index(prefix + names[0])
            return np.broadcast_to(values[:, :, first:first + 1], (self.height, self.width, 3))
        red = names.index(prefix + "R")
        return values[:, :, red:red + 3]


def read(file: PathLike, *, replicates: Sequence[PathLike] = (), part: str = "", codes: bool = False) -> Picture:
    """Reads a picture in any format that OpenImageIO knows.

    Of replicates, which are renders of the same scene with other seeds and equally many samples, it
    is the mean, and their scatter is its noise. `part` is the name or number of a part (subimage);
    with `codes` integers are taken as they are stored, from 0 to 1, and no transfer function is
    undone."""
    files = [os.fspath(one) for one in (file, *replicates)]
    return Picture(_core.read(files, part, codes), files[0], files[0])


def _floats(values: npt.ArrayLike, what: str) -> Floats:
    array = np.asarray(values)
    if array.dtype.kind != "f":
        raise ArgumentError(f"{what}: linear radiance is wanted, as floats, not {array.dtype}: divide codes by the "
                            "largest one and undo their transfer function, or let plumbline.read() do it")
    if array.ndim == 2:
        array = array[:, :, np.newaxis]
    if array.ndim != 3 or 0 in array.shape:
        raise ArgumentError(f"{what}: height x width or height x width x channels values are wanted, not {array.shape}")
    return np.ascontiguousarray(array, dtype=np.float32)


def picture(values: PictureLike, *, variance: npt.ArrayLike | None = None, replicates: Sequence[PictureLike] = (),
            channels: Sequence[str] | None = None, samples: int = 0, name: str = "picture") -> Picture:
    """Makes a picture of anything that is like one.

    Arrays have height x width or height x width x channels values: luminance, RGB, or either with
    alpha, unless `channels` names them. `variance`, of the same shape, is that of each value as the
    mean that it is (not that of single samples). Replicates are as in read(). `samples` is how many
    there are per pixel, of one replicate."""
    if isinstance(values, Picture) and not replicates:
        if variance is None:
            return values
        values = values.radiance
    if isinstance(values, (str, os.PathLike)):
        if variance is not None:
            raise ArgumentError("variance: a file says itself how noisy it is")
        if all(isinstance(one, (str, os.PathLike)) for one in replicates):
            return read(values, replicates=[os.fspath(one) for one in replicates])  # type: ignore[arg-type]
        values = read(values)
    if replicates:
        if variance is not None:
            raise ArgumentError("variance: the replicates' scatter tells the noise")
        all_of_them = [picture(one, channels=channels, samples=samples, name=name) for one in (values, *replicates)]
        return Picture(_core.mean([one._held for one in all_of_them]), name)
    if isinstance(values, Picture):
        return values
    floats = _floats(values, name)
    count = floats.shape[2]
    names = list(channels) if channels is not None else _CHANNELS.get(count)
    if names is None or len(names) != count:
        raise ArgumentError(f"{name} of shape {floats.shape} has {count} channels: plumbline.picture(..., channels=) names them")
    noise = None
    if variance is not None:
        noise = np.ascontiguousarray(np.broadcast_to(_floats(variance, "variance"), floats.shape))
    return Picture(_core.from_arrays(floats, names, noise, samples), name)


def data_uri(png: bytes) -> str:
    return "data:image/png;base64," + base64.b64encode(png).decode("ascii")
