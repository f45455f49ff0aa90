"""One muscle at a time: the runs of section III.A.1 (figs 5 and 6)."""

from __future__ import annotations

from collections.abc import Iterable

from glossa.motor.commands import MotorCommands
from glossa.results import Posture
from glossa.scene import Scene

COMMAND = 0.75
"""Lambda as a fraction of rest length (caption of fig. 5)."""

LONG_MUSCLE_COMMAND = 0.85
"""Lambda of the long muscles (caption of fig. 5)."""

LONG_MUSCLES = ("Sty", "IL", "SL")


def single_muscle_command(muscle: str) -> float:
    """The paper's command of a muscle that acts alone, as a fraction of rest length."""
    return LONG_MUSCLE_COMMAND if muscle in LONG_MUSCLES else COMMAND


def single_muscle(scene: Scene, muscle: str, command: float | None = None) -> Posture:
    """Equilibrium with one muscle active and every other silent.

    Args:
        scene: any scene; the paper's has gravity and contact.
        muscle: its name.
        command: fraction of rest length; None takes the paper's.

    Raises:
        InputError: a muscle that the speaker lacks, or a command that is not a positive number.
        SolveError, SolveInterrupted: as :meth:`glossa.Scene.equilibrate`.
    """
    fraction = single_muscle_command(muscle) if command is None else command
    return scene.equilibrate(MotorCommands({muscle: fraction}))


def single_muscles(scene: Scene, muscles: Iterable[str] | None = None) -> dict[str, Posture]:
    """:func:`single_muscle` with the paper's command for several muscles; None: all that the speaker has.

    Raises:
        InputError, SolveError, SolveInterrupted: as :func:`single_muscle`.
    """
    names = list(scene.speaker.muscles) if muscles is None else list(muscles)
    return {name: single_muscle(scene, name) for name in names}
