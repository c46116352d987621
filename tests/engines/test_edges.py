"""Feet set about every kind of break: which segment they stand on, in both engines, and what the impact is there."""

import math

import numpy as np
import pytest

import mjbiped
from controllers import PassiveController
from mjbiped import Terrain
from mjbiped.engines.hybrid.meeting import CORNER, FACE_WIDTH
from mjbiped.records import measures
from mjbiped.terrain.profile import BESIDE, EDGE, OVER, height_of, segment_stood_on

LEAD = 0.06  # before the touchdown that a foot is let down, s
OFFSETS = (-1.1e-4, -5e-5, -3e-6, 2e-5, 8e-5, 1e-3)
PLACE = 0.36  # about where the foot comes down, m


# slopes before and after the break, degrees, its step, m, and how MuJoCo's ground is built
BREAKS = {
    "step down, boxes": (0.0, 0.0, -0.02, "auto"),
    "step up, heightfields": (0.5, 1.3, 0.012, "auto"),
    "crest of two boxes": (0.5, 3.0, 0.0, "boxes"),
    "valley of two heightfields": (2.0, -1.0, 0.0, "auto"),
}
EXACT = {"mujoco": (EDGE, BESIDE, OVER), "hybrid": (CORNER, FACE_WIDTH, FACE_WIDTH)}


def landed(gait: mjbiped.Gait, engine: str, name: str, place: float) -> mjbiped.Walk:
    """The passive gait's last moments, with the swing foot let down on the ground whose break is at a place.

    Both parts of the ground stay where they are, wherever the break is.
    """
    *slopes, rise, ground = BREAKS[name]
    before, after = np.radians(slopes).tolist()
    height = rise - math.tan(before) * PLACE - math.tan(after) * (place - PLACE)
    q, dq, _ = gait.reference(gait.period - LEAD)
    scuffing, law = mjbiped.ScuffingRule(reach=0.05, delay=0.0), PassiveController()
    made = mjbiped.Mujoco(ground=ground) if engine == "mujoco" else engine
    terrain = Terrain((0.0, place), (0.0, height), (before, after))
    return mjbiped.walk(law, terrain, engine=made, steps=1, initial=(*q, *dq), scuffing=scuffing, sample_period=1.0)


@pytest.mark.parametrize("name", BREAKS)
@pytest.mark.parametrize("engine", ["mujoco", "hybrid"])
def test_feet_about_a_break(name: str, engine: str, gait: mjbiped.Gait) -> None:
    """The foot comes down on the segment that it is over, with its slope and the impact map's rates."""
    # where the foot comes down on the upper ground, or before the break where there is no step up
    foothold = float(landed(gait, engine, name, PLACE - 0.03 if "up" in name else 0.6).touchdowns["x"][0])
    for offset in OFFSETS:
        place = foothold - offset  # the foot would come down so far behind it, were the ground there as it is here
        walk = landed(gait, engine, name, place)
        assert walk.steps == 1
        x, z, slope = (float(walk.touchdowns[name][0]) for name in ("x", "z", "slope"))
        profile = walk.terrain.profile
        on = segment_stood_on(profile, x, z, *EXACT[engine])
        assert abs(z - height_of(profile, on, x)) < EXACT[engine][0] + 2e-6
        assert slope == pytest.approx(walk.terrain.angle[on], abs=1e-15)
        if abs(x - place) > 2e-5:  # the way of a swing foot in a contact step
            assert on == (x > place)
        if not walk.touchdowns["strikes"][0]:
            assert np.abs(measures.impact_errors(walk)).max() < 6e-4  # of the contact step, as far from any edge
