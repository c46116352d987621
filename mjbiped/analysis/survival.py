"""Survival: the number of steps until a robot falls, from walks that ended with a fall and from censored ones.

Once the transient has died out, falls on random ground come without memory, so that one number says nearly all: the
mean number of steps to a fall, or the probability that the next step succeeds (the second eigenvalue of the walk as a
Markov chain; Byl and Tedrake, 2009). A walk that is still going at its last step is censored: it contributes its steps,
and no fall.
"""

from __future__ import annotations

import math
import warnings
from collections.abc import Iterable
from dataclasses import dataclass

import numpy as np
import scipy
from numpy.typing import NDArray

from mjbiped.errors import InputError
from mjbiped.records.record import Walk

CONFIDENCE = 0.95
"""Confidence of all intervals."""

SURVIVED = ("finished", "left the terrain")
"""Outcomes of walks that were broken off rather than ended by a fall."""

_RESAMPLES, _SEED = 2000, 0  # number and seed of the resamples for the interval of a ratio


@dataclass(frozen=True)
class Survival:
    """Walks of one controller on grounds of one kind.

    Attributes:
        steps: Number of steps of each walk.
        fell: Whether each walk ended with a fall, rather than at the greatest number of steps asked for.
    """

    steps: tuple[int, ...]
    fell: tuple[bool, ...]

    def __post_init__(self) -> None:
        """Refuse an empty or inconsistent set of walks.

        Raises:
            InputError: There are no walks, or not as many ends as walks.
        """
        if not self.steps or len(self.steps) != len(self.fell):
            raise InputError(
                f"survival needs at least one walk, and one end per walk; got {len(self.steps)} walks and "
                f"{len(self.fell)} ends"
            )

    @classmethod
    def of(cls, walks: Iterable[Walk]) -> Survival:
        """The survival of walks on random grounds, as `mjbiped.walk_many` makes them.

        Raises:
            InputError: There are none.
        """
        ends = [(walk.steps, walk.outcome not in SURVIVED) for walk in walks]
        return cls(tuple(steps for steps, _ in ends), tuple(fell for _, fell in ends))

    def after(self, transient: int) -> Survival:
        """Return the survival after a transient; a walk that ended within it contributes neither steps nor a fall.

        Args:
            transient: Number of steps after which the initial state no longer matters.
        """
        pairs = list(zip(self.steps, self.fell, strict=True))
        return Survival(
            tuple(max(steps - transient, 0) for steps, _ in pairs),
            tuple(fell and steps >= transient for steps, fell in pairs),
        )

    @property
    def falls(self) -> int:
        """Number of falls."""
        return sum(self.fell)

    @property
    def eigenvalue(self) -> float:
        """Maximum-likelihood probability that the next step succeeds: steps over steps plus falls; NaN without either.

        It estimates the second eigenvalue of the walk as a Markov chain whose first one, 1, is that of having fallen.
        """
        tried = sum(self.steps) + self.falls
        return sum(self.steps) / tried if tried else math.nan

    @property
    def misfit(self) -> float:
        """Greatest difference between the Kaplan-Meier curve and the geometric distribution of `eigenvalue`.

        It is small where falls come without memory; NaN without a fall.
        """
        if not self.falls:
            return math.nan
        at, share, _, _ = self.curve()
        expected = self.eigenvalue ** (at[1:] + 1.0)  # of making more steps than these
        return float(np.abs(share[1:] - expected).max())

    @property
    def mean(self) -> float:
        """Maximum-likelihood mean number of steps to a fall: all steps over all falls.

        Infinite without a fall; NaN without a step either.
        """
        if not self.falls:
            return math.inf if any(self.steps) else math.nan
        return sum(self.steps) / self.falls

    @property
    def interval(self) -> tuple[float, float]:
        """The 95 % confidence interval of the mean, if falls come without memory.

        Garwood's exact interval (1936) for the mean of a Poisson-distributed number, that of the falls in all T steps:
        2 T / mean between quantiles of the chi-squared distributions of 2 n and 2 n + 2 degrees of freedom for n falls.
        """
        steps, tail = sum(self.steps), (1.0 - CONFIDENCE) / 2.0
        low = 2.0 * steps / float(scipy.stats.chi2.ppf(1.0 - tail, 2 * self.falls + 2))
        high = 2.0 * steps / float(scipy.stats.chi2.ppf(tail, 2 * self.falls)) if self.falls else math.inf
        return low, high

    def curve(self) -> tuple[NDArray[np.float64], NDArray[np.float64], NDArray[np.float64], NDArray[np.float64]]:
        """The Kaplan-Meier estimate: steps at which walks ended, the share that survives them, and its 95 % band.

        The band is that of Greenwood's formula for the logarithm of the logarithm. It begins with (0, 1, 1, 1).
        """
        steps, fell = np.array(self.steps, dtype=float), np.array(self.fell)
        found = scipy.stats.ecdf(scipy.stats.CensoredData(steps[fell], right=steps[~fell])).sf
        share = np.asarray(found.probabilities)
        low, high = share, share
        if self.falls:
            with np.errstate(divide="ignore", invalid="ignore"), warnings.catch_warnings():
                warnings.simplefilter("ignore", RuntimeWarning)  # of a share of one or of nothing, see below
                band = found.confidence_interval(CONFIDENCE, method="log-log")
            low, high = (np.asarray(end.probabilities) for end in (band.low, band.high))  # type: ignore[attr-defined]
        start = np.array([[0.0], [1.0], [1.0], [1.0]])
        # a share of one or of nothing has no band by that formula
        rows = np.array([found.quantiles, share, *(np.where(np.isfinite(end), end, share) for end in (low, high))])
        at, all_, lowest, highest = np.hstack([start, rows])
        return at, all_, lowest, highest


def ratio(better: Survival, worse: Survival) -> tuple[float, float, float]:
    """The ratio of two mean numbers of steps to a fall, of walks on the same grounds.

    Args:
        better: Walks whose mean is the numerator, in the order of the grounds.
        worse: Walks whose mean is the denominator, in the same order.

    Returns:
        The ratio of the means, and its 95 % interval: percentiles over resampled grounds. Where the better one never
        fell, ratio and upper end are infinite, and the lower end is its interval's over the upper end of the other's.

    Raises:
        InputError: The numbers of grounds differ.
    """
    if len(better.steps) != len(worse.steps):
        raise InputError(f"walks on the same grounds are compared; got {len(better.steps)} and {len(worse.steps)}")
    if not better.falls:
        return math.inf, better.interval[0] / worse.interval[1], math.inf
    data = np.array([better.steps, better.fell, worse.steps, worse.fell], dtype=float)
    count = data.shape[1]
    draws = np.random.Generator(np.random.PCG64(_SEED)).integers(count, size=(_RESAMPLES, count))
    steps, falls, other_steps, other_falls = data[:, np.vstack([np.arange(count), draws])].sum(axis=-1)
    with np.errstate(divide="ignore", invalid="ignore"):
        whole, *drawn = (steps / falls / (other_steps / other_falls)).tolist()
    tail = (1.0 - CONFIDENCE) / 2.0
    low, high = np.quantile([each for each in drawn if not math.isnan(each)], (tail, 1.0 - tail), method="nearest")
    return whole, float(low), float(high)
