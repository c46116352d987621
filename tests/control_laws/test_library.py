"""The controller with two references: when it takes which, and that what it feels is the step."""

import math
from collections.abc import Sequence
from dataclasses import replace

import pytest

import mjbiped
from controllers import AdaptiveController, LibraryController
from mjbiped.analysis.replay import recorded_controller, replayed
from mjbiped.controllers.room import CLIMBING


@pytest.fixture(scope="module")
def library(robot: mjbiped.Compass) -> LibraryController:
    return LibraryController(robot, mjbiped.find_reference(robot, clearance=0.04), climbing_steps=3)


def step(library: LibraryController, rise: float, engine: str = "hybrid") -> mjbiped.Walk:
    """Two and a half steps on level ground, a step, and level ground again."""
    edge = 2.5 * library.gait.step_length
    ground = mjbiped.Terrain.from_segments([(edge, 0.0, 0.0), (50.0, 0.0, rise)])
    return mjbiped.walk(library, ground, engine=engine, steps=12)


@pytest.mark.parametrize("rise", [0.05, -0.08])
def test_a_height_change_brings_the_climbing_gait_for_some_steps(library: LibraryController, rise: float) -> None:
    walk = step(library, rise)
    assert walk.outcome == "finished"
    left = [memory[CLIMBING] for _, memory in replayed(walk, library)]
    changes = [
        library.robot.leg_length * (math.cos(q1) - math.cos(q2)) for q1, q2 in walk.touchdowns["q_before"].tolist()
    ]
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


def test_it_survives_treads_that_its_economical_gait_does_not(robot: mjbiped.Compass) -> None:
    """Ten treads of 1 m: a step of 0.05 m up and one of 0.1 m down, then some beyond the economical gait's reach."""
    economical = mjbiped.find_reference(robot, clearance=0.04)
    rises: Sequence[float] = (0.05, -0.1, 0.09, -0.04, 0.09, -0.05, 0.08, -0.09, 0.09, 0.05)
    ground = mjbiped.Terrain.from_segments([(1.0, 0.0, 0.0), *((1.0, 0.0, rise) for rise in rises), (9.0, 0.0, 0.0)])
    both = (
        LibraryController(robot, economical),
        AdaptiveController(robot, economical, replanning="additive"),
    )
    outcomes = [mjbiped.walk(each, ground, engine="hybrid", distance=14.0, steps=60).outcome for each in both]
    assert outcomes == ["finished", "fell"]


def test_a_record_builds_it_anew(library: LibraryController, gait: mjbiped.Gait) -> None:
    walk = step(library, 0.03)
    description = walk.settings["controller"]
    assert description["climbing_gait"]["goal"]["clearance"] == 0.1
    assert description["gait"]["goal"]["clearance"] == 0.04
    assert recorded_controller(walk) == library
    assert library.climbing_gait == mjbiped.find_reference(library.robot, speed=library.gait.speed, clearance=0.1)
    assert replace(library, climbing_gait=gait).climbing_gait is gait
