"""The return map of the unpowered robot on a plane: from just after one impact to just after the next (equations 1-4).

It is the hybrid engine's gait step by the engine's own machine code, started afresh after each impact, in integration
steps of one length, some fifteen to a gait step, so that its result depends smoothly on the state. That makes it fit
for Newton's method, and fast enough for diagrams of a million steps. docs/gaits.md has its accuracy.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import cached_property, lru_cache
from typing import Any, NamedTuple

import numpy as np
import scipy
from numpy.typing import ArrayLike

from mjbiped.control.compiled import MachineCode
from mjbiped.control.unpowered import Unpowered
from mjbiped.engines.hybrid.engine import Hybrid
from mjbiped.engines.hybrid.run import HybridRun, packed
from mjbiped.engines.hybrid.state import Tables
from mjbiped.engines.plan import Plan, Terms, check_robot, check_rule
from mjbiped.errors import InputError
from mjbiped.numerics.jit import announced, compiled
from mjbiped.robots.equations import FREE
from mjbiped.robots.robot import Array, Robot
from mjbiped.rules.scuffing import ScuffingRule
from mjbiped.rules.termination import Outcome
from mjbiped.terrain.terrain import Terrain
from mjbiped.utils import domains

STEP = 0.24
"""Integration step times the fastest rate of the linearised motion: 50 ms for Table I's robot."""

TOLERANCE = 1e-9
"""Tolerance of an integration step. Near a gait steps of full length keep it; wild motions take shorter ones."""

KICK = 1e-4
"""Angle by which the robot is pushed off a gait that may be unstable, so that it walks to a stable one, rad."""

SETTLED = -1  # an outcome of walks in addition to those of the engines
TOUCHDOWN, FELL, STALLED, DIVERGED, UNRESOLVED = (
    int(outcome) for outcome in (Outcome.WALKING, Outcome.FELL, Outcome.STALLED, Outcome.DIVERGED, Outcome.UNRESOLVED)
)


def kicked(state: Array) -> Array:
    """A state pushed off a gait: the stance leg is `KICK` further forward, the swing leg as far back."""
    pushed, half = state.copy(), len(state) // 2
    pushed[0] += KICK
    pushed[1:half] -= KICK
    return pushed


class EngineCode(NamedTuple):
    """The hybrid engine's machine code for the unpowered robot.

    Attributes:
        advance: See `mjbiped.engines.hybrid.run.HybridRun`.
    """

    advance: Any


class Plane(NamedTuple):
    """A robot on a plane in the form that the hybrid engine takes.

    Attributes:
        code: What walks it.
        law: The machine code of no torque.
        constants: Robot and rules; to be copied for each batch, as they have room to compute in.
        tables: The plane, and room for one touchdown; likewise.
        state: State of a walk just after an impact.
        robot: The robot.
    """

    code: EngineCode
    law: MachineCode
    constants: Any
    tables: Tables
    state: Any
    robot: Robot


class Batch(NamedTuple):
    """Inputs and outputs of a batch of walks.

    Attributes:
        law: The law of the unpowered robot.
        starts: First states, shape (walks, m), of m = 4 numbers, or 6 with knees.
        limit: Steps at most.
        goals: States near which a walk is settled and ends, shape (n, m); n may be 0.
        near: How near to one of them, shape (m,).
        start: Room for the first state of a step, shape (m,).
        memory: The engine's state, an array of one.
        fresh: What it is just after an impact.
        states: Last states after impacts, shape (walks, room, m): step n stands in row n % room.
        periods: Periods of the same steps, shape (walks, room), s.
        counts: Number of steps walked, shape (walks,).
        outcomes: `SETTLED`, `TOUCHDOWN` for a walk that reached the limit, or the engine's outcome, shape (walks,).
    """

    law: Any
    starts: Any
    limit: int
    goals: Any
    near: Any
    start: Any
    memory: Any
    fresh: Any
    states: Any
    periods: Any
    counts: Any
    outcomes: Any


