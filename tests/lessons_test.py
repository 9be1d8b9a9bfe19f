# SPDX-License-Identifier: Apache-2.0

"""Reads the lessons, and drives their pages in headless Chromium: python3 tests/lessons_test.py

The pages are made with the core that 'make lessons' builds, build-web/plumbline.wasm.
"""

import importlib.util
import json
import pathlib
import re
import shutil
import subprocess
import sys
import tempfile
import unittest
import xml.etree.ElementTree

sys.dont_write_bytecode = True  # nothing but sources in web/
ROOT = pathlib.Path(__file__).resolve().parent.parent
sys.path.insert(0, str(ROOT / "web"))
import make_lessons  # noqa: E402

try:
    from selenium import webdriver
    from selenium.webdriver.chrome.service import Service
    from selenium.webdriver.common.by import By
    from selenium.webdriver.common.keys import Keys
    from selenium.webdriver.support.ui import WebDriverWait
except ImportError:
    webdriver = None

CHROMIUM, CHROMEDRIVER = shutil.which("chromium"), shutil.which("chromedriver")
CORE = ROOT / "build-web" / "plumbline.wasm"
LESSONS = sorted(file for file in make_lessons.LESSONS.glob("*.md") if file.name != "README.md")
FIGURES = [(file, live) for file in LESSONS
           for live in make_lessons.live_figures(file.read_text("utf-8"))]
FAULTS = re.findall(r"^\| `([\w-]+)`", (ROOT / "docs" / "faults.md").read_text("utf-8"), re.MULTILINE)


def all_settings(live):
    """Those of a figure, of its pictures and of its controls' values."""
    yield live.get("settings", {})
    yield from live["pictures"].values()
    for control in live.get("controls", []):
        yield from control["values"].values()


class Lessons(unittest.TestCase):
    def test_the_index_lists_all(self):
        self.assertEqual(sorted(make_lessons.order()), LESSONS)

    def test_each_has_a_live_figure_and_a_task_with_its_answer(self):
        for file in LESSONS:
            with self.subTest(file.name):
                text = file.read_text("utf-8")
                self.assertIn(file, [figure[0] for figure in FIGURES])
                self.assertEqual(text.count("<!-- live:"), len(make_lessons.live_figures(text)))
                self.assertRegex(text, r"(?s)## Task\n.*<details>\n<summary>Answer</summary>\n\n.*</details>")

    def test_links_and_pictures_exist(self):
        for file in make_lessons.LESSONS.glob("*.md"):
            for target in re.findall(r"\]\(([^)]+)\)", file.read_text("utf-8")):
                with self.subTest(f"{file.name}: {target}"):
                    self.assertTrue((file.parent / target).is_file())

    def test_live_figures_name_what_exists(self):
        known = {"method": {"bsdf", "nee", "mis"}, "sampler": {"independent", "sobol"}, "fault": set(FAULTS)}
        for file, live in FIGURES:
            scene = make_lessons.scene_file(live["scene"])
            self.assertTrue(scene.is_file(), scene)
            nodes = xml.etree.ElementTree.parse(scene)
            defaults = {node.get("name") for node in nodes.iter("default")}
            shapes = {node.get("id") for node in nodes.iter("shape")}
            for settings in all_settings(live):
                with self.subTest(f"{file.name}: {settings}"):
                    self.assertLessEqual(set(settings), {*known, "first", "last", "light", "parameters"})
                    for name in set(settings) & set(known):
                        self.assertIn(settings[name], known[name])
                    self.assertLessEqual(set(settings.get("parameters", {})), defaults)
                    light = settings.get("light") or {"way": "by", "ids": []}
                    self.assertIn(light["way"], {"by", "from"})
                    self.assertLessEqual(set(light["ids"]), shapes)
            for control in live.get("controls", []):
                self.assertIn(control["start"], control["values"])
            self.assertIn(live.get("against", next(iter(live["pictures"]))), live["pictures"])

    def test_an_error_has_a_picture_that_it_is_held_against(self):
        for file, live in FIGURES:
            if live.get("curve") == "error" or live.get("share"):
                with self.subTest(f"{file.name}: {live['scene']}"):
                    scene = make_lessons.scene_file(live["scene"])
                    stored = scene.with_suffix(".exr"), scene.with_name("plumbline.exr")
                    self.assertTrue(any(picture.is_file() for picture in stored))


