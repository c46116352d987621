"""A disturbed control loop in both engines."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from functools import cache
from typing import Any, ClassVar

import numpy as np
import pytest

import mjbiped
from controllers import AdaptiveController, Controller
from mjbiped import Disturbances, Walk
from mjbiped.control.controller import Law, Memory

ENGINES = ("mujoco", "hybrid")
ROBOT = mjbiped.Compass()


@cache
def adaptive() -> AdaptiveController:
    return AdaptiveController(ROBOT, mjbiped.find_passive_gait(ROBOT, math.radians(2.0)))


def walked(engine: Any, disturbances: Disturbances | None, steps: int = 6, **given: Any) -> Walk:
    ground = given.pop("ground", mjbiped.Terrain.slopes(change_deg=-0.5))
    controller = given.pop("controller", None) or adaptive()
    return mjbiped.walk(controller, ground, engine=engine, steps=steps, disturbances=disturbances, **given)


def samples_of(walk: Walk) -> list[bytes]:
    return [walk.samples[name].tobytes() for name in sorted(walk.samples)]


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


@pytest.mark.parametrize("engine", ENGINES)
def test_nothing_given_is_no_disturbance(engine: str) -> None:
    assert walked(engine, None) == walked(engine, Disturbances()) == walked(engine, Disturbances(seed=0))
    assert "disturbances" not in walked(engine, None, steps=1).settings


def test_a_control_period_is_the_one_that_mujoco_has() -> None:
    """Two ways to say the same, but for the work's rule at ticks (`motors.count_work`)."""
    ours, own = walked("mujoco", Disturbances(control_period=4e-3)), walked(mjbiped.Mujoco(control_period=4e-3), None)
    for name in ("time", "x", "q", "dq", "slope_estimate"):
        np.testing.assert_array_equal(ours.touchdowns[name], own.touchdowns[name])
    assert math.isclose(ours.cost_of_transport, own.cost_of_transport, rel_tol=5e-3)


@pytest.mark.slow
@pytest.mark.parametrize("engine", ENGINES)
def test_a_seed_gives_a_walk_bit_by_bit(engine: str) -> None:
    first = walked(engine, NOISY)
    assert first == walked(engine, NOISY)
    assert first.steps == 6
    other = walked(engine, Disturbances(**{**NOISY.to_dict(), "seed": 6}))
    assert samples_of(first) != samples_of(other)


@pytest.mark.slow
@pytest.mark.parametrize("engine", ENGINES)
def test_walks_in_threads_are_the_same(engine: str) -> None:
    each = [Disturbances(angle_noise=0.003, seed=seed) for seed in range(3)]
    together = mjbiped.walk_many(
        adaptive(), mjbiped.Terrain.slopes(change_deg=-0.5), engine=engine, steps=4, disturbances=each, workers=2
    )
    for walk, disturbances in zip(together, each, strict=True):
        assert walk == walked(engine, disturbances, steps=4)
    assert together[0] != together[1]


@pytest.mark.parametrize("engine", ENGINES)
def test_plain_python_walks_as_compiled(engine: str) -> None:
    """Bitwise in MuJoCo; in the hybrid engine the integrator may round products otherwise (docs/hybrid.md)."""

    class InPython(AdaptiveController):
        def law(self) -> Law | None:  # type: ignore[override]  # as a controller may
            return None

    law = adaptive()
    python = InPython(law.robot, law.gait)
    ours, theirs = walked(engine, NOISY, steps=2), walked(engine, NOISY, steps=2, controller=python)
    if engine == "mujoco":
        assert samples_of(ours) == samples_of(theirs)
    else:
        for name in ("q", "dq", "torque"):
            # rounding, and what an encoder's step of 1e-3 rad may make of it where it decides, which it does not here
            np.testing.assert_allclose(ours.samples[name], theirs.samples[name], rtol=1e-9, atol=1e-9)


@pytest.mark.parametrize("engine", ENGINES)
def test_no_torque_is_greater_than_the_limit(engine: str) -> None:
    """2 N m bind: without a limit this walk asks for more."""
    free, bound = walked(engine, None), walked(engine, Disturbances(torque_limit=2.0, motor_bandwidth=50.0))
    assert free.peak_torque.max() > 2.2
    assert np.abs(bound.samples["torque"]).max() <= 2.0
    assert bound.peak_torque.max() <= 2.0


@dataclass(frozen=True)
class Clock(Controller):
    """Torques that tell when they were asked for, and what was read."""

    memory_size: ClassVar[int] = 1
    reading: bool = False

    def on_touchdown(self, memory: Memory, q_before: Sequence[float], q: Sequence[float], dq: Sequence[float]) -> None:
        memory[0] += 1.0

    def torque(self, memory: Memory, t: float, q: Sequence[float], dq: Sequence[float]) -> Sequence[float]:
        if self.reading:
            return 1e-6 * q[0], 1e-6 * (q[1] - q[0])
        return 0.0, 1e-6 * (1.0 + t)


