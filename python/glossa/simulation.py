"""Movements, advanced step by step or as a whole."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np

from glossa import _core
from glossa.anatomy.arrays import FloatArray
from glossa.anatomy.speaker import Speaker
from glossa.body import Body
from glossa.checks import finite_number, one_of
from glossa.effects import Yeoh
from glossa.errors import InputError, SolveError, SolveInterrupted
from glossa.motor.schedule import Schedule
from glossa.results import Movement, Posture, SolveReport

LOCAL_ERROR = {"draft": 20e-6, "standard": 2e-6, "reference": 0.1e-6}
"""Tolerated local error of an adaptive step, m, by accuracy.

Largest error at any node and time in 200 ms of /i/ and /a/ with everything (built-in speaker and PB, mirrored): draft
0.08 to 0.19 mm, standard 0.03 to 0.053 mm; reports state an estimate (``accumulated_error``: 0.13 to 0.15, 0.04 mm).
They take 0.3 to 0.5 and 0.5 to 0.55 s of one thread; ``glossa accuracy --show`` has 100 ms, and "reference"."""

STAGE_TOLERANCE = {"draft": 3e-4, "standard": 1e-4, "reference": 1e-9}
"""Residual of a stage over force scale, by accuracy.

Momentum carries what is left to the next step. After a step of 10 ms a short one turns 1e-3 of the scale into a jump of
a light node by 0.05 mm (at 5 m/s), which the error estimate answers with steps of 0.01 ms."""

LONGEST_STEP = 0.010
"""Longest adaptive step, s."""

SHORTEST_ADAPTIVE = 1e-5
"""An adaptive step is not made shorter than this for the sake of its error, s."""

SHORTEST_STEP = 1e-7
"""Shortest time step that can be asked for, s; a syllable would take a million."""

INTEGRATORS = ("SDIRK2", "BDF2", "backward_euler", "trapezoidal")


class Simulation:
    """A movement under way; made by :meth:`glossa.Scene.start`.

    A step that fails leaves the state as it was.
    """

    def __init__(
        self,
        speaker: Speaker,
        tissue: Yeoh,
        body: Body,
        solver: _core.Solver,
        schedule: Schedule,
        *,
        positions: FloatArray,
        pressure: FloatArray | None,
        contact_pressure: FloatArray | None,
        contact_drag: FloatArray | None,
        wall_displacements: Mapping[str, FloatArray],
        wall_shift: FloatArray | None,
        dt: float | None,
        accuracy: str | float,
        integrator: str | None,
    ) -> None:
        error, tolerance = _accuracy(accuracy)
        step = LONGEST_STEP if dt is None else _step(dt)
        touching = body.contact is not None
        if integrator is not None:
            one_of(integrator, INTEGRATORS, "integrator")
        times, fractions = schedule.table
        unknown = [name for name in schedule.muscles if name not in speaker.muscles]
        if unknown:
            known = ", ".join(speaker.muscles) or "none"
            raise InputError(f"unknown muscle {unknown[0]!r} in the schedule; this speaker has {known}")
        table = np.full((len(times), len(speaker.muscles)), np.nan)
        place = {name: k for k, name in enumerate(speaker.muscles)}
        table[:, [place[name] for name in schedule.muscles]] = fractions
        self.speaker = speaker
        self.tissue = tissue
        self.schedule = schedule
        self._body = body
        self._walls = wall_displacements
        self._core = _core.Simulation(
            solver,
            times=times,
            fractions=table.ravel(),
            positions=body.restrict_positions(positions, "initial"),
            pressure=None if pressure is None else body.restrict_elements(pressure),
            contact_pressure=contact_pressure,
            contact_drag=contact_drag,
            wall_shift=wall_shift,
            max_step=step,
            error_tolerance=error if dt is None else 0.0,
            least_step=SHORTEST_ADAPTIVE,
            tolerance=tolerance,
            integrator=integrator or ("BDF2" if touching else "SDIRK2"),
        )

    @property
    def time(self) -> float:
        """Present time, s."""
        return float(self._core.time)

    @property
    def positions(self) -> FloatArray:
        """(n, 3) present positions, m."""
        return self._body.expand(self._core.positions)

    @property
    def velocities(self) -> FloatArray:
        """(n, 3) present velocities, m/s."""
        return self._body.expand(self._core.velocities)

    @property
    def state(self) -> Any:
        """Everything the future depends on; a copy. Assigning a state goes back to it."""
        return self._core.state

    @state.setter
    def state(self, state: Any) -> None:
        if not isinstance(state, _core.State):
            raise InputError(f"state must come from a simulation, got {type(state).__name__}")
        self._core.state = state

    @property
    def report(self) -> SolveReport:
        """What the movement has taken so far."""
        return SolveReport.from_core(self._core.report)

    @property
    def posture(self) -> Posture:
        """The present moment."""
        core, positions = self._core, self.positions
        return Posture(
            speaker=self.speaker,
            commands=self.schedule.at(max(self.time, 0.0)),
            positions=positions,
            activations=self._body.expand_fibres(self._core.activation),
            fibre_forces=self._body.expand_tensions(self._core.tension),
            pressure=None,
            stiffening=None,
            support_forces=None,
            contact=self._body.expand_contact(positions, core.contact_pressure, core.contact_drag, self._walls),
            hyoid=self._body.hyoid_pose(core.positions),
            wall_displacements=self._walls,
            report=self.report,
            time=self.time,
            tissue=self.tissue,
        )

    @property
    def kinetic_energy(self) -> float:
        """Of the body or, mirrored, of its half, J."""
        return float(self._core.kinetic_energy)

    @property
    def potential_energy(self) -> float:
        """Of tissue, weight, hyoid springs and the penalty of contact, without muscles and friction, J.

        Of the body or, mirrored, of its half.
        """
        return float(self._core.potential_energy)

    def step(self, dt: float) -> float:
        """Advance by ``dt`` seconds, in shorter steps where options or reflex ask for it; returns the new time.

        Raises:
            InputError: a ``dt`` that is not positive and finite.
            SolveError, SolveInterrupted: as :meth:`run`; the state is that of the last good step.
        """
        status = self._core.step(_step(dt))
        if status != "converged":
            self._fail(status, None)
        return self.time

    def run(self, until: float) -> Movement:
        """Advance to a time in s and return the movement from now to then.

        Raises:
            InputError: an end that does not lie ahead.
            SolveError: a step failed; ``movement`` holds what was computed.
            SolveInterrupted: Ctrl-C; ``movement`` holds what was computed.
        """
        core, body = self._core, self._body
        now = (core.time, core.positions, core.velocities, core.activation, core.tension)
        touch = (core.contact_pressure, core.contact_drag)
        status, times, positions, velocities, activation, tension, pressure, drag = core.solve(
            finite_number(until, "until")
        )
        frames = (now[1], *positions)
        movement = Movement(
            speaker=self.speaker,
            times=np.concatenate([[now[0]], times]),
            positions=np.stack([body.expand(frame) for frame in frames]),
            velocities=np.stack([body.expand(frame) for frame in (now[2], *velocities)]),
            activations=body.expand_fibres(np.concatenate([now[3][None], activation])),
            fibre_forces=body.expand_tensions(np.concatenate([now[4][None], tension])),
            contact=body.contact_course(
                np.concatenate([touch[0][None], pressure]), np.concatenate([touch[1][None], drag]), self._walls
            ),
            hyoid=body.hyoid_course(frames),
            report=self.report,
            schedule=self.schedule,
            tissue=self.tissue,
        )
        if status != "converged":
            self._fail(status, movement)
        return movement

    def _fail(self, status: str, movement: Movement | None) -> None:
        if status == "interrupted":
            raise SolveInterrupted(
                f"movement interrupted at {self.time:g} s; .movement holds what was computed",
                posture=self.posture,
                movement=movement,
            )
        raise SolveError(
            f"no time step from {self.time:g} s on could be solved ({status}); .movement and .posture hold what was "
            "computed. Use smaller steps or slower commands",
            status=status,
            posture=self.posture,
            movement=movement,
            report=self.report,
        )


def _step(dt: float) -> float:
    """A time step that can work, s."""
    step = finite_number(dt, "dt")
    if step <= 0.0:
        raise InputError(f"dt must be positive, got {dt!r} s")
    if step < SHORTEST_STEP:
        raise InputError(f"dt must be at least {SHORTEST_STEP:g} s, got {dt!r} s")
    return step


def _accuracy(accuracy: str | float) -> tuple[float, float]:
    """Local error (m) and stage tolerance."""
    if isinstance(accuracy, str):
        if accuracy not in LOCAL_ERROR:
            allowed = ", ".join(map(repr, LOCAL_ERROR))
            raise InputError(f"accuracy must be {allowed} or a local error in m, got {accuracy!r}")
        return LOCAL_ERROR[accuracy], STAGE_TOLERANCE[accuracy]
    error = finite_number(accuracy, "accuracy")
    if error <= 0.0:
        raise InputError(f"accuracy must be a positive local error in m, got {accuracy!r}")
    return error, min(STAGE_TOLERANCE["draft"], max(STAGE_TOLERANCE["reference"], 0.4 * error))
