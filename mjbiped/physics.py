"""MuJoCo engine: rigid bodies, contacts, and a controller in `mjcb_control`.

Nothing of the paper's impact map is used here: the contact solver makes the impact, and the contact sensors say when
the legs exchange. `Simulation` holds model and state; `simulate` walks it to its end.
"""

from __future__ import annotations

import math
import threading
from collections import Counter
from collections.abc import Iterator, Sequence
from contextlib import ExitStack, contextmanager
from numbers import Real
from typing import TYPE_CHECKING, Any

import mujoco
import numpy as np
from tqdm.auto import tqdm

from mjbiped import events
from mjbiped.compass import Compass
from mjbiped.errors import InputError, MjbipedError
from mjbiped.events import Limits, Outcome
from mjbiped.recorder import Recorder
from mjbiped.scene import FOOT_RADIUS, build_scene
from mjbiped.scuffing import ScuffingRule
from mjbiped.terrain import Terrain

if TYPE_CHECKING:
    from controllers.base import Controller

LONGEST_STEP = 1.0  # no step of a walk is longer, in leg lengths; decides how far the ground is built
START_DEPTH = 1e-6  # a foot set exactly on the surface may find a heightfield's inner edge instead, m
_ONE_THREAD = threading.RLock()  # whose callbacks are installed
_ACCELERATION = int(mujoco.mjtStage.mjSTAGE_ACC)
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
            steps=math.inf if steps is None else steps,
            distance=math.inf if distance is None else distance,
        )
        self._height_at = terrain.height_at
        self._contact = tuple(int(self.model.sensor(f"{side}_contact").adr[0]) for side in ("left", "right"))
        self._slots = int(self.model.sensor("left_contact").dim[0])
        self._feet = tuple(int(self.model.geom(f"{side}_foot").id) for side in ("left", "right"))
        self._risers = frozenset(
            index for index in range(self.model.ngeom) if self.model.geom(index).name.startswith("riser_")
        )
        # no foot is deeper than this in the first step of a contact: twice the way at the fall of a leg
        self._deepest = 2.0 * timestep * math.sqrt(2.0 * robot.gravity * length)
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

        MuJoCo's warnings are counted meanwhile, where it would write them to the terminal and to MUJOCO_LOG.TXT.
        """
        with ExitStack() as stack:
            stack.enter_context(exclusive())
            installed: list[str] = []
            before, self._before = self._before, {}
            stack.callback(self._restore, installed, before)
            for name, callback in (
                ("mjcb_control", self._on_control),
                ("mjcb_sensor", self._on_sensor),
                ("mjcb_contactfilter", self._on_contact),
                ("mju_user_warning", self._on_warning),
            ):
                self._before[name] = getattr(mujoco, f"get_{name}")()
                installed.append(name)
                getattr(mujoco, f"set_{name}")(callback)
            yield

    def _restore(self, installed: list[str], before: dict[str, Any]) -> None:
        for name in reversed(installed):
            getattr(mujoco, f"set_{name}")(self._before[name])
        self._before = before

    def _on_control(self, model: mujoco.MjModel, data: mujoco.MjData) -> None:
        """`mjcb_control`: one tick per new time; a second call at the same time changes nothing."""
        if model is not self.model:
            self._pass_on("mjcb_control", model, data)
            return
        u = data.userdata.tolist()
        time = data.time
        if not u[events.RUNNING] or time <= u[events.TIME]:
            return
        qpos, qvel = data.qpos.tolist(), data.qvel.tolist()
        events.observe(u, self.limits, self._height_at, time, qpos, qvel)
        due = time > u[events.NEXT_CONTROL] - model.opt.timestep / 2.0
        if due or (u[events.TOUCHED] and u[events.OUTCOME]):  # the last touchdown is told at once: its row is whole
            self._tick(u, time)
        data.ctrl[:] = (
            (0.0, u[events.ANKLE], -u[events.HIP]) if u[events.STANCE] else (u[events.ANKLE], 0.0, u[events.HIP])
        )
        data.userdata[:] = u

    def _tick(self, u: list[float], time: float) -> None:
        """One tick of the digital controller: its events, its law, and one Euler step of its integrated states."""
        controller, slope = self.controller, u[events.SLOPE]
        memory = u[events.CONTROLLER_MEMORY :]
        if u[events.STANCE]:
            q = (u[events.RIGHT] - slope, u[events.LEFT] - slope)
            dq = (u[events.RIGHT_RATE], u[events.LEFT_RATE])
        else:
            q = (u[events.LEFT] - slope, u[events.RIGHT] - slope)
            dq = (u[events.LEFT_RATE], u[events.RIGHT_RATE])
        if u[events.TOUCHED]:
            u[events.TOUCHED] = 0.0
            u[events.ESTIMATE_BEFORE] = controller.slope_estimate(memory)
            # the contact switch holds the touchdown's posture and time for a controller that ticks later
            controller.on_touchdown(memory, *(u[first : first + 2] for first in events.TOLD_AT_TOUCHDOWN))
            u[events.ESTIMATE_AFTER] = controller.slope_estimate(memory)
        values = controller.torque(memory, time - u[events.EXCHANGE_TIME], q, dq)
        if len(values) != 2 + len(controller.states):
            rates = ", ".join(controller.states) or "none"
            raise InputError(
                f"torque returned {len(values)} values; expected ankle, hip and a rate per state ({rates})"
            )
        ankle, hip, *rates_now = values
        for index, rate in enumerate(rates_now):
            memory[index] += self.control_period * rate
        u[events.ANKLE], u[events.HIP] = ankle, hip
        if not u[events.OUTCOME]:
            u[events.PEAK_ANKLE] = max(u[events.PEAK_ANKLE], abs(ankle))
            u[events.PEAK_HIP] = max(u[events.PEAK_HIP], abs(hip))
        u[events.NEXT_CONTROL] = time + self.control_period
        u[events.CONTROLLER_MEMORY :] = memory

    def _on_sensor(self, model: mujoco.MjModel, data: mujoco.MjData, stage: int) -> None:
        """`mjcb_sensor`, after MuJoCo has filled its own contact sensors."""
        if model is not self.model:
            self._pass_on("mjcb_sensor", model, data, stage)
            return
        u = data.userdata
        if stage != _ACCELERATION or not u[events.RUNNING]:
            return
        readings = data.sensordata.tolist()
        left, right = (readings[start : start + self._slots] for start in self._contact)
        if u[events.STANCE]:
            left, right = right, left
        events.feel(u, self.limits, left, right)

    def _on_warning(self, message: str) -> None:
        """`mju_user_warning`: the first line says what it is; what follows differs from time to time."""
        self.warnings[message.partition(" at ")[0].strip()] += 1

    def _on_contact(self, model: mujoco.MjModel, data: mujoco.MjData, first: int, second: int) -> int:
        """`mjcb_contactfilter`: 1 refuses the pair.

        The swing foot passes through everything until it is armed (scuffing rule); the stance foot passes through
        risers, and through the ground from the step on that resolves the other foot's touchdown, as it does after the
        exchange. A solver with a convex friction cone would drag a foot that leaves the ground obliquely.
        """
        if model is not self.model:
            return int(self._pass_on("mjcb_contactfilter", model, data, first, second) or 0)
        u = data.userdata
        if not u[events.RUNNING]:
            return 0
        stance, swing = self._feet if not u[events.STANCE] else self._feet[::-1]
        armed = bool(u[events.ARMED])
        if swing in (first, second):
            return int(not armed)
        if not armed or stance not in (first, second):
            return 0
        if first in self._risers or second in self._risers:
            return 1
        x, _, z = data.geom_xpos[swing].tolist()
        return int(-self._deepest < z - self._height_at(x) < 0.0)

    def _pass_on(self, name: str, *arguments: Any) -> Any:
        """Hand a callback for another model to what stood there before this simulation's."""
        before = self._before.get(name)
        return before(*arguments) if callable(before) else None


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
    return isinstance(getattr(mujoco.get_mjcb_control(), "__self__", None), Simulation)


