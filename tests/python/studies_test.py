# SPDX-License-Identifier: Apache-2.0

"""What may be relied on about studies in Python: they are those of the command."""

import plumbline


def test_convergence_of_a_scene_and_of_pictures(cornell, draw):
    reference = draw(1024, seed=99)
    found = plumbline.converge(cornell, reference=reference, spp=(1, 16), runs=1, size=(64, 64),
                               samplers="independent")
    assert "plumbline mis independent" in str(found)
    assert found.sentences
    pictures = [draw(spp, seed=spp, sampler="independent") for spp in (1, 2, 4, 8, 16)]
    assert "plumbline mis independent" in str(plumbline.converge(pictures, reference=reference))


def test_a_planted_fault_is_diagnosed(cornell):
    faulty = plumbline.render(cornell, spp=256, size=(16, 16), fault="emitter-cosine", seed=7)
    found = plumbline.diagnose(faulty, plumbline.SCENES / "cornell" / "scene.xml")
    assert found.verdict == "different"
    assert found.suspects[0].name.startswith("`emitter-cosine`")
    assert "emitter-cosine" in str(found)
