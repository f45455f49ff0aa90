"""The numbers of the paper: Buchaillard, Perrier & Payan (2009), J. Acoust. Soc. Am. 126(4), 2033-2051.

The tables are files under ``data/paper``, in the units printed; nothing here is converted to SI. Every reader returns a
fresh copy, so that changing a result changes no other.
"""

from __future__ import annotations

import csv
from collections.abc import Mapping
from dataclasses import dataclass
from functools import cache
from types import MappingProxyType

import pandas as pd

from glossa.data_files import data_path
from glossa.errors import InputError


@dataclass(frozen=True)
class Constant:
    """A constant printed in the paper.

    Attributes:
        symbol: symbol in the paper, empty where it has none.
        value: value in ``unit``.
        unit: unit, ``"1"`` for pure numbers.
        place: equation or section that states it.
    """

    symbol: str
    value: float
    unit: str
    place: str


@cache
def rows(name: str) -> tuple[Mapping[str, str], ...]:
    """Rows of one table as text, by column name; comment lines are left out.

    Args:
        name: file name under ``data/paper``, for example ``"table2_forces.csv"``.

    Raises:
        InputError: no such file, or a row with too few or too many cells.
    """
    with data_path(f"paper/{name}").open(encoding="utf-8", newline="") as file:
        reader = csv.DictReader(line for line in file if not line.startswith("#"))
        table = [dict(row) for row in reader]
    for number, row in enumerate(table, start=1):
        if None in row or None in row.values():
            raise InputError(f"data file paper/{name}: row {number} does not have {len(reader.fieldnames or [])} cells")
    return tuple(MappingProxyType(row) for row in table)


@cache
def _frame(name: str) -> pd.DataFrame:
    return pd.read_csv(data_path(f"paper/{name}"), comment="#", encoding="utf-8")


def force_capacity() -> pd.DataFrame:
    """Table I: index ``muscle``; columns ``area_mm2`` and ``force_capacity_N`` (rho, both sides together)."""
    return _frame("table1_force_capacity.csv").set_index("muscle")


def forces() -> pd.DataFrame:
    """Table II: muscle forces in N; index ``vowel``, one column for each muscle."""
    return _frame("table2_forces.csv").set_index("vowel")


def motor_commands() -> pd.DataFrame:
    """Table III: motor commands as fractions of rest length; index ``vowel``, one column for each muscle."""
    return _frame("table3_motor_commands.csv").set_index("vowel")


def formants_simulated() -> pd.DataFrame:
    """Table IV: index ``vowel``; ``lip_area_cm2``, ``lip_protrusion_cm`` and ``F1_Hz`` to ``F4_Hz``."""
    return _frame("table4_formants_simulated.csv").set_index("vowel")


def formants_measured() -> pd.DataFrame:
    """Table V: index ``vowel``; ``F1_Hz`` to ``F4_Hz`` of speaker PB. There is no /ə/."""
    return _frame("table5_formants_measured.csv").set_index("vowel")


def sensitivity_i() -> pd.DataFrame:
    """Table VI: index ``(muscle, change_percent)``, 56 rows; ``F1_Hz`` to ``F3_Hz`` of the changed /i/."""
    return _frame("table6_sensitivity_i.csv").set_index(["muscle", "change_percent"])


def single_muscles() -> pd.DataFrame:
    """Section III.A.1: what each muscle does alone.

    Columns: ``muscle``; ``command`` (fraction of rest length); ``region``; ``direction`` of motion; ``bound``, how
    ``displacement_mm`` is meant: ``about``, ``up_to``, ``below``, or ``unstated`` (a direction only, NaN).
    """
    return _frame("section3_single_muscles.csv").copy()


def transversalis() -> pd.DataFrame:
    """Section III.B: ``first``, ``second`` (conditions of /i/), ``quantity``, and ``sign`` of first minus second."""
    return _frame("section3_transversalis.csv").copy()


def dispersion() -> pd.DataFrame:
    """Section IV.B: index ``node``, tip to root; ``major_mm``, ``minor_mm``, ``angle_deg`` (NaN: none is clear)."""
    return _frame("section4_dispersion.csv").set_index("node")


def gravity() -> pd.DataFrame:
    """Sections V.A and V.B: ``control``, ``gravity``, ``quantity``, ``bound``, ``value``, ``unit``."""
    return _frame("section5_gravity.csv").copy()


@cache
def constants() -> Mapping[str, Constant]:
    """Constants of equations 1 to 6 and of the materials, by name, for example ``"reflex_delay"``."""
    return MappingProxyType(
        {
            row["name"]: Constant(row["symbol"], float(row["value"]), row["unit"], row["place"])
            for row in rows("constants.csv")
        }
    )


def constant(name: str) -> float:
    """Value of one constant, in the unit printed.

    Raises:
        InputError: the paper has no constant of this name.
    """
    try:
        return constants()[name].value
    except KeyError:
        raise InputError(f"no constant {name!r} in the paper; known: {', '.join(constants())}") from None
