"""Passive walks whose records are read by other programs."""

import pytest
from foreign_models import DOWNHILL

import mjbiped
from mjbiped.control.controller import Unpowered

SLOW = ("wheel", "round")  # which compile engines of their own
NAMES = [pytest.param(name, marks=pytest.mark.slow) if name in SLOW else name for name in DOWNHILL]


@pytest.fixture(scope="package", params=NAMES)
def walk(request: pytest.FixtureRequest) -> mjbiped.Walk:
    robot, slope_deg = DOWNHILL[request.param]
    return mjbiped.walk(Unpowered(), mjbiped.Terrain.incline(slope_deg), robot=robot, steps=3, engine="hybrid")
