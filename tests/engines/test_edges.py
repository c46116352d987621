"""Feet set about every kind of break: which segment they stand on, in both engines, and what the impact is there."""

import math
from typing import NamedTuple

import numpy as np
import pytest

import mjbiped
from controllers import PassiveController
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
OFFSETS = (-1.1e-4, -5e-5, -3e-6, 2e-5, 8e-5, 1e-3)


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
    "step down, boxes": Break(0.0, 0.0, -0.02),
    "step up, heightfields": Break(0.5, 1.3, 0.012),
    "crest of two boxes": Break(0.5, 3.0, ground="boxes"),
    "valley of two heightfields": Break(2.0, -1.0),
}
EXACT = {"mujoco": (EDGE, BESIDE, OVER), "hybrid": (CORNER, FACE_WIDTH, FACE_WIDTH)}


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

    def foothold(self) -> float:
        """Where the foot comes down on the upper ground (on either side, where there is no step), m."""
        later = self.made.rise > 0.0
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


@pytest.mark.parametrize("name", BREAKS)
@pytest.mark.parametrize("engine", ["mujoco", "hybrid"])
def test_feet_about_a_break(name: str, engine: str, gait: mjbiped.Gait) -> None:
    made = BREAKS[name]
    dropped = Dropped(gait, engine, made)
    foothold = dropped.foothold()
    for offset in OFFSETS:
        check(made, engine, offset, foothold, dropped)
