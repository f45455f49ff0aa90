"""The built-in speaker: generated from the landmark table, at any resolution."""

from __future__ import annotations

import numpy as np

from glossa.anatomy.arrays import IntArray
from glossa.anatomy.generated_checks import check_mesh, check_rest
from glossa.anatomy.paper_table import force_capacities
from glossa.anatomy.reference_block import Block
from glossa.anatomy.reference_contact import reference_contact_faces
from glossa.anatomy.reference_hyoid import reference_hyoid
from glossa.anatomy.reference_muscles import mylohyoid_line, reference_muscles
from glossa.anatomy.reference_walls import reference_walls
from glossa.anatomy.speaker import Speaker
from glossa.anatomy.speaker_landmarks import SpeakerLandmarks, load_landmarks

#: single midsagittal points by name: ray i, layer j
_POINTS = {
    "tip": (0, 3),
    "upper_tip": (0, 6),
    "lower_tip": (0, 0),
    "blade": (3, 6),
    "dorsum": (6, 6),
    "rear": (11, 6),
    "vallecula": (14, 6),
    "frenulum": (3, 0),
}


def reference_speaker(resolution: int = 1, landmarks: SpeakerLandmarks | None = None) -> Speaker:
    """The built-in anatomy of a typical adult male.

    One block of 16 x 6 x 8 cells whose inner edge is the symphysis, each cell divided into r x r x r; exactly nested
    (nodes of resolution 1 are reproduced bit for bit) and exactly mirror symmetric. The two styloid points are the
    last two nodes. Muscles are families of grid lines that multiply with the resolution, four fibres per interior cell.
    Walls (hard_palate, soft_palate, pharynx, larynx, mandible) and hyoid do not depend on the resolution.

    Args:
        resolution: r >= 1.
        landmarks: of tongue, walls and hyoid; None takes the built-in ones.

    Raises:
        InputError: resolution not a whole number of at least 1, or landmarks that give no sound speaker: elements too
            distorted, a tongue that overlaps walls, a closed airway, or folded walls.
    """
    block = Block(resolution)
    landmarks = load_landmarks() if landmarks is None else landmarks
    hexahedra = block.hexahedra()
    nodes = np.concatenate([block.nodes(landmarks.tongue), landmarks.tongue.styloid_points])
    check_mesh(block, nodes, hexahedra, landmarks)
    node_sets = _node_sets(block)
    speaker = Speaker(
        nodes,
        hexahedra,
        muscles=reference_muscles(block, hexahedra, force_capacities(), landmarks.tongue.peak_multiplier),
        node_sets=node_sets,
        walls=reference_walls(landmarks.walls),
        hyoid=reference_hyoid(landmarks.walls),
        contours=_contours(block),
        name=f"{landmarks.name}, resolution {block.resolution}",
        contact_faces=reference_contact_faces(block, node_sets),
    )
    if landmarks.changes:
        check_rest(speaker, landmarks)
    return speaker


def block_resolution(speaker: Speaker) -> int:
    """Resolution of a speaker made here; of any other one that means nothing."""
    return int(np.rint(np.cbrt(len(speaker.hexahedra) / len(Block(1).hexahedra()))))


def built_in_resolution(speaker: Speaker) -> int | None:
    """Resolution of a speaker that is the built-in one with its own landmarks; None of any other."""
    resolution = block_resolution(speaker)
    if not resolution or len(speaker.hexahedra) != resolution**3 * len(Block(1).hexahedra()):
        return None
    return resolution if reference_speaker(resolution).fingerprint == speaker.fingerprint else None


def _node_sets(b: Block) -> dict[str, IntArray]:
    """Attachments, lines and single points."""
    r = b.resolution
    across = b.span(-4, 4)
    symphysis = b.node_grid(b.span(4, 16), b.span(0, 0), across)
    line = mylohyoid_line(b)
    hyoid = np.union1d(
        b.node_grid(b.span(15, 16), b.span(6, 6), across), b.node_grid(b.span(16, 16), b.span(5, 6), across)
    )
    sets = {
        "jaw": np.union1d(symphysis, line),
        "hyoid": hyoid,
        "symphysis": symphysis,
        "mylohyoid_line": line,
        "midsagittal": b.node_grid(b.span(0, 16), b.span(0, 6), b.span(0, 0)),
        "tip_face": b.node_grid(b.span(0, 0), b.span(0, 6), across),
        "styloid": np.array([b.n_nodes, b.n_nodes + 1]),
    }
    points = {name: np.array([b.node(i * r, j * r, 0)]) for name, (i, j) in _POINTS.items()}
    return {name: nodes.astype(np.int32) for name, nodes in (sets | points).items()}


def _contours(b: Block) -> dict[str, IntArray]:
    """Midsagittal outlines, front to back: dorsum from the lower tip to the hyoid, underside, mouth floor."""
    r = b.resolution
    lines = {
        "dorsum": b.path((0, 0, 0), (0, 6 * r, 0), (16 * r, 6 * r, 0)),
        "underside": b.path((0, 0, 0), (4 * r, 0, 0)),
        "floor": b.path((16 * r, 0, 0), (16 * r, 6 * r, 0)),
    }
    return {name: np.array(nodes, dtype=np.int32) for name, nodes in lines.items()}
