"""A disturbed control loop with knees, in the hybrid engine."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from functools import cache
from typing import Any, ClassVar

import numpy as np
import pytest
from command_line import run

import mjbiped
from controllers import Controller, KneedController
from mjbiped import Disturbances, KneedBiped, Terrain, Walk
from mjbiped.control.controller import Law, Memory
from mjbiped.disturbances.loop import SampledController

ROBOT = KneedBiped()
SLOPE = 2.5


@cache
def gait() -> mjbiped.KneedGait:
    return mjbiped.find_kneed_gait(ROBOT, math.radians(SLOPE))


@cache
def adaptive() -> KneedController:
    return KneedController(ROBOT, gait())


def walked(disturbances: Disturbances | None, steps: int = 4, **given: Any) -> Walk:
    ground = given.pop("ground", Terrain.slopes(change_deg=-0.5))
    controller = given.pop("controller", None) or adaptive()
    return mjbiped.walk(controller, ground, engine="hybrid", steps=steps, disturbances=disturbances, **given)


NOISY = Disturbances(
    angle_noise=0.002,
    rate_noise=0.02,
    angle_bias=0.003,
    rate_bias=-0.01,
    angle_resolution=0.001,
    delay=0.004,
    torque_limit=20.0,
    motor_bandwidth=30.0,
    seed=5,
)


@dataclass(frozen=True)
class Clock(Controller):
    """Torques too small to matter, which tell when they were asked for, or what was read."""

    joints: ClassVar[tuple[str, ...]] = KneedBiped.joints
    robot = ROBOT
    reading: bool = False

    def torque(self, memory: Memory, t: float, q: Sequence[float], dq: Sequence[float]) -> Sequence[float]:
        if self.reading:
            return 1e-7 * q[0], 1e-7 * (q[1] - q[0]), 1e-7 * (q[2] - q[1])
        return 0.0, 1e-7 * (1.0 + t), 2e-7 * (1.0 + t)


def clocked(disturbances: Disturbances, reading: bool = False, steps: int = 1) -> Walk:
    """A passive walk, for the torques are some 1e-7 of the robot's, with samples in each fifth of a tick of 5 ms."""
    initial = gait().start.tolist()
    ground, controller = Terrain.incline(SLOPE), Clock(reading)
    return walked(disturbances, steps, ground=ground, controller=controller, sample_period=0.001, initial=initial)


@pytest.mark.slow
def test_a_seed_gives_a_walk_bit_by_bit_also_in_threads() -> None:
    each = [NOISY, Disturbances.from_dict({**NOISY.to_dict(), "seed": 6})]
    ground = Terrain.slopes(change_deg=-0.5)
    together = mjbiped.walk_many(adaptive(), ground, engine="hybrid", steps=4, disturbances=each, workers=2)
    assert [walk.steps for walk in together] == [4, 4]
    assert together[0] == walked(NOISY)
    assert together[1] == walked(each[1])
    assert together[0] != together[1]


@pytest.mark.slow
@pytest.mark.compiled
def test_plain_python_walks_as_compiled() -> None:
    class InPython(KneedController):
        def law(self) -> Law | None:  # type: ignore[override]  # as a controller may
            return None

    ours, theirs = walked(NOISY, steps=2), walked(NOISY, steps=2, controller=InPython(ROBOT, gait()))
    for name in ("q", "dq", "torque"):
        np.testing.assert_array_equal(ours.samples[name], theirs.samples[name])


@pytest.mark.parametrize("ticks", [1, 20])
def test_a_delay_shifts_torques_by_whole_ticks(ticks: int) -> None:
    period = 0.005
    prompt = clocked(Disturbances(control_period=period)).samples["torque"][:-6, 1:]
    late = clocked(Disturbances(control_period=period, delay=ticks * period)).samples["torque"][: len(prompt), 1:]
    shift = round(ticks * period / 0.001)
    # the samples' times are the ticks' to rounding, so that one of them falls on either side: compared are the others
    inner = np.arange(len(prompt)) % 5 != 0
    inner[:shift] = False
    # the torques are numbers that the walk does not feel: they differ by rounding of the times alone
    np.testing.assert_allclose(late[inner], prompt[np.flatnonzero(inner) - shift], rtol=1e-9)
    assert not late[: shift - 1].any()


def test_what_waits_goes_to_the_motor_that_it_was_meant_for() -> None:
    """The hip's torque acts after the touchdown with the other sign; the knee that it was for is locked by then."""
    walk = clocked(Disturbances(control_period=0.005, delay=0.1), steps=2)
    touched = walk.touchdowns["time"][0]
    time, (hip, knee) = walk.samples["time"], walk.samples["torque"][:, 1:].T
    before, after = (time > touched - 0.08) & (time < touched), (time > touched + 0.006) & (time < touched + 0.09)
    later = time > touched + 0.106
    assert (hip[before] > 0.9e-7).all()
    assert (hip[after] < -0.9e-7).all()
    assert (knee[before] > 1.9e-7).all()
    assert (knee[after] == 0.0).all()
    assert (hip[later][:-1] > 0.9e-7).all()  # the last sample is after another touchdown
    assert (knee[later][:-1] > 1.9e-7).all()


