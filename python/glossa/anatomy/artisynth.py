"""Reader of the PB speaker from the files of the public repository artisynth/artisynth_models.

Files of src/artisynth/models/tongue3d/geometry, ANSYS numbering from 1 in the first four:

    tongueIcp.3.node, .elem   node number and x y z in m; eight node numbers, material, type, ..., element number.
                              Materials: 1 tongue, 921 hard palate, 932 soft palate, 933 mandible, 941 hyoid springs,
                              911, 912, 913: faces of the tongue that may touch these walls (some of 912 lie inside
                              the tongue and are left out).
                              tongue.node, tongue.elem hold the tongue alone and serve when these are absent
    Fibers.mac                FIBER(place, fibre, muscle) = node
    CreateMuscles.mac         muscleName(muscle) = 'NAME_SIDE'; ESEL,S|A,ELEM,,first,last,step ... CM,NAME_SIDE,ELEM
    ICPHyoid3.obj             surface of the hyoid; ICPPalate3.obj and ICPJaw3.obj serve when walls are not in .elem
    jawAttachments.txt, hyoidAttachments.txt, tongueContourNodes.txt   node numbers from 0

The attachments closest to the 2009 paper are in the sibling package jawTongue (hyoidAttachmentsStephanie.txt); they are
used when they are there. Cite Stavness, Lloyd, Payan & Fels 2011 (IJNMBE 27:367) and Buchaillard et al. 2009.
"""

from __future__ import annotations

import re
from collections import defaultdict
from collections.abc import Iterable
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from glossa.anatomy import hexahedra as hexa
from glossa.anatomy.arrays import FloatArray, IntArray
from glossa.anatomy.muscle import Muscle
from glossa.anatomy.obj_file import read_obj
from glossa.anatomy.paper_table import MUSCLE_NAMES, force_capacities
from glossa.anatomy.pb import HYOID_DENSITY, contour_points, hyoid_spring
from glossa.anatomy.solid import solid
from glossa.anatomy.speaker import Speaker
from glossa.anatomy.walls import Hyoid, Wall
from glossa.errors import InputError, SpeakerFileError

_PACKAGES = Path("src/artisynth/models")
_TONGUE, _SPRING = 1, 941
_WALL_MATERIALS = {"hard_palate": 921, "soft_palate": 932, "mandible": 933}
_CONTACT_MATERIALS = {"hard_palate": 911, "soft_palate": 912, "mandible": 913}
_WALL_SURFACES = {"palate": "ICPPalate3.obj", "mandible": "ICPJaw3.obj"}
_ATTACHMENTS = {  # node set: file, in the order of preference
    "jaw": ("jawAttachmentsStephanie.txt", "jawAttachments.txt"),
    "hyoid": ("hyoidAttachmentsStephanie.txt", "hyoidAttachments.txt"),
    "jaw_yohan": ("jawAttachmentsYohan.txt",),
    "jaw_anterior": ("jawAttachmentsAnterior.txt",),
    "jaw_artisynth": ("jawAttachments.txt",),
    "hyoid_full": ("hyoidAttachmentsFull.txt",),
    "hyoid_partial": ("hyoidAttachmentsPartial.txt",),
    "hyoid_artisynth": ("hyoidAttachments.txt",),
}
_LARGEST = 1e9
"""Of any number, element or coordinate."""
_MOST_ELEMENTS = 1_000_000  # of one selection
_TURNED = [0, 3, 2, 1, 4, 7, 6, 5]  # the same hexahedron with the opposite orientation


@dataclass(frozen=True, eq=False)
class _Mesh:
    """ANSYS nodes by number, and elements as rows: eight node numbers, material, element number."""

    path: Path
    positions: dict[int, tuple[float, float, float]]
    elements: IntArray

    def of(self, material: int) -> IntArray:
        rows: IntArray = self.elements[self.elements[:, 8] == material]
        return rows


