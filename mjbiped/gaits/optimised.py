"""References that are optimised: walking on level ground with motors, and lifting the swing foot as high as asked.

`find_reference` finds one; what it has found is kept on disk. `mjbiped.gaits.optimisation` says how.
"""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from contextvars import ContextVar
from dataclasses import dataclass, field
from functools import lru_cache
from typing import Any, overload

import numpy as np

from mjbiped.errors import GaitError, InputError, shown
from mjbiped.gaits import store
from mjbiped.gaits.bezier import DEGREE, curve, in_pieces
from mjbiped.gaits.compass_step import CompassStep
from mjbiped.gaits.found import Found
from mjbiped.gaits.gait import Gait
from mjbiped.gaits.hold import hold, pieces_of
from mjbiped.gaits.kneed_step import KneedStep
from mjbiped.gaits.optimisation import HALF_ANGLE, Goal, StepModel, free_numbers, optimise, solution_of
from mjbiped.gaits.optimised_kneed import OptimisedKneedGait, kneed_gait
from mjbiped.gaits.reference import table_of
from mjbiped.robots.compass import Array, Compass
from mjbiped.robots.kinds import robot_from
from mjbiped.robots.kneed import KneedBiped
from mjbiped.utils import domains

SPEED = 0.494
"""Of the passive gait on 2 degrees, which the paper imitates, m/s."""

FRICTION = 0.6
"""What a reference may ask of the ground, of the 0.8 that it has in MuJoCo."""


@dataclass(frozen=True, eq=False, repr=False)
class OptimisedGait(Found, Gait):
    """An optimised gait on level ground, made by `find_reference`.

    Beyond the period the swing leg comes to rest within 0.1 s, and the stance leg goes on at an even rate, until it has
    fallen 60 degrees (times for legs of 1 m).

    Attributes:
        goal: What was asked for: speed (m/s), clearance (m), retraction, torque_limit (N m) and friction.
        clearance_phase: Phase of the step, 0 to 1, at which the swing foot has its clearance, and with retraction
            begins to come back; of no meaning where no clearance was asked for.
        control_points: Of the legs' Bézier curves of degree 7, stance leg first, rad, shape (8, 2).
    """

    goal: Goal
    clearance_phase: float
    control_points: Array = field(compare=False, repr=False)

    @property
    def model(self) -> CompassStep:
        """The robot's step as the optimiser takes it."""
        return CompassStep(self.robot)


@overload
def find_reference(
    robot: Compass,
    *,
    speed: float = ...,
    clearance: float = ...,
    retraction: bool = ...,
    torque_limit: float | None = ...,
    friction: float = ...,
) -> OptimisedGait: ...
@overload
def find_reference(
    robot: KneedBiped,
    *,
    speed: float = ...,
    clearance: float = ...,
    retraction: bool = ...,
    torque_limit: float | None = ...,
    friction: float = ...,
) -> OptimisedKneedGait: ...
def find_reference(
    robot: Compass | KneedBiped,
    *,
    speed: float = SPEED,
    clearance: float = 0.06,
    retraction: bool = True,
    torque_limit: float | None = None,
    friction: float = FRICTION,
) -> OptimisedGait | OptimisedKneedGait:
    """The gait on level ground that costs least work and lifts its swing foot so high.

    A controller that tracks it climbs steps somewhat higher than the clearance. Results are kept in the user's cache
    folder, or where the environment variable MJBIPED_CACHE_DIR says.

    Args:
        robot: Any compass biped, or any biped with knees, whose swing foot stays above the ground at all times.
        speed: Mean speed, m/s.
        clearance: Height of the swing foot over level ground at some moment of the step, m. With 0 nothing is asked
            of its path but that it lands where it shall. With knees the foot rises to it within the first quarter of
            the step, and is so high until that moment.
        retraction: Whether the foot goes no further forward from that moment on, so that no riser can meet it from
            ahead. Without it the same height costs less.
        torque_limit: Greatest torque of each joint, N m; None for none.
        friction: Greatest ratio of tangential to normal force on the stance foot.

    Raises:
        InputError: A number is outside its domain, or the robot is neither a `Compass` nor a `KneedBiped`.
        GaitError: There is no such gait, or none was found; the message says what stands in the way.
    """
    if not isinstance(robot, KneedBiped):
        domains.check_kind("robot", robot, Compass)
    if domains.CLEARANCE.check("clearance", clearance) >= robot.leg_length:
        raise InputError(
            f"clearance = {clearance:g}: must be less than the leg's length of {robot.leg_length:g} m; the swing foot "
            "would be above the hip"
        )
    return _find(robot, Goal(speed, clearance, retraction, torque_limit, friction))


_searches_forbidden: ContextVar[bool] = ContextVar("searches_forbidden", default=False)


