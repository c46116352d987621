"""The stance knee's torque over a walk, and its greatest."""

import math
from dataclasses import replace

import numpy as np
import pytest

import mjbiped
from controllers import KneedController, PassiveController
from mjbiped.errors import InputError
from mjbiped.records import loads, measures
from mjbiped.robots.stance_knee import stance_knee_torque

ROBOT = mjbiped.KneedBiped()
KEY = "peak_stance_knee_torque_Nm"


@pytest.fixture(scope="module")
def walk() -> mjbiped.Walk:
    law = KneedController(ROBOT, mjbiped.find_kneed_gait(ROBOT, math.radians(2.5)))
    ground = mjbiped.Terrain.from_segments([(0.7, -2.0), (9.0, 5.0)])
    return mjbiped.walk(law, ground, engine="hybrid", steps=3)


def test_it_is_the_robots_at_each_sample(walk: mjbiped.Walk) -> None:
    found, samples = loads.knee_torque(walk), walk.samples
    assert found.shape == samples["time"].shape
    for index in (0, 50, len(found) - 1):
        q, dq, torque, slope = (samples[name][index] for name in ("q", "dq", "torque", "slope"))
        locked = bool(samples["locked"][index])
        assert found[index] == stance_knee_torque(ROBOT, q, dq, torque, slope, locked=locked)
    assert not loads.flexion(walk).any()


def test_the_greatest_is_of_those_that_a_motor_must_give(walk: mjbiped.Walk) -> None:
    found = loads.knee_torque(walk)
    assert found.min() < 0.0 < found.max()
    assert loads.peak_knee_torque(walk) == found.max()
    samples = dict(walk.samples)
    # a bent knee has no stop to lie against: what straightens it is the motor's as well
    samples["qpos"] = samples["qpos"] + np.array([0, 0, 0, 0, 0.3, 0.3])
    bent = replace(walk, samples=samples)
    assert loads.flexion(bent) == pytest.approx(0.3)
    assert loads.peak_knee_torque(bent) == np.abs(loads.knee_torque(bent)).max() > found.max()


def test_the_summary_has_it_where_there_are_samples(walk: mjbiped.Walk) -> None:
    assert measures.summary(walk)[KEY] == loads.peak_knee_torque(walk)
    rows = {label: value for label, value, _ in walk.summary().rows}
    assert rows["peak torque, stance knee"] == f"{loads.peak_knee_torque(walk):.2f}"
    bare = replace(walk, samples={name: column[:0] for name, column in walk.samples.items()})
    assert measures.summary(bare)[KEY] is None


def test_a_walk_that_diverged_is_measured_as_far_as_it_goes(walk: mjbiped.Walk) -> None:
    samples = {name: column.copy() for name, column in walk.samples.items()}
    samples["torque"][-1] = math.nan
    samples["q"][-2] = 1e6
    found = loads.knee_torque(broken := replace(walk, samples=samples))
    assert np.isnan(found[-2:]).all()
    assert np.isfinite(found[:-2]).all()
    assert loads.peak_knee_torque(broken) > 0.0


def test_straight_legs_have_none() -> None:
    ground = mjbiped.Terrain.incline(2.0)
    straight = mjbiped.walk(PassiveController(), ground, engine="hybrid", steps=1)
    assert KEY not in measures.summary(straight)
    with pytest.raises(InputError, match="a compass biped and has no knees"):
        loads.knee_torque(straight)
