"""The Dataset of an accuracy study."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any

import numpy as np
import xarray as xr

from glossa.scene import Scene
from glossa.studies.accuracy_choices import POSTURE, SOLVE, STEPS, Choice
from glossa.studies.accuracy_runs import COUNTS, Distance, Outcome
from glossa.studies.accuracy_settings import AccuracySettings
from glossa.studies.machine import machine
from glossa.studies.midsagittal_nodes import MIDSAGITTAL_NODES
from glossa.studies.provenance import provenance

_Value = Callable[[Outcome, Distance | None], Any]

CHECKED = (SOLVE, STEPS)
"""What has references with an error of their own."""


@dataclass
class AccuracyTable:
    """Rows by choice and vowel, as they come.

    Attributes:
        scene: of the study.
        settings: likewise.
        choices: likewise.
        resolutions: likewise.
        rows: outcome, and its distance from what it is measured against or None, by number of the choice and vowel.
        checks: distance of a reference from a second one, by what it is a reference for and vowel.
    """

    scene: Scene
    settings: AccuracySettings
    choices: list[Choice]
    resolutions: Sequence[int]
    rows: dict[tuple[int, str], tuple[Outcome, Distance | None]] = field(default_factory=dict)
    checks: dict[tuple[str, str], Distance] = field(default_factory=dict)

    @property
    def vowels(self) -> list[str]:
        """Of postures and movements."""
        return list(dict.fromkeys([*self.settings.vowels, *self.settings.moving]))

    def vowels_of(self, choice: Choice) -> Sequence[str]:
        """Those that a choice is asked for."""
        return self.settings.vowels if choice.kind == POSTURE else self.settings.moving

    def dataset(self) -> xr.Dataset:
        """What is there; the rest is NaN."""
        coordinates = {
            "kind": [choice.kind for choice in self.choices],
            "family": [choice.family for choice in self.choices],
            "label": [choice.label for choice in self.choices],
            "setting_units": [choice.units for choice in self.choices],
            "against": [choice.against for choice in self.choices],
        }
        return xr.Dataset(
            {**self._errors(), **self._costs(), **self._checks()},
            coords={
                "choice": np.arange(len(self.choices)),
                **{name: (("choice",), np.array(words, dtype=object)) for name, words in coordinates.items()},
                "setting": (("choice",), np.array([choice.setting for choice in self.choices])),
                "vowel": self.vowels,
                "node": list(MIDSAGITTAL_NODES),
                "muscle": list(self.scene.speaker.muscles),
                "formant": [1, 2, 3, 4],
                "reference": list(CHECKED),
            },
            attrs=provenance(self.scene, "accuracy") | machine() | self._settings(),
        )

    def _array(self, value: _Value, *sizes: int) -> Any:
        """(choices, vowels, sizes) of numbers, NaN where there is no row or no distance."""
        array = np.full((len(self.choices), len(self.vowels), *sizes), math.nan)
        for (number, vowel), (outcome, away) in self.rows.items():
            found = value(outcome, away)
            if found is not None:
                array[number, self.vowels.index(vowel)] = found
        return array

    def _errors(self) -> dict[str, Any]:
        muscles = len(self.scene.speaker.muscles)
        parts: Mapping[str, tuple[str, tuple[str, ...], tuple[int, ...], str]] = {
            "node_error": ("nodes", ("node",), (len(MIDSAGITTAL_NODES),), "m"),
            "largest_error": ("largest", (), (), "m"),
            "force_error": ("forces", ("muscle",), (muscles,), "N"),
            "formant_error": ("formants", ("formant",), (4,), "Hz"),
        }
        return {
            name: (
                ("choice", "vowel", *dims),
                self._array(_part(part), *sizes),
                {"units": units},
            )
            for name, (part, dims, sizes, units) in parts.items()
        }

    def _costs(self) -> dict[str, Any]:
        dims = ("choice", "vowel")
        asked = [[vowel in self.vowels_of(choice) for vowel in self.vowels] for choice in self.choices]
        reasons = np.full((len(self.choices), len(self.vowels)), "", dtype=object)
        for (number, vowel), (outcome, _) in self.rows.items():
            reasons[number, self.vowels.index(vowel)] = outcome.reason
        counts = {name: (dims, self._array(_count(name))) for name in COUNTS}
        return {
            "cpu_seconds": (dims, self._array(lambda outcome, _: outcome.cpu), {"units": "s"}),
            "wall_seconds": (dims, self._array(lambda outcome, _: outcome.wall), {"units": "s"}),
            "stated_error": (dims, self._array(lambda outcome, _: outcome.stated), {"units": "m"}),
            **counts,
            "asked": (dims, np.array(asked)),
            "reason": (dims, reasons),
        }

    def _checks(self) -> dict[str, Any]:
        def array(value: Callable[[Distance], float]) -> Any:
            found = np.full((len(CHECKED), len(self.vowels)), math.nan)
            for (against, vowel), away in self.checks.items():
                found[CHECKED.index(against), self.vowels.index(vowel)] = value(away)
            return found

        dims = ("reference", "vowel")
        return {
            "reference_nodes": (dims, array(lambda away: float(away.nodes.max())), {"units": "m"}),
            "reference_largest": (dims, array(lambda away: away.largest), {"units": "m"}),
            "reference_force": (dims, array(lambda away: float(away.forces.max())), {"units": "N"}),
            "reference_formant": (dims, array(lambda away: float(np.fmax.reduce(away.formants))), {"units": "Hz"}),
        }

    def _settings(self) -> dict[str, Any]:
        return {
            "until_s": float(self.settings.until),
            "reference_step_s": 0.5 * float(self.settings.reference_step),
            "resolutions": ", ".join(map(str, self.resolutions)),
            "repetitions": self.settings.repetitions,
            "settings": self.settings.name,
            "threads": self.scene.threads,
        }


def _part(name: str) -> _Value:
    return lambda _, away: None if away is None else getattr(away, name)


def _count(name: str) -> _Value:
    return lambda outcome, _: None if outcome.reason else outcome.counts[name]
