"""Roots of the delayed loop: against equations solved by hand, against each other, and against movements."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest
import scipy.sparse as sp
from scipy.special import lambertw
from tests.blocks import block

from glossa import VOWELS, InputError, MotorCommands, Posture, Reflex, Scene, SolveError, Speaker, studies
from glossa.linear_motion import LinearMotion
from glossa.studies.stability import check_stability, committed_stability, linear_range, strongest_muscle
from glossa.studies.stability_basis import reduced_motion
from glossa.studies.stability_generator import chebyshev_slope, spectrum
from glossa.studies.stability_loci import delay_margin, loop_loci, unstable_roots
from glossa.studies.stability_roots import rightmost_roots
from glossa.studies.stability_trace import growth_in_steps, measured_root

BODY = {"cells": (3, 2, 2), "size": (0.06, 0.03, 0.03), "muscles": {"axial": 20.0}}
COMMANDS = MotorCommands({"axial": 0.9})


def springs(mass: float, damping: float, stiffness: float, pull: float, count: int = 1) -> LinearMotion:
    """Equal masses, each on a spring and a damper, held by a delayed fibre of its own."""
    eye = sp.eye_array(count, format="csc")
    return LinearMotion(
        mass=mass * eye,
        damping=damping * eye,
        stiffness=stiffness * eye,
        pulls=pull * np.eye(count),
        gradients=np.eye(count),
        delay=0.0,
        velocity_gain=0.0,
        activations=np.full(count, 1e-3),
        muscles=("one",) * count,
        nodes_of=lambda values: np.stack([values, 0.0 * values, 0.0 * values], axis=1),
    )


def block_scene(delay: float = 0.017, velocity_gain: float = 0.01) -> Scene:
    return Scene(block(**BODY), fixed=["left"], reflex=Reflex(delay=delay, velocity_gain=velocity_gain))  # type: ignore[arg-type]


@pytest.fixture(scope="module")
def contracted() -> LinearMotion:
    scene = block_scene()
    return scene.linearise(scene.equilibrate(COMMANDS))


# Against equations solved by hand


@pytest.mark.parametrize("delay", [0.004, 0.017, 0.06])
def test_roots_of_a_massless_spring_are_those_of_lambert(delay: float) -> None:
    """C s + k + b exp(-s d) = 0: s = W_n(-(b d / C) exp(k d / C)) / d - k / C, n = 0, -1, ..."""
    damping, stiffness, pull = 1.0, 14.0, 120.0
    motion = springs(1e-9, damping, stiffness, pull)
    argument = -pull * delay / damping * math.exp(stiffness * delay / damping)
    exact = [complex(lambertw(argument, n)) / delay - stiffness / damping for n in range(3)]
    found = rightmost_roots(motion, reduced_motion(motion), delay, 0.0, 3)
    for root, expected in zip(found, exact, strict=True):
        # The mass shifts a root by about m s^2 / C.
        assert abs(root.value - expected) < 1e-8 * abs(expected) ** 2
        assert root.converged


@pytest.mark.parametrize("velocity_gain", [0.0, 0.004, 0.012])
def test_border_of_a_single_mass(velocity_gain: float) -> None:
    """On the border s = i w: b^2 (1 + mu^2 w^2) = (k - m w^2)^2 + C^2 w^2, a quadratic in w^2."""
    mass, damping, stiffness, pull = 0.02, 2.0, 30.0, 150.0
    squares = np.roots(
        [mass**2, damping**2 - 2.0 * stiffness * mass - (velocity_gain * pull) ** 2, stiffness**2 - pull**2]
    )
    crossings = np.sqrt([x.real for x in squares if abs(x.imag) < 1e-9 and x.real > 0.0])
    margins = []
    for w in crossings:
        loop = pull * (1.0 + 1j * w * velocity_gain) / (stiffness - mass * w * w + 1j * w * damping)
        margins.append(np.mod(np.angle(loop) + np.pi, 2.0 * np.pi) / w)
    border = min(margins)
    motion = springs(mass, damping, stiffness, pull)
    loci = loop_loci(motion)
    assert delay_margin(loci, velocity_gain) == pytest.approx(border, rel=2e-3)  # interpolated loci
    reduced = reduced_motion(motion)
    for delay, unstable in ((0.97 * border, 0), (1.03 * border, 2)):
        assert unstable_roots(loci, delay, velocity_gain) == unstable
        assert (rightmost_roots(motion, reduced, delay, velocity_gain, 1)[0].value.real > 0.0) == bool(unstable)
    on_border = rightmost_roots(motion, reduced, border, velocity_gain, 1)[0]
    assert abs(on_border.value.real) < 1e-6
    assert on_border.frequency == pytest.approx(crossings[int(np.argmin(margins))] / (2.0 * np.pi), rel=1e-6)


def test_gain_that_damping_cannot_hold_makes_a_chain() -> None:
    """mu b > C: roots 1/d apart, of growth ln(mu b / C) / d, until inertia ends them: more of them with less mass."""
    delay, velocity_gain = 0.017, 0.03
    counts = []
    for mass in (1e-4, 2e-5):
        motion = springs(mass, 2.0, 20.0, 100.0)
        counts.append(unstable_roots(loop_loci(motion), delay, velocity_gain))
    few, many = counts
    assert few is not None
    assert many is not None
    assert many > 3 * few > 30
    roots = rightmost_roots(motion, reduced_motion(motion), delay, velocity_gain, 4)
    chain = [root for root in roots if root.frequency > 0.0]
    assert len(chain) >= 3
    assert np.diff(sorted(root.frequency for root in chain)) == pytest.approx(1.0 / delay, rel=0.02)
    assert [root.value.real for root in chain] == pytest.approx([math.log(1.5) / delay] * len(chain), rel=0.2)


def test_without_a_fibre_nothing_is_delayed() -> None:
    motion = springs(0.01, 0.5, 40.0, 0.0)
    exact = np.roots([0.01, 0.5, 40.0])
    root = rightmost_roots(motion, reduced_motion(motion), 0.02, 0.01, 1)[0]
    assert root.value == pytest.approx(complex(exact[exact.imag > 0.0][0]), rel=1e-12)
    assert unstable_roots(loop_loci(motion), 0.02, 0.01) == 0
    assert delay_margin(loop_loci(motion), 0.01) == math.inf


def test_chebyshev_slope_is_exact_for_polynomials() -> None:
    place = np.cos(np.pi * np.arange(7) / 6)
    assert chebyshev_slope(6) @ place**5 == pytest.approx(5.0 * place**4, abs=1e-12)


# Of a body, against each other


def test_roots_converge_with_basis_and_points(contracted: LinearMotion) -> None:
    """Spectra of reduced loops come near the roots of the whole body, nearer with more responses and points."""
    exact = rightmost_roots(contracted, reduced_motion(contracted, 81, 81), 0.017, 0.01, 1)[0].value

    def away(modes: int, responses: int, points: int = 16) -> float:
        values, _ = spectrum(reduced_motion(contracted, modes, responses), 0.017, 0.01, points, 1e-8)
        return float(np.abs(values - exact).min())

    modes_only, few, more = away(30, 0), away(5, 4), away(5, 20)
    assert more < 1e-3 * abs(exact)
    assert few < modes_only
    by_points = [away(81, 81, points) for points in (4, 8, 16)]
    assert by_points[1] < 0.05 * by_points[0]
    assert by_points[2] < 1e-7 * abs(exact)


@pytest.mark.parametrize("velocity_gain", [0.0, 0.01])
def test_count_agrees_with_the_spectrum(contracted: LinearMotion, velocity_gain: float) -> None:
    loci, reduced = loop_loci(contracted), reduced_motion(contracted, 81, 81)
    seen = set()
    for delay in (0.0, 0.01, 0.03, 0.06):
        values, _ = spectrum(reduced, delay, velocity_gain, 24, 1e-6)
        count = unstable_roots(loci, delay, velocity_gain)
        assert count == int((values.real > 0.0).sum())
        seen.add(count)
    assert len(seen) > 1


def test_margin_is_where_a_root_reaches_the_axis(contracted: LinearMotion) -> None:
    reduced, border = reduced_motion(contracted), delay_margin(loop_loci(contracted), 0.01)
    assert abs(rightmost_roots(contracted, reduced, border, 0.01, 1)[0].value.real) < 0.05


def test_driver_and_range_of_a_root(contracted: LinearMotion) -> None:
    root = rightmost_roots(contracted, reduced_motion(contracted), 0.017, 0.01, 1)[0]
    assert strongest_muscle(contracted, root) == "axial"
    reach = linear_range(contracted, root)
    # Activations are millimetres here, and lengths follow the free end.
    assert 0.1 * contracted.activations.min() < reach < 10.0 * contracted.activations.max()
    table = studies.posture_roots(block_scene(), block_scene().equilibrate(COMMANDS), 1)
    assert table["growth"].tolist() == pytest.approx([root.value.real], rel=1e-6)
    assert table["linear_range"].tolist() == pytest.approx([reach], rel=1e-6)
    alone = springs(0.02, 2.0, 30.0, 150.0)
    single = rightmost_roots(alone, reduced_motion(alone), 0.02, 0.0, 1)[0]
    assert linear_range(alone, single) == pytest.approx(1e-3 * math.exp(single.value.real * 0.02), rel=1e-9)


# Against movements


def block_posture(delay: float) -> tuple[Scene, Posture]:
    scene = block_scene(delay)
    return scene, scene.equilibrate(COMMANDS)


@pytest.mark.parametrize("share", [0.75, 1.3])
def test_movements_of_a_block_grow_as_the_root_says(contracted: LinearMotion, share: float) -> None:
    """On both sides of the border, and the integrator's error falls with the square of its step."""
    scene, posture = block_posture(share * delay_margin(loop_loci(contracted), 0.01))
    table = growth_in_steps(scene, posture, (1e-3, 5e-4), until=0.45)
    assert ((table["growth"] > 0.0) == (share > 1.0)).all()
    frequency = table["frequency"].to_numpy(dtype=float)
    assert frequency == pytest.approx(frequency[2], rel=5e-3)
    growth = table["growth"].to_numpy(dtype=float)
    coarse, fine = growth[:2] - growth[2]
    assert abs(fine) < 0.3 * abs(coarse) < 1.0
    assert abs(fine + (fine - coarse) / 3.0) < 0.1


