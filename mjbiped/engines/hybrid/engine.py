"""`Hybrid`: the engine of the paper's equations and impact map, with its settings."""

from __future__ import annotations

import ctypes
import time
from dataclasses import dataclass
from functools import cached_property
from pkgutil import resolve_name
from typing import Annotated, Any, ClassVar

import numpy as np
from numpy.typing import NDArray

from mjbiped.control.compiled import as_machine_code, compilable_law
from mjbiped.control.controller import Controller
from mjbiped.control.functions import fault_at, fault_in
from mjbiped.disturbances.disturbances import Disturbances
from mjbiped.disturbances.loop import SampledController
from mjbiped.engines.base import Engine, Run, Show, step_under_way
from mjbiped.engines.compiling import Costs, announced_for, can_compile, compiles
from mjbiped.engines.hybrid.gait_step import advance, advance_at
from mjbiped.engines.hybrid.motion import take_angles
from mjbiped.engines.hybrid.resets import columns_of, write_sample
from mjbiped.engines.hybrid.setup import walk_of
from mjbiped.engines.hybrid.state import Constants, State
from mjbiped.engines.plan import Plan
from mjbiped.errors import InputError, MjbipedError
from mjbiped.numerics.blocks import packed, share_arrays, take_numbers
from mjbiped.records.columns import Cancellation, never_cancelled
from mjbiped.robots.robot import Robot
from mjbiped.rules.termination import Outcome
from mjbiped.utils import domains

TOLERANCE = 1e-8
"""Relative and absolute tolerance of an integration step. With `setup.LONGEST_STEP` it keeps the states after
touchdowns accurate to some 1e-10 (docs/hybrid.md)."""

_FIRST_STINT = 24_000  # evaluations of the law until compiled code first returns to Python, some 2 ms
_SHORT, _LONG = 0.02, 0.08  # wanted duration of a stint of compiled code, s
_WHY = {
    Outcome.UNRESOLVED: "the torque switches, or changes, faster than the integrator can follow: name the times of its "
    "jumps in the controller's next_discontinuity, make it smooth, or walk with engine='mujoco' and a control_period",
    Outcome.DIVERGED: "torques or motion are beyond all bounds, or no numbers",
}
_UNMAPPED = (
    "the swing foot struck the ground ahead of the stance foot so that the other foot could not leave it, or slid "
    "into a riser: such an impact has no map"
)


