"""What a training has come to, as a file: the policy, and all returns, from which the training goes on bitwise."""

from __future__ import annotations

import zipfile
from dataclasses import dataclass, fields
from pathlib import Path

import numpy as np

from mjbiped.errors import InputError
from mjbiped.utils.files import saved
from scripts.learning.policy import WEIGHTS, Array

LAST = 10
"""Generations whose mean says what a training has reached: one alone has four grounds, on which returns vary."""


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
        try:
            with np.load(path, allow_pickle=False) as file:
                read = {field.name: file[field.name] for field in fields(cls)}
        except FileNotFoundError as error:
            raise InputError(
                f"there is no policy {path}; train one: python -m scripts.learning.train --task residual, or free"
            ) from error
        except (OSError, KeyError, ValueError, EOFError, zipfile.BadZipFile) as error:
            raise InputError(f"{path} is no policy that scripts.learning.train wrote: {error}") from error
        if read["weights"].shape != WEIGHTS:
            raise InputError(f"{path}: its policy has the shape {read['weights'].shape}, this program's has {WEIGHTS}")
        return cls(**{**read, "residual": bool(read["residual"]), "seed": int(read["seed"])})
