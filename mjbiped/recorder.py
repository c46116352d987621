"""Gathers the samples and touchdowns of a walk in any engine."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from mjbiped.columns import SAMPLES, TOUCHDOWNS, split, width


class Recorder:
    """Grows with the walk; its tables may be asked for at any moment."""

    def __init__(self) -> None:
        """Begin an empty recording."""
        self._rows: list[NDArray[np.float64]] = [np.empty((0, width(TOUCHDOWNS)))]
        self._samples: list[NDArray[np.float64]] = []

    def add(self, rows: NDArray[np.float64], samples: NDArray[np.float64]) -> None:
        """Take copies of rows of both tables.

        Args:
            rows: Of touchdowns, shape (any, columns of `columns.TOUCHDOWNS`).
            samples: Shape (any, columns of `columns.SAMPLES` and the controller's states).
        """
        self._rows.append(rows.copy())
        self._samples.append(samples.copy())

    def add_touchdown(self, row: NDArray[np.float64]) -> None:
        """Take a copy of one touchdown's row."""
        self._rows.append(row[None].copy())

    def samples(self) -> dict[str, NDArray[np.float64]]:
        """Samples so far; see `mjbiped.columns.SAMPLES`."""
        own = width(SAMPLES)
        table = np.concatenate(self._samples) if self._samples else np.empty((0, own))
        return {**split(SAMPLES, table[:, :own].tolist()), "controller_states": table[:, own:].copy()}

    def touchdowns(self) -> dict[str, NDArray[np.float64]]:
        """Touchdowns so far; see `mjbiped.columns.TOUCHDOWNS`."""
        return split(TOUCHDOWNS, np.concatenate(self._rows).tolist())
