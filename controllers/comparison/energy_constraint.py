"""Energy constraint control (ECC) of Asano: the energy that virtual gravity supplies, at a fixed ratio of torques."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Annotated, Any

from mjbiped.control.controller import Memory, Numbers, Room
from mjbiped.controllers.comparison import known_slope
from mjbiped.controllers.comparison.known_slope import KnownSlopeController, against_slope, energy_error
from mjbiped.errors import InputError
from mjbiped.robots import compass
from mjbiped.utils import domains


@dataclass(frozen=True)
class EnergyConstraintController(KnownSlopeController):
    r"""Lets the mechanical energy rise as virtual gravity would let it (ECC, the paper's [17] and [18]).

    Virtual gravity pulls a robot of mass M on level ground forward with :math:`M g \tan \varphi_r`. With the energy E
    about the stance foot and the place X of the centre of mass ahead of it along the ground,

    .. math:: \dot E = M g \tan \varphi_r \dot X - \zeta (E - E_d), \quad E_d = E_0 + M g \tan \varphi_r X

    On ground of slope :math:`\varphi` true gravity's pull is a part of virtual gravity's, and the torques supply the
    rest: :math:`M g \tan \varphi_r` becomes :math:`M g \cos \varphi (\tan \varphi_r - \tan \varphi)`.

    :math:`E_0` is the energy that the imitated gait has above its stance foot, in gravity as strong as virtual gravity
    is: :math:`E_{ref} \cos \varphi / \cos \varphi_r`. :math:`E_d` so depends on the posture alone, and begins anew with
    each step's stance foot. (Were it set to the measured energy there, E would equal :math:`E_d` ever after, and
    :math:`\zeta` do nothing: what is lost or gained at a touchdown would stay lost or gained.)

    One condition, two torques: their ratio is fixed,

    .. math:: \tau_1 = \mu \tau_2, \qquad \dot E = \tau_2 [(\mu - 1) \dot q_1 + \dot q_2]

    Asano counts the hip's torque the other way round; his :math:`\mu` is minus ours. Where the bracket vanishes no
    torque can do it. On the gait of Table I's robot on 2 degrees that happens twice per step for every ratio from -0.04
    to 42.9, and never beyond. The torques of virtual gravity itself have
    :math:`\mu = 1 - [m a + (m_H + m) l] / (m b)`, which is -2, where the legs make equal angles with the normal. Where
    the bracket is less than `singular_band`, its inverse is replaced by the bracket over the band's square: the torques
    stay continuous and bounded, and the law does not hold.

    The slope is by default the one under the stance foot, which is what the paper's own controller estimates. The gains
    are those of docs/comparison.md.

    Sources: F. Asano, M. Yamakita, N. Kamamichi, Z.-W. Luo, A novel gait generation for biped walking robots based on
    mechanical energy constraint, IEEE Transactions on Robotics and Automation 20(3), 565-573, 2004; F. Asano,
    Z.-W. Luo, M. Yamakita, Biped gait generation and control based on a unified property of passive dynamic walking,
    IEEE Transactions on Robotics 21(4), 754-762, 2005.

    Attributes:
        gain: zeta, 1/s.
        ratio: mu, ankle torque over hip torque; not 0.
        singular_band: Smallest :math:`|(\mu - 1) \dot q_1 + \dot q_2|` at which the law holds, rad/s.
        slope_source: One of `SLOPE_SOURCES`; `KnownSlopeController` describes it and the other attributes.
    """

    gain: Annotated[float, domains.GAIN] = 5.0
    ratio: Annotated[float, domains.Domain(-1e6, 1e6)] = -2.3
    singular_band: Annotated[float, domains.SLOWEST_RATE] = 0.1

    def __post_init__(self) -> None:
        """Refuse parameters outside their domain.

        Raises:
            InputError: One is, as in `KnownSlopeController`, or the ratio is zero.
        """
        super().__post_init__()
        if self.ratio == 0.0:
            raise InputError("ratio = 0 (mu, ankle over hip torque): must be another number than 0")


def _torque(parameters: Numbers, memory: Memory, t: float, q: Numbers, dq: Numbers, out: Room) -> None:
    imitated, first = parameters[known_slope.IMITATED_SLOPE], known_slope.GAINS
    gain, ratio, band = parameters[first], parameters[first + 1], parameters[first + 2]
    slope, q1, q2 = against_slope(memory, q)
    constants: Any = parameters  # which begin with them
    gc1, gc2, gs1, gs2 = compass.gravity_terms(constants, compass.legs_of(q1, q2))
    moment, moment_rate = -(gs1 + gs2), -(gc1 * dq[0] + gc2 * dq[1])  # M g X and its rate
    pull = math.cos(slope) * math.tan(imitated) - math.sin(slope)  # of the torques, in weights
    wanted = parameters[known_slope.ENERGY] * math.cos(slope) / math.cos(imitated) + pull * moment
    power = pull * moment_rate - gain * energy_error(parameters, slope, wanted, q1, q2, dq)
    hip_speed = (ratio - 1.0) * dq[0] + dq[1]  # power per hip torque
    hip = power * hip_speed / max(hip_speed * hip_speed, band * band)
    out[0], out[1] = ratio * hip, hip


EnergyConstraintController.torque_law = staticmethod(_torque)
