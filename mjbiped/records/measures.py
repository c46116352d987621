"""Measures of a walk, each defined once for every engine, in SI units and radians."""

from __future__ import annotations

import math
from collections import defaultdict
from collections.abc import Mapping
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from mjbiped.errors import InputError, shown
from mjbiped.records.columns import Table, tables_of
from mjbiped.records.loads import peak_knee_torque, shortest_foot
from mjbiped.robots.robot import Array, Robot
from mjbiped.rules.termination import Outcome
from mjbiped.terrain.profile import GROUND_FRICTION
from mjbiped.terrain.terrain import Terrain

if TYPE_CHECKING:
    from mjbiped.records.record import Walk

SLIDING = 1.0 - 1e-3
"""Share of the friction coefficient at which a foot counts as sliding; MuJoCo's solver is accurate to 1e-4."""

FINISHED = Outcome.FINISHED.words
VIOLATING = f"{FINISHED}, contact violated"
"""Verdicts of walks that finished; see `violations`."""

WORK_KINDS = ("absolute", "net", "positive")


def ratio(part: float, whole: float) -> float:
    """Divide two numbers; NaN where the divisor is not positive."""
    return part / whole if whole > 0.0 else math.nan


def distance(walk: Walk) -> float:
    """Horizontal distance of the stance foot from x = 0 to the last touchdown, m."""
    return _last(walk, "x")


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
    return _last(walk, f"work_{kind}")


def powers(walk: Walk) -> Array:
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
    return ratio(work(walk, kind), walk.robot.weight * distance(walk))


def speed(walk: Walk) -> float:
    """Mean horizontal speed up to the last touchdown, m/s; NaN without a touchdown."""
    return ratio(distance(walk), _last(walk, "time"))


def _last(walk: Walk, name: str) -> float:
    return float(walk.touchdowns[name][-1]) if walk.steps else 0.0


def step_lengths(walk: Walk | Part) -> Array:
    """Distance from one stance foot to the next, shape (steps,), m."""
    ways = (np.diff(np.append(walk.start[name], walk.touchdowns[name])) for name in ("x", "z"))
    return np.asarray(np.hypot(*ways), dtype=np.float64)


def step_periods(walk: Walk) -> Array:
    """Time from one touchdown to the next, shape (steps,), s."""
    return np.asarray(np.diff(np.append(0.0, walk.touchdowns["time"])), dtype=np.float64)


def estimate_errors(walk: Walk | Part) -> tuple[Array, Array]:
    """Errors of the slope estimate, estimate minus true slope, rad; NaN for a controller that makes no estimate.

    Returns:
        Errors at the start of each step, after the update (27) at its touchdown, and at the end of each step, before
        the update at the next touchdown; shape (steps,) each. The last start is that of the unfinished step.
    """
    touchdowns, slopes = walk.touchdowns, np.append(walk.start["slope"], walk.touchdowns["slope"])
    return touchdowns["slope_estimate"] - slopes[1:], touchdowns["slope_estimate_before"] - slopes[:-1]


def impact_errors(walk: Walk | Part) -> Array:
    """Relative error of the rates after each impact, measured / map - 1, shape (steps, angles).

    The map is the impact map, equation (2) of the paper, of the state before the impact. The samples of a simulator
    before and after an impact lie one physics step apart, and the motion in between contributes to the error.
    """
    touchdowns, robot = walk.touchdowns, walk.robot
    leaving = (touchdowns["stance"] - 1) % len(robot.bodies.limbs)
    bent = robot.flexion(touchdowns["qpos"], leaving)
    before = zip(touchdowns["q_before"], touchdowns["dq_before"], bent, strict=True)
    mapped = np.reshape([robot.rates_after_touchdown(*state) for state in before], touchdowns["dq"].shape)
    return np.asarray(touchdowns["dq"] / mapped - 1.0, dtype=np.float64)


