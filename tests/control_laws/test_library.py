"""The controller with two references: when it takes which, and that what it feels is the step."""

import math

import pytest

import mjbiped
from controllers import LibraryController
from mjbiped.analysis.replay import replayed
from mjbiped.controllers.room import CLIMBING


@pytest.fixture(scope="module")
def library(robot: mjbiped.Compass) -> LibraryController:
    return LibraryController(robot, mjbiped.find_reference(robot, clearance=0.04), climbing_steps=3)


@pytest.mark.parametrize("rise", [0.05, -0.08])
def test_a_height_change_brings_the_climbing_gait_for_some_steps(library: LibraryController, rise: float) -> None:
    """Two and a half steps on level ground, a step, and level ground again."""
    edge = 2.5 * library.gait.step_length
    ground = mjbiped.Terrain.from_segments([(edge, 0.0, 0.0), (50.0, 0.0, rise)])
    walk = mjbiped.walk(library, ground, engine="hybrid", steps=12)
    assert walk.outcome == "finished"
    left = [memory[CLIMBING] for _, memory in replayed(walk, library)]
    changes = [library.robot.leg_length * (math.cos(q1) - math.cos(q2)) for q1, q2 in walk.touchdowns["q_before"]]
    # on level ground the old one's normal is vertical: what is felt is the step, to the touchdown's accuracy
    assert max(changes, key=abs) == pytest.approx(rise, abs=1e-9)
    at = left.index(3.0)
    assert left[: at + 5] == [*[0.0] * at, 3.0, 2.0, 1.0, 0.0, 0.0]
    for (_, memory), count in zip(replayed(walk, library), left, strict=True):
        expected = library.climbing_gait if count else library.gait
        assert expected is not None
        after = 0.95 * expected.period  # past the transition
        q, dq, ddq = expected.reference(after)
        assert library.reference(list(memory), after) == (*q, *dq, *ddq)
