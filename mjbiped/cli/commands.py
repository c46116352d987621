"""Commands made of annotated functions.

```python
@command("walk")
def walk(terrain: str = "mixed", /, *, steps: Annotated[int, domains.STEPS] = 60, video: Video) -> None:
    '''Simulate a walk.

    Walk:
        steps: End after this many steps.
    '''
```

Positional-only parameters become arguments, the others options: of a `bool`, or of `Annotated[type, valid]`, where
`valid` is a domain or a type of click's. A parameter whose type is a dataclass stands for an option of
each of its fields, and `Annotated[Given, options]` for a list of options. Docstrings hold the help of the options,
under headings that are the sections of the help. A function receives the options that were given; for the others the
signature or the dataclass has defaults, which the help shows.
"""

from __future__ import annotations

import inspect
import re
import shlex
from collections.abc import Callable, Container, Iterable
from dataclasses import is_dataclass
from functools import cache
from pathlib import Path
from types import NoneType
from typing import Annotated, Any, TypeVar, get_args, get_origin, get_type_hints

import click

from mjbiped.errors import InputError, shown
from mjbiped.exchange import MODULES, check_format
from mjbiped.utils.domains import Count, Domain, Ends, Words, parse_number
from mjbiped.utils.files import check_writable

_ENTRY = re.compile(r"^(\w[\w ]*):$|^ {4}(\w+): (.+(?:\n {8}.+)*)", re.MULTILINE)
_SECTION = re.compile(r"\n\w[\w ]*:\n(?: {4}\w+: .+\n?(?: {8}.+\n?)*)+")

Owner = TypeVar("Owner", bound=Any)


class Option(click.Option):
    """An option in a section of a command's help.

    Attributes:
        section: Heading of the section.
    """

    section = "Options"


class Given(dict[str, Any]):
    """Options that were given on the command line, by name; what is left out is for others to choose."""

    def take(self, names: Iterable[str]) -> dict[str, Any]:
        """Remove the options of some names, and return them."""
        return {name: self.pop(name) for name in names if name in self}

    def refuse(self, names: Container[str], owner: str, chosen: str) -> None:
        """Refuse options that belong to something other than what was chosen.

        Raises:
            click.UsageError: One of them is given.
        """
        for name, value in self.items():
            if name in names:
                word = f"--{'no-' if value is False else ''}{name.replace('_', '-')}"
                raise click.UsageError(f"{word} is for {owner}; {chosen} has no such thing.")


class Command(click.Command):
    """A command whose help lists its options by section, in the order in which the sections first occur."""

    def __init__(self, name: str, function: Callable[..., None]) -> None:
        """Make the command of a function."""
        self.groups: dict[str, tuple[Callable[..., Any], list[Option]]] = {}
        hints, texts = _described(function)
        parameters: list[click.Parameter] = []
        for each in inspect.signature(function).parameters.values():
            kind, *valid = _parts(hints[each.name])
            grouped = kind is Given or is_dataclass(kind)
            if each.kind is each.POSITIONAL_ONLY:
                parameters.append(_argument(each, hints[each.name]))
            elif grouped:
                self.groups[each.name] = kind, valid[0] if valid else options_of(kind)
                parameters += self.groups[each.name][1]
            else:
                parameters.append(_option(each.name, hints[each.name], each.default, *texts[each.name]))
        text = _SECTION.sub("", inspect.cleandoc(str(function.__doc__)))
        super().__init__(name, callback=function, params=parameters, help=text)

    def parse_args(self, ctx: click.Context, args: list[str]) -> list[str]:
        """Read the words of the command line, and keep them as `ctx.obj`: records say how they were made."""
        ctx.obj = shlex.join(["mjbiped", str(ctx.info_name), *args])
        return super().parse_args(ctx, args)

    def invoke(self, ctx: click.Context) -> object:
        """Run the command."""
        arguments = [ctx.params.pop(str(each.name)) for each in self.params if isinstance(each, click.Argument)]
        written = click.core.ParameterSource.COMMANDLINE
        given = Given(each for each in ctx.params.items() if ctx.get_parameter_source(each[0]) is written)
        named: dict[str, Any] = {
            name: kind(**given.take([str(each.name) for each in options]))
            for name, (kind, options) in self.groups.items()
        }
        run: Any = self.callback
        return ctx.invoke(run, *arguments, **named, **given)

    def format_options(self, ctx: click.Context, formatter: click.HelpFormatter) -> None:
        """Write the options into the help, one list per section."""
        sections: dict[str, list[tuple[str, str]]] = {}
        for parameter in self.get_params(ctx):
            record = parameter.get_help_record(ctx)
            if record is not None and isinstance(parameter, click.Option):
                sections.setdefault(getattr(parameter, "section", Option.section), []).append(record)
        for section, records in sections.items():
            with formatter.section(section):
                formatter.write_dl(records)


