"""Exceptions of the package.

Input faults raise :class:`InputError` with what is wrong, where, and what to do. Numerical failure raises
:class:`SolveError`, which carries the last good state.
"""

from __future__ import annotations

from typing import Any


class InputError(ValueError):
    """An argument is wrong: its shape, type, range or consistency with the other arguments."""


class SpeakerFileError(InputError):
    """A speaker file cannot be read: truncated, foreign, of another version, or inconsistent."""


class SolveError(RuntimeError):
    """A numerical solution failed.

    Attributes:
        status: name of the exit status.
        posture: last good posture of a static solve, or None.
        movement: movement up to the failure of a dynamic solve, or None.
        report: report of the run up to the failure, or None.
        study: what a study had finished, as its Dataset, or None.
    """

    def __init__(
        self,
        message: str,
        *,
        status: str = "",
        posture: Any = None,
        movement: Any = None,
        report: Any = None,
        study: Any = None,
    ) -> None:
        super().__init__(message)
        self.status = status
        self.posture = posture
        self.movement = movement
        self.report = report
        self.study = study


class SolveInterrupted(KeyboardInterrupt):
    """A solve was stopped by Ctrl-C.

    Attributes:
        posture: last good posture.
        movement: movement up to the interruption, or None.
        study: what a study had finished, as its Dataset, or None.
    """

    def __init__(self, message: str, *, posture: Any = None, movement: Any = None, study: Any = None) -> None:
        super().__init__(message)
        self.posture = posture
        self.movement = movement
        self.study = study
