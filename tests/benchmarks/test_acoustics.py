"""What formants and sounds cost: `make bench` prints it. CPU time of one thread of numpy, the median of a few runs."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import pytest
from tests.acoustics.tracts import rough
from tests.benchmarks.timing import cpu_seconds

from glossa import TUBE_CONSTANTS, AreaFunction, synthesize
from glossa.acoustics import formants

pytestmark = pytest.mark.slow
SECTIONS = 45


@pytest.mark.parametrize("name", TUBE_CONSTANTS)
@pytest.mark.parametrize("method", ["poles", "peaks"])
def test_thousand_tracts(name: str, method: str) -> None:
    """1,000 random tracts of 45 sections, four formants each."""
    lengths, areas = rough(0, 1000, SECTIONS, 0.35)
    table = formants(areas, 4, lengths=lengths, constants=name, method=method)
    seconds = cpu_seconds(lambda: formants(areas, 4, lengths=lengths, constants=name, method=method), 3)
    found = np.isfinite(table.frequencies).all(axis=1)
    print(f"\n1,000 tracts x 4 formants, {method}, {name}: {seconds:.2f} s, {found.sum()} with all four")
    assert (found | (np.array(table.reasons) != "")).all()


@pytest.mark.parametrize("step", [0.8, 1.2])
def test_thousand_harsh_tracts(step: float) -> None:
    """Areas of 0.001 to 100 cm² that jump from section to section: minima miss poles, F1 is often damped away."""
    lengths, areas = rough(1, 1000, SECTIONS, step, 1e-7, 1e-2)
    table = formants(areas, 4, lengths=lengths)
    seconds = cpu_seconds(lambda: formants(areas, 4, lengths=lengths), 1)
    lost = sum(map(bool, table.reasons))
    print(f"\n1,000 tracts that jump by e^{step:g}: {seconds:.2f} s, {lost} whose lowest resonance is damped away")
    assert np.isfinite(table.frequencies[[not reason for reason in table.reasons]]).all()


def test_single_results() -> None:
    lengths, areas = rough(2, 2, SECTIONS)
    one, two = (AreaFunction(*pair) for pair in zip(lengths, areas, strict=True))
    jobs: dict[str, Callable[[], object]] = {
        "four formants of one tract": one.formants,
        "four peaks of one tract": lambda: one.formants(method="peaks"),
        "sensitivity of four formants to 45 areas": one.sensitivity,
        "transfer function, 1,000 frequencies": lambda: one.transfer_function(np.arange(5.0, 5005.0, 5.0)),
        "vowel of 0.5 s": lambda: synthesize(one),
        "movement of 0.5 s": lambda: synthesize([one, two], times=[0.1, 0.4]),
    }
    print()
    for what, job in jobs.items():
        print(f"{what:45}{cpu_seconds(job, 3) * 1e3:9.1f} ms")
