"""The tracking law on a sole with knees: its torques make its accelerations, and the sole bears them."""

from __future__ import annotations

import math
from typing import TypeAlias

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from law_rooms import room_at

import mjbiped
from controllers import BoundedAnkleController, BoundedKneedController, KneedController
from mjbiped.analysis.replay import replayed
from mjbiped.control.controller import Law
from mjbiped.control.registry import controller_class
from mjbiped.controllers.bounded.bounded_ankle import move
from mjbiped.controllers.bounded.identifier import MOMENTUM, SLOPE, moments_about_foot
from mjbiped.controllers.layout import BEHIND
from mjbiped.controllers.room import ANGLES, BENT, BENT_FREE, FORCE, LEAN, MOTION, NORMAL, TORQUE
from mjbiped.controllers.slope_estimator import stand_bent
from mjbiped.controllers.tracking import track
from mjbiped.errors import InputError
from mjbiped.gaits.optimised import OptimisedGait

ANGLE, RATE = st.floats(-0.5, 0.5), st.floats(-3.0, 3.0)
STATES = st.tuples(ANGLE, ANGLE, ANGLE, RATE, RATE, RATE)
SLOPES = st.floats(-0.3, 0.3)
SOLES = st.tuples(st.floats(0.02, 0.2), st.floats(0.02, 0.2))
BENDS = st.sampled_from([0.0, 0.2])

Case: TypeAlias = tuple[tuple[float, ...], float, tuple[float, float], float]


@pytest.fixture(scope="module")
def robot() -> mjbiped.KneedBiped:
    return mjbiped.KneedBiped(sole=(0.12, 0.12))


@pytest.fixture(scope="module")
def gait(robot: mjbiped.KneedBiped) -> OptimisedGait:
    return mjbiped.find_reference(robot, clearance=0.08)


@pytest.fixture(scope="module")
def law(robot: mjbiped.KneedBiped, gait: OptimisedGait) -> BoundedKneedController:
    return BoundedKneedController(robot, gait)


def standing(law: BoundedKneedController, bent: float) -> list[float]:
    """A memory with a stance leg bent by so much, rad."""
    memory = [0.0] * law.memory_size
    memory[BENT] = bent
    if bent:
        stand_bent(law.parameters, memory)
    return memory


@pytest.mark.slow
@given(case=st.tuples(STATES, SLOPES, SOLES, BENDS))
def test_its_torques_make_its_accelerations_on_the_sole(law: BoundedKneedController, case: Case) -> None:
    """By the robot's own equations of motion and ground force, which share the chain's only."""
    state, slope, sole, bent = case
    given, memory, t = list(law.parameters), standing(law, bent), 0.3 * law.gait.period
    given[BEHIND], given[BEHIND + 1] = sole
    angle, (q, dq) = (math.sin(slope), math.cos(slope)), (state[:ANGLES], state[ANGLES:])
    asked, room = room_at(q, dq), room_at(q, dq)
    track(given, memory, t, angle, asked)
    wanted = sum(asked[FORCE : FORCE + 3])
    move(given, memory, t, 1.0, angle, room)
    ankle, hip, knee = room[TORQUE : TORQUE + 3]
    motion = np.array(room[MOTION : MOTION + 3])
    robot = law.robot
    chains = robot.chains_on(bent)
    pull = robot.input_matrix @ [ankle, hip, knee] - chains[3].coriolis_matrix(np.array(q), np.array(dq)) @ dq
    pull -= chains[3].gravity_vector(np.array(q), slope)
    ddq = np.linalg.solve(chains[3].mass_matrix(np.array(q)), pull)
    scale = max(1.0, *np.abs(motion), *np.abs(asked[MOTION : MOTION + 3]))  # rounding, of numbers of this size
    np.testing.assert_allclose(ddq, motion, rtol=0, atol=1e-11 * scale)
    np.testing.assert_array_equal(motion[1:], asked[MOTION + 1 : MOTION + 3])  # the swing leg follows its reference
    forward, upward = robot.ground_force(q, dq, [ankle, hip, knee], slope, locked=False, stance_flexion=bent)
    normal = forward * math.sin(slope) + upward * math.cos(slope)
    force = max(1.0, abs(forward), abs(upward))
    assert room[NORMAL] == pytest.approx(normal, abs=1e-11 * force)
    if normal > 0.0:
        slack = 1e-11 * max(force, abs(wanted))
        assert -sole[1] * normal - slack <= ankle <= sole[0] * normal + slack
    assert ankle * wanted >= -1e-11 * force * abs(wanted)  # of one sign, but for rounding
    assert abs(ankle) <= abs(wanted) * (1.0 + 1e-12)


@given(state=STATES, slope=SLOPES, bent=BENDS)
def test_the_momentum_changes_as_predicted(
    law: BoundedKneedController, state: tuple[float, ...], slope: float, bent: float
) -> None:
    """The derivative of the momentum along the motion, by central differences of the fourth order; G' likewise."""
    given, memory = law.parameters, standing(law, bent)
    q, dq = np.array(state[:ANGLES]), np.array(state[ANGLES:])
    room = room_at(q, dq)
    track(given, memory, 0.3 * law.gait.period, (math.sin(slope), math.cos(slope)), room)
    ankle, ddq = sum(room[FORCE : FORCE + 3]), np.array(room[MOTION : MOTION + 3])
    _, gravity, by_slope, inertia = moments_about_foot(given, memory, math.sin(slope), math.cos(slope), room)

    def momentum(t: float) -> float:
        there = room_at(q + dq * t + 0.5 * ddq * t * t, dq + ddq * t)
        return moments_about_foot(given, memory, 0.0, 1.0, there)[0]

    def moment(angle: float) -> float:
        return moments_about_foot(given, memory, math.sin(angle), math.cos(angle), room)[1]

    h = 1e-4
    scale = max(1.0, *np.abs(ddq))  # rounding, 1e-16 of some 100 kg m²/s over 1e-4 s, and h⁴ of its derivatives
    change = (8.0 * (momentum(h) - momentum(-h)) - (momentum(2 * h) - momentum(-2 * h))) / (12.0 * h)
    assert ankle + gravity == pytest.approx(change, abs=1e-8 * scale)
    turned = (8.0 * (moment(slope + h) - moment(slope - h)) - (moment(slope + 2 * h) - moment(slope - 2 * h))) / 12e-4
    assert by_slope == pytest.approx(turned, abs=1e-8)
    assert inertia == pytest.approx(np.sum(law.robot.chains_on(bent)[3].mass_matrix(q)), rel=1e-14)


