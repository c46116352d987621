"""One walk of a study: everything that it depends on, and the row that it becomes."""

from __future__ import annotations

import math
import threading
from collections.abc import Callable, Mapping
from contextlib import nullcontext
from dataclasses import dataclass
from typing import Any

from mjbiped.control.controller import Controller
from mjbiped.control.registry import make_controller
from mjbiped.control.settings import checked
from mjbiped.disturbances.disturbances import Disturbances
from mjbiped.engines.base import Engine
from mjbiped.engines.mujoco.engine import Mujoco
from mjbiped.engines.names import engine_of
from mjbiped.engines.plan import DEFAULT_SAMPLE_PERIOD
from mjbiped.errors import InputError, explained
from mjbiped.gaits.described import passive_gait_of
from mjbiped.gaits.gait import Periodic
from mjbiped.records import measures
from mjbiped.records.frames import flat_samples
from mjbiped.records.record import Walk
from mjbiped.robots.compass import Compass
from mjbiped.robots.kinds import named, robot_named
from mjbiped.robots.kneed import KneedBiped
from mjbiped.robots.robot import Robot
from mjbiped.rollout.walk import WalkStopped, walk
from mjbiped.rules.scuffing import ScuffingRule
from mjbiped.sweeps.values import Scalar
from mjbiped.terrain.files import FILE_KEY, parse_parameters
from mjbiped.terrain.terrain import Terrain
from mjbiped.utils import domains
from mjbiped.utils.domains import Count, Domain

Row = dict[str, Any]
"""A row of the table: values by the names of columns."""

_ENDS = ("ended_at_time_s", "ended_at_x_m")

MEASURES = (*(key for _, key, *_ in measures.MEASURES), *_ENDS)
"""Columns of a walk's measures, named as in `mjbiped.records.measures.summary`."""

KNEES_MEASURES = (
    *(key for _, key, *_ in measures.measures_of(KneedBiped) if key not in measures.OF_STANCE_KNEE),
    *_ENDS,
)
"""The same in studies with robots with knees; other robots have nothing in the columns that are added. A study's walks
have locked stance knees and, mostly, no samples."""

ROBOT = Compass.kind
"""The robot that walks unless a study names another, by its name in `mjbiped.robots.kinds.NAMED`."""

LIMITS: Mapping[str, Count | Domain] = {"steps": domains.STEPS, "distance": domains.DISTANCE}
"""Domains of what `walk` takes as it is."""

LIMIT = "limit"
"""Section of these: the walk's own number of steps is a measure."""

OPTIONS: Mapping[str, Domain] = {"timestep": domains.TIMESTEP, "contact_timestep": domains.CONTACT_TIMESTEP}
"""Domains of settings of the engine mujoco, s."""

FAILED = "failed"
"""Outcome of a walk that an error kept from ending."""

TRAJECTORY = "trajectory"
"""Key of a row that holds the samples too, in flat columns; it is no column of the table."""

SPARSE = 1.0
"""Sample period of walks whose samples are not kept, s."""

_MUJOCO = threading.Lock()  # its callbacks belong to a whole process, and a remote worker may have several threads


