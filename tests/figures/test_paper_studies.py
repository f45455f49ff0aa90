"""Figures of the paper's studies: what is drawn is what the studies say."""

from __future__ import annotations

import numpy as np
import pytest
import xarray as xr
from matplotlib.figure import Figure
from tests.blocks import block
from tests.studies.paper_runs import quick_scene, some_runs

from glossa import InputError, Scene, Speaker, Wall, paper
from glossa.anatomy.plane_cut import plane_cut
from glossa.figures import (
    delay_traces,
    dispersion,
    formant_changes,
    formant_dispersion,
    gravity_forces,
    gravity_shapes,
    saturation,
    transversalis,
)
from glossa.figures.midsagittal import outline_mm
from glossa.studies import compared_changes, delay, dispersion_ellipse, gravity, midsagittal_nodes
from glossa.studies import transversalis as run_transversalis
from glossa.studies.sensitivity_summary import scatter


@pytest.fixture(scope="module")
def quick(reference: Speaker) -> Scene:
    return quick_scene(reference)


@pytest.fixture(scope="module")
def runs(quick: Scene) -> xr.Dataset:
    return some_runs(quick)


@pytest.fixture(scope="module")
def weights(quick: Scene) -> xr.Dataset:
    return gravity(quick, ["a"], until=0.02, vowel_until=0.02)


@pytest.fixture(scope="module")
def delays(quick: Scene) -> xr.Dataset:
    return delay(quick, "i", [0.005, 0.017], until=0.02)


@pytest.fixture(scope="module")
def of_trans(quick: Scene) -> xr.Dataset:
    return run_transversalis(quick)


def with_gid(figure: Figure, gid: str, panel: int = 0) -> list[object]:
    axes = figure.axes[panel]
    return [artist for artist in [*axes.lines, *axes.collections] if artist.get_gid() == gid]


def test_scatter_and_ellipses_of_the_six_nodes(runs: xr.Dataset, reference: Speaker) -> None:
    figure = dispersion(runs, reference)
    assert len(figure.axes) == 4
    for node in runs["node"].values.tolist():
        points = scatter(runs, "all", node)
        (dots,) = with_gid(figure, f"scatter:{node}")
        assert np.asarray(dots.get_offsets()) == pytest.approx(points)  # type: ignore[attr-defined]
        (line,) = with_gid(figure, f"ellipse:{node}")
        assert np.column_stack(line.get_data()) == pytest.approx(dispersion_ellipse(points).outline())  # type: ignore[attr-defined]
    assert not with_gid(figure, "ellipse:palatal", 1)
    assert figure.axes[2].get_title() == "/i/, GGa only"
    assert "(mm)" in figure.axes[0].get_ylabel()


def test_formants_against_the_command_beside_table_6(runs: xr.Dataset) -> None:
    figure = saturation(runs)
    ours, theirs = figure.axes[0].lines[:2]
    assert np.asarray(ours.get_xdata()).tolist() == [-10.0, -5.0, 0.0, 5.0]
    f1 = runs["formants"].sel(muscle="GGa", formant=1)
    expected = [*f1.sel(change=[-10.0, -5.0]).values, runs["vowel_formants"][0], f1.sel(change=5.0)]
    assert np.asarray(ours.get_ydata()) == pytest.approx(np.array(expected, dtype=float))
    table = dict(zip(*np.asarray(theirs.get_data()).tolist(), strict=True))
    assert table[0.0] == 321.0
    assert table[-10.0] == paper.sensitivity_i().loc[("GGa", -10), "F1_Hz"]
    with pytest.raises(InputError, match="no muscle 'HG'"):
        saturation(runs, "HG")


def test_changes_of_formants_beside_table_6(runs: xr.Dataset) -> None:
    table = compared_changes(runs)
    for number, axes in enumerate(formant_changes(runs).axes, start=1):
        drawn = {str(line.get_label()): line for line in axes.lines}
        for muscle in ("GGa", "SL"):
            rows = table.xs(muscle, level="muscle")
            assert drawn[muscle].get_xdata() == pytest.approx(rows[f"paper_F{number}"].to_numpy())
            assert drawn[muscle].get_ydata() == pytest.approx(rows[f"F{number}"].to_numpy())
    with pytest.raises(InputError, match="Table VI has no runs"):
        formant_changes(runs.assign_attrs(vowel="u"))


def test_scatter_of_formants(runs: xr.Dataset) -> None:
    figure = formant_dispersion(runs)
    assert [axes.get_title() for axes in figure.axes[:2]] == ["glossa", "paper"]
    for panel, number in ((0, 1), (2, 3)):
        (ours,) = with_gid(figure, "runs:GGa", panel)
        found = runs["formants"].sel(muscle="GGa").to_numpy()
        expected = np.stack([found[:, 1], found[:, number - 1]])
        assert np.array_equal(np.asarray(ours.get_data()), expected, equal_nan=True)  # type: ignore[attr-defined]
    (theirs,) = with_gid(figure, "runs:Sty", 1)
    assert np.asarray(theirs.get_ydata()) == pytest.approx(paper.sensitivity_i().loc["Sty"]["F1_Hz"].to_numpy())  # type: ignore[attr-defined]
    assert len(formant_dispersion(runs.assign_attrs(vowel="u")).axes) == 2


