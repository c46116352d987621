"""A robot that stands on a slope, and the MuJoCo engine's state in which it does."""

import math
from functools import cache
from typing import Any

import numpy as np
from simulations import make_simulation

from controllers import PassiveController
from mjbiped.engines.mujoco import observation
from mjbiped.engines.mujoco.constants import Constants
from mjbiped.engines.mujoco.feet import Felt
from mjbiped.engines.mujoco.simulation import Simulation
from mjbiped.engines.mujoco.state import State
from mjbiped.robots.compass import Compass
from mjbiped.rules.scuffing import ScuffingRule
from mjbiped.terrain.terrain import Terrain

ROBOT = Compass(lower_length=0.4, upper_length=0.5)
LENGTH, SLOPE = ROBOT.leg_length, 0.05
GROUND = Terrain((-5.0, 0.2), (0.3, 0.3 - 5.2 * math.tan(SLOPE)), (SLOPE, -0.03))
"""Down to x = 0.2 m, and up from there."""
AWAY = Felt(0.0, 0.0, 0.0, 0.0, False, False)
Posture = tuple[list[float], list[float]]
"""qpos and qvel."""


@cache  # constants show memory of its model and data, which have to live
def _simulation(lands: bool) -> Simulation:
    rule = ScuffingRule(reach=0.2, delay=0.1)
    return make_simulation(
        PassiveController(), GROUND, robot=ROBOT, q=(0.0, 0.0), dq=(0.0, 0.0), steps=9, scuffing=rule, lands=lands
    )


def constants(state: Posture | None = None, *, lands: bool = True, **changed: Any) -> Constants:
    """Of a walk of nine steps on ground from -3 to 3 m; the robot's coordinates and rates are those of a posture."""
    if state is not None:
        changed |= {"qpos": np.array(state[0]), "qvel": np.array(state[1])}
    return _simulation(lands).constants.but(**{"start": -3.0, "end": 3.0, **changed})


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
    observation.begin(constants(state), u, GROUND.slope_at(0.0), GROUND.height_at(0.0))
    return u