def command(name: str) -> Callable[[Callable[..., None]], Command]:
    """Make a command of the decorated function."""
    return lambda function: Command(name, function)


def filled(**words: object) -> Callable[[Owner], Owner]:
    """Write words into the braces of a docstring."""

    def fill(owner: Owner) -> Owner:
        owner.__doc__ = str(owner.__doc__).format(**words)
        return owner

    return fill


class Choice(click.ParamType):  # type: ignore[type-arg]  # generic in the latest click alone
    """Type of an option whose value a function reads.

    Attributes:
        metavar: Placeholder of a value in the help.
        read: Function that converts the given text; it raises an `InputError` to refuse it.
        expected: Description of a valid value, for the message; if empty, the message is the error's own.
    """

    def __init__(self, metavar: str, read: Callable[[Any], object] = str, expected: str = "") -> None:
        """Set the attributes."""
        self.name = self.metavar = metavar
        self.read, self.expected = read, expected

    def convert(self, value: object, param: click.Parameter | None, ctx: click.Context | None) -> object:
        """Read a value."""
        try:
            return self.read(value)
        except InputError as error:
            self.fail(f"{shown(value)}; expected {self.expected}." if self.expected else f"{error}.", param, ctx)


def number(text: str, domain: Domain | Count) -> Any:
    """Read a number from a text, and check it against its domain."""
    return domain.check("", parse_number(text))


def quantity(valid: Any, *, optional: bool) -> Any:
    """Return the type of an option whose values are in a domain, or 'none' where that is allowed.

    Args:
        valid: A domain; a type of click's is returned as it is.
        optional: Whether 'none' is allowed.
    """
    if isinstance(valid, Words):
        return click.Choice(valid.valid)
    if not isinstance(valid, Domain | Count | Ends):
        return valid

    def read(value: object) -> Any:
        if optional and str(value).strip().lower() == "none":
            return None
        if not isinstance(value, str):
            return valid.check("", value)
        numbers = [parse_number(part) for part in value.split(",")]
        return valid.check("", numbers if len(numbers) > 1 else numbers[0])

    none = ("|none", ", or 'none'") if optional else ("", "")
    return Choice(_METAVARS[type(valid)] + none[0], read, valid.words + none[1])


_METAVARS = {Domain: "X", Count: "N", Ends: "X[,X]"}


def span(domain: Domain) -> Choice:
    """Return the type of two numbers in a domain, the first below the second, such as "0.8..1.6"."""

    def read(value: str) -> tuple[float, float]:
        low, high = (number(part, domain) for part in pair(value, ".."))
        if not low < high:
            raise InputError("wrong order")
        return low, high

    return Choice("LOW..HIGH", read, f"two numbers LOW..HIGH, {domain}, the first below the second, as 0.8..1.6")


def output(*suffixes: str) -> Choice:
    """Return the type of a file to write or replace, with one of these suffixes, in a folder that can be written to."""
    return Choice("FILE", lambda value: to_write(Path(value), *suffixes))


