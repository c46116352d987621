"""Passivity-based control (PBC) of Spong, Holm and Lee: the passive gait's gravity, and its energy as an attractor."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Annotated

from mjbiped.control.controller import Memory, Numbers, Room
from mjbiped.controllers.comparison import known_slope
from mjbiped.controllers.comparison.known_slope import KnownSlopeController, against_slope, energy_error, shaped_torque
from mjbiped.utils import domains


@dataclass(frozen=True)
class PassivityController(KnownSlopeController):
    r"""Imitates a passive gait by its gravity and its energy (PBC, the paper's [16]).

    .. math:: \tau = B^{-1} [g(q, \varphi) - g(q, \varphi_r) - k (E - E_{ref}) \dot q], \quad
              E = T + V(q, \varphi_r)

    Then the storage :math:`S = \frac12 (E - E_{ref})^2` falls within each step:

    .. math:: \dot E = -k (E - E_{ref}) |\dot q|^2, \quad \dot S = -2 k |\dot q|^2 S

    Its slope is by default that of the line through both feet, with which the paper says that this method bears
    changes of slope. The gain is that of docs/comparison.md.

    Source: M. W. Spong, J. K. Holm, D. Lee, Passivity-based control of bipedal locomotion, IEEE Robotics & Automation
    Magazine 14(2), 30-40, 2007.

    Attributes:
        gain: k, s.
        slope_source: One of `SLOPE_SOURCES`; `KnownSlopeController` describes it and the other attributes.
    """

    gain: Annotated[float, domains.Domain(1e-6, 1e6, "s")] = 5.0
    slope_source: str = field(default="two_point", kw_only=True)


def _torque(parameters: Numbers, memory: Memory, t: float, q: Numbers, dq: Numbers, out: Room) -> None:
    imitated = parameters[known_slope.IMITATED_SLOPE]
    gain = parameters[known_slope.GAINS]
    slope, q1, q2 = against_slope(memory, q)
    damping = gain * energy_error(parameters, imitated, parameters[known_slope.ENERGY], q1, q2, dq)
    out[0], out[1] = shaped_torque(parameters, slope, imitated, q1, q2, -damping * dq[0], -damping * dq[1])


PassivityController.torque_law = staticmethod(_torque)
