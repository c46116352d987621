"""MuJoCo engine: rigid bodies, contacts, and a controller in `mjcb_control`.

No impact map is used here: MuJoCo's contact solver resolves the impacts, and contact sensors detect support transfers.
The terrain's profile only decides the length of each physics step and the softness of its contacts
(`mjbiped.engines.mujoco.step_size`), and when the departing foot stops colliding. `Simulation` holds model and state;
`mjbiped.engines.mujoco.run` walks it to its end.
"""

from __future__ import annotations

import math
import warnings
from collections import Counter
from collections.abc import Iterator, Sequence
from contextlib import ExitStack, contextmanager
from dataclasses import replace
from functools import cached_property, lru_cache
from typing import Any

import numpy as np
from numpy.typing import NDArray

from mjbiped.control import adapters
from mjbiped.control.compiled import CalledMethods, MachineCode, compilable_law, refused_in_words
from mjbiped.disturbances.sampled import SampledController
from mjbiped.engines.compiling import announced_for, compiles
from mjbiped.engines.mujoco import leapfrog, motors, observation, step_size
from mjbiped.engines.mujoco.compiled import registry
from mjbiped.engines.mujoco.compiled.callbacks import ACCELERATION, POSITION, Native, attached, check_offsets
from mjbiped.engines.mujoco.compiled.layout import UnknownLayoutError
from mjbiped.engines.mujoco.contacts import refuses
from mjbiped.engines.mujoco.feet import foot_servo, for_feet
from mjbiped.engines.mujoco.ground_window import MARGIN, GroundWindows, places_in
from mjbiped.engines.mujoco.motors import Parts, Recording, Setting
from mjbiped.engines.mujoco.options import MOTOR, ROOM, Options
from mjbiped.engines.mujoco.scene import Scene, first_state
from mjbiped.engines.mujoco.servo import NONE, servo_of
from mjbiped.engines.mujoco.state import SIZE, Constants, Places, Softness, State, Userdata
from mjbiped.engines.mujoco.termination import ground_needed, limits_of
from mjbiped.engines.plan import DEFAULT_SAMPLE_PERIOD, Plan
from mjbiped.records.columns import index_of, tables_of
from mjbiped.records.recorder import Recorder
from mjbiped.records.rows import rows_of
from mjbiped.rules.termination import Outcome
from mjbiped.utils.mujoco import mujoco

WHOLE_STATE = mujoco.mjtState.mjSTATE_INTEGRATION
BLOCK = 500  # most physics steps in one call


