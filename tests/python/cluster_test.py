# SPDX-License-Identifier: Apache-2.0

"""What may be relied on about studies: the same bits however a render is cut, nothing is done twice, and
whatever is lost is made up for. Run by pytest; $PLUMB is the command."""

import os
import pathlib
import random
import re
import signal
import socket
import subprocess
import sys
import time

import pytest

ROOT = pathlib.Path(__file__).resolve().parent.parent.parent
sys.path.insert(0, str(ROOT / "images"))
import exr  # noqa: E402

try:
    from plumbline import cluster, study_command
except ImportError:  # from a clone, without the compiled part
    sys.path.append(str(ROOT / "python" / "plumbline"))
    import cluster
    import study_command

if not cluster.find_plumb():
    pytest.skip("there is no command plumb: neither in $PLUMB nor on the PATH", allow_module_level=True)

CORNELL = ROOT / "reference_scenes" / "cornell" / "scene.xml"
SMALL = ("--size", "24x24", "--seed", "5")

# A renderer of a few lines: every pixel is the seed.
TINY = '''#!/usr/bin/env python3
import array, sys
_, seed, output, *_ = sys.argv
with open(output, "wb") as file:
    file.write(b"PF\\n24 24\\n-1.0\\n" + array.array("f", [float(seed)] * 24 * 24 * 3).tobytes())
'''
DESCRIPTION = '''command = ["tiny", "{seed}", "{output}", "{spp}", "{scene}"]
scene = "json"
output = "pfm"
'''


def picture(file):
    """All that must not depend on where and how a picture was rendered: attributes and the pixels' bytes."""
    data = file.read_bytes()
    fields, begin = exr._fields(data)
    told = {name: value for name, value in fields.items() if not re.search("Seconds|host|runs", name)}
    return told, data[int.from_bytes(data[begin:begin + 8], "little"):]


def drawn_at_once(folder, *words):
    file = folder / "whole.exr"
    subprocess.run([cluster.find_plumb(), *map(str, words), "-o", file], check=True, capture_output=True)
    return picture(file)


def state(study):
    """Which results there are, and when they were made."""
    return {file: file.stat().st_mtime_ns for file in study.store.glob("*/*")}


@pytest.fixture
def study(tmp_path):
    return cluster.Study(tmp_path / "store")


@pytest.mark.parametrize("samples", [500, 100, 37, 7])
def test_a_render_has_the_same_bits_however_it_is_cut(study, tmp_path, samples):
    task = cluster.render(CORNELL, 250, SMALL, samples)
    assert study.run([task]) == []
    assert picture(study.file(task)) == drawn_at_once(tmp_path, "render", CORNELL, *SMALL, "--spp", 250)


@pytest.mark.parametrize(("most", "samples"), [(120, None), (120, 4), (10, None)])
def test_a_large_picture_is_cut_by_pixels(study, tmp_path, monkeypatch, most, samples):
    monkeypatch.setattr(cluster, "MOST_PIXELS", most)
    monkeypatch.setattr(cluster, "FAN_IN_OF_CROPS", 3)
    goal = cluster.render(CORNELL, 9, SMALL, samples)
    assert study.run([goal]) == []
    assert picture(study.file(goal)) == drawn_at_once(tmp_path, "render", CORNELL, *SMALL, "--spp", 9)


@pytest.mark.parametrize(("width", "height", "spp"), [(8192, 8192, 64), (8192, 8192, 65536), (7680, 4320, 2**20), (3, 2**19, 1)])
def test_the_crops_of_a_picture_are_small_and_make_it_up(width, height, spp):
    row = 0
    for crops in cluster.crops_of(width, height, spp):
        column = 0
        for x, y, w, h in crops:
            assert (x, y) == (column, row) and 0 < w * h <= cluster.MOST_PIXELS
            column += w
        assert column == width
        row += crops[0][3]
    assert row == height


def test_a_key_says_all_that_a_result_depends_on(tmp_path):
    scene = box(tmp_path)
    keys = {cluster.render(scene, *arguments).key
            for arguments in [(64,), (65,), (64, ("--seed", "2")), (64, (), 32), (64, ("--bounces", "0:1"))]}
    assert len(keys) == 5
    assert cluster.render(scene, 64).key in keys
    mesh = scene.with_name("floor.obj")
    mesh.write_text(mesh.read_text() + "\n# moved\n")
    assert cluster.render(scene, 64).key not in keys


