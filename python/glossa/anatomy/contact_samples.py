"""Points of the tongue's surface that may touch a wall."""

from __future__ import annotations

import numpy as np

from glossa.anatomy.arrays import BoolArray
from glossa.anatomy.facet_surface import FacetSurface
from glossa.anatomy.hexahedra import matching_faces
from glossa.anatomy.smooth_surface import SmoothSurface
from glossa.anatomy.speaker import Speaker
from glossa.anatomy.surface_sampling import SurfaceSamples, surface_samples

SPACING = 2.5e-3
"""Distance of neighbouring contact points, m: a surface bent to a radius of 10 mm sags by 0.08 mm between them."""


def contact_samples(speaker: Speaker, wall: str, held: BoolArray) -> SurfaceSamples:
    """Points of the faces that may touch a wall and have a node that moves.

    Named contact faces belong to an organ whose nodes sample a smooth surface. A body that names none is taken as it
    is, with bilinear faces.

    Args:
        speaker: with walls.
        wall: name.
        held: (n,) nodes that never move.
    """
    quads = speaker.surface_quads
    surface: SmoothSurface | FacetSurface
    if not speaker.contact_faces:
        surface, chosen = FacetSurface(speaker.nodes, quads), np.arange(len(quads))
    else:
        surface = speaker.smooth_surface
        chosen = (
            matching_faces(speaker.contact_faces[wall], quads) if wall in speaker.contact_faces else np.zeros(0, int)
        )
    return surface_samples(surface, chosen[~held[quads[chosen]].all(axis=1)].astype(np.int32), SPACING)
