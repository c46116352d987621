"""Chooses at each touchdown between the tracking law and a recovery step, by simulating both."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import ClassVar, NamedTuple

from mjbiped.control.controller import Law, Memory
from mjbiped.controllers import adaptive
from mjbiped.controllers.bounded import bounded_ankle, prediction, recovery
from mjbiped.controllers.bounded.bounded_ankle import BoundedAnkleController, feel, slope_law
from mjbiped.controllers.bounded.prediction import Limits, State, motion, nominal_steps, plan_nominal, step_ahead
from mjbiped.controllers.bounded.recovery import RECOVERING, Ankle, Step
from mjbiped.controllers.bounded.stance import SUPPORT, model_of, set_support
from mjbiped.controllers.gait_library import GaitLibrary, Switch, count_steps
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


class Foresight(NamedTuple):
    """What a choice takes.

    Attributes:
        walked: Parameters of the steps that are walked.
        prediction: Those of predictions, which count on less of the sole.
        recovery: Recovery steps that are tried, in SI units.
        weight: Weight of the robot times the length of its leg, by which a failure counts more than any work, J.
        unevenness: Difference of height between footholds that a recovery step should bear, m.
    """

    walked: prediction.Parameters
    prediction: prediction.Parameters
    recovery: Recovery
    weight: float
    unevenness: float


class Parameters(NamedTuple):
    """Parameters of the laws of this module.

    Attributes:
        economical: Of choices with the economical gait.
        climbing: Of choices with the climbing gait.
        switch: When the one takes the place of the other.
    """

    economical: Foresight
    climbing: Foresight
    switch: Switch


_CLIMBING = recovery.SIZE
"""Index in the memory of the number of steps left with the climbing gait, this one included."""

AHEAD, AFTER = 3, 2
"""Steps of the tracking law that have to be foreseen: from a touchdown, and after a recovery step."""

UNEVENNESS = 0.01
"""Difference of height between footholds that a recovery step should bear, in leg lengths."""


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

    memory_size: ClassVar[int] = _CLIMBING + 1
    with_knees: ClassVar[str | None] = None
    recovery: ClassVar[Recovery] = Recovery(
        Range(1.16, 0.38, 6), Range(0.13, 0.0345, 6), Range(-1.735, 0.855, 3), Ankle(0.235, 0.33, 2.73)
    )

    margin: ClassVar[float] = 0.9

    @cached_property
    def foresight(self) -> Foresight:
        """What choices with the economical gait take, in plain numbers."""
        length, mass, gravity = self.robot.leg_length, self.robot.total_mass, self.robot.gravity
        time, weight = math.sqrt(length / gravity), mass * gravity * length
        reach = ScuffingRule().reach * length
        # the friction leaves a margin to the ground's 0.8, as do the other numbers to a fall
        limits = Limits(0.02 * time, 5.0 * time, 0.8, 0.05 * mass * gravity, 0.75, length, reach, 0.6 * length)
        given, ankle = self.recovery, self.recovery.ankle
        walked = prediction.Parameters(
            self.parameters, Ankle(ankle.gain * weight * time, ankle.rate / time, ankle.stiffness / time), limits
        )
        cautious = self.parameters._replace(model=model_of(self.robot, self.margin * self.sole_share))
        return Foresight(
            walked,
            walked._replace(bounded=cautious),
            given._replace(times=Range(given.times.first * time, given.times.step * time, given.times.number)),
            weight,
            UNEVENNESS * length,
        )

    @cached_property
    def plain_law(self) -> Law:
        """The laws of this module; see `LawController.plain_law`."""
        return Law(self.library, torque_law, touchdown_law, slope_law, next_discontinuity_law)

    @cached_property
    def library(self) -> Parameters:
        """The attributes in plain numbers, as the laws take them."""
        return Parameters(self.foresight, self.climbing.foresight, self.switch)

    def parameters_of(self, memory: Memory) -> adaptive.Parameters:
        """Return the parameters of the tracking law with the gait of the step."""
        return _of_step(self.library, memory).walked.bounded.tracking

    def tracked(self, memory: Memory, t: float) -> tuple[Sequence[float], Sequence[float]]:
        """Angles and rates that are tracked; in recovery steps, which follow no time, there are none: NaN."""
        nothing = (math.nan, math.nan)
        return (nothing, nothing) if memory[RECOVERING] else super().tracked(memory, t)

    def plan_first_step(self, memory: Memory, q: Sequence[float], dq: Sequence[float]) -> None:
        """Choose the first step."""
        choose(self.foresight, memory, State(q[0], q[1], dq[0], dq[1]))


def _of_step(parameters: Parameters, memory: Memory) -> Foresight:
    """What the choice of the current step takes."""
    return parameters.climbing if memory[_CLIMBING] > 0.0 else parameters.economical


def torque_law(
    parameters: Parameters, memory: Memory, t: float, q1: float, q2: float, dq1: float, dq2: float
) -> tuple[float, float, float, float]:
    """Ankle and hip torque of the step that was chosen, and the rates of the identifier."""
    given = _of_step(parameters, memory).walked
    made = motion(given, memory, t, State(q1, q2, dq1, dq2))
    return bounded_ankle.with_rates(given.bounded.tracking, memory, made, q1, q2, dq1, dq2)


def touchdown_law(
    parameters: Parameters, memory: Memory, before1: float, before2: float, q1: float, q2: float, dq1: float, dq2: float
) -> None:
    """Estimate update (27), a new prediction of the momentum, and the choice of the new step and of its gait."""
    given = begin_step(parameters, memory, before1, before2, q1, q2, dq1, dq2)
    choose(given, memory, State(q1, q2, dq1, dq2))


def begin_step(
    parameters: Parameters, memory: Memory, before1: float, before2: float, q1: float, q2: float, dq1: float, dq2: float
) -> Foresight:
    """Take up what a touchdown tells, and return what the choice of the new step takes."""
    count_steps(parameters.switch, memory, _CLIMBING, before1, before2)
    given = _of_step(parameters, memory)
    feel(given.walked.bounded.tracking, memory, before1, q1, q2, dq1, dq2)
    return given


def next_discontinuity_law(parameters: Parameters, memory: Memory, t: float) -> float:
    """The time at which a recovery step is on its constraint, or the kinks of the tracking law, s."""
    if memory[RECOVERING] == 0.0:
        return bounded_ankle.next_discontinuity_law(_of_step(parameters, memory).walked.bounded, memory, t)
    time = recovery.planned(memory).time
    return time if t < time else math.inf


def choose(foresight: Foresight, memory: Memory, state: State) -> None:
    """Plan the step that begins in a state."""
    steps, _ = nominal_steps(foresight.prediction, memory, state, AHEAD)
    if steps == AHEAD or not recovers(foresight, memory, state):
        plan_nominal(foresight.prediction, memory, state)


def recovers(foresight: Foresight, memory: Memory, state: State) -> bool:
    """Plan the best recovery step, unless all of the grid fall."""
    found, step = cheapest(foresight, memory, state)
    if found == math.inf:
        return False
    recovery.begin(memory, step, state.q1, state.q2, state.dq1, state.dq2)
    return True


def cheapest(foresight: Foresight, memory: Memory, state: State) -> tuple[float, Step]:
    """The best recovery step of the grid, and its `cost`; infinite where all fall. The memory's plan is lost."""
    best, chosen = math.inf, Step(0.0, 0.0, 0.0)
    for index in range(number_of_steps(foresight.recovery)):
        step = step_of(foresight.recovery, index)
        found = cost(foresight, memory, state, step, best)
        if found < best:
            best, chosen = found, step
    return best, chosen


