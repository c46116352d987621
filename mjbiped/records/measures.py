"""Measures of a walk, each defined once for every engine; SI units and radians."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Any, TypeAlias

import numpy as np
from numpy.typing import NDArray

from mjbiped.errors import InputError, shown
from mjbiped.records import stance_knee
from mjbiped.records.pressure import USUAL, Sole
from mjbiped.robots.compass import Compass
from mjbiped.robots.kneed import KneedBiped
from mjbiped.robots.robot import Robot
from mjbiped.rules.termination import Outcome
from mjbiped.terrain.segments import GROUND_FRICTION
from mjbiped.terrain.terrain import Terrain

if TYPE_CHECKING:
    from mjbiped.records.record import Walk

OF_STANCE_KNEE = ("peak_stance_knee_torque_Nm", "cost_of_transport_stance_knee")
"""Keys of measures that tell, of a robot with knees, what holds its stance knee: of a lock from samples alone."""

Touchdowns: TypeAlias = Mapping[str, NDArray[Any]]
"""The table of a walk's touchdowns, or a part of it; see `mjbiped.records.columns.TOUCHDOWNS`."""

SLIDING = 1.0 - 1e-3
"""Share of the friction coefficient from which on a foot slides: MuJoCo's solver keeps to the cone within 1e-4."""

THROUGH, THROUGH_VIOLATING = "through", "through, contact violated"
"""Verdicts of finished walks; see `violations`."""

WORK_KINDS = ("absolute", "net", "positive")


def distance(walk: Walk) -> float:
    """Horizontal distance of the stance foot from x = 0 to the last touchdown, m."""
    return float(walk.touchdowns["x"][-1]) if walk.steps else 0.0


def work(walk: Walk, kind: str = "absolute") -> float:
    """Mechanical work of all joints up to the last touchdown, J.

    Args:
        walk: The walk.
        kind: "absolute", `∫ |τ₁ q̇₁| + |τ₂ (q̇₂ - q̇₁)| dt` (with knees `+ |τ₃ (q̇₃ - q̇₂)|`); "net" (with its sign), or
            "positive" (positive power alone).

    Raises:
        InputError: The kind is unknown.
    """
    if kind not in WORK_KINDS:
        raise InputError(f"unknown kind of work {shown(kind)}; valid are {', '.join(WORK_KINDS)}")
    return float(walk.touchdowns[f"work_{kind}"][-1]) if walk.steps else 0.0


def powers(walk: Walk) -> NDArray[np.float64]:
    """Mechanical power of each joint at each sample, torque times the joint's rate, shape (samples, joints), W."""
    return np.asarray(walk.samples["torque"] * walk.robot.joint_rates(walk.samples["dq"]), dtype=np.float64)


def cost_of_transport(walk: Walk, kind: str = "absolute") -> float:
    """Mechanical cost of transport c_mt: work / (weight · distance); NaN for a walk that got nowhere.

    Args:
        walk: The walk.
        kind: See `work`; the paper's c_mt is fitted by "absolute".

    Raises:
        InputError: The kind is unknown.
    """
    return _transport(work(walk, kind), walk.robot, distance(walk))


def _transport(work: float, robot: Robot, distance: float) -> float:
    return work / (robot.weight * distance) if distance > 0.0 else math.nan


def speed(walk: Walk) -> float:
    """Mean horizontal speed up to the last touchdown, m/s; NaN without one."""
    return _speed(distance(walk), float(walk.touchdowns["time"][-1])) if walk.steps else math.nan


def _speed(distance: float, time: float) -> float:
    return distance / time if time > 0.0 else math.nan


def step_lengths(walk: Walk) -> NDArray[np.float64]:
    """Distance from one stance foot to the next, shape (steps,), m."""
    return _lengths(walk.touchdowns, 0.0, walk.terrain.height_at(0.0))


def _lengths(touchdowns: Touchdowns, x: float, z: float) -> NDArray[np.float64]:
    """Step lengths from a first stance foot on, m."""
    ways = (np.diff(np.append(first, touchdowns[name])) for name, first in (("x", x), ("z", z)))
    return np.asarray(np.hypot(*ways), dtype=np.float64)


def step_periods(walk: Walk) -> NDArray[np.float64]:
    """Time from one touchdown to the next, shape (steps,), s."""
    return np.asarray(np.diff(np.append(0.0, walk.touchdowns["time"])), dtype=np.float64)


