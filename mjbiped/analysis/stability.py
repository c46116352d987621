"""Theorem 1 along a recorded walk: errors, Lyapunov function, excitation, contraction, and the constants (18)-(26)."""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray
from scipy.interpolate import CubicSpline

from mjbiped.analysis import error_dynamics
from mjbiped.analysis.replay import recorded_controller as recorded_controller
from mjbiped.analysis.replay import replayed
from mjbiped.control.tracking import AdaptiveTracking
from mjbiped.errors import InputError
from mjbiped.records.record import Walk
from mjbiped.robots.compass import Array
from mjbiped.utils.domains import check_kind

RESOLVED = 1e-8
"""Norm of eta below which errors are not evaluated: in the hybrid engine it is the integration's error."""

_SAME_TIME = 1e-9  # s; a sample nearer to a touchdown is the touchdown's own
_FEWEST = 8  # least number of points in a step, its ends included


@dataclass(frozen=True, eq=False)
class Stability:
    """Theorem 1 along a walk. A step goes from one touchdown to the next; the first one from the walk's start.

    "Start" and "end" are those of a step: eta_i^+ after its first touchdown, eta_{i+1}^- before its last. Norms are
    Euclidean over rad, rad/s and pure numbers, as the paper takes them.

    Attributes:
        controller: The law that walked.
        time: Time since the walk's start, s, shape (n,), with both ends of each step, so that touchdowns occur twice.
        step: The step of each time, shape (n,).
        errors: eta = (z1, z2, error of sine, error of cosine), truth minus estimate, shape (n, 6).
        lyapunov: V_a (15), shape (n,).
        slope_change: Change of slope at the touchdown where the step starts, rad, shape (steps,); 0 for the first step.
        start: eta at the step's start, shape (steps, 6).
        end: eta at the step's end, shape (steps, 6).
        gramian: Integral of W W' over the step, shape (steps, 2, 2) in (sine, cosine), 1/s³.
        transition: Phi of (22) over the step, shape (steps, 6, 6).
        alpha: The smallest alpha with which (19) holds at the step's first touchdown with this beta; unbounded where an
            error of the rates arises without one of the angles. NaN for the first step.
        beta: Norm of the impact map in the posture of the touchdown, beta of (19). NaN for the first step.
        impact_gain: k_Delta of (20) from alpha and beta. NaN for the first step.
        residual: Norm of (end - Phi start), shape (steps,): the walk's deviation from (22). In the hybrid engine the
            error of integration and interpolation, unless the swing foot struck a riser.
        balance: V_a(end) - V_a(start) + integral of z1' K1 z1 + z2' K2 z2, shape (steps,): zero by (16) with (17).
    """

    controller: AdaptiveTracking
    time: Array
    step: NDArray[np.int64]
    errors: Array
    lyapunov: Array
    slope_change: Array
    start: Array
    end: Array
    gramian: Array
    transition: Array
    alpha: Array
    beta: Array
    impact_gain: Array
    residual: Array
    balance: Array

    def __repr__(self) -> str:
        """Return a summary in one line; the tables are long."""
        name, holds = type(self.controller).__name__, int((self.condition[1:] < 1.0).sum())
        return f"<Stability of {name} over {self.steps} steps: (24) holds at {holds} of {self.steps - 1} touchdowns>"

    @property
    def steps(self) -> int:
        """Number of whole steps."""
        return len(self.start)

    @property
    def excitation(self) -> Array:
        """Eigenvalues of the Gramian, smaller first, shape (steps, 2), 1/s³: persistent excitation is that both > 0."""
        return np.asarray(np.linalg.eigvalsh(self.gramian), dtype=np.float64)

    @property
    def weak_direction(self) -> Array:
        """Angle between the smaller eigenvalue's direction and the cosine's axis, rad, 0 to pi/2, shape (steps,)."""
        weak = np.abs(np.linalg.eigh(self.gramian).eigenvectors[:, :, 0])
        return np.asarray(np.arctan2(weak[:, 0], weak[:, 1]), dtype=np.float64)

    @property
    def contraction(self) -> Array:
        """Norm of Phi: the smallest that k_C exp(-lambda T) of (23) can be, shape (steps,)."""
        return np.asarray(np.linalg.norm(self.transition, 2, axis=(1, 2)), dtype=np.float64)

    @property
    def condition(self) -> Array:
        """Left side of (24), shape (steps,); (24) holds where it is below 1. NaN for the first step."""
        return self.impact_gain * self.contraction

    @property
    def condition_floor(self) -> Array:
        """Left side of (24) with alpha = beta = 0, shape (steps,): no constants make (24) true unless it is below 1."""
        return error_dynamics.impact_gain(self.controller.position_gain, 0.0, 0.0) * self.contraction

    @property
    def ratio(self) -> Array:
        """Norm of eta at the step's end over that at the end of the step before, (26), shape (steps,).

        NaN for the first step, and where both are below `RESOLVED`.
        """
        norms = np.linalg.norm(self.end, axis=1)
        return np.append(np.nan, _ratio(norms[1:], norms[:-1]))

    @property
    def impact_ratio(self) -> Array:
        """Norm of eta after a touchdown over that before it, (21), shape (steps,); NaN as in `ratio`."""
        before, after = np.linalg.norm(self.end, axis=1), np.linalg.norm(self.start, axis=1)
        return np.append(np.nan, _ratio(after[1:], before[:-1]))

    @property
    def lyapunov_jump(self) -> Array:
        """Change of V_a at the touchdown where the step starts, shape (steps,); NaN for the first step."""
        values = 0.5 * np.stack([self.start, self.end]) ** 2 @ error_dynamics.lyapunov_weights(self.controller)
        return np.append(np.nan, values[0, 1:] - values[1, :-1])

    @property
    def estimate_rise(self) -> Array:
        """Largest norm of the estimates' error in the step less that at its start, shape (steps,)."""
        norms = np.linalg.norm(self.errors[:, error_dynamics.ESTIMATES], axis=1)
        largest = np.array([norms[self.step == step].max() for step in range(self.steps)])
        return np.asarray(largest - np.linalg.norm(self.start[:, error_dynamics.ESTIMATES], axis=1), dtype=np.float64)


