"""What a scene returns: postures and movements, with the evidence of how they were found."""

from __future__ import annotations

import json
from collections.abc import Mapping
from dataclasses import asdict, dataclass, field
from itertools import pairwise
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
import pandas as pd
import xarray as xr

from glossa.anatomy.arrays import BoolArray, FloatArray, IntArray
from glossa.anatomy.gradient_recovery import gradient_errors
from glossa.anatomy.speaker import Speaker
from glossa.contact import Contact
from glossa.contact_points import ContactCourse, checked_spacing, contact_points
from glossa.effects import Yeoh
from glossa.errors import InputError
from glossa.hyoid_motion import HyoidCourse, HyoidPose
from glossa.motor.commands import MotorCommands
from glossa.motor.schedule import Schedule
from glossa.result_files import damaged_is_refused, fields, read_dataset, write_dataset

if TYPE_CHECKING:
    import meshio


@dataclass(frozen=True, kw_only=True)
class SolveReport:
    """How a solve ended and what it took.

    Attributes:
        converged: the residual is within tolerance; for a movement, every step was.
        status: name of the exit status: converged, iteration_limit, stalled, inverted, penetrated, indefinite,
            interrupted.
        iterations: Newton iterations (posture) or stages solved (movement).
        quasi_newton: iterations with a frozen factor.
        residuals: residual evaluations.
        factorisations: numeric factorisations.
        indefinite: tangents that needed a cure.
        line_search: steps that were cut back.
        steps, rejected, rescued: time steps accepted; shortened for accuracy or, adaptive ones, for slow convergence;
            and saved by a fresh factor, a shorter step or backward Euler.
        residual: N, 2-norm over the free components; force_scale: N, what the tolerance refers to.
        least_jacobian: smallest J at any Gauss point; worst_element: its hexahedron in the body that was computed.
        error_estimate: largest estimated local error of a time step, m; accumulated_error: largest estimated error of
            the positions of a movement that is due to its time steps, m: those of the steps, fading with the relaxation
            time of the tissue.
        contact_updates: updates of the contact multipliers; penetration: deepest penetration of a wall, m;
            contact_violation: largest distance from the laws of contact and friction, m (posture).
        residuals_by_iteration: N, at the start of each Newton iteration.
        seconds: by part of the work, and "total".
    """

    converged: bool
    status: str
    iterations: int
    quasi_newton: int
    residuals: int
    factorisations: int
    indefinite: int
    line_search: int
    steps: int
    rejected: int
    rescued: int
    residual: float
    force_scale: float
    least_jacobian: float
    worst_element: int
    error_estimate: float
    accumulated_error: float
    contact_updates: int
    penetration: float
    contact_violation: float
    residuals_by_iteration: tuple[float, ...]
    seconds: Mapping[str, float]

    @classmethod
    def from_core(cls, report: Any) -> SolveReport:
        """Copy of a report of the C++ core."""
        values = {name: getattr(report, name) for name in cls.__dataclass_fields__}
        values["residuals_by_iteration"] = tuple(values["residuals_by_iteration"])
        return cls(**values)

    def as_dict(self) -> dict[str, Any]:
        """Plain values for JSON."""
        return asdict(self)


CONTACT_ARRAYS = {
    "wall": "1",
    "points": "m",
    "areas": "m2",
    "gaps": "m",
    "pressures": "Pa",
    "directions": "1",
    "drags": "Pa",
}
"""Arrays of :class:`Contact` in a posture file, and their units."""


def forces_by_muscle(speaker: Speaker, tensions: FloatArray) -> FloatArray:
    """(…, muscles) sums of fibre tensions (…, fibres), N: the forces of the paper's Table II."""
    counts = [len(muscle.fibres) for muscle in speaker.muscles.values()]
    ends = np.cumsum([0, *counts])
    parts = [tensions[..., a:b].sum(axis=-1) for a, b in pairwise(ends)]
    return np.stack(parts, axis=-1) if parts else np.zeros((*tensions.shape[:-1], 0))


