"""Takes samples and touchdowns of a MuJoCo walk while it is stepped."""

from __future__ import annotations

from typing import TYPE_CHECKING

import mujoco
import numpy as np
from numpy.typing import NDArray

from mjbiped import events
from mjbiped.columns import SAMPLES, TOUCHDOWNS, split

if TYPE_CHECKING:
    from controllers.base import Controller


class Recorder:
    """Grows with the walk; its tables may be asked for at any moment.

    Attributes:
        sample_period: Time between two samples, s.
        userdata: The engine's memory at the last sample; see `mjbiped.events`.
    """

    def __init__(self, sample_period: float) -> None:
        """Begin an empty recording.

        Args:
            sample_period: Time between two samples, s.
        """
        self.sample_period = sample_period
        self.userdata: list[float] = []
        self._samples: list[list[float]] = []
        self._states: list[list[float]] = []
        self._touchdowns: list[list[float]] = []
        self._count: float | None = None
        self._open = False  # the last touchdown's row waits for the controller's estimate
        self._width = 0

    def sample(self, data: mujoco.MjData, controller: Controller) -> None:
        """Take a sample of the state now and of the torque held until now.

        Where the last step resolved a touchdown, the rates are already those after the impact, and so are the roles
        here, though the engine exchanges them at its next step.
        """
        u = data.userdata.tolist()
        qpos, qvel = data.qpos.tolist(), data.qvel.tolist()
        memory = u[events.CONTROLLER_MEMORY :]
        slope, stance = u[events.SLOPE], int(u[events.STANCE])
        if u[events.NOTED]:
            slope, stance = u[events.NOTED_SLOPE], 1 - stance
        q = [qpos[2 + stance] - slope, qpos[3 - stance] - slope]
        dq = [qvel[2 + stance], qvel[3 - stance]]
        torque = [u[events.ANKLE], u[events.HIP]]
        self._samples.append([data.time, *q, *dq, *torque, slope, controller.slope_estimate(memory), stance, *qpos])
        self._width = len(controller.states)
        self._states.append(memory[: self._width])
        self.userdata = u
        if self._count is None:
            self._count = u[events.COUNT]  # above zero where the walk was resumed

    def take_touchdown(self, data: mujoco.MjData) -> bool:
        """Take the last touchdown's row if it is a new one; to be asked after every physics step.

        A controller that ticks less often than the physics takes notice later: then the row is taken again.
        """
        u = data.userdata
        count, new = u[events.COUNT], u[events.COUNT] != self._count
        if not new and not (self._open and not u[events.TOUCHED]):
            return False
        row = u[events.LAST_TOUCHDOWN : events.CONTROLLER_MEMORY].tolist()
        if new:
            self._touchdowns.append(row)
        else:
            self._touchdowns[-1] = row
        self._count, self._open = count, bool(u[events.TOUCHED])
        return bool(new)

    def samples(self) -> dict[str, NDArray[np.float64]]:
        """Samples so far; see `mjbiped.columns.SAMPLES`."""
        states = np.array(self._states, dtype=np.float64).reshape(len(self._states), self._width)
        return {**split(SAMPLES, self._samples), "controller_states": states}

    def touchdowns(self) -> dict[str, NDArray[np.float64]]:
        """Touchdowns so far; see `mjbiped.columns.TOUCHDOWNS`."""
        return split(TOUCHDOWNS, self._touchdowns)
