# SPDX-License-Identifier: Apache-2.0

"""What may be relied on about the report: what is rendered once is kept, programs that are missing
are stood in for, and an interrupt loses nothing. Run as: make_report_test.py PLUMB"""

import base64
import copy
import os
import pathlib
import re
import shutil
import signal
import struct
import subprocess
import sys
import tempfile
import time
import unittest
import zlib
from unittest import mock

ROOT = pathlib.Path(__file__).resolve().parent.parent
sys.path.insert(0, str(ROOT / "report"))
import make_report  # noqa: E402


def keep_pages(test):
    """What each page of the test holds, in a list that grows."""
    pages = []

    def keep(data, file):
        write(data, file)
        pages.append(copy.deepcopy(data))
    write = make_report.page.write_page
    patch = mock.patch.object(make_report.page, "write_page", keep)
    patch.start()
    test(patch.stop)
    return pages


def table(installed):
    return [{"word": word, "name": name, "isInstalled": word in installed,
             "hasSamples": word != "povray", "with": word}
            for word, name in (("cycles", "Cycles"), ("mitsuba", "Mitsuba"), ("povray", "POV-Ray"))]


class ReportWithoutOtherPrograms(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.folder = tempfile.TemporaryDirectory()
        cls.plan = make_report.Plan(out=pathlib.Path(cls.folder.name), scenes=("cornell",),
                                    methods="mis", samplers="sobol", last=16, runs=2,
                                    best=64, errors=("0.1%",))
        make_report.other_renderers = lambda *_: table([])
        pages = keep_pages(cls.addClassCleanup)
        cls.file, cls.lines = make_report.make(PLUMB, cls.plan)
        cls.data = pages[-1]
        cls.scene = cls.data["scenes"][0]

    @classmethod
    def tearDownClass(cls):
        cls.folder.cleanup()

    def test_says_what_is_missing_and_shows_what_is_stored(self):
        notes = " ".join(self.data["notes"])
        for program in ("Cycles", "POV-Ray", "Mitsuba"):
            self.assertIn(f"{program} is not installed", notes)
        titles = [picture["title"] for picture in self.scene["pictures"]]
        self.assertEqual(titles, ["Plumbline, rendered here", "Plumbline, stored", "Cycles, stored",
                                  "POV-Ray, stored", "Radiosity, computed here"])

    def test_stored_programs_agree(self):
        verdicts = {(v["test"], v["reference"]): v["verdict"] for v in self.scene["verdicts"]}
        self.assertEqual(verdicts["Plumbline, stored", "Cycles, stored"], "same")
        self.assertEqual(len(self.lines), len(verdicts))
        self.assertEqual(sorted(self.data["programs"]), ["Cycles", "Mitsuba", "POV-Ray", "Radiosity"])
        self.assertEqual({v["program"] for v in self.scene["verdicts"]}, {"Cycles", "POV-Ray", "Radiosity"})

    def test_radiosity_agrees_and_is_in_the_chart(self):
        verdicts = {v["reference"]: v["verdict"] for v in self.scene["verdicts"]}
        self.assertEqual(verdicts["Radiosity, computed here"], "same")
        self.assertIn("plumbline radiosity", self.scene["chart"]["svg"])

    def test_says_of_a_picture_without_samples_that_it_has_a_floor(self):
        for verdict in self.scene["verdicts"]:
            says = verdict["program"] == "POV-Ray" and verdict["verdict"] == "different"
            self.assertEqual("it has a floor" in verdict["explanation"], says)

    def test_plots_have_each_series(self):
        for kind in ("convergence", "chart"):
            self.assertIn("plumbline mis sobol bounces 0:5", self.scene[kind]["svg"])
            self.assertTrue(self.scene[kind]["table"]["rows"])

    def test_pictures_hold_what_the_files_hold(self):
        stored = self.scene["pictures"][2]
        halves = zlib.decompress(base64.b64decode(stored["values"]))
        low, high = halves[:65536], halves[65536:131072]  # of red
        pixel = 128 * 256 + 128
        red = struct.unpack("<e", bytes([low[pixel], high[pixel]]))[0]
        answer = subprocess.run(
            ["oiiotool", ROOT / "reference_scenes/cornell/cycles.exr", "--cut", "1x1+128+128",
             "--printstats"], capture_output=True, text=True, check=True).stdout
        average = float(re.search(r"Stats Avg: *([0-9.]+)", answer)[1])
        self.assertAlmostEqual(red, average, delta=average / 1024)

    def test_keeps_what_is_rendered(self):
        def times():
            kept = (self.plan.out / "report" / "cornell").rglob("*.exr")
            return {file: file.stat().st_mtime_ns for file in kept if file.name != "1spp.exr"}
        before = times()
        self.assertEqual(len(before), 22)
        make_report.make(PLUMB, self.plan)
        self.assertEqual(times(), before)

    def test_renders_anew_what_is_of_another_scene(self):
        file = self.plan.out / "report" / "cornell" / "best" / "64spp.exr"
        subprocess.run(["oiiotool", file, "--attrib", "plumbline:sceneHash", "another", "-o", file],
                       check=True)
        make_report.make(PLUMB, self.plan)
        self.assertNotEqual(make_report.exr.provenance(file)[make_report.exr.SCENE_HASH], "another")


# In place of a program, which is perhaps not installed and not quick.
def draw_stored(report, program, name, *_):
    file = report.folder / f"{name}.exr"
    report.commands[file] = f"plumb reference --with {program}"
    report.drawn.append(name)
    shutil.copy(report.stored[program], file)
    return file


class ReportInStages(unittest.TestCase):
    def setUp(self):
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.plan = make_report.Plan(
            out=pathlib.Path(folder.name), scenes=("cornell",), methods="mis", samplers="sobol",
            last=4, runs=2, best=16, samples=(4, 16), errors=("1%",))
        self.pages = keep_pages(self.addCleanup)
        for patch in (
                mock.patch.object(make_report, "other_renderers",
                                  lambda *_: table(["cycles", "povray"])),
                mock.patch.object(make_report.SceneReport, "drawn", [], create=True)):
            patch.start()
            self.addCleanup(patch.stop)

    def make(self, reference):
        with mock.patch.object(make_report.SceneReport, "drawn_by", reference):
            make_report.make(PLUMB, self.plan)

    @staticmethod
    def titles(data):
        return [picture["title"] for picture in data["scenes"][0]["pictures"]]

    def test_the_page_grows_and_says_what_is_missing(self):
        self.make(draw_stored)
        first, plots, radiosity, cycles, povray = self.pages
        self.assertIn("Still being rendered: the plots, Radiosity, Cycles, POV-Ray.", first["incomplete"])
        self.assertIsNone(first["scenes"][0]["chart"])
        self.assertEqual(self.titles(first), ["Plumbline, rendered here", "Plumbline, stored",
                                              "Cycles, stored", "POV-Ray, stored"])
        self.assertEqual(len(first["scenes"][0]["verdicts"]), 3)
        self.assertIn("Still being rendered: Radiosity, Cycles, POV-Ray.", plots["incomplete"])
        self.assertIn("plumbline mis sobol", plots["scenes"][0]["chart"]["svg"])
        self.assertIn("Still being rendered: Cycles, POV-Ray.", radiosity["incomplete"])
        self.assertIn("Radiosity, computed here", self.titles(radiosity))
        self.assertIn("Still being rendered: POV-Ray.", cycles["incomplete"])
        self.assertIn("Cycles, rendered here", self.titles(cycles))
        self.assertEqual(povray["incomplete"], "")
        self.assertEqual(self.titles(povray)[-2:],
                         ["Cycles, rendered here", "POV-Ray, rendered here"])
        self.assertEqual(len(povray["scenes"][0]["verdicts"]), 6)
        drawn = make_report.SceneReport.drawn
        self.assertEqual(len([name for name in drawn if "cycles" in name]), 4)
        self.assertEqual([name for name in drawn if "povray" in name],  # has no seeds
                         ["povray-draft", "povray-good"])

    def test_an_interrupt_leaves_a_page_that_says_so(self):
        def interrupted(report, program, *arguments):
            if program == "povray":
                raise KeyboardInterrupt
            return draw_stored(report, program, *arguments)
        with self.assertRaises(KeyboardInterrupt):
            self.make(interrupted)
        last = self.pages[-1]
        self.assertIn("Rendering ended before POV-Ray.", last["incomplete"])
        self.assertIn("Cycles, rendered here", self.titles(last))


class ReportOfAllScenes(unittest.TestCase):
    def test_shows_every_scene_that_has_a_folder_of_its_own(self):
        scenes = make_report.all_scenes()
        self.assertEqual(scenes[:2], ("cornell", "seed"))
        self.assertLessEqual({"spheres", "metals"}, set(scenes))
        self.assertFalse({"stress", "findings"} & set(scenes))

    def test_a_scene_without_stored_pictures_is_held_against_what_is_drawn_here(self):
        def draw(report, program, name, *_):
            if program == "povray":
                raise make_report.Trouble("it has no glass")
            return report.rendered(program, report.folder / f"{name}.exr", "render", report.scene,
                                   "--method", "bsdf", "--spp", 4, "--seed", int(name.split("seed")[1]))

        with tempfile.TemporaryDirectory() as folder:
            scenes = pathlib.Path(folder) / "scenes"
            (scenes / "glass_room").mkdir(parents=True)
            shutil.copy(ROOT / "reference_scenes" / "spheres" / "scene.xml", scenes / "glass_room")
            pages = keep_pages(self.addCleanup)
            with mock.patch.object(make_report, "SCENES", scenes), \
                    mock.patch.object(make_report, "other_renderers", lambda *_: table(["cycles", "povray"])), \
                    mock.patch.object(make_report.SceneReport, "drawn_by", draw):
                make_report.make(PLUMB, make_report.Plan(out=pathlib.Path(folder), scenes=("glass_room",),
                                                         methods="mis", best=16, last=4, runs=2))
        self.assertIn("Radiosity is for scenes of matte polygons", " ".join(pages[-1]["scenes"][0]["notes"]))
        scene = pages[-1]["scenes"][0]
        self.assertEqual(scene["title"], "Glass room")
        self.assertEqual([picture["title"] for picture in scene["pictures"]],
                         ["Plumbline, rendered here", "Cycles, rendered here"])
        self.assertEqual([(v["test"], v["reference"]) for v in scene["verdicts"]],
                         [("Cycles, rendered here", "Plumbline, rendered here")])
        for plot in ("convergence", "chart"):
            self.assertIn("plumbline mis sobol", scene[plot]["svg"])
        notes = " ".join(scene["notes"])
        for said in ("fewer samples than Cornell box and Seed scene", "No reference", "POV-Ray did not draw this scene"):
            self.assertIn(said, notes)

    def test_light_that_chance_never_meets_is_not_asked_of_it(self):
        with tempfile.TemporaryDirectory() as folder:
            pages = keep_pages(self.addCleanup)
            with mock.patch.object(make_report, "other_renderers", lambda *_: table([])):
                make_report.make(PLUMB, make_report.Plan(out=pathlib.Path(folder), scenes=("shadows",),
                                                         methods="bsdf,mis", best=16, last=4, runs=2))
        plot = pages[-1]["scenes"][0]["convergence"]["svg"]
        self.assertIn("plumbline mis sobol", plot)
        self.assertNotIn("bsdf", plot)


class InterruptedReport(unittest.TestCase):
    def test_ends_as_interrupted_and_keeps_what_is_finished(self):
        script = ("import sys, pathlib; sys.path.insert(0, 'report'); import make_report as m; "
                  "m.other_renderers = lambda *_: []; "
                  f"plan = m.Plan(out=pathlib.Path(sys.argv[1]), best=64); m.make({PLUMB!r}, plan)")
        with tempfile.TemporaryDirectory() as folder:
            kept = pathlib.Path(folder) / "report" / "cornell" / "whole"
            process = subprocess.Popen([sys.executable, "-c", script, folder], cwd=ROOT,
                                       stdout=subprocess.DEVNULL, stderr=subprocess.PIPE,
                                       start_new_session=True)
            deadline = time.monotonic() + 60
            while not list(kept.glob("*.exr")) and time.monotonic() < deadline:
                time.sleep(0.05)
            os.killpg(process.pid, signal.SIGINT)
            process.communicate(timeout=60)
            self.assertNotEqual(process.returncode, 0)
            self.assertTrue(list(kept.glob("*.exr")))
            self.assertFalse(list(kept.glob("*.part")))
            page = (pathlib.Path(folder) / "report.html").read_text("utf-8")
            self.assertIn("Rendering ended before the plots", page)


if __name__ == "__main__":
    PLUMB = str(pathlib.Path(sys.argv.pop(1)).resolve())
    unittest.main()
