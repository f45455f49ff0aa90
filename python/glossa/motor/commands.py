"""Motor commands: one activation threshold lambda for each muscle (equilibrium-point hypothesis)."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from types import MappingProxyType
from typing import Any, NoReturn

from glossa import paper
from glossa.checks import positive_number
from glossa.errors import InputError

MUSCLES = ("GGa", "GGm", "GGp", "Sty", "HG", "Vert", "Trans", "IL", "SL", "GH", "MH")
"""Muscles of the paper, in the order of its tables."""


class MotorCommands(Mapping[str, float]):
    """Thresholds lambda as fractions of each muscle's rest length, by muscle name.

    A muscle is active where its length exceeds lambda (eq. 2): below 1 it pulls at rest length, above 1 only once it
    is stretched that far. A muscle that is not named stays silent. Immutable, equal by content and hashable.

    Args:
        fractions: lambda by muscle, positive and finite. Names are checked by the scene, against its speaker.

    Raises:
        InputError: not a mapping of names to numbers, or a number that is NaN, infinite, zero or negative.

    Example:
        >>> MotorCommands({"GGp": 0.6, "MH": 0.75}).with_(GGp=0.62)
        MotorCommands({'GGp': 0.62, 'MH': 0.75})
    """

    __slots__ = ("_fractions",)
    _fractions: dict[str, float]

    def __init__(self, fractions: Mapping[str, float]) -> None:
        if not isinstance(fractions, Mapping):
            raise InputError(f"motor commands must map muscle names to fractions, got {type(fractions).__name__}")
        checked = {_muscle_name(name): _fraction(name, value) for name, value in fractions.items()}
        object.__setattr__(self, "_fractions", checked)

    def __getitem__(self, muscle: str) -> float:
        return self._fractions[muscle]

    def __iter__(self) -> Iterator[str]:
        return iter(self._fractions)

    def __len__(self) -> int:
        return len(self._fractions)

    def __eq__(self, other: object) -> bool:
        return self._fractions == other._fractions if isinstance(other, MotorCommands) else NotImplemented

    def __hash__(self) -> int:
        return hash(frozenset(self._fractions.items()))

    def __repr__(self) -> str:
        return f"MotorCommands({self._fractions!r})"

    def __setattr__(self, name: str, value: Any) -> NoReturn:
        raise AttributeError(f"motor commands cannot be changed; use with_() for a changed copy (tried to set {name})")

    def __reduce__(self) -> tuple[type[MotorCommands], tuple[dict[str, float]]]:
        return MotorCommands, (dict(self._fractions),)

    def with_(self, fractions: Mapping[str, float] | None = None, /, **by_name: float) -> MotorCommands:
        """Copy with some commands replaced or added, given as a mapping, by name, or both.

        Raises:
            InputError: as for the class.
        """
        if fractions is not None and not isinstance(fractions, Mapping):
            raise InputError(f"motor commands must map muscle names to fractions, got {type(fractions).__name__}")
        return MotorCommands({**self._fractions, **(fractions or {}), **by_name})

    def scaled(self, muscle: str, factor: float) -> MotorCommands:
        """Copy with one command multiplied: 1.05 raises lambda by 5 % and so lowers the activation.

        Raises:
            InputError: no command for this muscle, or a factor that is not a positive finite number.
        """
        if not isinstance(muscle, str) or muscle not in self._fractions:
            raise InputError(f"no command for muscle {muscle!r} to scale; commands: {', '.join(self) or 'none'}")
        return self.with_({muscle: self._fractions[muscle] * positive_number(factor, f"scale factor of {muscle!r}")})


def _muscle_name(name: Any) -> str:
    if not isinstance(name, str) or not name:
        raise InputError(f"muscle names must be non-empty strings, got {name!r}")
    return name


def _fraction(muscle: Any, value: Any) -> float:
    return positive_number(value, f"command of muscle {muscle!r}")


VOWELS: Mapping[str, MotorCommands] = MappingProxyType(
    {
        row["vowel"]: MotorCommands({muscle: float(row[muscle]) for muscle in MUSCLES})
        for row in paper.rows("table3_motor_commands.csv")
    }
)
"""Commands of /i/, /ə/, /u/ and /a/ (Table III)."""


def vowel_commands(vowel: Any) -> MotorCommands:
    """Commands of a vowel of Table III.

    Raises:
        InputError: another name; the message lists those there are.
    """
    if vowel not in VOWELS:
        raise InputError(f"unknown vowel {vowel!r}; Table III has {', '.join(VOWELS)}")
    return VOWELS[vowel]
