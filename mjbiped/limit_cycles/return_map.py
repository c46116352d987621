"""The return map of the unpowered robot on a plane: from just after one impact to just after the next (equations 1-4).

It is the hybrid engine's gait step by the engine's own machine code, started afresh after each impact, in integration
steps of one length, some fifteen to a gait step, so that its result depends smoothly on the state. That makes it fit
for Newton's method, and fast enough for diagrams of a million steps. docs/gaits.md has its accuracy.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import lru_cache
from typing import NamedTuple

import numpy as np
import scipy
from numpy.typing import ArrayLike

from mjbiped.control.compiled import CalledMethods, MachineCode, as_machine_code
from mjbiped.control.controller import Unpowered
from mjbiped.disturbances.disturbances import UNDISTURBED
from mjbiped.dynamics.modes import FREE, bend_stance_knee
from mjbiped.engines.checks import check_robot, check_rule
from mjbiped.engines.hybrid.engine import Hybrid, engine_address
from mjbiped.engines.hybrid.motion import enter_mode
from mjbiped.engines.hybrid.setup import (
    buffer_constants,
    ground_constants,
    law_constants,
    robot_constants,
    rule_constants,
    state_of,
)
from mjbiped.engines.hybrid.state import Constants, constants_at, state_at
from mjbiped.errors import InputError
from mjbiped.numerics.blocks import Block, Numbers, call, numbers, packed, reader, row, share_arrays
from mjbiped.numerics.cache import announced
from mjbiped.robots.robot import Array, Robot
from mjbiped.rules.scuffing import ScuffingRule
from mjbiped.rules.termination import Outcome
from mjbiped.terrain.profile import Profile
from mjbiped.utils import domains

STEP = 0.24
"""Integration step times the fastest rate of the linearised motion: 50 ms for Table I's robot."""

TOLERANCE = 1e-9
"""Tolerance of an integration step. Near a gait steps of full length keep it; wild motions take shorter ones."""

KICK = 1e-4
"""Angle by which the robot is pushed off a gait that may be unstable, so that it walks to a stable one, rad."""

SETTLED = -1  # an outcome of walks in addition to those of the engines
TOUCHDOWN, DIVERGED, UNRESOLVED = int(Outcome.WALKING), int(Outcome.DIVERGED), int(Outcome.UNRESOLVED)


def kicked(state: Array) -> Array:
    """A state pushed off a gait: the stance leg is `KICK` further forward, the swing leg as far back."""
    pushed, half = state.copy(), len(state) // 2
    pushed[0] += KICK
    pushed[1:half] -= KICK
    return pushed


class Plane(NamedTuple):
    """An unpowered robot on a plane in the form that the hybrid engine takes.

    Attributes:
        robot: The robot.
        constants: Robot, law and rules; their addresses are those of machine code.
        code: The law, which has to live as long as they do.
    """

    robot: Robot
    constants: Constants
    code: MachineCode | CalledMethods


class Batch(Block):
    """Inputs and outputs of a batch of walks, for machine code.

    Attributes:
        advance: Address of the hybrid engine.
        constants: Address of its constants.
        state: Address of its state.
        fresh: Address of what the state is just after an impact.
        words: Number of floats that are the size of a state.
        walks: Number of walks.
        numbers: Numbers of a first state, m: 4, or 6 with knees.
        room: Steps of each walk that are kept, the last ones.
        limit: Steps at most.
        goals: Number of states near which a walk is settled and ends.
        knee: Whether the robot has knees: indices 1 and 2 are then those of thigh and shank.
        starts: First states, shape (walks, m).
        goal: These states, shape (goals, m).
        near: How near to one of them, shape (m,).
        states: Last states after impacts, shape (walks, room * m): step n stands n % room rows behind the first.
        periods: Periods of the same steps, shape (walks, room), s.
        counts: Number of steps walked, shape (walks,).
        outcomes: `SETTLED`, `TOUCHDOWN` for a walk that reached the limit, or the engine's outcome, shape (walks,).
    """


_batch_at = reader(Batch)


def walk_batch(batch: int) -> None:
    """Walk each walk of a batch, which stands at an address, and fill in the rest of it.

    Place and time begin at zero after each impact, so that a step depends on its first state alone, and on the flexion
    of the stance knee after a touchdown with a bent one. Of each walk the last `room` steps are kept.
    """
    b = _batch_at(batch, 0)
    for walk in range(b.walks):
        _walk_one(b, walk)


