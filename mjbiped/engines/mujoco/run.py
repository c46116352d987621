"""Walks a MuJoCo simulation to its end."""

from __future__ import annotations

from collections import Counter
from collections.abc import Generator
from contextlib import AbstractContextManager
from dataclasses import asdict, replace
from typing import Any

import mujoco
import numpy as np
from numpy.typing import NDArray

from mjbiped.control.validation import fault_in
from mjbiped.disturbances.disturbances import Disturbances
from mjbiped.disturbances.sampled import SampledController
from mjbiped.engines.base import Run, Show
from mjbiped.engines.mujoco import callbacks, contact_events
from mjbiped.engines.mujoco.compiled.registry import is_compiled, shared_callbacks
from mjbiped.engines.mujoco.options import Options
from mjbiped.engines.mujoco.simulation import BLOCK, WHOLE_STATE, Simulation
from mjbiped.engines.plan import DEFAULT_SAMPLE_PERIOD, Plan
from mjbiped.errors import MjbipedError
from mjbiped.records.recorder import Cancellation, Recorder, never_cancelled
from mjbiped.rules.termination import Outcome

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
    ) -> None:
        """Build the scene; see `Engine.start`.

        Args:
            plan: As checked.
            options: The engine's settings.
            summarised: Keep no tables.
            cancellation: Called now and then while it walks.
            before: The simulation of a walk of the same plan but for the first state, which is made use of again.
            scenery: See `Simulation`.
        """
        super().__init__(plan, summarised=summarised, cancellation=cancellation)
        if before is not None:
            before.restart(plan.q, plan.dq)
            self.simulation = before
            return
        period = plan.terms.sample_period
        driven = plan.controller
        if plan.disturbances.in_loop:
            options = ticking(options, plan.disturbances)
            driven = plan.driven(options.control_period or 0.0)
        self.simulation = Simulation(
            driven,
            plan.terrain,
            **plan.arguments(),
            friction=plan.disturbances.friction,
            options=options,
            # also where no samples are kept: the last one tells where a walk that was broken off has been
            sample_period=DEFAULT_SAMPLE_PERIOD if period is None else period,
            scenery=scenery,
        )

    def walk(self, show: Show) -> Outcome:
        """Step to the end."""
        return simulate(self.simulation, self.recorder, show)

    def compile(self) -> bool:
        """Whether the callbacks are compiled ones."""
        return self.simulation.compiled

    def sharing(self) -> AbstractContextManager[None]:
        """The compiled callbacks, installed for all threads."""
        assert self.simulation.functions is not None
        return shared_callbacks(self.simulation.functions)

    def shares_with(self, other: Run) -> bool:
        """Whether both have the same compiled callbacks."""
        return isinstance(other, MujocoRun) and self.simulation.functions is other.simulation.functions

    def message(self, error: BaseException) -> str:
        """What went wrong, and when: in the controller, or in MuJoCo itself."""
        return gave_up(error, self.recorder, self.simulation.model) or super().message(error)

    def peak_torque(self) -> NDArray[np.float64]:
        """Greatest |ankle| and |hip| torque so far, N m."""
        u = self.simulation.data.userdata
        return np.array([u[contact_events.PEAK_ANKLE], u[contact_events.PEAK_HIP]])

    def pressure_times(self) -> NDArray[np.float64]:
        """How long the centre of pressure was where so far, s."""
        return contact_events.pressure_times(self.simulation.data.userdata)

    def settings(self) -> dict[str, Any]:
        """The engine's settings, and MuJoCo's warnings."""
        warnings = contact_events.warned(self.simulation.warnings, self.simulation.data.userdata)
        return {**asdict(self.simulation.options), "warnings": warnings}


def gave_up(error: BaseException, recorder: Recorder, model: mujoco.MjModel) -> str:
    """What to say of a walk in which MuJoCo itself failed; empty where it did not."""
    if not isinstance(error, mujoco.FatalError):
        return ""
    (time, _), reason = recorder.end, " ".join(str(error).split())
    return (
        f"MuJoCo gave up at {time:.3f} s, after {recorder.steps} steps, for no fault of the controller: {reason}. "
        f"Its scene has {model.ngeom} geoms; a ground of fewer, longer segments needs fewer, and the hybrid engine has "
        "none"
    )


