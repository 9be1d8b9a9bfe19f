# SPDX-License-Identifier: Apache-2.0

"""Renders the reference scenes with every installed program, and with those that files describe
(docs/renderers.md), and writes out/report.html.

    python3 report/make_report.py PLUMB [FILE.toml...]    (which is 'make report WITH=FILE.toml')

The page is written as soon as our pictures are there, and anew after each program's; until then,
and where a program is not installed, its stored picture stands in. Pictures are kept in out/report/
and not rendered again unless their scene or settings change. Exit codes: 0 done, 2 trouble,
130 interrupted.
"""

import datetime
import json
import pathlib
import platform
import subprocess
import sys
import time
import tomllib
from dataclasses import dataclass, field, replace

ROOT = pathlib.Path(__file__).resolve().parent.parent
sys.path[:0] = [str(ROOT / folder) for folder in ("images", "")]
import exr  # noqa: E402
from report import page, sections  # noqa: E402

SCENES = ROOT / "reference_scenes"
THOROUGH = ("cornell", "seed")  # the others are drawn more cheaply
RADIOSITY = "Radiosity"  # our other method
TOLERANCES = {"cornell": "1%"}  # as in tests/gate.toml; of others 2 %


def all_scenes():
    """Those that the plots in docs/ are of come first."""
    return THOROUGH + tuple(sorted({file.parent.name for file in SCENES.glob("*/scene.xml")} - set(THOROUGH)))


def described(file):
    """What `plumb reference --list` would say of a renderer's description (docs/renderers.md), whose place is `with`."""
    path = pathlib.Path(file).resolve()
    description = tomllib.loads(path.read_text(encoding="utf-8"))
    return {"word": path.stem, "name": description.get("name", path.stem), "isInstalled": True,
            "hasSamples": any("{spp}" in word for word in description["command"]), "with": str(path)}


def other_renderers(plumb, descriptions):
    """All that take part, those that are described last."""
    result = subprocess.run([plumb, "reference", "--list"], capture_output=True, text=True, check=True)
    known = sorted(json.loads(result.stdout), key=lambda renderer: renderer["word"])
    return [*({**renderer, "with": renderer["word"]} for renderer in known), *map(described, descriptions)]


@dataclass
class Plan:
    """What is rendered: by samples per pixel, or by quality where a program has no samples."""
    out: pathlib.Path = ROOT / "out"
    scenes: tuple = field(default_factory=all_scenes)
    methods: str = "bsdf,nee,mis"
    samplers: str = "sobol,independent"
    last: int = 256
    best: int = 4096  # samples of our picture that is judged and shown
    runs: int = 3
    cut_bounces: str = "0:5"  # a biased series: its floor is to be seen
    samples: tuple = (4, 16, 64, 256)  # of other programs
    qualities: tuple = ("draft", "good")
    errors: tuple = ("1%", "0.1%")  # of radiosity: at most

    def cheaper(self):
        """For so many scenes that all of them take a quarter of an hour."""
        return replace(self, samplers="sobol", last=min(self.last, 64), best=min(self.best, 1024),
                       runs=min(self.runs, 2), cut_bounces="", samples=self.samples[1:3],
                       qualities=self.qualities[:1], errors=self.errors[:1])


def floor(renderer):
    """A picture without samples has no noise but bias: all of it is shown."""
    return () if renderer["hasSamples"] else ("--floor", "0")


def floor_of(renderer, scene):
    """Why a picture without samples differs, from the card of the stored one; or nothing."""
    card = SCENES / scene / "card.json"
    stored = json.loads(card.read_text("utf-8"))["pictures"] if card.exists() else []
    known = next((one.get("floor") for one in stored if one["file"] == f"{renderer['word']}.exr"), None)
    if renderer["hasSamples"] or not known:
        return ""
    worst = max(known["regionsPercent"].items(), key=lambda region: region[1])
    return (f"\n{renderer['name']} takes no samples whose number would lower its error: it has a floor. That of the stored "
            f"picture, its best, is {known['wholePercent']:.2g} % of the whole and {worst[1]:.2g} % of {worst[0]}, by its "
            f"card; of a lower quality it is more.")


class Trouble(Exception):
    pass


class Plumb:
    """Runs `plumb`, whose own progress and errors are to be seen, and says what is under way."""

    def __init__(self, program, out):
        self.program, self.out = program, out
        self.begin = time.monotonic()

    def run(self, what, *arguments, accept=(0,)):
        arguments = [self.shown(argument) for argument in arguments]
        print(f"{time.monotonic() - self.begin:5.0f} s  {what}", flush=True)
        result = subprocess.run([self.program, *arguments], cwd=ROOT, check=False,
                                stdout=subprocess.DEVNULL)
        if result.returncode < 0 or result.returncode >= 128:
            raise KeyboardInterrupt
        if result.returncode not in accept:
            raise Trouble(f"plumb {' '.join(arguments)} ended with {result.returncode}")
        return "plumb " + " ".join(arguments)

    @staticmethod
    def shown(argument):
        """Paths as seen from the clone, where the page's reader runs the commands."""
        if isinstance(argument, pathlib.Path) and argument.is_relative_to(ROOT):
            return str(argument.relative_to(ROOT))
        return str(argument)


