"""The steps of both robots as the reference optimiser takes them: their laws of motion on arrays.

With knees, stance leg and swing thigh follow Bézier curves over the whole step. The flexion of the swing knee follows
one until the knee strikes its stop, and is zero from then on. The strike changes the rates of both by the robot's
impact map; that change is added to their curves afterwards, and fades until the heel strike. So either branch of the
motion, with the knee bent and with the knee straight, can be carried on beyond the strike, for a knee that strikes late
or early.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any, ClassVar, NamedTuple

import numpy as np

from mjbiped.gaits.optimisation import Course, Goal, Motion, StepModel
from mjbiped.gaits.pieces import DEGREE, Numbers, curve
from mjbiped.robots import compass
from mjbiped.robots.compass import Compass
from mjbiped.robots.kneed import KneedBiped
from mjbiped.robots.kneed_legs import SWING_LOCKED
from mjbiped.robots.robot import Array

REACH = 0.2  # of the compass, leg lengths ahead of the stance foot: from there on the swing foot may touch the ground
_CORNER = 1e-3  # leg lengths: how much the corner of "above the ground or not yet ahead" is rounded
RISEN = 0.25  # phase from which on the swing foot has its clearance, which rises smoothly until then
LANDS = 0.12  # phases before the end, until which the foot is lifted by `KneedStep.lifted` at least
KNEE_STRIKE = 0.88  # phase at which the knee strikes its stop
KNEE_RATES = (0.1, 0.3)  # least and greatest closing rate at the strike, sqrt(g/l): soft, but sure to reach the stop
GREATEST_FLEXION = 2.0  # upper bound of the flexion's control points, rad
STRAIGHTENS = 0.02  # least difference between the phases of clearance and knee strike


@dataclass(frozen=True)
class CompassStep(StepModel):
    """The step of the compass biped.

    The laws are those of `mjbiped.robots.compass`, whose functions of plain numbers take arrays as well.
    """

    robot: Compass
    intervals: ClassVar[Sequence[int]] = (48, 32)
    starts: ClassVar[Sequence[tuple[float, float]]] = ((0.15, 0.86), (0.22, 0.80))

    def rates_after_impact(self, half: Numbers, rates: Numbers) -> Numbers:
        """Rates after the impact of rates before it (eq. 2), rad/s."""
        legs: Any = (-np.sin(half), np.cos(half), np.sin(half), np.cos(half))
        cosine: Any = np.cos(2.0 * half)
        after = compass.rates_after_impact(self.robot.constants, legs, cosine, *np.moveaxis(rates, -1, 0))
        return np.stack(after, axis=-1)

    def along(self, motion: Motion, stretches: Sequence[Numbers]) -> Course:
        """Dynamics of a motion at phases in all stretches."""
        return self.course(*curve(motion.points, np.concatenate(stretches, axis=-1), motion.period))

    def keeps(self, goal: Goal, motion: Motion, course: Course, phases: Numbers, second: int) -> dict[str, Numbers]:
        """Keep the foot above the ground wherever it might touch it."""
        # the greater of height and what is missing to the reach, rounded
        height = course.height[..., :-1] / self.robot.leg_length
        missing = REACH - course.ahead[..., :-1] / self.robot.leg_length
        greater = 0.5 * (height + missing + np.sqrt((height - missing) ** 2 + _CORNER**2) - _CORNER)
        return {"foot above the ground": greater + 0.5 * _CORNER}  # just above zero at the end, where the foot lands

    def course(self, q: Numbers, dq: Numbers, ddq: Numbers) -> Course:
        """Inverse dynamics (eq. 1) and the swing foot's path (eq. 4)."""
        constants, length = self.robot.constants, self.robot.leg_length
        (q1, q2), (dq1, dq2), (ddq1, ddq2) = (tuple(np.moveaxis(each, -1, 0)) for each in (q, dq, ddq))
        legs: Any = np.sin(q1), np.cos(q1), np.sin(q2), np.cos(q2)
        m11, m12, m22 = compass.mass_terms(constants, legs)
        c1, c2 = compass.coriolis_terms(constants, legs, dq1, dq2)
        _, _, g1, g2 = compass.gravity_terms(constants, legs)
        ankle, hip = compass.joint_torques(m11 * ddq1 + m12 * ddq2 + c1 + g1, m12 * ddq1 + m22 * ddq2 + c2 + g2)
        forward, upward = compass.ground_force(
            constants, self.robot.total_mass, self.robot.gravity, legs, dq1, dq2, ddq1, ddq2
        )
        sine1, cosine1, sine2, cosine2 = legs
        ahead, height = compass.swing_foot(length, legs)
        return Course(
            torques=np.stack(np.broadcast_arrays(ankle, hip), axis=-1),
            powers=np.stack([ankle * dq1, hip * (dq2 - dq1)], axis=-1),
            tangential_force=np.asarray(forward),
            normal_force=np.asarray(upward),
            ahead=np.asarray(ahead),
            height=np.asarray(height),
            ahead_rate=length * (cosine1 * dq1 - cosine2 * dq2),
            height_rate=length * (sine2 * dq2 - sine1 * dq1),
        )


