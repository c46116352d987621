"""Robots that go from one decision to the next, some ticks of their controllers later, with numbers from outside.

Between two decisions nothing of them is Python where they are machine code, and they are stepped in threads.
"""

from __future__ import annotations

from concurrent.futures import ThreadPoolExecutor
from contextlib import ExitStack
from functools import cache
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from mjbiped.engines.mujoco import callback
from mjbiped.engines.mujoco.constants import constants_at
from mjbiped.engines.mujoco.simulation import Simulation
from mjbiped.engines.mujoco.state import MARK, State, state_at
from mjbiped.engines.mujoco.step import advance_ticks, look_ahead, warned
from mjbiped.envs.feeling import OUTCOME, feel
from mjbiped.numerics.blocks import Floats, numbers, packed, reader
from mjbiped.rules.termination import Outcome

_DIVERGED = float(Outcome.DIVERGED)


class Row(NamedTuple):
    """A robot of many.

    Attributes:
        constants: Its walk's, alone in a list; see `mjbiped.engines.mujoco.constants.Constants`.
        ahead: The same for a look ahead; see `mjbiped.engines.mujoco.step.look_ahead`.
        model: Its mjModel.
        data: Its mjData.
        inputs: What its controller is to find in its memory at the next tick.
        given: Number of these.
        place: Index in the memory where they belong.
        kept: Numbers that `feeling.feel` keeps.
        kept_count: Number of these.
        out: Numbers that it fills.
        out_count: Number of these.
    """

    constants: Any
    ahead: Any
    model: Any
    data: Any
    inputs: Floats
    given: int
    place: int
    kept: Floats
    kept_count: int
    out: Floats
    out_count: int


row_at = reader(Row)


def advance_rows(rows: Any, first: int, last: int, ticks: int) -> None:
    """Step robots to a later tick of their controllers, and fill in what they feel then.

    Args:
        rows: All robots.
        first: Number of the first one that is stepped.
        last: Number behind the last one.
        ticks: Number of ticks; 0: only look.
    """
    for index in range(first, last):
        row = row_at(rows, index)
        c, ahead = constants_at(row.constants, 0), constants_at(row.ahead, 0)
        u = state_at(c.state, 0)
        if ticks and u.mark == MARK and not u.outcome:
            memory, inputs = numbers(c.memory, c.memory_size), numbers(row.inputs, row.given)
            for number in range(row.given):
                memory[row.place + number] = inputs[number]
        advance_ticks(c, row.model, row.data, ticks)
        look_ahead(c, ahead)
        seen = state_at(ahead.state, 0)
        if ticks and seen.outcome and not u.outcome:
            advance_ticks(c, row.model, row.data, 1)  # so that its own state knows of it
        kept, out = numbers(row.kept, row.kept_count), numbers(row.out, row.out_count)
        feel(seen, kept, out, c.angles)
        if warned(c):
            for number in range(row.out_count):
                out[number] = 0.0
            out[OUTCOME] = _DIVERGED


def _by_addresses(rows: int, first: int, last: int, ticks: int) -> None:
    """`advance_rows` of packed rows."""
    advance_rows(rows, first, last, ticks)


@cache
def _machine_code() -> Any:
    from mjbiped.engines.mujoco import native
    from mjbiped.numerics import machine

    native.define_stages()
    return machine.compiled(_by_addresses, "void(int64, int64, int64, int64)")


