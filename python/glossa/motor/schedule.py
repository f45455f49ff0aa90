"""Motor commands that change in time: piecewise linear, with jumps allowed."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from glossa.checks import finite_number, items
from glossa.errors import InputError
from glossa.motor.commands import MotorCommands

FloatArray = NDArray[np.float64]


class Schedule:
    """Motor commands over time, linear between corners and constant before the first and after the last.

    Two corners at the same time are a jump; the later one holds from that time on.

    Args:
        times: (k,) corners in s, finite, not negative, not decreasing, at most two equal.
        commands: k motor commands, which all name the same muscles.

    Raises:
        InputError: wrong times, another number of commands, or commands for different muscles.
    """

    __slots__ = ("_commands", "_fractions", "_times")

    def __init__(self, times: Any, commands: Sequence[MotorCommands]) -> None:
        self._times = _checked_times(times)
        self._commands = _checked_commands(commands, len(self._times))
        muscles = self.muscles
        table = [[command[muscle] for muscle in muscles] for command in self._commands]
        self._fractions = np.array(table, dtype=np.float64).reshape(len(self._times), len(muscles))
        self._times.flags.writeable = False
        self._fractions.flags.writeable = False

    @classmethod
    def through(
        cls,
        targets: Sequence[tuple[float, MotorCommands]],
        *,
        transition: float = 0.030,
        start: MotorCommands | None = None,
    ) -> Schedule:
        """Ramps through several targets, each held until the next ramp starts.

        Args:
            targets: onset in s of the ramp towards each target, and the target; onsets increase.
            transition: duration of each ramp in s; 0 jumps.
            start: commands before the first ramp; None: every muscle at its rest length.

        Raises:
            InputError: no target, a ramp that starts before the one before it has ended, or as for the class.
        """
        duration = _duration(transition, "transition")
        pairs = [_target(pair) for pair in items(targets, "targets")]
        if not pairs:
            raise InputError("a schedule needs at least one target")
        current = _rest(pairs[0][1]) if start is None else start
        times: list[float] = []
        commands: list[MotorCommands] = []
        for onset, target in pairs:
            if times and onset < times[-1] - _SAME_TIME:
                raise InputError(f"the ramp at {onset} s starts before the one before it ends at {times[-1]} s")
            begin = onset
            if times and duration > 0.0 and onset <= times[-1] + _SAME_TIME:
                begin = times[-1]  # starts where the last ramp ended: one corner, not two
            else:
                times.append(begin)
                commands.append(current)
            times.append(begin + duration)
            commands.append(target)
            current = target
        return Schedule(times, commands)

    @property
    def muscles(self) -> tuple[str, ...]:
        """Muscles with a command, in the order of the first corner's commands."""
        return tuple(self._commands[0])

    @property
    def corners(self) -> FloatArray:
        """Times in s at which the commands jump or change slope, each once; shape (<= k,)."""
        return np.unique(self._times)

    @property
    def table(self) -> tuple[FloatArray, FloatArray]:
        """Corner times (k,) in s and fractions (k, n_muscles) of rest length; read-only. A jump is two equal times."""
        return self._times, self._fractions

    def at(self, time: float) -> MotorCommands:
        """Commands at a time in s; at a jump, those after it.

        Raises:
            InputError: the time is not a finite number.
        """
        seconds = finite_number(time, "time")
        k = int(np.searchsorted(self._times, seconds, side="right"))
        if k == 0:
            return self._commands[0]
        if k == len(self._times):
            return self._commands[-1]
        t0, t1 = float(self._times[k - 1]), float(self._times[k])
        share = (seconds - t0) / (t1 - t0)
        mixed = (1.0 - share) * self._fractions[k - 1] + share * self._fractions[k]
        return MotorCommands(dict(zip(self.muscles, mixed.tolist(), strict=True)))

    def __repr__(self) -> str:
        return (
            f"<{type(self).__name__}: {len(self._times)} corners from {self._times[0]:g} s to {self._times[-1]:g} s, "
            f"muscles {', '.join(self.muscles) or 'none'}>"
        )


