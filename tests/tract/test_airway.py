"""Which channels make up the airway, on drawn profiles of gaps."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from glossa.tract.airway import Channel, Passage, airway, channels, split_at_slits

BARRIER = 0.5e-3


def gaps(*rows: str) -> NDArray[np.float64]:
    """One row for each plane: # open (2 mm), + below the barrier (0.3 mm), . closed."""
    height = {"#": 2e-3, "+": 0.3e-3, ".": -1e-3}
    return np.array([[height[c] for c in row] for row in rows])


def passages(*rows: str) -> list[Passage]:
    return airway(gaps(*rows), 1, BARRIER)


def spans(passage: Passage) -> tuple[list[tuple[int, int]], list[tuple[int, int]]]:
    return tuple([(c.first, c.last) for c in group] for group in (passage.channels, passage.beside))  # type: ignore[return-value]


def test_runs_of_columns() -> None:
    assert channels(np.array([True, False, True, True])) == [Channel(0, 0), Channel(2, 3)]
    assert channels(np.zeros(3, dtype=bool)) == []


def test_one_channel_all_the_way() -> None:
    assert [spans(p) for p in passages("..##..", ".####.", "..##..")] == [
        ([(2, 3)], []),
        ([(1, 4)], []),
        ([(2, 3)], []),
    ]


def test_pockets_that_lead_nowhere_do_not_count() -> None:
    found = passages("##..##..##", "##..##....", "....##..##", "....##....")
    assert [spans(p) for p in found] == [([(4, 5)], [])] * 4


def test_side_channels_along_the_midline_are_beside() -> None:
    found = passages("##########", "##..##..##", "##########")
    assert spans(found[1]) == ([(4, 5)], [(0, 1), (8, 9)])


def test_with_the_midline_closed_every_way_through_counts() -> None:
    found = passages("##########", "###....###", "##########")
    assert spans(found[1]) == ([(0, 2), (7, 9)], [])
    assert all(channel.reached for channel in found[1].channels)


def test_slits_below_the_barrier_do_not_connect() -> None:
    found = passages("...####...", "++.####.++", "#++####++#")
    assert [spans(p) for p in found] == [([(3, 6)], [])] * 3


def test_a_channel_is_parted_at_a_long_slit_between_two_chambers() -> None:
    """Below 1 mm over three columns, off the midline, with room on both sides."""
    row = np.array([2, 2, 0.9, 0.6, 0.8, 2, 3, 3, 2, 0.9, 0.9, 2, 0.7, 0.7, 0.7, 0.7]) * 1e-3
    parted = split_at_slits(row[None], BARRIER, 3)[0]
    assert np.flatnonzero(parted != row).tolist() == [3]
    assert parted[3] == 0.0
    low = np.array([[2, 2, 0.9, 0.9, 0.9, 0.9, 2, 2]]) * 1e-3
    assert (split_at_slits(low, BARRIER, 3) == low).all(), "the midline itself is low"


def test_where_all_is_below_the_barrier_the_slit_in_front_of_the_airway_is_left() -> None:
    found = passages("..####....", "#.++++..##", "..####....")
    (channel,) = found[1].channels
    assert (channel.first, channel.last, channel.reached) == (2, 5, False)
    assert all(c.reached for p in (found[0], found[2]) for c in p.channels)


def test_a_pocket_beside_a_closure_is_not_taken_for_the_airway() -> None:
    """The midline is closed; a pocket that no air reaches from behind is the only gap."""
    found = passages("...####...", "##........", "...####...")
    assert found[1].channels == ()
    assert spans(found[2]) == ([(3, 6)], [])


def test_beyond_a_closure_the_airway_goes_on_nearest_the_midline() -> None:
    found = passages("...####...", "..........", "##..##..##")
    assert found[1].channels == ()
    assert spans(found[2]) == ([(4, 5)], [])


def test_all_closed() -> None:
    assert [p.channels for p in passages("....", "....")] == [(), ()]
