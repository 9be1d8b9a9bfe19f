# SPDX-License-Identifier: Apache-2.0

"""The pytest plugin `pytest-plumbline`: a fixture for the life of a reference picture.

    def test_cornell(pictures):
        pictures.check(my_render(spp=64), "cornell", tolerance="0.5%", regions="objects.png")

The reference is references/cornell.exr beside the test's file; `pytest --pictures-update` makes it."""

from __future__ import annotations

import json
import os
import pathlib
import tempfile
from collections.abc import Callable, Iterator
from typing import TYPE_CHECKING, Any, Literal, Optional, Union

import pytest

if TYPE_CHECKING:
    from .pictures import Picture, PictureLike
    from .verdicts import Verdict

    Render = Callable[[int, int], PictureLike]

# What makes replicates: so many renders a look.
SEEDS = 4
FIRST_SEED = 1
FIRST_SEED_OF_REFERENCES = 1_000_001

_FINDINGS = pytest.StashKey[pathlib.Path]()


def pytest_addoption(parser: pytest.Parser) -> None:
    group = parser.getgroup("pictures", "pictures (plumbline)")
    group.addoption("--pictures-update", action="store_true",
                    help="Write the references of all checks that don't end as the same, companions aside")
    group.addoption("--pictures-report", metavar="FILE", type=pathlib.Path,
                    help="Write a page that shows what was compared, one .html file")
    group.addoption("--pictures-history", metavar="FILE", type=pathlib.Path,
                    help="Add the biases of this run to a file, of which the page shows all runs")


def pytest_configure(config: pytest.Config) -> None:
    if config.getoption("--pictures-report") is None and config.getoption("--pictures-history") is None:
        return
    told = getattr(config, "workerinput", None)  # of pytest-xdist, by what made this process
    folder = told["pictures"] if told else tempfile.mkdtemp(prefix="plumbline-pictures-")
    config.stash[_FINDINGS] = pathlib.Path(folder)


@pytest.hookimpl(optionalhook=True)
def pytest_configure_node(node: Any) -> None:
    """Tells a worker of pytest-xdist where all of them leave what they find."""
    if _FINDINGS in node.config.stash:
        node.workerinput["pictures"] = str(node.config.stash[_FINDINGS])


@pytest.hookimpl(trylast=True)
def pytest_terminal_summary(terminalreporter: Any, config: pytest.Config) -> None:
    if _FINDINGS not in config.stash or hasattr(config, "workerinput"):
        return
    from .pytest_page import keep_history, take, write
    page, history = config.getoption("--pictures-report"), config.getoption("--pictures-history")
    found = take(config.stash[_FINDINGS])
    if not found:
        terminalreporter.write_line("pictures: nothing was compared")
        return
    if history is not None:
        added = keep_history(found, history)
        terminalreporter.write_line(f"pictures: {history} has the biases of {_checks(added)} more")
    if page is not None:
        write(found, page)
        terminalreporter.write_line(f"pictures: {page} shows {_checks(len(found))}")


def _checks(count: int) -> str:
    return f"{count} check{'' if count == 1 else 's'}"


@pytest.fixture
def pictures(request: pytest.FixtureRequest) -> Iterator[Pictures]:
    """Holds pictures against references: pictures.check(picture, "name", tolerance="0.5%")."""
    yield Pictures(request.path.parent, request.node.nodeid, request.config)


