"""The same walk in both engines: how far they agree, where they part, and why.

The engines share controller, terrain and rules, but neither equations of motion nor impact: MuJoCo resolves contacts in
time, the hybrid engine has the paper's impact map. (docs/physics.md says what is independent, and what is not.)
Touchdown by touchdown the differences stay small; where one exceeds what the contact's resolution explains, the walks
have parted, and `compare` looks for the cause in the two records.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import asdict, dataclass
from functools import partial
from typing import Any

import numpy as np
from scipy.interpolate import interp1d

from mjbiped.analysis import divergence
from mjbiped.analysis.divergence import Divergence
from mjbiped.control.controller import Controller
from mjbiped.disturbances.disturbances import Disturbances
from mjbiped.engines.hybrid.engine import Hybrid
from mjbiped.engines.mujoco.engine import Mujoco
from mjbiped.engines.plan import DEFAULT_SAMPLE_PERIOD, Initial
from mjbiped.errors import InputError
from mjbiped.records import measures
from mjbiped.records.record import Walk
from mjbiped.robots.robot import Array, Robot
from mjbiped.rollout.walk import WalkInterrupted, WalkStopped, walk
from mjbiped.rules.scuffing import ScuffingRule
from mjbiped.terrain.terrain import Terrain
from mjbiped.utils.domains import check_kind


@dataclass(frozen=True, eq=False)
class Comparison:
    """The records of one walk in both engines.

    Attributes:
        mujoco: The walk in MuJoCo.
        hybrid: The walk in the hybrid engine.
        touchdowns: Differences MuJoCo - hybrid at each touchdown that both walks have, in the columns of
            `mjbiped.analysis.divergence.COLUMNS`; beside each a column `limit_...`, the greatest difference that the
            contact's resolution explains.
        divergence: The first touchdown at which a difference exceeds its limit, and the causes; None without one.
    """

    mujoco: Walk
    hybrid: Walk
    touchdowns: Mapping[str, Array]
    divergence: Divergence | None

    def __repr__(self) -> str:
        """Return a summary in one line; the tables are long."""
        found = "they agree" if self.divergence is None else f"they part at touchdown {self.divergence.touchdown}"
        one, other = (f"{w.outcome} after {w.steps} steps, {w.distance:.3f} m" for w in (self.mujoco, self.hybrid))
        return f"<Comparison on {self.mujoco.settings['terrain']['name']}: MuJoCo {one}; hybrid {other}; {found}>"

    @property
    def verdict(self) -> str:
        """Whether the engines agree, or where and why they part, in one or more sentences."""
        if self.divergence is not None:
            return str(self.divergence)
        steps, both = len(self.touchdowns["x"]), f"{self.mujoco.outcome} in both"
        if not steps:
            return f"The engines agree: {both}, without a touchdown."
        resolved = self.mujoco.settings["timestep"]
        where = f"all {steps} touchdowns" if steps > 1 else "the only touchdown"
        return f"The engines agree at {where}, within the limits of contacts resolved at {resolved:g} s: {both}."

    def measures(self) -> dict[str, dict[str, Any]]:
        """Every measure of `mjbiped.records.measures.summary` in both engines, with the difference MuJoCo - hybrid.

        Returns:
            By name of the measure: "mujoco", "hybrid", "difference", and "difference_percent" of the hybrid engine's
            value; the last two are None if a value is missing, the percentage also if it would be beyond 1000 %.
        """
        there, here = measures.summary(self.mujoco), measures.summary(self.hybrid)
        table: dict[str, dict[str, Any]] = {}
        for name, value in there.items():
            other, difference, percent = here[name], None, None
            if all(isinstance(number, int | float) and math.isfinite(number) for number in (value, other)):
                difference = value - other
                percent = 100.0 * difference / abs(other) if abs(difference) < 10.0 * abs(other) else None
            table[name] = {"mujoco": value, "hybrid": other, "difference": difference, "difference_percent": percent}
        return table

    def to_dict(self) -> dict[str, Any]:
        """Return the comparison without its samples, in plain JSON types."""
        return {
            "verdict": self.verdict,
            "parting": None if self.divergence is None else asdict(self.divergence),
            "measures": self.measures(),
            "touchdowns": {name: column.tolist() for name, column in self.touchdowns.items()},
            "settings": {"mujoco": dict(self.mujoco.settings), "hybrid": dict(self.hybrid.settings)},
        }


def compare(
    controller: Controller,
    terrain: Terrain,
    *,
    steps: int | None = None,
    distance: float | None = None,
    initial: Initial = "gait",
    robot: Robot | None = None,
    mujoco: Mujoco | None = None,
    hybrid: Hybrid | None = None,
    sample_period: float = DEFAULT_SAMPLE_PERIOD,
    scuffing: ScuffingRule | None = None,
    disturbances: Disturbances | None = None,
    progress: bool = False,
) -> Comparison:
    """Compare the walk of one robot on one ground in both engines.

    A fall, in one engine or in both, is a result.

    Args:
        controller: The controller; the arguments are those of `mjbiped.walk`.
        terrain: The ground.
        steps: Touchdowns after which the walk is finished; 60 unless a distance is given.
        distance: Position x of the stance foot at which it is finished, m.
        initial: "gait", "rest", or (q1, q2, dq1, dq2).
        robot: The robot that walks.
        mujoco: Settings of the MuJoCo engine.
        hybrid: Settings of the hybrid engine.
        sample_period: Time between two samples of the records, s.
        scuffing: When the swing foot may touch the ground.
        disturbances: Noise and pushes, the same in both walks.
        progress: Show progress bars.

    Returns:
        Both records, their differences, and the causes.

    Raises:
        InputError: An argument is outside its domain; nothing has been computed then.
        GaitError: `initial="gait"` with a controller that imitates none, on a slope that has no passive gait.
        WalkStopped: The controller raised an exception; if MuJoCo's walk was complete, the error carries its record.
        WalkInterrupted: Ctrl-C was pressed; if MuJoCo's walk was complete, the error carries its record.
    """
    terms = {name: value for name, value in locals().items() if name not in ("mujoco", "hybrid")}
    if sample_period is None:
        raise InputError("sample_period = None: must be a number, for the records' samples are compared")
    contacts = Mujoco() if mujoco is None else check_kind("mujoco", mujoco, Mujoco)
    impacts = Hybrid() if hybrid is None else check_kind("hybrid", hybrid, Hybrid)
    walked = partial(walk, **terms)
    there = walked(engine=contacts)  # first: MuJoCo refuses all arguments that the hybrid engine refuses, and more
    try:
        here = walked(engine=impacts)
    except (WalkStopped, WalkInterrupted) as stop:
        stop.before = (there,)
        raise
    table = divergence.differences(there, here)
    return Comparison(there, here, table, divergence.find(there, here, table, controller))


def torque_differences(comparison: Comparison) -> tuple[Array, Array]:
    """Differences of torques MuJoCo - hybrid at equal times since the same touchdown.

    Differences at equal times since the start would have a spike where one step begins 0.1 ms later than the other.

    Returns:
        Times of MuJoCo's samples (s) and differences of all joints (N m), shapes (n,) and (n, joints); NaN beyond the
        end of the shorter of two steps.
    """
    there, here = comparison.mujoco, comparison.hybrid
    time, torque = there.samples["time"], there.samples["torque"]
    others, other_torque = here.samples["time"], here.samples["torque"]
    difference = np.full(torque.shape, math.nan)
    bounds = [np.concatenate([[0.0], walk.touchdowns["time"], walk.end[:1]]) for walk in (there, here)]
    for k in range(min(map(len, bounds)) - 1):
        (start, end), (other_start, other_end) = (each[k : k + 2] for each in bounds)
        inside = (time >= start) & (time < end) & (time - start <= other_end - other_start)
        own = (others > other_start) & (others < other_end)
        if own.sum() < 2:
            continue
        known = interp1d(others[own], other_torque[own], axis=0, bounds_error=False)
        difference[inside] = torque[inside] - known(time[inside] - start + other_start)
    return time, difference
