"""Passive gaits with knees: the design's numbers, published ones, an integration written anew, ends of branches."""

import math
from typing import Any

import numpy as np
import pytest
from scipy.integrate import solve_ivp

import mjbiped
from mjbiped.errors import GaitError, InputError
from mjbiped.gaits.kneed import KneedGait, find_kneed_gait
from mjbiped.robots.chain import Array
from mjbiped.robots.compass import Compass
from mjbiped.robots.kneed import KneedBiped

SLOPE = math.radians(2.5)


@pytest.fixture(scope="module")
def gait() -> KneedGait:
    return find_kneed_gait(KneedBiped(), SLOPE)


@pytest.fixture(scope="module")
def rods() -> KneedGait:
    return find_kneed_gait(KneedBiped.halved_rods(), math.radians(5.5))


def test_the_gait_of_light_shanks(gait: KneedGait) -> None:
    """Design, section 6, and its prototype; half a unit of the last digit given."""
    np.testing.assert_allclose(gait.start[:3], [-0.24448, 0.24448, 0.24448], rtol=0, atol=5e-6)
    np.testing.assert_allclose(gait.start[3:], [1.08907, 0.35378, 0.35378], rtol=0, atol=5e-6)
    assert gait.period == pytest.approx(0.61465, abs=5e-6)
    assert gait.knee_strike == pytest.approx(0.52706, abs=5e-6)
    assert abs(gait.multipliers[0]) == pytest.approx(0.71, abs=5e-3)
    assert gait.clearance == pytest.approx(0.026, abs=5e-4)
    assert gait.step_length == pytest.approx(2 * math.sin(0.24448), abs=2e-5)
    assert gait.stable
    assert repr(gait).startswith("<KneedGait on 2.5 deg: stable, period 0.614646 s")


def test_every_part_of_the_step_joins_the_next(gait: KneedGait) -> None:
    """From the samples alone: start, knee strike, end, and the impact that leads back to the start."""
    robot, at = gait.robot, gait.bent_samples
    before, after = gait.states[at - 1], gait.states[at]
    assert gait.times[at - 1] == gait.times[at] == pytest.approx(gait.knee_strike, abs=1e-15)
    np.testing.assert_allclose(gait.states[0], gait.start, rtol=0, atol=1e-10)  # of degree 9
    np.testing.assert_allclose(before[3:], gait.knee_rates, rtol=0, atol=1e-9)  # the dense solution is of order 7
    assert before[2] == pytest.approx(before[1], abs=1e-9)
    np.testing.assert_allclose(robot.knee_impact(gait.end[:3], gait.knee_rates)[0], gait.end[:2], rtol=0, atol=1e-12)
    _, rates = robot.knee_impact([before[0], before[1], before[1]], before[3:])
    np.testing.assert_allclose(after[[3, 4]], rates, rtol=0, atol=1e-9)
    assert robot.swing_foot(gait.end[:2])[1] == pytest.approx(0, abs=1e-10)
    q, dq = robot.heel_impact(gait.end[:2], gait.end[3:5])
    np.testing.assert_allclose([*q, *dq], gait.start[[0, 1, 3, 4]], rtol=0, atol=1e-9)  # the root finder's own
    # no torque acts: the energy changes at impacts alone
    energies = [robot.energy(state[:3], state[3:], gait.slope) for state in gait.states]
    np.testing.assert_allclose(energies[:at], energies[0], rtol=1e-9)
    np.testing.assert_allclose(energies[at:], energies[at], rtol=1e-9)
    assert energies[at] < energies[0]


def test_an_integration_written_anew_comes_back_and_has_the_same_multipliers(gait: KneedGait) -> None:
    """With one chain of three segments throughout, whose knee a force holds straight once it has struck."""
    robot, slope = gait.robot, gait.slope
    between = np.array([0.0, 1.0, -1.0])

    def law(locked: bool, y: Array) -> Array:
        q, dq = y[:3], y[3:]
        M = robot.mass_matrix(q)
        free = np.linalg.solve(M, -robot.coriolis_matrix(q, dq) @ dq - robot.gravity_vector(q, slope))
        if locked:
            turn = np.linalg.solve(M, between)
            free -= turn * (between @ free) / (between @ turn)
        return np.concatenate([dq, free])

    def step(start: Array) -> Array:
        y = np.concatenate([start[0] * np.array([1, -1, -1]), start[[1, 2, 2]]])
        for locked in (False, True):

            def strike(_: float, y: Array, locked: bool = locked) -> float:
                return float(robot.swing_foot(y[:3])[1] if locked else y[2] - y[1])

            strike.terminal, strike.direction = True, -1  # type: ignore[attr-defined]
            rates = (lambda _, y: law(True, y)) if locked else (lambda _, y: law(False, y))
            solved: Any = solve_ivp(rates, (0, 1), y, "RK45", events=strike, rtol=1e-9, atol=1e-9, max_step=0.02)
            y = solved.y_events[0][0]
            M = robot.mass_matrix(y[:3])
            turn = np.linalg.solve(M, between)
            y[3:] -= turn * (between @ y[3:]) / (between @ turn)
        q, dq = robot.heel_impact(y[:2], y[3:5])
        return np.array([q[0], *dq])

    start = gait.start[[0, 3, 4]]
    np.testing.assert_allclose(step(start), start, rtol=0, atol=1e-7)  # some 1e2 steps of relative error 1e-9
    width = 1e-3  # truncation about 1e-4 of the multipliers, noise 1e-7 / 1e-3
    columns = [(step(start + d) - step(start - d)) / (2 * width) for d in width * np.eye(3)]
    multipliers = np.linalg.eigvals(np.column_stack(columns))
    np.testing.assert_allclose(np.sort_complex(multipliers), np.sort_complex(gait.multipliers), rtol=0, atol=1e-3)


