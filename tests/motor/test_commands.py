import copy
import pickle
from collections.abc import Mapping
from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from glossa.errors import InputError
from glossa.motor import MUSCLES, VOWELS, MotorCommands

fractions = st.dictionaries(st.sampled_from(MUSCLES), st.floats(0.3, 2.0), max_size=11)


@given(fractions)
def test_behaves_as_the_mapping_it_was_made_from(given_fractions: dict[str, float]) -> None:
    commands = MotorCommands(given_fractions)
    assert isinstance(commands, Mapping)
    assert dict(commands) == given_fractions
    assert list(commands) == list(given_fractions)
    assert len(commands) == len(given_fractions)


@given(fractions)
def test_equal_and_hashed_by_content_whatever_the_order(given_fractions: dict[str, float]) -> None:
    forwards = MotorCommands(given_fractions)
    backwards = MotorCommands(dict(reversed(given_fractions.items())))
    assert forwards == backwards
    assert hash(forwards) == hash(backwards)
    assert forwards != MotorCommands({**given_fractions, "GGp": 0.1})


@given(fractions)
def test_copies_pickles_and_repr_give_the_same_commands(given_fractions: dict[str, float]) -> None:
    commands = MotorCommands(given_fractions)
    assert pickle.loads(pickle.dumps(commands)) == commands
    assert copy.deepcopy(commands) == commands
    assert eval(repr(commands), {"MotorCommands": MotorCommands}) == commands


def test_is_not_equal_to_a_plain_dict() -> None:
    assert MotorCommands({"GGp": 0.6}) != {"GGp": 0.6}


def test_cannot_be_changed_and_does_not_follow_its_source() -> None:
    source = {"GGp": 0.6}
    commands = MotorCommands(source)
    source["GGp"] = 0.9
    assert commands["GGp"] == 0.6
    with pytest.raises(AttributeError, match="with_"):
        commands.other = 1
    with pytest.raises(TypeError):
        commands["GGp"] = 0.5  # type: ignore[index]


def test_with_replaces_and_adds_in_a_copy() -> None:
    commands = MotorCommands({"GGp": 0.6})
    assert commands.with_(GGp=0.62, MH=0.8) == MotorCommands({"GGp": 0.62, "MH": 0.8})
    assert commands.with_({"left masseter": 0.7}) == MotorCommands({"GGp": 0.6, "left masseter": 0.7})
    assert commands == MotorCommands({"GGp": 0.6})


def test_scaled_multiplies_one_command() -> None:
    commands = VOWELS["i"].scaled("Sty", 1.05)
    assert commands["Sty"] == 0.90 * 1.05
    assert commands.with_(Sty=0.90) == VOWELS["i"]


def test_takes_numpy_numbers_and_integers() -> None:
    single: Any = np.float32(0.5)
    commands = MotorCommands({"GGp": np.float64(0.6), "MH": 1, "GH": single})
    assert all(type(value) is float for value in commands.values())


@pytest.mark.parametrize(
    ("value", "message"),
    [
        (float("nan"), "'GGp' must be finite, got nan"),
        (float("inf"), "'GGp' must be finite, got inf"),
        (0.0, "'GGp' must be positive, got 0.0"),
        (-0.6, "'GGp' must be positive, got -0.6"),
        ("0.6", "'GGp' must be a number, got '0.6'"),
        (None, "'GGp' must be a number, got None"),
        (True, "'GGp' must be a number, got True"),
        (1j, "'GGp' must be a number, got 1j"),
        (np.array([0.6, 0.7]), "'GGp' must be a number"),
    ],
)
def test_refuses_what_is_no_fraction(value: Any, message: str) -> None:
    with pytest.raises(InputError, match=message):
        MotorCommands({"GGp": value})
    with pytest.raises(InputError, match=message):
        MotorCommands({}).with_(GGp=value)


@pytest.mark.parametrize("value", [[0.6], np.ones(11), 0.6, None, "GGp"])
def test_refuses_what_is_no_mapping(value: Any) -> None:
    with pytest.raises(InputError, match="must map muscle names to fractions"):
        MotorCommands(value)


def test_with_refuses_what_is_no_mapping() -> None:
    with pytest.raises(InputError, match="must map muscle names to fractions"):
        MotorCommands({}).with_([("GGp", 0.6)])  # type: ignore[arg-type]


@pytest.mark.parametrize("name", ["", 3, None])
def test_refuses_what_is_no_name(name: Any) -> None:
    with pytest.raises(InputError, match="muscle names must be non-empty strings"):
        MotorCommands({name: 0.6})


def test_scaled_refuses_unknown_muscles_and_useless_factors() -> None:
    commands = MotorCommands({"GGp": 0.6})
    with pytest.raises(InputError, match="no command for muscle 'MH' to scale; commands: GGp"):
        commands.scaled("MH", 1.05)
    with pytest.raises(InputError, match="scale factor of 'GGp' must be positive"):
        commands.scaled("GGp", 0.0)
    with pytest.raises(InputError, match="scale factor of 'GGp' must be finite"):
        commands.scaled("GGp", float("nan"))


def test_vowels_are_those_of_table_3() -> None:
    assert set(VOWELS) == {"i", "ə", "u", "a"}
    assert all(tuple(commands) == MUSCLES for commands in VOWELS.values())
    assert VOWELS["i"]["GGp"] == 0.60
    assert VOWELS["a"]["HG"] == 0.70
    assert VOWELS["u"]["Vert"] == 1.35
    assert VOWELS["ə"]["MH"] == 0.94
