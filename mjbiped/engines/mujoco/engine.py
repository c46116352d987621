"""`Mujoco`: the engine of rigid bodies and contacts, with its settings."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, ClassVar

from mjbiped.disturbances.disturbances import Disturbances
from mjbiped.engines.base import Engine, Run
from mjbiped.engines.compiling import Costs
from mjbiped.engines.mujoco.callback import walking
from mjbiped.engines.mujoco.feet import for_feet
from mjbiped.engines.mujoco.options import MOTOR, Options
from mjbiped.engines.mujoco.run import MujocoRun
from mjbiped.engines.mujoco.scene import check_masses
from mjbiped.engines.mujoco.servo import LONGEST, servo_of
from mjbiped.engines.mujoco.simulation import Simulation
from mjbiped.engines.plan import Initial, Plan, Terms, make_plan
from mjbiped.errors import InputError, MjbipedError
from mjbiped.records.recorder import Cancellation, never_cancelled
from mjbiped.robots.robot import Robot
from mjbiped.rules.scuffing import ScuffingRule
from mjbiped.terrain.terrain import Terrain
from mjbiped.utils import domains

if TYPE_CHECKING:
    from mjbiped.control.controller import Controller

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
            longest = LONGEST / servo_of(plan.robot)[2]
            if self.timestep > longest:
                raise InputError(
                    f"timestep = {self.timestep:g} s: steps of at most {longest:.2g} s follow the servo of "
                    'stance_knee = "motor" at the knees of this robot'
                )
        domains.MUJOCO_LEG.check("leg length in MuJoCo (engine='hybrid' takes any)", plan.robot.leg_length)
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
        return MujocoRun(plan, self, summarised=summarised, cancellation=cancellation)
