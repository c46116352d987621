"""Robots that begin at rest, legs together: they stand, or fall, as in MuJoCo."""

from typing import Any

import pytest
from simulations import Plain, hybrid_run

import mjbiped
from mjbiped import Disturbances, KneedBiped, RoundKneed, Terrain
from mjbiped.engines.hybrid.gait_step import advance
from mjbiped.robots.robot import Robot
from mjbiped.rules.termination import Outcome


def from_rest(robot: Robot, terrain: Terrain, engine: str, **more: Any) -> mjbiped.Walk:
    return mjbiped.walk(Plain(), terrain, robot=robot, engine=engine, initial="rest", steps=3, **more)


@pytest.mark.parametrize("robot", [KneedBiped(gravity=400.0), KneedBiped(gravity=400.0, sole=(0.05, 0.15))])
def test_knees_stand_where_nothing_moves_them(robot: Robot) -> None:
    """The ground stopped a foot that no motion of the legs could move along the ground's normal: 0 / 0."""
    walk = from_rest(robot, Terrain.random(seed=1), "hybrid")
    assert (walk.outcome, walk.steps) == ("stalled", 0)
    assert not walk.samples["q"].any()
    assert not walk.samples["dq"].any()


@pytest.mark.parametrize("impulse", [5.0, -5.0])
def test_a_push_topples_knees_that_stand(impulse: float) -> None:
    pushes = Disturbances(pushes=((0.02, impulse),))
    exact, stepped = (
        from_rest(KneedBiped(), Terrain.level(), engine, disturbances=pushes) for engine in ("hybrid", "mujoco")
    )
    assert exact.outcome == stepped.outcome == "fell"
    # backwards MuJoCo's contacts hold the feet a little, 0.025 s measured; forwards 4e-4 s
    assert exact.end[0] == pytest.approx(stepped.end[0], abs=0.05)


def test_a_foot_beside_the_other_one_has_not_struck_the_ground_ahead() -> None:
    """On round feet it was ahead by rounding, and the robot was said to have fallen at once."""
    run = hybrid_run(Plain(), Terrain.incline(-3.0), robot=RoundKneed(), q=(0.0,) * 3, dq=(0.0,) * 3)
    run.state.pause = 500
    advance(run.constants, run.state)
    assert run.ended is Outcome.WALKING
    assert -0.1 < run.state.y[0] < -1e-4  # it begins to fall backwards
