"""Commands that run many points: sweeps."""

from __future__ import annotations

import contextlib
import math
from collections.abc import Mapping
from typing import Annotated, Any

import numpy as np
import typer
import xarray as xr
from rich.console import Console
from rich.table import Table

from glossa.checks import whole_number
from glossa.cli import output
from glossa.cli.files import write_netcdf
from glossa.cli.options import (
    ContactOption,
    FrictionOption,
    GravityOption,
    HyoidOption,
    JsonOption,
    LandmarksOption,
    MirrorOption,
    ResolutionOption,
    SaveOption,
    SchedulerOption,
    SpeakerOption,
    StoreOption,
    WorkersOption,
    check_output,
    make_scene,
    make_speaker,
    vowel_name,
)
from glossa.cli.running import study_bar, study_executor
from glossa.errors import InputError
from glossa.motor.commands import VOWELS
from glossa.studies.designs import NORMAL, Design, grid, latin_hypercube, monte_carlo
from glossa.studies.sweep import sweep

_MOST_ROWS = 50  # of the table of points


@output.guarded
def sweep_command(
    axis: Annotated[
        list[str],
        typer.Option(
            "--axis",
            "-a",
            metavar="NAME=VALUES",
            help="What varies (repeat): NAME=LOW:HIGH:COUNT, NAME=A,B,C; with --latin and --random NAME=LOW:HIGH or "
            "NAME=normal:MEAN:SD. Vectors: gravity=7/0/-7. An unknown NAME lists those there are.",
        ),
    ],
    base: Annotated[
        str, typer.Option("--base", "-b", metavar="VOWEL", help="Commands and lips that axes change; none: silent.")
    ] = "i",
    latin: Annotated[
        int | None, typer.Option("--latin", metavar="N", help="N points of a Latin hypercube in place of a grid.")
    ] = None,
    random: Annotated[
        int | None, typer.Option("--random", metavar="N", help="N random points in place of a grid.")
    ] = None,
    seed: Annotated[int | None, typer.Option("--seed", metavar="SEED", help="Of --latin and --random.")] = None,
    warm: Annotated[
        bool, typer.Option("--warm", help="Start from the base's posture, and from rest where that fails.")
    ] = False,
    store: StoreOption = None,
    retry_failed: Annotated[
        bool, typer.Option("--retry-failed", help="Compute points again that failed in an earlier run.")
    ] = False,
    workers: WorkersOption = 1,
    scheduler: SchedulerOption = None,
    save: SaveOption = None,
    speaker: SpeakerOption = "reference",
    resolution: ResolutionOption = 1,
    landmarks: LandmarksOption = None,
    gravity: GravityOption = "upright",
    contact: ContactOption = None,
    friction: FrictionOption = 0.1,
    hyoid: HyoidOption = None,
    mirror: MirrorOption = None,
    as_json: JsonOption = False,
) -> None:
    """Equilibria over a grid or sample of motor commands, tissue, gravity, lips or shape of the speaker."""
    check_output(save, (".nc",))
    whole_number(workers, "--workers", 1, 1000)
    design = _design(axis, latin, random, seed)
    commands = None if base == "none" else vowel_name(base)
    scene = make_scene(make_speaker(speaker, resolution, landmarks), gravity, mirror, contact, friction, hyoid)
    start = scene.equilibrate({} if commands is None else VOWELS[commands]) if warm else None
    with study_executor(workers, scheduler) as executor, study_bar() as progress:
        result = sweep(
            scene,
            design,
            commands,
            store=store,
            executor=executor,
            start=start,
            progress=progress,
            retry_failed=retry_failed,
        )
    if as_json:
        output.print_json(_as_json(result, design))
    else:
        _print(result, design)
    write_netcdf(result, save)
    failed = int((result["status"] != "converged").sum())
    if failed:
        reason = str(result["reason"].to_numpy()[np.flatnonzero(result["status"] != "converged")[0]])
        raise output.failure(f"{failed} of {len(design)} points failed, the first: {reason}", 1)


# Options


def _design(axes: list[str], latin: int | None, random: int | None, seed: int | None) -> Design:
    parts = [one.partition("=") for one in axes]
    names = [name.strip() for name, _, _ in parts]
    for name, equals, _ in parts:
        if not equals or not name.strip():
            raise InputError(f"--axis must be NAME=VALUES, got {name!r}")
    if len(set(names)) < len(names):
        raise InputError(f"--axis names {next(n for n in names if names.count(n) > 1)!r} twice")
    given = dict(zip(names, (text.strip() for _, _, text in parts), strict=True))
    if latin is None and random is None:
        if seed is not None:
            raise InputError("--seed belongs to --latin or --random; a grid has no chance in it")
        return grid({name: _values(name, text) for name, text in given.items()})
    if latin is not None and random is not None:
        raise InputError("choose one of --latin and --random")
    if seed is None:
        raise InputError("--latin and --random need --seed, so that the same points can be drawn again")
    ranges = {name: _range(name, text) for name, text in given.items()}
    if latin is not None:
        return latin_hypercube(ranges, latin, seed)
    assert random is not None
    return monte_carlo(ranges, random, seed)


