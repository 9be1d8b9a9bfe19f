# SPDX-License-Identifier: Apache-2.0

"""Whether two pictures are the same but for noise, and if not, where and by how much."""

from __future__ import annotations

import html
import json
import os
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, fields
from typing import Any, Literal, TypeVar, Union

import numpy as np
import numpy.typing as npt

from . import _core
from ._words import joined, words
from .errors import ArgumentError
from .pictures import Floats, PathLike, Picture, PictureLike, data_uri, picture
from .scenes import Mask

MapKind = Literal["difference", "z", "blocks", "flip"]
# A mask; the file of one; a number for each pixel, 0 being none; true for pixels that are compared;
# or such arrays by their regions' names.
Regions = Union[Mask, PathLike, npt.ArrayLike, Mapping[str, npt.ArrayLike]]


def _number(value: Any) -> Any:
    """JSON has no infinity and no NaN."""
    return float("nan") if value is None else float(value) if value in ("Infinity", "-Infinity") else value


@dataclass(frozen=True)
class Estimate:
    """The difference of two averages, in radiance, and how surely it is known."""
    test: float
    reference: float
    bias: float
    """test - reference."""
    relative_bias: float
    """The same as a part of the reference."""
    standard_error: float
    confidence: float
    """Half the width of the bias' 95 % confidence interval."""
    relative_confidence: float
    margin: float
    """The same for all tests of the comparison at once."""
    visible: float
    """A bias of this size would have been found with a probability of 95 %."""
    verdict: str

    def __str__(self) -> str:
        return f"{100 * self.relative_bias:+.3f} % ± {100 * self.relative_confidence:.3f} ({self.verdict})"


@dataclass(frozen=True)
class Errors:
    """Measures of the error in one channel; docs/compare.md has their formulas."""
    mae: float
    rmse: float
    rel_mse: float
    smape: float
    psnr: float
    mse: float
    bias_squared: float
    test_noise: float
    reference_noise: float


_NAMES = {"bias": "difference", "relative_bias": "relativeDifference", "standard_error": "standardError",
          "confidence": "confidence95", "relative_confidence": "relativeConfidence95", "rel_mse": "relMse",
          "bias_squared": "biasSquared", "test_noise": "testNoise", "reference_noise": "referenceNoise"}

Of = TypeVar("Of", Estimate, Errors)


def _from_json(kind: type[Of], entry: dict[str, Any]) -> Of:
    return kind(**{field.name: _number(entry[_NAMES.get(field.name, field.name)]) for field in fields(kind)})


class Channels(Mapping[str, Of]):
    """What was found, by channel: found["R"] or found.R; "all" is the mean of the colours."""

    def __init__(self, of: dict[str, Of]) -> None:
        self._of: dict[str, Of] = of

    def __getitem__(self, channel: str) -> Of:
        return self._of[channel]

    def __getattr__(self, channel: str) -> Of:
        if channel.startswith("_") or channel not in self._of:
            raise AttributeError(f"no channel {channel}, but {' '.join(self.__dict__.get('_of', ()))}")
        return self._of[channel]

    def __iter__(self) -> Iterator[str]:
        return iter(self._of)

    def __len__(self) -> int:
        return len(self._of)

    def __dir__(self) -> list[str]:
        return [*super().__dir__(), *self._of]

    def __repr__(self) -> str:
        return "\n".join(f"{channel}: {found}" for channel, found in self._of.items())


class Verdict:
    """What a comparison found. It is true if the pictures are the same, and printed it is the report
    of `plumb compare`."""

    def __init__(self, held: _core.Judgment) -> None:
        self._held = held
        self.verdict: str = held.verdict
        """"same", "different" or "inconclusive"."""
        self.explanation: str = held.explanation
        """The verdict with its reason, what would have been found, and what was assumed, a line each."""
        self.numbers: dict[str, Any] = json.loads(held.json)
        """All numbers, as `plumb compare --json` has them."""
        channels = self.numbers["channels"]
        self.image: Channels[Estimate] = Channels({one["channel"]: _from_json(Estimate, one) for one in channels})
        """The averages of the whole picture."""
        self.errors: Channels[Errors] = Channels({one["channel"]: _from_json(Errors, one) for one in channels})
        by_region: dict[str, dict[str, Estimate]] = {}
        for one in self.numbers.get("regions", []):
            by_region.setdefault(one["region"], {})[one["channel"]] = _from_json(Estimate, one)
        self.regions: dict[str, Channels[Estimate]] = {name: Channels(of) for name, of in by_region.items()}
        """The averages of each region."""
        self.samples_factor: float = _number(self.numbers["samplesFactor"])
        """If it is inconclusive, so many times the samples would tell; infinite if none would."""

    @property
    def same(self) -> bool:
        return self.verdict == "same"

    @property
    def different(self) -> bool:
        return self.verdict == "different"

    @property
    def inconclusive(self) -> bool:
        return self.verdict == "inconclusive"

    def __bool__(self) -> bool:
        return self.same

    @property
    def test(self) -> Picture:
        """What was compared, black where nothing was."""
        return Picture(self._held.test, "test")

    @property
    def reference(self) -> Picture:
        """Likewise."""
        return Picture(self._held.reference, "reference")

    def map(self, kind: MapKind = "difference") -> Picture:
        """Where they differ: blue where the reference has more, red where it has less. As radiance
        ("difference"), in standard deviations of a pixel ("z") or of means over 8 x 8 pixels
        ("blocks"); or FLIP, if that was asked for."""
        return Picture(self._held.map(kind), f"{kind} map")

    def __str__(self) -> str:
        return self._held.report

    def __repr__(self) -> str:
        return f"<plumbline.Verdict {self.explanation.splitlines()[0]}>"

    def _repr_html_(self) -> str:
        kinds: list[MapKind] = ["difference", "blocks"]
        shown = [("test", self.test), ("reference", self.reference)] if _has_colours(self.test) else []
        shown += [(kind, self.map(kind)) for kind in kinds]
        figures = "".join(
            f'<figure style="display:inline-block;margin:0 .5em .5em 0"><img src="{data_uri(one.png())}" '
            f'style="width:14em"><figcaption>{name}</figcaption></figure>' for name, one in shown)
        rows = [("image", self.image), *self.regions.items()]
        cells = "".join(f"<tr><td>{html.escape(name)}</td><td>{html.escape(channel)}</td><td>{one.test:.4g}</td>"
                        f"<td>{one.reference:.4g}</td><td>{html.escape(str(one))}</td></tr>"
                        for name, channels in rows for channel, one in channels.items())
        head = "".join(f"<th>{name}</th>" for name in ("where", "channel", "test", "reference", "bias ± 95 %"))
        return (f'<p style="white-space:pre-line">{html.escape(self.explanation.strip())}</p>{figures}'
                f"<details><summary>Regions and channels</summary><table><tr>{head}</tr>{cells}</table></details>")