class SceneReport:
    """Everything about one scene, in the order in which it is drawn."""

    def __init__(self, name, plan, plumb, others):
        self.name, self.title, self.plumb, self.others = name, page.title_of(name), plumb, others
        self.plan = plan if name in THOROUGH else plan.cheaper()
        self.names = {"plumbline": "Plumbline"}
        self.names |= {renderer["word"]: renderer["name"] for renderer in others}
        self.called = {renderer["word"]: renderer["with"] for renderer in others}
        self.folder = plan.out / "report" / name
        (self.folder / "best").mkdir(parents=True, exist_ok=True)
        self.scene = SCENES / name / "scene.xml"
        self.stored = {word: self.scene.with_name(f"{word}.exr") for word in self.names
                       if self.scene.with_name(f"{word}.exr").exists()}
        self.reference = ("Plumbline, stored", self.stored.get("plumbline"))  # of what is drawn here
        self.mask = self.folder / "objects.png"
        self.hash = None    # of the scene as it is now
        self.commands = {}  # by the picture's file
        self.series = []    # the files that the plots are of
        self.noiseless = []  # those of them that more samples would not change
        self.verdicts = []
        self.pictures = []
        self.notes = []     # what is unlike in other scenes
        if name not in THOROUGH:
            self.notes.append(
                f"Drawn with fewer samples than {' and '.join(map(page.title_of, THOROUGH))}, so that all scenes "
                f"take a quarter of an hour: Plumbline's picture has {self.plan.best}, its plots end at "
                f"{self.plan.last}, other programs' at {self.plan.samples[-1]}, or there is one of "
                f"{self.plan.qualities[0]} quality.")

    def run(self, what, *arguments, **options):
        return self.plumb.run(f"{self.title}: {what}", *arguments, **options)

    # -- Pictures

    def draw_ours(self):
        """Our best picture, held against the others' stored ones."""
        quick = self.folder / "best" / "1spp.exr"
        self.run("which scene it is", "render", self.scene, "--spp", 1, "-o", quick)
        self.hash = exr.provenance(quick)[exr.SCENE_HASH]
        self.run("mask of objects", "render", self.scene, "--aov", "object", "-o", self.mask)
        # What is held against it must not have its samples in common with it.
        seed = () if self.reference[1] else ("--seed", 0)
        ours = self.rendered("plumbline", self.folder / "best" / f"{self.plan.best}spp.exr",
                             "render", self.scene, "--spp", self.plan.best, *seed)
        here = ("Plumbline, rendered here", ours)
        if not self.reference[1]:
            self.reference = here
            self.notes.append("No reference of Plumbline's is stored of this scene yet: what is drawn here is held "
                              f"against its picture of {self.plan.best} samples.")
        stored = {word: (f"{self.names[word]}, stored", file)
                  for word, file in self.stored.items()}
        others = [renderer for renderer in self.others if renderer["word"] in stored]
        for renderer in others:
            self.compare(here, stored[renderer["word"]], renderer)
        for renderer in others:
            if renderer["hasSamples"] and "plumbline" in stored:
                self.compare(stored["plumbline"], stored[renderer["word"]], renderer)
        self.show(*here, self.commands[ours])
        for title, file in stored.values():
            self.show(title, file, "make references")

    def methods(self):
        """Of the plan's methods those that find light here: chance never meets a point."""
        has_points = '<emitter type="point"' in self.scene.read_text()
        return self.plan.methods.replace("bsdf,", "") if has_points else self.plan.methods

    def draw_series(self):
        more = () if not self.plan.cut_bounces else (("--bounces", self.plan.cut_bounces),)
        for bounces in ((), *more):
            folder = self.folder / ("cut" if bounces else "whole")
            methods = (("--methods", "mis") if bounces else
                       ("--methods", self.methods(), "--samplers", self.plan.samplers))
            self.run(
                f"Plumbline {' '.join(bounces) or self.methods()}, 1 to {self.plan.last} spp",
                "converge", self.scene, *methods, *bounces, "--spp", f"1:{self.plan.last}",
                "--runs", self.plan.runs, "--keep", folder, "--reference", self.reference[1])
            self.series += sorted(folder.glob("*.exr"))

    def draw_radiosity(self):
        """Of scenes that it is for; the best picture is held against our reference."""
        drawn = [self.folder / f"radiosity-{error}.exr" for error in self.plan.errors]
        for error, file in zip(self.plan.errors, drawn):
            self.rendered("plumbline", file, "radiosity", self.scene, "--error", error, accept=(0, 3))
            if not file.exists():
                self.notes.append("Radiosity is for scenes of matte polygons, which this is not.")
                return
        self.series += drawn
        self.noiseless += drawn
        here = ("Radiosity, computed here", drawn[-1])
        # Its floor, which is that of its worst block, takes up most of 1 %.
        self.compare(self.reference, here, {"name": RADIOSITY, "hasSamples": True, "tolerance": "2%"})
        self.show(*here, self.commands[drawn[-1]])

    def draw_by(self, renderer):
        """Another program's pictures; the last and best are held against our reference."""
        try:
            drawn = self.draw_all_by(renderer)
        except Trouble as trouble:
            self.notes.append(f"{renderer['name']} did not draw this scene: {trouble}")
            return
        self.series += [file for runs in drawn for file in runs]
        first, *more = drawn[-1]
        here = (f"{renderer['name']}, rendered here", first)
        self.compare(here, self.reference, renderer, *(("--replicates", *more) if more else ()))
        self.show(*here, self.commands[first])

    def draw_all_by(self, renderer):
        """The runs of each number of samples, or the picture of each quality."""
        word = renderer["word"]
        if renderer["hasSamples"]:
            return [[self.drawn_by(word, f"{word}-{samples}spp-seed{seed}", "--spp", samples,
                                   "--seeds", 1, "--seed", seed)
                     for seed in range(10 * samples + 1, 10 * samples + 1 + self.plan.runs)]
                    for samples in self.plan.samples]
        # Nor has it seeds: a second run would draw the same picture.
        drawn = [[self.drawn_by(word, f"{word}-{quality}", "--quality", quality)]
                 for quality in self.plan.qualities]
        self.noiseless += [file for runs in drawn for file in runs]
        return drawn

    def rendered(self, program, file, *command, **options):
        """The file, rendered unless one of this scene is there already."""
        command = [*command, "-o", file]
        self.commands[file] = " ".join(["plumb", *map(self.plumb.shown, command)])
        if not file.exists() or exr.provenance(file)[exr.SCENE_HASH] != self.hash:
            self.run(f"{self.names[program]}, {file.stem}", *command, **options)
        return file

    def drawn_by(self, program, name, *settings):
        return self.rendered(program, self.folder / f"{name}.exr", "reference", self.scene,
                             "--with", self.called[program], *settings)

    # -- Judgements

    def compare(self, test, reference, other, *options):
        """A pair of (title, file), in which another program has a part, becomes a row of the table of verdicts."""
        report = self.folder / f"{test[1].stem}-{reference[1].stem}.json"
        command = self.run(f"compare {test[0]} with {reference[0]}", "compare", test[1],
                           reference[1], "--regions", self.mask, "--tolerance",
                           other.get("tolerance") or TOLERANCES.get(self.name, "2%"), *floor(other), *options, "--json", report, accept=(0, 1, 3))
        found = json.loads(report.read_text("utf-8"))

        def row(where, entry):
            return {"where": where, "channel": entry["channel"], "test": entry["test"],
                    "reference": entry["reference"], "bias": entry["relativeDifference"],
                    "confidence": entry["relativeConfidence95"] or None,
                    "verdict": entry["verdict"]}
        self.verdicts.append({
            "test": test[0], "reference": reference[0], "verdict": found["verdict"], "program": other["name"],
            "explanation": found["explanation"] + (floor_of(other, self.name) if found["verdict"] == "different" else ""),
            "command": command,
            "rows": [row("image", entry) for entry in found["channels"]]
            + [row(entry["region"], entry) for entry in found.get("regions", [])]})

    def exhibit(self, kind, files):
        """'plumb converge' or 'plumb chart' of the files: plot, table and sentences."""
        if not files:
            return None
        plot = self.folder / f"{kind}.svg"
        report = self.folder / f"{kind}.json"
        self.run(kind, kind, *files, "--reference", self.reference[1], "-o", plot,
                 "--json", report)
        found = json.loads(report.read_text("utf-8"))
        folders = sorted({str(self.plumb.shown(file.parent)) + "/*.exr" for file in files})
        return {"svg": plot.read_text("utf-8"), "sentences": found["sentences"],
                "table": {"head": found["head"], "rows": found["rows"]},
                "command": f"plumb {kind} {' '.join(folders)} --reference "
                           f"{self.plumb.shown(self.reference[1])} -o {kind}.svg"}

    # -- The page

    def show(self, title, file, command):
        width, height, values = exr.planes(file, ["R", "G", "B"])
        errors = None
        if "variance.R" in exr.channels(file):
            _, _, planes = exr.planes(file, ["variance.R", "variance.G", "variance.B"], 0.5)
            errors = page.encode_picture(planes, mantissa_bits=3)
        card = exr.provenance(file)
        self.pictures.append({
            "id": file.stem, "title": title, "width": width, "height": height,
            "thumbnail": sections.thumbnail(values, width),
            "values": page.encode_picture(values), "errors": errors,
            "seconds": card.get(exr.WALL_SECONDS), "command": command, "card": card})

    def data(self):
        return {"name": self.name, "title": self.title, "notes": list(self.notes), "verdicts": list(self.verdicts),
                "convergence": self.exhibit("converge", [
                    file for file in self.series if file not in self.noiseless]),
                "chart": self.exhibit("chart", self.series),
                "pictures": list(self.pictures)}


