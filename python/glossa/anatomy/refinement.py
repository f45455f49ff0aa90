"""Refinement: every hexahedron in eight, with node sets, contours and muscles carried along.

New nodes are trilinear: midpoints of edges, centres of faces and of cells. A muscle is a bundle, so its fibres
multiply: besides the old fibres with midpoints inserted, new ones run between neighbouring parallel fibres
(see glossa.anatomy.fibre_refinement).
"""

from __future__ import annotations

import numpy as np

from glossa.anatomy.arrays import IntArray
from glossa.anatomy.fibre_refinement import refined_fibres
from glossa.anatomy.muscle import Muscle
from glossa.anatomy.muscle_topology import largest_fibre_count
from glossa.anatomy.refined_mesh import RefinedMesh
from glossa.anatomy.speaker import Speaker


def refined_speaker(speaker: Speaker) -> Speaker:
    """The speaker with every hexahedron divided in eight.

    Old nodes, outside points among them, keep their numbers. A node set gains the new nodes all of whose parents are
    in it; a contour gains the midpoints of consecutive nodes; muscle elements and contact faces become their children.
    The force capacity is unchanged, and so is the fibre count of the stiffening rule, written out if it was left open.
    Walls and hyoid are carried along.
    """
    mesh = RefinedMesh(speaker.nodes, speaker.hexahedra)
    muscles = {
        name: Muscle(
            mesh.children(muscle.elements),
            refined_fibres(mesh, muscle),
            muscle.force_capacity,
            muscle.fibres_per_element or max(1, largest_fibre_count(speaker.hexahedra, muscle)),
            muscle.peak_multiplier,
        )
        for name, muscle in speaker.muscles.items()
    }
    return Speaker(
        mesh.fine_nodes,
        mesh.fine_hexahedra,
        muscles=muscles,
        node_sets={name: _refined_set(mesh, nodes) for name, nodes in speaker.node_sets.items()},
        walls=speaker.walls,
        hyoid=speaker.hyoid,
        contours={name: mesh.with_midpoints(nodes) for name, nodes in speaker.contours.items()},
        contact_faces={name: mesh.face_children(faces) for name, faces in speaker.contact_faces.items()},
        name=f"{speaker.name}, refined" if speaker.name else "",
    )


def _refined_set(mesh: RefinedMesh, nodes: IntArray) -> IntArray:
    """The set and the new nodes all of whose parents are in it, old ones first and in their order."""
    member = np.zeros(mesh.n_nodes, dtype=bool)
    member[nodes] = True
    new = mesh.n_nodes + np.flatnonzero(mesh.inherited(member)[mesh.n_nodes :])
    return np.concatenate([nodes, new]).astype(np.int32)
