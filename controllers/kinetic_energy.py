"""Kinetic energy tracking control (KETC), reconstructed: the kinetic energy that the imitated slope asks for."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import NamedTuple

import mjbiped.compass as compass
from controllers.base import Memory
from controllers.given_slope import GivenSlopeController, against_slope
from controllers.virtual_gravity import energy_error, shaped_torque
from mjbiped import domains


class Parameters(NamedTuple):
    """What the law takes: `KineticEnergyController`'s attributes in plain numbers.

    Attributes:
        constants: Of the robot model.
        source: Of the slope.
        imitated_slope: phi_r, rad.
        energy: E_ref, J.
        gain: lambda, 1/s.
        slowest: |dq| below which the law weakens, rad/s.
    """

    constants: compass.Constants
    source: int
    imitated_slope: float
    energy: float
    gain: float
    slowest: float


@dataclass(frozen=True)
class KineticEnergyController(GivenSlopeController):
    r"""Tracks the kinetic energy that a passive gait has in the posture of the moment (KETC, the paper's [19]).

    A reconstruction: the paper says of the method only that it tracks kinetic energy, which on the imitated slope is
    what the gait's energy leaves beside the potential one. Here

    .. math:: T_{ref}(q) = E_{ref} - V(q, \varphi_r), \qquad
              \frac{d}{dt} (T - T_{ref}) = -\lambda (T - T_{ref})

    One condition leaves one of the two torques free. Beside the imitated slope's gravity, which keeps
    :math:`T - T_{ref}` as it is, the forces u are those of least norm, and so lie along the rates:

    .. math:: \tau = B^{-1} [g(q, \varphi) - g(q, \varphi_r) + u], \quad
              u = -\lambda (T - T_{ref}) \frac{\dot q}{|\dot q|^2}

    Thus it is the passivity-based law (`PassivityController`) with :math:`k = \lambda / |\dot q|^2`. Where the rates
    are small, u has no bound; below `slowest` they are divided by its square instead, and the error falls more slowly.
    The gait of Table I's robot on 2 degrees is never slower than 0.62 rad/s.

    The slope is by default the one under the stance foot, which is what the paper's own controller estimates. The gain
    is that of docs/comparison.md.

    Attributes:
        gain: lambda, 1/s.
        slowest: Smallest norm of the two rates at which the law holds, rad/s.
        slope_source: See `GivenSlopeController`, as for all attributes not named here.
    """

    gain: float = 6.0
    slowest: float = 0.1

    def __post_init__(self) -> None:
        """Refuse parameters outside their domain.

        Raises:
            InputError: One is (see `mjbiped.domains`), or as in `GivenSlopeController`.
        """
        super().__post_init__()
        domains.check_fields(self, gain=domains.GAIN, slowest=domains.SLOWEST_RATE)

    @cached_property
    def parameters(self) -> Parameters:
        """The attributes in plain numbers, as the law takes them."""
        return Parameters(
            constants=self.robot.constants,
            source=self.source,
            imitated_slope=float(self.gait.slope),
            energy=self.gait.energy,
            gain=float(self.gain),
            slowest=float(self.slowest),
        )


def _torque(
    parameters: Parameters, memory: Memory, t: float, q1: float, q2: float, dq1: float, dq2: float
) -> tuple[float, float]:
    constants, imitated = parameters.constants, parameters.imitated_slope
    slope, q1, q2 = against_slope(memory, q1, q2)
    error = energy_error(constants, imitated, parameters.energy, q1, q2, dq1, dq2)  # T - T_ref
    damping = parameters.gain * error / max(dq1 * dq1 + dq2 * dq2, parameters.slowest * parameters.slowest)
    return shaped_torque(constants, slope, imitated, q1, q2, -damping * dq1, -damping * dq2)


KineticEnergyController.torque_law = staticmethod(_torque)
