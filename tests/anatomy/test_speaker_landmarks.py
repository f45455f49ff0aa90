"""A user's landmarks: files and mappings, what they replace, and what is refused."""

from __future__ import annotations

import logging
import re
import tomllib
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from glossa import InputError, Speaker
from glossa.anatomy.generated_checks import check_mesh
from glossa.anatomy.landmark_tables import FILES, built_in_tables
from glossa.anatomy.reference import reference_speaker
from glossa.anatomy.reference_block import Block
from glossa.anatomy.shape import shape_parameters
from glossa.anatomy.speaker_landmarks import load_landmarks
from glossa.data_files import data_path

TONGUE, WALLS = (built_in_tables(part) for part in FILES)


def column(table: str, name: str) -> np.ndarray:
    """Of the built-in walls, as in the file."""
    return np.array(WALLS[table]["rows"], dtype=float)[:, WALLS[table]["columns"].index(name)]


def test_a_file_and_a_mapping_say_the_same(tmp_path: Path) -> None:
    path = tmp_path / "my speaker.toml"
    path.write_text("[shape]\nvault_height = 1.5\n[styloid]\npoint = [147, 33, 125]\n", encoding="utf-8")
    mapping = {"shape": {"vault_height": 1.5}, "styloid": {"point": np.array([147, 33, 125])}, "name": "my speaker"}
    speakers = [Speaker.reference(1, source) for source in (path, str(path), mapping)]
    assert {speaker.fingerprint for speaker in speakers} == {speakers[0].fingerprint}
    assert speakers[0].name == "my speaker, resolution 1"
    assert Speaker.reference(2, {"name": "Ms B"}).name == "Ms B, resolution 2"
    out = 1e-3 * shape_parameters()["styloid_width"].value  # added to what is given
    assert speakers[0].nodes[-1] == pytest.approx([0.147, 0.033 + out, 0.125])
    assert load_landmarks(path).changes == ("[styloid] point", "[shape] vault_height +1.5 mm")


@pytest.mark.parametrize("part", FILES)
def test_a_copy_of_a_built_in_table_changes_nothing(part: str, reference: Speaker) -> None:
    landmarks = load_landmarks(data_path(FILES[part]))
    assert landmarks.changes == ()
    assert reference_speaker(1, landmarks).fingerprint == reference.fingerprint


def test_both_copies_in_one_file_with_a_shape() -> None:
    """Shape parameters are added after entries are replaced."""
    content: dict[str, Any] = {}
    for name in FILES.values():
        content |= tomllib.loads(data_path(name).read_text(encoding="utf-8"))
    full = Speaker.reference(1, content | {"shape": {"arch_width": 1}})
    short = Speaker.reference(1, {"shape": {"arch_width": 1}, "name": "reference"})
    assert full.fingerprint == short.fingerprint


def test_saved_and_loaded_again(tmp_path: Path) -> None:
    speaker = Speaker.reference(1, {"shape": {"rear_wall": 1}})
    speaker.save(tmp_path / "copy.json")
    assert Speaker.load(tmp_path / "copy.json").fingerprint == speaker.fingerprint


def test_rows_and_columns_of_walls(reference: Speaker) -> None:
    depth = column("outer", "depth") + 0.25
    by_column = load_landmarks({"outer": {"depth": depth}})
    assert by_column.walls.outer["depth"] - load_landmarks().walls.outer["depth"] == pytest.approx(0.25)
    rows = [list(row) for row in WALLS["outer"]["rows"]]
    for row, value in zip(rows, depth, strict=True):
        row[WALLS["outer"]["columns"].index("depth")] = float(value)
    by_rows = Speaker.reference(1, {"outer": {"rows": rows}, "name": "x"})
    assert by_rows.fingerprint == Speaker.reference(1, {"outer": {"depth": depth}, "name": "x"}).fingerprint
    both = load_landmarks({"outer": {"depth": depth, "rows": rows}})
    assert np.array_equal(both.walls.outer["depth"], by_column.walls.outer["depth"])
    assert not np.array_equal(by_rows.walls["hard_palate"].vertices, reference.walls["hard_palate"].vertices)


