"""Figures of tissue laws and damping."""

from __future__ import annotations

import numpy as np
import pytest

from glossa import InputError
from glossa.figures import damping_ratio, stress_strain
from glossa.studies import damping_ratio as run_damping
from glossa.studies import stress_strain as run_laws


def test_a_line_for_each_law() -> None:
    study = run_laws(strains=[-0.2, 0.0, 0.2])
    (axes,) = stress_strain(study).axes
    lines = {str(line.get_label()).split(":")[0]: line for line in axes.lines if ":" in str(line.get_label())}
    assert list(lines) == study["law"].values.tolist()
    for law, line in lines.items():
        assert line.get_ydata() == pytest.approx(study["nominal_stress"].sel(law=law).values / 1e3)
    assert "passive: E = 6.22 kPa" in {line.get_label() for line in axes.lines}
    assert "(kPa)" in axes.get_ylabel()


def test_damping_against_frequency() -> None:
    study = run_damping(frequencies=[1.0, 3.0, 10.0])
    (axes,) = damping_ratio(study).axes
    drawn = [np.asarray(line.get_ydata()) for line in axes.lines]
    assert any(len(values) == 3 and values == pytest.approx(study["ratio"].values) for values in drawn)
    assert axes.get_title(loc="left") == "α = 40 1/s, β = 0.03 s"


def test_another_study_is_refused() -> None:
    with pytest.raises(InputError, match=r"glossa\.studies\.stress_strain"):
        stress_strain(run_damping())
    with pytest.raises(InputError, match=r"glossa\.studies\.damping_ratio"):
        damping_ratio(run_laws(strains=[0.1]))