def clocked(engine: str, disturbances: Disturbances, reading: bool = False, steps: int = 1) -> Walk:
    """A walk with torques too small to matter, sampled at the middle of each tick of 5 ms."""
    return walked(
        engine,
        disturbances,
        steps=steps,
        ground=mjbiped.Terrain.incline(2.0),
        controller=Clock(reading),
        sample_period=0.001,
    )


@pytest.mark.parametrize("engine", ENGINES)
@pytest.mark.parametrize("ticks", [1, 3, 20])
def test_a_delay_shifts_torques_by_whole_ticks(engine: str, ticks: int) -> None:
    period = 0.005
    prompt = clocked(engine, Disturbances(control_period=period))
    late = clocked(engine, Disturbances(control_period=period, delay=ticks * period))
    hip = prompt.samples["torque"][:-6, 1]
    shift = round(ticks * period / 0.001)
    given = late.samples["torque"][: len(hip), 1]
    # the samples' times are the ticks' to rounding, so that one of them falls on either side: compared are the others
    inner = np.arange(len(hip)) % 5 != 0
    inner[:shift] = False
    np.testing.assert_allclose(given[inner], hip[np.flatnonzero(inner) - shift], rtol=1e-12)
    assert not given[: shift - 1].any()


@pytest.mark.parametrize("engine", ENGINES)
def test_what_waits_goes_to_the_motor_that_it_was_meant_for(engine: str) -> None:
    """A torque of the hip that was asked for before a touchdown acts after it with the other sign."""
    walk = clocked(engine, Disturbances(control_period=0.005, delay=0.1), steps=2)
    touched = walk.touchdowns["time"][0]
    time, hip = walk.samples["time"], walk.samples["torque"][:, 1]
    before, after = (time > touched - 0.08) & (time < touched), (time > touched + 0.006) & (time < touched + 0.09)
    assert (hip[before] > 0.9e-6).all()
    assert (hip[after] < -0.9e-6).all()
    assert (hip[time > touched + 0.106][:-1] > 0.9e-6).all()  # the last sample is after another touchdown


@pytest.mark.parametrize("engine", ENGINES)
def test_encoders_are_off_by_half_a_step_at_most(engine: str) -> None:
    step = 0.02
    read = clocked(engine, Disturbances(control_period=0.005, angle_resolution=step), reading=True).samples
    at_ticks = np.abs(read["time"] / 0.005 - np.round(read["time"] / 0.005)) < 1e-6
    joints = np.stack([read["q"][:, 0], read["q"][:, 1] - read["q"][:, 0]], axis=1)
    shown = read["torque"] * 1e6
    # a reading is a whole number of steps, of an angle up to one tick ago: 5 ms at 3 rad/s
    np.testing.assert_allclose(shown / step, np.round(shown / step), atol=1e-9)
    assert np.abs(shown - joints)[2:-2].max() <= 0.5 * step + 0.005 * 3.0
    assert at_ticks.any()
    if engine == "mujoco":  # samples on a tick are taken after it
        assert np.abs(shown - joints)[at_ticks][:-2].max() <= 0.5 * step + 1e-9


@pytest.mark.parametrize("engine", ENGINES)
def test_noise_and_bias_are_as_large_as_they_say(engine: str) -> None:
    """Of some 150 ticks in one step: five deviations of mean and of deviation are allowed."""
    noise, bias = 0.01, 0.005
    given = Disturbances(control_period=0.005, angle_noise=noise, angle_bias=bias, seed=1)
    noisy = clocked(engine, given, reading=True).samples
    true = clocked(engine, Disturbances(control_period=0.005), reading=True).samples
    middle = slice(2, 745, 5)  # one sample in each tick
    error = 1e6 * (noisy["torque"] - true["torque"])[middle]
    count = len(error)
    for joint in (0, 1):
        assert abs(error[:, joint].mean() - bias) < 5.0 * noise / math.sqrt(count)
        assert abs(error[:, joint].std() / noise - 1.0) < 5.0 / math.sqrt(2.0 * count)


def test_both_engines_hear_the_same_noise() -> None:
    given = Disturbances(control_period=0.005, angle_noise=0.01, seed=9)
    first, second = (1e6 * clocked(engine, given, reading=True).samples["torque"][2:740:5] for engine in ENGINES)
    # the noise is the same, number by number; the motions differ by 1e-4 rad and less
    assert np.abs(first - second).max() < 1e-3


