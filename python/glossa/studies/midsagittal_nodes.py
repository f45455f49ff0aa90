"""The six nodes of the tongue's midsagittal surface whose scatter fig. 11 shows."""

from __future__ import annotations

import numpy as np

from glossa.anatomy.speaker import Speaker
from glossa.anatomy.swept_surface import chord_lengths
from glossa.errors import InputError
from glossa.studies.points import tracked_nodes

MIDSAGITTAL_NODES = (
    "apical",
    "alveopalatal",
    "palatal",
    "velopharyngeal",
    "upper_pharyngeal",
    "pharyngeal",
)
"""Names of the nodes, tip to root: the regions that section IV.B names (the last two are both "pharyngeal" there)."""


def midsagittal_nodes(speaker: Speaker) -> dict[str, int]:
    """Node of each of :data:`MIDSAGITTAL_NODES`, tip to root.

    The paper shows them in a picture and gives no positions. The rule here: the contour "dorsum" from the tip to the
    rearmost node behind the dorsum, at rest, is divided into five pieces of equal length; each node is that of the
    contour nearest, along it, to one of the six ends.

    Raises:
        InputError: no contour "dorsum", or one with too few nodes between tip and rear.
    """
    contour = speaker.contours.get("dorsum")
    if contour is None or not len(contour):
        raise InputError("the six midsagittal nodes need a speaker with the contour 'dorsum'")
    tracked = tracked_nodes(speaker)
    x, z = speaker.nodes[contour][:, [0, 2]].T
    first = int(np.linalg.norm(speaker.nodes[contour] - speaker.nodes[tracked["tip"]], axis=1).argmin())
    top = first + int(z[first:].argmax())
    last = top + int(x[top:].argmax())
    along = chord_lengths(np.stack([x, z], axis=1)[first : last + 1])
    ends = np.linspace(0.0, along[-1], len(MIDSAGITTAL_NODES))
    places = np.abs(along[None] - ends[:, None]).argmin(axis=1)
    if len(set(places.tolist())) < len(places):
        raise InputError(
            f"the contour 'dorsum' has {last - first + 1} nodes from tip to rear, too few for the six midsagittal nodes"
        )
    nodes = contour[first + places].tolist()
    return dict(zip(MIDSAGITTAL_NODES, (int(node) for node in nodes), strict=True))