def test_measured_growth_is_that_of_its_own_shape() -> None:
    """Of a sum of two shapes, one of which grows and one decays."""
    scene, posture = block_posture(0.017)
    still = scene.simulate(COMMANDS, 0.01, dt=0.005, initial=posture)
    times = np.linspace(0.0, 0.2, 101)
    rng = np.random.default_rng(7)
    size = posture.positions.shape
    shapes = [rng.normal(size=size) + 1j * rng.normal(size=size) for _ in range(2)]
    roots = (3.0 + 170.0j, -12.0 + 400.0j)
    parts = [np.real(np.exp(s * times)[:, None, None] * shape) for s, shape in zip(roots, shapes, strict=True)]
    movement = replace(still, times=times, velocities=parts[0] + parts[1])
    for k, s in enumerate(roots):
        found = measured_root(movement, [shapes[k], shapes[1 - k]], (0.05, 0.15))
        assert found.growth == pytest.approx(s.real, rel=1e-9)
        assert found.frequency == pytest.approx(s.imag / (2.0 * math.pi), rel=1e-9)
        assert found.misfit < 1e-9
    with pytest.raises(InputError, match="too few"):
        measured_root(movement, shapes, (0.05, 0.055))


@pytest.mark.slow
@pytest.mark.parametrize("share", [0.8, 1.2])
def test_movements_of_the_speaker_grow_as_the_root_says(reference: Speaker, share: float) -> None:
    """The mirrored speaker about /i/, walls without friction, hyoid mobile."""
    scene = Scene(reference, mirror=True, friction=0.0)
    posture = scene.equilibrate(VOWELS["i"])
    delay = share * delay_margin(loop_loci(scene.linearise(posture)), 0.01)
    there = Scene(reference, **{**scene.options, "reflex": Reflex(delay=delay)})
    table = growth_in_steps(there, posture, (1e-3, 5e-4))
    assert ((table["growth"] > 0.0) == (share > 1.0)).all()
    frequency = table["frequency"].to_numpy(dtype=float)
    assert frequency == pytest.approx(frequency[2], rel=2e-3)
    growth = table["growth"].to_numpy(dtype=float)
    coarse, fine = np.abs(growth[:2] - growth[2])
    assert fine < 0.1  # 0.01 to 0.03 seen
    assert coarse < 0.4


