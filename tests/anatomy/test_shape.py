"""Shape parameters: what they do to landmarks and to the speaker generated from them."""

from __future__ import annotations

import itertools
import re
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from glossa import VOWELS, InputError, Scene, Speaker, area_function
from glossa.anatomy.landmark_tables import add_to_entry, built_in_tables, entries, weights_shape
from glossa.anatomy.mirror import mirror_pairs
from glossa.anatomy.shape import shape_parameters
from glossa.anatomy.speaker_landmarks import SpeakerLandmarks, load_landmarks
from glossa.tract.midline import rest_midline

PARAMETERS = shape_parameters()
LIMITS = list(itertools.product(PARAMETERS, [0, 1]))
REFUSALS = "too distorted|the tongue at rest overlaps wall|the airway is closed at rest|is folded over itself"
BENT = {"vault_height": 2.0, "pharynx_length": 5.0, "arch_width": 1.0}


def shaped(**values: float) -> SpeakerLandmarks:
    return load_landmarks({"shape": values})


def reference_with(**values: float) -> Speaker:
    return Speaker.reference(1, {"shape": values})


def everything(landmarks: SpeakerLandmarks) -> dict[str, np.ndarray]:
    """Every number of the landmarks by name."""
    found: dict[str, np.ndarray] = {}

    def visit(name: str, value: Any) -> None:
        if isinstance(value, Mapping):
            for key, entry in value.items():
                visit(f"{name}.{key}", entry)
        else:
            found[name] = np.asarray(value, dtype=float)

    visit("tongue", vars(landmarks.tongue))
    visit("walls", vars(landmarks.walls))
    return found


def test_the_file_holds_the_parameters_of_the_recipe() -> None:
    assert {"vault_height", "arch_width", "pharynx_length", "larynx_length", "rear_wall"} <= set(PARAMETERS)
    for parameter in PARAMETERS.values():
        assert parameter.meaning.endswith(".")
        assert parameter.unit in ("mm", "degree", "1")
        assert parameter.limits[0] <= parameter.value <= parameter.limits[1]
        assert any(np.any(weights) for part in (parameter.tongue, parameter.walls) for weights in part.values())
    assert load_landmarks().shape == {name: parameter.value for name, parameter in PARAMETERS.items()}


@pytest.mark.parametrize("name", PARAMETERS)
def test_a_value_adds_itself_times_the_weights(name: str) -> None:
    parameter, rest = PARAMETERS[name], everything(load_landmarks())
    values = [0.25 * (limit - parameter.value) for limit in parameter.limits if limit != parameter.value]
    for value in values:
        moved = everything(shaped(**{name: value}))
        changed = {key for key in rest if not np.array_equal(moved[key], rest[key])}
        wanted: dict[str, np.ndarray] = {}
        for entry, weights in parameter.walls.items():
            keys = [key for key in rest if key.startswith("walls.springs.")] if entry == "hyoid.springs" else []
            wanted |= dict.fromkeys(keys or [f"walls.{entry}"], weights)
        for entry, weights in parameter.tongue.items():
            title, column = entry.split(".")
            end, _, axis = column.rpartition("_")
            if title == "rays" and axis in ("x", "z"):
                key = f"tongue.{end}"
                wanted.setdefault(key, np.zeros((2, len(weights))))["xz".index(axis)] = weights
            else:
                wanted[f"tongue.{'styloid' if title == 'styloid' else column}"] = weights
        assert changed == {key for key, weights in wanted.items() if np.any(weights)}
        for key, weights in wanted.items():
            # The sum is rounded once here and once there: a few units in the last place of numbers up to 200.
            assert moved[key] - rest[key] == pytest.approx(value * weights, abs=2e-13)


def test_parameters_add_up() -> None:
    rest, both = everything(load_landmarks()), everything(shaped(**BENT))
    single = [everything(shaped(**{name: value})) for name, value in BENT.items()]
    for key, values in rest.items():
        total = values + sum(moved[key] - values for moved in single)
        assert both[key] == pytest.approx(total, abs=2e-13)
    assert any(not np.array_equal(both[key], rest[key]) for key in rest)


