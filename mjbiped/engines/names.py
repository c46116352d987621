"""The engines with their default settings, by their names."""

from __future__ import annotations

from mjbiped.engines.base import Engine
from mjbiped.engines.hybrid.engine import Hybrid
from mjbiped.engines.mujoco.engine import Mujoco
from mjbiped.errors import InputError
from mjbiped.utils.domains import known_name

DEFAULT_ENGINE = "mujoco"
ENGINES: dict[str, Engine] = {"mujoco": Mujoco(), "hybrid": Hybrid()}


def engine_of(engine: str | Engine) -> Engine:
    """Look up an engine by its name; an engine itself is returned as it is.

    Raises:
        InputError: There is no such engine.
    """
    if isinstance(engine, Engine):
        return engine
    if isinstance(engine, type) and issubclass(engine, Engine):
        raise InputError(f"the engine {engine.__name__} is a class; give an object of it, {engine.__name__}()")
    return ENGINES[known_name("engine", engine, ENGINES)]
