"""Feet set about every kind of break: which segment they stand on, in both engines, and what the impact is there."""

import math
from typing import NamedTuple

import numpy as np
import pytest
from simulations import find_contacts, make_simulation

import mjbiped
from controllers import AdaptiveController, PassiveController
from mjbiped import Terrain
from mjbiped.engines.hybrid.meeting import CORNER, FACE_WIDTH
from mjbiped.records import measures
from mjbiped.terrain.profile import (
    BESIDE,
    EDGE,
    OVER,
    height_of,
    segment_stood_on,
)

LEAD = 0.06  # before the touchdown that a foot is let down, s
OFFSETS = (-1e-3, -1.1e-4, -8e-5, -5e-5, -2e-5, -3e-6, 3e-6, 2e-5, 5e-5, 8e-5, 1.1e-4, 1e-3)


class Break(NamedTuple):
    """A break of the ground.

    Attributes:
        before: Slope before it, degrees.
        after: Slope after it, degrees.
        rise: Of the step there, m; positive up.
        ground: How it is built.
    """

    before: float
    after: float
    rise: float = 0.0
    ground: str = "auto"

    def terrain(self, place: float) -> Terrain:
        """The ground with its break at a place (m)."""
        before, after = math.radians(self.before), math.radians(self.after)
        return Terrain((0.0, place), (0.0, self.rise - math.tan(before) * place), (before, after))


BREAKS = {
    "crest of two heightfields": Break(-1.0, 2.0),
    "valley of two heightfields": Break(2.0, -1.0),
    "crest of two boxes": Break(0.5, 3.0, ground="boxes"),
    "valley of two boxes": Break(3.0, 0.5, ground="boxes"),
    "step down, boxes": Break(0.0, 0.0, -0.02),
    "step up, boxes": Break(0.0, 0.0, 0.012),
    "step down, heightfields": Break(1.3, 0.5, -0.02),
    "step up, heightfields": Break(0.5, 1.3, 0.012),
    "step down, tilted boxes": Break(1.3, 0.5, -0.02, "boxes"),
    "step up, tilted boxes": Break(0.5, 1.3, 0.012, "boxes"),
    "step down, lower than a plate": Break(0.0, 1.0, -3e-5),
    "step up, less than a millimetre": Break(1.0, 0.0, 6e-4),
}
EXACT = {"mujoco": (EDGE, BESIDE, OVER), "hybrid": (CORNER, FACE_WIDTH, FACE_WIDTH)}
FEW = ("step down, boxes", "step up, heightfields", "crest of two boxes", "valley of two heightfields")


class Dropped:
    """The passive gait's last moments, with the swing foot set down about a break."""

    def __init__(self, gait: mjbiped.Gait, engine: str, made: Break) -> None:
        q, dq, _ = gait.reference(gait.period - LEAD)
        self.made, self.initial = made, (*q.tolist(), *dq.tolist())
        self.engine = engine

    def land(self, terrain: Terrain) -> mjbiped.Walk:
        return mjbiped.walk(
            PassiveController(),
            terrain,
            engine=mjbiped.Mujoco(ground=self.made.ground) if self.engine == "mujoco" else self.engine,
            steps=1,
            initial=self.initial,
            scuffing=mjbiped.ScuffingRule(reach=0.05, delay=0.0),
            sample_period=1.0,
        )

    def foothold(self, *, upper: bool) -> float:
        """Where the foot comes down on the upper or on the lower ground (on either side, where there is no step), m."""
        later = upper == (self.made.rise > 0.0)
        place = 0.36
        for _ in range(8):  # the later segment's height hangs a little on where it begins
            terrain = self.made.terrain(place)
            if later:  # as if it had begun 3 cm before
                x = place - 0.03
                terrain = Terrain((0.0, x), (0.0, height_of(terrain.profile, 1, x)), terrain.angle)
            else:
                terrain = self.made.terrain(0.6)
            x = float(self.land(terrain).touchdowns["x"][0])
            if abs(x - place) < 1e-9 or not later:
                return x
            place = x
        return place


def check(made: Break, engine: str, offset: float, foothold: float, dropped: Dropped) -> None:
    """The foot comes down on the segment that it is over, with its slope and the impact map's rates."""
    place = foothold - offset  # the foot would come down so far behind the break, were the ground there as it is here
    terrain = made.terrain(place)
    walk = dropped.land(terrain)
    assert walk.steps == 1
    x, z, slope = (float(walk.touchdowns[name][0]) for name in ("x", "z", "slope"))
    on = segment_stood_on(terrain.profile, x, z, *EXACT[engine])
    assert abs(z - height_of(terrain.profile, on, x)) < EXACT[engine][0] + 2e-6
    assert slope == pytest.approx(terrain.angle[on], abs=1e-15)
    if abs(x - place) > 2e-5:  # the way of a swing foot in a contact step
        assert on == (x > place)
    if not walk.touchdowns["strikes"][0]:
        assert np.abs(measures.impact_errors(walk)).max() < 6e-4  # of the contact step, as far from any edge


