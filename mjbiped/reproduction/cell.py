"""The walks of the reproduction: their inputs, their measures, and the finished ones on disk."""

from __future__ import annotations

import hashlib
import json
import math
from collections.abc import Iterable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from functools import cached_property, partial
from pathlib import Path

import numpy as np

from mjbiped.control.controller import Controller
from mjbiped.engines.plan import DEFAULT_SAMPLE_PERIOD, versions
from mjbiped.records import measures
from mjbiped.records.record import Walk
from mjbiped.rollout.walk import walk
from mjbiped.sweeps.cell import FAILED, SPARSE, Row, attempt
from mjbiped.sweeps.run import sources, walk_cells
from mjbiped.sweeps.store import Layout, Store, opened
from mjbiped.terrain.terrain import Terrain

LENGTHS = (20, 45, 60, 100)
"""Numbers of steps after which c_mt is taken, from one walk."""

COSTS = {
    f"{kind}_{'end' if steps is None else steps}": (kind, steps)
    for kind in measures.WORK_KINDS
    for steps in (*LENGTHS, None)
}
"""Columns of c_mt: the kind of work and the number of steps; None: up to the last touchdown."""

_KEY_DIGITS = 24  # hexadecimal
MEASURES = ("steps", "place", "ankle", "hip", "friction", "least_force", "strikes", "begun", "ended", "rms", "jump")
_LAYOUT = Layout("walks", ("key", "outcome", "error", *MEASURES, *COSTS), None, frozenset((*MEASURES, *COSTS)))


@dataclass(frozen=True)
class Cell:
    """A walk to be made.

    Attributes:
        engine: "mujoco" or "hybrid".
        controller: The law with its parameters.
        terrain: The ground.
        initial: First state, "gait" or "rest".
        steps: Touchdowns after which the walk is finished, or None.
        distance: Position x at which it is finished, m, or None.
        record: Whether the whole record is kept, for figures, and not the measures alone.
    """

    engine: str
    controller: Controller
    terrain: Terrain
    initial: str = "gait"
    steps: int | None = 60
    distance: float | None = None
    record: bool = False

    @cached_property
    def key(self) -> str:
        """Digest of all that the walk depends on: inputs, versions, and the sources of physics and control laws."""
        inputs = {**vars(self), "controller": self.controller.describe(), "terrain": self.terrain.to_dict()}
        text = json.dumps([inputs, versions(), sources()], sort_keys=True)
        return hashlib.sha256(text.encode()).hexdigest()[:_KEY_DIGITS]

    def walk(self) -> Walk:
        """Walk the cell."""
        return walk(
            self.controller,
            self.terrain,
            engine=self.engine,
            steps=self.steps,
            distance=self.distance,
            initial=self.initial,
            sample_period=DEFAULT_SAMPLE_PERIOD if self.record else SPARSE,
        )


def measures_of(done: Walk) -> Row:
    """Measure a walk.

    Returns:
        By column: number of steps; place of the hip at the end, m; greatest torques of ankle and hip, N m; risers
        struck; c_mt by kind and number of steps; and where a step was made, greatest friction and least normal force
        (weights) asked of a stance foot, and errors of the slope estimate (greatest at the steps' beginnings, greatest
        and root mean square at their ends, greatest change at a touchdown), degrees.
    """
    rows, (ankle, hip) = done.touchdowns, done.peak_torque.tolist()
    found = {
        "steps": done.steps,
        "place": done.end[1],
        "ankle": ankle,
        "hip": hip,
        "strikes": int(sum(rows["strikes"])),
    }
    found |= {name: cost_after(done, kind, steps) for name, (kind, steps) in COSTS.items()}
    if not done.steps:
        return found
    begun, ended = (np.abs(np.degrees(errors)) for errors in measures.estimate_errors(done))
    return found | {
        "friction": float(rows["friction"].max()),
        "least_force": float(rows["normal_force"].min()) / done.robot.weight,
        "begun": float(begun.max()),
        "ended": float(ended.max()),
        "rms": math.sqrt(float(np.mean(ended**2))),
        "jump": float(np.abs(begun - ended).max()),
    }


