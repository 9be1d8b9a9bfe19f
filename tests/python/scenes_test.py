# SPDX-License-Identifier: Apache-2.0

"""What may be relied on about scenes and renders in Python."""

import inspect
import os
import re
import signal
import subprocess
import sys
import threading
import time

import numpy as np
import pytest

import plumbline


def test_a_scene_is_what_its_file_says(cornell):
    assert {"left_wall", "tall_block", "lamp"} <= set(cornell.shapes)
    assert cornell.shapes["lamp"].radiance == [17, 12, 4]
    assert cornell.shapes["lamp"].is_lamp
    assert cornell.shapes["tall_block"].bsdf == "diffuse"
    assert len(cornell.shapes["tall_block"].faces) >= 5
    assert (cornell.camera.width, cornell.camera.height) == (256, 256)
    assert list(cornell.camera.origin) == [278, 273, -800]


def test_all_that_is_wrong_with_a_scene_is_in_one_exception(tmp_path):
    file = tmp_path / "scene.xml"
    file.write_text('<scene version="3.0.0">\n<shape type="cone"/>\n<shape type="torus"/>\n</scene>')
    with pytest.raises(plumbline.SceneError, match="cone(.|\n)*torus"):
        plumbline.load(file)


def test_a_picture_is_a_view_of_its_own_memory(draw):
    picture = draw(16)
    assert picture.radiance.shape == picture.variance.shape == (64, 64, 3)
    assert picture.radiance.dtype == np.float32
    assert np.shares_memory(picture.radiance, picture.values)
    assert not picture.radiance.flags.writeable
    radiance = picture.radiance
    kept = radiance.copy()
    del picture
    assert (radiance == kept).all()
    assert kept.min() >= 0 and kept.max() > 1


def test_a_seed_has_the_same_bits_on_any_number_of_threads(draw):
    one, two = draw(16, seed=3, threads=1), draw(16, seed=3, threads=2)
    assert (one.radiance == two.radiance).all()
    assert (one.radiance != draw(16, seed=4).radiance).any()


def test_a_crop_has_the_pixels_of_the_picture_and_knows_their_place(draw, tmp_path):
    whole, crop = draw(16), draw(16, crop=(10, 20, 30, 7))
    assert crop.radiance.shape == (7, 30, 3)
    assert (crop.radiance == whole.radiance[20:27, 10:40]).all()
    assert (crop.variance == whole.variance[20:27, 10:40]).all()
    assert crop.provenance["crop"] == "10,20,30,7" and "crop" not in whole.provenance
    crop.write(tmp_path / "crop.exr")
    for part in (crop, tmp_path / "crop.exr"):
        assert plumbline.compare(part, whole, crop=(10, 20, 30, 7), tolerance=0).same
        assert plumbline.compare(part, whole).different
    assert plumbline.compare(crop, draw(16, crop=(10, 20, 30, 7)), tolerance=0).same
    with pytest.raises(plumbline.ArgumentError, match="beyond the picture"):
        draw(16, crop=(60, 0, 5, 5))


def test_bounces_add_up(draw):
    whole, direct, rest = draw(16), draw(16, bounces=(0, 1)), draw(16, bounces=(2, None))
    # The same samples: what differs is the rounding of sums in float.
    assert np.allclose(direct.radiance + rest.radiance, whole.radiance, rtol=1e-4, atol=1e-6)


def test_a_picture_says_how_it_was_made_and_is_written_and_read(draw, tmp_path):
    picture = draw(16, seed=5)
    picture.write(tmp_path / "picture.exr")
    again = plumbline.read(tmp_path / "picture.exr")
    assert again.provenance == picture.provenance
    assert (again.provenance["seed"], again.provenance["samples"], again.samples_per_pixel) == (5, "0:16", 16)
    assert (again.values == picture.values).all()


def test_light_from_all_shapes_adds_up_to_the_whole(cornell):
    whole = plumbline.render(cornell, spp=4, size=(16, 16))
    red = plumbline.render(cornell, spp=4, size=(16, 16), from_="left_wall")
    rest = plumbline.render(cornell, spp=4, size=(16, 16), from_=[name for name in cornell.shapes if name != "left_wall"])
    assert np.allclose(red.radiance + rest.radiance, whole.radiance, rtol=1e-5, atol=1e-6)
    assert 0 < red.radiance.sum() < whole.radiance.sum()


def test_words_are_those_of_the_command():
    command = os.path.join(os.path.dirname(plumbline.__file__), "bin", "plumb")
    for function, name, others in (
            (plumbline.render, "render", {"help", "output", "aov", "exposure"}),
            (plumbline.radiosity, "radiosity", {"help", "output", "exposure", "teach"}),
            (plumbline.compare, "compare", {"help", "output", "json", "markdown", "map", "update", "gate", "junit",
                                            "part", "codes"})):
        told = subprocess.run([command, name, "--help"], capture_output=True, text=True, check=True).stdout
        options = set(re.findall(r"^\s+(?:-\w,)?--([\w-]+)", told, re.MULTILINE)) - others
        keywords = {name.rstrip("_").replace("_", "-") for name, one in inspect.signature(function).parameters.items()
                    if one.kind is one.KEYWORD_ONLY}
        assert options <= keywords
        assert keywords - options <= {"progress", "variance", "reference-variance"}


