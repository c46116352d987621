"""Limit cycle tracking of Hu, Yan and Lin: the passive gait's trajectory by feedback linearisation."""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import cached_property
from typing import Annotated, Any, ClassVar

from mjbiped.control.controller import Law, Memory, Numbers, Room
from mjbiped.controllers.comparison.known_slope import GAINS, KnownSlopeController, against_slope
from mjbiped.gaits.reference import MOST, reference_at, reference_discontinuity
from mjbiped.robots import compass
from mjbiped.utils import domains

_TABLE = GAINS + 2  # index in the parameters of the gait's trajectory
_REFERENCE = 2  # index in `out` of the reference


@dataclass(frozen=True)
class LimitCycleController(KnownSlopeController):
    r"""Tracks a passive gait's trajectory by feedback linearisation (the paper's [20]).

    .. math:: \tau = B^{-1} \{M [\ddot q_r + K_1 (\dot q_r - \dot q) + K_2 (q_r - q)] + C \dot q + g(q, \varphi)\}

    so that :math:`\ddot e + K_1 \dot e + K_2 e = 0` for :math:`e = q_r - q`. The reference begins anew at each
    touchdown. The source's gains, K1 = 10 and K2 = 25, damp critically: :math:`s^2 + 10 s + 25 = (s + 5)^2`.

    It is the paper's tracking law (12) with other names for the gains, a given slope, and no re-planning.

    The slope is by default the one under the stance foot, which is what the paper's own controller estimates.

    Source: Y. Hu, G. Yan, Z. Lin, Gait generation and control for biped robots with underactuation degree one,
    Automatica 47(8), 1605-1616, 2011.

    Attributes:
        rate_gain: K1 = diag(k, k), 1/s.
        position_gain: K2 = diag(k, k), 1/s².
        slope_source: One of `SLOPE_SOURCES`; `KnownSlopeController` describes it and the other attributes.
    """

    rate_gain: Annotated[float, domains.GAIN] = 10.0
    position_gain: Annotated[float, domains.Domain(1e-9, 1e9, "1/s^2")] = 25.0

    follows: ClassVar[bool] = True

    @cached_property
    def plain_law(self) -> Law:
        """The law of the class, with the end of the gait's trajectory; see `LawController.plain_law`."""
        return super().plain_law._replace(next_discontinuity=_next_discontinuity)


def _torque(parameters: Numbers, memory: Memory, t: float, q: Numbers, dq: Numbers, out: Room) -> None:
    rate_gain, position_gain = parameters[GAINS], parameters[GAINS + 1]
    slope, q1, q2 = against_slope(memory, q)
    reference_at(parameters, _TABLE, t, out, _REFERENCE)
    a1 = _commanded(out, 0, position_gain, q1, rate_gain, dq[0])
    a2 = _commanded(out, 1, position_gain, q2, rate_gain, dq[1])
    constants: Any = parameters  # which begin with them
    legs, sine, cosine = compass.legs_of(q1, q2), math.sin(slope), math.cos(slope)
    force1, force2 = compass.inverse_dynamics(constants, legs, dq[0], dq[1], sine, cosine, a1, a2)
    out[0], out[1] = compass.joint_torques(force1, force2)


def _commanded(room: Numbers, leg: int, position_gain: float, q: float, rate_gain: float, dq: float) -> float:
    """Acceleration of a leg that the law asks for, with the reference in the room, rad/s²."""
    at = _REFERENCE + leg
    return room[at + 2 * MOST] + position_gain * (room[at] - q) + rate_gain * (room[at + MOST] - dq)


def _next_discontinuity(parameters: Numbers, memory: Memory, t: float) -> float:
    return reference_discontinuity(parameters, _TABLE, t)


LimitCycleController.torque_law = staticmethod(_torque)
