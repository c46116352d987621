"""A setting has one name: that of the Python argument or field, with `_deg` where degrees are given."""

from __future__ import annotations

import inspect
from collections.abc import Callable, Iterator, Mapping
from typing import Any

import click
import pytest

import controllers
import mjbiped
from mjbiped.cli.main import main
from mjbiped.control.registry import controller_names, settings_of
from mjbiped.robots.kinds import KINDS
from mjbiped.studies import plan as sweeps
from mjbiped.studies import robustness
from mjbiped.studies.plan import SCUFFING
from mjbiped.terrain.presets import PRESETS

PUBLIC: tuple[Callable[..., Any], ...] = (
    *(each for name in mjbiped.__all__ if callable(each := getattr(mjbiped, name))),
    *(each for name in controllers.__all__ if inspect.isclass(each := getattr(controllers, name))),
    *(getattr(mjbiped.Terrain, name) for name in PRESETS),
)

OF_COMMANDS = {
    "what is written, and where": "out plot plot_width panels plot_multipliers video video_size no_video report "
    "parquet trajectories",
    "what is printed": "json quiet dry_run",
    "how a long command runs": "fresh quick scheduler clear for",
}
"""Options that are of commands alone: Python has other means."""

SAID_OTHERWISE = {
    "scuffing_reach": "`reach` of the argument `scuffing`",
    "disturb": "one field of `Disturbances`, so that it may be repeated",
    "push": "one of the field `pushes`",
    "flag": "one of the argument `flags`",
    "model_error": "a factor on a parameter of the model: in Python the model is an object",
    "reference": "the goal of a search for the field `gait`, in words",
    "imitate_slope_deg": "the slope of the passive gait that becomes the field `gait`",
    "points": "how many states stand in a section of the return map, which Python is given",
    "grid": "how many of `stance_rates` and `swing_rates`, which the command line gives by their ends",
}
"""Options that give what is an object or an array in Python, each with the reason."""

OF_STUDIES = {
    "samples": "how many walks are made of drawn values",
    "plot": "parameters and measures of figures",
    "model": "section of the controller's robot, an object in Python",
    "grounds": "terrains as on the command line",
    "seeds": "how many seeds: 0 and on",
    "limits": "section of single disturbances",
    "margins": "section of lasting disturbances",
}
"""Keys at the top of study files that neither `walk` nor its engine takes."""


def taken(public: Callable[..., Any]) -> Iterator[str]:
    """Names of arguments; those of a dataclass are its fields."""
    try:
        yield from inspect.signature(public).parameters
    except ValueError:  # an exception's
        return


NAMES = {name for public in PUBLIC for name in taken(public)}
COMMANDS: Mapping[str, click.Command] = main.commands


def options_of(command: str) -> Iterator[tuple[str, str]]:
    """Each option's name as it is written, and the argument that it becomes."""
    for option in COMMANDS[command].params:
        if isinstance(option, click.Option):
            yield option.opts[0].removeprefix("--").replace("-", "_"), str(option.name)


@pytest.mark.parametrize("command", COMMANDS)
def test_options_have_the_names_of_python(command: str) -> None:
    others = {*SAID_OTHERWISE, *" ".join(OF_COMMANDS.values()).split()}
    for written, becomes in options_of(command):
        assert written in others or written.removesuffix("_deg") in NAMES, f"{command} --{written}"
        assert written == becomes or written in others, f"{command} --{written} becomes {becomes}"


def test_every_exception_is_an_option_and_no_name_of_python() -> None:
    written = {name for command in COMMANDS for name, _ in options_of(command)}
    listed = {*SAID_OTHERWISE, *" ".join(OF_COMMANDS.values()).split()}
    assert listed <= written
    assert not {name.removesuffix("_deg") for name in listed} & NAMES


@pytest.mark.parametrize("name", controller_names())
def test_settings_of_controllers_are_their_fields(name: str) -> None:
    """In study files and of `--gain`; the sections `robot`, `terrain` and `disturbances` are read by their classes."""
    for key in settings_of(name):
        assert key in SAID_OTHERWISE or key.removesuffix("_deg") in NAMES


def test_keys_of_studies_have_the_names_of_python() -> None:
    keys = {*sweeps.KEYS, *robustness.KEYS}
    arguments = {name for public in (mjbiped.walk, mjbiped.Mujoco, mjbiped.Terrain.random) for name in taken(public)}
    assert keys - arguments == {*OF_STUDIES}
    assert {*SCUFFING} <= {*taken(mjbiped.ScuffingRule)}
    assert {name for kind in KINDS.values() for name in kind.parameters()} <= NAMES