def walk_batch(code: EngineCode, constants: Any, room: int, batch: Batch) -> None:
    """Walk each walk of a batch, and fill in the rest of it.

    Place and time begin at zero after each impact, so that a step depends on its first state alone, and on the flexion
    of the stance knee after a touchdown with a bent one. Of each walk the last `room` steps are kept.
    """
    w, numbers = batch.memory[0], batch.states.shape[2]
    for walk in range(len(batch.starts)):
        batch.memory[0] = batch.fresh[0]
        for c in range(numbers):
            w.y[c] = batch.starts[walk, c]
        opened = w.y[numbers // 2 + constants.robot.shank] > w.y[numbers // 2 + constants.robot.thigh]
        n, outcome, flexion, knee = 0, TOUCHDOWN, 0.0, FREE if opened else w.locked
        while True:
            if is_near(w.y, batch.goals, batch.near):
                outcome = SETTLED
            if outcome != TOUCHDOWN or n == batch.limit:
                break
            for c in range(numbers):
                batch.start[c] = w.y[c]
            batch.memory[0] = batch.fresh[0]
            for c in range(numbers):
                w.y[c] = batch.start[c]
            w.stance_flexion, w.locked, w.foot_angle = flexion, knee, w.y[0]
            code.advance(batch.law, constants, w)
            outcome = int(w.outcome)
            if outcome == TOUCHDOWN:
                batch.periods[walk, n % room] = w.time
                for c in range(numbers):
                    batch.states[walk, n % room, c] = w.y[c]
                flexion, knee = w.stance_flexion, w.locked
                n += 1
            elif outcome == UNRESOLVED:  # without torques only an unbounded motion is unresolved
                outcome = DIVERGED
        batch.counts[walk], batch.outcomes[walk] = n, outcome


def is_near(y: Any, goals: Any, near: Any) -> bool:
    """Whether a state is near a goal in every component."""
    for goal in range(len(goals)):
        inside = True
        for c in range(len(near)):
            inside = inside and abs(y[c] - goals[goal, c]) < near[c]
        if inside:
            return True
    return False


def walk_all(
    plane: Plane, starts: Array, limit: int, room: int = 1, goals: Array | None = None, near: Array | None = None
) -> Batch:
    """Walk from many states by compiled code, which lets other threads run; `Batch` explains arguments and result."""
    walks, numbers = starts.shape
    constants = plane.constants.copy()
    tables = plane.tables._replace(rows=plane.tables.rows.copy())  # which live as long as machine code writes to them
    table, _ = packed(tables)
    constants.tables = table.ctypes.data
    batch = Batch(
        law=plane.law.block,
        starts=starts,
        limit=limit,
        goals=np.empty((0, numbers)) if goals is None else goals,
        near=np.zeros(numbers) if near is None else near,
        start=np.empty(numbers),
        memory=np.array([plane.state]),
        fresh=np.array([plane.state]),
        states=np.empty((walks, room, numbers)),
        periods=np.empty((walks, room)),
        counts=np.empty(walks, dtype=np.int64),
        outcomes=np.empty(walks, dtype=np.int64),
    )
    with announced("the return map", Hybrid().costs(plane.robot).engine):
        compiled(walk_batch, EngineCode, plane.code, inlined=())(constants, room, batch)
    return batch


@lru_cache(maxsize=4096)
def plane_of(robot: Robot, slope: float, scuffing: ScuffingRule) -> Plane:
    """A robot on a plane under a scuffing rule, in the form that compiled functions take."""
    angles = len(robot.angles)
    pull = robot.gravity_vector(np.full(angles, 0.5 * math.pi), 0.0)  # at right angles to gravity: the whole moments
    fastest = scipy.linalg.eigvalsh(np.diag(pull), robot.mass_matrix(np.zeros(angles)))
    step = STEP / math.sqrt(float(np.abs(fastest).max()))
    engine, still = Hybrid(TOLERANCE), (0.0,) * angles
    terms = Terms(engine, None, None, robot, None, scuffing)
    controller = Unpowered().driving(robot)
    plan = Plan(terms, controller, controller, Terrain.level(), robot, still, still, {})
    run = HybridRun(plan, TOLERANCE, compile=True)
    constants, state = run.constants, run.state
    constants.mass = math.nan  # without a weight the engine does not look for the least force on the ground
    constants.longest_step = step
    # by hand, for a terrain refuses slopes on which no foot would stand
    ground = run.tables.ground._replace(angle=np.array([slope]), gradient=np.array([-math.tan(slope)]))
    state.slope, state.sine, state.cosine = slope, math.sin(slope), math.cos(slope)
    state.next_step, state.pause = step, math.inf
    assert run.code is not None
    tables = run.tables._replace(ground=ground, rows=run.tables.rows[:1].copy())
    return Plane(EngineCode(run.advance), run.code, constants, tables, state, robot)


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
        InputError: The slope is no finite number within 90 degrees, or a scuffing rule is given for a robot with knees.
    """

    robot: Robot
    slope: float
    scuffing: ScuffingRule = ScuffingRule()  # noqa: RUF009 (frozen)

    def __post_init__(self) -> None:
        """Refuse a slope on which nothing stands."""
        check_robot("robot", self.robot)
        object.__setattr__(self, "slope", domains.SLOPE.check("slope", self.slope))
        domains.check_kind("scuffing", self.scuffing, ScuffingRule)
        check_rule(self.robot, self.scuffing)

    @cached_property
    def plane(self) -> Plane:
        """Robot, plane and rule in the form that compiled functions take."""
        return plane_of(self.robot, self.slope, self.scuffing)

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
        batch = walk_all(self.plane, start[None], steps, room=steps)
        done = int(batch.counts[0])
        return Steps(batch.states[0, :done], batch.periods[0, :done], Outcome(batch.outcomes[0]).name.lower())