@dataclass(frozen=True, kw_only=True, eq=False)
class Posture:
    """A state of the tongue; n nodes, m hexahedra, f fibres (muscle by muscle, in the speaker's order).

    Attributes:
        speaker: whose tongue it is.
        commands: motor commands that hold, None without.
        positions: (n, 3) m.
        activations: (f,) A of eq. 2, m.
        fibre_forces: (f,) tensions, N.
        pressure: (m,) Pa, positive in dilatation.
        stiffening: (m,) factor of eq. 1.
        support_forces: (n, 3) N, force of the supports, a mobile hyoid among them, on the body where nodes are
            attached; 0 elsewhere. None where it was not computed (a moment of a movement).
        report: how it was found.
        contact: what touches which wall; None in a scene without contact.
        hyoid: pose of a mobile hyoid; None where it does not move.
        wall_displacements: (3,) m by wall, for walls that were displaced.
        time: s, for a moment of a movement.
        tissue: passive tissue of the scene; None where it is not known.
    """

    speaker: Speaker
    commands: MotorCommands | None
    positions: FloatArray
    activations: FloatArray
    fibre_forces: FloatArray
    pressure: FloatArray | None
    stiffening: FloatArray | None
    support_forces: FloatArray | None
    report: SolveReport | None
    contact: Contact | None = None
    hyoid: HyoidPose | None = None
    wall_displacements: Mapping[str, FloatArray] = field(default_factory=dict)
    time: float | None = None
    tissue: Yeoh | None = None

    @property
    def displacements(self) -> FloatArray:
        """(n, 3) m, from the rest positions."""
        return np.asarray(self.positions - self.speaker.nodes)

    @property
    def strain_errors(self) -> FloatArray:
        """(m,) where the mesh is too coarse: estimated error of the displacement gradient in each hexahedron.

        Milliseconds, without a solve (see :mod:`glossa.anatomy.gradient_recovery`). How far nodes, forces and formants
        are off is told by :meth:`glossa.Scene.spatial_error`.
        """
        return gradient_errors(self.speaker.nodes, self.displacements, self.speaker.hexahedra)

    @property
    def forces(self) -> pd.Series[float]:
        """Force of each muscle: the sum of the tensions of its fibres, N (as Table II)."""
        values = forces_by_muscle(self.speaker, self.fibre_forces)
        return pd.Series(values, index=list(self.speaker.muscles), name="force_N", dtype=float)

    def fibre_slice(self, muscle: str) -> slice:
        """Where a muscle's fibres lie in the fibre arrays.

        Raises:
            InputError: no such muscle.
        """
        start = 0
        for name, one in self.speaker.muscles.items():
            if name == muscle:
                return slice(start, start + len(one.fibres))
            start += len(one.fibres)
        raise InputError(f"no muscle {muscle!r}; this speaker has {', '.join(self.speaker.muscles) or 'none'}")

    def node_set(self, name: str) -> FloatArray:
        """(k, 3) positions of a node set or contour of the speaker, m.

        Raises:
            InputError: no such set.
        """
        return np.asarray(self.positions[_node_set(self.speaker, name)])

    def reactions(self, name: str) -> FloatArray:
        """(3,) N: total force of the support on the body over a node set.

        Raises:
            InputError: no such set, or a posture without support forces.
        """
        nodes = _node_set(self.speaker, name)
        if self.support_forces is None:
            raise InputError("this posture is a moment of a movement; support forces exist for equilibria only")
        return np.asarray(self.support_forces[nodes].sum(axis=0))

    def to_meshio(self) -> meshio.Mesh:
        """A meshio mesh (points in m) with displacement, stiffening and pressure, to write VTK and other formats.

        Raises:
            ImportError: meshio is not installed.
        """
        import meshio

        cells: dict[str, list[FloatArray]] = {}
        for name, values in (("pressure_Pa", self.pressure), ("stiffening", self.stiffening)):
            if values is not None:
                cells[name] = [values]
        return meshio.Mesh(
            self.positions,
            [("hexahedron", self.speaker.hexahedra)],
            point_data={"displacement_m": self.displacements},
            cell_data=cells,
        )

    def save(self, path: str | Path) -> None:
        """Write to one NetCDF file; :meth:`load` with the same speaker reads it back."""
        variables: dict[str, Any] = {
            "positions": (("node", "axis"), self.positions, {"units": "m"}),
            "activations": (("fibre",), self.activations, {"units": "m"}),
            "fibre_forces": (("fibre",), self.fibre_forces, {"units": "N"}),
        }
        optional = (("pressure", "element", self.pressure, "Pa"), ("stiffening", "element", self.stiffening, "1"))
        for name, dimension, values, units in optional:
            if values is not None:
                variables[name] = ((dimension,), values, {"units": units})
        if self.support_forces is not None:
            variables["support_forces"] = (("node", "axis"), self.support_forces, {"units": "N"})
        if self.contact is not None:
            variables |= {
                f"contact_{name}": (("contact_point", "axis")[: values.ndim], values, {"units": units})
                for name, units in CONTACT_ARRAYS.items()
                for values in [getattr(self.contact, name)]
            }
            variables["held_nodes"] = (("held",), self.contact.held)
        if self.hyoid is not None:
            variables["hyoid_displacement"] = (("axis",), self.hyoid.displacement, {"units": "m"})
            variables["hyoid_rotation"] = (("axis",), self.hyoid.rotation, {"units": "rad"})
            variables["hyoid_centre"] = (("axis",), self.hyoid.centre, {"units": "m"})
        attributes: dict[str, Any] = {
            "glossa": "posture",
            "speaker": self.speaker.name,
            "speaker_fingerprint": self.speaker.fingerprint,
            "commands": json.dumps(None if self.commands is None else dict(self.commands)),
            "report": json.dumps(None if self.report is None else self.report.as_dict()),
            "walls": json.dumps([] if self.contact is None else self.contact.walls),
            "wall_displacements": json.dumps({k: list(v) for k, v in self.wall_displacements.items()}),
        }
        attributes |= _tissue_attribute(self.tissue)
        if self.contact is not None:
            attributes["contact_spacing_m"] = self.contact.spacing
        if self.time is not None:
            attributes["time_s"] = self.time
        write_dataset(xr.Dataset(variables, attrs=attributes), path)

    @classmethod
    def load(cls, path: str | Path, speaker: Speaker) -> Posture:
        """Read a posture of ``speaker`` back.

        Raises:
            FileNotFoundError: nothing at ``path``.
            InputError: not a posture file, or one of another speaker.
        """
        data = read_dataset(path, "posture", speaker)
        with damaged_is_refused(path):
            return cls._read(data, speaker)

    @classmethod
    def _read(cls, data: xr.Dataset, speaker: Speaker) -> Posture:
        commands = json.loads(data.attrs["commands"])
        report = json.loads(data.attrs["report"])
        if report is not None:
            report["residuals_by_iteration"] = tuple(report["residuals_by_iteration"])
        n, m, f = len(speaker.nodes), len(speaker.hexahedra), _fibre_count(speaker)
        always = fields(data, {"positions": (n, 3), "activations": (f,), "fibre_forces": (f,)})
        shapes: dict[str, tuple[int, ...]] = {"pressure": (m,), "stiffening": (m,), "support_forces": (n, 3)}
        arrays: dict[str, Any] = {**dict.fromkeys(shapes)}
        arrays |= fields(data, {k: v for k, v in shapes.items() if k in data})
        contact = hyoid = None
        if "contact_wall" in data:
            contact = _read_contact(data, n)
        if "hyoid_displacement" in data:
            hyoid = HyoidPose(*fields(data, dict.fromkeys(_HYOID_POSE, (3,))).values())
        shifts = json.loads(data.attrs.get("wall_displacements", "{}"))
        return cls(
            speaker=speaker,
            commands=None if commands is None else MotorCommands(commands),
            report=None if report is None else SolveReport(**report),
            contact=contact,
            hyoid=hyoid,
            wall_displacements=_wall_shifts(shifts, speaker),
            time=float(data.attrs["time_s"]) if "time_s" in data.attrs else None,
            tissue=_read_tissue(data),
            **always,
            **arrays,
        )