@pytest.mark.parametrize("part", ["tongue", "walls"])
def test_every_entry_can_carry_weights(part: str) -> None:
    for name in entries(built_in_tables(part)):
        tables, before = built_in_tables(part), built_in_tables(part)
        add_to_entry(tables, name, np.ones(weights_shape(tables, name)))
        title = name.split(".")[0]
        assert tables[title] != before[title]
        add_to_entry(tables, name, -np.ones(weights_shape(tables, name)))
        assert {key: value for key, value in tables.items() if key != title} == {
            key: value for key, value in before.items() if key != title
        }


def test_no_shape_is_the_built_in_speaker_bit_for_bit(reference: Speaker) -> None:
    sources: list[dict[str, Any]] = [{}, {"shape": {}}, {"shape": dict.fromkeys(PARAMETERS, 0)}]
    for landmarks in sources:
        assert Speaker.reference(1, landmarks).fingerprint == reference.fingerprint


@pytest.mark.parametrize("resolution", [2, 3])
def test_refinement_stays_nested(resolution: int) -> None:
    coarse, fine = reference_with(**BENT), Speaker.reference(resolution, {"shape": BENT})
    r = resolution
    lattice = fine.nodes[:-2].reshape(16 * r + 1, 6 * r + 1, 8 * r + 1, 3)
    assert np.array_equal(lattice[::r, ::r, ::r].reshape(-1, 3), coarse.nodes[:-2])
    for name, wall in coarse.walls.items():
        assert np.array_equal(wall.vertices, fine.walls[name].vertices)


def test_mirror_symmetry_stays_exact() -> None:
    speaker = reference_with(**BENT)
    surfaces = [speaker.nodes, *(wall.vertices for wall in speaker.walls.values())]
    assert speaker.hyoid is not None
    assert speaker.hyoid.surface is not None
    for points in (*surfaces, speaker.hyoid.surface.vertices):
        mirror_pairs(points, tolerance=0.0)
    Scene(speaker, mirror=True)


REFUSALS = "is too distorted|the tongue at rest overlaps wall|the airway is closed at rest|is folded over itself"


def at_limit(name: str, side: int) -> Speaker | InputError:
    """The speaker, or why there is none."""
    parameter = PARAMETERS[name]
    try:
        return reference_with(**{name: parameter.limits[side] - parameter.value})
    except InputError as error:
        return error


@pytest.mark.parametrize(("name", "side"), LIMITS)
def test_at_its_limits_a_parameter_gives_a_sound_speaker_or_a_refusal(name: str, side: int) -> None:
    found = at_limit(name, side)
    if isinstance(found, InputError):
        assert re.search(rf"({REFUSALS}).*; change less of: \[shape\] {name} ", str(found))
        return
    quality = found.quality()
    assert quality.jacobian_min >= 0.1
    assert min(quality.clearance.values()) >= -2e-3


@pytest.mark.slow
@pytest.mark.parametrize(("name", "side"), LIMITS)
def test_at_its_limits_a_sound_speaker_finds_schwa(name: str, side: int) -> None:
    found = at_limit(name, side)
    if isinstance(found, Speaker):
        posture = Scene(found, mirror=True).equilibrate(VOWELS["ə"])
        assert posture.report is not None
        assert posture.report.converged


# What they say


def midline(speaker: Speaker, wall: str) -> np.ndarray:
    """(n, 2) x and z, mm, of a wall in the midplane."""
    vertices = speaker.walls[wall].vertices
    return np.asarray(vertices[vertices[:, 1] == 0.0][:, [0, 2]] * 1e3)


def test_a_higher_vault_is_higher_and_its_teeth_stay(reference: Speaker) -> None:
    high = reference_with(vault_height=3.0)
    tops = [midline(speaker, "hard_palate")[:, 1].max() for speaker in (reference, high)]
    assert tops[1] - tops[0] == pytest.approx(3.0, abs=0.1)
    edges = [speaker.walls["hard_palate"].vertices for speaker in (reference, high)]
    for x in (60.0, 75.0, 90.0):
        crests = [edge[np.abs(edge[:, 0] * 1e3 - x) < 1.0, 2].min() * 1e3 for edge in edges]
        assert crests[1] == pytest.approx(crests[0], abs=0.3)
    assert np.array_equal(high.nodes, reference.nodes)
    assert high.name == "changed reference, resolution 1"


