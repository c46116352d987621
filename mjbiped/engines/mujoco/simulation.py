"""A walk in MuJoCo: model, data, and the controller in `mjcb_control`.

No impact map is used here: MuJoCo's contact solver resolves the impacts, and contact sensors detect support transfers.
The terrain's profile only decides the length of each physics step and the softness of its contacts
(`mjbiped.engines.mujoco.step_size`), and when the departing foot stops colliding.
"""

from __future__ import annotations

import math
import weakref
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from typing import Any

import numpy as np
from numpy.typing import NDArray

from mjbiped.control.compiled import CalledMethods, MachineCode, as_machine_code
from mjbiped.engines.compiling import announced_for, compiles
from mjbiped.engines.mujoco import callback, observation, step
from mjbiped.engines.mujoco.collisions import soften, write_contact_bits
from mjbiped.engines.mujoco.constants import Constants
from mjbiped.engines.mujoco.options import Options
from mjbiped.engines.mujoco.scene import Scene, first_state
from mjbiped.engines.mujoco.setup import constants_of, settled, windows_of
from mjbiped.engines.mujoco.state import MARK, SIZE, State
from mjbiped.engines.plan import Plan
from mjbiped.numerics.blocks import packed
from mjbiped.records.columns import Recorder, tables_of, width
from mjbiped.rules.termination import Outcome
from mjbiped.utils.mujoco import mujoco

WHOLE_STATE = mujoco.mjtState.mjSTATE_INTEGRATION
BLOCK = 500  # most physics steps in one call