def test_what_is_finished_is_not_done_again(study, capsys):
    task = cluster.render(CORNELL, 40, SMALL, 10)
    assert study.run([task.needs[0], task.needs[2]]) == []
    before = state(study)
    assert len(study.missing([task])) == 3
    assert study.run([task]) == []
    done = state(study)
    assert done.items() > before.items()
    capsys.readouterr()
    assert study.run([task]) == []
    assert "nothing to do" in capsys.readouterr().err
    assert state(study) == done


def test_a_failure_is_tried_again_logged_and_costs_nothing_else(study):
    bad = cluster.render(CORNELL, 8, ("--method", "best"))
    good = cluster.render(CORNELL, 8, SMALL)
    assert study.run([bad, good]) == [bad]
    assert study.has(good)
    assert "bsdf, nee, mis" in (study.store / "failed" / f"{bad.key}.txt").read_text()


def test_an_interrupt_loses_nothing_that_is_finished(study, tmp_path):
    # In a process of its own, which Ctrl-C ends.
    program = tmp_path / "study.py"
    # Who runs these tests in the background has told all that they start to ignore SIGINT.
    program.write_text(f"import signal, sys\nsignal.signal(signal.SIGINT, signal.default_int_handler)\nsys.path = {[str(pathlib.Path(cluster.__file__).parent), *sys.path]!r}\n"
                       f"import cluster\ncluster.Study({str(study.store)!r}).run([cluster.render("
                       f"{str(CORNELL)!r}, 2**20, ('--size', '64x64'), 64)], slots=2)\n")
    with subprocess.Popen([sys.executable, program], stderr=subprocess.PIPE) as process:
        while len(state(study)) < 9:
            assert process.poll() is None
            time.sleep(0.05)
        process.send_signal(signal.SIGINT)
        process.communicate(timeout=60)
    assert process.returncode != 0
    assert not list((study.store / "unfinished").iterdir())
    assert len(state(study)) >= 9


def tiny_renderer(folder):
    """A description, and a folder for the PATH that holds what it starts."""
    (folder / "bin").mkdir(parents=True)
    (folder / "bin" / "tiny").write_text(TINY)
    (folder / "bin" / "tiny").chmod(0o755)
    (folder / "tiny.toml").write_text(DESCRIPTION)
    return str(folder / "tiny.toml"), folder / "bin"


def test_other_programs_are_tasks_too_seed_by_seed(study, tmp_path, monkeypatch):
    description, programs = tiny_renderer(tmp_path / "tiny")
    monkeypatch.setenv("PATH", f"{programs}:{os.environ['PATH']}")
    words = ("--size", "24x24", "--spp", "4")
    task = cluster.reference(CORNELL, description, words, range(3, 8))
    assert len(study.missing([task])) == 6
    assert study.run([task]) == []
    assert picture(study.file(task)) == drawn_at_once(
        tmp_path, "reference", CORNELL, "--with", description, *words, "--seeds", 5, "--seed", 3)


def test_where_no_program_is_that_is_said_and_the_rest_goes_on(study, tmp_path, capsys):
    description, _ = tiny_renderer(tmp_path)
    other = cluster.reference(CORNELL, description, ("--size", "24x24", "--spp", "4"), range(1, 4))
    ours = cluster.render(CORNELL, 8, SMALL)
    assert study.run([other, ours]) == [other]
    assert study.has(ours)
    assert f"has no {description}" in capsys.readouterr().err


def box(folder):
    """A folder of scenes that has the Cornell box alone."""
    (folder / "box").mkdir(parents=True)
    for file in [CORNELL, *CORNELL.parent.glob("*.obj")]:
        (folder / "box" / file.name).write_bytes(file.read_bytes())
    return folder / "box" / "scene.xml"


def test_references_are_put_where_they_belong(study, tmp_path, monkeypatch, capsys):
    scene = box(tmp_path / "scenes")
    scene.write_text(scene.read_text().replace('"256"', '"16"'))
    (tmp_path / "scenes" / "references.json").write_text('{"box": {"spp": 9, "seeds": 2, "quality": "good"}}')
    monkeypatch.setattr(cluster, "programs", dict)
    command = ["study", "references", "--folder", str(tmp_path / "scenes"), "--store", str(study.store)]
    assert study_command.main(command) == 0
    assert picture(scene.with_name("plumbline.exr")) == drawn_at_once(
        tmp_path, "render", scene, "--spp", 9, "--seed", 0)
    assert study_command.main(command) == 0
    assert "nothing to do" in capsys.readouterr().err


