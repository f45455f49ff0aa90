"""Where the numbers of a study come from."""

from __future__ import annotations

from typing import Any

from glossa import _core
from glossa.scene import Scene
from glossa.studies.study_point import canonical
from glossa.tolerances import ACCURACIES

STUDIED_ACCURACY = "standard"
"""Of the equilibria of studies."""


def provenance(scene: Scene, study: str) -> dict[str, Any]:
    """Attributes of a Dataset: the study's name, its speaker, and the effects of its scene."""
    return {
        "study": study,
        "speaker": scene.speaker.name,
        "speaker_fingerprint": scene.speaker.fingerprint,
        "effects": ", ".join(scene.effects),
    }


def effective_options(scene: Scene) -> dict[str, Any]:
    """The scene's options as they came out, without those that change nothing in a result."""
    return {name: getattr(scene, name) for name in scene.options if name != "threads"}


def solve_provenance(scene: Scene) -> dict[str, Any]:
    """What the bits of a study's equilibria depend on: versions, speaker, scene, tolerances."""
    wanted = ACCURACIES[STUDIED_ACCURACY]
    return {
        "glossa_version": _core.__version__,
        "kernel": _core.kernel_name(),
        "speaker": scene.speaker.name,
        "speaker_fingerprint": scene.speaker.fingerprint,
        "scene": canonical(effective_options(scene)),
        "residual_tolerance": wanted.residual,
        "gap_tolerance_m": wanted.gap,
    }