@pytest.mark.parametrize(
    ("name", "upper"),
    [
        pytest.param(name, upper, marks=() if name in FEW and upper else pytest.mark.slow)
        for name in BREAKS
        for upper in (True, False)
    ],
)
@pytest.mark.parametrize("engine", ["mujoco", "hybrid"])
def test_feet_about_a_break(name: str, upper: bool, engine: str, gait: mjbiped.Gait) -> None:
    made = BREAKS[name]
    dropped = Dropped(gait, engine, made)
    foothold = dropped.foothold(upper=upper)
    for offset in OFFSETS[1::2] if name in FEW else OFFSETS:
        check(made, engine, offset, foothold, dropped)


@pytest.mark.parametrize("name", BREAKS)
def test_normals_are_the_grounds(name: str) -> None:
    """A foot a micrometre in the ground about a break: each contact has the normal of the segment that it is over."""
    made, place = BREAKS[name], 0.4
    terrain, robot = made.terrain(place), mjbiped.Compass()
    simulation = make_simulation(
        PassiveController(), terrain, robot=robot, q=(0.0, 0.0), dq=(0.0, 0.0), steps=1, ground=made.ground
    )
    model, data = simulation.model, simulation.data
    swing, met = model.geom("right_foot").id, 0
    simulation.state.enabled = 1.0
    started = data.userdata.copy()
    for on in (0, 1):
        for away in (1e-3, 1.1e-4, 6e-5, 2e-5, 5e-6, -5e-6, -2e-5, -6e-5, -1.1e-4):
            x = place + (away if on else -away)
            if away < 0.0 and height_of(terrain.profile, 1 - on, x) > height_of(terrain.profile, on, x) - 2e-3:
                continue  # the other side is ground itself there
            z = height_of(terrain.profile, on, x) - 1e-6
            data.qpos[:] = x, z + robot.leg_length, 1.0, 0.0
            data.userdata[:] = started
            find_contacts(simulation)
            normals = [
                contact.frame[:3] * (-1.0 if contact.geom[0] == swing else 1.0)
                for contact in data.contact
                if swing in contact.geom
            ]
            if away < 0.0:
                assert not normals, "beyond the edge there is nothing"
                continue
            met += 1
            slope = terrain.angle[on]
            upward = [normal for normal in normals if abs(normal[2]) > 0.1]
            assert upward, (on, away)
            for normal in upward:  # heightfields are kept in single precision
                assert [normal[0], normal[2]] == pytest.approx([math.sin(slope), math.cos(slope)], abs=1e-4), away
            faces = [normal for normal in normals if abs(normal[2]) <= 0.1]
            assert all(abs(normal[0]) == pytest.approx(1.0, abs=1e-9) for normal in faces)
    assert met == 10


def test_a_foot_on_the_very_edge() -> None:
    """A step up of 30 mm at 1 m: feet on its edge, on its face, at its foot and in it."""
    profile = Terrain.from_segments([(1.0, 0.0), (1.0, 0.0, 0.03)]).profile
    for x, z, on in (
        (1.0, 0.03, 1),
        (1.0 - 1e-12, 0.03, 1),
        (1.0 - 2e-6, 0.03, 0),  # over the lower ground, in the air
        (1.0 + 1e-5, 0.03 - 4e-5, 1),
        (1.0 + 1e-5, 0.03 - 6e-5, 0),
        (1.0 + 1e-5, 0.0, 0),
        (1.0 + 2e-3, 0.0, 1),  # far inside
        (1.0 - 1e-12, 0.0, 0),
        (math.nan, 0.0, 1),
    ):
        assert segment_stood_on(profile, x, z) == on, (x, z)


def test_friction_on_a_joint_of_the_ground_is_that_of_both_its_sides(controller: AdaptiveController) -> None:
    """Level ground in two pieces bears a foot with two contacts; the friction used was that of the deeper one alone."""
    jointed = Terrain(x=(-5.0, 0.0), z=(0.0, 0.0), angle=(0.0, 0.0))
    there, level = (mjbiped.walk(controller, ground, steps=1) for ground in (jointed, Terrain.level()))
    # the joint's two contacts are together as soft as one and another solve: the 7th digit differs
    assert there.touchdowns["friction"] == pytest.approx(level.touchdowns["friction"], rel=1e-5)
