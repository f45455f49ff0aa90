"""Whether an adapted speaker can be used: the map, the elements, the walls, and the tongue between them at rest.

Each failure names the place, on the speaker before, and the landmark nearest to it.
"""

from __future__ import annotations

import logging
from dataclasses import dataclass

import numpy as np

from glossa.anatomy import hexahedra as hexa
from glossa.anatomy.arrays import FloatArray, place_mm
from glossa.anatomy.clearance import clearances
from glossa.anatomy.quality import GOOD_JACOBIAN, LEAST_JACOBIAN, NOTED_OVERLAP
from glossa.anatomy.speaker import Speaker
from glossa.anatomy.wall_checks import DEEPEST_OVERLAP, triangle_normals
from glossa.anatomy.walls import Wall
from glossa.anatomy.warp import Warp
from glossa.errors import InputError

LEAST_SHARE = 0.6
"""Of its scaled Jacobian before: an element that keeps it is not refused below LEAST_JACOBIAN, and a speaker whose
smallest keeps it is not warned of."""

_ADVICE = "check these targets and their neighbours, and that x runs front to back, y to the right and z up"
log = logging.getLogger(__name__)


@dataclass(frozen=True, eq=False)
class Moves:
    """What moved whither, to be named in messages.

    Attributes:
        names: (n,) of the points.
        points: (n, 3) m.
        targets: (n, 3) m.
    """

    names: tuple[str, ...]
    points: FloatArray
    targets: FloatArray

    def near(self, place: FloatArray) -> str:
        """A place, the point nearest to it, and how far that moved against the mean of all."""
        distances = np.linalg.norm(self.points - place, axis=1)
        n = int(distances.argmin())
        moves = (self.targets - self.points) * 1e3
        own = np.linalg.norm(moves[n] - moves.mean(axis=0))
        return (
            f"{place_mm(place)}; nearest to it, {distances[n] * 1e3:.0f} mm away, is {self.names[n]}, which "
            f"moved by {place_mm(moves[n] / 1e3)}, {own:.1f} mm off the mean of all points"
        )


def check_map(warp: Warp, speaker: Speaker, moves: Moves) -> None:
    """The map keeps the orientation of space at every node.

    Raises:
        InputError: it folds space over.
    """
    determinants = np.linalg.det(warp.gradient(speaker.nodes))
    worst = int(determinants.argmin())
    if determinants[worst] <= 0.0:
        raise InputError(
            f"the map from the speaker to the targets folds over at {moves.near(speaker.nodes[worst])}: {_ADVICE}"
        )


def check_elements(speaker: Speaker, nodes: FloatArray, moves: Moves) -> None:
    """No element is inside out or nearly so; a mesh that gets much worse is warned of.

    Raises:
        InputError: an inverted element, or a scaled Jacobian below LEAST_JACOBIAN.
    """
    cells = speaker.hexahedra
    determinants = [values(nodes, cells).min(axis=1) for values in (hexa.corner_determinants, hexa.gauss_determinants)]
    worst = int(np.minimum(*determinants).argmin())
    if min(part[worst] for part in determinants) <= 0.0:
        where = moves.near(speaker.nodes[cells[worst]].mean(axis=0))
        raise InputError(f"the targets turn hexahedron {worst} inside out, at {where}: {_ADVICE}")
    before, after = speaker.scaled_jacobians, hexa.scaled_jacobians(nodes, cells)
    poor = np.flatnonzero((after < LEAST_JACOBIAN) & (after < LEAST_SHARE * before))
    if len(poor):
        worst = int(poor[after[poor].argmin()])
        where = moves.near(speaker.nodes[cells[worst]].mean(axis=0))
        raise InputError(
            f"the targets distort hexahedron {worst} to a scaled Jacobian of {after[worst]:.3f} (before: "
            f"{before[worst]:.3f}; at least {LEAST_JACOBIAN:g} is needed), at {where}: {_ADVICE}"
        )
    least = float(after.min())
    if least < LEAST_SHARE * before.min() or least < GOOD_JACOBIAN <= before.min():
        log.warning(
            "smallest scaled Jacobian %.2f (before: %.2f), at %s",
            least,
            before.min(),
            moves.near(speaker.nodes[cells[int(after.argmin())]].mean(axis=0)),
        )


def check_surface(name: str, before: Wall, after: Wall, warp: Warp, moves: Moves) -> None:
    """No triangle of a wall or bone is turned over against the space around it.

    Raises:
        InputError: the surface folds.
    """
    triangles = before.triangles
    centres = before.vertices[triangles].mean(axis=1)
    turned = np.linalg.solve(
        np.swapaxes(warp.gradient(centres), 1, 2), triangle_normals(before.vertices[triangles])[:, :, None]
    )
    agreement = (turned[:, :, 0] * triangle_normals(after.vertices[triangles])).sum(axis=1)
    worst = int(agreement.argmin())
    if agreement[worst] <= 0.0:
        raise InputError(f"the targets fold {name} over at {moves.near(centres[worst])}: {_ADVICE}")


def check_overlap(before: Speaker, after: Speaker, scale: float, moves: Moves) -> None:
    """The tongue at rest does not stand deep in a wall, or hardly deeper than before.

    Args:
        before: the speaker.
        after: the adapted one.
        scale: between them: an overlap grows with the speaker.
        moves: for messages.

    Raises:
        InputError: an overlap of more than DEEPEST_OVERLAP, which contact cannot clear.
    """
    deep = {name: clear for name, clear in clearances(after).items() if clear.least < -NOTED_OVERLAP}
    usual = clearances(before) if deep else {}
    for name, clear in deep.items():
        if name in usual and clear.least >= scale * usual[name].least - NOTED_OVERLAP:
            continue
        own = before.nodes[int(((after.nodes - clear.place) ** 2).sum(axis=1).argmin())]  # what has moved there
        what = f"the adapted tongue at rest stands {-clear.least * 1e3:.1f} mm deep in wall {name!r}, at"
        if clear.least < -DEEPEST_OVERLAP:
            raise InputError(
                f"{what} {moves.near(own)}; at most {DEEPEST_OVERLAP * 1e3:g} mm can be cleared: {_ADVICE}"
            )
        log.warning("%s %s", what, moves.near(own))
