"""MuJoCo engine: rigid bodies, contacts, and a controller in `mjcb_control`.

Nothing of the paper's impact map is used here: the contact solver makes the impact, and the contact sensors say when
the legs exchange. `Simulation` holds model and state; `simulate` walks it to its end.
"""

from __future__ import annotations

import math
import threading
import warnings
from collections import Counter
from collections.abc import Iterator, Sequence
from contextlib import ExitStack, contextmanager
from functools import cached_property, lru_cache
from numbers import Real
from typing import TYPE_CHECKING, Any

import mujoco
import numpy as np
from tqdm.auto import tqdm

from mjbiped import callbacks, events, laws
from mjbiped.callbacks import Laws, World
from mjbiped.compass import Compass
from mjbiped.errors import InputError, MjbipedError
from mjbiped.events import Limits, Outcome
from mjbiped.law_check import refusal
from mjbiped.laws import gives_its_law
from mjbiped.native import Native, attached, check_offsets, native
from mjbiped.native_layout import UnknownLayoutError
from mjbiped.recorder import Recorder
from mjbiped.scene import FOOT_RADIUS, build_scene
from mjbiped.scuffing import ScuffingRule
from mjbiped.terrain import Terrain

if TYPE_CHECKING:
    from controllers.base import Controller

LONGEST_STEP = 1.0  # no step of a walk is longer, in leg lengths; decides how far the ground is built
START_DEPTH = 1e-6  # a foot set exactly on the surface may find a heightfield's inner edge instead, m
_ONE_THREAD = threading.RLock()  # whose callbacks are installed
_walking: list[Simulation] = []  # those whose callbacks are installed, the last one innermost
_CALLBACKS = ("mjcb_control", "mjcb_sensor", "mjcb_contactfilter")
_ACCELERATION = int(mujoco.mjtStage.mjSTAGE_ACC)
_METHODS = Laws(laws.torque, laws.touchdown, laws.slope_estimate)
_WHOLE_STATE = mujoco.mjtState.mjSTATE_INTEGRATION
LEAP = 50  # steps made at once, at most: with each touchdown as many are made twice
LONGEST_TIMESTEP = 1e-3  # at it the worst impact of a passive walk is already off by 9 %, s


