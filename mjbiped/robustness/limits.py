"""Greatest disturbances that are survived: what is disturbed, how much at most, and what came of it.

A disturbance meets the robot in many cases: at many phases of its step, or on many random grounds. It is survived where
nearly all cases are. The greatest that is survived is the greatest one of those tried below which none is not: a robot
that survives 60 mm and 80 mm, but not 70 mm, survives 60 mm.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass

from mjbiped.sweeps.values import Scalar

FAR = 1e4  # of ground that goes on behind the disturbance, m


@dataclass(frozen=True)
class Disturbance:
    """A kind of disturbance by the phase of the foot at which it comes.

    Attributes:
        unit: Of its magnitudes.
        magnitudes: Those that are tried unless a study says otherwise, ascending.
        values: What a study's cell says of the walk, of a magnitude and of the place (m) where it comes.
    """

    unit: str
    magnitudes: tuple[float, ...]
    values: Callable[[float, float], Mapping[str, Scalar]]


def _step(rise: float, place: float) -> Mapping[str, Scalar]:
    return {
        "terrain.name": "stairs",
        "terrain.tread": FAR,
        "terrain.rise": rise,
        "terrain.first": place,
        "terrain.count": 1,
    }


def _bend(change_deg: float, place: float) -> Mapping[str, Scalar]:
    return {
        "terrain.name": "slopes",
        "terrain.length": place,
        "terrain.change_deg": change_deg,
        "terrain.count": 1,
    }


def _evenly(step: float, last: float) -> tuple[float, ...]:
    return tuple(round(step * k, 9) for k in range(1, round(last / step) + 1))


DISTURBANCES: Mapping[str, Disturbance] = {
    "step up": Disturbance("m", _evenly(0.005, 0.15), _step),
    "step down": Disturbance("m", _evenly(0.01, 0.3), lambda height, place: _step(-height, place)),
    "slope down": Disturbance("deg", _evenly(1.0, 15.0), _bend),
    "slope up": Disturbance("deg", _evenly(1.0, 15.0), lambda change, place: _bend(-change, place)),
}
"""Single disturbances of level ground, by name."""


@dataclass(frozen=True)
class Limit:
    """What a robot survives of one kind of disturbance.

    Attributes:
        unit: Of magnitudes.
        magnitudes: That were tried, ascending.
        shares: Of the cases of each that were survived.
        wanted: Share that counts as survived.
    """

    unit: str
    magnitudes: tuple[float, ...]
    shares: tuple[float, ...]
    wanted: float

    @property
    def greatest(self) -> float:
        """The greatest magnitude below which none is not survived; 0 where the least is not."""
        found = 0.0
        for magnitude, share in zip(self.magnitudes, self.shares, strict=True):
            if share < self.wanted:
                return found
            found = magnitude
        return found

    @property
    def reached(self) -> bool:
        """Whether a magnitude was tried that is not survived: else `greatest` is only the greatest that was tried."""
        return any(share < self.wanted for share in self.shares)


def limit_of(unit: str, survived: Mapping[float, Sequence[bool]], wanted: float) -> Limit:
    """The limit of cases that were survived or not, by magnitude."""
    magnitudes = tuple(sorted(survived))
    shares = tuple(sum(survived[each]) / len(survived[each]) if survived[each] else math.nan for each in magnitudes)
    return Limit(unit, magnitudes, shares, wanted)
