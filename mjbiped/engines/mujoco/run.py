"""Walks a MuJoCo simulation to its end."""

from __future__ import annotations

from collections.abc import Generator
from dataclasses import asdict
from typing import Any

import numpy as np
from numpy.typing import NDArray

from mjbiped.control.functions import fault_in
from mjbiped.disturbances.loop import SampledController
from mjbiped.engines.base import Run, Show
from mjbiped.engines.compiling import can_compile
from mjbiped.engines.mujoco.observation import INTRUSION_WORDS, SLIDING_WORDS, SQUEEZING_WORDS
from mjbiped.engines.mujoco.options import Options
from mjbiped.engines.mujoco.record import take_sample
from mjbiped.engines.mujoco.simulation import BLOCK, Simulation
from mjbiped.engines.plan import Plan
from mjbiped.errors import MjbipedError
from mjbiped.records.columns import Cancellation, Recorder, never_cancelled
from mjbiped.records.loads import BINS
from mjbiped.rules.termination import Outcome
from mjbiped.utils.mujoco import mujoco

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
        """The engine's settings, and MuJoCo's warnings."""
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
        return {**asdict(simulation.options), "warnings": words}


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