def _has_colours(shown: Picture) -> bool:
    return len(shown.channels) >= 3


def _regions(regions: Regions | None) -> tuple[_core.Regions | None, str | None]:
    """What the core takes: a mask, or the file of one."""
    if regions is None:
        return None, None
    if isinstance(regions, (str, os.PathLike)):
        return None, os.fspath(regions)
    if isinstance(regions, Mask):
        return _core.regions(regions.names, regions.labels, False, regions._place), None
    if isinstance(regions, Mapping):
        names = list(regions)
        held = [np.asarray(regions[name], dtype=bool) for name in names]
        if not held:
            raise ArgumentError("regions: there is none")
        labels = np.full(held[0].shape, -1, np.int32)
        for i, pixels in enumerate(held):
            labels[pixels] = i
        return _core.regions(names, labels, False), None
    numbers = np.asarray(regions)
    if numbers.ndim != 2 or numbers.dtype.kind not in "iub":
        raise ArgumentError("regions: a whole number or a truth value for each pixel is wanted, not "
                            f"{numbers.dtype} {numbers.shape}")
    values, inverse = np.unique(numbers, return_inverse=True)
    kept = [value for value in values.tolist() if value]
    place = np.array([kept.index(value) if value else -1 for value in values.tolist()], np.int32)
    names = ["compared"] if numbers.dtype.kind == "b" else [str(value) for value in kept]
    return _core.regions(names, np.ascontiguousarray(place[inverse].reshape(numbers.shape)), True), None


def compare(test: PictureLike, reference: PictureLike, *, tolerance: float | str | None = None,
            floor: float | str | None = None, variance: npt.ArrayLike | None = None,
            reference_variance: npt.ArrayLike | None = None, replicates: Sequence[PictureLike] = (),
            reference_replicates: Sequence[PictureLike] = (), regions: Regions | None = None,
            crop: tuple[int, int, int, int] | str | None = None, channels: Sequence[str] | str | None = None,
            layer: str | None = None, max_outliers: int | str | None = None,
            hard_limit: float | str | None = None, false_alarms: float | None = None, negative: bool = False,
            other_scene: bool = False, flip: Literal["ldr", "hdr"] | None = None, flip_mean: float | None = None,
            flip_p95: float | None = None, pixels_per_degree: float | None = None) -> Verdict:
    """Tells whether two pictures differ by more than noise.

    A picture is a Picture, the name of a file, or an array (see picture()). What the arguments mean
    stands in `plumb compare --help` under the same words:

    tolerance       the difference that doesn't matter: "0.5%" of the reference's own pixel, block,
                    region or image, or 0.002 in radiance (default: 1%)
    floor           how wrong the pictures may be beside their known noise, likewise; it stands in
                    for noise that is not known
    variance, reference_variance
                    of each value as the mean that it is
    replicates, reference_replicates
                    renders with other seeds: their mean is judged, and their scatter is its noise
    regions         a mask, the file of one, {"name": array of truth values, ...}, or an array with
                    a number for each pixel, those with 0 not being compared
    max_outliers, hard_limit
                    how many pixels may differ, "0.1%" or 12, and by how much these may
    false_alarms    the chance that noise alone makes the verdict "different" (default: 0.001)

    Raises PictureError for pictures that can't be compared, and ArgumentError."""
    a = picture(test, variance=variance, replicates=replicates, name="test")
    b = picture(reference, variance=reference_variance, replicates=reference_replicates, name="reference")
    held, mask = _regions(regions)
    return Verdict(_core.compare(
        a._held, b._held, words(
            tolerance=tolerance, floor=floor, crop=joined(crop, ","), channels=joined(channels, ","), layer=layer,
            max_outliers=max_outliers, hard_limit=hard_limit, false_alarms=false_alarms, negative=negative,
            other_scene=other_scene, flip=flip, flip_mean=flip_mean, flip_p95=flip_p95,
            pixels_per_degree=pixels_per_degree),
        held, mask, a.name, b.name, b.file is not None))


__all__ = ["Channels", "Errors", "Estimate", "Floats", "Verdict", "compare"]