def test_a_single_spring() -> None:
    ends = [[114, 10, 52], [118, 9, 38]]
    speaker = Speaker.reference(1, {"hyoid": {"springs": {"sternohyoid": ends}}})
    assert speaker.hyoid is not None
    fixed = {spring.name: spring.fixed * 1e3 for spring in speaker.hyoid.springs}
    assert fixed["sternohyoid right"] == pytest.approx(ends[1])
    assert fixed["sternohyoid left"] == pytest.approx([118, -9, 38])
    assert len(fixed) == 2 * len(WALLS["hyoid"]["springs"])


def test_more_rows_need_shape_parameters_without_them() -> None:
    rows = [list(row) for row in WALLS["hyoid"]["rows"]]
    middle = (np.array(rows[1]) + np.array(rows[2])) / 2.0
    longer = {"hyoid": {"rows": [*rows[:2], middle.tolist(), *rows[2:]]}}
    off = {"hyoid_height": -shape_parameters()["hyoid_height"].value}
    assert len(load_landmarks(longer | {"shape": off}).walls.hyoid["x"]) == len(rows) + 1
    with pytest.raises(InputError, match=r"pharynx_length has weights for 6 values of hyoid\.z, and there are 7"):
        load_landmarks(longer | {"shape": off | {"pharynx_length": 1}})
    with pytest.raises(InputError, match=r"or set hyoid_height = .* in \[shape\], which switches it off"):
        load_landmarks(longer)


@pytest.mark.parametrize(
    ("source", "message"),
    [
        ({"vault": 3}, "landmarks: unknown entry 'vault'; known are the tables shape, rays, lateral"),
        ({"vault_height": 3}, r"shape parameters belong into the table \[shape\]: put 'vault_height' there"),
        ({"shape": {"vault": 3}}, r"\[shape\] has no parameter 'vault'; known are .*vault_height"),
        ({"shape": 3}, r"\[shape\] must be a table, got 3"),
        ({"shape": {"vault_height": "high"}}, r"\[shape\] vault_height must be a number, got 'high'"),
        ({"shape": {"vault_height": float("nan")}}, "vault_height must be finite"),
        ({"shape": {"vault_height": 1000}}, r"\[shape\] vault_height must lie between .* and .* mm, got 1000"),
        ({"rays": 3}, r"\[rays\] must be a table, got 3"),
        ({"rays": {"outer_y": [0] * 17}}, r"\[rays\] has no entry 'outer_y'; known are inner_x, inner_z"),
        ({"rays": {"outer_z": [100] * 16}}, "expected an array of numbers"),
        ({"rays": {"outer_angle": [0] * 16}}, r"outer_angle has shape \(16,\), expected \(17,\)"),
        ({"spacing": {"columns": [0, "a", 0.5, 0.7, 1]}}, "columns: expected an array of numbers"),
        ({"outer": {"height": [0] * 24}}, r"\[outer\] has no entry 'height'; known are columns, rows, .*half_width"),
        ({"outer": {"depth": [1, 2]}}, r"\[outer\] depth must be a list of \d+ values, one for each row, got \[1, 2\]"),
        ({"outer": {"rows": 3}}, "landmarks: missing or malformed entry"),
        ({"outer": {"rows": [[1, 2]], "depth": [5]}}, "landmarks: malformed entry"),
        ({"hyoid": {"springs": {"levator": [[1, 2, 3], [4, 5, 6]]}}}, r"\[hyoid.springs\] has no spring 'levator'"),
        ({"hyoid": {"springs": 3}}, r"\[hyoid.springs\] has no spring 3; known are digastric_anterior"),
        ({"format": "glossa-shape"}, "format must be 'glossa-landmarks' or .*, got 'glossa-shape'"),
        ({"version": 2}, "version must be 1, got 2"),
        ({"length_unit": "m"}, "length_unit must be 'mm', got 'm'"),
        ({"name": 3}, "name must be a text, got 3"),
        (3, "landmarks must be the path of a TOML file or a mapping, got int"),
    ],
)  # fmt: skip
def test_refusals(source: Any, message: str) -> None:
    with pytest.raises(InputError, match=message):
        load_landmarks(source)


def test_refusals_name_the_file(tmp_path: Path) -> None:
    path = tmp_path / "mine.toml"
    for text, message in (
        ("[shape", "Expected"),
        ("[shape]\nx = 1", "no parameter 'x'"),
        ("[rays]\ninner_angle = [1]", "has shape"),
    ):
        path.write_text(text, encoding="utf-8")
        with pytest.raises(InputError, match=message) as raised:
            Speaker.reference(1, path)
        assert str(raised.value).startswith(f"{path}: ")
    with pytest.raises(InputError, match=r"cannot read the landmarks .*none\.toml: No such file"):
        Speaker.reference(1, tmp_path / "none.toml")


