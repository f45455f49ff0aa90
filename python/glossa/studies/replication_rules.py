"""When a number of ours agrees with one of the paper: a rule for each kind of number.

The paper's numbers are read from figures and simulations of one speaker and given with one to four digits. The shares
below are wide enough for another speaker's tongue, and narrow enough that another vowel or muscle fails.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from types import MappingProxyType

from glossa.studies.dispersion import angle_between
from glossa.studies.muscle_effects import LEAST, SHARE
from glossa.studies.sensitivity_summary import LEAST_CHANGE

AGREES, DIFFERS = "agrees", "differs"
"""Verdicts on numbers."""

RIGHT, WRONG = "right", "wrong"
"""Verdicts on statements without a number: a direction, or that something is so."""

FAILED = "failed"
"""Verdict where there is no number of ours: a solve that failed."""

VERDICTS = (AGREES, DIFFERS, RIGHT, WRONG, FAILED)

FORCE_SHARE, FORCE_LEAST = 0.30, 0.1  # of the force; N
FORMANT_SHARE = 0.10
SMALL_CHANGE, NO_CHANGE = 10.0, 0.5  # Hz; what rounds to 0 in Table VI has no sign
SPAN_SHARE = 0.40
AXIS_SHARE = 0.40
ANGLE_LEAST = 20.0  # degrees
PERCENT_LEAST = 3.0  # percentage points
ORDER = math.sqrt(10.0)  # factor


@dataclass(frozen=True)
class Rule:
    """A rule for one kind of number.

    Attributes:
        words: the rule, to print.
        agree: of the paper's number and ours, both finite, in the same unit.
    """

    words: str
    agree: Callable[[float, float], bool]


def _percent(share: float) -> str:
    return f"{100.0 * share:g} %"


def _within(share: float, least: float = 0.0) -> Callable[[float, float], bool]:
    return lambda paper, ours: abs(ours - paper) <= max(share * abs(paper), least)


def _same_sign(paper: float, ours: float) -> bool:
    return paper * ours > 0.0


def _formant_change(paper: float, ours: float) -> bool:
    if abs(paper) < LEAST_CHANGE:
        return abs(ours) <= SMALL_CHANGE
    return _same_sign(paper, ours) and abs(ours) >= NO_CHANGE


RULES: Mapping[str, Rule] = MappingProxyType(
    {
        "force": Rule(
            f"within {_percent(FORCE_SHARE)} or {FORCE_LEAST:g} N, whichever is more", _within(FORCE_SHARE, FORCE_LEAST)
        ),
        "formant": Rule(f"within {_percent(FORMANT_SHARE)}", _within(FORMANT_SHARE)),
        "formant change": Rule(
            f"the paper's sign, and not 0 when rounded, where its change is {LEAST_CHANGE:g} Hz or more; "
            f"elsewhere at most {SMALL_CHANGE:g} Hz",
            _formant_change,
        ),
        "span": Rule(f"within {_percent(SPAN_SHARE)}", _within(SPAN_SHARE)),
        "displacement": Rule(f"within {_percent(SHARE)} or {LEAST:g} mm, whichever is more", _within(SHARE, LEAST)),
        "displacement below": Rule(
            f"at most {LEAST:g} mm above the paper's bound", lambda paper, ours: ours <= paper + LEAST
        ),
        "ellipse axis": Rule(f"within {_percent(AXIS_SHARE)}", _within(AXIS_SHARE)),
        "angle": Rule(
            f"within {ANGLE_LEAST:g} degrees, as lines without sense",
            lambda paper, ours: angle_between(paper, ours) <= ANGLE_LEAST,
        ),
        "force change": Rule(
            f"the paper's sign, and within {PERCENT_LEAST:g} percentage points",
            lambda paper, ours: _same_sign(paper, ours) and abs(ours - paper) <= PERCENT_LEAST,
        ),
        "order": Rule(
            "the same order of magnitude: within a factor of √10",
            lambda paper, ours: paper / ORDER <= ours <= paper * ORDER,
        ),
    }
)
"""By name; rows of :func:`glossa.studies.replicate` name theirs."""

STATEMENT = "statement"
"""What rows without a number in the paper name in place of a rule."""

RULE_WORDS: Mapping[str, str] = MappingProxyType(
    {
        **{name: rule.words for name, rule in RULES.items()},
        STATEMENT: "no number in the paper: right or wrong, by the number of ours that the row shows",
    }
)
"""Every rule, to print."""


def verdict(rule: str, paper: float, ours: float) -> str:
    """``AGREES`` or ``DIFFERS`` by a rule of :data:`RULES`; ``FAILED`` where ours is not finite."""
    if not math.isfinite(ours):
        return FAILED
    return AGREES if RULES[rule].agree(paper, ours) else DIFFERS
