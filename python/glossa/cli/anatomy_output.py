"""What the command line prints of a speaker's anatomy."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from rich.console import Console
from rich.table import Table

from glossa.anatomy.quality import Quality
from glossa.anatomy.shape import ShapeParameter
from glossa.anatomy.speaker import Speaker
from glossa.cli.output import number


def speaker_json(speaker: Speaker) -> dict[str, Any]:
    """Counts, volume, quality and muscles."""
    return {
        "speaker": speaker.name,
        "nodes": len(speaker.nodes),
        "hexahedra": len(speaker.hexahedra),
        "volume_cm3": number(speaker.volume * 1e6, 6),
        "least_scaled_jacobian": number(float(speaker.scaled_jacobians.min()), 6),
        "quality": quality_json(speaker.quality()),
        "muscles": muscles_json(speaker),
        "node_sets": {name: len(nodes) for name, nodes in speaker.node_sets.items()},
        "contours": {name: len(nodes) for name, nodes in speaker.contours.items()},
        "walls": list(speaker.walls),
        "contact_faces": {name: len(faces) for name, faces in speaker.contact_faces.items()},
        "hyoid": speaker.hyoid is not None,
        "fingerprint": speaker.fingerprint,
    }


def quality_json(quality: Quality) -> dict[str, Any]:
    """The quality report, lengths in mm."""
    return {
        "scaled_jacobian": {
            "min": number(quality.jacobian_min, 6),
            "percentile_5": number(quality.jacobian_low, 6),
            "median": number(quality.jacobian_median, 6),
        },
        "elements_below_0.3": quality.below_good,
        "elements_below_0.2": quality.below_poor,
        "element_volume_mm3": [number(volume * 1e9, 6) for volume in quality.element_volumes],
        "edge_length_mm": [number(length * 1e3, 6) for length in quality.edge_lengths],
        "clearance_mm": {wall: number(distance * 1e3, 6) for wall, distance in quality.clearance.items()},
        "notes": list(quality.notes),
    }


def muscles_json(speaker: Speaker) -> dict[str, Any]:
    """Size and force capacity of every muscle."""
    result: dict[str, Any] = {}
    for name, muscle in speaker.muscles.items():
        lengths = speaker.fibre_rest_lengths(name) * 1e3
        result[name] = {
            "fibres": len(muscle.fibres),
            "fibre_length_mm": [number(float(x), 6) for x in (lengths.min(), lengths.mean(), lengths.max())],
            "elements": len(muscle.elements),
            "volume_cm3": number(float(speaker.element_volumes[muscle.elements].sum() * 1e6), 6),
            "force_capacity_N": muscle.force_capacity,
        }
    return result


def shape_json(parameters: Mapping[str, ShapeParameter], values: Mapping[str, float]) -> dict[str, Any]:
    """Value, limits, unit and meaning of every shape parameter."""
    return {
        name: {
            "value": number(values[name]),
            "limits": list(parameter.limits),
            "unit": parameter.unit,
            "meaning": parameter.meaning,
        }
        for name, parameter in parameters.items()
    }


def print_muscles(speaker: Speaker) -> None:
    """A row for each muscle."""
    shown = Table(title=f"{speaker.name}: muscles", title_justify="left", title_style="bold")
    headings = ("", "fibres", "rest lengths, mm", "elements", "volume, cm³", "capacity, N")
    for heading in headings:
        shown.add_column(heading, justify="right" if heading else "left")
    for name, muscle in muscles_json(speaker).items():
        low, _, high = muscle["fibre_length_mm"]
        cells = (muscle["fibres"], f"{low:.1f} – {high:.1f}", muscle["elements"], f"{muscle['volume_cm3']:.1f}")
        shown.add_row(name, *map(str, cells), f"{muscle['force_capacity_N']:g}")
    Console().print(shown)


def print_shape(parameters: Mapping[str, ShapeParameter], values: Mapping[str, float]) -> None:
    """A row for each shape parameter."""
    shown = Table()
    for heading in ("", "value", "limits", "unit", "meaning"):
        shown.add_column(heading, justify="right" if heading in ("value", "limits") else "left")
    for name, parameter in parameters.items():
        low, high = parameter.limits
        shown.add_row(name, f"{values[name]:g}", f"{low:g} .. {high:g}", parameter.unit, parameter.meaning)
    Console().print(shown)
