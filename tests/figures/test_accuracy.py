"""The figure of an accuracy study: every choice at its place, those that pay on the front."""

from __future__ import annotations

import numpy as np
import pytest
import xarray as xr

from glossa.errors import InputError
from glossa.figures import accuracy
from glossa.studies.accuracy import committed_study, pareto, worst

SCALES = {"nodes": 1e3, "force": 1.0, "formant": 1.0}


@pytest.fixture(scope="module")
def study() -> xr.Dataset:
    return committed_study()


@pytest.mark.parametrize("cost", ["wall_seconds", "cpu_seconds"])
def test_every_choice_is_drawn(study: xr.Dataset, cost: str) -> None:
    figure = accuracy(study, cost)
    table = worst(study)
    assert len(figure.axes) == 6
    for place, axes in enumerate(figure.axes):
        kind, (measure, scale) = ("posture", "movement")[place // 3], list(SCALES.items())[place % 3]
        lines = {line.get_gid(): line for line in axes.lines}
        for family in set(table["family"].to_numpy()[(table["kind"] == kind).to_numpy()]):
            own = ((table["family"] == family) & (table["kind"] == kind) & (table[measure] > 0.0)).to_numpy()
            seconds, errors = np.asarray(lines[f"family:{family}"].get_data())
            assert seconds == pytest.approx(table[cost].to_numpy()[own])
            assert errors == pytest.approx(table[measure].to_numpy()[own] * scale)
        assert axes.get_xscale() == axes.get_yscale() == "log"
        assert "(s)" in axes.get_xlabel()
        assert ("(mm)", "(N)", "(Hz)")[place % 3] in axes.get_ylabel()


def test_front_is_what_pays(study: xr.Dataset) -> None:
    table, figure = worst(study), accuracy(study)
    for place, measure in enumerate(SCALES):
        marked = pareto(study, measure).to_numpy() & (table["against"] == "steps").to_numpy()
        (line,) = [line for line in figure.axes[3 + place].lines if line.get_gid() == "front:steps"]
        seconds, errors = np.asarray(line.get_data())
        assert sorted(seconds) == pytest.approx(sorted(table["wall_seconds"].to_numpy()[marked]))
        assert (np.diff(seconds) >= 0.0).all()
        assert (np.diff(errors) <= 0.0).all()


def test_one_kind_and_failures(study: xr.Dataset) -> None:
    some = study.isel(choice=(study["kind"] == "movement").to_numpy()).copy(deep=True)
    some["node_error"][0] = some["largest_error"][0] = np.nan
    figure = accuracy(some)
    assert len(figure.axes) == 3
    first = {line.get_gid(): line for line in figure.axes[0].lines}[f"family:{some['family'].values[0]}"]
    assert len(np.asarray(first.get_xdata())) == int((some["family"] == some["family"][0]).sum()) - 1


def test_refuses_other_studies(study: xr.Dataset) -> None:
    with pytest.raises(InputError, match="accuracy_study"):
        accuracy(study.assign_attrs(study="delay"))
    with pytest.raises(InputError, match="cost must be"):
        accuracy(study, "iterations")
