"""The tongue in the oral cavity, from the front and above, as fig. 2."""

from __future__ import annotations

import numpy as np
from matplotlib.colors import to_rgb
from matplotlib.figure import Figure
from matplotlib.patches import Patch
from mpl_toolkits.mplot3d.art3d import Line3DCollection, Poly3DCollection  # type: ignore[import-untyped]

from glossa.anatomy.arrays import FloatArray
from glossa.figures import style
from glossa.figures.facets import shades, view_frame
from glossa.figures.spatial import spatial_axes
from glossa.results import Posture
from glossa.surroundings import hyoid_of, springs_of, walls_of

VIEW = (24.0, -142.0)
"""Elevation and azimuth, degrees: anterior oblique, tongue tip on the left."""

JAW, BONE, SPRINGS, SOFT = "#40B8C8", "#E8C830", "#C0408F", "#A8A8A8"
"""Mandible, hyoid, springs and the other walls: cyan, yellow, magenta and grey, as the paper has them."""

THROUGH = {"mandible": 0.6}
"""Opacity of a wall."""

VEIL = 0.07
"""Opacity of the walls not in THROUGH: there are two layers of most, which hide the tongue."""


@style.styled
def cavity(posture: Posture) -> Figure:
    """Tongue, mandible, hyoid and its springs; palate, pharynx and larynx translucent.

    Args:
        posture: of a speaker with walls; for the shape at rest, of :func:`glossa.studies.rest_posture`.
    """
    speaker, walls, bone, springs = posture.speaker, walls_of(posture), hyoid_of(posture), springs_of(posture)
    tongue = posture.positions[np.unique(speaker.hexahedra)]
    points = np.concatenate([tongue, springs.reshape(-1, 3), *(wall.vertices for wall in walls.values())])
    sheet = style.new_sheet(6.4, 6.0)
    axes = spatial_axes(sheet, (1, 1, 1), VIEW, np.stack([points.min(axis=0), points.max(axis=0)]), zoom=1.2)
    weights, triangles = speaker.smooth_surface.triangulation()
    parts = [_painted(np.asarray((weights @ posture.positions)[triangles]), style.TISSUE, 1.0)]
    parts += [
        _painted(wall.vertices[wall.triangles], JAW if name in THROUGH else SOFT, THROUGH.get(name, VEIL))
        for name, wall in walls.items()
    ]
    if bone is not None:
        parts.append(_painted(bone.vertices[bone.triangles], BONE, 1.0))
    corners, colours = (np.concatenate(column) for column in zip(*parts, strict=True))
    surfaces = Poly3DCollection(list(corners), facecolors=colours, edgecolors="none", zsort="average", zorder=1)
    surfaces.set(antialiased=False)
    surfaces.set_clip_on(False)
    axes.add_collection3d(surfaces)  # one for all, so that what is nearer hides what is behind
    lines = Line3DCollection(list(springs), colors=SPRINGS, linewidths=1.3, zorder=3)
    lines.set_gid("springs")
    lines.set_clip_on(False)
    axes.add_collection3d(lines)
    sheet.legend(handles=_legend(bone is not None), loc="outside lower center", ncols=5, handlelength=1.2)
    return sheet


def _painted(corners: FloatArray, colour: str, opacity: float) -> tuple[FloatArray, FloatArray]:
    """Triangles (t, 3, 3) and their colours (t, 4)."""
    return corners, np.column_stack([_shaded(corners, colour), np.full(len(corners), opacity)])


def _shaded(corners: FloatArray, colour: str) -> FloatArray:
    normals = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    normals /= np.maximum(np.linalg.norm(normals, axis=1, keepdims=True), 1e-300)
    frame = view_frame(*VIEW)
    towards = np.where((normals @ frame[2])[:, None] < 0.0, -normals, normals)  # seen from either side
    return np.asarray(shades(towards, frame)[:, None] * np.array(to_rgb(colour)))


def _legend(hyoid: bool) -> list[Patch]:
    parts = {"tongue": style.TISSUE, "mandible": JAW, "palate, pharynx, larynx": SOFT}
    if hyoid:
        parts |= {"hyoid bone": BONE, "springs": SPRINGS}
    return [Patch(facecolor=colour, label=name) for name, colour in parts.items()]
