"""A speaker adapted to the measured points of a subject.

Everything is warped by one smooth map of space (glossa.anatomy.warp); numbering, muscles, sets and faces stay. Left and
right are kept mirror images, unless the targets say otherwise.
"""

from __future__ import annotations

import logging
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np
from scipy.spatial import cKDTree

from glossa.anatomy.adaptation_checks import Moves, check_elements, check_map, check_overlap, check_surface
from glossa.anatomy.arrays import FloatArray, float_array
from glossa.anatomy.landmark_points import LATERAL, SIDES, landmark_points
from glossa.anatomy.solid import solid
from glossa.anatomy.speaker import Speaker
from glossa.anatomy.walls import Hyoid, Spring, Wall
from glossa.anatomy.warp import Warp, best_similarity
from glossa.errors import InputError

LEAST_DISTANCE = 0.2e-3
"""Points nearer than this are one, m."""

FARTHEST = 1.0
"""Coordinate of a target beyond which it cannot be in metres, m."""

LARGEST_SCALE = 3.0
"""Of a subject over the speaker, or the inverse."""

LARGEST_TURN = np.radians(45.0)
"""Between the frames of subject and speaker."""

SAME = 1e-6
"""Targets that are mirror images but for this are meant to be, m."""

_REFLECTION = np.array([1.0, -1.0, 1.0])
_MIDPLANE = 1e-9  # m; as in Speaker
log = logging.getLogger(__name__)


@dataclass(frozen=True, eq=False)
class Correspondences:
    """Points of a speaker and where they belong in the subject.

    Attributes:
        names: (n,) for messages.
        points: (n, 3) m.
        targets: (n, 3) m.
        symmetric: both are their own mirror images about y = 0, exactly.
    """

    names: tuple[str, ...]
    points: FloatArray
    targets: FloatArray
    symmetric: bool


def adapted_speaker(speaker: Speaker, landmarks: Mapping[str, Any], points: Any, name: str | None) -> Speaker:
    """See ``Speaker.adapted_to``."""
    given = correspondences(speaker, landmarks, points)
    moves = Moves(given.names, given.points, given.targets)
    bone = None if speaker.hyoid is None else speaker.hyoid.surface
    surfaces = dict(speaker.walls) | ({} if bone is None else {"the hyoid bone": bone})
    reach = np.concatenate([speaker.nodes, *(surface.vertices for surface in surfaces.values())])
    warp = Warp(given.points, given.targets, reach, symmetric=given.symmetric)
    check_map(warp, speaker, moves)
    ends = [np.zeros((0, 3))] if speaker.hyoid is None else _hyoid_points(speaker.hyoid)
    cuts = np.cumsum([len(speaker.nodes), *(len(surface.vertices) for surface in surfaces.values())])
    nodes, *vertices, ends_moved = np.split(warp(np.concatenate([reach, *ends])), cuts)
    check_elements(speaker, nodes, moves)
    warped = {}
    for (key, surface), places in zip(surfaces.items(), vertices, strict=True):
        warped[key] = Wall(places, surface.faces)
        check_surface(f"wall {key!r}" if key in speaker.walls else key, surface, warped[key], warp, moves)
    hyoid = speaker.hyoid
    if hyoid is not None:
        hyoid = _hyoid(hyoid, warped.get("the hyoid bone"), ends_moved, symmetric=given.symmetric)
    built = Speaker(
        nodes,
        speaker.hexahedra,
        muscles=speaker.muscles,
        node_sets=speaker.node_sets,
        walls={key: warped[key] for key in speaker.walls},
        hyoid=hyoid,
        contours=speaker.contours,
        name=f"{speaker.name or 'speaker'}, adapted" if name is None else name,
        contact_faces=speaker.contact_faces,
    )
    check_overlap(speaker, built, warp.scale, moves)
    log.info(
        "%s: %s trend, scale %.3f, volume %.1f cm3 (before: %.1f), smallest scaled Jacobian %.2f (before: %.2f)",
        *(built.name, warp.trend, warp.scale, built.volume * 1e6, speaker.volume * 1e6),
        *(built.scaled_jacobians.min(), speaker.scaled_jacobians.min()),
    )
    if not given.symmetric:
        log.info("%s: the targets are not mirror symmetric about y = 0, and so the speaker is not", built.name)
    return built


