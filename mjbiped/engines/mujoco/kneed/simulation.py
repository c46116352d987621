"""The biped with knees in MuJoCo: its scene, its state, and the walk so far.

`mjbiped.engines.mujoco.kneed.stepping` has what a physics step consists of. It runs as Python for a controller written
in Python, and compiled where the controller has a law to compile, bit by bit the same.
"""

from __future__ import annotations

import math
from collections import Counter
from collections.abc import Sequence
from functools import cached_property, partial
from typing import Any

import mujoco
import numpy as np
from numpy.typing import NDArray

from mjbiped.control.adapters import LAWS
from mjbiped.control.compilation import MachineCode, compilable_law
from mjbiped.control.compile_errors import refused_in_words
from mjbiped.control.controller import Controller
from mjbiped.control.validation import fault_in
from mjbiped.disturbances.pushes import Pushes, following
from mjbiped.disturbances.sampled import SampledController
from mjbiped.engines.mujoco import contact_events as events
from mjbiped.engines.mujoco.callbacks import in_arrays
from mjbiped.engines.mujoco.compiled.layout import UnknownLayoutError, layout, library
from mjbiped.engines.mujoco.ground_window import MARGIN, GroundWindows, places_in
from mjbiped.engines.mujoco.judged import ground_needed, limits_of
from mjbiped.engines.mujoco.kneed import stages
from mjbiped.engines.mujoco.kneed import state as at
from mjbiped.engines.mujoco.kneed.observation import OPENED, begin_step, look, stand
from mjbiped.engines.mujoco.kneed.scene import motors_of, shown
from mjbiped.engines.mujoco.kneed.servo import NONE, servo_of
from mjbiped.engines.mujoco.kneed.state import Buffers, Constants, Links, Parts
from mjbiped.engines.mujoco.kneed.stepping import advance
from mjbiped.engines.mujoco.options import MOTOR, ROOM, Options
from mjbiped.engines.mujoco.simulation import BLOCK, START_DEPTH, WHOLE_STATE, warn_once
from mjbiped.errors import MjbipedError
from mjbiped.numerics.jit import compiled
from mjbiped.records.columns import tables_of, width
from mjbiped.records.recorder import Recorder
from mjbiped.records.rows import KNEED_SAMPLED
from mjbiped.robots.kneed import KneedBiped
from mjbiped.rules.scuffing import chosen
from mjbiped.rules.termination import Outcome
from mjbiped.terrain.terrain import Terrain

_TOUCHED = width(tables_of(KneedBiped).touchdowns)


