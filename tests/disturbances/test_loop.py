"""A disturbed control loop of robots with straight legs in both engines, and mostly in the hybrid one with knees."""

import math
from collections.abc import Sequence
from dataclasses import dataclass
from functools import cache
from typing import Any, ClassVar

import numpy as np
import pytest
from simulations import Torques

import mjbiped
from controllers import AdaptiveController, Controller, KneedController
from mjbiped import Disturbances, KneedBiped, Terrain, Walk
from mjbiped.control.controller import Memory

ENGINES = ("mujoco", "hybrid")
ROBOT = KneedBiped()
GROUND = Terrain.slopes(change_deg=-0.5)
SENSORS: Any = {"angle_noise": 0.002, "rate_noise": 0.02, "angle_bias": 0.003, "rate_bias": -0.01, "seed": 5}
NOISY = Disturbances(**SENSORS, angle_resolution=0.001, delay=0.004, torque_limit=20.0, motor_bandwidth=30.0)
SLOW: Any = {"motor_bandwidth": 50.0}
each_engine = pytest.mark.parametrize("engine", ENGINES)
CASES = [("mujoco", False), ("hybrid", False), ("hybrid", True)]
each_case = pytest.mark.parametrize(("engine", "knees"), CASES)


@cache
def adaptive(knees: bool = False) -> Any:
    if knees:
        return KneedController(ROBOT, mjbiped.find_kneed_gait(ROBOT, math.radians(2.5)))
    robot = mjbiped.Compass()
    return AdaptiveController(robot, mjbiped.find_passive_gait(robot, math.radians(2.0)))


def walked(engine: Any, disturbances: Disturbances | None, knees: bool = False, **given: Any) -> Walk:
    law, ground = given.pop("controller", adaptive(knees)), given.pop("ground", GROUND)
    return mjbiped.walk(law, ground, engine=engine, disturbances=disturbances, **{"steps": 4, **given})


@dataclass(frozen=True)
class Clock(Controller):
    """Torques that tell when they were asked for, or what was read: 1e-7 of the robot's, which it does not feel."""

    reading: bool = False

    def torque(self, memory: Memory, t: float, q: Sequence[float], dq: Sequence[float]) -> Sequence[float]:
        if self.reading:
            return tuple(1e-7 * np.diff(q, prepend=0.0))
        return 0.0, *(1e-7 * (joint + t) for joint in range(1, len(q)))


@dataclass(frozen=True)
class KneedClock(Clock):
    joints: ClassVar[tuple[str, ...]] = KneedBiped.joints
    robot = ROBOT


def clocked(engine: str, knees: bool, reading: bool = False, steps: int = 1, **given: Any) -> Walk:
    """A passive walk with ticks of 5 ms, and samples in each fifth of a tick."""
    controller = (KneedClock if knees else Clock)(reading)
    start = {"initial": adaptive(True).gait.start.tolist()} if knees else {}
    disturbances = Disturbances(**{"control_period": 0.005, **given})
    ground = Terrain.incline(2.5 if knees else 2.0)
    return walked(engine, disturbances, controller=controller, ground=ground, steps=steps, sample_period=0.001, **start)


@each_case
def test_a_record_repeats_its_walk_bit_by_bit_also_in_threads(engine: str, knees: bool, tmp_path: Any) -> None:
    first = walked(engine, NOISY, knees, steps=2)
    first.save(tmp_path / "walk.npz")
    again = Disturbances.from_dict(Walk.load(tmp_path / "walk.npz").settings["disturbances"])
    each = [again, Disturbances(**{**NOISY.to_dict(), "seed": 6})]
    together = mjbiped.walk_many(adaptive(knees), GROUND, engine=engine, steps=2, disturbances=each, workers=2)
    assert together[0] == first
    assert together[0] != together[1]


