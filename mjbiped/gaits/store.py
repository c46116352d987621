"""Optimised references on disk, so that each is searched for once.

A file is a JSON object under the digest of all that the result depends on: what was asked, the sources of the search,
and the versions of the libraries that it is made with. Its numbers carry a digest of their own; a file that is damaged
counts as none, and is written anew. What cannot be written is searched for again.
"""

from __future__ import annotations

import hashlib
import json
import os
from collections.abc import Mapping, Sequence
from contextlib import suppress
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np
import platformdirs
import scipy

from mjbiped.utils.files import written_whole

_SOURCES = (
    *("bezier.py", "compass_step.py", "kneed_step.py", "optimisation.py"),
    *("../robots/chain.py", "../robots/compass.py", "../robots/kneed.py"),
)


def folder() -> Path:
    """Where references are kept: what the environment variable MJBIPED_CACHE_DIR names, else the user's cache."""
    named = os.environ.get("MJBIPED_CACHE_DIR")
    return Path(named) if named else platformdirs.user_cache_path("mjbiped") / "references"


def load(asked: Mapping[str, Any]) -> list[float] | None:
    """The numbers kept for what is asked, bit by bit as they were saved; None where there are none.

    Args:
        asked: In plain JSON types.
    """
    try:
        kept = json.loads(_file(asked).read_text(encoding="utf-8"))
        numbers = [float(number) for number in kept["numbers"]]
    except (OSError, ValueError, KeyError, TypeError, RecursionError):
        return None
    return numbers if kept.get("sha256") == _digest(numbers) else None


def save(asked: Mapping[str, Any], numbers: Sequence[float]) -> None:
    """Keep numbers for what is asked, where the folder can be written to."""
    kept = {"asked": asked, "numbers": list(numbers), "sha256": _digest(list(numbers))}
    with suppress(OSError):
        path = _file(asked)
        path.parent.mkdir(parents=True, exist_ok=True)
        with written_whole(path) as unfinished:
            unfinished.write_text(json.dumps(kept, indent=1), encoding="utf-8")


def _file(asked: Mapping[str, Any]) -> Path:
    return folder() / f"{_digest([asked, _made_with()])}.json"


@cache
def _made_with() -> list[str]:
    """Digests and versions of what makes a reference."""
    sources = [(Path(__file__).parent / name).read_bytes() for name in _SOURCES]
    return [np.__version__, scipy.__version__, *(hashlib.sha256(source).hexdigest() for source in sources)]


def _digest(value: Any) -> str:
    return hashlib.sha256(json.dumps(value, sort_keys=True).encode()).hexdigest()
