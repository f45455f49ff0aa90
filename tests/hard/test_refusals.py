"""What fuzzing has found and what is refused since, case by case."""

from __future__ import annotations

import copy
import json
import sqlite3
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from tests.blocks import block
from tests.hard.test_fuzz_arguments import TARGETS
from tests.hard.test_fuzz_files import ANSYS, LANDMARKS, OBJ, ansys_folder, pb_folder, small_study

from glossa import InputError, MotorCommands, Movement, Posture, Scene, Speaker, studies
from glossa.anatomy.obj_file import read_obj
from glossa.anatomy.speaker_landmarks import load_landmarks

HUGE = 10**400  # no double
COMPLEX = np.zeros(3, dtype=complex)
RAGGED = [[1, 2], [3]]

ARGUMENTS: list[tuple[str, str, Any]] = [
    ("Yeoh", "c10", HUGE),
    ("Damping", "law", np.zeros(0)),
    ("Stiffening", "gains", 0),
    ("a command", "value", HUGE),
    ("commands changed", "muscle", []),
    ("Schedule", "commands", 0),
    ("Schedule.through", "targets", 0),
    ("Wall", "vertices", 1j),
    ("Wall", "faces", RAGGED),
    ("Spring", "stiffness", HUGE),
    ("Spring", "on_hyoid", COMPLEX),
    ("Hyoid", "mass", 1j),
    ("Hyoid", "springs", 0),
    ("Muscle", "fibres", 0),
    ("Muscle", "force_capacity", HUGE),
    ("Scene", "gravity", HUGE),
    ("Scene", "gravity", COMPLEX),
    ("Scene", "fixed", 0),
    ("Scene", "fixed", RAGGED),
    ("equilibrate", "start", COMPLEX),
    ("equilibrate", "prescribed", np.zeros(0)),
    ("equilibrate", "loads", np.zeros(0)),
    ("a prescribed displacement", "value", HUGE),
    ("a prescribed displacement", "value", COMPLEX),
    ("a load", "value", HUGE),
    ("simulate", "integrator", np.zeros(0)),
    ("AreaFunction", "lengths", COMPLEX),
    ("synthesize", "f0", HUGE),
    ("synthesize", "source", np.zeros(0)),
    ("synthesize", "onset", 2**31),
    ("grid", "value", np.array(2.0)),
    ("run_points", "points", 0),
    ("run_points", "store", 0),
    ("run_points", "store", "\x00"),
    ("run_points", "store", "x" * 300),
]


@pytest.mark.parametrize(
    ("name", "argument", "value"), ARGUMENTS, ids=[f"{n}-{a}-{k}" for k, (n, a, _) in enumerate(ARGUMENTS)]
)
def test_arguments(name: str, argument: str, value: Any) -> None:
    target = TARGETS[name]
    with pytest.raises(InputError):
        target.call(**{**target.good, argument: value})


LONG = b"9" * 5000


@pytest.mark.parametrize("content", [b"[" * 5000, b'{"format": ' + LONG + b"}"])
def test_speaker_files(tmp_path: Path, content: bytes) -> None:
    path = tmp_path / "speaker.json"
    path.write_bytes(content)
    with pytest.raises(InputError, match="not a speaker file"):
        Speaker.load(path)


def test_landmarks(tmp_path: Path) -> None:
    path = tmp_path / "mine.toml"
    for content in (b"x = " + b"[" * 5000, b"x = " + LONG):
        path.write_bytes(LANDMARKS + content)
        with pytest.raises(InputError, match=r"mine\.toml"):
            load_landmarks(path)


def test_surfaces_with_comments_in_any_encoding(tmp_path: Path) -> None:
    path = tmp_path / "wall.obj"
    path.write_bytes(b"# \xa9\n" + OBJ)
    assert len(read_obj(path).faces) == 2


