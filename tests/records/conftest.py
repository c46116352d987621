"""Walks that tests of records share."""

import math

import pytest

import mjbiped
from controllers import AdaptiveController, KneedController


@pytest.fixture(scope="session")
def walk(controller: AdaptiveController) -> mjbiped.Walk:
    return mjbiped.walk(controller, mjbiped.Terrain.mixed(), engine="hybrid", steps=4)


@pytest.fixture(scope="session")
def kneed() -> mjbiped.Walk:
    robot = mjbiped.KneedBiped()
    law = KneedController(robot, mjbiped.find_kneed_gait(robot, math.radians(2.5)))
    ground = mjbiped.Terrain.from_segments([(0.7, -2.0), (9.0, 5.0)])
    return mjbiped.walk(law, ground, engine="hybrid", steps=3)
