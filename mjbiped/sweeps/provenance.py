"""What a walk's numbers depend on beside its inputs: the sources of physics and control laws."""

from __future__ import annotations

import hashlib
from collections.abc import Sequence
from functools import lru_cache
from importlib.util import find_spec
from pathlib import Path

from mjbiped import errors
from mjbiped.control.registry import registered
from mjbiped.engines.mujoco import scene

_NO_NUMBERS = ("cli", "plotting", "rendering", "reports", "reproduction", "sweeps")
"""Packages that change no number of a walk; but what their files `cell.py` say of one does."""


@lru_cache(maxsize=1)
def sources() -> str:
    """Digest of all source files that a walk's numbers can depend on: a mended engine is another engine."""
    return digest(Path(errors.__file__).parent, law_folders(), scene.models_folder())


def law_folders() -> list[Path]:
    """The packages that register controllers, and the modules that are in no package."""
    packages = {entry.module.partition(".")[0] for entry in registered().values()}
    specs = [spec for spec in map(find_spec, sorted(packages)) if spec]
    return [Path(place) for spec in specs for place in spec.submodule_search_locations or (spec.origin,) if place]


def digest(package: Path, laws: Sequence[Path], models: Path) -> str:
    """Digest of all files of these places that numbers can depend on, by their contents and their places."""
    files = [(package, file) for file in package.rglob("*.py") if _is_of_numbers(file.relative_to(package))]
    files += [(place, file) for place in laws for file in ([place] if place.is_file() else place.rglob("*.py"))]
    files += [(models, file) for file in models.rglob("*.xml")]
    found = hashlib.sha256()
    for name, file in sorted((f"{folder.name}/{file.relative_to(folder).as_posix()}", file) for folder, file in files):
        found.update(f"{name}\n".encode() + hashlib.sha256(file.read_bytes()).digest())
    return found.hexdigest()


def _is_of_numbers(file: Path) -> bool:
    return file.parts[0] not in _NO_NUMBERS or file.name == "cell.py"