@pytest.mark.parametrize("engine", ENGINES)
def test_a_motor_of_first_order_answers_as_one(engine: str) -> None:
    """A constant demand: 1 - exp(-2 pi f t), in the mean over each tick of 10 ms."""

    class Constant(Controller):
        def torque(self, memory: Memory, t: float, q: Sequence[float], dq: Sequence[float]) -> Sequence[float]:
            return 0.0, 1e-6

    period, rate = 0.01, 2.0 * math.pi * 4.0
    walk = walked(
        engine,
        Disturbances(motor_bandwidth=4.0, control_period=period),
        steps=1,
        ground=mjbiped.Terrain.incline(2.0),
        controller=Constant(),
        sample_period=0.005,
    )
    begun = period * np.arange(30)
    expected = 1.0 - np.exp(-rate * begun) * (1.0 - math.exp(-rate * period)) / (rate * period)
    # samples in the middle of ticks; the numbers are the same but for rounding
    np.testing.assert_allclose(walk.samples["torque"][1:61:2, 1] * 1e6, expected, rtol=1e-9)


@pytest.mark.slow
@pytest.mark.parametrize("period", [1e-3, 4e-3, 8e-3])
def test_engines_agree_about_a_sampled_controller(period: float) -> None:
    """On level ground; c_mt of the default settings agrees to 0.03 % without sampling (docs/physics.md)."""
    costs = [
        walked(engine, Disturbances(control_period=period), steps=15, ground=mjbiped.Terrain.level()).cost_of_transport
        for engine in ENGINES
    ]
    assert math.isclose(*costs, rel_tol=1e-3)


def test_engines_agree_about_the_cost_of_noise() -> None:
    """Work is counted with the torques that were held; means of those at both ends of a step lose a third of it."""
    given = Disturbances(angle_noise=0.01, rate_noise=0.02, seed=1)
    costs = [walked(engine, given, steps=10, ground=mjbiped.Terrain.level()).cost_of_transport for engine in ENGINES]
    free = walked("hybrid", None, steps=10, ground=mjbiped.Terrain.level()).cost_of_transport
    assert min(costs) > 1.5 * free
    assert math.isclose(*costs, rel_tol=5e-3)


def test_the_hybrid_engine_converges_to_a_controller_that_never_pauses() -> None:
    """A torque that is held is late by half a period: the error is of first order in it."""
    plain = walked("hybrid", None)
    errors = [
        abs(walked("hybrid", Disturbances(control_period=period)).end[0] - plain.end[0])
        for period in (4e-3, 2e-3, 1e-3)
    ]
    assert errors[0] < 2e-3
    assert 1.5 < errors[0] / errors[1] < 2.7
    assert 1.5 < errors[1] / errors[2] < 2.7


@pytest.mark.parametrize("engine", ENGINES)
def test_a_record_repeats_its_walk(engine: str, tmp_path: Any) -> None:
    first = walked(engine, NOISY, steps=3)
    first.save(tmp_path / "walk.npz")
    before = Walk.load(tmp_path / "walk.npz")
    again = walked(engine, Disturbances.from_dict(before.settings["disturbances"]), steps=3)
    assert again == before


@pytest.mark.parametrize("engine", ENGINES)
def test_a_torque_that_is_no_number_is_its_controllers(engine: str) -> None:
    class Lost(Controller):
        def torque(self, memory: Memory, t: float, q: Sequence[float], dq: Sequence[float]) -> Sequence[float]:
            return 0.0, math.nan if t > 0.1 else 0.0

    walk = walked(engine, Disturbances(torque_limit=5.0), controller=Lost(), ground=mjbiped.Terrain.incline(2.0))
    assert walk.outcome == "diverged"
    assert "Lost.torque gives nan for the hip torque at t = 0.1" in "".join(walk.warnings)


@pytest.mark.parametrize("engine", ENGINES)
def test_an_exception_in_a_controller_is_told_as_ever(engine: str) -> None:
    class Broken(Controller):
        def torque(self, memory: Memory, t: float, q: Sequence[float], dq: Sequence[float]) -> Sequence[float]:
            if t > 0.1:
                raise ValueError("no more")
            return 0.0, 0.0

    with pytest.raises(mjbiped.WalkStopped, match=r"Broken failed at 0\.\d* s, after 0 steps: ValueError: no more"):
        walked(engine, Disturbances(delay=0.002), controller=Broken(), ground=mjbiped.Terrain.incline(2.0))


@pytest.mark.slow
def test_short_control_periods_are_no_sign_of_torques_that_switch() -> None:
    """The hybrid engine ends walks that need 100 000 integration steps in a gait step; here ticks ask for more."""
    given = Disturbances(control_period=5e-6)
    walk = walked("hybrid", given, steps=1, sample_period=None, ground=mjbiped.Terrain.level())
    assert walk.outcome == "finished"
    assert walk.end[0] / 5e-6 > 1.4e5
    free = walked("hybrid", None, steps=1, ground=mjbiped.Terrain.level())
    assert math.isclose(walk.end[0], free.end[0], rel_tol=1e-6)
