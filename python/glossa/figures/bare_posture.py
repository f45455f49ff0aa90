"""Shapes kept in the tables of studies, as postures that can be drawn: positions and the pose of the hyoid only."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from typing import Any

import numpy as np
import xarray as xr
from numpy.typing import ArrayLike

from glossa.anatomy.speaker import Speaker
from glossa.errors import InputError
from glossa.hyoid_motion import HyoidPose
from glossa.results import Posture
from glossa.studies.rest import rest_posture


def bare_posture(speaker: Speaker, positions: ArrayLike, hyoid: ArrayLike | None = None) -> Posture | None:
    """A posture without forces and contact; None where the study has no numbers.

    Args:
        speaker: whose positions they are.
        positions: (n, 3) m.
        hyoid: (3, 3) displacement (m), rotation vector (rad) and centre at rest (m); NaN or None: at rest.
    """
    places = np.asarray(positions, dtype=float)
    if not np.isfinite(places).all():
        return None
    pose = None if hyoid is None else np.asarray(hyoid, dtype=float)
    known = pose is not None and bool(np.isfinite(pose).all())
    return replace(
        rest_posture(speaker), positions=places, hyoid=HyoidPose(*pose) if known and pose is not None else None
    )


def check_study(study: Any, name: str, speaker: Speaker | None = None) -> None:
    """Refuse what is not the result of the study ``name``, or belongs to another speaker.

    Raises:
        InputError: either.
    """
    if not isinstance(study, xr.Dataset) or study.attrs.get("study") != name:
        raise InputError(f"this figure needs the result of glossa.studies.{name}")
    if speaker is not None and study.attrs.get("speaker_fingerprint") != speaker.fingerprint:
        raise InputError(f"this study belongs to another speaker ({study.attrs.get('speaker')!r})")


def drawable(postures: Mapping[str, Posture | None]) -> dict[str, Posture]:
    """Those that have a shape.

    Raises:
        InputError: none has.
    """
    found = {name: posture for name, posture in postures.items() if posture is not None}
    if not found:
        raise InputError("nothing to draw: no run of this study has a shape")
    return found
