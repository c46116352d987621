"""The equations for people's own laws: against the robots' methods, and compiled against plain Python."""

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from simulations import UNEQUAL

import mjbiped
from controllers import Law, LawController, Memory, never
from mjbiped.control.machine_code import halves
from mjbiped.robots.model import (
    Model,
    Numbers,
    coriolis_matrix,
    gravity_vector,
    mass_matrix,
    rates_after_knee_strike,
    rates_after_touchdown,
)
from mjbiped.robots.robot import Robot

ROBOTS = [
    mjbiped.Compass(),
    mjbiped.Compass(leg_mass=3.1, hip_mass=7.3, lower_length=0.37, upper_length=0.58, leg_inertia=0.123, gravity=1.62),
    mjbiped.KneedBiped(),
    mjbiped.KneedBiped.halved_rods(),
    UNEQUAL,
    mjbiped.RimlessWheel(),
    mjbiped.RimlessWheel(mass=3.0, inertia=0.4, length=0.7, spokes=6, gravity=1.62),
]

# rounding of a few dozen operations; the terms differ by at most a factor of about 1e2
RELATIVE = 1e-12

angle = st.floats(-1.5, 1.5)
rate = st.floats(-8.0, 8.0)
triple = st.tuples(angle, angle, angle)
rates = st.tuples(rate, rate, rate)


@given(st.sampled_from(ROBOTS), triple, rates, angle)
@settings(deadline=None, derandomize=True)
def test_they_are_the_robots_methods(robot: Robot, angles: Numbers, speeds: Numbers, slope: float) -> None:
    model, n = robot.model, len(robot.angles)
    q, dq = angles[:n], speeds[:n]
    size, weight = np.abs(model.weights).max(), np.abs(model.moments).max()
    np.testing.assert_allclose(mass_matrix(model, q), robot.mass_matrix(q), rtol=0, atol=RELATIVE * size)
    np.testing.assert_allclose(
        coriolis_matrix(model, q, dq), robot.coriolis_matrix(q, dq), rtol=0, atol=RELATIVE * 8.0 * size
    )
    np.testing.assert_allclose(
        gravity_vector(model, q, slope), robot.gravity_vector(q, slope), rtol=0, atol=RELATIVE * weight
    )
    np.testing.assert_allclose(
        rates_after_touchdown(model, q, dq),
        robot.rates_after_touchdown(q, dq),
        rtol=0,
        atol=RELATIVE * 100 * 8.0,  # of M^-1 as well, whose condition number is up to 1e2
    )


@given(st.sampled_from([robot for robot in ROBOTS if isinstance(robot, mjbiped.KneedBiped)]), angle, angle, rates)
@settings(deadline=None, derandomize=True)
def test_the_knee_strike_is_the_robots(robot: mjbiped.KneedBiped, stance: float, swing: float, dq: Numbers) -> None:
    q = stance, swing, swing
    _, after = robot.knee_impact(q, dq)
    got = rates_after_knee_strike(robot.model, q, dq)
    np.testing.assert_allclose(got, after[[0, 1, 1]], rtol=0, atol=RELATIVE * 100 * 8.0)  # as above


def force(model: Model, q: Numbers, dq: Numbers, i: int) -> float:
    """One generalised force in which all equations take part, N m."""
    mass, coriolis, gravity = mass_matrix(model, q), coriolis_matrix(model, q, dq), gravity_vector(model, q, 0.02)
    touchdown = rates_after_touchdown(model, q, dq)
    strike = rates_after_knee_strike(model, q, dq) if len(q) == 3 else touchdown
    made = gravity[i]
    for j in range(len(q)):
        made += mass[i][j] * (touchdown[j] + strike[j]) + coriolis[i][j] * dq[j]
    return 1e-3 * made


def torque_law(model: Model, memory: Memory, t: float, *state: float) -> Numbers:
    q, dq = halves(state)
    return forces(model, q, dq)


def forces(model: Model, q: Numbers, dq: Numbers) -> Numbers:
    if len(q) == 1:
        return (force(model, q, dq, 0),)
    if len(q) == 2:
        return force(model, q, dq, 0), force(model, q, dq, 1)
    return force(model, q, dq, 0), force(model, q, dq, 1), force(model, q, dq, 2)


def nothing(model: Model, memory: Memory, *state: float) -> None:
    pass


def unknown(model: Model, memory: Memory) -> float:
    return math.nan


@dataclass(frozen=True)
class OnWheel(LawController):
    robot: Robot

    joints = mjbiped.RimlessWheel.joints

    @property
    def plain_law(self) -> Law:
        return Law(self.robot.model, torque_law, nothing, unknown, never, knee_strike=nothing)


class OnCompass(OnWheel):
    joints = mjbiped.Compass.joints


class OnKnees(OnWheel):
    joints = mjbiped.KneedBiped.joints


def plain(law: LawController) -> LawController:
    """The same law, of a class whose methods must be called."""

    class Plain(type(law)):  # type: ignore[misc]  # a class that is computed
        def torque(self, memory: Memory, t: float, q: Sequence[float], dq: Sequence[float]) -> Sequence[float]:
            return super().torque(memory, t, q, dq)  # type: ignore[no-any-return]

    made: LawController = Plain(law.robot)
    return made


WALKS = {
    "wheel": (OnWheel(mjbiped.RimlessWheel()), 5.0, (-0.39, 1.5)),
    "compass": (OnCompass(mjbiped.Compass()), 2.0, (-0.19, 0.19, 1.1, 0.81)),
    "kneed": (OnKnees(mjbiped.KneedBiped()), 3.0, (-0.19, 0.23, 0.23, 1.2, 0.8, 0.8)),
}


@pytest.mark.slow  # each compiles its engine for a law of its own
@pytest.mark.compiled
@pytest.mark.parametrize("engine", ["hybrid", "mujoco"])
@pytest.mark.parametrize("name", WALKS)
def test_compiled_they_are_the_same(name: str, engine: str) -> None:
    """Bit by bit."""
    law, slope_deg, start = WALKS[name]
    terrain = mjbiped.Terrain.incline(slope_deg)
    one, other = (mjbiped.walk(each, terrain, engine=engine, steps=1, initial=start) for each in (law, plain(law)))
    assert np.abs(one.samples["torque"]).max() > 1e-3
    assert {key: column.tobytes() for key, column in one.samples.items()} == {
        key: column.tobytes() for key, column in other.samples.items()
    }