def _values(name: str, text: str) -> list[Any]:
    """LOW:HIGH:COUNT or A,B,C."""
    if ":" not in text:
        return [_value(one.strip()) for one in text.split(",")]
    parts = text.split(":")
    if len(parts) != 3 or not parts[2].strip().isdigit() or int(parts[2]) < 2:
        raise InputError(f"--axis {name}: a grid needs LOW:HIGH:COUNT, COUNT at least 2, or A,B,C; got {text!r}")
    low, high = (_number(name, part) for part in parts[:2])
    values: list[Any] = np.linspace(low, high, int(parts[2])).tolist()
    return values


def _value(text: str) -> Any:
    """A number, a vector with slashes, or a name."""
    for words in ([text], text.split("/")):
        with contextlib.suppress(ValueError):
            numbers = tuple(float(word) for word in words)
            return numbers[0] if len(numbers) == 1 else numbers
    return "ə" if text == "@" else text


def _range(name: str, text: str) -> Any:
    parts = text.split(":")
    if len(parts) == 3 and parts[0].strip() == NORMAL:
        return (NORMAL, *(_number(name, part) for part in parts[1:]))
    if len(parts) != 2:
        raise InputError(f"--axis {name}: a sample needs LOW:HIGH or normal:MEAN:SD, got {text!r}")
    return tuple(_number(name, part) for part in parts)


def _number(name: str, text: str) -> float:
    try:
        return float(text)
    except ValueError:
        raise InputError(f"--axis {name}: {text!r} is no number") from None


# Output


def _as_json(result: xr.Dataset, design: Design) -> dict[str, Any]:
    rows = [_row_json(result.isel(point=number), design) for number in range(result.sizes["point"])]
    return {
        "speaker": result.attrs["speaker"],
        "design": {"method": design.method, "axes": list(design.axes), "seed": design.seed},
        "converged": int((result["status"] == "converged").sum()),
        "points": rows,
    }


def _row_json(row: xr.Dataset, design: Design) -> dict[str, Any]:
    formants = [output.number(value, 3) for value in row["formants"].to_numpy().tolist()]
    moved = row["displacement"].sel(axis=["x", "z"]).to_numpy() * 1e3
    nodes = row["node"].to_numpy().tolist()
    return {
        "axes": {name: row[name].item() for name in design.axes},
        "status": str(row["status"].item()),
        "reason": str(row["reason"].item() or row["acoustic_reason"].item()),
        "forces_N": _named(row["muscle"].to_numpy().tolist(), row["forces"].to_numpy().tolist()),
        "formants_Hz": formants if "lips_area" in row else None,
        "displacement_mm": {
            name: [output.number(value, 6) for value in pair] for name, pair in zip(nodes, moved.tolist(), strict=True)
        },
        "started_from": str(row["started"].item()),
        "iterations": int(row["iterations"]),
        "seconds": output.number(float(row["seconds"]), 6),
    }


def _named(names: list[str], values: list[float]) -> Mapping[str, float | None]:
    return {name: output.number(value) for name, value in zip(names, values, strict=True)}


def _print(result: xr.Dataset, design: Design) -> None:
    console = Console()
    count = result.sizes["point"]
    good = int((result["status"] == "converged").sum())
    facts = f"{result.attrs['speaker']}: {design.method.replace('_', ' ')} of {count} points, {good} converged"
    console.print(facts, style="bold", highlight=False, soft_wrap=True)
    sounds = "lips_area" in result
    shown = Table()
    for heading in (*design.axes, *(["F1", "F2", "F3", "F4"] if sounds else []), "strongest muscle", "status"):
        shown.add_column(heading, justify="left" if heading == "status" else "right")
    for number in range(min(count, _MOST_ROWS)):
        row = result.isel(point=number)
        cells = [_cell(row[name].item()) for name in design.axes]
        if sounds:
            cells += [f"{value:.0f}" if math.isfinite(value) else "-" for value in row["formants"].to_numpy().tolist()]
        shown.add_row(*cells, _strongest(row), str(row["status"].item()))
    console.print(shown, highlight=False)
    if count > _MOST_ROWS:
        console.print(f"{count - _MOST_ROWS} more; --json and --save have all", style="dim", highlight=False)


def _cell(value: Any) -> str:
    return value if isinstance(value, str) else f"{value:.6g}"


def _strongest(row: xr.Dataset) -> str:
    forces = row["forces"].to_numpy()
    if not forces.size or not np.isfinite(forces).all() or forces.max() <= 0.0:
        return "-"
    return f"{row['muscle'].to_numpy()[forces.argmax()]} {forces.max():.2f} N"
