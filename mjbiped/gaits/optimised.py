"""Optimised references: gaits on level ground with motors, which lift the swing foot as high as asked.

`find_reference` searches for a reference with `mjbiped.gaits.optimisation`, and keeps it on disk.
"""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from contextvars import ContextVar
from dataclasses import dataclass
from functools import cached_property, lru_cache
from typing import Any, ClassVar, Self

import numpy as np

from mjbiped.errors import GaitError, InputError
from mjbiped.gaits import store
from mjbiped.gaits.gait import Gait
from mjbiped.gaits.optimisation import HALF_ANGLE, Told, motion_of, optimise, tell
from mjbiped.gaits.reference import (
    DEGREE,
    closing_on,
    count_of_pieces,
    curve,
    curve_in_pieces,
    hold,
    in_pieces,
    table_of,
)
from mjbiped.gaits.steps import KNEE_STRIKE, CompassStep, Goal, KneedStep, Motion, flexion_points
from mjbiped.robots.compass import Compass
from mjbiped.robots.kinds import robot_from
from mjbiped.robots.kneed import KneedBiped
from mjbiped.robots.robot import Array, Robot
from mjbiped.utils import domains

SPEED = 0.494
"""Speed of the passive gait on 2 degrees, which the paper imitates, m/s."""

FRICTION = 0.6
"""Friction coefficient that a reference may use; the ground's in MuJoCo is 0.8."""

_STEP, _BENT = 25, 22  # pieces of a step with knees, and of its part before the knee strike: the share KNEE_STRIKE


@dataclass(frozen=True, eq=False, repr=False, kw_only=True)
class OptimisedGait(Gait):
    """An optimised gait on level ground, made by `find_reference`.

    After the period, the trajectory goes on: the swing leg comes to rest within 0.1 s (for legs of 1 m), and the stance
    leg keeps its rate until it has fallen 60 degrees.

    Attributes:
        goal: Requirements: speed (m/s), clearance (m), retraction, torque_limit (N m) and friction.
        clearance_phase: Phase of the step, 0 to 1, at which the swing foot has its clearance; with retraction the foot
            moves no further forward from this phase on. Meaningless without clearance.
        control_points: Control points of the Bézier curves of degree 7 of stance leg and swing leg, or thigh, rad,
            shape (8, 2).
        own: Further numbers of the robot's kind, such as the control points of a knee's flexion.
    """

    step: ClassVar[type[CompassStep]] = CompassStep
    goal: Goal
    clearance_phase: float
    control_points: Array
    own: Array

    @classmethod
    def of(cls, robot: Any, goal: Goal, x: Array) -> Self:
        """Make the gait from the optimiser's unknowns x; see `motion_of`."""
        model = cls.step(robot)
        motion = motion_of(model, goal, x)
        points, period = motion.points, float(motion.period)
        (q0, q), (dq0, dq), _ = curve(points, np.array([0.0, 1.0]), period)
        columns = [0, 1, 1][: len(robot.angles)]
        followed = cls.followed(model, motion)
        return cls(
            robot=robot,
            slope=0.0,
            start=np.concatenate([q0[columns], dq0[columns]]),
            end=np.concatenate([q[columns], followed.pop("rates", dq)[columns]]),
            period=period,
            step_length=float(model.step_length(motion.half)),
            goal=goal,
            clearance_phase=float(x[0]),
            control_points=points,
            own=motion.own,
            **followed,
        )

    @classmethod
    def followed(cls, model: Any, motion: Motion) -> dict[str, Any]:
        """The gait's trajectories."""
        period = float(motion.period)
        (q,), (dq,), (ddq,) = curve(motion.points, np.array([1.0]), period)
        count = count_of_pieces(period, model.robot.leg_length, model.robot.gravity)
        after = hold(q, dq, ddq, period / count, count)
        return {"tables": (table_of(count / period, np.concatenate([curve_in_pieces(motion.points, count), after])),)}

    @property
    def model(self) -> CompassStep:
        """The robot's step as the optimiser takes it."""
        return self.step(self.robot)

    @cached_property
    def measures(self) -> Told:
        """Measures of the gait on level ground, tracked without error: cost, torques, forces, clearance."""
        half, points = float(self.end[0]), self.control_points[2:-1].ravel()
        return tell(self.model, self.goal, np.concatenate([[self.clearance_phase, half], points, self.own]))

    @property
    def cost_of_transport(self) -> float:
        """Absolute work on level ground for weight and distance, c_mt."""
        return self.measures.cost_of_transport

    def describe(self) -> dict[str, Any]:
        """Return the trajectory and its goal in plain JSON types, from which `gait_from` makes the gait again."""
        return {
            "goal": dataclasses.asdict(self.goal),
            "clearance_phase": self.clearance_phase,
            "half_angle": float(self.end[0]),
            "control_points": self.control_points[2:-1].tolist(),
            **({"own": self.own.tolist()} if len(self.own) else {}),
            "robot": self.robot.to_dict(),
        }

    def __repr__(self) -> str:
        """Return a summary in one line."""
        return (
            f"<{type(self).__name__} at {self.speed:.4g} m/s with {self.goal.clearance:.4g} m of clearance: "
            f"c_mt {self.cost_of_transport:.4f}, period {self.period:.6g} s, step {self.step_length:.6g} m>"
        )


