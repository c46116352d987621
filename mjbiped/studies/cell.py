"""One walk of a study: its inputs, and the measures in its row of the table."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

from mjbiped.control.controller import Controller
from mjbiped.control.loading import checked, digest_of
from mjbiped.control.registry import make_controller
from mjbiped.disturbances.disturbances import Disturbances
from mjbiped.engines.base import Engine, engine_of
from mjbiped.engines.mujoco.engine import Mujoco
from mjbiped.engines.plan import DEFAULT_SAMPLE_PERIOD, INITIAL_STATES
from mjbiped.errors import InputError, MjbipedError, explained
from mjbiped.gaits.described import passive_gait_of
from mjbiped.gaits.gait import Gait
from mjbiped.records import measures
from mjbiped.records.columns import flat_samples
from mjbiped.records.record import Walk
from mjbiped.records.summary import OF_STANCE_KNEE, measures_of
from mjbiped.robots.compass import Compass
from mjbiped.robots.kinds import named, robot_named
from mjbiped.robots.kneed import KneedBiped
from mjbiped.robots.robot import Robot
from mjbiped.rollout.walk import WalkStopped, walk
from mjbiped.rules.scuffing import ScuffingRule
from mjbiped.terrain.files import FILE_KEY, parse_parameters
from mjbiped.terrain.terrain import Terrain
from mjbiped.utils import domains
from mjbiped.utils.domains import Domain, known_name
from mjbiped.utils.draws import Scalar

Row = dict[str, Any]
"""A row of the table: values by the names of columns."""

_ENDS = ("ended_at_time_s", "ended_at_x_m")

MEASURES = (*(each.key for each in measures_of(Compass)), *_ENDS)
"""Columns of a walk's measures, named as in `mjbiped.records.measures.summary`."""

KNEES_MEASURES = (
    *(each.key for each in measures_of(KneedBiped) if each.key not in OF_STANCE_KNEE),
    *_ENDS,
)
"""Columns of measures in studies with kneed robots; other robots leave the additional columns empty. A study's walks
have locked stance knees and usually no samples, so that measures of the stance knee are left out."""

ROBOT = Compass.kind
"""The robot that walks unless a study names another, by its name in `mjbiped.robots.kinds.NAMED`."""

LIMITS = ("steps", "distance")
"""Limits of a walk: arguments of `walk`, passed on unchanged."""

LIMIT = "limit"
"""Section of `LIMITS` in a cell's values; the number of steps that were walked is a measure."""

OPTIONS = ("timestep", "contact_timestep")
"""Settings of the engine mujoco, s."""

FAILED = "failed"
"""Outcome of a walk that an error stopped."""

TRAJECTORY = "trajectory"
"""Key of a row for the walk's samples, in flat columns; it is no column of the table."""

SPARSE = 1.0
"""Sample period of walks whose samples are not kept, s."""


