"""One section of the vocal tract: a closed contour in a cutting plane."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

from glossa.anatomy.arrays import FloatArray
from glossa.tract.contour import Shape


@dataclass(frozen=True, eq=False, kw_only=True)
class Section:
    """The airway in one cutting plane; all in m and m².

    Attributes:
        area: m², at least the floor.
        measured_area: m², of the contour, 0 where there is none.
        area_beside: m², of channels beside the contour that are connected to the airway on either side but left out.
        contour: polygon in coordinates (y, t) of the plane; several polygons for an ambiguous section, an empty one for
            an occluded tract without any air left.
        centroid: (3,) of the contour.
        origin: (3,) midline at rest.
        normal: (3,) unit normal of the plane, towards the lips.
        outwards: (3,) unit vector of t, towards palate and rear wall.
        midsagittal: (2,) t of the lower and the upper boundary on the midline, m; equal where they touch, NaN for an
            open section.
        bounds: share of the contour's width that each structure bounds, above and below together, by name: "tongue",
            "hyoid" and the names of the walls; they add up to 1 less what nothing bounds.
        status: "closed", the contour is closed by structures and seams up to 3 mm; "open", the wall or what faces it is
            missing on the midline; "ambiguous", several channels lie side by side: those beside the midline are left
            out unless the midline is closed.
        floored: the area was raised to the floor.
        occluded: nowhere as high as the barrier, though a pocket on the midline may be left; or nothing connects it
            with the sections behind it.
        clamped: what bounds a part of the contour from below is missing or too deep; it was cut off at a fixed depth.
        bridged: a seam or a narrow slot in what bounds the contour from below was bridged.
        lateral_end: the contour reaches the lateral end on either side.
        arch: the plane cuts the upper dental arch, where the choice of the lateral end matters.
    """

    area: float
    measured_area: float
    area_beside: float
    contour: Shape
    centroid: FloatArray
    origin: FloatArray
    normal: FloatArray
    outwards: FloatArray
    midsagittal: FloatArray
    bounds: Mapping[str, float]
    status: str
    floored: bool
    occluded: bool
    clamped: bool
    bridged: bool
    lateral_end: bool
    arch: bool

    @property
    def sagittal_distance(self) -> float:
        """Height of the airway on the midline, m."""
        return float(self.midsagittal[1] - self.midsagittal[0])

    def __repr__(self) -> str:
        words = [name for name in ("floored", "occluded", "clamped", "lateral_end", "arch") if getattr(self, name)]
        marks = ", ".join([self.status, *words])
        return f"Section({self.area * 1e4:.3g} cm², {'/'.join(self.bounds)}; {marks})"
