"""Scenes: a speaker and the effects that act on it; what motor commands make of it."""

from __future__ import annotations

import logging
import math
from collections.abc import Mapping, Sequence
from functools import cached_property
from types import MappingProxyType
from typing import Any

import numpy as np
import pandas as pd

from glossa import _core
from glossa.anatomy.arrays import BoolArray, FloatArray
from glossa.anatomy.contact_samples import SPACING
from glossa.anatomy.division import Division
from glossa.anatomy.speaker import Speaker
from glossa.body import Body, gather_fibres
from glossa.boundary import nodal_loads, prescribed_positions, wall_displacements
from glossa.checks import finite_number, flag, instance, items, one_of, positive_number, real_array, whole_number
from glossa.contact_points import ContactPoints, checked_spacing, contact_points
from glossa.effects import (
    DEFAULT,
    FIRING_GRADIENT,
    Damping,
    Default,
    Reflex,
    Stiffening,
    Yeoh,
    gravity_vector,
)
from glossa.errors import InputError, SolveError, SolveInterrupted
from glossa.hyoid_motion import check_mobile_hyoid
from glossa.linear_motion import LinearMotion, linear_motion
from glossa.motor.commands import MotorCommands
from glossa.motor.schedule import Schedule
from glossa.results import Movement, Posture, SolveReport
from glossa.simulation import Simulation
from glossa.spatial_error import (
    Divided,
    MovementSpatialError,
    SpatialError,
    finer_body,
    movement_error,
    posture_error,
)
from glossa.tolerances import Tolerances, tolerances

log = logging.getLogger(__name__)

_BALANCED = 1e-3  # residual over force scale of what counts as an equilibrium
_LEAST_SCALE = 1e-6  # N


