"""Scaling of units: a robot of other lengths, masses and gravity makes the same walk in its own units."""

import dataclasses
import math
from typing import NamedTuple

import numpy as np
import pytest
from engines.conformance.cases import parametrised, steps_of, walk_of
from golden_walks import GROUNDS, ROBOTS, Case

import mjbiped
from controllers import PassiveController
from mjbiped.robots.robot import Robot


class Scale(NamedTuple):
    """Factors of masses, lengths and gravity."""

    mass: float
    length: float
    gravity: float

    @property
    def time(self) -> float:
        return math.sqrt(self.length / self.gravity)

    def robot(self, robot: Robot) -> Robot:
        """The robot in other units."""
        units = {"gravity": self.gravity, "inertia": self.mass * self.length**2, "mass": self.mass}
        units |= {"angle": 1.0, "spokes": 1, "length": self.length, "centre": self.length}
        units |= {"offset": self.length, "radius": self.length}
        changed = {name: getattr(robot, name) * units[name.split("_")[-1]] for name in robot.numbers()}
        return dataclasses.replace(robot, **changed)  # type: ignore[type-var]  # subclasses


SCALES = {"larger and denser": Scale(2.0, 4.0, 4.0), "small on the moon": Scale(0.5, 0.25, 0.16)}
GROUND_OF = {"compass": "2 down", "kneed": "3 down", "round": "2 down", "round kneed": "2 down", "wheel": "8 down"}
PASSIVE = [Case(robot, "passive", GROUND_OF[robot], engine) for robot in GROUND_OF for engine in ("hybrid", "mujoco")]


@parametrised(PASSIVE)
@pytest.mark.parametrize("name", SCALES)
def test_passive_walks(case: Case, name: str) -> None:
    """Hybrid: within the tolerance of integration steps. MuJoCo's feet have a radius of 0.05 mm on every robot."""
    scale, here = SCALES[name], walk_of(case)
    robot, exact = scale.robot(ROBOTS[case.robot]), case.engine == "hybrid"
    start = [*here.samples["q"][0], *(here.samples["dq"][0] / scale.time)]
    engine = mjbiped.Mujoco(timestep=1e-3 * scale.time, contact_timestep=1e-5 * scale.time)
    rule = None if robot.collides_from_lift_off else mjbiped.ScuffingRule(delay=0.1 * scale.time)
    there = mjbiped.walk(
        PassiveController(),
        GROUNDS[case.ground],
        engine="hybrid" if exact else engine,
        robot=robot,
        initial=start,
        steps=steps_of(case),
        scuffing=rule,
    )
    assert there.steps == here.steps
    force, rate = scale.mass * scale.gravity, 1.0 / scale.time
    units = {"time": scale.time, "x": scale.length, "q": 1.0, "dq": rate, "normal_force": force, "friction": 1.0}
    for column, unit in units.items():
        limit = 0.03 if column in ("normal_force", "friction") else 1e-6 if exact else 2e-3
        wanted = here.touchdowns[column]
        found, atol = there.touchdowns[column] / unit, limit * np.abs(wanted).max()
        np.testing.assert_allclose(found, wanted, rtol=0, atol=atol, err_msg=column)
