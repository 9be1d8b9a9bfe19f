# SPDX-License-Identifier: Apache-2.0

import pytest

import plumbline

pytest_plugins = ["pytester"]


@pytest.fixture(scope="session")
def cornell():
    return plumbline.load(plumbline.SCENES / "cornell" / "scene.xml")


@pytest.fixture(scope="session")
def draw(cornell):
    """A small picture of the Cornell box."""
    def render(spp=64, size=(64, 64), **words):
        return plumbline.render(cornell, spp=spp, size=size, **words)
    return render