class Moved(NamedTuple):
    """Part of a motion, shapes (..., m, angles): three with the knee bent, two with the knee straight."""

    q: Numbers
    dq: Numbers
    ddq: Numbers


@dataclass(frozen=True)
class KneedStep(StepModel):
    """The step of the biped with knees.

    Its own numbers are the five control points of the flexion that are not zero.
    """

    robot: KneedBiped
    own: ClassVar[Sequence[tuple[float, float]]] = ((0.0, GREATEST_FLEXION),) * 5
    intervals: ClassVar[Sequence[int]] = (40, 16, 16)
    starts: ClassVar[Sequence[tuple[float, float]]] = ((0.22, 0.80), (0.15, 0.60))
    lifted: ClassVar[float] = 0.005

    def rates_after_impact(self, half: Numbers, rates: Numbers) -> Numbers:
        """Rates of stance and swing leg after the heel strike, of rates before it, rad/s."""
        chain = self.robot.chains[2]
        _, before = self.postures(half)
        about, _ = _weighted(chain.about_end, before)
        onto, _ = _weighted(chain.onto_end, before)
        return _solved(about, _times(onto, rates))[..., ::-1]

    def breaks(self, own: Numbers) -> tuple[Numbers, ...]:
        """The phase of the knee strike."""
        return (np.full_like(own[..., 0], KNEE_STRIKE),)

    def bent(self, motion: Motion, phases: Numbers) -> Moved:
        """Stance leg, swing thigh and swing shank at phases up to the knee strike, shape (..., m)."""
        legs = curve(motion.points, phases, motion.period)
        flexion = curve(flexion_points(motion.own), phases / KNEE_STRIKE, KNEE_STRIKE * motion.period)
        return Moved(*(np.concatenate([leg, leg[..., 1:] + knee], -1) for leg, knee in zip(legs, flexion, strict=True)))

    def straight(self, motion: Motion, phases: Numbers) -> Moved:
        """Stance and swing leg at phases after the knee strike, shape (..., m)."""
        left = (1.0 - KNEE_STRIKE) * motion.period[..., None]
        x = (phases - KNEE_STRIKE) / (1.0 - KNEE_STRIKE)
        fading = (left * x * (1.0 - x) ** 2, (1.0 - x) * (1.0 - 3.0 * x), (6.0 * x - 4.0) / left)
        change = self.knee_strike(motion)[..., None, :]
        legs = curve(motion.points, phases, motion.period)
        return Moved(*(leg + change * each[..., None] for leg, each in zip(legs, fading, strict=True)))

    def knee_strike(self, motion: Motion) -> Numbers:
        """Change of the rates of stance leg and thigh in the knee strike, rad/s, shape (..., 2)."""
        q, dq, _ = (each[..., 0, :] for each in self.bent(motion, np.array([KNEE_STRIKE])))
        matrix, _ = _weighted(self.robot.chains[3].weights, q)
        groups = SWING_LOCKED
        return _solved(groups.T @ matrix @ groups, _times(groups.T @ matrix, dq)) - dq[..., :2]

    def along(self, motion: Motion, stretches: Sequence[Numbers]) -> Course:
        """Dynamics of a motion whose knee is bent in all stretches but the last."""
        bent = self.course(*self.bent(motion, np.concatenate(stretches[:-1], axis=-1)))
        straight = self.course(*self.straight(motion, stretches[-1]))
        axes = [-2 if name in ("torques", "powers") else -1 for name in Course._fields]
        return Course(*(np.concatenate(pair, axis) for *pair, axis in zip(bent, straight, axes, strict=True)))

    def course(self, q: Numbers, dq: Numbers, ddq: Numbers) -> Course:
        """Inverse dynamics and the swing foot's path, for three angles or, with the knee locked, for two."""
        chain = self.robot.chains[q.shape[-1]]
        even, odd = _weighted(chain.weights, q)
        forces = _times(even, ddq) + _times(odd, dq * dq) - chain.moments * np.sin(q)
        torques = np.cumsum(forces[..., ::-1], axis=-1)[..., ::-1]  # each joint moves all segments beyond it
        powers = torques * np.concatenate([dq[..., :1], np.diff(dq, axis=-1)], axis=-1)
        if q.shape[-1] == 2:  # the lock bears the knee's torque
            torques, powers = (np.concatenate([each, 0.0 * each[..., :1]], axis=-1) for each in (torques, powers))
        sine, cosine = np.sin(q), np.cos(q)
        levers = chain.moments / chain.gravity
        return Course(
            torques=torques,
            powers=powers,
            tangential_force=(cosine * ddq - sine * dq * dq) @ levers,
            normal_force=chain.mass * chain.gravity - (sine * ddq + cosine * dq * dq) @ levers,
            ahead=sine @ chain.reach,
            height=cosine @ chain.reach,
            ahead_rate=(cosine * dq) @ chain.reach,
            height_rate=-(sine * dq) @ chain.reach,
        )

    def keeps(self, goal: Goal, motion: Motion, course: Course, phases: Numbers, second: int) -> dict[str, Numbers]:
        """Keep the foot above the ground, with its clearance from `RISEN` on; the knee closes softly."""
        last, unit = motion.own[..., -1:], math.sqrt(self.robot.leg_length / self.robot.gravity)
        closing = DEGREE * last * unit / (KNEE_STRIKE * motion.period[..., None])
        risen, lands = _smoothly(phases / RISEN), _smoothly((1.0 - phases) / LANDS)
        height = course.height / self.robot.leg_length
        above = (height - self.lifted * risen * lands)[..., 1:-1]
        until = slice(1, second)  # at the clearance's phase itself it is a constraint of all robots
        cleared = (height - goal.clearance / self.robot.leg_length * risen)[..., until]
        return {
            "foot above the ground": np.concatenate([above, cleared], axis=-1),
            "knee strike": np.concatenate([closing - KNEE_RATES[0], KNEE_RATES[1] - closing], axis=-1),
            "knee straightens": KNEE_STRIKE - STRAIGHTENS - phases[..., second : second + 1],
        }

    def guess(self, half: float) -> tuple[Array, Array]:
        """Control points of straight legs, and of a knee that bends by some 40 degrees."""
        return super().guess(half)[0], np.array([0.4, 1.0, 1.0, 0.4, 0.05])


