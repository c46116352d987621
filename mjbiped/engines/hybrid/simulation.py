"""Hybrid engine: the paper's own model, equations (1) to (4), integrated from touchdown to touchdown.

`HybridSimulation` holds the state of one walk; `simulate` walks it to its end. docs/hybrid.md explains the
method, `mjbiped.engines.hybrid.gait_step` has it.
"""

from __future__ import annotations

import math
import time
from collections.abc import Sequence
from functools import cached_property, partial
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from mjbiped.control.adapters import LAWS
from mjbiped.control.compilation import MachineCode, compilable_law
from mjbiped.control.compile_errors import refused_in_words
from mjbiped.control.validation import fault_at, fault_in
from mjbiped.disturbances.pushes import NONE, Pushes, following
from mjbiped.disturbances.sampled import SampledController
from mjbiped.engines.base import Show
from mjbiped.engines.hybrid import state as at
from mjbiped.engines.hybrid.dynamics import HANDED_ON
from mjbiped.engines.hybrid.gait_step import advance
from mjbiped.engines.hybrid.models import model_of
from mjbiped.engines.hybrid.state import Buffers, Laws, SimulationConstants
from mjbiped.engines.hybrid.transfer import begin_step
from mjbiped.errors import MjbipedError
from mjbiped.numerics.dormand_prince import POWERS, STAGES_WITH_DENSE, unrolled
from mjbiped.numerics.jit import compiled
from mjbiped.records.columns import tables_of, width
from mjbiped.records.pressure import BINS
from mjbiped.records.recorder import Cancellation, Recorder, never_cancelled
from mjbiped.robots.robot import Robot
from mjbiped.rules.scuffing import ScuffingRule, chosen
from mjbiped.rules.termination import STALL_TIME, Outcome
from mjbiped.terrain.terrain import Terrain
from mjbiped.utils import domains

if TYPE_CHECKING:
    from mjbiped.control.controller import Controller

TOLERANCE = 1e-8
"""Of an integration step, relative and absolute. With `LONGEST_STEP` the state after each step of a walk is good to
1e-10 and better (docs/hybrid.md)."""

LONGEST_STEP = 0.22  # of an integration step, in units of sqrt(l / g): passive walking needs no other limit
FIRST_STEP = 0.1  # the first one tried, in the same units
_ROWS = 1024  # touchdowns between two looks at the progress bar, some 20 ms
_FIRST_STINT = 24_000  # evaluations of the law until Python first has its turn, some 2 ms
_SHORT, _LONG = 0.02, 0.08  # s: a stint shall take a time between these
_STALLS = 10  # longest gait steps of which the buffer holds the samples
_WHY = {
    Outcome.UNRESOLVED: "the torque switches, or changes, faster than the integrator can follow: name the times of its "
    "jumps in the controller's next_discontinuity, make it smooth, or walk with engine='mujoco' and a control_period",
    Outcome.DIVERGED: "torques or motion are beyond all bounds, or no numbers",
}


_TOE = (
    "the swing foot struck the ground ahead of the stance foot so that the other foot could not leave it, or slid "
    "into a riser: such an impact has no map"
)


