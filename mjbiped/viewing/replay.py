"""Replay of a record in the viewer."""

from __future__ import annotations

import numpy as np

from mjbiped.errors import RenderError
from mjbiped.records.record import Walk
from mjbiped.rendering.marks import Scales
from mjbiped.rendering.moments import Moment, Moments
from mjbiped.rendering.posed import PosedScene
from mjbiped.viewing.player import Source

_SAME = 1e-9  # times that differ by less are the same, s


class Replay(Source):
    """A record of either engine, in which time can run forwards and backwards."""

    goes_back = True

    def __init__(self, walk: Walk) -> None:
        """Build the scene about the start of the record.

        Raises:
            RenderError: The record holds no samples.
        """
        times = walk.samples["time"]
        if not len(times):
            raise RenderError("the record holds no samples: there is nothing to show")
        self.robot, self.terrain, self._walk = walk.robot, walk.terrain, walk
        self._begin, self._end = float(times[0]), float(times[-1])
        self._moments = Moments(walk)
        self.scales = Scales(self._moments.greatest_torque(self._begin, self._end), walk.robot.weight)
        self._scene = PosedScene(walk)
        self.restart()
        self.show()

    @property
    def time(self) -> float:
        """Time of the record, s."""
        return self._moment.time

    @property
    def ended(self) -> str:
        """Outcome, at the end of the record."""
        return self._walk.outcome if self.time >= self._end else ""

    def go_to(self, time: float) -> None:
        """Look up an instant; see `Source.go_to`."""
        self._moment = self._moments.at(min(max(time, self._begin), self._end))

    def touchdown_beside(self, direction: int) -> float:
        """Go to the next or last touchdown, or to the start or end of the record; see `Source.touchdown_beside`."""
        times = self._walk.touchdowns["time"]
        if direction > 0:
            self.go_to(float(np.min(times[times > self.time + _SAME], initial=self._end)))
        else:
            self.go_to(float(np.max(times[times < self.time - _SAME], initial=self._begin)))
        return self.time

    def restart(self) -> None:
        """Go back to the start."""
        self.go_to(self._begin)

    def moment(self) -> Moment:
        """Return the present instant."""
        return self._moment

    def show(self) -> None:
        """Set the robot to the present posture, for which MuJoCo computes contacts and forces."""
        self._scene.go_to(self._moment.qpos[0])
        self._scene.pose(self._moment, forces=True)
        self.model, self.data = self._scene.model, self._scene.data
