"""Results the figure tests share: computed once."""

from __future__ import annotations

import pytest

from glossa import VOWELS, Movement, Posture, Ramp, Scene, Speaker


@pytest.fixture(scope="session")
def scene() -> Scene:
    return Scene(Speaker.reference(), mirror=True)


@pytest.fixture(scope="session")
def postures(scene: Scene) -> dict[str, Posture]:
    return {name: scene.equilibrate(VOWELS[name]) for name in ("i", "a")}


@pytest.fixture(scope="session")
def movement(scene: Scene) -> Movement:
    return scene.simulate(Ramp(VOWELS["i"]), until=0.02, accuracy="draft")
