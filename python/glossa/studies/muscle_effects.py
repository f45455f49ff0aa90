"""What each muscle does alone, in the words of section III.A.1: regions, directions and millimetres beside the paper's.

The paper names regions without bounds and gives one number for each. Here a region is a stretch of the midsagittal
outline or of one side's surface, its number is the largest displacement in the stated direction, and the direction is
right when the region's mean displacement has it. Displacements are from the shape at rest, from which the paper's
movements started, so that they contain what gravity does.
"""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np
import pandas as pd

from glossa import paper
from glossa.anatomy.arrays import FloatArray, IntArray
from glossa.anatomy.speaker import Speaker
from glossa.anatomy.swept_surface import chord_lengths
from glossa.errors import InputError
from glossa.results import Posture
from glossa.scene import Scene
from glossa.studies.points import tracked_nodes
from glossa.studies.single_muscle import single_muscles

SHARE, LEAST = 0.4, 1.0
"""A magnitude agrees within this share of the paper's, or within so many mm, whichever is more."""

_AROUND_TOP = 0.012  # m along the outline on each side of the dorsum's highest node
_REAR_DEPTH, _REAR_HEIGHT = 0.008, 0.020  # m in front of, above and below the rearmost node
_APEX_DEPTH = 0.012  # m behind the tip
_UPPER = 0.019  # m below the dorsum's highest node
_PHARYNX = 0.110  # m: surface behind this is pharyngeal
_FLOOR = 0.075  # m: midsagittal nodes below this are mouth floor
_OFF_MIDLINE = 0.005  # m

_AXES: Mapping[str, tuple[int, float]] = {
    "backward": (0, 1.0),
    "forward": (0, -1.0),
    "up": (2, 1.0),
    "down": (2, -1.0),
    "wider": (1, 1.0),
    "narrower": (1, -1.0),
}


def muscle_effects(scene: Scene, postures: Mapping[str, Posture] | None = None) -> pd.DataFrame:
    """Every sentence of section III.A.1 beside the posture of that muscle alone, at the paper's command.

    Args:
        scene: of a speaker with the muscles of Table III, the contour "dorsum" and a mobile hyoid; the paper's has
            upright gravity and contact.
        postures: of :func:`glossa.studies.single_muscles` in this scene; None: they are computed.

    Returns:
        The rows of :func:`glossa.paper.single_muscles` with ``ours_mm`` (largest displacement in that direction),
        ``mean_mm``, ``right`` (its mean has the direction) and ``agrees`` (magnitude within 40 % or 1 mm; for "below",
        at most 1 mm above; None where the paper gives no number).

    Raises:
        InputError: a muscle, contour or hyoid that is missing.
        SolveError, SolveInterrupted: as :meth:`glossa.Scene.equilibrate`.
    """
    table = paper.single_muscles()
    regions = _Regions(scene.speaker)
    if postures is None:
        postures = single_muscles(scene, dict.fromkeys(table["muscle"]))
    found = [
        regions.displacements_mm(postures[str(row.muscle)], str(row.region), str(row.direction))
        for row in table.itertuples()
    ]
    table["ours_mm"] = [float(values.max()) for values in found]
    # how far a side widens is told by its widest place, not by its mean
    lateral = table["direction"].isin(["wider", "narrower"]) | (table["region"] == "mouth_floor")
    table["mean_mm"] = np.where(lateral, table["ours_mm"], [float(values.mean()) for values in found])
    table["right"] = table["mean_mm"] > 0.0
    table["agrees"] = [
        _agrees(ours, bound, wanted)
        for ours, bound, wanted in zip(table["ours_mm"], table["bound"], table["displacement_mm"], strict=True)
    ]
    return table


def _agrees(ours: float, bound: str, wanted: float) -> bool | None:
    if np.isnan(wanted):
        return None
    if bound == "below":
        return ours < wanted + LEAST
    return abs(ours - wanted) <= max(SHARE * wanted, LEAST)


class _Regions:
    """The regions of one speaker."""

    def __init__(self, speaker: Speaker) -> None:
        if "dorsum" not in speaker.contours:
            raise InputError("the effects of single muscles need a speaker with the contour 'dorsum'")
        contour = speaker.contours["dorsum"]
        x, _, z = speaker.nodes[contour].T
        tip, top = int(x.argmin()), int(z.argmax())
        behind = np.arange(len(contour)) > top
        rear = int(np.where(behind, x, -np.inf).argmax())
        along = chord_lengths(np.stack([x, z], axis=1))
        number = np.arange(len(contour))
        apex = tracked_nodes(speaker)["tip"]
        self._lines: dict[str, IntArray] = {
            "apex": np.array([apex], dtype=np.int32),
            "palatal": contour[(number > tip) & (number <= top)],
            "dorsum": contour[np.abs(along - along[top]) < _AROUND_TOP],
            "pharyngeal": contour[behind & (x > x[rear] - _REAR_DEPTH) & (np.abs(z - z[rear]) < _REAR_HEIGHT)],
            "tongue": contour[(number > tip) & (along < along[top] + _AROUND_TOP)],
            "mouth_floor": speaker.midsagittal_nodes[speaker.nodes[speaker.midsagittal_nodes, 2] < _FLOOR],
        }
        x, y, z = speaker.nodes.T
        side = np.isin(np.arange(len(x)), speaker.surface_quads) & (y > _OFF_MIDLINE)
        upper = z > speaker.nodes[contour, 2].max() - _UPPER
        places = {
            "apex": x < speaker.nodes[apex, 0] + _APEX_DEPTH,
            "pharyngeal": x > _PHARYNX,
            "dorsum": upper,
            "superior": upper,
            "tongue": side,
        }
        self._sides = {name: np.flatnonzero(side & inside) for name, inside in places.items()}

    def displacements_mm(self, posture: Posture, region: str, direction: str) -> FloatArray:
        """(k,) displacements from rest in ``direction`` of the nodes of ``region``, mm."""
        axis, sign = _AXES[direction]
        if region == "hyoid":
            if posture.hyoid is None:
                raise InputError("the effects of single muscles need a mobile hyoid")
            moved = posture.hyoid.displacement[None]
        else:
            nodes = self._sides[region] if axis == 1 else self._lines[region]
            moved = posture.displacements[nodes]
        return np.asarray(1e3 * sign * moved[:, axis])
