# SPDX-License-Identifier: Apache-2.0

"""plumbline study: the project's long studies, cut into tasks for this machine or a Dask cluster."""

import argparse
import json
import pathlib
import shutil
import sys

try:
    from plumbline import cluster
except ImportError:  # from a clone, without the compiled part
    import cluster

# Programs whose references lie beside the scenes.
STORED = ("plumbline", "cycles", "povray")
OURS = "plumbline"


def references(folder, out, scenes=()):
    """(where it is kept, the task) of each picture that `make references` compares."""
    for scene, how in json.loads((folder / "references.json").read_text(encoding="utf-8")).items():
        if scenes and scene not in scenes:
            continue
        file = folder / scene / "scene.xml"

        def place(program, end="", scene=scene):
            return (out if end or program not in STORED else folder) / scene / f"{program}{end}.exr"

        yield place(OURS), cluster.render(file, how["spp"], ("--seed", "0"))
        others = cluster.programs()
        for word, other in others.items():
            words, seeds = ("--quality", how["quality"]), None
            if other["hasSamples"]:  # those of a picture, which some programs hold in memory at once
                words, seeds = (*words, "--spp", "256"), range(1, how["seeds"] + 1)
            yield place(word), cluster.reference(file, word, words, seeds)
        for end, some in how.get("bounces", {}).items():
            yield place(OURS, f"-{end}"), cluster.render(file, how["spp"], some)
            for word in STORED[1:]:
                # Good is enough where noise is known, and allowed for.
                quality = "good" if others[word]["hasSamples"] else how["quality"]
                yield place(word, f"-{end}"), cluster.reference(file, word, ("--quality", quality, *some))


def convergence(options):
    least, most = map(int, options.spp.split(":"))
    samples = [least << i for i in range(64) if least << i <= most]
    runs = [(n, i * options.runs + run + 1) for i, n in enumerate(samples) for run in range(options.runs)]
    first = options.scene[0]
    pictures = [cluster.render(first, n, ("--method", method, "--seed", seed), samples_per_task=n)
                for method in options.methods.split(",") for n, seed in runs]
    pictures += [cluster.reference(first, program, ("--spp", n), [seed])
                 for program in options.programs for n, seed in runs]
    reference = pathlib.Path(options.reference)
    words = ("converge", *(f"{task.key}/{cluster.PICTURE}" for task in pictures), "--reference", reference.name,
             "-o", "result/convergence.svg", "--json", "result/convergence.json")
    return [cluster.Task("converge", words, {reference.name: reference.read_bytes()}, tuple(pictures))]


def stress(options):
    for file in options.scene or sorted((options.folder / "stress").glob("*.xml")):
        name, files = cluster.bundle(file)
        place = pathlib.PurePath(name)
        words = ("stress", "--folder", str(place.parent), "--scene", place.stem, "--time", options.time or "10")
        for program in options.programs:
            given, files = cluster.with_program(program, files)
            words += ("--with", given)
        yield cluster.Task(f"stress-{place.stem}", words, files, program=" ".join(options.programs), is_timed=True)


def power(options):
    for file in options.scene or [options.folder / scene / "scene.xml" for scene in ("cornell", "seed", "spheres")]:
        name, bundled = cluster.bundle(file)
        healthy = pathlib.Path(file).with_name("plumbline.exr")
        bundled[str(pathlib.PurePath(name).with_name(healthy.name))] = healthy.read_bytes()
        yield cluster.Task(f"power-{healthy.parent.name}", ("power", name, "--time", options.time or "60"), bundled,
                           is_timed=True)


def certificates(options):
    scenes = {str(file.relative_to(options.folder.parent)): file.read_bytes()
              for file in options.folder.rglob("*") if file.is_file()}
    for program in options.programs or cluster.programs():
        given, files = cluster.with_program(program, scenes)
        words = ("certify", "--with", given, "--folder", options.folder.name, "-o", "result/certificate.html",
                 *(("--time", options.time) if options.time else ()))
        yield cluster.Task(f"certify-{pathlib.Path(program).stem}", words, files, program=program, is_timed=True)


def tasks_of(options):
    """By where their pictures go, or else by their names."""
    if options.study == "references":
        return dict(references(options.folder, options.output, options.scene))
    makers = {"convergence": convergence, "stress": stress, "power": power, "certify": certificates}
    return {task.label: task for task in makers[options.study](options)}


def present(study, wanted, options):
    """Copies what was found to where it is expected, and prints what was said."""
    said = {}  # the head of a table once
    for place, task in wanted.items():
        if not study.has(task):
            continue
        if isinstance(place, pathlib.Path):
            if study.file(task).exists():
                place.parent.mkdir(parents=True, exist_ok=True)
                shutil.copyfile(study.file(task), place)
            continue
        said |= dict.fromkeys(study.file(task, "out.txt").read_text(encoding="utf-8").splitlines())
        for file in study.file(task, "").iterdir():
            if file.suffix != ".txt":
                options.output.mkdir(parents=True, exist_ok=True)
                shutil.copyfile(file, options.output / f"{place}{file.suffix}")
    print(*said, sep="\n", end="\n" if said else "")


def parse(arguments):
    parser = argparse.ArgumentParser(prog="plumbline", description=__doc__)
    study = parser.add_subparsers(required=True, metavar="study").add_parser("study", help=__doc__)
    add = study.add_argument
    add("study", choices=["references", "convergence", "stress", "power", "certify"])
    add("--dask", metavar="ADDRESS", help="a Dask scheduler, such as tcp://host:8786 (default: this machine alone)")
    add("--store", metavar="FOLDER", default="out/study", help="where results are kept (default: out/study)")
    add("--folder", metavar="DIR", type=pathlib.Path, default="reference_scenes", help="scenes (default: reference_scenes)")
    add("--scene", action="append", default=[], help="only this one: a name of a reference, else a file")
    add("--with", dest="programs", action="append", default=[], help="other programs, by word or FILE.toml")
    add("-o", "--output", metavar="DIR", type=pathlib.Path, default="out/references")
    add("--reference", help="of convergence: a converged picture")
    add("--methods", default="mis", help="of convergence (default: mis)")
    add("--spp", default="1:1024", help="of convergence: from A, doubled to B (default: 1:1024)")
    add("--runs", type=int, default=3, help="of convergence: renders of each (default: 3)")
    add("--time", help="seconds, as the command of the study takes them")
    return parser.parse_args(arguments)


def main(arguments=None):
    options = parse(arguments)
    study, client = cluster.Study(options.store), None
    if options.dask:
        from distributed import Client
        client = Client(options.dask)
    try:
        wanted = tasks_of(options)
        failed = study.run(list(wanted.values()), client)
    except KeyboardInterrupt:
        print("interrupted: the same command goes on from here", file=sys.stderr)
        return 130
    except (OSError, ValueError) as error:
        print(f"plumbline: {error}", file=sys.stderr)
        return 2
    present(study, wanted, options)
    return 2 if failed else 0


if __name__ == "__main__":
    sys.exit(main())
