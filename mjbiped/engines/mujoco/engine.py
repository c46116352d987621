"""`Mujoco`: the engine of rigid bodies and contacts, with its settings."""

from __future__ import annotations

import math
from collections.abc import Generator
from dataclasses import asdict, dataclass, replace
from pkgutil import resolve_name
from typing import TYPE_CHECKING, Any, ClassVar

import numpy as np
from numpy.typing import NDArray

from mjbiped.control.functions import fault_in
from mjbiped.disturbances.disturbances import Disturbances
from mjbiped.disturbances.loop import SampledController
from mjbiped.engines.base import Engine, Run, Show, step_under_way
from mjbiped.engines.compiling import Costs, can_compile
from mjbiped.engines.mujoco.callback import walking
from mjbiped.engines.mujoco.feet import for_feet, least_normal_force
from mjbiped.engines.mujoco.motors import take_sample
from mjbiped.engines.mujoco.observation import INTRUSION_WORDS, SLIDING_WORDS, SQUEEZING_WORDS
from mjbiped.engines.mujoco.options import MOTOR, SERVO_PACE, Options, servo_of
from mjbiped.engines.mujoco.scene import check_masses
from mjbiped.engines.mujoco.simulation import BLOCK, Simulation
from mjbiped.engines.plan import Initial, Plan, Terms, make_plan
from mjbiped.errors import InputError, MjbipedError
from mjbiped.records.columns import Cancellation, Recorder, never_cancelled
from mjbiped.records.loads import BINS
from mjbiped.robots.robot import Robot
from mjbiped.rules.scuffing import ScuffingRule
from mjbiped.rules.termination import Outcome
from mjbiped.terrain.terrain import Terrain
from mjbiped.utils.domains import Domain
from mjbiped.utils.mujoco import mujoco

if TYPE_CHECKING:
    from mjbiped.control.controller import Controller

LEG = Domain(0.01, 10.0, "m")
"""Legs for which ground and feet are made in MuJoCo."""

_MISSED = "a foot came to lie in the ground or over it: it slid under a step, or the timestep is too long"


class MujocoRun(Run):
    """A walk in MuJoCo.

    Attributes:
        simulation: Model and state.
    """

    def __init__(
        self,
        plan: Plan,
        options: Options,
        *,
        summarised: bool = False,
        cancellation: Cancellation = never_cancelled,
        before: Simulation | None = None,
        scenery: bool = False,
        compile: bool | None = None,
    ) -> None:
        """Build the scene; see `Engine.start`.

        Args:
            plan: As checked.
            options: The engine's settings.
            summarised: Keep no tables.
            cancellation: Called now and then while it walks.
            before: The simulation of a walk of the same plan but for the first state, which is made use of again.
            scenery: See `Simulation`.
            compile: See `Simulation`.
        """
        super().__init__(plan, summarised=summarised, cancellation=cancellation)
        if before is not None:
            before.restart(plan.q, plan.dq)
        self._options = options
        self.simulation = before or Simulation(plan, options, scenery=scenery, compile=compile)

    def walk(self, show: Show) -> Outcome:
        """Step to the end."""
        for steps in stepped(self.simulation, self.recorder):
            show(steps, float(self.simulation.state.foot_x))
        return self.simulation.outcome

    def compile(self) -> bool:
        """Compile the callbacks now, unless the walk is interpreted; whether they and the laws are machine code."""
        return self.simulation.compiled

    def restart_compiled(self) -> bool:
        """Begin an interpreted walk again as machine code; see `Run.restart_compiled`."""
        if self.simulation.compiled or not can_compile(self.plan):
            return False
        self.recorder = self._new_recorder()
        self.simulation = Simulation(self.plan, self._options, compile=True)
        return self.compile()

    def peak_torque(self) -> NDArray[np.float64]:
        """Greatest magnitude of each joint's torque so far, N m."""
        return np.array(self.simulation.state.peak[: self.simulation.constants.angles])

    def pressure_times(self) -> NDArray[np.float64]:
        """How long the centre of pressure was where so far, s."""
        return np.array(self.simulation.state.pressure[2 : 2 + BINS])

    def settings(self) -> dict[str, Any]:
        """The engine's settings, what the stance foot has felt in the step under way, and MuJoCo's warnings."""
        simulation = self.simulation
        warning = simulation.data.warning
        texts = [mujoco.mju_warningText(kind, int(warning.lastinfo[kind])) for kind in np.flatnonzero(warning.number)]
        words = {text.partition(" at ")[0].strip(): 1 for text in texts}
        if simulation.outcome is Outcome.DIVERGED:
            fault = _fault(simulation)
            if fault or not words:
                words[fault or _MISSED] = 1
        u = simulation.state
        felt = {SLIDING_WORDS: u.slides, SQUEEZING_WORDS: u.squeezes, INTRUSION_WORDS: u.intrusions}
        words |= {text: int(count) for text, count in felt.items() if count}
        step = step_under_way(slip=u.slip, friction=u.friction, normal_force=least_normal_force(u))
        return {**asdict(simulation.options), **step, "warnings": words}


