"""The steps of both robots for the reference optimiser: requirements, and equations of motion on arrays.

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
from typing import Annotated, Any, ClassVar, NamedTuple

import numpy as np

from mjbiped.errors import InputError, shown
from mjbiped.gaits.reference import DEGREE, Numbers, curve
from mjbiped.robots.chain import SWING_LOCKED
from mjbiped.robots.robot import Array
from mjbiped.utils import domains

REACH = 0.2  # of the compass, leg lengths ahead of the stance foot: from there on the swing foot may touch the ground
_CORNER = 1e-3  # leg lengths: how much the corner of "above the ground or not yet ahead" is rounded
RISEN = 0.25  # phase from which on the swing foot has its clearance, which rises smoothly until then
LANDS = 0.12  # phases before the end, until which the foot is lifted by `KneedStep.lifted` at least
KNEE_STRIKE = 0.88  # phase at which the knee strikes its stop
KNEE_RATES = (0.1, 0.3)  # least and greatest closing rate at the strike, sqrt(g/l): soft, but sure to reach the stop
GREATEST_FLEXION = 2.0  # upper bound of the flexion's control points, rad
STRAIGHTENS = 0.02  # least difference between the phases of clearance and knee strike


@dataclass(frozen=True)
class Goal:
    """Requirements on a reference.

    Attributes:
        speed: Mean speed, m/s.
        clearance: Height of the swing foot over level ground at some moment, m; 0 constrains only the place where the
            foot lands.
        retraction: Whether the foot stops moving forward from that moment on; without retraction the height costs less.
        torque_limit: Greatest torque of each joint, N m; no limit unless given.
        friction: Greatest ratio of tangential to normal force on the stance foot.

    Raises:
        InputError: One is outside its domain.
    """

    speed: Annotated[float, domains.SPEED]
    clearance: Annotated[float, domains.CLEARANCE]
    retraction: bool
    torque_limit: Annotated[float | None, domains.Domain(1e-9, 1e9, "N m")]
    friction: Annotated[float, domains.Domain(1e-3, 100.0)]

    def __post_init__(self) -> None:
        """Check the values."""
        domains.check_fields(self)
        if not isinstance(self.retraction, bool):
            raise InputError(f"retraction = {shown(self.retraction)}: must be True or False")


class Course(NamedTuple):
    """Dynamics along a motion at m moments: shapes (..., m), torques and powers (..., m, actuators).

    Attributes:
        torques: Torques of the actuators, N m.
        powers: Powers of the actuators, W.
        tangential_force: Tangential force of the ground on the stance foot, N.
        normal_force: Normal force of the ground on the stance foot, N.
        ahead: Distance of the swing foot ahead of the stance foot, m.
        height: Height of the swing foot over the ground, m.
        ahead_rate: Rate of `ahead`, m/s.
        height_rate: Rate of `height`, m/s.
    """

    torques: Numbers
    powers: Numbers
    tangential_force: Numbers
    normal_force: Numbers
    ahead: Numbers
    height: Numbers
    ahead_rate: Numbers
    height_rate: Numbers


class Motion(NamedTuple):
    """A step that is tried; shapes may have further axes in front.

    Attributes:
        half: Half the angle between the legs at the impact, rad.
        points: Control points, rad, shape (..., DEGREE + 1, joints).
        own: Numbers that the robot adds, shape (..., n).
        period: Duration of the step, s.
    """

    half: Numbers
    points: Numbers
    own: Numbers
    period: Numbers


@dataclass(frozen=True)
class CompassStep:
    """The step of a robot with straight legs on level ground, and what those of all robots have in common.

    It begins and ends on two straight legs. Its functions take complex arrays, and are analytic in them.

    Attributes:
        robot: The robot that walks.
        joints: Number of angles that are Bézier curves over the whole step.
        own: Bounds of the numbers that the robot adds, each of the kind (least, greatest).
        breaks: Phases after the clearance's at which the motion changes abruptly.
        intervals: Intervals of the quadrature between the moments at which something changes abruptly: the clearance's
            phase and those of `breaks`. All even.
        starts: Half angles (rad) and phases of clearance from which searches begin.
        lifted: Leg lengths by which the foot is lifted even where no clearance is asked for; 0: it may scuff.
    """

    robot: Any
    joints: ClassVar[int] = 2
    own: ClassVar[Sequence[tuple[float, float]]] = ()
    breaks: ClassVar[Sequence[float]] = ()
    intervals: ClassVar[Sequence[int]] = (48, 32)
    starts: ClassVar[Sequence[tuple[float, float]]] = ((0.15, 0.86), (0.22, 0.80))
    lifted: ClassVar[float] = 0.0

    def postures(self, half: Numbers) -> tuple[Numbers, Numbers]:
        """Angles after and before the impact, rad, shape half.shape + (joints,): the legs `half` from the vertical."""
        return np.stack([-half, half], axis=-1), np.stack([half, -half], axis=-1)

    def step_length(self, half: Numbers) -> Numbers:
        """Distance between the feet, m."""
        return np.asarray(2.0 * self.robot.leg_length * np.sin(half))

    def guess(self, half: float) -> tuple[Array, Array]:
        """Control points to begin the search with, shape (DEGREE + 1, joints), and the robot's own numbers.

        The stance leg turns evenly; the swing leg swings out and comes back.
        """
        stance = np.linspace(-half, half, DEGREE + 1)
        swing = np.linspace(half, -half, DEGREE + 1)
        swing[3:DEGREE] -= 0.5 * half * np.sin(np.linspace(0.25, 0.9, DEGREE - 3) * math.pi)
        return np.stack([stance, swing], axis=-1), np.empty(0)

    def rates_after_impact(self, half: Numbers, rates: Numbers) -> Numbers:
        """Rates of stance and swing leg after the heel strike, of rates before it, rad/s."""
        chain, (_, before) = self.robot.chains[2], self.postures(half)
        about, onto = (
            chain._replace(weights=weights).mass_matrix(before) for weights in (chain.about_end, chain.onto_end)
        )
        return np.asarray(np.linalg.solve(about, onto @ rates[..., None])[..., ::-1, 0])

    def course(self, q: Numbers, dq: Numbers, ddq: Numbers) -> Course:
        """Inverse dynamics (eq. 1) and the swing foot's path (eq. 4), for as many angles as are free."""
        chain = self.robot.chains[q.shape[-1]]
        forces = (chain.mass_matrix(q) @ ddq[..., None])[..., 0] + chain.pull(q, dq, 0.0)
        torques = np.cumsum(forces[..., ::-1], axis=-1)[..., ::-1]  # each joint moves all segments beyond it
        powers = torques * np.concatenate([dq[..., :1], np.diff(dq, axis=-1)], axis=-1)
        for _ in range(len(self.robot.joints) - q.shape[-1]):  # the lock bears the knee's torque
            torques, powers = (np.concatenate([each, 0.0 * each[..., :1]], axis=-1) for each in (torques, powers))
        (forward, upward), (ahead, height) = (
            np.moveaxis(each, -1, 0) for each in (chain.ground_force(q, dq, ddq, 0.0), chain.end(q))
        )
        ahead_rate, height_rate = (np.cos(q) * dq) @ chain.reach, -(np.sin(q) * dq) @ chain.reach
        return Course(torques, powers, forward, upward, ahead, height, ahead_rate, height_rate)

    def along(self, motion: Motion, stretches: Sequence[Numbers]) -> Course:
        """Dynamics of a motion at phases in each stretch between the breaks, each of shape (..., m)."""
        return self.course(*curve(motion.points, np.concatenate(stretches, axis=-1), motion.period))

    def keeps(self, goal: Goal, motion: Motion, course: Course, phases: Numbers, second: int) -> dict[str, Numbers]:
        """Constraints on the way that this robot swings its leg: scaled values >= 0, shapes (..., n), by name.

        Straight legs keep the foot above the ground wherever it might touch it.

        Args:
            goal: What is asked.
            motion: The motion that is tried.
            course: Its dynamics.
            phases: Phases of the course, shape (..., m).
            second: Index of the moment at which the swing foot has its clearance.
        """
        # the greater of height and what is missing to the reach, rounded
        height = course.height[..., :-1] / self.robot.leg_length
        missing = REACH - course.ahead[..., :-1] / self.robot.leg_length
        greater = 0.5 * (height + missing + np.sqrt((height - missing) ** 2 + _CORNER**2) - _CORNER)
        return {"foot above the ground": greater + 0.5 * _CORNER}  # just above zero at the end, where the foot lands


