"""A speaker: a hexahedral tongue with muscles, attachments, walls and hyoid."""

from __future__ import annotations

import hashlib
from collections.abc import Mapping
from dataclasses import dataclass
from functools import cached_property, partial
from pathlib import Path
from types import MappingProxyType
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import ArrayLike

from glossa.anatomy import hexahedra as hexa
from glossa.anatomy import speaker_checks as checks
from glossa.anatomy.arrays import FloatArray, IntArray, float_array, frozen, int_array
from glossa.anatomy.muscle import Muscle
from glossa.anatomy.walls import Hyoid, Wall
from glossa.errors import InputError

if TYPE_CHECKING:
    from glossa.anatomy.quality import Quality
    from glossa.anatomy.smooth_surface import SmoothSurface

_MIDPLANE_TOLERANCE = 1e-9  # m; rounding of mirror-symmetric files is far below
_NOTHING: Mapping[str, Any] = MappingProxyType({})


@dataclass(frozen=True, eq=False, init=False, repr=False)
class Speaker:
    """A hexahedral body with its muscles and surroundings; SI units, arrays write-protected.

    Frame: x front to back, y lateral with the midsagittal plane at y = 0, z up.

    Attributes:
        nodes: (n, 3) m. Nodes in no hexahedron are outside points: some fibre has to pass through each.
        hexahedra: (m, 8) node indices, VTK corner order, positive Jacobian at corners and Gauss points.
        muscles: by name.
        node_sets: by name; "jaw" and "hyoid" are the attachments.
        walls: rigid surfaces by name.
        hyoid: the bone that moves the node set "hyoid", or None.
        contours: ordered node lists by name; "dorsum" runs front to back.
        contact_faces: by wall: (k, 4) the boundary faces that may touch it, corners as in ``surface_quads``, given in
            any order. Empty: every wall may touch the whole free surface. Otherwise a wall that is not named touches
            nothing; it only bounds the vocal tract.
        name: free text.

    Raises:
        InputError: naming what is wrong, where, and what to do.
    """

    nodes: FloatArray
    hexahedra: IntArray
    muscles: Mapping[str, Muscle]
    node_sets: Mapping[str, IntArray]
    walls: Mapping[str, Wall]
    hyoid: Hyoid | None
    contours: Mapping[str, IntArray]
    name: str
    contact_faces: Mapping[str, IntArray]

    def __init__(
        self,
        nodes: ArrayLike,
        hexahedra: ArrayLike,
        *,
        muscles: Mapping[str, Muscle] = _NOTHING,
        node_sets: Mapping[str, ArrayLike] = _NOTHING,
        walls: Mapping[str, Wall] = _NOTHING,
        hyoid: Hyoid | None = None,
        contours: Mapping[str, ArrayLike] = _NOTHING,
        name: str = "",
        contact_faces: Mapping[str, ArrayLike] = _NOTHING,
    ) -> None:
        keep = partial(object.__setattr__, self)
        keep("nodes", float_array(nodes, "nodes", 3))
        keep("hexahedra", int_array(hexahedra, "hexahedra", 8))
        checks.check_hexahedra(self.nodes, self.hexahedra)
        checks.check_jacobians(self.nodes, self.hexahedra)
        keep("muscles", checks.checked_muscles(muscles, self.nodes, len(self.hexahedra)))
        checks.check_orphans(self.nodes, self.hexahedra, self.muscles)
        keep("node_sets", checks.checked_node_sets(node_sets, len(self.nodes)))
        keep("contours", checks.checked_contours(contours, len(self.nodes)))
        keep("walls", checks.checked_walls(walls))
        checks.check_hyoid_and_name(hyoid, name)
        keep("hyoid", hyoid)
        keep("name", name)
        faces = checks.checked_contact_faces(contact_faces, self.walls, self.hexahedra, len(self.nodes))
        keep("contact_faces", faces)

    def __reduce__(self) -> tuple[Any, ...]:
        return _rebuilt, (self.nodes, self.hexahedra, self._parts())

    def __repr__(self) -> str:
        return (
            f"Speaker({self.name!r}: {len(self.nodes)} nodes, {len(self.hexahedra)} hexahedra, "
            f"{len(self.muscles)} muscles)"
        )

    def _parts(self) -> dict[str, Any]:
        """Keyword arguments of the constructor, mappings as plain dicts."""
        mappings = ("muscles", "node_sets", "walls", "contours", "contact_faces")
        parts: dict[str, Any] = {key: dict(getattr(self, key)) for key in mappings}
        return parts | {"hyoid": self.hyoid, "name": self.name}

    # Constructors and files

    @classmethod
    def reference(cls, resolution: int = 1, landmarks: str | Path | Mapping[str, Any] | None = None) -> Speaker:
        """The built-in anatomy, or one with own landmarks.

        Args:
            resolution: r divides every cell of level 1 into r x r x r.
            landmarks: path of a TOML file, or a mapping with its content: what is to differ from the built-in landmarks
                (see :func:`glossa.anatomy.speaker_landmarks.load_landmarks`), for example
                ``{"shape": {"vault_height": 4}}``.

        Raises:
            InputError: malformed landmarks, or such as give no sound speaker.
        """
        from glossa.anatomy.reference import reference_speaker
        from glossa.anatomy.speaker_landmarks import load_landmarks

        return reference_speaker(resolution, load_landmarks(landmarks))

    @classmethod
    def load(cls, path: str | Path) -> Speaker:
        """A saved speaker file, or a folder that holds pb_tongue.json (the PB speaker).

        Raises:
            FileNotFoundError: nothing at ``path``.
            SpeakerFileError: truncated, foreign or inconsistent file.
        """
        if Path(path).is_dir():
            from glossa.anatomy.pb import load_pb

            return load_pb(Path(path))
        from glossa.anatomy.speaker_file import load_speaker

        return load_speaker(Path(path))

    @classmethod
    def from_artisynth(cls, folder: str | Path) -> Speaker:
        """The PB speaker from a checkout of ArtiSynth Models, or from its tongue geometry folder."""
        from glossa.anatomy.artisynth import load_artisynth

        return load_artisynth(Path(folder))

    def save(self, path: str | Path) -> None:
        """Write one speaker file (see glossa.anatomy.speaker_file), atomically."""
        from glossa.anatomy.speaker_file import save_speaker

        save_speaker(self, Path(path))

    def refined(self) -> Speaker:
        """Every hexahedron in eight, fibres multiplied, node sets, contours and contact faces carried along."""
        from glossa.anatomy.refinement import refined_speaker

        return refined_speaker(self)

    def adapted_to(self, landmarks: Mapping[str, Any], *, points: Any = None, name: str | None = None) -> Speaker:
        """This speaker warped smoothly so that its landmarks lie where they were measured on a subject.

        Nodes, walls, hyoid and springs move together; numbering, muscles, sets and faces stay. The hyoid's mass follows
        its volume, its springs are as slack as before. What is measured nowhere follows what is: with few points the
        speaker is scaled and turned, or only shifted (see :mod:`glossa.anatomy.warp`); without lateral targets widths
        follow the size of the profile.

        Targets of one side only are mirrored, so that the result is as mirror symmetric as this speaker; targets of
        both sides that differ make it asymmetric.

        Args:
            landmarks: name -> measured x, y, z in m, or x, z in the midsagittal plane. Names, and where they are on
                this speaker, from :func:`glossa.anatomy.landmark_points`. Same axes as the speaker, any origin.
            points: other pairs: places on this speaker (n, 3) and in the subject (n, 3), m.
            name: of the result; None takes "<name>, adapted".

        Raises:
            InputError: malformed targets, units or frames that cannot be right, targets that fold the speaker over,
                distort an element to a scaled Jacobian below 0.1 or push the tongue 2 mm into a wall; the message names
                the nearest landmark. Lesser faults are logged as warnings.

        Example:
            >>> speaker = Speaker.reference()
            >>> own = landmark_points(speaker)
            >>> longer = {key: own[key] - [0, 0, 0.008] for key in ("glottis", "hyoid", "vallecula")}
            >>> subject = speaker.adapted_to(own | longer | {"vault": (0.090, 0.123)}, name="S1")
        """
        from glossa.anatomy.adaptation import adapted_speaker

        return adapted_speaker(self, landmarks, points, name)

    # Geometry

    @cached_property
    def element_volumes(self) -> FloatArray:
        """(m,) m3."""
        return frozen(hexa.volumes(self.nodes, self.hexahedra))

    @property
    def volume(self) -> float:
        """Volume of the body, m3."""
        return float(self.element_volumes.sum())

    @cached_property
    def scaled_jacobians(self) -> FloatArray:
        """(m,) smallest corner determinant of the unit edge vectors; 1 for a cuboid."""
        return frozen(hexa.scaled_jacobians(self.nodes, self.hexahedra))

    def quality(self) -> Quality:
        """Shape and size of the elements, and how far walls are from the tongue at rest."""
        from glossa.anatomy.quality import quality_of

        return quality_of(self)

    @cached_property
    def surface_quads(self) -> IntArray:
        """(q, 4) faces of one hexahedron only, normals outwards."""
        return frozen(hexa.boundary_quads(self.hexahedra, len(self.nodes)))

    @cached_property
    def smooth_surface(self) -> SmoothSurface:
        """Smooth surface through the nodes of ``surface_quads``, linear in node positions.

        Raises:
            InputError: parts of the body touch along an edge only.
        """
        from glossa.anatomy.smooth_surface import SmoothSurface

        return SmoothSurface(self.nodes, self.surface_quads)

    @cached_property
    def midsagittal_nodes(self) -> IntArray:
        """(k,) nodes with |y| below 1e-9 m."""
        return frozen(np.flatnonzero(np.abs(self.nodes[:, 1]) < _MIDPLANE_TOLERANCE).astype(np.int32))

    @cached_property
    def outside_points(self) -> IntArray:
        """(k,) nodes in no hexahedron."""
        return frozen(np.setdiff1d(np.arange(len(self.nodes)), self.hexahedra).astype(np.int32))

    def fibre_rest_lengths(self, muscle: str) -> FloatArray:
        """(n_fibres,) polyline lengths at rest, m.

        Raises:
            InputError: no muscle of that name.
        """
        if muscle not in self.muscles:
            raise InputError(f"no muscle {muscle!r}; this speaker has {', '.join(self.muscles) or 'none'}")
        segments = self.muscles[muscle].segments
        lengths = np.linalg.norm(self.nodes[segments[:, 1]] - self.nodes[segments[:, 0]], axis=1)
        return np.asarray(np.bincount(segments[:, 2], weights=lengths), dtype=np.float64)

    # Descriptions

    @cached_property
    def fingerprint(self) -> str:
        """SHA-256 (hex) of the content: equal for equal speakers, whatever the machine."""
        digest = hashlib.sha256()
        for item in _content(self):
            if isinstance(item, np.ndarray):
                kind = "<f8" if item.dtype.kind == "f" else "<i8"
                digest.update(f"{kind}{item.shape}".encode())
                digest.update(np.ascontiguousarray(item, dtype=kind).tobytes())
            else:
                digest.update(f"{item!r};".encode())
        return digest.hexdigest()

    def summary(self) -> str:
        """Counts, volume, quality and one line per muscle, as text."""
        quality = f"{self.scaled_jacobians.min():.3f}" if len(self.hexahedra) else "-"
        lines = [
            f"{self.name or 'speaker'}: {len(self.nodes)} nodes ({len(self.outside_points)} outside points), "
            f"{len(self.hexahedra)} hexahedra, {self.volume * 1e6:.2f} cm3, smallest scaled Jacobian {quality}"
        ]
        for name, muscle in self.muscles.items():
            lengths = self.fibre_rest_lengths(name) * 1e3
            volume = self.element_volumes[muscle.elements].sum() * 1e6
            lines.append(
                f"  {name}: {len(muscle.fibres)} fibres of {lengths.min():.1f}..{lengths.max():.1f} mm "
                f"(mean {lengths.mean():.1f}), {len(muscle.elements)} elements, {volume:.1f} cm3, "
                f"{muscle.force_capacity:g} N"
            )
        for title, mapping in (("node sets", self.node_sets), ("contours", self.contours)):
            lines.append(f"  {title}: " + (", ".join(f"{k} ({len(v)})" for k, v in mapping.items()) or "none"))
        if self.contact_faces:
            counts = ", ".join(f"{name} ({len(faces)})" for name, faces in self.contact_faces.items())
            lines.append(f"  contact faces: {counts}")
        lines.append(f"  walls: {', '.join(self.walls) or 'none'}; hyoid: {'yes' if self.hyoid else 'no'}")
        return "\n".join(lines)


