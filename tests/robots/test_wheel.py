"""The rimless wheel in both engines, against the closed form of its rolling."""

import math
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import ClassVar

import numpy as np
import pytest
from click.testing import CliRunner
from numpy.typing import NDArray
from scipy.integrate import solve_ivp
from simulations import Plain

import mjbiped
from mjbiped.cli.main import main
from mjbiped.control.controller import Controller, Memory
from mjbiped.control.registry import make_controller
from mjbiped.errors import GaitError, InputError
from mjbiped.gaits.passive import find_rolling
from mjbiped.limit_cycles.basin import basin_of_attraction
from mjbiped.plotting.walk import plot_walk
from mjbiped.records import measures
from mjbiped.robots.kinds import robot_from, robot_named

SLOPE = math.radians(5)
GROUND = mjbiped.Terrain.incline(5)
HUB = mjbiped.RimlessWheel()
HEAVY = mjbiped.RimlessWheel(mass=3.0, inertia=0.7, length=0.8, gravity=3.7)
ODD = mjbiped.RimlessWheel(mass=3.0, inertia=0.7, length=0.8, spokes=11, gravity=3.7)
WHEELS = (HUB, HEAVY, ODD)
# each number of spokes compiles engines of its own, for half a minute
WALKED = (HUB, HEAVY, pytest.param(ODD, marks=pytest.mark.slow))
STEPS = ODD.spokes + 1  # more than a turn


@dataclass(frozen=True)
class Brake(Controller):
    """A motor that brakes the stance spoke."""

    joints: ClassVar[tuple[str, ...]] = ("ankle",)

    def torque(self, memory: Memory, t: float, q: Sequence[float], dq: Sequence[float]) -> tuple[float]:
        return (-0.5 * dq[0],)

    def on_touchdown(self, memory: Memory, before: Sequence[float], q: Sequence[float], dq: Sequence[float]) -> None:
        """Nothing is remembered."""


def roll(robot: mjbiped.RimlessWheel, engine: str, rate: float, steps: int = STEPS) -> mjbiped.Walk:
    start = (-math.pi / robot.spokes, rate)
    return mjbiped.walk(Plain(), GROUND, robot=robot, engine=engine, initial=start, steps=steps)


def rates(robot: mjbiped.RimlessWheel, rate: float, steps: int) -> list[float]:
    """Rates just after the impacts, by energy and angular momentum."""
    hub, half = robot.mass * robot.length**2, math.pi / robot.spokes
    inertia, found = hub + robot.inertia, []
    for _ in range(steps):
        fall = 4 * robot.mass * robot.gravity * robot.length * math.sin(half) * math.sin(SLOPE)
        rate = (hub * math.cos(2 * half) + robot.inertia) / inertia * math.sqrt(rate**2 + fall / inertia)
        found.append(rate)
    return found


def test_the_steady_rate_is_the_textbooks() -> None:
    """Without inertia: cot 2a sqrt(4 (g/l) sin a sin slope)."""
    half = math.pi / 8
    told = math.sqrt(4 * 9.81 * math.sin(half) * math.sin(SLOPE)) / math.tan(2 * half)
    assert HUB.rolling_rate(SLOPE) == pytest.approx(told, rel=1e-14)
    for robot in WHEELS:
        steady = robot.rolling_rate(SLOPE)
        assert rates(robot, steady, 1) == pytest.approx([steady], rel=1e-14)


@pytest.mark.slow
@pytest.mark.parametrize("robot", WALKED)
def test_rates_after_impacts_are_the_closed_forms(robot: mjbiped.RimlessWheel) -> None:
    """From the fixed point and from others; in MuJoCo within the error of its contact steps, 1e-4 measured."""
    steady = robot.rolling_rate(SLOPE)
    for rate in (steady, 1.4 * steady):
        for engine, error in (("hybrid", 1e-11), ("mujoco", 4e-4)):
            walk = roll(robot, engine, rate)
            assert (walk.outcome, walk.steps) == ("finished", STEPS)
            assert walk.touchdowns["dq"][:, 0] == pytest.approx(rates(robot, rate, STEPS), rel=error)


