"""The six nodes of fig. 11 on both speakers, and where there are none."""

from __future__ import annotations

import numpy as np
import pytest
from tests.blocks import block

from glossa import InputError, Speaker, paper
from glossa.studies import MIDSAGITTAL_NODES, midsagittal_nodes, tracked_nodes


def check(speaker: Speaker) -> None:
    found = midsagittal_nodes(speaker)
    assert tuple(found) == MIDSAGITTAL_NODES
    assert found["apical"] == tracked_nodes(speaker)["tip"]
    places = speaker.nodes[list(found.values())]
    assert places[:, 1] == pytest.approx(0.0)
    assert (np.diff(places[:, 0])[:4] > 0.0).all()  # from front to back as far as the upper pharynx
    assert places[:, 2].argmax() == 2  # the palatal one is on top
    contour = speaker.nodes[speaker.contours["dorsum"]]
    rear = contour[contour[:, 0].argmax()]
    assert places[5] == pytest.approx(rear)
    steps = np.linalg.norm(np.diff(places, axis=0), axis=1)
    assert steps.max() < 2.5 * steps.min()


def test_on_the_built_in_speaker(reference: Speaker) -> None:
    check(reference)


def test_on_pb(pb: Speaker) -> None:
    check(pb)


def test_hardly_another_place_at_a_finer_resolution(reference: Speaker) -> None:
    fine = Speaker.reference(2)
    coarse_places = reference.nodes[list(midsagittal_nodes(reference).values())]
    fine_places = fine.nodes[list(midsagittal_nodes(fine).values())]
    assert np.linalg.norm(fine_places - coarse_places, axis=1).max() < 5e-3  # half a cell


def test_names_are_those_of_the_papers_ellipses() -> None:
    assert tuple(paper.dispersion().index) == MIDSAGITTAL_NODES


def test_speakers_without_a_contour_or_with_few_nodes_are_refused(reference: Speaker) -> None:
    with pytest.raises(InputError, match="contour 'dorsum'"):
        midsagittal_nodes(block())
    short = Speaker(
        reference.nodes,
        reference.hexahedra,
        muscles=reference.muscles,
        node_sets=reference.node_sets,
        contours={"dorsum": reference.contours["dorsum"][[3, 11, 14, 18]]},
    )
    with pytest.raises(InputError, match="4 nodes from tip to rear, too few"):
        midsagittal_nodes(short)