def test_a_wider_arch_is_wider(reference: Speaker) -> None:
    wide = reference_with(arch_width=1.5)
    widths = []
    for speaker in (reference, wide):
        palate = speaker.walls["hard_palate"].vertices * 1e3
        widths.append(np.ptp(palate[np.abs(palate[:, 0] - 85.0) < 5.0, 1]))
    assert widths[1] - widths[0] == pytest.approx(3.0, abs=0.2)  # two sides
    assert np.array_equal(wide.nodes, reference.nodes)
    room = [speaker.quality().clearance["hard_palate"] for speaker in (reference, wide)]
    assert room[1] > room[0] + 0.3e-3


def test_a_longer_pharynx_lowers_root_hyoid_and_larynx(reference: Speaker) -> None:
    deep = reference_with(pharynx_length=5.0)
    assert reference.hyoid is not None
    assert deep.hyoid is not None
    assert (deep.hyoid.centre - reference.hyoid.centre) * 1e3 == pytest.approx([0.0, 0.0, -5.0], abs=0.01)
    assert deep.hyoid.mass == pytest.approx(reference.hyoid.mass, rel=1e-3)
    for old, new in zip(reference.hyoid.springs, deep.hyoid.springs, strict=True):
        assert new.rest_length == pytest.approx(old.rest_length, rel=1e-9)
    lowest = [midline(speaker, "larynx")[:, 1].min() for speaker in (reference, deep)]
    assert lowest[0] - lowest[1] == pytest.approx(5.0, abs=0.01)
    fall = (reference.nodes - deep.nodes)[:, 2] * 1e3
    assert fall.min() == pytest.approx(0.0, abs=0.05)
    for point, least, most in (("dorsum", -0.01, 0.01), ("rear", 0.5, 3.0), ("vallecula", 3.5, 5.0)):
        assert least <= fall[reference.node_sets[point][0]] <= most
    # the velum's spline gives way by less than a micrometre
    assert midline(deep, "hard_palate") == pytest.approx(midline(reference, "hard_palate"), abs=1e-3)


def test_a_longer_pharynx_is_a_longer_tract(reference: Speaker) -> None:
    """By as much, measured along the middle of the airway at rest; its lower part stands nearly upright."""
    lines = [rest_midline(speaker) for speaker in (reference, reference_with(pharynx_length=5.0))]
    lengths = [np.linalg.norm(np.diff(line, axis=0), axis=1).sum() * 1e3 for line in lines]
    assert lengths[1] - lengths[0] == pytest.approx(5.0, abs=0.5)


def test_a_longer_larynx_lowers_the_glottis_alone(reference: Speaker) -> None:
    deep = reference_with(larynx_length=4.0)
    lowest = [midline(speaker, "larynx")[:, 1].min() for speaker in (reference, deep)]
    assert lowest[0] - lowest[1] == pytest.approx(4.0, abs=0.01)
    assert np.array_equal(deep.nodes, reference.nodes)
    assert deep.hyoid is not None
    assert reference.hyoid is not None
    assert np.array_equal(deep.hyoid.centre, reference.hyoid.centre)


def test_a_rear_wall_further_back_widens_the_pharynx(reference: Speaker) -> None:
    places = [midline(speaker, "pharynx") for speaker in (reference, reference_with(rear_wall=2.0))]
    back = [np.interp(80.0, line[::-1, 1], line[::-1, 0]) for line in places]
    assert back[1] - back[0] == pytest.approx(2.0, abs=0.1)


@pytest.mark.slow
def test_a_changed_speaker_says_i(reference: Speaker) -> None:
    """It equilibrates in contact with its palate, and the longer tract lowers the formants."""
    long = reference_with(pharynx_length=5.0, vault_height=1.0)
    tracts = []
    for speaker in (reference, long):
        posture = Scene(speaker, mirror=True).equilibrate(VOWELS["i"])
        assert posture.report is not None
        assert posture.report.converged
        assert posture.contact is not None
        assert posture.contact.touched_areas["hard_palate"] > 0.0
        tracts.append(area_function(posture, lips="i"))
    assert tracts[1].length > tracts[0].length + 3e-3
    second = [tract.formants(2).frequencies[1] for tract in tracts]
    assert second[1] < second[0]