def estimate_errors(walk: Walk) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Errors of the slope estimate, estimate minus truth, rad; NaN for a controller without one.

    Returns:
        At each step's beginning, after the update (27) at its touchdown, and at each step's end, before the next
        touchdown's update; shape (steps,) each. The last beginning is that of the step that was not walked any more.
    """
    return _errors(walk.touchdowns, walk.terrain.slope_at(0.0))


def _errors(touchdowns: Touchdowns, slope: float) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Errors of the estimate from a first stance foot on, which stands on a slope (rad)."""
    slope_before = np.append(slope, touchdowns["slope"])[:-1]
    return touchdowns["slope_estimate"] - touchdowns["slope"], touchdowns["slope_estimate_before"] - slope_before


def impact_errors(walk: Walk) -> NDArray[np.float64]:
    """Rates after each impact against the impact map (the paper's (2)) of the state before it, shape (steps, angles).

    Relative: measured / map - 1, for the new stance and the new swing leg. What a simulator samples before and after an
    impact lies a physics step apart, and the motion in between is part of this number.
    """
    return _impact_errors(walk.touchdowns, walk.robot)


def _impact_errors(touchdowns: Touchdowns, robot: Robot) -> NDArray[np.float64]:
    before = [touchdowns["q_before"], touchdowns["dq_before"]]
    if isinstance(robot, KneedBiped):  # the leg that leaves the ground may have stood on a bent knee
        before.append(robot.flexion(touchdowns["qpos"], 1 - touchdowns["stance"]))
    rates = [robot.rates_after_touchdown(*row) for row in zip(*before, strict=True)]
    mapped = np.reshape(rates, touchdowns["dq"].shape)
    return np.asarray(touchdowns["dq"] / mapped - 1.0, dtype=np.float64)


def pulls(touchdowns: Touchdowns) -> NDArray[np.bool_]:
    """Whether the ground would have had to pull at the stance foot in the step that ends, shape (steps,).

    In the hybrid engine, whose stance foot cannot leave the ground, the least normal force is then below zero. In
    MuJoCo it is zero: the foot was off the ground. Not known (False) in records that do not hold that force.
    """
    return np.asarray(touchdowns["normal_force"] <= 0.0)


def friction_asked(touchdowns: Touchdowns) -> NDArray[np.float64]:
    """Greatest `|F_t| / F_n` of the stance foot in the step that ends, shape (steps,).

    Infinite where F_n falls below zero, as it can in the hybrid engine: the record's ratio leaves out a foot that
    hardly presses on the ground, and says little where the force goes through zero.
    """
    return np.where(touchdowns["normal_force"] < 0.0, np.inf, touchdowns["friction"])


def foot_length(walk: Walk, share: float = USUAL) -> float:
    """Length of a flat foot that holds the centre of pressure for a share of the time, m.

    See `mjbiped.records.pressure`; infinite where no foot does, NaN for records that do not tell.
    """
    ahead, behind = (np.max(walk.touchdowns[f"pressure_{side}"], initial=-math.inf) for side in ("ahead", "behind"))
    return Sole(walk.pressure_times, walk.end[0], float(ahead), float(behind), walk.robot.leg_length).length(share)


def violations(touchdowns: Touchdowns) -> NDArray[np.bool_]:
    """Whether the step that ends asks for ground that no foot has, shape (steps,): it pulls, or has friction over 0.8.

    The hybrid engine's stance foot stands all the same. MuJoCo's hops or slides, and the walk may go on. Where the
    ground in MuJoCo was given less friction, a foot that slides on it violates nothing.
    """
    return pulls(touchdowns) | (friction_asked(touchdowns) > SLIDING * GROUND_FRICTION)


def verdict(outcome: str, violated: int | None) -> str:
    """The outcome of a walk, where a finished one is told apart by how many of its steps violate the contact."""
    if outcome != Outcome.FINISHED.words:
        return outcome
    return THROUGH_VIOLATING if violated else THROUGH


def summary(walk: Walk) -> dict[str, Any]:
    """All measures of a walk in plain JSON types; angles here are in degrees, as the names say.

    A measure that does not exist (a cost without a distance, an estimate of a controller that makes none, the torque of
    a locked stance knee in a walk without samples) is None.
    """
    gathered = Summary(walk.robot, walk.terrain)
    gathered.take(walk.touchdowns)
    return gathered.to_dict(
        outcome=walk.outcome,
        end=walk.end,
        peak_torque=walk.peak_torque,
        warnings=walk.warnings,
        pressure_times=walk.pressure_times,
        stance_knee=stance_knee.peak_torque(walk) if walk.robot.knees else math.nan,
    )