def pulls(touchdowns: Table) -> NDArray[np.bool_]:
    """Whether the ground would have had to pull at the stance foot in the step that ends, shape (steps,).

    In the hybrid engine, whose stance foot cannot leave the ground, the least normal force is then below zero. In
    MuJoCo it is zero: the foot was off the ground. The answer is False for records that do not hold that force.
    """
    return np.asarray(touchdowns["normal_force"] <= 0.0)


def friction_asked(touchdowns: Table) -> Array:
    """Greatest `|F_t| / F_n` of the stance foot in the step that ends, shape (steps,).

    It is infinite where F_n falls below zero, as it can in the hybrid engine: the recorded ratio leaves out a foot that
    hardly presses on the ground, and is meaningless where the force passes through zero.
    """
    return np.where(touchdowns["normal_force"] < 0.0, np.inf, touchdowns["friction"])


def violations(touchdowns: Table) -> NDArray[np.bool_]:
    """Whether the step that ends violates the contact, shape (steps,): the ground pulls, or needs friction over 0.8.

    The stance foot of the hybrid engine stands all the same. In MuJoCo the foot hops or slides, and the walk may go on.
    Where the ground in MuJoCo was given less friction, a foot that slides on it violates nothing.
    """
    return pulls(touchdowns) | (friction_asked(touchdowns) > SLIDING * GROUND_FRICTION)


def verdict(outcome: str, violated: int | None) -> str:
    """Outcome of a walk, which says of a finished one whether any of its steps violate the contact."""
    return VIOLATING if outcome == FINISHED and violated else outcome


def summary(walk: Walk) -> dict[str, Any]:
    """All measures of a walk in plain JSON types; angles here are in degrees, as the names say.

    A measure that does not exist is None: a cost without a distance, an estimate of a controller that makes none, the
    torque of a locked stance knee in a walk without samples.
    """
    gathered = Summary(walk.robot, walk.terrain)
    gathered.take(walk.touchdowns)
    return gathered.to_dict(walk)


def start_of(terrain: Terrain) -> dict[str, float]:
    """The stance foot at the start of a walk: its place x and z (m), the slope under it (rad), and the time (s)."""
    return {"x": 0.0, "z": terrain.height_at(0.0), "slope": terrain.slope_at(0.0), "time": 0.0}


class Part(NamedTuple):
    """Table of a walk that follow another touchdown, or the start of the walk as `start_of` gives it."""

    robot: Robot
    touchdowns: Table
    start: Mapping[str, float]


