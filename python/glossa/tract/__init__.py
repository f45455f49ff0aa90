"""From a posture to the area function of its vocal tract (section II.E of the paper).

What the paper leaves open is chosen for physical reasons, the same for every vowel and speaker:

- *Midline*: the centres of the circles that fit between the outer walls and what faces them at rest, smoothed until
  neighbouring planes do not cross within a section. Nothing is drawn by hand.
- *Tongue*: the smooth surface through the nodes that contact uses, in facets of 0.75 mm; facets of a hexahedron's size
  move F2 of /i/ by 500 Hz.
- *Outer wall*: followed sideways from the midline, with the tongue at rest. Sections of the mouth end at the outer edge
  of the upper arch: there the cheeks lie against the teeth.
- *Airway*: gaps of at least 0.5 mm, parted at slits lower than 1 mm: a mesh leaves slits where a tongue seals. The
  channel on the midline is the section; what runs beside it between tongue and teeth is told of, not counted.
- *Seams and clefts* deeper than wide are bridged; the space under the tongue is cut off 20 mm below the midline.
- *Length*: along the centroids of 45 planes, the paper's rule. It does not converge with more planes, and makes a
  detour where the space beside the teeth opens: ``path="midline"`` shows what that is worth.
- *Lips*: one cylinder (Table IV).
"""

from glossa.tract.lips import LIPS, Lips
from glossa.tract.section import Section
from glossa.tract.tract import Tract, area_function, cut_tract

__all__ = ["LIPS", "Lips", "Section", "Tract", "area_function", "cut_tract"]
