"""Controllers that compensate gravity on a slope that is given or dead reckoned, not estimated.

`KnownSlopeController` is the base class of the comparison controllers of the paper's section V.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass, field, fields
from functools import cached_property
from typing import Annotated, Any, ClassVar

from mjbiped.control.controller import Law, LawController, Memory, Numbers, never
from mjbiped.controllers.adaptive import check_imitation
from mjbiped.controllers.slope_estimator import slope_change
from mjbiped.gaits.gait import Gait
from mjbiped.gaits.passive import PassiveGait
from mjbiped.robots import compass
from mjbiped.robots.compass import Compass
from mjbiped.utils import domains

SLOPE_SOURCES = ("none", "local", "two_point")

# indices in the memory: slope under the stance foot, and from there to the slope that the law takes, rad
_LOCAL, _TILT = 0, 1

SOURCE, IMITATED_SLOPE, ENERGY, GAINS = range(7, 11)
"""Indices in the parameters, behind the robot model's lumped `compass.Constants`: index of the slope's source in
`SLOPE_SOURCES`; phi_r, rad; E_ref, J (NaN for a gait that has none); and the law's own attributes, in their order.
Behind these stands the gait's trajectory, for a law that follows it."""


@dataclass(frozen=True)
class KnownSlopeController(LawController):
    r"""A law that uses the slope of the ground: given at the start, and dead reckoned at touchdowns if so chosen.

    | `slope_source` | slope :math:`\varphi` of the law, which measures angles from its normal |
    |---|---|
    | `"none"` | the slope given at the start |
    | `"local"` | the slope of the ground under the stance foot |
    | `"two_point"` | the slope of the line through both feet at the last touchdown; before the first, as `"local"` |

    The local slope is exact kinematics from touchdown to touchdown, and the line follows from the equal legs:

    .. math:: \varphi^+ = \varphi^- + q_1^- - q_2^+, \qquad
              \varphi_{line} = \varphi^+ + \tfrac12 (q_1^+ + q_2^+)

    Nothing corrects an error of the slope given at the start. On ground that is not level under
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
    torque_law: ClassVar[Callable[..., None]]
    """`Law.torque` of the class; a function at a module's top level."""

    def __post_init__(self) -> None:
        """Refuse a robot or gait of another kind, an unknown source, and numbers outside their domains.

        Raises:
            InputError: An attribute is refused; see `mjbiped.utils.domains`.
        """
        check_imitation(self)
        domains.known_name("slope_source", self.slope_source, SLOPE_SOURCES)
        domains.check_fields(self)

    @cached_property
    def parameters(self) -> list[float]:
        """The attributes in plain numbers, as the law takes them."""
        gains = (getattr(self, each.name) for each in fields(self) if each.name not in _COMMON)
        return [
            *self.robot.constants,
            float(SLOPE_SOURCES.index(self.slope_source)),
            float(self.gait.slope),
            self.gait.energy if isinstance(self.gait, PassiveGait) else math.nan,
            *map(float, gains),
            *(self.gait.tables[0] if self.follows else ()),
        ]

    def start(self, memory: Memory, q: Numbers, dq: Numbers) -> None:
        """Begin with the given slope."""
        memory[_LOCAL], memory[_TILT] = float(self.initial_slope_estimate), 0.0

    @cached_property
    def plain_law(self) -> Law:
        """The law of the class; see `LawController.plain_law`."""
        return Law(self.parameters, type(self).torque_law, _touchdown, _slope_estimate, never)


_COMMON = tuple(each.name for each in fields(KnownSlopeController))


def against_slope(memory: Numbers, q: Numbers) -> tuple[float, float, float]:
    """Return the law's slope, and both legs' angles from that slope's normal instead of the ground's, rad."""
    return memory[_LOCAL] + memory[_TILT], q[0] - memory[_TILT], q[1] - memory[_TILT]


def _touchdown(parameters: Numbers, memory: Memory, q_before: Numbers, q: Numbers, dq: Numbers) -> None:
    if parameters[SOURCE] >= 1.0:  # all but "none"
        memory[_LOCAL] += slope_change(q_before[0], q[1])
    if parameters[SOURCE] == 2.0:  # "two_point"
        memory[_TILT] = 0.5 * (q[0] + q[1])


def _slope_estimate(parameters: Numbers, memory: Memory) -> float:
    """Slope under the stance foot as given or dead reckoned, rad, also with "two_point"."""
    return memory[_LOCAL]


def energy_error(constants: Any, slope: float, energy: float, q1: float, q2: float, dq: Numbers) -> float:
    r"""Error of the energy that the robot would have on a slope.

    .. math:: E - E_{ref} = T(q, \dot q) + V(q, \varphi) - E_{ref}

    Args:
        constants: Begin with the lumped `compass.Constants` of the controller's robot model.
        slope: phi, of the imitated slope or of the ground, rad.
        energy: E_ref about the stance foot, J.
        q1: Stance angle, rad.
        q2: Swing angle, rad.
        dq: Rates of both, rad/s.

    Returns:
        E - E_ref, J.
    """
    kinetic = compass.kinetic_energy(constants, q1, q2, dq[0], dq[1])
    return kinetic + compass.potential_energy(constants, q1, q2, slope) - energy


def shaped_torque(
    constants: Any, slope: float, imitated_slope: float, q1: float, q2: float, force1: float, force2: float
) -> tuple[float, float]:
    r"""Potential energy shaping (Spong's controlled symmetry) with further forces u.

    .. math:: \tau = B^{-1} [g(q, \varphi) - g(q, \varphi_r) + u] \quad\Rightarrow\quad
              \frac{d}{dt} [T + V(q, \varphi_r)] = u^T \dot q

    Args:
        constants: Begin with the lumped `compass.Constants` of the controller's robot model.
        slope: phi, of the ground, rad.
        imitated_slope: phi_r, rad.
        q1: Stance angle from that ground's normal, rad.
        q2: Swing angle, rad.
        force1: u on the stance leg, N m.
        force2: u on the swing leg, N m.

    Returns:
        Ankle and hip torque, N m.
    """
    gc1, gc2, gs1, gs2 = compass.gravity_terms(constants, compass.legs_of(q1, q2))
    sine = math.sin(slope) - math.sin(imitated_slope)
    cosine = math.cos(slope) - math.cos(imitated_slope)
    return compass.joint_torques(gc1 * sine + gs1 * cosine + force1, gc2 * sine + gs2 * cosine + force2)
