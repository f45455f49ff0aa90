"""The mobile hyoid: a rigid bone as extra nodes of the body, and its pose in results."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from glossa.anatomy.arrays import FloatArray, IntArray
from glossa.anatomy.mirror import TOLERANCE
from glossa.anatomy.speaker import Speaker
from glossa.anatomy.walls import Hyoid, Spring, Wall
from glossa.errors import InputError


@dataclass(frozen=True, eq=False)
class HyoidPose:
    """Where the hyoid bone is.

    Attributes:
        displacement: (3,) m, of its centre from rest.
        rotation: (3,) rotation vector about the centre, rad.
        centre: (3,) m, of the bone at rest.
    """

    displacement: FloatArray
    rotation: FloatArray
    centre: FloatArray

    def moved(self, points: FloatArray) -> FloatArray:
        """(…, 3) m: where points of the bone at rest are now."""
        arms = np.asarray(points, dtype=float) - self.centre
        return np.asarray(self.centre + self.displacement + arms @ _rotation_matrix(self.rotation).T)

    def __repr__(self) -> str:
        d, r = self.displacement * 1e3, np.degrees(self.rotation)
        return f"HyoidPose({d[0]:.2f}, {d[1]:.2f}, {d[2]:.2f} mm; {r[0]:.2f}, {r[1]:.2f}, {r[2]:.2f} degrees)"


@dataclass(frozen=True, eq=False)
class HyoidCourse:
    """Pose of the hyoid over time; t frames.

    Attributes:
        displacements: (t, 3) m, of its centre from rest.
        rotations: (t, 3) rotation vectors about the centre, rad.
        centre: (3,) m, of the bone at rest.
    """

    displacements: FloatArray
    rotations: FloatArray
    centre: FloatArray

    def between(self, before: int, after: int, share: float) -> HyoidPose:
        """The pose between two frames, linearly; the angles are small."""
        mix = [
            (1.0 - share) * values[before] + share * values[after] for values in (self.displacements, self.rotations)
        ]
        return HyoidPose(mix[0], mix[1], self.centre)


class HyoidNodes:
    """Extra nodes that stand for a mobile hyoid in the core, after the k nodes of the body.

    In order: ends of the springs on the bone, their fixed ends, six point masses, the centre, the turn. The point
    masses have the mass, centre and second moments of the bone: on its principal axes through the centre, at distances
    sqrt(3 J_i / m), J_i the second moment along the axis. The turn holds the rotation vector times the root mean square
    distance of the tied nodes from the centre. In a mirrored half only what lies at y >= 0 is there, what lies in the
    midplane halved, and the bone keeps three degrees of freedom.

    Attributes:
        nodes: (e, 3) m, at rest.
        free: (e, 3) degrees of freedom of the pose.
        core: arrays for the core's constructor.
    """

    def __init__(self, hyoid: Hyoid, body_nodes: FloatArray, tied: IntArray, *, mirror: bool) -> None:
        springs = [_halved(spring, mirror) for spring in hyoid.springs if not mirror or _right(spring.on_hyoid)]
        masses, mass_points = _point_masses(hyoid, body_nodes[tied])
        if mirror:
            kept = mass_points[:, 1] > -TOLERANCE
            masses, mass_points = masses[kept], mass_points[kept]
            masses = np.where(mass_points[:, 1] > TOLERANCE, masses, 0.5 * masses)
        first, count = len(body_nodes), len(springs)
        ends = np.reshape([s.on_hyoid for s in springs], (-1, 3))
        fixed = np.reshape([s.fixed for s in springs], (-1, 3))
        self._centre = hyoid.centre
        self.nodes = np.concatenate([ends, fixed, mass_points, hyoid.centre[None], np.zeros((1, 3))])
        self.free = np.zeros((len(self.nodes), 3), dtype=bool)
        self.free[-2] = [True, not mirror, True]
        self.free[-1] = [not mirror, True, not mirror]
        on_bone = first + np.arange(count)
        mass_nodes = first + 2 * count + np.arange(len(masses))
        all_tied = np.concatenate([np.sort(tied), on_bone, mass_nodes]).astype(np.int32)
        self._tied = tied
        everything = np.concatenate([body_nodes, self.nodes])
        self._arm = float(np.sqrt(np.mean(np.sum((everything[all_tied] - hyoid.centre) ** 2, axis=1)))) or 1.0
        self._rest_arms = body_nodes[tied] - hyoid.centre
        self._mirror = mirror
        self.core: dict[str, Any] = {
            "tied": all_tied,
            "centre": first + len(self.nodes) - 2,
            "turn": first + len(self.nodes) - 1,
            "mass_node": mass_nodes.astype(np.int32),
            "mass": masses,
            "spring_on_bone": on_bone.astype(np.int32),
            "spring_fixed": (on_bone + count).astype(np.int32),
            "spring_stiffness": np.array([s.stiffness for s in springs], dtype=float),
            "spring_rest": np.array([s.rest_length for s in springs], dtype=float),
        }

    def appended(self, positions: FloatArray) -> FloatArray:
        """Positions (k, 3) of the body with those of the extra nodes: the pose that fits the tied nodes best."""
        pose = self._fitted(positions[self._tied])
        extra = np.array(self.nodes)
        extra[-2] += pose.displacement
        extra[-1] = self._arm * pose.rotation
        return np.concatenate([positions, extra])

    def pose(self, extended: FloatArray) -> HyoidPose:
        """The pose in positions of the body and the extra nodes."""
        return HyoidPose(extended[-2] - self._centre, extended[-1] / self._arm, self._centre)

    def _fitted(self, places: FloatArray) -> HyoidPose:
        """Best rigid motion of the tied nodes (Kabsch 1976); in a half, one of the midplane."""
        arms, weights = self._rest_arms, np.ones(len(places))
        if self._mirror:
            image = np.array([1.0, -1.0, 1.0])
            arms, places = np.concatenate([arms, arms * image]), np.concatenate([places, places * image])
            weights = np.concatenate([weights, weights])
        mean_arm, mean_place = arms.mean(axis=0), places.mean(axis=0)
        u, s, vt = np.linalg.svd((arms - mean_arm).T @ (places - mean_place))
        if s[1] <= 1e-9 * max(s[0], 1e-300):  # on one line: no rotation can be read off
            rotation = np.eye(3)
        else:
            rotation = vt.T @ np.diag([1.0, 1.0, np.sign(np.linalg.det(vt.T @ u.T))]) @ u.T
        displacement = mean_place - rotation @ mean_arm - self._centre
        return HyoidPose(displacement, _rotation_vector(rotation), self._centre)


def check_mobile_hyoid(speaker: Speaker, held: tuple[str, ...], *, mirror: bool) -> None:
    """Raises InputError where a mobile hyoid cannot work: nodes both tied and held, or no symmetry in a half."""
    hyoid = speaker.hyoid
    assert hyoid is not None
    tied = speaker.node_sets["hyoid"]
    for name in held:
        both = np.intersect1d(tied, speaker.node_sets[name])
        if len(both):
            raise InputError(f"hyoid='mobile': node {both[0]} belongs to the hyoid and to the fixed set {name!r}")
    if not mirror:
        return
    ends = [(s.on_hyoid, s.fixed, s.stiffness, s.rest_length) for s in hyoid.springs]
    image = np.array([1.0, -1.0, 1.0])
    if abs(hyoid.centre[1]) > TOLERANCE:
        raise InputError("mirror=True needs a symmetric hyoid; its centre lies beside the midplane y = 0")
    for spring in hyoid.springs:
        twins = [
            other
            for other in ends
            if np.allclose(other[0], spring.on_hyoid * image, rtol=0.0, atol=1e-6)
            and np.allclose(other[1], spring.fixed * image, rtol=0.0, atol=1e-6)
            and np.isclose(other[2], spring.stiffness)
            and np.isclose(other[3], spring.rest_length)
        ]
        if not twins:
            raise InputError(f"mirror=True needs a symmetric hyoid; spring {spring.name!r} has no mirror image")


def _right(point: FloatArray) -> bool:
    return bool(point[1] > -TOLERANCE)


def _halved(spring: Spring, mirror: bool) -> Spring:
    """In a half, a spring in the midplane carries half its force."""
    if not mirror or spring.on_hyoid[1] > TOLERANCE:
        return spring
    return Spring(spring.on_hyoid, spring.fixed, 0.5 * spring.stiffness, spring.rest_length, spring.name)


def _point_masses(hyoid: Hyoid, tied: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Masses (kg) and places (m) of the six points; none for a bone without mass."""
    if hyoid.mass == 0.0:
        return np.zeros(0), np.zeros((0, 3))
    if hyoid.surface is not None:
        moments = second_moments(hyoid.surface, hyoid.centre)
    else:  # as if the mass lay where the tongue is attached
        moments = (tied - hyoid.centre).T @ (tied - hyoid.centre) / len(tied)
    values, axes = np.linalg.eigh(moments)
    reach = np.sqrt(3.0 * np.maximum(values, 0.0))
    places = [hyoid.centre + sign * reach[i] * axes[:, i] for i in range(3) for sign in (1.0, -1.0)]
    return np.full(6, hyoid.mass / 6.0), np.array(places)


def second_moments(surface: Wall, centre: FloatArray) -> FloatArray:
    """(3, 3) mean of (x - centre)(x - centre)' over the volume inside a closed surface, m2."""
    corners = surface.vertices[surface.triangles] - centre
    volumes = np.einsum("ti,ti->t", corners[:, 0], np.cross(corners[:, 1], corners[:, 2])) / 6.0
    total = corners.sum(axis=1)
    moments = np.einsum("t,tai,taj->ij", volumes, corners, corners) + np.einsum("t,ti,tj->ij", volumes, total, total)
    return np.asarray(moments / (20.0 * volumes.sum()))


def _rotation_matrix(vector: FloatArray) -> FloatArray:
    from scipy.spatial.transform import Rotation

    return np.asarray(Rotation.from_rotvec(vector).as_matrix())


def _rotation_vector(matrix: FloatArray) -> FloatArray:
    from scipy.spatial.transform import Rotation

    return np.asarray(Rotation.from_matrix(matrix).as_rotvec())
