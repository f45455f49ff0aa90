import pickle
from typing import Any

import numpy as np
import pytest
from hypothesis import assume, given
from hypothesis import strategies as st

from glossa.errors import InputError
from glossa.motor import VOWELS, MotorCommands, Ramp, Schedule

LOW = MotorCommands({"GGp": 0.6, "MH": 0.8})
HIGH = MotorCommands({"MH": 1.2, "GGp": 1.0})
times = st.floats(0.0, 2.0)
values = st.floats(0.3, 2.0)


@st.composite
def schedules(draw: st.DrawFn) -> Schedule:
    corners = sorted(draw(st.lists(st.integers(0, 2000), min_size=1, max_size=6, unique=True)))
    commands = [MotorCommands({"GGp": draw(values), "MH": draw(values)}) for _ in corners]
    return Schedule([corner / 1000 for corner in corners], commands)


@given(schedules(), times)
def test_agrees_with_linear_interpolation(schedule: Schedule, time: float) -> None:
    corner_times, fractions = schedule.table
    commands = schedule.at(time)
    for column, muscle in enumerate(schedule.muscles):
        expected = np.interp(time, corner_times, fractions[:, column])
        assert commands[muscle] == pytest.approx(expected, rel=1e-12)  # one multiplication and addition


@given(schedules(), st.floats(0.0, 1.0), st.data())
def test_is_linear_between_corners(schedule: Schedule, share: float, data: st.DataObject) -> None:
    corner_times, fractions = schedule.table
    assume(len(corner_times) > 1)
    k = data.draw(st.integers(0, len(corner_times) - 2))
    time = (1 - share) * corner_times[k] + share * corner_times[k + 1]
    expected = (1 - share) * fractions[k] + share * fractions[k + 1]
    # The time is rounded: its error over the shortest piece, 1 ms, times the largest change, 1.7, is below 1e-12.
    assert [schedule.at(time)[muscle] for muscle in schedule.muscles] == pytest.approx(expected, abs=1e-11)


@given(schedules())
def test_is_exact_at_corners_and_constant_outside(schedule: Schedule) -> None:
    corner_times, fractions = schedule.table
    for time, row in zip(corner_times, fractions, strict=True):
        assert list(schedule.at(float(time)).values()) == row.tolist()
    assert schedule.at(-1.0) == schedule.at(float(corner_times[0]))
    assert schedule.at(9.0) == schedule.at(float(corner_times[-1]))


def test_a_jump_takes_the_later_commands_from_its_time_on() -> None:
    schedule = Schedule([0.0, 0.1, 0.1, 0.2], [LOW, LOW, HIGH, HIGH])
    assert schedule.at(0.1) == HIGH
    assert schedule.at(np.nextafter(0.1, 0.0)) == LOW
    assert schedule.corners.tolist() == [0.0, 0.1, 0.2]
    assert schedule.table[0].tolist() == [0.0, 0.1, 0.1, 0.2]


def test_table_follows_the_muscle_order_of_the_first_corner() -> None:
    schedule = Schedule([0.0, 1.0], [LOW, HIGH])
    assert schedule.muscles == ("GGp", "MH")
    assert schedule.table[1].tolist() == [[0.6, 0.8], [1.0, 1.2]]


def test_table_is_read_only_and_a_copy() -> None:
    given_times = np.array([0.0, 1.0])
    schedule = Schedule(given_times, [LOW, HIGH])
    given_times[1] = 5.0
    for array in schedule.table:
        with pytest.raises(ValueError, match="read-only"):
            array[0] = 7.0
    assert schedule.corners.tolist() == [0.0, 1.0]


def test_ramp_starts_at_rest_length_and_takes_30_ms() -> None:
    ramp = Ramp(VOWELS["i"])
    assert isinstance(ramp, Schedule)
    assert set(ramp.at(0.0).values()) == {1.0}
    assert ramp.at(0.015)["GGp"] == pytest.approx(0.8, rel=1e-14)
    assert ramp.at(0.030) == VOWELS["i"]
    assert ramp.corners.tolist() == [0.0, 0.030]


def test_ramp_from_a_start_at_an_onset() -> None:
    ramp = Ramp(HIGH, duration=0.2, start=LOW, onset=0.1)
    assert ramp.at(0.05) == LOW
    assert ramp.at(0.2)["GGp"] == pytest.approx(0.8, rel=1e-14)
    assert ramp.at(0.4) == HIGH


def test_ramp_of_no_duration_is_a_jump() -> None:
    ramp = Ramp(HIGH, duration=0.0, start=LOW, onset=0.1)
    assert ramp.at(np.nextafter(0.1, 0.0)) == LOW
    assert ramp.at(0.1) == HIGH
    assert ramp.corners.tolist() == [0.1]


def test_through_holds_each_target_until_the_next_ramp() -> None:
    schedule = Schedule.through([(0.0, VOWELS["i"]), (0.2, VOWELS["a"])], transition=0.030)
    assert schedule.table[0].tolist() == [0.0, 0.030, 0.2, 0.230]
    assert set(schedule.at(0.0).values()) == {1.0}
    assert schedule.at(0.030) == schedule.at(0.2) == VOWELS["i"]
    assert schedule.at(0.1) == pytest.approx(VOWELS["i"], rel=1e-15)
    assert schedule.at(0.3) == VOWELS["a"]


