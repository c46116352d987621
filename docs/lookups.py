"""Tables of the site that are made of the code: a record's columns, and the domains of numbers."""

from __future__ import annotations

from typing import Any

import mjbiped
from controllers import (
    AdaptiveController,
    EnergyConstraintController,
    KineticEnergyController,
    LimitCycleController,
    PassivityController,
)
from mjbiped.disturbances.disturbances import PUSHES
from mjbiped.engines.mujoco.engine import LEG
from mjbiped.engines.plan import Terms
from mjbiped.records.columns import tables_of
from mjbiped.robots.kinds import KINDS
from mjbiped.utils import domains


def samples() -> list[list[str]]:
    """Columns of samples."""
    return _columns("samples")


def touchdowns() -> list[list[str]]:
    """Columns of touchdowns."""
    return _columns("touchdowns")


def limits() -> list[list[str]]:
    """Domains of all quantities."""
    ranges = {name: str(domain).removeprefix("a whole number ") for name, domain in _DOMAINS.items()}
    return [["quantity", "domain"], *map(list, ranges.items())]


def _columns(table: str) -> list[list[str]]:
    rows: dict[str, list[str]] = {}
    kinds: dict[str, list[str]] = {}
    for kind, robot in KINDS.items():
        numbers = {robot.angles: "angles", robot.joints: "joints", robot.places: "places", (): "1"}
        for name, column in getattr(tables_of(robot), table).items():
            rows.setdefault(name, [f"`{name}`", numbers[column.parts], column.unit, column.meaning])
            kinds.setdefault(name, []).append(kind)
    robots = {name: "all" if len(those) == len(KINDS) else ", ".join(those) for name, those in kinds.items()}
    return [["column", "numbers", "unit", "meaning", "robots"], *([*row, robots[name]] for name, row in rows.items())]


def _of_field(kind: type, name: str) -> Any:
    """The domain in a field's annotation."""
    return domains.annotated(kind)[name][0]


_DOMAINS = {
    "`leg_mass`": domains.LEG_MASS,
    "`hip_mass`": domains.HIP_MASS,
    "`lower_length`, `upper_length`": domains.LENGTH,
    "`lower_length + upper_length`": domains.LEG,
    "`leg_inertia`": domains.INERTIA,
    "`foot_radius`": domains.FOOT_RADIUS,
    "`shank_offset`": _of_field(mjbiped.RoundKneed, "shank_offset"),
    "`stop_angle`": _of_field(mjbiped.RoundKneed, "stop_angle"),
    "`gravity`": domains.GRAVITY,
    "length of a leg in MuJoCo": LEG,
    "angle of a leg": domains.ANGLE,
    "rate of a leg": domains.RATE,
    "slope of a gait, plane or estimate": domains.SLOPE,
    "`steps` of a walk": domains.STEPS,
    "`distance`": domains.DISTANCE,
    "`timestep`": domains.TIMESTEP,
    "`contact_timestep`": _of_field(mjbiped.Mujoco, "contact_timestep"),
    "`control_period`": domains.CONTROL_PERIOD,
    "`sample_period`": _of_field(Terms, "sample_period"),
    "scuffing rule: `reach`": domains.REACH,
    "scuffing rule: `delay`": _of_field(mjbiped.ScuffingRule, "delay"),
    "`angle_noise`, `angle_resolution`": domains.ANGLE_NOISE,
    "`angle_bias`": _of_field(mjbiped.Disturbances, "angle_bias"),
    "`rate_noise`": _of_field(mjbiped.Disturbances, "rate_noise"),
    "`rate_bias`": _of_field(mjbiped.Disturbances, "rate_bias"),
    "`delay` of a control loop": _of_field(mjbiped.Disturbances, "delay"),
    "`torque_limit`": domains.TORQUE_LIMIT,
    "`motor_bandwidth`": _of_field(mjbiped.Disturbances, "motor_bandwidth"),
    "`push_impulse`": domains.IMPULSE,
    "impulse of a push at a given time": domains.PUSH,
    "pushes at given times": PUSHES,
    "`push_interval`": _of_field(mjbiped.Disturbances, "push_interval"),
    "`push_duration`": _of_field(mjbiped.Disturbances, "push_duration"),
    "`friction`": _of_field(mjbiped.Disturbances, "friction"),
    "factor of `--model-error`": domains.MODEL_ERROR,
    "`position_gain`, `velocity_gain`, `rate_gain`; `gain` of ECC and KETC": domains.GAIN,
    "`position_gain` of limit cycle tracking": _of_field(LimitCycleController, "position_gain"),
    "`adaptation_gain`": _of_field(AdaptiveController, "adaptation_gain"),
    "`gain` of PBC": _of_field(PassivityController, "gain"),
    "`ratio` of ECC, not 0": _of_field(EnergyConstraintController, "ratio"),
    "`singular_band`, `slowest`": domains.SLOWEST_RATE,
    "`hip_weight` of KETC": _of_field(KineticEnergyController, "hip_weight"),
    "`replanning_delay`": _of_field(AdaptiveController, "replanning_delay"),
    "`update_threshold`": _of_field(AdaptiveController, "update_threshold"),
    "`replanning_threshold`": _of_field(AdaptiveController, "replanning_threshold"),
    "terrain: places and heights": domains.PLACE,
    "terrain: length of a segment": domains.STRETCH,
    "terrain: height of a step": domains.STEP,
    "terrain: segments": domains.SEGMENTS,
    "seeds": domains.SEED,
    "steps of a return map": domains.MAP_STEPS,
    "starts along a side of a basin": domains.GRID,
    "walks of a study": domains.WALKS,
    "threads and processes": domains.WORKERS,
}
