"""Points of the tongue's surface that may touch a wall."""

from __future__ import annotations

import numpy as np

from glossa.anatomy.arrays import BoolArray, IntArray
from glossa.anatomy.facet_surface import FacetSurface
from glossa.anatomy.hexahedra import matching_faces
from glossa.anatomy.smooth_surface import SmoothSurface
from glossa.anatomy.speaker import Speaker
from glossa.anatomy.surface_sampling import LARGEST_DIVISION, SurfaceSamples, surface_samples

SPACING = 2.5e-3
"""Distance of neighbouring contact points, m, unless a scene asks for less: a surface bent to a radius of 10 mm sags by
0.08 mm between them, and sharp edges enter there (glossa.surface_penetration)."""


def contact_samples(speaker: Speaker, wall: str, held: BoolArray, spacing: float = SPACING) -> SurfaceSamples:
    """Points of the faces that may touch a wall and have a node that moves.

    Args:
        speaker: with walls.
        wall: name.
        held: (n,) nodes that never move.
        spacing: of the points, m; in faces longer than 15 mm, where points are further apart, in proportion.
    """
    faces = moving_contact_faces(speaker, wall, held)
    return surface_samples(contact_surface(speaker), faces, spacing, round(LARGEST_DIVISION * SPACING / spacing))


def contact_surface(speaker: Speaker) -> SmoothSurface | FacetSurface:
    """The surface whose points touch walls.

    Named contact faces belong to an organ whose nodes sample a smooth surface. A body that names none is taken as it
    is, with bilinear faces.
    """
    return speaker.smooth_surface if speaker.contact_faces else FacetSurface(speaker.nodes, speaker.surface_quads)


def moving_contact_faces(speaker: Speaker, wall: str, held: BoolArray) -> IntArray:
    """Numbers of the surface faces that may touch a wall and have a node that is not among the (n,) held ones."""
    quads = speaker.surface_quads
    if not speaker.contact_faces:
        faces = np.arange(len(quads))
    elif wall in speaker.contact_faces:
        faces = matching_faces(speaker.contact_faces[wall], quads)
    else:
        faces = np.zeros(0, int)
    return faces[~held[quads[faces]].all(axis=1)].astype(np.int32)
