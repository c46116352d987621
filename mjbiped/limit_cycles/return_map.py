"""The return map of the unpowered robot on a plane: from just after one impact to just after the next (eq. 1-4).

It is the hybrid engine's walk without a controller, on a plane, and without a record: the same laws and scuffing rule,
in fixed integration steps, some fifteen to a gait step, so that its result depends smoothly on the state. That makes it
fit for Newton's method, and fast enough for diagrams of a million steps. docs/gaits.md has its accuracy.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from functools import cache, cached_property, lru_cache
from typing import Any, NamedTuple

import numpy as np
import scipy
from numpy.typing import ArrayLike

from mjbiped.numerics.dormand_prince import STAGES, unrolled
from mjbiped.numerics.jit import Function, compiled
from mjbiped.robots.compass import Array, Compass, Constants, acceleration, impact_rates, mass_terms
from mjbiped.rules.scuffing import ScuffingRule, swing_foot_collides
from mjbiped.rules.termination import FALLEN_HIP, STALL_TIME, Outcome
from mjbiped.utils import domains

STEP = 0.3
"""Integration step times the fastest rate of the motion: 50 ms for Table I's gait on 2 degrees."""

FINEST = 1e-4  # of the stall time: no integration step is shorter, however fast the legs
SHORTEST = 1e-3  # of an integration step: events are not searched for in intervals shorter than this
ROOM = 2.0  # the foot is allowed this many times the acceleration that it has at an integration step's ends
TAYLOR = 1e-6  # a touchdown known so closely, in shares of an integration step, is brought home by a Taylor series
SETTLED = -1  # beside the engines' outcomes
TOUCHDOWN, FELL, STALLED, DIVERGED = (
    int(outcome) for outcome in (Outcome.WALKING, Outcome.FELL, Outcome.STALLED, Outcome.DIVERGED)
)


class Plane(NamedTuple):
    """Robot, plane and rules in plain numbers.

    Attributes:
        constants: Of the robot.
        length: Of a leg, m.
        gravity: m/s^2.
        sine: Of the slope.
        cosine: Of the slope.
        reach: Of the scuffing rule, m.
        delay: Of the scuffing rule, s.
        rate: The fastest rate of the linearised motion, 1/s.
        stall_time: Longest time without touchdown, s.
    """

    constants: Constants
    length: float
    gravity: float
    sine: float
    cosine: float
    reach: float
    delay: float
    rate: float
    stall_time: float


class Integration(NamedTuple):
    """The unrolled integrator's functions; see `mjbiped.numerics.dormand_prince.Integrator`."""

    begin: Callable[..., None]
    step: Callable[..., float]


class Work(NamedTuple):
    """Working memory of one walk, for compiled code does not allocate any.

    Attributes:
        y: The state (q1, q2, dq1, dq2).
        k: Rates at the stages of an integration step.
        out: State at its end.
        curve: Angles within it, as polynomials.
    """

    y: Any
    k: Any
    out: Any
    curve: Any


def rates(
    constants: Constants,
    sine: float,
    cosine: float,
    t: float,  # noqa: ARG001 (the integrator's)
    state: tuple[float, ...],
) -> tuple[float, float, float, float]:
    """Rates of a state (q1, q2, dq1, dq2) of the unpowered motion, whatever the time."""
    q1, q2, dq1, dq2 = state[0], state[1], state[2], state[3]
    ddq1, ddq2 = acceleration(constants, q1, q2, dq1, dq2, sine, cosine, 0.0, 0.0)
    return dq1, dq2, ddq1, ddq2


def integrate(use: Integration, plane: Plane, h: float, work: Work) -> None:
    """One Runge-Kutta step of order 8 from `work.y` to `work.out`; the rates at its start stand in `work.k` already."""
    use.step(rates, plane.constants, plane.sine, plane.cosine, 0.0, h, work.y, work.k, work.out, 1.0)


def swing_foot(plane: Plane, q1: float, q2: float) -> tuple[float, float]:
    """The swing foot's horizontal distance ahead of the stance foot and its height along the plane's normal, m."""
    along = plane.length * (math.sin(q1) - math.sin(q2))
    height = plane.length * (math.cos(q1) - math.cos(q2))
    return along * plane.cosine + height * plane.sine, height