# The study


def test_study_of_a_block() -> None:
    grid = studies.StabilityGrid(
        delays=(0.0, 0.017, 0.03), velocity_gains=(0.0, 0.01), firing_gradients=(40.0, 80.0), roots=2
    )
    told: list[str] = []
    study = studies.stability(block_scene(), {"short": COMMANDS}, grid, progress=told.append)
    check_stability(study)
    assert told == ["short, c = 40 per m", "short, c = 80 per m"]
    assert dict(study["growth"].sizes) == {
        "posture": 1,
        "firing_gradient": 2,
        "velocity_gain": 2,
        "delay": 3,
        "root": 2,
    }
    growth = study["growth"].isel(root=0)
    assert float(growth.sel(delay=0.0).max()) < 0.0
    assert ((growth > 0.0) == (study["unstable"] > 0)).all()
    beyond = study["delay"] > study["border_delay"].sel(
        border_gain=study["velocity_gain"].values, method="nearest"
    ).rename(border_gain="velocity_gain").assign_coords(velocity_gain=study["velocity_gain"])
    assert (beyond.transpose(*growth.dims) == (growth > 0.0)).all()
    assert float(study["residual"].max()) < 1e-9
    assert set(np.unique(study["muscle"].values)) == {"axial"}
    assert study.attrs["delay_s"] == 0.017
    assert (study["reason"] == "").all()


