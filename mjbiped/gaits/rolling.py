"""The steady rolling of a rimless wheel down a slope, in closed form but for its motion between two impacts."""

from __future__ import annotations

import math
from dataclasses import dataclass, field
from typing import Any

import numpy as np
import scipy
from numpy.typing import ArrayLike, NDArray

from mjbiped.errors import GaitError
from mjbiped.gaits.gait import Passive
from mjbiped.robots.robot import Array
from mjbiped.robots.wheel import RimlessWheel
from mjbiped.utils import domains


@dataclass(frozen=True, repr=False)
class Rolling(Passive):
    """The steady rolling of a rimless wheel; see `Passive`.

    Attributes:
        robot: The wheel.
        slope: Slope of the plane, rad, positive downhill.
        start: Angle (rad) and rate (rad/s) of the stance spoke just after an impact, shape (2,).
        end: The same just before the next impact.
        period: Time between impacts, s.
        step_length: Distance between the feet of two neighbouring spokes, m.
        multipliers: The one multiplier, that of the rate after impacts, shape (1,).
    """

    robot: RimlessWheel
    slope: float
    start: Array = field(compare=False)
    end: Array = field(compare=False)
    period: float
    step_length: float
    multipliers: NDArray[np.complex128] = field(compare=False)

    @property
    def energy(self) -> float:
        """Energy about the stance foot, J."""
        return self.robot.energy(self.start[:1], self.start[1:], self.slope)

    @property
    def horizon(self) -> float:
        """Time up to which `reference` moves, s."""
        return self.period

    def reference(self, t: ArrayLike) -> tuple[Array, Array, Array]:
        """Angle (rad), rate and acceleration of the stance spoke at times t since the impact, s.

        Each is of shape t.shape + (1,).
        """
        times, robot = domains.TIME.array("t", t, None), self.robot
        pull = robot.weight * robot.length / robot.mass_matrix([0.0])[0, 0]

        def rates(_: float, state: Array) -> Array:
            return np.array([state[1], pull * math.sin(state[0] + self.slope)])

        moments, places = np.unique(times, return_inverse=True)
        span = 0.0, max(self.period, moments[-1])
        solver: dict[str, Any] = {"method": "DOP853", "rtol": 1e-11, "atol": 1e-12}
        motion = scipy.integrate.solve_ivp(rates, span, self.start, t_eval=moments, **solver).y.T
        q, dq = np.moveaxis(motion[places.ravel()].reshape(*times.shape, 2, 1), -2, 0)
        return q, dq, pull * np.sin(q + self.slope)


def find_rolling(robot: RimlessWheel, slope: float) -> Rolling:
    """Find the steady rolling of a wheel down a slope, rad.

    Raises:
        InputError: The slope is outside its domain.
        GaitError: The wheel does not roll on: the slope does not give what the impacts take.
    """
    slope, half = domains.SLOPE.check("slope", slope), robot.between / 2
    rate, inertia = robot.rolling_rate(slope), float(robot.mass_matrix([0.0])[0, 0])

    def squared(angle: float) -> float:
        fall = math.cos(slope - half) - math.cos(angle + slope)
        return rate**2 + 2 * robot.weight * robot.length * fall / inertia

    if slope <= 0.0 or squared(max(-slope, -half)) <= 0.0:
        raise GaitError(
            f"a wheel of {robot.spokes} spokes does not roll steadily on {math.degrees(slope):.4g} degrees; it does on "
            "steeper slopes"
        )
    return Rolling(
        robot,
        slope,
        start=np.array([-half, rate]),
        end=np.array([half, rate / robot.kept]),
        period=scipy.integrate.quad(lambda angle: 1 / math.sqrt(squared(angle)), -half, half)[0],
        step_length=2 * robot.length * math.sin(half),
        multipliers=np.array([robot.kept**2], dtype=np.complex128),
    )
