"""Walks, gaits and studies that figures show, each made once."""

import math

import numpy as np
import pytest

import mjbiped
from controllers import AdaptiveController, PassiveController
from mjbiped.analysis.stability import Stability, stability
from mjbiped.control.registry import make_controller
from mjbiped.limit_cycles.basin import Basin, basin_of_attraction
from mjbiped.limit_cycles.bifurcation import BifurcationDiagram, Cascade, bifurcation_diagram, find_cascade


@pytest.fixture(scope="session")
def ground() -> mjbiped.Terrain:
    return mjbiped.Terrain.from_segments([(0.6, 0.0), (0.8, 2.0, -0.02), (2.0, -1.0)])


@pytest.fixture(scope="session")
def law(robot: mjbiped.Compass, gait: mjbiped.PassiveGait) -> AdaptiveController:
    return AdaptiveController(robot, gait, initial_slope_estimate=math.radians(3))


@pytest.fixture(scope="session")
def walk(law: AdaptiveController, ground: mjbiped.Terrain) -> mjbiped.Walk:
    return mjbiped.walk(law, ground, engine="hybrid", steps=5, sample_period=0.01)


@pytest.fixture(scope="session")
def long_walk(law: AdaptiveController, ground: mjbiped.Terrain) -> mjbiped.Walk:
    return mjbiped.walk(law, ground, engine="hybrid", steps=20, sample_period=0.01)


@pytest.fixture(scope="session")
def fallen() -> mjbiped.Walk:
    """A fall without a single touchdown, by a controller without an estimate."""
    return mjbiped.walk(PassiveController(), mjbiped.Terrain.level(), engine="hybrid", initial=(-0.2, 0.2, 0.2, 0.8))


@pytest.fixture(scope="session")
def kneed_walk() -> mjbiped.Walk:
    start, robot = (-0.24, 0.24, 0.24, 1.10, 0.33, 0.33), mjbiped.KneedBiped()
    ground = mjbiped.Terrain.incline(2.5)
    return mjbiped.walk(PassiveController(), ground, robot=robot, engine="hybrid", initial=start, steps=2)


@pytest.fixture(scope="session")
def kneed_gait() -> mjbiped.Gait:
    return mjbiped.find_kneed_gait(mjbiped.KneedBiped(), math.radians(2.5))


@pytest.fixture(scope="session")
def reference(robot: mjbiped.Compass) -> mjbiped.Gait:
    return mjbiped.find_reference(robot, clearance=0.06)


@pytest.fixture(scope="session")
def compared(law: AdaptiveController, ground: mjbiped.Terrain) -> mjbiped.Comparison:
    return mjbiped.compare(law, ground, steps=2)


@pytest.fixture(scope="session")
def compared_falls(robot: mjbiped.Compass) -> mjbiped.Comparison:
    start = (-0.2, 0.2, 0.2, 0.8)
    return mjbiped.compare(PassiveController(), mjbiped.Terrain.level(), robot=robot, initial=start, steps=2)


@pytest.fixture(scope="session")
def diagram(robot: mjbiped.Compass) -> BifurcationDiagram:
    return bifurcation_diagram(robot, np.radians(np.linspace(2.6, 3.7, 12)), steps=60, keep=20)


@pytest.fixture(scope="session")
def cascade(robot: mjbiped.Compass) -> Cascade:
    return find_cascade(robot, 2)


@pytest.fixture(scope="session")
def maps(robot: mjbiped.Compass) -> list[Basin]:
    return [
        basin_of_attraction(robot, math.radians(2), stance_rates=np.linspace(*a, 9), swing_rates=np.linspace(*b, 8))
        for a, b in (((0.9, 1.3), (-0.5, 1.5)), ((0.5, 2.0), (-2.0, 3.0)))
    ]


@pytest.fixture(scope="session")
def evaluated(robot: mjbiped.Compass, gait: mjbiped.PassiveGait) -> dict[str, Stability]:
    """Of a walk without an estimate that is too steep, and of one without any error."""
    ground, start = mjbiped.Terrain.from_segments([(0.6, 0.0), (9.0, -1.5)]), math.radians(2)
    blind = AdaptiveController(robot, gait, initial_slope_estimate=start, estimate_update=False, replanning_delay=None)
    exact = mjbiped.walk(AdaptiveController(robot, gait), mjbiped.Terrain.level(), engine="hybrid", steps=1)
    wrong = mjbiped.walk(blind, ground, engine="hybrid", steps=4, sample_period=0.01)
    return {"a walk": stability(wrong), "exact": stability(exact)}


@pytest.fixture(scope="session")
def walk_in_space() -> mjbiped.Walk:
    """Two steps over ground that falls to the left."""
    robot = mjbiped.Compass3D()
    law, ground = make_controller("adaptive", robot, {}), mjbiped.Terrain.level(lateral_deg=1.0)
    return mjbiped.walk(law, ground, robot=robot, engine="hybrid", steps=2, sample_period=0.02)