def fit(h: float, work: Work) -> None:
    """Polynomials of degree 5 in the share of the step, of q1 and q2, from angle, rate and acceleration at its ends."""
    y, k, out, curve = work.y, work.k, work.out, work.curve
    for leg in range(2):
        c0, c1, c2 = y[leg], h * y[2 + leg], 0.5 * h * h * k[2 + leg]
        d0 = out[leg] - (c0 + c1 + c2)
        d1 = h * out[2 + leg] - (c1 + 2.0 * c2)
        d2 = h * h * k[4 * STAGES + 2 + leg] - 2.0 * c2
        at = 6 * leg
        curve[at], curve[at + 1], curve[at + 2] = c0, c1, c2
        curve[at + 3] = 10.0 * d0 - 4.0 * d1 + 0.5 * d2
        curve[at + 4] = -15.0 * d0 + 7.0 * d1 - d2
        curve[at + 5] = 6.0 * d0 - 3.0 * d1 + 0.5 * d2


def angle_at(work: Work, leg: int, x: float) -> float:
    """An angle at the share x of the step."""
    c, at = work.curve, 6 * leg
    return float(c[at] + x * (c[at + 1] + x * (c[at + 2] + x * (c[at + 3] + x * (c[at + 4] + x * c[at + 5])))))


def foot_at(plane: Plane, work: Work, x: float) -> tuple[float, float]:
    """`swing_foot` at the share x of the step."""
    return swing_foot(plane, angle_at(work, 0, x), angle_at(work, 1, x))


def nothing_happens(
    plane: Plane, armed: bool, room: float, ahead: float, height: float, then_ahead: float, then_height: float
) -> bool:
    """Whether a foot that strays at most `room` from the straight line between two places has met nothing."""
    if armed:
        return min(height, then_height) > room
    return max(ahead, then_ahead) + room < plane.reach or max(height, then_height) + room < 0.0


def search(plane: Plane, work: Work, armed: bool, t: float, h: float, bound: float, until: float) -> tuple[bool, float]:
    """Look for the touchdown in the step from time t on, up to the share `until`.

    Returns:
        Whether the foot collides at the end, and the share of the touchdown; a share of 2 for none.
    """
    x = 0.0
    if not armed:
        x = max(0.0, (plane.delay - t) / h)
        if x >= until:
            return False, 2.0
    ahead, height = foot_at(plane, work, x)
    while x < until:
        end = until
        while True:
            then_ahead, then_height = foot_at(plane, work, end)
            width = (end - x) * h
            if nothing_happens(plane, armed, bound * width * width, ahead, height, then_ahead, then_height):
                break
            if end - x < SHORTEST:
                if armed and then_height <= 0.0:
                    return True, crossing(plane, work, x, height, end, then_height)
                armed = armed or swing_foot_collides(plane.reach, plane.delay, t + end * h, then_ahead, then_height)
                break
            end = 0.5 * (x + end)
        x, ahead, height = end, then_ahead, then_height
    return armed, 2.0


def crossing(plane: Plane, work: Work, low: float, above: float, high: float, below: float) -> float:
    """The share between two others at which the foot passes through the ground, by the Illinois method."""
    x = high
    for _ in range(50):
        x = high - below * (high - low) / (below - above)
        height = foot_at(plane, work, x)[1]
        if abs(height) <= 1e-15 * plane.length or high - low < 1e-14:
            break
        if height <= 0.0:
            high, below = x, height
            above *= 0.5
        else:
            low, above = x, height
            below *= 0.5
    return x


def fall(work: Work) -> float:
    """The share of the step at which the hip has sunk to where the robot has fallen."""
    low, high = 0.0, 1.0
    while high - low > 1e-9:
        middle = 0.5 * (low + high)
        if math.cos(angle_at(work, 0, middle)) < FALLEN_HIP:
            high = middle
        else:
            low = middle
    return high


def land(use: Integration, plane: Plane, h: float, share: float, work: Work) -> float:
    """Integrate from `work.y` to the touchdown, which is near a share of the step h; returns the time that takes.

    Newton's method on steps of the full order, and at last two terms of the Taylor series.
    """
    k, out = work.k, work.out
    time = share * h
    for _ in range(6):
        integrate(use, plane, time, work)
        height = swing_foot(plane, out[0], out[1])[1]
        speed = plane.length * (math.sin(out[1]) * out[3] - math.sin(out[0]) * out[2])
        if speed >= 0.0 or abs(height) > 1e-3 * h * abs(speed):
            break  # it grazes: the crossing that was found stands
        change = -height / speed
        time += change
        if abs(change) < TAYLOR * h:
            for c in range(4):
                out[c] += change * k[4 * STAGES + c]
            out[0] += 0.5 * change * change * k[4 * STAGES + 2]
            out[1] += 0.5 * change * change * k[4 * STAGES + 3]
            break
    return time


