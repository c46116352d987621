"""A robot that stands on a slope, and the MuJoCo engine's state in which it does."""

import math

from simulations import make_simulation

from controllers import PassiveController
from mjbiped.engines.mujoco import observation
from mjbiped.engines.mujoco.contacts import Felt
from mjbiped.engines.mujoco.state import Constants, State
from mjbiped.engines.mujoco.termination import limits_of
from mjbiped.robots.compass import Compass
from mjbiped.rules.scuffing import ScuffingRule
from mjbiped.rules.termination import Limits
from mjbiped.terrain.terrain import Terrain

ROBOT = Compass(lower_length=0.4, upper_length=0.5)
LENGTH, SLOPE = ROBOT.leg_length, 0.05
GROUND = Terrain((-5.0, 0.2), (0.3, 0.3 - 5.2 * math.tan(SLOPE)), (SLOPE, -0.03))
"""Down to x = 0.2 m, and up from there."""
AWAY = Felt(0.0, 0.0, 0.0, 0.0, False, False)
CONSTANTS = make_simulation(PassiveController(), GROUND, robot=ROBOT, q=(0.0, 0.0), dq=(0.0, 0.0)).constants
Posture = tuple[list[float], list[float]]
"""qpos and qvel."""


def limits(lands: bool = True, steps: int = 9, distance: float | None = None) -> Limits:
    return limits_of(ROBOT, ScuffingRule(reach=0.2, delay=0.1), 1e-3, (-3.0, 3.0), steps, distance, lands)


def constants(lands: bool = True, sampled: bool = False) -> Constants:
    return CONSTANTS._replace(limits=limits(lands), sampled=sampled)


def standing_at(
    x: float, stance: float, swing: float, dq: tuple[float, float] = (0.0, 0.0), left: bool = True
) -> Posture:
    """The robot with its stance foot on the ground at x, its legs at angles from the vertical, rad."""
    hip = (x + LENGTH * math.sin(stance), GROUND.height_at(x) + LENGTH * math.cos(stance))
    turning = (LENGTH * math.cos(stance) * dq[0], -LENGTH * math.sin(stance) * dq[0])
    legs, turns = ((stance, swing), dq) if left else ((swing, stance), dq[::-1])
    return [*hip, *legs], [*turning, *turns]


def begun(state: Posture) -> State:
    u = State()
    observation.begin(constants(), u, *state, GROUND.slope_at(0.0), GROUND.height_at(0.0))
    return u
