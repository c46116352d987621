"""What a training has come to, as a file: the policy, and all returns, from which the training goes on bitwise."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, fields
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from mjbiped.errors import InputError, RecordError
from mjbiped.records.arrays import NUMBERS, read_arrays
from mjbiped.utils.files import saved
from scripts.learning.rollouts import WEIGHTS, Array

LAST = 10
"""Generations whose mean says what a training has reached: one alone has four grounds, on which returns vary."""


_WHAT = "policy that scripts.learning.train wrote"
_FLAG, (_FLOAT, _WHOLE) = np.dtype(np.bool_), NUMBERS


@dataclass(frozen=True)
class Checkpoint:
    """A training after so many generations.

    Attributes:
        residual: Whether the policy's torques are added to the adaptive controller's.
        seed: Of the training.
        weights: The policy, the mean of CMA-ES's distribution, shape `WEIGHTS`.
        returns: Of the population, shape (generations, population, grounds).
        mean_returns: Of the distribution's mean before each generation, shape (generations, grounds).
        steps: Control periods that robots had walked after each generation.
        wall: Time that the training had taken by then, s.
        processor: Processor time of all threads by then, s.
    """

    residual: bool
    seed: int
    weights: Array
    returns: Array
    mean_returns: Array
    steps: Array
    wall: Array
    processor: Array

    @property
    def generations(self) -> int:
        """How many there are."""
        return len(self.returns)

    @property
    def last_return(self) -> float:
        """Mean over the last `LAST` generations and their grounds."""
        return float(self.mean_returns[-LAST:].mean())

    def save(self, path: Path) -> None:
        """Write the file; it appears whole or not at all.

        Raises:
            RecordError: It cannot be written.
        """
        with saved(path) as unfinished:
            np.savez_compressed(unfinished, **{field.name: getattr(self, field.name) for field in fields(self)})

    @classmethod
    def load(cls, path: Path) -> Checkpoint:
        """Read it.

        Raises:
            InputError: There is no such file, or it is none that a training wrote.
        """
        if not path.exists():
            raise InputError(
                f"there is no policy {path}; train one: python -m scripts.learning.train --task residual, or free"
            )
        try:
            read = read_arrays(path, _WHAT, (*NUMBERS, _FLAG))
        except RecordError as error:
            raise InputError(str(error)) from error
        missing = [field.name for field in fields(cls) if field.name not in read]
        if missing:
            raise InputError(f"{path} is no {_WHAT}: it lacks {', '.join(missing)}")
        _check(path, read)
        given: dict[str, Any] = {field.name: read[field.name] for field in fields(cls)}
        return cls(**{**given, "residual": bool(read["residual"]), "seed": int(read["seed"])})


def _check(path: Path, read: Mapping[str, NDArray[Any]]) -> None:
    """Refuse arrays that are not those of a checkpoint.

    Raises:
        InputError: One has another type or shape, or holds what is no finite number.
    """
    returns = read["returns"].shape
    if len(returns) != 3 or 0 in returns:
        raise InputError(
            f"{path} is no {_WHAT}: returns has the shape {returns}; expected generations, policies, grounds"
        )
    expected = {
        "residual": ((), _FLAG),
        "seed": ((), _WHOLE),
        "weights": (WEIGHTS, _FLOAT),
        "returns": (returns, _FLOAT),
        "mean_returns": (returns[::2], _FLOAT),
        **dict.fromkeys(("steps", "wall", "processor"), (returns[:1], _FLOAT)),
    }
    for name, (shape, kind) in expected.items():
        array = read[name]
        if (array.shape, array.dtype) != (shape, kind):
            raise InputError(
                f"{path} is no {_WHAT}: {name} is of type {array.dtype} and shape {array.shape}; expected {kind} and "
                f"{shape}"
            )
        if not np.isfinite(array).all():
            raise InputError(f"{path} is damaged: {name} holds what is no finite number; train again")
