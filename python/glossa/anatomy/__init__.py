"""A speaker's anatomy: mesh, muscles, attachments, walls; how it is generated, read, refined and mirrored."""

from __future__ import annotations

from glossa.anatomy.landmark_points import landmark_points
from glossa.anatomy.muscle import Muscle
from glossa.anatomy.speaker import Speaker
from glossa.anatomy.walls import Hyoid, Spring, Wall

__all__ = ["Hyoid", "Muscle", "Speaker", "Spring", "Wall", "landmark_points"]
