"""Postures without a scene: nodes put somewhere."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from glossa import Posture, Speaker
from glossa.studies import rest_posture


def placed(speaker: Speaker, displacements: NDArray[np.float64]) -> Posture:
    """The speaker at rest but for node displacements (n, 3) or (3,) m."""
    return replace(rest_posture(speaker), positions=speaker.nodes + displacements)