@contextmanager
def only_kept() -> Iterator[None]:
    """Let `find_reference` search for nothing in a block: what is not kept on this machine is a `GaitError` there.

    For what others have asked for, as a record does.
    """
    token = _searches_forbidden.set(True)
    try:
        yield
    finally:
        _searches_forbidden.reset(token)


@lru_cache(maxsize=256)
def _find(robot: Compass | KneedBiped, goal: Goal) -> OptimisedGait | OptimisedKneedGait:
    model = _model(robot)
    asked = {"robot": dataclasses.asdict(robot), "goal": dataclasses.asdict(goal)}
    kept = store.load(asked)
    if kept is None:
        if _searches_forbidden.get():
            raise GaitError("this reference is not kept on this machine, and is not searched for here")
        found = optimise(model, goal)
        kept = [found.clearance_phase, *free_numbers(found).tolist()]
        store.save(asked, kept)
    return _gait(robot, goal, kept[0], np.array(kept[1:]))


def _model(robot: Compass | KneedBiped) -> StepModel:
    return KneedStep(robot) if isinstance(robot, KneedBiped) else CompassStep(robot)


def optimised_from(described: Mapping[str, Any]) -> OptimisedGait | OptimisedKneedGait:
    """The gait of `Found.describe`, bit by bit; nothing is optimised again.

    Raises:
        KeyError: Something is missing.
        TypeError: Something is of another kind.
        InputError: Control points are missing, or something is no number.
    """
    goal = Goal(**described["goal"])
    free = domains.ANGLE.array("control_points", described["control_points"], (DEGREE - 2, 2))
    robot = robot_from(described["robot"])
    assert isinstance(robot, Compass | KneedBiped)
    own = domains.ANGLE.array("own", described.get("own", ()), (len(_model(robot).own),))
    numbers = np.concatenate([[HALF_ANGLE.check("half_angle", described["half_angle"])], free.ravel(), own])
    phase = domains.PROBABILITY.check("clearance_phase", described["clearance_phase"])
    return _gait(robot, goal, phase, numbers)


def _gait(
    robot: Compass | KneedBiped, goal: Goal, clearance_phase: float, free: Array
) -> OptimisedGait | OptimisedKneedGait:
    model = _model(robot)
    solution = solution_of(model, goal, clearance_phase, free)
    if isinstance(robot, KneedBiped):
        return kneed_gait(robot, goal, solution)
    period = solution.period
    (q0, q), (dq0, dq), (_, ddq) = curve(solution.points, np.array([0.0, 1.0]), period)
    count = pieces_of(period, robot.leg_length, robot.gravity)
    step = in_pieces(solution.points, count)
    after = hold(q, dq, ddq, period / count, count)
    start, end = np.concatenate([q0, dq0]), np.concatenate([q, dq])
    for array in (start, end, solution.points):
        array.flags.writeable = False
    return OptimisedGait(
        robot=robot,
        slope=0.0,
        start=start,
        end=end,
        period=period,
        step_length=float(model.step_length(np.array(solution.half))),
        table=table_of(count / period, np.concatenate([step, after])),
        goal=goal,
        clearance_phase=clearance_phase,
        control_points=solution.points,
    )


_PARTS = ("speed", "clearance", "retraction", "torque_limit", "friction")
_WORDS = {"yes": True, "no": False}


def parse_reference(text: str) -> dict[str, Any]:
    """The arguments of `find_reference` of a text such as "clearance=0.06,retraction=no", as the command line takes it.

    Raises:
        InputError: A name is unknown or stands twice, or a value is none.
    """
    found: dict[str, Any] = {}
    for part in text.split(","):
        name, equals, value = (each.strip() for each in part.partition("="))
        if not equals:
            raise InputError(f"reference {shown(text)}: expected NAME=VALUE[,NAME=VALUE...], as clearance=0.06")
        domains.known_name("part of a reference", name, _PARTS)
        if name in found:
            raise InputError(f"reference {shown(text)}: {name} stands twice")
        found[name] = _value(text, name, value)
    return found


def _value(text: str, name: str, value: str) -> float | bool:
    if name == "retraction":
        if value not in _WORDS:
            raise InputError(f"reference {shown(text)}: retraction = {shown(value)}; expected yes or no")
        return _WORDS[value]
    try:
        number = float(value)
    except ValueError:
        raise InputError(f"reference {shown(text)}: {name} = {shown(value)} is no number") from None
    if not math.isfinite(number):
        raise InputError(f"reference {shown(text)}: {name} must be finite")
    return number


def words_of(goal: Goal) -> str:
    """The text that `parse_reference` reads as a goal."""
    asked = {name: getattr(goal, name) for name in _PARTS}
    return ",".join(
        f"{name}={('no', 'yes')[value] if isinstance(value, bool) else repr(value)}"
        for name, value in asked.items()
        if value is not None and (name, value) != ("retraction", True)
    )
