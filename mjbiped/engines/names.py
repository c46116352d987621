"""The engines with their default settings, by their names; each is imported when it is first asked for."""

from __future__ import annotations

from collections.abc import Mapping
from functools import cache
from pkgutil import resolve_name

from mjbiped.engines.base import Engine
from mjbiped.errors import InputError
from mjbiped.utils.domains import known_name

DEFAULT_ENGINE = "mujoco"
ENGINES: Mapping[str, str] = {
    "mujoco": "mjbiped.engines.mujoco.engine:Mujoco",
    "hybrid": "mjbiped.engines.hybrid.engine:Hybrid",
}
"""Where the class of each engine is, as "module:name"."""


def engine_of(engine: str | Engine) -> Engine:
    """Look up an engine by its name; an engine itself is returned as it is.

    Raises:
        InputError: There is no such engine.
    """
    if isinstance(engine, Engine):
        return engine
    if isinstance(engine, type) and issubclass(engine, Engine):
        raise InputError(f"the engine {engine.__name__} is a class; give an object of it, {engine.__name__}()")
    return _with_defaults(known_name("engine", engine, ENGINES))


@cache
def _with_defaults(name: str) -> Engine:
    engine: Engine = resolve_name(ENGINES[name])()
    return engine