def to_write(path: Path, *suffixes: str) -> Path:
    """Return the path of a file to write, as `output` describes it.

    Raises:
        InputError: The file cannot be written, or needs an extra that is not installed.
    """
    named = shown(str(path))
    if path.suffix not in suffixes:
        raise InputError(f"{named} must end in {' or '.join(suffixes)}")
    try:
        check_writable(path)
    except OSError as error:
        missing = isinstance(error, FileNotFoundError | NotADirectoryError) and not path.parent.is_dir()
        reason = f"there is no folder {shown(str(path.parent))}; make it first" if missing else error.strerror
        raise InputError(f"{named} cannot be written: {reason}") from error
    return check_format(path) if path.suffix in MODULES else path


def pair(value: str, separator: str = "=") -> tuple[str, str]:
    """Split a text such as "ratio=-2" at its separator into two texts, neither of them empty."""
    first, _, second = value.partition(separator)
    if not first.strip() or not second.strip():
        raise InputError("one part is missing")
    return first.strip(), second


@cache
def _described(owner: Any) -> tuple[dict[str, Any], dict[str, tuple[str, str]]]:
    """Types of the parameters of a function or the fields of a class; and headings and texts in its docstring."""
    found, heading = {}, ""
    for each in reversed(getattr(owner, "__mro__", (owner,))):
        for title, name, text in _ENTRY.findall(inspect.cleandoc(each.__doc__ or "")):
            heading = title or heading
            if name:
                found[name] = heading, " ".join(text.split())
    return get_type_hints(owner, include_extras=True), found


def options_of(owner: type, section: str = "", *names: str, **defaults: object) -> list[Option]:
    """Return options that set fields of a dataclass.

    Args:
        owner: The dataclass.
        section: Section of the help, for a class that is not made for the command line, whose texts are cut after
            their first sentence. Unless given, the headings in the docstring are the sections.
        *names: Fields with the defaults that they have there; all unless names or defaults are given.
        **defaults: Other fields, with their defaults.
    """
    (hints, texts), made = _described(owner), []
    usual = {name: getattr(owner, name) for name in (names if names or defaults else texts)}
    for name, default in {**usual, **defaults}.items():
        heading, text = texts[name]
        brief = text.partition(". ")[0].removesuffix(".") + "."
        made.append(_option(name, hints[name], default, section or heading, brief if section else text))
    return made


def _parts(hint: Any) -> tuple[Any, ...]:
    """A type, and what it is annotated with."""
    return get_args(hint) if get_origin(hint) is Annotated else (hint,)


def _argument(parameter: inspect.Parameter, hint: Any) -> click.Argument:
    """The argument of a parameter; a third part of its type is what the help calls it."""
    kind, valid, metavar = (*_parts(hint), None, None)[:3]
    many, required = get_origin(kind) is tuple, parameter.default is parameter.empty
    settings: dict[str, Any] = {} if required else {"default": parameter.default}
    required, nargs = required and not many, -1 if many else 1
    return click.Argument([parameter.name], type=valid, nargs=nargs, required=required, metavar=metavar, **settings)


def _option(name: str, hint: Any, default: Any, section: str, text: str) -> Option:
    """The option of a parameter or a field; a third part of its type is its word, which else is its name."""
    kind, *rest = _parts(hint)
    valid, word = (*rest, name.replace("_", "-"))[:2] if rest else (bool, name.replace("_", "-"))
    if kind is not bool:
        valid = quantity(valid, optional=default is not None and NoneType in get_args(kind))
    shown = default is not None and default is not False and default != ()
    made = Option(
        [f"--{word}/--no-{word}" if default is True else f"--{word}", name],
        type=valid,
        is_flag=kind is bool,
        default=default,
        multiple=default == (),
        show_default=shown,
        metavar=getattr(valid, "metavar", None),
        help=text,
    )
    made.section = section
    return made