def correspondences(speaker: Speaker, landmarks: Mapping[str, Any], points: Any = None) -> Correspondences:
    """Checked points and targets with their mirror images.

    Raises:
        InputError: see ``Speaker.adapted_to``.
    """
    if not isinstance(landmarks, Mapping):
        raise InputError(f"landmarks must be a mapping from names to points in m, got {type(landmarks).__name__}")
    known = landmark_points(speaker) if landmarks else {}
    names, sources, targets = _named(known, landmarks)
    free, goals = _free(points)
    names += [f"point {number}" for number in range(len(free))]
    if not names:
        raise InputError(
            "adapted_to needs at least one landmark or point; glossa.anatomy.landmark_points(speaker) lists landmarks"
        )
    sources, targets = np.concatenate([sources, free]), np.concatenate([targets, goals])
    _check_units(names, targets)
    names, sources, targets = _both_sides(known, names, sources, targets)
    sources, targets, symmetric = _symmetrised(sources, targets)
    pairs = cKDTree(sources).query_pairs(LEAST_DISTANCE, output_type="ndarray")
    if len(pairs):
        a, b = sorted(pairs[np.lexsort(pairs.T[::-1])[0]].tolist())
        raise InputError(
            f"{names[a]} and {names[b]} are {np.linalg.norm(sources[a] - sources[b]) * 1e3:.3f} mm apart on the "
            f"speaker; points must be at least {LEAST_DISTANCE * 1e3:g} mm apart: leave one of them out"
        )
    _check_frame(sources, targets)
    return Correspondences(tuple(names), sources, targets, symmetric)


def _named(known: Mapping[str, FloatArray], landmarks: Mapping[str, Any]) -> tuple[list[str], FloatArray, FloatArray]:
    """Names, points and targets of landmarks, from all that the speaker has (name -> (3,) m)."""
    sources, targets = [np.zeros((0, 3))], [np.zeros((0, 3))]
    for name, value in landmarks.items():
        if name not in known:
            raise InputError(f"this speaker has no landmark {name!r}; it has {', '.join(known) or 'none'}")
        target = float_array(value, f"landmark {name!r}")
        stem, _, side = name.rpartition("_")
        lateral = stem in LATERAL and side in SIDES
        if len(target) == 2 and not lateral:
            target = np.array([target[0], 0.0, target[1]])
        if len(target) != 3:
            expected = "x, y, z" if lateral else "x, y, z (or x, z: in the midsagittal plane)"
            raise InputError(f"landmark {name!r}: expected the coordinates {expected} in m, got {len(target)} numbers")
        if lateral and target[1] * SIDES[side] <= 0.0:
            raise InputError(
                f"landmark {name!r}: y = {target[1]:g} m is on the other side; left is y < 0, right is y > 0"
            )
        sources.append(known[name][None])
        targets.append(target[None])
    return list(landmarks), np.concatenate(sources), np.concatenate(targets)


def _free(points: Any) -> tuple[FloatArray, FloatArray]:
    if points is None:
        return np.zeros((0, 3)), np.zeros((0, 3))
    if not isinstance(points, tuple | list) or len(points) != 2:
        raise InputError("points must be a pair of arrays (n, 3): points of the speaker, points of the subject, in m")
    source, target = (
        float_array(part, f"points, {what}", 3) for part, what in zip(points, ("first", "second"), strict=True)
    )
    if len(source) != len(target):
        raise InputError(
            f"points: {len(source)} points of the speaker and {len(target)} of the subject; they are pairs"
        )
    return source, target


def _check_units(names: list[str], targets: FloatArray) -> None:
    size = np.abs(targets).max(axis=1)
    worst = int(size.argmax())
    if size[worst] > FARTHEST:
        raise InputError(
            f"{names[worst]} is to go to {np.round(targets[worst], 3).tolist()}, {size[worst]:.3g} m from the origin; "
            f"coordinates are in metres: divide millimetres by 1000"
        )


