"""What ``--spatial-error`` prints: estimated errors of the mesh beside the postures."""

from __future__ import annotations

from typing import Any

import numpy as np
import xarray as xr
from rich.console import Console

from glossa.cli.output import number
from glossa.cli.study_tables import MM, cell, numbers, table_of

LARGE = 0.1
"""Muscles whose force is off by less in every posture are not listed, N."""


def print_spatial_errors(errors: xr.Dataset) -> None:
    """Of :func:`glossa.studies.spatial_errors`: mm, N by muscle, Hz."""
    console = Console()
    console.print(
        "Estimated error of the mesh; forces and formants: what the limit of fine meshes has more", highlight=False
    )
    large = errors["muscle"].values[(abs(errors["forces"]) >= LARGE).any("posture").to_numpy()].tolist()
    names = errors["posture"].values.tolist()
    shown = table_of("", *(f"/{name}/" for name in names))
    for title, key in (("nodes on the mean, mm", "root_mean_square"), ("farthest node, mm", "largest")):
        shown.add_row(title, *(cell(float(value) * MM) for value in errors[key]))
    for muscle in large:
        shown.add_row(f"{muscle}, N", *(cell(float(value), sign="+") for value in errors["forces"].sel(muscle=muscle)))
    if bool(np.isfinite(errors["formants"]).any()):
        for formant in errors["formant"].values.tolist():
            row = errors["formants"].sel(formant=formant)
            shown.add_row(f"F{formant}, Hz", *(cell(float(value), 0, "+") for value in row))
    shown.add_row("time, s", *(cell(float(value), 1) for value in errors["cpu_seconds"]))
    console.print(shown)
    for name in names:
        reason = str(errors["reason"].sel(posture=name).item())
        if reason:
            console.print(f"note: /{name}/: {reason}", style="dim", highlight=False)


def spatial_json(errors: xr.Dataset, name: str) -> dict[str, Any]:
    """One posture; null where nothing is known."""
    row = errors.sel(posture=name)
    forces = zip(errors["muscle"].values.tolist(), row["forces"].values.tolist(), strict=True)
    areas = zip(errors["wall"].values.tolist(), (row["touched_areas"] * MM**2).values.tolist(), strict=True)
    return {
        "root_mean_square_mm": number(float(row["root_mean_square"]) * MM),
        "largest_mm": number(float(row["largest"]) * MM),
        "forces_N": {muscle: number(force) for muscle, force in forces},
        "formants_Hz": numbers(row["formants"], 3),
        "touched_areas_mm2": {wall: number(area, 6) for wall, area in areas},
        "seconds": number(float(row["cpu_seconds"]), 6),
        "reason": str(row["reason"].item()),
    }
