"""Events of the hybrid engine: which of two comes first, and a foot that slides up a face and over its edge."""

import dataclasses
import math

import numpy as np
import pytest

import mjbiped
from controllers import AdaptiveController, PassiveController
from mjbiped.terrain.terrain import Terrain


def test_foot_slides_over_the_top_edge_and_walks_on(controller: AdaptiveController) -> None:
    """The hip goes backwards at the start: only then a straight leg that is held at a face moves its foot upwards."""
    face, rise, start = 0.21, 0.009, (0.11, 0.11, -0.36, -2.6)
    terrain = Terrain.from_segments([(face, 0.0), (9.0, 0.0, rise)])
    walk = mjbiped.walk(controller, terrain, engine="hybrid", steps=2, initial=start, sample_period=1e-5)
    x, z = walk.robot.limbs(walk.samples["qpos"][walk.samples["time"] < walk.touchdowns["time"][0]])[:, 1, -1].T
    (held,) = np.nonzero(np.abs(x - face) < 1e-9)
    assert len(held) > 1000
    assert (np.diff(held) == 1).all()  # pressed against the face up to the edge: it is the edge that ends the slide
    assert z[held[0]] < rise - 2e-3
    assert z[held[-1]] == pytest.approx(rise, abs=1e-5)
    # pressed no more, it goes on forwards over the upper tread for a while (then the falling hip draws it back, above
    # the edge), and lands there
    assert (x[held[-1] + 1 : held[-1] + 101] > face).all()
    assert (z[held[-1] + 1 :] >= rise).all()
    assert walk.outcome == "finished"
    assert walk.touchdowns["strikes"].tolist() == [1, 0]
    assert walk.touchdowns["x"][0] > face + 0.1
    assert walk.touchdowns["z"][0] == pytest.approx(rise, abs=1e-12)


@pytest.mark.parametrize(("later", "locked"), [(1e-4, 1.0), (-1e-4, 0.0)])
def test_a_knee_strikes_in_the_step_in_which_the_hip_leaves_the_ground_if_it_comes_first(
    later: float, locked: float
) -> None:
    """The ground ends just after the place of the hip at the strike, or just before: within one integration step."""
    robot = mjbiped.KneedBiped()
    ground, gait = Terrain.incline(2.5), mjbiped.find_kneed_gait(robot, slope=math.radians(2.5))
    walk = mjbiped.walk(PassiveController(), ground, robot=robot, engine="hybrid", steps=1, sample_period=1e-4)
    assert walk.touchdowns["knee_strike"][0] == pytest.approx(gait.knee_strike, abs=1e-6)
    hip = float(np.interp(gait.knee_strike, walk.samples["time"], walk.samples["qpos"][:, 0]))
    short = dataclasses.replace(ground, end=hip + later)  # at some 1 m/s
    ended = mjbiped.walk(PassiveController(), short, robot=robot, engine="hybrid", steps=1)
    assert ended.outcome == "left the terrain"
    assert ended.end[0] == pytest.approx(gait.knee_strike, abs=2e-3)
    assert ended.samples["locked"][-1] == locked
