"""Walls and hyoid where a posture has them: for pictures, and for the sections of the vocal tract."""

from __future__ import annotations

import numpy as np

from glossa.anatomy.arrays import FloatArray
from glossa.anatomy.walls import Wall
from glossa.results import Posture


def walls_of(posture: Posture) -> dict[str, Wall]:
    """The speaker's walls, each where it was displaced to."""
    shifts = posture.wall_displacements
    return {
        name: wall if name not in shifts else Wall(wall.vertices + shifts[name], wall.faces)
        for name, wall in posture.speaker.walls.items()
    }


def hyoid_of(posture: Posture) -> Wall | None:
    """The surface of the hyoid bone at its pose; None where the speaker has none."""
    hyoid = posture.speaker.hyoid
    if hyoid is None or hyoid.surface is None:
        return None
    if posture.hyoid is None:
        return hyoid.surface
    return Wall(posture.hyoid.moved(hyoid.surface.vertices), hyoid.surface.faces)


def springs_of(posture: Posture) -> FloatArray:
    """(k, 2, 3) m: ends of the hyoid's springs, on the bone at its pose and fixed."""
    hyoid = posture.speaker.hyoid
    if hyoid is None or not hyoid.springs:
        return np.zeros((0, 2, 3))
    on_bone = np.array([spring.on_hyoid for spring in hyoid.springs])
    fixed = np.array([spring.fixed for spring in hyoid.springs])
    return np.stack([on_bone if posture.hyoid is None else posture.hyoid.moved(on_bone), fixed], axis=1)
