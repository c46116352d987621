"""The stance knee in MuJoCo: what its lock bears, by MuJoCo's own forces, and a motor that holds it instead."""

import math
from typing import Any

import numpy as np
import pytest

import mjbiped
from controllers import KneedController, PassiveController
from mjbiped.errors import InputError
from mjbiped.records import loads, measures
from mjbiped.robots.kneed import stance_knee_torque

ROBOT = mjbiped.KneedBiped()
LAW = KneedController(ROBOT, mjbiped.find_kneed_gait(ROBOT, math.radians(2.5)))


STAIRS = mjbiped.Terrain.stairs(rise=0.02, first=0.7)


def walked(stance_knee: str, **settings: Any) -> mjbiped.Walk:
    return mjbiped.walk(LAW, STAIRS, engine=mjbiped.Mujoco(stance_knee=stance_knee), steps=6, **settings)


@pytest.fixture(scope="module")
def held() -> mjbiped.Walk:
    return walked("motor", sample_period=1e-3)


def test_the_servo_gives_what_the_lock_bore(held: mjbiped.Walk) -> None:
    """Its torque against the equations of the locked knee, at each sample but those of 0.1 s after each impact."""
    samples, touched = held.samples, held.touchdowns
    assert held.outcome == "finished"
    needed = stance_knee_torque(
        ROBOT,
        *(samples[name] for name in ("q", "dq", "torque", "slope")),
        locked=samples["locked"],
        stance_flexion=(bent := loads.flexion(held)),
    )
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


def test_its_work_is_that_of_its_torque_and_counts(held: mjbiped.Walk) -> None:
    samples, touched = held.samples, held.touchdowns
    peaks = np.abs(samples["stance_knee_torque"]).max()
    assert touched["stance_knee_torque"].max() == pytest.approx(peaks, rel=0.02)  # of all steps, of samples
    work = np.abs(0.5 * (samples["stance_knee_torque"][1:] + samples["stance_knee_torque"][:-1])
                  * np.diff(loads.flexion(held)))[np.diff(samples["stance"]) == 0].sum()  # fmt: skip
    assert touched["stance_knee_work"][-1] == pytest.approx(work, rel=0.02)
    summary = measures.summary(held)
    assert summary["peak_stance_knee_torque_Nm"] == pytest.approx(peaks, rel=0.02)
    part = touched["stance_knee_work"][-1] / (ROBOT.weight * held.distance)
    assert summary["cost_of_transport_stance_knee"] == part > 0.0
    bare = walked("motor", sample_period=None)
    told = ("peak_stance_knee_torque_Nm", "cost_of_transport_stance_knee")
    assert [measures.summary(bare)[key] for key in told] == [summary[key] for key in told]


def test_a_servo_is_refused_where_there_is_none_and_where_steps_are_too_long() -> None:
    ground, motor = mjbiped.Terrain.incline(2.0), mjbiped.Mujoco(stance_knee="motor")
    with pytest.raises(InputError, match=r'stance_knee = "motor" needs a robot with knees'):
        mjbiped.walk(PassiveController(), ground, engine=motor, steps=1)
    slow = mjbiped.Mujoco(stance_knee="motor", timestep=2e-3)
    with pytest.raises(InputError, match=r"timestep = 0.002 s: steps of at most 0.0012 s follow the servo"):
        mjbiped.walk(LAW, ground, engine=slow, steps=1)