class Simulation:
    """A robot, a controller and a terrain in MuJoCo.

    ```python
    simulation = Simulation(controller, Terrain.mixed(), steps=10)
    with simulation.callbacks():
        mujoco.mj_step(simulation.model, simulation.data, nstep=1000)
    ```

    The whole state, the controller's memory included, is in `data`: `mujoco.mj_getState` with
    `mjtState.mjSTATE_INTEGRATION` saves it, `mj_setState` on a like simulation resumes it, bit by bit the same.

    Attributes:
        model: The compiled scene. qpos is hip x, hip z (m), left and right leg angle from the vertical (rad);
            ctrl is left ankle, right ankle, hip torque (N m).
        data: Its state.
        controller: Drives stance ankle and hip.
        limits: What ends the walk.
        control_period: Time between two ticks of the controller, s.
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
        timestep: float = 1e-4,
        control_period: float | None = None,
        scuffing: ScuffingRule | None = None,
        ground: str = "auto",
        compile: bool = True,
    ) -> None:
        """Build the scene and set the robot on it.

        Args:
            controller: See `controllers.Controller`.
            terrain: The ground.
            robot: The robot that walks.
            q: Stance (left) and swing angle at the start, from the ground's normal under x = 0, rad.
            dq: Their rates, rad/s.
            steps: Touchdowns after which the walk is finished; None: no limit.
            distance: Place x of the stance foot at which it is finished, m; None: no limit.
            timestep: Physics step, s.
            control_period: Time between two ticks of the controller, s; a multiple of the timestep, by default one.
            scuffing: When the swing foot may touch the ground.
            ground: How the terrain is built; see `mjbiped.scene.build_scene`.
            compile: Whether laws that can be compiled are.

        Raises:
            InputError: A value is outside its domain.
        """
        period = timestep if control_period is None else control_period
        _check_times(timestep, period)
        rule = scuffing or ScuffingRule()
        length = robot.leg_length
        reach = 2.0 * length + min(
            math.inf if steps is None else steps * LONGEST_STEP * length,
            math.inf if distance is None else distance,
        )
        size = events.CONTROLLER_MEMORY + controller.memory_size
        scene = build_scene(robot, terrain, timestep=timestep, reach=reach, ground=ground, userdata=size)
        self.model = scene.model
        self.data = mujoco.MjData(scene.model)
        self.controller = controller
        self.control_period = period
        self.limits = Limits(
            leg_length=length,
            foot_radius=FOOT_RADIUS,
            weight=robot.weight,
            reach=rule.reach * length,
            delay=rule.delay,
            stall_time=events.STALL_TIME * math.sqrt(length / robot.gravity),
            start=scene.start,
            end=scene.end,
            steps=math.inf if steps is None else float(steps),
            distance=math.inf if distance is None else float(distance),
        )
        model = self.model
        left, right = (model.sensor(f"{side}_contact") for side in ("left", "right"))
        self._world = World(
            limits=self.limits,
            profile=terrain.profile,
            feet=(int(model.geom("left_foot").id), int(model.geom("right_foot").id)),
            contacts=(int(left.adr[0]), int(right.adr[0])),
            slots=int(left.dim[0]),
            risers=tuple(float(model.geom(index).name.startswith("riser_")) for index in range(model.ngeom)),
            # twice the way at the fall of a leg
            deepest=2.0 * timestep * math.sqrt(2.0 * robot.gravity * length),
            control_period=period,
            memory_size=controller.memory_size,
        )
        self._compile = compile
        self._before: dict[str, Any] = {}
        self.warnings: Counter[str] = Counter()
        self._place(terrain, length, q, dq)

    def _place(self, terrain: Terrain, length: float, q: Sequence[float], dq: Sequence[float]) -> None:
        """Set the robot with its left foot at x = 0, and begin the controller's memory."""
        slope, height = terrain.slope_at(0.0), terrain.height_at(0.0)
        stance, swing = q[0] + slope, q[1] + slope
        hip = (length * math.sin(stance), height + length * math.cos(stance) - START_DEPTH)
        qpos = [*hip, stance, swing]
        qvel = [length * math.cos(stance) * dq[0], -length * math.sin(stance) * dq[0], dq[0], dq[1]]
        self.data.qpos[:] = qpos
        self.data.qvel[:] = qvel
        u = self.data.userdata.tolist()
        events.begin(u, qpos, qvel, slope, (0.0, height))
        memory = u[events.CONTROLLER_MEMORY :]
        self.controller.start(memory, tuple(q), tuple(dq))
        self.data.userdata[:] = u[: events.CONTROLLER_MEMORY] + memory

    @property
    def outcome(self) -> Outcome:
        """How the walk ended, or `Outcome.WALKING`; a MuJoCo warning means that it diverged."""
        code = Outcome(int(self.data.userdata[events.OUTCOME]))
        return Outcome.DIVERGED if self.data.warning.number.any() else code

    @contextmanager
    def callbacks(self) -> Iterator[None]:
        """Install this simulation's callbacks, which are MuJoCo's process-wide globals; what stood there comes back.

        Compiled ones are not installed over others than their like: those could not be asked for other models.

        MuJoCo's warnings are counted meanwhile, where it would write them to the terminal and to MUJOCO_LOG.TXT.
        """
        with ExitStack() as stack:
            stack.enter_context(exclusive())
            before = {name: getattr(mujoco, f"get_{name}")() for name in (*_CALLBACKS, "mju_user_warning")}
            made = self._native
            if made and all(before[name] in (None, getattr(made.functions, name)) for name in _CALLBACKS):
                stack.enter_context(attached(self.model, [made]))
                chosen = {name: getattr(made.functions, name) for name in _CALLBACKS}
            else:
                chosen = dict(zip(_CALLBACKS, (self._on_control, self._on_sensor, self._on_contact), strict=True))
            installed: list[str] = []
            stack.callback(self._restore, installed, before, self._before)
            self._before = before
            _walking.append(self)
            for name, callback in {**chosen, "mju_user_warning": self._on_warning}.items():
                installed.append(name)
                getattr(mujoco, f"set_{name}")(callback)
            yield

    def _restore(self, installed: list[str], before: dict[str, Any], before_that: dict[str, Any]) -> None:
        for name in reversed(installed):
            getattr(mujoco, f"set_{name}")(before[name])
        if self in _walking:
            _walking.remove(self)
        self._before = before_that

    @property
    def compiled(self) -> bool:
        """Whether the callbacks can be compiled ones."""
        return self._native is not None

    @cached_property
    def _native(self) -> Native | None:
        """The compiled callbacks and this walk's record; None where the walk needs Python's.

        Raises:
            LawError: The controller's laws cannot be compiled.
        """
        controller = self.controller
        if not (self._compile and gives_its_law(controller)):
            return None
        law = controller.law()
        if law is None:
            return None
        try:
            check_offsets(self.data)
            return native(law, self._world, len(controller.states))
        except UnknownLayoutError as error:
            _warn_once(str(error))
            return None
        except Exception as error:
            refused = refusal(error, law, controller.states, whose=type(controller).__name__)
            if refused is not None:
                raise refused from error
            raise

    def _on_control(self, model: mujoco.MjModel, data: mujoco.MjData) -> None:
        """`mjcb_control`; see `callbacks.control`."""
        if model is not self.model:
            self._pass_on("mjcb_control", model, data)
            return
        u = data.userdata.tolist()
        memory = u[events.CONTROLLER_MEMORY :]
        qpos, qvel = data.qpos.tolist(), data.qvel.tolist()
        timestep = model.opt.timestep
        if callbacks.control(
            _METHODS, self.controller, self._world, timestep, u, memory, data.ctrl, data.time, qpos, qvel
        ):
            u[events.CONTROLLER_MEMORY :] = memory
            data.userdata[:] = u

    def _on_sensor(self, model: mujoco.MjModel, data: mujoco.MjData, stage: int) -> None:
        """`mjcb_sensor`; see `callbacks.sense`."""
        if model is not self.model:
            self._pass_on("mjcb_sensor", model, data, stage)
        elif stage == _ACCELERATION:
            callbacks.sense(self._world, data.userdata, data.sensordata.tolist())

    def _on_warning(self, message: str) -> None:
        """`mju_user_warning`: the first line says what it is; what follows differs from time to time."""
        self.warnings[message.partition(" at ")[0].strip()] += 1

    def _on_contact(self, model: mujoco.MjModel, data: mujoco.MjData, first: int, second: int) -> int:
        """`mjcb_contactfilter`: 1 refuses the pair; see `callbacks.refuses`."""
        if model is not self.model:
            return int(self._pass_on("mjcb_contactfilter", model, data, first, second) or 0)
        return int(callbacks.refuses(self._world, data.userdata, data.geom_xpos, first, second))

    def _pass_on(self, name: str, model: mujoco.MjModel, data: mujoco.MjData, *arguments: int) -> Any:
        """Hand a callback for another model to what stood there before this simulation's."""
        before: Any = self._before.get(name)
        if _is_compiled(before):
            return before(model._address, data._address, *arguments)
        return before(model, data, *arguments) if callable(before) else None


