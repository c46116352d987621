"""Robots of somebody's own: described by its bodies, one walks in both engines; by its linkage, in the hybrid one."""

from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from typing import Annotated, ClassVar

import numpy as np
import pytest

import mjbiped
from controllers import Controller, PassiveController
from controllers import Memory as State
from mjbiped.dynamics.linkage import Linkage
from mjbiped.numerics.blocks import Numbers
from mjbiped.robots.bodies import Bodies, Segment, linkage_with
from mjbiped.robots.chain import Chain, chain_by
from mjbiped.robots.compass import StraightLegs
from mjbiped.utils import domains


@dataclass(frozen=True)
class LeaningCompass(mjbiped.Compass):
    """Legs whose centres of mass lie ahead of the line from hip to foot."""

    offset: Annotated[float, domains.LENGTH] = 0.02

    kind: ClassVar[str] = "leaning"

    @property
    def bodies(self) -> Bodies:
        leg = Segment("leg", self.leg_mass, self.leg_length, self.upper_length, self.leg_inertia, offset=self.offset)
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


@dataclass(frozen=True)
class TrunkCompass(StraightLegs):
    """Straight legs, and a trunk on a hinge at the hip."""

    trunk_mass: Annotated[float, domains.LEG_MASS] = 10.0
    trunk_centre: Annotated[float, domains.LENGTH] = 0.3

    kind: ClassVar[str] = "trunk"
    angles: ClassVar[tuple[str, ...]] = ("stance", "swing", "trunk")
    joints: ClassVar[tuple[str, ...]] = ("ankle", "hip", "waist")
    places: ClassVar[tuple[str, ...]] = (*StraightLegs.places, "trunk")

    @property
    def total_mass(self) -> float:
        return 2 * self.leg_mass + self.hip_mass + self.trunk_mass

    @cached_property
    def linkages(self) -> tuple[Linkage, ...]:
        stance, swing, trunk = np.eye(3, dtype=np.complex128)
        hip = self.leg_length * stance
        masses = [
            (self.leg_mass, self.leg_inertia, 0, self.lower_length * stance),
            (self.leg_mass, self.leg_inertia, 1, hip - self.upper_length * swing),
            (self.hip_mass, 0.0, -1, hip),
            (self.trunk_mass, 0.0, -1, hip + self.trunk_centre * trunk),
        ]
        end = hip - self.leg_length * swing
        return (linkage_with(masses, hip, end, 0 * hip, angles=3, gravity=self.gravity),)

    @cached_property
    def chains(self) -> dict[int, Chain]:
        return {3: chain_by(self.linkages[0], (0, 1, 2))}

    def posture(
        self, foot: Numbers, stance: int, angles: Numbers, stance_flexion: float = 0.0, slope: float = 0.0
    ) -> tuple[float, ...]:
        return (*super().posture(foot, stance, angles[:2]), angles[2])


class Upright(Controller):
    """Holds the trunk upright and swings the leg forward."""

    robot, gait = TrunkCompass(), None
    joints = TrunkCompass.joints

    def torque(self, memory: State, t: float, q: Numbers, dq: Numbers) -> tuple[float, float, float]:
        waist = -400.0 * q[2] - 40.0 * dq[2]
        return 0.0, waist - 120.0 * (q[1] + 0.25) - 14.0 * dq[1], waist


def test_a_trunk_walks_and_its_record_knows_it(tmp_path: Path) -> None:
    start = (-0.2, 0.2, 0.0, 1.4, 0.5, 0.0)
    ground = mjbiped.Terrain.incline(3.0)
    walk = mjbiped.walk(Upright(), ground, engine="hybrid", initial=start, steps=30)
    assert walk.outcome == "finished"
    walk.save(tmp_path / "trunk.npz")
    assert mjbiped.Walk.load(tmp_path / "trunk.npz").robot == TrunkCompass()


def test_mujoco_says_why_it_does_not_build_a_trunk() -> None:
    with pytest.raises(mjbiped.InputError, match=r"of 10 kg, and a TrunkCompass weighs 20 kg; .*engine='hybrid'"):
        mjbiped.walk(Upright(), mjbiped.Terrain.level(), initial=(-0.2, 0.2, 0.0, 1.4, 0.5, 0.0), steps=1)