def ticking(options: Options, disturbances: Disturbances) -> Options:
    """The settings with the control period of a disturbed loop.

    Raises:
        InputError: It does not fit the timestep.
    """
    return replace(options, control_period=disturbances.period(options.control_period, options.timestep))


def simulate(simulation: Simulation, recorder: Recorder, show: Show | None = None) -> Outcome:
    """Step a simulation until its walk ends, recording as it goes.

    Args:
        simulation: As built; it may have been resumed in the middle.
        recorder: Takes samples and touchdowns; what it holds is complete at any moment, also when this raises.
        show: Called after each block of steps, for a progress bar.

    Returns:
        The outcome.

    Raises:
        MjbipedError: A compiled law raised an exception.
    """
    for steps in stepped(simulation, recorder):
        if show is not None:
            show(steps, float(simulation.data.userdata[contact_events.FOOT_X]))
    return simulation.outcome


def stepped(simulation: Simulation, recorder: Recorder, *, most: int = BLOCK) -> Generator[int, None, None]:
    """Step a simulation until its walk ends, as `simulate` does, giving back the control after each block of steps.

    The simulation's callbacks are installed until the walk has ended or the generator is closed.

    Args:
        simulation: See `simulate`.
        recorder: See `simulate`.
        most: Steps in a block, at most; the walk is the same whatever they are.

    Yields:
        Touchdowns in the block.

    Raises:
        MjbipedError: A compiled law raised an exception.
    """
    simulation.move_on()
    with simulation.callbacks():
        blocks = _Blocks(simulation, most)
        try:
            while not simulation.over:
                if simulation.move_on():
                    blocks = _Blocks(simulation, most)
                recorder.cancellation()
                blocks.advance()
                yield simulation.take(recorder)
        finally:
            u = simulation.data.userdata
            if u[contact_events.OUTCOME] == Outcome.INTERRUPTED:
                simulation.sample()
            simulation.take(recorder)
            if u[contact_events.TRANSFERRED]:  # the controller was not told of it any more
                recorder.add_touchdown(u[contact_events.LAST_TOUCHDOWN : contact_events.CONTROLLER_MEMORY])
    if u[contact_events.OUTCOME] == Outcome.INTERRUPTED:
        raise MjbipedError("a compiled law raised an exception; let law() return None to see where")
    if simulation.outcome is Outcome.DIVERGED:
        explain(simulation.warnings, _fault(simulation))


def explain(warnings: Counter[str], fault: str) -> None:
    """Note why a walk has diverged.

    Args:
        warnings: So far; changed.
        fault: Which torque was no number, in words; empty if none was.
    """
    if fault:
        warnings[fault] += 1
    elif not warnings:
        warnings[_MISSED] += 1


def _fault(simulation: Simulation) -> str:
    """Which torque was no number at the controller's last tick, in words; empty if none was."""
    u = simulation.data.userdata.tolist()
    q, dq = callbacks.posture(u)
    torque, t = (
        (u[contact_events.ANKLE], u[contact_events.HIP]),
        u[contact_events.TIME] - u[contact_events.TRANSFER_TIME],
    )
    controller = simulation.controller
    own = controller.inner if isinstance(controller, SampledController) else controller
    return fault_in(own, torque, t, q, dq)


class _Blocks:
    """Steps a simulation, a block of many steps at once where its callbacks are compiled.

    A block in which the walk's end lies, or a warning of MuJoCo's, is taken back and made step by step.
    """

    def __init__(self, simulation: Simulation, most: int) -> None:
        self._simulation, self._model, self._data = simulation, simulation.model, simulation.data
        self._state = np.empty(mujoco.mj_stateSize(simulation.model, WHOLE_STATE))
        self._steps = min(BLOCK, most) if is_compiled(mujoco.get_mjcb_control()) else 1

    def advance(self) -> None:
        """Make at least one step, at most so many as the recording has room for."""
        model, data, simulation = self._model, self._data, self._simulation
        if self._steps == 1:
            mujoco.mj_step(model, data)
            return
        warnings, numbers = simulation.warnings.copy(), data.warning.number.copy()
        mujoco.mj_getState(model, data, self._state, WHOLE_STATE)
        mujoco.mj_step(model, data, nstep=self._steps)
        if not simulation.over:
            return
        mujoco.mj_setState(model, data, self._state, WHOLE_STATE)
        simulation.warnings, data.warning.number[:] = warnings, numbers  # the steps made again warn again
        while not simulation.over:
            mujoco.mj_step(model, data)