def flexion_points(own: Numbers) -> Numbers:
    """Control points of the flexion until the knee strike, shape (..., DEGREE + 1, 1), of the robot's own numbers.

    The knee begins straight and at rest, as the heel strike leaves it, and is straight at its strike.
    """
    zero = np.zeros_like(own[..., :1])
    return np.concatenate([zero, zero, own, zero], axis=-1)[..., None]


def _weighted(weights: Array, q: Numbers) -> tuple[Numbers, Numbers]:
    """`mjbiped.robots.chain.weighted` on arrays of angles, shape (..., n): two matrices, shape (..., n, n)."""
    difference = q[..., :, None] - q[..., None, :]
    return weights * np.cos(difference), weights * np.sin(difference)


def _times(matrices: Numbers, vectors: Numbers) -> Numbers:
    return (matrices @ vectors[..., None])[..., 0]


def _solved(matrices: Numbers, vectors: Numbers) -> Numbers:
    return np.asarray(np.linalg.solve(matrices, vectors[..., None])[..., 0])


def _smoothly(x: Numbers) -> Numbers:
    """A cubic that rises from 0 at x = 0 to 1 at x = 1, and is 1 beyond."""
    x = np.where(x.real < 1.0, x, 1.0)
    return np.asarray(x * x * (3.0 - 2.0 * x))
