"""Simulations that go from one decision to the next, some ticks of their controllers later, with numbers from outside.

For whoever decides now and then what the robots do: an environment of a learner. Between two decisions nothing
of it is Python where the callbacks are compiled, and the robots of one `Ticks` are stepped in threads.
"""

from __future__ import annotations

from concurrent.futures import ThreadPoolExecutor
from contextlib import ExitStack
from typing import Any

import numpy as np

from mjbiped.engines.mujoco.compiled import registry
from mjbiped.engines.mujoco.compiled.advance import After, Row, Sizes, advancing, step_address
from mjbiped.engines.mujoco.compiled.callbacks import Functions
from mjbiped.engines.mujoco.compiled.layout import UnknownLayoutError
from mjbiped.engines.mujoco.motors import NOW
from mjbiped.engines.mujoco.simulation import Simulation
from mjbiped.engines.mujoco.state import SIZE, State
from mjbiped.utils.mujoco import mujoco


class Ticks:
    """A row of simulations, all of one kind of controller with a control period.

    Attributes:
        inputs: What the controllers find in their memory at the next tick, shape (robots, floats).
        kept: What `after` keeps of each robot from call to call.
        out: What `after` has filled.
        now: What is remembered of each robot's walk, as the next tick will find it.
    """

    def __init__(self, count: int, sizes: Sizes, after: After, *, threads: int = 1, ticks: int = 1) -> None:
        """Make room; there are no simulations yet.

        Args:
            count: Number of robots.
            sizes: Floats for each.
            after: Called for each robot after its steps, compiled where the callbacks are.
            threads: That step at a time.
            ticks: Ticks of the controllers from one call of `advance` to the next.
        """
        self.inputs, self.kept, self.out = (np.zeros((count, size)) for size in sizes)
        self.now = [State() for _ in range(count)]
        self._lines = [np.zeros(0)] * count  # which these show, with the last touchdown's row
        self._sizes, self._after, self._threads = sizes, after, max(1, min(threads, count))
        self._ticks = ticks
        self._table = np.zeros((count, len(Row._fields)), dtype=np.int64)
        self._address = self._table.ctypes.data
        self._simulations: list[Simulation | None] = [None] * count
        self._attachments = [ExitStack() for _ in range(count)]
        self._places = [0] * count
        self._functions: Functions | None = None
        self._advance: Any = None
        self._warned = registry.warned()
        self._following = np.zeros(1, dtype=np.int64)  # row that is to be stepped next, of whatever thread
        self._next = self._following.ctypes.data
        self._pool: ThreadPoolExecutor | None = None

    def put(self, index: int, simulation: Simulation, place: int) -> None:
        """Let a simulation stand at an index of the row.

        Args:
            index: In the row.
            simulation: Of a controller with a control period, which is stepped by nobody else from now on.
            place: Index in its controller's memory where the inputs belong.
        """
        self._attachments[index].close()
        behind = SIZE + simulation.constants.touched
        self._simulations[index], self._places[index] = simulation, behind + place
        line: Any = np.zeros(behind)
        self._lines[index], self.now[index] = line, State.from_buffer(line)
        native = _usable(simulation)
        if native is None:
            return
        if self._functions is None:
            self._advance = advancing(native, self._after, self._sizes)
            self._mj_step = step_address()
            self._functions = native.functions
        elif native.functions is not self._functions:
            raise ValueError("the simulations of a row need the same compiled callbacks")
        simulation.attach(self._attachments[index])
        self._enter(index)

    def _enter(self, index: int) -> None:
        """Say where a simulation lies."""
        simulation = self._simulations[index]
        assert simulation is not None
        self._table[index] = Row(
            model=simulation.model._address,
            data=simulation.data._address,
            place=self._places[index],
            inputs=self.inputs[index].ctypes.data,
            now=self._lines[index].ctypes.data,
            kept=self.kept[index].ctypes.data,
            out=self.out[index].ctypes.data,
        )

    def move_on(self, index: int) -> bool:
        """`Simulation.move_on` of one of them; whether it has other ground now."""
        simulation = self._simulations[index]
        assert simulation is not None
        moved = simulation.move_on()
        if moved and self._functions is not None:
            self._enter(index)
        return moved

    def look(self, index: int) -> None:
        """Call `after` for one robot as it stands."""
        self._go(index, index + 1, ticks=0)

    def advance(self) -> bool:
        """Step all robots that walk to a later tick, and call `after` for all.

        Returns:
            Whether MuJoCo has warned of anything meanwhile: `Simulation.outcome` then says of whom.
        """
        if self._functions is None or self._threads == 1:
            self._go(0, len(self._simulations), ticks=self._ticks)
        else:
            self._in_threads()
        before, self._warned = self._warned, registry.warned()
        return self._functions is None or self._warned != before

    def _in_threads(self) -> None:
        """Step all, each thread the row that is next."""
        if self._pool is None:
            self._pool = ThreadPoolExecutor(self._threads - 1, thread_name_prefix="robots")
        arguments = (self._address, self._next, len(self._simulations), self._mj_step, self._ticks)
        with registry.compiled():
            self._following[0] = 0
            others = [self._pool.submit(self._advance, *arguments) for _ in range(self._threads - 1)]
            self._advance(*arguments)
            for other in others:
                other.result()

    def _go(self, first: int, last: int, *, ticks: int) -> None:
        """Step some, or only look, in this thread."""
        if self._functions is None:
            for index in range(first, last):
                self._go_in_python(index, ticks)
            return
        self._following[0] = first
        registry.enter()
        try:
            self._advance(self._address, self._next, last, self._mj_step, ticks)
        finally:
            registry.leave()

    def _go_in_python(self, index: int, ticks: int) -> None:
        """What `advance` does, where the callbacks are Python's."""
        simulation = self._simulations[index]
        assert simulation is not None
        with simulation.callbacks():
            model, data, u = simulation.model, simulation.data, simulation.state
            if ticks and not simulation.over:
                place = self._places[index]
                data.userdata[place : place + self._sizes.inputs] = self.inputs[index]
            for _ in range(ticks):
                while not simulation.over:
                    mujoco.mj_step(model, data)
                    if not data.time <= u.next_control - NOW:
                        break
            line = self._lines[index]
            line[:] = data.userdata[: len(line)]
            if not simulation.over and simulation.look_ahead(self.now[index], line) and ticks:
                mujoco.mj_step(model, data)
        self._after(self.now[index], self.kept[index], self.out[index])

    def close(self) -> None:
        """End the threads, and let the simulations go."""
        if self._pool is not None:
            self._pool.shutdown()
            self._pool = None
        for attachment in self._attachments:
            attachment.close()
        self._simulations = [None] * len(self._simulations)


def _usable(simulation: Simulation) -> Any:
    """The compiled callbacks of a simulation, None where Python's must do."""
    try:
        step_address()
    except UnknownLayoutError:
        return None
    return simulation.native if simulation.compiled else None
