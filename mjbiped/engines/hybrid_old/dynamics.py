"""Motion between touchdowns: rates of a state, one integration step, and its dense output."""

from __future__ import annotations

import math
from typing import Any

from mjbiped.engines.hybrid.stance import bear, on_sole, push_torque
from mjbiped.engines.hybrid.state import Walk, hand_over
from mjbiped.numerics.dormand_prince import STAGES, STAGES_WITH_DENSE, dense_at

WILDEST_ANGLE = 1e6  # beyond it, rad, the motion has no meaning, and sine and cosine no digits


def rates(s: Walk, t: float, state: tuple[float, ...]) -> tuple[float, ...]:
    """Rates of a state at time t since the support transfer, by the controller's law and the robot's equations."""
    laws, w = s.laws, s.w
    q, dq = laws.q(state), laws.dq(state)
    hand_over(s, state)
    push = 0.0
    for angle in q:
        if not abs(angle) < WILDEST_ANGLE:
            push = math.nan
    if push != 0.0:
        q = dq = laws.still(state)
    given = laws.torque(s.law, w.memory, min(max(t, w.after), w.before), laws.told(q), laws.told_rates(dq))
    if s.c.behind < math.inf:
        w.asked[w.stage] = given[0]
        given, w.normals[w.stage] = on_sole(s, state, q, dq, given)
    if w.push != 0.0:
        push += push_torque(s, q[0])
    accelerations = laws.accelerations(s.c.robot, w, q, dq, given, push)
    if s.c.toe > 0.0:
        bear(s, state, q, given, accelerations)
    joints = len(w.peak_torque)
    for joint in range(joints):
        w.torques[w.stage * joints + joint] = given[joint]
    w.stage += 1
    # Numba adds tuples, but cannot unpack them into another
    return dq + accelerations + laws.own(given) + laws.powers(given, dq)  # type: ignore[no-any-return]


def begin(s: Walk) -> None:
    """Compute the rates of the state in `w.y`, which no step has led to."""
    s.w.stage = 0
    s.laws.begin(rates, s, s.w.elapsed, s.w.y, s.w.k)


def attempt(s: Walk, h: float) -> float:
    """Integrate one step of length h from `w.y` to `w.out`; the rates at its start stand in `w.k` already.

    Returns:
        The estimated error over the tolerance; NaN where the motion has no meaning.
    """
    w = s.w
    w.has_dense, w.stage = False, 1
    w.evaluations += STAGES
    return float(s.laws.step(rates, s, w.elapsed, h, w.y, w.k, w.out, s.c.tolerance, s.c.tested))


def carry_over(w: Any) -> None:
    """Let the rates and torques at the end of a step be those at the start of the next."""
    n, joints = len(w.y), len(w.peak_torque)
    for component in range(n):
        w.k[component] = w.k[STAGES * n + component]
    for joint in range(joints):
        w.torques[joint] = w.torques[STAGES * joints + joint]
    w.asked[0], w.normals[0] = w.asked[STAGES], w.normals[STAGES]
    w.moments[0], w.margins[0] = w.moments[STAGES], w.margins[STAGES]


def ensure_dense(s: Walk, h: float) -> None:
    """Compute the step's dense output, unless it is there; forces of contacts stay those at the step's end."""
    w = s.w
    if w.has_dense:
        return
    press, stop_press = w.press, w.stop_press
    s.laws.dense(rates, s, w.elapsed, h, w.y, w.k, w.out, w.dense)
    w.press, w.stop_press = press, stop_press
    w.has_dense = True
    w.evaluations += STAGES_WITH_DENSE - STAGES - 1


def is_motion(s: Walk, state: Any) -> bool:
    """Whether angles and rates are numbers."""
    total = 0.0
    for component in range(2 * len(s.w.strike_q)):
        total += state[component]
    return math.isfinite(total)


def component_at(w: Any, component: int, x: float) -> float:
    """One component of the state at the share x of the step."""
    return dense_at(w.dense, len(w.y), component, w.y[component], x)


def dense_state(s: Walk, x: float) -> None:
    """Write the state at the share x of the step into `w.spare`."""
    w = s.w
    for component in range(len(w.y)):
        w.spare[component] = component_at(w, component, x)