@dataclass(frozen=True, eq=False, repr=False, kw_only=True)
class OptimisedKneedGait(OptimisedGait):
    """An optimised gait with knees on level ground, made by `find_reference`.

    It has a trajectory for the bent knee and another one for the straight knee. After the knee strike, the bent knee's
    trajectory goes on past the stop at the rate of the strike. Before the knee strike, the straight knee's trajectory
    is that of the legs, with the rates changed as the strike changes them. After the period, the swing leg comes to
    rest, and the stance leg keeps its rate until it has fallen 60 degrees. `own` has the control points of the
    flexion's Bézier curve that are not zero, rad, shape (5,).
    """

    step: ClassVar[type[CompassStep]] = KneedStep
    knee_strike: float

    @classmethod
    def followed(cls, model: Any, motion: Motion) -> dict[str, Any]:
        """The gait's trajectories, and the rates of the legs with which they end."""
        robot, points, period = model.robot, motion.points, float(motion.period)
        groups = math.ceil(count_of_pieces(period, robot.leg_length, robot.gravity) / _STEP)
        count, until = _STEP * groups, _BENT * groups
        width, strike = period / count, KNEE_STRIKE * period
        (q1,), (dq1,), (ddq1,) = curve(points, np.array([1.0]), period)
        _, (knee_dq,), (knee_ddq,) = model.bent(motion, np.array([KNEE_STRIKE]))
        (q,), (dq,), (ddq,) = model.straight(motion, np.array([1.0]))
        legs = curve_in_pieces(points, count)

        base = np.concatenate([legs, hold(q1, dq1, ddq1, width, count)])
        flexion = curve_in_pieces(flexion_points(motion.own), until)[..., 0]
        closing, slowing = knee_dq[2] - knee_dq[1], knee_ddq[2] - knee_ddq[1]
        driven = closing_on(0.0, closing, slowing, width, len(base) - until)
        shank = base[..., 1] + np.concatenate([flexion, driven])
        bent = np.concatenate([base, shank[..., None]], axis=-1)

        change = model.knee_strike(motion)
        early = in_pieces(lambda place: change * (width * place - strike)[:, None], range(until))
        locked = in_pieces(lambda place: model.straight(motion, place / count)[0], range(until, count))
        straight = np.concatenate([legs[:until] + early, locked, hold(q, dq, ddq, width, count)])
        tables = tuple(table_of(count / period, pieces) for pieces in (bent, straight))
        return {"tables": tables, "knee_strike": strike, "rates": dq}


_KINDS: Mapping[str, type[OptimisedGait]] = {
    Compass.kind: OptimisedGait,
    KneedBiped.kind: OptimisedKneedGait,
}


