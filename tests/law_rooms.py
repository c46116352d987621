"""What the tests of the paper's law share: its parts, with parameters of a robot's own and a room of numbers."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np

from mjbiped.controllers import layout
from mjbiped.controllers.dynamics import inverse_dynamics, observe, write_torques
from mjbiped.controllers.room import ANGLES, ERROR, REFERENCE, ROOM
from mjbiped.controllers.slope_estimator import estimate_rates
from mjbiped.controllers.tracking import aim
from mjbiped.robots.chain import Array
from mjbiped.robots.compass import Compass

Reference = tuple[Array, Array, Array]
"""Angles (rad), rates and accelerations that are tracked."""


def parameters_of(robot: Compass, k1: float = 5.0, k2: float = 12.0, more: Any = ()) -> list[float]:
    """Parameters of the law of a compass biped without a gait."""
    gains = {layout.POSITION_GAIN: k1, layout.ON_ANGLE: k1 * k2 + 1.0, layout.ON_RATE: k1 + k2}
    return layout.flat(
        {layout.SEGMENTS: 2, **gains, **dict(more)}, {layout.FREE: layout.chain_block(*robot.chains[2][:3])}
    )


def chain_at(parameters: Sequence[float]) -> tuple[Sequence[float], int, int]:
    """Arguments that say where the chain of two segments stands."""
    return parameters, int(parameters[layout.FREE]), 2


def room_at(q: Sequence[float] | Array, dq: Sequence[float] | Array) -> list[float]:
    """A room with a state."""
    room = [0.0] * (ROOM + 48)
    observe(len(q), [float(each) for each in q], [float(each) for each in dq], room)
    return room


def aimed(parameters: Sequence[float], reference: Reference, q: Array, dq: Array) -> list[float]:
    """A room with a state, a reference, and what (12) asks for."""
    room = room_at(q, dq)
    for kind, values in enumerate(reference):
        for i, value in enumerate(values):
            room[REFERENCE + ANGLES * kind + i] = float(value)
    aim(parameters, 2, room)
    return room


def tracking_torque(
    parameters: Sequence[float], reference: Reference, q: Array, dq: Array, estimate: tuple[float, float]
) -> Array:
    """Torques of (12), or (14) with estimates of the slope's sine and cosine, N m."""
    room, out = aimed(parameters, reference, q, dq), [0.0, 0.0]
    inverse_dynamics(*chain_at(parameters), estimate, room)
    write_torques(2, room, out, 0)
    return np.array(out)


def rates_of(parameters: Sequence[float], gamma: float, q: Array, z2: Array) -> tuple[float, float]:
    """Rates of the estimates by (17) with errors z2, 1/s."""
    room = room_at(q, (0.0, 0.0))
    room[ERROR], room[ERROR + 1] = map(float, z2)
    return estimate_rates(gamma, *chain_at(parameters), room)