def gait_step(use: Integration, plane: Plane, work: Work) -> tuple[float, int]:
    """Walk from just after one impact, in `work.y`, to just after the next, which then stands there.

    Returns:
        The period, s, and `TOUCHDOWN`; or the time and what became of the robot else.
    """
    y, k, out = work.y, work.k, work.out
    step = max(STEP / (plane.rate + max(abs(y[2]), abs(y[3]))), FINEST * plane.stall_time)
    t, armed = 0.0, False
    use.begin(rates, plane.constants, plane.sine, plane.cosine, 0.0, y, k)
    ahead, height = swing_foot(plane, y[0], y[1])
    while t < plane.stall_time:
        h = min(step, plane.stall_time - t)
        integrate(use, plane, h, work)
        if not (abs(out[0]) < 1e6 and abs(out[1]) < 1e6 and math.isfinite(out[2] + out[3])):
            return t, DIVERGED
        fallen = math.cos(out[0]) < FALLEN_HIP
        then_ahead, then_height = swing_foot(plane, out[0], out[1])
        if armed or t + h > plane.delay or fallen:
            end = 4 * STAGES
            fastest = max(
                abs(k[2]) + abs(k[3]) + y[2] * y[2] + y[3] * y[3],
                abs(k[end + 2]) + abs(k[end + 3]) + out[2] * out[2] + out[3] * out[3],
            )
            bound = (ROOM * plane.length * fastest + plane.gravity) / 8.0
            if fallen or not nothing_happens(plane, armed, bound * h * h, ahead, height, then_ahead, then_height):
                fit(h, work)
                until = fall(work) if fallen else 1.0
                armed, share = search(plane, work, armed, t, h, bound, until)
                if share <= 1.0:
                    t += land(use, plane, h, share, work)
                    dq1, dq2 = impact_rates(plane.constants, out[0], out[1], out[2], out[3])
                    y[0], y[1], y[2], y[3] = out[1], out[0], dq1, dq2
                    return t, TOUCHDOWN
                if fallen:
                    return t + until * h, FELL
        t += h
        ahead, height = then_ahead, then_height
        for c in range(4):
            y[c] = out[c]
            k[c] = k[4 * STAGES + c]
    return t, STALLED


class Batch(NamedTuple):
    """Walks to be walked, and what comes of them.

    Attributes:
        starts: First states, shape (walks, 4).
        limit: Steps at most.
        goals: States near which a walk is settled and ends, shape (n, 4); n may be 0.
        near: How near to one of them, shape (4,).
        states: Last states after impacts, shape (walks, room, 4): step n stands in row n % room.
        periods: Of the same steps, shape (walks, room), s.
        counts: Steps walked, shape (walks,).
        outcomes: `SETTLED`, `TOUCHDOWN` for a walk that reached the limit, or what became of the robot, shape (walks,).
    """

    starts: Any
    limit: int
    goals: Any
    near: Any
    states: Any
    periods: Any
    counts: Any
    outcomes: Any


def walk_batch(use: Integration, plane: Plane, work: Work, batch: Batch) -> None:
    """Walk each walk of a batch, and fill in the rest of it."""
    room = batch.states.shape[1]
    for walk in range(len(batch.starts)):
        for c in range(4):
            work.y[c] = batch.starts[walk, c]
        n, outcome = 0, TOUCHDOWN
        while True:
            if is_near(work.y, batch.goals, batch.near):
                outcome = SETTLED
            if outcome != TOUCHDOWN or n == batch.limit:
                break
            period, outcome = gait_step(use, plane, work)
            if outcome == TOUCHDOWN:
                batch.periods[walk, n % room] = period
                for c in range(4):
                    batch.states[walk, n % room, c] = work.y[c]
                n += 1
        batch.counts[walk], batch.outcomes[walk] = n, outcome


