"""Feet that are bodies in MuJoCo: when they stand, what they tell, how they are held, and walks on them."""

import math
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
from simulations import started

import mjbiped
from controllers import AdaptiveController, BoundedAnkleController
from mjbiped.engines.mujoco import feet
from mjbiped.engines.mujoco.constants import sole_angle
from mjbiped.robots.footed import FootedCompass

ROBOT = FootedCompass()
GAIT = mjbiped.find_passive_gait(ROBOT, math.radians(2.0))
LAW = BoundedAnkleController(ROBOT, GAIT)
SHORT = 1e-4  # s: the engine's longest step with feet


def on(ground: mjbiped.Terrain, steps: int = 4, robot: FootedCompass = ROBOT, **more: Any) -> mjbiped.Walk:
    law = BoundedAnkleController(robot, GAIT)
    return mjbiped.walk(law, ground, engine="mujoco", steps=steps, **more)


@pytest.mark.slow
def test_a_change_of_slope_lets_the_foot_slap() -> None:
    ground = mjbiped.Terrain.from_segments([(0.6, 0.0, 0.0), (5.0, 3.0, 0.0)])
    walk = on(ground, steps=3)
    slaps, slopes = walk.touchdowns["slap"], walk.touchdowns["slope"]
    changed = int(np.argmax(slopes > 0.02))
    assert slopes[changed] == pytest.approx(math.radians(3.0), abs=1e-3)
    assert slaps[changed] == slaps.max() > 1e-3
    assert slaps[changed + 1] < 1e-3  # the foot is held parallel to the new ground by then


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


def test_the_servo_of_the_swing_foot_presses_no_harder_than_on_a_plausible_error() -> None:
    """A foot that landed on an edge turns to it; what holds it parallel to the ground so far must give."""
    simulation = started(LAW, mjbiped.Terrain.level())
    constants, u = simulation.constants, simulation.state
    leg, torques = constants.legs[1], []
    for error in (0.0, 0.5, 1.0, 3.0, -3.0):
        u.q[leg.sole] += error * feet.PLAUSIBLE - sole_angle(leg, u.q)
        torques.append(feet.swing_foot_torque(constants, u))
    half, full, far, other = (torque - torques[0] for torque in torques[1:])
    assert full == far == pytest.approx(2.0 * half, rel=1e-12)
    assert other == pytest.approx(-full, rel=1e-12)


def test_a_box_across_an_edge_tells_how_far_the_ground_bears_it() -> None:
    """From the ankle to the edge, within contacts' softness: 0.1 mm; the walk's phase lets a foot land across it."""
    robot, edge = FootedCompass(underside="box"), 1.1
    walk = on(mjbiped.Terrain.from_segments([(edge, 0.0, 0.0), (5.0, 0.0, 0.01)]), robot=robot, steps=3)
    x, behind, ahead = (walk.touchdowns[name] for name in ("x", "support_behind", "support_ahead"))
    across = int(np.argmin(abs(x - edge - 0.05)))
    assert edge + 1e-3 < x[across] < edge + 0.11
    assert behind[across] == pytest.approx(x[across] - edge, abs=1e-4)
    np.testing.assert_allclose(ahead, 0.12, atol=1e-4)
    np.testing.assert_allclose(np.delete(behind, across), 0.12, atol=1e-4)


class Asking(BoundedAnkleController):
    """Shows in its estimate how far behind the ankle the ground bore the last foothold."""

    def law(self) -> None:  # type: ignore[override]  # so that engines call the methods
        return None

    def slope_estimate(self, memory: Any) -> float:
        return float(memory[self.support])


@pytest.mark.parametrize(("engine", "delay"), [("hybrid", 0.0), ("hybrid", 1e-3), ("mujoco", 1e-3)])
def test_a_law_is_told_what_the_record_tells(engine: str, delay: float) -> None:
    robot = FootedCompass(sole=(0.11, 0.12))
    law, ground = Asking(robot, GAIT), mjbiped.Terrain.level()
    walk = mjbiped.walk(law, ground, engine=engine, steps=1, disturbances=mjbiped.Disturbances(delay=delay))
    assert walk.touchdowns["slope_estimate_before"].tolist() == [0.0]
    np.testing.assert_array_equal(walk.touchdowns["slope_estimate"], walk.touchdowns["support_behind"])
    np.testing.assert_allclose(walk.touchdowns["support_behind"], 0.11, atol=1e-4)
