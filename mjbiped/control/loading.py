"""Load a user's own controllers by the names of their classes: `spread.py:HipSpread`, or `package.module:Class`.

Nothing has to be installed or registered. A file is loaded by itself, under a name that no other module has, so that
it may be called like a package of this project. It can import other files of its folder.

The fields of a controller's dataclass are its settings, with their defaults and valid types.
"""

from __future__ import annotations

import hashlib
import importlib
import importlib.util
import inspect
import math
import os
import re
import sys
import types
from collections.abc import Mapping
from contextlib import redirect_stdout, suppress
from dataclasses import MISSING, fields, is_dataclass
from numbers import Integral
from pathlib import Path
from types import ModuleType
from typing import Any, Literal, Union, get_args, get_origin, get_type_hints

from mjbiped.control.controller import Controller
from mjbiped.errors import InputError, explained, place_of, prefixed, shown
from mjbiped.utils.domains import as_float, check_text, known_name, parse_number
from mjbiped.utils.files import read_bytes
from mjbiped.utils.packages import hidden_laws

FORMS = "FILE.py:CLASS or PACKAGE.MODULE:CLASS"
FILES = (".onnx",)
"""Suffixes of files that describe a controller."""

_loaded: dict[Path, tuple[bytes, ModuleType]] = {}
_named: dict[type, dict[str, str]] = {}


def is_reference(name: object) -> bool:
    """Tell whether a controller's name is a reference to a class in a file or a module."""
    return isinstance(name, str) and (":" in name or name.endswith(".py"))


def file_of(name: str) -> tuple[str, str]:
    """Split NAME:FILE, a registered controller that a file describes; of all other names the second part is empty."""
    kind, _, file = name.partition(":")
    return (kind, file) if file.endswith(FILES) else (name, "")


def located(reference: str, folder: Path) -> str:
    """Resolve a reference's file against a folder; all other names stay as they are.

    Modules are looked for in the working directory, and among the installed ones.
    """
    if not is_reference(reference):
        return reference
    kind, file = file_of(reference)
    if file:
        return f"{kind}:{_whole(folder / Path(file).expanduser())}"
    place, name = _parts(reference)
    return f"{_whole(folder / Path(place).expanduser())}:{name}" if _is_file(place) else reference


def own_class(reference: str) -> type[Controller]:
    """Load the class that a reference names; an unchanged file or module is loaded once.

    Raises:
        InputError: There is no such file, module or class, loading it fails, or the class is no controller.
    """
    place, name = _parts(check_text("the controller's place", reference))
    module = _module(place)
    own = [each for each in vars(module).values() if isinstance(each, type) and each.__module__ == module.__name__]
    valid = [each.__name__ for each in own if issubclass(each, Controller) and not inspect.isabstract(each)]
    if not name:
        raise InputError(f"{shown(reference)} names no class; give it as {place}:{valid[0] if valid else 'CLASS'}")
    found = vars(module).get(name) or known_name(f"controller in {place}", name, valid)
    if not isinstance(found, type) or not issubclass(found, Controller):
        raise InputError(
            f"{name} in {place} does not derive from controllers.Controller; a controller begins with "
            f"`from controllers import Controller` and `class {name}(Controller):`"
        )
    if lacking := sorted(found.__abstractmethods__):
        raise InputError(
            f"{name} in {place} lacks {', '.join(lacking)}; a controller needs a method torque(self, memory, t, q, dq)"
        )
    if found not in _named:
        _named[found] = {"class": reference, "sha256": digest_of(reference)}
    return found


def recorded_class(source: Mapping[str, str], named: str | None) -> type[Controller]:
    """Load the class that a record's controller came from, if the user names it and its source is unchanged.

    Args:
        source: Reference and digest in the record, as `source_of` returns them; nothing is loaded from there.
        named: Reference to the class, given by the user; None if the user named none.

    Raises:
        InputError: Nothing was named, another class was, or its sources have changed since then.
    """
    recorded = shown(source["class"])
    if named is None:
        raise InputError(
            f"the record's controller is {recorded}, somebody's own code, and no record decides what code is loaded; "
            f"if you trust it, name it yourself: --controller {FORMS}, or controller_from(..., named=...)"
        )
    if not is_reference(named) or _parts(named)[1] != _parts(source["class"])[1]:
        raise InputError(f"the record's controller is {recorded}; {shown(named)} is another class")
    if digest_of(named) != source["sha256"]:
        raise InputError(f"the record's controller is {recorded}, and the source of {shown(named)} is another one")
    return own_class(named)