# Refusals of the file

FILE = """
format = "glossa-shape"
version = 1
name = "test"
[lower_lip]
meaning = "A test."
unit = "mm"
limits = [-4, 8]
value = 0.5
[lower_lip.tongue]
"styloid.point" = [0, 1, 0]
[lower_lip.walls]
"larynx_front.x" = [LARYNX]
"hyoid.springs" = [[0, 0, -1], [0, 0, -1]]
"""


def shape_file(folder: Path, old: str = "", new: str = "") -> Path:
    rows = weights_shape(built_in_tables("walls"), "larynx_front.x")[0]
    assert old in FILE
    path = folder / "shape.toml"
    path.write_text(FILE.replace(old, new, 1).replace("LARYNX", ", ".join(["0.5"] * rows)), encoding="utf-8")
    return path


def test_a_shape_file_as_read(tmp_path: Path) -> None:
    (parameter,) = shape_parameters(shape_file(tmp_path)).values()
    assert (parameter.name, parameter.limits, parameter.value) == ("lower_lip", (-4.0, 8.0), 0.5)
    assert parameter.tongue["styloid.point"].tolist() == [0.0, 1.0, 0.0]
    assert parameter.walls["hyoid.springs"].shape == (2, 3)


@pytest.mark.parametrize(
    ("old", "new", "message"),
    [
        ('"glossa-shape"', '"shape"', "format must be 'glossa-shape', got 'shape'"),
        ("version = 1", "version = 2", "version must be 1, got 2"),
        ("[lower_lip]", "[lower_lip", "Expected"),
        ("larynx_front.x", "larynx_front.y", "lower_lip: walls: unknown entry 'larynx_front.y'; known are outer.x"),
        ("larynx_front.x", "mandible.end", "lower_lip: walls: unknown entry 'mandible.end'"),
        ("styloid.point", "rays.inner", "lower_lip: tongue: unknown entry 'rays.inner'; known are rays.inner_x"),
        ("[LARYNX]", "[0, LARYNX]", r"lower_lip: walls: larynx_front.x must .* shape \(\d+,\), got shape \(\d+,\)"),
        ("[0, 1, 0]", "[0, nan, 0]", "lower_lip: tongue: styloid.point must hold finite numbers"),
        ("[0, 1, 0]", '[0, "a", 0]', "lower_lip: tongue: styloid.point must hold numbers"),
        ("[[0, 0, -1], [0, 0, -1]]", "[0, 0, -1]", r"hyoid.springs .* shape \(2, 3\), got shape \(3,\)"),
        ("[lower_lip.walls]", "[lower_lip.palate]", "lower_lip: unknown entry 'palate'; known are meaning, unit"),
        ("[lower_lip.tongue]", "tongue = 3\n[other]", "lower_lip: tongue must be a table, got 3"),
        ("limits = [-4, 8]", "limits = 4", r"lower_lip: limits must be \[least, largest\], got 4"),
        ("limits = [-4, 8]", "limits = [1, 8]", "lower_lip: limits must be ascending and hold the value 0.5"),
        ('"A test."', "3", "lower_lip: meaning must be a text, got 3"),
        ("value = 0.5", 'value = "much"', "lower_lip: value must be a number, got 'much'"),
        ('name = "test"', "width = 3", "width: a shape parameter must be a table, got 3"),
    ],
)
def test_bad_shape_files(tmp_path: Path, old: str, new: str, message: str) -> None:
    path = shape_file(tmp_path, old, new)
    with pytest.raises(InputError, match=message) as raised:
        shape_parameters(path)
    assert str(path) in str(raised.value)


def test_no_shape_file(tmp_path: Path) -> None:
    with pytest.raises(InputError, match=r"cannot read the landmarks .*none\.toml: No such file"):
        shape_parameters(tmp_path / "none.toml")
