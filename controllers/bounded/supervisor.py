"""Chooses at each touchdown between the tracking law and a recovery step, by simulating both."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass
from typing import ClassVar, NamedTuple

from mjbiped.control.controller import Law, Memory, Numbers
from mjbiped.controllers.bounded import prediction, recovery
from mjbiped.controllers.bounded.bounded_ankle import BoundedAnkleController, feel_step, next_discontinuity, torque
from mjbiped.controllers.bounded.identifier import slope_estimate
from mjbiped.controllers.bounded.prediction import FAILURE, GRID, State, nominal_steps, plan_nominal, step_ahead
from mjbiped.controllers.bounded.recovery import Ankle, Step
from mjbiped.controllers.layout import ANKLE_GAIN, ANKLE_RATE, ANKLE_STIFFNESS, SUPERVISION
from mjbiped.controllers.library import GaitLibrary
from mjbiped.controllers.room import RECOVERING, SUPPORT, SUPPORT_AHEAD
from mjbiped.rules.scuffing import ScuffingRule


class Range(NamedTuple):
    """Values of one number of a recovery step that are tried.

    Attributes:
        first: The least.
        step: From one to the next.
        number: How many.
    """

    first: float
    step: float
    number: float


class Recovery(NamedTuple):
    """Recovery steps that are tried, in units of which the law is free: the leg's length l, the mass m, gravity g.

    Attributes:
        times: T, in sqrt(l/g).
        halves: alpha, rad.
        retractions: rho.
        ankle: Gain in m g l sqrt(l/g), rates in sqrt(g/l).
    """

    times: Range
    halves: Range
    retractions: Range
    ankle: Ankle


AHEAD, AFTER = 3, 2
"""Steps of the tracking law that have to be foreseen: from a touchdown, and after a recovery step."""

UNEVENNESS = 0.01
"""Difference of height between footholds that a recovery step should bear, in leg lengths."""


def touchdown(parameters: Numbers, memory: Memory, q_before: Numbers, q: Numbers, dq: Numbers) -> None:
    """Take up what the touchdown tells, and choose the new step and its gait; see `Law.touchdown`."""
    feel_step(parameters, memory, q_before, q, dq)
    choose(parameters, memory, State(q[0], q[1], dq[0], dq[1]))


def choose(parameters: Numbers, memory: Memory, state: State) -> None:
    """Plan the step that begins in a state."""
    steps, _ = nominal_steps(parameters, memory, state, AHEAD)
    if steps == AHEAD or not recovers(parameters, memory, state):
        plan_nominal(parameters, memory, state)


def recovers(parameters: Numbers, memory: Memory, state: State) -> bool:
    """Plan the best recovery step, unless all of the grid fall."""
    found, step = cheapest(parameters, memory, state)
    if found == math.inf:
        return False
    recovery.begin(memory, step, (state.q1, state.q2), (state.dq1, state.dq2))
    return True


def cheapest(parameters: Numbers, memory: Memory, state: State) -> tuple[float, Step]:
    """Return the `cost` of the best recovery step of the grid, infinite where all fall, and it; the plan is lost."""
    best, chosen = math.inf, Step(0.0, 0.0, 0.0)
    for index in range(number_of_steps(parameters)):
        step = step_of(parameters, index)
        found = cost(parameters, memory, state, step, best)
        if found < best:
            best, chosen = found, step
    return best, chosen


def number_of_steps(parameters: Numbers) -> int:
    """Return how many recovery steps are tried."""
    grid = int(parameters[SUPERVISION]) + GRID
    return int(parameters[grid + 2] * parameters[grid + 5] * parameters[grid + 8])


def step_of(parameters: Numbers, index: int) -> Step:
    """Return one of the recovery steps that are tried."""
    grid = int(parameters[SUPERVISION]) + GRID
    pair, k = divmod(index, int(parameters[grid + 8]))
    i, j = divmod(pair, int(parameters[grid + 5]))
    return Step(
        parameters[grid] + i * parameters[grid + 1],
        parameters[grid + 3] + j * parameters[grid + 4],
        parameters[grid + 6] + k * parameters[grid + 7],
    )


def cost(parameters: Numbers, memory: Memory, state: State, step: Step, best: float) -> float:
    """Return the cost of a recovery step, J, or some number over `best` if it is more than that.

    It is the work of this and the following steps, and m g l for each step of `AFTER` that is not foreseen, and for
    each foothold, higher or lower by the unevenness, from which they are not all foreseen; infinite where this step
    fails.
    """
    found, limits = 0.0, int(parameters[SUPERVISION])
    behind, ahead = memory[SUPPORT], memory[SUPPORT_AHEAD]
    for side in range(3):
        recovery.begin(memory, step, (state.q1, state.q2), (state.dq1, state.dq2))
        rise = parameters[limits + prediction.UNEVENNESS] * (0.0, 1.0, -1.0)[side]
        work, after = step_ahead(parameters, memory, state, rise)
        steps = 0
        if work < math.inf:
            memory[SUPPORT], memory[SUPPORT_AHEAD] = 0.0, 0.0
            steps, more = nominal_steps(parameters, memory, after, AFTER)
            memory[SUPPORT], memory[SUPPORT_AHEAD] = behind, ahead
            work += more
        if side == 0:
            found = work + parameters[limits + FAILURE] * (AFTER - steps)
        elif steps < AFTER:
            found += parameters[limits + FAILURE]
        if found >= best or (steps < AFTER and side == 0):
            return found
    return found


@dataclass(frozen=True)
class SupervisedController(GaitLibrary, BoundedAnkleController):
    """Tracks a gait while it can foresee that this goes well, and otherwise makes a recovery step.

    At each touchdown the steps to come are simulated with the tracking law of `BoundedAnkleController`, on a plane of
    the estimated slope. Where one fails, because the foot does not get ahead or the ground would have to pull or to
    hold more than friction can, this step becomes a recovery step: of a grid of them, the one with the least work from
    which steps of the tracking law are foreseen, preferably also if the next foothold is a little higher or lower. The
    simulations know the ground as far as it was felt, and the default scuffing rule. Where the foot landed much higher
    than expected, the steps that follow track a gait of more clearance.

    Attributes:
        robot: See `BoundedAnkleController`, as for all attributes but those of the climbing gait; for those
            `GaitLibrary`.
        recovery: Recovery steps that are tried.
        margin: Share that simulations count on, of the sole on which the law leans; errors of its model take the rest.
    """

    for_joints: ClassVar[Mapping[str, str]] = {}
    functions: ClassVar[Law] = Law((), torque, touchdown, slope_estimate, next_discontinuity)
    recovery: ClassVar[Recovery] = Recovery(
        Range(1.16, 0.38, 6), Range(0.13, 0.0345, 6), Range(-1.735, 0.855, 3), Ankle(0.235, 0.33, 2.73)
    )

    margin: ClassVar[float] = 0.9

    def scalars(self) -> dict[int, float]:
        """Return the scalars among the parameters, by their indices."""
        time, failure, (gain, rate, stiffness) = *self._units, self.recovery.ankle
        own = (gain * failure * time, rate / time, stiffness / time)
        return {**super().scalars(), **dict(zip((ANKLE_GAIN, ANKLE_RATE, ANKLE_STIFFNESS), own, strict=True))}

    @property
    def _units(self) -> tuple[float, float]:
        """Unit of time, s, and weight times leg length, by which a failure counts more than any work, J."""
        length, gravity = self.robot.leg_length, self.robot.gravity
        return math.sqrt(length / gravity), self.robot.total_mass * gravity * length

    def chains(self) -> dict[int, Numbers]:
        """Return the robot model's chain, and what choices take, by the indices of their starts."""
        (time, failure), length, (times, halves, retractions, _) = self._units, self.robot.leg_length, self.recovery
        supervision = [
            # the friction leaves a margin to the ground's 0.8, as do the other numbers to a fall
            *(self.margin * self.sole_share, 0.02 * time, 5.0 * time, 0.8, 0.05 * failure / length, 0.75),
            *(length, ScuffingRule().reach * length, 0.6 * length, *self.robot.constants, failure),
            *(UNEVENNESS * length, times.first * time, times.step * time, times.number, *halves, *retractions),
        ]
        return {**super().chains(), SUPERVISION: supervision}

    def tracked(self, memory: Memory, t: float) -> tuple[Numbers, Numbers]:
        """Angles and rates that are tracked; in recovery steps, which follow no time, there are none: NaN."""
        nothing = (math.nan, math.nan)
        return (nothing, nothing) if memory[RECOVERING] else super().tracked(memory, t)

    def plan_first_step(self, memory: Memory, q: Numbers, dq: Numbers) -> None:
        """Choose the first step."""
        choose(self.parameters, memory, State(q[0], q[1], dq[0], dq[1]))
