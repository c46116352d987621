"""Sensors, loop, motors and pushes of the biped with knees in MuJoCo; tests/disturbances has the loop's own law."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from functools import cache
from typing import Any, ClassVar

import numpy as np
import pytest

import mjbiped
from controllers import Controller, KneedController, PassiveController
from mjbiped import Disturbances, KneedBiped, Terrain, Walk
from mjbiped.control.controller import Memory

ROBOT = KneedBiped()
SLOPE = math.radians(2.5)


@cache
def gait() -> mjbiped.KneedGait:
    return mjbiped.find_kneed_gait(ROBOT, SLOPE)


@dataclass(frozen=True)
class Clock(Controller):
    """Torques too small to matter, which tell when they were asked for."""

    joints: ClassVar[tuple[str, ...]] = KneedBiped.joints

    def torque(self, memory: Memory, t: float, q: Sequence[float], dq: Sequence[float]) -> Sequence[float]:
        return 0.0, 1e-7 * (1.0 + t), 2e-7 * (1.0 + t)


def walked(disturbances: Disturbances | None, steps: int = 3, **given: Any) -> Walk:
    controller = given.pop("controller", None) or KneedController(ROBOT, gait())
    ground = given.pop("ground", Terrain.slopes(change_deg=-0.5))
    given = {"engine": "mujoco", **given}
    return mjbiped.walk(controller, ground, steps=steps, disturbances=disturbances, **given)


def passive(disturbances: Disturbances | None, controller: Controller | None = None, steps: int = 1) -> Walk:
    start = gait().start.tolist()
    own = {"ground": Terrain.incline(2.5), "controller": controller or PassiveController(), "robot": ROBOT}
    return walked(disturbances, steps, **own, sample_period=1e-3, initial=start)


@pytest.mark.parametrize("ticks", [1, 20])
def test_a_delay_shifts_torques_by_whole_ticks(ticks: int) -> None:
    period = 0.005
    each = (Disturbances(control_period=period, delay=late) for late in (0.0, ticks * period))
    prompt, late = (passive(disturbances, Clock()).samples for disturbances in each)
    time, shift = np.arange(0.0025, 0.5, period), ticks * period  # in the middle of ticks, before the knee strike
    expected = np.interp(time, prompt["time"], prompt["torque"][:, 1])
    found = np.interp(time + shift, late["time"], late["torque"][:, 1])
    inside = time + shift < 0.5
    # the torques are numbers that the walk does not feel: they differ by rounding of the times alone
    np.testing.assert_allclose(found[inside], expected[inside], rtol=1e-9)
    assert not late["torque"][late["time"] < shift - 1e-6].any()


def test_what_waits_goes_to_the_motor_that_it_was_meant_for() -> None:
    """The hip's torque acts after the touchdown with the other sign; the knee that it was for is locked by then."""
    walk = passive(Disturbances(control_period=0.005, delay=0.1), Clock(), steps=2)
    touched = walk.touchdowns["time"][0]
    time, (hip, knee) = walk.samples["time"], walk.samples["torque"][:, 1:].T
    before, after = (time > touched - 0.08) & (time < touched - 1e-9), (time > touched) & (time < touched + 0.09)
    later = (time > touched + 0.106) & (time < walk.touchdowns["time"][1] - 1e-9) & (walk.samples["locked"] == 0)
    assert (hip[before] > 0.9e-7).all()
    assert (hip[after] < -0.9e-7).all()
    assert not knee[before].any()  # it is locked
    assert not knee[after].any()
    assert (hip[later] > 0.9e-7).all()
    assert (knee[later] > 1.9e-7).all()


@pytest.mark.parametrize("impulse", [0.05, -0.05])
def test_a_short_push_is_an_impulse_through_the_mass_matrix(impulse: float) -> None:
    """Of the change of rates, a push of 1 ms differs from M^-1 J' P by what the motion goes on in it, some 1 %."""
    start = 0.2
    given = Disturbances(pushes=((start, impulse),), push_duration=1e-3)
    free, after = (passive(each).samples for each in (None, given))
    at, later = (int(np.argmin(np.abs(free["time"] - time))) for time in (start, start + 3e-3))
    q = free["q"][at]
    lever = np.array([ROBOT.leg_length * math.cos(q[0] + SLOPE), 0.0, 0.0])
    expected = np.linalg.solve(ROBOT.mass_matrix(q), lever * impulse)
    change = after["dq"][later] - free["dq"][later]
    np.testing.assert_allclose(change, expected, rtol=0.03, atol=0.01 * np.abs(expected).max())