def find_reference(
    robot: Compass | KneedBiped,
    *,
    speed: float = SPEED,
    clearance: float = 0.06,
    retraction: bool = True,
    torque_limit: float | None = None,
    friction: float = FRICTION,
) -> OptimisedGait:
    """The gait on level ground with the least cost of transport for a speed and a clearance of the swing foot.

    A controller that tracks it climbs steps somewhat higher than the clearance. Results are kept in the user's cache
    folder, or where the environment variable MJBIPED_CACHE_DIR says.

    Args:
        robot: Any compass biped, or any biped with knees, whose swing foot stays above the ground at all times. If it
            has a sole, the centre of pressure stays within it.
        speed: Mean speed, m/s.
        clearance: Height of the swing foot over level ground at some moment of the step, m; 0 leaves the foot's path
            free. With knees the foot rises to this height within the first quarter of the step, and keeps it until
            that moment.
        retraction: Whether the foot moves no further forward from that moment on, so that it meets no riser from the
            front. Without retraction the same clearance costs less.
        torque_limit: Greatest torque of each joint, N m; None for none.
        friction: Greatest ratio of tangential to normal force on the stance foot.

    Raises:
        InputError: A number is outside its domain, or the robot is neither a `Compass` nor a `KneedBiped`.
        GaitError: There is no such gait, or none was found; the message says what stands in the way.
    """
    if not isinstance(robot, Robot) or robot.flat.kind not in _KINDS:
        if isinstance(robot, Robot) and "hip_y" in robot.places:
            raise InputError(
                f"references are searched for planar robots: search one for the legs of a {type(robot).__name__}, "
                "mjbiped.find_reference(robot.planar); a walk's --reference lets a robot in space track it, with a roll"
            )
        domains.check_kind("robot", robot, Compass)
    if domains.CLEARANCE.check("clearance", clearance) >= robot.leg_length:
        raise InputError(
            f"clearance = {clearance:g}: must be less than the leg's length of {robot.leg_length:g} m, which puts the "
            "swing foot at the height of the hip"
        )
    return _find(robot.flat, Goal(speed, clearance, retraction, torque_limit, friction))


_searches_forbidden: ContextVar[bool] = ContextVar("searches_forbidden", default=False)


@contextmanager
def only_kept() -> Iterator[None]:
    """Forbid searches in a block: `find_reference` raises `GaitError` for a reference that is not stored here.

    For references that a file names, such as a record.
    """
    token = _searches_forbidden.set(True)
    try:
        yield
    finally:
        _searches_forbidden.reset(token)


@lru_cache(maxsize=256)
def _find(robot: Compass | KneedBiped, goal: Goal) -> OptimisedGait:
    kind = _KINDS[robot.kind]
    asked = {"robot": robot.to_dict(), "goal": dataclasses.asdict(goal)}

    def search() -> dict[str, Any]:
        if _searches_forbidden.get():
            raise GaitError("this reference is not stored on this machine; find it with `mjbiped reference` first")
        return {"x": optimise(kind.step(robot), goal)}

    return kind.of(robot, goal, **store.kept(asked, search))


def optimised_from(described: Mapping[str, Any]) -> OptimisedGait:
    """Make the gait that `OptimisedGait.describe` described, bitwise and without a new optimisation.

    Raises:
        KeyError: Something is missing.
        TypeError: Something is of another kind.
        InputError: Control points are missing, or something is no number.
    """
    goal = Goal(**described["goal"])
    points = domains.ANGLE.array("control_points", described["control_points"], (DEGREE - 2, 2))
    robot = robot_from(described["robot"])
    kind = _KINDS[robot.kind]
    own = domains.ANGLE.array("own", described.get("own", ()), (len(kind.step.own),))
    phase = domains.PROBABILITY.check("clearance_phase", described["clearance_phase"])
    half = HALF_ANGLE.check("half_angle", described["half_angle"])
    return kind.of(robot, goal, np.concatenate([[phase, half], points.ravel(), own]))
