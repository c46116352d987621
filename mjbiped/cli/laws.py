"""The controller of a command, of its options."""

from __future__ import annotations

from collections.abc import Iterable
from typing import Any

import click

from mjbiped.cli import options
from mjbiped.control.controller import Controller
from mjbiped.control.loading import is_reference
from mjbiped.control.registry import SHARED, controller_class, make_controller, settings_of
from mjbiped.control.settings import shown_defaults, value_of, why_none
from mjbiped.errors import InputError, shortened
from mjbiped.robots.robot import Robot
from mjbiped.utils.domains import nearest


def controller_of(ctx: click.Context, robot: Robot, values: dict[str, Any]) -> Controller:
    """The controller of a command, its options taken out of `values`.

    Raises:
        click.UsageError: An option is given that the controller does not have.
        MjbipedError: There is no such controller, a gain is outside its domain, or the slope to be imitated has no
            passive gait.
    """
    name, gains = values.pop("controller"), dict(values.pop("gain"))
    settings = taken(ctx, values, options.ADAPTIVE, options.COMPARISON)
    valid = settings_of(name, robot)
    _refuse_options(ctx, name, valid)
    fields = options.gains_of(name, robot)
    for unknown in gains.keys() - fields.keys():
        said = f"valid are {shown_defaults(fields)}" if fields else f"it has none{why_none(controller_class(name))}"
        raise click.UsageError(
            f"--gain {shortened(unknown)}: {name} has no such gain; {said}{nearest(unknown, fields) or '.'}"
        )
    given = {key: value for key, value in settings.items() if key in valid and is_given(ctx, key)}
    for twice in given.keys() & gains.keys():
        raise click.UsageError(f"--gain {twice} and --{twice.replace('_', '-')} say the same; give one of them.")
    return make_controller(name, robot, {**given, **_values(controller_class(name, robot), gains)})


def _refuse_options(ctx: click.Context, name: str, valid: Iterable[str]) -> None:
    """Refuse options for other controllers.

    Raises:
        click.UsageError: One is given.
    """
    adaptive, comparison = section(ctx, options.ADAPTIVE), section(ctx, options.COMPARISON)
    if is_reference(name):  # whatever its fields are called, their domains are its own: --gain sets them
        own = [each for each in (*SHARED, "slope_source") if each in valid]
        others = [each for each in (*adaptive, *comparison) if each.name not in own]
        refuse(ctx, others, "controllers of this project, and --gain sets what yours has", name)
        return
    compared = name in options.OTHERS
    if name != "adaptive":
        others = [each for each in adaptive if not (compared and each.name in SHARED)]
        refuse(ctx, others, "--controller adaptive", name)
    if not compared or "slope_source" not in valid:
        refuse(ctx, comparison, f"--controller {', '.join(options.OTHERS)}", name)


def _values(kind: type[Controller], gains: dict[str, str]) -> dict[str, Any]:
    """The values of gains that are given as texts.

    Raises:
        InputError: One is not of its field's type.
    """
    try:
        return {key: value_of(kind, key, text) for key, text in gains.items()}
    except InputError as error:
        raise InputError(f"--gain {error}") from error


def refuse(ctx: click.Context, parameters: Iterable[click.Parameter], owner: str, name: str) -> None:
    """Refuse options that are for something else than what was chosen.

    Raises:
        click.UsageError: One of them is given.
    """
    for parameter in parameters:
        if is_given(ctx, str(parameter.name)):
            raise click.UsageError(f"{parameter.opts[0]} is for {owner}; {name} has no such thing.")


def section(ctx: click.Context, *sections: str) -> list[click.Parameter]:
    """The options of sections of a command's help."""
    return [parameter for parameter in ctx.command.params if getattr(parameter, "section", "") in sections]


def taken(ctx: click.Context, values: dict[str, Any], *sections: str) -> dict[str, Any]:
    """The options of sections of a command's help, taken out of `values`."""
    return {str(parameter.name): values.pop(str(parameter.name)) for parameter in section(ctx, *sections)}


def is_given(ctx: click.Context, name: str) -> bool:
    """Whether an option stands on the command line."""
    return ctx.get_parameter_source(name) is click.core.ParameterSource.COMMANDLINE
