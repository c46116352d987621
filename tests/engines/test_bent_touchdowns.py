"""Touchdowns with a bent knee: both engines make them the same, and the controller goes on."""

import math

import numpy as np
import pytest
from simulations import hybrid_run

import mjbiped
from controllers import KneedController
from mjbiped.controllers.footholds import stand_bent
from mjbiped.controllers.memory import BENT
from mjbiped.dynamics.modes import bend_stance_knee
from mjbiped.engines.hybrid.motion import enter_mode
from mjbiped.records import measures

ROBOT = mjbiped.KneedBiped()
GROUND = mjbiped.Terrain.from_segments([(0.6, 0.0, 0.0), (20.0, 0.0, 0.03)])
"""The passive gait clears 2.6 cm: two feet in a row come down on or after the riser before their knee is straight."""


@pytest.fixture(scope="module")
def law() -> KneedController:
    return KneedController(ROBOT, mjbiped.find_kneed_gait(ROBOT, math.radians(2.5)))


@pytest.fixture(scope="module")
def hybrid(law: KneedController) -> mjbiped.Walk:
    return mjbiped.walk(law, GROUND, engine="hybrid", steps=8, sample_period=1e-3)


def test_the_engines_agree(law: KneedController, hybrid: mjbiped.Walk) -> None:
    grip = mjbiped.Disturbances(friction=5.0)  # these impacts ask for more than the usual 0.8
    mujoco = mjbiped.walk(law, GROUND, engine="mujoco", steps=8, disturbances=grip)
    here, there = hybrid.touchdowns, mujoco.touchdowns
    assert (hybrid.outcome, mujoco.outcome) == ("finished", "finished")
    flexions = ROBOT.flexion(here["qpos"], here["stance"])
    assert (flexions > 0.4).tolist() == [False, True, True] + [False] * 5
    # MuJoCo's soft impacts err by 1e-4, and each step after one enlarges its error about tenfold. Measured 2.8e-3,
    # 7.3e-3 and 6.1e-3, with steps of 0.05 ms as with 0.1 ms
    np.testing.assert_allclose(there["time"], here["time"], rtol=0, atol=4e-3)
    np.testing.assert_allclose(there["qpos"], here["qpos"], rtol=0, atol=1e-2)
    np.testing.assert_allclose(there["dq"], here["dq"], rtol=0, atol=1e-2)
    assert mujoco.cost_of_transport == pytest.approx(hybrid.cost_of_transport, rel=1e-2)  # measured 7e-3


def test_the_impact_is_the_map_of_the_state_before(hybrid: mjbiped.Walk) -> None:
    assert np.abs(measures.impact_errors(hybrid)).max() < 1e-12  # rounding; the map is checked in test_bent_leg.py


def test_the_update_compares_thighs(hybrid: mjbiped.Walk) -> None:
    """All of this ground is level; the line of a bent leg is 0.2 rad from its thigh."""
    touched = hybrid.touchdowns
    np.testing.assert_allclose(touched["slope_estimate"], touched["slope_estimate_before"], rtol=0, atol=1e-12)


def test_a_leg_that_stands_bent_is_not_taken_for_a_slope(law: KneedController) -> None:
    """A step that begins on one, with a true estimate, is tracked exactly, and leaves the estimate as it is."""
    flexion = 0.4
    simulation = hybrid_run(
        law,
        mjbiped.Terrain.level(),
        robot=ROBOT,
        q=(-0.1, 0.1, 0.6),  # off the limit cycle: from here it is planned
        dq=(1.0, 0.3, 0.0),
        steps=1,
        sample_period=1e-3,
    )
    c, w = simulation.constants, simulation.state
    w.stance_flexion = w.memory[BENT] = flexion
    stand_bent(law.law().parameters, w.memory)
    bend_stance_knee(w, c.upper, c.lower, flexion)
    enter_mode(c, w)
    simulation.go()
    samples = simulation.recorder.samples()
    led = samples["time"] < 0.8 * law.gait.period  # by the transition
    assert np.count_nonzero(led) > 450
    np.testing.assert_array_equal(samples["qpos"][led, 4], flexion)
    # the tolerance of an integration step; 0.035 rad if the law takes it for a straight leg
    assert np.abs(samples["slope_estimate"][led]).max() < 1e-8


def test_samples_hold_the_bent_stance_leg(hybrid: mjbiped.Walk) -> None:
    """Its foot stays where it is, its knee as it was; q is the line's angle, and after its step the knee is free."""
    touched, samples = hybrid.touchdowns, hybrid.samples
    for index in (1, 2):
        leg, x = int(touched["stance"][index]), touched["x"][index]
        during = (samples["time"] > touched["time"][index]) & (samples["time"] < touched["time"][index + 1])
        qpos = samples["qpos"][during]
        feet = ROBOT.limbs(qpos)[:, leg, -1]
        np.testing.assert_allclose(feet, [[x, touched["z"][index]]] * len(feet), rtol=0, atol=1e-12)
        line = np.arctan2(*(qpos[:, :2] - feet).T)
        np.testing.assert_allclose(samples["q"][during, 0], line, rtol=0, atol=1e-12)
        first = np.flatnonzero(samples["time"] > touched["time"][index + 1])[0]
        assert ROBOT.flexion(samples["qpos"][first], leg) == pytest.approx(ROBOT.flexion(qpos[0], leg), abs=0.02)
        assert not samples["locked"][first]