class HybridRun(Run):
    """A walk in the hybrid model.

    Attributes:
        controller: The controller that the engine calls: the plan's, in a loop that ticks if disturbances need one.
        compiled: Whether engine and laws run as machine code; a controller without `law` runs in plain Python.
        constants: Robot, law, rules and limits, and the buffers of the record, for plain Python.
        state: The state of the walk, as it is whenever the engine has returned to Python.
    """

    def __init__(
        self,
        plan: Plan,
        tolerance: float = TOLERANCE,
        *,
        summarised: bool = False,
        cancellation: Cancellation = never_cancelled,
        compile: bool | None = None,
    ) -> None:
        """Set the robot on the ground, and initialise the controller's memory; see `Engine.start`.

        Args:
            plan: The checked walk.
            tolerance: Relative and absolute tolerance of an integration step.
            summarised: Keep only what `Run.summary` needs, and no tables.
            cancellation: Called repeatedly during the walk; an exception that it raises stops the walk.
            compile: Whether to compile laws that can be compiled; None: see `mjbiped.engines.compiling`.
        """
        super().__init__(plan, summarised=summarised, cancellation=cancellation)
        self._tolerance = tolerance
        self._set_up(compiles(plan) if compile is None else compile)

    def _set_up(self, compile: bool) -> None:
        """Make everything that the walk begins with, for machine code or for plain Python."""
        plan = self.plan
        self.controller, self._stint = plan.driven(plan.disturbances.period(None, 0.0)), _FIRST_STINT
        self._law = compilable_law(self.controller) if compile else None
        self.compiled = self._law is not None
        self.constants, self.state = walk_of(plan, self.controller, self._tolerance, self.sampled, self.compiled)

    @property
    def ended(self) -> Outcome:
        """How the walk ended, or `Outcome.WALKING`."""
        return Outcome(int(self.state.outcome))

    def walk(self, show: Show) -> Outcome:
        """Integrate until the walk ends; see `Run.walk`."""
        while self.ended is Outcome.WALKING:
            try:
                self.recorder.cancellation()
                self.go_on()
            except BaseException:
                self.take()
                self._sample()
                raise
            show(self.take(), float(self.state.foot_x))
        return self.ended

    def go_on(self) -> None:
        """Walk on until the walk ends or the buffers are full; `take` then empties them.

        Machine code cannot be interrupted. It therefore works in stints of some evaluations that take less than 0.1 s,
        between which Python handles Ctrl-C; the number of evaluations changes nothing in the walk.

        Raises:
            LawError: The controller's laws cannot be compiled.
        """
        w, machine = self.state, self.machine if self.compiled else None
        while True:
            w.pause = w.evaluations + self._stint
            started = time.perf_counter()
            if machine is None:
                advance(self.constants, w)
            else:
                machine.advance(w)
            if machine is not None and machine.code.failed:
                raise MjbipedError("a compiled law raised an exception; let law() return None to see where")
            if w.evaluations < w.pause or w.outcome != Outcome.WALKING:
                return
            taken = time.perf_counter() - started
            if taken < _SHORT:
                self._stint *= 4
            elif taken > _LONG:
                self._stint = max(self._stint // 4, 1)
            self.recorder.cancellation()

    def take(self) -> int:
        """Move the contents of the buffers to the recorder; return the number of touchdowns."""
        w, c = self.state, self.constants
        rows, samples = int(w.rows), int(w.samples)
        self._record(c.row_buffer[:rows], c.sample_buffer[:samples])
        w.rows = w.samples = 0
        return rows

    def _record(self, rows: NDArray[np.float64], samples: NDArray[np.float64]) -> None:
        """Let the recorder have the columns of the robot, and of the samples the controller's states behind them."""
        kind, c = type(self.plan.robot), self.constants
        own = np.arange(c.sample_width - c.states, c.sample_width)
        self.recorder.add(
            rows[:, columns_of(kind, "touchdowns")], samples[:, np.append(columns_of(kind, "samples"), own)]
        )

    def _sample(self) -> None:
        """Record the last state reached with the last torque computed, without calling the controller's `torque`."""
        c, w = self.constants, self.state
        w.sampled[: c.joints] = w.given[0][: c.joints]
        write_sample(c, w, w.time, w.y, w.asked[0])
        self._record(c.row_buffer[:0], c.sample_buffer[:1])

    def compile(self) -> bool:
        """Compile the controller's laws now, not at the first step; return whether they are compiled at all.

        Raises:
            LawError: The laws cannot be compiled.
        """
        if self.compiled:
            with announced_for(self.plan):
                assert self.machine is not None
        return self.compiled

    def restart_compiled(self) -> bool:
        """Begin an interpreted walk again as machine code; see `Run.restart_compiled`."""
        if self.compiled or not can_compile(self.plan):
            return False
        self.recorder = self._new_recorder()
        vars(self).pop("machine", None)
        self._set_up(True)
        return self.compile()

    @cached_property
    def machine(self) -> Machine:
        """The walk for machine code.

        Raises:
            LawError: The controller's laws cannot be compiled.
        """
        return Machine(self.constants, self.state, self.controller)

    def peak_torque(self) -> NDArray[np.float64]:
        """Greatest magnitude of each joint's torque so far, N m."""
        return np.array(self.state.peak_torque[: self.constants.joints], dtype=np.float64)

    def pressure_times(self) -> NDArray[np.float64]:
        """Time that the centre of pressure spent in each bin so far, s; see `mjbiped.records.loads`."""
        return np.array(self.state.pressure[2:], dtype=np.float64)

    def settings(self) -> dict[str, Any]:
        """Tolerance, what the stance foot has felt in the step under way, and warnings if there are any."""
        step = step_under_way(slip=0.0, friction=self.state.friction, normal_force=self.state.normal_force)
        settings = {"tolerance": self._tolerance, **step}
        return {**settings, "warnings": self.warnings} if self.warnings else settings

    @property
    def warnings(self) -> dict[str, int]:
        """Explanations of the walk's end where the outcome says too little, as sentences with the count 1."""
        if self.state.unmapped:
            return {_UNMAPPED: 1}
        if self.ended not in _WHY:
            return {}
        fault = self._fault() if self.ended is Outcome.DIVERGED else ""
        return {fault or _WHY[self.ended]: 1}

    def _fault(self) -> str:
        """Name the torque that was no finite number at the walk's end; empty if there was none."""
        c, w, controller = self.constants, self.state, self.controller
        first = 2 * c.angles
        memory = [float(value) for value in (*w.y[first : first + c.states], *w.memory[c.states :])]
        take_angles(c, w, w.y)
        q, dq = (tuple(map(float, values)) for values in (w.told, w.told_rates))
        t = float(w.time - w.clock)
        if isinstance(controller, SampledController):
            return fault_in(controller.inner, controller.torque(memory, t, q, dq), t, q, dq)
        return fault_at(controller, memory, t, q, dq)


class Machine:
    """A walk for machine code: its constants and its state in C's memory.

    Attributes:
        code: Machine code of the laws.
    """

    def __init__(self, constants: Constants, state: State, controller: Controller) -> None:
        """Lay the walk out; the state's lists become arrays, on which plain Python works as well."""
        share_arrays(state)
        self.code = as_machine_code(controller)
        self.constants, *below = packed(constants.but(**self.code.law._asdict()))
        self.state, *further = packed(state)
        self._kept = below, further
        self._advance = ctypes.CFUNCTYPE(None, ctypes.c_int64, ctypes.c_int64)(engine_address())

    def advance(self, state: State) -> None:
        """Walk on; `state` has the pause, and then the numbers that the walk has come to."""
        for name in ("pause", "rows", "samples"):
            self.state[name] = getattr(state, name)
        self._advance(self.constants.ctypes.data, self.state.ctypes.data)
        take_numbers(state, self.state)


def engine_address() -> int:
    """The address of `gait_step.advance` as machine code for constants and state: one for all robots and laws."""
    from mjbiped.numerics.machine import compiled

    return int(compiled(advance_at, "void(int64, int64)", for_c=True).address)


@dataclass(frozen=True)
class Hybrid(Engine):
    """The paper's equations of motion and impact map, integrated from touchdown to touchdown; see docs/hybrid.md.

    It has no timestep, and its controller acts without pause, unless `mjbiped.Disturbances` make it tick.

    Attributes:
        tolerance: Of an integration step, relative and absolute.

    Raises:
        InputError: It is outside its domain.
    """

    name: ClassVar[str] = "hybrid"
    robots: ClassVar[tuple[type[Robot], ...]] = (Robot,)

    tolerance: Annotated[float, domains.Domain(1e-14, 1e-3)] = TOLERANCE

    def __post_init__(self) -> None:
        """Check the value."""
        domains.check_fields(self)

    def check_disturbances(self, disturbances: Disturbances) -> None:
        """Refuse a delay that does not fit the control period, and friction.

        Raises:
            InputError: It does not, or there is one.
        """
        if disturbances.friction is not None:
            raise InputError(
                f"friction = {disturbances.friction:g}: the hybrid engine's stance foot never slips; walk in mujoco, "
                "or see in the record how much friction is asked for"
            )
        disturbances.delay_ticks(disturbances.period(None, 0.0))

    def costs(self, robot: Robot) -> Costs:
        """See `mjbiped.engines.compiling`; measured in docs/hybrid.md."""
        return Costs(engine=25.0, step=0.045 if len(robot.angles) < 3 else 0.11)

    def start(self, plan: Plan, *, summarised: bool = False, cancellation: Cancellation = never_cancelled) -> HybridRun:
        """Set the robot on the ground; see `Engine.start`."""
        kind = resolve_name(plan.robot.runs[self.name]) if self.name in plan.robot.runs else HybridRun
        return kind(plan, self.tolerance, summarised=summarised, cancellation=cancellation)
