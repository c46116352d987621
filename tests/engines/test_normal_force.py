"""What the ground under the stance foot bears, where it would have to pull."""

from __future__ import annotations

import dataclasses
import math

import numpy as np
import pytest
from rich.table import Table

import mjbiped
from controllers import AdaptiveController
from mjbiped.records import measures


@pytest.fixture(scope="module")
def hurried(controller: AdaptiveController) -> AdaptiveController:
    """Re-plans so quickly that the ground would have to pull."""
    return dataclasses.replace(controller, replanning_delay=0.1)


def test_steps_that_pull_are_marked(hurried: AdaptiveController) -> None:
    """Stairs of -60 mm, no faces met: steps 4 and 9 are re-planned in haste."""
    pulled = mjbiped.walk(hurried, mjbiped.Terrain.stairs(), engine="hybrid", steps=9)
    marked = measures.pulls(pulled.touchdowns)
    assert np.flatnonzero(marked).tolist() == [3, 8]
    asked = np.where(marked, np.inf, pulled.touchdowns["friction"])
    assert (measures.friction_asked(pulled.touchdowns) == asked).all()
    summary = measures.summary(pulled)
    assert summary["steps_that_pull"] == 2
    assert summary["least_normal_force_weights"] == pulled.touchdowns["normal_force"].min() / pulled.robot.weight < -0.5
    assert summary["largest_stance_friction"] == math.inf
    table = pulled.summary().__rich__()
    assert isinstance(table, Table)
    assert "unbounded" in [str(cell) for column in table.columns for cell in column.cells]


def test_a_foot_that_leaves_the_ground_bears_nothing(hurried: AdaptiveController) -> None:
    """What the hybrid engine's ground pulls at lifts off in MuJoCo: in the same step, where the walk comes so far."""
    terrain = mjbiped.Terrain.random(seed=1)
    there, here = (mjbiped.walk(hurried, terrain, steps=18, engine=engine) for engine in ("mujoco", "hybrid"))
    lifted, pulls = (np.flatnonzero(measures.pulls(walk.touchdowns)) for walk in (there, here))
    assert pulls.tolist() == [17]
    assert 17 in lifted
    assert (there.touchdowns["normal_force"][lifted] == 0.0).all()
    assert measures.summary(there)["least_normal_force_weights"] == 0.0
    assert math.isfinite(measures.summary(there)["largest_stance_friction"])


def test_a_foot_that_slides_is_told(controller: AdaptiveController) -> None:
    """Without re-planning a step down of 6 cm asks for more friction than there is: a foot slides by 15 mm."""
    unplanned = dataclasses.replace(controller, replanning_delay=None)
    slid, stood = (mjbiped.walk(law, mjbiped.Terrain.stairs(rise=-0.06), steps=4) for law in (unplanned, controller))
    (told,) = slid.warnings
    assert "slid by more than 0.001 leg lengths" in told
    assert slid.warnings[told] == np.count_nonzero(slid.touchdowns["slip"] > 1e-3)
    assert slid.verdict == measures.VIOLATING
    assert (dict(stood.warnings), stood.verdict) == ({}, measures.FINISHED)
