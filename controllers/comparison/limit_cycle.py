"""Limit cycle tracking of Hu, Yan and Lin: the passive gait's trajectory by feedback linearisation."""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import cached_property
from typing import Annotated, ClassVar

from mjbiped.control.controller import Law, Memory
from mjbiped.controllers.comparison.known_slope import KnownSlopeController, Parameters, against_slope
from mjbiped.controllers.tracking import computed_torque, tracking_errors
from mjbiped.gaits.reference import reference_at, reference_discontinuity
from mjbiped.robots.compass import legs_of
from mjbiped.utils import domains


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
    position_gain: Annotated[float, domains.POSITION_GAIN] = 25.0

    follows: ClassVar[bool] = True

    @cached_property
    def plain_law(self) -> Law:
        """The law of the class, with the end of the gait's trajectory; see `LawController.plain_law`."""
        return super().plain_law._replace(next_discontinuity=_next_discontinuity)


def _torque(
    parameters: Parameters, memory: Memory, t: float, q1: float, q2: float, dq1: float, dq2: float
) -> tuple[float, float]:
    rate_gain, position_gain = parameters.gains
    slope, q1, q2 = against_slope(memory, q1, q2)
    reference = reference_at(parameters.table, t)
    errors = tracking_errors(0.0, reference, q1, q2, dq1, dq2)
    return computed_torque(
        parameters.constants,
        position_gain,
        rate_gain,
        reference,
        errors,
        legs_of(q1, q2),
        dq1,
        dq2,
        math.sin(slope),
        math.cos(slope),
    )


def _next_discontinuity(parameters: Parameters, memory: Memory, t: float) -> float:
    return reference_discontinuity(parameters.table, t)


LimitCycleController.torque_law = staticmethod(_torque)
