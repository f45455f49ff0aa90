"""Solves must not come to take more work: counts against the table of tests/guard_counts.csv, never seconds.

After a change that is meant, renew the table with ``python -m tests.guard_counts``.
"""

from __future__ import annotations

import math

import pytest
from tests.guard_counts import COUNTS, Counts, measured, stored

SLACK = 1.3
"""Share of the stored counts that is allowed: other processors round differently and may take an iteration more."""


@pytest.fixture(scope="module")
def now() -> Counts:
    return measured()


def test_every_case_is_in_the_table(now: Counts) -> None:
    assert list(now) == list(stored()), "renew the table: python -m tests.guard_counts"


@pytest.mark.parametrize("case", stored())
def test_no_more_work(now: Counts, case: str) -> None:
    allowed = {name: math.ceil(SLACK * stored()[case][name]) for name in COUNTS}
    more = [f"{name} {now[case][name]} > {allowed[name]}" for name in COUNTS if now[case][name] > allowed[name]]
    assert not more, f"{case}: {'; '.join(more)}"


def test_a_whole_tongue_takes_no_more_iterations_than_its_half(now: Counts) -> None:
    half, whole = now["/ə/ from rest"], now["/ə/ from rest, whole tongue"]
    assert whole["iterations"] <= math.ceil(SLACK * half["iterations"])


def test_starting_from_a_neighbour_saves_work(now: Counts) -> None:
    """Over all neighbours of the table together."""
    names = [case for case in now if " times " in case]
    rest = [f"{case.split(' with ')[0]} from rest" for case in names]
    assert len(names) > 3
    assert sum(now[case]["factorisations"] for case in names) < sum(now[case]["factorisations"] for case in rest)