def _rebuilt(nodes: FloatArray, hexahedra: IntArray, parts: dict[str, Any]) -> Speaker:
    return Speaker(nodes, hexahedra, **parts)


def _content(speaker: Speaker) -> list[Any]:
    """Everything a speaker holds as a flat list of arrays and scalars, names in sorted order."""
    items: list[Any] = [speaker.name, speaker.nodes, speaker.hexahedra]
    for name in sorted(speaker.muscles):
        muscle = speaker.muscles[name]
        items += ["muscle", name, muscle.force_capacity, muscle.fibres_per_element, muscle.peak_multiplier]
        items += [muscle.elements, *muscle.fibres]
    for title, mapping in (("set", speaker.node_sets), ("contour", speaker.contours)):
        for name in sorted(mapping):
            items += [title, name, mapping[name]]
    for name in sorted(speaker.walls):
        items += ["wall", name, speaker.walls[name].vertices, speaker.walls[name].faces]
    for name in sorted(speaker.contact_faces):
        items += ["contact", name, speaker.contact_faces[name]]
    if speaker.hyoid is not None:
        items += ["hyoid", speaker.hyoid.mass, speaker.hyoid.centre]
        if speaker.hyoid.surface is not None:
            items += [speaker.hyoid.surface.vertices, speaker.hyoid.surface.faces]
        for spring in speaker.hyoid.springs:
            items += [spring.name, spring.on_hyoid, spring.fixed, spring.stiffness, spring.rest_length]
    return items