def is_near(y: Any, goals: Any, near: Any) -> bool:
    """Whether a state is near a goal in every component."""
    for goal in range(len(goals)):
        inside = True
        for c in range(4):
            inside = inside and abs(y[c] - goals[goal, c]) < near[c]
        if inside:
            return True
    return False


def walk_all(
    plane: Plane, starts: Array, limit: int, room: int = 1, goals: Array | None = None, near: Array | None = None
) -> Batch:
    """Walk from many states by compiled code, which lets other threads run; see `Batch`."""
    walks = len(starts)
    batch = Batch(
        starts=starts,
        limit=limit,
        goals=np.empty((0, 4)) if goals is None else goals,
        near=np.zeros(4) if near is None else near,
        states=np.empty((walks, room, 4)),
        periods=np.empty((walks, room)),
        counts=np.empty(walks, dtype=np.int64),
        outcomes=np.empty(walks, dtype=np.int64),
    )
    work = Work(np.empty(4), np.empty(4 * (STAGES + 1)), np.empty(4), np.empty(12))
    _machine_code()(plane, work, batch)
    return batch


@cache
def _machine_code() -> Function:
    integrator = unrolled(4, untested=0, arguments=("constants", "sine", "cosine"))
    return compiled(walk_batch, Integration, (integrator.begin, integrator.step), inlined=(rates,))


@lru_cache(maxsize=4096)
def plane_of(robot: Compass, slope: float, scuffing: ScuffingRule) -> Plane:
    """What the compiled functions take for a robot on a plane under a rule."""
    m11, m12, m22 = mass_terms(robot.constants, 0.0, 0.0)
    fastest = scipy.linalg.eigvalsh(
        np.diag([-robot.constants[3], robot.constants[4]]), np.array([[m11, m12], [m12, m22]])
    )
    return Plane(
        constants=robot.constants,
        length=robot.leg_length,
        gravity=robot.gravity,
        sine=math.sin(slope),
        cosine=math.cos(slope),
        reach=scuffing.reach * robot.leg_length,
        delay=float(scuffing.delay),
        rate=math.sqrt(float(np.abs(fastest).max())),
        stall_time=STALL_TIME * math.sqrt(robot.leg_length / robot.gravity),
    )


@dataclass(frozen=True)
class Steps:
    """Steps of the return map.

    Attributes:
        states: (q1, q2, dq1, dq2) just after each impact, shape (steps, 4), rad and rad/s.
        periods: Time of each step, shape (steps,), s.
        outcome: "walking", or what became of the robot after these steps: "fell", "stalled" or "diverged".
    """

    states: Array
    periods: Array
    outcome: str

    def __repr__(self) -> str:
        """One line; the tables are long."""
        return f"<Steps: {self.outcome} after {len(self.states)}>"


@dataclass(frozen=True)
class ReturnMap:
    """The unpowered robot on a plane, from just after one impact to just after the next.

    Attributes:
        robot: Any compass biped.
        slope: Of the plane, rad, positive downhill.
        scuffing: When the swing foot may touch the ground; the engines' rule unless given.

    Raises:
        InputError: The slope is no finite number within 90 degrees.
    """

    robot: Compass
    slope: float
    scuffing: ScuffingRule = ScuffingRule()  # noqa: RUF009 (frozen)

    def __post_init__(self) -> None:
        """Refuse a slope on which nothing stands."""
        domains.check_kind("robot", self.robot, Compass)
        object.__setattr__(self, "slope", domains.SLOPE.check("slope", self.slope))
        domains.check_kind("scuffing", self.scuffing, ScuffingRule)

    @cached_property
    def plane(self) -> Plane:
        """Robot, plane and rule in plain numbers."""
        return plane_of(self.robot, self.slope, self.scuffing)

    def walk(self, state: ArrayLike, steps: int) -> Steps:
        """Walk from a state, by rule one just after an impact: both feet on the plane.

        Args:
            state: (q1, q2, dq1, dq2), rad and rad/s.
            steps: How many.

        Raises:
            InputError: The state is not four finite numbers, or steps is below 1.
        """
        start = domains.check_states("state", state, (4,))
        steps = domains.MAP_STEPS.check("steps", steps)
        batch = walk_all(self.plane, start[None], steps, room=steps)
        done = int(batch.counts[0])
        return Steps(batch.states[0, :done], batch.periods[0, :done], Outcome(batch.outcomes[0]).name.lower())