def simulate(simulation: Simulation, recorder: Recorder, *, progress: bool) -> Outcome:
    """Step a simulation until its walk ends, recording as it goes.

    Args:
        simulation: As built; it may have been resumed in the middle.
        recorder: Takes samples and touchdowns; what it holds is complete at any moment, also when this raises.
        progress: Whether to show a progress bar (never where the output is not a terminal).

    Returns:
        The outcome.
    """
    model, data, limits = simulation.model, simulation.data, simulation.limits
    stride = max(1, round(recorder.sample_period / model.opt.timestep))
    by_steps = math.isfinite(limits.steps)
    with (
        simulation.callbacks(),
        tqdm(
            total=int(limits.steps) if by_steps else round(limits.distance, 2),
            desc="walking",
            unit="step" if by_steps else "m",
            disable=None if progress else True,
        ) as bar,
    ):
        recorder.sample(data, simulation.controller)
        u, since_sample = data.userdata, 0
        while not u[events.OUTCOME]:
            mujoco.mj_step(model, data)
            since_sample += 1
            if recorder.take_touchdown(data):
                bar.update(1 if by_steps else max(0.0, round(float(u[events.FOOT_X]), 2) - bar.n))
            if since_sample == stride or u[events.OUTCOME]:
                recorder.sample(data, simulation.controller)
                since_sample = 0
                if simulation.outcome is not Outcome.WALKING:  # also where MuJoCo has warned
                    break
    return simulation.outcome


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
