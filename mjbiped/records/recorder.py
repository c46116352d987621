"""Collection of the samples and touchdowns of a walk in any engine."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any, TypeAlias

import numpy as np
from numpy.typing import NDArray

from mjbiped.records.columns import Columns, index_of, split, tables_of, width
from mjbiped.records.measures import Summary
from mjbiped.robots.compass import Compass
from mjbiped.robots.robot import Robot

Cancellation: TypeAlias = Callable[[], None]
"""Function that is called at times during a walk, and may raise an exception to stop it."""

Rows: TypeAlias = NDArray[np.float64]

_TIME = 0  # index of the time in a row of either table


def _new(columns: Columns, rows: Rows, taken: Sequence[Rows]) -> Rows:
    """Return a copy of the rows that are later than the last row that was taken, and hold a motion of numbers."""
    finite = np.repeat([column.finite for column in columns.values()], [column.width for column in columns.values()])
    rows = rows[np.isfinite(rows[:, : len(finite)][:, finite]).all(axis=1)]  # the controller's states follow in a row
    return rows[rows[:, _TIME] > taken[-1][-1, _TIME]] if taken and len(taken[-1]) else rows


def never_cancelled() -> None:
    """Never cancel a walk."""


class Recorder:
    """Samples and touchdowns so far, whose tables may be read at any time.

    Attributes:
        cancellation: Function that the engine calls each time before the walk goes on.
    """

    def __init__(
        self,
        *,
        robot: type[Robot] = Compass,
        keep_samples: bool = True,
        summary: Summary | None = None,
        cancellation: Cancellation = never_cancelled,
    ) -> None:
        """Begin an empty recording.

        Args:
            robot: Kind of robot that walks.
            keep_samples: Whether all samples are kept; otherwise only the last one is.
            summary: Summary that takes the touchdowns, which are then not kept.
            cancellation: Function that the engine calls each time before the walk goes on.
        """
        self.cancellation = cancellation
        self._keep_samples = keep_samples
        self._summary = summary
        self._columns = tables_of(robot)
        self._sampled = width(self._columns.samples)
        self._rows: list[Rows] = [np.empty((0, width(self._columns.touchdowns)))]
        self._samples: list[Rows] = []

    def add(self, rows: NDArray[np.float64], samples: NDArray[np.float64]) -> None:
        """Add copies of rows to both tables.

        Rows that were added before are skipped: Ctrl-C may come before an engine notes that its rows were added. So are
        rows of a motion that is no number, as a walk that diverges may end with: a record that holds one is refused.

        Args:
            rows: Rows of touchdowns, shape (any, columns of `columns.TOUCHDOWNS`).
            samples: Rows of samples, shape (any, columns of `columns.SAMPLES` and the controller's states).
        """
        rows = _new(self._columns.touchdowns, rows, self._rows)
        samples = _new(self._columns.samples, samples, self._samples)
        if len(rows) and self._summary is not None:
            self._summary.take(split(self._columns.touchdowns, rows))
        elif len(rows):
            self._rows.append(rows)
        if len(samples) and self._keep_samples:
            self._samples.append(samples)
        elif len(samples):
            self._samples = [samples[-1:]]

    def add_touchdown(self, row: NDArray[np.float64]) -> None:
        """Add a copy of one touchdown's row."""
        self.add(row[None], np.empty((0, self._sampled)))

    @property
    def end(self) -> tuple[float, float]:
        """Time (s) and hip x (m) of the last sample; zeros without one."""
        if not self._samples:
            return 0.0, 0.0
        last = self._samples[-1][-1]
        return float(last[_TIME]), float(last[index_of(self._columns.samples, "qpos")])

    @property
    def steps(self) -> int:
        """Number of touchdowns."""
        return self._summary.steps if self._summary is not None else sum(map(len, self._rows))

    def summary(self) -> Summary:
        """Return the summary that was given to the constructor."""
        assert self._summary is not None
        return self._summary

    def samples(self) -> dict[str, NDArray[Any]]:
        """Return the samples so far; see `mjbiped.records.columns.SAMPLES`."""
        table = np.concatenate(self._samples) if self._samples else np.empty((0, self._sampled))
        if not self._keep_samples:
            table = table[:0]
        own = table[:, self._sampled :].copy()
        return {**split(self._columns.samples, table[:, : self._sampled]), "controller_states": own}

    def touchdowns(self) -> dict[str, NDArray[Any]]:
        """Return the touchdowns so far; see `mjbiped.records.columns.TOUCHDOWNS`."""
        return split(self._columns.touchdowns, np.concatenate(self._rows))