class Scene:
    """A speaker and the effects that act on it. An effect is off when its argument is None or False, and then free.

    Args:
        speaker: any body of hexahedra with its muscles.
        gravity: "upright" (-z), "supine" (+x), a vector in m/s2, or None.
        contact: contact with the speaker's walls, on the faces that :attr:`Speaker.contact_faces` names for each, or
            on the whole free surface where it names none. Left alone: if the speaker has walls.
        contact_spacing: distance of the contact points, m, from 0.4e-3 to 2.5e-3. Between them the tongue may enter a
            wall deeper than ``accuracy`` allows: 0.5 mm in the built-in speaker's /i/, 0.06 mm at 0.625e-3
            (:mod:`glossa.surface_penetration`).
        friction: Coulomb coefficient of contact; 0 or None for none, which is cheaper.
        hyoid: "mobile": the node set "hyoid" moves with the bone, which hangs on its springs; "fixed" holds it. Left
            alone: mobile if the speaker has a hyoid, else fixed if it has the node set.
        stiffening: eq. 1; True for its defaults, or :class:`Stiffening`.
        reflex: eq. 2 with delay and rate; None: the activation follows the length at once, without rate.
        force_velocity: eq. 5.
        damping: Rayleigh damping of movements.
        tissue: material.
        element: "Q1P0" (mean dilatation), "Q2P1" (quadratic, discontinuous linear pressure: the hexahedra of a mesh of
            even division, eight by eight) or "Q1" (locks; for comparison).
        mirror: compute the half y >= 0 only; refused where the scene is not symmetric.
        fixed: node sets held at rest. Left alone: "jaw", if the speaker has it.
        firing_gradient: c of eq. 3, 1/m.
        threads: of the element loops; results have the same bits for any number.

    A scene can be pickled: it is built anew from its speaker and ``options``, the arguments as they were given.

    Raises:
        InputError: impossible options, saying which and why.
    """

    def __init__(
        self,
        speaker: Speaker,
        *,
        gravity: str | Sequence[float] | None = "upright",
        contact: bool | Default = DEFAULT,
        contact_spacing: float = SPACING,
        friction: float | None = 0.1,
        hyoid: str | Default = DEFAULT,
        stiffening: bool | Stiffening = True,
        reflex: Reflex | None = Reflex(),
        force_velocity: bool = True,
        damping: Damping | None = Damping(),
        tissue: Yeoh = Yeoh(),
        element: str = "Q1P0",
        mirror: bool = False,
        fixed: Sequence[str] | Default = DEFAULT,
        firing_gradient: float = FIRING_GRADIENT,
        threads: int = 1,
    ) -> None:
        options = {name: value for name, value in locals().items() if name not in ("self", "speaker")}
        if not isinstance(speaker, Speaker):
            raise InputError(f"speaker must be a Speaker, got {type(speaker).__name__}")
        self.speaker = speaker
        self.options: Mapping[str, Any] = MappingProxyType(options)
        self.gravity = gravity_vector(gravity)
        self.stiffening = _stiffening(stiffening, speaker)
        self.reflex = instance(reflex, Reflex, "reflex", optional=True)
        self.damping = instance(damping, Damping, "damping", optional=True) or Damping(alpha=0.0, beta=0.0)
        self.tissue = instance(tissue, Yeoh, "tissue")
        self.element = one_of(element, ("Q1P0", "Q1", "Q2P1"), "element")
        self.force_velocity = flag(force_velocity, "force_velocity")
        self.mirror = flag(mirror, "mirror")
        self.firing_gradient = positive_number(firing_gradient, "firing gradient")
        self.threads = whole_number(threads, "threads", 1, 256)
        self.notes = tuple[str, ...]()
        self.contact = self._with_contact(contact)
        self.contact_spacing = checked_spacing(contact_spacing)
        self.friction = _friction(friction)
        self.hyoid = self._hyoid_mode(hyoid)
        self.fixed = self._held_sets(fixed)
        if self.notes:
            log.info("%s: %s", speaker.name or "scene", "; ".join(self.notes))
        self._seconds: Mapping[str, float] | None = None
        self._divided: Divided | None = None
        self._body, self._solver  # noqa: B018 - symmetry and symbolic faults belong to construction

    # Options

    def _note(self, text: str) -> None:
        self.notes = (*self.notes, text)

    def _with_contact(self, contact: bool | Default) -> bool:
        if contact is not DEFAULT:
            if flag(contact, "contact") and not self.speaker.walls:
                raise InputError("contact=True: this speaker has no walls; use contact=False or give it walls")
            return bool(contact)
        if not self.speaker.walls:
            self._note("no wall contact: the speaker has no walls")
        return bool(self.speaker.walls)

    def _hyoid_mode(self, hyoid: str | Default) -> str | None:
        """Either "mobile" or "fixed", or None where there is none."""
        attached, bone = "hyoid" in self.speaker.node_sets, self.speaker.hyoid is not None
        if isinstance(hyoid, Default):
            if attached and not bone:
                self._note("the hyoid is fixed: the speaker has the node set but no bone that could move")
            return ("mobile" if bone else "fixed") if attached else None
        if one_of(hyoid, ("mobile", "fixed"), "hyoid") == "mobile" and not bone:
            raise InputError("hyoid='mobile': this speaker has no hyoid bone; use hyoid='fixed' or give it one")
        if not attached:
            raise InputError(f"hyoid={hyoid!r}: this speaker has no node set 'hyoid'")
        return hyoid

    def _held_sets(self, fixed: Sequence[str] | Default) -> tuple[str, ...]:
        sets = self.speaker.node_sets
        if isinstance(fixed, Default):
            held = ["jaw"] if "jaw" in sets else []
            if not held:
                self._note("no node is held: the speaker has no node set 'jaw'")
        else:
            if isinstance(fixed, str):
                raise InputError(f"fixed must be a sequence of node set names, got the string {fixed!r}")
            held = list(items(fixed, "fixed (names of node sets)"))
        if self.hyoid == "fixed":
            held.append("hyoid")
        for name in held:
            if not isinstance(name, str) or name not in sets:
                raise InputError(f"fixed: no node set {name!r}; this speaker has {', '.join(sets) or 'none'}")
        return tuple(dict.fromkeys(held))

    @cached_property
    def effects(self) -> tuple[str, ...]:
        """Names of the effects in force."""
        chosen = {
            "elasticity": True,
            "muscles": bool(self.speaker.muscles),
            "stiffening": bool(self.speaker.muscles) and self.stiffening is not None,
            "reflex": bool(self.speaker.muscles) and self.reflex is not None,
            "force_velocity": bool(self.speaker.muscles) and self.force_velocity,
            "gravity": self.gravity is not None,
            "contact": self.contact,
            "friction": self.contact and self.friction > 0.0,
            "hyoid": self.hyoid == "mobile",
            "damping": self.damping != Damping(alpha=0.0, beta=0.0),
            "mirror": self.mirror,
        }
        return tuple(name for name, on in chosen.items() if on)

    def cost(self) -> pd.Series[float]:
        """Seconds of the last solve by part of the work.

        Raises:
            InputError: nothing has been solved yet.
        """
        if self._seconds is None:
            raise InputError("nothing has been solved in this scene yet; call equilibrate or simulate first")
        return pd.Series(dict(self._seconds), name="seconds", dtype=float)

    def __reduce__(self) -> tuple[Any, ...]:
        return _rebuilt, (self.speaker, dict(self.options))

    def __repr__(self) -> str:
        return f"Scene({self.speaker.name or 'unnamed speaker'}: {', '.join(self.effects)})"

    # The body in the core

    @cached_property
    def _body(self) -> Body:
        saturation = math.log(2.0) / self.firing_gradient
        if self.hyoid == "mobile":
            check_mobile_hyoid(self.speaker, self.fixed, mirror=self.mirror)
        return Body(
            self.speaker,
            gather_fibres(self.speaker, self.stiffening, saturation),
            mirror=self.mirror,
            mobile_hyoid=self.hyoid == "mobile",
            contact=self._contact_points,
        )

    @cached_property
    def _contact_points(self) -> ContactPoints | None:
        if not self.contact:
            return None
        return contact_points(self.speaker, self._held_nodes, mirror=self.mirror, spacing=self.contact_spacing)

    @cached_property
    def _free(self) -> BoolArray:
        """(k, 3) unknown components of the body."""
        return self._body.free_components(np.repeat(self._held_nodes[:, None], 3, axis=1))

    @cached_property
    def _solver(self) -> _core.Solver:
        gravity = self.gravity
        if self.mirror and gravity is not None and gravity[1] != 0.0:
            raise InputError(f"mirror=True needs gravity in the midsagittal plane, got {gravity}")
        return _core.Solver(
            self._body.nodes,
            self._body.hexahedra,
            self._body.core_fibres(),
            muscle_count=len(self.speaker.muscles),
            c10=self.tissue.c10,
            c20=self.tissue.c20,
            bulk_modulus=self.tissue.bulk_modulus,
            density=self.tissue.density,
            element=self.element,
            firing_gradient=self.firing_gradient,
            force_velocity=self.force_velocity,
            stiffening=self.stiffening is not None,
            reflex=None if self.reflex is None else (self.reflex.delay, self.reflex.velocity_gain),
            damping=(self.damping.alpha, self.damping.beta, self.damping.law),
            gravity=gravity,
            contact=self._body.core_contact(self.friction),
            bone=None if self._body.hyoid is None else self._body.hyoid.core,
            free=self._free.astype(np.uint8).ravel(),
            threads=self.threads,
        )

    def _commands(self, commands: Any) -> MotorCommands | None:
        if commands is None:
            return None
        checked = commands if isinstance(commands, MotorCommands) else MotorCommands(commands)
        unknown = [name for name in checked if name not in self.speaker.muscles]
        if unknown:
            known = ", ".join(self.speaker.muscles) or "none"
            raise InputError(f"unknown muscle {unknown[0]!r} in the commands; this speaker has {known}")
        return checked

    def _fractions(self, commands: MotorCommands | None) -> FloatArray:
        """(muscles,) fractions in the speaker's order, NaN where silent."""
        return np.array([math.nan if commands is None else commands.get(m, math.nan) for m in self.speaker.muscles])

    # Solves

    def equilibrate(
        self,
        commands: MotorCommands | Mapping[str, float] | None = None,
        *,
        start: Posture | FloatArray | None = None,
        prescribed: Mapping[str, Any] | None = None,
        loads: Mapping[str, Any] | None = None,
        accuracy: str | Tolerances = "standard",
        max_iterations: int = 150,
    ) -> Posture:
        """Static equilibrium of motor commands, gravity, loads and prescribed displacements.

        Args:
            commands: lambda by muscle; muscles not named are silent; None: no muscle acts.
            start: posture or (n, 3) positions in m to start from; None: rest. An equilibrium brings the state of its
                contact along, so that nothing is left to do where it is one of these commands, too, and little where
                they differ by a few percent. The slip that friction opposes counts from rest all the same. Of tissue
                more than twice or less than half as stiff as this scene's, whose pressures tell nothing here, a posture
                brings positions alone.
            prescribed: displacement from rest of node sets, (3,) or (k, 3) in m; None as a component leaves it free.
                "wall:name" displaces a wall, (3,) in m.
            loads: total dead force on node sets, (3,) in N. It is spread as a uniform traction over the boundary faces
                that lie wholly in the set, or equally over its nodes where there are none.
            accuracy: "draft", "standard" or "reference": residual below 1e-5, 1e-8 or 1e-11 of the force scale, and
                no wall entered deeper than 0.05, 0.05 or 0.02 mm at any contact point; or a
                :class:`glossa.tolerances.Tolerances`.
            max_iterations: Newton iterations after which a minimisation is given up. Contact's multipliers, stiffening
                factors that must be held and walls that move take one minimisation for each of their updates.

        Raises:
            InputError: wrong input, or a body that is not held.
            SolveError: no convergence; ``posture`` is the last good state and ``report`` says what happened.
            SolveInterrupted: Ctrl-C; ``posture`` is the last good state.
        """
        checked = self._commands(commands)
        wanted = tolerances(accuracy)
        limit = whole_number(max_iterations, "max_iterations", 1, 100_000)
        from_positions, pressure = self._start(start)
        walls, sets = wall_displacements(self.speaker, {} if prescribed is None else prescribed)
        if walls and not self.contact:
            raise InputError(f"prescribed: wall {next(iter(walls))!r} moves, but this scene has no contact")
        held, target = prescribed_positions(self.speaker, sets)
        if self.hyoid == "mobile" and held[self.speaker.node_sets["hyoid"]].any():
            raise InputError("prescribed: a node of the mobile hyoid cannot be prescribed; use hyoid='fixed'")
        free = self._free & ~self._body.restrict_mask(held, "prescribed")
        at_rest = np.where(self._held_nodes[:, None], self.speaker.nodes, from_positions)
        targets = np.where(held, target, at_rest)
        load = nodal_loads(self.speaker, {} if loads is None else loads)
        before = start if isinstance(start, Posture) else None
        pressed = before is not None and before.time is None and self._same_pressures(before)
        solution = self._solver.equilibrate(
            fractions=self._fractions(checked),
            start=self._body.restrict_positions(from_positions, "start"),
            pressure=None if pressure is None else self._body.restrict_elements(pressure),
            target=self._body.restrict_positions(targets, "prescribed"),
            free=free.astype(np.uint8).ravel(),
            load=None if load is None else self._body.restrict_forces(load, "loads"),
            wall_start=self._wall_shift({} if before is None else before.wall_displacements),
            wall_shift=self._wall_shift(walls),
            contact_pressure=self._body.restrict_contact(before.contact)[0] if before and pressed else None,
            tolerance=wanted.residual,
            gap_tolerance=wanted.gap,
            max_iterations=limit,
        )
        posture = self._posture(solution, checked, free, walls)
        return self._finished(posture)

    def _same_pressures(self, start: Posture) -> bool:
        """Whether the posture's tissue is stiff enough, and not too stiff, for its pressures to be a start."""
        return start.tissue is not None and start.tissue.about_as_stiff_as(self.tissue)

    def _wall_shift(self, walls: Mapping[str, FloatArray]) -> FloatArray | None:
        """(walls, 3) m; None without contact."""
        if not self.contact:
            return None
        for name, shift in walls.items():
            if self.mirror and shift[1] != 0.0:
                raise InputError(f"mirror=True: wall {name!r} cannot move sideways, got {shift}")
        return np.array([walls.get(name, np.zeros(3)) for name in self.speaker.walls])

    @cached_property
    def _held_nodes(self) -> BoolArray:
        """(n,) nodes of the speaker that the scene holds at rest."""
        held = np.zeros(len(self.speaker.nodes), dtype=bool)
        for name in self.fixed:
            held[self.speaker.node_sets[name]] = True
        held[self.speaker.outside_points] = True
        return held

    def _start(self, start: Posture | FloatArray | None) -> tuple[FloatArray, FloatArray | None]:
        if start is None:
            return self.speaker.nodes, None
        if isinstance(start, Posture):
            if start.speaker is not self.speaker and start.speaker.fingerprint != self.speaker.fingerprint:
                raise InputError("start: this posture belongs to another speaker")
            return start.positions, start.pressure if self._same_pressures(start) else None
        positions = real_array(start, "start must be a Posture or an array of node positions")
        if positions.shape != self.speaker.nodes.shape:
            raise InputError(f"start: positions need shape {self.speaker.nodes.shape}, got {positions.shape}")
        if not np.isfinite(positions).all():
            raise InputError("start: positions must be finite")
        return positions, None

    def _posture(
        self, solution: Any, commands: MotorCommands | None, free: BoolArray, walls: Mapping[str, FloatArray]
    ) -> Posture:
        body = self._body
        positions = body.expand(solution.positions)
        support = np.where(free, 0.0, solution.force)
        return Posture(
            speaker=self.speaker,
            commands=commands,
            positions=positions,
            activations=body.expand_fibres(solution.activation),
            fibre_forces=body.expand_tensions(solution.tension),
            pressure=body.expand_elements(solution.pressure),
            stiffening=body.expand_elements(solution.stiffening),
            support_forces=body.expand_forces(support),
            contact=body.expand_contact(positions, solution.contact_pressure, solution.contact_drag, walls),
            hyoid=body.hyoid_pose(solution.positions),
            wall_displacements=walls,
            report=SolveReport.from_core(solution.report),
            tissue=self.tissue,
        )

    def _finished(self, posture: Posture) -> Posture:
        report = posture.report
        assert report is not None
        self._seconds = report.seconds
        if report.converged:
            return posture
        if report.status == "interrupted":
            raise SolveInterrupted("equilibrium interrupted; .posture is the last good state", posture=posture)
        raise SolveError(
            f"no equilibrium: {report.status} after {report.iterations} iterations, residual {report.residual:.3g} N "
            f"of a force scale of {report.force_scale:.3g} N, smallest Jacobian {report.least_jacobian:.3g} in "
            f"hexahedron {report.worst_element}; .posture is the last good state. Start from a nearer posture or "
            "change the commands in smaller steps",
            status=report.status,
            posture=posture,
            report=report,
        )

    def linearise(self, posture: Posture) -> LinearMotion:
        """Matrices of small movements about an equilibrium of this scene, its reflex delayed.

        Raises:
            InputError: a posture of another speaker, a moment of a movement, or no equilibrium of this scene.
        """
        if not isinstance(posture, Posture) or posture.time is not None:
            raise InputError("linearise needs a Posture from equilibrate, not a moment of a movement")
        positions, _ = self._start(posture)
        walls = posture.wall_displacements if self.contact else {}
        pressure, drag = self._body.restrict_contact(posture.contact)
        core = _core.LinearMotion(
            self._solver,
            fractions=self._fractions(self._commands(posture.commands)),
            positions=self._body.restrict_positions(positions, "posture"),
            contact_pressure=pressure,
            contact_drag=drag,
            wall_shift=self._wall_shift(walls),
        )
        nothing = np.zeros(len(core.unknowns))
        residual = float(np.linalg.norm(core.force(nothing, nothing, core.activation)))
        scale = 1.0 if posture.report is None else posture.report.force_scale
        if residual > _BALANCED * max(scale, _LEAST_SCALE):
            raise InputError(
                f"linearise: forces of {residual:.3g} N are left in this posture; it is no equilibrium of this scene. "
                "Equilibrate it here first"
            )
        names, source = list(self.speaker.muscles), self._body.fibre_source
        return linear_motion(
            core,
            self.reflex,
            muscles=[names[k] for k in self._body.fibres.muscle[source][core.active]],
            nodes_of=self._body.expand,
        )

    def start(
        self,
        schedule: Schedule | MotorCommands | Mapping[str, float] | None = None,
        *,
        dt: float | None = None,
        accuracy: str | float = "standard",
        initial: Posture | None = None,
        integrator: str | None = None,
    ) -> Simulation:
        """A movement to be advanced step by step from Python; arguments as :meth:`simulate`."""
        if isinstance(schedule, Schedule):
            for commands in (schedule.at(float(time)) for time in schedule.corners[:1]):
                self._commands(commands)
            planned = schedule
        else:
            planned = Schedule([0.0], [self._commands(schedule) or MotorCommands({})])
        positions, pressure = self._start(initial)
        before = initial if isinstance(initial, Posture) else None
        walls = {} if before is None or not self.contact else before.wall_displacements
        touch = before.contact if before is not None and self._same_pressures(before) else None
        contact_pressure, contact_drag = self._body.restrict_contact(touch)
        return Simulation(
            self.speaker,
            self.tissue,
            self._body,
            self._solver,
            planned,
            positions=positions,
            pressure=pressure,
            contact_pressure=contact_pressure,
            contact_drag=contact_drag,
            wall_displacements=walls,
            wall_shift=self._wall_shift(walls),
            dt=dt,
            accuracy=accuracy,
            integrator=integrator,
        )

    def simulate(
        self,
        schedule: Schedule | MotorCommands | Mapping[str, float] | None,
        until: float,
        *,
        dt: float | None = None,
        accuracy: str | float = "standard",
        initial: Posture | None = None,
        integrator: str | None = None,
    ) -> Movement:
        """Movement under motor commands that change with time, from rest at time 0.

        Args:
            schedule: commands over time; constant commands; or None: no muscle acts.
            until: end, s.
            dt: longest time step, s, for fixed steps: intervals between corners of the commands (and their first
                echoes after the reflex delay) are divided equally. Steps beyond 2/3 of the delay are divided further,
                because the reflex needs the past. None: steps adapt to the accuracy.
            accuracy: "draft", "standard" or "reference", or the tolerated local error of a step in m.
            initial: posture to start from, without velocity; walls stay where it has them; None: rest positions.
            integrator: "SDIRK2", "BDF2", "backward_euler" or "trapezoidal" (the last two for comparison). None: BDF2
                with contact, which makes no energy at touching points, else SDIRK2.

        Raises:
            InputError: wrong input.
            SolveError: a step failed; ``movement`` holds what was computed.
            SolveInterrupted: Ctrl-C; ``movement`` holds what was computed.
        """
        simulation = self.start(schedule, dt=dt, accuracy=accuracy, initial=initial, integrator=integrator)
        try:
            movement = simulation.run(until)
        finally:
            self._seconds = simulation.report.seconds
        return movement

    # Error in space

    def spatial_error(
        self,
        posture: Posture,
        *,
        prescribed: Mapping[str, Any] | None = None,
        loads: Mapping[str, Any] | None = None,
        finer: Speaker | None = None,
    ) -> SpatialError:
        """Estimated error of an equilibrium that is due to its mesh, from a second solve with half the size of cells.

        It takes 20 to 60 times what the posture took; see :mod:`glossa.spatial_error` for what it is worth.

        Args:
            posture: equilibrium of this scene.
            prescribed: as the posture was solved with.
            loads: likewise.
            finer: the same body with every hexahedron divided in eight; None: the built-in speaker at twice its
                resolution, any other speaker's :meth:`glossa.Speaker.refined`.

        Raises:
            InputError: no equilibrium of this scene, ``prescribed`` and ``loads``, or another body.
            SolveError: no convergence on the finer mesh.
            SolveInterrupted: Ctrl-C.
        """
        return posture_error(self, posture, prescribed or {}, loads or {}, finer)

    def spatial_error_of_movement(self, movement: Movement, *, finer: Speaker | None = None) -> MovementSpatialError:
        """As :meth:`spatial_error` for a movement from rest or from an equilibrium: repeated on the finer mesh.

        Both have adaptive steps; the errors of a movement in time should be smaller than what is looked for.

        Args:
            movement: of this scene, with steps of ``accuracy="standard"`` or shorter.
            finer: as for :meth:`spatial_error`.

        Raises:
            InputError: another speaker, a movement that begins in motion or was read from a file, or another body.
            SolveError: a step on the finer mesh failed.
            SolveInterrupted: Ctrl-C.
        """
        return movement_error(self, movement, finer)

    def divided(self, finer: Speaker | None = None) -> Divided:
        """This scene with the finer body of :meth:`spatial_error`; the last one is kept.

        Raises:
            InputError: another body.
        """
        instance(finer, Speaker, "finer", optional=True)
        key = None if finer is None else finer.fingerprint
        if self._divided is None or self._divided.key != key:
            body = finer_body(self.speaker) if finer is None else finer
            self._divided = Divided(key, Division(self.speaker, body), Scene(body, **self.options))
        return self._divided


def _rebuilt(speaker: Speaker, options: dict[str, Any]) -> Scene:
    return Scene(speaker, **options)


def _friction(value: float | None) -> float:
    if value is None:
        return 0.0
    friction = finite_number(value, "friction")
    if not 0.0 <= friction <= 10.0:
        raise InputError(f"friction must lie between 0 and 10, got {value!r}")
    return friction


def _stiffening(value: bool | Stiffening | None, speaker: Speaker) -> Stiffening | None:
    if value is None or value is False:
        return None
    if value is True:
        return Stiffening()
    if not isinstance(value, Stiffening):
        raise InputError(f"stiffening must be True, False or Stiffening, got {value!r}")
    unknown = [name for name in value.gains if name not in speaker.muscles]
    if unknown:
        raise InputError(f"stiffening: unknown muscle {unknown[0]!r}; this speaker has {', '.join(speaker.muscles)}")
    return value