@unittest.skipUnless(webdriver, "selenium is not installed (Debian: python3-selenium)")
@unittest.skipUnless(CHROMIUM and CHROMEDRIVER, "chromium and chromedriver are not installed")
@unittest.skipUnless(importlib.util.find_spec("markdown"), "Debian's python3-markdown is not installed")
@unittest.skipUnless(shutil.which("esbuild"), "esbuild is not installed")
class Pages(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        if not CORE.is_file():
            raise unittest.SkipTest("'make lessons' has not built the core")
        folder = tempfile.TemporaryDirectory()
        cls.addClassCleanup(folder.cleanup)
        cls.folder = pathlib.Path(folder.name) / "lessons"
        subprocess.run([sys.executable, ROOT / "web" / "make_lessons.py", CORE, cls.folder], check=True,
                       stdout=subprocess.DEVNULL)
        cls.driver = cls.start()

    @classmethod
    def start(cls, **preferences):
        options = webdriver.ChromeOptions()
        options.binary_location = CHROMIUM
        for argument in ("--headless=new", "--no-sandbox", "--disable-gpu", "--window-size=1000,1400"):
            options.add_argument(argument)
        options.add_experimental_option("prefs", preferences)
        options.set_capability("goog:loggingPrefs", {"browser": "ALL", "performance": "ALL"})
        driver = webdriver.Chrome(service=Service(CHROMEDRIVER), options=options)
        cls.addClassCleanup(driver.quit)
        return driver

    def open(self, file, driver=None):
        (driver or self.driver).get((self.folder / f"{file.stem}.html").as_uri())

    def figures(self, driver=None):
        return (driver or self.driver).find_elements(By.CSS_SELECTOR, "figure.live")

    def wait(self, condition):
        WebDriverWait(self.driver, 60).until(lambda _: condition())

    def draw(self, figure):
        """Looks at a figure until it has drawn."""
        self.driver.execute_script("arguments[0].scrollIntoView({block: 'center'})", figure)
        self.wait(lambda: figure.get_attribute("data-samples"))

    def tearDown(self):
        self.assertEqual([m for m in self.driver.get_log("browser") if m["level"] == "SEVERE"], [])

    def test_figures_draw_from_the_disk_and_ask_for_nothing_else(self):
        for file in LESSONS:
            with self.subTest(file.name):
                self.open(file)
                for figure in self.figures():
                    self.draw(figure)
                    self.assertFalse(figure.find_element(By.TAG_NAME, "img").is_displayed())
                    colours = self.driver.execute_script(
                        "const {width, height} = arguments[0], context = arguments[0].getContext('2d');"
                        "return new Set(context.getImageData(0, 0, width, height).data).size;",
                        figure.find_element(By.TAG_NAME, "canvas"))
                    self.assertGreater(colours, 16)
        asked = [json.loads(entry["message"])["message"] for entry in self.driver.get_log("performance")]
        for message in asked:
            if message["method"] == "Network.requestWillBeSent":
                address = message["params"]["request"]["url"]
                self.assertTrue(address.startswith((self.folder.as_uri(), "blob:", "data:")), address)

    def move_first_slider(self, figure, title):
        """To its start, where it says `title`, and another picture is drawn."""
        shown = "return arguments[0].querySelector('canvas').toDataURL()"
        before = self.driver.execute_script(shown, figure)
        figure.find_element(By.CSS_SELECTOR, "input[type=range]").send_keys(Keys.HOME)
        self.wait(lambda: figure.find_element(By.TAG_NAME, "output").text == title)
        self.wait(lambda: self.driver.execute_script(shown, figure) != before)

    def test_controls_change_the_picture(self):
        for file in LESSONS:
            for number, live in enumerate(make_lessons.live_figures(file.read_text("utf-8"))):
                first = next(iter(live.get("controls", [])), {})
                if first.get("isSlider"):
                    with self.subTest(f"{file.name}, figure {number + 1}"):
                        self.open(file)
                        figure = self.figures()[number]
                        self.draw(figure)
                        self.move_first_slider(figure, next(iter(first["values"])))

    def test_answers_unfold_for_print(self):
        self.open(LESSONS[0])
        answer = self.driver.find_element(By.TAG_NAME, "details")
        self.assertIsNone(answer.get_attribute("open"))
        self.driver.execute_script("window.dispatchEvent(new Event('beforeprint'))")
        self.assertIsNotNone(answer.get_attribute("open"))

    def test_without_scripts_there_are_pictures(self):
        driver = self.start(**{"profile.managed_default_content_settings.javascript": 2})
        for file in LESSONS:
            with self.subTest(file.name):
                self.open(file, driver)
                for figure in self.figures(driver):
                    picture = figure.find_element(By.TAG_NAME, "img")
                    self.assertTrue(picture.is_displayed())
                    self.assertGreater(picture.size["height"], 100)


if __name__ == "__main__":
    unittest.main()