@dataclass(frozen=True)
class Cell:
    """A walk to be made.

    Attributes:
        index: Index of the walk in the table.
        sample: Number of the sample that its values were drawn for; None without distributions.
        values: Everything the study file sets for it, by dotted names such as "controller.position_gain".
        ground: The terrain of a file, or the elevation record that the terrain is a stretch of; else None.
        law: Name of a user's own controller with the whole path of its file; else None.
    """

    index: int
    sample: int | None
    values: Mapping[str, Scalar]
    ground: Terrain | None = None
    law: str | None = None

    def section(self, name: str) -> dict[str, Any]:
        """Return the values of a section of the file by their names in it."""
        start = f"{name}."
        return {key.removeprefix(start): value for key, value in self.values.items() if key.startswith(start)}

    def robot(self, **changed: object) -> Robot:
        """The robot that walks, or one that differs from it in some parameters."""
        parameters = {**self.section("robot"), **changed}
        return robot_named(str(parameters.pop("kind", ROBOT)), parameters)

    @property
    def kind(self) -> type[Robot]:
        """Kind of the robot that walks."""
        return named(str(self.values.get("robot.kind", ROBOT)))[0]

    def controller(self, gait: Gait | None = None) -> Controller:
        """Make the controller; its robot model is the walking robot, except for parameters of the section `model`.

        Args:
            gait: A stand-in for the imitated gait, which checks the settings without a search for a gait.
        """
        settings = self.section("controller")
        name = settings.pop("name")
        return make_controller(self.law or name, self.robot(**self.section("model")), settings, gait)

    def disturbances(self) -> Disturbances | None:
        """Noise, delay, weak motors and pushes; None without the section."""
        given = {name: checked(Disturbances, name, value) for name, value in self.section("disturbances").items()}
        return Disturbances(**given) if given else None

    def scuffing(self) -> ScuffingRule:
        """The rule that says when the foot of a straight swing leg may touch the ground."""
        return ScuffingRule(**self.section("scuffing"))

    def engine(self) -> Engine:
        """The engine with its settings."""
        options: dict[str, Any] = {key: self.values[key] for key in OPTIONS if key in self.values}
        name = str(self.values["engine"])
        if options and name != Mujoco.name:
            raise InputError(f"{', '.join(options)}: settings of the engine mujoco; the engine {name} has none")
        return Mujoco(**options) if options else engine_of(name)

    def terrain(self) -> Terrain:
        """Return the ground."""
        settings = self.section("terrain")
        name = settings.pop("name", None)
        if name is None and self.ground is not None:
            check_keys("key of a terrain of a file", settings, (FILE_KEY,))
            return self.ground
        settings.pop(FILE_KEY, None)
        parameters: dict[str, Any] = {}
        for key, value in settings.items():
            outer, _, part = key.partition(".")
            if part == "plus_minus":
                half = domains.Domain(0.0, 1e18).check(f"terrain.{key}", value)
                parameters[outer] = (-half, half)
            elif part:  # "low" or "high"
                parameters[outer] = (settings[f"{outer}.low"], settings[f"{outer}.high"])
            else:
                parameters |= parse_parameters(f"{key}={value}") if isinstance(value, str) else {key: value}
        if self.ground is not None:
            parameters[FILE_KEY] = self.ground
        return Terrain.preset(name, **parameters)

    def initial(self, gait_start: Callable[[], Sequence[float]]) -> str | tuple[float, ...]:
        """Return the first state: a name, or the robot's angles and rates.

        Args:
            gait_start: Returns the first state of the gait that the controller imitates.

        Raises:
            InputError: The section is not valid for the robot.
        """
        if "initial" in self.values:
            return known_name("initial state", self.values["initial"], INITIAL_STATES)
        given, valid = self.section("initial"), state_of(self.kind)
        check_keys("key of initial", given, ("around", *valid))
        state = {name: valid[name].check(f"initial.{name}", given[name]) for name in valid if name in given}
        missing = [name for name in valid if name not in given]
        if missing and "around" not in given:
            words = f"all of {', '.join(valid)}, or around = one of {', '.join(INITIAL_STATES)} and the deviations"
            raise InputError(f"initial needs {', '.join(missing)} as well: {words} from it")
        around = known_name("initial.around", given.get("around", "rest"), INITIAL_STATES)
        base = gait_start() if around == "gait" else [0.0] * len(valid)
        return tuple(start + state.get(name, 0.0) for name, start in zip(valid, base, strict=True))

    def walk(self, sample_period: float = SPARSE) -> Walk:
        """Walk the cell.

        Args:
            sample_period: Sample period of the record, s.
        """
        robot, terrain, controller = self.robot(), self.terrain(), self.controller()
        return walk(
            controller,
            terrain,
            engine=self.engine(),
            initial=self.initial(
                lambda: (controller.gait or passive_gait_of(robot, terrain.slope_at(0.0))).start.tolist()
            ),
            robot=robot,
            scuffing=self.scuffing(),
            disturbances=self.disturbances(),
            sample_period=sample_period,
            **self.section(LIMIT),
        )

    def row(self, *, trajectory: bool = False, laws: Mapping[str, str] | None = None) -> Row:
        """Walk the cell, and return its row: its values, with booleans as text, outcome, error and measures.

        Args:
            trajectory: Whether the samples are kept, in the row's `TRAJECTORY`.
            laws: Digests of the user's own controllers, by their names in the study, with which it must walk.

        Raises:
            MjbipedError: The source of the user's own controller differs from the one that the study began with.
        """
        name = self.values["controller.name"]
        if self.law is not None and laws and digest_of(self.law) != laws[str(name)]:
            raise MjbipedError(f"the source of the controller {name} is another one where it walks, or just changed")

        def measure(done: Walk) -> Row:
            summary = measures.summary(done)
            # friction is unbounded where the ground would have to pull
            row = {name: None if summary.get(name) == math.inf else summary.get(name) for name in KNEES_MEASURES}
            return row | ({TRAJECTORY: flat_samples(done)} if trajectory else {})

        plain = {name: str(value).lower() if isinstance(value, bool) else value for name, value in self.values.items()}
        period = DEFAULT_SAMPLE_PERIOD if trajectory else SPARSE
        return {"cell": self.index, "sample": self.sample, **plain, **attempt(lambda: self.walk(period), measure)}


def check_keys(what: str, table: Iterable[str], valid: Iterable[str]) -> None:
    """Refuse a table with unknown keys.

    Raises:
        InputError: A key is unknown; the message says what kind of key it is.
    """
    for key in table:
        known_name(what, key, valid)


def state_of(robot: type[Robot]) -> dict[str, Domain]:
    """Domains of an initial state: angles q1, q2, ... from the ground's normal, rad, and rates dq1, ..., rad/s."""
    count = range(1, 1 + len(robot.angles))
    return {**{f"q{k}": domains.ANGLE for k in count}, **{f"dq{k}": domains.RATE for k in count}}


def attempt(walked: Callable[[], Walk], measure: Callable[[Walk], Row]) -> Row:
    """Measure a walk that may fail.

    An error is a result: its text is kept, and the measures of the steps before it where there were any. Errors of the
    machine, in memory or files, are raised.

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
