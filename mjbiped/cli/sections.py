"""Options in sections of a command's help, and queries about the options that were given."""

from __future__ import annotations

import inspect
import re
import shlex
from collections.abc import Callable, Iterable
from dataclasses import fields
from functools import partial
from typing import Any, TypeVar

import click

from mjbiped.cli.files import Results
from mjbiped.cli.kinds import quantity
from mjbiped.utils.domains import Count, Domain, Ends, Words

Function = TypeVar("Function", bound=Callable[..., Any])

_OF_RESULTS = {field.name for field in fields(Results) if field.init}

Row = tuple[str, Any, str] | tuple[str, Any, str, Any]
"""An option: its names, type (numbers: their domain), help, and default if it has one; () lets it be repeated."""


class SectionCommand(click.Command):
    """A command whose help lists its options by section, in the order in which the sections first occur.

    It receives the options of the section "Results" together, as its argument `results`.
    """

    def invoke(self, ctx: click.Context) -> object:
        """Run the command."""
        if given := {name: ctx.params.pop(name) for name in _OF_RESULTS & ctx.params.keys()}:
            ctx.params["results"] = Results(**given)
        return super().invoke(ctx)

    def parse_args(self, ctx: click.Context, args: list[str]) -> list[str]:
        """Read the words of the command line, and keep them as `ctx.obj`: records say how they were made."""
        ctx.obj = shlex.join(["mjbiped", str(ctx.info_name), *args])
        return super().parse_args(ctx, args)

    def format_options(self, ctx: click.Context, formatter: click.HelpFormatter) -> None:
        """Write the options into the help, one list per section."""
        sections: dict[str, list[tuple[str, str]]] = {}
        for parameter in self.get_params(ctx):
            record = parameter.get_help_record(ctx)
            if record is not None and isinstance(parameter, click.Option):
                sections.setdefault(getattr(parameter, "section", "Options"), []).append(record)
        sections["Options"] = sections.pop("Options", [])  # --help and its like come last
        for section, records in sections.items():
            with formatter.section(section):
                formatter.write_dl(records)


def described(kind: type) -> dict[str, str]:
    """Return the text about each field in the docstring of a class and its bases."""
    found: dict[str, str] = {}
    for each in reversed(kind.__mro__):
        attributes = inspect.cleandoc(each.__doc__ or "").partition("Attributes:\n")[2].partition("\n\n")[0]
        entries = re.findall(r"^ {4}(\w+): (.+(?:\n {8}.+)*)", attributes, re.MULTILINE)
        found |= {name: " ".join(text.split()) for name, text in entries}
    return found


def rows_of(kind: type, **words: str) -> list[Row]:
    """Return the options that a class describes, in the order of its docstring.

    Args:
        kind: A class with a field for each option, whose text in the docstring is the help. The field holds the type,
            or a tuple of type and default, or of type, default and the option's names where the field's is not its.
        **words: Words that stand in braces in the texts.
    """
    made: list[Row] = []
    for field, text in described(kind).items():
        value = getattr(kind, field)
        valid, *rest = value if isinstance(value, tuple) else (value,)
        name = rest.pop() if len(rest) > 1 else f"--{field.replace('_', '-')}"
        made.append((name, valid, text.format(**words), *rest))
    return made


def options(section: str, *rows: Row) -> Callable[[Function], Function]:
    """Give a command the options of one section."""

    def decorate(function: Function) -> Function:
        for name, given, text, *rest in reversed(rows):
            kind = quantity(given) if isinstance(given, Domain | Count | Ends | Words) else given
            default = rest[0] if rest else False if kind is bool else None
            function = click.option(
                *name.split(),
                type=kind,
                is_flag=kind is bool,
                default=default,
                multiple=default == (),
                show_default=default is not None and default is not False and default != (),
                metavar=getattr(kind, "metavar", None),
                help=text,
            )(function)
            function.__click_params__[-1].section = section  # type: ignore[attr-defined]  # where click keeps it
        return function

    return decorate


def together(*decorators: Callable[[Function], Function]) -> Callable[[Function], Function]:
    """Combine decorators into one; the first is the outermost."""

    def decorate(function: Function) -> Function:
        for decorator in reversed(decorators):
            function = decorator(function)
        return function

    return decorate


results = partial(options, "Results")
"""The options of a command's results, given its rows."""


def section(ctx: click.Context, *sections: str) -> list[click.Parameter]:
    """Return the options in sections of a command's help."""
    return [parameter for parameter in ctx.command.params if getattr(parameter, "section", "") in sections]


def taken(ctx: click.Context, values: dict[str, Any], *sections: str) -> dict[str, Any]:
    """Remove the options in sections of a command's help from `values`, and return them."""
    return {str(parameter.name): values.pop(str(parameter.name)) for parameter in section(ctx, *sections)}


def is_given(ctx: click.Context, name: str) -> bool:
    """Tell whether an option was given on the command line."""
    return ctx.get_parameter_source(name) is click.core.ParameterSource.COMMANDLINE


def refuse(ctx: click.Context, parameters: Iterable[click.Parameter], owner: str, name: str) -> None:
    """Refuse options that belong to something other than what was chosen.

    Raises:
        click.UsageError: One of them is given.
    """
    for parameter in parameters:
        if is_given(ctx, str(parameter.name)):
            off = ctx.params[str(parameter.name)] is False  # as --no-lands
            said = parameter.secondary_opts[0] if off else parameter.opts[0]
            raise click.UsageError(f"{said} is for {owner}; {name} has no such thing.")