class Ramp(Schedule):
    """One linear change of the motor commands, as in the paper: from rest length in 30 ms (section III.A.2).

    Args:
        target: commands at the end; muscles that it does not name are silent throughout.
        duration: length of the ramp in s; 0 is a jump.
        start: commands at the beginning, of the same muscles; None: every muscle at its rest length.
        onset: beginning of the ramp in s.

    Raises:
        InputError: a negative or non-finite time, or a start that names other muscles than the target.
    """

    __slots__ = ()

    def __init__(
        self,
        target: MotorCommands,
        duration: float = 0.030,
        start: MotorCommands | None = None,
        onset: float = 0.0,
    ) -> None:
        begin = finite_number(onset, "onset")
        length = _duration(duration, "duration")
        beginning = _rest(target) if start is None else start
        super().__init__([begin, begin + length], [beginning, target])


_SAME_TIME = 1e-9
"""Times closer than this, in s, are taken as equal: rounding of sums such as 0.1 + 0.03."""


def _rest(target: MotorCommands) -> MotorCommands:
    """Every muscle of the target at its rest length."""
    if not isinstance(target, MotorCommands):
        raise InputError(f"target must be MotorCommands, got {type(target).__name__}")
    return MotorCommands(dict.fromkeys(target, 1.0))


def _duration(value: Any, what: str) -> float:
    number = finite_number(value, what)
    if number < 0.0:
        raise InputError(f"{what} must not be negative, got {number!r} s")
    return number


def _target(pair: Any) -> tuple[float, MotorCommands]:
    try:
        onset, target = pair
    except (TypeError, ValueError):
        raise InputError(f"each target must be a pair of onset and MotorCommands, got {pair!r}") from None
    return finite_number(onset, "onset"), target


def _checked_times(times: Any) -> FloatArray:
    try:
        given = np.array(times)
    except ValueError:
        raise InputError(f"schedule times must be a list of numbers, got {times!r}") from None
    if given.size and given.dtype.kind not in "fiu":
        raise InputError(f"schedule times must be numbers, got {times!r}")
    array = given.astype(np.float64)
    if array.ndim != 1 or len(array) == 0:
        raise InputError(f"schedule times must be a non-empty list, got shape {array.shape}")
    if not np.isfinite(array).all():
        raise InputError(f"schedule times must be finite; time {int(np.argmin(np.isfinite(array)))} is not")
    if array[0] < 0.0:
        raise InputError(f"schedule times must not be negative, got {float(array[0])!r} s")
    steps = np.diff(array)
    if (steps < 0.0).any():
        k = int(np.argmax(steps < 0.0))
        raise InputError(f"schedule times must not decrease: {float(array[k])!r} s, then {float(array[k + 1])!r} s")
    repeated = (steps[1:] == 0.0) & (steps[:-1] == 0.0)
    if repeated.any():
        seconds = float(array[np.argmax(repeated)])
        raise InputError(f"at most two schedule times may be equal (a jump); three are {seconds!r} s")
    return array


def _checked_commands(commands: Sequence[MotorCommands], count: int) -> tuple[MotorCommands, ...]:
    listed = items(commands, "commands of a schedule")
    if len(listed) != count:
        raise InputError(f"a schedule needs one set of commands for each time: {count} times, {len(listed)} commands")
    for k, command in enumerate(listed):
        if not isinstance(command, MotorCommands):
            raise InputError(f"commands {k} of the schedule must be MotorCommands, got {type(command).__name__}")
        different = sorted(set(command) ^ set(listed[0]))
        if different:
            names = ", ".join(different)
            raise InputError(f"all commands of a schedule must name the same muscles: 0 and {k} differ in {names}")
    return listed
