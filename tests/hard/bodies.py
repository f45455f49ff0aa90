"""Bodies that make solves hard: tissue of several stiffnesses, flat elements, slender columns, walls with edges."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from tests.blocks import face_sets, furnished, lattice, plate, sheet

from glossa import Muscle, Speaker


def layered_bar(layers: Sequence[str], size: Sequence[float] = (0.04, 0.01, 0.01), across: int = 2) -> Speaker:
    """A bar along x with one layer of elements for each entry of ``layers``.

    Elements of a layer called "" are passive; those of others are stiffened by a muscle of that name, whose fibres are
    the layer's edges along x and which pulls with a nanonewton. The node set "at <name>" holds a muscle's nodes.
    """
    nodes, hexahedra, number = lattice((len(layers), across, across))
    nodes = nodes * np.asarray(size)
    layer = np.repeat(np.arange(len(layers)), across * across)
    sets, muscles = face_sets(number), {}
    for name in dict.fromkeys(filter(None, layers)):
        which = [k for k, other in enumerate(layers) if other == name]
        lines = [number[k : k + 2, i, j] for k in which for i in range(across + 1) for j in range(across + 1)]
        muscles[name] = Muscle(np.flatnonzero(np.isin(layer, which)), lines, 1e-9)
        sets[f"at {name}"] = np.unique(np.concatenate(lines)).astype(np.int32)
    return Speaker(nodes, hexahedra, muscles=muscles, node_sets=sets, name="layered bar")


def with_flat_element(speaker: Speaker, thickness: float) -> Speaker:
    """A block whose middle element is squeezed along x to this share of its thickness; its neighbours give way."""
    nodes = np.array(speaker.nodes)
    middle = speaker.hexahedra[len(speaker.hexahedra) // 2]
    x = nodes[middle, 0]
    near, far = x.min(), x.max()
    nodes[middle[x == near], 0] = far - thickness * (far - near)
    return Speaker(
        nodes, speaker.hexahedra, muscles=dict(speaker.muscles), node_sets=dict(speaker.node_sets), name="flat element"
    )


def column(slenderness: float, cells: Sequence[int] = (12, 2, 2)) -> Speaker:
    """A column along x, symmetric about y = 0, that gives way sideways (along y) first."""
    nodes, hexahedra, number = lattice(cells)
    height = 0.06
    size = np.array([height, height / slenderness, 1.5 * height / slenderness])
    nodes = (nodes - np.array([0.0, 0.5, 0.0])) * size
    return Speaker(nodes, hexahedra, node_sets=face_sets(number, sides=False), name="column")


def over_tooth(speaker: Speaker, angle: float, *, x: float, clearance: float) -> Speaker:
    """A block above the edge of a wedge (``angle`` in degrees) that runs along y at ``x``, ``clearance`` below, m."""
    slope = 1.0 / np.tan(np.radians(0.5 * angle))
    half = 0.02 / slope
    low, high = speaker.nodes.min(axis=0), speaker.nodes.max(axis=0)
    top = low[2] - clearance
    wall = sheet(
        lambda at, _: top - slope * np.abs(at - x), (x - half, low[1] - 0.02), (x + half, high[1] + 0.02), (2, 1)
    )
    return furnished(speaker, walls={"tooth": wall})


def in_slot(speaker: Speaker, gap: float, *, beyond: float) -> Speaker:
    """A block whose end (x > ``beyond``) lies between two horizontal plates, ``gap`` away from each (m)."""
    low, high = speaker.nodes.min(axis=0), speaker.nodes.max(axis=0)
    corners = (beyond, low[1] - 0.02), (high[0] + 0.02, high[1] + 0.02)
    return furnished(
        speaker,
        walls={
            "roof": plate(high[2] + gap, *corners, facing=-1),
            "floor": plate(low[2] - gap, *corners, facing=1),
        },
    )


def over_floor(speaker: Speaker, clearance: float) -> Speaker:
    """A block above a horizontal floor that reaches 0.02 m beyond it on all sides."""
    low, high = speaker.nodes.min(axis=0), speaker.nodes.max(axis=0)
    floor = plate(low[2] - clearance, low[:2] - 0.02, high[:2] + 0.02, facing=1)
    return furnished(speaker, walls={"floor": floor})
