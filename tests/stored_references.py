"""Optimised references that quick tests walk with, found before: the search for all of them takes a minute.

`python tests/stored_references.py` searches for all requests of the file again, and writes what is found into it.
"""

import json
from pathlib import Path
from typing import Any

import numpy as np

from mjbiped.gaits import store
from mjbiped.gaits.optimisation import optimise
from mjbiped.gaits.steps import CompassStep, Goal, KneedStep
from mjbiped.robots.kinds import robot_from
from mjbiped.robots.kneed import KneedBiped

FILE = Path(__file__).with_name("references.json")


def stored() -> list[dict[str, Any]]:
    """The requests, and the numbers that the optimiser chose for each."""
    found: list[dict[str, Any]] = json.loads(FILE.read_text(encoding="utf-8"))
    return found


def request(asked: dict[str, Any]) -> tuple[CompassStep, Goal]:
    """What the optimiser takes."""
    robot = robot_from(asked["robot"])
    step: type[CompassStep] = KneedStep if isinstance(robot, KneedBiped) else CompassStep
    return step(robot), Goal(**asked["goal"])


def put_away() -> None:
    """Put all of them where `find_reference` looks first."""
    for each in stored():
        store.save(each["asked"], {"x": np.array(each["x"])})


if __name__ == "__main__":
    again = [{"asked": each["asked"], "x": optimise(*request(each["asked"])).tolist()} for each in stored()]
    FILE.write_text("\n".join(["[", ",\n".join(map(json.dumps, again)), "]", ""]), encoding="utf-8")