def stepped(simulation: Simulation, recorder: Recorder, *, most: int = BLOCK) -> Generator[int, None, None]:
    """Step a simulation until its walk ends, recording as it goes, and give back the control after each block of steps.

    Args:
        simulation: As built; it may have been resumed in the middle.
        recorder: Takes samples and touchdowns; what it holds is complete at any moment, also when this raises.
        most: Steps in a block, at most; the walk is the same whatever they are.

    Yields:
        Touchdowns in the block.

    Raises:
        MjbipedError: A compiled law raised an exception.
    """
    try:
        while not simulation.over:
            simulation.move_on()
            recorder.cancellation()
            simulation.advance(min(BLOCK, most))
            yield simulation.take(recorder)
    finally:
        if simulation.state.outcome == Outcome.INTERRUPTED:
            take_sample(simulation.constants, simulation.state, simulation.memory)
        simulation.finish(recorder)
    if simulation.state.outcome == Outcome.INTERRUPTED:
        raise MjbipedError("a compiled law raised an exception; let law() return None to see where")


def _fault(simulation: Simulation) -> str:
    """Which torque was no number at the controller's last tick, in words; empty if none was."""
    u, controller = simulation.state, simulation.controller
    torque, q, dq = (tuple(each[: simulation.constants.angles]) for each in (u.torque, u.angles, u.turning))
    own = controller.inner if isinstance(controller, SampledController) else controller
    return fault_in(own, torque, u.time - u.transfer_time, q, dq)


PLAIN = 1e-4
"""Longest step of plain `mujoco.mj_step`, s: with longer ones impacts err (docs/physics.md)."""
_GAIT_STEP = 2.4  # duration of a gait step, sqrt(l / g)
_LANDING = 60  # short physics steps about a touchdown
_PHYSICS_STEP, _WITH_KNEES = 3.2e-4, 7.0e-4  # of CPU, interpreted, s