def _walk_one(b: Batch, walk: int) -> None:
    """Walk one walk of a batch."""
    w, m, half = state_at(b.state, 0), b.numbers, b.numbers // 2
    c, y = constants_at(b.constants, 0), numbers(w.y, m)
    states, periods = row(b.states, walk, b.room * m), row(b.periods, walk, b.room)
    _copy(b.fresh, b.state, b.words)
    for i in range(m):
        y[i] = row(b.starts, walk, m)[i]
    n, outcome, flexion, knee = 0, TOUCHDOWN, 0.0, w.locked
    if b.knee and y[half + 2] > y[half + 1]:
        knee = FREE
    while True:
        if is_near(b, y):
            outcome = SETTLED
        if outcome != TOUCHDOWN or n == b.limit:
            break
        _copy(b.fresh, b.state, b.words)  # all but the arrays, such as y
        w.stance_flexion, w.locked, w.foot_angle = flexion, knee, y[0]
        bend_stance_knee(w, c.upper, c.lower, flexion)
        enter_mode(c, w)
        call(b.advance, b.constants, b.state)
        outcome = w.outcome
        if outcome == TOUCHDOWN:
            periods[n % b.room] = w.time
            for i in range(m):
                states[n % b.room * m + i] = y[i]
            flexion, knee = w.stance_flexion, w.locked
            n += 1
        elif outcome == UNRESOLVED:  # without torques only an unbounded motion is unresolved
            outcome = DIVERGED
    numbers(b.counts, b.walks)[walk], numbers(b.outcomes, b.walks)[walk] = n, outcome


def _copy(source: int, target: int, words: int) -> None:
    """Copy words from one address to another."""
    there, here = numbers(target, words), numbers(source, words)
    for i in range(words):
        there[i] = here[i]


def is_near(b: Batch, y: Numbers) -> bool:
    """Whether a state is near a goal in every component."""
    near = numbers(b.near, b.numbers)
    for goal in range(b.goals):
        inside = True
        for i in range(b.numbers):
            inside = inside and abs(y[i] - row(b.goal, goal, b.numbers)[i]) < near[i]
        if inside:
            return True
    return False


def walk_all(
    plane: Plane, starts: Array, limit: int, room: int = 1, goals: Array | None = None, near: Array | None = None
) -> Batch:
    """Walk from many states by compiled code, which lets other threads run; `Batch` explains arguments and result."""
    from mjbiped.numerics.machine import compiled

    walks, count = starts.shape
    # buffers are of one batch alone
    buffers = buffer_constants(1, 1, 0, math.inf)
    constants, below = packed(plane.constants.but(**buffers))
    first = state_of(plane.constants, [0.0] * count, [], (0.0, 0.0, 0), math.inf)
    first.next_step = plane.constants.longest_step
    share_arrays(first)
    (state, arrays), (fresh, _) = packed(first), packed(first)
    batch = Batch(
        advance=0,
        constants=constants.ctypes.data,
        state=state.ctypes.data,
        fresh=fresh.ctypes.data,
        words=state.itemsize // 8,
        walks=walks,
        numbers=count,
        room=room,
        limit=limit,
        goals=0 if goals is None else len(goals),
        knee=plane.constants.thigh != plane.constants.shank,
        starts=np.ascontiguousarray(starts, dtype=np.float64),
        goal=np.zeros((1, count)) if goals is None else np.ascontiguousarray(goals, dtype=np.float64),
        near=np.zeros(count) if near is None else np.ascontiguousarray(near, dtype=np.float64),
        states=np.empty((walks, room, count)),
        periods=np.empty((walks, room)),
        counts=np.empty(walks),
        outcomes=np.empty(walks),
    )
    with announced("the return map", Hybrid().costs(plane.robot).engine):
        batch.advance = engine_address()
        walk = compiled(walk_batch, "void(int64)")
    made, kept = packed(batch)
    walk(made.ctypes.data)
    del below, arrays, kept  # which lived until now
    batch.counts, batch.outcomes = batch.counts.astype(np.int64), batch.outcomes.astype(np.int64)
    return batch


