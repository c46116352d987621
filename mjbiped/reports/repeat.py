"""Repetition of a recorded walk: the Python program that gives bitwise the same record."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import fields

from mjbiped.engines.hybrid.engine import Hybrid
from mjbiped.engines.mujoco.engine import Mujoco
from mjbiped.records.record import Walk

_ENGINES: Mapping[str, type[Mujoco] | type[Hybrid]] = {"mujoco": Mujoco, "hybrid": Hybrid}


def python_of(walk: Walk, record: str) -> str | None:
    """Write a program that repeats the walk.

    Args:
        walk: The record.
        record: Path of the record in the program.

    Returns:
        The program; None if the engine is not one of mjbiped's own.
    """
    settings = walk.settings
    engine = _ENGINES.get(settings["engine"])
    if engine is None:
        return None
    set_here = {each.name: settings[each.name] for each in fields(engine) if each.name in settings}
    rule = "None" if settings["scuffing"] is None else 'mjbiped.ScuffingRule(**settings["scuffing"])'
    source = settings.get("controller_source")
    named = "" if source is None else f', settings["controller_source"], named={source["class"]!r}'
    of_engine = ", ".join(f"{name}={value!r}" for name, value in set_here.items())
    return f"""import mjbiped
from mjbiped.control.registry import controller_from

before = mjbiped.Walk.load({record!r})
settings = before.settings
again = mjbiped.walk(
    controller_from(settings["controller"]{named}),
    before.terrain,
    engine=mjbiped.{engine.__name__}({of_engine}),
    robot=before.robot,
    initial=settings["initial"],
    steps=settings["steps"],
    distance=settings["distance"],
    sample_period=settings["sample_period"],
    scuffing={rule},
    disturbances=mjbiped.Disturbances.from_dict(settings.get("disturbances", {{}})),
)
print(again.summary())
print("the same, bit by bit:", again == before)
"""
