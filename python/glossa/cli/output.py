"""What the command line prints: tables for people, JSON for machines."""

from __future__ import annotations

import json
import math
import sys
from collections.abc import Callable, Mapping
from functools import wraps
from pathlib import Path
from typing import Any, ParamSpec, TypeVar

import numpy as np
import typer
import xarray as xr
from rich.console import Console
from rich.table import Table

from glossa import paper
from glossa.errors import InputError, SolveError
from glossa.palatogram import palatogram
from glossa.results import Movement, Posture
from glossa.scene import Scene
from glossa.studies import contact_over_time, contact_table, displacements_mm, tracked_nodes
from glossa.studies.failure import reason_of

_Parameters = ParamSpec("_Parameters")
_Result = TypeVar("_Result")


def guarded(command: Callable[_Parameters, _Result]) -> Callable[_Parameters, _Result]:
    """Decorator of commands: a fault becomes one line on stderr and an exit code."""

    @wraps(command)
    def run(*args: _Parameters.args, **options: _Parameters.kwargs) -> _Result:
        try:
            return command(*args, **options)
        except SolveError as error:
            raise failure(reason_of(error), 1) from error
        except (InputError, ImportError, OSError) as error:
            raise failure(str(error), 2) from error
        except KeyboardInterrupt as stop:
            raise failure(reason_of(stop) or "interrupted", 130) from stop

    return run


def failure(message: str, code: int) -> typer.Exit:
    """Say what went wrong in one line; the exit to raise."""
    say(" ".join(message.split()))
    return typer.Exit(code)


def say(message: str) -> None:
    """One line on stderr."""
    sys.stderr.write(f"glossa: {message}\n")


def wrote(path: Path) -> None:
    """Tell of a file, on stderr."""
    say(f"wrote {path}")


# JSON


def print_json(value: Mapping[str, Any]) -> None:
    """One JSON object on stdout."""
    sys.stdout.write(json.dumps(value, ensure_ascii=False, indent=2, allow_nan=False) + "\n")


def posture_json(
    table: xr.Dataset, name: str, posture: Posture, formants: xr.Dataset | None = None, *, epg: bool = False
) -> dict[str, Any]:
    """One posture and its row of :func:`glossa.studies.posture_table`; null where it has not converged.

    "formants_Hz" is null where ``formants``, of :func:`glossa.studies.formant_table`, has no row for the posture.
    "contact" is null without contact, "hyoid_displacement_mm" (x, z) with a fixed hyoid. "palatogram" is there only
    with ``epg``: rows of 1 and 0, a blank where there is no electrode.
    """
    around = contact_table({name: posture}).sel(posture=name)
    row = table.sel(posture=name)
    forces = zip(table["muscle"].values.tolist(), row["forces"].values.tolist(), strict=True)
    return {
        "converged": bool(row["converged"]),
        "forces_N": {muscle: number(force) for muscle, force in forces},
        "formants_Hz": None if formants is None or name not in formants["tract"] else _formants_json(formants, name),
        "tip_displacement_mm": [number(x) for x in row["displacement"].sel(point="tip").values.tolist()],
        "dorsum_displacement_mm": [number(x) for x in row["displacement"].sel(point="dorsum").values.tolist()],
        "contact": None if posture.contact is None else _contact_json(around),
        "hyoid_displacement_mm": None if posture.hyoid is None else _hyoid_json(around),
        **({"palatogram": _palatogram_json(posture)} if epg else {}),
        "iterations": int(row["iterations"]),
        "seconds": number(float(row["seconds"]), 6),
    }


def _contact_json(around: xr.Dataset) -> dict[str, Any]:
    """By wall, area and force; over time where there is a dimension time."""
    return {
        wall: {
            "area_mm2": _numbers(around["area"].sel(wall=wall).values.tolist()),
            "force_N": _numbers(around["force"].sel(wall=wall).values.tolist()),
        }
        for wall in around["wall"].values.tolist()
    }


