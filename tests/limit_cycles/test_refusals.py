"""What maps, gaits, basins and diagrams do not take, by name, and robots without a gait."""

from __future__ import annotations

import math
from collections.abc import Callable

import pytest

import mjbiped
from controllers import PassiveController
from mjbiped import Compass, GaitError, InputError, KneedBiped, RimlessWheel, RoundKneed, ScuffingRule
from mjbiped.limit_cycles.basin import basin_of_attraction, basin_of_control
from mjbiped.limit_cycles.bifurcation import bifurcation_diagram, find_cascade
from mjbiped.limit_cycles.periodic import find_periodic_gait
from mjbiped.limit_cycles.return_map import ReturnMap

ROBOT, KNEED = Compass(), KneedBiped()
BENT, BENDING = [-0.2, 0.2, 0.3, 1.0, 0.5, 0.5], [-0.3, 0.3, 0.3, 1.0, 0.5, 0.6]
FORWARDS, FAR = [-0.3, 0.3, 0.3, 1.0, 0.5, 0.4], ScuffingRule(reach=0.3)
START = mjbiped.find_passive_gait(ROBOT, 0.03).start


@pytest.mark.parametrize(
    ("error", "words", "call"),
    [
        (InputError, "^state", lambda: ReturnMap(ROBOT, 0.03).walk([1, 2, 3, math.nan], 1)),
        (InputError, "^state", lambda: ReturnMap(KNEED, 0.03).walk(BENT, 1)),
        (InputError, "^state", lambda: ReturnMap(KNEED, 0.03).walk(BENDING, 1)),
        (InputError, "^state", lambda: ReturnMap(RoundKneed(), 0.03).walk(FORWARDS, 1)),
        (InputError, r"shape \(n, 4\)", lambda: find_periodic_gait(ROBOT, 0.03, [0, 0, 0, 0])),
        (GaitError, "falls or stalls", lambda: find_periodic_gait(ROBOT, 0.03, [[-0.2, 0.2, 0.0, 0.0]])),
        (GaitError, "repeats itself sooner", lambda: find_periodic_gait(ROBOT, 0.03, [START, START])),
        (InputError, "stance_rates", lambda: basin_of_attraction(ROBOT, 0.03, stance_rates=[1.0, 0.5])),
        (InputError, "threads", lambda: basin_of_attraction(ROBOT, 0.03, threads=0)),
        (InputError, "scuffing", lambda: basin_of_attraction(KNEED, 0.0436, scuffing=FAR)),
        (GaitError, "gait", lambda: basin_of_attraction(ROBOT, -0.1)),
        (InputError, "imitates no gait", lambda: basin_of_control(PassiveController())),
        (InputError, "0.0 in it: must be numbers from 1e-12", lambda: bifurcation_diagram(ROBOT, [0.0, 0.1])),
        (InputError, "ascend", lambda: bifurcation_diagram(ROBOT, [0.05, 0.04])),
        (InputError, "keep = 2.5: must be", lambda: bifurcation_diagram(ROBOT, [0.05], keep=2.5)),  # type: ignore[arg-type]
        (InputError, "not be more than the 10", lambda: bifurcation_diagram(ROBOT, [0.05], steps=10, keep=11)),
        (InputError, "a RimlessWheel has no swing leg", lambda: bifurcation_diagram(RimlessWheel(), [0.03])),
        (InputError, "scuffing is for straight", lambda: bifurcation_diagram(KNEED, [0.04], scuffing=FAR)),
        pytest.param(
            GaitError, r"0\.1 degrees", lambda: find_cascade(Compass(leg_inertia=50.0)), marks=pytest.mark.slow
        ),
    ],
)
def test_what_is_no_input_is_refused(error: type[Exception], words: str, call: Callable[[], object]) -> None:
    with pytest.raises(error, match=words):
        call()
