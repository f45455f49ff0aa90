"""The posture in which nothing acts."""

from __future__ import annotations

import numpy as np

from glossa.anatomy.speaker import Speaker
from glossa.results import Posture


def rest_posture(speaker: Speaker) -> Posture:
    """A speaker at rest, which is free of stress: no displacement, no force, nothing solved."""
    fibres = sum(len(muscle.fibres) for muscle in speaker.muscles.values())
    return Posture(
        speaker=speaker,
        commands=None,
        positions=np.array(speaker.nodes),
        activations=np.zeros(fibres),
        fibre_forces=np.zeros(fibres),
        pressure=np.zeros(len(speaker.hexahedra)),
        stiffening=np.ones(len(speaker.hexahedra)),
        support_forces=np.zeros(speaker.nodes.shape),
        report=None,
    )