class Summary:
    """The measures of a walk from its touchdowns, which are given part by part and not kept.

    In which parts makes no difference, to the last bit.

    Attributes:
        steps: Touchdowns so far.
    """

    def __init__(self, robot: Robot, terrain: Terrain) -> None:
        """Begin without a touchdown.

        Args:
            robot: The robot that walks.
            terrain: The ground.
        """
        self.steps = 0
        self._robot = robot
        start = {"x": 0.0, "z": terrain.height_at(0.0), "slope": terrain.slope_at(0.0), "time": 0.0}
        self._last = {**start, **{f"work_{kind}": 0.0 for kind in WORK_KINDS}}
        if robot.knees:
            self._last["stance_knee_work"] = 0.0
        self._length = 0.0  # sum of the steps', m
        self._strikes = 0
        self._largest: dict[str, float] = {}
        self._least_force = math.inf  # N
        self._pulls = self._violations = 0
        self._last_error = math.nan

    def take(self, touchdowns: Touchdowns) -> None:
        """Take the touchdowns that follow.

        Args:
            touchdowns: Columns of `columns.TOUCHDOWNS`, any number of rows.
        """
        count = len(touchdowns["time"])
        if not count:
            return
        last = self._last
        started, ended = _errors(touchdowns, last["slope"])
        named = {
            "estimate_error_at_touchdown": started,
            "estimate_error_at_step_end": ended,
            "impact_error": _impact_errors(touchdowns, self._robot),
            "friction": friction_asked(touchdowns),
            **{name: touchdowns[name] for name in ("slip", "penetration")},
        }
        signed = {name: touchdowns[name] for name in ("pressure_ahead", "pressure_behind")}
        if self._robot.knees:
            named["stance_knee_torque"] = touchdowns["stance_knee_torque"]
        for name, values in {**{name: np.abs(values) for name, values in named.items()}, **signed}.items():
            largest = float(np.max(values))
            self._largest[name] = float(np.maximum(self._largest.get(name, largest), largest))  # NaN stays
        # one after another, which NumPy's sum would not do
        self._length = float(np.cumsum(np.append(self._length, _lengths(touchdowns, last["x"], last["z"])))[-1])
        self._least_force = float(np.minimum(self._least_force, np.min(touchdowns["normal_force"])))  # NaN stays
        self._pulls += int(np.sum(pulls(touchdowns)))
        self._violations += int(np.sum(violations(touchdowns)))
        self._strikes += int(np.sum(touchdowns["strikes"]))
        self._last = {name: float(touchdowns[name][-1]) for name in last}
        self._last_error = float(ended[-1])
        self.steps += count

    def to_dict(
        self,
        *,
        outcome: str,
        end: tuple[float, float],
        peak_torque: Sequence[float] | NDArray[np.float64],
        warnings: Mapping[str, int],
        pressure_times: NDArray[np.float64],
        stance_knee: float = math.nan,
    ) -> dict[str, Any]:
        """The measures, as `summary` gives them; the arguments are what touchdowns do not tell, as in `Walk`.

        `stance_knee` is the greatest torque of the stance knee in the samples, N m; of a locked knee, they alone tell.
        """
        last, steps = self._last, self.steps

        def largest(name: str) -> float:
            return self._largest.get(name, math.nan)

        def cost(kind: str) -> float:
            return _transport(last[f"work_{kind}"], self._robot, last["x"])

        violated = None if math.isnan(self._least_force) else self._violations
        ahead, behind = largest("pressure_ahead"), largest("pressure_behind")
        sole = Sole(pressure_times, end[0], ahead, behind, self._robot.leg_length)
        measured = {
            "steps": steps,
            "distance_m": last["x"],
            "time_s": last["time"],
            "speed_m_per_s": _speed(last["x"], last["time"]),
            "mean_step_length_m": self._length / steps if steps else math.nan,
            "mean_step_period_s": last["time"] / steps if steps else math.nan,
            "cost_of_transport": cost("absolute"),
            "cost_of_transport_net": cost("net"),
            "cost_of_transport_positive": cost("positive"),
            **{f"peak_{joint}_torque_Nm": float(peak_torque[k]) for k, joint in enumerate(self._robot.joints)},
            **self._of_stance_knee(stance_knee),
            "estimate_error_at_touchdown_deg": math.degrees(largest("estimate_error_at_touchdown")),
            "estimate_error_at_step_end_deg": math.degrees(largest("estimate_error_at_step_end")),
            "final_estimate_error_deg": math.degrees(self._last_error),
            "largest_impact_error": largest("impact_error"),
            "largest_slip_m": largest("slip"),
            "largest_penetration_m": largest("penetration"),
            "largest_stance_friction": largest("friction"),
            "least_normal_force_weights": self._least_force / self._robot.weight if steps else math.nan,
            "steps_that_pull": None if math.isnan(self._least_force) else self._pulls,
            "steps_violating_contact": violated,
            "pressure_ahead_m": sole.ahead,
            "pressure_behind_m": sole.behind,
            "foot_length_99_percent_m": sole.length(),
            "strikes": self._strikes,
        }
        plain: dict[str, Any] = {
            name: None if isinstance(value, float) and math.isnan(value) else value for name, value in measured.items()
        }
        return {
            "outcome": outcome,
            "verdict": verdict(outcome, violated),
            "ended_at_time_s": end[0],
            "ended_at_x_m": end[1],
            **plain,
            "warnings": dict(warnings),
        }

    def _of_stance_knee(self, sampled: float) -> dict[str, float]:
        """Greatest torque of the stance knee, N m, given that of the samples, and the share of its motor in c_mt."""
        if not self._robot.knees:
            return {}
        peak = np.fmax(sampled, self._largest.get("stance_knee_torque", math.nan))
        cost = _transport(self._last["stance_knee_work"], self._robot, self._last["x"])
        return dict(zip(OF_STANCE_KNEE, (float(peak), cost), strict=True))


