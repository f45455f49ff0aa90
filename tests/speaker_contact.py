"""What the tests of contact and hyoid on whole speakers share: scenes, postures, balances of forces."""

from __future__ import annotations

from functools import cache

import numpy as np
from tests.blocks import FloatArray

from glossa import MUSCLES, VOWELS, Posture, Scene, Speaker

FRICTIONS = (0.0, 0.1)
REFLEX_ONLY = dict.fromkeys(MUSCLES, 1.0)
"""Commands equal to the lengths at rest."""


@cache
def scene_of(speaker: Speaker, friction: float, mirror: bool = True, gravity: str = "upright") -> Scene:
    return Scene(speaker, friction=friction, mirror=mirror, gravity=gravity)


@cache
def vowel_of(speaker: Speaker, friction: float, vowel: str, mirror: bool = True) -> Posture:
    """From rest."""
    return scene_of(speaker, friction, mirror).equilibrate(VOWELS[vowel])


def largest(difference: FloatArray) -> float:
    """Largest length of (…, 3) vectors."""
    return float(np.linalg.norm(difference, axis=-1).max())


def mass(scene: Scene) -> float:
    """Of the tongue at rest, kg: each hexahedron by 2 x 2 x 2 Gauss points."""
    corners = np.array(
        [[-1, -1, -1], [1, -1, -1], [1, 1, -1], [-1, 1, -1], [-1, -1, 1], [1, -1, 1], [1, 1, 1], [-1, 1, 1]]
    )
    nodes = scene.speaker.nodes[scene.speaker.hexahedra]
    volume = 0.0
    for point in corners / np.sqrt(3.0):
        grown = 1.0 + corners * point
        slopes = corners * np.stack(
            [grown[:, 1] * grown[:, 2], grown[:, 0] * grown[:, 2], grown[:, 0] * grown[:, 1]], axis=1
        )
        volume += float(np.linalg.det(np.einsum("hai,aj->hij", nodes, slopes / 8.0)).sum())
    return float(scene.tissue.density * volume)


def tongue_balance(scene: Scene, posture: Posture) -> FloatArray:
    """(3,) N: supports, walls and weight on the tongue, which cancel in an equilibrium."""
    assert posture.contact is not None
    supports = sum((posture.reactions(name) for name in ("jaw", "hyoid", "styloid")), start=np.zeros(3))
    weight = np.zeros(3) if scene.gravity is None else mass(scene) * np.asarray(scene.gravity)
    return np.asarray(supports + posture.contact.forces.to_numpy().sum(axis=0) + weight)


def bone_balance(scene: Scene, posture: Posture) -> tuple[FloatArray, FloatArray]:
    """Force (3,) N and moment (3,) Nm on the hyoid from springs, weight and tongue, from its pose alone."""
    bone, pose = posture.speaker.hyoid, posture.hyoid
    assert bone is not None
    assert pose is not None
    assert posture.support_forces is not None
    centre = bone.centre + pose.displacement
    force = np.zeros(3) if scene.gravity is None else bone.mass * np.asarray(scene.gravity)
    moment = np.zeros(3)
    for spring in bone.springs:
        end = pose.moved(spring.on_hyoid)
        length = float(np.linalg.norm(spring.fixed - end))
        pull = spring.stiffness * (length - spring.rest_length) * (spring.fixed - end) / length
        force, moment = force + pull, moment + np.cross(end - centre, pull)
    tied = posture.speaker.node_sets["hyoid"]
    pulls = -posture.support_forces[tied]
    return force + pulls.sum(axis=0), moment + np.cross(posture.positions[tied] - centre, pulls).sum(axis=0)


def touched(posture: Posture, wall: str) -> FloatArray:
    """(k, 3) m: points under pressure at a wall."""
    assert posture.contact is not None
    return posture.contact.points[posture.contact.at_wall(wall) & posture.contact.touching]


def on_both_sides(points: FloatArray) -> bool:
    """Some at y > 0 and some at y < 0."""
    return bool((points[:, 1] > 0.0).any() and (points[:, 1] < 0.0).any())
