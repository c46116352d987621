"""The biped with knees in MuJoCo: friction, gaps, and what its stance knee bears, by a lock or by a motor."""

import math
from typing import Any

import numpy as np
import pytest

import mjbiped
from controllers import KneedController, PassiveController
from mjbiped.engines.mujoco.step_size import Lengths, sooner
from mjbiped.errors import InputError
from mjbiped.records import loads
from mjbiped.robots.kneed import stance_knee_torque

ROBOT = mjbiped.KneedBiped()


def test_friction_is_the_feets() -> None:
    ground, icy = mjbiped.Terrain.incline(2.5), mjbiped.Disturbances(friction=0.05)
    assert mjbiped.walk(PassiveController(), ground, robot=ROBOT, steps=2, disturbances=icy).outcome == "slipped"


def test_a_gap_that_stays_open_cuts_no_step_short_that_closes_the_other() -> None:
    """A step may end half as long again as planned: rounding decides, and a touchdown was lost, one in hundreds."""
    closing, open_still = Lengths(1.0000008e-5, 1e-5, True), Lengths(1e-5, 1e-3, False)
    assert sooner(closing, open_still, 1e-5) == sooner(open_still, closing, 1e-5) == closing
    ending = Lengths(4e-6, 1e-5, False)  # but one that needs a shorter step has it
    assert sooner(closing, ending, 1e-5) == sooner(ending, closing, 1e-5) == ending


LAW = KneedController(ROBOT, mjbiped.find_kneed_gait(ROBOT, math.radians(2.5)))


def on_stairs(**settings: Any) -> mjbiped.Walk:
    stairs, motor = mjbiped.Terrain.stairs(rise=0.02, first=0.7), mjbiped.Mujoco(stance_knee="motor")
    return mjbiped.walk(LAW, stairs, engine=motor, steps=6, **settings)


@pytest.fixture(scope="module")
def held() -> mjbiped.Walk:
    return on_stairs(sample_period=1e-3)


def test_the_servo_gives_what_the_lock_bore(held: mjbiped.Walk) -> None:
    """Its torque against the equations of the locked knee, at each sample but those of 0.1 s after each impact."""
    samples, touched, bent = held.samples, held.touchdowns, loads.flexion(held)
    assert held.outcome == "finished"
    state = (samples[name] for name in ("q", "dq", "torque", "slope"))
    needed = stance_knee_torque(ROBOT, *state, locked=samples["locked"], stance_flexion=bent)
    events_at = np.concatenate([[0.0], touched["time"], np.append(0.0, touched["time"][:-1]) + touched["knee_strike"]])
    since = samples["time"][:, None] - events_at
    quiet = ~((since >= -1e-9) & (since < 0.1)).any(axis=1)
    assert np.sum(quiet & (needed > 1.0)) > 500
    # what the stop bears is not the servo's, and when the knee leaves it or comes to it the servo swings for a while
    errors = np.abs(samples["stance_knee_torque"] - np.maximum(needed, 0.0))[quiet]
    assert np.quantile(errors, 0.95) < 0.05  # measured 0.02
    assert errors.max() < 1.0
    assert needed.max() > 10.0
    assert 1e-3 < bent.max() < 0.01  # the sag that its stiffness is chosen for
    assert bent.min() > -1e-4  # the stop


def test_a_servo_is_refused_where_there_is_none_and_where_steps_are_too_long() -> None:
    ground, motor = mjbiped.Terrain.incline(2.0), mjbiped.Mujoco(stance_knee="motor")
    with pytest.raises(InputError, match=r'stance_knee = "motor" needs a robot with knees'):
        mjbiped.walk(PassiveController(), ground, engine=motor, steps=1)
    slow = mjbiped.Mujoco(stance_knee="motor", timestep=2e-3)
    with pytest.raises(InputError, match=r"timestep = 0.002 s: steps of at most 0.0012 s follow the servo"):
        mjbiped.walk(LAW, ground, engine=slow, steps=1)