class Simulation:
    """A walk in MuJoCo, which `mujoco.mj_step` advances while its callbacks are installed.

    ```python
    robot = mjbiped.Compass()
    controller = AdaptiveController(robot, mjbiped.find_passive_gait(robot, slope=np.deg2rad(2)))
    simulation = mjbiped.Mujoco().simulation(controller, mjbiped.Terrain.mixed(), steps=10)
    with simulation.callbacks():
        mujoco.mj_step(simulation.model, simulation.data, nstep=1000)
    ```

    The whole state, the controller's memory included, is in `data`: `mujoco.mj_getState` with
    `mjtState.mjSTATE_INTEGRATION` saves it, and `mj_setState` on a simulation built alike resumes it bit for bit.

    For a terrain of more than `mjbiped.engines.mujoco.ground.FEW_SEGMENTS` segments, `model` holds only the ground
    near the robot: see `move_on`.

    Attributes:
        model: The compiled scene; the robot's file in `models/` defines qpos and ctrl.
        data: State of the model.
        controller: The controller of the robot's joints.
        options: The engine's settings.
        limits: Limits at which the walk ends.
        constants: Values that stay the same as long as the model does.
        inside: Range of the hip's x, m, in which `move_on` need not rebuild the ground.
        recording: Buffers of samples and touchdowns; once full they take no more until `take` empties them.
        warnings: Counts of MuJoCo's warnings by text, while this simulation's callbacks were installed.
    """

    model: mujoco.MjModel
    data: mujoco.MjData
    constants: Constants
    inside: tuple[float, float]

    def __init__(self, plan: Plan, options: Options, *, compile: bool | None = None, scenery: bool = False) -> None:
        """Build the scene and set the robot on it.

        Args:
            plan: The checked walk.
            options: The engine's settings. If physics steps do not end at touchdowns, the model never changes and can
                serve many walks at the same time.
            compile: Whether to compile callbacks, and laws that can be; None: see `mjbiped.engines.compiling`.
            scenery: Whether to add a side view of the ground for pictures; the walk is the same.
        """
        robot, terms, disturbances = plan.robot, plan.terms, plan.disturbances
        if robot.bodies.foot is not None:
            options = for_feet(options, robot.bodies.foot)
        if disturbances.in_loop:
            options = replace(options, control_period=disturbances.period(options.control_period, options.timestep))
        self.plan, self.options = plan, options
        self._compile = compiles(plan) if compile is None else compile
        self.controller = controller = plan.driven(options.control_period or 0.0)
        states, self._rows = len(controller.states), rows_of(type(robot))
        # path of the hip, m; a faster one would fly
        block = BLOCK * options.timestep * math.sqrt(robot.gravity * robot.leg_length)
        self._windows = GroundWindows(
            robot,
            plan.terrain,
            timestep=self._shortest,
            reach=ground_needed(robot, terms.steps, terms.distance),
            ground=options.ground,
            userdata=SIZE + self._rows.touched + controller.memory_size + states,
            scenery=scenery,
            margin=MARGIN * robot.leg_length + block,
        )
        whole = (self._windows.start, self._windows.end)
        self.limits = limits_of(
            robot, terms.scuffing, options.timestep, whole, terms.steps, terms.distance, options.lands
        )
        period = terms.sample_period
        self.recording = Recording(
            # set even if no samples are kept: the last one tells where an interrupted walk stopped
            sample_period=DEFAULT_SAMPLE_PERIOD if period is None else period,
            samples=np.zeros((BLOCK + 1, self._rows.sampled + states)),
            rows=np.zeros((BLOCK, self._rows.touched)),
        )
        self._attachment: ExitStack | None = None
        self.warnings: Counter[str] = Counter()
        self._use(self._windows.about(0.0))
        self._place(plan.q, plan.dq)

    @property
    def _shortest(self) -> float:
        """Length of the physics steps that resolve impacts, s."""
        options = self.options
        return min(options.contact_timestep, options.timestep) if options.lands else options.timestep

    def _use(self, scene: Scene) -> None:
        """Switch to a scene, with new data."""
        scene.model.opt.timestep = self.options.timestep
        self.model, self.data = scene.model, mujoco.MjData(scene.model)
        self.inside = self._windows.inside(scene)
        places = places_in(scene, self.plan.terrain, self.plan.robot)
        self.constants = self._constants(scene, places)
        if self.plan.disturbances.friction is not None:  # the feet's friction has priority over the ground's
            self.model.geom_friction[np.array(places.owner) >= 0.0, 0] = self.plan.disturbances.friction
        self._here = self._userdata_of(self.data)

    def _constants(self, scene: Scene, places: Places) -> Constants:
        """Collect the values that stay the same while a scene is used."""
        plan, options, controller = self.plan, self.options, self.controller
        robot, columns = plan.robot, tables_of(type(plan.robot)).touchdowns
        scuffs, shortest = not robot.collides_from_lift_off, self._shortest
        foot = robot.bodies.foot
        # a foot with mass bounds no torque: it tips
        behind, ahead = (math.inf, math.inf) if robot.sole is None or foot is not None else robot.sole
        return Constants(
            limits=self.limits._replace(start=scene.start, end=scene.end),
            places=places,
            joints=(0.0,) * len(robot.joints),
            scuffs=scuffs,
            stepped=any(plan.terrain.rises),
            # twice the path in a timestep after a fall through a leg length
            deepest=2.0 * options.timestep * math.sqrt(2.0 * robot.gravity * robot.leg_length),
            timestep=options.timestep,
            contact_timestep=shortest,
            sliding=shortest if scuffs else max(options.timestep / step_size.SLIDING, shortest),
            lands=options.lands,
            control_period=options.control_period or 0.0,
            memory_size=controller.memory_size,
            states=len(controller.states),
            sampled=isinstance(controller, SampledController),
            estimates=(index_of(columns, "slope_estimate_before"), index_of(columns, "slope_estimate")),
            touched=self._rows.touched,
            sampled_columns=self._rows.sampled,
            pushes=plan.disturbances.schedule,
            servo=servo_of(robot) if options.stance_knee == MOTOR else NONE,
            behind=behind,
            ahead=ahead,
            radius=robot.radius,
            feet=foot is not None,
            box=foot is not None and foot.box,
            support=-1 if foot is None else controller.support,
            foot_servo=NONE if foot is None else foot_servo(foot, robot.leg_length, robot.gravity),
            knee_opens=robot.knee_opens,
        )

    def restart(self, q: Sequence[float], dq: Sequence[float]) -> None:
        """Restart the walk from another initial state, as if the simulation had just been built with it.

        Args:
            q: Angles from the ground's normal under x = 0, rad.
            dq: Their rates, rad/s.
        """
        mujoco.mj_resetData(self.model, self.data)
        self.warnings.clear()
        self._place(q, dq)
        self.move_on()

    def _place(self, q: Sequence[float], dq: Sequence[float]) -> None:
        """Place the first stance foot at x = 0 under a straight leg, and initialise the controller's memory."""
        terrain, qpos, qvel = self.plan.terrain, [0.0] * self.model.nq, [0.0] * self.model.nv
        slope, height = terrain.slope_at(0.0), terrain.height_at(0.0)
        states = zip(self.constants.places.order, *first_state(self.plan.robot, terrain, q, dq), strict=True)
        for index, place, rate in states:
            qpos[index], qvel[index] = place, rate
        self.data.qpos[:] = qpos
        self.data.qvel[:] = qvel
        u, _, memory, _ = self._here
        observation.begin(self.constants, u, qpos, qvel, slope, height)
        own = memory.tolist()
        self.controller.start(own, tuple(q), tuple(dq))
        memory[:] = own
        step_size.expect(self.constants, u, _softness_of(self.model, self.data), 0.0)

    def _userdata_of(self, data: mujoco.MjData) -> Userdata:
        """Views of the parts of `mjData.userdata`, which share MuJoCo's memory."""
        values: Any = data.userdata
        row, memory = SIZE + self._rows.touched, self.controller.memory_size
        return Userdata(State.from_buffer(values), values[SIZE:row], values[row : row + memory], values[row + memory :])

    @property
    def state(self) -> State:
        """The engine's own state, which lasts from one physics step to the next."""
        state: State = self._here.u
        return state

    @property
    def memory(self) -> list[float]:
        """A copy of the controller's memory."""
        memory: list[float] = self._here.memory.tolist()
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
        step_size.expect(self.constants, self.state, _softness_of(self.model, self.data), self.data.time)
        made = self.__dict__.get("native")  # the cached property, if it was computed
        if made is not None:
            check_offsets(self.model, self.data)
            self.native = made.with_constants(self.constants)
        if self._attachment is not None:
            self._attachment.close()
            self._attach()
        return True

    @property
    def outcome(self) -> Outcome:
        """How the walk ended, or `Outcome.WALKING`; a MuJoCo warning means that it diverged."""
        return Outcome.DIVERGED if self.data.warning.number.any() else Outcome(int(self.state.outcome))

    @property
    def over(self) -> bool:
        """Whether the walk has ended."""
        return self.outcome is not Outcome.WALKING

    def sample(self) -> None:
        """Record the state now."""
        motors.take_sample(self._setting, self._here)

    def take(self, recorder: Recorder) -> int:
        """Move the contents of the buffers to a recorder; return the number of touchdowns."""
        u, recording = self.state, self.recording
        rows, samples = recording.rows[: int(u.rows)], recording.samples[: int(u.samples)]
        recorder.add(rows, samples)
        u.rows = u.samples = 0.0
        return len(rows)

    def look_ahead(self, u: State, line: NDArray[np.float64]) -> bool:
        """Advance a copy of the engine's state to what the controller is told at the next tick.

        Args:
            u: The copy, which is a view of the first numbers of `line`.
            line: The copy, then the row of the last touchdown; both are overwritten.

        Returns:
            Whether the walk is over at that tick.
        """
        data = self.data
        if data.time > u.time:
            row, parts = line[SIZE:].tolist(), _parts(self._rows)
            observation.observe(parts, self.constants, u, row, data.time, data.qpos.tolist(), data.qvel.tolist())
            line[SIZE:] = row
        return bool(u.outcome)

    def finish(self, recorder: Recorder) -> None:
        """Move the rest of an ended walk to a recorder, with a last touchdown that the controller was not told of."""
        self.take(recorder)
        if self.over and self.state.transferred:
            recorder.add_touchdown(np.array(self._here.row))

    @contextmanager
    def callbacks(self) -> Iterator[None]:
        """Install this simulation's callbacks, which are global in MuJoCo; restore the earlier ones afterwards.

        Meanwhile MuJoCo's warnings are counted instead of written to the terminal and to MUJOCO_LOG.TXT. Its timers
        (`data.timer`) stand still while compiled callbacks are installed.

        An exception in a controller's Python method ends the walk, and is raised at the end of the block.

        Raises:
            MjbipedError: The callbacks are in Python, and another thread is walking with callbacks in Python.
        """
        with ExitStack() as stack:
            if self.native is not None:
                self.attach(stack)
                stack.enter_context(registry.compiled())
            else:
                stack.callback(setattr, self, "_attachment", self._attachment)
                self._attachment = stack.enter_context(ExitStack())
                self._attach()
            stack.enter_context(registry.heard_by(self._on_warning))
            # perhaps a state was set
            if self.state.running and not self.move_on() and self.data.time > self.state.time:
                step_size.expect(self.constants, self.state, _softness_of(self.model, self.data), self.data.time)
            yield
            self.check()

    def attach(self, stack: ExitStack) -> None:
        """Register this walk with the compiled callbacks until `stack` closes, also for models built by `move_on`."""
        if self._attachment is None:
            stack.callback(setattr, self, "_attachment", None)
            self._attachment = stack.enter_context(ExitStack())
            self._attach()

    def _attach(self) -> None:
        """Register the current model with the callbacks."""
        assert self._attachment is not None
        if self.native is not None:
            self._attachment.enter_context(attached(self.model, [self.native]))
        else:
            self._attachment.enter_context(registry.in_python(self, self.model._address))

    @property
    def compiled(self) -> bool:
        """Whether both the callbacks and the laws that they call are compiled."""
        return self.native is not None and isinstance(self.native.code, MachineCode)

    @cached_property
    def native(self) -> Native | None:
        """Compiled callbacks of this walk; None if the walk needs callbacks in Python.

        Raises:
            LawError: The controller's laws cannot be compiled.
        """
        controller = self.controller
        if not self._compile:
            return None
        states, joints = len(controller.states), len(controller.joints)
        code: MachineCode | CalledMethods
        try:
            registry.learn_layout()
            check_offsets(self.model, self.data)
            with announced_for(self.plan):
                law = compilable_law(controller)
                with refused_in_words(controller, law):
                    if law is None:
                        code = CalledMethods(controller, room=ROOM)
                    else:
                        code = MachineCode(law, states, controller.memory_size, room=ROOM, joints=joints)
                    return Native(code, self.constants, self._rows, self.recording)
        except UnknownLayoutError as error:
            warn_once(str(error))
            return None

    def check(self) -> None:
        """Raise the exception of a Python method that a compiled callback has called; the walk can then continue."""
        code = self.native.code if self.native is not None else None
        if isinstance(code, CalledMethods) and code.error is not None:
            error, code.error, u = code.error, None, self.state
            u.running, u.outcome = 1.0, 0.0
            raise error

    @property
    def _setting(self) -> Setting:
        """Arguments of the callbacks in plain Python."""
        return Setting(_parts(self._rows), self.controller, self.constants, self.recording)

    def on(self, name: str, model: mujoco.MjModel, data: mujoco.MjData, *arguments: int) -> Any:
        """Run one of MuJoCo's callbacks, given by name, in plain Python; see `motors.control` and `step_size`.

        Returns:
            1 if the contact filter discards the pair of geoms, else 0.
        """
        userdata = self._here if data is self.data else self._userdata_of(data)
        u, constants = userdata.u, self.constants
        if not u.running or (name == "mjcb_sensor" and arguments[0] not in (POSITION, ACCELERATION)):
            return 0
        if arguments == (ACCELERATION,) and name == "mjcb_sensor":
            softness = _softness_of(model, data)
            length = step_size.resolve(constants, u, data.sensordata.tolist(), data.qacc, softness)
            model.opt.timestep = length
            return 0
        if u.shown or data.time > u.time:
            motors.arrive(self._setting, userdata, data.time, data.qpos.tolist(), data.qvel)
        if name == "mjcb_control":
            memory = userdata.memory.tolist()
            motors.control(self._setting, userdata._replace(memory=memory), data.ctrl, data.qfrc_applied, data.time)
            userdata.memory[:] = memory
        elif name == "mjcb_sensor":
            leapfrog.show(constants, u, data.qpos.tolist(), data.qvel)
        else:
            if not u.prepared:
                step_size.soften(constants, u, _softness_of(model, data))
            return int(refuses(constants, u, data.geom_xpos, *arguments))
        return 0

    def _on_warning(self, message: str) -> None:
        """Count a warning of MuJoCo (`mju_user_warning`) by its text without place and time, which follow " at "."""
        self.warnings[message.partition(" at ")[0].strip()] += 1


def _softness_of(model: mujoco.MjModel, data: mujoco.MjData) -> Softness:
    return Softness(model.geom_solref, model.jnt_solref, model.eq_solref, model.eq_data, data.eq_active)


@lru_cache(maxsize=8)
def _parts(rows: Any) -> Parts:
    """Functions for callbacks in plain Python: calls of the controller's methods, and writers of the record."""
    return Parts(
        adapters.torque,
        adapters.touchdown,
        adapters.slope_estimate,
        adapters.tick,
        adapters.knee_strike,
        motors.told,
        rows.write_sample,
        rows.write_touchdown,
    )


@lru_cache(maxsize=1)
def warn_once(reason: str) -> None:
    """Warn, once, why walks do not run in compiled code."""
    warnings.warn(f"{reason}; walks run with callbacks in Python, which gives the same, only slower", stacklevel=4)
