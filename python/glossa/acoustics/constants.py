"""Physical constants of the tube: air, losses, wall and radiation, in named sets.

Every loss used here has one of two dependences on area, so that a section of area A has, per unit length,

    series impedance  z = z1(ω) / A + z2(ω) / A^(3/2)      (Pa s/m⁴)
    shunt admittance  y = y1(ω) A + y2(ω) A^(1/2)          (m²/(Pa s))

with the perimeter of a circle, 2 √(πA). ω may be complex with a positive real part (time factor e^{jωt}): the
coefficients are continued analytically, which is what complex poles need.

The numbers are those the programs print in cgs; λ/c_p, the only combination that counts, is converted with 4.184 J/cal.
"""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Mapping
from dataclasses import dataclass
from types import MappingProxyType
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from glossa.checks import finite_number, flag, instance, not_negative_number, one_of, positive_number
from glossa.errors import InputError

Complex = NDArray[np.complex128]

CALORIE = 4.184
SECTIONS = ("exact", "lumped")
RADIATIONS = ("series", "parallel", "none")


class Coefficients(NamedTuple):
    """z1, z2, y1, y2 of the module's formulas, or their derivatives by ω."""

    z1: Complex
    z2: Complex
    y1: Complex
    y2: Complex


@dataclass(frozen=True, kw_only=True)
class BoundaryLayer:
    """Viscous and thermal losses at the wall (Flanagan 1972, section 3.2): grow with √ω and with the perimeter S.

    R = (S/A²) √(ωρμ/2) in series, G = S (η-1)/(ρc²) √(ωλ/(2 c_p ρ)) in parallel, per unit length.

    Attributes:
        viscosity: μ, Pa s.
        heat_ratio: η, ratio of specific heats.
        heat_conduction: λ, W/(m K); 0 leaves the thermal loss out.
        specific_heat: c_p, J/(kg K).
        shape_factor: perimeter over that of a circle of the same area.
        reactance: the viscous layer also adds its mass, an inertance of ωL = R.
    """

    viscosity: float = 1.86e-5
    heat_ratio: float = 1.4
    heat_conduction: float = 5.5e-3 * CALORIE
    specific_heat: float = 240.0 * CALORIE
    shape_factor: float = 1.0
    reactance: bool = False

    def __post_init__(self) -> None:
        not_negative_number(self.viscosity, "viscosity (Pa s)")
        if positive_number(self.heat_ratio, "heat_ratio") < 1.0:
            raise InputError(f"heat_ratio must be at least 1, got {self.heat_ratio!r}")
        not_negative_number(self.heat_conduction, "heat_conduction (W/(m K))")
        positive_number(self.specific_heat, "specific_heat (J/(kg K))")
        positive_number(self.shape_factor, "shape_factor")
        flag(self.reactance, "reactance")

    def add(self, omega: Complex, air: TubeConstants, into: list[Any], slopes: list[Any]) -> None:
        """Adds to z2 and y2."""
        perimeter = self.shape_factor * 2.0 * math.sqrt(math.pi)
        root = np.sqrt(omega)
        layer = (1.0 + 1.0j) if self.reactance else 1.0
        viscous = perimeter * math.sqrt(air.density * self.viscosity / 2.0) * layer
        diffusion = math.sqrt(self.heat_conduction / (2.0 * self.specific_heat * air.density))
        thermal = perimeter * (self.heat_ratio - 1.0) / (air.density * air.sound_speed**2) * diffusion
        into[1] = into[1] + viscous * root
        slopes[1] = slopes[1] + viscous * 0.5 / root
        into[3] = into[3] + thermal * root
        slopes[3] = slopes[3] + thermal * 0.5 / root


@dataclass(frozen=True, kw_only=True)
class MeanLosses:
    """Losses that do not depend on the perimeter (Sondhi & Schroeter 1987): z = ρ(jω + r)/A, y ∝ A √(jωq).

    Attributes:
        drag: r, 1/s.
        conduction: q, 1/s; thermal and viscous losses together.
    """

    drag: float
    conduction: float

    def __post_init__(self) -> None:
        not_negative_number(self.drag, "drag (1/s)")
        not_negative_number(self.conduction, "conduction (1/s)")

    def add(self, omega: Complex, air: TubeConstants, into: list[Any], slopes: list[Any]) -> None:
        """Adds to z1 and y1."""
        root = np.sqrt(1j * omega * self.conduction) / (air.density * air.sound_speed**2)
        into[0] = into[0] + air.density * self.drag
        into[2] = into[2] + root
        slopes[2] = slopes[2] + 0.5 * root / omega


