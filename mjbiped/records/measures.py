"""Measures of a walk, each defined once for every engine, in SI units and radians."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Any, TypeAlias

import numpy as np
from numpy.typing import NDArray

from mjbiped.errors import InputError, shown
from mjbiped.records import stance_knee
from mjbiped.records.columns import tables_of
from mjbiped.records.pressure import USUAL, Sole
from mjbiped.robots.compass import Compass
from mjbiped.robots.robot import Robot
from mjbiped.rules.termination import Outcome
from mjbiped.terrain.segments import GROUND_FRICTION
from mjbiped.terrain.terrain import Terrain

if TYPE_CHECKING:
    from mjbiped.records.record import Walk

OF_STANCE_KNEE = ("peak_stance_knee_torque_Nm", "cost_of_transport_stance_knee")
"""Keys of the measures of the stance knee of a robot with knees. The torque of a lock is known from samples alone."""

Touchdowns: TypeAlias = Mapping[str, NDArray[Any]]
"""Table of a walk's touchdowns, or a part of it; see `mjbiped.records.columns.TOUCHDOWNS`."""

SLIDING = 1.0 - 1e-3
"""Share of the friction coefficient at which a foot counts as sliding; MuJoCo's solver is accurate to 1e-4."""

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
    """Mechanical power of each joint at each sample, torque times joint rate, shape (samples, joints), W."""
    return np.asarray(walk.samples["torque"] * walk.robot.joint_rates(walk.samples["dq"]), dtype=np.float64)


def cost_of_transport(walk: Walk, kind: str = "absolute") -> float:
    """Mechanical cost of transport c_mt = work / (weight · distance); NaN for a walk without distance.

    Args:
        walk: The walk.
        kind: Kind of work, see `work`; "absolute" reproduces the paper's c_mt.

    Raises:
        InputError: The kind is unknown.
    """
    return _transport(work(walk, kind), walk.robot, distance(walk))


def _transport(work: float, robot: Robot, distance: float) -> float:
    return work / (robot.weight * distance) if distance > 0.0 else math.nan


def _share_bound(last: Mapping[str, float], robot: Robot) -> float:
    """Share of the time in which the sole has not transmitted the ankle torque asked for; NaN without a sole."""
    return last["sole_bound_time"] / last["time"] if robot.sole is not None and last["time"] > 0.0 else math.nan


def speed(walk: Walk) -> float:
    """Mean horizontal speed up to the last touchdown, m/s; NaN without a touchdown."""
    return _speed(distance(walk), float(walk.touchdowns["time"][-1])) if walk.steps else math.nan


def _speed(distance: float, time: float) -> float:
    return distance / time if time > 0.0 else math.nan


def step_lengths(walk: Walk) -> NDArray[np.float64]:
    """Distance from one stance foot to the next, shape (steps,), m."""
    return _lengths(walk.touchdowns, 0.0, walk.terrain.height_at(0.0))


def _lengths(touchdowns: Touchdowns, x: float, z: float) -> NDArray[np.float64]:
    """Step lengths of touchdowns that follow a stance foot at x, z (m)."""
    ways = (np.diff(np.append(first, touchdowns[name])) for name, first in (("x", x), ("z", z)))
    return np.asarray(np.hypot(*ways), dtype=np.float64)


def step_periods(walk: Walk) -> NDArray[np.float64]:
    """Time from one touchdown to the next, shape (steps,), s."""
    return np.asarray(np.diff(np.append(0.0, walk.touchdowns["time"])), dtype=np.float64)


def estimate_errors(walk: Walk) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Errors of the slope estimate, estimate minus true slope, rad; NaN for a controller that makes no estimate.

    Returns:
        Errors at the start of each step, after the update (27) at its touchdown, and at the end of each step, before
        the update at the next touchdown; shape (steps,) each. The last start is that of the unfinished step.
    """
    return _errors(walk.touchdowns, walk.terrain.slope_at(0.0))


def _errors(touchdowns: Touchdowns, slope: float) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Errors of the estimate in touchdowns that follow a stance foot on a slope (rad)."""
    slope_before = np.append(slope, touchdowns["slope"])[:-1]
    return touchdowns["slope_estimate"] - touchdowns["slope"], touchdowns["slope_estimate_before"] - slope_before


def impact_errors(walk: Walk) -> NDArray[np.float64]:
    """Relative error of the rates after each impact, measured / map - 1, shape (steps, angles).

    The map is the impact map, equation (2) of the paper, of the state before the impact. The samples of a simulator
    before and after an impact lie one physics step apart, and the motion in between contributes to the error.
    """
    return _impact_errors(walk.touchdowns, walk.robot)


def _impact_errors(touchdowns: Touchdowns, robot: Robot) -> NDArray[np.float64]:
    leaving = (touchdowns["stance"] - 1) % len(robot.bodies.limbs)
    bent = robot.flexion(touchdowns["qpos"], leaving)
    before = zip(touchdowns["q_before"], touchdowns["dq_before"], bent, strict=True)
    mapped = np.reshape([robot.rates_after_touchdown(*state) for state in before], touchdowns["dq"].shape)
    return np.asarray(touchdowns["dq"] / mapped - 1.0, dtype=np.float64)


