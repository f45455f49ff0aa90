"""Calibration of the built-in speaker: shape parameters such that Table III's commands give Tables IV and II.

What may change are the shape parameters of data/landmarks/reference_shape.toml that have a ``step``, within their
``limits``; commands, force capacities (Table I), tissue and reflex stay as the paper has them, and nothing is fitted
vowel by vowel. Compared are the sixteen formants of Table IV and the forces above 1 N of Table II, and nothing else:
Table VI and the single muscles of section III.A.1 remain for checking.

The method is Gauss-Newton: derivatives by differences of one ``step``, then a least-squares problem with bounds and a
trust region on the linear model, and a new start from the better point. Few and small changes are preferred by a
penalty close to their absolute values, relative to the limits.

The command ``glossa calibrate`` does it.
"""

from __future__ import annotations

import logging
import math
from collections.abc import Callable, Iterable, Mapping
from concurrent.futures import Executor, ProcessPoolExecutor
from dataclasses import dataclass
from functools import cache

import numpy as np
import xarray as xr
from scipy.optimize import least_squares

from glossa import paper
from glossa.acoustics import formants
from glossa.anatomy.arrays import FloatArray
from glossa.anatomy.quality import quality_of
from glossa.anatomy.reference import reference_speaker
from glossa.anatomy.shape import ShapeParameter, shape_parameters
from glossa.anatomy.speaker_landmarks import load_landmarks
from glossa.errors import InputError, SolveError
from glossa.results import Posture
from glossa.scene import Scene
from glossa.studies.vowels import vowels
from glossa.tract import area_function
from glossa.tract.tract import BARRIER, PLANES

log = logging.getLogger(__name__)

VOWEL_NAMES = ("i", "ə", "u", "a")
FORMANTS = 4
LARGE_FORCE = 1.0
"""Forces of Table II above this take part, N."""

VARIANTS = ((PLANES, BARRIER, 0.4), (41, BARRIER, 0.2), (50, BARRIER, 0.2), (PLANES, 2.0 * BARRIER, 0.2))
"""Cutting planes, smallest gap in m, and weight: formants are averaged over them, lest a plane that falls into the
vallecula or a slit beside the molars steer the result."""

FORMANT_SCALE, FORMANT_EDGE, FORMANT_STEEPNESS = 0.05, 0.075, 0.012
"""Of log ratios: the deviation that counts one, the one from which it counts extra, and that extra's unit."""

FORCE_SCALE, FORCE_LOW, FORCE_HIGH, FORCE_STEEPNESS = 2.0, -0.26, 0.19, 0.03
"""Likewise for forces: within LOW..HIGH a force is nearly free."""

LEAST_JACOBIAN, MOST_OVERLAP, VOLUME_RANGE = 0.312, 0.4e-3, (93e-6, 102e-6)
"""Of the scaled Jacobians; of tongue and walls at rest, m; of the tongue, m3."""

PRIOR, PRIOR_SOFTNESS = 0.9, 0.08
"""Weight of the penalty on changes, and the share of a limit under which it is quadratic."""


FIRST_REACH, LEAST_REACH, SHARES = 4.0, 0.2, (1.0, 0.5, 0.25, 0.125)
"""Trust region: the first, in steps, the one at which the search ends, and the shares of it that are tried."""