def test_through_joins_ramps_that_touch_up_to_rounding() -> None:
    schedule = Schedule.through([(0.1, LOW), (0.13, HIGH)], transition=0.03, start=HIGH)
    assert 0.1 + 0.03 != 0.13 or len(schedule.corners) == 3
    assert schedule.corners == pytest.approx([0.1, 0.13, 0.16], rel=1e-12)
    assert schedule.at(0.0) == HIGH


def test_through_without_transition_jumps() -> None:
    schedule = Schedule.through([(0.0, LOW), (0.1, HIGH)], transition=0.0)
    assert schedule.table[0].tolist() == [0.0, 0.0, 0.1, 0.1]
    assert schedule.at(0.0) == schedule.at(0.099) == LOW
    assert schedule.at(0.1) == HIGH


def test_one_corner_and_silent_commands_are_schedules() -> None:
    assert Schedule([0.0], [LOW]).at(3.0) == LOW
    silent = Ramp(MotorCommands({}))
    assert silent.table[1].shape == (2, 0)
    assert silent.at(0.01) == MotorCommands({})


@pytest.mark.parametrize("schedule", [Ramp(LOW), Schedule([0.0, 0.0, 1.0], [LOW, HIGH, LOW])])
def test_pickles(schedule: Schedule) -> None:
    copy = pickle.loads(pickle.dumps(schedule))
    assert type(copy) is type(schedule)
    for one, other in zip(copy.table, schedule.table, strict=True):
        assert np.array_equal(one, other)


def test_repr_says_what_it_is() -> None:
    assert repr(Ramp(LOW)) == "<Ramp: 2 corners from 0 s to 0.03 s, muscles GGp, MH>"


@pytest.mark.parametrize(
    ("bad_times", "message"),
    [
        ([], "non-empty list"),
        ([[0.0, 1.0]], "non-empty list, got shape"),
        (0.0, "non-empty list, got shape"),
        ([0.0, float("nan")], "must be finite; time 1 is not"),
        ([float("inf"), 1.0], "must be finite; time 0 is not"),
        ([-0.1, 1.0], "must not be negative, got -0.1 s"),
        ([1.0, 0.5], "must not decrease: 1.0 s, then 0.5 s"),
        ([0.5, 0.5, 0.5], "at most two schedule times may be equal .* three are 0.5 s"),
        (["0", "1"], "must be numbers"),
        ([0.0, [1.0]], "must be a list of numbers"),
        (None, "must be numbers"),
    ],
)
def test_refuses_wrong_times(bad_times: Any, message: str) -> None:
    with pytest.raises(InputError, match=message):
        Schedule(bad_times, [LOW, HIGH])


def test_refuses_another_number_of_commands() -> None:
    with pytest.raises(InputError, match="2 times, 1 commands"):
        Schedule([0.0, 1.0], [LOW])


def test_refuses_commands_for_different_muscles() -> None:
    with pytest.raises(InputError, match="same muscles: 0 and 1 differ in GGp, GH"):
        Schedule([0.0, 1.0], [LOW, MotorCommands({"MH": 1.0, "GH": 1.0})])
    with pytest.raises(InputError, match="differ in MH"):
        Ramp(LOW, start=MotorCommands({"GGp": 1.0}))


def test_refuses_plain_dicts() -> None:
    plain: Any = {"GGp": 0.6}
    with pytest.raises(InputError, match="commands 1 of the schedule must be MotorCommands, got dict"):
        Schedule([0.0, 1.0], [LOW, plain])
    with pytest.raises(InputError, match="target must be MotorCommands, got dict"):
        Ramp(plain)


@pytest.mark.parametrize(
    ("options", "message"),
    [
        ({"duration": -0.01}, "duration must not be negative"),
        ({"duration": float("nan")}, "duration must be finite"),
        ({"duration": "long"}, "duration must be a number"),
        ({"onset": float("inf")}, "onset must be finite"),
        ({"onset": None}, "onset must be a number"),
        ({"onset": -0.1}, "must not be negative"),
    ],
)
def test_ramp_refuses_wrong_times(options: dict[str, Any], message: str) -> None:
    with pytest.raises(InputError, match=message):
        Ramp(LOW, **options)


@pytest.mark.parametrize(
    ("targets", "message"),
    [
        ([], "at least one target"),
        ([(0.0, LOW), (0.02, HIGH)], "starts before the one before it ends"),
        ([(0.0, LOW, 3)], "pair of onset and MotorCommands"),
        ([0.0], "pair of onset and MotorCommands"),
        ([(None, LOW)], "onset must be a number"),
        ([(0.0, LOW), (0.2, {"GGp": 0.6})], "must be MotorCommands, got dict"),
    ],
)
def test_through_refuses_wrong_targets(targets: Any, message: str) -> None:
    with pytest.raises(InputError, match=message):
        Schedule.through(targets)


def test_through_refuses_a_wrong_transition() -> None:
    with pytest.raises(InputError, match="transition must not be negative"):
        Schedule.through([(0.0, LOW)], transition=-0.1)


@pytest.mark.parametrize("time", [float("nan"), "now", None])
def test_at_refuses_what_is_no_time(time: Any) -> None:
    with pytest.raises(InputError, match="time must be"):
        Ramp(LOW).at(time)