def pulls(touchdowns: Touchdowns) -> NDArray[np.bool_]:
    """Whether the ground would have had to pull at the stance foot in the step that ends, shape (steps,).

    In the hybrid engine, whose stance foot cannot leave the ground, the least normal force is then below zero. In
    MuJoCo it is zero: the foot was off the ground. The answer is False for records that do not hold that force.
    """
    return np.asarray(touchdowns["normal_force"] <= 0.0)


def friction_asked(touchdowns: Touchdowns) -> NDArray[np.float64]:
    """Greatest `|F_t| / F_n` of the stance foot in the step that ends, shape (steps,).

    It is infinite where F_n falls below zero, as it can in the hybrid engine: the recorded ratio leaves out a foot that
    hardly presses on the ground, and is meaningless where the force passes through zero.
    """
    return np.where(touchdowns["normal_force"] < 0.0, np.inf, touchdowns["friction"])


def foot_length(walk: Walk, share: float = USUAL) -> float:
    """Length of the flat foot that contains the centre of pressure for a share of the time, m.

    It is infinite where no foot does, and NaN for records without the times; see `mjbiped.records.pressure`.
    """
    ahead, behind = (np.max(walk.touchdowns[f"pressure_{side}"], initial=-math.inf) for side in ("ahead", "behind"))
    return Sole(walk.pressure_times, walk.end[0], float(ahead), float(behind), walk.robot.leg_length).length(share)


def violations(touchdowns: Touchdowns) -> NDArray[np.bool_]:
    """Whether the step that ends violates the contact, shape (steps,): the ground pulls, or needs friction over 0.8.

    The stance foot of the hybrid engine stands all the same. In MuJoCo the foot hops or slides, and the walk may go on.
    Where the ground in MuJoCo was given less friction, a foot that slides on it violates nothing.
    """
    return pulls(touchdowns) | (friction_asked(touchdowns) > SLIDING * GROUND_FRICTION)


def verdict(outcome: str, violated: int | None) -> str:
    """Outcome of a walk, with finished walks split by whether any of their steps violate the contact."""
    if outcome != Outcome.FINISHED.words:
        return outcome
    return THROUGH_VIOLATING if violated else THROUGH


def summary(walk: Walk) -> dict[str, Any]:
    """All measures of a walk in plain JSON types; angles here are in degrees, as the names say.

    A measure that does not exist is None: a cost without a distance, an estimate of a controller that makes none, the
    torque of a locked stance knee in a walk without samples.
    """
    gathered = Summary(walk.robot, walk.terrain)
    gathered.take(walk.touchdowns)
    return gathered.to_dict(
        outcome=walk.outcome,
        end=walk.end,
        peak_torque=walk.peak_torque,
        warnings=walk.warnings,
        pressure_times=walk.pressure_times,
        stance_knee=stance_knee.peak_torque(walk) if "stance_knee_torque" in walk.samples else math.nan,
    )


