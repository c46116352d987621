"""Walks of the adaptive controller: what its estimate of the slope and its errors do from step to step."""

import itertools
import math
from dataclasses import replace
from typing import Any, NamedTuple

import numpy as np

import mjbiped
from controllers import AdaptiveController
from mjbiped.analysis.replay import replayed
from mjbiped.gaits.passive import find_passive_gait
from mjbiped.gaits.reference import motion_at
from mjbiped.robots.compass import Compass

GAIT = find_passive_gait(Compass(), math.radians(2))
PAPER = AdaptiveController(Compass(), GAIT)


class Step(NamedTuple):
    """A step: its errors max |q_r - q| (rad) at both ends, the next slope, and estimates about its touchdown."""

    first_error: float
    last_error: float
    slope: float
    before: float
    after: float
    replanned: bool


def walked(controller: AdaptiveController, *ground: tuple[float, float], steps: int) -> list[Step]:
    """The steps of a walk on segments of some length (m) and slope (degrees)."""
    terrain = mjbiped.Terrain.from_segments([*ground])
    walk = mjbiped.walk(controller, terrain, engine="hybrid", steps=steps)
    rows: dict[str, Any] = dict(walk.touchdowns)
    found = []
    for row, (begun, memory) in enumerate(itertools.islice(replayed(walk, controller), walk.steps)):
        period = rows["time"][row] - begun.time
        first, last = (np.array(controller.reference(memory, t))[:2] for t in (0.0, period))
        errors = np.abs(first - begun.q).max(), np.abs(last - rows["q_before"][row]).max()
        replanned = controller.reference(memory, 0.5 * period) != motion_at(GAIT.tables[0], 0.5 * period)
        slope, before, after = (float(rows[name][row]) for name in ("slope", "slope_estimate_before", "slope_estimate"))
        found.append(Step(float(errors[0]), float(errors[1]), slope, before, after, replanned))
    assert len(found) == steps
    return found


UNEVEN = (0.5, 0.0), (0.7, 3.0), (9.0, -2.0)


def test_on_uneven_ground_the_estimate_follows_every_change_of_slope_at_once() -> None:
    steps = walked(PAPER, *UNEVEN, steps=6)
    assert sorted({round(math.degrees(step.slope), 9) for step in steps}) == [-2.0, 0.0, 3.0]
    for step in steps:
        # with a true estimate (27) gives the true slope; what is left is the integration's error
        assert abs(step.after - step.slope) < 1e-7
        # transitions begin in the measured state, so that nothing is ever off the reference
        assert step.last_error < 1e-7
    assert [step.replanned for step in steps].count(True) == 2  # the step after each change of slope, no other


def test_a_wrong_estimate_is_found_out_by_walking() -> None:
    """Starting with "level" on 3 degrees: the estimate converges by (17), and by (27) keeps its error over a change."""
    steps = walked(PAPER, (0.9, 3.0), (9.0, 1.0), steps=4)
    true = [math.radians(3), *(step.slope for step in steps)]
    errors = [abs(true[0])]
    for step, old, new in zip(steps, true, true[1:], strict=False):
        # (27) neither adds nor takes: exact angles, arcsin's rounding and the integration's error
        assert abs(step.after - new - (step.before - old)) < 1e-7
        errors.append(abs(step.after - new))
    # the paper's gains: each step leaves a fraction of the error (observed 0.04 to 0.22)
    assert all(later < 0.5 * earlier for earlier, later in itertools.pairwise(errors))
    assert errors[-1] < 1e-3
    assert steps[-1].last_error < 0.1 * steps[0].last_error  # tracking heals with the estimate (Theorem 1)
    assert true[-1] == math.radians(1)  # the change was walked over


def test_without_the_update_only_the_adaptive_law_finds_the_new_slope() -> None:
    """Fig. 5 of the paper: both arrive, (27) at once."""
    plain = walked(replace(PAPER, estimate_update=False), (0.5, 0.0), (9.0, 3.0), steps=5)
    change = next(step for step in plain if step.slope > 0)
    assert abs(change.after - change.slope) > 0.04  # the whole 3 degrees are missing
    assert abs(plain[-1].after - plain[-1].slope) < 1e-3  # and gone after three steps
    assert max(step.last_error for step in plain) > 1e-5  # with (27) below 1e-7, see above


def test_without_replanning_the_error_decays_within_the_step() -> None:
    steps = walked(replace(PAPER, replanning_delay=None), *UNEVEN, steps=6)
    changed = [step for step in steps if step.first_error > 0.01]
    assert len(changed) == 2
    for step in changed:
        # z1 obeys z'' + 17 z' + 61 z = 0 while the estimate is true: the slow root is 5.1 / s, and exp(-5.1 T) = 0.02;
        # five times that for the initial rate and the adaptation that the error sets off
        assert step.last_error < 0.1 * step.first_error
    assert abs(steps[-1].after - steps[-1].slope) < 5e-3  # disturbed by the errors (Fig. 6), not lost