@dataclass(frozen=True)
class Cell:
    """A walk to be made.

    Attributes:
        index: Its index in the table.
        sample: Of a study with distributions, the sample that its values were drawn for; else None.
        values: All that the study file says of it, by dotted names such as "controller.position_gain".
        ground: The terrain, where it is of a file; or the record that it is a stretch of.
        law: The controller's name, where it names a file: with the file's whole path.
    """

    index: int
    sample: int | None
    values: Mapping[str, Scalar]
    ground: Terrain | None = None
    law: str | None = None

    def section(self, name: str) -> dict[str, Any]:
        """Values of a section of the file by their names there; those with a dot in it stand in a table of their own.

        A range of values as text, "low..high", stays text.
        """
        found: dict[str, Any] = {}
        for key, value in self.values.items():
            section, _, rest = key.partition(".")
            if section == name and rest:
                outer, _, inner = rest.partition(".")
                if inner:
                    found.setdefault(outer, {})[inner] = value
                else:
                    found[outer] = value
        return found

    def robot(self) -> Robot:
        """The robot that walks."""
        return self._robot({})

    def _robot(self, model: Mapping[str, Any]) -> Robot:
        parameters = {**self.section("robot"), **model}
        return robot_named(str(parameters.pop("kind", ROBOT)), parameters)

    @property
    def knees(self) -> bool:
        """Whether the robot has knees."""
        return named(str(self.values.get("robot.kind", ROBOT)))[0].knees

    def controller(self, gait: Periodic | None = None) -> Controller:
        """The law; its robot model is the robot that walks, except where the section `model` says otherwise.

        Args:
            gait: A stand-in for the gait that is imitated, to check the settings without looking for one.
        """
        settings = self.section("controller")
        name = settings.pop("name")
        return make_controller(self.law or name, self._robot(self.section("model")), settings, gait)

    def disturbances(self) -> Disturbances | None:
        """Noise, delay, weak motors and pushes; None where the file says nothing of them."""
        given = self.section("disturbances")
        if not given:
            return None
        return Disturbances(**{name: checked(Disturbances, name, value) for name, value in given.items()})

    def scuffing(self) -> ScuffingRule:
        """When a straight swing leg's foot may touch the ground."""
        return ScuffingRule(**self.section("scuffing"))

    def engine(self) -> Engine:
        """The physics."""
        options = {key: self.values[key] for key in OPTIONS if key in self.values}
        return Mujoco(**options) if options else engine_of(str(self.values["engine"]))  # type: ignore[arg-type]  # checked

    def terrain(self) -> Terrain:
        """The ground."""
        settings = self.section("terrain")
        name = settings.pop("name", None)
        if name is None and self.ground is not None:
            return self.ground
        parameters = {key: _range(f"terrain.{key}", value) for key, value in settings.items() if key != FILE_KEY}
        return Terrain.preset(name, **({} if self.ground is None else {FILE_KEY: self.ground}), **parameters)

    def initial(self, controller: Controller, robot: Robot, terrain: Terrain) -> str | tuple[float, ...]:
        """The first state."""
        if "initial" in self.values:
            return str(self.values["initial"])
        domain, state = state_of(type(robot)), self.section("initial")
        base = [0.0] * len(domain)  # at rest, or of the numbers alone
        if state.get("around") == "gait":  # as in `walk`
            base = (controller.gait or passive_gait_of(robot, terrain.slope_at(0.0))).start.tolist()
        added = [domain[key].check(f"initial.{key}", state.get(key, 0.0)) for key in domain]
        return tuple(start + change for start, change in zip(base, added, strict=True))

    def walk(self, sample_period: float = SPARSE) -> Walk:
        """Let it walk.

        Args:
            sample_period: Of the record, s.
        """
        robot, terrain, controller = self.robot(), self.terrain(), self.controller()
        return walk(
            controller,
            terrain,
            engine=self.engine(),
            initial=self.initial(controller, robot, terrain),
            robot=robot,
            scuffing=self.scuffing(),
            disturbances=self.disturbances(),
            sample_period=sample_period,
            **self.section(LIMIT),
        )


def state_of(robot: type[Robot]) -> dict[str, Domain]:
    """Domains of a first state: angles q1, q2, ... from the ground's normal, rad, and their rates dq1, ..., rad/s."""
    count = range(1, 1 + len(robot.angles))
    return {**{f"q{k}": domains.ANGLE for k in count}, **{f"dq{k}": domains.RATE for k in count}}


def measured(cell: Cell, *, trajectory: bool = False) -> Row:
    """Walk a cell of a study.

    Args:
        cell: What walks.
        trajectory: Whether the samples are kept, in the row's `TRAJECTORY`.

    Returns:
        Outcome, error and measures; None for what does not exist.
    """
    period = DEFAULT_SAMPLE_PERIOD if trajectory else SPARSE
    with _MUJOCO if cell.values["engine"] == "mujoco" else nullcontext():
        return attempt(lambda: cell.walk(period), lambda done: {**_measures(done), **_samples(done, trajectory)})


def attempt(walked: Callable[[], Walk], measure: Callable[[Walk], Row]) -> Row:
    """Measure a walk that may fail.

    An error is a result: its text is kept, and the measures of the steps before it where there were any. What is the
    machine's fault and not the walk's is raised.

    Args:
        walked: Makes the walk.
        measure: Measures it.

    Returns:
        Outcome, error, and the measures where there are any.
    """
    try:
        done = walked()
    except WalkStopped as stop:
        return {**measure(stop.walk), "outcome": FAILED, "error": str(stop)}
    except (MemoryError, OSError):
        raise
    except Exception as error:
        return {"outcome": FAILED, "error": explained(error)}
    return {**measure(done), "outcome": done.outcome, "error": None}


def _samples(done: Walk, wanted: bool) -> Row:
    return {TRAJECTORY: flat_samples(done)} if wanted else {}


def _measures(done: Walk) -> Row:
    summary = measures.summary(done)
    # friction is unbounded where the ground would have to pull
    return {name: None if summary.get(name) == math.inf else summary.get(name) for name in KNEES_MEASURES}


def _range(where: str, value: Any) -> Any:
    """A range of numbers as a terrain takes it, of "low..high" or of a table; anything else as it is."""
    if isinstance(value, str):
        return parse_parameters(f"{where}={value}")[where]
    if isinstance(value, Mapping):
        if "plus_minus" in value:
            half = domains.STUDY_HALF.check(f"{where}.plus_minus", value["plus_minus"])
            return (-half, half)
        if not {"low", "high"} <= value.keys():
            raise InputError(f"{where} needs both low and high, or plus_minus alone")
        return (value["low"], value["high"])
    return value
