"""How far postures and movements are from those of fine meshes, told from a solve with cells of half the size.

The change between the two, times 1 / (1 - 2^-p), is what the coarse one lacks where its error falls with the power p
of the size of cells (Richardson; Roache 1994, J. Fluids Eng. 116:405). Nothing cheaper will do: one step with the
tangent of the fine mesh from the carried posture finds a tenth of it, four Newton steps a third of that of /i/, because
points that begin to touch lie between the two, and volumes that a trilinear field does not keep.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace
from functools import cached_property
from typing import TYPE_CHECKING, Any

import numpy as np
import pandas as pd

from glossa.anatomy import hexahedra as hexa
from glossa.anatomy.arrays import FloatArray
from glossa.anatomy.division import TOLERANCE, Division
from glossa.anatomy.speaker import Speaker
from glossa.boundary import WALL
from glossa.checks import instance
from glossa.errors import InputError
from glossa.results import Movement, Posture

if TYPE_CHECKING:
    from glossa.scene import Scene

ORDER = 1.0
"""Power p of the size of cells with which errors fall.

Smooth solutions have 2, and errors stated too large by half. Clamped edges leave a cantilever 1.0 to 1.2; those, fibres
and the borders of contact leave 0.8 to 1.4 to the positions of /i/, /ə/ and /u/ (0.5 to /a/).
"""

LACKING = 1.0 / (1.0 - 0.5**ORDER)
"""What the limit has more than the coarse mesh, over what the finer one has more."""

SAME = 1e-3
"""A posture that moves by more than this share of the body's extent, solved again, is no equilibrium of its scene."""

LEAST_JACOBIAN = 0.05
"""Volume ratio at a Gauss point that the solve on the finer mesh may start from."""


@dataclass(frozen=True, eq=False)
class Divided:
    """A scene with every hexahedron in eight.

    Attributes:
        key: fingerprint of the finer body that was asked for; None where none was.
        division: what lies where.
        scene: of the finer body; the same options.
    """

    key: str | None
    division: Division
    scene: Scene


@dataclass(frozen=True, kw_only=True, eq=False)
class SpatialError:
    """Estimated error of a posture that is due to its mesh; n nodes, m hexahedra.

    Differences are what the limit of fine meshes has more than the posture.

    Attributes:
        posture: whose error it is.
        finer: the same on the finer mesh.
        division: what of the one is where in the other.
    """

    posture: Posture
    finer: Posture
    division: Division

    @cached_property
    def displacements(self) -> FloatArray:
        """(n, 3) m."""
        return np.asarray(LACKING * (self.finer.positions[self.division.nodes] - self.posture.positions))

    @property
    def largest(self) -> float:
        """Of the displacement of any node, m."""
        return float(np.linalg.norm(self.displacements, axis=1).max())

    @property
    def root_mean_square(self) -> float:
        """Of the displacements of all nodes, m."""
        return float(np.sqrt((self.displacements**2).sum(axis=1).mean()))

    @property
    def forces(self) -> pd.Series[float]:
        """By muscle, N."""
        missing: pd.Series[float] = LACKING * (self.finer.forces - self.posture.forces)
        return missing

    @property
    def touched_areas(self) -> pd.Series[float]:
        """By wall, m2 of the tongue at rest; empty without contact."""
        mine, theirs = self.posture.contact, self.finer.contact
        if mine is None or theirs is None:
            return pd.Series(dtype=float, name="area_m2")
        missing: pd.Series[float] = LACKING * (theirs.touched_areas - mine.touched_areas)
        return missing

    def __repr__(self) -> str:
        return f"SpatialError({self.root_mean_square * 1e3:.2g} mm on the mean, {self.largest * 1e3:.2g} mm at most)"


@dataclass(frozen=True, kw_only=True, eq=False)
class MovementSpatialError:
    """Estimated error of a movement that is due to its mesh.

    Attributes:
        movement: whose error it is.
        finer: the same on the finer mesh, at times of its own.
        division: what of the one is where in the other.
    """

    movement: Movement
    finer: Movement
    division: Division

    def at(self, time: float) -> SpatialError:
        """The error at a time, s.

        Raises:
            InputError: a time outside the movement.
        """
        return SpatialError(posture=self.movement.at(time), finer=self.finer.at(time), division=self.division)

    @cached_property
    def largest(self) -> FloatArray:
        """(t,) m, of the displacement of any node, at the frames of the movement."""
        return np.array([self.at(float(time)).largest for time in self.movement.times])