@dataclass(frozen=True, kw_only=True)
class YieldingWall:
    """Wall that moves as a damped mass on a spring, per unit area: Y = S/(b + j(ωm - k/ω)) per unit length.

    Attributes:
        mass: m, kg/m².
        resistance: b, kg/(s m²).
        stiffness: k, kg/(s² m²).
    """

    mass: float
    resistance: float
    stiffness: float = 0.0

    def __post_init__(self) -> None:
        positive_number(self.mass, "wall mass (kg/m²)")
        positive_number(self.resistance, "wall resistance (kg/(s m²))")
        not_negative_number(self.stiffness, "wall stiffness (kg/(s² m²))")

    def add(self, omega: Complex, air: TubeConstants, into: list[Any], slopes: list[Any]) -> None:  # noqa: ARG002
        """Adds to y2."""
        impedance = self.resistance + 1j * (omega * self.mass - self.stiffness / omega)
        admittance = 2.0 * math.sqrt(math.pi) / impedance
        into[3] = into[3] + admittance
        slopes[3] = slopes[3] - admittance / impedance * 1j * (self.mass + self.stiffness / omega**2)

    @property
    def resonance(self) -> float:
        """√(k/m)/2π, Hz: below it the wall acts as a spring, above it as a mass."""
        return math.sqrt(self.stiffness / self.mass) / (2.0 * math.pi)


@dataclass(frozen=True, kw_only=True)
class ResonantWall:
    """Wall whose effect does not depend on the perimeter (Sondhi & Schroeter 1987).

    y gains (A/(ρc²)) jω ω_t² / ((jω + r) jω + ω_w²).

    Attributes:
        tract_frequency: ω_t/2π, Hz: lowest resonance of the tract closed at both ends.
        wall_frequency: ω_w/2π, Hz: resonance of the wall.
        drag: r, ratio of wall resistance to wall mass, 1/s.
    """

    tract_frequency: float
    wall_frequency: float
    drag: float

    def __post_init__(self) -> None:
        positive_number(self.tract_frequency, "tract_frequency (Hz)")
        not_negative_number(self.wall_frequency, "wall_frequency (Hz)")
        positive_number(self.drag, "drag (1/s)")

    def add(self, omega: Complex, air: TubeConstants, into: list[Any], slopes: list[Any]) -> None:
        """Adds to y1."""
        s = 1j * omega
        square = (2.0 * math.pi * self.wall_frequency) ** 2
        bottom = (s + self.drag) * s + square
        scale = (2.0 * math.pi * self.tract_frequency) ** 2 / (air.density * air.sound_speed**2)
        into[2] = into[2] + scale * s / bottom
        slopes[2] = slopes[2] + scale * 1j * (square - s * s) / bottom**2

    @property
    def resonance(self) -> float:
        """Hz: below it the wall acts as a spring, above it as a mass."""
        return self.wall_frequency


@dataclass(frozen=True, kw_only=True)
class TubeConstants:
    """What the tube is made of. Use a named set (:data:`TUBE_CONSTANTS`), or ``.with_`` of one, or your own.

    Attributes:
        name: for messages and labels.
        sound_speed: c, m/s.
        density: ρ, kg/m³.
        losses: of the air, or None.
        wall: how the wall yields, or None for a rigid wall.
        radiation: load at the lips, for a piston of area A in a wall: ``"series"`` ρω²/(2πc) + jω 8ρ/(3π√(πA))
            (Flanagan 1972, eq. 3.36 for ka ≪ 1), ``"parallel"`` 128ρc/(9π²A) beside jω 8ρ/(3π√(πA)) (same, eq. 3.37),
            ``"none"`` no pressure at the lips.
        sections: ``"exact"`` hyperbolic chain matrices, or ``"lumped"``: one T of concentrated elements for each
            section, which differs from the exact one by about (ωl/c)²/12 and is meant for comparisons with programs
            that do so.

    Raises:
        InputError: a value out of range.
    """

    name: str = "own"
    sound_speed: float = 351.0
    density: float = 1.14
    losses: BoundaryLayer | MeanLosses | None = None
    wall: YieldingWall | ResonantWall | None = None
    radiation: str = "series"
    sections: str = "exact"

    def __post_init__(self) -> None:
        if not 100.0 <= finite_number(self.sound_speed, "sound_speed (m/s)") <= 2000.0:
            raise InputError(f"sound_speed must be in m/s, from 100 to 2000, got {self.sound_speed!r}")
        if not 0.01 <= finite_number(self.density, "density (kg/m³)") <= 100.0:
            raise InputError(f"density must be in kg/m³, from 0.01 to 100, got {self.density!r}")
        if not isinstance(self.losses, BoundaryLayer | MeanLosses | None):
            raise InputError(f"losses must be a BoundaryLayer, MeanLosses or None, got {self.losses!r}")
        if not isinstance(self.wall, YieldingWall | ResonantWall | None):
            raise InputError(f"wall must be a YieldingWall, ResonantWall or None, got {self.wall!r}")
        one_of(self.radiation, RADIATIONS, "radiation")
        one_of(self.sections, SECTIONS, "sections")

    def with_(self, **changes: Any) -> TubeConstants:
        """The same with some attributes changed: ``TUBE_CONSTANTS["badin"].with_(wall=None, sections="lumped")``.

        Raises:
            InputError: no such attribute, or a value out of range.
        """
        known = [field.name for field in dataclasses.fields(self)]
        unknown = sorted(set(changes) - set(known))
        if unknown:
            raise InputError(f"tube constants have no attribute {unknown[0]!r}; they have {', '.join(known)}")
        return dataclasses.replace(self, **changes)

    def lossless(self) -> TubeConstants:
        """Air alone: no losses, rigid wall, no pressure at the lips."""
        return self.with_(losses=None, wall=None, radiation="none")

    @property
    def lowest_frequency(self) -> float:
        """Hz below which no formant is looked for: the wall's resonance, and at least 1 Hz.

        Where the wall is a spring, the air of a nearly closed tract bounces on it; that is not a formant.
        """
        return max(1.0, self.wall.resonance if self.wall is not None else 0.0)

    def line(self, omega: Complex) -> tuple[Coefficients, Coefficients]:
        """z1, z2, y1, y2 at angular frequencies ω (rad/s, any shape), and their derivatives by ω."""
        stiffness = 1.0 / (self.density * self.sound_speed**2)
        zero = np.zeros_like(omega)
        values: list[Any] = [1j * omega * self.density, zero, 1j * omega * stiffness, zero]
        slopes: list[Any] = [zero + 1j * self.density, zero, zero + 1j * stiffness, zero]
        for part in (self.losses, self.wall):
            if part is not None:
                part.add(omega, self, values, slopes)
        return Coefficients(*values), Coefficients(*slopes)

    def load(self, omega: Complex, area: NDArray[np.float64]) -> tuple[Complex, Complex, Complex]:
        """Radiation impedance (Pa s/m³) of an opening of this area (m²), and its derivatives by ω and by area."""
        zero = np.zeros_like(omega)
        if self.radiation == "none":
            return zero, zero, zero
        inertance = 8.0 * self.density / (3.0 * math.pi * np.sqrt(math.pi * area))
        mass = 1j * omega * inertance
        mass_area = -0.5 * mass / area
        if self.radiation == "series":
            resistance = self.density / (2.0 * math.pi * self.sound_speed)
            return resistance * omega**2 + mass, 2.0 * resistance * omega + 1j * inertance, mass_area
        plate = 128.0 * self.density * self.sound_speed / (9.0 * math.pi**2 * area)
        total = (plate + mass) ** 2
        by_omega = plate**2 * 1j * inertance / total
        by_area = (plate**2 * mass_area - mass**2 * plate / area) / total
        return plate * mass / (plate + mass), by_omega, by_area