@each_case
def test_each_motor_has_its_own_limit(engine: str, knees: bool) -> None:
    """The limits stand in the order of the joints, and a record keeps them; each of these binds."""
    free = walked(engine, Disturbances(control_period=1e-3), knees, steps=3)
    limits = tuple((0.5 * free.peak_torque).tolist())
    bound = walked(engine, Disturbances(torque_limit=limits), knees, steps=3)
    slow = walked(engine, Disturbances(torque_limit=limits, **SLOW), knees, steps=3)
    assert bound.peak_torque.tolist() == list(limits)
    assert (slow.peak_torque <= limits).all()
    assert (np.abs(slow.samples["torque"]) <= limits).all()
    assert bound.settings["disturbances"] == {"torque_limit": list(limits)}
    assert Disturbances.from_dict(bound.settings["disturbances"]).torque_limit == limits


@each_case
@pytest.mark.parametrize("ticks", [1, 20])
def test_a_delay_shifts_torques_by_whole_ticks(engine: str, knees: bool, ticks: int) -> None:
    prompt = clocked(engine, knees).samples["torque"][:-6, 1:]
    late = clocked(engine, knees, delay=ticks * 0.005).samples["torque"][: len(prompt), 1:]
    shift = 5 * ticks
    # the samples' times are the ticks' to rounding, so that one of them falls on either side: compared are the others
    inner = np.arange(len(prompt)) % 5 != 0
    inner[:shift] = False
    # the torques differ by rounding of the times alone
    np.testing.assert_allclose(late[inner], prompt[np.flatnonzero(inner) - shift], rtol=1e-9)
    assert not late[: shift - 1].any()


@pytest.mark.parametrize(("engine", "knees"), [*CASES, ("mujoco", True)])
def test_what_waits_goes_to_the_motor_that_it_was_meant_for(engine: str, knees: bool) -> None:
    """The hip's torque acts after the touchdown with the other sign; the knee that it was for is locked by then."""
    walk = clocked(engine, knees, steps=2, delay=0.1)
    touched, time, torque = walk.touchdowns["time"][0], walk.samples["time"], walk.samples["torque"]
    before, after = (time > touched - 0.08) & (time < touched), (time > touched + 0.006) & (time < touched + 0.09)
    later = time > touched + 0.106
    later[-1] = False  # the last sample is after another touchdown
    for rows, sign, knee in ((before, 1.0, True), (after, -1.0, False), (later, 1.0, True)):
        assert (sign * torque[rows, 1] > 0.9e-7).all()
        if knees:  # MuJoCo's record has no torque of a locked knee
            acts = (walk.samples["locked"][rows] == 0) | (engine == "hybrid")
            assert ((torque[rows, 2] > 1.9e-7) == (acts & knee)).all()
    assert not knees or (torque[after, 2] == 0.0).all()


@each_case
def test_noise_and_bias_of_each_joint_are_as_large_as_they_say(engine: str, knees: bool) -> None:
    """Of some 120 ticks in each of two steps: five deviations of mean and of deviation are allowed."""
    noise, bias = 0.01, 0.005
    walk, true = (
        clocked(engine, knees, reading=True, steps=2, **given)
        for given in ({"angle_noise": noise, "angle_bias": bias, "seed": 1}, {})
    )
    time, touched = true.samples["time"], true.touchdowns["time"][0]
    for begin, end, hip in ((0.0, touched, 1.0), (touched, time[-1], -1.0)):  # an encoder's sign is that of the legs
        rows = np.flatnonzero((time > begin + 0.01) & (time < end - 0.01) & (np.round(1e3 * time) % 5 == 2))
        error = 1e7 * (walk.samples["torque"] - true.samples["torque"])[rows]  # one sample in each tick
        count, joints = len(error), [1.0, hip, 1.0][: error.shape[1]]
        assert (np.abs(error.mean(axis=0) - np.multiply(bias, joints)) < 5.0 * noise / math.sqrt(count)).all()
        assert (np.abs(error.std(axis=0) / noise - 1.0) < 5.0 / math.sqrt(2.0 * count)).all()
        # joints have nothing to do with one another: five deviations of a correlation
        assert np.abs(np.corrcoef(error.T)[np.triu_indices(len(error.T), 1)]).max() < 5.0 / math.sqrt(count)