@dataclass(frozen=True)
class KneedStep(CompassStep):
    """The step of the biped with knees.

    Its own numbers are the five control points of the flexion that are not zero.
    """

    own: ClassVar[Sequence[tuple[float, float]]] = ((0.0, GREATEST_FLEXION),) * 5
    breaks: ClassVar[Sequence[float]] = (KNEE_STRIKE,)
    intervals: ClassVar[Sequence[int]] = (40, 16, 16)
    starts: ClassVar[Sequence[tuple[float, float]]] = ((0.22, 0.80), (0.15, 0.60))
    lifted: ClassVar[float] = 0.005

    def bent(self, motion: Motion, phases: Numbers) -> tuple[Numbers, Numbers, Numbers]:
        """Angles, rates and accelerations of stance leg, thigh and shank up to the knee strike, shapes (..., m, 3)."""
        legs = curve(motion.points, phases, motion.period)
        flexion = curve(flexion_points(motion.own), phases / KNEE_STRIKE, KNEE_STRIKE * motion.period)
        q, dq, ddq = (np.concatenate([leg, leg[..., 1:] + knee], -1) for leg, knee in zip(legs, flexion, strict=True))
        return q, dq, ddq

    def straight(self, motion: Motion, phases: Numbers) -> tuple[Numbers, Numbers, Numbers]:
        """Angles, rates and accelerations of stance and swing leg after the knee strike, shapes (..., m, 2)."""
        left = (1.0 - KNEE_STRIKE) * motion.period[..., None]
        x = (phases - KNEE_STRIKE) / (1.0 - KNEE_STRIKE)
        fading = (left * x * (1.0 - x) ** 2, (1.0 - x) * (1.0 - 3.0 * x), (6.0 * x - 4.0) / left)
        change = self.knee_strike(motion)[..., None, :]
        legs = curve(motion.points, phases, motion.period)
        q, dq, ddq = (leg + change * each[..., None] for leg, each in zip(legs, fading, strict=True))
        return q, dq, ddq

    def knee_strike(self, motion: Motion) -> Numbers:
        """Change of the rates of stance leg and thigh in the knee strike, rad/s, shape (..., 2)."""
        q, dq, _ = (each[..., 0, :] for each in self.bent(motion, np.array([KNEE_STRIKE])))
        return np.asarray(self.robot.chains[3].joints_lock(SWING_LOCKED, q, dq) - dq[..., :2])

    def along(self, motion: Motion, stretches: Sequence[Numbers]) -> Course:
        """Dynamics of a motion whose knee is bent in all stretches but the last."""
        bent = self.course(*self.bent(motion, np.concatenate(stretches[:-1], axis=-1)))
        straight = self.course(*self.straight(motion, stretches[-1]))
        axes = [-2 if name in ("torques", "powers") else -1 for name in Course._fields]
        return Course(*(np.concatenate(pair, axis) for *pair, axis in zip(bent, straight, axes, strict=True)))

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


def _smoothly(x: Numbers) -> Numbers:
    """A cubic that rises from 0 at x = 0 to 1 at x = 1, and is 1 beyond."""
    x = np.where(x.real < 1.0, x, 1.0)
    return np.asarray(x * x * (3.0 - 2.0 * x))
