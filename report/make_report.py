"""Renders the reference scenes with every installed program and writes out/report.html.

    python3 report/make_report.py PLUMB    (which is 'make report')

Pictures are kept in out/report/ and not rendered again unless their scene or settings change. A
program that is not installed is stood in for by its stored picture. Exit codes: 0 done, 2 trouble,
130 interrupted.
"""

import datetime
import json
import pathlib
import platform
import shutil
import subprocess
import sys
import time
from dataclasses import dataclass, field

ROOT = pathlib.Path(__file__).resolve().parent.parent
sys.path[:0] = [str(ROOT / "images"), str(ROOT / "report")]
import exr  # noqa: E402
import page  # noqa: E402

TITLES = {"cornell": "Cornell box", "seed": "Seed scene"}
TOLERANCES = {"cornell": "1%", "seed": "2%"}  # as in tests/gate.toml
NAMES = {"plumbline": "Plumbline", "cycles": "Cycles", "povray": "POV-Ray", "mitsuba": "Mitsuba"}


@dataclass
class Plan:
    """What is rendered: ours by samples per pixel, Cycles and Mitsuba too, POV-Ray by quality."""
    out: pathlib.Path = ROOT / "out"
    scenes: tuple = ("cornell", "seed")
    methods: str = "bsdf,nee,mis"
    samplers: str = "sobol,independent"
    last: int = 512
    best: int = 4096  # samples of our picture that is judged and shown
    runs: int = 3
    cut_bounces: str = "0:5"  # a biased series: its floor is to be seen
    samples: dict = field(default_factory=lambda: {
        "cycles": (4, 16, 64, 256), "mitsuba": (4, 16, 64, 256)})
    qualities: tuple = ("draft", "good")


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


def installed():
    """The programs that can render on this machine."""
    has_mitsuba = subprocess.run([shutil.which("python3") or sys.executable, "-c", "import mitsuba"],
                                 capture_output=True, check=False).returncode == 0
    found = {"cycles": shutil.which("blender"), "povray": shutil.which("povray"),
             "mitsuba": has_mitsuba}
    return [name for name, is_there in found.items() if is_there]


