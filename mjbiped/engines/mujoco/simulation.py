"""MuJoCo engine: rigid bodies, contacts, and a controller in `mjcb_control`.

Nothing of the paper's impact map is used here: the contact solver makes the impact, and the contact sensors say when
support is transferred. What the callbacks do take from the terrain's profile is how long a step is, and with it the
contacts' softness (`mjbiped.engines.mujoco.step_size`), and when the departing foot ceases to collide. `Simulation`
holds model and state; `mjbiped.engines.mujoco.run` walks it to its end.
"""

from __future__ import annotations

import math
import warnings
from collections import Counter
from collections.abc import Iterator, Sequence
from contextlib import ExitStack, contextmanager
from functools import cached_property, lru_cache
from itertools import chain
from typing import Any

import mujoco
import numpy as np

from mjbiped.control import adapters
from mjbiped.control.compilation import compilable_law
from mjbiped.control.compile_errors import refused_in_words
from mjbiped.control.controller import Controller
from mjbiped.disturbances.pushes import NONE, Pushes, following
from mjbiped.disturbances.sampled import SampledController
from mjbiped.engines.mujoco import callbacks, leapfrog
from mjbiped.engines.mujoco import contact_events as events
from mjbiped.engines.mujoco.callbacks import Laws, Recording, Setting, SimulationConstants, Userdata
from mjbiped.engines.mujoco.compiled import registry
from mjbiped.engines.mujoco.compiled.callbacks import Functions, Native, attached, check_offsets
from mjbiped.engines.mujoco.compiled.layout import UnknownLayoutError
from mjbiped.engines.mujoco.contact_events import State
from mjbiped.engines.mujoco.ground_window import MARGIN, GroundWindows, places_in
from mjbiped.engines.mujoco.judged import ground_needed, limits_of
from mjbiped.engines.mujoco.options import Options
from mjbiped.records.recorder import Recorder
from mjbiped.records.rows import SAMPLED, TOUCHED
from mjbiped.robots.compass import Compass
from mjbiped.rules.scuffing import ScuffingRule, chosen
from mjbiped.rules.termination import Outcome
from mjbiped.terrain.terrain import Terrain

START_DEPTH = 1e-6  # a foot set exactly on the surface may find a heightfield's inner edge instead, m
_POSITION, _ACCELERATION = int(mujoco.mjtStage.mjSTAGE_POS), int(mujoco.mjtStage.mjSTAGE_ACC)
_METHODS = Laws(adapters.torque, adapters.touchdown, adapters.slope_estimate, adapters.tick)
WHOLE_STATE = mujoco.mjtState.mjSTATE_INTEGRATION
BLOCK = 500  # steps made at once, at most


