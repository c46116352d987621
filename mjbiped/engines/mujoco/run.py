"""Steps a MuJoCo walk to its end."""

from __future__ import annotations

import math

import mujoco
import numpy as np

from mjbiped.engines.mujoco import contact_events as events
from mjbiped.engines.mujoco.compiled.registry import is_compiled
from mjbiped.engines.mujoco.simulation import LEAP, WHOLE_STATE, Simulation
from mjbiped.errors import MjbipedError
from mjbiped.numerics.jit import announced
from mjbiped.records.recorder import Recorder
from mjbiped.rules.termination import Outcome

_MISSED = "a foot came to lie in the ground or over it: it slid under a step, or the timestep is too long"


def simulate(simulation: Simulation, recorder: Recorder, *, progress: bool) -> Outcome:
    """Step a simulation until its walk ends, recording as it goes.

    Args:
        simulation: As built; it may have been resumed in the middle.
        recorder: Takes samples and touchdowns; what it holds is complete at any moment, also when this raises.
        progress: Whether to show a progress bar (never where the output is not a terminal), and to say that something
            is being compiled.

    Returns:
        The outcome.

    Raises:
        MjbipedError: A compiled law raised an exception.
    """
    from tqdm.auto import tqdm  # imported where it is used: `import mjbiped` need not wait for it

    simulation.move_on()
    limits, u = simulation.limits, simulation.data.userdata
    by_steps = math.isfinite(limits.steps)
    with (
        announced(f"{type(simulation.controller).__name__} for the engine mujoco", wanted=progress),
        simulation.callbacks(),
        tqdm(
            total=int(limits.steps) if by_steps else round(limits.distance, 2),
            desc="walking",
            unit="step" if by_steps else "m",
            disable=None if progress else True,
        ) as bar,
    ):
        leaps = _Leaps(simulation)
        try:
            while not simulation.over:
                if simulation.move_on():
                    leaps, u = _Leaps(simulation), simulation.data.userdata
                recorder.heed()
                leaps.advance()
                taken = simulation.take(recorder)
                bar.update(taken if by_steps else max(0.0, round(float(u[events.FOOT_X]), 2) - bar.n))
        finally:
            if u[events.OUTCOME] == Outcome.INTERRUPTED:
                simulation.sample()
            simulation.take(recorder)
            if u[events.TOUCHED]:  # the controller was not told of it any more
                recorder.add_touchdown(u[events.LAST_TOUCHDOWN : events.CONTROLLER_MEMORY])
    if u[events.OUTCOME] == Outcome.INTERRUPTED:
        raise MjbipedError("a compiled law raised an exception; let law() return None to see where")
    if simulation.outcome is Outcome.DIVERGED and not simulation.warnings:
        simulation.warnings[_MISSED] += 1
    return simulation.outcome


class _Leaps:
    """Steps a simulation, many steps at once where its callbacks are compiled.

    A leap in which the walk's end lies, or a warning of MuJoCo's, is taken back and made step by step.
    """

    def __init__(self, simulation: Simulation) -> None:
        self._simulation, self._model, self._data = simulation, simulation.model, simulation.data
        self._state = np.empty(mujoco.mj_stateSize(simulation.model, WHOLE_STATE))
        self._leap = LEAP if is_compiled(mujoco.get_mjcb_control()) else 1

    def advance(self) -> None:
        """Make at least one step, at most so many as the recording has room for."""
        model, data, simulation = self._model, self._data, self._simulation
        if self._leap == 1:
            mujoco.mj_step(model, data)
            return
        told, numbers = simulation.warnings.copy(), data.warning.number.copy()
        mujoco.mj_getState(model, data, self._state, WHOLE_STATE)
        mujoco.mj_step(model, data, nstep=self._leap)
        if not simulation.over:
            return
        mujoco.mj_setState(model, data, self._state, WHOLE_STATE)
        simulation.warnings, data.warning.number[:] = told, numbers  # the steps made again warn again
        while not simulation.over:
            mujoco.mj_step(model, data)
