"""Types of the C++ extension. Arrays that are returned belong to the caller."""

from collections.abc import Mapping
from typing import Any, Literal, TypeAlias

import numpy as np
from numpy.typing import NDArray

_Reals: TypeAlias = NDArray[np.float64]
_Ints: TypeAlias = NDArray[np.int32]
_Bytes: TypeAlias = NDArray[np.uint8]
_Status: TypeAlias = Literal["converged", "iteration_limit", "stalled", "inverted", "indefinite", "interrupted"]
_Integrator: TypeAlias = Literal["SDIRK2", "BDF2", "backward_euler", "trapezoidal"]

__version__: str

def kernel_name() -> str: ...

class Report:
    @property
    def status(self) -> _Status: ...
    @property
    def converged(self) -> bool: ...
    @property
    def iterations(self) -> int: ...
    @property
    def quasi_newton(self) -> int: ...
    @property
    def residuals(self) -> int: ...
    @property
    def factorisations(self) -> int: ...
    @property
    def indefinite(self) -> int: ...
    @property
    def line_search(self) -> int: ...
    @property
    def steps(self) -> int: ...
    @property
    def rejected(self) -> int: ...
    @property
    def rescued(self) -> int: ...
    @property
    def residual(self) -> float: ...
    @property
    def force_scale(self) -> float: ...
    @property
    def least_jacobian(self) -> float: ...
    @property
    def worst_element(self) -> int: ...
    @property
    def error_estimate(self) -> float: ...
    @property
    def residuals_by_iteration(self) -> list[float]: ...
    @property
    def seconds(self) -> dict[str, float]: ...

class Equilibrium:
    @property
    def report(self) -> Report: ...
    @property
    def positions(self) -> _Reals: ...
    @property
    def force(self) -> _Reals: ...
    @property
    def pressure(self) -> _Reals: ...
    @property
    def stiffening(self) -> _Reals: ...
    @property
    def activation(self) -> _Reals: ...
    @property
    def tension(self) -> _Reals: ...

class Solver:
    def __init__(
        self,
        nodes: _Reals,
        hexahedra: _Ints,
        fibres: Mapping[str, Any],
        *,
        muscle_count: int,
        c10: float,
        c20: float,
        bulk_modulus: float,
        density: float,
        element: str,
        firing_gradient: float,
        force_velocity: bool,
        stiffening: bool,
        reflex: tuple[float, float] | None,
        damping: tuple[float, float],
        gravity: tuple[float, float, float] | None,
        free: _Bytes,
        threads: int,
    ) -> None: ...
    def equilibrate(
        self,
        *,
        fractions: _Reals,
        start: _Reals,
        pressure: _Reals | None = None,
        target: _Reals,
        free: _Bytes,
        load: _Reals | None = None,
        tolerance: float = 1e-8,
        max_iterations: int = 150,
        quasi_newton: bool = True,
    ) -> Equilibrium: ...

class State:
    @property
    def time(self) -> float: ...

class Simulation:
    state: State
    def __init__(
        self,
        solver: Solver,
        *,
        times: _Reals,
        fractions: _Reals,
        positions: _Reals,
        pressure: _Reals | None = None,
        time: float = 0.0,
        max_step: float = 2e-3,
        error_tolerance: float = 0.0,
        tolerance: float = 2e-6,
        integrator: _Integrator | str = "SDIRK2",
    ) -> None: ...
    def step(self, dt: float) -> _Status: ...
    def solve(self, until: float) -> tuple[_Status, _Reals, _Reals, _Reals, _Reals, _Reals]: ...
    @property
    def time(self) -> float: ...
    @property
    def positions(self) -> _Reals: ...
    @property
    def velocities(self) -> _Reals: ...
    @property
    def momentum(self) -> _Reals: ...
    @property
    def activation(self) -> _Reals: ...
    @property
    def tension(self) -> _Reals: ...
    @property
    def kinetic_energy(self) -> float: ...
    @property
    def potential_energy(self) -> float: ...
    @property
    def report(self) -> Report: ...