Shown: TypeAlias = tuple[str, str, float, str, str]
_PEAKS: tuple[Shown, ...] = tuple(
    (f"peak torque, {joint}", f"peak_{joint}_torque_Nm", 1, ".2f", "N m") for joint in Compass.joints
)
MEASURES: tuple[Shown, ...] = (
    ("steps", "steps", 1, "d", ""),
    ("distance", "distance_m", 1, ".3f", "m"),
    ("last touchdown at", "time_s", 1, ".3f", "s"),
    ("speed", "speed_m_per_s", 1, ".4f", "m/s"),
    ("step length, mean", "mean_step_length_m", 1, ".4f", "m"),
    ("step period, mean", "mean_step_period_s", 1, ".4f", "s"),
    ("cost of transport, absolute", "cost_of_transport", 1, ".4f", ""),
    ("cost of transport, net", "cost_of_transport_net", 1, ".4f", ""),
    ("cost of transport, positive", "cost_of_transport_positive", 1, ".4f", ""),
    *_PEAKS,
    ("estimate error at touchdown, largest", "estimate_error_at_touchdown_deg", 1, ".4f", "deg"),
    ("estimate error at step end, largest", "estimate_error_at_step_end_deg", 1, ".4f", "deg"),
    ("final estimate error", "final_estimate_error_deg", 1, ".4f", "deg"),
    ("impact against the impact map, worst", "largest_impact_error", 1e2, ".3f", "%"),
    ("slip, largest", "largest_slip_m", 1e3, ".4f", "mm"),
    ("penetration, largest", "largest_penetration_m", 1e3, ".4f", "mm"),
    ("stance friction used, largest", "largest_stance_friction", 1, ".3f", ""),
    ("normal force on the stance foot, least", "least_normal_force_weights", 1, ".3f", "weights"),
    ("steps in which the ground would have to pull", "steps_that_pull", 1, "d", ""),
    ("steps that violate the contact (pull, or friction over 0.8)", "steps_violating_contact", 1, "d", ""),
    ("centre of pressure, ahead of the ankle at most", "pressure_ahead_m", 1e2, ".2f", "cm"),
    ("centre of pressure, behind it at most", "pressure_behind_m", 1e2, ".2f", "cm"),
    ("foot that holds it 99 % of the time, length", "foot_length_99_percent_m", 1e2, ".1f", "cm"),
    ("impacts on vertical faces", "strikes", 1, "d", ""),
)
"""Of a compass biped's summary, as they are shown: label, key, factor to the unit shown, format, and that unit."""


def measures_of(robot: type[Robot]) -> tuple[Shown, ...]:
    """The same for a kind of robot."""
    last = 1 + MEASURES.index(_PEAKS[-1])
    others = [joint for joint in robot.joints if joint not in Compass.joints]
    more: list[Shown] = [
        (f"peak torque, swing {joint}", f"peak_{joint}_torque_Nm", 1, ".2f", "N m") for joint in others
    ]
    if robot.knees:
        peak, cost = OF_STANCE_KNEE
        more += [
            ("peak torque, stance knee", peak, 1, ".2f", "N m"),
            ("cost of transport, stance knee's part", cost, 1, ".4f", ""),
        ]
    return (*MEASURES[:last], *more, *MEASURES[last:])


def in_words(value: float | None, factor: float, form: str) -> str:
    """A number with its format, as it is shown; a dash for one that does not exist."""
    return "-" if value is None else "unbounded" if value == math.inf else format(value * factor, form)
