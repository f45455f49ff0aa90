"""Laws of the tissue and damping: figs 3 and 4."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from tests.blocks import SIZE, block

from glossa import Damping, InputError, Scene, Yeoh
from glossa.studies import damping_ratio, stress_strain
from glossa.studies.tissue_laws import LAWS


def test_a_block_under_load_follows_the_curve() -> None:
    """The solver's stretch under a load, sides free, is where the curve has that stress."""
    tissue, load = Yeoh(), 1.5
    sets = {"left": (0.0, None, None), "front": (None, 0.0, None), "bottom": (None, None, 0.0)}
    scene = Scene(block((3, 2, 2)), gravity=None, fixed=[], tissue=tissue)
    for force in (load, -load):
        posture = scene.equilibrate(prescribed=sets, loads={"right": (force, 0.0, 0.0)}, accuracy="reference")
        strain = float(posture.displacements[:, 0].max() if force > 0 else posture.displacements[:, 0].min()) / SIZE[0]
        curve = stress_strain({"tissue": (tissue, 1.0)}, [strain])
        assert float(curve["nominal_stress"][0, 0]) == pytest.approx(force / (SIZE[1] * SIZE[2]), rel=1e-7)
        assert abs(strain) > 0.1
        assert np.sign(strain) == np.sign(force)


def test_moduli_are_those_the_paper_speaks_of() -> None:
    """1.15 kPa of the cadaver, 6.2 kPa at rest (section II.B), and ten times that, below 110 kPa."""
    study = stress_strain()
    modulus = dict(zip(study["law"].values.tolist(), (study["modulus"].values / 1e3).tolist(), strict=True))
    assert modulus["fresh cadaver"] == pytest.approx(1.15, abs=0.01)
    assert modulus["passive"] == pytest.approx(6.2, abs=0.05)
    assert modulus["maximal activation"] == pytest.approx(62.0, rel=0.01)
    assert list(modulus) == list(LAWS)
    assert study["modulus"].attrs["units"] == "Pa"


def test_stress_is_the_slope_of_the_energy() -> None:
    """With sides free, the work of the load is the energy density; true and nominal stress differ by the area."""
    tissue, factor = Yeoh(poissons_ratio=0.45), 4.0
    strains = np.linspace(0.0, 0.5, 501)
    study = stress_strain({"soft": (tissue, factor)}, strains).sel(law="soft")
    work = np.trapezoid(study["nominal_stress"], strains)
    volume, stretch = float(study["volume_ratio"][-1]), 1.5
    invariant = volume ** (-2 / 3) * (stretch**2 + 2.0 * volume / stretch)
    energy = factor * (tissue.c10 * (invariant - 3.0) + tissue.c20 * (invariant - 3.0) ** 2)
    energy += 0.5 * tissue.bulk_modulus * (volume - 1.0) ** 2
    assert work == pytest.approx(energy, rel=1e-5)
    assert study["stress"].values * volume_over(study, strains) == pytest.approx(study["nominal_stress"].values)


def volume_over(study: Any, strains: np.ndarray) -> np.ndarray:
    """Area of the moment over area at rest."""
    return np.asarray(study["volume_ratio"]) / (1.0 + strains)


@pytest.mark.parametrize(
    ("laws", "strains", "message"),
    [
        ({}, [0.1], "at least one law"),
        ({"weak": (Yeoh(), 0.5)}, [0.1], "factor of 'weak' must be at least 1"),
        (LAWS, [-1.0], "above -1"),
        (LAWS, [], "list of numbers"),
        (LAWS, [float("nan")], "list of numbers"),
    ],
)
def test_impossible_laws_and_strains_are_refused(laws: Any, strains: Any, message: str) -> None:
    with pytest.raises(InputError, match=message):
        stress_strain(laws, strains)


def test_damping_is_nearest_critical_between_3_and_10_hz() -> None:
    """Fig. 4; 1.34 at 3 Hz and 1.26 at 10 Hz, where the paper says "below 1.26" for both ends."""
    study = damping_ratio(frequencies=[3.0, 10.0])
    assert study["ratio"].values == pytest.approx([1.344, 1.261], abs=1e-3)
    curve = damping_ratio()
    least = float(curve["frequency"][curve["ratio"].to_numpy().argmin()])
    assert 3.0 < least < 10.0
    assert float(curve["ratio"].min()) == pytest.approx(np.sqrt(40.0 * 0.03), rel=1e-4)
    assert damping_ratio(Damping(alpha=0.0, beta=1.0 / np.pi), [1.0])["ratio"].item() == pytest.approx(1.0)
    with pytest.raises(InputError, match="positive numbers in Hz"):
        damping_ratio(frequencies=[0.0])