def load_artisynth(folder: Path) -> Speaker:
    """The PB speaker from a checkout, or from its folder tongue3d/geometry.

    Raises:
        FileNotFoundError: the folder lacks a needed file.
        SpeakerFileError: a file that cannot be read or does not fit the others.
    """
    geometry, attachments = _folders(folder)
    mesh = _read_mesh(geometry)
    fibres = _read_fibres(geometry / "Fibers.mac")
    elements = _read_components(geometry / "CreateMuscles.mac")
    try:
        return _build(mesh, fibres, elements, geometry, attachments)
    except SpeakerFileError:
        raise
    except InputError as error:
        raise SpeakerFileError(f"{geometry}: {error}") from None


def _folders(folder: Path) -> tuple[Path, list[Path]]:
    """The tongue's geometry folder, and the folders to look for attachments in, first the preferred one."""
    geometry = folder / _PACKAGES / "tongue3d" / "geometry"
    if not geometry.is_dir():
        geometry = folder
    if not (geometry / "Fibers.mac").is_file():
        raise FileNotFoundError(
            f"{folder} is neither a checkout of artisynth_models nor its folder tongue3d/geometry: no Fibers.mac found"
        )
    return geometry, [geometry.parents[1] / "jawTongue" / "geometry", geometry]


def _build(
    mesh: _Mesh, fibres: dict[str, list[list[int]]], elements: dict[str, list[int]], geometry: Path, folders: list[Path]
) -> Speaker:
    tongue = mesh.of(_TONGUE)
    element_number = {int(row[9]): e for e, row in enumerate(tongue)}
    corners = np.unique(tongue[:, :8])
    outside = sorted({node for paths in fibres.values() for path in paths for node in path} - set(corners.tolist()))
    numbers = [*corners.tolist(), *outside]
    place = {number: index for index, number in enumerate(numbers)}
    _need(mesh, numbers)
    nodes = np.array([mesh.positions[number] for number in numbers])
    hexahedra = _oriented(nodes, np.array([[place[n] for n in row[:8]] for row in tongue.tolist()], dtype=np.int32))
    from_zero = {number - 1: index for number, index in place.items()}
    sets = _node_sets(folders, from_zero)
    contours = _listed(folders, "tongueContourNodes.txt", from_zero)
    dorsum = {} if contours is None else {"dorsum": contours}
    walls = _walls(mesh, geometry)
    return Speaker(
        nodes,
        hexahedra,
        muscles=_muscles(fibres, elements, place, element_number, geometry),
        node_sets={
            **sets,
            "midsagittal": np.flatnonzero(np.abs(nodes[: len(corners), 1]) < 1e-9).astype(np.int32),
            "styloid": np.arange(len(corners), len(nodes), dtype=np.int32),
            **(contour_points(nodes, contours) if contours is not None else {}),
        },
        walls=walls,
        hyoid=_hyoid(mesh, geometry / "ICPHyoid3.obj"),
        contours=dorsum,
        name="PB",
        contact_faces=_contact_faces(mesh, place, hexa.boundary_quads(hexahedra, len(nodes)), set(walls)),
    )


def _need(mesh: _Mesh, numbers: Iterable[int]) -> None:
    missing = [number for number in numbers if number not in mesh.positions]
    if missing:
        raise SpeakerFileError(f"{mesh.path}: node {missing[0]} is used but not in the node file")


def _read_mesh(geometry: Path) -> _Mesh:
    for name in ("tongueIcp.3", "tongue"):
        if (geometry / f"{name}.node").is_file():
            positions = {}
            for row in _rows(geometry / f"{name}.node", 4):
                positions[int(row[0])] = (row[1], row[2], row[3])
            rows = np.array(_rows(geometry / f"{name}.elem", 14))[:, [*range(9), 13]].astype(np.int32)
            return _Mesh(geometry / f"{name}.node", positions, rows)
    raise FileNotFoundError(f"{geometry} holds neither tongueIcp.3.node nor tongue.node")


def _rows(path: Path, columns: int) -> list[list[float]]:
    rows = []
    for number, line in enumerate(path.read_text(encoding="latin-1").splitlines(), start=1):
        words = line.split()
        if not words or words[0].startswith(("#", "!")):
            continue
        try:
            row = [float(word) for word in words[:columns]]
        except ValueError as error:
            raise SpeakerFileError(f"{path}, line {number}: {error}") from None
        if len(row) < columns:
            raise SpeakerFileError(f"{path}, line {number}: {len(row)} numbers, expected {columns}")
        if not all(abs(value) < _LARGEST for value in row):
            raise SpeakerFileError(f"{path}, line {number}: every number must be below {_LARGEST:g}")
        rows.append(row)
    if not rows:
        raise SpeakerFileError(f"{path}: empty")
    return rows


