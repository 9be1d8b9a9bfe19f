# SPDX-License-Identifier: Apache-2.0

"""What may be relied on about pictures and comparisons in Python."""

import numpy as np
import pytest

import plumbline


def test_two_seeds_are_the_same_and_a_brighter_one_is_not(draw):
    one, two = draw(256, seed=1), draw(256, seed=2)
    verdict = plumbline.compare(one, two, tolerance="2%")
    assert verdict and verdict.same and verdict.verdict == "same"
    brighter = plumbline.compare(one.radiance * 1.05, two, variance=one.variance * 1.05 ** 2, tolerance="2%")
    assert brighter.different and not brighter
    assert brighter.image["all"].relative_bias == pytest.approx(0.05, abs=3 * brighter.image["all"].standard_error
                                                                / brighter.image["all"].reference)
    assert "different" in str(brighter) and "RMSE" in str(brighter)


def test_arrays_are_judged_as_files_are(draw, tmp_path):
    one, two = draw(64, seed=1), draw(64, seed=2)
    one.write(tmp_path / "one.exr")
    two.write(tmp_path / "two.exr")
    of_files = plumbline.compare(tmp_path / "one.exr", str(tmp_path / "two.exr"))
    of_pictures = plumbline.compare(one, two)
    skipped = ("test", "reference")
    assert {k: v for k, v in of_files.numbers.items() if k not in skipped} == {
        k: v for k, v in of_pictures.numbers.items() if k not in skipped}


def test_replicates_tell_the_noise(draw):
    takes = [draw(16, seed=seed).radiance for seed in range(1, 9)]
    mean = plumbline.picture(takes[0], replicates=takes[1:], samples=16)
    assert np.allclose(mean.radiance, np.mean(takes, axis=0), rtol=1e-5)
    assert np.allclose(mean.variance, np.var(takes, axis=0, ddof=1) / 8, rtol=1e-3, atol=1e-9)
    assert plumbline.compare(takes[0], draw(256, seed=100), replicates=takes[1:], tolerance="3%").same
    with pytest.raises(plumbline.PictureError, match="the picture's replicates differ in size or channels"):
        plumbline.picture(takes[0], replicates=[takes[1][:32]])


def test_regions_are_masks_files_arrays_or_names(cornell, draw, tmp_path):
    one, two = draw(256, seed=1), draw(256, seed=2)
    mask = plumbline.load(cornell.file).mask()
    assert "left_wall" in mask.names and mask["left_wall"].sum() > 1000
    named = {"left": np.arange(64) < 32, "right": np.arange(64) >= 32}
    named = {name: np.broadcast_to(columns, (64, 64)) for name, columns in named.items()}
    verdict = plumbline.compare(one, two, regions=named, tolerance="5%")
    assert list(verdict.regions) == ["left", "right"]
    left = verdict.regions["left"]
    assert left.R.bias == pytest.approx((one.radiance - two.radiance)[:, :32, 0].mean(), abs=1e-6)
    assert left.R.bias == left["R"].bias and list(left) == ["R", "G", "B", "all"]
    with pytest.raises(AttributeError, match="no channel X, but R G B all"):
        left.X  # noqa: B018
    by_number = plumbline.compare(one, two, regions=named["left"] * 7, tolerance="5%")
    assert list(by_number.regions) == ["7"]
    assert by_number.image.R.bias == pytest.approx(left.R.bias)  # the rest is not compared
    whole = [plumbline.render(cornell, spp=4, seed=seed) for seed in (1, 2)]
    mask.write(tmp_path / "objects.png")
    of_file = plumbline.compare(*whole, regions=tmp_path / "objects.png")
    of_mask = plumbline.compare(*whole, regions=mask)
    assert of_file.regions["left_wall"].R == of_mask.regions["left_wall"].R
    with pytest.raises(plumbline.ArgumentError, match="a mask of 64 x 64 pixels is needed"):
        plumbline.compare(one, two, regions=mask)


@pytest.mark.parametrize("values, reason", [
    (np.zeros((4, 4, 3), np.uint8), "linear radiance is wanted, as floats, not uint8"),
    (np.zeros(4), "height x width"),
    (np.zeros((4, 4, 5)), r"of shape \(4, 4, 5\) has 5 channels: plumbline.picture\(..., channels=\) names them"),
])
def test_what_is_no_picture_is_refused(values, reason):
    with pytest.raises(plumbline.ArgumentError, match=reason):
        plumbline.compare(values, np.ones((4, 4, 3)))


def test_poison_and_other_sizes_are_trouble():
    good, bad = np.ones((8, 8, 3)), np.ones((8, 8, 3))
    bad[2, 3] = np.nan
    with pytest.raises(plumbline.PictureError, match="not a number|nan|NaN"):
        plumbline.compare(bad, good)
    with pytest.raises(plumbline.PictureError, match="8 x 8 pixels .* 4 x 8"):
        plumbline.compare(good, good[:, :4])
    with pytest.raises(plumbline.PictureError, match="No such file"):
        plumbline.compare(good, "missing.exr")


def test_anything_array_like_of_any_layout_is_a_picture():
    values = np.arange(24.0).reshape(2, 4, 3) + 1
    lists = values.tolist()
    turned = np.asfortranarray(values)
    for one in (lists, turned, values[::-1][::-1], values.astype(np.float16)):
        assert plumbline.compare(one, values, tolerance=0).same
    grey = plumbline.picture(values[:, :, 0])
    assert grey.channels == ["Y"] and grey.radiance.shape == (2, 4, 3)
    alpha = plumbline.picture(np.dstack([values, np.ones((2, 4))]))
    assert alpha.channels == ["R", "G", "B", "A"]


def test_a_verdict_shows_itself(draw):
    verdict = plumbline.compare(draw(64, seed=1), draw(64, seed=2), flip="ldr")
    shown = verdict._repr_html_()
    assert shown.count("data:image/png;base64,") == 4 and verdict.verdict in shown
    assert verdict.map("flip").width >= 64
    assert verdict.errors.R.rel_mse > 0
    with pytest.raises(plumbline.ArgumentError, match="is not one of difference, z, blocks, flip"):
        verdict.map("heat")


def test_a_map_of_any_kind_is_a_picture_with_a_scale(draw):
    verdict = plumbline.compare(draw(64, seed=1), draw(64, seed=2))
    for kind in "difference", "z", "blocks":
        drawn = verdict.map(kind)
        assert drawn.width >= 64 and "scale" in drawn.provenance