def test_noise_and_bias_of_each_joint_are_as_large_as_they_say() -> None:
    """Of some 120 ticks in one step: five deviations of mean and of deviation are allowed."""
    noise, bias = 0.01, 0.005
    given = Disturbances(control_period=0.005, angle_noise=noise, angle_bias=bias, seed=1)
    noisy, true = (clocked(each, reading=True).samples for each in (given, Disturbances(control_period=0.005)))
    error = 1e7 * (noisy["torque"] - true["torque"])[slice(2, 595, 5)]  # one sample in each tick
    count = len(error)
    assert (np.abs(error.mean(axis=0) - bias) < 5.0 * noise / math.sqrt(count)).all()
    assert (np.abs(error.std(axis=0) / noise - 1.0) < 5.0 / math.sqrt(2.0 * count)).all()
    # joints have nothing to do with one another: five deviations of a correlation
    assert np.abs(np.corrcoef(error.T)[np.triu_indices(3, 1)]).max() < 5.0 / math.sqrt(count)
    # the last joint is the knee: what it reads without noise is its flexion, of at most one tick ago, at 8 rad/s
    flexion = np.diff(true["q"], axis=1)[:, 1]
    assert np.abs(1e7 * true["torque"][:-1, 2] - flexion[:-1])[2:].max() < 0.005 * 8.0


def test_what_a_controller_is_told_is_each_joints_encoder() -> None:
    """Where there is bias alone each joint's error is known: that of the hip has the sign of the standing leg."""

    class Told(Clock):
        """Keeps what it is told at events, for the test to look at."""

        def on_touchdown(
            self, memory: Memory, q_before: Sequence[float], q: Sequence[float], dq: Sequence[float]
        ) -> None:
            heard.append((*q_before, *q, *dq))

        def on_knee_strike(self, memory: Memory, t: float, q: Sequence[float], dq: Sequence[float]) -> None:
            heard.append((*q, *dq))

    heard: list[tuple[float, ...]] = []
    a, r = 0.01, 0.1
    loop = SampledController(Told(), Disturbances(angle_bias=a, rate_bias=r), 1e-3)
    memory = [0.0] * loop.memory_size
    before, after, rates = (0.1, -0.2, 0.3), (-0.2, 0.1, 0.1), (1.0, 2.0, 3.0)
    loop.start(memory, before, rates)
    loop.on_knee_strike(memory, 0.4, before, rates)
    loop.on_touchdown(memory, before, after, rates)
    loop.on_knee_strike(memory, 0.4, before, rates)
    left, right = (a, 2.0 * a, 3.0 * a), (a, 0.0, a)  # stance leg, thigh, shank: ankle, plus or minus hip, plus knee
    expected = [
        (*np.add(before, left), *np.add(rates, np.multiply(left, r / a))),
        # the posture is read once at the hip, which is right to left in the new roles
        (*np.add(before, left), *np.add(after, right), *np.add(rates, np.multiply(right, r / a))),
        (*np.add(before, right), *np.add(rates, np.multiply(right, r / a))),
    ]
    for found, wanted in zip(heard, expected, strict=True):
        np.testing.assert_allclose(found, wanted, rtol=0.0, atol=1e-15)


@pytest.mark.slow
def test_no_torque_is_greater_than_the_limit() -> None:
    """4 N m bind: without a limit this walk asks for more."""
    free, bound = walked(None), walked(Disturbances(torque_limit=4.0, motor_bandwidth=50.0))
    assert free.peak_torque.max() > 4.4
    assert np.abs(bound.samples["torque"]).max() <= 4.0
    assert bound.peak_torque.max() <= 4.0


@pytest.mark.slow
def test_walks_converge_to_a_controller_that_never_pauses() -> None:
    """A torque that is held is late by half a period: the error is of first order in it."""
    plain = walked(None, steps=3).end[0]
    errors = [abs(walked(Disturbances(control_period=period), steps=3).end[0] - plain) for period in (4e-3, 2e-3, 1e-3)]
    assert errors[0] < 4e-3
    assert 1.5 < errors[0] / errors[1] < 2.7
    assert 1.5 < errors[1] / errors[2] < 2.7


@pytest.mark.slow
def test_the_command_line_disturbs_robots_with_knees(tmp_path: Any) -> None:
    out = tmp_path / "walk.npz"
    options = ["--engine", "hybrid", "--imitate-slope-deg", "2.5", "--disturb", "delay=0.004", "--push", "1:2"]
    run("walk", "level", "--robot", "kneed", *options, "--steps", 3, "--out", out)
    walk = Walk.load(out)
    assert walk.settings["disturbances"] == {"delay": 0.004, "pushes": [[1.0, 2.0]]}
    again = walked(Disturbances.from_dict(walk.settings["disturbances"]), steps=3, ground=Terrain.level())
    assert again.touchdowns["x"] == pytest.approx(walk.touchdowns["x"], abs=1e-12)
