"""The speaker file: exact round trip, and what is refused."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from glossa.anatomy import Hyoid, Muscle, Speaker, Spring, Wall
from glossa.errors import SpeakerFileError

CUBE = np.array([[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0], [0, 0, 1], [1, 0, 1], [1, 1, 1], [0, 1, 1]], dtype=float)


def full_speaker(scale: float = 1.0, name: str = "cube") -> Speaker:
    wall = Wall(scale * CUBE, [[0, 1, 2, 3]])
    return Speaker(
        scale * CUBE,
        [list(range(8))],
        muscles={"m": Muscle([0], [[0, 1, 2], [4, 5]], scale, 4), "n": Muscle([0], [[0, 1]], 2.0)},
        node_sets={"jaw": [0, 1]},
        walls={"palate": wall},
        hyoid=Hyoid(wall, 0.0068, [0.1, 0.2, scale], (Spring([0, 0, 0], [1, 1, 1], 220.0, name="ligament"),)),
        contours={"dorsum": [4, 5, 6]},
        name=name,
        contact_faces={"palate": [[4, 5, 6, 7]]},
    )


@settings(max_examples=30, deadline=None)
@given(scale=st.floats(min_value=1e-6, max_value=1e6), name=st.text(max_size=20).filter(lambda t: t.isprintable()))
def test_round_trip_is_exact(tmp_path_factory: pytest.TempPathFactory, scale: float, name: str) -> None:
    path = tmp_path_factory.mktemp("speakers") / "speaker.json"
    speaker = full_speaker(scale, name)
    speaker.save(path)
    copy = Speaker.load(path)
    assert copy.fingerprint == speaker.fingerprint
    assert np.array_equal(copy.nodes, speaker.nodes)
    assert copy.muscles["m"].fibres_per_element == 4
    assert copy.muscles["n"].fibres_per_element is None


def test_file_without_contact_faces(tmp_path: Path) -> None:
    path = tmp_path / "speaker.json"
    full_speaker().save(path)
    document = json.loads(path.read_text())
    assert document.pop("contact_faces") == {"palate": [[4, 5, 6, 7]]}
    path.write_text(json.dumps(document))
    assert dict(Speaker.load(path).contact_faces) == {}


def test_reference_round_trip(tmp_path: Path, reference: Speaker) -> None:
    reference.save(tmp_path / "reference.json")
    assert Speaker.load(str(tmp_path / "reference.json")).fingerprint == reference.fingerprint


def test_nothing_is_left_of_a_failed_save(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    path = tmp_path / "speaker.json"
    full_speaker().save(path)
    before = path.read_bytes()

    def broken(*_: Any) -> None:
        raise OSError("disk full")

    monkeypatch.setattr("os.replace", broken)
    with pytest.raises(OSError, match="disk full"):
        full_speaker(2.0).save(path)
    assert path.read_bytes() == before
    assert [p.name for p in tmp_path.iterdir()] == ["speaker.json"]


@pytest.mark.parametrize("fraction", [0.0, 0.01, 0.3, 0.7, 0.999])
def test_truncated(tmp_path: Path, fraction: float) -> None:
    path = tmp_path / "speaker.json"
    full_speaker().save(path)
    text = path.read_bytes().rstrip()
    path.write_bytes(text[: int(fraction * len(text))])
    with pytest.raises(SpeakerFileError, match=r"speaker\.json .*at line 1, column"):
        Speaker.load(path)


def test_missing_file(tmp_path: Path) -> None:
    with pytest.raises(FileNotFoundError):
        Speaker.load(tmp_path / "none.json")
    with pytest.raises(FileNotFoundError, match=r"no pb_tongue\.json"):
        Speaker.load(tmp_path)


@pytest.mark.parametrize(
    ("content", "message"),
    [
        (b"\xff\xfe\x00", "not UTF-8"),
        (b"hello", "is not valid JSON|truncated"),
        (b"[1, 2]", 'its "format" is not "glossa-speaker"'),
        (b'{"format": "other"}', 'its "format" is not "glossa-speaker"'),
        (b'{"format": "glossa-speaker", "version": 1}', "version 1; this program reads version 2"),
        (b'{"format": "glossa-speaker", "version": 2}', "the file lacks the entry 'muscles'"),
        (b"[" * 100000, "nested too deeply|truncated"),
    ],
)
def test_foreign(tmp_path: Path, content: bytes, message: str) -> None:
    path = tmp_path / "speaker.json"
    path.write_bytes(content)
    with pytest.raises(SpeakerFileError, match=message):
        Speaker.load(path)


@pytest.mark.parametrize(
    ("place", "value", "message"),
    [
        (("nodes",), [[0, 0]], r"nodes: expected shape \(n, 3\)"),
        (("nodes",), None, "nodes"),
        (("hexahedra", 0, 0), 99, "hexahedron 0 names node 99"),
        (("muscles",), [], "'muscles' must be a JSON object"),
        (("muscles", "m"), 3, "muscle 'm' must be a JSON object"),
        (("muscles", "m", "fibres"), 3, "muscle 'm': 'fibres' must be a list"),
        (("muscles", "m", "fibres"), [[0]], r"muscle 'm': fibre 0 has 1 node\(s\)"),
        (("muscles", "m"), {}, "muscle 'm' lacks the entry 'elements'"),
        (("walls", "palate", "faces"), [[0, 1, 99]], "wall 'palate': wall face 0 names vertex 99"),
        (("walls", "palate", "faces"), [[0, 1], [2]], "wall 'palate'"),
        (("hyoid", "springs"), 1, "hyoid: 'springs' must be a list"),
        (("hyoid", "springs"), [{}], "hyoid spring 0 lacks the entry 'on_hyoid'"),
        (("name",), 5, "name must be a string"),
        (("contact_faces",), 5, "'contact_faces' must be a JSON object"),
        (("contact_faces", "palate", 0, 0), 3, "contact faces of wall 'palate', face 0: the nodes"),
    ],
)
def test_inconsistent(tmp_path: Path, place: tuple[Any, ...], value: Any, message: str) -> None:
    path = tmp_path / "speaker.json"
    full_speaker().save(path)
    document = json.loads(path.read_text())
    inner = document
    for key in place[:-1]:
        inner = inner[key]
    inner[place[-1]] = value
    path.write_text(json.dumps(document))
    with pytest.raises(SpeakerFileError, match=message) as caught:
        Speaker.load(path)
    assert str(path) in str(caught.value)
