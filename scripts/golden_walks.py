"""Make `tests/golden_walks.npz` anew: the columns of all golden walks, and how far each of them moves elsewhere.

Rounding decides now and then whether an integration step of the hybrid engine is rejected, after which peaks of forces
are taken at other moments: so all walks are walked with gravities that differ by their last bits. They also move where
gaits and references are searched for with the linear algebra of another processor, since a search then ends elsewhere
within its own tolerance: so they are walked with the routines of three processors, each in a process of its own.

    PYTHONPATH=tests python -m scripts.golden_walks
"""

import os
import subprocess
import sys
import tempfile
from pathlib import Path
from typing import Any

import golden_walks
import numpy as np
import stored_references
from numpy.typing import NDArray

KERNELS = ("Prescott", "Haswell", "")
"""Processors whose routines OpenBLAS takes in place of this one's; the last is this one."""


def walk_all(heavier: float = 0.0) -> dict[str, NDArray[Any]]:
    """The columns of all walks, after the number of each."""
    walks = (golden_walks.kept(golden_walks.walked(case, heavier=heavier)) for case in golden_walks.CASES)
    return {f"{number}/{name}": column for number, walk in enumerate(walks) for name, column in walk.items()}


def walked_elsewhere(kernel: str, folder: Path) -> dict[str, NDArray[Any]]:
    """All walks, with gaits searched for by the routines of another processor."""
    made = folder / f"{kernel}.npz"
    terms = {"OPENBLAS_CORETYPE": kernel, "MJBIPED_CACHE_DIR": str(folder / f"gaits {kernel}")}
    subprocess.run([sys.executable, "-m", "scripts.golden_walks", made], env={**os.environ, **terms}, check=True)
    with np.load(made) as file:
        return dict(file)


def moved(walks: dict[str, NDArray[Any]], others: list[dict[str, NDArray[Any]]]) -> dict[str, NDArray[Any]]:
    """How far each column of walks moves in others."""
    found = {}
    for name, column in walks.items():
        if column.dtype.kind == "f":
            there = [other[name] for other in others if other[name].shape == column.shape]
            finite = [np.isfinite(each) & np.isfinite(column) for each in there]
            apart = [
                np.abs(each - column).max(initial=0.0, where=both) for each, both in zip(there, finite, strict=True)
            ]
            found[name.replace("/", "/moved ", 1)] = np.array(max(apart, default=0.0))
    return found


def main(path: str = "") -> None:
    """Make the file anew, or walk for its tolerances into another file."""
    stored_references.put_away()
    here = walk_all()
    if path:
        np.savez(path, allow_pickle=False, **here)
        return
    others = [walk_all(bits * np.finfo(float).eps) for bits in (-8.0, -4.0, 4.0, 8.0)]
    with tempfile.TemporaryDirectory() as folder:
        others += [walked_elsewhere(kernel, Path(folder)) for kernel in KERNELS]
    np.savez_compressed(golden_walks.FILE, allow_pickle=False, **here, **moved(here, others))


if __name__ == "__main__":
    main(*sys.argv[1:])