def _hyoid_json(around: xr.Dataset) -> Any:
    """X and z, mm; over time where there is a dimension time."""
    return _numbers(around["hyoid_displacement"].sel(axis=["x", "z"]).values.tolist())


def _formants_json(formants: xr.Dataset, name: str) -> Any:
    return _numbers(formants["frequency"].sel(tract=name).values.tolist(), 3)


def _palatogram_json(posture: Posture) -> dict[str, Any]:
    gram = palatogram(posture)
    signs = np.ma.MaskedArray(np.where(gram.rows.data, "1", "0"), mask=gram.rows.mask)
    return {"percent": number(gram.percent, 3), "rows": ["".join(row) for row in signs.filled(" ").tolist()]}


def movement_json(movement: Movement, name: str) -> dict[str, Any]:
    """Times, displacements of tip and dorsum, and forces."""
    rest = movement.speaker.nodes
    moved = {
        f"{point}_displacement_mm": ((movement.positions[:, node] - rest[node])[:, [0, 2]] * 1e3).round(6).tolist()
        for point, node in tracked_nodes(movement.speaker).items()
    }
    forces = movement.forces
    around = contact_over_time(movement)
    return {
        "speaker": movement.speaker.name,
        "vowel": name,
        "converged": movement.report.converged,
        "times_s": movement.times.tolist(),
        "forces_N": {muscle: forces[muscle].round(6).tolist() for muscle in forces},
        **moved,
        "contact": None if movement.contact is None else _contact_json(around),
        "hyoid_displacement_mm": None if movement.hyoid is None else _hyoid_json(around),
        "steps": movement.report.steps,
        "seconds": number(movement.report.seconds["total"], 6),
    }


def costs_json(costs: xr.Dataset) -> dict[str, Any]:
    """The table of :func:`glossa.studies.effect_costs`."""
    scenes: dict[str, Any] = {}
    for scene in costs["scene"].values.tolist():
        row = costs.sel(scene=scene)
        scenes[scene] = {
            "seconds": number(float(row["seconds"]), 6),
            "contact_seconds": number(float(row["contact_seconds"]), 6),
            **{name: int(row[name]) for name in ("factorisations", "residuals", "stages")},
        }
    changes = {
        effect: {
            name: number(float(costs[name].sel(effect=effect)), 6) for name in ("tip_change_largest", "tip_change_end")
        }
        for effect in costs["effect"].values.tolist()
    }
    facts = {name: costs.attrs[name] for name in ("speaker", "vowel", "until_s", "dt_s", "integrator", "repetitions")}
    return {**facts, "mirror": bool(costs.attrs["mirror"]), "scenes": scenes, "left_out_mm": changes}


def number(value: float, digits: int = 9) -> float | None:
    """A number for JSON, rounded; None where not finite."""
    return round(value, digits) + 0.0 if math.isfinite(value) else None


def _numbers(values: Any, digits: int = 6) -> Any:
    """Numbers in nested lists, rounded; None where not finite."""
    return [_numbers(value, digits) for value in values] if isinstance(values, list) else number(values, digits)


# Tables


def print_postures(scene: Scene, postures: Mapping[str, Posture], table: xr.Dataset, *, epg: bool = False) -> None:
    """Forces beside Table II, displacements, contact; for postures without a row in Table II, active muscles only."""
    console = Console()
    console.print(f"{scene.speaker.name}: {', '.join(scene.effects)}", style="bold", highlight=False, soft_wrap=True)
    console.print("Muscle forces, N" + (": here / paper's Table II" if _in_table_2(table) else ""), highlight=False)
    console.print(_force_table(table))
    console.print("Displacement from rest, mm: x backward, z upward", highlight=False)
    console.print(_displacement_table(postures, table))
    contact, hyoid = scene.contact, scene.hyoid == "mobile"
    if contact or hyoid:
        words = ["Contact: area, mm² / force, N"] * contact + ["Hyoid: displacement x / z, mm"] * hyoid
        console.print(". ".join(words), highlight=False)
        console.print(_surroundings_table(postures, contact=contact, hyoid=hyoid))
    if epg:
        _print_palatograms(console, postures)
    for note in scene.notes:
        console.print(f"note: {note}", style="dim", highlight=False)


