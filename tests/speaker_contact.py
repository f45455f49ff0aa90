"""What the tests of contact and hyoid on whole speakers share: balances of forces, fine samples of the surface."""

from __future__ import annotations

from functools import cache

import numpy as np
from tests.blocks import FloatArray

from glossa import MUSCLES, VOWELS, Posture, Scene, Speaker
from glossa.anatomy.hexahedra import matching_faces
from glossa.anatomy.surface_sampling import surface_samples
from glossa.contact_points import LEAST_MOBILITY, contact_points

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


class FineSurface:
    """Samples of every contact face every millimetre: more than six times the points that the solver sees."""

    def __init__(self, speaker: Speaker) -> None:
        held = np.zeros(len(speaker.nodes), dtype=bool)
        held[speaker.node_sets["jaw"]] = True
        self._fields = dict(zip(speaker.walls, contact_points(speaker, held, mirror=False).fields, strict=True))
        self._samples = {}
        for wall, faces in speaker.contact_faces.items():
            numbers = matching_faces(faces, speaker.surface_quads)
            samples = surface_samples(speaker.smooth_surface, numbers, 1e-3)
            mobile = np.flatnonzero(samples.operator @ (~held).astype(float) > LEAST_MOBILITY)
            operator = samples.operator[mobile]
            overlap = np.maximum(0.0, -self._fields[wall].distance(operator @ speaker.nodes))
            self._samples[wall] = (operator, overlap)

    def depths(self, posture: Posture, wall: str) -> FloatArray:
        """(k,) m: how deep each sample is in the wall, overlap at rest left out; 0 outside."""
        operator, overlap = self._samples[wall]
        return np.asarray(np.maximum(0.0, -self._fields[wall].distance(operator @ posture.positions) - overlap))

    def points(self, posture: Posture, wall: str) -> FloatArray:
        """(k, 3) m."""
        return np.asarray(self._samples[wall][0] @ posture.positions)

    @property
    def walls(self) -> tuple[str, ...]:
        """With contact faces."""
        return tuple(self._samples)


@cache
def fine_surface(speaker: Speaker) -> FineSurface:
    """Made once for each speaker."""
    return FineSurface(speaker)


def touched(posture: Posture, wall: str) -> FloatArray:
    """(k, 3) m: points under pressure at a wall."""
    assert posture.contact is not None
    return posture.contact.points[posture.contact.at_wall(wall) & posture.contact.touching]


def on_both_sides(points: FloatArray) -> bool:
    """Some at y > 0 and some at y < 0."""
    return bool((points[:, 1] > 0.0).any() and (points[:, 1] < 0.0).any())
