# SPDX-License-Identifier: Apache-2.0

"""Renders as tasks, on this machine or on the workers of a Dask cluster.

    from plumbline import cluster
    whole = cluster.render("scene.xml", 65536)
    study = cluster.Study("out/study")
    study.run([whole])                                       # here, or
    study.run([whole], distributed.Client("tcp://...:8786"))  # there
    study.file(whole)                                        # the picture, the same bits

A task is a call of the command `plumb`. Its result is a folder named after the task's key, which says all
that the result depends on: what is there is not made again, by whomever and whenever it was made. Workers
need Dask and `plumb` (in $PLUMB, in this package, or on the PATH); a folder that they share with whoever
runs the study saves them from sending results, and they find that out by themselves.
"""

import asyncio
import contextlib
import dataclasses
import datetime
import functools
import hashlib
import importlib.util
import json
import os
import pathlib
import queue
import re
import shutil
import socket
import statistics
import subprocess
import sys
import tempfile
import threading
import time
import uuid
from collections import defaultdict, deque
from collections.abc import Iterable, Sequence
from concurrent.futures import ThreadPoolExecutor
from typing import Any

# Of one task, before it is given up.
TRIES = 3
# A merge reads so many parts at most: a tree of them is flat, and no task waits for long.
FAN_IN = 8
# Those of pictures cut by pixels have as many bytes as what is made of them.
FAN_IN_OF_CROPS = 64
# A task draws so many pixels at most: its film has 384 bytes for each, 0.4 GB.
MOST_PIXELS = 2**20
# So many samples take half a minute of a core.
SAMPLES = 2**27
PICTURE = "picture.exr"


@dataclasses.dataclass(frozen=True, eq=False)
class Task:
    """A call of `plumb` in a folder that has `files` (bytes by name) and the results of `needs`, each in a
    folder with its key for a name. It writes into the folder `result`."""

    label: str  # for people, and for what such tasks are expected to take
    words: tuple[str, ...]
    files: dict[str, bytes] = dataclasses.field(default_factory=dict, repr=False)
    needs: tuple["Task", ...] = ()
    program: str = ""  # the other program that it takes, or several with spaces between
    is_timed: bool = False  # measures time, and takes all cores

    @functools.cached_property
    def key(self) -> str:
        files = {name: hashlib.sha256(data).hexdigest() for name, data in self.files.items()}
        depends = [plumb_version(), [program_version(word) for word in self.program.split()], self.words, files,
                   [need.key for need in self.needs]]
        return hashlib.sha256(json.dumps(depends, sort_keys=True).encode()).hexdigest()[:40]


def find_plumb():
    """The command; that within the package comes before what is on the PATH. None if there is none."""
    if "PLUMB" in os.environ:
        return os.environ["PLUMB"]
    package = importlib.util.find_spec("plumbline")
    for folder in package.submodule_search_locations if package else ():
        if (inside := pathlib.Path(folder) / "bin" / "plumb").exists():
            return str(inside)
    return shutil.which("plumb")


def said_by(*words):
    return subprocess.run(words, capture_output=True, text=True, check=True).stdout.strip()


@functools.cache
def plumb_version():
    if not (plumb := find_plumb()):
        raise FileNotFoundError("there is no command plumb: it is in $PLUMB, or on the PATH")
    return said_by(plumb, "--version")


@functools.cache
def programs():
    """What `plumb reference --list` says of each other program, by its word."""
    return {program["word"]: program for program in json.loads(said_by(find_plumb(), "reference", "--list"))}


def program_version(word):
    """Empty where only workers have the program, or its description is all that is known of it."""
    return programs().get(word, {}).get("version", "") if not word.endswith(".toml") else ""


def bundle(file):
    """(its name, all files that a scene or a description names, as bytes by name)."""
    found, left, listed = {}, [pathlib.Path(file).resolve()], {}
    while left:
        path = left.pop()
        if path in found:
            continue
        found[path] = path.read_bytes()
        if path.suffix in (".xml", ".toml"):
            left += named_in(found[path].decode(errors="replace"), path.parent, listed)
    # A scene may be called after its folder.
    root = pathlib.Path(os.path.commonpath([path.parent for path in found])).parent
    files = {str(path.relative_to(root)): data for path, data in found.items()}
    return next(iter(files)), files


