"""Reader of the published PB speaker: a folder with pb_tongue.json and four OBJ surfaces, in SI units.

The data come from the open ArtiSynth Models collection; cite Stavness, Lloyd, Payan & Fels 2011 (IJNMBE 27:367) and
Buchaillard, Perrier & Payan 2009.
"""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import numpy as np

from glossa.anatomy.arrays import FloatArray, IntArray, int_array
from glossa.anatomy.muscle import Muscle
from glossa.anatomy.obj_file import read_obj
from glossa.anatomy.paper_table import force_capacities
from glossa.anatomy.speaker import Speaker
from glossa.anatomy.walls import Hyoid, Spring, Wall
from glossa.errors import InputError, SpeakerFileError

HYOID_DENSITY = 2000.0  # kg/m3, Buchaillard et al. 2009, section II.B
HYOID_SPRING_STIFFNESS = 220.0  # N/m, Buchaillard et al. 2009, section II.B
WALL_FILES = {
    "hard_palate": "hard_palate_upper_teeth.obj",
    "soft_palate": "soft_palate_pharynx.obj",
    "mandible": "mandible_lower_teeth.obj",
}
CONTACT_ZONES = {  # wall: entry of contact_surface_quads
    "hard_palate": "tongue_contact_hardpalate",
    "soft_palate": "tongue_contact_softpalate",
    "mandible": "tongue_contact_mandible",
}


def load_pb(folder: Path) -> Speaker:
    """The PB speaker from its folder.

    Node sets: "jaw" (the published jaw_fixed), "hyoid" (hyoid_fixed), "midsagittal", "styloid", every alternative
    attachment set under its own name, and the single nodes "tip", "dorsum" and "rear" of the dorsum contour.
    Contour "dorsum": 27 midline nodes, front to back. Contact faces: the published zones of the three walls, where the
    file has them.

    Raises:
        FileNotFoundError: the folder lacks one of its files.
        SpeakerFileError: a file that cannot be read or is inconsistent.
    """
    path = folder / "pb_tongue.json"
    if not path.is_file():
        raise FileNotFoundError(f"{folder} is not a speaker folder: it holds no pb_tongue.json")
    try:
        data = json.loads(path.read_text(encoding="utf-8"))
    except (ValueError, RecursionError) as error:
        raise SpeakerFileError(f"{path}: not a complete JSON file ({error})") from None
    bone = read_obj(folder / "hyoid.obj")
    try:
        return Speaker(
            data["nodes"],
            data["hexes"],
            muscles=_muscles(data["muscles"]),
            node_sets=_node_sets(data),
            walls={name: read_obj(folder / file) for name, file in WALL_FILES.items()},
            hyoid=_hyoid(data, bone),
            contours={"dorsum": data["dorsum_contour"]},
            name="PB",
            contact_faces=_contact_faces(data),
        )
    except SpeakerFileError:
        raise
    except InputError as error:
        raise SpeakerFileError(f"{path}: {error}") from None
    except (KeyError, TypeError, ValueError, AttributeError, IndexError, OverflowError) as error:
        raise SpeakerFileError(f"{path}: missing or malformed entry ({error})") from None


def _muscles(data: dict[str, Any]) -> dict[str, Muscle]:
    rho = force_capacities()
    return {name: Muscle(entry["elements"], entry["fibers"], rho[name]) for name, entry in data.items()}


def _node_sets(data: dict[str, Any]) -> dict[str, IntArray]:
    sets = {
        "jaw": data["jaw_fixed"],
        "hyoid": data["hyoid_fixed"],
        "midsagittal": data["midsagittal"],
        "styloid": sorted(data["external_points"].values()),
        **data["alternative_attachment_sets"],
        **contour_points(np.asarray(data["nodes"], dtype=float), np.asarray(data["dorsum_contour"], dtype=np.int32)),
    }
    return {name: np.asarray(nodes, dtype=np.int32) for name, nodes in sets.items()}


def _contact_faces(data: dict[str, Any]) -> dict[str, IntArray]:
    zones = data.get("contact_surface_quads", {})
    quads = np.asarray(data["surface_quads"], dtype=np.int32) if zones else None
    result = {}
    for wall, key in CONTACT_ZONES.items():
        if quads is None or key not in zones:
            continue
        numbers = int_array(zones[key], f"contact_surface_quads: {key}")
        if len(numbers) and numbers.max() >= len(quads):
            raise InputError(f"contact_surface_quads: {key} names face {numbers.max()} of {len(quads)} surface_quads")
        result[wall] = quads[numbers]
    return result


def contour_points(nodes: FloatArray, dorsum: IntArray) -> dict[str, IntArray]:
    """Single nodes of the dorsum contour as node sets: "tip" (foremost), "dorsum" (highest), "rear" (rearmost)."""
    x, _, z = nodes[dorsum].T
    chosen = {"tip": x.argmin(), "dorsum": z.argmax(), "rear": x.argmax()}
    return {name: dorsum[[position]] for name, position in chosen.items()}


def _hyoid(data: dict[str, Any], bone: Wall) -> Hyoid:
    springs = tuple(
        hyoid_spring(bone, entry["a"], entry["b"], f"{entry['name']} {entry['side']}", entry["rest_length_m"])
        for entry in data["hyoid_springs"]
    )
    return Hyoid(bone, data["hyoid"]["volume_m3"] * HYOID_DENSITY, data["hyoid"]["com"], springs)


def hyoid_spring(bone: Wall, a: Any, b: Any, name: str, rest_length: float | None = None) -> Spring:
    """A spring between ``a`` and ``b`` (3,) m; the end nearer to the bone's surface is the one that moves with it."""
    ends = [np.asarray(end, dtype=float) for end in (a, b)]
    distances = [np.linalg.norm(bone.vertices - end, axis=1).min() for end in ends]
    moving = int(np.argmin(distances))
    return Spring(ends[moving], ends[1 - moving], HYOID_SPRING_STIFFNESS, rest_length, name)
