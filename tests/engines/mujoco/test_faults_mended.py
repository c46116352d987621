"""Faults of feet and states that the MuJoCo engine once had; each walk here was wrong before."""

import math
import threading
from typing import Any

import mujoco
import numpy as np
import pytest
from simulations import put, started, state_of

import mjbiped
from controllers import AdaptiveController, BoundedAnkleController, PassiveController, SupervisedController
from mjbiped.engines.mujoco.observation import INTRUSION_WORDS, SQUEEZING_WORDS

SOLE = (0.12, 0.12)
FLAT = mjbiped.Compass(sole=SOLE)
LEVEL = mjbiped.Terrain.level()
PLAIN: dict[str, Any] = {"lands": False, "timestep": 1e-4}
both = pytest.mark.parametrize("compile", [pytest.param(True, marks=pytest.mark.compiled), False])


def supervised(robot: mjbiped.Compass) -> SupervisedController:
    return SupervisedController(robot, mjbiped.find_reference(FLAT, clearance=0.077, retraction=False))


def stepped_up(place: float, rise: float, steps: int = 2, **feet: Any) -> mjbiped.Walk:
    """A walk from level ground over a step up, whose first foothold is at 0.393 m."""
    robot, ground = mjbiped.FootedCompass(sole=SOLE, **feet), mjbiped.Terrain.from_segments
    law = supervised(robot)
    return mjbiped.walk(law, ground([(place, 0.0, 0.0), (8.0, 0.0, rise)]), engine="mujoco", steps=steps)


def test_a_pad_that_comes_down_along_a_riser_is_not_gripped() -> None:
    """The toe slides down the face and stands before it; it was held by 1000 weights until the robot fell."""
    walk = stepped_up(0.512, 0.008)
    assert (walk.outcome, walk.steps) == ("finished", 2)
    assert walk.touchdowns["contact_force"].max() < 2.0 * walk.robot.weight
    assert walk.touchdowns["x"][0] + SOLE[1] == pytest.approx(0.512, abs=1e-4)
    assert SQUEEZING_WORDS not in walk.settings["warnings"]
    assert walk.settings["warnings"][INTRUSION_WORDS] == 1  # the step's edge stands beside the toe
    assert walk.touchdowns["intrusion"][0] == pytest.approx(0.008, abs=2e-4)


def test_a_box_with_an_edge_beside_its_ankle_stands() -> None:
    """It bears the robot on 3 mm ahead of the ankle; it never became the stance foot, and slipped."""
    walk = stepped_up(0.3935, 0.01, underside="box")
    assert walk.outcome != "slipped"
    assert walk.steps >= 1
    assert walk.touchdowns["support_ahead"][0] < 0.005


@pytest.mark.parametrize("underside", ["pads", "box"])
@pytest.mark.parametrize("change", [-3.0, 3.0])
def test_a_foot_slaps_in_both_engines_on_ground_of_another_slope(change: float, underside: str) -> None:
    """Heel or toe comes down first; the hybrid engine's foot lay flat at once, and its rates were off by up to 3.3 %.

    0.5 % is the goal that was set; at the engine's usual 0.1 ms MuJoCo's rates before are 0.7 % from those at 20 us.
    """
    robot = mjbiped.FootedCompass(sole=SOLE, underside=underside)
    ground = mjbiped.Terrain.from_segments([(0.2, 0.0, 0.0), (8.0, change, 0.0)])
    engines = "hybrid", mjbiped.Mujoco(timestep=2e-5)
    here, there = (mjbiped.walk(supervised(robot), ground, engine=engine, steps=1) for engine in engines)
    for column in ("dq", "dq_before"):
        rates, expected = here.touchdowns[column], there.touchdowns[column]
        np.testing.assert_allclose(rates, expected, atol=0.005 * np.abs(expected).max())
    np.testing.assert_allclose(here.touchdowns["slap"], there.touchdowns["slap"], atol=3e-4)
    assert here.touchdowns["slap"][0] > 0.01


def test_states_of_a_controller_have_no_bias() -> None:
    """They are integrated by the mean of both ticks' rates; by the earlier one alone 0.0248 degrees, and 0.04 mm."""
    law = BoundedAnkleController(FLAT, mjbiped.find_reference(FLAT, clearance=0.077, retraction=False))
    walks = {name: mjbiped.walk(law, LEVEL, engine=name, steps=4) for name in ("mujoco", "hybrid")}
    assert np.abs(walks["mujoco"].samples["slope_estimate"]).max() < math.radians(0.002)
    np.testing.assert_allclose(walks["mujoco"].touchdowns["x"], walks["hybrid"].touchdowns["x"], rtol=0, atol=2e-5)


@both
def test_a_state_of_another_simulation_goes_on_within_a_block(compile: bool, controller: AdaptiveController) -> None:
    """Whose a state is was in it, as an address."""
    one, other = (started(controller, LEVEL, compile=compile, **PLAIN) for _ in range(2))
    with one.callbacks(), other.callbacks():
        mujoco.mj_step(one.model, one.data, nstep=200)
        put(other, state_of(one))
        for each in (one, other):
            mujoco.mj_step(each.model, each.data, nstep=100)
    assert other.data.qpos.tobytes() == one.data.qpos.tobytes()
    assert other.state.time == one.state.time == pytest.approx(0.0299)


@both
def test_what_no_state_holds_is_not_taken_from_another_one(compile: bool) -> None:
    """Accelerations are the solver's guess, and contacts are none: those of before stood there still, or zeros."""
    robot = mjbiped.KneedBiped()
    one, other = (
        started(PassiveController(), mjbiped.Terrain.incline(2.5), robot=robot, compile=compile, **PLAIN)
        for _ in range(2)
    )
    with one.callbacks(), other.callbacks():
        mujoco.mj_step(one.model, one.data, nstep=50)
        put(other, state_of(one))
        other.data.sensordata[:] = other.data.qacc[:] = 1.0
        for each in (one, other):
            mujoco.mj_step(each.model, each.data)
    assert other.state.qacc[:] == one.state.qacc[:]
    assert (one.state.force > 0.0, other.state.force) == (True, 0.0)


@pytest.mark.compiled
@pytest.mark.parametrize("theirs", [None, print])
def test_walks_in_python_and_in_machine_code_go_on_in_threads(theirs: Any, controller: AdaptiveController) -> None:
    """With somebody's callback, which stays, while models are built.

    Callbacks behind MuJoCo's bindings left walks without torques for steps, or ended the process.
    """
    makers = [True, True, False, True, False]
    ends: list[list[bytes]] = [[] for _ in makers]

    def walk(compile: bool, into: list[bytes]) -> None:
        for _ in range(6 if compile else 2):
            simulation = started(controller, LEVEL, compile=compile)
            for _ in range(10):
                simulation.advance(10)
            into.append(state_of(simulation))

    threads = [threading.Thread(target=walk, args=each) for each in zip(makers, ends, strict=True)]
    mujoco.set_mjcb_control(theirs)
    try:
        for thread in threads:
            thread.start()
        for thread in threads:
            thread.join()
        assert mujoco.get_mjcb_control() is theirs
    finally:
        mujoco.set_mjcb_control(None)
    assert len({end for each in ends for end in each}) == 1
