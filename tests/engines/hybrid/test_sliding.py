"""A swing foot that slides on the ground, because it cannot take the robot over: onto what it slides."""

import math

import numpy as np
import pytest
from simulations import hybrid_simulation

from mjbiped.engines.hybrid.guards import on_its_segment
from mjbiped.engines.hybrid.impacts import slide_on
from mjbiped.robots.kneed import KneedBiped
from mjbiped.terrain.terrain import Terrain

EDGE = -0.45
BACKWARDS = (-0.2, 0.201, 0.201, -2.0, 1.0, 1.0)
"""The swing foot, 0.4 m behind the other one and barely above level ground, comes down and goes backwards."""

SLOPE = math.radians(1.0)
BEHIND = {
    "down a step": Terrain((-5.0, EDGE), (-0.02, 0.0), (0.0, 0.0)),
    "down a slope": Terrain((-5.0, EDGE), (-math.tan(SLOPE) * (5.0 + EDGE), 0.0), (-SLOPE, 0.0)),
    "up a slope": Terrain((-5.0, EDGE), (math.tan(SLOPE) * (5.0 + EDGE), 0.0), (SLOPE, 0.0)),
}


@pytest.mark.parametrize("name", BEHIND)
def test_a_foot_that_slides_backwards_over_an_edge_is_on_what_lies_behind_it(name: str) -> None:
    ground = BEHIND[name]
    simulation = hybrid_simulation(ground, BACKWARDS, sample_period=1e-3, steps=1)
    simulation.go()
    feet = KneedBiped().limbs(simulation.recorder.samples()["qpos"])[:, 1, -1]
    above = feet[:, 1] - [ground.height_at(x) for x in feet[:, 0]]
    assert above.min() > -1e-7  # ground that a foot slides on is met again at 1e-8 m below it
    before = np.flatnonzero((feet[:, 0] > EDGE) & (above < 1e-9))
    beyond = np.flatnonzero(feet[:, 0] < EDGE)
    assert len(before) > 5
    assert beyond[0] == before[-1] + 1  # it slid up to the edge
    assert above[beyond[0]] == pytest.approx(-ground.height_at(EDGE - 1e-9) if name == "down a step" else 0.0, abs=1e-3)


@pytest.mark.parametrize(("place", "segment"), [(-0.5, 0), (-0.1, 2)])
def test_a_sliding_foot_comes_to_the_segment_before_or_behind(place: float, segment: int) -> None:
    """Of level ground, of which the one in the middle reaches from -0.4 m to -0.2 m, higher than the others."""
    ground = Terrain((-5.0, -0.4, -0.2), (0.0, 0.01, 0.0), (0.0, 0.0, 0.0))
    simulation = hybrid_simulation(ground, (-0.1, 0.2, 0.2, 1.0, 0.0, 0.0))
    c, w = simulation.constants, simulation.state
    w.sliding, w.slid_segment = True, 1
    for inside in (-0.4, -0.3, -0.2):
        assert on_its_segment(c, w, foot_at(inside, 0.01))
    w.y[:3] = foot_at(place, 0.005)
    assert not on_its_segment(c, w, w.y)
    slide_on(c, w)
    assert (w.outcome, w.impulse_along, w.impulse_normal) == (0, 0.0, 0.0)
    assert (w.sliding, w.slid_segment, w.landing) == (False, -1, segment)


def foot_at(x: float, z: float) -> list[float]:
    """Angles of a robot on level ground, its knee bent, whose swing foot is at x, z."""
    line = -0.3
    way = np.array([math.sin(line), math.cos(line)]) - [x, z]
    lean, half = math.atan2(*way), math.acos(np.hypot(*way) / KneedBiped().leg_length)  # of two links of equal length
    return [line, lean - half, lean + half]