def _force_table(table: xr.Dataset) -> Table:
    published = paper.forces()
    shown = Table()
    shown.add_column("")
    names = table["posture"].values.tolist()
    for name in names:
        shown.add_column(_slashed(name), justify="right")
    for muscle in table["muscle"].values.tolist():
        cells = []
        if not _in_table_2(table) and not (table["forces"].sel(muscle=muscle) >= 0.005).any():
            continue
        for name in names:
            own = f"{float(table['forces'].sel(posture=name, muscle=muscle)):.2f}"
            known = name in published.index and muscle in published.columns
            cells.append(f"{own} / {float(published.loc[name, muscle]):5.2f}" if known else own)
        shown.add_row(muscle, *cells)
    return shown


def _in_table_2(table: xr.Dataset) -> bool:
    return any(name in paper.forces().index for name in table["posture"].values.tolist())


def _displacement_table(postures: Mapping[str, Posture], table: xr.Dataset) -> Table:
    shown = Table()
    for heading in ("", "tip x", "tip z", "dorsum x", "dorsum z", "iterations", "seconds"):
        shown.add_column(heading, justify="right" if heading else "left")
    for name in postures:
        row = table.sel(posture=name)
        moved = row["displacement"].values.ravel().tolist()
        count = f"{int(row['iterations'])}" if bool(row["converged"]) else "not converged"
        shown.add_row(_slashed(name), *(f"{x:+.1f}" for x in moved), count, f"{float(row['seconds']):.2f}")
    return shown


def _surroundings_table(postures: Mapping[str, Posture], *, contact: bool, hyoid: bool) -> Table:
    """A row for each wall that something touches, and one for a mobile hyoid."""
    around = contact_table(postures)
    shown = Table()
    shown.add_column("")
    for name in postures:
        shown.add_column(_slashed(name), justify="right")
    sizes = (around["force"] ** 2).sum("axis", skipna=False) ** 0.5
    for wall in around["wall"].values.tolist():
        areas, forces = around["area"].sel(wall=wall), sizes.sel(wall=wall)
        if bool((areas > 0.0).any()):
            pairs = zip(areas.values.tolist(), forces.values.tolist(), strict=True)
            shown.add_row(wall, *(f"{area:.0f} / {force:5.2f}" if area != 0.0 else "-" for area, force in pairs))
    if contact and not shown.row_count:
        shown.add_row("nothing touches")
    if hyoid:
        moved = around["hyoid_displacement"].sel(axis=["x", "z"]).values.tolist()
        shown.add_row("hyoid", *(f"{x:+.1f} / {z:+5.1f}" for x, z in moved))
    return shown


def print_formants(formants: xr.Dataset | None, reasons: Mapping[str, str]) -> None:
    """Formants beside Table IV, and why some are missing."""
    console = Console()
    if formants is not None:
        console.print("Formants, Hz: here / paper's Table IV. Tract length, glottis to lips, cm", highlight=False)
        published = paper.formants_simulated()
        shown = Table()
        for heading in ("", *(f"F{number}" for number in formants["formant"].values.tolist()), "length"):
            shown.add_column(heading, justify="right" if heading else "left")
        for name in formants["tract"].values.tolist():
            row = formants.sel(tract=name)
            cells = []
            for number, value in zip(row["formant"].values.tolist(), row["frequency"].values.tolist(), strict=True):
                own = f"{value:.0f}" if math.isfinite(value) else "-"
                known = name in published.index and f"F{number}_Hz" in published.columns
                cells.append(f"{own} / {float(published.loc[name, f'F{number}_Hz']):4.0f}" if known else own)
            shown.add_row(_slashed(name), *cells, f"{float(row['length']) * 1e2:.1f}")
        console.print(shown)
        causes = zip(formants["tract"].values.tolist(), formants["reason"].values.tolist(), strict=True)
        reasons = {**reasons, **{name: cause for name, cause in causes if cause}}
    for name, reason in reasons.items():
        console.print(f"note: no formants of {_slashed(name)}: {reason}", style="dim", highlight=False)


