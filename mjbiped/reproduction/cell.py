"""One walk of the reproduction: everything that it depends on, and what is kept of it."""

from __future__ import annotations

import dataclasses
import hashlib
import json
import math
from dataclasses import dataclass
from functools import cached_property
from typing import Any

from mjbiped.control.controller import Controller
from mjbiped.engines.mujoco.engine import Mujoco
from mjbiped.engines.mujoco.options import DEFAULT_TIMESTEP
from mjbiped.engines.plan import DEFAULT_SAMPLE_PERIOD, versions
from mjbiped.errors import MjbipedError, RecordError, explained, shown
from mjbiped.records import measures
from mjbiped.records.record import Walk
from mjbiped.records.schema import OUTCOMES
from mjbiped.rollout.walk import WalkStopped, walk
from mjbiped.sweeps.cell import FAILED
from mjbiped.sweeps.provenance import sources
from mjbiped.terrain.terrain import Terrain

KEY_DIGITS = 24
"""Hexadecimal digits of a cell's key."""

_SPARSE = 1.0  # sample period where no record is kept, s


@dataclass(frozen=True)
class Cell:
    """A walk to be made.

    Attributes:
        engine: "mujoco" or "hybrid".
        controller: The law with its parameters.
        terrain: The ground.
        initial: First state, "gait" or "rest".
        steps: Touchdowns after which the walk is finished, or None.
        distance: Place x at which it is finished, m, or None.
        timestep: Of MuJoCo, s; the hybrid engine has none.
        record: Whether the whole record is kept, for figures, and not the touchdowns alone.
    """

    engine: str
    controller: Controller
    terrain: Terrain
    initial: str = "gait"
    steps: int | None = 60
    distance: float | None = None
    timestep: float = DEFAULT_TIMESTEP
    record: bool = False

    @property
    def inputs(self) -> dict[str, Any]:
        """All that the walk depends on, in plain JSON types."""
        return {
            "engine": self.engine,
            "controller": self.controller.describe(),
            "terrain": self.terrain.to_dict(),
            "initial": self.initial,
            "steps": self.steps,
            "distance": self.distance,
            "timestep": self.timestep if self.engine == "mujoco" else None,
            "record": self.record,
        }

    @cached_property
    def key(self) -> str:
        """Digest of the inputs, of all versions, and of the sources of physics and control laws."""
        text = json.dumps([self.inputs, versions(), sources()], sort_keys=True)
        return hashlib.sha256(text.encode()).hexdigest()[:KEY_DIGITS]


@dataclass(frozen=True)
class Result:
    """What came of a cell.

    Attributes:
        outcome: As of a walk; "failed" where an error kept it from ending.
        error: The error's text, empty without one.
        time: When it ended, s.
        place: Hip's x when it ended, m.
        peak_torque: Greatest |ankle| and |hip| torque, N m.
        weight: Of the robot, N.
        friction: Greatest |F_t|/F_n asked of a stance foot.
        least_force: Least normal force of the ground on a stance foot, weights; below zero it would have to pull.
        strikes: Swing feet that struck a riser.
        x: Places of the touchdowns, m.
        work: Work since the start at each touchdown by kind, J.
        begun: Errors of the slope estimate at the beginning of the steps, after the update, rad.
        ended: The same at the ends of the steps.
    """

    outcome: str
    error: str = ""
    time: float = 0.0
    place: float = 0.0
    peak_torque: tuple[float, float] = (math.nan, math.nan)
    weight: float = math.nan
    friction: float = math.nan
    least_force: float = math.nan
    strikes: int = 0
    x: tuple[float, ...] = ()
    work: dict[str, tuple[float, ...]] = dataclasses.field(default_factory=dict)
    begun: tuple[float, ...] = ()
    ended: tuple[float, ...] = ()

    @property
    def steps(self) -> int:
        """Number of touchdowns."""
        return len(self.x)

    def cost_of_transport(self, kind: str, steps: int | None = None) -> float:
        """c_mt from the start to a touchdown, by default the last; NaN where the walk did not come so far.

        Args:
            kind: "absolute", "net" or "positive", see `mjbiped.records.measures.work`.
            steps: Number of the touchdown, from 1.
        """
        last = self.steps if steps is None else steps
        if not 0 < last <= self.steps or not self.x[last - 1] > 0.0:
            return math.nan
        return self.work[kind][last - 1] / (self.weight * self.x[last - 1])

    def to_dict(self) -> dict[str, Any]:
        """In plain JSON types; `from_dict` undoes it."""
        return dataclasses.asdict(self)

    @classmethod
    def from_dict(cls, fields: Any) -> Result:
        """The result that `to_dict` wrote.

        Raises:
            RecordError: A field is unknown, missing, or not what it must be.
        """
        try:
            work = {kind: tuple(values) for kind, values in fields["work"].items()}
            lists = {name: tuple(fields[name]) for name in ("peak_torque", "x", "begun", "ended")}
            result = cls(**{**fields, **lists, "work": work})
        except (AttributeError, KeyError, TypeError) as error:
            raise RecordError(f"no result of a walk: {shown(error)}") from error
        if not result._sound():
            raise RecordError("no result of a walk: its values are of other kinds or numbers than a walk's")
        return result

    def _sound(self) -> bool:
        """Whether every field is of its kind, and there is a number for each step."""
        by_step = (self.begun, self.ended, *self.work.values())
        numbers = (self.time, self.place, self.weight, self.friction, *self.peak_torque, *self.x)
        return (
            self.outcome in (*OUTCOMES, FAILED)
            and isinstance(self.error, str)
            and type(self.strikes) is int
            and len(self.peak_torque) == 2
            and all(type(number) in (int, float) for numbers in (numbers, *by_step) for number in numbers)
            and all(len(values) == self.steps for values in by_step)
            and ({*self.work} == {*measures.WORK_KINDS} or not self.work)
        )


def measured(cell: Cell) -> tuple[Result, Walk | None]:
    """Let a cell walk.

    An error is a result: its text is kept, and the steps before it where there were any.

    Returns:
        The result, and the record where the cell asks for it.
    """
    try:
        done = walk(
            cell.controller,
            cell.terrain,
            engine=Mujoco(timestep=cell.timestep) if cell.engine == "mujoco" else cell.engine,
            steps=cell.steps,
            distance=cell.distance,
            initial=cell.initial,
            sample_period=DEFAULT_SAMPLE_PERIOD if cell.record else _SPARSE,
        )
    except WalkStopped as stop:
        return dataclasses.replace(_kept(stop.walk), outcome=FAILED, error=str(stop)), None
    except (MjbipedError, ArithmeticError, ValueError) as error:
        return Result(FAILED, explained(error)), None
    return _kept(done), done if cell.record else None


def _kept(done: Walk) -> Result:
    """What is kept of a walk."""
    rows = done.touchdowns
    begun, ended = measures.estimate_errors(done)
    return Result(
        outcome=done.outcome,
        time=done.end[0],
        place=done.end[1],
        peak_torque=(float(done.peak_torque[0]), float(done.peak_torque[1])),
        weight=done.robot.weight,
        friction=float(rows["friction"].max()) if done.steps else math.nan,
        least_force=float(rows["normal_force"].min()) / done.robot.weight if done.steps else math.nan,
        strikes=int(rows["strikes"].sum()),
        x=tuple(rows["x"].tolist()),
        work={kind: tuple(rows[f"work_{kind}"].tolist()) for kind in measures.WORK_KINDS},
        begun=tuple(begun.tolist()),
        ended=tuple(ended.tolist()),
    )