def finer_body(speaker: Speaker) -> Speaker:
    """The built-in speaker at twice its resolution; of any other every hexahedron in eight, on the same planes."""
    from glossa.anatomy.reference import built_in_resolution

    resolution = built_in_resolution(speaker)
    return speaker.refined() if resolution is None else Speaker.reference(2 * resolution)


def posture_error(
    scene: Scene,
    posture: Posture,
    prescribed: Mapping[str, Any],
    loads: Mapping[str, Any],
    finer: Speaker | None,
) -> SpatialError:
    """See :meth:`glossa.Scene.spatial_error`."""
    instance(posture, Posture, "posture")
    if posture.time is not None:
        raise InputError(
            "posture: a moment of a movement is no equilibrium; spatial_error_of_movement(movement).at(time) tells its "
            "error"
        )
    again = scene.equilibrate(posture.commands, start=posture, prescribed=prescribed, loads=loads, accuracy="draft")
    _check_same(again, posture, "posture: this is no equilibrium of the scene; pass prescribed and loads as they were")
    divided = scene.divided(finer)
    found = divided.scene.equilibrate(
        posture.commands,
        start=carried_posture(posture, divided),
        prescribed=_carried_prescription(posture.speaker, prescribed, divided),
        loads=loads,
        accuracy="draft",
    )
    return SpatialError(posture=posture, finer=found, division=divided.division)


def movement_error(scene: Scene, movement: Movement, finer: Speaker | None) -> MovementSpatialError:
    """See :meth:`glossa.Scene.spatial_error_of_movement`."""
    instance(movement, Movement, "movement")
    if movement.speaker.fingerprint != scene.speaker.fingerprint:
        raise InputError("movement: this movement belongs to another speaker")
    if movement.schedule is None:
        raise InputError("movement: a movement read from a file does not know its commands; simulate it again")
    if movement.times[0] != 0.0 or movement.velocities[0].any():
        raise InputError("movement: it must begin at time 0 and at rest or in equilibrium, not in motion")
    first, initial = movement.at(0.0), None
    if first.wall_displacements or np.abs(first.displacements).max() > TOLERANCE:
        walls = {WALL + name: shift for name, shift in first.wall_displacements.items()}
        start = scene.equilibrate(first.commands, start=first, prescribed=walls)
        _check_same(start, first, "movement: it does not begin in an equilibrium of this scene, or at rest")
        initial = posture_error(scene, start, walls, {}, finer).finer
    divided = scene.divided(finer)
    found = divided.scene.simulate(movement.schedule, float(movement.times[-1]), initial=initial)
    return MovementSpatialError(movement=movement, finer=found, division=divided.division)


def _check_same(again: Posture, posture: Posture, message: str) -> None:
    away = np.abs(again.positions - posture.positions).max()
    if away > SAME * np.ptp(posture.speaker.nodes, axis=0).max():
        raise InputError(f"{message} (solved again it moves by {away * 1e3:.3g} mm)")


def carried_posture(posture: Posture, divided: Divided) -> Posture:
    """Where to start on the finer mesh: the posture, without its contact, whose points are others there.

    A strongly bent hexahedron may have children that are folded over: then so much less displaced, in eighths, that no
    Gauss point is compressed below :data:`LEAST_JACOBIAN`.
    """
    finer, division = divided.scene.speaker, divided.division
    moved = division.carried(posture.displacements)
    at_rest = hexa.gauss_determinants(finer.nodes, finer.hexahedra)
    for share in np.linspace(1.0, 0.0, 9).tolist():
        positions = finer.nodes + share * moved
        if (hexa.gauss_determinants(positions, finer.hexahedra) >= LEAST_JACOBIAN * at_rest).all():
            break
    return replace(
        posture,
        speaker=finer,
        positions=positions,
        pressure=None if posture.pressure is None else share * division.inherited(posture.pressure),
        contact=None,
    )


def _carried_prescription(coarse: Speaker, prescribed: Mapping[str, Any], divided: Divided) -> dict[str, Any]:
    """The same on the finer mesh: what is given node by node trilinear between them, free where a neighbour is."""
    finer, result = divided.scene.speaker, dict(prescribed)
    for name, value in prescribed.items():
        if name in coarse.node_sets and np.ndim(value) == 2:
            field = np.full(coarse.nodes.shape, np.nan)
            field[coarse.node_sets[name]] = np.array(value, dtype=float)
            between = divided.division.carried(field)[finer.node_sets[name]]
            result[name] = [[None if np.isnan(x) else x for x in place] for place in between.tolist()]
    return result