# Landmarks that give no sound speaker


def moved(table: str, name: str, by: float, first: int = 0, last: int | None = None) -> dict[str, Any]:
    """The built-in walls with some rows of a column moved."""
    values = column(table, name)
    values[first:last] += by
    return {table: {name: values}}


def test_too_distorted_elements_are_named() -> None:
    """Against elements counted by hand: where it says the worst one is, it is."""
    outer = list(TONGUE["rays"]["outer_z"])
    outer[11:] = [value + 8.0 for value in outer[11:]]
    with pytest.raises(InputError) as raised:
        Speaker.reference(1, {"rays": {"outer_z": outer}})
    message = str(raised.value)
    assert message.startswith("changed reference: hexahedron ")
    assert "at least 0.1 is needed and the built-in speaker keeps 0.3; change less of: [rays] outer_z" in message
    number = int(message.split()[3])
    index, place = ([float(part) for part in found.split(",")] for found in re.findall(r"\((.*?)\)", message)[:2])
    block, landmarks = Block(1), load_landmarks({"rays": {"outer_z": outer}})
    nodes, hexahedra = block.nodes(landmarks.tongue), block.hexahedra()
    i, j, k = (int(part) for part in index)
    assert block.node(i, j, k) in hexahedra[number]
    assert block.node(i + 1, j + 1, k + 1) in hexahedra[number]
    assert place == pytest.approx(nodes[hexahedra[number]].mean(axis=0) * 1e3, abs=0.051)
    with pytest.raises(InputError, match="too distorted"):
        check_mesh(block, nodes, hexahedra, landmarks)


def test_a_tongue_that_overlaps_a_wall() -> None:
    message = r"the tongue at rest overlaps wall hard_palate by [3-9]\.\d mm at \(.*\) mm; .*: \[outer\] half_width"
    with pytest.raises(InputError, match=message):
        Speaker.reference(1, moved("outer", "half_width", -5.0, 4, 12))


def test_a_closed_airway() -> None:
    """A palate lowered onto the midline of the tongue; a larynx whose front lies behind its rear."""
    low = moved("outer", "z", -6.4, 5, 9)
    low["outer"]["depth"] = column("outer", "depth")
    low["outer"]["depth"][5:9] -= 6.4
    low["outer"]["exponent"] = np.full_like(column("outer", "exponent"), 6.0)  # flat: its sides stay off the tongue
    with pytest.raises(InputError, match="closed at rest: on the midline the tongue reaches wall hard_palate"):
        Speaker.reference(1, low)
    with pytest.raises(InputError, match="closed at rest: on the midline the front wall reaches wall larynx"):
        Speaker.reference(1, moved("larynx_front", "x", 10.0, 2, 6))
    with pytest.raises(InputError, match="closed at rest: on the midline the hyoid bone reaches wall pharynx"):
        Speaker.reference(1, {"hyoid": {"z": column("hyoid", "z") + 10.0, "x": column("hyoid", "x") + 22.0}})


def test_a_folded_wall() -> None:
    """A trough deeper than its bend is wide, and a jaw whose rows run back."""
    for change, wall in (
        (moved("outer", "depth", 30.0, 12, 14), "soft_palate"),
        (moved("mandible", "z", -10.0, 5, 6), "mandible"),
    ):
        with pytest.raises(InputError, match=f"wall {wall} is folded over itself at .* mm: its landmarks bend too"):
            Speaker.reference(1, change)


def test_what_falls_short_is_logged(caplog: pytest.LogCaptureFixture) -> None:
    with caplog.at_level(logging.WARNING):
        Speaker.reference(1, {"shape": {"vault_height": 0.5}})
        assert caplog.messages == []
        speaker = Speaker.reference(1, moved("outer", "half_width", -2.0, 4, 12) | {"name": "narrow"})
    notes = speaker.quality().notes
    assert caplog.messages == [f"narrow, resolution 1: {note}" for note in notes]
    assert "the tongue at rest overlaps wall hard_palate by 1." in notes[0]


def test_a_parameter_of_zero_is_no_change() -> None:
    assert load_landmarks({"shape": dict.fromkeys(shape_parameters(), 0.0)}).changes == ()