class Summary:
    """Measures of a walk, from touchdowns that are given in parts and not kept.

    The result is bitwise the same for any division into parts.

    Attributes:
        robot: The robot that walks.
        steps: Number of touchdowns so far.
        last: Columns of the last touchdown.
    """

    def __init__(self, robot: Robot, terrain: Terrain) -> None:
        """Begin without a touchdown.

        Args:
            robot: The robot that walks.
            terrain: The ground.
        """
        self.robot, self.steps = robot, 0
        works = (name for name in tables_of(type(robot)).touchdowns if name.endswith(("_work", *WORK_KINDS)))
        self.last = start_of(terrain) | dict.fromkeys((*works, "sole_bound_time"), 0.0)
        self._last_error, self._least_force = math.nan, math.inf
        self._sums = dict.fromkeys(("length", "pulls", "violations", "strikes"), 0.0)
        self._largest: dict[str, float] = defaultdict(lambda: math.nan)  # without a step

    def take(self, touchdowns: Table) -> None:
        """Add the touchdowns that follow.

        Args:
            touchdowns: Columns of the robot's touchdowns, with any number of rows.
        """
        if not len(touchdowns["time"]):
            return
        part = Part(self.robot, touchdowns, self.last)
        started, ended = estimate_errors(part)
        for name, values in {
            "started": np.abs(started),
            "ended": np.abs(ended),
            "impact": np.abs(impact_errors(part)),
            "friction": np.abs(friction_asked(touchdowns)),
            **{name: np.abs(touchdowns[name]) for name in ("slip", "penetration")},
            **{side: touchdowns[f"pressure_{side}"] for side in ("ahead", "behind")},
            "knee": np.abs(touchdowns.get("stance_knee_torque", np.array(math.nan))),
        }.items():
            before = self._largest[name] if self.steps else -math.inf
            self._largest[name] = float(np.maximum(before, np.max(values)))  # NaN stays
        self._least_force = float(np.minimum(self._least_force, np.min(touchdowns["normal_force"])))
        for name, values in {
            "length": step_lengths(part),
            "pulls": pulls(touchdowns),
            "violations": violations(touchdowns),
            "strikes": touchdowns["strikes"],
        }.items():  # one after another, unlike NumPy's sum, whose rounding depends on the division into parts
            self._sums[name] = float(np.cumsum(np.append(self._sums[name], values))[-1])
        self.last = {name: float(touchdowns[name][-1]) for name in self.last}
        self._last_error = float(ended[-1])
        self.steps += len(touchdowns["time"])

    def to_dict(self, walk: Walk) -> dict[str, Any]:
        """Return the measures as `summary` does, of a walk whose touchdowns were taken; the record may lack them."""
        robot, steps, last, sums, largest = self.robot, self.steps, self.last, self._sums, self._largest
        x, time, load = last["x"], last["time"], robot.weight * last["x"]
        forces_known = not math.isnan(self._least_force)
        foot = shortest_foot(walk.pressure_times, walk.end[0], largest["ahead"], largest["behind"], robot.leg_length)
        violating = int(sums["violations"]) if forces_known else None
        measured: dict[str, Any] = {
            "outcome": walk.outcome,
            "verdict": verdict(walk.outcome, violating),
            "ended_at_time_s": walk.end[0],
            "ended_at_x_m": walk.end[1],
            "steps": steps,
            "distance_m": x,
            "time_s": time,
            "speed_m_per_s": ratio(x, time),
            "mean_step_length_m": ratio(sums["length"], steps),
            "mean_step_period_s": ratio(time, steps),
            "cost_of_transport": ratio(last["work_absolute"], load),
            "cost_of_transport_net": ratio(last["work_net"], load),
            "cost_of_transport_positive": ratio(last["work_positive"], load),
            **({"cost_of_transport_roll": ratio(last["roll_work"], load)} if "roll_work" in last else {}),
            **{f"peak_{joint}_torque_Nm": float(walk.peak_torque[k]) for k, joint in enumerate(robot.joints)},
            "estimate_error_at_touchdown_deg": math.degrees(largest["started"]),
            "estimate_error_at_step_end_deg": math.degrees(largest["ended"]),
            "final_estimate_error_deg": math.degrees(self._last_error),
            "largest_impact_error": largest["impact"],
            "largest_slip_m": largest["slip"],
            "largest_penetration_m": largest["penetration"],
            "largest_stance_friction": largest["friction"],
            "least_normal_force_weights": self._least_force / robot.weight if steps else math.nan,
            "steps_that_pull": int(sums["pulls"]) if forces_known else None,
            "steps_violating_contact": violating,
            "pressure_ahead_m": largest["ahead"],
            "pressure_behind_m": largest["behind"],
            "foot_length_99_percent_m": foot,
            "share_of_time_at_sole_bound": math.nan if robot.sole is None else ratio(last["sole_bound_time"], time),
            "strikes": int(sums["strikes"]),
        }
        if "knee" in robot.joints:
            measured["peak_stance_knee_torque_Nm"] = float(np.fmax(peak_knee_torque(walk), largest["knee"]))
            measured["cost_of_transport_stance_knee"] = ratio(last["stance_knee_work"], load)
        known = {name: None if value != value else value for name, value in measured.items()}
        return {**known, "warnings": dict(walk.warnings)}