@dataclass(frozen=True, eq=False)
class Outcome:
    """What one set of values gives.

    Attributes:
        values: total value of every calibrated parameter.
        formants: (variant, vowel, formant) Hz.
        forces: (vowel, muscle) N, muscles as in Table II.
        jacobian: smallest scaled Jacobian.
        volume: of the tongue, m3.
        overlap: of tongue and walls at rest, m.
    """

    values: Mapping[str, float]
    formants: FloatArray
    forces: FloatArray
    jacobian: float
    volume: float
    overlap: float

    @property
    def formant_ratios(self) -> FloatArray:
        """(vowel, formant): at the default slicing, over Table IV."""
        return np.asarray(self.formants[0] / _formant_targets())

    @property
    def force_ratios(self) -> FloatArray:
        """(k,) over Table II, in the order of :func:`large_forces`."""
        large = _paper_forces() > LARGE_FORCE
        return np.asarray(self.forces[large] / _paper_forces()[large])

    def table(self) -> xr.Dataset:
        """``formant_ratio (vowel, formant)`` and ``force_ratio (force,)`` over Tables IV and II, with coordinates."""
        return xr.Dataset(
            {
                "formant_ratio": (("vowel", "formant"), self.formant_ratios),
                "formant_Hz": (("vowel", "formant"), self.formants[0]),
                "force_ratio": (("force",), self.force_ratios),
            },
            coords={
                "vowel": list(VOWEL_NAMES),
                "formant": np.arange(1, FORMANTS + 1),
                "force": [f"{muscle} of {vowel}" for vowel, muscle in large_forces()],
            },
        )


def calibrated_parameters() -> dict[str, ShapeParameter]:
    """The shape parameters that take part: those with a step."""
    return {name: parameter for name, parameter in shape_parameters().items() if parameter.step is not None}


@cache
def large_forces() -> tuple[tuple[str, str], ...]:
    """(vowel, muscle) of the forces of Table II above 1 N."""
    muscles, forces = list(paper.forces().columns), _paper_forces()
    return tuple((VOWEL_NAMES[v], muscles[m]) for v, m in np.argwhere(forces > LARGE_FORCE))


@cache
def _paper_forces() -> FloatArray:
    """(vowel, muscle) of Table II, N."""
    return paper.forces().loc[list(VOWEL_NAMES)].to_numpy(dtype=float)


@cache
def _formant_targets() -> FloatArray:
    columns = [f"F{n}_Hz" for n in range(1, FORMANTS + 1)]
    return paper.formants_simulated().loc[list(VOWEL_NAMES), columns].to_numpy(dtype=float)


def outcome(values: Mapping[str, float]) -> Outcome:
    """Vowels, formants and forces of the built-in speaker with these total values; what is not named stays as it is.

    Raises:
        InputError: an unknown parameter, a value outside of its limits, or a speaker that is not sound.
        SolveError: a vowel without equilibrium.
    """
    parameters = shape_parameters()
    unknown = [name for name in values if name not in parameters]
    if unknown:
        raise InputError(f"no shape parameter {unknown[0]!r}; known are {', '.join(parameters)}")
    shape = {name: value - parameters[name].value for name, value in values.items()}
    speaker = reference_speaker(1, load_landmarks({"shape": shape}))
    quality = quality_of(speaker)
    postures = vowels(Scene(speaker, mirror=True), VOWEL_NAMES)
    return Outcome(
        dict(values),
        _formants(postures),
        np.array([[postures[v].forces[m] for m in paper.forces().columns] for v in VOWEL_NAMES]),
        quality.jacobian_min,
        quality.volume,
        max(0.0, -min(quality.clearance.values())),
    )


def _formants(postures: Mapping[str, Posture]) -> FloatArray:
    for name, posture in postures.items():
        if posture.report is not None and not posture.report.converged:
            raise SolveError(f"vowel {name} has no equilibrium: {posture.report.status}", posture=posture)
    tracts = [
        area_function(postures[v], v, planes=planes, barrier=barrier)
        for planes, barrier, _ in VARIANTS
        for v in VOWEL_NAMES
    ]
    found = formants(tracts, FORMANTS).frequencies
    if not np.isfinite(found).all():
        raise InputError("a vowel has fewer than four formants")
    return found.reshape(len(VARIANTS), len(VOWEL_NAMES), FORMANTS)


