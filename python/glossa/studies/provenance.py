"""Where the numbers of a study come from."""

from __future__ import annotations

from typing import Any

from glossa.scene import Scene


def provenance(scene: Scene, study: str) -> dict[str, Any]:
    """Attributes of a Dataset: the study's name, its speaker, and the effects of its scene."""
    return {
        "study": study,
        "speaker": scene.speaker.name,
        "speaker_fingerprint": scene.speaker.fingerprint,
        "effects": ", ".join(scene.effects),
    }