def source_of(kind: type) -> dict[str, str] | None:
    """Return the reference to a class loaded by `own_class` and the digest of its sources, for the record."""
    return _named.get(kind)


def digest_of(reference: str) -> str:
    """Return the digest of the file that describes a controller, or that its class stands in, without its imports.

    Raises:
        InputError: There is no such file or module.
    """
    if file := file_of(reference)[1]:
        with prefixed(f"{shown(file)}: "):
            return hashlib.sha256(read_bytes(Path(file).expanduser())).hexdigest()
    place, _ = _parts(reference)
    if _is_file(place):
        return hashlib.sha256(_read(place)[1]).hexdigest()
    _import_from(Path.cwd())
    with suppress(ImportError):
        if (spec := importlib.util.find_spec(place)) and spec.origin:
            return hashlib.sha256(read_bytes(Path(spec.origin))).hexdigest()
    raise InputError(f"there is no module {shown(place)} to take a controller from")


def _parts(reference: str) -> tuple[str, str]:
    """Return a file's path or a module's name, and the name of the class, which is empty where only a file is named."""
    place, _, name = (f"{reference}:" if reference.endswith(".py") else reference).rpartition(":")
    if not place:
        raise InputError(f"the controller {shown(reference)} names no file or module; expected {FORMS}")
    return place, name


def _is_file(place: str) -> bool:
    return place.endswith(".py") or "/" in place or os.sep in place


def _module(place: str) -> ModuleType:
    """Load a file or import a module; see `own_class`."""
    path, text = _read(place) if _is_file(place) else (None, b"")
    if path is None and not all(part.isidentifier() for part in place.split(".")):
        raise InputError(f"{shown(place)} is no name of a module; expected {FORMS}")
    _import_from(path.parent if path else Path.cwd())
    try:
        with redirect_stdout(sys.stderr):  # a command's own output may be for machines
            return _executed(path, text) if path else importlib.import_module(place)
    except (Exception, SystemExit) as error:
        missing = error.name if isinstance(error, ModuleNotFoundError) and path is None else None
        if missing is not None and f"{place}.".startswith(f"{missing}."):
            raise InputError(
                f"there is no module {shown(missing)} to take a controller from, neither in {Path.cwd()} nor among "
                "the installed ones; a file is named with its suffix, as spread.py:HipSpread"
            ) from error
        hint = f"; {hidden}" if isinstance(error, ImportError) and (hidden := hidden_laws()) else ""
        raise InputError(
            f"{place} cannot be loaded: {explained(error)}{place_of(error, path or Path())}{hint}"
        ) from error


def _executed(path: Path, text: bytes) -> ModuleType:
    """Make a module of a file's text, unless there is one already.

    Importlib would take what it has compiled before for a file of the same size and second.
    """
    if path in _loaded and _loaded[path][0] == text:
        return _loaded[path][1]
    # the name tells files of different folders apart, and stays when the file changes: machine code is kept by it
    name = f"{re.sub(r'[^0-9A-Za-z_]', '_', path.stem)}_{hashlib.sha256(str(path).encode()).hexdigest()[:8]}"
    module = sys.modules[name] = ModuleType(name)  # dataclasses look for it there
    module.__file__ = str(path)
    try:
        exec(compile(text, str(path), "exec"), vars(module))
    except BaseException:
        del sys.modules[name]
        raise
    _loaded[path] = text, module
    return module


def _whole(path: Path) -> Path:
    """Make a path absolute but keep links: files in the folder of a link can be imported, not those of its target."""
    return Path(os.path.normpath(Path.cwd() / path))


