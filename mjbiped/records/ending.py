"""Why a walk failed, in words: in which step, how the robot was placed, and what was wrong from the start."""

from __future__ import annotations

import math
from collections.abc import Iterator
from typing import TYPE_CHECKING

from mjbiped.errors import MjbipedError
from mjbiped.rules.termination import Outcome

if TYPE_CHECKING:
    from mjbiped.records.record import Walk

_LOST = [outcome.words for outcome in (Outcome.FELL, Outcome.STALLED, Outcome.SLIPPED)]
_FAILURES = [*_LOST, Outcome.DIVERGED.words]
_AT_ONCE = 2  # steps
_ESTIMATE = "initial_slope_estimate"  # setting of the controllers that estimate the slope
_ROLLED = 15.0  # degrees; walks roll by 8
_DEEP = 0.01  # leg lengths; no contact lets a foot come deeper
_FAR_OFF = math.radians(1.0)  # from the slope at the start


def why_it_failed(walk: Walk) -> str:
    """Say in one sentence why a walk failed, as far as its record shows; empty for a walk that did not fail."""
    if walk.outcome not in _FAILURES:
        return ""
    return "; ".join([*_placed(walk), *_without_torques(walk), *_misjudged(walk)])


def unfinished_step(walk: Walk) -> str:
    """Say how the stance foot stood in the step that no touchdown ended; empty unless the walk failed in it."""
    felt = walk.settings.get("unfinished_step")
    if walk.outcome not in _FAILURES or not felt:
        return ""
    weights = felt["normal_force"] / walk.robot.weight
    return (
        f"slip {1e3 * felt['slip']:.4f} mm, stance friction used {felt['friction']:.3f}, "
        f"least normal force {weights:.3f} weights"
    )


def _placed(walk: Walk) -> Iterator[str]:
    """Say where hip and swing foot were when the walk was lost; the swing foot's place is known from samples alone."""
    if walk.outcome not in _LOST:
        return
    foot = float(walk.touchdowns["x"][-1]) if walk.steps else walk.start["x"]
    placed = f"{walk.outcome} in step {walk.steps + 1} with the hip {_apart(walk.end[1] - foot)} the stance foot"
    if len(walk.samples["time"]) and len(walk.robot.bodies.limbs) == 2:
        qpos, stance = walk.samples["qpos"][-1:], int(walk.samples["stance"][-1])
        x, z = map(float, walk.robot.outline(qpos)[0, 1 - stance, -1])
        placed += f", and the swing foot {_apart(x - float(qpos[0, 0]))} the hip"
        depth = walk.terrain.height_at(x) - z
        if depth > _DEEP * walk.robot.leg_length and not walk.robot.collides_from_lift_off:
            placed += f" and {depth:.2f} m under the ground, through which the scuffing rule lets it swing"
    yield placed
    roll = (
        math.degrees(float(walk.samples["q"][-1, -1]))
        if "roll" in walk.robot.angles and len(walk.samples["time"])
        else 0.0
    )
    if abs(roll) > _ROLLED:
        side = "right" if (roll > 0.0) == (walk.samples["stance"][-1] == 1) else "left"
        yield f"it had rolled by {abs(roll):.0f}° to the {side}"


def _apart(distance: float) -> str:
    """Say how far ahead of, or behind, another point a point is, m."""
    return f"{abs(distance):.2f} m {'behind' if distance < 0.0 else 'ahead of'}"


def _without_torques(walk: Walk) -> Iterator[str]:
    """Say whether the ground under the last stance foot has a passive gait, and a stable one, if no motor acted."""
    from mjbiped.gaits.described import passive_gait_of  # what searches for gaits loads slowly

    if walk.peak_torque.any() or any(walk.terrain.lateral) or walk.terrain.surface is not None:
        return
    slope = walk.terrain.slope_at(float(walk.touchdowns["x"][-1]) if walk.steps else walk.start["x"])
    place = f"a slope of {math.degrees(slope):.3g}°"
    try:
        gait = passive_gait_of(walk.robot, slope)
    except MjbipedError:
        yield f"no passive gait is found on {place}"
        return
    if not gait.stable:
        growth = abs(gait.multipliers[0])
        yield f"the passive gait on {place} is unstable: a small disturbance grows {growth:.2f} times in each step"


def _misjudged(walk: Walk) -> Iterator[str]:
    """Say of a walk that failed at once what was wrong with the slope estimate that its controller was given."""
    estimate = walk.settings["controller"].get(_ESTIMATE)
    if estimate is None or walk.steps > _AT_ONCE:
        return
    slope = walk.terrain.slope_at(0.0)
    if abs(slope - estimate) >= _FAR_OFF:
        degrees = math.degrees(slope)
        yield (
            f"it starts on {degrees:.1f}° with a slope estimate of {math.degrees(estimate):.1f}°; give "
            f"--initial-slope-estimate-deg {degrees:.3g}, in Python {_ESTIMATE}={slope:.4g}"
        )