@dataclass(frozen=True, kw_only=True, eq=False)
class Movement:
    """A movement of the tongue, one frame per accepted time step and one at the start; t frames.

    Attributes:
        speaker: whose tongue it is.
        times: (t,) s.
        positions: (t, n, 3) m.
        velocities: (t, n, 3) m/s.
        activations: (t, f) m.
        fibre_forces: (t, f) N.
        report: how it was found.
        contact: contact over time; None in a scene without.
        hyoid: pose of a mobile hyoid over time; None where it does not move.
        schedule: motor commands over time; None for a movement read from a file.
        tissue: passive tissue of the scene; None where it is not known.
    """

    speaker: Speaker
    times: FloatArray
    positions: FloatArray
    velocities: FloatArray
    activations: FloatArray
    fibre_forces: FloatArray
    report: SolveReport
    contact: ContactCourse | None = None
    hyoid: HyoidCourse | None = None
    schedule: Schedule | None = None
    tissue: Yeoh | None = None

    @property
    def forces(self) -> pd.DataFrame:
        """Force of each muscle over time, N; index: time in s."""
        values = forces_by_muscle(self.speaker, self.fibre_forces)
        return pd.DataFrame(values, index=pd.Index(self.times, name="time_s"), columns=list(self.speaker.muscles))

    def at(self, time: float) -> Posture:
        """The posture at a time within the movement: positions by cubic Hermite interpolation, forces linearly.

        Raises:
            InputError: a time outside the movement.
        """
        first, last = float(self.times[0]), float(self.times[-1])
        if not first <= time <= last:
            raise InputError(f"time must lie between {first:g} s and {last:g} s, got {time!r}")
        k = min(int(np.searchsorted(self.times, time, side="right")) - 1, len(self.times) - 2)
        if k < 0:
            k, h, x = 0, 1.0, 0.0
            after = 0
        else:
            after = k + 1
            h = float(self.times[after] - self.times[k])
            x = (time - float(self.times[k])) / h
        positions = (
            (1 + 2 * x) * (1 - x) ** 2 * self.positions[k]
            + x * x * (3 - 2 * x) * self.positions[after]
            + h * x * (1 - x) ** 2 * self.velocities[k]
            - h * x * x * (1 - x) * self.velocities[after]
        )
        return Posture(
            speaker=self.speaker,
            commands=None if self.schedule is None else self.schedule.at(float(time)),
            positions=positions,
            activations=(1 - x) * self.activations[k] + x * self.activations[after],
            fibre_forces=(1 - x) * self.fibre_forces[k] + x * self.fibre_forces[after],
            pressure=None,
            stiffening=None,
            support_forces=None,
            contact=None if self.contact is None else self.contact.between(positions, k, after, x),
            hyoid=None if self.hyoid is None else self.hyoid.between(k, after, x),
            wall_displacements={} if self.contact is None else self.contact.wall_displacements,
            report=self.report,
            time=float(time),
            tissue=self.tissue,
        )

    def to_xarray(self) -> xr.Dataset:
        """Dataset with dimensions time, node, axis, muscle, fibre and contact_point; units in the attributes."""
        extra: dict[str, Any] = {}
        if self.contact is not None:
            extra["contact_pressures"] = (("time", "contact_point"), self.contact.pressures, {"units": "Pa"})
            extra["contact_drags"] = (("time", "contact_point", "axis"), self.contact.drags, {"units": "Pa"})
            extra["held_nodes"] = (("held",), self.contact.points.held)
        if self.hyoid is not None:
            extra["hyoid_displacements"] = (("time", "axis"), self.hyoid.displacements, {"units": "m"})
            extra["hyoid_rotations"] = (("time", "axis"), self.hyoid.rotations, {"units": "rad"})
            extra["hyoid_centre"] = (("axis",), self.hyoid.centre, {"units": "m"})
        return xr.Dataset(
            {
                "positions": (("time", "node", "axis"), self.positions, {"units": "m"}),
                "velocities": (("time", "node", "axis"), self.velocities, {"units": "m/s"}),
                "forces": (("time", "muscle"), self.forces.to_numpy(), {"units": "N"}),
                "activations": (("time", "fibre"), self.activations, {"units": "m"}),
                "fibre_forces": (("time", "fibre"), self.fibre_forces, {"units": "N"}),
                **extra,
            },
            coords={
                "time": ("time", self.times, {"units": "s"}),
                "axis": ["x", "y", "z"],
                "muscle": list(self.speaker.muscles),
            },
            attrs={
                "glossa": "movement",
                "speaker": self.speaker.name,
                "speaker_fingerprint": self.speaker.fingerprint,
                "report": json.dumps(self.report.as_dict()),
                **_tissue_attribute(self.tissue),
                **({} if self.contact is None else {"contact_spacing_m": self.contact.points.spacing}),
                "wall_displacements": json.dumps(
                    {}
                    if self.contact is None
                    else {name: list(shift) for name, shift in self.contact.wall_displacements.items()}
                ),
            },
        )

    def save(self, path: str | Path) -> None:
        """Write to one NetCDF file."""
        write_dataset(self.to_xarray(), path)

    @classmethod
    def load(cls, path: str | Path, speaker: Speaker) -> Movement:
        """Read a movement of ``speaker`` back.

        Raises:
            FileNotFoundError: nothing at ``path``.
            InputError: not a movement file, or one of another speaker.
        """
        data = read_dataset(path, "movement", speaker)
        with damaged_is_refused(path):
            return cls._read(data, speaker)

    @classmethod
    def _read(cls, data: xr.Dataset, speaker: Speaker) -> Movement:
        report = json.loads(data.attrs["report"])
        report["residuals_by_iteration"] = tuple(report["residuals_by_iteration"])
        n, f = len(speaker.nodes), _fibre_count(speaker)
        times = fields(data, {"time": (-1,)})["time"]
        t = len(times)
        shapes = {"positions": (t, n, 3), "velocities": (t, n, 3), "activations": (t, f), "fibre_forces": (t, f)}
        contact = hyoid = None
        if "contact_pressures" in data:
            points = contact_points(speaker, _held(data, n), mirror=False, spacing=_spacing(data))
            k = len(points.wall)
            course = fields(data, {"contact_pressures": (t, k), "contact_drags": (t, k, 3)})
            shifts = _wall_shifts(json.loads(data.attrs.get("wall_displacements", "{}")), speaker)
            contact = ContactCourse(points, course["contact_pressures"], course["contact_drags"], shifts)
        if "hyoid_displacements" in data:
            course = fields(data, {"hyoid_displacements": (t, 3), "hyoid_rotations": (t, 3), "hyoid_centre": (3,)})
            hyoid = HyoidCourse(*course.values())
        return cls(
            speaker=speaker,
            times=times,
            report=SolveReport(**report),
            contact=contact,
            hyoid=hyoid,
            tissue=_read_tissue(data),
            **fields(data, shapes),
        )


