"""Walks that pictures show."""

import pytest

import mjbiped
from controllers import AdaptiveController, PassiveController
from mjbiped import Terrain, Walk
from mjbiped.control.registry import make_controller


@pytest.fixture(scope="session")
def walk() -> Walk:
    return mjbiped.walk(PassiveController(), Terrain.incline(2.0), engine="hybrid", steps=5)


@pytest.fixture(scope="session")
def adaptive(controller: AdaptiveController) -> Walk:
    """A walk with all that can be shown: on a step whose estimate is wrong, with torques and labels in view."""
    ground = Terrain.from_segments([(0.5, 0.0, 0.0), (9.0, 3.0, -0.02)])
    return mjbiped.walk(controller, ground, engine="hybrid", steps=5)


@pytest.fixture(scope="session")
def in_space() -> Walk:
    """A walk over ground that falls ahead and to the left behind a step."""
    robot, ground = mjbiped.Compass3D(), Terrain.from_segments([(0.2, 0.0), (9.0, 3.0, -0.01, 2.0)])
    return mjbiped.walk(make_controller("adaptive", robot, {}), ground, robot=robot, engine="hybrid", steps=3)