def cost_after(done: Walk, kind: str, steps: int | None = None) -> float:
    """Compute c_mt from the start to a touchdown; NaN where the walk did not come so far.

    Args:
        done: The walk.
        kind: "absolute", "net" or "positive", see `mjbiped.records.measures.work`.
        steps: Number of the touchdown, from 1; the last one unless given.
    """
    last = done.steps if steps is None else steps
    if not 0 < last <= done.steps or not done.touchdowns["x"][last - 1] > 0.0:
        return math.nan
    distance = done.robot.weight * float(done.touchdowns["x"][last - 1])
    return float(done.touchdowns[f"work_{kind}"][last - 1]) / distance


@dataclass(frozen=True)
class Walks:
    """Finished cells in a folder: a table, and a file for each record that is kept, named by the cell's key.

    Attributes:
        store: The open table.
        workers: Number of processes that walk; one for each core unless given.
        progress: Show a progress bar (never where the output is not a terminal).
    """

    store: Store
    workers: int | None = None
    progress: bool = False

    def results(self, cells: Iterable[Cell]) -> dict[str, Row]:
        """Return the measures of cells; those that are not kept yet are walked, and kept as they end.

        The results do not depend on the number of workers. A cell that fails is a result with an error's text, and is
        tried again the next time.

        Args:
            cells: Any number; equal ones are walked once.

        Returns:
            Outcome, error and measures of each cell, by its key; None for what does not exist.

        Raises:
            RecordError: The table is damaged, or a file cannot be written.
            MjbipedError: A process died, of lack of memory perhaps; what had ended is kept.
            KeyboardInterrupt: Ctrl-C; what had ended is kept.
        """
        wanted = {cell.key: cell for cell in cells}
        todo = [cell for cell in wanted.values() if not self._is_kept(cell)]
        # MuJoCo's take the longest, and longer the more steps they have
        todo.sort(key=lambda cell: (cell.engine != "mujoco", -(cell.steps or 0)))
        walk_cells(
            partial(walked, self.store.folder),
            todo,
            self.store,
            ended=len(wanted) - len(todo),
            workers=self.workers,
            progress=self.progress,
        )
        return {key: self.store.row(key) or {} for key in wanted}

    def record(self, cell: Cell) -> Walk:
        """Load the record of a finished cell that kept it.

        Raises:
            RecordError: There is none.
        """
        return Walk.load(record_path(self.store.folder, cell))

    def _is_kept(self, cell: Cell) -> bool:
        """Whether a cell has ended without an error, with its record where it keeps one."""
        row = self.store.row(cell.key)
        there = not cell.record or record_path(self.store.folder, cell).exists()
        return row is not None and row["outcome"] != FAILED and there


@contextmanager
def opened_walks(
    folder: Path, *, fresh: bool = False, workers: int | None = None, progress: bool = False
) -> Iterator[Walks]:
    """Open a folder of finished walks, and keep other processes out.

    Args:
        folder: The folder; it is made if missing.
        fresh: Delete the walks that are kept.
        workers: See `Walks`.
        progress: See `Walks`.

    Raises:
        InputError: The folder cannot be made, or another process has it.
        RecordError: The table is damaged, or cannot be written.
    """
    with opened(folder, _LAYOUT, {}, fresh=fresh) as store:
        if fresh:
            for file in folder.glob(f"{'[0-9a-f]' * _KEY_DIGITS}.npz"):
                file.unlink()
        yield Walks(store, workers, progress)


def record_path(folder: Path, cell: Cell) -> Path:
    """Path of a cell's record."""
    return folder / f"{cell.key}.npz"


def walked(folder: Path, cell: Cell) -> Row:
    """Walk a cell, keep its record if the cell says so, and return its row."""

    def measure(done: Walk) -> Row:
        if cell.record:
            done.save(record_path(folder, cell))
        return measures_of(done)

    return {"key": cell.key, **attempt(cell.walk, measure)}