def number_of_steps(recovery: Recovery) -> int:
    """How many recovery steps are tried."""
    return int(recovery.times.number * recovery.halves.number * recovery.retractions.number)


def step_of(recovery: Recovery, index: int) -> Step:
    """One of the recovery steps that are tried."""
    times, halves, retractions, _ = recovery
    pair, k = divmod(index, int(retractions.number))
    i, j = divmod(pair, int(halves.number))
    return Step(times.first + i * times.step, halves.first + j * halves.step, retractions.first + k * retractions.step)


def cost(foresight: Foresight, memory: Memory, state: State, step: Step, best: float) -> float:
    """Cost of a recovery step, J, or some number over `best` if it is more than that.

    It is the work of this and the following steps, and m g l for each step of `AFTER` that is not foreseen, and for
    each foothold, higher or lower by the unevenness, from which they are not all foreseen; infinite where this step
    fails.
    """
    found = 0.0
    behind, ahead = memory[SUPPORT], memory[SUPPORT + 1]
    for side in range(3):
        recovery.begin(memory, step, state.q1, state.q2, state.dq1, state.dq2)
        rise = foresight.unevenness * (0.0, 1.0, -1.0)[side]
        work, after = step_ahead(foresight.prediction, memory, state, rise)
        steps = 0
        if work < math.inf:
            set_support(memory, 0.0, 0.0)
            steps, more = nominal_steps(foresight.prediction, memory, after, AFTER)
            set_support(memory, behind, ahead)
            work += more
        if side == 0:
            found = work + foresight.weight * (AFTER - steps)
        elif steps < AFTER:
            found += foresight.weight
        if found >= best or (steps < AFTER and side == 0):
            return found
    return found
