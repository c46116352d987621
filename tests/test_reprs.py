"""What people print shows itself in one line, however long its tables are."""

import math
from collections.abc import Callable

import numpy as np
import pytest

import mjbiped
from controllers import AdaptiveController
from mjbiped.analysis.stability import stability
from mjbiped.limit_cycles.basin import Basin
from mjbiped.limit_cycles.bifurcation import Cascade

LONGEST = 300  # characters


@pytest.fixture(scope="module")
def comparison(controller: AdaptiveController) -> mjbiped.Comparison:
    return mjbiped.compare(controller, mjbiped.Terrain.mixed(), steps=2)


def assert_one_line(shown: str, beginning: str) -> None:
    assert shown.startswith(beginning)
    assert "\n" not in shown
    assert len(shown) < LONGEST


def test_a_comparison_shows_itself_in_one_line(comparison: mjbiped.Comparison) -> None:
    walked = "finished after 2 steps, 0.756 m"
    assert repr(comparison) == f"<Comparison on mixed: MuJoCo {walked}; hybrid {walked}; they agree>"
    assert str(comparison) == repr(comparison)


def test_theorem_1_shows_itself_in_one_line(comparison: mjbiped.Comparison) -> None:
    assert_one_line(repr(stability(comparison.hybrid)), "<Stability of AdaptiveController over 2 steps: ")


def test_gaits_show_themselves_in_one_line(gait: mjbiped.Gait, controller: AdaptiveController) -> None:
    assert repr(gait) == "<PassiveGait on 2 deg: stable, period 0.764844 s, step 0.377884 m>"
    periodic = mjbiped.find_periodic_gait(gait.robot, gait.slope, gait.start[None])
    assert repr(periodic) == "<PeriodicGait of period 1 on 2 deg: stable>"
    steps = mjbiped.ReturnMap(gait.robot, gait.slope).walk(gait.start, 3)
    assert repr(steps) == "<Steps: walking after 3>"
    assert "\n" not in repr(controller)
    assert repr(gait) in repr(controller)


def test_studies_of_gaits_show_themselves_in_one_line(robot: mjbiped.Compass, gait: mjbiped.Gait) -> None:
    slopes = np.radians(np.linspace(3.0, 6.0, 40))
    diagram = mjbiped.bifurcation_diagram(robot, slopes, steps=20, keep=10)
    assert_one_line(repr(diagram), "<BifurcationDiagram of 40 slopes from 3 to 6 deg, 10 steps each; lost on ")
    cascade = mjbiped.find_cascade(robot, 1)
    assert_one_line(repr(cascade), "<Cascade: periods double on ")
    assert repr(Cascade(robot, (), "nothing was looked for")) == "<Cascade: no period doubles>"
    grid = np.zeros((50, 40))
    basin = Basin(
        slope=gait.slope,
        start=gait.start,
        stance_rates=grid[0],
        swing_rates=grid[:, 0],
        fates=grid.astype(np.int8),
        steps=grid.astype(np.int16),
        peak_torque=grid,
        limit=10,
        walker="passive",
    )
    assert_one_line(repr(basin), "<Basin of passive on 2 deg, 50 x 40 starts: 100 % ")


@pytest.mark.parametrize(
    ("make", "shown"),
    [
        (mjbiped.Terrain.level, "<Terrain level: 1 segment without end>"),
        (mjbiped.Terrain.mixed, "<Terrain mixed: 14 segments without end>"),
        (lambda: mjbiped.Terrain.stairs(count=5000, rise=0.001), "<Terrain stairs (tread=1.8, rise=0.001, "),
        (lambda: mjbiped.Terrain((0.0,), (0.0,), (0.1,), end=3.0), "<Terrain custom: 1 segment up to x = 3 m>"),
        (lambda: mjbiped.Terrain.from_segments([(1.0, 0.0)] * 999), "<Terrain segments (999 segments): 999 "),
    ],
)
def test_a_terrain_shows_itself_in_one_line(make: Callable[[], mjbiped.Terrain], shown: str) -> None:
    assert_one_line(repr(make()), shown)
    assert math.inf == make().end or "up to x" in repr(make())
