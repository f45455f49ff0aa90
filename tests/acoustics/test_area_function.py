from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest

from glossa import AreaFunction, InputError


def test_measures() -> None:
    area = AreaFunction([0.01, 0.02, 0.03], [1e-4, 2e-4, 3e-4])
    assert area.length == pytest.approx(0.06)
    assert area.volume == pytest.approx(1e-6 + 4e-6 + 9e-6)
    assert area.positions == pytest.approx([0.005, 0.02, 0.045])
    assert area.sections is None
    assert "3 sections, 6.00 cm, least 1 cm² at 0.5 cm, lips 3 cm²" in repr(area)


def test_arrays_are_read_only_copies() -> None:
    lengths, areas = np.full(3, 0.05), np.full(3, 1e-4)
    area = AreaFunction(lengths, areas, sections={"closed": [False] * 3})
    lengths[0] = areas[0] = 9.0
    assert area.lengths[0] == 0.05
    assert area.areas[0] == 1e-4
    with pytest.raises(ValueError, match="read-only"):
        area.areas[0] = 1.0
    assert area.sections == {"closed": [False] * 3}


def test_lips_come_in_front() -> None:
    area = AreaFunction([0.16], [3e-4], sections="anything").with_lips(0.008, 1.5e-4)
    assert area.lengths.tolist() == [0.16, 0.008]
    assert area.areas.tolist() == [3e-4, 1.5e-4]
    assert area.sections is None


def test_uniform() -> None:
    area = AreaFunction.uniform(0.17, 4e-4, 10)
    assert area.length == pytest.approx(0.17)
    assert area.areas.tolist() == [4e-4] * 10


@pytest.mark.parametrize(
    ("lengths", "areas", "message"),
    [
        ([0.1, 0.1], [1e-4], "one value for each section, got 2 and 1"),
        ([], [], "at least one section"),
        ([[0.1]], [[1e-4]], r"one row of numbers, got an array of shape \(1, 1\)"),
        (["long"], [1e-4], "lengths must be numbers"),
        ([0.1, 0.1], [1e-4, -1e-4], r"area of section 1 .* positive number of m², got -0\.0001"),
        ([0.1, 0.1], [0.0, 1e-4], "area of section 0 .* got 0.0; a closed tract has no formants: floor its areas"),
        ([0.1, 0.1], [1e-4, np.nan], "area of section 1 .* got nan"),
        ([0.1, np.inf], [1e-4, 1e-4], "length of section 1 .* got inf"),
        ([0.0, 0.1], [1e-4, 1e-4], r"length of section 0 .* got 0\.0$"),
        ([8.5, 9.0], [1e-4, 1e-4], r"add up to 17\.5 m, over 1 m: they must be in m"),
        ([0.1, 0.1], [1e-4, 9e-9], r"area of section 1 is 9e-09 m², below 1e-08 m² .* floor the areas"),
        ([0.1, 0.1], [1e-4, 3.0], "area of section 1 is 3 m², over 0.01 m²"),
    ],
)
def test_bad_values_are_refused(lengths: Any, areas: Any, message: str) -> None:
    with pytest.raises(InputError, match=message):
        AreaFunction(lengths, areas)


@pytest.mark.parametrize("sections", [0, True, 2.0])
def test_uniform_needs_sections(sections: Any) -> None:
    with pytest.raises(InputError, match="sections must be a whole number"):
        AreaFunction.uniform(0.17, 3e-4, sections)


@pytest.mark.parametrize(("length", "area"), [(0.0, 1e-4), (0.01, np.nan)])
def test_bad_lips_are_refused(length: float, area: float) -> None:
    with pytest.raises(InputError, match="lip"):
        AreaFunction([0.16], [3e-4]).with_lips(length, area)


def test_table_gives_the_same_bits(tmp_path: Path) -> None:
    area = AreaFunction(np.array([0.1, 0.2]) / 3.0, np.array([1e-4, 2e-4]) / 7.0)
    area.to_csv(tmp_path / "a.csv")
    again = AreaFunction.from_csv(tmp_path / "a.csv")
    assert again.lengths.tolist() == area.lengths.tolist()
    assert again.areas.tolist() == area.areas.tolist()
    assert (tmp_path / "a.csv").read_text(encoding="utf-8").startswith("length_m,area_m2\n")


@pytest.mark.parametrize(("unit", "length", "area"), [("cm", 0.5, 3.0), ("mm", 5.0, 300.0)])
def test_table_in_other_units(tmp_path: Path, unit: str, length: float, area: float) -> None:
    path = tmp_path / "a.csv"
    path.write_text(f"# by hand\nname, area_{unit}2 ,length_{unit}\nx,{area},{length}\n", encoding="utf-8")
    read = AreaFunction.from_csv(path)
    assert read.lengths == pytest.approx([0.005])
    assert read.areas == pytest.approx([3e-4])


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("", "has columns none; it needs length_m and area_m2"),
        ("length,area\n0.1,1e-4\n", "has columns length, area; it needs length_m"),
        ("length_m,area_m2\n0.1,wide\n", "row 1 has 'wide' as area_m2, not a number"),
        ("length_m,area_m2\n0.1\n", "row 1 has None as area_m2"),
        ("length_m,area_m2\n", "at least one section"),
        ("length_m,area_m2\n0.1,3\n", "areas must be in m²"),
    ],
)
def test_bad_tables_are_refused(tmp_path: Path, text: str, message: str) -> None:
    path = tmp_path / "bad.csv"
    path.write_text(text, encoding="utf-8")
    with pytest.raises(InputError, match=message) as raised:
        AreaFunction.from_csv(path)
    assert "bad.csv" in str(raised.value)


def test_missing_files_are_refused(tmp_path: Path) -> None:
    with pytest.raises(InputError, match=r"none\.csv' cannot be read"):
        AreaFunction.from_csv(tmp_path / "none.csv")
    with pytest.raises(InputError, match="cannot be written"):
        AreaFunction([0.1], [1e-4]).to_csv(tmp_path / "no" / "a.csv")
