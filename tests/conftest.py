"""What many tests share: Table I's robot, its passive gait on 2 degrees, and the paper's controller."""

import math

import pytest

import mjbiped
from controllers import AdaptiveController


@pytest.fixture(scope="session")
def robot() -> mjbiped.Compass:
    return mjbiped.Compass()


@pytest.fixture(scope="session")
def gait(robot: mjbiped.Compass) -> mjbiped.Gait:
    return mjbiped.find_passive_gait(robot, math.radians(2))


@pytest.fixture(scope="session")
def controller(robot: mjbiped.Compass, gait: mjbiped.Gait) -> AdaptiveController:
    return AdaptiveController(robot, gait)
