"""A robot of somebody's own is a description of its bodies: both engines and the paper's law walk with it."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Annotated, ClassVar

import numpy as np

import mjbiped
from controllers import AdaptiveController, PassiveController
from mjbiped.robots.bodies import Bodies, Segment
from mjbiped.utils import domains


@dataclass(frozen=True)
class LeaningCompass(mjbiped.Compass):
    """Legs whose centres of mass lie ahead of the line from hip to foot."""

    leg_offset: Annotated[float, domains.LENGTH] = 0.02

    kind: ClassVar[str] = "leaning"

    @property
    def bodies(self) -> Bodies:
        leg = Segment(
            "leg", self.leg_mass, self.leg_length, self.upper_length, self.leg_inertia, offset=self.leg_offset
        )
        return Bodies("scene.xml", self.hip_mass, (leg,))


def test_both_engines_agree_about_its_step() -> None:
    start = (-0.19, 0.19, 1.1, 0.81)
    ground, law = mjbiped.Terrain.incline(2.0), PassiveController()
    one, other = (
        mjbiped.walk(law, ground, engine=engine, robot=LeaningCompass(), steps=1, initial=start)
        for engine in ("hybrid", "mujoco")
    )
    straight = mjbiped.walk(law, ground, engine="hybrid", steps=1, initial=start)
    for name in ("time", "x", "dq_before", "dq"):  # MuJoCo's foot sinks in by some 50 um, 2e-4 of a step
        size = np.abs(one.touchdowns[name]).max()
        np.testing.assert_allclose(one.touchdowns[name], other.touchdowns[name], atol=3e-4 * size)
        assert np.abs(one.touchdowns[name] - straight.touchdowns[name]).max() > 1e-2 * size


def test_the_papers_law_walks_with_it() -> None:
    gait = mjbiped.find_passive_gait(mjbiped.Compass(), slope=math.radians(2.0))
    walk = mjbiped.walk(AdaptiveController(LeaningCompass(), gait), mjbiped.Terrain.level(), engine="hybrid", steps=10)
    assert walk.outcome == "finished"
