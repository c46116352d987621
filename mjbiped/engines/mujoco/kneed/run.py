"""Walks the biped with knees in MuJoCo to its end."""

from __future__ import annotations

from contextlib import AbstractContextManager, ExitStack
from dataclasses import asdict
from typing import Any

import numpy as np
from numpy.typing import NDArray

from mjbiped.engines.base import Run, Show
from mjbiped.engines.mujoco.compiled import registry
from mjbiped.engines.mujoco.compiled.registry import NO_CALLBACKS
from mjbiped.engines.mujoco.kneed.simulation import KneedSimulation
from mjbiped.engines.mujoco.options import Options
from mjbiped.engines.mujoco.run import explain, gave_up, ticking
from mjbiped.engines.plan import DEFAULT_SAMPLE_PERIOD, Plan
from mjbiped.records.recorder import Cancellation, Recorder
from mjbiped.rules.termination import Outcome


class KneedRun(Run):
    """A walk of the biped with knees in MuJoCo.

    Attributes:
        simulation: Model and state.
    """

    def __init__(self, plan: Plan, options: Options, *, summarised: bool, cancellation: Cancellation) -> None:
        """Build the scene; see `Engine.start`."""
        super().__init__(plan, summarised=summarised, cancellation=cancellation)
        period = plan.terms.sample_period
        if plan.disturbances.in_loop:
            options = ticking(options, plan.disturbances)
        self._options = options
        arguments = plan.arguments()
        del arguments["scuffing"]  # knees need no such rule
        self.simulation = KneedSimulation(
            plan.driven(options.control_period or 0.0),
            plan.terrain,
            **arguments,
            sample_period=DEFAULT_SAMPLE_PERIOD if period is None else period,
            friction=plan.disturbances.friction,
            options=options,
        )

    def compile(self) -> bool:
        """Whether the stepping is compiled."""
        return self.simulation.compile()

    def sharing(self) -> AbstractContextManager[None]:
        """Compiled stepping needs no callbacks but that for warnings."""
        return registry.shared_callbacks(NO_CALLBACKS)

    def shares_with(self, other: Run) -> bool:
        """Whether both are compiled walks with knees."""
        return isinstance(other, KneedRun) and self.simulation.compiled

    def message(self, error: BaseException) -> str:
        """What went wrong, and when: in the controller, or in MuJoCo itself."""
        return gave_up(error, self.recorder, self.simulation.model) or super().message(error)

    def walk(self, show: Show) -> Outcome:
        """Step to the end."""
        simulation, recorder = self.simulation, self.recorder
        with ExitStack() as stack:
            if registry.shared() is NO_CALLBACKS and simulation.compiled:
                stack.enter_context(registry.stepped_under_shared(simulation.warn))
            else:
                stack.enter_context(registry.exclusive())
                stack.enter_context(registry.own_callbacks(simulation, {"mju_user_warning": simulation.warn}))
            return self._walked(simulation, recorder, show)

    @staticmethod
    def _walked(simulation: KneedSimulation, recorder: Recorder, show: Show) -> Outcome:
        try:
            while simulation.outcome is Outcome.WALKING:
                recorder.cancellation()
                simulation.block()
                show(simulation.take(recorder), simulation.place)
        finally:
            simulation.take(recorder)
        if simulation.outcome is Outcome.DIVERGED:
            explain(simulation.warnings, simulation.fault())
        return simulation.outcome

    def peak_torque(self) -> NDArray[np.float64]:
        """Greatest magnitude of each joint's torque so far, N m."""
        return self.simulation.peak_torque

    def pressure_times(self) -> NDArray[np.float64]:
        """How long the centre of pressure was where so far, s."""
        return self.simulation.pressure_times

    def settings(self) -> dict[str, Any]:
        """The engine's settings, and warnings."""
        return {**asdict(self._options), "warnings": self.simulation.told}