def named_in(text, folder, listed):
    """The files that the text of one in this folder names. Most words are no file's name: a folder's list, which
    `listed` keeps, says so sooner than asking for each, and studies have thousands of tasks."""
    names = listed.get(folder) or listed.setdefault(folder, set(os.listdir(folder)))
    for word in dict.fromkeys(re.findall(r"[^\s\"'<>{}=,;]{1,200}", text)):
        # An oracle like another scene is named without its .xml; {here}/... is beside the file.
        word = word.lstrip("/").rstrip(".")
        for place in (word, f"{word}.xml"):
            if (place in names or "/" in place) and (folder / place).is_file():
                yield (folder / place).resolve()


def size_of(files, name, words):
    size = words[words.index("--size") + 1] if "--size" in words else "x".join(
        ([*re.findall(rf'"{side}"\s+value="(\d+)"', files[name].decode(errors="replace")), "512"])[0]
        for side in ("width", "height"))
    return tuple(map(int, size.split("x")))


def crops_of(width, height, spp):
    """Rectangles (x, y, width, height) that make up the picture, some for each of its rows or for several, so that
    spp samples of one make a task."""
    if width * height <= MOST_PIXELS:
        return [[(0, 0, width, height)]]
    pixels = min(MOST_PIXELS, max(1024, SAMPLES // spp))
    rows = max(1, pixels // width)
    return [[(x, y, min(pixels, width - x), min(rows, height - y)) for x in range(0, width, min(pixels, width))]
            for y in range(0, height, rows)]


def render(scene: str | os.PathLike[str], spp: int, words: Iterable[object] = (),
           samples_per_task: int | None = None) -> Task:
    """The task whose result is the picture that `plumb render --spp` draws, bit for bit: of parts and a tree of
    merges. A part takes half a minute of a core. Pictures of more than MOST_PIXELS are cut by pixels, others by
    samples, each part of which has enough to be worth its bytes; with `samples_per_task` both are."""
    name, files = bundle(scene)
    words = tuple(map(str, words))
    width, height = size_of(files, name, words)
    rows = crops_of(width, height, samples_per_task or spp)
    is_whole = len(rows) == len(rows[0]) == 1
    each = samples_per_task or (max(256, SAMPLES // (width * height)) if is_whole else spp)
    label = f"render-{pathlib.Path(name).parent.name}"

    def part(crop, *range_words):
        crop_words = () if is_whole else ("--crop", ",".join(map(str, crop)))
        return Task(label, ("render", name, *words, *crop_words, *range_words, "-o", f"result/{PICTURE}"), files)

    def all_samples(crop):
        if spp <= each:
            return part(crop, "--spp", str(spp))
        parts = [part(crop, "--samples", f"{first}:{min(first + each, spp)}") for first in range(0, spp, each)]
        return merge_in_turn(parts, FAN_IN, "--last")

    if is_whole:
        return all_samples(rows[0][0])
    bands = [merge_in_turn([all_samples(crop) for crop in row], FAN_IN_OF_CROPS) for row in rows]
    return merge_in_turn(bands, FAN_IN_OF_CROPS, "--last")


def merge_in_turn(parts, at_once, *last_words):
    """So many at once, as a tree; one part alone needs none."""
    while len(parts) > at_once:
        parts = [merge(parts[i:i + at_once]) for i in range(0, len(parts), at_once)]
    return merge(parts, *last_words) if len(parts) > 1 else parts[0]


def merge(parts: Sequence[Task], *words: str) -> Task:
    files = (f"{part.key}/{PICTURE}" for part in parts)
    return Task("merge", ("merge", *files, *words, "-o", f"result/{PICTURE}"), needs=tuple(parts))


def with_program(program, files):
    """(what to call it, the files and what its description names)."""
    if not program.endswith(".toml"):
        return program, files
    name, described = bundle(program)
    return f"program/{name}", {**files, **{f"program/{name}": data for name, data in described.items()}}


def reference(scene: str | os.PathLike[str], program: str, words: Iterable[object] = (),
              seeds: Iterable[int] | None = None) -> Task:
    """The task whose result another program draws, known by its word or described in a file; with `seeds`
    (a range), pictures of so many tasks, whose mean it is."""
    name, files = bundle(scene)
    label = f"{pathlib.Path(program).stem}-{pathlib.Path(name).parent.name}"
    given, files = with_program(program, files)
    words = ("reference", name, "--with", given, *map(str, words), "-o", f"result/{PICTURE}")
    if seeds is None:
        return Task(label, words, files, program=program)
    pictures = [Task(label, (*words, "--seeds", "1", "--seed", str(seed)), files, program=program)
                for seed in seeds]
    return pictures[0] if len(pictures) == 1 else merge(pictures)


def perform(key, words, files, needs, program, version, store, token, stop=None):
    """Carries out a task, wherever this is; sends a plain dictionary, since workers may lack this module."""
    worker, is_shared, versions = socket.gethostname(), True, {}
    store = pathlib.Path(store)
    if stop is None:
        from distributed import get_worker
        dask, current = get_worker(), get_worker().get_current_task()
        worker = dask.address
        versions = vars(dask).setdefault("plumb_versions", {})  # to ask for it again costs as much as all else
        # Nobody waits any more for what was cancelled.
        stop = lambda: getattr(dask.state.tasks.get(current), "state", "") != "executing"  # noqa: E731
        is_shared = (store / "token").is_file() and (store / "token").read_text() == token
    if needs and not is_shared:
        return {"lacks": "store", "worker": worker}
    plumb = find_plumb()
    if plumb and plumb not in versions:
        versions[plumb] = subprocess.run([plumb, "--version"], capture_output=True, text=True).stdout.strip()
    if versions.get(plumb) != version:
        return {"lacks": "plumb", "worker": worker}
    with tempfile.TemporaryDirectory(dir=store / "unfinished" if is_shared else None) as folder:
        folder = pathlib.Path(folder)
        result = folder / "result"
        result.mkdir()
        for name, data in files.items():
            (folder / name).parent.mkdir(parents=True, exist_ok=True)
            (folder / name).write_bytes(data)
        for need in needs:
            (folder / need).symlink_to(store / need)
        # The bits do not depend on it, and results are not told apart by it.
        threads = ("--threads", os.environ.get("PLUMB_THREADS", "1")) if words[0] in ("render", "reference") else ()
        outcome = carry_out([plumb, *words, *threads], folder, needs, program, stop)
        if "seconds" not in outcome:
            return {**outcome, "worker": worker}
        if is_shared:
            publish(result, store / key)
        else:
            outcome["files"] = {path.name: path.read_bytes() for path in result.iterdir()}
        return {**outcome, "worker": worker}


def carry_out(command, folder, needs, program, stop):
    begin = time.perf_counter()
    refused = [need for need in needs if not (folder / need / "picture.exr").exists()]
    code, out, err = (3, "", f"not drawn: {refused}\n") if refused else call(command, folder, stop, program)
    if code is None:
        return {"stopped": True}
    if program and re.search(r"is not (installed|there)|No module named|FileNotFoundError", out + err):
        return {"lacks": program}
    seconds = time.perf_counter() - begin
    log = f"plumb {' '.join(command[1:])}\n{socket.gethostname()}, {seconds:.2f} s, exit code {code}\n{err}{out}"
    # Wrong, or that a program can't, is an answer, too.
    answers = {"stress": (0, 1), "certify": (0, 1, 3), "reference": (0, 3), "merge": (0, 3)}
    if code not in answers.get(command[1], (0,)):
        return {"failed": log}
    (folder / "result" / "out.txt").write_text(out)
    (folder / "result" / "log.txt").write_text(log)
    return {"seconds": seconds}


def call(command, folder, stop, program):
    """(exit code, output, errors); the code is None if it was stopped."""
    with subprocess.Popen(command, cwd=folder, stdin=subprocess.DEVNULL, stdout=subprocess.PIPE,
                          stderr=subprocess.PIPE, text=True) as process:
        while True:
            try:
                out, err = process.communicate(timeout=0.2)
                return process.returncode, out, err
            except subprocess.TimeoutExpired:
                if stop():
                    # It hands SIGTERM on; alone, it need not save what nobody asks for.
                    process.terminate() if program else process.kill()
                    process.communicate()
                    return None, "", ""


def publish(result, target):
    """At once, for whoever looks; what somebody else was faster with stays."""
    try:
        os.rename(result, target)
    except OSError:
        if not target.is_dir():
            raise


class Study:
    """Results in a folder, by their tasks' keys."""

    def __init__(self, store: str | os.PathLike[str]) -> None:
        self.store = pathlib.Path(store).resolve()
        for name in ("unfinished", "failed"):
            (self.store / name).mkdir(parents=True, exist_ok=True)
        # Whether a worker's folder of this path is this one.
        if not (self.store / "token").exists():
            (self.store / "unfinished" / "token").write_text(uuid.uuid4().hex)
            os.replace(self.store / "unfinished" / "token", self.store / "token")
        self.token = (self.store / "token").read_text()

    def has(self, task: Task) -> bool:
        return (self.store / task.key).is_dir()

    def file(self, task: Task, name: str = PICTURE) -> pathlib.Path:
        return self.store / task.key / name

    def missing(self, goals: Iterable[Task]) -> dict[str, Task]:
        """Tasks by their keys, those before others that these need; not what only finished ones need."""
        found = {}

        def visit(task):
            if task.key not in found and not self.has(task):
                for need in task.needs:
                    visit(need)
                found[task.key] = task
        for goal in goals:
            visit(goal)
        return found

    def run(self, goals: Sequence[Task], client: Any = None, slots: int | None = None) -> list[Task]:
        """Does what is missing, on this machine's cores or by a Dask client. Returns the goals that could not
        be reached; their logs are in the store's folder `failed`."""
        todo = self.missing(goals)
        if not todo:
            say(f"nothing to do: all is in {self.store}")
            return []
        if any(task.is_timed for task in todo.values()):
            slots = 1
        _Run(self, todo, client, slots or len(os.sched_getaffinity(0))).go()
        return [goal for goal in goals if not self.has(goal)]


def say(text):
    print(f"\r{text}\x1b[K" if sys.stderr.isatty() else text, file=sys.stderr, flush=True)


class _Run:
    """What is under way."""

    def __init__(self, study, todo, client, slots):
        self.study, self.client, self.todo, self.slots = study, client, todo, slots
        self.total, self.begin, self.shown, self.looked = len(todo), time.monotonic(), time.monotonic(), 0.0
        self.here, self.stop = ThreadPoolExecutor(slots), threading.Event()
        self.returned = queue.SimpleQueue()  # names of flights
        self.flights = {}  # by name: future, task, the workers that may have it
        self.users = defaultdict(list)
        for task in todo.values():
            for need in task.needs:
                self.users[need.key].append(task)
        self.ready = deque(task for task in todo.values() if self.can_start(task))
        self.tries, self.lacking = defaultdict(int), defaultdict(set)
        self.seconds = defaultdict(list)  # by label
        self.workers = {}  # threads by address
        if client:
            # Workers need not have this module: what is no name's function is sent as code.
            from distributed.protocol.pickle import cloudpickle
            cloudpickle.register_pickle_by_value(sys.modules[__name__])
            self.sent = lambda *arguments: perform(*arguments)

    def go(self):
        try:
            while self.todo:
                self.look()
                self.start_some()
                try:
                    self.take(self.returned.get(timeout=1.0))
                except queue.Empty:
                    pass
                self.show()
        finally:
            self.close()

    def can_start(self, task):
        return not any(need.key in self.todo for need in task.needs)

    def look(self):
        """Workers come and go; a task must not wait for one that is gone."""
        if not self.client or time.monotonic() < self.looked + 1.0:
            return
        self.looked = time.monotonic()
        with contextlib.suppress(OSError, TimeoutError):  # the client tries to reach the scheduler again
            self.workers = self.client.nthreads()
        if self.client.status == "closed":
            raise ConnectionError("the scheduler is gone; the same study goes on from here")
        for future, _, allowed in self.flights.values():
            if allowed and not allowed & self.workers.keys():
                future.cancel()

    def start_some(self):
        # Some wait at the workers, so that these need not wait; not all, since they hold memory there.
        room = 2 * sum(self.workers.values()) if self.client else self.slots
        for _ in range(len(self.ready)):
            if len(self.flights) >= room:
                return
            task = self.ready.popleft()
            if not self.start(task):
                self.ready.append(task)
        if self.ready and not self.flights:
            for task in list(self.ready):
                self.fail(task, f"no worker has {task.program or plumb_version()}", TRIES)

    def start(self, task):
        """Whether there is somebody to do it."""
        study = self.study
        arguments = (task.key, task.words, task.files, [need.key for need in task.needs], task.program,
                     plumb_version(), str(study.store), study.token)
        takes = ["plumb", task.program, *(["store"] if task.needs else [])]
        allowed = self.workers.keys() - set().union(*(self.lacking[what] for what in takes))
        name = f"{task.label}-{task.key[:12]}-{uuid.uuid4().hex[:8]}"
        # What only this machine has need not be sent.
        if not self.client or (task.needs and not allowed):
            if task.program and self.lacking[task.program]:
                return False
            future = self.here.submit(perform, *arguments, self.stop.is_set)
        elif not allowed:
            return False
        else:
            some = sorted(allowed) if len(allowed) < len(self.workers) else None
            future = self.client.submit(self.sent, *arguments, key=name, pure=False, workers=some)
        self.flights[name] = future, task, allowed
        future.add_done_callback(lambda _: self.returned.put(name))
        return True

    def take(self, name):
        future, task, _ = self.flights.pop(name)
        try:
            # It may wait for a worker that is gone.
            outcome = {"stopped": True} if future.cancelled() else future.result(timeout=30)
        except (Exception, asyncio.CancelledError) as error:
            outcome = {"failed": repr(error)} if future.done() and not future.cancelled() else {"stopped": True}
        if "seconds" in outcome:
            self.finish(task, outcome)
        elif "failed" in outcome:
            self.fail(task, outcome["failed"], self.tries[task.key] + 1)
        else:
            if "lacks" in outcome:
                self.lacking[outcome["lacks"]].add(outcome["worker"])
                if outcome["lacks"] != "store":
                    say(f"{outcome['worker']} has no {outcome['lacks']}, or another version")
            self.ready.append(task)

    def finish(self, task, outcome):
        if files := outcome.get("files"):
            self.lacking["store"].add(outcome["worker"])
            with tempfile.TemporaryDirectory(dir=self.study.store / "unfinished") as folder:
                result = pathlib.Path(folder) / "result"
                result.mkdir()
                for name, data in files.items():
                    (result / name).write_bytes(data)
                publish(result, self.study.store / task.key)
        self.seconds[task.label].append(outcome["seconds"])
        del self.todo[task.key]
        self.ready.extendleft(user for user in self.users[task.key] if self.can_start(user))

    def fail(self, task, log, tries):
        self.tries[task.key] = tries
        file = self.study.store / "failed" / f"{task.key}.txt"
        file.write_text(log)
        say(f"{task.label} failed, try {min(tries, TRIES)} of {TRIES}: {file}")
        if tries < TRIES:
            self.ready.append(task)
        else:
            self.give_up(task)

    def give_up(self, task):
        if self.todo.pop(task.key, None) is None:
            return
        with contextlib.suppress(ValueError):
            self.ready.remove(task)
        for user in self.users[task.key]:
            self.give_up(user)

    def show(self):
        """Tasks of a label are expected to take as long as those before, at the speed until now."""
        now = time.monotonic()
        if self.todo and now < self.shown + (1.0 if sys.stderr.isatty() else 30.0):
            return
        self.shown, elapsed = now, now - self.begin
        done = [second for seconds in self.seconds.values() for second in seconds]
        text = f"{len(done)} of {self.total} tasks in {elapsed:.0f} s" + (f" by {len(self.workers)} workers" if self.client else "")
        if done and self.todo:
            usual = statistics.mean(done)
            means = {label: statistics.mean(seconds) for label, seconds in self.seconds.items()}
            left = sum(means.get(task.label, usual) for task in self.todo.values()) * elapsed / sum(done)
            text += f", about {datetime.timedelta(seconds=round(left))} left"
        print(f"\r{text}\x1b[K" if sys.stderr.isatty() else text, end="" if self.todo and sys.stderr.isatty() else "\n",
              file=sys.stderr, flush=True)

    def close(self):
        """What has come back is kept, also after Ctrl-C."""
        deadline = time.monotonic() + 0.5
        while not self.returned.empty() and time.monotonic() < deadline:
            self.take(self.returned.get())
        self.stop.set()
        for future, *_ in self.flights.values():
            future.cancel()
        self.here.shutdown(cancel_futures=True)