@contextmanager
def exclusive() -> Iterator[None]:
    """Keep other threads from building or stepping a walk meanwhile.

    Raises:
        MjbipedError: Another thread does already.
    """
    if not _ONE_THREAD.acquire(blocking=False):
        raise MjbipedError(
            "another thread of this process is walking, and MuJoCo's callbacks are shared by all threads; "
            "let walks run one after another, or in processes of their own"
        )
    try:
        yield
    finally:
        _ONE_THREAD.release()


def walking() -> bool:
    """Whether a simulation's callbacks are installed; MuJoCo cannot compile a model then."""
    return bool(_walking)


@lru_cache(maxsize=1)
def _warn_once(reason: str) -> None:
    warnings.warn(f"{reason}; walks run with callbacks in Python, which gives the same, only slower", stacklevel=4)


def simulate(simulation: Simulation, recorder: Recorder, *, progress: bool) -> Outcome:
    """Step a simulation until its walk ends, recording as it goes.

    Args:
        simulation: As built; it may have been resumed in the middle.
        recorder: Takes samples and touchdowns; what it holds is complete at any moment, also when this raises.
        progress: Whether to show a progress bar (never where the output is not a terminal).

    Returns:
        The outcome.

    Raises:
        MjbipedError: A compiled law raised an exception.
    """
    model, data, limits = simulation.model, simulation.data, simulation.limits
    stride = max(1, round(recorder.sample_period / model.opt.timestep))
    by_steps = math.isfinite(limits.steps)
    with (
        tqdm(
            total=int(limits.steps) if by_steps else round(limits.distance, 2),
            desc="preparing",  # the first walk with a kind of law compiles it
            unit="step" if by_steps else "m",
            disable=None if progress else True,
        ) as bar,
        simulation.callbacks(),
    ):
        bar.set_description("walking", refresh=False)
        bar.reset()
        recorder.sample(data, simulation.controller)
        leaps = _Leaps(simulation)
        u, since_sample = data.userdata, 0
        while not u[events.OUTCOME]:
            since_sample += leaps.advance(stride - since_sample)
            if recorder.take_touchdown(data):
                bar.update(1 if by_steps else max(0.0, round(float(u[events.FOOT_X]), 2) - bar.n))
            if since_sample == stride or u[events.OUTCOME]:
                recorder.sample(data, simulation.controller)
                since_sample = 0
                if simulation.outcome is not Outcome.WALKING:  # also where MuJoCo has warned
                    break
    if data.userdata[events.OUTCOME] == Outcome.INTERRUPTED:
        raise MjbipedError("a compiled law raised an exception; let law() return None to see where")
    return simulation.outcome


