"""Walks of the adaptive controller: what its estimate of the slope and its errors do from step to step."""

import itertools
import math
from dataclasses import replace

import numpy as np

import mjbiped
from controllers import AdaptiveController
from mjbiped.analysis.replay import replayed
from mjbiped.gaits.passive import find_passive_gait
from mjbiped.gaits.reference import motion_at
from mjbiped.robots.compass import Array, Compass

GAIT = find_passive_gait(Compass(), math.radians(2))
PAPER = AdaptiveController(Compass(), GAIT)
UNEVEN = (0.5, 0.0), (0.7, 3.0), (9.0, -2.0)


def walked(controller: AdaptiveController, *ground: tuple[float, float], steps: int) -> tuple[mjbiped.Walk, Array, int]:
    """A walk on segments of some length (m) and slope (degrees).

    Returns:
        The walk; the errors max |q_r - q| at both ends of each step, shape (steps, 2), rad; how many steps were planned
        anew.
    """
    walk = mjbiped.walk(controller, mjbiped.Terrain.from_segments([*ground]), engine="hybrid", steps=steps)
    errors, replanned, half = [], 0, 0.35
    for row, (begun, memory) in enumerate(itertools.islice(replayed(walk, controller), steps)):
        ends = (0.0, begun.q), (walk.touchdowns["time"][row] - begun.time, walk.touchdowns["q_before"][row])
        errors.append([np.abs(np.array(controller.reference(memory, float(t))[:2]) - q).max() for t, q in ends])
        replanned += controller.reference(memory, half) != motion_at(GAIT.tables[0], half)
    return walk, np.array(errors), replanned


def test_on_uneven_ground_the_estimate_follows_every_change_of_slope_at_once() -> None:
    walk, errors, replanned = walked(PAPER, *UNEVEN, steps=6)
    assert set(np.degrees(walk.touchdowns["slope"]).round(9)) == {-2.0, 0.0, 3.0}
    # with a true estimate (27) gives the true slope; what is left is the integration's error
    np.testing.assert_allclose(walk.touchdowns["slope_estimate"], walk.touchdowns["slope"], rtol=0, atol=1e-7)
    # transitions begin in the measured state, so that nothing is ever off the reference
    assert errors[:, 1].max() < 1e-7
    assert replanned == 2  # the step after each change of slope, no other


def test_a_wrong_estimate_is_found_out_by_walking() -> None:
    """Starting with "level" on 3 degrees: the estimate converges by (17), and by (27) keeps its error over a change."""
    walk, errors, _ = walked(PAPER, (0.9, 3.0), (9.0, 1.0), steps=4)
    rows, true = walk.touchdowns, np.append(math.radians(3), walk.touchdowns["slope"])
    after = rows["slope_estimate"] - true[1:]
    # (27) neither adds nor takes: exact angles, arcsin's rounding and the integration's error
    np.testing.assert_allclose(after, rows["slope_estimate_before"] - true[:-1], rtol=0, atol=1e-7)
    left = np.abs(np.append(true[0], after))
    assert (left[1:] < 0.5 * left[:-1]).all()  # the paper's gains leave a fraction of it (observed 0.04 to 0.22)
    assert left[-1] < 1e-3
    assert errors[-1, 1] < 0.1 * errors[0, 1]  # tracking heals with the estimate (Theorem 1)
    assert true[-1] == math.radians(1)  # the change was walked over


def test_without_the_update_only_the_adaptive_law_finds_the_new_slope() -> None:
    """Fig. 5 of the paper: both arrive, (27) at once."""
    walk, errors, _ = walked(replace(PAPER, estimate_update=False), (0.5, 0.0), (9.0, 3.0), steps=5)
    left = np.abs(walk.touchdowns["slope_estimate"] - walk.touchdowns["slope"])
    assert left[np.argmax(walk.touchdowns["slope"] > 0)] > 0.04  # the whole 3 degrees are missing
    assert left[-1] < 1e-3  # and gone after three steps
    assert errors[:, 1].max() > 1e-5  # with (27) below 1e-7, see above


def test_without_replanning_the_error_decays_within_the_step() -> None:
    walk, errors, _ = walked(replace(PAPER, replanning_delay=None), *UNEVEN, steps=6)
    first, last = errors[errors[:, 0] > 0.01].T
    assert len(first) == 2
    # z1 obeys z'' + 17 z' + 61 z = 0 while the estimate is true: the slow root is 5.1 / s, and exp(-5.1 T) = 0.02;
    # five times that for the initial rate and the adaptation that the error sets off
    assert (last < 0.1 * first).all()
    left = walk.touchdowns["slope_estimate"] - walk.touchdowns["slope"]
    assert abs(left[-1]) < 5e-3  # disturbed by the errors (Fig. 6), not lost