_HYOID_POSE = ("hyoid_displacement", "hyoid_rotation", "hyoid_centre")


def _fibre_count(speaker: Speaker) -> int:
    return sum(len(muscle.fibres) for muscle in speaker.muscles.values())


def _tissue_attribute(tissue: Yeoh | None) -> dict[str, str]:
    return {} if tissue is None else {"tissue": json.dumps(asdict(tissue))}


def _read_tissue(data: xr.Dataset) -> Yeoh | None:
    return Yeoh(**json.loads(data.attrs["tissue"])) if "tissue" in data.attrs else None


def _read_contact(data: xr.Dataset, nodes: int) -> Contact:
    walls = tuple(json.loads(data.attrs["walls"]))
    k = data["contact_wall"].size
    vectors = ("points", "directions", "drags")
    arrays = fields(data, {f"contact_{name}": (k, 3) if name in vectors else (k,) for name in CONTACT_ARRAYS})
    number = arrays["contact_wall"]
    if k and not 0 <= number.min() <= number.max() < len(walls):
        raise InputError(f"contact_wall names wall {int(number.max())} of {len(walls)}")
    return Contact(
        walls=walls,
        held=np.flatnonzero(_held(data, nodes)).astype(np.int32),
        spacing=_spacing(data),
        **{name.removeprefix("contact_"): values for name, values in arrays.items()},
    )


def _held(data: xr.Dataset, nodes: int) -> BoolArray:
    """(n,) nodes that never move."""
    held = np.zeros(nodes, dtype=bool)
    held[fields(data, {"held_nodes": (-1,)})["held_nodes"]] = True
    return held


def _spacing(data: xr.Dataset) -> float:
    """Of contact points, m."""
    return checked_spacing(float(data.attrs["contact_spacing_m"]))


def _wall_shifts(shifts: Mapping[str, Any], speaker: Speaker) -> dict[str, FloatArray]:
    unknown = [name for name in shifts if name not in speaker.walls]
    if unknown:
        raise InputError(f"it displaces a wall {unknown[0]!r}, which the speaker has not")
    return {name: np.asarray(shift, dtype=np.float64).reshape(3) for name, shift in shifts.items()}


def _node_set(speaker: Speaker, name: str) -> IntArray:
    for sets in (speaker.node_sets, speaker.contours):
        if name in sets:
            return sets[name]
    known = ", ".join([*speaker.node_sets, *speaker.contours]) or "none"
    raise InputError(f"no node set {name!r}; this speaker has {known}")
