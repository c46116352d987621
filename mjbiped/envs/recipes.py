"""Recipes of episodes: robot, terrain and disturbances of an environment, fixed or drawn from distributions.

A recipe is what a user gives: an object, a name, or a table of parameters. In a table each number may be a
distribution, {"uniform": [4, 5]}, as in the study files of `mjbiped sweep`; it is drawn anew in each episode.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from functools import cached_property, partial
from numbers import Real
from types import MappingProxyType
from typing import Annotated, Any, Generic, Literal, TypeVar

from mjbiped.disturbances.disturbances import UNDISTURBED, Disturbances
from mjbiped.errors import InputError, prefixed, shown
from mjbiped.robots.compass import Compass
from mjbiped.robots.kinds import robot_named
from mjbiped.robots.robot import Robot
from mjbiped.rules.termination import Outcome
from mjbiped.terrain.presets import RANDOM
from mjbiped.terrain.terrain import Terrain
from mjbiped.utils import domains
from mjbiped.utils.domains import check_fields, known_name
from mjbiped.utils.draws import Draw, Number, read_draw

Made = TypeVar("Made")

SEED = MappingProxyType({"integer": (0, 2**31 - 1)})
"""Distribution of the seed of whatever has one that is not given."""

TASKS: Mapping[str, tuple[str, Mapping[str, object]]] = MappingProxyType(
    {
        "walk_level": ("level", {}),
        "walk_slopes": ("slopes", {}),
        "walk_stairs": ("stairs", {"rise": -0.02}),
        "walk_random": ("random", {"length": 15.0}),
    }
)
"""The terrain's preset and parameters by the task's name; random ground is new in each episode."""

_ROBOT = "a robot, a name such as 'kneed', or a table of parameters such as {'kind': 'kneed', 'thigh_mass': 4.0}"
_TERRAIN = (
    "a Terrain, the name of a preset such as 'stairs', a Curriculum, or a dictionary of parameters of the preset {}, "
    "or of another one as {{'name': 'stairs', 'rise': 0.01}}"
)
_DISTURBANCES = (
    "a mjbiped.Disturbances, or a table of its parameters such as "
    "{'angle_noise': 0.002, 'torque_limit': {'uniform': [20, 40]}}"
)


@dataclass(frozen=True)
class Recipe(Generic[Made]):
    """Makes an object of a table of parameters.

    Attributes:
        name: Name of the setting, "robot" for instance.
        make: Makes the object of the parameters.
        given: Parameters, with a `Draw` in the place of each number that is drawn.
    """

    name: str
    make: Callable[[dict[str, Any]], Made]
    given: Mapping[str, object]

    @cached_property
    def draws(self) -> dict[str, Draw]:
        """Distributions by dotted names, "robot.leg_mass" for instance."""
        found: dict[str, Draw] = {}
        self._table(found.setdefault)
        return found

    def made(self, drawn: Mapping[str, Number]) -> Made:
        """Make the object with the numbers that were drawn, by dotted names; without any it is always the same.

        Raises:
            InputError: A parameter is unknown or outside its domain.
        """
        return self.make(self._table(lambda name, _: drawn[name])) if self.draws else self._only

    @cached_property
    def _only(self) -> Made:
        return self.make(dict(self.given))

    def _table(self, change: Callable[[str, Any], Any]) -> dict[str, Any]:
        return {key: _changed(f"{self.name}.{key}", value, change) for key, value in self.given.items()}

    @property
    def middle(self) -> Made:
        """The object made with the median of each distribution."""
        return self.made({name: draw.middle for name, draw in self.draws.items()})

    def check(self) -> None:
        """Refuse parameters with which the object cannot be made, at either end of all distributions.

        Raises:
            InputError: A parameter is unknown, or reaches beyond its domain.
        """
        for end, which in enumerate(("least", "greatest")):
            with prefixed(f"with the {which} numbers that can be drawn, " if self.draws else ""):
                self.made({name: draw.ends[end] for name, draw in self.draws.items()})


def _changed(name: str, value: object, change: Callable[[str, Any], Any]) -> object:
    """Replace each distribution in a value by what a function returns for its dotted name and itself."""
    if isinstance(value, Mapping | Draw):
        return change(name, value)
    if isinstance(value, list | tuple):
        return tuple(_changed(f"{name}.{key}", each, change) for key, each in enumerate(value))
    return value


def _recipe(name: str, kind: Any, value: object, make: Callable[[dict[str, Any]], Made], wanted: str) -> Recipe[Made]:
    """Read a setting: an object of a class, or a table of parameters in which distributions may stand.

    Raises:
        InputError: It is neither, or a table in it is no distribution.
    """
    if isinstance(value, kind):
        return Recipe(name, partial(_given, value), {})
    if not isinstance(value, Mapping):
        raise InputError(f"{name} = {shown(value)}: must be {wanted}")
    return Recipe(name, make, Recipe(name, make, value)._table(read_draw))


def _given(made: Made, _: object) -> Made:
    return made


@dataclass(frozen=True)
class Curriculum:
    """Ground that becomes harder as the learner gets on, to be given as the setting `terrain` of an environment.

    Each parameter of the ground goes from its value in `easy` to that in `hard` with the difficulty, which is 0 in the
    first episode and at most 1. Each robot has a difficulty of its own, so that many robots learn on grounds of all
    kinds; `info` tells it as "terrain.difficulty". A reset with a seed begins anew at 0.

    ```python
    ground = Curriculum(
        easy={"name": "random", "slope_deg": (-1.0, 1.0), "rise": (-0.005, 0.0)},
        hard={"slope_deg": (-6.0, 6.0), "rise": (-0.05, 0.015)},
    )
    envs = gymnasium.make_vec("mjbiped/CompassWalkRandom-v0", num_envs=64, terrain=ground)
    ```

    Attributes:
        easy: Parameters at difficulty 0, with the preset's name as `name`, unless it is the task's. Numbers may be
            distributions.
        hard: Parameters that differ at difficulty 1; their values have the same form as in `easy`.
        step: Change of the difficulty from one episode to the next, from 0 to 1.
        by: "success": it grows after an episode that the robot walked to the time limit or to the end of the ground,
            and shrinks after any other; "episodes": it grows after each.

    Raises:
        InputError: A value is outside its domain, or `hard` has parameters that `easy` lacks.
    """

    easy: Mapping[str, object]
    hard: Mapping[str, object]
    step: Annotated[float, domains.PROBABILITY] = 0.1
    by: Literal["success", "episodes"] = "success"

    def __post_init__(self) -> None:
        """Check the settings."""
        check_fields(self)
        known_name("curriculum's `by`", self.by, ("success", "episodes"))
        for name in self.hard:
            known_name("parameter in `hard`; give it in `easy` too", name, self.easy)

    def at(self, difficulty: float) -> dict[str, object]:
        """Parameters of the ground at a difficulty."""
        return {
            name: _between(f"terrain.{name}", value, self.hard.get(name, value), difficulty)
            for name, value in self.easy.items()
        }

    def after(self, difficulty: float, outcome: Outcome) -> float:
        """Difficulty of the episode that follows one with an outcome."""
        walked = outcome in (Outcome.TIME_LIMIT, Outcome.LEFT_TERRAIN)
        grows = walked or self.by == "episodes"
        return min(max(difficulty + (self.step if grows else -self.step), 0.0), 1.0)


def _between(name: str, easy: object, hard: object, difficulty: float) -> object:
    """Go from an easy value to a hard one of the same form: numbers, sequences and distributions of numbers.

    Raises:
        InputError: They have different forms.
    """
    if easy == hard:
        return easy
    if isinstance(easy, Mapping) and isinstance(hard, Mapping) and easy.keys() == hard.keys():
        return {key: _between(name, value, hard[key], difficulty) for key, value in easy.items()}
    if isinstance(easy, list | tuple) and isinstance(hard, list | tuple) and len(easy) == len(hard):
        return tuple(_between(name, *ends, difficulty) for ends in zip(easy, hard, strict=True))
    if isinstance(easy, Real) and isinstance(hard, Real):
        number = (1.0 - difficulty) * float(easy) + difficulty * float(hard)
        return round(number) if isinstance(easy, int) and isinstance(hard, int) else number
    raise InputError(f"{name}: {shown(easy)} and {shown(hard)} have different forms, between which there is nothing")


def robot_recipe(value: Robot | str | Mapping[str, object]) -> Recipe[Robot]:
    """Read the setting `robot`.

    Args:
        value: A robot; the name of one; or its parameters, with its name as `kind`, as in study files.

    Raises:
        InputError: It is none of these.
    """
    return _recipe("robot", Robot, {"kind": value} if isinstance(value, str) else value, _robot, _ROBOT)


def _robot(parameters: dict[str, Any]) -> Robot:
    return robot_named(parameters.pop("kind", Compass.kind), parameters)


def terrain_recipe(
    value: Terrain | str | Mapping[str, object] | Curriculum, task: str, difficulty: float = 0.0
) -> Recipe[Terrain]:
    """Read the setting `terrain`.

    Args:
        value: A terrain; the name of a preset; or its parameters, with its name as `name`, as in study files. Without
            the name they replace those of the task's preset. Or a curriculum.
        task: The task's name.
        difficulty: Difficulty of the episode, for a curriculum.

    Raises:
        InputError: It is none of these.
    """
    preset, own = TASKS[task]
    if isinstance(value, Curriculum):
        value = value.at(difficulty)
    table: object = {"name": value} if isinstance(value, str) else value
    if isinstance(table, Mapping):
        table = table if "name" in table else {"name": preset, **own, **table}
        table = {"seed": SEED, **table} if table["name"] in RANDOM else table
    return _recipe("terrain", Terrain, table, _terrain, _TERRAIN.format(preset))


def _terrain(parameters: dict[str, Any]) -> Terrain:
    return Terrain.preset(**parameters)


def disturbances_recipe(value: Disturbances | Mapping[str, object] | None) -> Recipe[Disturbances]:
    """Read the setting `disturbances`.

    Args:
        value: Disturbances, or a table of their parameters; None: none.

    Raises:
        InputError: It is none of these, or the period of the control loop is drawn.
    """
    table: object = {"seed": SEED, **value} if isinstance(value, Mapping) else UNDISTURBED if value is None else value
    recipe = _recipe("disturbances", Disturbances, table, Disturbances.from_dict, _DISTURBANCES)
    if "disturbances.control_period" in recipe.draws:
        raise InputError("disturbances.control_period cannot be drawn: it is the same in all episodes; give a number")
    return recipe
