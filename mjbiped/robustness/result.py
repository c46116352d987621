"""Findings of a robustness study, controller by controller."""

from __future__ import annotations

import itertools
import math
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from mjbiped.analysis.survival import CONFIDENCE, SURVIVED, Survival, ratio
from mjbiped.robots.kneed import KneedBiped
from mjbiped.robustness.limits import DISTURBANCES, MARGINS, Limit, limit_of
from mjbiped.robustness.walks import BASIN, LEVEL, SURVIVAL, Plan, rough_from
from mjbiped.sweeps.cell import FAILED, Row

VIOLATING = "steps_violating_contact"
FORGETTING = 5
"""Number of steps on ground of full roughness in which a walk forgets how it began."""
SOLE = "foot_length_99_percent_m"
TORQUES = tuple(f"peak_{joint}_torque_Nm" for joint in KneedBiped.joints)


@dataclass(frozen=True)
class Findings:
    """Findings of one controller in one engine.

    Attributes:
        controller: The controller's label.
        engine: The engine's name.
        level: The row of its walk on level ground.
        survival: Survival of the walks on each random ground.
        settled: Survival after the transient, which ends `FORGETTING` steps after the ground has reached its full
            roughness, on each random ground.
        costs: Cost of transport of all walks on each random ground; NaN where it is not known.
        soles: Length of the foot that would hold the centre of pressure for 99 % of the time, m: on level ground
            ("level"), by random ground the median of the walks, by disturbance the greatest at the limit; NaN where
            it is not known.
        limits: Limit of each disturbance, single or lasting, on ground that real feet could stand on.
        limits_violating: Limits that also count walks that violate the contact, see
            `mjbiped.records.measures.violations`.
        violating: Share of steps that violate the contact, on each random ground; NaN where it is not known.
        basin: Share of the first rates of the legs from which the robot walks on; NaN where none were tried.
        basin_area: Area of these rates, rad^2/s^2; NaN where none were tried.
        errors: Texts of the errors that ended walks; such walks do not count on random ground, and are not survived
            otherwise.
    """

    controller: str
    engine: str
    level: Row
    survival: Mapping[str, Survival]
    settled: Mapping[str, Survival]
    costs: Mapping[str, float]
    soles: Mapping[str, float]
    limits: Mapping[str, Limit]
    limits_violating: Mapping[str, Limit]
    violating: Mapping[str, float]
    basin: float
    basin_area: float
    errors: tuple[str, ...]

    @property
    def level_cost(self) -> float:
        """Cost of transport on level ground; NaN where the robot did not walk there."""
        return _number(self.level, "cost_of_transport")


@dataclass(frozen=True)
class Robustness:
    """Findings of a robustness study.

    Attributes:
        plan: The plan of the study.
        findings: Findings of each controller in each engine.
    """

    plan: Plan
    findings: tuple[Findings, ...]

    def of(self, engine: str) -> list[Findings]:
        """Findings in one engine, in the order of the file."""
        return [each for each in self.findings if each.engine == engine]

    def ratios(self, engine: str, ground: str) -> dict[str, tuple[float, float, float]]:
        """Mean steps to a fall of each other controller in multiples of the first one's, by label; see `ratio`."""
        first, *others = self.of(engine)
        return {each.controller: ratio(each.settled[ground], first.settled[ground]) for each in others}

    def summary(self) -> dict[str, Any]:
        """Summarise all findings in plain JSON types; null stands for what is infinite or was not walked."""
        plan, limits, margins = self.plan, self.plan.limits, self.plan.margins
        return {
            "confidence": CONFIDENCE,
            "scuffing": {"reach_leg_lengths": plan.scuffing.reach, "delay_s": plan.scuffing.delay},
            "limits": {"share": limits.share, "phases": plan.phases, "torque_Nm": limits.torque, "basin": plan.basin},
            "margins": {"share": margins.share, "ground": plan.margin_ground, "steps": margins.steps},
            "random_ground": {"seeds": plan.seeds, "steps": plan.steps},
            "controllers": [_summary(self, each) for each in self.findings],
        }


def found(plan: Plan, rows: Sequence[Row]) -> Robustness:
    """Evaluate the rows of a plan."""
    each = itertools.product(plan.engines, plan.controllers)
    return Robustness(plan, tuple(_findings(plan, controller, engine, rows) for engine, controller in each))


