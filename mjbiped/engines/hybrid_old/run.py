"""`HybridRun`: one walk of the paper's own model, equations (1) to (4), integrated from touchdown to touchdown.

docs/hybrid.md explains the method, `mjbiped.engines.hybrid.gait_step` implements it.
"""

from __future__ import annotations

import math
import time
from functools import cached_property, partial
from typing import Any

import numpy as np
from numpy.typing import NDArray

from mjbiped.control.adapters import LAWS
from mjbiped.control.compilation import MachineCode, compilable_law, unpacking
from mjbiped.control.compile_errors import refused_in_words
from mjbiped.control.validation import fault_at, fault_in
from mjbiped.disturbances.pushes import following
from mjbiped.disturbances.sampled import SampledController
from mjbiped.engines.base import Run, Show
from mjbiped.engines.compiling import announced_for, can_compile, compiles
from mjbiped.engines.hybrid.accounting import write_state
from mjbiped.engines.hybrid.dynamics import rates
from mjbiped.engines.hybrid.gait_step import advance
from mjbiped.engines.hybrid.stance import on_sole
from mjbiped.engines.hybrid.state import Constants, Ground, Laws, State, Tables, Walk
from mjbiped.engines.hybrid.transfer import begin_gait_step
from mjbiped.engines.hybrid.tuples import Tuples, tuples_of
from mjbiped.engines.plan import Plan
from mjbiped.errors import MjbipedError
from mjbiped.numerics.dormand_prince import POWERS, STAGES_WITH_DENSE, unrolled
from mjbiped.numerics.jit import compiled
from mjbiped.numerics.records import Packer, Shared, in_one_block
from mjbiped.records.pressure import BINS
from mjbiped.records.recorder import Cancellation, never_cancelled
from mjbiped.records.rows import rows_of
from mjbiped.robots.chain import hold_end
from mjbiped.robots.equations import FREE, LOCKED, RESTING
from mjbiped.robots.robot import Robot
from mjbiped.rules.termination import STALL_TIME, Outcome
from mjbiped.terrain.terrain import Terrain

TOLERANCE = 1e-8
"""Relative and absolute tolerance of an integration step. With `LONGEST_STEP` it keeps the states after touchdowns
accurate to some 1e-10 (docs/hybrid.md)."""

LONGEST_STEP = 0.22  # longest integration step, in sqrt(l / g): the only limit that passive walking needs
FIRST_STEP = 0.1  # length of the first trial step, in the same units
_ROWS = 1024  # touchdowns between updates of the progress bar, some 20 ms
_MEMORY = 1024  # floats kept for a compiled controller's memory, delays included: one machine code serves all
_FIRST_STINT = 24_000  # evaluations of the law until compiled code first returns to Python, some 2 ms
_SHORT, _LONG = 0.02, 0.08  # wanted duration of a stint of compiled code, s
_STALLS = 10  # number of longest gait steps whose samples fit in the buffer
_WHY = {
    Outcome.UNRESOLVED: "the torque switches, or changes, faster than the integrator can follow: name the times of its "
    "jumps in the controller's next_discontinuity, make it smooth, or walk with engine='mujoco' and a control_period",
    Outcome.DIVERGED: "torques or motion are beyond all bounds, or no numbers",
}
_TOE = (
    "the swing foot struck the ground ahead of the stance foot so that the other foot could not leave it, or slid "
    "into a riser: such an impact has no map"
)