class SceneReport:
    """Everything about one scene, in the order in which it is made."""

    def __init__(self, name, plan, plumb, programs):
        self.name, self.plan, self.plumb, self.programs = name, plan, plumb, programs
        self.folder = plan.out / "report" / name
        self.folder.mkdir(parents=True, exist_ok=True)
        self.scene = ROOT / "reference_scenes" / name / "scene.xml"
        self.stored = {program: self.scene.with_name(f"{program}.exr")
                       for program in ("plumbline", "cycles", "povray")}
        self.mask = self.folder / "objects.png"
        self.commands = {}  # by the picture's file
        self.others = {}    # the runs of each other program's best pictures, rendered here

    def run(self, what, *arguments, **options):
        return self.plumb.run(f"{TITLES[self.name]}: {what}", *arguments, **options)

    # -- Pictures

    def render_ours(self):
        more = () if not self.plan.cut_bounces else (("--bounces", self.plan.cut_bounces),)
        for bounces in ((), *more):
            folder = self.folder / ("cut" if bounces else "whole")
            methods = (("--methods", "mis") if bounces else
                       ("--methods", self.plan.methods, "--samplers", self.plan.samplers))
            command = self.run(
                f"Plumbline {' '.join(bounces) or self.plan.methods}, 1 to {self.plan.last} spp",
                "converge", self.scene, *methods, *bounces, "--spp", f"1:{self.plan.last}",
                "--runs", self.plan.runs, "--keep", folder, "--reference", self.stored["plumbline"])
            for file in folder.glob("*.exr"):
                self.commands[file] = command
        method, sampler = (words.split(",")[0] for words in (self.plan.methods, self.plan.samplers))
        first = self.folder / "whole" / f"{self.name}-{method}-{sampler}-1spp-seed1.exr"
        self.hash = exr.attributes(first)["sceneHash"]  # of the scene as it is now
        self.ours = self.rendered("plumbline", self.folder / "best" / f"{self.plan.best}spp.exr",
                                  "render", self.scene, "--spp", self.plan.best)

    def rendered(self, program, file, *command):
        """The file, rendered unless one of this scene is there already."""
        command = [*command, "-o", file]
        self.commands[file] = " ".join(["plumb", *map(self.plumb.shown, command)])
        file.parent.mkdir(exist_ok=True)
        if not file.exists() or exr.attributes(file)["sceneHash"] != self.hash:
            self.run(f"{NAMES[program]}, {file.stem}", *command)
        return file

    def reference(self, program, name, *settings):
        return self.rendered(program, self.folder / f"{name}.exr", "reference", self.scene,
                             "--with", program, *settings)

    def render_others(self):
        for program, counts in self.plan.samples.items():
            for samples in counts if program in self.programs else ():
                seeds = range(10 * samples + 1, 10 * samples + 1 + self.plan.runs)
                self.others[program] = [
                    self.reference(program, f"{program}-{samples}spp-seed{seed}", "--spp", samples,
                                   "--seeds", 1, "--seed", seed) for seed in seeds]
        for quality in self.plan.qualities if "povray" in self.programs else ():
            self.others["povray"] = [
                self.reference("povray", f"povray-{quality}-{run}", "--quality", quality)
                for run in range(1, self.plan.runs + 1)]

    # -- Judgements

    def compare(self, test, reference, *options):
        """A pair of (title, file) as a row of the table of verdicts."""
        report = self.folder / f"{test[1].stem}-{reference[1].stem}.json"
        command = self.run(f"compare {test[0]} with {reference[0]}", "compare", test[1],
                           reference[1], "--regions", self.mask, "--tolerance",
                           TOLERANCES[self.name], *options, "--json", report, accept=(0, 1, 3))
        found = json.loads(report.read_text("utf-8"))

        def row(where, entry):
            return {"where": where, "channel": entry["channel"], "test": entry["test"],
                    "reference": entry["reference"], "bias": entry["relativeDifference"],
                    "confidence": entry["relativeConfidence95"] or None,
                    "verdict": entry["verdict"]}
        return {"test": test[0], "reference": reference[0], "verdict": found["verdict"],
                "explanation": found["explanation"], "command": command,
                "rows": [row("image", entry) for entry in found["channels"]]
                + [row(entry["region"], entry) for entry in found.get("regions", [])]}

    def judge(self):
        """Ours against the others' stored ground truth; what was rendered here against it, too."""
        self.run("mask of objects", "render", self.scene, "--aov", "object", "-o", self.mask)
        ours = ("Plumbline, rendered here", self.ours)
        stored = {program: (f"{NAMES[program]}, stored", file)
                  for program, file in self.stored.items()}
        no_noise = ("--floor", "0")  # a picture by POV-Ray has none, but bias: all of it is shown
        pairs = [(ours, stored["cycles"], ()), (ours, stored["povray"], no_noise),
                 (stored["plumbline"], stored["cycles"], ())]
        for program, (first, *more) in self.others.items():
            noise = no_noise if program == "povray" else ("--replicates", *more)
            pairs.append(((f"{NAMES[program]}, rendered here", first), stored["plumbline"], noise))
        return [self.compare(test, reference, *options) for test, reference, options in pairs]

    def exhibit(self, kind, files):
        """'plumb converge' or 'plumb chart' of the files: plot, table and sentences."""
        plot = self.folder / f"{kind}.svg"
        report = self.folder / f"{kind}.json"
        self.run(kind, kind, *files, "--reference", self.stored["plumbline"], "-o", plot,
                 "--json", report)
        found = json.loads(report.read_text("utf-8"))
        folders = sorted({str(self.plumb.shown(file.parent)) + "/*.exr" for file in files})
        return {"svg": plot.read_text("utf-8"), "sentences": found["sentences"],
                "table": {"head": found["head"], "rows": found["rows"]},
                "command": f"plumb {kind} {' '.join(folders)} --reference "
                           f"{self.plumb.shown(self.stored['plumbline'])} -o {kind}.svg"}

    # -- The page

    def picture(self, title, file, command):
        width, height, values = exr.planes(file, ["R", "G", "B"])
        errors = None
        if "variance.R" in exr.channels(file):
            _, _, planes = exr.planes(file, ["variance.R", "variance.G", "variance.B"], 0.5)
            errors = page.encode_picture(planes, mantissa_bits=3)
        card = exr.attributes(file)
        if "runs" in card:
            card["runs"] = json.loads(card["runs"])
        return {"id": file.stem, "title": title, "width": width, "height": height,
                "values": page.encode_picture(values), "errors": errors,
                "seconds": card.get("wallSeconds"), "command": command, "card": card}

    def pictures(self):
        found = [self.picture("Plumbline, rendered here", self.ours, self.commands[self.ours])]
        for program, file in self.stored.items():
            found.append(self.picture(f"{NAMES[program]}, stored", file, "make references"))
        for program, (first, *_) in self.others.items():
            found.append(self.picture(f"{NAMES[program]}, rendered here", first,
                                      self.commands[first]))
        return found

    def make(self):
        self.render_ours()
        self.render_others()
        verdicts = self.judge()
        own = sorted((self.folder / "whole").glob("*.exr"))
        cut = sorted((self.folder / "cut").glob("*.exr"))
        others = sorted(self.folder.glob("*.exr"))
        return {"name": self.name, "title": TITLES[self.name], "verdicts": verdicts,
                "convergence": self.exhibit("converge", own + cut + [
                    file for file in others if not file.name.startswith("povray")]),
                "chart": self.exhibit("chart", own + cut + others),
                "pictures": self.pictures()}


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


def make(program, plan):
    """Returns the page's file and the verdicts."""
    plumb = Plumb(program, plan.out)
    programs = installed()
    notes = [f"{NAMES[name]} is not installed: only its stored picture is here."
             for name in ("cycles", "povray") if name not in programs]
    if "mitsuba" not in programs:
        notes.append("Mitsuba is not installed, and has no part in this.")
    for note in notes:
        print(note)
    scenes = [SceneReport(name, plan, plumb, programs).make() for name in plan.scenes]
    lines = summary(scenes)
    version = subprocess.run([program, "--version"], capture_output=True, text=True, check=True)
    file = plan.out / "report.html"
    page.write_page({
        "title": "Plumbline: speed and accuracy of renderers", "summary": lines, "notes": notes,
        "made": f"{datetime.datetime.now(datetime.timezone.utc):%Y-%m-%d %H:%M} UTC",
        "host": scenes[0]["pictures"][0]["card"].get("host", platform.machine()),
        "version": version.stdout.split()[-1], "scenes": scenes}, file)
    return file, lines


def main():
    if len(sys.argv) != 2:
        sys.exit(__doc__)
    begin = time.monotonic()
    try:
        file, lines = make(str(pathlib.Path(sys.argv[1]).resolve()), Plan())
    except KeyboardInterrupt:
        print("\ninterrupted: the pictures that are finished are kept in out/report/")
        return 130
    except (Trouble, OSError, subprocess.CalledProcessError) as problem:
        print(problem, file=sys.stderr)
        return 2
    print("\n" + "\n".join(lines))
    print(f"\n{file} ({file.stat().st_size / 1e6:.1f} MB), {time.monotonic() - begin:.0f} s")
    return 0


if __name__ == "__main__":
    sys.exit(main())
