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


def take(folder: pathlib.Path) -> list[dict[str, Any]]:
    """What was found, the failures first, out of a folder that is then removed."""
    found = [json.loads(one.read_text("utf-8")) for one in folder.glob("*.json")]
    shutil.rmtree(folder)
    return sorted(found, key=lambda one: (one["passed"], one["test"], one["number"]))


def keep_history(found: list[dict[str, Any]], file: pathlib.Path) -> int:
    """Adds a line of JSON for each check that has a bias to the file, and to each check what the file
    tells of it. Returns how many lines it added."""
    earlier = [json.loads(line) for line in file.read_text("utf-8").splitlines()] if file.exists() else []
    made = f"{datetime.datetime.now(datetime.timezone.utc):%Y-%m-%d %H:%M}"
    new = []
    for one in found:
        whole = next((row for verdict in one["scene"]["verdicts"] for row in verdict["rows"]
                      if (row["where"], row["channel"]) == ("image", "all")), None)
        check = f"{one['test']} {one['number']}"
        if whole is not None and whole["bias"] is not None:
            new.append({"made": made, "check": check, "verdict": one["scene"]["verdicts"][0]["verdict"],
                        "bias": whole["bias"], "confidence": whole["confidence"] or 0.0})
        runs = [run for run in earlier + new if run["check"] == check]
        if runs:
            one["scene"]["history"] = _history(runs)
    file.parent.mkdir(parents=True, exist_ok=True)
    with open(file, "a", encoding="utf-8") as stream:
        stream.writelines(json.dumps(run) + "\n" for run in new)
    return len(new)


def _history(runs: list[dict[str, Any]]) -> dict[str, Any]:
    """Biases with their 95 % confidence intervals, from the first run to this one."""
    width, height, edge = 640, 160, 20
    largest = max(abs(run["bias"]) + run["confidence"] for run in runs) or 1.0
    marks = [f'<path d="M{edge} {height / 2}H{width - edge}" stroke="#888"/>']
    for i, run in enumerate(runs):
        x = edge + (i + 0.5) * (width - 2 * edge) / len(runs)
        top, y, bottom = (height / 2 - (height / 2 - edge) * (run["bias"] + d * run["confidence"]) / largest
                          for d in (1, 0, -1))
        marks.append(f'<path d="M{x:.1f} {top:.1f}V{bottom:.1f}" stroke="#06c"/><circle cx="{x:.1f}" cy="{y:.1f}" r="3" fill="#06c"/>')
    return {"svg": f'<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 {width} {height}" width="{width}" '
                   f'height="{height}">{"".join(marks)}</svg>',
            "sentences": [f"Bias of the whole picture in {len(runs)} run{'' if len(runs) == 1 else 's'}, the last on the right; "
                          f"the plot ends at ±{100 * largest:.2g} %."],
            "table": {"head": ["run", "verdict", "bias"],
                      "rows": [[run["made"], run["verdict"], sections.percent(run["bias"], run["confidence"])] for run in runs]},
            "command": ""}


def write(found: list[dict[str, Any]], file: pathlib.Path) -> None:
    """Writes the page of what take() took."""
    scenes = [{"name": f"check-{i}", **one["scene"]} for i, one in enumerate(found)]
    failed = [one for one in found if not one["passed"]]
    made = datetime.datetime.now(datetime.timezone.utc)
    file.parent.mkdir(parents=True, exist_ok=True)
    page.write_page({
        "title": f"Pictures: {len(found)} compared, {len(failed)} not as expected", "version": __version__,
        "made": f"{made:%Y-%m-%d %H:%M} UTC", "host": platform.node(), "incomplete": "", "notes": [],
        "summary": [f"{one['scene']['title']}: {one['said']}" for one in failed],
        "scenes": scenes}, file)
