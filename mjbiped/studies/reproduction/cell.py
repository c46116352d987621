"""One walk of the reproduction: its inputs, and what is measured of it."""

from __future__ import annotations

import hashlib
import json
import math
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from mjbiped.analysis.replay import recorded_controller, replayed
from mjbiped.control.registry import settings_of
from mjbiped.records import measures
from mjbiped.records.record import Walk
from mjbiped.studies.cell import LIMIT, LIMITS, SPARSE, Cell, Row, attempt
from mjbiped.studies.reproduction.section_5 import gains_told
from mjbiped.studies.run import machinery
from mjbiped.terrain.terrain import Terrain

KEY_DIGITS = 24  # hexadecimal
SAMPLED = 0.005
"""Sample period of the records that are kept, s."""

LENGTHS = (20, 45, 60, 100)
"""Numbers of steps after which c_mt is taken, from one walk."""

COSTS = {
    f"{kind}_{'end' if steps is None else steps}": (kind, steps)
    for kind in measures.WORK_KINDS
    for steps in (*LENGTHS, None)
}
"""Columns of c_mt: the kind of work and the number of steps; None: up to the last touchdown."""

RESOLVED_SLOPE = float(settings_of("adaptive")["update_threshold"])
"""Epsilon of (27), rad: the controller treats slopes that differ by less as one."""

TRACES = tuple(
    f"trace_{name}" for name in ("settled", "later", "off_time", "error", "travel", "z1", "z2", "straight", "bent")
)
"""Measures of what Figs. 4 to 6 show, of a walk of the adaptive controller:

settled: Error of the slope estimate at the end of the last step that began before the ground first changes, degrees.
later: Greatest error from then on, degrees.
off_time: Time for which the error was greater than `RESOLVED_SLOPE`, s.
error: Root mean square of the error over time, degrees.
travel: Total variation of the error, degrees.
z1: Greatest tracking error of a leg's angle (5), degrees.
z2: Greatest error of the second stage (9), rad/s.
straight: Greatest distance of a torque from a straight line over its step, N m, of all steps that began on the
    imitated gait.
bent: Least distance of a torque from a straight line over its step, N m, of all re-planned steps.
"""

_SAME_TIME = 1e-9  # s; a sample nearer to a touchdown has the state of one step and the roles of another
_FEWEST = 3  # samples of a step that is measured


def cell(terrain: Terrain, law: Mapping[str, Any], **columns: Any) -> Cell:
    """Make a cell of the reproduction.

    Args:
        terrain: The ground.
        law: Values of the control law, by the names of a study's cell.
        **columns: Further values: the engine; `steps` or `distance`, the number of touchdowns or the position x (m) at
            which the walk is finished; the first state unless it is the gait's; `record` where the whole record is kept
            for figures and not the measures alone; and the columns that say what its role in the report is.
    """
    limits = {f"{LIMIT}.{name}": columns.pop(name) for name in LIMITS if name in columns}
    return Cell(0, None, {"initial": "gait", "method": "adaptive", "first": 0.0, **columns, **law, **limits}, terrain)


def key(cell: Cell) -> str:
    """Digest of all that a row depends on: inputs, versions, and the sources of physics and control laws."""
    text = json.dumps([cell.values, cell.terrain().to_dict(), machinery()], sort_keys=True)
    return hashlib.sha256(text.encode()).hexdigest()[:KEY_DIGITS]


def record_path(folder: Path, cell: Cell) -> Path:
    """Path of a cell's record."""
    return folder / f"{key(cell)}.npz"


def row(cell: Cell, folder: Path | None = None) -> Row:
    """Walk a cell, and return its key and its row; a record that is kept goes into the folder."""
    law, record = cell.controller().describe(), cell.values.get("record", False)

    def measure(done: Walk) -> Row:
        if record and folder is not None:
            done.save(record_path(folder, cell))
        return {**measures_of(done), **(traced(done) if record else {})}

    measured = attempt(lambda: cell.walk(SAMPLED if record else SPARSE), measure)
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
        **{name: cost_after(done, kind, steps) for name, (kind, steps) in COSTS.items()},
    }
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


def traced(walk: Walk) -> dict[str, float]:
    """Measure a record.

    Args:
        walk: A walk of the adaptive controller, with samples.

    Returns:
        The `TRACES` that exist.

    Raises:
        InputError: Another controller walked.
    """
    controller = recorded_controller(walk)
    samples, time = walk.samples, walk.samples["time"]
    error = np.degrees(samples["slope_estimate"] - samples["slope"])
    first_change = walk.terrain.x[1] if len(walk.terrain.x) > 1 else math.inf
    places, ends = [0.0, *walk.touchdowns["x"].tolist()], walk.touchdowns["time"].tolist()
    tracking: list[NDArray[np.float64]] = []  # greatest z1 and z2 by step
    known: dict[str, list[float]] = {name: [] for name in ("settled", "later", "straight", "bent")}
    for (start, memory), place, end in zip(replayed(walk, controller), places, ends, strict=False):
        inside = (time > start.time + _SAME_TIME) & (time < end - _SAME_TIME)
        if inside.sum() < _FEWEST:
            continue
        if place < first_change:
            known["settled"] = [abs(float(error[inside][-1]))]
        else:
            known["later"].append(float(np.abs(error[inside]).max()))
        now, torque = time[inside] - start.time, samples["torque"][inside]
        motion = zip(now.tolist(), samples["q"][inside].tolist(), samples["dq"][inside].tolist(), strict=True)
        z = np.abs([controller.tracking_errors(memory, t, q, dq) for t, q, dq in motion])
        tracking.append(np.array([z[:, :2].max(), z[:, 4:].max()]))
        lines = (np.polynomial.Polynomial.fit(now, joint, 1)(now) for joint in torque.T)
        bend = max(float(np.abs(joint - line).max()) for joint, line in zip(torque.T, lines, strict=True))
        known["bent" if controller.transition_end(memory) > 0.0 else "straight"].append(bend)
    if not tracking:
        return {}
    if controller.replanning_delay is None:
        known["straight"] = []  # no plan says which steps follow the gait
    lasted, (z1, z2) = np.diff(time), np.max(tracking, axis=0).tolist()
    found = {
        **{name: min(values) if name == "bent" else max(values) for name, values in known.items() if values},
        "off_time": float(lasted[np.abs(error[:-1]) > math.degrees(RESOLVED_SLOPE)].sum()),
        "error": math.sqrt(float((lasted * error[:-1] ** 2).sum() / lasted.sum())),
        "travel": float(np.abs(np.diff(error)).sum()),
        "z1": math.degrees(z1),
        "z2": z2,
    }
    return {f"trace_{name}": value for name, value in found.items()}
