"""What a window can show: a walk under way or a record, at a time that the viewer asks for."""

from __future__ import annotations

from abc import ABC, abstractmethod
from typing import TYPE_CHECKING

if TYPE_CHECKING:  # the command line's help needs none of them
    import mujoco

    from mjbiped.rendering.marks import Scales
    from mjbiped.rendering.moments import Moment
    from mjbiped.robots.robot import Robot
    from mjbiped.terrain.terrain import Terrain


class Source(ABC):
    """A walk that can be seen.

    Attributes:
        model: The scene that is seen. It is another object where another part of the ground has been built.
        data: Its state; whatever is done to it, the walk does not change.
        robot: The robot.
        terrain: The ground.
        scales: Of torques and forces, for `mjbiped.rendering.marks.draw_marks`.
        goes_back: Whether times that have passed can be shown again.
        news: What the viewer should say, a sentence; empty where there is nothing.
    """

    model: mujoco.MjModel
    data: mujoco.MjData
    robot: Robot
    terrain: Terrain
    scales: Scales
    goes_back: bool
    news: str = ""

    @property
    @abstractmethod
    def time(self) -> float:
        """Of the walk, s."""

    @property
    @abstractmethod
    def ended(self) -> str:
        """How the walk ended, in words; empty while it goes on."""

    @abstractmethod
    def go_to(self, time: float) -> None:
        """Bring the walk to a time (s), or to its end if that is before.

        A time that has passed is for sources that go back; for others it changes nothing.
        """

    @abstractmethod
    def touchdown_beside(self, direction: int) -> float:
        """Time of the next (1) or the last (-1) touchdown, s; the walk has been brought there, or to its end."""

    @abstractmethod
    def restart(self) -> None:
        """Begin anew."""

    def next_seed(self) -> None:
        """Begin anew on the next ground, where there is another; else say so in `news`."""
        self.news = "only random ground has seeds"

    def push(self, perturbation: mujoco.MjvPerturb) -> None:
        """Let the mouse pull the robot from now on, as MuJoCo's viewers do."""
        if perturbation.active:
            self.news = "a record cannot be pushed"

    @abstractmethod
    def moment(self) -> Moment:
        """All that is drawn of the walk now."""

    @abstractmethod
    def show(self) -> None:
        """Bring `data` to the walk's state."""

    def close(self) -> None:
        """End the walk."""
        return
