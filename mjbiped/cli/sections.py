"""Options of a command in sections of its help."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, TypeVar

import click

from mjbiped.cli.kinds import quantity
from mjbiped.utils.domains import Count, Domain

_Function = TypeVar("_Function", bound=Callable[..., Any])

Row = tuple[str, Any, Any, str]
"""An option: its names, type (numbers: their domain), default, and help."""


class SectionOption(click.Option):
    """An option that stands in a section of its command's help."""

    def __init__(self, *args: Any, section: str = "Options", **kwargs: Any) -> None:
        """Take the section beside an option's usual arguments."""
        super().__init__(*args, **kwargs)
        self.section = section


class SectionCommand(click.Command):
    """A command whose help lists its options by section, in the order in which the sections first occur."""

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


def options(section: str, *rows: Row) -> Callable[[_Function], _Function]:
    """Options of one section of the help: a decorator for the command's function."""

    def decorate(function: _Function) -> _Function:
        for name, given, default, text in reversed(rows):
            kind = quantity(given) if isinstance(given, Domain | Count) else given
            function = click.option(
                *name.split(),
                cls=SectionOption,
                section=section,
                type=kind,
                is_flag=kind is bool,
                default=default,
                multiple=default == (),
                show_default=default is not None and default is not False and default != (),
                metavar=getattr(kind, "metavar", None),
                help=text,
            )(function)
        return function

    return decorate
