"""Studies: runs that answer a question of the paper, from a scene to a table. Nothing here draws or prints."""

from glossa.studies import accuracy
from glossa.studies.accuracy import accuracy_study
from glossa.studies.acoustics import formant_error, formant_table, movement_tracts, vowel_tracts
from glossa.studies.contact import contact_over_time, contact_table
from glossa.studies.costs import effect_costs
from glossa.studies.damping_ratio import damping_ratio
from glossa.studies.delay import delay
from glossa.studies.designs import Design, grid, latin_hypercube, monte_carlo
from glossa.studies.dispersion import Ellipse, dispersion_ellipse
from glossa.studies.executors import worker_pool
from glossa.studies.gravity import gravity, gravity_at_rest, gravity_of_vowels
from glossa.studies.midsagittal_nodes import MIDSAGITTAL_NODES, midsagittal_nodes
from glossa.studies.muscle_effects import muscle_effects
from glossa.studies.points import displacements_mm, tracked_nodes
from glossa.studies.replication import Replication, replicate
from glossa.studies.resolution import error_bars, observed_order, resolution_study
from glossa.studies.rest import rest_posture
from glossa.studies.run import Point, Progress, run_points
from glossa.studies.sensitivity import sensitivity, sensitivity_changes
from glossa.studies.sensitivity_summary import compared_changes, sensitivity_summary
from glossa.studies.single_muscle import single_muscle, single_muscle_command, single_muscles
from glossa.studies.size import size_study
from glossa.studies.spatial_errors import spatial_errors
from glossa.studies.stability import StabilityGrid, posture_roots, stability
from glossa.studies.stability_schedules import movements_in_steps, random_ramps
from glossa.studies.stability_trace import growth_in_steps
from glossa.studies.study_dataset import open_study
from glossa.studies.sweep import as_grid, sweep
from glossa.studies.symmetry import SymmetryCheck, symmetry
from glossa.studies.tissue_laws import stress_strain
from glossa.studies.transversalis import transversalis
from glossa.studies.vowels import posture_table, vowels

__all__ = [
    "MIDSAGITTAL_NODES",
    "Design",
    "Ellipse",
    "Point",
    "Progress",
    "Replication",
    "StabilityGrid",
    "SymmetryCheck",
    "accuracy",
    "accuracy_study",
    "as_grid",
    "compared_changes",
    "contact_over_time",
    "contact_table",
    "damping_ratio",
    "delay",
    "dispersion_ellipse",
    "displacements_mm",
    "effect_costs",
    "error_bars",
    "formant_error",
    "formant_table",
    "gravity",
    "gravity_at_rest",
    "gravity_of_vowels",
    "grid",
    "growth_in_steps",
    "latin_hypercube",
    "midsagittal_nodes",
    "monte_carlo",
    "movement_tracts",
    "movements_in_steps",
    "muscle_effects",
    "observed_order",
    "open_study",
    "posture_roots",
    "posture_table",
    "random_ramps",
    "replicate",
    "resolution_study",
    "rest_posture",
    "run_points",
    "sensitivity",
    "sensitivity_changes",
    "sensitivity_summary",
    "single_muscle",
    "single_muscle_command",
    "single_muscles",
    "size_study",
    "spatial_errors",
    "stability",
    "stress_strain",
    "sweep",
    "symmetry",
    "tracked_nodes",
    "transversalis",
    "vowel_tracts",
    "vowels",
    "worker_pool",
]
