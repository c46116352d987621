"""Theorem 1 on the limit cycle, where it depends on robot, gait and gains alone: transition, impact and return map."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from mjbiped.analysis.error_dynamics import (
    ESTIMATES,
    SIZE,
    Evolution,
    evolve,
    impact_matrix,
    lyapunov_weights,
)
from mjbiped.control.tracking import AdaptiveTracking
from mjbiped.gaits.cycle import eigenvalues
from mjbiped.robots.compass import Array


class Envelope(NamedTuple):
    """The bound (23) of the norm of Phi over a step, gain exp(-rate (t - t_0)), which is sharp at its end.

    Attributes:
        gain: k_C.
        rate: lambda_alpha, 1/s.
    """

    gain: float
    rate: float


def envelope(time: Array, transitions: Array) -> Envelope:
    """The bound (23) with the smallest k_C among those whose value at the end is the norm of Phi there.

    No other pair of constants makes the left side of (24) smaller, for none can be below the norm itself.

    Args:
        time: Shape (n,), s.
        transitions: Phi(t, t_0) at them, shape (n, 6, 6).
    """
    logs = np.log(np.linalg.norm(transitions, 2, axis=(1, 2)))
    left = time[-1] - time[:-1]
    rate = float(np.max((logs[:-1] - logs[-1]) / left))
    return Envelope(math.exp(logs[-1] + rate * (time[-1] - time[0])), rate)


@dataclass(frozen=True, eq=False)
class CycleStability:
    """What becomes of small errors on the limit cycle, on ground of any constant slope.

    The cycle's angles are measured from the ground, and so is all of (22): nothing here depends on the slope.

    Attributes:
        evolution: Of (22) over a period, with q = q_r.
        envelope: The constants of (23).
        impact: eta after a touchdown from eta before it, to first order, shape (6, 6). The touchdown comes when the
            swing foot meets the ground, not when the reference would: the error moves it in time.
        alpha: Of (19), to first order: how the error of the angles makes one of the rates.
        beta: Of (19): norm of the impact map.
        return_map: eta after a touchdown from eta after the one before it, shape (6, 6).
    """

    evolution: Evolution
    envelope: Envelope
    impact: Array
    alpha: float
    beta: float
    return_map: Array

    def __repr__(self) -> str:
        """One line; the matrices are long."""
        largest = abs(self.multipliers[0])
        return f"<CycleStability: contraction {self.contraction:.6g} a step, largest multiplier {largest:.6g}>"

    @property
    def contraction(self) -> float:
        """Norm of Phi over the period: the sharp k_C exp(-lambda T) of (23)."""
        return float(np.linalg.norm(self.evolution.transitions[-1], 2))

    @property
    def multipliers(self) -> NDArray[np.complex128]:
        """Eigenvalues of the return map, largest modulus first; the loop is stable where all lie in the unit circle."""
        return eigenvalues(self.return_map)

    @property
    def multipliers_replanned(self) -> NDArray[np.complex128]:
        """The same where each step is re-planned to begin without tracking error: of the estimates alone."""
        return eigenvalues(self.evolution.transitions[-1][ESTIMATES, ESTIMATES])


def cycle_stability(controller: AdaptiveTracking, intervals: int = 200) -> CycleStability:
    """Theorem 1's constants on the limit cycle, where they depend on robot, gait and gains alone.

    Args:
        controller: The law; its re-planning and its update (27) do not act in the neighbourhood of the cycle.
        intervals: Of the period; the error is of fourth order in their width.
    """
    gait = controller.gait
    time = np.linspace(0.0, gait.period, intervals + 1)
    q, dq, ddq = gait.reference(time)
    evolution = evolve(controller, time, q, dq)
    phi = evolution.transitions[-1]
    impact, alpha, beta = _impact(controller, q[-1], dq[-1], ddq[-1])
    return CycleStability(evolution, envelope(time, evolution.transitions), impact, alpha, beta, impact @ phi)


def _impact(controller: AdaptiveTracking, q: Array, dq: Array, ddq: Array) -> tuple[Array, float, float]:
    """First-order map of eta at a touchdown of the cycle, whose state before it is q, dq, ddq; alpha and beta of (19).

    The robot is at q - z1 and meets the ground later by t with sum(q + dq t - z1) = 0; the reference begins anew.
    """
    constants = controller.robot.constants
    swap = np.array([[0.0, 1.0], [1.0, 0.0]])
    delay = np.array([1.0, 1.0]) / dq.sum()  # t per z1
    moved = np.outer(dq, delay) - np.eye(2)  # of the posture at touchdown, per z1
    hit = impact_matrix(constants, q)
    step = 1e-5  # central differences: truncation and rounding both some 1e-10
    turn = np.column_stack(
        [
            (impact_matrix(constants, q + step * unit) - impact_matrix(constants, q - step * unit)) @ dq / (2 * step)
            for unit in np.eye(2)
        ]
    )
    z1_z1 = -swap @ moved
    dz1_z1 = -(turn @ moved + hit @ np.outer(ddq, delay))
    gain = controller.position_gain
    result = np.eye(SIZE)
    # z2 = dz1 + K1 z1 on both sides
    result[0:2, 0:2], result[0:2, 2:4] = z1_z1, 0.0
    result[2:4, 0:2] = gain * z1_z1 + dz1_z1 - gain * hit
    result[2:4, 2:4] = hit
    return result, float(np.linalg.norm(dz1_z1, 2)), float(np.linalg.norm(hit, 2))


def lyapunov_gain(controller: AdaptiveTracking, transition: Array) -> float:
    """Largest V_a at the end of a stretch over V_a at its start, of all first errors; at most 1 by (17)."""
    root = np.sqrt(lyapunov_weights(controller))
    return float(np.linalg.norm(root[:, None] * transition / root, 2)) ** 2
