"""The invariants that Drake's own tests ask of its compass gait, asked of this laboratory's robot and engines."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping

import numpy as np

import mjbiped
from controllers import PassiveController
from mjbiped.robots.compass import Array, acceleration
from scripts.validation.published import DRAKE_ROBOT, DRAKE_SLOPE

TOUCHDOWN = 0.2
"""Angle of the legs from the ramp's normal in Drake's test of an impact, rad."""
RATES = (2.0, -1.0)
"""The legs' rates there, rad/s."""
STEPS = 20


def statics() -> float:
    """Greatest acceleration where Drake has none, rad/s^2.

    The swing leg is held level by the hip torque that its weight asks for, the centre of mass above the stance foot.
    """
    robot = DRAKE_ROBOT
    moment = robot.leg_mass * robot.upper_length
    stance = math.asin(moment / (robot.leg_mass * robot.lower_length + robot.leg_mass + robot.hip_mass))
    torque = moment * robot.gravity
    # the leg points forward, as Drake's at +90 degrees points back: our hip torque turns it forward, up
    ddq = acceleration(robot.constants, -stance, -math.pi / 2, 0.0, 0.0, 0.0, 1.0, torque, -torque)
    return max(map(abs, ddq))


def guard() -> float:
    """Height of the swing foot over the ramp at touchdown, m."""
    return abs(float(DRAKE_ROBOT.swing_foot([0.1, -0.1])[1]))


def _angular_momentum(q: Array, dq: Array, *, about_swing_foot: bool) -> float:
    """Angular momentum of the three point masses about a foot, kg m^2/s, from their places and velocities."""
    robot, total = DRAKE_ROBOT, 0.0
    up, along = np.stack([np.sin(q), np.cos(q)], axis=1), np.stack([np.cos(q), -np.sin(q)], axis=1) * dq[:, None]
    length = robot.leg_length
    foot = length * (up[0] - up[1]) if about_swing_foot else np.zeros(2)
    bodies = (
        (robot.leg_mass, robot.lower_length * up[0], robot.lower_length * along[0]),
        (robot.hip_mass, length * up[0], length * along[0]),
        (
            robot.leg_mass,
            length * up[0] - robot.upper_length * up[1],
            length * along[0] - robot.upper_length * along[1],
        ),
    )
    for mass, place, velocity in bodies:
        x, z = place - foot
        total += mass * float(z * velocity[0] - x * velocity[1])
    return total


def angular_momentum() -> float:
    """Change of the angular momentum about the struck point in an impact, kg m^2/s."""
    q, dq = np.array([TOUCHDOWN, -TOUCHDOWN]), np.array(RATES)
    after = DRAKE_ROBOT.impact(q, dq)
    before = _angular_momentum(q, dq, about_swing_foot=True)
    return abs(_angular_momentum(*after, about_swing_foot=False) - before)


INVARIANTS: Mapping[str, tuple[str, Callable[[], float]]] = {
    "statics": ("acceleration of the posture that its hip torque holds, rad/s²", statics),
    "guard": ("height of the swing foot where both legs make the same angle with the ramp, m", guard),
    "angular momentum": ("change of the angular momentum about the struck point, kg m²/s", angular_momentum),
}
"""What they are, and how much of each is left, by the names of Drake's tolerances."""


ENGINES: Mapping[str, mjbiped.Engine] = {
    "hybrid engine": mjbiped.Hybrid(),
    "hybrid engine, tolerance 1e-12": mjbiped.Hybrid(tolerance=1e-12),
    "MuJoCo": mjbiped.Mujoco(),
    "MuJoCo, steps of 0.2 ms": mjbiped.Mujoco(timestep=2e-4),
}


def energy_drift(engine: mjbiped.Engine) -> float:
    """Greatest change of the energy within a step of a passive walk, as a share of its greatest kinetic energy."""
    robot, slope = DRAKE_ROBOT, DRAKE_SLOPE
    ground = mjbiped.Terrain.incline(math.degrees(slope))
    walk = mjbiped.walk(PassiveController(), ground, robot=robot, engine=engine, steps=STEPS)
    samples = walk.samples
    steps = np.searchsorted(walk.touchdowns["time"], samples["time"], side="right")
    states = list(zip(samples["q"], samples["dq"], strict=True))
    energies = np.array([robot.energy(q, dq, slope) for q, dq in states])
    kinetic = max(robot.kinetic_energy(q, dq) for q, dq in states)
    return max(float(np.ptp(energies[steps == step])) for step in range(walk.steps)) / kinetic