class Ticks:
    """A row of simulations.

    Attributes:
        inputs: What the controllers find in their memory at the next tick, shape (robots, floats).
        kept: What `feeling.feel` keeps of each robot from call to call.
        out: What that has filled.
    """

    def __init__(self, count: int, sizes: tuple[int, int, int], *, threads: int = 1, ticks: int = 1) -> None:
        """Make room; there are no simulations yet.

        Args:
            count: Number of robots.
            sizes: Floats of inputs, kept and out for each.
            threads: That step at a time.
            ticks: Ticks of the controllers from one call of `advance` to the next.
        """
        self.inputs, self.kept, self.out = (np.zeros((count, size)) for size in sizes)
        self._threads, self._ticks = max(1, min(threads, count)), ticks
        self._simulations: list[Simulation | None] = [None] * count
        self._rows: list[Row | None] = [None] * count
        self._table: NDArray[Any] | None = None
        self._places = [0] * count
        self._living: list[Any] = [None] * count  # what the rows of the table point to
        self._pool: ThreadPoolExecutor | None = None
        self._called = False  # methods in Python are called by machine code

    def put(self, index: int, simulation: Simulation, place: int) -> None:
        """Let a simulation stand at an index of the row.

        Args:
            index: In the row.
            simulation: Of a controller with a control period, which is stepped by nobody else from now on.
            place: Index in its controller's memory where the inputs belong.
        """
        self._simulations[index], self._places[index] = simulation, place
        ahead = simulation.ahead()
        inputs, kept, out = self.inputs[index], self.kept[index], self.out[index]
        row = Row(
            constants=[simulation.constants],
            ahead=[ahead],
            model=simulation.model,
            data=simulation.data,
            inputs=inputs,
            given=len(inputs),
            place=place,
            kept=kept,
            kept_count=len(kept),
            out=out,
            out_count=len(out),
        )
        self._rows[index] = row
        if simulation.block is None:
            self._table = None
            return
        block, living = simulation.packed(ahead)
        made, more = packed(
            row._replace(
                constants=simulation.block, ahead=block, model=simulation.model._address, data=simulation.data._address
            )
        )
        if self._table is None:
            self._table = np.zeros(len(self._rows), made.dtype)
            self._native, self._machine_code = simulation.native, _machine_code()
        self._called = self._called or not simulation.compiled
        self._table[index], self._living[index] = made[0], (block, living, more)

    def now(self, index: int) -> State:
        """What is remembered of a robot's walk, as the next tick will find it."""
        row = self._rows[index]
        assert row is not None
        state: State = row.ahead[0].state[0]
        return state

    def move_on(self, index: int) -> bool:
        """`Simulation.move_on` of one of them; whether it has other ground now."""
        simulation = self._simulations[index]
        assert simulation is not None
        moved = simulation.move_on()
        if moved:
            self.put(index, simulation, self._places[index])
        return moved

    def look(self, index: int) -> None:
        """Fill in what one robot feels as it stands, perhaps in a state that was set."""
        simulation = self._simulations[index]
        assert simulation is not None
        self._go(index, index + 1, 0)

    def advance(self) -> None:
        """Step all robots that walk to a later tick, and fill in what all feel."""
        count = len(self._rows)
        if self._table is None or self._threads == 1:
            self._go(0, count, self._ticks)
            return
        if self._pool is None:
            self._pool = ThreadPoolExecutor(self._threads - 1, thread_name_prefix="robots")
        ends = [count * part // self._threads for part in range(self._threads + 1)]
        others = [
            self._pool.submit(self._go, ends[part], ends[part + 1], self._ticks) for part in range(1, self._threads)
        ]
        self._go(ends[0], ends[1], self._ticks)
        for other in others:
            other.result()

    def _go(self, first: int, last: int, ticks: int) -> None:
        """Step some, or only look, in this thread."""
        if self._table is not None:
            callback.enter(self._native)
            try:
                self._machine_code(self._table.ctypes.data, first, last, ticks)
            finally:
                callback.leave(self._native)
            if not self._called:
                return
        simulations = [each for each in self._simulations[first:last] if each is not None]
        if self._table is None:
            with ExitStack() as stack:
                for simulation in simulations:
                    stack.enter_context(simulation.acting())
                advance_rows(self._rows, first, last, ticks)
        for simulation in simulations:
            simulation.check()

    def close(self) -> None:
        """End the threads, and let the simulations go."""
        if self._pool is not None:
            self._pool.shutdown()
            self._pool = None
        self._table = None
        self._simulations, self._rows = [None] * len(self._rows), [None] * len(self._rows)
