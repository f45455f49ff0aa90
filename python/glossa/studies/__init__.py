"""Studies: runs that answer a question of the paper, from a scene to a table. Nothing here draws or prints."""

from glossa.studies.acoustics import formant_table, movement_tracts, vowel_tracts
from glossa.studies.contact import contact_over_time, contact_table
from glossa.studies.costs import effect_costs
from glossa.studies.points import displacements_mm, tracked_nodes
from glossa.studies.rest import rest_posture
from glossa.studies.single_muscle import single_muscle, single_muscle_command, single_muscles
from glossa.studies.vowels import posture_table, vowels

__all__ = [
    "contact_over_time",
    "contact_table",
    "displacements_mm",
    "effect_costs",
    "formant_table",
    "movement_tracts",
    "posture_table",
    "rest_posture",
    "single_muscle",
    "single_muscle_command",
    "single_muscles",
    "tracked_nodes",
    "vowel_tracts",
    "vowels",
]