def stability(walk: Walk, controller: AdaptiveTracking | None = None) -> Stability:
    """Evaluate Theorem 1 along a walk.

    The errors are those of the recorded states; between samples angles are interpolated, with an error of fourth order
    in the sample period. In the hybrid engine the residuals are below 1e-9 up to 8 ms; in MuJoCo the timestep counts
    (0.1 ms: 1.4e-3).

    Args:
        walk: A walk of an adaptive controller, in either engine, with at least one touchdown.
        controller: The law that walked, where the record does not say it: an object of a derived class.

    Raises:
        InputError: The walk has no step, too few samples, another controller, or numbers that are none or too great.
    """
    controller = recorded_controller(walk) if controller is None else controller
    check_kind("controller", controller, AdaptiveTracking)  # type: ignore[type-abstract]
    if walk.steps == 0:
        raise InputError("the walk has no touchdown: there is no whole step to look at")
    with np.errstate(over="ignore", invalid="ignore"):  # what is no number then is told below, or in `_steps`
        try:
            walked = list(_steps(walk, controller))
            rows = [_evaluate(controller, step) for step in walked]
        except (np.linalg.LinAlgError, ArithmeticError) as error:
            raise InputError(f"the walk holds numbers that are too great to compute with: {error}") from error
    start, end = (np.array([step.errors[place] for step in walked]) for place in (0, -1))
    alpha, beta, gain = _impacts(walk, controller, start, end)
    errors = np.concatenate([step.errors for step in walked])
    slope = np.append(walk.terrain.slope_at(0.0), walk.touchdowns["slope"])[:-1]
    return Stability(
        controller=controller,
        time=np.concatenate([step.time for step in walked]),
        step=np.repeat(np.arange(len(walked)), [len(step.time) for step in walked]),
        errors=errors,
        lyapunov=0.5 * errors**2 @ error_dynamics.lyapunov_weights(controller),
        slope_change=np.diff(slope, prepend=slope[0]),
        start=start,
        end=end,
        alpha=alpha,
        beta=beta,
        impact_gain=gain,
        **{name: np.array([row[name] for row in rows]) for name in rows[0]},
    )


class _Step(NamedTuple):
    """A step's motion at its samples and at both its ends."""

    time: Array
    q: Array
    dq: Array
    errors: Array


