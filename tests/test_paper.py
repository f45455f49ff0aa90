from pathlib import Path

import numpy as np
import pandas as pd
import pytest

from glossa import data_files, paper
from glossa.errors import InputError
from glossa.motor import MUSCLES


def numbers(table: pd.DataFrame) -> np.ndarray[tuple[int, ...], np.dtype[np.float64]]:
    return table.to_numpy(dtype=np.float64)


def test_table_1_in_the_order_of_the_muscles() -> None:
    table = paper.force_capacity()
    assert tuple(table.index) == MUSCLES
    assert table.loc["GH", "force_capacity_N"] == 17.5
    # Force capacity follows the area: 0.22 N/mm2, rounded to half a newton.
    assert numbers(table)[:, 1] / numbers(table)[:, 0] == pytest.approx(0.22, rel=0.02)


def test_tables_2_and_3_by_vowel_and_muscle() -> None:
    for table in (paper.forces(), paper.motor_commands()):
        assert list(table.index) == ["i", "ə", "u", "a"]
        assert tuple(table.columns) == MUSCLES
        assert np.isfinite(numbers(table)).all()
    assert paper.forces().loc["i", "GGp"] == 25.82
    assert paper.motor_commands().loc["i", "GGp"] == 0.60


def test_forces_stay_below_capacity() -> None:
    capacity = numbers(paper.force_capacity())[:, 1]
    assert (numbers(paper.forces()) <= capacity).all()


def test_formants_differ_as_section_3_says() -> None:
    measured = paper.formants_measured()
    simulated = paper.formants_simulated().loc[measured.index, measured.columns]
    difference = np.abs(1 - numbers(measured) / numbers(simulated))
    assert difference.shape == (3, 4)
    assert difference[:, 0].argmax() == 1  # /u/
    assert difference[:, 0].max() == pytest.approx(0.043, abs=0.001)
    assert difference[:, 1].argmax() == 0  # /i/
    assert difference[:, 1].max() == pytest.approx(0.102, abs=0.001)


def test_sensitivity_spans_the_ranges_of_section_4() -> None:
    table = paper.sensitivity_i()
    assert len(table) == 56
    assert table.index.is_unique
    assert table.index.get_level_values("muscle").nunique() == 9
    assert np.ptp(numbers(table), axis=0).tolist() == [103, 250, 283]


def test_dispersion_of_section_4_from_tip_to_root() -> None:
    table = paper.dispersion()
    assert len(table) == 6
    assert numbers(table)[0].tolist() == [8.3, 3.4, 147.0]
    assert (table["major_mm"] > table["minor_mm"]).all()
    assert table["angle_deg"].isna().sum() == 2  # "no clear direction"


def test_gravity_of_section_5() -> None:
    table = paper.gravity().set_index(["control", "gravity"])
    assert table["value"].loc[[("silent", "upright"), ("silent", "supine"), ("reflex", "supine")]].tolist() == [
        1.5,
        9,
        3,
    ]
    assert table.loc[["a", "u", "i"], "value"].tolist() == [8.0, 7.0, 1.0]
    assert set(table["unit"]) == {"mm", "%"}


def test_single_muscles_cover_every_muscle() -> None:
    table = paper.single_muscles()
    assert tuple(dict.fromkeys(table["muscle"])) == MUSCLES
    long_muscles = table["muscle"].isin(["Sty", "IL", "SL"])
    assert set(table.loc[long_muscles, "command"]) == {0.85}
    assert set(table.loc[~long_muscles, "command"]) == {0.75}
    assert (table["displacement_mm"].isna() == (table["bound"] == "unstated")).all()
    assert set(table["bound"]) == {"about", "up_to", "below", "unstated"}
    assert set(table["direction"]) == {"forward", "backward", "up", "down", "wider", "narrower"}


def test_constants_are_consistent() -> None:
    for coefficient in ("yeoh_c10", "yeoh_c20"):
        cadaver, active = paper.constant(f"{coefficient}_cadaver"), paper.constant(f"{coefficient}_active")
        raised = paper.constant("cadaver_to_living_factor") * cadaver
        assert paper.constant(coefficient) == pytest.approx(raised, rel=1e-3)
        assert active == 10 * paper.constant(coefficient)
    assert paper.constants()["reflex_delay"] == paper.Constant("d", 0.017, "s", "equation 2 (section II.C.1)")


def test_force_velocity_is_one_at_rest() -> None:
    f1, f2, f3 = (paper.constant(f"force_velocity_f{k}") for k in (1, 2, 3))
    assert f1 + f2 * np.arctan(f3) == pytest.approx(1.0, abs=0.001)


def test_changing_a_table_changes_no_other() -> None:
    for read in (paper.forces, paper.single_muscles):
        table = read()
        table[table.columns[0]] = 0
        assert not table.equals(read())
    assert paper.forces().loc["i", "GGp"] == 25.82


def test_unknown_names_are_refused() -> None:
    with pytest.raises(InputError, match="no constant 'gravity' in the paper; known: yeoh_c10"):
        paper.constant("gravity")
    with pytest.raises(InputError, match=r"table7\.csv"):
        paper.rows("table7.csv")


def test_incomplete_rows_are_refused(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    broken = tmp_path / "broken.csv"
    broken.write_text("# note\nmuscle,area\nGGa,82\nGGm\n", encoding="utf-8")
    monkeypatch.setattr(paper, "data_path", lambda _: broken)
    with pytest.raises(InputError, match=r"broken\.csv: row 2 does not have 2 cells"):
        paper.rows("broken.csv")


def test_files_say_where_they_come_from() -> None:
    folder = data_files.data_path("paper/constants.csv").parent
    files = sorted(folder.glob("*.csv"))
    assert len(files) == 11
    for file in files:
        assert file.read_text(encoding="utf-8").startswith("# Buchaillard, S., Perrier, P. & Payan, Y. (2009)")
