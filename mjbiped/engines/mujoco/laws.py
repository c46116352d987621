"""A controller's functions, as the engine calls them."""

from __future__ import annotations

import ctypes
from collections.abc import Callable
from typing import Any, NamedTuple

import numpy as np

from mjbiped.control import adapters
from mjbiped.control.controller import Controller

NAMES = ("torque", "touchdown", "slope_estimate", "tick", "knee_strike")


class Functions(NamedTuple):
    parameters: Any
    torque: Any
    touchdown: Any
    slope_estimate: Any
    tick: Any
    knee_strike: Any
    failed: Any


def _torque(controller: Controller, memory: Any, t: float, q: Any, dq: Any, out: Any) -> None:
    values = adapters.torque(controller, memory, t, tuple(q), tuple(dq))
    for index in range(len(values)):
        out[index] = values[index]


def _touchdown(controller: Controller, memory: Any, before: Any, q: Any, dq: Any) -> None:
    controller.on_touchdown(memory, tuple(before), tuple(q), tuple(dq))


def _slope(controller: Controller, memory: Any) -> float:
    return controller.slope_estimate(memory)


def _tick(controller: Any, memory: Any, t: float, q: Any, dq: Any) -> None:
    controller.tick(memory, t, tuple(q), tuple(dq))


def _strike(controller: Controller, memory: Any, t: float, q: Any, dq: Any) -> None:
    controller.on_knee_strike(memory, t, tuple(q), tuple(dq))


def methods(controller: Controller) -> Functions:
    return Functions(controller, _torque, _touchdown, _slope, _tick, _strike, [0.0])


class Called:
    """C functions that call a controller's methods in plain Python, to be kept while the engine calls them."""

    def __init__(self, controller: Controller) -> None:
        self.error: BaseException | None = None
        self.failed: Any = np.zeros(1)
        n, states = len(controller.joints), len(controller.states)
        number, word = ctypes.c_double, ctypes.c_int64
        self._memory = number * controller.memory_size
        self._angles = number * n
        self._out = number * (n + states)
        plain = methods(controller)
        kinds: dict[str, tuple[Any, ...]] = {
            "torque": (word, word, number, word, word, word),
            "touchdown": (word, word, word, word, word),
            "slope_estimate": (word, word),
            "tick": (word, word, number, word, word),
            "knee_strike": (word, word, number, word, word),
        }
        made = {}
        for name, kind in kinds.items():
            returned = number if name == "slope_estimate" else None
            made[name] = ctypes.CFUNCTYPE(returned, *kind)(self._behind(name, getattr(plain, name), controller))
        self._made = made
        self.functions = Functions(
            0, **{name: ctypes.cast(each, ctypes.c_void_p).value for name, each in made.items()}, failed=self.failed
        )

    def _behind(self, name: str, function: Callable[..., Any], controller: Controller) -> Any:
        def call(_parameters: int, memory: int, *given: Any) -> float:
            held = self._memory.from_address(memory)
            own = held[:]
            arguments = [self._angles.from_address(each)[:] if isinstance(each, int) else each for each in given]
            if self.error is None:
                try:
                    if name == "torque":
                        out = self._out.from_address(given[-1])
                        function(controller, own, *arguments[:-1], out)
                        return 0.0
                    found = function(controller, own, *arguments)
                    held[:] = own
                    return 0.0 if found is None else float(found)
                except BaseException as error:
                    self.error, self.failed[0] = error, 1.0
            if name == "torque":
                self._out.from_address(given[-1])[:] = [float("nan")] * len(self._out.from_address(given[-1]))
            return float("nan")

        return call
