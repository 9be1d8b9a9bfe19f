# SPDX-License-Identifier: Apache-2.0

"""A user's program passes a strict type checker, and one with a mistake does not."""

import subprocess
import sys

import pytest

pytest.importorskip("mypy")

PROGRAM = """
import numpy as np
import plumbline


def bias(file: str) -> float:
    scene = plumbline.load(file)
    picture = plumbline.render(scene, spp=16, seed=3, bounces=(0, None), size=(64, 64), progress=True)
    brighter = picture.radiance * np.float32(1.01)
    verdict = plumbline.compare(brighter, picture, tolerance="0.5%", variance=picture.variance, regions=scene.mask())
    print(verdict, scene.shapes["lamp"].radiance[0] + scene.camera.fov_degrees)
    return verdict.regions["left_wall"].R.bias
"""


def check(tmp_path, program):
    file = tmp_path / "program.py"
    file.write_text(program, "utf-8")
    return subprocess.run([sys.executable, "-m", "mypy", "--strict", "--cache-dir", tmp_path / "cache", file],
                          capture_output=True, text=True, check=False)


def test_a_program_passes_strictly(tmp_path):
    result = check(tmp_path, PROGRAM)
    assert result.returncode == 0, result.stdout


def test_mistakes_are_seen(tmp_path):
    result = check(tmp_path, PROGRAM.replace("spp=16", 'spp="many"').replace(".R.bias", ".R.basi"))
    assert result.returncode == 1
    assert '"render" has incompatible type "str"' in result.stdout and '"basi"' in result.stdout
