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

from mjbiped.control.compilation import MachineCode
from mjbiped.control.unpowered import Unpowered
from mjbiped.engines.hybrid import state as indices
from mjbiped.engines.hybrid.models import model_of
from mjbiped.engines.hybrid.simulation import HybridSimulation
from mjbiped.engines.hybrid.state import Buffers, SimulationConstants
from mjbiped.engines.plan import check_robot
from mjbiped.errors import InputError
from mjbiped.numerics.jit import compiled
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
        advance: The engine's loop; see `mjbiped.engines.hybrid.simulation.HybridSimulation`.
    """

    advance: Any


class Plane(NamedTuple):
    """A robot on a plane in the form that the hybrid engine takes.

    Attributes:
        robot: The robot that walks.
        code: The engine's machine code.
        law: The machine code of a controller without torques.
        constants: Robot, plane and rules in plain numbers.
        buffers: Buffers of a walk just after an impact, with room for one touchdown; copied for each batch.
    """

    robot: Robot
    code: EngineCode
    law: MachineCode
    constants: SimulationConstants
    buffers: Buffers


class Batch(NamedTuple):
    """Inputs and outputs of a batch of walks.

    Attributes:
        law: The law of the unpowered robot.
        starts: First states, shape (walks, m), of m = 4 numbers, or 6 with knees.
        limit: Greatest number of steps.
        goals: States near which a walk has settled and ends, shape (n, m); n may be 0.
        near: Greatest distance from a goal in each component, shape (m,).
        scalars: Scalars of the engine just after an impact.
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
    scalars: Any
    states: Any
    periods: Any
    counts: Any
    outcomes: Any


def check_rule(robot: Robot, scuffing: ScuffingRule) -> None:
    """Refuse a scuffing rule for a robot with knees.

    Raises:
        InputError: The rule is not the default one.
    """
    if robot.knees and scuffing != ScuffingRule():
        raise InputError("scuffing is for straight legs: with knees the swing foot collides from lift-off on")


def walk_batch(code: EngineCode, constants: SimulationConstants, b: Buffers, batch: Batch) -> None:
    """Walk a batch and fill in its outputs.

    Place and time begin at zero after each impact, so that a step depends only on its first state, and on the flexion
    of the stance knee after a touchdown with a bent knee.
    """
    room, numbers = batch.states.shape[1], batch.states.shape[2]
    for walk in range(len(batch.starts)):
        for c in range(len(b.y)):
            b.y[c] = batch.starts[walk, c] if c < numbers else 0.0
        n, outcome, flexion, knee = 0, TOUCHDOWN, 0.0, batch.scalars[indices.LOCKED]
        while True:
            if is_near(b.y, batch.goals, batch.near):
                outcome = SETTLED
            if outcome != TOUCHDOWN or n == batch.limit:
                break
            for place in range(len(b.w)):
                b.w[place] = batch.scalars[place]
            b.w[indices.STANCE_FLEXION], b.w[indices.LOCKED] = flexion, knee
            code.advance(batch.law, constants, b)
            outcome = int(b.w[indices.OUTCOME])
            if outcome == TOUCHDOWN:
                batch.periods[walk, n % room] = b.w[indices.TIME]
                for c in range(numbers):
                    batch.states[walk, n % room, c] = b.y[c]
                flexion, knee = b.w[indices.STANCE_FLEXION], b.w[indices.LOCKED]
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
    batch = Batch(
        law=plane.law.law,
        starts=starts,
        limit=limit,
        goals=np.empty((0, numbers)) if goals is None else goals,
        near=np.zeros(numbers) if near is None else near,
        scalars=plane.buffers.w,
        states=np.empty((walks, room, numbers)),
        periods=np.empty((walks, room)),
        counts=np.empty(walks, dtype=np.int64),
        outcomes=np.empty(walks, dtype=np.int64),
    )
    walk = compiled(walk_batch, EngineCode, plane.code, inlined=())
    # a robot's constants may have room to compute in, which is of one thread alone
    constants = plane.constants._replace(robot=model_of(plane.robot).constants(plane.robot, True))
    walk(constants, Buffers(*(buffer.copy() for buffer in plane.buffers)), batch)
    return batch


@lru_cache(maxsize=4096)
def plane_of(robot: Robot, slope: float, scuffing: ScuffingRule) -> Plane:
    """A robot on a plane under a scuffing rule, in the form that compiled functions take."""
    angles = len(robot.angles)
    pull = robot.gravity_vector(np.full(angles, 0.5 * math.pi), 0.0)  # at right angles to gravity: the whole moments
    fastest = scipy.linalg.eigvalsh(np.diag(pull), robot.mass_matrix(np.zeros(angles)))
    step = STEP / math.sqrt(float(np.abs(fastest).max()))
    simulation = HybridSimulation(
        Unpowered().driving(robot),
        Terrain.level(),
        robot=robot,
        q=(0.0,) * angles,
        dq=(0.0,) * angles,
        sample_period=math.inf,
        scuffing=scuffing,
        tolerance=TOLERANCE,
    )
    constants = simulation.constants._replace(
        angle=np.array([slope]),  # by hand, for a terrain refuses slopes on which no foot would stand
        gradient=np.array([-math.tan(slope)]),
        mass=math.nan,  # without a weight the engine does not look for the least force on the ground, which takes time
        longest_step=step,
    )
    buffers = simulation.buffers._replace(rows=simulation.buffers.rows[:1].copy())
    buffers.w[indices.SLOPE] = slope
    buffers.w[indices.SINE], buffers.w[indices.COSINE] = math.sin(slope), math.cos(slope)
    buffers.w[indices.NEXT_STEP], buffers.w[indices.PAUSE] = step, math.inf
    assert simulation.code is not None
    return Plane(robot, EngineCode(simulation.advance), simulation.code, constants, buffers)


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
            state: (q1, q2, dq1, dq2), rad and rad/s; with knees (q1, q2, q3, dq1, dq2, dq3), the swing leg straight.
            steps: Number of steps.

        Raises:
            InputError: The state has another shape or is not finite, its swing knee is bent, or steps is below 1.
        """
        angles = len(self.robot.angles)
        start = domains.check_states("state", state, (2 * angles,))
        if np.ptp(start[1:angles]) or np.ptp(start[angles + 1 :]):
            raise InputError("state: just after an impact the swing leg is straight: q3 = q2 and dq3 = dq2")
        steps = domains.MAP_STEPS.check("steps", steps)
        batch = walk_all(self.plane, start[None], steps, room=steps)
        done = int(batch.counts[0])
        return Steps(batch.states[0, :done], batch.periods[0, :done], Outcome(batch.outcomes[0]).name.lower())
