"""What ``glossa accuracy`` prints: tables, Markdown for README.md, JSON."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
import pandas as pd
import xarray as xr
from rich.console import Console

from glossa.cli.output import number
from glossa.cli.study_tables import MM, cell, print_title, table_of
from glossa.studies.accuracy_choices import AGAINST, KINDS, MESH, POSTURE, WHOLE
from glossa.studies.accuracy_summary import COSTS, MEASURES, cheapest, pareto, presets, savings, worst

WITHIN = 0.1e-3
"""Error at every node and time that the cheapest movement is named for, m (issue 7's)."""

_SCALES = {"nodes": MM, "largest": MM, "force": 1.0, "formant": 1.0}
_UNITS = {"nodes": "mm", "largest": "mm", "force": "N", "formant": "Hz"}
_ERRORS = ("six nodes, mm", "any node, mm", "force, N", "formant, Hz")
_SHORT = ("nodes", "any", "N", "Hz")
_WIDE = 110  # characters, from which counts have room
_TIMES = ("wall, s", "CPU, s")
_NOUNS = {"posture": "equilibria", "movement": "movements"}


def print_accuracy(study: xr.Dataset) -> None:
    """Every choice, those marked that pay; presets; effects; machine."""
    console = Console()
    print_title(console, study, "what accuracy costs")
    console.print(_facts(study), highlight=False)
    console.print("Largest error: mm at six nodes, mm at any node, N, Hz. Mean time: s", highlight=False)
    table, pays, wide = worst(study), _pays(study), console.width >= _WIDE
    for kind in _kinds(study):
        console.print(f"{_headline(study, kind)}; * pays: nothing is quicker and more exact", highlight=False)
        shown = table_of("", *_SHORT, "wall", "CPU", *(("iterations", "factorisations") if wide else ()))
        for place in np.flatnonzero(((table["kind"] == kind) & (table["against"] != WHOLE)).to_numpy()).tolist():
            one = table.isel(choice=place)
            counted = [cell(float(one[name]), 0) for name in ("iterations", "factorisations")] if wide else []
            mark = " *" if pays[place] else ""
            times = (cell(float(one[cost])) for cost in COSTS)
            shown.add_row(f"{_name(one)}{mark}", *_errors(one), *times, *counted)
        console.print(shown)
    console.print("Presets", highlight=False)
    shown = table_of("", *_SHORT, "wall", "CPU")
    for kind, accuracy, row in _records(presets(study)):
        shown.add_row(f"{_NOUNS[kind]}, {accuracy}", *_preset_cells(row))
    console.print(shown)
    console.print("Effects left out: what changes, and how much processor time it saves", highlight=False)
    shown = table_of("", *_SHORT, "CPU", "saved, %")
    for kind, effect, row in _records(savings(study)):
        shown.add_row(f"{_NOUNS[kind]}, {effect}", *_saving_cells(row))
    console.print(shown)
    for line in _notes(study):
        console.print(line, style="dim", highlight=False)


def accuracy_markdown(study: xr.Dataset) -> str:
    """Presets, choices that pay, and effects, for README.md."""
    parts = [_facts(study), "", *_table(("", *_ERRORS, *_TIMES), _preset_rows(study)), ""]
    parts += ["Choices that pay, nothing being both quicker and more exact:", ""]
    parts += [*_table(("", *_ERRORS, *_TIMES), _paying_rows(study)), ""]
    parts += ["Effects left out: what changes, and the share of the processor time that it saves:", ""]
    parts += _table(("", *_ERRORS, "CPU, s", "saved, %"), _saving_rows(study))
    return "\n".join([*parts, "", *_notes(study)])


def _preset_rows(study: xr.Dataset) -> list[list[str]]:
    return [[f'{_NOUNS[kind]}, `"{name}"`', *_preset_cells(row)] for kind, name, row in _records(presets(study))]


def _saving_rows(study: xr.Dataset) -> list[list[str]]:
    return [[f"{_NOUNS[kind]}, {name}", *_saving_cells(row)] for kind, name, row in _records(savings(study))]


def _paying_rows(study: xr.Dataset) -> list[list[str]]:
    table, rows = worst(study), []
    places = np.flatnonzero(_pays(study))
    order = np.lexsort((table["wall_seconds"].to_numpy()[places], table["kind"].to_numpy()[places] != POSTURE))
    listed = set[tuple[float, ...]]()
    for place in places[order].tolist():
        one = table.isel(choice=place)
        same = tuple(float(one[name]) for name in (*MEASURES, *COSTS))
        if same in listed:  # the standard belongs to several families
            continue
        listed.add(same)
        rows.append(
            [
                f"{_NOUNS[one['kind'].item()]}, {_name(one)}",
                *_errors(one),
                *(cell(float(one[cost]), 2) for cost in COSTS),
            ]
        )
    return rows


def _table(headings: Sequence[str], rows: Sequence[Sequence[str]]) -> list[str]:
    lines = [headings, ["---"] * len(headings), *rows]
    return ["| " + " | ".join(line) + " |" for line in lines]


def accuracy_json(study: xr.Dataset) -> dict[str, Any]:
    """Every choice with the errors of every vowel; presets, effects, references, machine."""
    pays = {measure: pareto(study, measure).to_numpy() for measure in MEASURES}
    choices = [
        {
            **{name: study[name].values[place] for name in ("kind", "family", "label", "setting_units", "against")},
            "setting": number(float(study["setting"][place])),
            "pays": {measure: bool(flags[place]) for measure, flags in pays.items()},
            "vowels": _by_vowel(study.isel(choice=place)),
        }
        for place in range(study.sizes["choice"])
    ]
    references = {
        f"{against}, {vowel}": {
            name.removeprefix("reference_"): number(float(study[name].sel(reference=against, vowel=vowel)))
            for name in ("reference_nodes", "reference_largest", "reference_force", "reference_formant")
        }
        for against in study["reference"].values.tolist()
        for vowel in study["vowel"].values.tolist()
    }
    return {
        "facts": {name: _json_value(value) for name, value in study.attrs.items()},
        "against": dict(AGAINST),
        "choices": choices,
        "presets": _frame_json(presets(study)),
        "effects": _frame_json(savings(study)),
        "references_SI": references,
    }


def _by_vowel(one: xr.Dataset) -> dict[str, Any]:
    found = {}
    for vowel in one["vowel"].values[one["asked"].to_numpy()].tolist():
        row = one.sel(vowel=vowel)
        nodes = zip(one["node"].values.tolist(), (row["node_error"].to_numpy() * MM).tolist(), strict=True)
        forces = zip(one["muscle"].values.tolist(), row["force_error"].values.tolist(), strict=True)
        found[vowel] = {
            "nodes_mm": {name: number(value) for name, value in nodes},
            "largest_mm": number(float(row["largest_error"]) * MM),
            "force_N": {name: number(value) for name, value in forces},
            "formant_Hz": [number(value, 6) for value in row["formant_error"].values.tolist()],
            "stated_mm": number(float(row["stated_error"]) * MM),
            **{name: number(float(row[name]), 6) for name in (*COSTS, "iterations", "factorisations", "steps")},
            "reason": str(row["reason"].item()),
        }
    return found


def _frame_json(table: pd.DataFrame) -> dict[str, Any]:
    return {
        f"{kind}, {name}": {column: number(value) for column, value in row.items()}
        for kind, name, row in _records(table)
    }


def _json_value(value: Any) -> Any:
    return value.item() if isinstance(value, np.generic) else value


# Cells


def _records(table: pd.DataFrame) -> list[tuple[str, str, dict[str, float]]]:
    """Kind, name and numbers of each row."""
    kinds, names = (table.index.get_level_values(level).tolist() for level in (0, 1))
    columns = [str(name) for name in table.columns]
    rows = [dict(zip(columns, values, strict=True)) for values in table.to_numpy(dtype=float).tolist()]
    return list(zip(kinds, names, rows, strict=True))


def _name(one: xr.Dataset) -> str:
    return f"{one['family'].item()}: {one['label'].item()}"


def _facts(study: xr.Dataset) -> str:
    facts = study.attrs
    half = "mirrored" if "mirror" in facts["effects"] else "full"
    threads = f"{facts['threads']} thread{'' if facts['threads'] == 1 else 's'}"
    return (
        f"{facts['processor']}, {facts['cores']} cores, {facts['kernel']}, {threads}, {facts['load']:g} processes "
        f"running on the mean; {half}; movements of {facts['until_s'] * MM:g} ms; {facts['settings']} settings, "
        f"best of {facts['repetitions']}"
    )


def _headline(study: xr.Dataset, kind: str) -> str:
    asked = study["asked"].isel(choice=(study["kind"] == kind).to_numpy()).any("choice")
    vowels = " ".join(f"/{vowel}/" for vowel in study["vowel"].values[asked.to_numpy()].tolist())
    return f"{_NOUNS[kind].capitalize()} ({vowels})"


def _notes(study: xr.Dataset) -> list[str]:
    """What the references are, how good, and what is cheap enough."""
    used = [against for against in AGAINST if bool((study["against"] == against).any())]
    lines = [f"Errors of {_words_for(against)} are against {AGAINST[against]}." for against in used if against != WHOLE]
    for against in study["reference"].values.tolist():
        away = float(study["reference_largest"].sel(reference=against).max())
        if np.isfinite(away):
            noun = "equilibria" if against == "solve" else "movements"
            lines.append(f"The reference of {noun} is {away * MM:.2g} mm from the next coarser one, at any node.")
    if "movement" in _kinds(study):
        best = cheapest(study, largest=WITHIN)
        lines.append(f"The quickest movement within {WITHIN * MM:g} mm at every node: {best or 'none'}.")
    return lines


def _words_for(against: str) -> str:
    return {MESH: "mesh and element", "solve": "other equilibria", "steps": "movements"}[against]


def _kinds(study: xr.Dataset) -> list[str]:
    return [kind for kind in KINDS if bool((study["kind"] == kind).any())]


def _pays(study: xr.Dataset) -> np.ndarray:
    """By the error at the six nodes, against the clock."""
    return pareto(study).to_numpy()


def _errors(one: xr.Dataset) -> list[str]:
    return [_short(float(one[name]) * scale) for name, scale in _SCALES.items()]


def _preset_cells(row: Mapping[str, float]) -> list[str]:
    errors = [_short(row[f"{name}_{unit}"]) for name, unit in _UNITS.items()]
    return [*errors, cell(row["wall_s"]), cell(row["cpu_s"])]


def _saving_cells(row: Mapping[str, float]) -> list[str]:
    errors = [_short(row[f"{name}_{unit}"]) for name, unit in _UNITS.items()]
    return [
        *errors,
        cell(row["cpu_s"]),
        cell(round(100.0 * row["saved"]) + 0.0, 0) if np.isfinite(row["saved"]) else "-",
    ]


def _short(value: float) -> str:
    """Two digits, or a dash where there is no number."""
    return f"{value:.2g}" if abs(value) < 10.0 else f"{value:.0f}" if np.isfinite(value) else "-"
