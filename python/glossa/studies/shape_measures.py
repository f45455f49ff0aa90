"""Shapes of the whole tongue in single numbers: its width and its midsagittal section."""

from __future__ import annotations

import math

import numpy as np

from glossa.anatomy.arrays import FloatArray
from glossa.anatomy.hexahedra import FACES
from glossa.anatomy.speaker import Speaker
from glossa.errors import InputError
from glossa.results import Posture

_OFF_MIDLINE = 5e-3
"""Distance from the midplane beyond which nodes of the surface are sides of the tongue, m."""


def muscle_stretch(posture: Posture, muscle: str) -> float:
    """Length of a muscle's fibres together over that at rest. Of the transversalis: how wide the tongue is, on average.

    Raises:
        InputError: no such muscle.
    """
    speaker = posture.speaker
    if muscle not in speaker.muscles:
        raise InputError(f"no muscle {muscle!r}; this speaker has {', '.join(speaker.muscles) or 'none'}")
    fibres = speaker.muscles[muscle].fibres
    lengths = [sum(_length(where[fibre]) for fibre in fibres) for where in (posture.positions, speaker.nodes)]
    return lengths[0] / lengths[1]


def widening(posture: Posture) -> float:
    """Growth of the tongue's width from rest where it grows most, both sides together, m."""
    speaker = posture.speaker
    surface = np.unique(speaker.surface_quads)
    y = speaker.nodes[surface, 1]
    outward = np.sign(y) * posture.displacements[surface, 1]
    sides = [outward[sign * y > _OFF_MIDLINE] for sign in (-1.0, 1.0)]
    return math.fsum(float(side.max(initial=-math.inf)) for side in sides)


def midsagittal_area(speaker: Speaker, positions: FloatArray) -> float:
    """Area of the tongue's section y = 0, m2, at node positions (n, 3) in m.

    Raises:
        InputError: no face of a hexahedron lies in y = 0 at rest.
    """
    in_plane = np.zeros(len(speaker.nodes), dtype=bool)
    in_plane[speaker.midsagittal_nodes] = True
    faces = speaker.hexahedra[:, FACES].reshape(-1, 4)
    faces = faces[in_plane[faces].all(axis=1)]
    if not len(faces):
        raise InputError("no midsagittal section: no face of a hexahedron lies in the plane y = 0")
    _, one_of_two = np.unique(np.sort(faces, axis=1), axis=0, return_index=True)
    corners = positions[faces[one_of_two]][:, :, [0, 2]]
    diagonals = corners[:, 2] - corners[:, 0], corners[:, 3] - corners[:, 1]
    return float(np.abs(diagonals[0][:, 0] * diagonals[1][:, 1] - diagonals[0][:, 1] * diagonals[1][:, 0]).sum() / 2.0)


def _length(line: FloatArray) -> float:
    return float(np.linalg.norm(np.diff(line, axis=0), axis=1).sum())