def _print_palatograms(console: Console, postures: Mapping[str, Posture]) -> None:
    """Side by side, front at the top."""
    console.print("Palatogram, front at the top; share of electrodes touched", highlight=False)
    shown = Table.grid(padding=(0, 3))
    grams = {name: palatogram(posture) for name, posture in postures.items()}
    shown.add_row(*(f"{_slashed(name)}  {gram.percent:.0f} %" for name, gram in grams.items()))
    shown.add_row(*(gram.text() for gram in grams.values()))
    console.print(shown, highlight=False)


def print_movement(movement: Movement, name: str) -> None:
    """Final forces and displacements, and what the movement took."""
    console = Console()
    end = movement.at(float(movement.times[-1]))
    moved = displacements_mm(end)
    report = movement.report
    console.print(f"{movement.speaker.name}: movement to {_slashed(name)}", style="bold", highlight=False)
    console.print(
        f"{movement.times[-1] * 1e3:g} ms in {report.steps} steps ({report.rejected} repeated), "
        f"{report.seconds['total']:.2f} s of computing",
        highlight=False,
    )
    for point, (x, z) in moved.items():
        console.print(f"{point} at the end: x {x:+.1f} mm (backward), z {z:+.1f} mm (upward)", highlight=False)
    forces = end.forces
    active = ", ".join(f"{muscle} {force:.2f}" for muscle, force in forces.items() if force >= 0.005)
    console.print(f"forces at the end, N: {active or 'none'}", highlight=False)
    if end.hyoid is not None:
        x, _, z = end.hyoid.displacement * 1e3
        console.print(f"hyoid at the end: x {x:+.1f} mm, z {z:+.1f} mm", highlight=False)
    if end.contact is not None:
        sizes = np.linalg.norm(end.contact.forces.to_numpy(), axis=1)
        pairs = zip(end.contact.touched_areas.items(), sizes.tolist(), strict=True)
        touched = ", ".join(f"{wall} {area * 1e6:.0f} mm², {force:.2f} N" for (wall, area), force in pairs if area > 0)
        console.print(f"contact at the end: {touched or 'nothing touches'}", highlight=False)


def print_costs(costs: xr.Dataset) -> None:
    """Seconds of each scene, and changes at the tip without each effect."""
    console = Console()
    facts = costs.attrs
    half = "mirrored" if facts["mirror"] else "full"
    console.print(
        f"{facts['speaker']}, {half}: {facts['until_s'] * 1e3:g} ms of {_slashed(facts['vowel'])}, "
        f"{facts['integrator']} {facts['dt_s'] * 1e3:g} ms; processor time, best of {facts['repetitions']}",
        style="bold",
        highlight=False,
    )
    shown = Table()
    for heading in ("", "seconds", "ratio", "in contact", "factorisations"):
        shown.add_column(heading, justify="right" if heading else "left")
    bare = float(costs["seconds"][0])
    for scene in costs["scene"].values.tolist():
        row = costs.sel(scene=scene)
        seconds = float(row["seconds"])
        cells = f"{seconds:.3f}", f"{seconds / bare:.2f}", f"{float(row['contact_seconds']):.3f}"
        shown.add_row(scene, *cells, f"{int(row['factorisations'])}")
    console.print(shown)
    without = Table()
    for heading in ("all effects, but without", "tip moves otherwise by, mm: at most", "at the end"):
        without.add_column(heading, justify="left" if heading.startswith("all") else "right")
    for effect in costs["effect"].values.tolist():
        row = costs.sel(effect=effect)
        without.add_row(effect, f"{float(row['tip_change_largest']):.2f}", f"{float(row['tip_change_end']):.2f}")
    console.print(without)


def _slashed(name: str) -> str:
    return f"/{name}/" if name in paper.forces().index else name