def calibrate(
    start: Mapping[str, float] | None = None,
    iterations: int = 12,
    *,
    names: Iterable[str] | None = None,
    executor: Executor | None = None,
    progress: Callable[[int, float, Outcome], None] | None = None,
) -> list[Outcome]:
    """Adjust the calibrated parameters; returns the starting point and every improvement, the best last.

    Args:
        start: values to begin with; None: all zero, the tables as they stand.
        iterations: at most; it ends earlier when a step gains less than 2 %.
        names: parameters that may change, the others stay at ``start``; None: all that are calibrated.
        executor: runs the differences; None: a process for every processor.
        progress: called with iteration, cost and outcome after every improvement.

    Raises:
        InputError: an unknown parameter, or a start that cannot be computed.
    """
    parameters = calibrated_parameters()
    values = dict.fromkeys(parameters, 0.0) | dict(start or {})
    free = list(parameters) if names is None else list(names)
    unknown = [name for name in [*values, *free] if name not in parameters]
    if unknown:
        raise InputError(f"{unknown[0]!r} is not calibrated; those that are: {', '.join(parameters)}")
    parameters = {name: parameters[name] for name in free}
    if executor is not None:
        return _calibrate(parameters, values, iterations, executor, progress)
    with ProcessPoolExecutor() as processes:
        return _calibrate(parameters, values, iterations, processes, progress)


def _calibrate(
    parameters: Mapping[str, ShapeParameter],
    start: Mapping[str, float],
    iterations: int,
    executor: Executor,
    progress: Callable[[int, float, Outcome], None] | None,
) -> list[Outcome]:
    names = list(parameters)
    fixed = {name: value for name, value in start.items() if name not in parameters}
    low, high = np.array([parameters[name].limits for name in names]).T
    steps = np.array([parameters[name].step for name in names], dtype=float)
    scale = np.where(high >= -low, high, -low)
    x = np.array([start[name] for name in names])

    def named(point: FloatArray) -> dict[str, float]:
        return fixed | dict(zip(names, point.tolist(), strict=True))

    def run(points: Iterable[FloatArray]) -> list[Outcome | None]:
        return list(executor.map(_attempt, [named(point) for point in points]))

    def cost(point: FloatArray, found: Outcome | None) -> float:
        if found is None:
            return math.inf
        return float((_terms(_numbers(found)) ** 2).sum() + 2.0 * PRIOR**2 * np.abs(point / scale).sum())

    best = outcome(named(x))
    least, history, trust = cost(x, best), [best], FIRST_REACH
    for iteration in range(1, iterations + 1):
        signs = np.where(x + steps <= high, 1.0, -1.0)
        base = _numbers(best)
        changed = run(x + step for step in np.diag(signs * steps))
        slopes = np.array(
            [
                np.zeros_like(base) if found is None else (_numbers(found) - base) / step
                for found, step in zip(changed, signs * steps, strict=True)
            ]
        )
        before = least
        while trust > LEAST_REACH:
            tried = [_step(base, slopes, x, low, high, scale, trust * share * steps) for share in SHARES]
            found = run(tried)
            costs = [cost(point, result) for point, result in zip(tried, found, strict=True)]
            k = int(np.argmin(costs))
            result = found[k]
            if result is not None and costs[k] < least:
                x, best, least = tried[k], result, costs[k]
                trust *= 1.5 * SHARES[k]
                break
            trust *= SHARES[-1] / 2.0
        else:
            break
        history.append(best)
        if progress is not None:
            progress(iteration, least, best)
        if before - least < 0.02 * before:
            break
    return history


def _attempt(values: Mapping[str, float]) -> Outcome | None:
    """None where these values give no sound speaker, no equilibrium or no tract."""
    try:
        return outcome(values)
    except (InputError, SolveError) as error:
        log.info("%s: %s", values, error)
        return None


def _numbers(found: Outcome) -> FloatArray:
    """What the linear model is about.

    Log ratios of the averaged and of the default formants, their change with the gap, forces, quality.
    """
    logs = np.log(found.formants / _formant_targets()).reshape(len(VARIANTS), -1)
    weights = np.array([weight for _, _, weight in VARIANTS])
    forces = np.log(np.maximum(found.force_ratios, 1e-3))
    rest = [found.jacobian / 0.004, found.overlap / 0.15e-3, found.volume / 1e-6]
    return np.concatenate([weights @ logs, logs[0], logs[3] - logs[0], forces, rest])


