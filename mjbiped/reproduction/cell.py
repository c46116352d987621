"""The walks of the reproduction: their inputs, their measures, and the finished ones on disk."""

from __future__ import annotations

import hashlib
import json
import math
from collections.abc import Mapping, Sequence
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np

from mjbiped.engines.plan import DEFAULT_SAMPLE_PERIOD
from mjbiped.records import measures
from mjbiped.records.record import Walk
from mjbiped.reproduction.methods import gains_told
from mjbiped.reproduction.rows import COLUMNS, COSTS, Row, row_of
from mjbiped.reproduction.traces import traced
from mjbiped.rules.termination import Outcome
from mjbiped.sweeps.cell import LIMIT, SPARSE, Cell, attempt
from mjbiped.sweeps.run import machinery, walk_cells
from mjbiped.sweeps.store import opened
from mjbiped.terrain.terrain import Terrain

_KEY_DIGITS = 24  # hexadecimal
_ENDS = {outcome.words for outcome in Outcome}


def cell(
    terrain: Terrain, law: Mapping[str, Any], *, steps: int | None = None, distance: float | None = None, **columns: Any
) -> Cell:
    """Make a cell of the reproduction.

    Args:
        terrain: The ground.
        law: Values of the control law, by the names of a study's cell.
        steps: Touchdowns after which the walk is finished, where it has no other end.
        distance: Position x at which it is finished instead, m.
        **columns: Further values: the engine, the first state unless it is the gait's, `record` where the whole record
            is kept for figures and not the measures alone, and the columns that say what its role in the report is.
    """
    limit: dict[str, Any] = {f"{LIMIT}.distance": distance} if steps is None else {f"{LIMIT}.steps": steps}
    return Cell(0, None, {"initial": "gait", "method": "adaptive", "first": 0.0, **columns, **law, **limit}, terrain)


def key(cell: Cell) -> str:
    """Digest of all that a row depends on: inputs, versions, and the sources of physics and control laws."""
    text = json.dumps([cell.values, cell.terrain().to_dict(), machinery()], sort_keys=True)
    return hashlib.sha256(text.encode()).hexdigest()[:_KEY_DIGITS]


def row(cell: Cell, folder: Path | None = None) -> dict[str, Any]:
    """Walk a cell, and return its key and its row; a record that is kept goes into the folder."""
    law, record = cell.controller().describe(), cell.values.get("record", False)

    def measure(done: Walk) -> dict[str, Any]:
        if record and folder is not None:
            done.save(record_path(folder, cell))
        return {**measures_of(done), **(traced(done) if record else {})}

    measured = attempt(lambda: cell.walk(DEFAULT_SAMPLE_PERIOD if record else SPARSE), measure)
    return {
        **cell.values,
        **measured,
        "key": key(cell),
        "delay": law.get("replanning_delay"),
        "slope_source": law.get("slope_source"),
        "gains": gains_told(law),
        "adaptation_gain": law.get("adaptation_gain"),
        "update": {None: "", True: "yes", False: "no"}[law.get("estimate_update")],
        "start_estimate": math.degrees(law.get("initial_slope_estimate", math.nan)),
        "error": " ".join((measured["error"] or "").split()),
    }


def measures_of(done: Walk) -> dict[str, Any]:
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


def walked(
    cells: Sequence[Cell], folder: Path, *, fresh: bool = False, workers: int | None = None, progress: bool = False
) -> list[Row]:
    """Return the rows of cells; those that are not kept in a folder yet are walked, and kept there as they end.

    The rows do not depend on the number of workers. A cell that fails has a row with the error's text, and is walked
    again the next time.

    Args:
        cells: Any number; equal ones are walked once.
        folder: Folder of a table, and of a file for each record that is kept; it is made if missing.
        fresh: Delete the walks that are kept.
        workers: Number of processes that walk; one for each core unless given.
        progress: Show a progress bar (never where the output is not a terminal).

    Raises:
        InputError: The folder cannot be made, or another process has it.
        RecordError: The table is damaged, or a file cannot be written.
        MjbipedError: A process died, of lack of memory perhaps; what had ended is kept.
        KeyboardInterrupt: Ctrl-C; what had ended is kept.
    """
    keys = [key(cell) for cell in cells]
    wanted = dict(zip(keys, cells, strict=True))
    with opened(folder, "walks", ("key", *COLUMNS), {}, fresh=fresh) as store:
        for file in folder.glob(f"{'[0-9a-f]' * _KEY_DIGITS}.npz") if fresh else ():
            file.unlink()
        kept = {row["key"] for row in store.rows() if row["outcome"] in _ENDS}  # others failed, or are damaged
        todo = [
            cell
            for known, cell in wanted.items()
            if known not in kept or (cell.values.get("record") and not record_path(folder, cell).exists())
        ]
        # MuJoCo's take the longest, and longer the more steps they have
        todo.sort(key=lambda cell: (cell.values["engine"] != "mujoco", -int(cell.values.get(f"{LIMIT}.steps", 0))))
        ended = len(wanted) - len(todo)
        walk_cells(partial(row, folder=folder), todo, store.save, ended=ended, workers=workers, progress=progress)
        found = {row["key"]: row_of(row) for row in store.rows()}
    return [found[each] for each in keys]


def record_path(folder: Path, cell: Cell) -> Path:
    """Path of a cell's record."""
    return folder / f"{key(cell)}.npz"