def test_shapes_upright_and_supine(weights: xr.Dataset, reference: Speaker) -> None:
    for moment in ("final", "static"):
        figure = gravity_shapes(weights, reference, moment=moment)
        assert [axes.get_title() for axes in figure.axes] == ["gravity alone", "gravity and reflex"]
        for panel, control in enumerate(("silent", "reflex")):
            (line,) = with_gid(figure, "tongue:supine", panel)
            moved = weights[moment].sel(control=control, gravity="supine").values
            curve = outline_mm(reference, reference.nodes + moved)
            assert np.column_stack(line.get_data())[:-1] == pytest.approx(curve)  # type: ignore[attr-defined]
    with pytest.raises(InputError, match="moment"):
        gravity_shapes(weights, reference, moment="later")


def test_forces_upright_and_supine(weights: xr.Dataset) -> None:
    figure = gravity_forces(weights, "HG")
    heights = [bar.get_height() for bar in figure.axes[0].patches]  # type: ignore[attr-defined]
    assert heights == pytest.approx(weights["peak_force"].sel(vowel="a", acting="HG").values)
    change = float(weights["peak_change"].sel(vowel="a", acting="HG"))
    assert figure.axes[0].texts[0].get_text() == f"{change:+.1f} %"
    with pytest.raises(InputError, match="no muscle 'XX'"):
        gravity_forces(weights, "XX")


def test_a_line_for_each_delay(delays: xr.Dataset) -> None:
    figure = delay_traces(delays, "palatal", "Sty")
    assert [line.get_label() for line in figure.axes[0].lines] == ["5 ms", "17 ms"]
    upward = delays["trace"].sel(delay=0.005, node="palatal", axis="z").values * 1e3
    assert figure.axes[1].lines[0].get_ydata() == pytest.approx(upward)
    assert figure.axes[2].lines[1].get_ydata() == pytest.approx(delays["force"].sel(delay=0.017, muscle="Sty").values)
    for node, muscle in (("tip", "Sty"), ("palatal", "XX")):
        with pytest.raises(InputError, match="this study has no"):
            delay_traces(delays, node, muscle)


def test_frontal_sections_are_those_of_each_condition(of_trans: xr.Dataset, reference: Speaker) -> None:
    figure = transversalis(of_trans, reference)
    at = float(reference.nodes[midsagittal_nodes(reference)["palatal"], 0])
    weights, triangles = reference.smooth_surface.triangulation()
    for label, condition in (("transversalis silent", "silent"), ("voluntary", "voluntary")):
        surface = Wall(np.asarray(weights @ of_trans["positions"].sel(condition=condition).values), triangles)
        cuts = plane_cut(surface, 0, at)
        lines = with_gid(figure, f"section:{label}", 1)
        assert len(lines) == len(cuts) > 0
        for line, cut in zip(lines, cuts, strict=True):
            assert np.column_stack(line.get_data()) == pytest.approx(cut * 1e3)  # type: ignore[attr-defined]
    assert figure.axes[1].get_title() == f"frontal section at x = {at * 1e3:.0f} mm"


def test_another_study_or_speaker_is_refused(
    runs: xr.Dataset, weights: xr.Dataset, delays: xr.Dataset, of_trans: xr.Dataset, reference: Speaker
) -> None:
    needs, other = "needs the result of", "another speaker"
    with pytest.raises(InputError, match=needs):
        dispersion(weights, reference)
    for draw in (saturation, formant_changes, formant_dispersion):
        with pytest.raises(InputError, match=needs):
            draw(weights)
    with pytest.raises(InputError, match=needs):
        gravity_shapes(runs, reference)
    with pytest.raises(InputError, match=needs):
        gravity_forces(runs)
    with pytest.raises(InputError, match=needs):
        delay_traces(runs)
    with pytest.raises(InputError, match=needs):
        transversalis(delays, reference)
    with pytest.raises(InputError, match=other):
        dispersion(runs, block())
    with pytest.raises(InputError, match=other):
        gravity_shapes(weights, block())
    with pytest.raises(InputError, match=other):
        transversalis(of_trans, block())


def test_a_study_without_shapes_is_refused(of_trans: xr.Dataset, reference: Speaker) -> None:
    empty = of_trans.copy(deep=True)
    empty["positions"][:] = np.nan
    with pytest.raises(InputError, match="nothing to draw"):
        transversalis(empty, reference)
