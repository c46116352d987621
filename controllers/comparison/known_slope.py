"""Controllers that compensate gravity on a slope that is given or dead reckoned, not estimated.

`KnownSlopeController` is what the comparison controllers of the paper's section V have in common.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field, fields
from functools import cached_property
from typing import Annotated, Any, ClassVar, NamedTuple

from mjbiped.control.controller import Law, LawController, Memory, never
from mjbiped.controllers.settings import check_imitation
from mjbiped.controllers.slope_estimator import slope_change
from mjbiped.gaits.gait import Gait
from mjbiped.gaits.passive import PassiveGait
from mjbiped.robots import compass
from mjbiped.robots.compass import Compass
from mjbiped.utils import domains

SLOPE_SOURCES = ("none", "local", "two_point")

# indices in the memory: slope under the stance foot, and from there to the slope that the law takes, rad
_LOCAL, _TILT = 0, 1


class Parameters(NamedTuple):
    """Parameters of the laws of these controllers: the attributes in plain numbers.

    Attributes:
        constants: Lumped constants of the robot model.
        source: Index of the slope's source in `SLOPE_SOURCES`.
        imitated_slope: phi_r, rad.
        energy: E_ref, J; NaN for a gait that has none.
        gains: The law's own attributes, in their order.
        table: The gait's trajectory, for a law that follows it; else empty.
    """

    constants: compass.Constants
    source: int
    imitated_slope: float
    energy: float
    gains: tuple[float, ...]
    table: Any


@dataclass(frozen=True)
class KnownSlopeController(LawController):
    r"""A law that uses the slope of the ground, given at the start and then, by choice, dead reckoned at touchdowns.

    | `slope_source` | the law's slope :math:`\varphi`, which its angles are taken from the normal of |
    |---|---|
    | `"none"` | the slope given at the start, for ever |
    | `"local"` | of the ground under the stance foot |
    | `"two_point"` | of the line through both feet at the last touchdown; before the first one as `"local"` |

    The local slope is exact kinematics from touchdown to touchdown, and the line follows from the equal legs:

    .. math:: \varphi^+ = \varphi^- + q_1^- - q_2^+, \qquad
              \varphi_{line} = \varphi^+ + \tfrac12 (q_1^+ + q_2^+)

    Nothing corrects an error of the slope given at the start: it stays for ever. On ground that is not level under
    x = 0, give `initial_slope_estimate=terrain.slope_at(0.0)`.

    Attributes:
        robot: Robot model of the law; it may differ from the robot that walks.
        gait: Gait that is imitated; a passive one, except for a law that `follows` its trajectory.
        slope_source: One of `SLOPE_SOURCES`.
        initial_slope_estimate: Slope of the ground at the start as it is given to the law, rad, positive downhill.
    """

    robot: Compass
    gait: Gait
    slope_source: str = field(default="local", kw_only=True)
    initial_slope_estimate: Annotated[float, domains.SLOPE] = field(default=0.0, kw_only=True)

    memory_size: ClassVar[int] = 2
    follows: ClassVar[bool] = False
    torque_law: ClassVar[Callable[..., tuple[float, float]]]
    """(parameters, memory, t, q1, q2, dq1, dq2) -> ankle and hip torque, N m; a function at a module's top level."""

    def __post_init__(self) -> None:
        """Refuse a robot or gait of another kind, an unknown source, and numbers outside their domains.

        Raises:
            InputError: An attribute is so; see `mjbiped.utils.domains`.
        """
        check_imitation(self)
        domains.known_name("slope_source", self.slope_source, SLOPE_SOURCES)
        domains.check_fields(self)

    @cached_property
    def parameters(self) -> Parameters:
        """The attributes in plain numbers, as the law takes them."""
        return Parameters(
            constants=self.robot.constants,
            source=SLOPE_SOURCES.index(self.slope_source),
            imitated_slope=float(self.gait.slope),
            energy=self.gait.energy if isinstance(self.gait, PassiveGait) else math.nan,
            gains=tuple(getattr(self, each.name) for each in fields(self) if each.name not in _COMMON),
            table=self.gait.table if self.follows else (),
        )

    def start(self, memory: Memory, q: Sequence[float], dq: Sequence[float]) -> None:
        """Begin with the given slope."""
        memory[_LOCAL], memory[_TILT] = float(self.initial_slope_estimate), 0.0

    @cached_property
    def plain_law(self) -> Law:
        """The law of the class; see `LawController.plain_law`."""
        return Law(self.parameters, type(self).torque_law, _touchdown, _slope_estimate, never)


_COMMON = tuple(each.name for each in fields(KnownSlopeController))


def against_slope(memory: Memory, q1: float, q2: float) -> tuple[float, float, float]:
    """Return the law's slope, and convert angles from the ground's normal to angles from that slope's normal, rad."""
    return memory[_LOCAL] + memory[_TILT], q1 - memory[_TILT], q2 - memory[_TILT]


def _touchdown(
    parameters: Parameters, memory: Memory, before1: float, before2: float, q1: float, q2: float, dq1: float, dq2: float
) -> None:
    if parameters.source >= 1:  # all but "none"
        memory[_LOCAL] += slope_change(before1, q2)
    if parameters.source == 2:  # "two_point"
        memory[_TILT] = 0.5 * (q1 + q2)


def _slope_estimate(parameters: Parameters, memory: Memory) -> float:
    """Slope under the stance foot as given or dead reckoned, rad; with "two_point" too, whose line differs."""
    return memory[_LOCAL]