class Simulation:
    """A walk in MuJoCo, which a loop of your own advances by `mujoco.mj_step`.

    ```python
    robot = mjbiped.Compass()
    controller = AdaptiveController(robot, mjbiped.find_passive_gait(robot, slope=np.deg2rad(2)))
    simulation = mjbiped.Mujoco().simulation(controller, mjbiped.Terrain.mixed(), steps=10)
    with simulation.callbacks():
        mujoco.mj_step(simulation.model, simulation.data, nstep=10000)
    ```

    `advance` makes the steps of `mjbiped.walk`, which end at touchdowns.

    The whole state, the controller's memory included, is in `data`: `mujoco.mj_getState` with
    `mjtState.mjSTATE_INTEGRATION` saves it, and `mj_setState` on a simulation built alike resumes it; `advance` goes on
    from there bit for bit.

    For a terrain of more than `mjbiped.engines.mujoco.ground.FEW_SEGMENTS` segments, `model` holds only the ground
    near the robot: see `move_on`.

    Attributes:
        model: The compiled scene; the robot's file in `models/` defines qpos and ctrl.
        data: State of the model.
        controller: The controller of the robot's joints.
        options: The engine's settings.
        constants: Values that stay the same as long as the model does.
        inside: Range of the hip's x, m, in which `move_on` need not rebuild the ground.
        block: The constants for machine code; None where the walk is interpreted.
        native: `mjcb_control` as a C function; None where the walk is interpreted.
        compiled: Whether steps and laws are machine code.
    """

    block: NDArray[np.void] | None
    native: callback.Native | None

    def __init__(self, plan: Plan, options: Options, *, compile: bool | None = None, scenery: bool = False) -> None:
        """Build the scene and set the robot on it.

        Args:
            plan: The checked walk.
            options: The engine's settings.
            compile: Whether steps are machine code, and laws that can be; None: see `mjbiped.engines.compiling`.
            scenery: Whether to add a side view of the ground for pictures; the walk is the same.

        Raises:
            LawError: The controller's laws cannot be compiled.
        """
        self.plan, self.options = plan, settled(options, plan)
        self.controller = controller = plan.driven(self.options.control_period or 0.0, ticks=True)
        states, tables = len(controller.states), tables_of(type(plan.robot))
        touched = width(tables.touchdowns)
        userdata = SIZE + touched + controller.memory_size + states
        self._windows = windows_of(plan, self.options, BLOCK, userdata=userdata, scenery=scenery)
        self._buffers = np.zeros((BLOCK + 1, width(tables.samples) + states)), np.zeros((BLOCK, touched))
        self._compiling = compiles(plan) if compile is None else compile
        self._code: MachineCode | CalledMethods | None = None
        self._forget: Callable[[], object] = lambda: None
        self._error: BaseException | None = None
        self._use(self._windows.about(0.0))
        self._place(plan.q, plan.dq)

    def _use(self, scene: Scene) -> None:
        """Switch to a scene, with new data."""
        self._forget()
        scene.model.opt.timestep = self.options.timestep
        self.model, self.data = scene.model, mujoco.MjData(scene.model)
        self.inside = scene.inside
        self.constants = constants_of(self.plan, self.options, self.controller, scene, self.data, self._buffers)
        self.block = self.native = None
        if self._compiling:
            self._compile()
        address, constants = self.data._address, 0 if self.block is None else self.block.ctypes.data
        callback.register(address, self, constants)
        self._forget = weakref.finalize(self, callback.forget, address)

    def _compile(self) -> None:
        """Make machine code of the steps and of the laws, and pack the constants for it."""
        with announced_for(self.plan):
            if self._code is None:
                self._code = as_machine_code(self.controller)
            self.block, self._kept = self.packed(self.constants)
            self._advance, self.native = callback.advancing(), callback.control_callback()

    def packed(self, constants: Constants) -> tuple[NDArray[np.void], list[object]]:
        """Constants of this walk for machine code, and what has to live as long; see `numerics.blocks.packed`."""
        assert self._code is not None
        called = self._code.law._asdict()
        return packed(constants.but(state=constants.whole, failed=called["parameters"], **called))

    def ahead(self) -> Constants:
        """The walk's constants with a state and a row of their own, for `step.look_ahead`."""
        whole: Any = np.zeros(SIZE + self.constants.row_width)
        return self.constants.but(whole=whole, state=[State.from_buffer(whole)], row=whole[SIZE:])

    @property
    def compiled(self) -> bool:
        """Whether steps and laws are machine code."""
        return isinstance(self._code, MachineCode)

    def restart(self, q: Sequence[float], dq: Sequence[float]) -> None:
        """Restart the walk from another initial state, as if the simulation had just been built with it.

        Args:
            q: Angles from the ground's normal under x = 0, rad.
            dq: Their rates, rad/s.
        """
        mujoco.mj_resetData(self.model, self.data)
        self._place(q, dq)
        self.move_on()

    def _place(self, q: Sequence[float], dq: Sequence[float]) -> None:
        """Place the first stance foot at x = 0 under a straight leg, and initialise the controller's memory."""
        terrain, qpos, qvel = self.plan.terrain, [0.0] * self.model.nq, [0.0] * self.model.nv
        order = map(int, self.constants.order)
        for index, place, rate in zip(order, *first_state(self.plan.robot, terrain, q, dq), strict=True):
            qpos[index], qvel[index] = place, rate
        self.data.qpos[:], self.data.qvel[:] = qpos, qvel
        memory = [0.0] * self.controller.memory_size
        self.controller.start(memory, tuple(q), tuple(dq))
        self.constants.memory[:] = memory
        observation.begin(self.constants, self.state, terrain.slope_at(0.0), terrain.height_at(0.0))
        self.look_again()

    def look_again(self) -> None:
        """Write what is only in the model: contact bits and softness."""
        softened = self.state.softened, self.state.acted
        soften(self.constants, self.state)
        self.state.softened, self.state.acted = softened
        write_contact_bits(self.constants, self.state)

    @property
    def state(self) -> State:
        """The engine's own state, which lasts from one physics step to the next."""
        state: State = self.constants.state[0]
        return state

    @property
    def memory(self) -> list[float]:
        """A copy of the controller's memory."""
        memory: list[float] = self.constants.memory.tolist()
        return memory

    def move_on(self) -> bool:
        """Rebuild the ground around the robot if the robot nears the end of the part of a long terrain that is built.

        `model` and `data` are then new objects in the same state, and the walk continues bit for bit as on the whole
        terrain. Call this between steps, at least once per leg length; `callbacks` calls it first. A hip beyond the
        ground that is built counts as having left the terrain. Changes made to `model` by hand are lost.

        Returns:
            Whether the ground was rebuilt.
        """
        before, data, x = self.model, self.data, float(self.data.qpos[0])
        low, high = self.inside
        if low < x < high or not math.isfinite(x) or data.warning.number.any():
            return False
        state, timestep = np.empty(mujoco.mj_stateSize(before, WHOLE_STATE)), before.opt.timestep
        mujoco.mj_getState(before, data, state, WHOLE_STATE)
        self._use(self._windows.about(x))
        self.model.opt.timestep = timestep
        mujoco.mj_setState(self.model, self.data, state, WHOLE_STATE)
        self.look_again()
        return True

    def advance(self, steps: int = BLOCK, until: float = math.inf) -> int:
        """Make steps, which end at touchdowns, until the walk ends.

        Args:
            steps: Number of steps, at most.
            until: Time from which on no step begins, s.

        Returns:
            Number of steps that were made.
        """
        with self.acting():
            if self.block is not None:
                made: int = self._advance(self.block.ctypes.data, self.model._address, self.data._address, steps, until)
            else:
                made = step.advance(self.constants, self.model, self.data, steps, until)
        return made

    @contextmanager
    def acting(self) -> Iterator[None]:
        """Let `mjcb_control` act on this walk meanwhile; what a controller has raised is raised at the end."""
        native = self.native
        callback.enter(native)
        try:
            yield
        finally:
            callback.leave(native)
            self.check()

    def on_control(self) -> None:
        """Act for `mjcb_control` in plain Python; what is raised ends the walk."""
        if self._error is None:
            try:
                step.on_control(self.constants, self.data.time)
            except BaseException as error:
                self._error, self.state.outcome = error, float(Outcome.INTERRUPTED)

    @contextmanager
    def callbacks(self) -> Iterator[None]:
        """Install `mjcb_control`, which is global in MuJoCo; restore the earlier one afterwards.

        Meanwhile MuJoCo's warnings are not written to the terminal nor to MUJOCO_LOG.TXT.

        An exception in a controller's Python method ends the walk, and is raised at the end of the block.
        """
        with self.acting():
            if self.state.mark == MARK and not self.move_on():
                self.look_again()
            yield

    def check(self) -> None:
        """Raise the exception of a Python method that was called behind C; the walk can then continue."""
        code = self._code
        error = code.raised() if isinstance(code, CalledMethods) else self._error
        self._error = None
        if error is not None:
            self.state.outcome = 0.0
            raise error

    @property
    def outcome(self) -> Outcome:
        """How the walk ended, or `Outcome.WALKING`; a MuJoCo warning means that it diverged."""
        return Outcome.DIVERGED if self.data.warning.number.any() else Outcome(int(self.state.outcome))

    @property
    def over(self) -> bool:
        """Whether the walk has ended."""
        return self.outcome is not Outcome.WALKING

    def take(self, recorder: Recorder) -> int:
        """Move the contents of the buffers to a recorder; return the number of touchdowns."""
        u = self.state
        samples, rows = self._buffers[0][: int(u.samples)], self._buffers[1][: int(u.rows)]
        recorder.add(rows, samples)
        u.rows = u.samples = 0.0
        return len(rows)

    def finish(self, recorder: Recorder) -> None:
        """Move the rest of an ended walk to a recorder, with a last touchdown that the controller was not told of."""
        self.take(recorder)
        if self.over and self.state.transferred:
            recorder.add(np.array(self.constants.row)[None])