def test_tables_of_many_tasks_have_one_head(study, tmp_path, capsys):
    scenes = [str(ROOT / "reference_scenes" / "stress" / f"{name}.xml") for name in ("slit", "edge_pixel")]
    assert study_command.main(["study", "stress", "--time", "0.01", "--store", str(study.store),
                               *(word for scene in scenes for word in ("--scene", scene))]) == 0
    table = capsys.readouterr().out
    assert table.count("| scene |") == 1
    assert table.count("| slit |") == table.count("| edge_pixel |") == 8


class Cluster:
    """A scheduler and workers in processes that nobody looks after."""

    def __init__(self):
        with socket.socket() as free:
            free.bind(("127.0.0.1", 0))
            self.address = f"tcp://127.0.0.1:{free.getsockname()[1]}"
        self.workers = []
        self.start_scheduler()

    def start(self, command, *words, **environment):
        return subprocess.Popen([sys.executable, "-m", "distributed.cli." + command, *words, "--no-dashboard"],
                                env={**os.environ, **environment}, stdout=subprocess.DEVNULL,
                                stderr=subprocess.DEVNULL)

    def start_scheduler(self):
        self.scheduler = self.start("dask_scheduler", "--host", self.address, "--no-show")

    def start_worker(self, **environment):
        self.workers.append(self.start("dask_worker", self.address, "--no-nanny", "--nthreads", "1", **environment))

    def kill_scheduler(self):
        self.scheduler.kill()
        self.scheduler.wait()
        self.start_scheduler()
        for _ in self.workers.copy():  # which end without a scheduler
            self.kill_worker(0)

    def kill_worker(self, which):
        self.workers[which].kill()
        self.workers.pop(which).wait()
        self.start_worker()

    def close(self):
        for process in [*self.workers, self.scheduler]:
            process.kill()
            process.wait()


@pytest.fixture
def dask():
    pytest.importorskip("distributed", reason="Dask is not installed")
    cluster = Cluster()
    yield cluster
    cluster.close()


def client_of(dask):
    from distributed import Client
    return Client(dask.address, timeout=60)


def test_workers_that_share_no_folder_send_what_they_have_drawn(study, dask, tmp_path):
    dask.start_worker()
    study.token = "of another folder"
    task = cluster.render(CORNELL, 90, SMALL, 10)
    with client_of(dask) as client:
        assert study.run([task], client) == []
    assert picture(study.file(task)) == drawn_at_once(tmp_path, "render", CORNELL, *SMALL, "--spp", 90)


def test_a_worker_without_the_program_leaves_the_task_to_another(study, dask, tmp_path, capsys):
    description, programs = tiny_renderer(tmp_path)
    dask.start_worker()
    task = cluster.reference(CORNELL, description, ("--size", "24x24", "--spp", "4"), [1])
    with client_of(dask) as client:
        client.wait_for_workers(1, timeout=60)
        assert study.run([task], client) == [task]
        dask.start_worker(PATH=f"{programs}:{os.environ['PATH']}")
        client.wait_for_workers(2, timeout=60)
        assert study.run([task], client) == []
    assert f"has no {description}" in capsys.readouterr().err


def test_whoever_is_killed_the_bits_are_the_same(study, dask, tmp_path):
    chance = random.Random(20)
    for _ in range(2):
        dask.start_worker()
    task = cluster.render(CORNELL, 640, SMALL, 16)
    kills = sorted(chance.sample(range(2, 40), 5))
    victims = [chance.choice([0, 1]) for _ in kills]
    victims[chance.randrange(len(victims))] = None  # the scheduler

    def finish(self, *arguments, finish=cluster._Run.finish):
        finish(self, *arguments)
        if kills and self.total - len(self.todo) >= kills[0]:
            kills.pop(0)
            victim = victims.pop(0)
            dask.kill_scheduler() if victim is None else dask.kill_worker(victim)

    with client_of(dask) as client, pytest.MonkeyPatch.context() as patch:
        patch.setattr(cluster._Run, "finish", finish)
        assert study.run([task], client) == []
    assert not kills
    assert picture(study.file(task)) == drawn_at_once(tmp_path, "render", CORNELL, *SMALL, "--spp", 640)
