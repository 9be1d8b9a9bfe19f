# SPDX-License-Identifier: Apache-2.0

"""What may be relied on about the pytest plugin."""

import json
import re
import textwrap

import pytest

TESTS = """
    import plumbline
    import pytest
    scene = plumbline.load(plumbline.SCENES / "cornell" / "scene.xml")

    def render(spp, seed, **words):
        return plumbline.render(scene, spp=spp, seed=seed, size=(32, 32), **words)
"""


@pytest.fixture
def run(pytester):
    def run(tests, *arguments):
        pytester.makepyfile(textwrap.dedent(TESTS) + textwrap.dedent(tests))
        return pytester.runpytest_subprocess("-p", "no:cacheprovider", *arguments)
    return run


def test_a_reference_is_missing_then_made_then_held_against(run, pytester):
    test = """
    def test_cornell(pictures):
        pictures.check(render(256, 1), "cornell", tolerance="2%")
    """
    missing = run(test)
    missing.assert_outcomes(failed=1)
    missing.stdout.fnmatch_lines(["*references/cornell.exr is missing: 'pytest --pictures-update' makes it*"])
    run(test, "--pictures-update").assert_outcomes(passed=1)
    card = json.loads((pytester.path / "references" / "card.json").read_text("utf-8"))
    [entry] = card["pictures"]
    assert entry["file"] == "cornell.exr" and entry["test"].endswith("::test_cornell")
    assert entry["samples"] == "0:256" and entry["renderer"] == "plumbline"
    run(test).assert_outcomes(passed=1)


def test_what_is_different_fails_and_its_companion_passes(run):
    run('def test_it(pictures):\n    pictures.check(render(256, 1), "cornell")', "--pictures-update")
    result = run("""
    def test_brighter(pictures):
        picture = render(256, 2)
        verdict = pictures.check(picture.radiance * 1.1, "cornell", variance=picture.variance, expect="different")
        assert verdict.different

    def test_darker(pictures):
        picture = render(256, 2)
        pictures.check(picture.radiance * 0.9, "cornell", variance=picture.variance)

    def test_companion_that_is_the_same(pictures):
        pictures.check(render(256, 2), "cornell", tolerance="5%", expect="different")
    """)
    result.assert_outcomes(passed=1, failed=2)
    result.stdout.fnmatch_lines(["*cornell: different: *", "*It should have been different.*"])


def test_an_update_leaves_what_is_the_same(run, pytester):
    test = 'def test_it(pictures):\n    pictures.check(render({spp}, {seed}){more}, "box", tolerance="5%")'
    file = pytester.path / "references" / "box.exr"
    run(test.format(spp=256, seed=1, more=""), "--pictures-update")
    first = file.read_bytes()
    run(test.format(spp=256, seed=2, more=""), "--pictures-update").assert_outcomes(passed=1)
    assert file.read_bytes() == first
    run(test.format(spp=256, seed=2, more=".radiance * 2"), "--pictures-update").assert_outcomes(passed=1)
    assert file.read_bytes() != first


def test_an_update_replaces_a_reference_of_another_size(run):
    test = 'def test_it(pictures):\n    pictures.check(render(256, 1).radiance{part}, "box")'
    run(test.format(part=""), "--pictures-update")
    smaller = test.format(part="[8:24]")
    run(smaller).stdout.fnmatch_lines(["*PictureError: the test shows 32 x 16 pixels*"])
    run(smaller, "--pictures-update").assert_outcomes(passed=1)
    run(smaller).assert_outcomes(passed=1)


def test_an_update_makes_no_reference_that_nothing_could_be_held_against(run, pytester):
    result = run("""
    def test_it(pictures):
        pictures.check(render(16, 1).radiance - float("inf"), "box")
    """, "--pictures-update")
    result.stdout.fnmatch_lines(["*PictureError: the test has 3072 values that are NaN, infinite or negative*"])
    assert not (pytester.path / "references").exists()


def test_a_function_is_called_until_the_verdict_is_sure(run):
    run('def test_it(pictures):\n    pictures.check(render, "box", budget=4096)',
        "--pictures-update").assert_outcomes(passed=1)
    run("""
    def test_more_samples(pictures):
        calls = []
        def counted(spp, seed):
            calls.append((spp, seed))
            return render(spp, seed).radiance
        pictures.check(counted, "box", tolerance="2%", spp=16, budget=4096)
        assert len(calls) > 4 and len({seed for _, seed in calls}) == len(calls)
        assert sum(spp for spp, _ in calls) <= 4096

    def test_no_more_than_the_budget(pictures):
        calls = []
        def counted(spp, seed):
            calls.append(spp)
            return render(spp, seed).radiance
        with pytest.raises(AssertionError, match="inconclusive(.|\\n)*budget= lets it take more"):
            pictures.check(counted, "box", tolerance="0.05%", spp=16, budget=128)
        assert sum(calls) <= 128

    def test_a_fault_is_found(pictures):
        pictures.check(lambda spp, seed: render(spp, seed, fault="emitter-cosine"), "box", expect="different")
    """).assert_outcomes(passed=3)


