"""What each effect costs in a movement, and what leaving it out changes."""

from __future__ import annotations

import time
from collections.abc import Mapping
from types import MappingProxyType
from typing import Any

import numpy as np
import xarray as xr

from glossa.anatomy.arrays import FloatArray
from glossa.anatomy.speaker import Speaker
from glossa.anatomy.walls import Wall
from glossa.checks import whole_number
from glossa.motor.commands import vowel_commands
from glossa.motor.schedule import Ramp
from glossa.results import Movement
from glossa.scene import Scene
from glossa.studies.points import tracked_nodes

OUT_OF_REACH = 0.05
"""How far all walls lie from the tongue at rest, m, where they are out of reach."""

BARE: Mapping[str, Any] = MappingProxyType({"contact": False, "friction": 0.0, "hyoid": "fixed", "gravity": None})
"""Options of a scene of tissue and muscles only."""

EFFECTS: Mapping[str, Mapping[str, Any]] = MappingProxyType(
    {
        "contact": {"contact": True},
        "friction": {"friction": 0.1},
        "hyoid": {"hyoid": "mobile"},
        "gravity": {"gravity": "upright"},
    }
)
"""Effects in the order in which they are added, and the options that bring them in."""

FAR = "contact, walls out of reach"


def effect_costs(
    speaker: Speaker,
    vowel: str = "i",
    until: float = 0.2,
    *,
    dt: float = 0.002,
    integrator: str = "BDF2",
    mirror: bool = True,
    repetitions: int = 3,
) -> xr.Dataset:
    """Processor time of a movement with effects added one by one, and what leaving each of them out changes.

    The first scene has tissue and muscles only; contact, friction, a mobile hyoid and gravity follow. One more scene
    is the first with walls that the tongue never comes near. Times are of the movement alone, without making the scene.

    Args:
        speaker: with walls and a hyoid.
        vowel: of Table III; its commands ramp up in 30 ms from rest.
        until: end of the movement, s.
        dt: time step, s.
        integrator: as in :meth:`glossa.Scene.simulate`.
        mirror: compute one half.
        repetitions: runs of each scene, all scenes in turn; the shortest counts.

    Returns:
        Dataset over ``scene`` with ``seconds``, of these ``contact_seconds`` in contact alone (by the clock), and
        ``factorisations``, ``residuals``, ``stages``; over ``effect`` what the tip of the full scene does differently
        without it: ``tip_change_largest`` over time and ``tip_change_end`` in mm. Without contact there is no friction
        either.

    Raises:
        InputError: an unknown vowel, no walls or no hyoid, or impossible numbers.
        SolveError, SolveInterrupted: as :meth:`glossa.Scene.simulate`.
    """
    own = vowel_commands(vowel)
    count = whole_number(repetitions, "repetitions", 1, 1000)
    schedule = Ramp(own)

    def move(scene: Scene) -> tuple[float, Movement]:
        begin = time.process_time()
        movement = scene.simulate(schedule, until, dt=dt, integrator=integrator)
        return time.process_time() - begin, movement

    scenes = _scenes(speaker, mirror=mirror)
    runs = [{name: move(scene) for name, scene in scenes.items()} for _ in range(count)]
    movements = {name: movement for name, (_, movement) in runs[0].items()}
    seconds = np.array([min(run[name][0] for run in runs) for name in scenes])
    in_contact = np.array([min(run[name][1].report.seconds["contact"] for run in runs) for name in scenes])
    changes = np.array([_tip_change(movements[_full_name()], without) for without in _left_out(speaker, mirror, move)])
    reports = [movement.report for movement in movements.values()]
    counts = {
        "factorisations": [report.factorisations for report in reports],
        "residuals": [report.residuals for report in reports],
        "stages": [report.iterations for report in reports],
    }
    return xr.Dataset(
        {
            "seconds": (("scene",), seconds, {"units": "s"}),
            "contact_seconds": (("scene",), in_contact, {"units": "s"}),
            **{name: (("scene",), np.array(values)) for name, values in counts.items()},
            "tip_change_largest": (("effect",), changes[:, 0], {"units": "mm"}),
            "tip_change_end": (("effect",), changes[:, 1], {"units": "mm"}),
        },
        coords={"scene": list(scenes), "effect": list(EFFECTS)},
        attrs={
            "speaker": speaker.name,
            "speaker_fingerprint": speaker.fingerprint,
            "vowel": vowel,
            "until_s": float(until),
            "dt_s": float(dt),
            "integrator": integrator,
            "mirror": int(mirror),
            "repetitions": count,
        },
    )


def far_walls(speaker: Speaker, distance: float = OUT_OF_REACH) -> Speaker:
    """The speaker with a closed box ``distance`` (m) around the tongue at rest in place of each wall.

    The same faces may touch, and none ever does.
    """
    body = speaker.nodes[np.unique(speaker.hexahedra)]
    box = _inward_box(body.min(axis=0) - distance, body.max(axis=0) + distance)
    return Speaker(
        speaker.nodes,
        speaker.hexahedra,
        muscles=speaker.muscles,
        node_sets=speaker.node_sets,
        walls=dict.fromkeys(speaker.walls, box),
        hyoid=speaker.hyoid,
        contours=speaker.contours,
        name=speaker.name,
        contact_faces=speaker.contact_faces,
    )


def _inward_box(low: FloatArray, high: FloatArray) -> Wall:
    """A box, symmetric about y = 0, with normals to its inside."""
    reach = max(-low[1], high[1])
    low, high = np.array([low[0], -reach, low[2]]), np.array([high[0], reach, high[2]])
    corners = np.array([[x, y, z] for z in (0, 1) for x, y in ((0, 0), (1, 0), (1, 1), (0, 1))])
    faces = [[0, 1, 2, 3], [7, 6, 5, 4], [4, 5, 1, 0], [5, 6, 2, 1], [6, 7, 3, 2], [7, 4, 0, 3]]
    return Wall(low + corners * (high - low), faces)


def _full_name() -> str:
    return f"+ {list(EFFECTS)[-1]}"


def _scenes(speaker: Speaker, *, mirror: bool) -> dict[str, Scene]:
    options = dict(BARE)
    scenes = {"tissue and muscles": Scene(speaker, mirror=mirror, **options)}
    scenes[FAR] = Scene(far_walls(speaker), mirror=mirror, **{**options, **EFFECTS["contact"]})
    for name, option in EFFECTS.items():
        options |= option
        scenes[f"+ {name}"] = Scene(speaker, mirror=mirror, **options)
    return scenes


def _left_out(speaker: Speaker, mirror: bool, move: Any) -> list[Movement]:
    """The movement with all effects but one, for each effect."""
    everything: dict[str, Any] = {}
    for option in EFFECTS.values():
        everything |= option
    return [
        move(Scene(speaker, mirror=mirror, **(everything | {key: BARE[key] for key in option})))[1]
        for option in EFFECTS.values()
    ]


def _tip_change(full: Movement, without: Movement) -> tuple[float, float]:
    """Distance of the tips, mm: the largest over time and that at the end."""
    tip = tracked_nodes(full.speaker)["tip"]
    times = np.linspace(0.0, full.times[-1], 201)[1:]
    away = [np.linalg.norm((full.at(t).positions - without.at(t).positions)[tip]) for t in times.tolist()]
    return float(max(away)) * 1e3, float(away[-1]) * 1e3
