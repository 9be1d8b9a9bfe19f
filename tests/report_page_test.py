# SPDX-License-Identifier: Apache-2.0

"""Drives the report's page in headless Chromium: python3 tests/report_page_test.py"""

import base64
import math
import pathlib
import shutil
import struct
import sys
import tempfile
import unittest
import zlib

sys.dont_write_bytecode = True  # nothing but sources in report/
sys.path.insert(0, str(pathlib.Path(__file__).resolve().parent.parent))
from report import page, sections  # noqa: E402

try:
    from selenium import webdriver
    from selenium.webdriver.chrome.service import Service
    from selenium.webdriver.common.action_chains import ActionChains
    from selenium.webdriver.common.actions.wheel_input import ScrollOrigin
    from selenium.webdriver.common.by import By
    from selenium.webdriver.common.keys import Keys
    from selenium.webdriver.support.ui import Select, WebDriverWait
except ImportError:
    webdriver = None

CHROMIUM, CHROMEDRIVER = shutil.which("chromium"), shutil.which("chromedriver")
WIDTH, HEIGHT = 32, 24
MARKER = (20, 10)  # a pixel that stands out in both pictures


def half(value):
    return struct.unpack("<e", struct.pack("<e", value))[0]


def decoded(text, planes):
    data = zlib.decompress(base64.b64decode(text))
    size = len(data) // planes
    halves = [data[i * size:(i + 1) * size] for i in range(planes)]
    mixed = [bytes(b for pair in zip(p[:size // 2], p[size // 2:]) for b in pair) for p in halves]
    return [list(struct.unpack(f"<{size // 2}e", plane)) for plane in mixed]


def srgb_byte(light):
    light = min(max(light, 0.0), 1.0)
    return 255 * (12.92 * light if light <= 0.0031308 else 1.055 * light ** (1 / 2.4) - 0.055)


def picture(title, colour, marker, noise):
    """One colour but for the marker, equally noisy everywhere."""
    planes = [[value] * (WIDTH * HEIGHT) for value in colour]
    for plane, value in zip(planes, marker):
        plane[MARKER[1] * WIDTH + MARKER[0]] = value
    errors = [[noise] * (WIDTH * HEIGHT)] * 3
    return {"id": title, "title": title, "width": WIDTH, "height": HEIGHT, "seconds": 1.5,
            "thumbnail": sections.thumbnail(planes, WIDTH),
            "values": page.encode_picture(planes), "command": f"plumb render {title}",
            "errors": page.encode_picture(errors) if noise else None,
            "card": {"seed": 7, "runs": [{"spp": 4}]}}


SVG = '''<svg xmlns="http://www.w3.org/2000/svg" xmlns:xlink="http://www.w3.org/1999/xlink" width="60" height="40">
<defs><path id="dot" d="M-2 -2h4v4h-4z"/></defs>
<g id="gnuplot_plot_1"><title>gnuplot_plot_1</title><text>mis</text><path stroke="rgb(1,2,3)" d="M0 9h50"/>
<use xlink:href="#dot" transform="translate(9,9)"/></g>
<g id="gnuplot_plot_2"><title>gnuplot_plot_2</title><path stroke="rgb(1,2,3)" d="M0 12h50"/></g>
<g id="gnuplot_plot_3"><title>gnuplot_plot_3</title><text y="30">nee</text><path stroke="rgb(9,2,3)" stroke-width="20" d="M0 30h50"/></g>
</svg>'''
A_COLOUR, B_COLOUR, NOISE = (0.1234, 0.0567, 0.01), (0.05, 0.1, 0.01), (0.01, 0.02)


def report():
    result = {"svg": SVG, "sentences": ["It falls."], "command": "plumb chart",
              "table": {"head": ["series", "p"], "rows": [["mis", "1.00"]]}}
    row = {"where": "image", "channel": "all", "test": 0.1, "reference": 0.1, "bias": 0.0123,
           "confidence": math.nan, "verdict": "different"}
    verdict = {"test": "bright", "reference": "dark", "verdict": "different", "program": "Other", "rows": [row],
               "explanation": "They differ.\n</script>", "command": "plumb compare"}
    first = [picture("bright", A_COLOUR, (0.9, 0, 0), NOISE[0]),
             picture("dark", B_COLOUR, (0, 0.9, 0), NOISE[1]),
             picture("noise unknown", (0.2, 0.2, 0.2), (0, 0, 0), None)]
    second = [picture("other", (0.5, 0.5, 0.5), (0, 0, 0), None)]
    scene = {"notes": ["It is <quick>."], "verdicts": [verdict], "convergence": result, "chart": result}
    return {"title": "A <report>", "made": "today", "host": "here", "version": "1", "notes": [],
            "incomplete": "",
            "summary": ["All is well."], "programs": ["Other", "Absent"], "scenes": [
                {"name": "first", "title": "First scene", "pictures": first, **scene},
                {"name": "second", "title": "Second scene", "pictures": second, "notes": [], "verdicts": [],
                 "convergence": None, "chart": None}]}


class EncodePicture(unittest.TestCase):
    def test_round_trip(self):
        planes = [[0, 1, -2.5, 0.1], [1e-7, 65504, 1e9, -1e9]]
        expected = [[half(max(min(v, 65504), -65504)) for v in plane] for plane in planes]
        self.assertEqual(decoded(page.encode_picture(planes), 2), expected)

    def test_fewer_bits_are_close_and_shorter(self):
        plane = [1e-3 * 1.01 ** i for i in range(1000)] + [65504]
        rounded = page.encode_picture([plane], 5)
        for value, kept in zip(plane, decoded(rounded, 1)[0]):
            self.assertLessEqual(abs(kept / value - 1), 1 / 62)
        self.assertLess(len(rounded), len(page.encode_picture([plane])))


@unittest.skipUnless(webdriver, "selenium is not installed (Debian: python3-selenium)")
@unittest.skipUnless(CHROMIUM and CHROMEDRIVER, "chromium and chromedriver are not installed")
class Page(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.folder = tempfile.TemporaryDirectory()
        cls.addClassCleanup(cls.folder.cleanup)
        cls.file = pathlib.Path(cls.folder.name) / "report.html"
        page.write_page(report(), cls.file)
        cls.driver = cls.start()

    @classmethod
    def start(cls, **preferences):
        options = webdriver.ChromeOptions()
        options.binary_location = CHROMIUM
        for argument in ("--headless=new", "--no-sandbox", "--disable-gpu", "--window-size=1000,1400"):
            options.add_argument(argument)
        options.add_experimental_option("prefs", preferences)
        options.set_capability("goog:loggingPrefs", {"browser": "ALL"})
        driver = webdriver.Chrome(service=Service(CHROMEDRIVER), options=options)
        cls.addClassCleanup(driver.quit)
        return driver

    def setUp(self):
        self.open_page()

    def open_page(self):
        self.driver.get("about:blank")  # or else only the fragment might change
        self.driver.get(self.file.as_uri())
        self.wait_for_page()

    def wait_for_page(self):
        WebDriverWait(self.driver, 20).until(
            lambda driver: driver.find_elements(By.CSS_SELECTOR, "body.ready, #trouble:not([hidden])"))

    def tearDown(self):
        self.assertEqual([m for m in self.driver.get_log("browser") if m["level"] == "SEVERE"], [])

    def find(self, selector):
        return self.driver.find_element(By.CSS_SELECTOR, ".scene:not([hidden]) " + selector)

    def mode(self, name):
        self.find(f"[value={name}]").click()

    def press(self, *keys):
        ActionChains(self.driver).send_keys(*keys).perform()

    def colour(self, x, y, pane="a"):
        """What the pane shows at the middle of a pixel of the whole picture."""
        script = """const [pane, u, v] = arguments, context = pane.getContext('2d');
            return [...context.getImageData(u * pane.width, v * pane.height, 1, 1).data].slice(0, 3);"""
        place = [(x + 0.5) / WIDTH, (y + 0.5) / HEIGHT]
        return self.driver.execute_script(script, self.find(f".pane-{pane}"), *place)

    def box_of_marker(self, pane):
        """Where the marker begins and ends, across and down."""
        script = """const {width, height} = arguments[0], found = [[], []];
            const {data} = arguments[0].getContext('2d').getImageData(0, 0, width, height);
            for (let i = 0; i < width * height; i++)
              if (Math.abs(data[4 * i] - data[4 * i + 1]) > 200)
                found[0].push(i % width), found[1].push(Math.floor(i / width));
            return found.map(all => [Math.min(...all), Math.max(...all)]);"""
        return self.driver.execute_script(script, self.find(f".pane-{pane}"))

    def point_at(self, x, y, pane="a"):
        canvas = self.find(f".pane-{pane}")
        right = round(((x + 0.5) / WIDTH - 0.5) * canvas.size["width"])
        down = round(((y + 0.5) / HEIGHT - 0.5) * canvas.size["height"])
        ActionChains(self.driver).move_to_element_with_offset(canvas, right, down).perform()

    def read_out(self):
        """Columns A, B, A − B; each R, G, B, mean, noise."""
        cells = self.driver.find_elements(By.CSS_SELECTOR, ".scene:not([hidden]) .readout td")
        texts = [cell.text.replace("−", "-") for cell in cells]
        return [texts[column::3] for column in range(3)]

    def assert_shows(self, colour, radiance, stops=0):
        for byte, light in zip(colour, radiance):
            self.assertAlmostEqual(byte, srgb_byte(light * 2 ** stops), delta=1.01)

    def test_opens_alone_and_is_complete(self):
        requests = "return performance.getEntriesByType('resource').map(entry => entry.name)"
        self.assertEqual(self.driver.execute_script(requests), [])
        self.assertEqual(self.driver.title, "A <report>")
        text = self.find(".verdicts").text
        for expected in ("different", "+1.230 %", "They differ.\n</script>", "plumb compare"):
            self.assertIn(expected, text)
        plots = self.driver.find_elements(By.CSS_SELECTOR, ".scene:not([hidden]) svg.plot")
        self.assertEqual([plot.get_attribute("aria-label") for plot in plots],
                         ["Convergence: It falls.", "Speed against accuracy: It falls."])
        self.assertFalse(self.driver.find_element(By.ID, "trouble").is_displayed())

    def test_begins_with_the_chart_and_who_agrees(self):
        front = self.driver.find_element(By.CSS_SELECTOR, ".front")
        self.assertEqual(len(front.find_elements(By.CSS_SELECTOR, "svg.plot")), 1)
        rows = [[cell.text for cell in row.find_elements(By.CSS_SELECTOR, "th, td")]
                for row in front.find_elements(By.TAG_NAME, "tr")]
        self.assertEqual(rows, [["Scene", "Other"], ["First scene", "different +1.230 %"], ["Second scene", ""]])
        front.find_element(By.LINK_TEXT, "Second scene").click()
        self.assertEqual(self.find("h2").text, "Second scene")

    def test_plots_tell_one_series_from_the_others(self):
        groups = self.driver.find_elements(By.CSS_SELECTOR, ".front g[data-series]")
        titles = [group.find_element(By.TAG_NAME, "title").get_attribute("textContent") for group in groups]
        self.assertEqual(titles, ["mis", "mis", "nee"])
        ids = self.driver.execute_script("return [...document.querySelectorAll('svg [id]')].map(one => one.id)")
        self.assertEqual(len(set(ids)), len(ids))

        def opacities():
            return [round(float(group.value_of_css_property("opacity")), 2) for group in groups]
        ActionChains(self.driver).move_to_element(groups[2]).perform()
        WebDriverWait(self.driver, 5).until(lambda _: opacities() == [0.12, 0.12, 1])
        ActionChains(self.driver).move_to_element(self.driver.find_element(By.TAG_NAME, "h1")).perform()
        WebDriverWait(self.driver, 5).until(lambda _: opacities() == [1, 1, 1])

    def test_side_by_side_and_swap(self):
        self.assert_shows(self.colour(3, 3, "a"), A_COLOUR)
        self.assert_shows(self.colour(3, 3, "b"), B_COLOUR)
        self.mode("swap")
        for key, shown in (("x", B_COLOUR), ("x", A_COLOUR), (" ", B_COLOUR), (" ", A_COLOUR)):
            self.press(key)
            self.assert_shows(self.colour(3, 3), shown)

    def test_exposure_doubles_radiance_per_stop(self):
        self.find("[name=exposure]").send_keys(Keys.ARROW_RIGHT * 15)
        self.assertEqual(self.find("[name=stops]").text, "+1.5 stops")
        self.assert_shows(self.colour(3, 3), A_COLOUR, 1.5)
        self.find("[name=expose]").click()
        self.assert_shows(self.colour(3, 3), A_COLOUR)

    def test_read_out(self):
        self.point_at(5, 7, "b")
        self.assertIn("x 5, y 7 ", self.find(".where").text)
        columns = self.read_out()
        for column, colour, noise in zip(columns, (A_COLOUR, B_COLOUR), NOISE):
            for text, value in zip(column, (*colour, sum(colour) / 3, noise)):
                self.assertAlmostEqual(float(text), value, delta=value * 2 ** -10)
        self.assertAlmostEqual(float(columns[2][0]), half(A_COLOUR[0]) - half(B_COLOUR[0]), delta=1e-5)
        self.point_at(*MARKER)
        self.assertAlmostEqual(float(self.read_out()[0][0]), half(0.9), delta=1e-4)

    def test_split_follows_slider_and_pointer(self):
        self.mode("split")
        self.assert_shows(self.colour(8, 3), A_COLOUR)
        self.assert_shows(self.colour(24, 3), B_COLOUR)
        self.find("[name=split]").send_keys(Keys.END)
        self.assert_shows(self.colour(24, 3), A_COLOUR)
        self.find("[name=split]").send_keys(Keys.HOME)
        self.assert_shows(self.colour(8, 3), B_COLOUR)
        canvas = self.find(".pane-a")
        half_width = canvas.size["width"] // 2
        ActionChains(self.driver).move_to_element_with_offset(canvas, 3 - half_width, 0).click_and_hold() \
            .move_to_element_with_offset(canvas, half_width // 2, 0).release().perform()
        self.assertAlmostEqual(float(self.find("[name=split]").get_property("value")), 0.75, delta=0.01)

    def test_difference_is_red_where_a_is_brighter(self):
        self.mode("difference")
        for channel, brightest in (("R", 0), ("G", 2), ("B", None)):
            Select(self.find("[name=channel]")).select_by_visible_text(channel)
            colour = self.colour(3, 3)
            self.assertEqual(colour == [255] * 3, brightest is None, f"{channel}: {colour}")
            if brightest is not None:
                self.assertEqual(max(range(3), key=lambda c: colour[c]), brightest, f"{channel}: {colour}")

    def test_z_and_blocks(self):
        difference = sum(half(a) - half(b) for a, b in zip(A_COLOUR, B_COLOUR)) / 3
        z = difference / math.hypot(*map(half, NOISE))
        self.mode("z")
        self.point_at(3, 3)
        for name, expected in ((r"· z ", z), (r"block ", 8 * z)):
            text = self.find(".where").text.replace("−", "-").split(name)[1].split(" ")[0]
            self.assertAlmostEqual(float(text), expected, delta=abs(expected) * 5e-3)
        shown = self.colour(6, 20)
        self.mode("block")
        self.assertEqual(self.find(".where").is_displayed(), True)
        self.assertGreater(shown[0], shown[2])  # A is brighter on average, hence red

    def test_unknown_noise_is_said(self):
        for select in "ab":
            Select(self.find(f"[name={select}]")).select_by_index(2)
        self.mode("z")
        self.assertIn("noise of neither picture is known", self.find(".message").text)
        self.assertFalse(self.find(".stage").is_displayed())
        self.mode("side")
        self.assert_shows(self.colour(3, 3), [0.2] * 3)

    def test_both_panes_zoom_and_pan_together(self):
        before = self.box_of_marker("a")
        canvas = self.find(".pane-a")
        self.point_at(*MARKER)
        origin = ScrollOrigin.from_element(canvas, 30, -20)
        ActionChains(self.driver).scroll_from_origin(origin, 0, -400).perform()
        zoomed = self.box_of_marker("a")
        self.assertGreater(zoomed[0][1] - zoomed[0][0], 2 * (before[0][1] - before[0][0]))
        self.assertEqual(zoomed, self.box_of_marker("b"))
        ActionChains(self.driver).drag_and_drop_by_offset(canvas, 40, 25).perform()
        panned = self.box_of_marker("b")
        self.assertEqual([panned[0][0] - zoomed[0][0], panned[1][0] - zoomed[1][0]], [40, 25])
        self.assertEqual(panned, self.box_of_marker("a"))
        self.press("0")
        self.assertEqual(self.find("[name=factor]").text, "1×")

    def test_scenes_switch(self):
        self.driver.find_element(By.ID, "tab-second").click()
        self.assertEqual(self.find("h2").text, "Second scene")
        self.assert_shows(self.colour(3, 3), [0.5] * 3)
        self.driver.back()
        self.assertEqual(self.find("h2").text, "First scene")

    def test_scenes_are_tabs_that_keys_choose_and_the_address_names(self):
        def tabs(name):
            return [tab.get_attribute(name) for tab in self.driver.find_elements(By.CSS_SELECTOR, "[role=tab]")]
        self.assertEqual(tabs("aria-selected"), ["true", "false"])
        for tab, scene in zip(tabs("aria-controls"), ("First scene", "Second scene")):
            panel = self.driver.find_element(By.ID, tab)
            self.assertEqual(panel.get_attribute("role"), "tabpanel")
            self.assertEqual(self.driver.find_element(By.ID, panel.get_attribute("aria-labelledby")).text, scene)
        self.driver.find_element(By.ID, "tab-first").send_keys(Keys.ARROW_RIGHT)
        self.assertEqual(self.find("h2").text, "Second scene")
        self.assertEqual(self.driver.switch_to.active_element.text, "Second scene")
        self.assertEqual(tabs("aria-selected"), ["false", "true"])
        self.assertTrue(self.driver.current_url.endswith("#second"))
        self.driver.refresh()
        self.wait_for_page()
        self.assertEqual(self.find("h2").text, "Second scene")
        self.driver.find_element(By.ID, "tab-second").send_keys(Keys.HOME)
        self.assertEqual(self.find("h2").text, "First scene")

    def test_without_a_script_all_scenes_are_one_page(self):
        driver = self.start(**{"profile.managed_default_content_settings.javascript": 2})
        driver.get(self.file.as_uri())
        self.assertEqual([one.text for one in driver.find_elements(By.CSS_SELECTOR, "main h2")],
                         ["First scene", "Second scene"])
        text = driver.find_element(By.TAG_NAME, "main").text
        for said in ("It is <quick>.", "+1.230 %", "They differ.", "plumb compare", "It falls.", "noise unknown, 1.5"):
            self.assertIn(said, text)
        for picture in driver.find_elements(By.CSS_SELECTOR, ".pictures img"):
            self.assertTrue(picture.is_displayed())
            self.assertEqual(picture.get_property("naturalWidth"), WIDTH // 2)
        self.assertTrue(driver.find_element(By.CSS_SELECTOR, "noscript .trouble").is_displayed())

    def test_on_paper_everything_is_open(self):
        def shown(selector):
            found = self.driver.find_elements(By.CSS_SELECTOR, selector)
            return [one.is_displayed() for one in found]

        self.mode("swap")
        self.assertEqual(shown(".scene"), [True, False])
        self.driver.execute_script("dispatchEvent(new Event('beforeprint'))")
        self.assertEqual(shown(".scene"), [True, True])
        self.assertEqual(shown("canvas.pane-b"), [True, True])
        self.assertEqual(set(shown("details:not(.list, .list *) > dl, details > .wide")), {True})
        self.driver.execute_script("dispatchEvent(new Event('afterprint'))")
        self.assertEqual(shown(".scene"), [True, False])
        self.assertTrue(self.find("[value=swap]").is_selected())
        self.assertEqual(set(shown("details > .wide")), {False})

    def test_old_browsers_get_a_sentence(self):
        command = "Page.addScriptToEvaluateOnNewDocument"
        script = {"source": "delete window.DecompressionStream"}
        script = self.driver.execute_cdp_cmd(command, script)
        self.open_page()
        self.driver.execute_cdp_cmd("Page.removeScriptToEvaluateOnNewDocument", script)
        self.assertIn("cannot unpack", self.driver.find_element(By.ID, "trouble").text)


if __name__ == "__main__":
    unittest.main(verbosity=2)  # says why tests are skipped
