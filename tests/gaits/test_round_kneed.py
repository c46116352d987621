"""Passive gaits with knees on round feet: McGeer's machine, its branch, and feet of no radius."""

import math

import numpy as np
import pytest
from numpy.typing import ArrayLike

from mjbiped.gaits.cycle import step
from mjbiped.gaits.kneed import KneedGait, find_kneed_gait
from mjbiped.robots.chain import Array
from mjbiped.robots.kneed import KneedBiped
from mjbiped.robots.robot import Robot
from mjbiped.robots.round import RoundKneed

SLOPE = 0.0456
PLAIN = KneedBiped()


class Latched(RoundKneed):
    """A latch keeps the departing knee straight through the heel strike, as that of `KneedBiped`."""

    knee_opens = False

    def heel_impact(self, q: ArrayLike, dq: ArrayLike) -> tuple[Array, Array]:
        """Legs of one piece."""
        angles, rates = np.asarray(q), np.asarray(dq)
        return angles[::-1], self.rates_after_touchdown(angles[[0, 1, 1]], rates[[0, 1, 1]])[:2]

    def after_touchdown(self, places: Array) -> Array:
        """The knee is straight."""
        return Robot.after_touchdown(self, places)


@pytest.fixture(scope="module")
def gait() -> KneedGait:
    return find_kneed_gait(RoundKneed(), SLOPE)


@pytest.mark.slow
def test_the_gait_of_mcgeers_machine(gait: KneedGait) -> None:
    """The numbers that he gives to two or three digits, from the nonlinear model; half a unit of our last digit."""
    pair, _, real = gait.multipliers
    assert (abs(pair), abs(np.angle(pair))) == pytest.approx((0.4606, 0.9443), abs=5e-5)
    assert real == pytest.approx(0.0670, abs=5e-5)
    assert gait.stable
    second = math.sqrt(1.0 / 9.81)
    assert gait.period / second == pytest.approx(2.6550, abs=5e-5)
    assert gait.start[0] == pytest.approx(-0.35011, abs=5e-6)
    assert gait.start[5] > gait.start[4]  # the heel strike bends the departing knee
    assert gait.clearance == pytest.approx(0.0088, abs=5e-5)


@pytest.mark.slow
def test_every_part_of_the_step_joins_the_next(gait: KneedGait) -> None:
    """As with point feet, and the energy of a foot that rolls is constant between impacts."""
    robot, at = gait.robot, gait.bent_samples
    before, after = gait.states[at - 1], gait.states[at]
    # states are read from the table, whose pieces of degree 9 keep the rates of so quick a shank to 2.5e-10
    np.testing.assert_allclose(gait.states[0], gait.start, rtol=0, atol=1e-9)
    assert before[2] == pytest.approx(before[1], abs=1e-9)
    _, rates = robot.knee_impact([before[0], before[1], before[1]], before[3:])
    np.testing.assert_allclose(after[[3, 4]], rates, rtol=0, atol=1e-9)
    assert robot.swing_foot(gait.end[:2])[1] == pytest.approx(0, abs=1e-10)
    q, dq = robot.heel_impact(gait.end[:2], gait.end[3:5])
    np.testing.assert_allclose([*q, *dq], gait.start, rtol=0, atol=1e-9)  # the root finder's own
    energies = [robot.energy(state[:3], state[3:], gait.slope) for state in gait.states]
    np.testing.assert_allclose(energies[:at], energies[0], rtol=1e-9)
    np.testing.assert_allclose(energies[at:], energies[at], rtol=1e-9)
    assert energies[at] < energies[0]
    # and what the impacts take is what the way downhill gives
    way = gait.step_length * math.sin(gait.slope) * robot.weight
    lost = robot.kinetic_energy(gait.end[:3], gait.end[3:]) - robot.kinetic_energy(gait.start[:3], gait.start[3:])
    lost += energies[0] - energies[at]
    assert lost == pytest.approx(way, rel=1e-9)


def test_the_reference_is_the_motion_up_to_the_end(gait: KneedGait) -> None:
    q, dq, _ = gait.reference(gait.times[1:-1])
    smooth = np.abs(gait.times[1:-1] - gait.knee_strike) > 1e-9
    np.testing.assert_allclose(np.hstack([q, dq])[smooth], gait.states[1:-1][smooth], rtol=0, atol=1e-6)


@pytest.mark.slow
def test_sizes_and_gravities_do_not_matter(gait: KneedGait) -> None:
    """In units of leg, mass and gravity."""
    scaled = find_kneed_gait(RoundKneed(gravity=1.0, thigh_mass=0.1, shank_mass=0.062, hip_mass=0.676), SLOPE)
    np.testing.assert_allclose(scaled.multipliers, gait.multipliers, rtol=0, atol=1e-5)
    assert scaled.step_length == pytest.approx(gait.step_length, abs=1e-8)


def test_without_radius_and_latched_steps_are_those_of_point_feet() -> None:
    """The whole step from the gait of `KneedBiped`, integrated to 1e-11, is the same to rounding."""
    numbers = {name: getattr(PLAIN, name) for name in KneedBiped.numbers()}
    point = Latched(**numbers, foot_radius=0.0, stop_angle=0.0, shank_offset=0.0)
    gait = find_kneed_gait(PLAIN, math.radians(2.5))
    second = math.sqrt(1.0 / 9.81)
    for scaled in (gait.start[[0, 3, 4]] * [1.0, second, second], np.array([-0.22, 0.32, 0.09])):
        mine, its = (step(robot, gait.slope, scaled) for robot in (point, PLAIN))
        np.testing.assert_allclose(mine.after, its.after, rtol=0, atol=1e-12)
        assert mine.second.duration == pytest.approx(its.second.duration, abs=1e-12)


def test_the_stop_alone_lets_the_knee_of_a_point_foot_open() -> None:
    """So the heel strike is another one than that of `KneedBiped`, whose knee is latched."""
    numbers = {name: getattr(PLAIN, name) for name in KneedBiped.numbers()}
    point = RoundKneed(**numbers, foot_radius=0.0, stop_angle=0.0, shank_offset=0.0)
    end = find_kneed_gait(PLAIN, math.radians(2.5)).end
    _, rates = point.heel_impact(end[:2], end[3:5])
    assert rates[2] - rates[1] > 1.0


@pytest.mark.slow
def test_gaits_of_mcgeers_machine_end_where_the_foot_scrapes() -> None:
    gentle = find_kneed_gait(RoundKneed(), math.radians(0.62))
    assert gentle.clearance < 5e-4
    assert abs(find_kneed_gait(RoundKneed(), math.radians(4.3)).multipliers[0]) > 0.95
