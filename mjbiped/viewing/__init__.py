"""The viewer: a window that shows a walk under way, or replays a record; here its time and its keys.

They are here, without MuJoCo, which takes long to load, because the command line's help shows the keys.
"""

from __future__ import annotations

import math
from collections import deque
from collections.abc import Mapping
from typing import TYPE_CHECKING, NamedTuple

if TYPE_CHECKING:  # the command line's help does not need it
    from mjbiped.viewing.sources import Source

STRIDE = 0.01
"""Time of the walk by which a key steps back or forth, s."""

FASTEST, SLOWEST = 16.0, 1.0 / 64.0
"""Speeds that the keys reach, walk time over real time."""

_LONGEST = 0.1  # longest real time that a frame makes up for, s; on a slower computer the walk is slower
_MEASURED = 0.5  # real time over which the speed is measured, s


class Key(NamedTuple):
    """Action of one or more keys.

    Attributes:
        codes: GLFW's codes of the keys.
        name: Names of the keys for the help.
        does: Action in words for the help.
    """

    codes: tuple[int, ...]
    name: str
    does: str


# the numbers are GLFW's: https://www.glfw.org/docs/latest/group__keys.html
KEYS: Mapping[str, Key] = {
    "pause": Key((32,), "Space", "pause, go on"),
    "slower": Key((264, 45), "Down, -", "half the speed"),
    "faster": Key((265, 61), "Up, +", "twice the speed"),
    "back": Key((263,), "Left", "0.01 s back (records)"),
    "forward": Key((262,), "Right", "0.01 s forward"),
    "last_touchdown": Key((44,), ", (comma)", "previous touchdown (records)"),
    "next_touchdown": Key((46,), ". (full stop)", "next touchdown"),
    "restart": Key((259,), "Backspace", "restart the walk"),
    "next_seed": Key((257,), "Enter", "next random ground"),
    "help": Key((297,), "F8", "hide, show these keys"),
}
"""Actions of the keys; all other keys are those of MuJoCo's viewer."""

MOUSE: Mapping[str, str] = {
    "double click": "choose a leg or the hip",
    "Ctrl+right drag": "push what is chosen",
    "drag, wheel": "turn, move, zoom",
    "F, C, F1": "contact forces, points, MuJoCo's keys",
}
"""Actions of the mouse, and useful keys of MuJoCo's viewer."""


class Player:
    """Moves the time of a walk by the clock and the keys.

    Attributes:
        source: The walk.
        speed: Requested walk time over real time.
        paused: Whether time stands still.
        helps: Whether the keys are shown.
        reached: Measured walk time over real time; NaN until it is measured.
    """

    def __init__(self, source: Source, *, speed: float = 1.0) -> None:
        """Begin at the present time of the walk."""
        self.source, self.speed, self.paused, self.reached = source, speed, False, math.nan
        self.helps = True
        self._pressed: deque[int] = deque()
        self._due = self._from = source.time
        self._real = 0.0

    def press(self, code: int) -> None:
        """Note a pressed key (GLFW's code) from any thread; it acts at the next `tick`."""
        self._pressed.append(code)

    def tick(self, elapsed: float) -> None:
        """Act on the keys, and let the walk go on for an elapsed real time (s).

        Raises:
            WalkStopped: The controller raised an exception.
        """
        while self._pressed:
            code = self._pressed.popleft()
            for name, key in KEYS.items():
                if code in key.codes:
                    self._act(name)
        if self.paused or self.source.ended:
            self._measure()
            return
        self._due += min(elapsed, _LONGEST) * self.speed
        self.source.go_to(self._due)
        self._real += elapsed
        if self._real > _MEASURED:
            self.reached = (self.source.time - self._from) / self._real
            self._real, self._from = 0.0, self.source.time

    def _measure(self) -> None:
        """Start measuring the speed now."""
        self._real, self._from, self.reached = 0.0, self.source.time, math.nan

    def _act(self, name: str) -> None:
        """Do what a key of a name in `KEYS` does."""
        source = self.source
        source.news = ""
        if name == "pause":
            self.paused = not self.paused
        elif name == "help":
            self.helps = not self.helps
        elif name in ("slower", "faster"):
            self.speed = min(FASTEST, max(SLOWEST, self.speed * (0.5 if name == "slower" else 2.0)))
            self._measure()
        elif name in ("back", "last_touchdown") and not source.goes_back:
            self.paused = True
            source.news = "a walk under way cannot go back: write a record (mjbiped walk --out) and view that"
        else:
            if name == "restart":
                source.restart()
            elif name == "next_seed":
                source.next_seed()
            else:
                self.paused = True
                if name in ("back", "forward"):
                    source.go_to(source.time + (STRIDE if name == "forward" else -STRIDE))
                else:
                    source.touchdown_beside(1 if name == "next_touchdown" else -1)
            self._due = source.time  # from which the walk goes on
            self._measure()