def _check_frame(sources: FloatArray, targets: FloatArray) -> None:
    """A subject that is far larger, smaller or turned is in another unit or frame."""
    spread = [float(np.sqrt(((part - part.mean(axis=0)) ** 2).sum())) for part in (sources, targets)]
    if spread[0] == 0.0 or len(sources) < 3:
        return
    ratio = spread[1] / spread[0]
    if not 1.0 / LARGEST_SCALE <= ratio <= LARGEST_SCALE:
        raise InputError(
            f"the targets lie {ratio:.3g} times as far apart as the points of the speaker; coordinates are in metres"
        )
    turn = float(np.angle(best_similarity(sources, targets).factor))
    if abs(turn) > LARGEST_TURN:
        raise InputError(
            f"the targets are turned by {np.degrees(turn):.0f} degrees about the lateral axis against the speaker; "
            f"coordinates are x front to back, y to the right, z up"
        )


def _both_sides(
    known: Mapping[str, FloatArray], names: list[str], sources: FloatArray, targets: FloatArray
) -> tuple[list[str], FloatArray, FloatArray]:
    """With the other side of landmarks given on one side only, and of free points that all lie on one side."""
    free = np.array([name.startswith("point ") for name in names])
    y = sources[free, 1]
    one_sided = bool((y >= -_MIDPLANE).all() or (y <= _MIDPLANE).all())
    more: list[tuple[str, FloatArray, FloatArray]] = []
    for number, name in enumerate(names):
        stem, _, side = name.rpartition("_")
        source, target = sources[number], targets[number]
        if free[number]:
            if one_sided and abs(source[1]) > _MIDPLANE:
                more.append((f"{name} mirrored", source * _REFLECTION, target * _REFLECTION))
        elif stem in LATERAL and side in SIDES:
            other = f"{stem}_{'left' if side == 'right' else 'right'}"
            if other not in names:
                more.append((other, known.get(other, source * _REFLECTION), target * _REFLECTION))
    if not more:
        return names, sources, targets
    extra = [np.stack([row[column] for row in more]) for column in (1, 2)]
    return (
        names + [row[0] for row in more],
        np.concatenate([sources, extra[0]]),
        np.concatenate([targets, extra[1]]),
    )


def _symmetrised(sources: FloatArray, targets: FloatArray) -> tuple[FloatArray, FloatArray, bool]:
    """Points and targets made exact mirror images where they are so within SAME; whether they are."""
    both = np.concatenate([sources, targets], axis=1)
    reflection = np.tile(_REFLECTION, 2)
    distance, partner = cKDTree(both).query(both * reflection, p=np.inf)
    if distance.max() > SAME or (partner[partner] != np.arange(len(both))).any():
        return sources, targets, False
    both = 0.5 * (both + both[partner] * reflection)
    return both[:, :3], both[:, 3:], True


def _hyoid_points(hyoid: Hyoid) -> list[FloatArray]:
    """Centre of mass and ends of the springs, (1 + 2 k, 3) m in pieces."""
    return [hyoid.centre[None], *(np.stack([spring.on_hyoid, spring.fixed]) for spring in hyoid.springs)]


def _hyoid(hyoid: Hyoid, surface: Wall | None, moved: FloatArray, *, symmetric: bool) -> Hyoid:
    """Mass by volume, at the same density; the centre of mass moves as that of the enclosed volume.

    Args:
        hyoid: before.
        surface: after.
        moved: ``_hyoid_points`` after.
        symmetric: the centre stays at its y.
    """
    mass, centre = hyoid.mass, moved[0]
    if surface is not None and hyoid.surface is not None:
        before, after = solid(hyoid.surface), solid(surface)
        mass *= after[0] / before[0]
        centre = hyoid.centre + (after[1] - before[1])
        if symmetric:
            centre[1] = hyoid.centre[1]
    ends = moved[1:].reshape(-1, 2, 3)
    return Hyoid(surface, mass, centre, tuple(map(_spring, hyoid.springs, ends)))


def _spring(spring: Spring, ends: FloatArray) -> Spring:
    """The spring between new ends, as slack or taut as before."""
    before = float(np.linalg.norm(spring.fixed - spring.on_hyoid))
    length = float(np.linalg.norm(ends[1] - ends[0]))
    rest = None if np.isclose(spring.rest_length, before) else spring.rest_length * length / before
    return Spring(ends[0], ends[1], spring.stiffness, rest, spring.name)
