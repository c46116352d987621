"""What a walk's numbers depend on beside its inputs: the sources of physics and control laws."""

from __future__ import annotations

import hashlib
from collections.abc import Iterator
from functools import lru_cache
from pathlib import Path

import controllers
from mjbiped import errors
from mjbiped.engines.mujoco import scene

_NO_NUMBERS = ("cli", "plotting", "rendering", "reproduction", "sweeps")
"""Packages that change no number of a walk; but what their files `cell.py` say of one does."""


@lru_cache(maxsize=1)
def sources() -> str:
    """Digest of all source files that a walk's numbers can depend on: a mended engine is another engine."""
    return digest(Path(errors.__file__).parent, Path(controllers.__file__).parent, scene.models_folder())


def digest(package: Path, laws: Path, models: Path) -> str:
    """Digest of the files of these folders that numbers can depend on, by their contents and their places."""
    files = [(package, file) for file in _of_numbers(package)]
    files += [(laws, file) for file in laws.rglob("*.py")] + [(models, file) for file in models.rglob("*.xml")]
    found = hashlib.sha256()
    for name, file in sorted((f"{folder.name}/{file.relative_to(folder).as_posix()}", file) for folder, file in files):
        found.update(f"{name}\n".encode() + hashlib.sha256(file.read_bytes()).digest())
    return found.hexdigest()


def _of_numbers(package: Path) -> Iterator[Path]:
    for file in package.rglob("*.py"):
        room = file.relative_to(package).parts[0]
        if room not in _NO_NUMBERS or file.name == "cell.py":
            yield file