@pytest.mark.parametrize("which", ["gait", "rods"])
def test_the_ground_pushes_all_the_time_and_the_foot_clears_it(which: str, request: pytest.FixtureRequest) -> None:
    """What the equations take for granted: the stance foot never has to pull, in motion or at the knee's strike."""
    gait: KneedGait = request.getfixturevalue(which)
    robot, lowest, at = gait.robot, math.inf, gait.bent_samples
    for k, state in enumerate(gait.states):
        n = 3 if k < at else 2
        chain, q, dq = robot.chains[n], state[:n], state[3 : 3 + n]
        ddq = chain.accelerations(np.zeros(n), q, dq, gait.slope)
        upward = robot.weight * math.cos(gait.slope)
        upward -= chain.moments / robot.gravity @ (np.sin(q) * ddq + np.cos(q) * dq**2)
        lowest = min(lowest, float(upward))
    assert lowest > 0.5 * robot.weight
    chain, before, after = robot.chains[3], gait.states[at - 1], gait.states[at]
    impulse = -chain.moments / robot.gravity @ (np.sin(before[:3]) * (after[3:] - before[3:]))
    assert impulse > 0.1  # N s
    assert gait.feet[1:-1, 1].min() > 0
    assert gait.clearance > 0.005


def test_the_halved_rods_walk_too(rods: KneedGait) -> None:
    """On steeper slopes, where a prototype had found none: stable, and clear of the ground by 8 mm."""
    np.testing.assert_allclose(rods.start[[0, 3, 4]], [-0.265841, 1.287258, 0.685040], rtol=0, atol=5e-7)
    assert rods.stable
    assert rods.period == pytest.approx(0.757109, abs=5e-7)


@pytest.mark.slow
@pytest.mark.parametrize(
    ("robot", "walks", "none"),
    [(KneedBiped(), 1.96, 1.92), (KneedBiped.halved_rods(), 4.51, 4.46), (KneedBiped(), 6.84, 6.88)],
)
def test_gaits_end_where_two_meet_or_the_foot_touches(robot: KneedBiped, walks: float, none: float) -> None:
    """Downwards no gait is left; upwards the foot comes down to the ground."""
    assert find_kneed_gait(robot, math.radians(walks)).clearance < 0.02
    with pytest.raises(GaitError):
        find_kneed_gait(robot, math.radians(none))


def test_robots_that_are_alike_walk_alike(gait: KneedGait) -> None:
    """Twice the length, a third of the mass, the moon's gravity: the same angles, times as sqrt(l/g)."""
    robot, gravity = gait.robot, 1.62
    other = KneedBiped(
        robot.thigh_mass / 3, robot.shank_mass / 3, robot.hip_mass / 3, 1.0, 1.0, 0.6, 0.18, gravity=gravity
    )
    time = math.sqrt(2 * robot.gravity / gravity)
    found = find_kneed_gait(other, gait.slope)
    # both by the same search; its tolerance is 1e-11, and the integration's relative to the units
    np.testing.assert_allclose(found.start[:3], gait.start[:3], rtol=0, atol=1e-8)
    np.testing.assert_allclose(found.start[3:], gait.start[3:] / time, rtol=0, atol=1e-8)
    assert found.period == pytest.approx(gait.period * time, rel=1e-8)
    assert found.clearance == pytest.approx(2 * gait.clearance, abs=1e-4)  # of samples


@pytest.mark.slow
def test_what_cannot_be_found_is_told() -> None:
    with pytest.raises(GaitError, match=r"walks only downhill; give one above 0, to 89.95 degrees"):
        find_kneed_gait(KneedBiped(), 0.0)
    with pytest.raises(InputError, match=r"robot must be a mjbiped.KneedBiped, got Compass"):
        find_kneed_gait(Compass(), 0.1)  # type: ignore[arg-type]
    with pytest.raises(GaitError, match=r"no passive gait on a slope of 25 degrees: the search found none"):
        find_kneed_gait(KneedBiped(), math.radians(25))
    with pytest.raises(GaitError, match="the search found none"):  # the swing foot would dip into the ground
        find_kneed_gait(KneedBiped(), math.radians(7.2))
    assert mjbiped.find_kneed_gait is find_kneed_gait
    assert mjbiped.KneedGait is KneedGait
