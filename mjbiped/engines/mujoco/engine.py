"""`Mujoco`: the engine of rigid bodies and contacts, with its settings."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from typing import ClassVar

from mjbiped.disturbances.disturbances import Disturbances
from mjbiped.engines.base import Engine, Run
from mjbiped.engines.mujoco.compiled.registry import exclusive, require_no_callbacks, walking
from mjbiped.engines.mujoco.kneed.run import KneedRun
from mjbiped.engines.mujoco.kneed.servo import LONGEST, frequency_of
from mjbiped.engines.mujoco.options import MOTOR, ROOM, Options
from mjbiped.engines.mujoco.run import MujocoRun, ticking
from mjbiped.engines.plan import Plan
from mjbiped.errors import InputError, MjbipedError
from mjbiped.records.recorder import Cancellation, never_cancelled
from mjbiped.robots.compass import Compass
from mjbiped.robots.kneed import KneedBiped
from mjbiped.robots.robot import Robot
from mjbiped.utils import domains


@dataclass(frozen=True)
class Mujoco(Options, Engine):
    """Rigid bodies and contacts; nothing of the paper's impact map is used. docs/physics.md has its accuracy.

    ```python
    mjbiped.walk(controller, terrain, engine=mjbiped.Mujoco(timestep=1e-3, control_period=2e-3))
    ```

    Attributes:
        timestep: Longest physics step, s, 1e-3 unless given; steps become shorter toward each touchdown, which ends
            one of them.
        contact_timestep: Of the step that makes an impact, s, 1e-5 unless given; the timestep where that is shorter.
        control_period: Time between two ticks of the controller, s, a multiple of the timestep; by default it ticks at
            every physics step.
        ground: "auto", "heightfield" or "boxes"; see `mjbiped.engines.mujoco.scene`.
        lands: Whether steps end at touchdowns. With False all are of the one length `timestep`, and touchdowns come
            when the contact sensors say so: nothing but plain `mj_step`, and nothing is taken from the analytic
            profile to time an impact. That is the stricter test of the contact model; it needs steps of 0.1 ms and
            less (docs/convergence.md).
        stance_knee: Of a robot with knees, "locked" or "motor": then a servo at the stance knee holds it, whose torque
            is recorded and whose work is counted (docs/kneed_walks.md).

    Raises:
        InputError: A value is outside its domain.
    """

    name: ClassVar[str] = "mujoco"
    robots: ClassVar[tuple[type[Robot], ...]] = (Compass, KneedBiped)

    def check(self, plan: Plan) -> None:
        """Refuse legs of a length for which contacts are not resolved, and a servo where there can be none.

        Raises:
            InputError: They are too short or too long, or one is asked for.
        """
        if self.stance_knee == MOTOR:
            self._check_servo(plan.robot)
        domains.MUJOCO_LEG.check("leg length in MuJoCo (engine='hybrid' takes any)", plan.robot.leg_length)

    def _check_servo(self, robot: Robot) -> None:
        """Refuse a servo at a knee that is not there, or with steps that cannot follow it.

        Raises:
            InputError: It is so.
        """
        if not isinstance(robot, KneedBiped):
            raise InputError('stance_knee = "motor" needs a robot with knees; leave it out, or take a KneedBiped')
        longest = LONGEST / frequency_of(robot)
        if self.timestep > longest:
            raise InputError(
                f"timestep = {self.timestep:g} s: steps of at most {longest:.2g} s follow the servo of "
                'stance_knee = "motor" at the knees of this robot'
            )

    def check_disturbances(self, disturbances: Disturbances) -> None:
        """Refuse a control period that is no multiple of the timestep, and a delay that is none of the control period.

        Raises:
            InputError: It is so.
        """
        if disturbances.in_loop:
            period = ticking(self, disturbances).control_period
            assert period is not None
            disturbances.delay_ticks(period)

    def room(self, states: int, robot: Robot) -> int:
        """One machine code serves all controllers with up to eight states; see `Engine.room`."""
        return max(states, ROOM)

    def start(self, plan: Plan, *, summarised: bool = False, cancellation: Cancellation = never_cancelled) -> Run:
        """Build the scene; see `Engine.start`."""
        if plan.robot.knees:
            return KneedRun(plan, self, summarised=summarised, cancellation=cancellation)
        return MujocoRun(plan, self, summarised=summarised, cancellation=cancellation)

    @contextmanager
    def session(self, *, many: bool = False) -> Iterator[None]:
        """Keep MuJoCo's callbacks, which are globals of the process, for these walks.

        Raises:
            MjbipedError: Somebody else has them.
        """
        with exclusive():
            if walking():
                raise MjbipedError("a walk cannot be started from inside another's controller")
            if many:
                require_no_callbacks()
            yield
