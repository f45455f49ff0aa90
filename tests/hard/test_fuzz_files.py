"""File readers, byte by byte and value by value: a file is read, or refused in glossa's own words.

``GLOSSA_FUZZ=5000 pytest tests/hard -k fuzz`` tries more.
"""

from __future__ import annotations

import json
import sqlite3
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from tests.blocks import block, furnished, hyoid_block, plate
from tests.hard.fuzzing import damaged, damaged_json, fuzz, only_own_errors

from glossa import Movement, Posture, Scene, Speaker, studies
from glossa.acoustics import AreaFunction
from glossa.anatomy.obj_file import read_obj
from glossa.motor.commands import MotorCommands
from glossa.studies import Point

OBJ = b"""# a wall
v 0 0 0
v 0.01 0 0
v 0.01 0.01 0
v 0 0.01 0.001
f 1/1/1 2/2/2 3/3/3
f 1 3 4
"""

LANDMARKS = b"""name = "mine"
[shape]
vault_height = 4.0
arch_width = 0.5
[styloid]
x = 60.0
"""

TRACT = b"# glottis to lips\nlength_cm,area_cm2\n0.4,2.0\n0.5,3.0\n0.4,2.5\n"


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return tmp_path_factory.mktemp("fuzz")


@pytest.fixture(scope="module")
def body() -> Speaker:
    body = hyoid_block(muscles={"upper": 2.0})
    return furnished(body, walls={"floor": plate(-0.001, (-0.01, -0.02), (0.05, 0.02), facing=1)}, hyoid=body.hyoid)


def read(read_file: Callable[[Path], Any], path: Path, content: bytes) -> Any:
    """What a reader makes of content."""
    path.write_bytes(content)
    return only_own_errors(lambda: read_file(path))


def speaker_text(body: Speaker, folder: Path) -> str:
    path = folder / "whole.json"
    if not path.exists():
        body.save(path)
    return path.read_text()


@fuzz
@given(data=st.data())
def test_fuzz_speaker_file(body: Speaker, folder: Path, data: st.DataObject) -> None:
    text = speaker_text(body, folder)
    content = data.draw(st.one_of(damaged(text.encode()), damaged_json(text)))
    read(Speaker.load, folder / "speaker.json", content)


@fuzz
@given(content=damaged(OBJ))
def test_fuzz_obj(folder: Path, content: bytes) -> None:
    read(read_obj, folder / "wall.obj", content)


@fuzz
@given(content=damaged(LANDMARKS))
def test_fuzz_landmarks(folder: Path, content: bytes) -> None:
    from glossa.anatomy.speaker_landmarks import load_landmarks

    read(load_landmarks, folder / "mine.toml", content)


@fuzz
@given(content=damaged(TRACT))
def test_fuzz_area_function(folder: Path, content: bytes) -> None:
    read(AreaFunction.from_csv, folder / "tract.csv", content)


# Two readers of the PB speaker, on a small body in their formats

ANSYS = {
    "tongue.node": "".join(f"{n + 1} {x} {y} {z} 0 0 0\n" for n, (x, y, z) in enumerate(np.ndindex(3, 3, 3))),
    "tongue.elem": "",
    "Fibers.mac": "NB_NODES_FIBER(1,1)=2\nFIBER(1,1,1)=1\nFIBER(2,1,1)=10\n",
    "CreateMuscles.mac": "muscleName(1)='GGA_L'\nESEL,S,ELEM,,1,2,1\nESEL,A,ELEM,,3\nCM,GGA_L,ELEM\n",
    "jawAttachments.txt": "0 1 2\n",
    "hyoidAttachments.txt": "24 25\n",
    "tongueContourNodes.txt": "2 11 20\n",
}


def elements() -> str:
    """Eight cubes, and a shell of the hard palate above them, whose nodes are those of the top."""
    number = np.arange(27).reshape(3, 3, 3) + 1
    rows = []
    for e, (i, j, k) in enumerate(np.ndindex(2, 2, 2), start=1):
        low, high = number[i : i + 2, j : j + 2, k], number[i : i + 2, j : j + 2, k + 1]
        corners = [*low[[0, 1, 1, 0], [0, 0, 1, 1]], *high[[0, 1, 1, 0], [0, 0, 1, 1]]]
        rows.append([*corners, 1, 1, 1, 1, 0, e])
    rows.append([3, 12, 15, 6, 0, 0, 0, 0, 921, 1, 1, 1, 0, 9])
    return "".join(" ".join(map(str, row)) + "\n" for row in rows)


ANSYS["tongue.elem"] = elements()


def ansys_folder(folder: Path) -> Path:
    place = folder / "ansys"
    place.mkdir(exist_ok=True)
    for name, text in ANSYS.items():
        (place / name).write_text(text)
    return place


def test_small_artisynth_speaker_loads(folder: Path) -> None:
    """So that the next test starts from something that loads."""
    speaker = Speaker.from_artisynth(ansys_folder(folder))
    assert len(speaker.hexahedra) == 8
    assert speaker.muscles["GGa"].elements.tolist() == [0, 1, 2]


@fuzz
@given(data=st.data(), name=st.sampled_from(list(ANSYS)))
def test_fuzz_artisynth(folder: Path, data: st.DataObject, name: str) -> None:
    place = ansys_folder(folder)
    (place / name).write_bytes(data.draw(damaged(ANSYS[name].encode())))
    only_own_errors(lambda: Speaker.from_artisynth(place), FileNotFoundError)


