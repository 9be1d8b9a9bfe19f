# SPDX-License-Identifier: Apache-2.0

"""What may be relied on about an installation: a stranger builds against it, and `plumb` finds its
scenes, wherever the folder has been moved to. Run as: install_test.py CMAKE BUILD COMPILER"""

import pathlib
import subprocess
import sys
import tempfile
import unittest

ROOT = pathlib.Path(__file__).resolve().parent.parent


class Installation(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.temporary = tempfile.TemporaryDirectory()
        cls.folder = pathlib.Path(cls.temporary.name)
        first, cls.prefix = cls.folder / "first", cls.folder / "moved"
        cls.run_command(CMAKE, "--install", BUILD, "--prefix", first)
        first.rename(cls.prefix)
        cls.scenes = cls.prefix / "share" / "plumbline"

    @classmethod
    def tearDownClass(cls):
        cls.temporary.cleanup()

    @classmethod
    def run_command(cls, *command, accept=(0,)):
        """What the command prints; it runs in a folder that knows nothing of this project."""
        result = subprocess.run([str(word) for word in command], cwd=cls.folder, text=True,
                                stdout=subprocess.PIPE, stderr=subprocess.STDOUT, check=False)
        if result.returncode not in accept:
            raise AssertionError(f"{command}: {result.returncode}\n{result.stdout}")
        return result.stdout

    def test_can_be_built_against(self):
        build = self.folder / "build"
        self.run_command(CMAKE, "-S", ROOT / "tests" / "install", "-B", build,
                         f"-DCMAKE_CXX_COMPILER={COMPILER}", f"-DCMAKE_PREFIX_PATH={self.prefix}")
        self.run_command(CMAKE, "--build", build)
        said = self.run_command(build / "stranger", self.scenes / "stress" / "easy" / "room.xml")
        self.assertIn("Would have been found", said)

    def test_tests_pictures(self):
        plumb, build = self.prefix / "bin" / "plumb", self.folder / "pictures"
        scene = self.scenes / "stress" / "easy" / "room.xml"
        files = {"SCENE": scene, "REFERENCE": self.folder / "reference.exr",
                 "MASK": self.folder / "mask.png"}
        self.run_command(plumb, "render", scene, "--spp", "1024", "--size", "32x32",
                         "-o", files["REFERENCE"])
        self.run_command(plumb, "render", scene, "--aov", "object", "--size", "32x32",
                         "-o", files["MASK"])
        self.run_command(CMAKE, "-S", ROOT / "tests" / "install" / "pictures", "-B", build,
                         f"-DCMAKE_PREFIX_PATH={self.prefix}",
                         *(f"-D{name}={file}" for name, file in files.items()))
        for test, words in {"holds": "100% tests passed", "companion": "100% tests passed",
                            "unlike": "unlike: different (expected: same)",
                            "noisy": "it has too few samples to tell",
                            "not_drawn": "the command that renders ended with 2",
                            "no_reference": "no_reference: trouble"}.items():
            with self.subTest(test):
                said = self.run_command(CMAKE.replace("cmake", "ctest"), "--test-dir", build, "-R",
                                        f"^{test}$", "--output-on-failure", accept=(0, 8))
                self.assertIn(words, " ".join(said.split()))

    def test_has_a_manual(self):
        share = self.prefix / "share"
        for file in ("man/man1/plumb-render.1", "bash-completion/completions/plumb",
                     "zsh/site-functions/_plumb", "fish/vendor_completions.d/plumb.fish"):
            self.assertTrue((share / file).is_file(), file)

    def test_stress_finds_its_scenes(self):
        said = self.run_command(self.prefix / "bin" / "plumb", "stress", "--scene",
                                "gap,caustic,needle", "--methods", "mis", "--spp", "4", accept=(0, 1))
        for scene in "gap", "caustic", "needle":
            self.assertIn(f"| {scene} | mis double |", said)

    def test_power_finds_its_scenes(self):
        said = self.run_command(self.prefix / "bin" / "plumb", "power", "--fault", "inverse-pi",
                                "--time", "0.01")
        for scene in "cornell", "seed":
            self.assertIn(f"| {scene} | inverse-pi |", said)

    def test_writes_and_reads_other_formats_than_exr(self):
        plumb, picture = self.prefix / "bin" / "plumb", self.folder / "room.png"
        self.run_command(plumb, "render", self.scenes / "stress" / "easy" / "room.xml", "--spp", "1",
                         "--size", "8x8", "-o", picture)
        said = self.run_command(plumb, "compare", picture, picture, accept=(0, 1))
        self.assertIn("srgb, made linear", said)

    def test_has_scenes_and_pictures_alone(self):
        kinds = {file.suffix for file in self.scenes.rglob("*") if file.is_file()}
        self.assertEqual(kinds, {".xml", ".obj", ".exr", ".json"})


if __name__ == "__main__":
    CMAKE, BUILD, COMPILER = sys.argv[1:]
    unittest.main(argv=sys.argv[:1])
