"""Types of the command line's options: each reads a value, and refuses what it is not in words."""

from __future__ import annotations

import math
from collections.abc import Callable
from pathlib import Path
from typing import Any

import click

from mjbiped.control.loading import FORMS, is_reference
from mjbiped.control.registry import controller_names
from mjbiped.engines.plan import INITIAL_STATES
from mjbiped.errors import InputError, shown
from mjbiped.gaits.described import parse_reference
from mjbiped.robots.compass import Compass
from mjbiped.robots.kinds import NAMED
from mjbiped.robots.kneed import KneedBiped
from mjbiped.terrain.files import parse_number
from mjbiped.utils import domains
from mjbiped.utils.domains import Count, Domain
from mjbiped.utils.files import check_writable


class Kind(click.types.FuncParamType):  # type: ignore[type-arg]  # generic in the latest click alone
    """Values that a function reads; `metavar` stands for one in the help."""

    def __init__(self, metavar: str, read: Callable[[Any], Any]) -> None:
        """Take the name beside the function."""
        super().__init__(read)
        self.metavar = metavar


class Folder(click.Path):
    """The path of a folder, which need not be there."""

    metavar = "FOLDER"

    def __init__(self) -> None:
        """Take folders alone."""
        super().__init__(file_okay=False, path_type=Path)


def output(*suffixes: str) -> Kind:
    """The type of a file to write: its suffix is one of these, its folder is there and takes new files.

    A file that is there already may be replaced.
    """

    def convert(value: Any) -> Path:
        path = Path(value)
        if path.suffix not in suffixes:
            raise click.BadParameter(f"{shown(str(path))} must end in {' or '.join(suffixes)}.")
        try:
            if path.is_dir():
                raise click.BadParameter(f"{shown(str(path))} is a folder.")
            if not path.parent.is_dir():
                raise click.BadParameter(
                    f"{shown(str(path))}: there is no folder {shown(str(path.parent))}; make it first."
                )
            check_writable(path)
        except (OSError, ValueError) as error:  # a name that no file can have is a ValueError
            reason = getattr(error, "strerror", None) or error
            raise click.BadParameter(f"{shown(str(path))} cannot be written: {reason}.") from error
        return path

    return Kind("FILE", convert)


def quantity(domain: Domain | Count) -> Kind:
    """The type of a number of a domain."""

    def number(value: Any) -> float:
        try:
            return domain.check("", parse_number(value) if isinstance(value, str) else value)
        except InputError as error:
            raise click.BadParameter(f"{shown(value)}; expected {domain.words}.") from error

    return Kind("X" if isinstance(domain, Domain) else "N", number)


def span(domain: Domain) -> Kind:
    """The type of two numbers of a domain as "0.8..1.6", the first below the second."""

    def ends(value: Any) -> tuple[float, float]:
        first, _, second = str(value).partition("..")
        try:
            low, high = (domain.check("", parse_number(end)) for end in (first, second))
        except InputError:
            low = high = math.nan
        if not low < high:
            raise click.BadParameter(
                f"{shown(value)}; expected two numbers LOW..HIGH, {domain}, the first below the second, as 0.8..1.6."
            )
        return low, high

    return Kind("LOW..HIGH", ends)


def delay(value: Any) -> float | None:
    """A number, or "none"."""
    if isinstance(value, str) and value.strip().lower() == "none":
        return None
    try:
        number: float = quantity(domains.REPLANNING_DELAY)(value)
        return number
    except click.BadParameter as error:
        raise click.BadParameter(f"{error.message[:-1]}, or 'none' to switch re-planning off.") from error


def initial_state(value: str) -> str | tuple[float, ...]:
    """The name of a walk's first state, or four numbers, or six of a robot with knees."""
    if value in INITIAL_STATES:
        return value
    try:
        numbers = [parse_number(part) for part in value.split(",")]
        return tuple(domains.check_states("", numbers, (6 if len(numbers) == 6 else 4,)).tolist())
    except InputError as error:
        wanted = f"{', '.join(map(repr, INITIAL_STATES))} or four numbers q1,q2,dq1,dq2 (rad, rad/s)"
        raise click.BadParameter(f"{shown(value)}; expected {wanted}.") from error


def gain(value: str) -> tuple[str, str]:
    """A setting's name and value, as "ratio=-2"; the controller knows which it has, their types and domains."""
    name, _, rest = value.partition("=")
    if not name.strip() or not rest.strip():
        raise click.BadParameter(f"{shown(value)}; expected NAME=VALUE, as gain=10.")
    return name.strip(), rest


def push(value: str) -> tuple[float, float]:
    """When a push begins (s) and its impulse (N s), as "2:-5"."""
    time, _, impulse = value.partition(":")
    try:
        return domains.TIME.check("", parse_number(time)), domains.PUSH.check("", parse_number(impulse))
    except InputError as error:
        raise click.BadParameter(f"{shown(value)}; expected TIME:IMPULSE in s and N s, as 2:-5.") from error


def model_error(value: str) -> tuple[str, float]:
    """A parameter of the robot and a factor, as "leg_mass=1.2"."""
    name, _, factor = value.partition("=")
    known = list(dict.fromkeys((*Compass.parameters(), *KneedBiped.parameters())))
    try:
        domains.known_name("parameter of the robot", name.strip(), known)
        return name.strip(), domains.MODEL_ERROR.check("", parse_number(factor))
    except InputError as error:
        names = ", ".join(known)
        raise click.BadParameter(
            f"{shown(value)}; expected NAME=FACTOR, as leg_mass=1.2, of {names}, and {domains.MODEL_ERROR.words}."
        ) from error


def controller_name(value: str) -> str:
    """The name of a registered controller, or of a class of the user's own, which is not loaded yet."""
    if is_reference(value) or value in controller_names():
        return value
    names = controller_names()
    hint = domains.nearest(value, names) or "."
    raise click.BadParameter(f"{shown(value)}; expected one of {', '.join(names)}, or {FORMS}{hint}")


CONTROLLER = Kind("NAME", controller_name)


def own_controller(value: str) -> str:
    """The place of a class of the user's own, which is not loaded yet."""
    if is_reference(value):
        return value
    raise click.BadParameter(f"{shown(value)}; expected {FORMS}; registered controllers are found by themselves.")


OWN_CONTROLLER = Kind("FILE.py:CLASS", own_controller)


def reference(value: Any) -> str:
    """What is asked of an optimised reference, as it was written."""
    try:
        parse_reference(value)
    except InputError as error:
        raise click.BadParameter(f"{error}.") from error
    return str(value)


def robot_name(value: Any) -> str:
    """A robot's name, or the path of a file that has one."""
    text = str(value)
    if text not in NAMED and not text.endswith(".toml"):
        raise click.BadParameter(f"{shown(text)}; expected {', '.join(NAMED)}, or a .toml file.")
    return text
