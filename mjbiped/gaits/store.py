"""Gaits on disk, so that each is searched for once.

A file holds NumPy arrays; its name is a digest of all that the result depends on: the request, the sources of the
search, and the versions of the libraries. A damaged file is replaced. Where nothing can be written, every request is a
new search.
"""

from __future__ import annotations

import hashlib
import json
import os
from collections.abc import Callable, Mapping
from contextlib import suppress
from functools import cache, lru_cache
from pathlib import Path
from typing import Any

import numpy as np
import platformdirs
import scipy

from mjbiped.robots.robot import Robot
from mjbiped.utils.files import written_whole


def folder() -> Path:
    """Return the folder of stored gaits: the environment variable MJBIPED_CACHE_DIR, or one in the user's cache."""
    named = os.environ.get("MJBIPED_CACHE_DIR")
    return Path(named) if named else platformdirs.user_cache_path("mjbiped") / "references"


def load(asked: Mapping[str, object]) -> dict[str, Any] | None:
    """Load the numbers and arrays stored for a request, bitwise as they were saved; None where there are none.

    Args:
        asked: What the result was searched for, in plain JSON types.
    """
    try:
        with _file(asked).open("rb") as file, np.load(file) as kept:
            return {name: kept[name] if kept[name].ndim else kept[name].item() for name in kept.files}
    except Exception:  # a damaged file can raise nearly anything
        return None


def save(asked: Mapping[str, object], found: Mapping[str, Any]) -> None:
    """Store numbers and arrays for a request, if the folder can be written to."""
    with suppress(OSError):
        path = _file(asked)
        path.parent.mkdir(parents=True, exist_ok=True)
        with written_whole(path) as unfinished:
            np.savez(unfinished, **found)


def kept(asked: Mapping[str, object], search: Callable[[], dict[str, Any]]) -> dict[str, Any]:
    """Return what is stored for a request, or what a search finds, which is then stored."""
    found = load(asked)
    if found is None:
        found = search()
        save(asked, found)
    return found


@lru_cache(maxsize=256)
def passive(kind: Any, robot: Robot, slope: float, search: Callable[[Any, float], dict[str, Any]]) -> Any:
    """Return a passive gait, from the store or from a search.

    Args:
        kind: Class of the gait.
        robot: The robot that walks.
        slope: Slope of the plane, rad.
        search: What finds the attributes of the gait by name.

    Raises:
        GaitError: The search finds none.
    """
    asked = {"passive": robot.mechanism.to_dict(), "slope": slope}
    return kind(robot=robot, slope=slope, **with_tables(kept(asked, lambda: search(robot.mechanism, slope))))


def with_tables(found: Mapping[str, Any]) -> dict[str, Any]:
    """Return attributes of a gait as they are stored, with its tables as lists under their name in the gait."""
    names = [name for name in ("table", "bent", "straight") if name in found]
    others = {name: value for name, value in found.items() if name not in names}
    return {**others, "tables": tuple(np.asarray(found[name]).tolist() for name in names)}


def _file(asked: Mapping[str, object]) -> Path:
    text = json.dumps([asked, _made_with()], sort_keys=True)
    return folder() / f"{hashlib.sha256(text.encode()).hexdigest()}.npz"


@cache
def _made_with() -> list[str]:
    """Return the versions of the libraries and the digests of the sources on which a search depends."""
    package = Path(__file__).parents[1]
    sources = [source for room in ("gaits", "robots", "dynamics") for source in package.glob(f"{room}/*.py")]
    sources.append(package / "numerics" / "trigonometry.py")
    digests = [hashlib.sha256(source.read_bytes()).hexdigest() for source in sorted(sources)]
    return [np.__version__, scipy.__version__, *digests]
