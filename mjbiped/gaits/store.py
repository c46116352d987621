"""Gaits on disk, so that each is searched for once.

A file holds NumPy arrays under the digest of all that the result depends on: what was asked, the sources of the search,
and the versions of the libraries that it is made with. A damaged file counts as none, and is written anew. What cannot
be written is searched for again.
"""

from __future__ import annotations

import hashlib
import json
import os
from collections.abc import Callable, Mapping
from contextlib import suppress
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np
import platformdirs
import scipy

from mjbiped.robots.robot import Robot
from mjbiped.utils.files import written_whole

_REPEATS = 1e-7  # error of the rates after the impact, sqrt(g/l): searches are good to 1e-9 and better


def folder() -> Path:
    """The folder that the environment variable MJBIPED_CACHE_DIR names, else one in the user's cache."""
    named = os.environ.get("MJBIPED_CACHE_DIR")
    return Path(named) if named else platformdirs.user_cache_path("mjbiped") / "references"


def load(asked: Mapping[str, Any]) -> dict[str, Any] | None:
    """The numbers and arrays kept for what is asked, bit by bit as they were saved; None where there are none.

    Args:
        asked: What the result was searched for, in plain JSON types.
    """
    try:
        with _file(asked).open("rb") as file, np.load(file) as kept:
            return {name: kept[name] if kept[name].ndim else kept[name].item() for name in kept.files}
    except Exception:  # a damaged file can raise nearly anything
        return None


def save(asked: Mapping[str, Any], found: Mapping[str, Any]) -> None:
    """Keep numbers and arrays for what is asked, where the folder can be written to."""
    with suppress(OSError):
        path = _file(asked)
        path.parent.mkdir(parents=True, exist_ok=True)
        with written_whole(path) as unfinished:
            np.savez(unfinished, **found)


def passive(robot: Robot, slope: float, search: Callable[[Any, float], dict[str, Any]]) -> dict[str, Any]:
    """The attributes of a passive gait by their names, kept or searched for.

    Args:
        robot: The robot that walks.
        slope: Slope of the plane, rad.
        search: What finds the gait.

    Raises:
        GaitError: The search finds none.
    """
    asked = {"passive": robot.to_dict(), "slope": slope}
    kept = load(asked)
    if kept is None or not _repeats(robot, kept):
        kept = search(robot, slope)
        save(asked, kept)
    return kept


def _repeats(robot: Robot, gait: Mapping[str, Any]) -> bool:
    """Whether the impact leads from a gait's end to its start."""
    half = len(robot.angles)
    rates = robot.rates_after_touchdown(gait["end"][:half], gait["end"][half:])
    return bool(np.abs(rates - gait["start"][half:]).max() < _REPEATS * np.sqrt(robot.gravity / robot.leg_length))


def _file(asked: Mapping[str, Any]) -> Path:
    text = json.dumps([asked, _made_with()], sort_keys=True)
    return folder() / f"{hashlib.sha256(text.encode()).hexdigest()}.npz"


@cache
def _made_with() -> list[str]:
    """Digests and versions of what makes a gait."""
    here = Path(__file__).parent
    sources = [
        *here.glob("*.py"),
        *here.with_name("robots").glob("*.py"),
        here.with_name("numerics") / "trigonometry.py",
    ]
    digests = [hashlib.sha256(source.read_bytes()).hexdigest() for source in sorted(sources)]
    return [np.__version__, scipy.__version__, *digests]
