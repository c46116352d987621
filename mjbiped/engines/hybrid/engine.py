"""`Hybrid`: the engine of the paper's equations and impact map, with its settings."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any, ClassVar

import numpy as np
from numpy.typing import NDArray

from mjbiped.disturbances.disturbances import Disturbances
from mjbiped.engines.base import Engine, Run, Show
from mjbiped.engines.hybrid.simulation import TOLERANCE, HybridSimulation, idle_states, simulate
from mjbiped.engines.plan import Plan
from mjbiped.errors import InputError
from mjbiped.records.recorder import Cancellation, never_cancelled
from mjbiped.robots.compass import Compass
from mjbiped.robots.kneed import KneedBiped
from mjbiped.robots.robot import Robot
from mjbiped.rules.termination import Outcome
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
    robots: ClassVar[tuple[type[Robot], ...]] = (Compass, KneedBiped)

    tolerance: float = TOLERANCE

    def __post_init__(self) -> None:
        """Check the value."""
        domains.check_fields(self, tolerance=domains.TOLERANCE)

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

    def room(self, states: int, robot: Robot) -> int:
        """With knees, controllers without states have idle ones; see `Engine.room`."""
        return states + idle_states(states, robot)

    def start(self, plan: Plan, *, summarised: bool = False, cancellation: Cancellation = never_cancelled) -> HybridRun:
        """Set the robot on the ground; see `Engine.start`."""
        return HybridRun(plan, self.tolerance, summarised=summarised, cancellation=cancellation)


class HybridRun(Run):
    """A walk in the hybrid model.

    Attributes:
        simulation: The model and its state.
    """

    def __init__(self, plan: Plan, tolerance: float, *, summarised: bool, cancellation: Cancellation) -> None:
        """Set the robot on the ground; see `Engine.start`."""
        super().__init__(plan, summarised=summarised, cancellation=cancellation)
        self._tolerance = tolerance
        period, control_period = plan.terms.sample_period, plan.disturbances.period(None, 0.0)
        self.simulation = HybridSimulation(
            plan.driven(control_period),
            plan.terrain,
            **plan.arguments(),
            sample_period=period if period is not None and self.sampled else math.inf,
            tolerance=tolerance,
            control_period=control_period,
        )

    def walk(self, show: Show) -> Outcome:
        """Integrate to the end."""
        return simulate(self.simulation, self.recorder, show)

    def compile(self) -> bool:
        """Compile the controller's laws."""
        self.simulation.compile()
        return self.simulation.compiled

    def peak_torque(self) -> NDArray[np.float64]:
        """Greatest magnitude of each joint's torque so far, N m."""
        return self.simulation.peak_torque

    def pressure_times(self) -> NDArray[np.float64]:
        """How long the centre of pressure was where so far, s."""
        return self.simulation.pressure_times

    def settings(self) -> dict[str, Any]:
        """The tolerance, and why the walk ended where its outcome does not say it."""
        simulation = self.simulation
        settings = {"tolerance": self._tolerance, "compiled": simulation.compiled}
        return {**settings, "warnings": simulation.warnings} if simulation.warnings else settings