class Summary:
    """Measures of a walk, from touchdowns that are given in parts and not kept.

    The result is bitwise the same for any division into parts.

    Attributes:
        steps: Number of touchdowns so far.
    """

    def __init__(self, robot: Robot, terrain: Terrain) -> None:
        """Begin without a touchdown.

        Args:
            robot: The robot that walks.
            terrain: The ground.
        """
        self.steps = 0
        self._robot = robot
        works = (name for name in tables_of(type(robot)).touchdowns if name.endswith(("_work", *WORK_KINDS)))
        self._last = {"x": 0.0, "z": terrain.height_at(0.0), "slope": terrain.slope_at(0.0), "time": 0.0}
        self._last |= dict.fromkeys((*works, "sole_bound_time"), 0.0)
        self._last_error = math.nan
        self._largest: dict[str, float] = {}
        self._least_force = math.inf  # N
        self._sums = dict.fromkeys(("length", "pulls", "violations", "strikes"), 0.0)

    def take(self, touchdowns: Touchdowns) -> None:
        """Add the touchdowns that follow.

        Args:
            touchdowns: Columns of the robot's touchdowns, with any number of rows.
        """
        count = len(touchdowns["time"])
        if not count:
            return
        last = self._last
        started, ended = _errors(touchdowns, last["slope"])
        largest = {
            "estimate_error_at_touchdown": np.abs(started),
            "estimate_error_at_step_end": np.abs(ended),
            "impact_error": np.abs(_impact_errors(touchdowns, self._robot)),
            "friction": np.abs(friction_asked(touchdowns)),
            **{name: np.abs(touchdowns[name]) for name in ("slip", "penetration")},
            **{name: touchdowns[name] for name in ("pressure_ahead", "pressure_behind")},
            "stance_knee": np.abs(touchdowns.get("stance_knee_torque", np.array(math.nan))),
        }
        for name, values in largest.items():  # NaN stays
            self._largest[name] = float(np.maximum(self._largest.get(name, -math.inf), np.max(values)))
        self._least_force = float(np.minimum(self._least_force, np.min(touchdowns["normal_force"])))
        for name, values in {
            "length": _lengths(touchdowns, last["x"], last["z"]),
            "pulls": pulls(touchdowns),
            "violations": violations(touchdowns),
            "strikes": touchdowns["strikes"],
        }.items():  # one after another, unlike NumPy's sum, whose rounding depends on the division into parts
            self._sums[name] = float(np.cumsum(np.append(self._sums[name], values))[-1])
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
        """Return the measures as `summary` does; the arguments are what the touchdowns do not tell, as in `Walk`.

        The greatest torque of the stance knee in the samples, `stance_knee` in N m, is needed for a locked knee alone.
        """
        last, steps, robot = self._last, self.steps, self._robot

        def largest(name: str) -> float:
            return self._largest.get(name, math.nan)

        def cost(work: str) -> float:
            return _transport(last[work], robot, last["x"])

        unknown = math.isnan(self._least_force)
        pulls, violations = (None if unknown else int(self._sums[name]) for name in ("pulls", "violations"))
        ahead, behind = largest("pressure_ahead"), largest("pressure_behind")
        sole = Sole(pressure_times, end[0], ahead, behind, robot.leg_length)
        measured: dict[str, Any] = {
            "steps": steps,
            "distance_m": last["x"],
            "time_s": last["time"],
            "speed_m_per_s": _speed(last["x"], last["time"]),
            "mean_step_length_m": self._sums["length"] / steps if steps else math.nan,
            "mean_step_period_s": last["time"] / steps if steps else math.nan,
            "cost_of_transport": cost("work_absolute"),
            "cost_of_transport_net": cost("work_net"),
            "cost_of_transport_positive": cost("work_positive"),
            **{f"peak_{joint}_torque_Nm": float(peak_torque[k]) for k, joint in enumerate(robot.joints)},
        }
        if "stance_knee_work" in last:
            peak = float(np.fmax(stance_knee, largest("stance_knee")))
            measured |= zip(OF_STANCE_KNEE, (peak, cost("stance_knee_work")), strict=True)
        measured |= {
            "estimate_error_at_touchdown_deg": math.degrees(largest("estimate_error_at_touchdown")),
            "estimate_error_at_step_end_deg": math.degrees(largest("estimate_error_at_step_end")),
            "final_estimate_error_deg": math.degrees(self._last_error),
            "largest_impact_error": largest("impact_error"),
            "largest_slip_m": largest("slip"),
            "largest_penetration_m": largest("penetration"),
            "largest_stance_friction": largest("friction"),
            "least_normal_force_weights": self._least_force / robot.weight if steps else math.nan,
            "steps_that_pull": pulls,
            "steps_violating_contact": violations,
            "pressure_ahead_m": ahead,
            "pressure_behind_m": behind,
            "foot_length_99_percent_m": sole.length(),
            "share_of_time_at_sole_bound": _share_bound(last, robot),
            "strikes": int(self._sums["strikes"]),
        }
        return {
            "outcome": outcome,
            "verdict": verdict(outcome, violations),
            "ended_at_time_s": end[0],
            "ended_at_x_m": end[1],
            **{name: None if value != value else value for name, value in measured.items()},
            "warnings": dict(warnings),
        }


Shown: TypeAlias = tuple[str, str, float, str, str]
"""How a measure is shown: label, key, factor to the displayed unit, format, and that unit."""


def measures_of(robot: type[Robot]) -> tuple[Shown, ...]:
    """Measures in the summary of a kind of robot, in the order in which they are shown."""
    parts = {"knee": "swing knee"}
    shown: list[Shown] = [
        ("steps", "steps", 1, "d", ""),
        ("distance", "distance_m", 1, ".3f", "m"),
        ("last touchdown at", "time_s", 1, ".3f", "s"),
        ("speed", "speed_m_per_s", 1, ".4f", "m/s"),
        ("step length, mean", "mean_step_length_m", 1, ".4f", "m"),
        ("step period, mean", "mean_step_period_s", 1, ".4f", "s"),
        ("cost of transport, absolute", "cost_of_transport", 1, ".4f", ""),
        ("cost of transport, net", "cost_of_transport_net", 1, ".4f", ""),
        ("cost of transport, positive", "cost_of_transport_positive", 1, ".4f", ""),
        *(
            (f"peak torque, {parts.get(name, name)}", f"peak_{name}_torque_Nm", 1, ".2f", "N m")
            for name in robot.joints
        ),
        ("peak torque, stance knee", OF_STANCE_KNEE[0], 1, ".2f", "N m"),
        ("cost of transport, stance knee's part", OF_STANCE_KNEE[1], 1, ".4f", ""),
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
        ("time in which the sole transmits less than asked", "share_of_time_at_sole_bound", 1e2, ".1f", "%"),
        ("impacts on vertical faces", "strikes", 1, "d", ""),
    ]
    return tuple(row for row in shown if row[1] not in OF_STANCE_KNEE or "knee" in robot.joints)


MEASURES = measures_of(Compass)
"""Measures in the summary of the compass biped."""


def in_words(value: float | None, factor: float, form: str) -> str:
    """Format a measure for display; a dash stands for one that does not exist."""
    return "-" if value is None else "unbounded" if value == math.inf else format(value * factor, form)