def test_the_mask_of_a_crop_is_a_crop_of_the_mask(cornell, draw, tmp_path):
    crop = (30, 20, 30, 17)
    whole, part = (cornell.mask(size=(64, 64), crop=some) for some in (None, crop))
    assert part.labels.shape == (17, 30) and set(part.names) < set(whole.names)
    for name in part.names:
        assert (part[name] == whole[name][20:37, 30:60]).all()
    pictures = []
    for name, mask in (("whole", whole), ("part", part)):
        mask.write(tmp_path / f"{name}.exr")
        pictures.append(plumbline.read(tmp_path / f"{name}.exr").radiance)
    assert (pictures[1][20:37, 30:60] == pictures[0][20:37, 30:60]).all()


def test_the_mask_of_a_crop_fits_the_crop_and_the_whole_picture(cornell, draw):
    crop = (30, 20, 30, 17)
    mask, whole = cornell.mask(size=(64, 64), crop=crop), cornell.mask(size=(64, 64))
    takes = [draw(256, seed=seed, crop=crop) for seed in (1, 2)]
    pictures = [draw(256, seed=seed) for seed in (1, 2)]
    of_crops = plumbline.compare(*takes, regions=mask)
    of_pictures = plumbline.compare(*pictures, crop=crop, regions=mask)
    of_whole_mask = plumbline.compare(*pictures, crop=crop, regions=whole)
    for verdict in (of_pictures, of_whole_mask):
        assert verdict.regions["right_wall"].R.test == of_crops.regions["right_wall"].R.test
        assert verdict.regions["right_wall"].R.bias == of_crops.regions["right_wall"].R.bias
    with pytest.raises(plumbline.ArgumentError, match="a mask of 32 x 32 pixels is needed"):
        plumbline.compare(draw(4, size=(32, 32)), draw(4, size=(32, 32)), regions=mask)


def test_arguments_are_refused_in_the_words_of_the_command(cornell):
    with pytest.raises(plumbline.ArgumentError, match="--spp: '0' is not a whole number from 1 to"):
        plumbline.render(cornell, spp=0)
    with pytest.raises(ValueError, match="--samples excludes --spp"):
        plumbline.render(cornell, spp=1, samples=(0, 4))


def test_what_was_chosen_otherwise_is_a_warning():
    with pytest.warns(plumbline.Notice, match="in double precision, because float is too coarse"):
        plumbline.render(plumbline.SCENES / "stress" / "gap.xml", spp=1)


def test_progress_is_told_in_lines(cornell):
    lines = []
    plumbline.render(cornell, time=0.5, progress=lines.append)
    assert lines and any("spp" in line for line in lines)


def test_what_progress_raises_ends_the_render(cornell):
    def give_up(line):
        raise RuntimeError(line)
    with pytest.raises(RuntimeError, match="first pass|spp"):
        plumbline.render(cornell, spp=1 << 20, progress=give_up)


def test_other_threads_run_while_one_renders(cornell):
    beats = []
    done = threading.Event()

    def beat():
        while not done.is_set():
            beats.append(time.monotonic())
            time.sleep(0.001)
    thread = threading.Thread(target=beat)
    thread.start()
    plumbline.render(cornell, time=0.5)
    done.set()
    thread.join()
    assert len(beats) > 10  # with the lock held there would be one


def test_ctrl_c_ends_a_render(cornell):
    # Who runs these tests in the background has told all that they start to ignore SIGINT.
    script = ("import plumbline, signal, sys\n"
              "signal.signal(signal.SIGINT, signal.default_int_handler)\n"
              "scene = plumbline.load(plumbline.SCENES / 'cornell' / 'scene.xml')\n"
              "def show(line):\n  print(line, flush=True)\n"
              "try:\n  plumbline.render(scene, spp=1 << 30, progress=show)\n"
              "except KeyboardInterrupt:\n  sys.exit(7)\n")
    process = subprocess.Popen([sys.executable, "-c", script], stdout=subprocess.PIPE, text=True)
    process.stdout.readline()  # it renders
    process.send_signal(signal.SIGINT)
    assert process.wait(60) == 7


def test_radiosity_has_no_noise_and_says_how_wrong_it_is(cornell, draw):
    picture = plumbline.radiosity(cornell, size=(32, 32), bounces=(0, 1))
    assert picture.variance is None
    assert 0 < picture.provenance["imageFloor"] < 0.01
    verdict = plumbline.compare(draw(256, bounces=(0, 1), size=(32, 32)), picture, tolerance="5%")
    assert verdict.same
