"""One impact of any compass biped on any slopes, by MuJoCo's contact solver in one step, against the impact map."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Any, NamedTuple

import numpy as np
import pytest
from numpy.typing import NDArray
from simulations import make_simulation

from controllers import Controller, Memory
from mjbiped.engines.mujoco.scene import START_DEPTH
from mjbiped.records.columns import TOUCHDOWNS, split
from mjbiped.robots.compass import Compass
from mjbiped.rules.scuffing import ScuffingRule
from mjbiped.terrain.profile import GROUND_FRICTION
from mjbiped.terrain.terrain import Terrain

Array = NDArray[np.float64]


class Landing(NamedTuple):
    """A robot just before its swing foot meets the ground.

    Attributes:
        robot: Any.
        q: Angles from the normal of the ground under the stance foot.
        dq: Rates.
        slopes: Of the ground under the stance foot, and of that which is met.
        foot: Swing foot from the stance foot, x and z in m.
        speed: At which it approaches the ground, m/s.
    """

    robot: Compass
    q: Array
    dq: Array
    slopes: tuple[float, float]
    foot: complex
    speed: float

    def terrain(self, clearance: float) -> Terrain:
        """Ground with the new slope as far under the swing foot, and a step half-way, however high."""
        half, (old, new) = self.foot.real / 2.0, self.slopes
        return Terrain(
            (0.0, half), (0.0, self.foot.imag - clearance / math.cos(new) + math.tan(new) * half), (old, new)
        )


def landing(random: np.random.Generator, same_slope: bool = False) -> Landing:
    """Draw a state that ends in an impact as the paper has it: plastic, without slip, the trailing foot leaves."""
    while True:
        masses: dict[str, Any] = {"leg_mass": random.uniform(1.0, 20.0), "hip_mass": random.uniform(0.0, 30.0)}
        lengths: dict[str, Any] = {"lower_length": random.uniform(0.2, 0.8), "upper_length": random.uniform(0.2, 0.8)}
        robot = Compass(**masses, **lengths, gravity=random.uniform(1.6, 20.0))
        old = random.uniform(-0.2, 0.2)
        new = old if same_slope else random.uniform(-0.2, 0.2)
        pace, length = math.sqrt(robot.gravity / robot.leg_length), robot.leg_length
        q = np.array([random.uniform(0.05, 0.4), random.uniform(-0.4, -0.05)])
        dq = pace * np.array([random.uniform(0.1, 1.0), random.uniform(-1.0, 1.7)])
        q_plus, dq_plus = robot.impact(q, dq)
        # complex numbers are x + iz; a leg turns by exp(-i angle)
        foot = complex(*robot.swing_foot(q)) * np.exp(-1j * old)
        moments = np.array([robot.constants[3], -robot.constants[4]]) / robot.gravity
        momentum = [rates * moments @ np.exp(-1j * (legs + old)) for legs, rates in ((q, dq), (q_plus, dq_plus))]
        speeds = [
            length * (rates * [1.0, -1.0]) @ np.exp(-1j * (legs + old)) for legs, rates in ((q, dq), (q_plus, dq_plus))
        ]
        normal = 1j * np.exp(-1j * np.array([new, old]))
        impulse = (momentum[1] - momentum[0]) / normal[0]
        speed, lifts = -(speeds[0] / normal[0]).real, (speeds[1] / normal[1]).real
        sticks = abs(impulse.imag) < 0.9 * GROUND_FRICTION * impulse.real
        ahead = foot.real > 0.1 * length and abs(foot.imag) < 0.3
        if speed > 0.05 * pace * length and lifts > 0.0 and sticks and ahead:
            return Landing(robot, q, dq, (old, new), foot, float(speed))


class Held(Controller):
    """Torques that never change."""

    def __init__(self, ankle: float, hip: float) -> None:
        self.torques = ankle, hip

    def torque(self, memory: Memory, t: float, q: Sequence[float], dq: Sequence[float]) -> Sequence[float]:
        return self.torques


def impact_error(case: Landing, timestep: float, torque: float) -> float:
    """Rates after the impact, as they are recorded, against the impact map of those before it; of the largest rate.

    The robot begins one and a half steps before its foot meets the ground; torques are of a size that a walk may ask
    for in the instant of an impact.
    """
    moment = torque * case.robot.weight * case.robot.leg_length
    simulation = make_simulation(
        Held(0.3 * moment, -0.2 * moment),
        case.terrain(1.5 * timestep * case.speed + START_DEPTH),  # else a slow foot would begin in the ground
        robot=case.robot,
        q=case.q.tolist(),
        dq=case.dq.tolist(),
        timestep=timestep,
        contact_timestep=timestep,
        steps=1,
        scuffing=ScuffingRule(reach=0.0, delay=0.0),
    )
    simulation.advance(40)
    assert simulation.state.count == 1.0
    row = split(TOUCHDOWNS, [simulation._buffers[1][0].tolist()])
    _, mapped = case.robot.impact(row["q_before"][0], row["dq_before"][0])
    return float(np.abs(row["dq"][0] - mapped).max() / np.abs(row["dq_before"]).max())


@pytest.mark.parametrize("torque", [0.0, 1.0])
def test_the_error_of_an_impact_shrinks_with_the_step(torque: float) -> None:
    """First order in h, for the forces and the turning of the legs in one step.

    The constant is the acceleration: torques of 0.3 and 0.2 weights times leg lengths in the instant of the impact make
    the worst error fourteen times as large.
    """
    random = np.random.default_rng(1)
    cases = [landing(random, same_slope=number % 3 == 0) for number in range(20)]
    timesteps = 2e-5 * 2.0 ** np.arange(4)  # at shorter ones what does not shrink is the greater part
    errors = np.array([[impact_error(case, h, torque) for case in cases] for h in timesteps])
    # order 1, bent by what does not shrink: the constraint's softness and the foot's radius
    assert np.polyfit(np.log(timesteps), np.log(errors.max(axis=1)), 1)[0] == pytest.approx(1.0, abs=0.05)
    # h times the accelerations at play
    assert errors[0].max() < (0.005 if torque else 0.0004)
