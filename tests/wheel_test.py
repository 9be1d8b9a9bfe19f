# SPDX-License-Identifier: Apache-2.0

"""What may be relied on about the wheel that `make wheel` makes: it takes nothing that it was built with from
the system. Run as: wheel_test.py WHEEL"""

import pathlib
import re
import subprocess
import sys
import tempfile
import unittest
import venv
import zipfile

# What a script may map beside the wheel: Python's own modules, NumPy, and what every Linux has.
EVERYWHERE = re.compile(r"/(lib(c|m|dl|rt|pthread|util|gcc_s|stdc\+\+|z|expat)|ld-linux[\w-]*)[.-]|/lib-dynload/|/numpy"
                        r"|/libpython|/libcrypto|/libssl|/libffi|/lib(bz2|lzma|mpdec|sqlite3|uuid)\.")
HDR = b"#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n-Y 1 +X 2\n" + bytes([128, 64, 32, 129, 0, 0, 0, 0])


class Wheel(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.temporary = tempfile.TemporaryDirectory()
        cls.folder = pathlib.Path(cls.temporary.name)
        venv.create(cls.folder / "venv", with_pip=True)
        cls.run_command("pip", "install", "--quiet", "--disable-pip-version-check", WHEEL)

    @classmethod
    def tearDownClass(cls):
        cls.temporary.cleanup()

    @classmethod
    def run_command(cls, name, *words):
        """What a command of the environment prints; it runs in a folder that knows nothing of this project."""
        result = subprocess.run([cls.folder / "venv" / "bin" / name, *words], cwd=cls.folder, text=True,
                                stdout=subprocess.PIPE, stderr=subprocess.STDOUT, check=False)
        if result.returncode != 0:
            raise AssertionError(f"{name} {words}: {result.returncode}\n{result.stdout}")
        return result.stdout

    def run_script(self, script):
        return self.run_command("python", "-c", f"import plumbline\n{script}")

    def test_renders_compares_and_stores(self):
        self.run_script("""
scene = plumbline.load(plumbline.SCENES / "cornell" / "scene.xml")
picture = plumbline.render(scene, spp=16, size=(32, 32))
picture.write("box.exr")
picture.write("box.png")
assert plumbline.compare(picture, "box.exr", tolerance=0).same
assert plumbline.read("box.png").radiance.shape == (32, 32, 3)
""")

    def test_reads_what_openimageio_does(self):
        (self.folder / "two.hdr").write_bytes(HDR)
        said = self.run_script("print(*plumbline.read('two.hdr').radiance.ravel().tolist())")
        self.assertEqual([float(word) for word in said.split()], [1.0, 0.5, 0.25, 0.0, 0.0, 0.0])

    def test_takes_no_library_of_the_systems_but_those_that_every_one_has(self):
        (self.folder / "maps.hdr").write_bytes(HDR)
        said = self.run_script("""
plumbline.read("maps.hdr")
print(*{line.split()[-1] for line in open("/proc/self/maps") if ".so" in line}, sep="\\n")
""")
        own = [file for file in said.split() if "/plumbline.libs/" in file]
        self.assertTrue(any("OpenImageIO" in file for file in own), said)
        others = [file for file in said.split() if "/site-packages/plumbline" not in file]
        self.assertEqual([file for file in others if not EVERYWHERE.search(file)], [])

    def test_has_the_command(self):
        scene = self.run_script("print(plumbline.SCENES / 'cornell' / 'scene.xml')").strip()
        self.run_command("plumb", "render", scene, "--spp", "4", "--size", "16x16", "-o", "command.png")
        self.assertIn("srgb, made linear", self.run_command("plumb", "compare", "command.png", "command.png"))

    def test_has_the_licences_of_what_is_inside(self):
        with zipfile.ZipFile(WHEEL) as wheel:
            names = wheel.namelist()
        licences = " ".join(name for name in names if "/licenses/" in name)
        for file in (name for name in names if name.startswith("plumbline.libs/lib")):
            library = re.match(r"lib([A-Za-z]+)", file.split("/")[1])[1]
            known = {"hwy": "libhwy", "Iex": "libopenexr", "IlmThread": "libopenexr", "Util": "OpenImageIO"}
            self.assertIn(known.get(library, library).lower(), licences.lower(), file)


if __name__ == "__main__":
    WHEEL = str(pathlib.Path(sys.argv[1]).resolve())
    unittest.main(argv=sys.argv[:1])