class HybridRun(Run):
    """A walk in the hybrid model.

    Attributes:
        controller: The controller that the engine calls: the plan's, in a loop that ticks if disturbances need one.
        compiled: Whether the controller's laws are compiled; a controller without `law` runs in plain Python.
        advance: `gait_step.advance` for these laws: a function of their parameters, the constants and the state.
        constants: Robot, rules and limits.
        tables: Ground, pushes, and the buffers of the record.
        state: The state of the walk.
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
        """Make everything that the walk begins with, for compiled code or for plain Python."""
        plan, control_period = self.plan, self.plan.disturbances.period(None, 0.0)
        self.controller, self._stint = plan.driven(control_period), _FIRST_STINT
        self._law = compilable_law(self.controller) if compile else None
        self.compiled = self._law is not None
        states, robot = len(self.controller.states), plan.robot
        self._idle = idle_states(states, robot) if self.compiled else 0
        self._own = self._idle + states
        self.tables = self._begin_tables()
        self.constants = self._begin_constants(control_period)
        self.state = self._begin()
        tuples = tuples_of(len(self.state.strike_q), len(robot.joints), self._own, tips=bool(robot.untold))
        self.functions = _functions(robot, tuples, len(self.state.y))
        if self.compiled:
            from mjbiped.control import machine_code

            self._packed, unpack = packed(self.tables)
            self.constants.tables = self._packed.ctypes.data
            self.constants, self.state = in_one_block(self.constants), in_one_block(self.state)
            inlined: tuple[Any, ...] = (rates, machine_code.torque, *tuples)
            if robot.equations.inlined:
                inlined += (robot.equations.accelerations,)
            functions = (*machine_code.LAWS, unpack, *self.functions)
            self.advance: Any = compiled(advance, Laws, functions, inlined=inlined, apart=(hold_end, on_sole))
        else:
            self.advance = partial(advance, self.plain.laws)

    @property
    def plain(self) -> Walk:
        """Argument of the engine's functions for this walk, in plain Python."""
        laws = Laws._make((*LAWS, self._own_tables, *self.functions))
        return Walk(laws, self.controller, self.constants, self.state)

    def _own_tables(self, _: Any) -> Tables:
        """Return the tables, as `Laws.tables` does in plain Python."""
        return self.tables

    def _begin_tables(self) -> Tables:
        """Make the tables: ground, pushes and empty buffers of the record."""
        plan, rows = self.plan, rows_of(type(self.plan.robot))
        terrain, samples = plan.terrain, 1
        if math.isfinite(self._sample_period):
            longest = int(_stall_time(plan.robot) / self._sample_period) + 3
            samples += (_STALLS if self.compiled else 2) * longest
        ground = raised(terrain, _height(plan.robot))
        # plain Python reads arrays slower than lists
        kind = partial(np.array, dtype=np.float64) if self.compiled else list
        return Tables(
            ground=Ground(*(kind(each) for each in ground)),
            pushes=plan.disturbances.schedule,
            rows=np.zeros((_ROWS if self.compiled else 1, rows.touched)),
            samples=np.zeros((samples, rows.sampled + self._own)),
        )

    @property
    def _sample_period(self) -> float:
        """Time between two samples, s; infinite if only the last one is kept."""
        period = self.plan.terms.sample_period
        return float(period) if period is not None and self.sampled else math.inf

    def _begin_constants(self, control_period: float) -> Any:
        """Collect robot, rules and limits as plain numbers."""
        robot, terms = self.plan.robot, self.plan.terms
        foot, asks = robot.bodies.foot, self.controller.support
        behind, ahead = (robot.sole if foot is None else None) or (math.inf, math.inf)
        return Constants(
            robot=robot.equations.constants(robot),
            tables=0,
            length=robot.leg_length,
            radius=robot.radius,
            behind=behind,
            ahead=ahead,
            heel=0.0 if foot is None else foot.behind,
            toe=0.0 if foot is None else foot.ahead,
            support=-1 if foot is None or asks < 0 else self._idle + asks,
            height=_height(robot),
            mass=robot.total_mass,
            gravity=robot.gravity,
            legs=len(robot.bodies.limbs),
            contact=robot.collides_from_lift_off,
            reach=terms.scuffing.reach * robot.leg_length,
            delay=float(terms.scuffing.delay),
            stall_time=_stall_time(robot),
            end=self.plan.terrain.end,
            steps=math.inf if terms.steps is None else float(terms.steps),
            distance=math.inf if terms.distance is None else float(terms.distance),
            tolerance=self._tolerance,
            tested=float(2 * _angles(robot) + self._own - self._idle),
            longest_step=LONGEST_STEP * math.sqrt(robot.leg_length / robot.gravity),
            sample_period=self._sample_period,
            control_period=control_period,
        )

    def _begin(self) -> Any:
        """Make the initial state, with the left foot at x = 0."""
        plan, controller, terrain, constants = self.plan, self.controller, self.plan.terrain, self.constants
        angles, joints = _angles(plan.robot), len(plan.robot.joints)
        q, dq = list(map(float, plan.q)), list(map(float, plan.dq))
        memory = [0.0] * controller.memory_size
        controller.start(memory, tuple(q), tuple(dq))
        memory = [0.0] * self._idle + memory
        if self.compiled:
            memory += [0.0] * (_MEMORY * (1 + len(memory) // _MEMORY) - len(memory))
        flat = [0.0] * (angles - len(q))
        y = [*q, *flat, *dq, *flat, *memory[: self._own], *[0.0] * joints]
        slope, segment = terrain.slope_at(0.0), int(terrain.segment_at(0.0))
        push, impulse = following(plan.disturbances.schedule, 0, 0.0)
        thigh, shank = constants.robot.thigh, constants.robot.shank
        straight = q[thigh] == q[shank] and dq[thigh] == dq[shank]
        state = State(
            y=y,
            out=[0.0] * len(y),
            spare=[0.0] * len(y),
            ddq=[0.0] * angles,
            k=[0.0] * (len(y) * STAGES_WITH_DENSE),
            dense=[0.0] * (len(y) * POWERS),
            memory=memory,
            torques=[0.0] * (joints * STAGES_WITH_DENSE),
            asked=[0.0] * STAGES_WITH_DENSE,
            normals=[0.0] * STAGES_WITH_DENSE,
            moments=[0.0] * STAGES_WITH_DENSE,
            margins=[math.inf] * STAGES_WITH_DENSE,
            peak_torque=[0.0] * joints,
            pressure=[0.0] * (2 + BINS),
            strike_q=[0.0] * angles,
            strike_dq=[0.0] * angles,
            struck_dq=[0.0] * angles,
            slope=slope,
            sine=math.sin(slope),
            cosine=math.cos(slope),
            segment=segment,
            foot_x=constants.height * math.sin(slope),
            foot_z=terrain.height_at(0.0) + constants.height * math.cos(slope),
            foot_segment=segment,
            next_tick=0.0 if isinstance(controller, SampledController) else math.inf,
            next_push=push,
            push_impulse=impulse,
            next_step=FIRST_STEP * math.sqrt(constants.length / constants.gravity),
            locked=LOCKED if thigh == shank else RESTING if straight else FREE,
        )
        begin_gait_step(state, constants.contact)
        return state

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

        Compiled code cannot be interrupted. It therefore works in stints of some evaluations that take less than 0.1 s,
        between which Python handles Ctrl-C; the number of evaluations changes nothing in the walk.

        Raises:
            LawError: The controller's laws cannot be compiled.
        """
        w, parameters = self.state, self.parameters
        while True:
            w.pause = w.evaluations + self._stint
            started = time.perf_counter()
            self.advance(parameters, self.constants, w)
            if self.code is not None and self.code.failed:
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
        w, tables = self.state, self.tables
        rows, samples = int(w.rows), int(w.samples)
        self.recorder.add(tables.rows[:rows], self._recorded(tables.samples[:samples]))
        w.rows = w.samples = 0
        return rows

    def _sample(self) -> None:
        """Record the last state reached with the last torque computed, without calling the controller's `torque`."""
        row, w = np.empty((1, self.tables.samples.shape[1])), self.state
        estimate = self.controller.slope_estimate(self._memory())
        torques = (float((w.torques if self.constants.behind == math.inf else w.asked)[0]), w.torques)
        write_state(self.plain, row[0], w.time, [float(value) for value in w.y], torques, estimate)
        self.recorder.add(self.tables.rows[:0], self._recorded(row))

    def _recorded(self, samples: NDArray[np.float64]) -> NDArray[np.float64]:
        """Remove the idle states from samples: the last columns, since a controller with idle states has no others."""
        return samples[:, : samples.shape[1] - self._idle]

    def _memory(self) -> list[float]:
        """The controller's memory, with its integrated states as last reached."""
        first = 2 * len(self.state.strike_q)
        memory = [*self.state.y[first : first + self._own], *self.state.memory[self._own :]]
        return [float(value) for value in memory[self._idle : self._idle + self.controller.memory_size]]

    def compile(self) -> bool:
        """Compile the controller's laws now, not at the first step; return whether they are compiled at all.

        Raises:
            LawError: The laws cannot be compiled.
        """
        if self.compiled:
            import numba

            with announced_for(self.plan):
                self.advance.compile(tuple(map(numba.typeof, (self.parameters, self.constants, self.state))))
        return self.compiled

    def restart_compiled(self) -> bool:
        """Begin an interpreted walk again as machine code; see `Run.restart_compiled`."""
        if self.compiled or not can_compile(self.plan):
            return False
        self.recorder = self._new_recorder()
        vars(self).pop("code", None)  # an interpreted walk has none
        self._set_up(True)
        return self.compile()

    @cached_property
    def code(self) -> MachineCode | None:
        """Machine code of the controller's laws; None if they run in plain Python."""
        if self._law is None:
            return None
        with refused_in_words(self.controller, self._law):
            states, size, joints = len(self.controller.states), self.controller.memory_size, len(self.plan.robot.joints)
            return MachineCode(self._law, states, size, joints=joints, idle=self._idle)

    @property
    def parameters(self) -> Any:
        """First argument of `advance`: the block of compiled laws, or the controller itself.

        Raises:
            LawError: The controller's laws cannot be compiled.
        """
        return self.controller if self.code is None else self.code.block

    def peak_torque(self) -> NDArray[np.float64]:
        """Greatest magnitude of each joint's torque so far, N m."""
        return np.array(self.state.peak_torque, dtype=np.float64)

    def pressure_times(self) -> NDArray[np.float64]:
        """Time that the centre of pressure spent in each bin so far, s; see `mjbiped.records.pressure`."""
        return np.array(self.state.pressure[2:], dtype=np.float64)

    def settings(self) -> dict[str, Any]:
        """The engine's settings: tolerance, and warnings if there are any."""
        settings: dict[str, Any] = {"tolerance": self._tolerance}
        return {**settings, "warnings": self.warnings} if self.warnings else settings

    @property
    def warnings(self) -> dict[str, int]:
        """Explanations of the walk's end where the outcome says too little, as sentences with the count 1."""
        if self.state.toe:
            return {_TOE: 1}
        if self.ended not in _WHY:
            return {}
        fault = self._fault() if self.ended is Outcome.DIVERGED else ""
        return {fault or _WHY[self.ended]: 1}

    def _fault(self) -> str:
        """Name the torque that was no finite number at the walk's end; empty if there was none."""
        w, memory, controller = self.state, self._memory(), self.controller
        functions, state = self.plain.laws, [float(value) for value in w.y]
        q, dq = functions.told(functions.q(state)), functions.told_rates(functions.dq(state))
        t = float(w.time - w.clock)
        if isinstance(controller, SampledController):
            return fault_in(controller.inner, controller.torque(memory, t, q, dq), t, q, dq)
        return fault_at(controller, memory, t, q, dq)


def idle_states(states: int, robot: Robot) -> int:
    """Number of idle states with which compiled code pads the state for a controller with `states` of its own.

    Machine code is made for one length of the state, and compiles slowly for robots with long equations. There, a
    controller without states gets as many idle ones as the adaptive law has states, to share its code.
    """
    return 0 if robot.equations.inlined or states else 2


def _angles(robot: Robot) -> int:
    """Number of angles of a robot's equations."""
    return len(robot.angles) + len(robot.untold)


def _height(robot: Robot) -> float:
    """Height over the ground of what moves as a point foot does, m: a round foot's centre, or the ankle of a foot."""
    foot = robot.bodies.foot
    return robot.radius if foot is None else foot.height


def raised(terrain: Terrain, height: float) -> Ground:
    """The ground as points meet it that are so far from it, m: each segment is moved along its normal.

    Where two segments meet at an angle, and not at a riser, so do they afterwards.
    """
    slant = np.hypot(1.0, terrain.gradients)
    x, z = np.array(terrain.x), terrain.z + height * slant
    if height > 0.0:
        change = np.diff(terrain.gradients)
        meets = (np.array(terrain.rises[1:]) == 0.0) & (change != 0.0)
        x[1:][meets] -= height * (np.diff(slant)[meets] / change[meets])
        z += terrain.gradients * (x - terrain.x)
    return Ground(x, z, terrain.gradients, terrain.angle)


def _stall_time(robot: Robot) -> float:
    """Longest time without touchdown, s."""
    return STALL_TIME * math.sqrt(robot.leg_length / robot.gravity)


def _functions(robot: Robot, tuples: Tuples, size: int) -> tuple[Any, ...]:
    """Functions of `Laws` that follow the controller's and `tables`, for a state `y` of `size` components."""
    rows, e = rows_of(type(robot)), robot.equations
    return (
        *unrolled(size, untested=len(robot.joints), arguments=("s",)),
        *tuples,
        *(e.accelerations, e.stop_foot, e.lands, e.exchange, e.lock_knee, e.limbs, e.ground_force, e.turn_foot),
        *(rows.write_sample, rows.write_touchdown),
    )


def packed(tables: Tables) -> tuple[NDArray[np.float64], Any]:
    """Pack tables for compiled code, which reads and writes their arrays in place.

    Returns:
        A block of numbers, whose address goes into `Constants.tables`, and a compiled function that rebuilds the tables
        from it. Keep block and arrays alive while the engine runs.
    """
    packer = Packer()
    shared = Tables(Ground(*map(Shared, tables.ground)), tables.pushes, Shared(tables.rows), Shared(tables.samples))
    unpack = unpacking(packer.add(shared), tuple(packer.classes.items()))
    return packer.record(), unpack
