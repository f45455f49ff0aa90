"""The body that a scene computes on: the whole speaker or its half, as the flat arrays of the C++ core."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np

from glossa.anatomy.arrays import BoolArray, FloatArray, IntArray
from glossa.anatomy.mirror import HalfBody, half_body, mirror_pairs
from glossa.anatomy.muscle_topology import capacity_shares, pass_table, stiffening_gain
from glossa.anatomy.speaker import Speaker
from glossa.contact import Contact
from glossa.contact_points import ContactCourse, ContactPoints
from glossa.effects import Stiffening
from glossa.errors import InputError
from glossa.hyoid_motion import HyoidCourse, HyoidNodes, HyoidPose

SYMMETRY_TOLERANCE = 1e-9
"""Relative size of an asymmetry that counts as rounding."""
START_SYMMETRY_TOLERANCE = 1e-6
"""The same of positions that a solve may have left: what its tolerance allows."""


@dataclass(frozen=True, eq=False)
class Fibres:
    """All macrofibres of a speaker, flat, muscle by muscle; f fibres.

    Attributes:
        muscles: names in order.
        muscle: (f,) index of each fibre's muscle.
        nodes: f node lists.
        capacity: (f,) rho of eq. 4, N.
        rest_length: (f,) m.
        stiffened: f arrays of elements that the fibre stiffens (p2 = 1 in eq. 1).
        gain: (f,) p1 of eq. 1, 1/m.
    """

    muscles: tuple[str, ...]
    muscle: IntArray
    nodes: tuple[IntArray, ...]
    capacity: FloatArray
    rest_length: FloatArray
    stiffened: tuple[IntArray, ...]
    gain: FloatArray


def gather_fibres(speaker: Speaker, stiffening: Stiffening | None, saturation: float) -> Fibres:
    """Fibres of a speaker with the force shares of eq. 4 and the stiffening gains of eq. 1.

    Args:
        speaker: any speaker.
        stiffening: rule for p1; None leaves the tissue passive.
        saturation: activation at which eq. 3 saturates, m.
    """
    muscle_index: list[int] = []
    nodes: list[IntArray] = []
    stiffened: list[IntArray] = []
    capacity, rest, gain = [np.zeros(0)], [np.zeros(0)], [np.zeros(0)]
    for number, (name, muscle) in enumerate(speaker.muscles.items()):
        count = len(muscle.fibres)
        muscle_index += [number] * count
        nodes += muscle.fibres
        capacity.append(muscle.force_capacity * capacity_shares(speaker.nodes, speaker.hexahedra, muscle))
        rest.append(speaker.fibre_rest_lengths(name))
        if stiffening is None:
            stiffened += [np.zeros(0, np.int32)] * count
            gain.append(np.zeros(count))
            continue
        table = pass_table(speaker.hexahedra, muscle)
        stiffened += np.split(table.elements, np.searchsorted(table.fibres, np.arange(1, count)))
        p1 = stiffening.gains.get(name)
        if p1 is None:
            p1 = stiffening_gain(speaker.hexahedra, muscle, saturation, stiffening.peak_multiplier)
        gain.append(np.full(count, p1))
    return Fibres(
        muscles=tuple(speaker.muscles),
        muscle=np.array(muscle_index, np.int32),
        nodes=tuple(nodes),
        capacity=np.concatenate(capacity),
        rest_length=np.concatenate(rest),
        stiffened=tuple(stiffened),
        gain=np.concatenate(gain),
    )


class Body:
    """A speaker, or its half y >= 0, in the numbering of the core, and the way back.

    A mobile hyoid adds nodes at the end (:class:`HyoidNodes`), which only the core sees.
    """

    def __init__(
        self, speaker: Speaker, fibres: Fibres, *, mirror: bool, mobile_hyoid: bool, contact: ContactPoints | None
    ) -> None:
        self.speaker = speaker
        self.fibres = fibres
        self.half: HalfBody | None = half_body(speaker) if mirror else None
        own = speaker.nodes if self.half is None else self.half.nodes
        self._count = len(own)
        self.hyoid: HyoidNodes | None = None
        if mobile_hyoid and speaker.hyoid is not None:
            tied = np.sort(speaker.node_sets["hyoid"])
            if self.half is not None:
                tied = np.unique(self.half.node_index[tied])
            self.hyoid = HyoidNodes(speaker.hyoid, own, tied.astype(np.int32), mirror=mirror)
        self.nodes: FloatArray = own if self.hyoid is None else np.concatenate([own, self.hyoid.nodes])
        self.contact = contact
        if contact is not None:
            self._rows: IntArray
            self._place: IntArray
            self._image: BoolArray
            if self.half is None:
                self._rows = self._place = np.arange(len(contact.wall), dtype=np.int32)
                self._image = np.zeros(len(contact.wall), dtype=bool)
            else:
                self._rows, self._place, self._image = contact.halves(speaker.nodes)

    @property
    def hexahedra(self) -> IntArray:
        """(h, 8)."""
        return self.speaker.hexahedra if self.half is None else self.half.hexahedra

    @cached_property
    def _pairs(self) -> IntArray:
        return mirror_pairs(self.speaker.nodes)

    @cached_property
    def fibre_source(self) -> IntArray:
        """(g,) index in the speaker of each fibre of the body."""
        if self.half is None:
            return np.arange(len(self.fibres.muscle), dtype=np.int32)
        starts = np.searchsorted(self.fibres.muscle, range(len(self.fibres.muscles)))
        first = dict(zip(self.fibres.muscles, starts, strict=True))
        return np.array([first[f.muscle] + f.index for f in self.half.fibres], np.int32)

    @cached_property
    def fibre_index(self) -> IntArray:
        """(f,) fibre of the body that stands for each fibre of the speaker."""
        if self.half is None:
            return self.fibre_source
        parts = [self.half.fibre_index[name] for name in self.fibres.muscles]
        return np.concatenate(parts).astype(np.int32) if parts else np.zeros(0, np.int32)

    @cached_property
    def force_share(self) -> FloatArray:
        """(g,) part of each fibre's force that acts on the body: 0.5 in the midplane of a half."""
        if self.half is None:
            return np.ones(len(self.fibres.muscle))
        return np.array([fibre.force_share for fibre in self.half.fibres], dtype=float)

    def core_fibres(self) -> dict[str, Any]:
        """Arrays for the core's constructor."""
        source = self.fibre_source
        if self.half is None:
            paths: Sequence[IntArray] = self.fibres.nodes
            factor = np.ones(len(source))
            element = np.arange(len(self.speaker.hexahedra), dtype=np.int32)
        else:
            paths = [fibre.nodes for fibre in self.half.fibres]
            factor = np.array([fibre.length_factor for fibre in self.half.fibres], dtype=float)
            element = np.full(len(self.speaker.hexahedra), -1, np.int32)
            element[self.half.kept_elements] = np.arange(len(self.half.kept_elements))
        stiffened = self._stiffened(source, element)
        gains = [np.full(len(e), self.fibres.gain[f]) for e, f in zip(stiffened, source, strict=True)]
        return {
            "nodes": _flat(paths),
            "node_start": _starts(paths),
            "muscle": self.fibres.muscle[source],
            "capacity": self.fibres.capacity[source] * self.force_share,
            "length_factor": factor,
            "rest_length": self.fibres.rest_length[source],
            "stiffened_elements": _flat(stiffened),
            "stiffening_gains": np.concatenate([*gains, np.zeros(0)]),
            "stiffened_start": _starts(stiffened),
        }

    def _stiffened(self, source: IntArray, element: IntArray) -> list[IntArray]:
        """Elements of the body stiffened by each of its fibres.

        What a fibre of the other side stiffens here (along the midplane) is added to its mirror image, which is kept.
        """
        lists = [[*element[self.fibres.stiffened[f]]] for f in source]
        if self.half is not None:
            kept = set(source.tolist())
            for f, own in enumerate(self.fibre_index):
                if f not in kept:
                    lists[own] += [*element[self.fibres.stiffened[f]]]
        return [np.array([e for e in found if e >= 0], np.int32) for found in lists]

    # Between the speaker and the body

    def restrict_positions(self, positions: FloatArray, what: str) -> FloatArray:
        """Positions (n, 3) of the speaker on the body; refuses asymmetry beyond that of a solve in a half body."""
        own = self._restrict(positions, what, START_SYMMETRY_TOLERANCE)
        return own if self.hyoid is None else self.hyoid.appended(own)

    def _restrict(self, field: FloatArray, what: str, tolerance: float = SYMMETRY_TOLERANCE) -> FloatArray:
        if self.half is None:
            return np.ascontiguousarray(field)
        image = field[self._pairs] * np.array([1.0, -1.0, 1.0])
        size = float(np.abs(field).max(initial=0.0))
        worst = np.abs(image - field).max(axis=1, initial=0.0)
        if len(worst) and worst.max() > tolerance * max(size, 1e-12):
            raise InputError(
                f"{what} is not mirror symmetric about y = 0 (node {int(worst.argmax())}); use mirror=False for it"
            )
        return np.ascontiguousarray(field[self.half.kept_nodes])

    def restrict_forces(self, forces: FloatArray, what: str) -> FloatArray:
        """As :meth:`restrict` for nodal forces: a node of the midplane carries half on each side."""
        result = self._restrict(forces, what).copy()
        if self.half is not None:
            result[self.half.midplane] *= 0.5
        return np.asarray(self._with_rows(result))

    def _with_rows(self, values: FloatArray | BoolArray) -> Any:
        """Zeros at the extra nodes."""
        extra = np.zeros((len(self.nodes) - self._count, 3), dtype=values.dtype)
        return np.concatenate([values, extra]) if len(extra) else values

    def restrict_mask(self, mask: BoolArray, what: str) -> BoolArray:
        """(n, 3) flags of the speaker on the body; refuses asymmetry in a half body."""
        if self.half is None:
            return np.asarray(self._with_rows(mask))
        wrong = np.flatnonzero((mask[self._pairs] != mask).any(axis=1))
        if len(wrong):
            raise InputError(f"{what} is not mirror symmetric about y = 0 (node {wrong[0]}); use mirror=False for it")
        return np.asarray(self._with_rows(mask[self.half.kept_nodes]))

    def expand(self, field: FloatArray) -> FloatArray:
        """(n, 3) positions or velocities of the speaker."""
        own = field[: self._count]
        return np.array(own) if self.half is None else self.half.expand(own)

    def expand_forces(self, forces: FloatArray) -> FloatArray:
        """(n, 3) nodal forces of the speaker."""
        whole = np.array(forces[: self._count])
        if self.half is None:
            return whole
        whole[self.half.midplane] *= [2.0, 0.0, 2.0]
        return self.half.expand(whole)

    def expand_fibres(self, values: FloatArray) -> FloatArray:
        """(…, f) values of the speaker's fibres."""
        return np.ascontiguousarray(values[..., self.fibre_index])

    def expand_tensions(self, values: FloatArray) -> FloatArray:
        """(…, f) tensions of the speaker's fibres, N."""
        return self.expand_fibres(values / self.force_share)

    def expand_elements(self, values: FloatArray) -> FloatArray:
        """(m,) values of the speaker's hexahedra."""
        return np.array(values) if self.half is None else values[self.half.element_index]

    def restrict_elements(self, values: FloatArray) -> FloatArray:
        """(h,) values of the body's hexahedra."""
        return values if self.half is None else np.ascontiguousarray(values[self.half.kept_elements])

    def free_components(self, held: BoolArray) -> BoolArray:
        """(k, 3) unknown components of the body, given what the scene holds (n, 3): not those of tied nodes."""
        free = ~self.restrict_mask(held, "fixed")
        if self.half is not None:
            free[: self._count][self.half.midplane, 1] = False
        if self.hyoid is not None:
            free[self.hyoid.core["tied"]] = False
            free[self._count :] = self.hyoid.free
        return free

    # Hyoid and contact

    def hyoid_pose(self, positions: FloatArray) -> HyoidPose | None:
        """Pose of a mobile hyoid in positions of the body."""
        return None if self.hyoid is None else self.hyoid.pose(positions)

    def core_contact(self, friction: float) -> dict[str, Any] | None:
        """Arrays for the core's constructor."""
        return None if self.contact is None else self.contact.core(self._rows, self.half, friction)

    def restrict_contact(self, contact: Contact | None) -> tuple[FloatArray | None, FloatArray | None]:
        """Pressures and drags to start from, of the body's contact points; None where they do not fit."""
        if self.contact is None or contact is None or contact.walls != self.contact.walls:
            return None, None
        if not np.array_equal(contact.wall, self.contact.wall) or not np.array_equal(contact.areas, self.contact.areas):
            return None, None
        return contact.pressures[self._rows], contact.drags[self._rows]

    def expand_contact(
        self, positions: FloatArray, pressures: FloatArray, drags: FloatArray, shifts: Mapping[str, FloatArray]
    ) -> Contact | None:
        """Contact of the speaker at its node positions (n, 3), from values of the body's contact points."""
        if self.contact is None:
            return None
        return self.contact.contact(positions, pressures[self._place], self._whole_drags(drags), shifts)

    def _whole_drags(self, drags: FloatArray) -> FloatArray:
        if not drags.any():
            return np.zeros((*drags.shape[:-2], len(self._place), 3))
        whole = np.array(drags[..., self._place, :])
        whole[..., self._image, 1] *= -1.0
        return whole

    def contact_course(
        self, pressures: FloatArray, drags: FloatArray, shifts: Mapping[str, FloatArray]
    ) -> ContactCourse | None:
        """Contact of the speaker over time, from values (t, …) of the body's contact points."""
        if self.contact is None:
            return None
        return ContactCourse(self.contact, pressures[:, self._place], self._whole_drags(drags), shifts)

    def hyoid_course(self, frames: Sequence[FloatArray]) -> HyoidCourse | None:
        """Pose of a mobile hyoid in each of the body's position frames."""
        if self.hyoid is None:
            return None
        poses = [self.hyoid.pose(frame) for frame in frames]
        return HyoidCourse(
            np.array([pose.displacement for pose in poses]),
            np.array([pose.rotation for pose in poses]),
            poses[0].centre,
        )


def _flat(lists: Sequence[IntArray]) -> IntArray:
    return np.concatenate([*lists, np.zeros(0, np.int32)]).astype(np.int32)


def _starts(lists: Sequence[IntArray]) -> IntArray:
    return np.concatenate([[0], np.cumsum([len(x) for x in lists])]).astype(np.int32)
