"""The built-in speaker: counts, size, quality, nesting, symmetry, fibres."""

from __future__ import annotations

import dataclasses
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from glossa.anatomy import Speaker
from glossa.anatomy.landmarks import pchip
from glossa.anatomy.mirror import mirror_pairs
from glossa.anatomy.muscle_topology import pass_table
from glossa.anatomy.paper_table import MUSCLE_NAMES, force_capacities
from glossa.anatomy.shape import shape_parameters
from glossa.anatomy.speaker_landmarks import load_landmarks
from glossa.data_files import data_path
from glossa.errors import InputError


@pytest.fixture(scope="module", params=[1, 2, 3])
def at_resolution(request: pytest.FixtureRequest) -> tuple[int, Speaker]:
    return request.param, Speaker.reference(request.param)


def test_counts_size_and_quality(at_resolution: tuple[int, Speaker]) -> None:
    r, speaker = at_resolution
    assert len(speaker.hexahedra) == 768 * r**3
    assert len(speaker.nodes) == (16 * r + 1) * (6 * r + 1) * (8 * r + 1) + 2
    assert speaker.scaled_jacobians.min() > 0.3
    assert 90e-6 < speaker.volume < 105e-6
    assert len(speaker.node_sets["jaw"]) >= 133
    assert len(speaker.outside_points) == 2


AS_WRITTEN = {"shape": {name: -parameter.value for name, parameter in shape_parameters().items()}}


@pytest.fixture(scope="module")
def recipe() -> Speaker:
    """The tables as they stand, all shape parameters at zero."""
    return Speaker.reference(1, AS_WRITTEN)


def test_volume_of_the_recipe(recipe: Speaker) -> None:
    assert recipe.volume * 1e6 == pytest.approx(97.3, abs=0.05)
    assert recipe.scaled_jacobians.min() == pytest.approx(0.312, abs=0.001)
    assert len(recipe.node_sets["jaw"]) == 133
    assert len(recipe.node_sets["hyoid"]) == 27


def test_nested_bit_for_bit(at_resolution: tuple[int, Speaker], reference: Speaker) -> None:
    r, speaker = at_resolution
    fine = speaker.nodes[:-2].reshape(16 * r + 1, 6 * r + 1, 8 * r + 1, 3)
    coarse = reference.nodes[:-2].reshape(17, 7, 9, 3)
    assert np.array_equal(fine[::r, ::r, ::r], coarse)
    assert np.array_equal(speaker.nodes[-2:], reference.nodes[-2:])
    for name in ("tip", "upper_tip", "lower_tip", "blade", "dorsum", "rear", "vallecula", "frenulum"):
        assert np.array_equal(speaker.nodes[speaker.node_sets[name]], reference.nodes[reference.node_sets[name]])


def test_mirror_symmetric_exactly(at_resolution: tuple[int, Speaker]) -> None:
    _, speaker = at_resolution
    partner = mirror_pairs(speaker.nodes, tolerance=0.0)
    for nodes in speaker.node_sets.values():
        assert set(partner[nodes].tolist()) == set(nodes.tolist())
    for muscle in speaker.muscles.values():
        paths = {tuple(fibre.tolist()) for fibre in muscle.fibres}
        assert len(paths) == len(muscle.fibres)
        assert {tuple(partner[fibre].tolist()) for fibre in muscle.fibres} == paths


def test_contours_run_front_to_back(at_resolution: tuple[int, Speaker]) -> None:
    _, speaker = at_resolution
    dorsum = speaker.nodes[speaker.contours["dorsum"]]
    assert (dorsum[:, 1] == 0).all()
    assert dorsum[0, 0] < 0.06 < 0.1 < dorsum[-1, 0]
    surface = set(speaker.surface_quads.ravel().tolist())
    for contour in speaker.contours.values():
        assert set(contour.tolist()) <= surface


#: muscle: fibres, elements, volume in cm3, mean length in mm, at resolution 1 (recipe of the generated speaker)
TABLE = {
    "GGa": (15, 40, 5.0, 34), "GGm": (12, 30, 6.6, 44), "GGp": (18, 50, 10.5, 46), "Sty": (16, 32, 4.4, 90),
    "HG": (18, 68, 12.4, 48), "Vert": (66, 116, 16.6, 16), "Trans": (130, 288, 43.7, 12.6), "IL": (8, 40, 4.9, 88),
    "SL": (14, 78, 16.6, 92), "GH": (6, 10, 2.2, 31.7), "MH": (16, 86, 9.7, 23),
}  # fmt: skip


@pytest.mark.parametrize("name", MUSCLE_NAMES)
def test_muscles_of_the_recipe(recipe: Speaker, name: str) -> None:
    fibres, elements, volume, length = TABLE[name]
    muscle = recipe.muscles[name]
    assert (len(muscle.fibres), len(muscle.elements)) == (fibres, elements)
    assert recipe.element_volumes[muscle.elements].sum() * 1e6 == pytest.approx(volume, abs=0.06)
    assert recipe.fibre_rest_lengths(name).mean() * 1e3 == pytest.approx(length, abs=0.6)
    assert muscle.fibres_per_element == 4
    assert muscle.force_capacity == force_capacities()[name]