def _code(path: Path) -> list[tuple[int, str]]:
    """Numbered lines of an ANSYS macro without comments and blanks."""
    lines = path.read_text(encoding="latin-1").splitlines()
    code = ((number, re.sub(r"\s", "", line.split("!")[0])) for number, line in enumerate(lines, start=1))
    return [(number, line) for number, line in code if line]


def _read_fibres(path: Path) -> dict[str, list[list[int]]]:
    """Fibres by muscle number (as text); each a list of ANSYS node numbers in order."""
    found: dict[tuple[int, int], dict[int, int]] = defaultdict(dict)
    lengths: dict[tuple[int, int], int] = {}
    for number, line in _code(path):
        if entry := re.fullmatch(r"FIBER\((\d{1,9}),(\d{1,9}),(\d{1,9})\)=(\d{1,9})", line):
            position, fibre, muscle, node = (int(text) for text in entry.groups())
            found[muscle, fibre][position] = node
        elif entry := re.fullmatch(r"NB_NODES_FIBER\((\d{1,9}),(\d{1,9})\)=(\d{1,9})", line):
            fibre, muscle, length = (int(text) for text in entry.groups())
            lengths[muscle, fibre] = length
        elif line.startswith(("FIBER(", "NB_NODES_FIBER(")):
            raise SpeakerFileError(f"{path}, line {number}: cannot read {line!r}")
    if not lengths:
        raise SpeakerFileError(f"{path}: no fibres found (no NB_NODES_FIBER entries)")
    result: dict[str, list[list[int]]] = defaultdict(list)
    for (muscle, fibre), length in sorted(lengths.items()):
        nodes = found[muscle, fibre]
        if any(position not in nodes for position in range(1, length + 1)):
            raise SpeakerFileError(f"{path}: muscle {muscle}, fibre {fibre} has {length} nodes but not all are given")
        result[str(muscle)].append([nodes[position] for position in range(1, length + 1)])
    return dict(result)


def _read_components(path: Path) -> dict[str, list[int]]:
    """ANSYS element numbers by component name, and under "#number" the component name of each muscle number."""
    components: dict[str, list[int]] = {}
    selected: list[int] = []
    for number, line in _code(path):
        if entry := re.fullmatch(r"muscleName\((\d{1,9})\)='(\w+)'", line):
            components.setdefault(f"#{entry.group(1)} {entry.group(2)}", [])
        elif entry := re.fullmatch(r"ESEL,([SA]),ELEM,,(\d{1,9})(?:,(\d{1,9}))?(?:,(\d{1,9}))?", line):
            first = int(entry.group(2))
            chosen = range(first, int(entry.group(3) or first) + 1, int(entry.group(4) or 1))
            if len(chosen) > _MOST_ELEMENTS:
                raise SpeakerFileError(f"{path}, line {number}: {line!r} selects {len(chosen)} elements")
            selected = [*chosen] if entry.group(1) == "S" else [*selected, *chosen]
        elif entry := re.fullmatch(r"CM,(\w+),ELEM", line):
            components[entry.group(1)] = selected
        elif line.startswith("ESEL,") and ",ELEM," in line:
            raise SpeakerFileError(f"{path}, line {number}: cannot read the selection {line!r}")
    return components


