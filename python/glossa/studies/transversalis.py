"""The transversalis in a vowel: by reflex, silent, and activated voluntarily (section III.B).

In the paper's /i/ its command lies above its length at rest, so that only what stretches it makes it pull. The paper
argues from that force and shows no run without it; here is that run, and one with a command below the length at rest.
"""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import xarray as xr

from glossa.checks import positive_number
from glossa.errors import InputError, SolveError
from glossa.motor.commands import MotorCommands, vowel_commands
from glossa.scene import Scene
from glossa.studies.acoustics import posture_formants
from glossa.studies.failure import reason_of
from glossa.studies.midsagittal_nodes import MIDSAGITTAL_NODES, midsagittal_nodes
from glossa.studies.points import hyoid_pose
from glossa.studies.provenance import provenance
from glossa.studies.shape_measures import midsagittal_area, muscle_stretch, widening

CONDITIONS: tuple[str, ...] = ("reflex", "silent", "voluntary")
"""The vowel's own command; no transversalis; a command below its length at rest."""

VOLUNTARY = 0.95
"""Command of the voluntary condition: that of /u/, where the paper activates the muscle (Table III)."""

_MUSCLE = "Trans"


def transversalis(scene: Scene, vowel: str = "i", *, voluntary: float = VOLUNTARY) -> xr.Dataset:
    """A vowel with its own command of the transversalis, without the muscle, and with a voluntary command.

    Args:
        scene: of a speaker with the muscles of Table III and the contour "dorsum".
        vowel: of Table III, with a command of the transversalis of at least 1: /i/, or /ə/ and /a/.
        voluntary: command of the third condition, below 1.

    Returns:
        Over ``condition``: ``stretch``, length of the muscle's fibres over that at rest, hence the mean width of the
        tongue over that at rest; ``widening``, growth of the width where it grows most, m; ``midsagittal_area``, over
        that at rest; ``midsagittal_deformation``, root mean square displacement of the six midsagittal nodes from rest,
        m; ``displacement (…, node, axis)``, the same by node, m; ``forces (…, muscle)`` N; ``formants (…, formant)``
        Hz; ``positions (…, vertex, axis)`` m; ``hyoid (…, part, axis)``, pose of a mobile hyoid as in
        :func:`glossa.studies.gravity_at_rest`; ``converged``, ``reason``. NaN without equilibrium or without tract.

    Raises:
        InputError: an unknown vowel, a vowel or a voluntary command that is not what the study is about, or a speaker
            that lacks a muscle or the contour.
        SolveInterrupted: Ctrl-C.
    """
    own = vowel_commands(vowel)
    if own[_MUSCLE] < 1.0:
        raise InputError(f"/{vowel}/ activates {_MUSCLE} voluntarily ({own[_MUSCLE]:g}); choose a vowel that does not")
    if positive_number(voluntary, "voluntary command") >= 1.0:
        raise InputError(f"a voluntary command lies below 1, got {voluntary:g}")
    commands = {
        "reflex": own,
        "silent": MotorCommands({muscle: value for muscle, value in own.items() if muscle != _MUSCLE}),
        "voluntary": own.with_({_MUSCLE: voluntary}),
    }
    nodes = list(midsagittal_nodes(scene.speaker).values())
    found = [_measured(scene, commands[condition], vowel, nodes) for condition in CONDITIONS]
    units = {
        "stretch": "1",
        "widening": "m",
        "midsagittal_area": "1",
        "midsagittal_deformation": "m",
        "displacement": "m",
        "forces": "N",
        "formants": "Hz",
        "positions": "m",
        "hyoid": "m",
    }
    dims = {
        "displacement": ("node", "axis"),
        "forces": ("muscle",),
        "formants": ("formant",),
        "positions": ("vertex", "axis"),
        "hyoid": ("part", "axis"),
    }
    return xr.Dataset(
        {
            **{
                name: (("condition", *dims.get(name, ())), np.stack([one[name] for one in found]), {"units": unit})
                for name, unit in units.items()
            },
            "converged": (("condition",), np.array([one["converged"] for one in found])),
            "reason": (("condition",), np.array([one["reason"] for one in found], dtype=object)),
        },
        coords={
            "condition": list(CONDITIONS),
            "node": list(MIDSAGITTAL_NODES),
            "axis": ["x", "y", "z"],
            "muscle": list(scene.speaker.muscles),
            "formant": [1, 2, 3, 4],
            "part": ["displacement", "rotation", "centre"],
        },
        attrs=provenance(scene, "transversalis") | {"vowel": vowel, "voluntary": float(voluntary)},
    )


def _measured(scene: Scene, commands: MotorCommands, vowel: str, nodes: list[int]) -> dict[str, Any]:
    speaker = scene.speaker
    result: dict[str, Any] = {
        "stretch": math.nan,
        "widening": math.nan,
        "midsagittal_area": math.nan,
        "midsagittal_deformation": math.nan,
        "displacement": np.full((len(nodes), 3), math.nan),
        "forces": np.full(len(speaker.muscles), math.nan),
        "formants": np.full(4, math.nan),
        "positions": np.full(speaker.nodes.shape, math.nan),
        "hyoid": np.full((3, 3), math.nan),
        "converged": False,
        "reason": "",
    }
    try:
        posture = scene.equilibrate(commands)
    except SolveError as error:
        return result | {"reason": reason_of(error)}
    moved = posture.displacements[nodes]
    formants, reason = posture_formants(posture, vowel)
    at_rest = midsagittal_area(speaker, speaker.nodes)
    return result | {
        "stretch": muscle_stretch(posture, _MUSCLE),
        "widening": widening(posture),
        "midsagittal_area": midsagittal_area(speaker, posture.positions) / at_rest,
        "midsagittal_deformation": math.sqrt(float((moved**2).sum(axis=1).mean())),
        "displacement": moved,
        "forces": posture.forces.to_numpy(),
        "positions": posture.positions,
        "converged": True,
        "hyoid": hyoid_pose(posture),
        "formants": formants,
        "reason": reason,
    }
