"""The steady rolling of a rimless wheel down a slope, in closed form but for its period."""

from __future__ import annotations

import math
from dataclasses import dataclass, field

import numpy as np
import scipy
from numpy.typing import NDArray

from mjbiped.errors import GaitError
from mjbiped.gaits.gait import Passive
from mjbiped.robots.robot import Array
from mjbiped.robots.wheel import RimlessWheel
from mjbiped.utils import domains


@dataclass(frozen=True, repr=False)
class Rolling(Passive):
    """The steady rolling of a rimless wheel; see `Passive`. It has one multiplier, that of the rate after impacts."""

    robot: RimlessWheel
    slope: float
    start: Array = field(compare=False)
    period: float
    step_length: float
    multipliers: NDArray[np.complex128] = field(compare=False)


def find_rolling(robot: RimlessWheel, slope: float) -> Rolling:
    """The steady rolling of a wheel down a slope, rad.

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
        raise GaitError(f"a wheel of {robot.spokes} spokes does not roll steadily on {math.degrees(slope):.4g} degrees")
    period, _ = scipy.integrate.quad(lambda angle: 1 / math.sqrt(squared(angle)), -half, half)
    multiplier = np.array([robot.kept**2], dtype=np.complex128)
    return Rolling(robot, slope, np.array([-half, rate]), period, 2 * robot.length * math.sin(half), multiplier)
