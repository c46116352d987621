"""Scaling of units: a robot of other lengths, masses and gravity makes the same walk in its own units."""

from __future__ import annotations

import dataclasses
import math
from typing import Any, NamedTuple

import numpy as np
import pytest
from engines.conformance.cases import parametrised, steps_of, walk_of
from golden_walks import ENGINES, GROUNDS, ROBOTS, Case

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
        changed: dict[str, Any] = {}
        for name in robot.numbers():
            value = getattr(robot, name)
            if name == "gravity":
                changed[name] = value * self.gravity
            elif "mass" in name:
                changed[name] = value * self.mass
            elif "inertia" in name:
                changed[name] = value * self.mass * self.length**2
            elif name not in ("stop_angle", "spokes"):
                changed[name] = value * self.length
        return dataclasses.replace(robot, **changed)  # type: ignore[type-var]  # subclasses


SCALES = {"larger and denser": Scale(2.0, 4.0, 4.0), "small on the moon": Scale(0.5, 0.25, 0.16)}
PASSIVE = [
    Case(robot, "passive", ground, engine)
    for robot, ground in (
        ("compass", "2 down"),
        ("kneed", "3 down"),
        ("round", "2 down"),
        ("round kneed", "2 down"),
        ("wheel", "8 down"),
    )
    for engine in ("hybrid", "mujoco")
]


@parametrised(PASSIVE)
@pytest.mark.parametrize("name", SCALES)
def test_passive_walks(case: Case, name: str) -> None:
    """Hybrid: within the tolerance of integration steps. MuJoCo's feet have a radius of 0.05 mm on every robot."""
    scale, here = SCALES[name], walk_of(case)
    robot, exact = scale.robot(ROBOTS[case.robot]), case.engine == "hybrid"
    start = [*here.samples["q"][0], *(here.samples["dq"][0] / scale.time)]
    engine = ENGINES[case.engine]
    if not exact:
        engine = mjbiped.Mujoco(timestep=1e-3 * scale.time, contact_timestep=1e-5 * scale.time)
    rule = None if robot.collides_from_lift_off else mjbiped.ScuffingRule(delay=0.1 * scale.time)
    there = mjbiped.walk(
        PassiveController(),
        GROUNDS[case.ground],
        engine=engine,
        robot=robot,
        initial=start,
        steps=steps_of(case),
        scuffing=rule,
    )
    assert there.steps == here.steps
    force = scale.mass * scale.gravity
    units = {
        "time": scale.time,
        "x": scale.length,
        "q": 1.0,
        "dq": 1.0 / scale.time,
        "normal_force": force,
        "friction": 1.0,
    }
    for column, unit in units.items():
        size = np.abs(here.touchdowns[column]).max()
        limit = size * ((1e-6 if exact else 2e-3) if column not in ("normal_force", "friction") else 0.03)
        np.testing.assert_allclose(
            there.touchdowns[column] / unit, here.touchdowns[column], rtol=0, atol=limit, err_msg=column
        )
