"""An interactive view of a posture; needs pyvista (``pip install 'glossa[view]'``)."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np

from glossa.anatomy.arrays import FloatArray, IntArray
from glossa.figures import style
from glossa.results import Posture
from glossa.surroundings import hyoid_of, springs_of, walls_of


def view(
    posture: Posture, *, muscle: str | None = None, springs: bool = False, screenshot: str | Path | None = None
) -> None:
    """Open a window with tongue, the half of the walls behind it, and hyoid at its pose; or write a picture of it.

    Args:
        posture: what to show.
        muscle: also show the fibres of this muscle, through a translucent tongue.
        springs: also show the springs that hold the hyoid.
        screenshot: write this PNG file off screen and open no window.

    Raises:
        ImportError: pyvista is not installed.
        InputError: a muscle that the speaker lacks.
    """
    if muscle is not None:
        posture.fibre_slice(muscle)
    plotter = _plotter(off_screen=screenshot is not None)
    import pyvista

    speaker = posture.speaker
    tongue = pyvista.PolyData(posture.positions, _padded(speaker.surface_quads))
    opacity = 1.0 if muscle is None else 0.35
    look = {"color": style.TISSUE, "opacity": opacity, "show_edges": True, "edge_color": "#8A5A5A"}
    plotter.add_mesh(tongue, smooth_shading=True, **look)
    if muscle is not None:
        segments = speaker.muscles[muscle].segments[:, :2]
        lines = pyvista.PolyData(posture.positions, lines=_padded(segments))
        plotter.add_mesh(lines, color=style.FIBRE, line_width=3)
    for wall in walls_of(posture).values():
        surface = pyvista.PolyData(wall.vertices, _padded(wall.triangles)).clip(normal="-y", origin=(0.0, 0.0, 0.0))
        plotter.add_mesh(surface, color=style.BONE, smooth_shading=True)
    bone = hyoid_of(posture)
    if bone is not None:
        plotter.add_mesh(pyvista.PolyData(bone.vertices, _padded(bone.triangles)), color="#EDE6D0", smooth_shading=True)
    ends = springs_of(posture)
    if springs and len(ends):
        pairs = np.arange(2 * len(ends), dtype=np.int32).reshape(-1, 2)
        plotter.add_mesh(pyvista.PolyData(ends.reshape(-1, 3), lines=_padded(pairs)), color=style.HYOID, line_width=2)
    plotter.camera_position = [_viewpoint(posture.positions), posture.positions.mean(axis=0), (0.0, 0.0, 1.0)]
    plotter.camera.parallel_scale = 0.055
    if screenshot is None:
        plotter.show(title=f"glossa: {speaker.name}")
    else:
        plotter.screenshot(str(screenshot))
    plotter.close()


def _plotter(*, off_screen: bool) -> Any:
    try:
        import pyvista
    except ImportError as error:
        raise ImportError(f"the 3D view needs pyvista ({error}); install it with: pip install 'glossa[view]'") from None
    plotter = pyvista.Plotter(off_screen=off_screen, window_size=[1100, 850])
    plotter.set_background("white")
    plotter.enable_parallel_projection()
    return plotter


def _padded(cells: IntArray) -> IntArray:
    """Flat cells, each with its number of corners in front."""
    return np.column_stack([np.full(len(cells), cells.shape[1]), cells]).ravel()


def _viewpoint(positions: FloatArray) -> FloatArray:
    """Anterior oblique, tongue tip on the left."""
    direction = np.array([-0.56, -0.72, 0.41])
    return np.asarray(positions.mean(axis=0) + 0.35 * direction)