FILES = [
    ("tongue.node", "1 nan 0 0 0 0 0\n"),
    ("tongue.node", "inf 0 0 0 0 0 0\n"),
    ("tongue.elem", ANSYS["tongue.elem"].replace("3 12 15 6", "3 12 15 35")),
    ("tongueContourNodes.txt", ""),
    ("CreateMuscles.mac", "ESEL,S,ELEM,,1,999999999\n"),
    ("CreateMuscles.mac", "ESEL,S,ELEM,,1," + "9" * 5000 + "\n"),
]


@pytest.mark.parametrize(("name", "text"), FILES)
def test_artisynth_files(tmp_path: Path, name: str, text: str) -> None:
    folder = ansys_folder(tmp_path)
    (folder / name).write_text(text)
    with pytest.raises(InputError, match=name.split(".", maxsplit=1)[0]):
        Speaker.from_artisynth(folder)


ENTRIES: list[tuple[str, Any]] = [
    ("muscles", 1),
    ("external_points", 1),
    ("alternative_attachment_sets", {"a": RAGGED}),
    ("alternative_attachment_sets", {"a": [2**31]}),
    ("alternative_attachment_sets", {"a": [10**30]}),
    ("jaw_fixed", "x"),
    ("dorsum_contour", [1000]),
    ("nodes", [0.0]),
    ("surface_quads", 1),
]


@pytest.mark.parametrize(("entry", "value"), ENTRIES)
def test_pb_files(tmp_path: Path, entry: str, value: Any) -> None:
    path = pb_folder(tmp_path) / "pb_tongue.json"
    document = copy.deepcopy(json.loads(path.read_text()))
    document[entry] = value
    path.write_text(json.dumps(document))
    with pytest.raises(InputError, match=r"pb_tongue\.json"):
        Speaker.load(path.parent)


@pytest.mark.parametrize(
    ("statement", "words"),
    [
        ("UPDATE record SET seconds = 'soon'", "point 0"),
        ("UPDATE header SET value = x'8a' WHERE name = 'points'", "its header"),
    ],
)
def test_stores(tmp_path: Path, statement: str, words: str) -> None:
    path = tmp_path / "a.study"
    path.write_bytes(small_study(tmp_path))
    with sqlite3.connect(path) as database:
        database.execute(statement)
    database.close()
    with pytest.raises(InputError, match=f"is damaged \\({words}\\)"):
        studies.open_study(path)


PARTS: list[tuple[str, Any]] = [
    ("positions", np.zeros((2, 2))),
    ("positions", np.nan),
    ("activations", None),
    ("fibre_forces", np.zeros(1)),
]


@pytest.mark.parametrize("kind", [Posture, Movement])
@pytest.mark.parametrize(("name", "value"), PARTS)
def test_results(tmp_path: Path, kind: type[Posture] | type[Movement], name: str, value: Any) -> None:
    import h5py

    scene = Scene(block((2, 1, 1), muscles={"upper": 2.0}), fixed=["left"])
    path = tmp_path / "a.nc"
    commands = MotorCommands({"upper": 0.9})
    (scene.equilibrate(commands) if kind is Posture else scene.simulate(commands, 0.002)).save(path)
    with h5py.File(path, "a") as file:
        if isinstance(value, float):
            file[name][...] = value
        else:
            del file[name]
            if value is not None:
                file[name] = value
    with pytest.raises(InputError, match=f"is damaged: .*{name}"):
        kind.load(path, scene.speaker)


def test_attributes_of_postures(tmp_path: Path) -> None:
    import h5py

    scene = Scene(block((2, 1, 1), muscles={"upper": 2.0}), fixed=["left"])
    path = tmp_path / "a.nc"
    posture = scene.equilibrate({"upper": 0.9})
    damages = {"commands": "[1", "report": "[]", "wall_displacements": '{"roof": [0, 0, 1]}'}
    for name, text in damages.items():
        posture.save(path)
        with h5py.File(path, "a") as file:
            file.attrs[name] = text
        with pytest.raises(InputError, match="is damaged"):
            Posture.load(path, scene.speaker)