class KneedSimulation:
    """A biped with knees, a controller and a terrain in MuJoCo.

    Attributes:
        model: The compiled scene; see `models/kneed.xml`.
        data: Its state.
        controller: Drives ankle, hip and swing knee.
        warnings: What went wrong, and how often.
    """

    def __init__(
        self,
        controller: Controller,
        terrain: Terrain,
        *,
        robot: KneedBiped,
        q: Sequence[float],
        dq: Sequence[float],
        steps: int | None,
        distance: float | None,
        sample_period: float,
        pushes: Pushes,
        friction: float | None,
        options: Options,
        compile: bool = True,
    ) -> None:
        """Build the scene and set the robot on it, on its left leg.

        Args:
            controller: See `controllers.Controller`.
            terrain: The ground.
            robot: The robot that walks.
            q: Stance leg, swing thigh and swing shank at the start, from the ground's normal under x = 0, rad.
            dq: Their rates, rad/s.
            steps: Touchdowns after which the walk is finished.
            distance: Place at which it is, m.
            sample_period: Time between samples, s.
            pushes: At the hip.
            friction: Of the feet; None: as in the file.
            options: The engine's settings.
            compile: Whether laws that can be compiled are, and the stepping with them.
        """
        self.controller, self._robot, self._terrain, self._friction = controller, robot, terrain, friction
        shortest = min(options.contact_timestep, options.timestep)
        block = BLOCK * options.timestep * math.sqrt(robot.gravity * robot.leg_length)  # a faster hip would fly
        self._windows = GroundWindows(
            robot,
            terrain,
            timestep=shortest,
            reach=ground_needed(robot, steps, distance),
            ground=options.ground,
            margin=MARGIN * robot.leg_length + block,
        )
        whole = (self._windows.start, self._windows.end)
        self._servo = options.stance_knee == MOTOR
        self._limits = limits_of(robot, chosen(None), options.timestep, whole, steps, distance, options.lands)
        self._law = self._law_to_compile() if compile else None
        self._constants = partial(
            Constants,
            links=Links(robot.thigh_length, robot.shank_length),
            gravity=robot.gravity,
            stepped=any(terrain.rises),
            # twice the distance at the fall of a leg
            deepest=2.0 * options.timestep * math.sqrt(2.0 * robot.gravity * robot.leg_length),
            timestep=options.timestep,
            contact_timestep=shortest,
            lands=options.lands,
            control_period=options.control_period or 0.0,
            sample_period=sample_period,
            states=len(controller.states),
            sampled=isinstance(controller, SampledController),
            pushes=pushes,
            servo=servo_of(robot) if self._servo else NONE,
        )
        self.warnings: Counter[str] = Counter()
        self.model: mujoco.MjModel
        self.data: mujoco.MjData
        self.constants: Constants
        self._u = self._table([0.0] * at.SCALARS)
        self._own = (self._table([0.0] * controller.memory_size), self._table([0.0] * len(controller.states)))
        self._records = (np.zeros((BLOCK, KNEED_SAMPLED + len(controller.states))), np.zeros((BLOCK, _TOUCHED)))
        self._build(0.0, None)
        self._start(q, dq)

    def _law_to_compile(self) -> Any:
        """The controller's law, where it can be compiled and MuJoCo be called by address."""
        law = compilable_law(self.controller)
        if law is None:
            return None
        try:
            layout()
            library()
        except UnknownLayoutError as error:
            warn_once(str(error))
            return None
        return law

    def _table(self, values: Sequence[float]) -> Any:
        """Numbers as the stepping reads them: an array for compiled code; plain Python reads lists faster."""
        return np.array(values, dtype=np.float64) if self.compiled else list(values)

    @property
    def compiled(self) -> bool:
        """Whether the stepping is compiled."""
        return self._law is not None

    # --- the scene ------------------------------------------------------------------------------------------------

    def _build(self, x: float, before: mujoco.MjData | None) -> None:
        """Build the ground about the robot at x (m), and take over its state."""
        scene = self._windows.about(x)
        model, data = scene.model, mujoco.MjData(scene.model)
        if before is not None:
            state = np.empty(mujoco.mj_stateSize(self.model, WHOLE_STATE))
            mujoco.mj_getState(self.model, before, state, WHOLE_STATE)
            mujoco.mj_setState(model, data, state, WHOLE_STATE)
            model.eq_data[:] = self.model.eq_data  # the flexion of a knee that is locked bent
        places = places_in(scene, self._terrain)
        if self._friction is not None:
            model.geom_friction[list(places.feet), 0] = self._friction
        self.model, self.data, self._inside = model, data, self._windows.inside(scene)
        self._untried = self.compiled
        self.constants = self._constants(
            limits=self._limits._replace(start=scene.start, end=scene.end),
            places=in_arrays(places) if self.compiled else places,
            motors=motors_of(model),
        )
        self.buffers = Buffers(self._u, *self._own, *self._records, shown(model, data, places), self._machine())

    def _machine(self) -> Any:
        """What the stages of a step are called with."""
        if not self.compiled:
            return stages.Machine(self.model, self.data)
        from mjbiped.engines.mujoco.kneed import compiled as by_address

        return by_address.machine_of(self.model, self.data)

    def _move_on(self) -> None:
        """Build the ground further on where the robot comes near the end of what is built."""
        low, high = self._inside
        x = float(self.data.qpos[at.X])
        if math.isfinite(x) and not low < x < high:
            self._build(x, self.data)
            stand(self.constants, self._u, self.buffers.scene)

    def _start(self, q: Sequence[float], dq: Sequence[float]) -> None:
        terrain, data, u, length = self._terrain, self.data, self._u, self._robot.leg_length
        slope, height = terrain.slope_at(0.0), terrain.height_at(0.0)
        leg, thigh, shank = (angle + slope for angle in q)
        data.qpos[:] = [
            *(length * math.sin(leg), height + length * math.cos(leg) - START_DEPTH),
            *(leg, 0.0, thigh, shank - thigh),
        ]
        data.qvel[:] = [
            *(length * math.cos(leg) * dq[0], -length * math.sin(leg) * dq[0]),
            *(dq[0], 0.0, dq[1], dq[2] - dq[1]),
        ]
        data.eq_active[list(self.constants.motors.locks)] = [0 if self._servo else 1, 0]
        memory = [0.0] * self.controller.memory_size
        self.controller.start(memory, tuple(q), tuple(dq))
        self.buffers.memory[:] = memory
        u[events.TIME], u[events.PLANNED] = -1.0, self.constants.timestep
        u[events.PLAIN] = 0.0 if self.constants.lands else 1.0
        u[events.SLOPE], u[events.FOOT_Z], u[events.FOOT_ANGLE] = slope, height, leg
        u[at.REACH] = length
        u[events.NEXT_PUSH], u[events.PUSH_IMPULSE] = following(self.constants.pushes, 0, 0.0)
        look(u, self.buffers.scene)
        begin_step(self.constants, u, self.buffers.scene)
        u[at.OPENED] = 1.0 if shank - thigh > OPENED else 0.0

    # --- the walk -------------------------------------------------------------------------------------------------

    @cached_property
    def code(self) -> MachineCode | None:
        """The machine code of the controller's laws, where the stepping is compiled.

        Raises:
            LawError: They cannot be compiled.
        """
        if self._law is None:
            return None
        with refused_in_words(self.controller, self._law):
            size, states = self.controller.memory_size, len(self.controller.states)
            return MachineCode(self._law, states, size, contract=False, room=ROOM, joints=at.JOINTS)

    @cached_property
    def _advance(self) -> Any:
        """`stepping.advance` for this controller: a function of its laws' parameters, the constants and the buffers."""
        if self.code is None:
            return partial(advance, Parts(*LAWS, *stages.STAGES))
        from mjbiped.control import machine_code
        from mjbiped.engines.mujoco.kneed import compiled as by_address

        return compiled(advance, Parts, (*machine_code.LAWS, *by_address.STAGES), inlined=(), contract=False)

    def compile(self) -> bool:
        """Compile what can be now, and not at the first step; whether the stepping is compiled.

        Raises:
            LawError: The controller's laws cannot be compiled.
        """
        if self.code is not None:
            import numba

            self._advance.compile(tuple(map(numba.typeof, (self.code.law, self.constants, self.buffers))))
        return self.compiled

    @property
    def outcome(self) -> Outcome:
        """How the walk ended, or `Outcome.WALKING`."""
        return Outcome(int(self._u[events.OUTCOME]))

    @property
    def peak_torque(self) -> NDArray[np.float64]:
        """Greatest magnitudes of ankle, hip and swing knee so far, N m."""
        return np.array([self._u[index] for index in (events.PEAK_ANKLE, events.PEAK_HIP, at.PEAK_KNEE)])

    @property
    def pressure_times(self) -> NDArray[np.float64]:
        """How long the centre of pressure was where so far, s."""
        return events.pressure_times(self._u)

    @property
    def place(self) -> float:
        """Of the stance foot, x in m."""
        return float(self._u[events.FOOT_X])

    def block(self, steps: int = BLOCK) -> None:
        """Make so many steps at most; rows and samples are then to be taken.

        Raises:
            LawError: The controller's laws cannot be compiled.
            MjbipedError: A compiled law raised an exception.
        """
        self._move_on()
        if self._untried:
            self._try()
        self._u[at.STEPS] = float(min(steps, BLOCK))
        self._advance(self.controller if self.code is None else self.code.law, self.constants, self.buffers)
        if self.code is not None and self.code.failed:
            raise MjbipedError("a compiled law raised an exception; let law() return None to see where")
        if self.data.warning.number.any() and self.outcome is Outcome.WALKING:
            self._u[events.OUTCOME] = float(Outcome.DIVERGED)

    def _try(self) -> None:
        """Let MuJoCo find the forces in a scene once: what fails there, such as a lack of memory, is an exception.

        Under compiled stepping, which calls it by address, it would end the process.
        """
        trial = mujoco.MjData(self.model)
        trial.qpos[:] = self.data.qpos
        mujoco.mj_forward(self.model, trial)
        self._untried = False

    def warn(self, message: str) -> None:
        """`mju_user_warning`: the first line says what it is."""
        self.warnings[message.partition(" at ")[0].strip()] += 1

    @property
    def told(self) -> dict[str, int]:
        """What went wrong and what is to be known, and how often."""
        return events.warned(self.warnings, self._u)

    def fault(self) -> str:
        """Which torque was no number at the controller's last tick, in words; empty if none was."""
        u, stance = [float(number) for number in self._u], at.stance_of(self._u)
        torque, t = (u[events.ANKLE], u[events.HIP], u[at.KNEE]), u[events.TIME] - u[events.TRANSFER_TIME]
        q, dq = at.angles_of(u, at.Q, stance, u[events.SLOPE]), at.rates_of(u, at.RATES, stance)
        own = self.controller.inner if isinstance(self.controller, SampledController) else self.controller
        return fault_in(own, torque, t, q, dq)

    def take(self, recorder: Recorder) -> int:
        """Hand what was recorded on; returns the number of touchdowns."""
        rows, samples = int(self._u[events.ROWS]), int(self._u[events.SAMPLES])
        recorder.add(self.buffers.rows[:rows], self.buffers.samples[:samples])
        self._u[events.ROWS] = self._u[events.SAMPLES] = 0.0
        return rows