@pytest.mark.parametrize(("slope_deg", "verdict"), [(10.0, "finished"), (20.0, "finished, contact violated")])
def test_engines_agree_where_the_ground_can_hold_the_foot(slope_deg: float, verdict: str) -> None:
    """Elsewhere MuJoCo's foot slides or hops, and the energies differ by 16 %: the records of both engines say so."""
    robot = mjbiped.RimlessWheel(mass=20.6, inertia=1.42, length=0.355, gravity=2.74)
    start, ground = (-math.pi / 8, robot.rolling_rate(math.radians(slope_deg))), mjbiped.Terrain.incline(slope_deg)
    exact, stepped = (
        mjbiped.walk(Plain(), ground, robot=robot, engine=engine, initial=start, steps=6)
        for engine in ("hybrid", "mujoco")
    )
    assert exact.verdict == stepped.verdict == verdict
    agree = verdict == "finished"
    assert agree == (not stepped.settings["warnings"])
    energies = (stepped.touchdowns["dq"] / exact.touchdowns["dq"]) ** 2
    assert agree == (np.abs(energies - 1.0).max() < 4e-4)  # measured 1.6e-4


@pytest.mark.slow
@pytest.mark.parametrize(("longer", "heavier", "stronger"), [(0.25, 0.5, 1.0), (2.0, 7.0, 0.5)])
def test_a_wheel_in_other_units_rolls_alike_in_mujoco(longer: float, heavier: float, stronger: float) -> None:
    slower = math.sqrt(longer / stronger)
    other = mjbiped.RimlessWheel(
        mass=3.0 * heavier, inertia=0.7 * heavier * longer**2, length=0.8 * longer, gravity=3.7 * stronger
    )
    rolled = []
    for robot, time in ((HEAVY, 1.0), (other, slower)):
        engine = mjbiped.Mujoco(timestep=1e-3 * time, contact_timestep=1e-5 * time)
        start = (-math.pi / 8, 1.3 * robot.rolling_rate(SLOPE))
        walk = mjbiped.walk(Plain(), GROUND, robot=robot, engine=engine, initial=start, steps=4)
        rolled.append((walk.touchdowns["dq"] * time, walk.touchdowns["time"] / time))
    assert rolled[1][0] == pytest.approx(rolled[0][0], rel=3e-4)  # measured 1.2e-4: stiffness and depths have units
    assert rolled[1][1] == pytest.approx(rolled[0][1], abs=5e-4)


@pytest.mark.slow
@pytest.mark.parametrize("robot", WALKED[1:])
@pytest.mark.parametrize("engine", ["hybrid", "mujoco"])
def test_the_record_tells_of_spokes(robot: mjbiped.RimlessWheel, engine: str, tmp_path: Path) -> None:
    walk = roll(robot, engine, robot.rolling_rate(SLOPE))
    touchdowns, half, exact = walk.touchdowns, math.pi / robot.spokes, {"hybrid": 1e-12, "mujoco": 1e-4}[engine]
    assert touchdowns["stance"].tolist() == [k % robot.spokes for k in range(1, STEPS + 1)]
    assert touchdowns["q_before"] == pytest.approx(np.full((STEPS, 1), half), abs=exact)
    assert touchdowns["q"] == pytest.approx(np.full((STEPS, 1), -half), abs=exact)
    turned = touchdowns["qpos"][:, 2] - SLOPE
    assert turned == pytest.approx(half + 2 * half * np.arange(STEPS), abs=exact)  # it goes on beyond a whole turn
    feet = robot.limbs(touchdowns["qpos"])[np.arange(STEPS), touchdowns["stance"], -1]
    assert feet == pytest.approx(np.column_stack([touchdowns["x"], touchdowns["z"]]), abs=exact)
    assert walk.distance == pytest.approx(STEPS * 2 * 0.8 * math.sin(half) * math.cos(SLOPE), abs=exact)
    assert np.abs(measures.impact_errors(walk)).max() < 1e-3
    assert walk.cost_of_transport == 0.0
    assert touchdowns["normal_force"] == pytest.approx(np.full(STEPS, touchdowns["normal_force"][-1]), rel=0.02)
    walk.save(tmp_path / "wheel.npz")
    again = mjbiped.Walk.load(tmp_path / "wheel.npz")
    assert again == walk
    assert again.robot == robot
    plot_walk(again, tmp_path / "wheel.png")