def _findings(plan: Plan, controller: str, engine: str, rows: Iterable[Row]) -> Findings:
    mine = [row for row in rows if row["controller"] == controller and row["engine"] == engine]
    walked = [row for row in mine if row["outcome"] != FAILED]
    level = next((row for row in walked if row["test"] == LEVEL), {})
    survival, settled, costs, violating = {}, {}, {}, {}
    soles = {LEVEL: _number(level, SOLE)}
    for ground in plan.grounds:
        there = sorted((r for r in walked if r["test"] == SURVIVAL and r["ground"] == ground), key=lambda r: r["case"])
        if there:
            fell = tuple(row["outcome"] not in SURVIVED for row in there)
            survival[ground] = Survival(tuple(row["steps"] for row in there), fell)
            settled[ground] = survival[ground].after(_transient(ground, level))
            costs[ground] = _cost(there)
            lengths = np.array([_number(row, SOLE) for row in there])
            lengths = lengths[np.isfinite(lengths)]
            soles[ground] = float(np.median(lengths)) if lengths.size else math.nan
            violating[ground] = sum(_number(row, VIOLATING) for row in there) / max(sum(survival[ground].steps), 1)
    limits, limits_violating = (
        {test: _limit(plan, test, mine, on_any_ground) for test in (*plan.limits.magnitudes, *plan.margins.magnitudes)}
        for on_any_ground in (False, True)
    )
    for test, limit in limits.items():
        at = [_number(row, SOLE) for row in mine if row["test"] == test and row["magnitude"] == limit.greatest]
        soles[test] = max(at, default=math.nan)
    recovered = [_survived(row, plan.limits.torque) for row in mine if row["test"] == BASIN]
    basin = sum(recovered) / len(recovered) if recovered else math.nan
    errors = tuple(dict.fromkeys(row["error"] for row in mine if row["outcome"] == FAILED))
    of_grounds, of_limits = (survival, settled, costs, soles), (limits, limits_violating, violating)
    return Findings(
        controller, engine, level, *of_grounds, *of_limits, basin, basin * _window(plan, controller), errors
    )


def _transient(ground: str, level: Row) -> int:
    """Number of steps, as long as on level ground, until a ground has its full roughness and the start is forgotten."""
    length = _number(level, "mean_step_length_m")
    return math.ceil(rough_from(ground) / length) + FORGETTING if length > 0.0 else FORGETTING


def _cost(rows: Sequence[Row]) -> float:
    """Cost of transport of several walks of one robot: all work over the weight and the whole distance."""
    pairs = [(_number(row, "cost_of_transport"), _number(row, "distance_m")) for row in rows if row["steps"]]
    distance = sum(metres for _, metres in pairs)
    return sum(cost * metres for cost, metres in pairs) / distance if distance else math.nan


def _limit(plan: Plan, test: str, rows: Iterable[Row], on_any_ground: bool) -> Limit:
    """Find the greatest magnitude that a controller survives, with or without walks that violate the contact."""
    kind = {**DISTURBANCES, **MARGINS}[test]
    trial = plan.limits if test in DISTURBANCES else plan.margins
    survived: dict[float, list[bool]] = {}
    for row in rows:
        if row["test"] == test:
            walked_on = _survived(row, trial.torque, on_any_ground)
            survived.setdefault(row["magnitude"], []).append(walked_on and kind.borne(row))
    return limit_of(kind, survived, trial.share)


def _window(plan: Plan, controller: str) -> float:
    """Area of the first rates that were tried, rad^2/s^2; 0 where none were."""
    cells = (cell.values for cell in plan.study.cells)
    mine = [values for values in cells if (values["test"], values["controller"]) == (BASIN, controller)]
    tried = [[float(values[f"initial.{rate}"]) for values in mine] for rate in ("dq1", "dq2")]
    return float(np.prod(np.ptp(tried, axis=1))) if mine else 0.0


def _survived(row: Row, torque: float | None, on_any_ground: bool = False) -> bool:
    """Whether a robot walked on within the torque allowed and, unless accepted, without violating the contact."""
    if row["outcome"] not in SURVIVED or (row[VIOLATING] and not on_any_ground):
        return False
    return torque is None or all(row[name] <= torque for name in TORQUES if row.get(name) is not None)


def _number(row: Row, name: str) -> float:
    value = row.get(name)
    return math.nan if value is None else float(value)


def _summary(robustness: Robustness, each: Findings) -> dict[str, Any]:
    first = robustness.of(each.engine)[0]
    survival = {}
    for ground, settled in each.settled.items():
        low, high = settled.interval
        survival[ground] = {
            "walks": len(settled.steps),
            "cost_of_transport": _finite(each.costs[ground]),
            "foot_length_99_percent_m": _finite(each.soles[ground]),
            "falls_after_transient": settled.falls,
            "falls": each.survival[ground].falls,
            "mean_steps_to_fall": _finite(settled.mean),
            "interval": [_finite(low), _finite(high)],
            "second_eigenvalue": _finite(settled.eigenvalue),
            "misfit_of_kaplan_meier": _finite(settled.misfit),
            "share_of_steps_violating_contact": _finite(each.violating[ground]),
        }
        if each is not first and ground in first.settled:
            survival[ground]["ratio_to_first"] = [_finite(x) for x in ratio(settled, first.settled[ground])]
    return {
        "controller": each.controller,
        "engine": each.engine,
        "level": {
            "cost_of_transport": _finite(each.level_cost),
            "foot_length_99_percent_m": _finite(each.soles[LEVEL]),
            "speed_m_per_s": _finite(_number(each.level, "speed_m_per_s")),
        },
        "survival": survival,
        "greatest_survived": {
            test: {
                "magnitude": limit.greatest,
                "foot_length_99_percent_m": _finite(each.soles[test]),
                "with_contact_violated": each.limits_violating[test].greatest,
                "unit": limit.unit,
                "beyond_what_was_tried": not limit.reached,
            }
            for test, limit in each.limits.items()
        },
        "basin": {"share": _finite(each.basin), "area_rad2_per_s2": _finite(each.basin_area)},
        "errors": list(each.errors),
    }


def _finite(value: float) -> float | None:
    return value if math.isfinite(value) else None
