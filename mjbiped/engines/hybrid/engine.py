"""`Hybrid`: the engine of the paper's equations and impact map, with its settings."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Annotated, ClassVar

from mjbiped.disturbances.disturbances import Disturbances
from mjbiped.engines.base import Engine
from mjbiped.engines.compiling import Costs
from mjbiped.engines.hybrid.run import TOLERANCE, HybridRun
from mjbiped.engines.plan import Plan
from mjbiped.errors import InputError
from mjbiped.records.recorder import Cancellation, never_cancelled
from mjbiped.robots.robot import Robot
from mjbiped.utils import domains


@dataclass(frozen=True)
class Hybrid(Engine):
    """The paper's equations of motion and impact map, integrated from touchdown to touchdown; see docs/hybrid.md.

    It has no timestep, and its controller acts without pause, unless `mjbiped.Disturbances` make it tick.

    Attributes:
        tolerance: Of an integration step, relative and absolute.

    Raises:
        InputError: It is outside its domain.
    """

    name: ClassVar[str] = "hybrid"
    robots: ClassVar[tuple[type[Robot], ...]] = (Robot,)

    tolerance: Annotated[float, domains.TOLERANCE] = TOLERANCE

    def __post_init__(self) -> None:
        """Check the value."""
        domains.check_fields(self)

    def check_disturbances(self, disturbances: Disturbances) -> None:
        """Refuse a delay that does not fit the control period, and friction.

        Raises:
            InputError: It does not, or there is one.
        """
        if disturbances.friction is not None:
            raise InputError(
                f"friction = {disturbances.friction:g}: the hybrid engine's stance foot never slips; walk in mujoco, "
                "or see in the record how much friction is asked for"
            )
        disturbances.delay_ticks(disturbances.period(None, 0.0))

    def costs(self, robot: Robot) -> Costs:
        """See `mjbiped.engines.compiling`; measured in docs/hybrid.md."""
        return Costs(engine=25.0, step=0.045 if len(robot.angles) < 3 else 0.11)

    def start(self, plan: Plan, *, summarised: bool = False, cancellation: Cancellation = never_cancelled) -> HybridRun:
        """Set the robot on the ground; see `Engine.start`."""
        return HybridRun(plan, self.tolerance, summarised=summarised, cancellation=cancellation)
