"""Passive walks of Drake's `CompassGait`: what the benchmark measures the hybrid engine against, Drake's own model.

Optional: `pip install drake`. Drake's robot has legs without inertia, its angles are those of the legs from the
vertical; it touches down where the swing leg, ahead of the stance leg, makes with it an isosceles triangle on the ramp.
"""

from __future__ import annotations

import time
from typing import Any

import numpy as np
from numpy.typing import NDArray
from pydrake.examples import CompassGait
from pydrake.systems.analysis import ResetIntegratorFromFlags, Simulator
from pydrake.systems.framework import EventStatus

from mjbiped.robots.compass import Compass

INTEGRATORS = ("runge_kutta3", "runge_kutta5")
"""Drake's default, and its most exact explicit one."""
LONGEST_STEP = 0.1  # s, Drake's own


def robot_and_slope() -> tuple[Compass, float]:
    """Drake's robot as one of ours, and the slope of its ramp (rad)."""
    given = CompassGait().CreateDefaultContext().get_numeric_parameter(0)
    upper = float(given.center_of_mass_leg())
    robot = Compass(
        leg_mass=float(given.mass_leg()),
        hip_mass=float(given.mass_hip()),
        lower_length=float(given.length_leg()) - upper,
        upper_length=upper,
        leg_inertia=0.0,
        gravity=float(given.gravity()),
    )
    return robot, float(given.slope())


def derivatives(state: NDArray[np.float64]) -> NDArray[np.float64]:
    """Drake's rates of stance and swing leg from the vertical and of their rates, without a hip torque."""
    system = CompassGait()
    context = system.CreateDefaultContext()
    context.SetContinuousState(state)
    return np.asarray(system.EvalTimeDerivatives(context).CopyToVector())


class DrakeWalk:
    """A walk down Drake's ramp."""

    def __init__(self, integrator: str, accuracy: float) -> None:
        """Build the simulator.

        Args:
            integrator: One of `INTEGRATORS`.
            accuracy: Drake's target; it also sets how closely a touchdown is isolated.
        """
        self.slope = robot_and_slope()[1]
        self._system = CompassGait()
        self._simulator = Simulator(self._system)
        ResetIntegratorFromFlags(self._simulator, integrator, LONGEST_STEP)
        self._simulator.get_mutable_integrator().set_target_accuracy(accuracy)
        self._simulator.get_mutable_context().SetAccuracy(accuracy)

    def _begin(self, start: NDArray[np.float64]) -> None:
        context = self._simulator.get_mutable_context()
        context.SetTime(0.0)
        context.SetContinuousState(start + np.array([self.slope, self.slope, 0.0, 0.0]))
        context.SetDiscreteState([0.0])
        self._simulator.Initialize()

    def touchdowns(self, start: NDArray[np.float64], until: float) -> NDArray[np.float64]:
        """Walk, and look after each integration step.

        Args:
            start: q1, q2, dq1, dq2 at the start, from the ramp's normal.
            until: Time, s.

        Returns:
            State (rad, rad/s) just before the impact of each touchdown, and its time (s), shape (touchdowns, 5).
        """
        found: list[list[float]] = []
        before: list[Any] = [None, 0.0]  # the state before, and where the stance foot was

        def look(context: Any) -> Any:
            toe = context.get_discrete_state_vector()[0]
            if toe != before[1]:  # Drake looks before it exchanges the legs, and next after a step behind that
                found.append(before[0])
            before[:] = [*context.get_continuous_state_vector().CopyToVector(), context.get_time()], toe
            return EventStatus.DidNothing()

        self._simulator.set_monitor(look)
        self._begin(start)
        self._simulator.AdvanceTo(until)
        self._simulator.clear_monitor()
        touchdowns = np.array(found, dtype=np.float64)
        touchdowns[:, :2] -= self.slope
        return touchdowns

    def timed(self, start: NDArray[np.float64], until: float) -> float:
        """CPU time of the same walk, s, without anything that looks on."""
        self._begin(start)
        started = time.thread_time()
        self._simulator.AdvanceTo(until)
        return time.thread_time() - started