def test_regions_lie_beside_the_references(run, pytester):
    run('def test_it(pictures):\n    pictures.check(render(64, 1), "box")', "--pictures-update")
    result = run("""
    def test_it(pictures):
        import numpy as np
        from plumbline import picture
        mask = np.zeros((32, 32, 3)); mask[:, :16, 0] = 1; mask[:, 16:, 1] = 1
        picture(mask).write(pictures.references / "halves.png")
        verdict = pictures.check(render(64, 1), "box", regions="halves.png")
        assert len(verdict.regions) == 2
    """)
    result.assert_outcomes(passed=1)


@pytest.mark.parametrize("workers", [(), ("-n", "2")])
def test_the_page_shows_all_checks_whoever_made_them(run, pytester, workers):
    if workers:
        pytest.importorskip("xdist")
    run("""
    @pytest.mark.parametrize("box", range(4))
    def test_make(pictures, box):
        pictures.check(render(256, 1), f"box{box}")
    """, "--pictures-update", *workers).assert_outcomes(passed=4)
    card = json.loads((pytester.path / "references" / "card.json").read_text("utf-8"))
    assert [one["file"] for one in card["pictures"]] == [f"box{i}.exr" for i in range(4)]
    result = run("""
    @pytest.mark.parametrize("box", range(4))
    def test_box(pictures, box):
        pictures.check(render(256, 2).radiance * (2 if box == 3 else 1), f"box{box}", floor="5%", tolerance="10%")
        """, "--pictures-report=out/page.html", *workers)
    result.assert_outcomes(passed=3, failed=1)
    result.stdout.fnmatch_lines(["pictures: out/page.html shows 4 checks"])
    page = (pytester.path / "out" / "page.html").read_text("utf-8")
    data = json.loads(re.search(r'<script type="application/json" id="data">(.*?)</script>', page, re.DOTALL)[1])
    assert [len(scene["pictures"]) for scene in data] == [2] * 4
    assert "4 compared, 1 not as expected" in page
    assert page.index("test_box[3]") < page.index("test_box[0]")  # failures come first


def shown(page):
    """The scenes' data, and the page's text."""
    text = page.read_text("utf-8")
    return json.loads(re.search(r'<script type="application/json" id="data">(.*?)</script>', text, re.DOTALL)[1]), text


def test_the_page_shows_checks_that_trouble_ended(run, pytester):
    run('def test_it(pictures):\n    pictures.check(render(256, 1), "box")', "--pictures-update")
    run("""
    def test_wrong_size(pictures):
        pictures.check(plumbline.render(scene, spp=4, size=(16, 16)), "box")

    def test_renderer_that_fails(pictures):
        def broken(spp, seed):
            raise RuntimeError("no more memory on the card")
        pictures.check(broken, "box")

    def test_unreadable_reference(pictures):
        (pictures.references / "box.exr").write_text("not a picture")
        pictures.check(render(16, 2), "box")
    """, "--pictures-report=page.html").assert_outcomes(failed=3)
    scenes, text = shown(pytester.path / "page.html")
    assert [scene["pictures"] for scene in scenes] == [[], [], []]
    assert "3 compared, 3 not as expected" in text
    for said in ("no more memory on the card", "16 x 16", "test_unreadable_reference"):
        assert said in text


def test_an_interrupt_leaves_the_page_what_was_seen(run, pytester):
    run('def test_it(pictures):\n    pictures.check(render(256, 1), "box")', "--pictures-update")
    run("""
    def test_first(pictures):
        pictures.check(render(256, 2), "box", tolerance="10%", floor="5%")

    def test_interrupted(pictures):
        def until_ctrl_c(spp, seed):
            if seed > 4:
                raise KeyboardInterrupt
            return render(spp, seed)
        pictures.check(until_ctrl_c, "box", tolerance="0.1%")
    """, "--pictures-report=page.html")
    scenes, text = shown(pytester.path / "page.html")
    assert [len(scene["pictures"]) for scene in scenes] == [2, 2]
    assert "Ended by KeyboardInterrupt. Until then:" in text


def test_a_history_grows_and_is_shown(run, pytester):
    run('def test_it(pictures):\n    pictures.check(render(256, 1), "box")', "--pictures-update")
    for seed in (2, 3):
        run(f'def test_it(pictures):\n    pictures.check(render(256, {seed}), "box", tolerance="10%", floor="5%")',
            "--pictures-history=kept/biases.jsonl", "--pictures-report=page.html").assert_outcomes(passed=1)
    runs = [json.loads(line) for line in (pytester.path / "kept" / "biases.jsonl").read_text("utf-8").splitlines()]
    assert [one["verdict"] for one in runs] == ["same", "same"]
    assert all(0 < abs(one["bias"]) < 5 * one["confidence"] for one in runs)
    _, text = shown(pytester.path / "page.html")
    assert "Bias over runs" in text and "in 2 runs" in text


def test_a_history_counts_what_had_a_bias(run, pytester):
    missing = run('def test_it(pictures):\n    pictures.check(render(16, 1), "never")', "--pictures-history=biases.jsonl")
    missing.assert_outcomes(failed=1)
    missing.stdout.fnmatch_lines(["*biases.jsonl has the biases of 0 checks more"])
    assert (pytester.path / "biases.jsonl").read_text("utf-8") == ""
