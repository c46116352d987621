"""What the tests of the comparison controllers share: a motion under control in matrices, and walks in plain Python."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import fields
from typing import Any

import numpy as np
from hypothesis import strategies as st
from scipy.integrate import solve_ivp

from mjbiped.controllers.comparison.known_slope import KnownSlopeController
from mjbiped.robots.compass import Array

angles, rates = st.floats(-0.6, 0.6), st.floats(-4.0, 4.0)
states = st.tuples(angles, angles, rates, rates).map(np.array)
slopes = st.floats(-0.3, 0.3)


def memory_on(controller: KnownSlopeController, tilt: float = 0.0) -> list[float]:
    """Memory on ground of the slope given, after a touchdown with the line through the feet tilted from the ground."""
    memory = [0.0] * controller.memory_size
    controller.start(memory, (0.0, 0.0), (0.0, 0.0))
    controller.on_touchdown(memory, (tilt - 0.2, tilt + 0.2), (tilt + 0.2, tilt - 0.2), (0.0, 0.0))
    return memory


def power(controller: KnownSlopeController, memory: list[float], state: Array) -> float:
    """Power of ankle and hip, W: the rate of the true energy."""
    ankle, hip = controller.torque(memory, 0.0, state[:2].tolist(), state[2:].tolist())
    return float(ankle * state[2] + hip * (state[3] - state[2]))


def motion(controller: KnownSlopeController, tilt: float, start: Sequence[float], times: Array) -> Array:
    """States at some times of a step under control on ground of the slope given, shape (n, 4); eq. (1) in matrices."""
    robot, memory, slope = controller.robot, memory_on(controller, tilt), controller.initial_slope_estimate

    def rate(t: float, state: Array) -> Array:
        q, dq = state[:2], state[2:]
        torque = np.array(controller.torque(memory, t, q.tolist(), dq.tolist()))
        force = robot.input_matrix @ torque - robot.coriolis_matrix(q, dq) @ dq - robot.gravity_vector(q, slope)
        return np.concatenate([dq, np.linalg.solve(robot.mass_matrix(q), force)])

    done = solve_ivp(rate, (0.0, times[-1]), start, method="DOP853", t_eval=times, rtol=1e-12, atol=1e-13)
    assert done.success
    return np.asarray(done.y.T)


def in_plain_python(controller: KnownSlopeController) -> KnownSlopeController:
    """The same controller, of a class that no engine compiles: a short walk is then sooner done."""
    kind = type(controller)
    plain: Any = type(f"Plain{kind.__name__}", (kind,), {"torque": lambda self, *state: kind.torque(self, *state)})
    copy: KnownSlopeController = plain(**{each.name: getattr(controller, each.name) for each in fields(controller)})
    return copy