STAIRS = mjbiped.Terrain.from_segments([(1.3, 0.0, 0.0), *[(1.8, 0.0, 0.03)] * 4])


@pytest.mark.slow
@pytest.mark.parametrize("engine", ["hybrid", "mujoco"])
def test_it_climbs_stairs_on_which_the_paper_s_law_falls(
    law: BoundedKneedController, gait: OptimisedGait, engine: str
) -> None:
    walk, clipped = (
        mjbiped.walk(each, STAIRS, engine=engine, steps=16) for each in (law, KneedController(law.robot, gait))
    )
    assert clipped.outcome in ("fell", "slipped")
    assert walk.verdict == "finished"
    if engine == "hybrid":  # the law leans on its share of the sole
        assert walk.summary()["share_of_time_at_sole_bound"] == 0.0
        # a rad of error of the slope's estimate changes the normal force by some ten times itself
        error = 10.0 * 0.12 * np.abs(walk.samples["slope_estimate"]).max()
        assert walk.touchdowns["pressure_behind"].max() == pytest.approx(0.95 * 0.12, abs=error)
        assert error < 1e-3


@pytest.mark.slow
@pytest.mark.parametrize("engine", ["hybrid", "mujoco"])
def test_a_wrong_start_is_found_out_within_three_steps(law: BoundedKneedController, engine: str) -> None:
    wrong = BoundedKneedController(law.robot, law.gait, initial_slope_estimate=math.radians(2.0), estimate_update=False)
    walk = mjbiped.walk(wrong, mjbiped.Terrain.level(), engine=engine, steps=5)
    assert walk.outcome == "finished"
    left = np.abs(walk.samples["slope_estimate"])
    assert left[0] == pytest.approx(math.radians(2.0))
    late = walk.samples["time"] > walk.touchdowns["time"][2]
    # 6 rad/s overdamped: some -2.4/s leaves less than 1 % of 2° after 2.4 s; MuJoCo's impacts add 1e-4 rad
    assert left[late].max() < 0.01 * math.radians(2.0) + 3e-4


@pytest.mark.slow
def test_the_prediction_begins_with_the_momentum_of_each_step(law: BoundedKneedController) -> None:
    walk = mjbiped.walk(law, STAIRS, engine="hybrid", steps=8)
    for k, (_, memory) in enumerate(replayed(walk, law)):
        if k == 0:
            continue
        q, dq = walk.touchdowns["q"][k - 1], walk.touchdowns["dq"][k - 1]
        chains = law.robot.chains_on(memory[BENT])
        assert memory[MOMENTUM] == pytest.approx(np.sum(chains[3].mass_matrix(q) @ dq), rel=1e-12)
        assert abs(memory[SLOPE]) < 1e-2


@pytest.mark.slow
@pytest.mark.parametrize(("engine", "tolerance"), [("hybrid", 1e-6), ("mujoco", 0.0)])
def test_compiled_and_in_python_it_walks_the_same(law: BoundedKneedController, engine: str, tolerance: float) -> None:
    """Bitwise in MuJoCo; the hybrid engine itself rounds otherwise in Python, and chooses its steps by that."""

    class InPython(BoundedKneedController):
        def law(self) -> Law:
            return None  # type: ignore[return-value]  # as a controller in plain Python does

    ground = mjbiped.Terrain.from_segments([(0.5 * law.gait.step_length, 0.0, 0.0), (50.0, 0.0, 0.02)])
    walks = [mjbiped.walk(each, ground, engine=engine, steps=2) for each in (law, InPython(law.robot, law.gait))]
    np.testing.assert_allclose(walks[0].samples["q"], walks[1].samples["q"], rtol=0, atol=tolerance)


def test_a_compass_is_refused(gait: OptimisedGait) -> None:
    with pytest.raises(InputError, match=r"BoundedKneedController needs a mjbiped.KneedBiped"):
        BoundedKneedController(mjbiped.Compass(), gait)  # type: ignore[arg-type]


def test_a_bent_leg_changes_what_the_law_takes_the_robot_for(law: BoundedKneedController) -> None:
    memory = standing(law, 0.3)
    chains = law.robot.chains_on(0.3)
    found = np.array(memory[BENT_FREE : BENT_FREE + 16])
    np.testing.assert_allclose(found[:9], chains[3].weights.ravel(), rtol=1e-14)
    np.testing.assert_allclose(found[9:12], chains[3].moments, rtol=1e-14)
    np.testing.assert_allclose(found[13:], chains[3].reach, rtol=1e-14)
    assert found[12] == pytest.approx(float(chains[3].across[0]), rel=1e-14)
    assert memory[LEAN] > 0.0


def test_by_name_it_is_the_bounded_ankle_with_knees(robot: mjbiped.KneedBiped) -> None:
    assert controller_class("bounded-ankle", robot) is BoundedKneedController
    assert controller_class("bounded-ankle", mjbiped.Compass()) is BoundedAnkleController
