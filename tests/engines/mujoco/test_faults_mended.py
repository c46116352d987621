"""Faults of feet and states that the MuJoCo engine once had; each walk here was wrong before."""

import math

import numpy as np
import pytest

import mjbiped
from controllers import BoundedAnkleController, SupervisedController
from mjbiped.engines.mujoco.observation import INTRUSION_WORDS, SQUEEZED, SQUEEZING_WORDS

SOLE = (0.12, 0.12)
FLAT = mjbiped.Compass(sole=SOLE)
LEVEL = mjbiped.Terrain.level()


def supervised(robot: mjbiped.Compass) -> SupervisedController:
    return SupervisedController(robot, mjbiped.find_reference(FLAT, clearance=0.077, retraction=False))


def stepped_up(place: float, rise: float, steps: int = 2, **feet: str) -> mjbiped.Walk:
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


@pytest.mark.slow
def test_over_that_riser_it_walks_as_the_hybrid_engine_does() -> None:
    """The third foothold is the one beside the riser."""
    ground = mjbiped.Terrain.from_segments([(1.298, 0.0, 0.0), (8.0, 0.0, 0.008)])
    robots = {"mujoco": mjbiped.FootedCompass(sole=SOLE), "hybrid": FLAT}
    walks = {name: mjbiped.walk(supervised(each), ground, engine=name, steps=7) for name, each in robots.items()}
    assert {walk.outcome for walk in walks.values()} == {"finished"}
    np.testing.assert_allclose(walks["mujoco"].touchdowns["x"], walks["hybrid"].touchdowns["x"], atol=1e-3)
    assert walks["mujoco"].touchdowns["contact_force"].max() < SQUEEZED * FLAT.weight


def test_a_box_with_an_edge_beside_its_ankle_stands() -> None:
    """It bears the robot on 3 mm ahead of the ankle; it never became the stance foot, and slipped."""
    walk = stepped_up(0.3935, 0.01, underside="box")
    assert walk.outcome != "slipped"
    assert walk.steps >= 1
    assert walk.touchdowns["support_ahead"][0] < 0.005


def test_a_level_walk_has_no_ground_inside_its_feet() -> None:
    robot = mjbiped.FootedCompass(sole=SOLE)
    walk = mjbiped.walk(supervised(robot), LEVEL, engine="mujoco", steps=2)
    assert not walk.touchdowns["intrusion"].any()
    assert walk.settings["warnings"] == {}


def test_states_of_a_controller_have_no_bias() -> None:
    """They are integrated by the mean of both ticks' rates; by the earlier one alone 0.0248 degrees, and 0.04 mm."""
    law = BoundedAnkleController(FLAT, mjbiped.find_reference(FLAT, clearance=0.077, retraction=False))
    walks = {name: mjbiped.walk(law, LEVEL, engine=name, steps=4) for name in ("mujoco", "hybrid")}
    assert np.abs(walks["mujoco"].samples["slope_estimate"]).max() < math.radians(0.002)
    np.testing.assert_allclose(walks["mujoco"].touchdowns["x"], walks["hybrid"].touchdowns["x"], rtol=0, atol=2e-5)
