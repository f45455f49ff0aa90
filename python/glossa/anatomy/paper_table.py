"""Muscle force capacities of the paper (Buchaillard, Perrier & Payan 2009, Table I)."""

from __future__ import annotations

import csv

from glossa.data_files import data_path

#: the paper's muscle names, in the order of Table III
MUSCLE_NAMES = ("GGa", "GGm", "GGp", "Sty", "HG", "Vert", "Trans", "IL", "SL", "GH", "MH")


def force_capacities() -> dict[str, float]:
    """rho(m) by muscle, N, total over left and right; read from data/paper/table1_force_capacity.csv."""
    with data_path("paper/table1_force_capacity.csv").open(encoding="utf-8", newline="") as lines:
        rows = csv.DictReader(line for line in lines if line.strip() and not line.startswith("#"))
        return {row["muscle"].strip(): float(row["force_capacity_N"]) for row in rows}