@pytest.mark.slow
@pytest.mark.parametrize("engine", ["hybrid", "mujoco"])
def test_a_wheel_rolls_off_a_step_and_falls_back_from_a_hill(engine: str) -> None:
    robot, rate = HUB, HUB.rolling_rate(SLOPE)
    down = mjbiped.Terrain.from_segments([(1.0, 5.0, 0.0), (9.0, 5.0, -0.05)])
    walk = mjbiped.walk(Plain(), down, robot=robot, engine=engine, initial="gait", steps=8)
    assert walk.outcome == "finished"
    foot = math.asin(0.05 * math.cos(SLOPE) / (2 * math.sin(math.pi / 8)))  # one foot is lower than the other
    turned = np.sort(walk.touchdowns["q"][:, 0] + math.pi / 8)
    assert turned == pytest.approx([*[0.0] * 7, foot], abs=3e-5)
    assert walk.touchdowns["z"][-1] < -0.05
    hill = mjbiped.walk(
        Plain(), mjbiped.Terrain.incline(-5), robot=robot, engine=engine, initial=(-math.pi / 8, rate), steps=8
    )
    assert hill.outcome == "fell"


def test_the_equations_are_a_pendulums() -> None:
    q, dq, torque = 0.2, 1.3, 0.4
    robot = HEAVY
    inertia = 3.0 * 0.8**2 + 0.7
    ddq = np.linalg.solve(robot.mass_matrix([q]), robot.input_matrix @ [torque] - robot.gravity_vector([q], SLOPE))
    assert ddq == pytest.approx([(torque + 3.0 * 3.7 * 0.8 * math.sin(q + SLOPE)) / inertia], rel=1e-14)
    assert robot.energy([q], [dq], SLOPE) == pytest.approx(
        0.5 * inertia * dq**2 + 3.0 * 3.7 * 0.8 * math.cos(q + SLOPE), rel=1e-14
    )
    assert not robot.coriolis_matrix([q], [dq]).any()
    # the hub's acceleration, and gravity
    forward, upward = robot.ground_force([q], [dq], [torque], SLOPE)
    sine, cosine = math.sin(q + SLOPE), math.cos(q + SLOPE)
    assert forward == pytest.approx(3.0 * 0.8 * (cosine * ddq[0] - sine * dq**2), rel=1e-12)
    assert upward == pytest.approx(3.0 * (3.7 - 0.8 * (sine * ddq[0] + cosine * dq**2)), rel=1e-12)


def test_limbs_lead_to_the_next_foot() -> None:
    for stance in range(HEAVY.spokes):
        qpos = HEAVY.posture((0.3, 0.1), stance, [0.2])
        feet = HEAVY.limbs(qpos)[:, -1]
        assert feet[stance] == pytest.approx([0.3, 0.1], abs=1e-14)
        ahead = feet[(stance + 1) % HEAVY.spokes] - feet[stance]
        assert ahead == pytest.approx(HEAVY.swing_foot([0.2]), abs=1e-14)
        assert HEAVY.centre_of_mass(qpos) == pytest.approx(qpos[:2])