class HybridSimulation:
    """A robot, a controller and a terrain in the hybrid model.

    Attributes:
        controller: Drives the robot's joints.
        compiled: Whether the controller's laws are compiled; a controller without `law` runs in plain Python.
        advance: `gait_step.advance` for these laws: a function of their parameters, the constants and the buffers.
        constants: Robot, ground and limits in plain numbers.
        buffers: The state of the walk.
    """

    def __init__(
        self,
        controller: Controller,
        terrain: Terrain,
        *,
        robot: Robot,
        q: Sequence[float],
        dq: Sequence[float],
        steps: int | None = None,
        distance: float | None = None,
        sample_period: float = 0.005,
        scuffing: ScuffingRule | None = None,
        tolerance: float = TOLERANCE,
        control_period: float = math.inf,
        pushes: Pushes = NONE,
        compile: bool = True,
    ) -> None:
        """Set the robot on the ground, and begin the controller's memory.

        Args:
            controller: See `controllers.Controller`.
            terrain: The ground.
            robot: The robot that walks.
            q: Its angles at the start, from the ground's normal under x = 0, rad; the stance leg is the left one.
            dq: Their rates, rad/s.
            steps: Touchdowns after which the walk is finished; None: no limit.
            distance: Position x of the stance foot at which it is finished, m; None: no limit.
            sample_period: Time between two samples, s; infinity: none but the last.
            scuffing: When the swing foot may touch the ground.
            tolerance: Of an integration step.
            control_period: Time between two ticks of a `SampledController`, s.
            pushes: At the hip.
            compile: Whether laws that can be compiled are.

        Raises:
            InputError: A value is outside its domain.
        """
        if not (isinstance(sample_period, float) and sample_period == math.inf):
            domains.SAMPLE_PERIOD.check("sample_period", sample_period)
        rule = chosen(scuffing)
        self._law = compilable_law(controller) if compile else None
        self.controller = controller
        self.compiled = self._law is not None
        model, angles, joints = model_of(robot), len(robot.angles), len(robot.joints)
        self._idle = idle_states(len(controller.states), robot) if self.compiled else 0
        size = 2 * angles + self._own + joints
        integrator = unrolled(size, untested=joints, arguments=HANDED_ON)
        if self.compiled:
            from mjbiped.control import machine_code

            functions = (*machine_code.LAWS, *integrator, *model.functions)
            self.advance: Any = compiled(
                advance, Laws, functions, inlined=(*model.hot, machine_code.torque), apart=model.apart
            )
        else:
            self.advance = partial(advance, Laws._make((*LAWS, *integrator, *model.functions)))
        self._robot, self._write_state = robot, model.write_state
        self.constants = SimulationConstants(
            robot=model.constants(robot, self.compiled),
            angles=angles,
            joints=joints,
            length=robot.leg_length,
            mass=robot.total_mass,
            gravity=robot.gravity,
            x=self._table(terrain.x),
            z=self._table(terrain.z),
            gradient=self._table(terrain.gradients),
            angle=self._table(terrain.angle),
            contact=1.0 if robot.knees else 0.0,
            reach=rule.reach * robot.leg_length,
            delay=float(rule.delay),
            stall_time=STALL_TIME * math.sqrt(robot.leg_length / robot.gravity),
            end=terrain.end,
            steps=math.inf if steps is None else float(steps),
            distance=math.inf if distance is None else float(distance),
            tolerance=tolerance
            * math.sqrt(1.0 - self._idle / (size - joints)),  # of a mean, to which idle ones add none
            longest_step=LONGEST_STEP * math.sqrt(robot.leg_length / robot.gravity),
            sample_period=float(sample_period),
            control_period=control_period,
            pushes=pushes,
        )
        self.buffers = self._begin(terrain, q, dq)
        self._stint = _FIRST_STINT

    @property
    def _own(self) -> int:
        """How many of the controller's states are integrated with the robot's, idle ones included."""
        return self._idle + len(self.controller.states)

    def _memory(self) -> list[float]:
        """The controller's memory, with the states last reached."""
        buffers, own, first = self.buffers, self._own, 2 * self.constants.angles
        memory = [*buffers.y[first : first + own], *buffers.memory[own:]]
        return [float(value) for value in memory[self._idle :]]

    def _table(self, values: Sequence[float]) -> Any:
        """Numbers as the engine reads them: an array for compiled code, which plain Python reads slower than a list."""
        return np.array(values, dtype=np.float64) if self.compiled else list(values)

    def _begin(self, terrain: Terrain, q: Sequence[float], dq: Sequence[float]) -> Buffers:
        """Buffers of a walk that starts with the left foot at x = 0."""
        controller, constants = self.controller, self.constants
        own = self._own
        angles, joints = constants.angles, constants.joints
        n = 2 * angles + own + joints
        memory = [0.0] * controller.memory_size
        controller.start(memory, tuple(map(float, q)), tuple(map(float, dq)))
        memory = [0.0] * self._idle + memory
        w = [0.0] * at.SCALARS
        slope = terrain.slope_at(0.0)
        w[at.SLOPE], w[at.SINE], w[at.COSINE] = slope, math.sin(slope), math.cos(slope)
        w[at.FOOT_Z] = terrain.height_at(0.0)
        w[at.SEGMENT] = w[at.FOOT_SEGMENT] = float(terrain.segment_at(0.0))
        w[at.FACE_X] = math.nan
        begin_step(constants, w)
        if self._robot.knees and q[2] == q[1] and dq[2] == dq[1]:
            w[at.LOCKED] = at.KNEE_RESTING
        w[at.PAUSE] = w[at.FIRST_STEP] = math.inf
        w[at.NEXT_PUSH], w[at.PUSH_IMPULSE] = following(constants.pushes, 0, 0.0)
        w[at.NEXT_TICK] = 0.0 if isinstance(controller, SampledController) else math.inf
        w[at.NEXT_STEP] = FIRST_STEP * math.sqrt(constants.length / constants.gravity)
        samples, columns = 1, tables_of(type(self._robot))
        if math.isfinite(constants.sample_period):
            samples += (_STALLS if self.compiled else 2) * (int(constants.stall_time / constants.sample_period) + 3)
        return Buffers(
            y=self._table([*q, *dq, *memory[:own], *[0.0] * joints]),
            out=self._table([0.0] * n),
            spare=self._table([0.0] * n),
            k=self._table([0.0] * (n * STAGES_WITH_DENSE)),
            dense=self._table([0.0] * (n * POWERS)),
            w=self._table(w),
            memory=self._table(memory),
            rows=np.zeros((_ROWS if self.compiled else 1, width(columns.touchdowns))),
            samples=np.zeros((samples, width(columns.samples) + own)),
        )

    @property
    def outcome(self) -> Outcome:
        """How the walk ended, or `Outcome.WALKING`."""
        return Outcome(int(self.buffers.w[at.OUTCOME]))

    @property
    def warnings(self) -> dict[str, int]:
        """Why the walk ended, where its outcome does not say it: sentences, and how often each is meant."""
        if self.buffers.w[at.TOE]:
            return {_TOE: 1}
        if self.outcome not in _WHY:
            return {}
        fault = self._fault() if self.outcome is Outcome.DIVERGED else ""
        return {fault or _WHY[self.outcome]: 1}

    def _fault(self) -> str:
        """Which torque was no number where the walk ended, in words; empty if none was."""
        w, memory = self.buffers.w, self._memory()
        state, angles = [float(value) for value in self.buffers.y], self.constants.angles
        q, dq = tuple(state[:angles]), tuple(state[angles : 2 * angles])
        t, controller = float(w[at.TIME] - w[at.CLOCK]), self.controller
        if isinstance(controller, SampledController):
            return fault_in(controller.inner, controller.torque(memory, t, q, dq), t, q, dq)
        return fault_at(controller, memory, t, q, dq)

    @property
    def peak_torque(self) -> NDArray[np.float64]:
        """Greatest magnitude of each joint's torque so far, N m."""
        joints = range(self.constants.joints)
        return np.array([self.buffers.w[at.PEAK_ANKLE + joint] for joint in joints], dtype=np.float64)

    @property
    def pressure_times(self) -> NDArray[np.float64]:
        """How long the centre of pressure was where so far, s; see `mjbiped.records.pressure`."""
        return np.array(self.buffers.w[at.PRESSURE_TIMES : at.PRESSURE_TIMES + BINS], dtype=np.float64)

    @cached_property
    def code(self) -> MachineCode | None:
        """The machine code of the controller's laws, where they are compiled."""
        if self._law is None:
            return None
        with refused_in_words(self.controller, self._law):
            states, size, joints = len(self.controller.states), self.controller.memory_size, self.constants.joints
            return MachineCode(self._law, states, size, contract=True, joints=joints, idle=self._idle)

    @property
    def parameters(self) -> Any:
        """What `advance` takes for the controller.

        Raises:
            LawError: The controller's laws cannot be compiled.
        """
        return self.controller if self.code is None else self.code.law

    def compile(self) -> None:
        """Compile the controller's laws now, where they are compiled, and not at the first step.

        Raises:
            LawError: They cannot be compiled.
        """
        if self.compiled:
            import numba

            self.advance.compile(tuple(map(numba.typeof, (self.parameters, self.constants, self.buffers))))

    def go_on(self, cancellation: Cancellation = never_cancelled) -> None:
        """Walk some steps further; rows and samples are then in the buffers, for `take`.

        Compiled code cannot be interrupted. So Python has its turn, and thus Ctrl-C, after stints of so many
        evaluations that they take less than 0.1 s; how many they are changes nothing in the walk.

        Args:
            cancellation: Called between the stints; what it raises breaks the walk off.

        Raises:
            LawError: The controller's laws cannot be compiled.
        """
        w, parameters = self.buffers.w, self.parameters
        while True:
            w[at.PAUSE] = w[at.EVALUATIONS] + self._stint
            started = time.perf_counter()
            self.advance(parameters, self.constants, self.buffers)
            if self.code is not None and self.code.failed:
                raise MjbipedError("a compiled law raised an exception; let law() return None to see where")
            if w[at.EVALUATIONS] < w[at.PAUSE] or self.outcome is not Outcome.WALKING:
                return
            taken = time.perf_counter() - started
            if taken < _SHORT:
                self._stint *= 4
            elif taken > _LONG:
                self._stint = max(self._stint // 4, 1)
            cancellation()

    def take(self, recorder: Recorder) -> int:
        """Hand what the buffers hold on, and empty them; returns the number of touchdowns."""
        buffers = self.buffers
        rows, samples = int(buffers.w[at.ROWS]), int(buffers.w[at.SAMPLES])
        recorder.add(buffers.rows[:rows], self._recorded(buffers.samples[:samples]))
        buffers.w[at.ROWS] = buffers.w[at.SAMPLES] = 0.0
        return rows

    def sample(self, recorder: Recorder) -> None:
        """Record the last state reached, with the torque last computed, and without asking the controller."""
        buffers, w = self.buffers, self.buffers.w
        state = [float(value) for value in buffers.y]
        row = np.empty((1, buffers.samples.shape[1]))
        estimate = self.controller.slope_estimate(self._memory())
        self._write_state(self.constants, buffers, row[0], w[at.TIME], state, estimate)
        recorder.add(buffers.rows[:0], self._recorded(row))

    def _recorded(self, samples: NDArray[np.float64]) -> NDArray[np.float64]:
        """Samples without the idle states, which stand behind the robot's columns, where the controller has none."""
        return samples[:, : samples.shape[1] - self._idle]


def idle_states(states: int, robot: Robot) -> int:
    """How many idle states compiled code has for a controller with so many of its own.

    Machine code is for one length of the state, and takes long with knees: a controller without states has as many as
    the adaptive law.
    """
    return 2 if robot.knees and states == 0 else 0


def simulate(simulation: HybridSimulation, recorder: Recorder, show: Show | None = None) -> Outcome:
    """Walk until the walk ends, recording as it goes.

    Args:
        simulation: As built.
        recorder: Takes samples and touchdowns; what it holds is complete at any moment, also when this raises.
        show: Called from time to time, for a progress bar.

    Returns:
        The outcome.
    """
    while simulation.outcome is Outcome.WALKING:
        try:
            recorder.cancellation()
            simulation.go_on(recorder.cancellation)
        except BaseException:
            simulation.take(recorder)
            simulation.sample(recorder)
            raise
        steps = simulation.take(recorder)
        if show is not None:
            show(steps, float(simulation.buffers.w[at.FOOT_X]))
    return simulation.outcome
