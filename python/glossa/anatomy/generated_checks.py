"""Whether landmarks give a sound speaker. Each failure names what, where, and which changes to take back."""

from __future__ import annotations

import logging
from collections.abc import Mapping

import numpy as np

from glossa import _core
from glossa.anatomy import hexahedra as hexa
from glossa.anatomy.arrays import FloatArray, IntArray, place_mm
from glossa.anatomy.clearance import Clearance, clearances
from glossa.anatomy.landmarks import COLUMNS, LAYERS
from glossa.anatomy.quality import GOOD_JACOBIAN, LEAST_JACOBIAN, quality_of
from glossa.anatomy.reference_block import Block
from glossa.anatomy.speaker import Speaker
from glossa.anatomy.speaker_landmarks import SpeakerLandmarks
from glossa.anatomy.wall_checks import DEEPEST_OVERLAP, INTERIOR, check_wall, triangle_edges, triangle_normals
from glossa.anatomy.walls import Wall
from glossa.errors import InputError

log = logging.getLogger(__name__)

NEAR_MIDLINE = 3e-3
"""Distance from the midplane within which the airway must be open, m."""

LEAST_BEND = -0.5
"""Cosine of the angle between the normals of neighbouring triangles of a wall: one that turns farther is folded."""

_ROOF = ("hard_palate", "soft_palate", "pharynx")
_TUBE = "larynx"


def check_mesh(block: Block, nodes: FloatArray, hexahedra: IntArray, landmarks: SpeakerLandmarks) -> None:
    """No element too distorted.

    Raises:
        InputError: a scaled Jacobian below LEAST_JACOBIAN.
    """
    jacobians = hexa.scaled_jacobians(nodes, hexahedra)
    worst = int(jacobians.argmin())
    if jacobians[worst] >= LEAST_JACOBIAN:
        return
    r = block.resolution
    i, rest = divmod(worst, LAYERS * r * 2 * COLUMNS * r)
    j, k = divmod(rest, 2 * COLUMNS * r)
    index = ", ".join(f"{value / r:g}" for value in (i, j, k - COLUMNS * r))
    where = place_mm(nodes[hexahedra[worst]].mean(axis=0))
    raise InputError(
        f"{landmarks.name}: hexahedron {worst} at ray, layer, column ({index}), {where}, is "
        f"too distorted: scaled Jacobian {jacobians[worst]:.3f}, at least {LEAST_JACOBIAN} is needed and the built-in "
        f"speaker keeps {GOOD_JACOBIAN}{_advice(landmarks)}"
    )


def check_rest(speaker: Speaker, landmarks: SpeakerLandmarks) -> None:
    """Sound walls, a tongue that clears them, and an airway that is open at rest; warns where quality falls short.

    Raises:
        InputError: anything else.
    """
    for name, wall in speaker.walls.items():
        _check_folds(name, wall, landmarks)
    clear = clearances(speaker)
    for name, room in clear.items():
        if room.least < -DEEPEST_OVERLAP:
            raise InputError(
                f"{landmarks.name}: the tongue at rest overlaps wall {name} by {-room.least * 1e3:.1f} mm at "
                f"{place_mm(room.place)}; at most {DEEPEST_OVERLAP * 1e3:g} mm can be cleared{_advice(landmarks)}"
            )
    _check_airway(speaker, clear, landmarks)
    for note in quality_of(speaker, clear).notes:
        log.warning("%s: %s", speaker.name, note)


def _check_folds(name: str, wall: Wall, landmarks: SpeakerLandmarks) -> None:
    """Faces that have an area; no wall turns back over itself, except the larynx at its two seams."""
    try:
        check_wall(name, wall)
    except InputError as error:
        raise InputError(f"{landmarks.name}: {error}{_advice(landmarks)}") from None
    if name == _TUBE:
        return
    normals = triangle_normals(wall.vertices[wall.triangles])
    normals /= np.linalg.norm(normals, axis=1, keepdims=True)
    edges, of_side, count = triangle_edges(wall.triangles)
    side = np.argsort(of_side.ravel(), kind="stable")  # sides of one edge stand together
    shared = np.flatnonzero(count[of_side.ravel()[side]] == 2)
    pairs = side[shared].reshape(-1, 2)
    bend = (normals[pairs[:, 0] // 3] * normals[pairs[:, 1] // 3]).sum(axis=1)
    worst = int(bend.argmin())
    if bend[worst] < LEAST_BEND:
        edge = edges[of_side.ravel()[pairs[worst, 0]]]
        where = place_mm(wall.vertices[edge].mean(axis=0))
        raise InputError(
            f"{landmarks.name}: wall {name} is folded over itself at {where}: its landmarks bend too "
            f"sharply{_advice(landmarks)}"
        )


def _check_airway(speaker: Speaker, clear: Mapping[str, Clearance], landmarks: SpeakerLandmarks) -> None:
    """Open on the midline between tongue and roof, hyoid and rear wall, and in the larynx."""
    for name in _ROOF:
        if name in clear:
            _check_open("tongue", name, clear[name].points, clear[name].distances, landmarks)
    if speaker.hyoid is not None and speaker.hyoid.surface is not None:
        bone = speaker.hyoid.surface.vertices
        wall = speaker.walls["pharynx"]
        distances, _, kinds, _ = _core.nearest_features(wall.vertices, wall.triangles, bone)
        facing = kinds == INTERIOR
        _check_open("hyoid bone", "pharynx", bone[facing], distances[facing], landmarks)
    vertices = speaker.walls[_TUBE].vertices
    rear, front = np.moveaxis(vertices[vertices[:, 1] == 0.0].reshape(-1, 2, 3), 1, 0)  # each row starts at the rear
    _check_open("front wall", _TUBE, front, rear[:, 0] - front[:, 0], landmarks)


def _check_open(what: str, wall: str, points: FloatArray, distances: FloatArray, landmarks: SpeakerLandmarks) -> None:
    middle = np.abs(points[:, 1]) < NEAR_MIDLINE
    points, distances = points[middle], distances[middle]
    if len(points) and distances.min() <= 0.0:
        raise InputError(
            f"{landmarks.name}: the airway is closed at rest: on the midline the {what} reaches wall {wall}, at "
            f"{place_mm(points[distances.argmin()])}{_advice(landmarks)}"
        )


def _advice(landmarks: SpeakerLandmarks) -> str:
    return f"; change less of: {', '.join(landmarks.changes)}" if landmarks.changes else ""