def _read(place: str) -> tuple[Path, bytes]:
    path = _whole(Path(place).expanduser())
    if path.suffix != ".py":
        raise InputError(f"the controller's file {shown(place)} must end in .py; expected {FORMS}")
    try:
        return path, read_bytes(path)
    except InputError as error:
        raise InputError(f"the controller's file {shown(place)} (in {path.parent}): {error}") from error


def _import_from(folder: Path) -> None:
    """Make modules of a folder importable, last in the search path, so that none of them hides a library."""
    if str(folder) not in sys.path:
        sys.path.append(str(folder))


REQUIRED = MISSING
"""Stands for the default of a setting that has none."""

_WORDS = {
    bool: "true or false",
    int: "a whole number",
    float: "a finite number",
    str: "a text",
    tuple: "numbers with commas between them",
    types.NoneType: "none",
}
_READ = {"none": None, "true": True, "false": False}


def fields_of(kind: type) -> dict[str, Any]:
    """Return the fields of a controller's dataclass that its constructor takes, by name, with their defaults.

    The default of a field that has none is `REQUIRED`. Other classes have no fields.
    """
    given = [field for field in fields(kind) if field.init] if is_dataclass(kind) else []
    return {
        field.name: field.default if field.default_factory is MISSING else field.default_factory() for field in given
    }


def shown_defaults(settings: Mapping[str, object]) -> str:
    """Write settings with their defaults for a message."""
    return ", ".join(f"{key} (needed)" if value is REQUIRED else f"{key}={value}" for key, value in settings.items())


def value_of(kind: type, name: str, text: str) -> Any:
    """Read the value of a field from a text on the command line, by the field's type.

    Raises:
        InputError: The text is no value of the field's type.
    """
    text, number = text.strip(), parse_number(text.strip())
    word = text.lower()
    meanings = [*([_READ[word]] if word in _READ else []), *([] if number is None else [number]), text]
    wanted = _kinds(kind, name)
    return checked(kind, name, next((each for each in meanings if _fits(each, wanted)), text))


def checked(kind: type, name: str, value: object) -> Any:
    """Check a value against a field's type; a whole number also passes where a float is asked for.

    The class itself checks what the type does not say, such as a gain's domain.

    Raises:
        InputError: The value is of another type.
    """
    wanted = _kinds(kind, name)
    if value == "none" and types.NoneType in wanted and str not in wanted:
        return None
    if isinstance(value, str) and any(get_origin(each) is tuple for each in wanted):
        value = _several(value) or value
    if _fits(value, wanted):
        return as_float(value) if isinstance(value, Integral) and float in wanted and int not in wanted else value
    words = " or ".join(
        "one of " + ", ".join(map(str, get_args(each)))
        if get_origin(each) is Literal
        else _WORDS.get(get_origin(each) or each, f"a {getattr(each, '__name__', each)}, which cannot be given here")
        for each in wanted
    )
    raise InputError(f"{name} = {shown(value)}: must be {words}, as declared in {kind.__name__}")


def _several(text: str) -> tuple[float, ...]:
    """Read numbers with commas between them; none from any other text."""
    numbers = tuple(number for part in text.split(",") if (number := parse_number(part.strip())) is not None)
    return numbers if len(numbers) == text.count(",") + 1 > 1 else ()


def _kinds(kind: type, name: str) -> tuple[Any, ...]:
    """Return the types that a field takes; none where they are not known."""
    try:
        hint = get_type_hints(kind).get(name, Any)
    except Exception:  # names that stand only where a type checker sees them
        return ()
    kinds = get_args(hint) if get_origin(hint) in (Union, types.UnionType) else (hint,)
    return () if Any in kinds else kinds


def _fits(value: object, wanted: tuple[object, ...]) -> bool:
    """Whether a value is of one of some types, or of any type where none is known."""

    def fits(kind: object) -> bool:
        if get_origin(kind) is Literal:
            return value in get_args(kind)
        if get_origin(kind) is tuple:
            return type(value) is tuple and all(_fits(each, get_args(kind)[:1]) for each in value)
        if kind is float:
            return math.isfinite(as_float(value))
        if kind is int:
            return isinstance(value, Integral) and not isinstance(value, bool)
        return type(value) is kind

    return not wanted or any(map(fits, wanted))