class Simulation:
    """A robot, a controller and a terrain in MuJoCo.

    ```python
    robot = mjbiped.Compass()
    gait = mjbiped.find_passive_gait(robot, slope=np.deg2rad(2))
    controller = AdaptiveController(robot, gait)
    terrain = mjbiped.Terrain.mixed()
    simulation = Simulation(controller, terrain, robot=robot, q=gait.start[:2], dq=gait.start[2:], steps=10)
    with simulation.callbacks():
        mujoco.mj_step(simulation.model, simulation.data, nstep=1000)
    ```

    The whole state, the controller's memory included, is in `data`: `mujoco.mj_getState` with
    `mjtState.mjSTATE_INTEGRATION` saves it, `mj_setState` on a like simulation resumes it, bit by bit the same.

    Of a terrain of more than `mjbiped.engines.mujoco.ground.FEW_SEGMENTS` segments, `model` holds only the ground
    about the robot: see `move_on`.

    Attributes:
        model: The compiled scene. qpos is hip x, hip z (m), left and right leg angle from the vertical (rad);
            ctrl is left ankle, right ankle, hip torque (N m).
        data: Its state.
        controller: Drives stance ankle and hip.
        options: The engine's settings.
        limits: What ends the walk.
        recording: Where samples and touchdowns are written as the walk goes on, until there is no room.
        warnings: What MuJoCo warned of while this simulation's callbacks were installed, and how often.
    """

    def __init__(
        self,
        controller: Controller,
        terrain: Terrain,
        *,
        robot: Compass,
        q: Sequence[float],
        dq: Sequence[float],
        steps: int | None = None,
        distance: float | None = None,
        sample_period: float = math.inf,
        scuffing: ScuffingRule | None = None,
        pushes: Pushes = NONE,
        friction: float | None = None,
        options: Options | None = None,
        compile: bool = True,
        scenery: bool = False,
    ) -> None:
        """Build the scene and set the robot on it.

        Args:
            controller: See `controllers.Controller`.
            terrain: The ground.
            robot: The robot that walks.
            q: Stance (left) and swing angle at the start, from the ground's normal under x = 0, rad.
            dq: Their rates, rad/s.
            steps: Touchdowns after which the walk is finished; None: no limit.
            distance: Position x of the stance foot at which it is finished, m; None: no limit.
            sample_period: Time between two samples, s; infinity: none but the first and the last.
            scuffing: When the swing foot may touch the ground.
            pushes: At the hip.
            friction: Coefficient between feet and ground, other than the scene's.
            options: The engine's settings. Where its steps do not end at touchdowns, the model stays as it is, and may
                serve many walks at the same time.
            compile: Whether laws that can be compiled are.
            scenery: Add the ground as it is seen from the side, for pictures; the walk is the same.
        """
        options = options or Options()
        timestep, contact_timestep, lands = options.timestep, options.contact_timestep, options.lands
        shortest = min(contact_timestep, timestep) if lands else timestep
        rule = chosen(scuffing)
        length = robot.leg_length
        states = len(controller.states)
        size = events.CONTROLLER_MEMORY + controller.memory_size + states
        self._terrain = terrain
        block = BLOCK * timestep * math.sqrt(robot.gravity * length)  # a faster hip would fly
        self._windows = GroundWindows(
            robot,
            terrain,
            timestep=shortest,
            reach=ground_needed(robot, steps, distance),
            ground=options.ground,
            userdata=size,
            scenery=scenery,
            margin=MARGIN * length + block,
        )
        scene = self._windows.about(0.0)
        scene.model.opt.timestep = timestep
        self._inside = self._windows.inside(scene)
        self.model = scene.model
        self.data = mujoco.MjData(scene.model)
        self.controller = controller
        self.options = options
        whole = (self._windows.start, self._windows.end)
        self.limits = limits_of(robot, rule, timestep, whole, steps, distance, lands)
        self._constants = SimulationConstants(
            limits=self.limits._replace(start=scene.start, end=scene.end),
            places=places_in(scene, terrain),
            stepped=any(terrain.rises),
            # twice the distance at the fall of a leg
            deepest=2.0 * timestep * math.sqrt(2.0 * robot.gravity * length),
            timestep=timestep,
            contact_timestep=shortest,
            lands=lands,
            control_period=options.control_period or 0.0,
            memory_size=controller.memory_size,
            states=states,
            sampled=isinstance(controller, SampledController),
            pushes=pushes,
        )
        room = BLOCK + 1 if math.isfinite(sample_period) else 2
        self.recording = Recording(
            sample_period=sample_period,
            samples=np.zeros((room, SAMPLED + states)),
            rows=np.zeros((BLOCK, TOUCHED)),
        )
        self._friction = friction
        self._set_friction()
        self._compile = compile
        self._before: dict[str, Any] = {}
        self._attachment: ExitStack | None = None
        self.warnings: Counter[str] = Counter()
        self._place(terrain, length, q, dq)

    def restart(self, q: Sequence[float], dq: Sequence[float]) -> None:
        """Set the robot back to its start, as if the simulation had been built with another first state.

        Args:
            q: Stance (left) and swing angle, from the ground's normal under x = 0, rad.
            dq: Their rates, rad/s.
        """
        mujoco.mj_resetData(self.model, self.data)
        self.warnings.clear()
        self._place(self._terrain, self.limits.leg_length, q, dq)
        self.move_on()

    def _place(self, terrain: Terrain, length: float, q: Sequence[float], dq: Sequence[float]) -> None:
        """Set the robot with its left foot at x = 0, and begin the controller's memory."""
        slope, height = terrain.slope_at(0.0), terrain.height_at(0.0)
        stance, swing = q[0] + slope, q[1] + slope
        hip = (length * math.sin(stance), height + length * math.cos(stance) - START_DEPTH)
        qpos = [*hip, stance, swing]
        qvel = [length * math.cos(stance) * dq[0], -length * math.sin(stance) * dq[0], dq[0], dq[1]]
        self.data.qpos[:] = qpos
        self.data.qvel[:] = qvel
        userdata = self._userdata()
        events.begin(userdata.events, State(qpos, qvel), slope, (0.0, height), self._constants.timestep)
        u = userdata.events
        u[events.NEXT_PUSH], u[events.PUSH_IMPULSE] = following(self._constants.pushes, 0, 0.0)
        self.controller.start(userdata.memory, tuple(q), tuple(dq))
        self.data.userdata[:] = list(chain(*userdata))

    def _userdata(self) -> Userdata:
        """A copy of the userdata, in its parts."""
        u = self.data.userdata.tolist()
        memory = events.CONTROLLER_MEMORY
        rates = memory + self._constants.memory_size
        return Userdata(u[:memory], u[memory:rates], u[rates:])

    @property
    def _setting(self) -> Setting:
        """What the callbacks work with in plain Python."""
        return Setting(_METHODS, self.controller, self._constants, self.recording)

    def move_on(self) -> bool:
        """Build the ground about the robot, where it comes near the end of what is built of a long terrain.

        `model` and `data` are others then, in the same state; the walk goes on bit by bit as on the whole terrain. To
        be called between steps, at least once in a leg length; `callbacks` begins with it. A hip that passes the end of
        the ground that is built has left the terrain. What was changed in `model` by hand does not go along.

        Returns:
            Whether it was built.
        """
        data, x = self.data, float(self.data.qpos[0])
        low, high = self._inside
        if low < x < high or not math.isfinite(x) or data.warning.number.any():
            return False
        scene, before = self._windows.about(x), self._constants
        constants = before._replace(
            limits=self.limits._replace(start=scene.start, end=scene.end), places=places_in(scene, self._terrain)
        )
        scene.model.opt.timestep = self.model.opt.timestep
        scene.model.geom_solref[list(constants.places.feet)] = self.model.geom_solref[list(before.places.feet)]
        state = np.empty(mujoco.mj_stateSize(self.model, WHOLE_STATE))
        mujoco.mj_getState(self.model, data, state, WHOLE_STATE)
        data = mujoco.MjData(scene.model)
        mujoco.mj_setState(scene.model, data, state, WHOLE_STATE)
        self.model, self.data, self._constants, self._inside = scene.model, data, constants, self._windows.inside(scene)
        self._set_friction()
        made = self.__dict__.get("_native")  # as `cached_property` keeps it
        if made is not None:
            check_offsets(self.data)
            self._native = made.with_constants(self._constants)
            if self._attachment is not None:
                self._attachment.close()
                self._attachment.enter_context(attached(self.model, [self._native]))
        return True

    def _set_friction(self) -> None:
        """Write the friction into the model: it is the feet's, which have priority over the ground's."""
        if self._friction is not None:
            self.model.geom_friction[list(self._constants.places.feet), 0] = self._friction

    @property
    def inside(self) -> tuple[float, float]:
        """Between which places of the hip, x in m, `move_on` has nothing to build."""
        return self._inside

    @property
    def constants(self) -> SimulationConstants:
        """What does not change while the model is the same."""
        return self._constants

    @property
    def outcome(self) -> Outcome:
        """How the walk ended, or `Outcome.WALKING`; a MuJoCo warning means that it diverged."""
        code = Outcome(int(self.data.userdata[events.OUTCOME]))
        return Outcome.DIVERGED if self.data.warning.number.any() else code

    def sample(self) -> None:
        """Record the state now."""
        userdata = self._userdata()
        callbacks.take_sample(self._setting, userdata, self.data.time, self.data.qpos.tolist())
        self.data.userdata[:] = list(chain(*userdata))

    def take(self, recorder: Recorder) -> int:
        """Hand what was recorded on, and make room; returns the number of touchdowns."""
        u, recording = self.data.userdata, self.recording
        rows, samples = recording.rows[: int(u[events.ROWS])], recording.samples[: int(u[events.SAMPLES])]
        recorder.add(rows, samples)
        u[events.ROWS] = u[events.SAMPLES] = 0.0
        return len(rows)

    @property
    def over(self) -> bool:
        """Whether the walk has ended."""
        return self.outcome is not Outcome.WALKING

    @contextmanager
    def callbacks(self) -> Iterator[None]:
        """Install this simulation's callbacks, which are MuJoCo's process-wide globals; what stood there comes back.

        Compiled ones are not installed over others than their like: those could not be asked for other models.

        MuJoCo's warnings are counted meanwhile, where it would write them to the terminal and to MUJOCO_LOG.TXT.

        Within `shared_callbacks` of its functions nothing has to be installed, and any thread may ask.
        """
        made = self._native
        with ExitStack() as stack:
            if made is not None and made.functions is registry.shared():
                self.attach(stack)
                stack.enter_context(registry.stepped_under_shared(self._on_warning))
                yield
                return
            stack.enter_context(registry.exclusive())
            self.move_on()
            before, made = registry.installed(), self._native
            if made and all(before[name] in (None, getattr(made.functions, name)) for name in registry.CALLBACKS):
                self.attach(stack)
                chosen = {name: getattr(made.functions, name) for name in registry.CALLBACKS}
            else:
                own = (self._on_control, self._on_sensor, self._on_contact)
                chosen = dict(zip(registry.CALLBACKS, own, strict=True))
            stack.callback(setattr, self, "_before", self._before)
            self._before = before
            stack.enter_context(registry.own_callbacks(self, {**chosen, "mju_user_warning": self._on_warning}))
            yield

    def attach(self, stack: ExitStack) -> None:
        """Tell the compiled callbacks of this walk for as long as `stack` lasts, whatever model it moves on to."""
        if self._attachment is None and self._native is not None:
            stack.callback(setattr, self, "_attachment", None)
            self._attachment = stack.enter_context(ExitStack())
            self._attachment.enter_context(attached(self.model, [self._native]))

    @property
    def compiled(self) -> bool:
        """Whether the callbacks can be compiled ones."""
        return self._native is not None

    @property
    def native(self) -> Native | None:
        """The compiled callbacks and this walk's record, None where it needs Python's; raises as `compiled` does."""
        return self._native

    @property
    def functions(self) -> Functions | None:
        """Its compiled callbacks, None where it needs Python's; raises as `compiled` does, where a law will not do.

        Walks of the same kind of law and constants share theirs.
        """
        return self._native.functions if self._native is not None else None

    @cached_property
    def _native(self) -> Native | None:
        """The compiled callbacks and this walk's record; None where the walk needs Python's.

        Raises:
            LawError: The controller's laws cannot be compiled.
        """
        controller = self.controller
        law = compilable_law(controller) if self._compile else None
        if law is None:
            return None
        try:
            check_offsets(self.data)
            with refused_in_words(controller, law):
                return Native(law, self._constants, self.recording)
        except UnknownLayoutError as error:
            warn_once(str(error))
            return None

    def _on_control(self, model: mujoco.MjModel, data: mujoco.MjData) -> None:
        """`mjcb_control`; see `callbacks.control`."""
        if model is not self.model:
            self._pass_on("mjcb_control", model, data)
            return
        leapfrog.put_back(data.userdata, data.qvel)
        userdata, state = self._userdata(), State(data.qpos.tolist(), data.qvel.tolist())
        if callbacks.control(self._setting, userdata, data.ctrl, data.qfrc_applied, data.time, state):
            data.userdata[:] = list(chain(*userdata))

    def _on_sensor(self, model: mujoco.MjModel, data: mujoco.MjData, stage: int) -> None:
        """`mjcb_sensor`; see `callbacks.sense`."""
        if model is not self.model:
            self._pass_on("mjcb_sensor", model, data, stage)
        elif stage == _POSITION:
            leapfrog.show(data.userdata, self._constants, data.qpos.tolist(), data.qvel, data.time)
        elif stage == _ACCELERATION:
            state, readings = State(data.qpos.tolist(), data.qvel.tolist()), data.sensordata.tolist()
            now = (readings, data.time, state, data.qacc.tolist())
            length, weight = callbacks.sense(self._constants, data.userdata, *now)
            if length > 0.0:
                model.opt.timestep = length
                if weight != 1.0:
                    data.qacc *= weight

    def _on_warning(self, message: str) -> None:
        """`mju_user_warning`: the first line says what it is; what follows differs from time to time."""
        self.warnings[message.partition(" at ")[0].strip()] += 1

    def _on_contact(self, model: mujoco.MjModel, data: mujoco.MjData, first: int, second: int) -> int:
        """`mjcb_contactfilter`: 1 refuses the pair; see `callbacks.refuses`."""
        if model is not self.model:
            return int(self._pass_on("mjcb_contactfilter", model, data, first, second) or 0)
        solref = callbacks.softness(self._constants, data.userdata, data.time)
        if solref[0] < 0.0:
            model.geom_solref[list(self._constants.places.feet)] = solref
        return int(callbacks.refuses(self._constants, data.userdata, data.geom_xpos, first, second))

    def _pass_on(self, name: str, model: mujoco.MjModel, data: mujoco.MjData, *arguments: int) -> Any:
        """Hand a callback for another model to what stood there before this simulation's."""
        before: Any = self._before.get(name)
        if registry.is_compiled(before):
            return before(model._address, data._address, *arguments)
        return before(model, data, *arguments) if callable(before) else None


@lru_cache(maxsize=1)
def warn_once(reason: str) -> None:
    """Say why walks are not made in compiled code."""
    warnings.warn(f"{reason}; walks run with callbacks in Python, which gives the same, only slower", stacklevel=4)