@each_engine
def test_encoders_are_off_by_half_a_step_at_most(engine: str) -> None:
    step = 0.02
    read = clocked(engine, False, reading=True, angle_resolution=step).samples
    joints, shown = np.diff(read["q"], axis=1, prepend=0.0), read["torque"] * 1e7
    # a reading is a whole number of steps, of an angle up to one tick ago: 5 ms at 3 rad/s
    np.testing.assert_allclose(shown / step, np.round(shown / step), atol=1e-9)
    assert np.abs(shown - joints)[2:-2].max() <= 0.5 * step + 0.005 * 3.0
    at_ticks = np.abs(read["time"] / 0.005 - np.round(read["time"] / 0.005)) < 1e-6
    if engine == "mujoco":  # samples on a tick are taken after it
        assert np.abs(shown - joints)[at_ticks][:-2].max() <= 0.5 * step + 1e-9


@each_engine
def test_a_motor_of_first_order_answers_as_one(engine: str) -> None:
    """A constant demand: 1 - exp(-2 pi f t), in the mean over each tick of 10 ms."""
    period, rate = 0.01, 2.0 * math.pi * 4.0
    law, ground = Torques(lambda *_: (0.0, 1e-6)), Terrain.incline(2.0)
    given: Any = {"steps": 1, "ground": ground, "controller": law, "sample_period": 0.005}
    walk = walked(engine, Disturbances(motor_bandwidth=4.0, control_period=period), **given)
    expected = 1.0 - np.exp(-rate * period * np.arange(30)) * (1.0 - math.exp(-rate * period)) / (rate * period)
    # samples in the middle of ticks; the numbers are the same but for rounding
    np.testing.assert_allclose(walk.samples["torque"][1:61:2, 1] * 1e6, expected, rtol=1e-9)


@pytest.mark.parametrize("knees", [False, pytest.param(True, marks=pytest.mark.slow)])
def test_walks_converge_to_a_controller_that_never_pauses(knees: bool) -> None:
    """A torque that is held is late by half a period: the error is of first order in it."""
    walks = [
        walked("hybrid", each, knees, steps=3 if knees else 6)
        for each in (None, *(Disturbances(control_period=period) for period in (4e-3, 2e-3, 1e-3)))
    ]
    errors = np.abs([walk.end[0] - walks[0].end[0] for walk in walks[1:]])
    assert errors[0] < 4e-3
    assert ((errors[:-1] / errors[1:] > 1.5) & (errors[:-1] / errors[1:] < 2.7)).all()


@each_engine
def test_a_torque_that_is_no_number_and_an_exception_are_the_controllers(engine: str) -> None:
    lost = Torques(lambda t, *_: (0.0, math.nan if t > 0.1 else 0.0))
    broken = Torques(lambda t, *_: (0.0, 1.0 / (t <= 0.1) - 1.0))
    walk = walked(engine, Disturbances(torque_limit=5.0), controller=lost, ground=Terrain.incline(2.0))
    assert walk.outcome == "diverged"
    assert "Torques.torque gives nan for the hip torque at t = 0.1" in "".join(walk.warnings)
    with pytest.raises(mjbiped.WalkStopped, match=r"Torques failed at 0\.\d* s, after 0 steps: ZeroDivisionError"):
        walked(engine, Disturbances(delay=0.002), controller=broken, ground=Terrain.incline(2.0))


@pytest.mark.slow
def test_short_control_periods_are_no_sign_of_torques_that_switch() -> None:
    """The hybrid engine ends walks that need 100 000 integration steps in a gait step; here ticks ask for more."""
    given: Any = {"steps": 1, "sample_period": None, "ground": Terrain.level()}
    walk, free = (walked("hybrid", each, **given) for each in (Disturbances(control_period=5e-6), None))
    assert walk.outcome == "finished"
    assert walk.end[0] / 5e-6 > 1.4e5
    assert math.isclose(walk.end[0], free.end[0], rel_tol=1e-6)
