# SPDX-License-Identifier: Apache-2.0

"""The page of `pytest --pictures-report`: the project's viewer, with a tab for each check."""

from __future__ import annotations

import datetime
import json
import pathlib
import platform
import shutil
from typing import Any, Optional

import numpy as np

from . import __version__
from .pictures import Floats, Picture
from .report import page, sections
from .verdicts import Estimate, Verdict


def _planes(values: Floats) -> list[list[float]]:
    return [np.nan_to_num(values[:, :, c], nan=0.0).ravel().tolist() for c in range(3)]


def _picture(shown: Picture, title: str) -> dict[str, Any]:
    planes = _planes(shown.radiance)
    variance = shown.variance
    return {"title": title, "width": shown.width, "height": shown.height, "values": page.encode_picture(planes),
            "errors": None if variance is None else page.encode_picture(_planes(np.sqrt(variance)), 3),
            "thumbnail": sections.thumbnail(planes, shown.width), "seconds": shown.provenance.get("wallSeconds"),
            "command": "", "card": shown.provenance}


def _row(where: str, channel: str, found: Estimate) -> dict[str, Any]:
    return {"where": where, "channel": channel, "test": found.test, "reference": found.reference,
            "bias": found.relative_bias, "confidence": found.relative_confidence or None, "verdict": found.verdict}


def _verdict(verdict: Verdict) -> dict[str, Any]:
    rows = [_row(where, channel, found) for where, channels in [("image", verdict.image), *verdict.regions.items()]
            for channel, found in channels.items()]
    return {"test": "test", "reference": "reference", "verdict": verdict.verdict,
            "explanation": verdict.explanation, "command": "", "rows": rows}


def finding(verdict: Optional[Verdict], name: str, expect: str, test: str, number: int,
            trouble: Optional[BaseException] = None) -> dict[str, Any]:
    """What the page has of a check: its verdict, or what it had found when trouble ended it."""
    notes = [test] if expect == "same" else [test, f"It should be {expect}."]
    said = "" if verdict is None else verdict.explanation.splitlines()[0]
    if trouble is not None:
        said = f"{type(trouble).__name__}: {trouble}".rstrip(": ")
        notes.append(f"Ended by {said}" + ("" if verdict is None else ". Until then:"))
    return {"test": test, "number": number, "said": said,
            "passed": trouble is None and verdict is not None and verdict.verdict == expect, "scene": {
                "title": f"{test.rpartition('::')[2]}: {name}", "notes": notes,
                "verdicts": [] if verdict is None else [_verdict(verdict)], "convergence": None, "chart": None,
                "pictures": [] if verdict is None else [_picture(verdict.test, "test"), _picture(verdict.reference, "reference")]}}


def write(folder: pathlib.Path, file: pathlib.Path) -> int:
    """Joins what was found, the failures first, and returns how many checks there were."""
    found = [json.loads(one.read_text("utf-8")) for one in folder.glob("*.json")]
    shutil.rmtree(folder)
    found.sort(key=lambda one: (one["passed"], one["test"], one["number"]))
    scenes = [{"name": f"check-{i}", **one["scene"]} for i, one in enumerate(found)]
    failed = [one for one in found if not one["passed"]]
    made = datetime.datetime.now(datetime.timezone.utc)
    if scenes:
        file.parent.mkdir(parents=True, exist_ok=True)
        page.write_page({
            "title": f"Pictures: {len(found)} compared, {len(failed)} not as expected", "version": __version__,
            "made": f"{made:%Y-%m-%d %H:%M} UTC", "host": platform.node(), "incomplete": "", "notes": [],
            "summary": [f"{one['scene']['title']}: {one['said']}" for one in failed],
            "scenes": scenes}, file)
    return len(found)