class Pictures:
    """What the fixture `pictures` is, for one test."""

    def __init__(self, folder: pathlib.Path, test: str, config: pytest.Config) -> None:
        self.references = folder / "references"
        self.test = test
        self._updates: bool = config.getoption("--pictures-update")
        self._findings = config.stash.get(_FINDINGS, None)
        self._count = 0
        self._seen: Optional[Verdict] = None  # what a check that has not ended has found so far

    def check(self, test: Union[PictureLike, Render], reference: Union[str, pathlib.Path], *,
              expect: Literal["same", "different"] = "same", spp: int = 16, budget: int = 1024,
              **terms: Any) -> Verdict:
        """Holds a picture against a reference, and fails unless the verdict is the expected one.

        `reference` is a name, which stands for an .exr in the folder references/ beside the test's
        file, or a file; so is the keyword `regions` if it is a text. The other keywords are those
        of plumbline.compare() and mean the same.

        expect="different" is for a companion that must fail: with the lamp 3 % brighter, say.

        `test` may be a function render(spp, seed) that returns a picture: then it is called with
        growing numbers of samples per pixel, from `spp` on, four seeds each, until the verdict is
        sure or `budget` samples per pixel are spent. The looks share the chance of a false alarm, a
        half for the first one, a quarter for the next."""
        __tracebackhide__ = True
        self._seen = None
        try:
            verdict, drawn = self._judge(test, reference, expect, spp, budget, terms)
        except BaseException as trouble:
            self._note(self._seen, reference, expect, trouble)
            raise
        self._note(verdict, reference, expect)
        if verdict.verdict != expect:
            raise AssertionError(_message(verdict, reference, expect, callable(test), drawn))
        return verdict

    def _judge(self, test: Union[PictureLike, Render], reference: Union[str, pathlib.Path], expect: str, spp: int,
               budget: int, terms: dict[str, Any]) -> tuple[Verdict, int]:
        """The verdict, and the samples per pixel that were drawn."""
        __tracebackhide__ = True
        from . import PictureError
        file = self._place(reference, ".exr")
        if isinstance(terms.get("regions"), str):
            terms["regions"] = self._place(terms["regions"], "")
        verdict, may_update = None, self._updates and expect == "same"
        if file.exists():
            try:
                drawn, verdict = self._look(test, file, spp, budget, terms)
            except PictureError:  # the reference has another size, for instance
                if not may_update:
                    raise
        if may_update and (verdict is None or not verdict.same):
            self._update(test, file, budget, terms)
            drawn, verdict = self._look(test, file, spp, budget, terms)
        if verdict is None:
            raise AssertionError(f"{os.path.relpath(file)} is missing: 'pytest --pictures-update' makes it of what the test draws")
        return verdict, drawn

    def _place(self, name: Union[str, pathlib.Path], extension: str) -> pathlib.Path:
        path = pathlib.Path(name)
        if path.suffix == "" and extension:
            path = path.with_name(path.name + extension)
        return self.references / path  # which is the path alone where that is absolute

    def _look(self, test: Union[PictureLike, Render], file: pathlib.Path, spp: int, budget: int,
              terms: dict[str, Any]) -> tuple[int, Verdict]:
        """The samples per pixel that were drawn, and the verdict."""
        from . import compare
        if not callable(test):
            return 0, compare(test, file, **terms)
        terms = dict(terms)
        false_alarms = terms.pop("false_alarms", 1e-3)
        drawn, seed, samples = 0, FIRST_SEED, min(spp, max(1, budget // SEEDS))
        while True:
            false_alarms /= 2
            mean = _mean(test, samples, seed)
            drawn, seed = drawn + SEEDS * samples, seed + SEEDS
            verdict = self._seen = compare(mean, file, false_alarms=false_alarms, **terms)
            left = (budget - drawn) // SEEDS
            if not verdict.inconclusive or verdict.samples_factor == float("inf") or left < samples:
                return drawn, verdict
            # A fifth more than are told to be needed: that is an estimate, and the next look is stricter.
            samples = min(left, max(2 * samples, round(1.2 * verdict.samples_factor * samples)))

    def _update(self, test: Union[PictureLike, Render], file: pathlib.Path, budget: int,
                terms: dict[str, Any]) -> None:
        from . import compare, picture
        if callable(test):
            made = _mean(test, max(1, budget // SEEDS), FIRST_SEED_OF_REFERENCES)
        else:
            made = picture(test, variance=terms.get("variance"), replicates=terms.get("replicates", ()))
        # Raises what any picture would be refused for that is held against it, such as a value that is NaN.
        compare(made, made, **{word: terms[word] for word in ("channels", "crop", "negative") if word in terms})
        file.parent.mkdir(parents=True, exist_ok=True)
        made.write(file)
        _write_card(file, self.test, made)

    def _note(self, verdict: Optional[Verdict], reference: Union[str, pathlib.Path], expect: str,
              trouble: Optional[BaseException] = None) -> None:
        """Leaves what was found, and what ended the check before it was sure, for the page, in a file of its own."""
        if self._findings is None:
            return
        from .pytest_page import finding
        self._count += 1
        handle = tempfile.NamedTemporaryFile("w", dir=self._findings, suffix=".json", delete=False, encoding="utf-8")
        with handle:
            json.dump(finding(verdict, str(reference), expect, self.test, self._count, trouble), handle)


def _mean(render: Render, samples: int, first_seed: int) -> Picture:
    from . import picture
    takes = [picture(render(samples, seed), samples=samples) for seed in range(first_seed, first_seed + SEEDS)]
    return picture(takes[0], replicates=takes[1:], name="test")


def _message(verdict: Verdict, reference: Union[str, pathlib.Path], expect: str, takes_more: bool, drawn: int) -> str:
    lines = [f"{reference}: {verdict.explanation.rstrip()}"]
    if expect != "same":
        lines.append(f"It should have been {expect}.")
    if takes_more:
        lines.append(f"{drawn} samples per pixel were drawn; budget= lets it take more.")
    elif verdict.inconclusive:
        lines.append("A function render(spp, seed) instead of a picture lets check() take the samples that it needs.")
    elif "test: noise not known" in verdict.explanation:
        lines.append("variance=, replicates= or a function render(spp, seed) instead of the picture tells its noise.")
    return "\n".join(lines)


def _write_card(file: pathlib.Path, test: str, made: Picture) -> None:
    """Notes in the folder's card.json how a reference was made. Other processes may do so, too."""
    import datetime
    import fcntl
    card = file.with_name("card.json")
    with open(card, "a+", encoding="utf-8") as stream:
        fcntl.flock(stream, fcntl.LOCK_EX)
        stream.seek(0)
        held = json.loads(stream.read() or '{"pictures": []}')
        before: dict[str, Any] = next((one for one in held["pictures"] if one["file"] == file.name), {})
        entry = {"file": file.name, "test": test, "made": f"{datetime.date.today()}", **made.provenance}
        if "floor" in before:
            entry["floor"] = before["floor"]
        held["pictures"] = sorted([*(one for one in held["pictures"] if one is not before), entry],
                                  key=lambda one: str(one["file"]))
        stream.seek(0)
        stream.truncate()
        json.dump(held, stream, indent=1)
        stream.write("\n")
