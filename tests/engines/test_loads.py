"""What the ground bears: the centre of pressure stays on the sole, and steps in which it would pull are marked."""

import dataclasses
import math
from typing import Any

import numpy as np
import pytest

import mjbiped
from controllers import AdaptiveController
from mjbiped.records import measures
from mjbiped.records.loads import centre_of_pressure

EXACT = 1e-9  # m, and N m: the law of the record and that of the engine round differently
MUJOCO = 1e-3  # m; the load is that of the step before, which changes by some 0.2 %


@pytest.mark.parametrize(
    ("engine", "pushes"), [("hybrid", ()), ("hybrid", ((0.3, 1.0), (1.1, -1.0))), ("mujoco", ())], ids=str
)
def test_the_centre_of_pressure_reaches_an_end_and_goes_no_farther(engine: str, pushes: Any) -> None:
    robot, (behind, ahead) = mjbiped.Compass(sole=(0.03, 0.05)), (0.03, 0.05)
    law = AdaptiveController(robot, mjbiped.find_passive_gait(robot, slope=np.deg2rad(2)))
    ground, pushed = mjbiped.Terrain.stairs(tread=1.8, rise=-0.01), mjbiped.Disturbances(pushes=pushes)
    walk = mjbiped.walk(law, ground, engine=engine, steps=6, disturbances=pushed if pushes else None)
    steps = walk.touchdowns
    over = max(float(steps["pressure_ahead"].max()) - ahead, float(steps["pressure_behind"].max()) - behind)
    assert abs(over) < (EXACT if engine == "hybrid" else MUJOCO)
    given, asked = walk.samples["torque"][:, 0], walk.samples["ankle_asked"]
    bound = given != asked
    assert bound.any()
    assert not bound.all()
    assert (np.abs(given) <= np.abs(asked)).all()
    share = float(np.mean(bound[walk.samples["time"] < steps["time"][-1]]))
    assert steps["sole_bound_time"][-1] / steps["time"][-1] == pytest.approx(share, abs=0.02)
    if engine == "hybrid" and not pushes:
        places = centre_of_pressure(walk)[:-1]
        ends = np.minimum(np.abs(places + behind), np.abs(places - ahead))
        assert np.nanmax(ends[bound[:-1]]) < EXACT  # where it gives less than is asked, at an end


def test_a_foot_that_leaves_the_ground_bears_nothing(controller: AdaptiveController) -> None:
    """What the ground of the hybrid engine has to pull at, since the law re-plans in haste, lifts off in MuJoCo."""
    terrain, hurried = mjbiped.Terrain.random(seed=1), dataclasses.replace(controller, replanning_delay=0.1)
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