def _terms(numbers: FloatArray) -> FloatArray:
    """Their deviations, each in its scale."""
    count = len(VOWEL_NAMES) * FORMANTS
    averaged, default, slit = numbers[: 3 * count].reshape(3, count)
    forces, (jacobian, overlap, volume) = numbers[3 * count : -3], numbers[-3:]
    return np.concatenate(
        [
            averaged / FORMANT_SCALE,
            np.maximum(0.0, np.abs(averaged) - FORMANT_EDGE) / FORMANT_STEEPNESS,
            0.5 * np.maximum(0.0, np.abs(default) - FORMANT_EDGE) / FORMANT_STEEPNESS,
            0.3 * slit / 0.03,
            forces / FORCE_SCALE,
            np.maximum(0.0, FORCE_LOW - forces) / FORCE_STEEPNESS,
            np.maximum(0.0, forces - FORCE_HIGH) / FORCE_STEEPNESS,
            np.maximum(0.0, [LEAST_JACOBIAN / 0.004 - jacobian, overlap - MOST_OVERLAP / 0.15e-3]),
            np.maximum(0.0, [VOLUME_RANGE[0] / 1e-6 - volume, volume - VOLUME_RANGE[1] / 1e-6]),
        ]
    )


def _step(
    base: FloatArray,
    slopes: FloatArray,
    x: FloatArray,
    low: FloatArray,
    high: FloatArray,
    scale: FloatArray,
    reach: FloatArray,
) -> FloatArray:
    """Best point of the linear model within ``reach`` of x and within the limits."""
    lower, width = np.maximum(low, x - reach), np.minimum(high, x + reach) - np.maximum(low, x - reach)
    prior = PRIOR / np.sqrt(np.abs(x / scale) + PRIOR_SOFTNESS)

    def deviations(share: FloatArray) -> FloatArray:
        point = lower + share * width
        return np.concatenate([_terms(base + (point - x) @ slopes), prior * point / scale])

    begin = np.clip((x - lower) / width, 0.02, 0.98)
    found = least_squares(deviations, begin, bounds=(0.0, 1.0), max_nfev=300).x
    return np.asarray(np.clip(lower + found * width, low, high))


def effects(values: Mapping[str, float], *, executor: Executor | None = None) -> xr.Dataset:
    """What each parameter does: formants and forces with it set back to zero, the others at ``values``.

    Returns:
        Dataset with ``value``, ``mean_deviation``, ``largest_deviation`` (formants, shares) and ``force_deviation``
        (sum of deviations over sum of Table II's large forces) over ``parameter``; the first is "none".
    """
    names = [name for name, value in values.items() if value != 0.0]
    sets = [dict(values), *({**values, name: 0.0} for name in names)]
    if executor is None:
        with ProcessPoolExecutor() as processes:
            found = list(processes.map(_attempt, sets))
    else:
        found = list(executor.map(_attempt, sets))
    rows = [(math.nan,) * 3 if result is None else summary(result) for result in found]
    mean, largest, force = np.array(rows).T
    return xr.Dataset(
        {
            "value": (("parameter",), [0.0, *(values[name] for name in names)]),
            "mean_deviation": (("parameter",), mean),
            "largest_deviation": (("parameter",), largest),
            "force_deviation": (("parameter",), force),
        },
        coords={"parameter": ["none", *names]},
    )


def summary(found: Outcome) -> tuple[float, float, float]:
    """Mean and largest deviation of the formants, and sum of the deviations of the large forces over their sum."""
    deviation = np.abs(found.formant_ratios - 1.0)
    wanted = _paper_forces()[_paper_forces() > LARGE_FORCE]
    force = np.abs(found.force_ratios - 1.0) @ wanted / wanted.sum()
    return float(deviation.mean()), float(deviation.max()), float(force)