def test_steady_rolling_is_a_gait() -> None:
    """Its period is that of the pendulum between two impacts, its multiplier that of the rate."""
    gait = find_rolling(ODD, SLOPE)
    half, inertia, moment = math.pi / 11, 3.0 * 0.8**2 + 0.7, 3.0 * 3.7 * 0.8

    def fall(_: float, state: NDArray[np.float64]) -> list[float]:
        return [state[1], moment * math.sin(state[0] + SLOPE) / inertia]

    def lands(_: float, state: NDArray[np.float64]) -> float:
        return float(state[0]) - half

    lands.terminal = True  # type: ignore[attr-defined]
    step = solve_ivp(fall, (0.0, 5.0), gait.start, events=lands, rtol=1e-11, atol=1e-12)
    assert gait.period == pytest.approx(step.t[-1], rel=1e-9)
    near, far = (rates(ODD, gait.start[1] * (1 + change), 1)[0] for change in (-1e-6, 1e-6))
    assert gait.multipliers.real == pytest.approx([(far - near) / (2e-6 * gait.start[1])], rel=1e-8)
    assert gait.step_length == pytest.approx(2 * 0.8 * math.sin(half))
    assert gait.stable
    assert np.concatenate(gait.reference(gait.period)[:2]) == pytest.approx(gait.end, abs=1e-9)
    for slope in (0.0, -0.1, 0.01):
        with pytest.raises(GaitError, match="does not roll"):
            find_rolling(HUB, slope)


def test_what_a_wheel_is_told() -> None:
    assert robot_named("wheel", {"spokes": 9}) == mjbiped.RimlessWheel(spokes=9)
    assert robot_from(HEAVY.to_dict()) == HEAVY
    with pytest.raises(InputError, match="spokes = 4: must be a whole number from 5"):
        mjbiped.RimlessWheel(spokes=4)
    with pytest.raises(InputError, match="two finite numbers q1, dq1"):
        roll(HUB, "hybrid", math.nan)
    with pytest.raises(InputError, match="RimlessWheel has ankle: choose a controller for that robot: passive"):
        make_controller("adaptive", HUB, {})
    with pytest.raises(InputError, match="a RimlessWheel has no swing leg"):
        basin_of_attraction(HUB, SLOPE)


@pytest.mark.slow
@pytest.mark.parametrize("engine", ["hybrid", "mujoco"])
def test_a_motor_at_the_ankle_is_disturbed_as_others_are(engine: str) -> None:
    """Noise and a push change the rolling; a motor that brakes is no stronger than its limit."""
    disturbed = mjbiped.Disturbances(
        angle_noise=0.01, rate_noise=0.2, delay=0.01, motor_bandwidth=30.0, torque_limit=0.7, pushes=((1.0, 2.0),)
    )
    walk = mjbiped.walk(Brake(), GROUND, robot=HUB, engine=engine, initial="gait", steps=10, disturbances=disturbed)
    assert walk.outcome == "finished"
    assert 0.6 < walk.peak_torque[0] <= 0.7
    free = mjbiped.walk(Plain(), GROUND, robot=HUB, engine=engine, initial="gait", steps=10)
    assert free.touchdowns["time"][-1] + 0.1 < walk.touchdowns["time"][-1]


@pytest.mark.slow  # the map of another robot takes a minute to compile
def test_the_return_map_rolls_too() -> None:
    steady = HUB.rolling_rate(SLOPE)
    steps = mjbiped.ReturnMap(HUB, SLOPE).walk([-math.pi / 8, 1.1 * steady], 6)
    assert steps.states[:, 1] == pytest.approx(rates(HUB, 1.1 * steady, 6), rel=1e-7)


@pytest.mark.slow
def test_the_command_line_rolls_a_wheel_of_ones_own(tmp_path: Path) -> None:
    words = ["incline:slope_deg=5", "--robot", "wheel", "--controller", "passive", "--mass", "2"]
    result = CliRunner().invoke(main, ["walk", *words, "--steps", "3", "--out", str(tmp_path / "wheel.npz")])
    assert result.exit_code == 0, result.output
    assert mjbiped.Walk.load(tmp_path / "wheel.npz").robot == mjbiped.RimlessWheel(mass=2.0)
    result = CliRunner().invoke(
        main, ["gait", "--robot", "wheel", "--slope-deg", "5", "--plot", str(tmp_path / "g.png")]
    )
    assert result.exit_code == 0, result.output
    assert "modulus 0.5 " in result.output