@lru_cache(maxsize=4096)
def check_planar(robot: Robot) -> None:
    """Refuse a robot in space, whose steps the planar engine does not make.

    Raises:
        InputError: It is one.
    """
    if "hip_y" in robot.places:
        raise InputError(
            f"passive walks and bifurcations are mapped of planar robots, and a {type(robot).__name__} moves in space: "
            f"mjbiped return-map --robot {robot.kind} shows its passive steps, and mjbiped lateral-basin its walks"
        )


def plane_of(robot: Robot, slope: float, scuffing: ScuffingRule) -> Plane:
    """A robot on a plane under a scuffing rule, in the form that compiled functions take."""
    angles = len(robot.angles)
    pull = robot.gravity_vector(np.full(angles, 0.5 * math.pi), 0.0)  # at right angles to gravity: the whole moments
    fastest = scipy.linalg.eigvalsh(np.diag(pull), robot.mass_matrix(np.zeros(angles)))
    step = STEP / math.sqrt(float(np.abs(fastest).max()))
    code = as_machine_code(Unpowered().driving(robot))
    # by hand, for a terrain refuses slopes on which no foot would stand
    ground = Profile([0.0], [0.0], [-math.tan(slope)], 1)
    # without a weight the engine does not look for the least force on the ground
    own = {**robot_constants(robot), "weight": math.nan, "longest_step": step}
    constants = Constants(
        **own,
        **law_constants(code.law, robot, 0, -1),
        **ground_constants(ground, [slope], math.inf),
        pushes=[UNDISTURBED.schedule],
        **buffer_constants(1, 1, 0, math.inf),
        **rule_constants(robot, scuffing, None, None),
        tolerance=TOLERANCE,
        control_period=math.inf,
    )
    return Plane(robot, constants, code)


@dataclass(frozen=True)
class Steps:
    """Steps of the return map.

    Attributes:
        states: (q1, q2, dq1, dq2) just after each impact, with knees (q1, q2, q3, dq1, dq2, dq3), shape (steps, 4) or
            (steps, 6), rad and rad/s.
        periods: Duration of each step, shape (steps,), s.
        outcome: "walking", or the end of the walk after these steps: "fell", "stalled" or "diverged".
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
        robot: Any robot.
        slope: Slope of the plane, rad, positive downhill.
        scuffing: When the swing foot of straight legs may touch the ground; the engines' rule unless given.

    Raises:
        InputError: The robot moves in space, the slope is no finite number within 90 degrees, or a scuffing rule is
            given for a robot with knees.
    """

    robot: Robot
    slope: float
    scuffing: ScuffingRule = ScuffingRule()  # noqa: RUF009 (frozen)

    def __post_init__(self) -> None:
        """Refuse a slope on which nothing stands."""
        check_robot("robot", self.robot)
        check_planar(self.robot)
        object.__setattr__(self, "slope", domains.SLOPE.check("slope", self.slope))
        domains.check_kind("scuffing", self.scuffing, ScuffingRule)
        check_rule(self.robot, self.scuffing)

    def walk(self, state: ArrayLike, steps: int) -> Steps:
        """Walk from a state just after an impact, with both feet on the plane.

        Args:
            state: (q1, q2, dq1, dq2), rad and rad/s; with knees (q1, q2, q3, dq1, dq2, dq3), the swing leg straight;
                its knee may bend already where `Robot.knee_opens`.
            steps: Number of steps.

        Raises:
            InputError: The state has another shape or is not finite, its swing knee is bent, or steps is below 1.
        """
        angles = len(self.robot.angles)
        start = domains.check_states("state", state, (2 * angles,))
        bends = np.diff(start[angles + 1 :])
        if np.diff(start[1:angles]).any() or (bends < 0.0 if self.robot.knee_opens else bends != 0.0).any():
            raise InputError("state: just after an impact the swing leg is straight: q3 = q2 and dq3 = dq2")
        steps = domains.MAP_STEPS.check("steps", steps)
        batch = walk_all(plane_of(self.robot, self.slope, self.scuffing), start[None], steps, room=steps)
        done = int(batch.counts[0])
        outcome = Outcome(int(batch.outcomes[0])).name.lower()
        return Steps(batch.states[0, :done], batch.periods[0, :done], outcome)