def _steps(walk: Walk, controller: AdaptiveTracking) -> Iterator[_Step]:
    """The steps, with the controller's memory replayed through the touchdowns: it holds the references.

    Raises:
        InputError: A step has too few samples, or holds what is no finite number.
    """
    samples, touchdowns = walk.samples, walk.touchdowns
    for number, (started, memory) in enumerate(replayed(walk, controller)):
        if number == walk.steps:
            return
        row: dict[str, Any] = {name: column[number].tolist() for name, column in touchdowns.items()}
        inside = (samples["time"] > started.time + _SAME_TIME) & (samples["time"] < row["time"] - _SAME_TIME)
        if inside.sum() < _FEWEST - 2:
            raise InputError(
                f"step {number + 1} of {row['time'] - started.time:.3g} s has only {inside.sum()} samples; "
                "record the walk with a shorter sample_period (5e-3 s is the default)"
            )
        time = np.array([started.time, *samples["time"][inside], row["time"]])
        angles = np.vstack([started.q, samples["q"][inside], row["q_before"]])
        rates = np.vstack([started.dq, samples["dq"][inside], row["dq_before"]])
        tracking = np.array(
            [
                controller.tracking_errors(memory, t, a, r)
                for t, a, r in zip((time - started.time).tolist(), angles.tolist(), rates.tolist(), strict=True)
            ]
        )
        z1, z2 = tracking[:, 0:2], tracking[:, 4:6]
        estimates = np.vstack([memory[:2], samples["controller_states"][inside, :2]])
        # (17) from the last sample to the touchdown, which the record does not hold
        late = slice(-4, None)
        w = error_dynamics.regressor(controller.robot.constants, angles[late])
        adaptation = controller.adaptation_gain * (w @ z2[late, :, None])[:, :, 0]
        if not all(np.isfinite(values**2).all() for values in (tracking, estimates, adaptation)):
            raise InputError(f"step {number + 1} of the walk holds what is no finite number, or becomes none")
        gained = CubicSpline(time[late], adaptation).integrate(time[-2], time[-1])
        estimates = np.vstack([estimates, estimates[-1] + gained])
        memory[:2] = estimates[-1].tolist()
        truth = [math.sin(started.slope), math.cos(started.slope)]
        yield _Step(time, angles, rates, np.hstack([z1, z2, truth - estimates]))


def _evaluate(controller: AdaptiveTracking, step: _Step) -> dict[str, object]:
    """Excitation, transition matrix and balances of a step."""
    evolution = error_dynamics.evolve(controller, step.time, step.q, step.dq)
    phi = evolution.transitions[-1]
    first, last = 0.5 * step.errors[[0, -1]] ** 2 @ error_dynamics.lyapunov_weights(controller)
    lost = CubicSpline(step.time, _dissipation(controller, step.errors)).integrate(step.time[0], step.time[-1])
    return {
        "gramian": evolution.gramian,
        "transition": phi,
        "residual": float(np.linalg.norm(step.errors[-1] - phi @ step.errors[0])),
        "balance": float(last - first + lost),
    }


def _dissipation(controller: AdaptiveTracking, errors: Array) -> Array:
    """z1' K1 z1 + z2' K2 z2 of errors of shape (n, 6)."""
    gains = np.repeat([controller.position_gain, controller.velocity_gain, 0.0], error_dynamics.SIZE // 3)
    return np.asarray(errors**2 @ gains, dtype=np.float64)


def _impacts(walk: Walk, controller: AdaptiveTracking, start: Array, end: Array) -> tuple[Array, Array, Array]:
    """Find alpha and beta of (19) and k_Delta of (20) at the touchdown where each step starts; NaN for the first."""
    gain = controller.position_gain
    z1 = np.linalg.norm(end[:-1, 0:2], axis=1)
    before, after = (np.linalg.norm(eta[:, 2:4] - gain * eta[:, 0:2], axis=1) for eta in (end[:-1], start[1:]))
    maps = [error_dynamics.impact_matrix(controller.robot.constants, q) for q in walk.touchdowns["q_before"][:-1]]
    beta = np.array([np.linalg.norm(matrix, 2) for matrix in maps])
    made = np.maximum(0.0, after - beta * before)
    with np.errstate(divide="ignore", invalid="ignore"):
        alpha = np.where(made < RESOLVED, 0.0, made / z1)
    total = [error_dynamics.impact_gain(gain, *pair) for pair in zip(alpha.tolist(), beta.tolist(), strict=True)]
    return np.append(np.nan, alpha), np.append(np.nan, beta), np.append(np.nan, total)


def _ratio(above: Array, below: Array) -> Array:
    """Divide norms: infinite where only the lower one is zero, NaN where neither is resolved."""
    with np.errstate(divide="ignore", invalid="ignore"):
        return np.where(np.maximum(above, below) < RESOLVED, np.nan, above / below)