@dataclass(frozen=True)
class Mujoco(Options, Engine):
    """Rigid bodies and contacts; nothing of the paper's impact map is used. docs/physics.md has its accuracy.

    ```python
    mjbiped.walk(controller, terrain, engine=mjbiped.Mujoco(timestep=1e-3, control_period=2e-3))
    ```

    Attributes:
        timestep: Longest physics step, s, 1e-3 unless given; steps become shorter toward each touchdown, which ends
            one of them. Of robots with feet that have mass all steps are of one length, at most 1e-4.
        contact_timestep: Physics step during an impact, s, 1e-5 unless given; the timestep where that is shorter.
        control_period: Time between two ticks of the controller, s, a multiple of the timestep; by default it ticks at
            every physics step.
        ground: "auto", "heightfield" or "boxes"; see `mjbiped.engines.mujoco.scene`.
        lands: Whether steps end at touchdowns. With False all are of the one length `timestep`, and touchdowns come
            when the contact sensors say so: nothing but plain `mj_step`, and nothing is taken from the analytic
            profile to time an impact. That is the stricter test of the contact model; it needs steps of 0.1 ms and
            less (docs/physics.md).
        stance_knee: Of a robot with knees, "locked" or "motor": then a servo at the stance knee holds it, whose torque
            is recorded and whose work is counted (docs/knees.md).

    Raises:
        InputError: A value is outside its domain.
    """

    name: ClassVar[str] = "mujoco"
    robots: ClassVar[tuple[type[Robot], ...]] = (Robot,)

    def check(self, plan: Plan) -> None:
        """Refuse legs for which contacts are not resolved, bodies too light, and a servo where there can be none.

        Raises:
            InputError: Legs are too short or too long, MuJoCo takes a body for one without mass, or a servo is asked
                for at a knee that is not there, or with steps that cannot follow it.
        """
        if self.stance_knee == MOTOR:
            if len(plan.robot.bodies.leg) == 1:
                raise InputError('stance_knee = "motor" needs a robot with knees; leave it out, or take a KneedBiped')
            if plan.robot.knee_opens:
                raise InputError(
                    f'stance_knee = "motor": the stop of a {type(plan.robot).__name__} bears its stance knee without a '
                    "motor; leave it out, or take a KneedBiped"
                )
            longest = SERVO_PACE / servo_of(plan.robot)[2]
            if self.timestep > longest:
                raise InputError(
                    f"timestep = {self.timestep:g} s: steps of at most {longest:.2g} s follow the servo of "
                    'stance_knee = "motor" at the knees of this robot'
                )
        LEG.check("leg length in MuJoCo (engine='hybrid' takes any)", plan.robot.leg_length)
        check_masses(plan.robot)

    def check_disturbances(self, disturbances: Disturbances) -> None:
        """Refuse a control period that is no multiple of the timestep, and a delay that is none of the control period.

        Raises:
            InputError: It is so.
        """
        if disturbances.in_loop:
            period = disturbances.period(self.control_period, self.timestep)
            replace(self, control_period=period)
            disturbances.delay_ticks(period)

    def costs(self, robot: Robot) -> Costs:
        """See `mjbiped.engines.compiling`; measured in docs/hybrid.md."""
        foot = robot.bodies.foot
        timestep = (self if foot is None else for_feet(self, foot)).timestep
        steps = _GAIT_STEP * math.sqrt(robot.leg_length / robot.gravity) / timestep
        knees = len(robot.angles) > 2
        step = (_WITH_KNEES if knees else _PHYSICS_STEP) * (steps + _LANDING)
        return Costs(engine=31.0 if knees else 24.0, step=step)

    def simulation(
        self,
        controller: Controller,
        terrain: Terrain,
        *,
        steps: int | None = None,
        initial: Initial = "gait",
        robot: Robot | None = None,
        sample_period: float | None = None,
        disturbances: Disturbances | None = None,
        compile: bool | None = None,
    ) -> Simulation:
        """A robot on its ground, to be stepped by `mujoco.mj_step` in a loop of your own: in steps of `PLAIN` or less.

        Args:
            controller: See `mjbiped.walk` for this and all that follow but the last.
            terrain: The ground.
            steps: Touchdowns after which the walk is finished; 60 unless given.
            initial: The first state.
            robot: The robot that walks.
            sample_period: Time between two samples, s.
            disturbances: What the walk is disturbed by.
            compile: Whether callbacks and laws that can be compiled are; None: if that pays for so many steps.

        Raises:
            InputError: An argument is outside its domain.
            GaitError: `initial="gait"` with a controller that imitates none, on a slope that has no passive gait.
        """
        engine = replace(self, timestep=min(self.timestep, PLAIN), lands=False)
        terms = Terms(engine, steps, None, robot, sample_period, ScuffingRule())
        plan = make_plan(terms, controller, terrain, initial, disturbances=disturbances)
        return Simulation(plan, engine, compile=compile)

    def start(self, plan: Plan, *, summarised: bool = False, cancellation: Cancellation = never_cancelled) -> Run:
        """Build the scene; see `Engine.start`.

        Raises:
            MjbipedError: The walk is begun inside another one's controller.
        """
        if walking():
            raise MjbipedError("a walk cannot be started from inside another's controller")
        kind = resolve_name(plan.robot.runs[self.name]) if self.name in plan.robot.runs else MujocoRun
        run: Run = kind(plan, self, summarised=summarised, cancellation=cancellation)
        return run