TUBE_CONSTANTS: Mapping[str, TubeConstants] = MappingProxyType(
    {
        # Constants of P. Badin's transmission-line program (ICP Grenoble), published with Berthommier,
        # arXiv:2111.00868; wall of Mrayati (1976): 1.4 g/cm², 1600 g/(s cm²), no stiffness.
        "badin": TubeConstants(
            name="badin",
            sound_speed=351.0,
            density=1.14,
            losses=BoundaryLayer(),
            wall=YieldingWall(mass=14.0, resistance=16000.0),
        ),
        # Praat 6.3, VocalTract: To Spectrum (Boersma): viscous layer with its mass, twice the perimeter of a circle,
        # rigid wall.
        "praat": TubeConstants(
            name="praat",
            sound_speed=353.0,
            density=1.14,
            losses=BoundaryLayer(shape_factor=2.0, reactance=True),
        ),
        # Maeda (1982), Speech Communication 1, 199-229: 1.5 g/cm², 1600 g/(s cm²), 3e5 g/(s² cm²).
        "maeda": TubeConstants(
            name="maeda",
            sound_speed=350.0,
            density=1.14,
            losses=BoundaryLayer(),
            wall=YieldingWall(mass=15.0, resistance=16000.0, stiffness=3.0e6),
        ),
        # VocalTractLab 2.x (Birkholz): 2.4 g/cm², 5000 g/(s cm²), 1e5 g/(s² cm²), thermal loss off by default.
        "vocaltractlab": TubeConstants(
            name="vocaltractlab",
            sound_speed=350.0,
            density=1.14,
            losses=BoundaryLayer(heat_conduction=0.0),
            wall=YieldingWall(mass=24.0, resistance=50000.0, stiffness=1.0e6),
            radiation="parallel",
        ),
        # Story, Laukkanen & Titze (2000), J. Voice 14, 455-469, after Sondhi & Schroeter (1987), IEEE Trans. ASSP 35,
        # 955-967; values as in B. Story's program VokalTraktM (2010).
        "story": TubeConstants(
            name="story",
            sound_speed=350.0,
            density=1.14,
            losses=MeanLosses(drag=408.0, conduction=4.0),
            wall=ResonantWall(tract_frequency=200.0, wall_frequency=15.0, drag=408.0),
            radiation="parallel",
        ),
    }
)
"""Named sets; they move F1 by up to 80 Hz, so say which one was used."""


def tube_constants(choice: str | TubeConstants) -> TubeConstants:
    """A named set, or the object itself.

    Raises:
        InputError: neither; the message lists the names.
    """
    if isinstance(choice, str):
        return TUBE_CONSTANTS[one_of(choice, tuple(TUBE_CONSTANTS), "constants")]
    return instance(choice, TubeConstants, "constants (a name such as 'badin', or its object)")  # type: ignore[no-any-return]
