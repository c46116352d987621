"""Time in the viewer: pausing, speed, steps back and forth, and what the keys do."""

from __future__ import annotations

import math
from collections import deque
from collections.abc import Callable, Mapping
from typing import NamedTuple

from mjbiped.viewing.source import Source

STRIDE = 0.01
"""By how much a key steps back or forth, s of the walk."""

FASTEST, SLOWEST = 16.0, 1.0 / 64.0
"""Speeds that the keys reach, in walk time by real time."""

_LONGEST = 0.1  # real time that a frame makes up for, s; where the computer is slower, the walk is
_MEASURED = 0.5  # real time over which the speed is measured, s


class Key(NamedTuple):
    """What a key does.

    Attributes:
        codes: GLFW's codes of the keys that do it.
        name: Of the keys, for the help.
        does: In words, for the help.
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
    "last_touchdown": Key((44,), ", (comma)", "last touchdown (records)"),
    "next_touchdown": Key((46,), ". (full stop)", "next touchdown"),
    "restart": Key((259,), "Backspace", "begin anew"),
    "next_seed": Key((257,), "Enter", "next random ground"),
    "help": Key((297,), "F8", "hide, show these keys"),
}
"""What the keys do; all others are those of MuJoCo's viewer."""

MOUSE: Mapping[str, str] = {
    "double click": "choose a leg or the hip",
    "Ctrl+right drag": "push what is chosen",
    "drag, wheel": "turn, move, zoom",
    "F, C, F1": "contact forces, points, MuJoCo's keys",
}
"""What the mouse does, and the keys of MuJoCo's viewer that matter here."""


class Player:
    """Moves a walk's time by what the clock and the keys say.

    Attributes:
        source: The walk.
        speed: Walk time by real time, as asked for.
        paused: Whether time stands still.
        helps: Whether the keys are shown.
        reached: Walk time by real time, as measured; NaN until it is.
    """

    def __init__(self, source: Source, *, speed: float = 1.0) -> None:
        """Begin where the walk is."""
        self.source, self.speed, self.paused, self.reached = source, speed, False, math.nan
        self.helps = True
        self._pressed: deque[int] = deque()
        self._due = self._from = source.time
        self._real = 0.0
        self._actions: dict[int, Callable[[], None]] = {
            code: getattr(self, f"_{name}") for name, key in KEYS.items() for code in key.codes
        }

    def press(self, code: int) -> None:
        """Take a key (GLFW's code), in whatever thread; it acts at the next `tick`."""
        self._pressed.append(code)

    def tick(self, elapsed: float) -> None:
        """Do what the keys say, and let the walk go on for so much real time (s).

        Raises:
            WalkStopped: The controller raised an exception.
        """
        while self._pressed:
            action = self._actions.get(self._pressed.popleft())
            if action is not None:
                self.source.news = ""
                action()
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
        """Measure the speed from now on."""
        self._real, self._from, self.reached = 0.0, self.source.time, math.nan

    def _jumped(self) -> None:
        """Take the walk's time as it is now."""
        self._due = self.source.time
        self._measure()

    def _pause(self) -> None:
        self.paused = not self.paused

    def _slower(self) -> None:
        self.speed = max(SLOWEST, 0.5 * self.speed)
        self._measure()

    def _faster(self) -> None:
        self.speed = min(FASTEST, 2.0 * self.speed)
        self._measure()

    def _forward(self) -> None:
        self.paused = True
        self.source.go_to(self.source.time + STRIDE)
        self._jumped()

    def _back(self) -> None:
        if self._can_go_back():
            self.source.go_to(self.source.time - STRIDE)
            self._jumped()

    def _next_touchdown(self) -> None:
        self.paused = True
        self.source.touchdown_beside(1)
        self._jumped()

    def _last_touchdown(self) -> None:
        if self._can_go_back():
            self.source.touchdown_beside(-1)
            self._jumped()

    def _can_go_back(self) -> bool:
        self.paused = True
        if not self.source.goes_back:
            self.source.news = "a walk under way cannot go back: write a record (mjbiped walk --out) and view that"
        return self.source.goes_back

    def _restart(self) -> None:
        self.source.restart()
        self._jumped()

    def _next_seed(self) -> None:
        self.source.next_seed()
        self._jumped()

    def _help(self) -> None:
        self.helps = not self.helps
