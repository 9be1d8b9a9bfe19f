# SPDX-License-Identifier: Apache-2.0

"""What may be relied on about images/exr.py: it reads what our pictures say of themselves."""

import pathlib
import re
import sys
import unittest

ROOT = pathlib.Path(__file__).resolve().parent.parent
sys.path.insert(0, str(ROOT / "images"))
import exr  # noqa: E402


class Provenance(unittest.TestCase):
    def setUp(self):
        source = (ROOT / "images" / "provenance.cpp").read_text("utf-8")
        self.names = re.findall(r'visit\("(\w+)"', source)

    def test_has_the_same_names_here_as_in_cpp(self):
        for name, value in vars(exr).items():
            if name.isupper():
                self.assertIn(value, self.names)

    def test_of_stored_pictures_is_read(self):
        drawn_by_hand = ROOT / "reference_scenes" / "closed_forms"
        for picture in (ROOT / "reference_scenes").rglob("*.exr"):
            if picture.is_relative_to(drawn_by_hand):
                continue
            found = exr.provenance(picture)
            self.assertLessEqual(set(found), set(self.names))
            self.assertEqual(len(found[exr.SCENE_HASH]), 40)
            self.assertGreater(found[exr.WALL_SECONDS], 0.0)
            self.assertIsInstance(found.get(exr.RUNS, []), list)


if __name__ == "__main__":
    unittest.main()
