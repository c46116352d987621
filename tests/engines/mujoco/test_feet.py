"""What feet of MuJoCo feel; feet that are bodies: when they stand, how they are held, and faults that were mended."""

import math
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import mjbiped
from controllers import AdaptiveController, BoundedAnkleController, SupervisedController
from mjbiped.engines.mujoco import feet
from mjbiped.engines.mujoco.feet import felt
from mjbiped.engines.mujoco.observation import INTRUSION_WORDS, SQUEEZING_WORDS
from mjbiped.robots.footed import FootedCompass

GAIT = mjbiped.find_passive_gait(FootedCompass(), math.radians(2.0))


def test_a_foot_on_an_edge_tells_no_slope_unless_the_next_one_says_the_same() -> None:
    u: Any = SimpleNamespace(level=0.0, stood=0.0)
    for angle, level in ((0.05, 0.05), (0.2, 0.05), (0.05, 0.05), (0.2, 0.05), (0.21, 0.21), (0.2, 0.2), (0.1, 0.2)):
        feet.stand_flat(u, angle)
        assert (u.stood, u.level) == (angle, level)


def test_a_law_that_asks_for_more_than_the_sole_bears_tips_the_foot() -> None:
    """The paper's law knows no sole: on a short one it asks for more uphill, and rolls over the heel."""
    robot = FootedCompass(sole=(0.03, 0.03))
    walk = mjbiped.walk(AdaptiveController(robot, GAIT), mjbiped.Terrain.incline(-2.0), engine="mujoco", steps=3)
    assert walk.samples["ankle_asked"].tobytes() == walk.samples["torque"][:, 0].tobytes()
    assert np.abs(walk.samples["slope"] - math.radians(-2.0)).max() > 0.01


def test_a_box_across_an_edge_tells_how_far_the_ground_bears_it() -> None:
    """From the ankle to the edge, within contacts' softness: 0.1 mm; the walk's phase lets a foot land across it."""
    robot, edge = FootedCompass(underside="box"), 1.1
    ground = mjbiped.Terrain.from_segments([(edge, 0.0, 0.0), (5.0, 0.0, 0.01)])
    walk = mjbiped.walk(BoundedAnkleController(robot, GAIT), ground, engine="mujoco", steps=3)
    x, behind, ahead = (walk.touchdowns[name] for name in ("x", "support_behind", "support_ahead"))
    across = int(np.argmin(abs(x - edge - 0.05)))
    assert edge + 1e-3 < x[across] < edge + 0.11
    assert behind[across] == pytest.approx(x[across] - edge, abs=1e-4)
    np.testing.assert_allclose(ahead, 0.12, atol=1e-4)
    np.testing.assert_allclose(np.delete(behind, across), 0.12, atol=1e-4)


forces = st.tuples(st.floats(0.0, 300.0), st.floats(-200.0, 200.0))
tilts = st.one_of(st.floats(-0.7, 0.7), st.just(math.radians(91.0)))  # of the ground, and of faces
slots = st.lists(st.tuples(st.booleans(), tilts, forces, st.floats(-1e-3, 1e-3)), min_size=1, max_size=3)


@given(slots, st.integers(0, 3))
@settings(deadline=None, derandomize=True)
def test_forces_of_all_contacts_are_added_as_vectors(contacts: list[Any], before: int) -> None:
    """By slots as MuJoCo fills them: the force in the contact's frame, of which the lateral axis is the second.

    The third axis is the cross product of the normal and the lateral axis. A face presses; what else it feels is none
    of the ground's.
    """
    readings, total, depths, shear, found_face = [9.0] * before, np.zeros(3), [0.0], 0.0, False
    for found, tilt, (pressed, rubbed), distance in contacts:
        normal = np.array([math.sin(tilt), 0.0, -math.cos(tilt)])
        readings += [float(found), pressed, 17.0, rubbed, distance, 0.0, 0.0, 0.0, *normal]
        found_face |= found and tilt > 1.0
        if found and tilt < 1.0:
            total += pressed * normal + rubbed * np.cross(normal, [0.0, 1.0, 0.0])
            depths.append(-distance)
            shear += rubbed
    leg: Any = SimpleNamespace(contacts=before, hip=2, knee=-1, sole=-1, offset=0.0, turn=0.0, upper=0.0, height=0.0)
    c: Any = SimpleNamespace(slots=len(readings) - before)
    u: Any = SimpleNamespace(q=[0.0] * 4)
    foot = felt(c, u, readings, leg)
    assert [foot.forward, -foot.downward, foot.shear] == pytest.approx([*total[[0, 2]], shear], abs=1e-12 * 1e3)
    assert foot.pressure == pytest.approx(sum(contact[2][0] for contact in contacts if contact[0]))
    assert (foot.depth, foot.ground, foot.face) == (max(depths), len(depths) > 1, found_face)


SOLE = (0.12, 0.12)
FLAT = mjbiped.Compass(sole=SOLE)
LEVEL = mjbiped.Terrain.level()


def supervised(robot: mjbiped.Compass) -> SupervisedController:
    return SupervisedController(robot, mjbiped.find_reference(FLAT, clearance=0.077, retraction=False))


def stepped_up(place: float, rise: float, steps: int = 2, **feet: Any) -> mjbiped.Walk:
    """A walk from level ground over a step up, whose first foothold is at 0.393 m."""
    robot, ground = mjbiped.FootedCompass(sole=SOLE, **feet), mjbiped.Terrain.from_segments
    law = supervised(robot)
    return mjbiped.walk(law, ground([(place, 0.0, 0.0), (8.0, 0.0, rise)]), engine="mujoco", steps=steps)


@pytest.mark.slow
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