def pb_folder(folder: Path) -> Path:
    """The body of the files above in the format of the published PB data."""
    place = folder / "pb"
    place.mkdir(exist_ok=True)
    speaker = Speaker.from_artisynth(ansys_folder(folder))
    muscle = speaker.muscles["GGa"]
    document = {
        "nodes": speaker.nodes.tolist(),
        "hexes": speaker.hexahedra.tolist(),
        "muscles": {"GGa": {"elements": muscle.elements.tolist(), "fibers": [f.tolist() for f in muscle.fibres]}},
        "jaw_fixed": [0, 1, 2],
        "hyoid_fixed": [24, 25],
        "midsagittal": [3, 4, 5],
        "external_points": {},
        "alternative_attachment_sets": {"jaw_other": [0, 1]},
        "dorsum_contour": [2, 11, 20],
        "surface_quads": [[0, 9, 12, 3]],
        "contact_surface_quads": {"tongue_contact_hardpalate": []},
        "hyoid_springs": [{"a": [0, 0, 0], "b": [0.1, 0, 0], "name": "x", "side": "l", "rest_length_m": 0.1}],
        "hyoid": {"volume_m3": 1e-6, "com": [0.0, 0.0, 0.0]},
    }
    (place / "pb_tongue.json").write_text(json.dumps(document))
    for name in ("hyoid", "hard_palate_upper_teeth", "soft_palate_pharynx", "mandible_lower_teeth"):
        (place / f"{name}.obj").write_bytes(OBJ)
    return place


def test_small_pb_speaker_loads(folder: Path) -> None:
    assert len(Speaker.load(pb_folder(folder)).hexahedra) == 8


@fuzz
@given(data=st.data())
def test_fuzz_pb(folder: Path, data: st.DataObject) -> None:
    path = pb_folder(folder) / "pb_tongue.json"
    text = path.read_text()
    path.write_bytes(data.draw(st.one_of(damaged_json(text), damaged(text.encode()))))
    only_own_errors(lambda: Speaker.load(path.parent))


# Results and studies


@fuzz
@given(data=st.data())
def test_fuzz_posture_and_movement_files(body: Speaker, folder: Path, data: st.DataObject) -> None:
    files = folder / "posture.nc", folder / "movement.nc"
    if not files[0].exists():
        scene = Scene(body, fixed=["right"])
        scene.equilibrate({"upper": 0.8}).save(files[0])
        scene.simulate(MotorCommands({"upper": 0.9}), 0.01).save(files[1])
    which = data.draw(st.integers(0, 1))
    content = data.draw(damaged(files[which].read_bytes()))
    loader = (Posture.load, Movement.load)[which]
    read(lambda path: loader(path, body), folder / "damaged.nc", content)


ATTRIBUTES = ("commands", "report", "walls", "wall_displacements", "time_s")


@fuzz
@given(
    name=st.sampled_from([*ATTRIBUTES, "positions", "activations", "contact_wall", "hyoid_rotation", "pressure"]),
    text=st.sampled_from(["", "{", "[1", "null", "3", "[]", '{"a": 1}', '"x"', '{"residual": 1}', "NaN"]),
)
def test_fuzz_parts_of_a_posture_file(body: Speaker, folder: Path, name: str, text: str) -> None:
    """A file whose parts are damaged but not the checksums of the format around them."""
    import h5py

    whole, path = folder / "parts.nc", folder / "part.nc"
    if not whole.exists():
        Scene(body, fixed=["right"]).equilibrate({"upper": 0.8}).save(whole)
    path.write_bytes(whole.read_bytes())
    with h5py.File(path, "a") as file:
        if name in ATTRIBUTES:
            file.attrs[name] = text
        elif text in ("", "3", "[]"):
            del file[name]
        else:
            file[name][...] = np.nan if file[name].dtype.kind == "f" else 10**6
    only_own_errors(lambda: Posture.load(path, body))


def small_study(folder: Path) -> bytes:
    path = folder / "whole.study"
    if not path.exists():
        scene = Scene(block((3, 2, 2), muscles={"upper": 2.0}), fixed=["left"])
        studies.run_points(scene, [Point(commands={"upper": x}) for x in (0.9, 0.8)], store=path)
    return path.read_bytes()


@fuzz
@given(data=st.data())
def test_fuzz_study_store(folder: Path, data: st.DataObject) -> None:
    content = data.draw(damaged(small_study(folder)))
    read(studies.open_study, folder / "damaged.study", content)


@fuzz
@given(
    statement=st.sampled_from(
        [
            "UPDATE header SET value = '[]'",
            "UPDATE header SET value = 'x' WHERE name = 'points'",
            "DELETE FROM header",
            "DELETE FROM header WHERE name = 'layout'",
            "DROP TABLE record",
            "DROP TABLE header",
            "UPDATE record SET doubles = x'00'",
            "UPDATE record SET number = 99 WHERE number = 1",
            "UPDATE record SET number = -1 WHERE number = 1",
            "UPDATE record SET seconds = 'soon'",
            "PRAGMA user_version = 77",
            "PRAGMA application_id = 7",
            "ALTER TABLE record RENAME COLUMN doubles TO singles",
        ]
    )
)
def test_fuzz_parts_of_a_study_store(folder: Path, statement: str) -> None:
    path = folder / "part.study"
    path.write_bytes(small_study(folder))
    with sqlite3.connect(path) as database:
        database.execute(statement)
    database.close()
    only_own_errors(lambda: studies.open_study(path))
