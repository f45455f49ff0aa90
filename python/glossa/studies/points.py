"""The nodes whose motion is reported: tongue tip and dorsum."""

from __future__ import annotations

import math

import numpy as np

from glossa.anatomy.arrays import FloatArray
from glossa.anatomy.speaker import Speaker
from glossa.errors import InputError
from glossa.results import Posture


def tracked_nodes(speaker: Speaker) -> dict[str, int]:
    """Node of the "tip" and of the "dorsum".

    The node set of that name where the speaker has it (its first node); else, of the contour "dorsum", the first node
    for the tip and the highest at rest for the dorsum.

    Raises:
        InputError: the speaker has neither.
    """
    contour = speaker.contours.get("dorsum")
    found = {}
    for name in ("tip", "dorsum"):
        if len(speaker.node_sets.get(name, ())):
            found[name] = int(speaker.node_sets[name][0])
        elif contour is not None and len(contour):
            found[name] = int(contour[0] if name == "tip" else contour[speaker.nodes[contour, 2].argmax()])
        else:
            raise InputError(f"the speaker has neither a node set {name!r} nor a contour 'dorsum' to find it on")
    return found


def hyoid_pose(posture: Posture) -> FloatArray:
    """(3, 3) displacement (m), rotation vector (rad) and centre at rest (m) of a mobile hyoid; NaN without."""
    pose = posture.hyoid
    if pose is None:
        return np.full((3, 3), math.nan)
    return np.stack([pose.displacement, pose.rotation, pose.centre])


def displacements_mm(posture: Posture) -> dict[str, FloatArray]:
    """Displacement from rest of "tip" and "dorsum": (2,) mm, x backward and z upward.

    Raises:
        InputError: as :func:`tracked_nodes`.
    """
    moved = posture.displacements
    return {name: np.asarray(moved[node, [0, 2]] * 1e3) for name, node in tracked_nodes(posture.speaker).items()}
