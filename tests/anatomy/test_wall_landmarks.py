"""The landmark table of walls and hyoid: every way to break it, with its message."""

from __future__ import annotations

from pathlib import Path

import pytest

from glossa.anatomy.speaker_landmarks import load_landmarks
from glossa.data_files import data_path
from glossa.errors import InputError


@pytest.mark.parametrize(
    ("old", "new", "message"),
    [
        ('length_unit = "mm"', 'length_unit = "cm"', "length_unit must be 'mm'"),
        ("[mandible]", "[jaw]", "unknown entry 'jaw'"),
        ("[outer]", "[outer", r"table\.toml"),
        ('"depth", "exponent", "end"]', '"depth", "end"]', r"outer: columns must be \['x', 'z', 'direction'"),
        ("[52, 104, -90, 11.5, 3, 3.0, 15]", "[52, 104, -90, 11.5, 3, 15]", "row 1 has 6 values, expected 7: x, z"),
        ("[52, 104, -90, 11.5,", "[nan, 104, -90, 11.5,", r"outer rows: value at \(1, 0\) is nan, not finite"),
        ("[52, 104, -90, 11.5,", '["a", 104, -90, 11.5,', "outer rows: expected an array of numbers"),
        ("[52, 104, -90, 11.5,", "[52, 104, -90, -1,", "outer: half_width must be positive, row 1 has -1"),
        ("[52, 104, -90,", "[49.5, 100, -90,", "outer: rows 0 and 1 are at the same place"),
        ("soft_palate = 9", "soft_palate = 14", "must name ascending rows"),
        ("pharynx = 13", "pharynx = 13.5", "must name ascending rows"),
        ("[55.5, 126.5, 2]", "[60.5, 126.5, 2]", "larynx_front: z must fall from row to row"),
        ("end = 3.4", "end = 5", "mandible end must be at most 4"),
        ("end = 3.4", 'end = "far"', "mandible end must be a number, got 'far'"),
        ("[112.9, 0, 54.3", "[112.9, 1, 54.3", "hyoid: the first row must have y = 0"),
        ("density = 2000", "density = 0", "hyoid density must be positive"),
        ("[[115, 13, 55], [76, 4, 57]]", "[[115, 13, 55]]", "hyoid spring digastric_anterior: expected two different"),
        ("[[115, 13, 55], [76, 4, 57]]", "[[115, -13, 55], [76, 4, 57]]", "two different points .* with y > 0"),
        ("[114.5, 9, 54.3", "[112.9, 0, 54.3", "hyoid: rows 0 and 1 are at the same place"),
        ("sternohyoid = ", "geniohyoid = ", "has no spring 'geniohyoid'; known are digastric_anterior,"),
    ],
)  # fmt: skip
def test_bad_wall_landmarks(tmp_path: Path, old: str, new: str, message: str) -> None:
    text = data_path("landmarks/reference_walls.toml").read_text(encoding="utf-8")
    assert old in text
    path = tmp_path / "table.toml"
    path.write_text(text.replace(old, new, 1), encoding="utf-8")
    with pytest.raises(InputError, match=message) as raised:
        load_landmarks(path)
    assert "table.toml" in str(raised.value)


def test_too_few_rows() -> None:
    rows = [[59, 125, 2], [52, 126, 2], [26.5, 117, 2.5]]
    with pytest.raises(InputError, match="landmarks: larynx_front: 3 rows, at least 4 are needed"):
        load_landmarks({"larynx_front": {"rows": rows}})