def test_a_failed_equilibrium_keeps_its_reason(monkeypatch: pytest.MonkeyPatch) -> None:
    def refuse(*_: object, **__: object) -> None:
        raise SolveError("no equilibrium: stalled; .posture is the last good state", status="stalled")

    monkeypatch.setattr(Scene, "equilibrate", refuse)
    grid = studies.StabilityGrid(delays=(0.0,), velocity_gains=(0.0,), firing_gradients=(40.0,))
    study = studies.stability(block_scene(), {"crushed": COMMANDS}, grid)
    assert study["reason"].values.tolist() == [["no equilibrium: stalled"]]
    assert np.isnan(study["growth"].values).all()
    assert np.isnan(study["border_delay"].values).all()


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        ({"delays": (0.02, 0.01)}, "delays must be one or more numbers that rise"),
        ({"delays": (-0.01, 0.01)}, "delays"),
        ({"velocity_gains": ()}, "velocity_gains must be one or more"),
        ({"firing_gradients": (0.0,)}, "firing_gradients"),
        ({"roots": 0}, "roots"),
    ],
)
def test_bad_grids_are_refused(arguments: dict[str, object], message: str) -> None:
    with pytest.raises(InputError, match=message):
        studies.StabilityGrid(**arguments)  # type: ignore[arg-type]


def test_what_has_no_loop_is_refused() -> None:
    with pytest.raises(InputError, match="needs a scene with a reflex"):
        studies.stability(Scene(block(**BODY), fixed=["left"], reflex=None), {"short": COMMANDS})  # type: ignore[arg-type]
    with pytest.raises(InputError, match="unknown vowel"):
        studies.stability(block_scene(), "y")
    with pytest.raises(InputError, match="no posture"):
        studies.stability(block_scene(), {})
    motion = springs(0.01, 0.5, 40.0, 1.0)
    with pytest.raises(InputError, match="delay"):
        rightmost_roots(motion, reduced_motion(motion), -0.01, 0.0, 1)


def test_committed_study_is_of_the_built_in_speaker(reference: Speaker) -> None:
    study = committed_stability()
    check_stability(study)
    assert study.attrs["speaker_fingerprint"] == reference.fingerprint
    assert study["posture"].values.tolist() == ["i", "ə", "u", "a"]
    assert (study["reason"] == "").all()
    assert float(study["residual"].max()) < 1e-9
