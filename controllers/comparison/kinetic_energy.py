"""Kinetic energy tracking control (KETC), reconstructed: the kinetic energy that the imitated slope asks for."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Annotated

from mjbiped.control.controller import Memory, Numbers, Room
from mjbiped.controllers.comparison import known_slope
from mjbiped.controllers.comparison.known_slope import KnownSlopeController, against_slope, energy_error, shaped_torque
from mjbiped.utils import domains


@dataclass(frozen=True)
class KineticEnergyController(KnownSlopeController):
    r"""Tracks the kinetic energy that a passive gait has in the posture of the moment (KETC, the paper's [19]).

    A reconstruction: the paper says of the method only that it tracks kinetic energy, which on the imitated slope is
    what the gait's energy leaves beside the potential one. Here

    .. math:: T_{ref}(q) = E_{ref} - V(q, \varphi_r), \qquad
              \frac{d}{dt} (T - T_{ref}) = -\lambda (T - T_{ref})

    One condition leaves one of the two torques free. Beside the imitated slope's gravity, which keeps
    :math:`T - T_{ref}` as it is, forces u on the two legs change it, in proportions that are set by a weight w:

    .. math:: \tau = B^{-1} [g(q, \varphi) - g(q, \varphi_r) + u], \quad
              u = -\lambda (T - T_{ref}) \frac{(\dot q_1, w \dot q_2)}{\dot q_1^2 + w \dot q_2^2}

    They are those of least :math:`u_1^2 + u_2^2 / w`. With w = 1 they lie along the rates, as in the passivity-based
    law (`PassivityController`) with :math:`k = \lambda / |\dot q|^2`. With w = 0, the default, the ankle does it alone,
    and the hip's torque is that of gravity. The step and the change of slope that the paper's introduction says the
    method bears are borne with the ankle alone, in both engines, and not with w = 1 (docs/comparison.md). X and numbers
    stand as in the paper's Table II with some gain of either (docs/reproduction.md).

    Where the rates are small, u has no bound; where the root of the denominator is below `slowest`, its square stands
    in the denominator's place, and the error falls more slowly. On the gait of Table I's robot on 2 degrees that root
    is never less than 0.62 rad/s with w = 1; with the ankle alone it is the stance leg's rate, which falls to
    0.04 rad/s about the middle of the step.

    The slope is by default that of the line through both feet; gain and slope source are those of docs/comparison.md.

    Attributes:
        gain: lambda, 1/s.
        slowest: Smallest root of the denominator at which the law holds, rad/s.
        hip_weight: w, at least 0; with 0 the ankle acts alone.
        slope_source: One of `SLOPE_SOURCES`; `KnownSlopeController` describes it and the other attributes.
    """

    gain: Annotated[float, domains.GAIN] = 20.0
    slowest: Annotated[float, domains.SLOWEST_RATE] = 0.1
    hip_weight: Annotated[float, domains.Domain(0.0, 1e6)] = 0.0
    slope_source: str = field(default="two_point", kw_only=True)


def _torque(parameters: Numbers, memory: Memory, t: float, q: Numbers, dq: Numbers, out: Room) -> None:
    imitated, first = parameters[known_slope.IMITATED_SLOPE], known_slope.GAINS
    gain, slowest, hip_weight = parameters[first], parameters[first + 1], parameters[first + 2]
    slope, q1, q2 = against_slope(memory, q)
    error = energy_error(parameters, imitated, parameters[known_slope.ENERGY], q1, q2, dq)  # T - T_ref
    swing = hip_weight * dq[1]
    damping = gain * error / max(dq[0] * dq[0] + swing * dq[1], slowest * slowest)
    out[0], out[1] = shaped_torque(parameters, slope, imitated, q1, q2, -damping * dq[0], -damping * swing)


KineticEnergyController.torque_law = staticmethod(_torque)