def summary(scenes):
    """A line for each verdict."""
    lines = []
    for scene in scenes:
        for verdict in scene["verdicts"]:
            whole = next(row for row in verdict["rows"] if row["channel"] == "all")
            spread = f" ± {100 * whole['confidence']:.3f}" if whole["confidence"] else ""
            lines.append(f"{scene['title']}: {verdict['test']} against {verdict['reference']}: "
                         f"{verdict['verdict']}, {100 * whole['bias']:+.3f}{spread} % on the whole")
    return lines


@dataclass
class Stage:
    """What the page is written anew after."""
    name: str
    minutes: str  # for all scenes, on two cores
    draw: callable  # for one SceneReport


def stages(others):
    return [Stage("Plumbline's pictures", "1 or 2", SceneReport.draw_ours),
            Stage("the plots", "2 or 3", SceneReport.draw_series),
            Stage(RADIOSITY, "1", SceneReport.draw_radiosity),
            *(Stage(other["name"], "3 or 4", lambda report, other=other: report.draw_by(other))
              for other in others if other["isInstalled"])]


def note(renderer, reports):
    """What the page lacks of a program that is not installed."""
    if any(renderer["word"] in report.stored for report in reports):
        return f"{renderer['name']} is not installed: only its stored picture is here."
    return f"{renderer['name']} is not installed, and has no part in this."