def _muscles(
    fibres: dict[str, list[list[int]]],
    components: dict[str, list[int]],
    place: dict[int, int],
    element_number: dict[int, int],
    geometry: Path,
) -> dict[str, Muscle]:
    """Left and right joined; a midline fibre, listed on both sides, once."""
    rho = force_capacities()
    canonical = {name.upper(): name for name in MUSCLE_NAMES}
    elements: dict[str, set[int]] = defaultdict(set)
    paths: dict[str, dict[tuple[int, ...], None]] = defaultdict(dict)
    for key in (key for key in components if key.startswith("#")):
        number, component = key[1:].split(" ")
        name = canonical.get(component.split("_")[0].upper())
        if name is None:
            raise SpeakerFileError(f"{geometry / 'CreateMuscles.mac'}: unknown muscle {component!r}")
        if component not in components or number not in fibres:
            raise SpeakerFileError(f"{geometry}: muscle {component!r} (number {number}) lacks elements or fibres")
        elements[name].update(components[component])
        for path in fibres[number]:
            if tuple(path[::-1]) not in paths[name]:
                paths[name][tuple(path)] = None
    unknown = sorted(set().union(*elements.values()) - element_number.keys())
    if unknown:
        macro = geometry / "CreateMuscles.mac"
        raise SpeakerFileError(f"{macro}: element {unknown[0]} is not an element of the tongue")
    return {
        name: Muscle(
            sorted(element_number[e] for e in elements[name]),
            [[place[node] for node in path] for path in paths[name]],
            rho[name],
        )
        for name in MUSCLE_NAMES
        if name in elements
    }


def _oriented(nodes: FloatArray, hexahedra: IntArray) -> IntArray:
    """VTK orientation: elements with a negative volume are turned."""
    negative = hexa.volumes(nodes, hexahedra) < 0.0
    return np.where(negative[:, None], hexahedra[:, _TURNED], hexahedra)


def _listed(folders: list[Path], name: str, from_zero: dict[int, int]) -> IntArray | None:
    """Node list of a text file of numbers from 0; None when no folder has the file."""
    for folder in folders:
        if (folder / name).is_file():
            words = (folder / name).read_text(encoding="latin-1").split()
            try:
                if not words:
                    raise ValueError("empty")
                return np.array([from_zero[int(word)] for word in words], dtype=np.int32)
            except (ValueError, KeyError) as error:
                raise SpeakerFileError(f"{folder / name}: not a list of tongue nodes ({error})") from None
    return None


def _node_sets(folders: list[Path], from_zero: dict[int, int]) -> dict[str, IntArray]:
    sets = {}
    for name, files in _ATTACHMENTS.items():
        for file in files:
            nodes = _listed(folders[::-1] if name.endswith("_artisynth") else folders, file, from_zero)
            if nodes is not None:
                sets[name] = np.unique(nodes)
                break
    for name in ("jaw", "hyoid"):
        if name not in sets:
            raise FileNotFoundError(f"{folders[-1]} lacks {_ATTACHMENTS[name][-1]} (nodes attached to the {name})")
    return sets


def _walls(mesh: _Mesh, geometry: Path) -> dict[str, Wall]:
    walls = {}
    for name, material in _WALL_MATERIALS.items():
        shells = mesh.of(material)[:, :4]
        if len(shells):
            used, faces = np.unique(shells, return_inverse=True)
            _need(mesh, used.tolist())
            walls[name] = Wall([mesh.positions[n] for n in used.tolist()], faces.reshape(shells.shape))
    if not walls:
        for name, file in _WALL_SURFACES.items():
            if (geometry / file).is_file():
                walls[name] = read_obj(geometry / file)
    return walls


def _contact_faces(mesh: _Mesh, place: dict[int, int], boundary: IntArray, walls: set[str]) -> dict[str, IntArray]:
    result = {}
    for name, material in _CONTACT_MATERIALS.items():
        shells = mesh.of(material)[:, :4]
        if name in walls and len(shells):
            faces = np.array([[place.get(n, -1) for n in face] for face in shells.tolist()], dtype=np.int32)
            numbers = hexa.matching_faces(faces, boundary)
            result[name] = boundary[np.unique(numbers[numbers >= 0])]
    return result


def _hyoid(mesh: _Mesh, surface: Path) -> Hyoid | None:
    if not surface.is_file():
        return None
    bone = read_obj(surface)
    volume, centre = solid(bone)
    _need(mesh, mesh.of(_SPRING)[:, :2].ravel().tolist())
    springs = tuple(
        hyoid_spring(bone, mesh.positions[row[0]], mesh.positions[row[1]], f"spring {row[9]}")
        for row in mesh.of(_SPRING).tolist()
    )
    return Hyoid(bone, abs(volume) * HYOID_DENSITY, centre, springs)
