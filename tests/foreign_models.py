"""Robots as other programs have read them, beside their own equations."""

from collections.abc import Iterator

import mujoco
import numpy as np
from numpy.typing import NDArray

import mjbiped
from mjbiped.engines.mujoco.scene import first_state
from mjbiped.robots.robot import Robot

LEVEL = mjbiped.Terrain.level()
ROBOTS: dict[str, Robot] = {
    "compass": mjbiped.Compass(),
    "other compass": mjbiped.Compass(leg_mass=1 / 3, hip_mass=0.7, lower_length=0.31, leg_inertia=0.0123456789012345),
    "kneed": mjbiped.KneedBiped(),
    "other knees": mjbiped.KneedBiped(shank_mass=1 / 7, thigh_length=0.41, shank_length=1 / 3, shank_inertia=1e-3),
    "wheel": mjbiped.RimlessWheel(inertia=0.2),
    "round": mjbiped.RoundCompass(hip_mass=2.0),
    "round knees": mjbiped.RoundKneed(),
}
DOWNHILL: dict[str, tuple[Robot, float]] = {
    "compass": (mjbiped.Compass(), 2.0),
    "kneed": (mjbiped.KneedBiped(), 2.5),
    "wheel": (mjbiped.RimlessWheel(), 4.0),
    "round": (mjbiped.RoundCompass(), 1.6),
}
"""Robots, and slopes that each walks down without torques, degrees."""


def addresses(model: mujoco.MjModel, robot: Robot) -> list[int]:
    """Where the numbers of a posture are in `qpos`."""
    return [int(model.joint(name).qposadr[0]) for name in robot.places]


def some_angles(robot: Robot) -> Iterator[NDArray[np.float64]]:
    """Some angles of a robot, rad."""
    yield from np.random.default_rng(0).uniform(-0.5, 0.5, (5, len(robot.angles)))


def mass_matrix_in(model: mujoco.MjModel, robot: Robot, q: NDArray[np.float64]) -> NDArray[np.float64]:
    """Mass matrix of a robot that stands on its left foot, kg m^2, of what MuJoCo has for the robot without ground."""
    order, size = addresses(model, robot), len(robot.angles)
    states = [first_state(robot, LEVEL, q.tolist(), row) for row in np.eye(size).tolist()]
    data = mujoco.MjData(model)
    data.qpos[order] = states[0][0]
    rates = np.zeros((size, model.nv))
    rates[:, order] = [state[1] for state in states]
    full = np.zeros((model.nv, model.nv))
    mujoco.mj_forward(model, data)
    mujoco.mj_fullM(model, data, full)
    return rates @ full @ rates.T