def test_fibres_keep_their_course_and_multiply(at_resolution: tuple[int, Speaker], reference: Speaker) -> None:
    r, speaker = at_resolution
    for name in MUSCLE_NAMES:
        mean = speaker.fibre_rest_lengths(name).mean()
        assert mean == pytest.approx(reference.fibre_rest_lengths(name).mean(), rel=0.03)
        growth = len(speaker.muscles[name].fibres) / len(reference.muscles[name].fibres)
        assert r <= growth + 1e-12
        assert growth <= r**3


def test_interior_cells_hold_four_fibres(at_resolution: tuple[int, Speaker]) -> None:
    _, speaker = at_resolution
    for name in ("GGa", "GGm", "GGp", "Vert", "Trans", "SL"):
        table = pass_table(speaker.hexahedra, speaker.muscles[name])
        assert set(np.bincount(table.elements)[speaker.muscles[name].elements].tolist()) == {4}


@pytest.mark.parametrize(
    ("index", "place"),
    [
        ((0, 0, 0), (59.3, 0, 93.8)), ((5, 3, 2), (84.09, 8.681, 95.733)), ((8, 4, 4), (102.027, 20.979, 97.272)),
        ((12, 6, 3), (126.505, 23.79, 80.827)), ((14, 2, 3), (91.409, 10.333, 65.238)),
        ((16, 4, 4), (104.37, 25.519, 66.305)), ((16, 6, 4), (122, 22, 60.5)),
        ((4.5, 2.5, 1.5), (81.505, 5.766, 92.594)), ((14.5, 0.5, 3.5), (80.086, 5.933, 59.139)),
    ],
)  # fmt: skip
def test_check_points_of_the_map(index: tuple[float, ...], place: tuple[float, ...]) -> None:
    """The recipe's check points hold for its first table; the three rows that were tuned later are put back."""
    table = load_landmarks(AS_WRITTEN).tongue
    half_width, shift_z = table.half_width.copy(), table.shift_z.copy()
    half_width[3, 5:11] = [15.5, 16.5, 17.5, 18.5, 20.5, 23.5]
    shift_z[3, 3:10] = [-2, -2.3, -2.5, -2.5, -2.5, -2.5, -2]
    columns = np.array([0, 0.28, 0.54, 0.78, 1])
    first = dataclasses.replace(table, columns=columns, half_width=half_width, shift_z=shift_z)
    point = first.positions(*(np.array([value], dtype=float) for value in index))[0, 0, 0]
    assert point * 1e3 == pytest.approx(place, abs=0.0006)


def test_pchip_agrees_with_scipy() -> None:
    interpolate = pytest.importorskip("scipy.interpolate")
    knots = np.array([0.0, 1.0, 2.5, 3.0, 4.0, 6.0])
    values = np.array([[0.0, 1.0, 0.5, 0.5, 2.0, 9.0], [3.0, 2.0, 4.0, 1.0, 1.5, -1.0]])
    at = np.linspace(0.0, 6.0, 101)
    expected = interpolate.PchipInterpolator(knots, values, axis=-1)(at)
    assert np.allclose(pchip(knots, values, at), expected, rtol=0, atol=1e-13)
    assert np.array_equal(pchip(knots, values, knots), values)


@pytest.mark.parametrize(("resolution", "message"), [(0, "at least 1"), (-1, "at least 1"), (1.5, "whole number")])
def test_bad_resolution(resolution: Any, message: str) -> None:
    with pytest.raises(InputError, match=message):
        Speaker.reference(resolution)


@pytest.mark.parametrize(
    ("old", "new", "message"),
    [
        ('length_unit = "mm"', 'length_unit = "cm"', "length_unit must be 'mm'"),
        ("[rays]", "[other]", "unknown entry 'other'"),
        ("inner_angle = [112, ", "inner_angle = [", r"inner_angle has shape \(16,\), expected \(17,\)"),
        ("[lateral]", "[lateral", "table.toml"),
        ("columns = [0,", 'columns = ["none",', "columns: expected an array of numbers"),
        ("linear_mix = { start = 10,", "linear_mix = {", "missing or malformed entry 'start'"),
    ],
)
def test_bad_landmarks(tmp_path: Path, old: str, new: str, message: str) -> None:
    text = data_path("landmarks/reference_tongue.toml").read_text(encoding="utf-8")
    assert old in text
    path = tmp_path / "table.toml"
    path.write_text(text.replace(old, new, 1), encoding="utf-8")
    with pytest.raises(InputError, match=message):
        load_landmarks(path)


def test_landmarks_of_the_file() -> None:
    assert (load_landmarks().tongue.inner[0, 4:] == 76).all()
    with pytest.raises(InputError, match=r"data file 'none\.csv' not found"):
        data_path("none.csv")