def make(program, plan, descriptions=()):
    """Returns the page's file and the verdicts."""
    others = other_renderers(program, descriptions)
    plumb = Plumb(program, plan.out)
    reports = [SceneReport(name, plan, plumb, others) for name in plan.scenes]
    notes = [note(other, reports) for other in others if not other["isInstalled"]]
    coming = stages(others)
    file = plan.out / "report.html"
    print(*notes, "Minutes of rendering on two cores, less what is kept of earlier runs: "
          + ", ".join(f"{stage.name} {stage.minutes}" for stage in coming) + ".",
          f"After each of them {file} is written anew.", sep="\n", flush=True)
    version = subprocess.run([program, "--version"], capture_output=True, text=True, check=True)
    data = {"title": "Plumbline: speed and accuracy of renderers",
            "version": version.stdout.split()[-1], "notes": notes, "summary": [],
            "programs": [RADIOSITY, *(other["name"] for other in others)]}

    def write(why_not_complete):
        missing = why_not_complete.format(", ".join(stage.name for stage in coming))
        data["incomplete"] = f"Not complete. {missing}" if coming else ""
        page.write_page(data, file)

    try:
        while coming:
            for report in reports:
                coming[0].draw(report)
            scenes = [report.data() for report in reports]
            del coming[0]
            data |= {"scenes": scenes,
                     "host": scenes[0]["pictures"][0]["card"].get(exr.HOST, platform.machine()),
                     "made": f"{datetime.datetime.now(datetime.timezone.utc):%Y-%m-%d %H:%M} UTC"}
            write("Still being rendered: {}. Load this page again later.")
    except BaseException:
        if "scenes" in data:
            write("Rendering ended before {}. 'make report' goes on from there.")
        raise
    return file, summary(scenes)


def main():
    if len(sys.argv) < 2:
        sys.exit(__doc__)
    begin = time.monotonic()
    try:
        file, lines = make(str(pathlib.Path(sys.argv[1]).resolve()), Plan(), sys.argv[2:])
    except KeyboardInterrupt:
        print("\ninterrupted: the page shows what was finished, and out/report/ keeps it")
        return 130
    except (Trouble, OSError, subprocess.CalledProcessError) as problem:
        print(problem, file=sys.stderr)
        return 2
    print("\n" + "\n".join(lines))
    print(f"\n{file} ({file.stat().st_size / 1e6:.1f} MB), {time.monotonic() - begin:.0f} s")
    return 0


if __name__ == "__main__":
    sys.exit(main())
