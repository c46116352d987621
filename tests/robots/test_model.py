"""The equations for people's own laws: against the robots' methods, and compiled against plain Python."""

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any, ClassVar

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from simulations import UNEQUAL

import mjbiped
from controllers import Law, LawController, Memory, never
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


def flat(model: Model) -> list[float]:
    """The constants as a law's parameters."""
    return [float(each) for part in model for each in np.ravel(part)]


def on_wheel(parameters: Any, memory: Any, t: float, q: Any, dq: Any, out: Any) -> None:
    p = parameters
    model = Model(((p[0],),), (p[1],), ((p[2],),), ((p[3],),))
    out[0] = force(model, (q[0],), (dq[0],), 0)


def on_compass(parameters: Any, memory: Any, t: float, q: Any, dq: Any, out: Any) -> None:
    p = parameters
    model = Model(
        ((p[0], p[1]), (p[2], p[3])), (p[4], p[5]), ((p[6], p[7]), (p[8], p[9])), ((p[10], p[11]), (p[12], p[13]))
    )
    for i in range(2):
        out[i] = force(model, (q[0], q[1]), (dq[0], dq[1]), i)


def on_knees(parameters: Any, memory: Any, t: float, q: Any, dq: Any, out: Any) -> None:
    p = parameters
    model = Model(
        ((p[0], p[1], p[2]), (p[3], p[4], p[5]), (p[6], p[7], p[8])),
        (p[9], p[10], p[11]),
        ((p[12], p[13], p[14]), (p[15], p[16], p[17]), (p[18], p[19], p[20])),
        ((p[21], p[22], p[23]), (p[24], p[25], p[26]), (p[27], p[28], p[29])),
    )
    for i in range(3):
        out[i] = force(model, (q[0], q[1], q[2]), (dq[0], dq[1], dq[2]), i)


def nothing(parameters: Any, memory: Memory, first: Any, second: Any, third: Any) -> None:
    pass


def unknown(parameters: Any, memory: Memory) -> float:
    return math.nan


@dataclass(frozen=True)
class OnWheel(LawController):
    robot: Robot

    joints = mjbiped.RimlessWheel.joints
    forces: ClassVar[Any] = staticmethod(on_wheel)

    @property
    def plain_law(self) -> Law:
        return Law(flat(self.robot.model), self.forces, nothing, unknown, never, knee_strike=nothing)


class OnCompass(OnWheel):
    joints = mjbiped.Compass.joints
    forces = staticmethod(on_compass)


class OnKnees(OnWheel):
    joints = mjbiped.KneedBiped.joints
    forces = staticmethod(on_knees)


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
