# SPDX-License-Identifier: Apache-2.0

"""What may be relied on about the GitHub action: what its gate leaves behind.
Run as: action_test.py PLUMB"""

import os
import pathlib
import subprocess
import sys
import tempfile
import unittest

ROOT = pathlib.Path(__file__).resolve().parent.parent
SCENE = ROOT / "reference_scenes" / "stress" / "easy" / "room.xml"

GATE = """
[[compare]]
name = "room & <all>"
test = "test.exr"
reference = "reference.exr"
tolerance = "10%"
output = "report/room.png"
markdown = "report/room.md"
"""
COMPANION = """
[[compare]]
name = "must differ"
test = "test.exr"
reference = "reference.exr"
tolerance = "10%"
expect = "different"
"""


class Gate(unittest.TestCase):
    def setUp(self):
        self.temporary = tempfile.TemporaryDirectory()
        self.addCleanup(self.temporary.cleanup)
        self.folder = pathlib.Path(self.temporary.name)
        for name, seed in ("test", "2"), ("reference", "3"):
            subprocess.run([PLUMB, "render", SCENE, "--size", "32x32", "--spp", "256", "--seed", seed,
                            "-o", self.folder / f"{name}.exr"], check=True, stdout=subprocess.DEVNULL)

    def run_gate(self, text):
        """Its exit code and what it has written, by name."""
        (self.folder / "gate.toml").write_text(text, "utf-8")
        environment = {**os.environ, "PATH": f"{PLUMB.parent}:{os.environ['PATH']}",
                       "GITHUB_STEP_SUMMARY": str(self.folder / "summary.md")}
        result = subprocess.run([ROOT / ".github" / "gate.sh", "gate.toml", "report"], check=False,
                                cwd=self.folder, env=environment, stdout=subprocess.DEVNULL)
        files = [self.folder / "summary.md", *(self.folder / "report").iterdir()]
        return result.returncode, {file.name: file.read_text("utf-8") for file in files
                                   if file.suffix != ".png"}

    def test_leaves_a_summary_a_page_and_junits_file(self):
        code, files = self.run_gate(GATE)
        self.assertEqual(code, 0)
        self.assertIn("ok   room & <all>: same: the means differ by less", files["summary.md"])
        self.assertIn("| channel |", files["summary.md"])
        page = files["report.html"]
        self.assertIn("ok   room &amp; &lt;all>: same", page)
        self.assertIn("<summary>room</summary>", page)
        self.assertIn('src="data:image/png;base64,iVBOR', page)
        self.assertIn("<testsuite", files["results.xml"])

    def test_fails_as_the_gate_does(self):
        code, files = self.run_gate(GATE + COMPANION)
        self.assertEqual(code, 1)
        self.assertIn("FAIL must differ: same", files["summary.md"])
        self.assertEqual(self.run_gate("[[compare]]")[0], 2)


if __name__ == "__main__":
    PLUMB = pathlib.Path(sys.argv[1]).resolve()
    unittest.main(argv=sys.argv[:1])
