"""What a walk's numbers depend on beside its inputs: the sources of physics and control laws."""

from __future__ import annotations

import hashlib
from functools import lru_cache
from pathlib import Path

import controllers
from mjbiped import scene

_NO_NUMBERS = ("cli", "plot", "reports", "video", "caption", "workers")
"""Modules whose names begin so change no number."""


@lru_cache(maxsize=1)
def sources() -> str:
    """Digest of all source files that a walk's numbers can depend on: a mended engine is another engine."""
    package, laws = Path(scene.__file__).parent, Path(controllers.__file__).parent
    files = [file for file in package.glob("*.py") if not file.name.startswith(_NO_NUMBERS)]
    files += [*laws.glob("*.py"), *scene.models_folder().glob("*.xml"), *package.glob("*/cell.py")]
    digest = hashlib.sha256()
    for file in sorted(files, key=lambda path: (path.parent.name, path.name)):
        digest.update(f"{file.parent.name}/{file.name}\n".encode() + file.read_bytes())
    return digest.hexdigest()