class _Leaps:
    """Steps a simulation, many steps at once where its callbacks are compiled and nothing has to be looked at between.

    A leap in which a leg exchange or the end of the walk turns out to lie is taken back and made step by step.
    """

    def __init__(self, simulation: Simulation) -> None:
        self._simulation, self._model, self._data = simulation, simulation.model, simulation.data
        self._state = np.empty(mujoco.mj_stateSize(simulation.model, _WHOLE_STATE))
        self._single = 0 if _is_compiled(mujoco.get_mjcb_control()) else math.inf  # steps to be made one by one

    def advance(self, most: int) -> int:
        """Make at least one step and at most so many; returns how many."""
        model, data, u = self._model, self._data, self._data.userdata
        steps = min(most, LEAP)
        if steps > 1 and self._single == 0:
            count, warned = u[events.COUNT], self._simulation.warnings.copy()
            mujoco.mj_getState(model, data, self._state, _WHOLE_STATE)
            mujoco.mj_step(model, data, nstep=steps)
            if u[events.COUNT] == count and not u[events.OUTCOME]:
                return steps
            mujoco.mj_setState(model, data, self._state, _WHOLE_STATE)
            self._simulation.warnings = warned  # the steps made again warn again
            self._single = steps
        mujoco.mj_step(model, data)
        self._single = max(self._single - 1, 0)
        return 1


def _is_compiled(callback: Any) -> bool:
    return hasattr(callback, "argtypes")  # a C function's pointer of ctypes


def _check_times(timestep: float, period: float) -> None:
    """Refuse a physics step or control period that the contact cannot be resolved with.

    Raises:
        InputError: One is outside its domain.
    """
    for name, value in (("timestep", timestep), ("control_period", period)):
        if not isinstance(value, Real):
            raise InputError(f"{name} must be a number of seconds, got {value!r}")
    if not 0.0 < timestep <= LONGEST_TIMESTEP:
        raise InputError(f"timestep must lie in (0, {LONGEST_TIMESTEP}] s, got {timestep!r}")
    ratio = period / timestep if math.isfinite(period) else math.nan
    if not (ratio > 0.5 and np.isclose(ratio, round(ratio), rtol=1e-6)):
        raise InputError(f"control_period must be a multiple of the timestep {timestep!r} s, got {period!r}")
