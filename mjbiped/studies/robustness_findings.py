"""Findings of a robustness study, controller by controller: what its tables and pictures show."""

from __future__ import annotations

import itertools
import math
from collections import defaultdict
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Any, TypeAlias

import numpy as np

from mjbiped.analysis.survival import CONFIDENCE, SURVIVED, Survival, ratio
from mjbiped.robots.kneed import KneedBiped
from mjbiped.studies.cell import FAILED, Row
from mjbiped.studies.robustness import Plan
from mjbiped.studies.robustness_walks import ALL, BASIN, DISTURBANCES, LEVEL, SURVIVAL, Disturbance, rough_from

VIOLATING = "steps_violating_contact"
FORGETTING = 5
"""Number of steps on fully rough ground until a walk no longer depends on its beginning."""
SOLE = "foot_length_99_percent_m"
TORQUES = tuple(f"peak_{joint}_torque_Nm" for joint in KneedBiped.joints)

Findings: TypeAlias = dict[str, Any]
"""Findings of one controller in one engine in plain types, as `mjbiped robustness --json` prints them; NaN is an
unknown value. The foot length is that of a foot that would contain the centre of pressure for 99 % of the time: the
median of the walks on random ground, the greatest of the walks at the limit of a disturbance."""


@dataclass(frozen=True)
class Robustness:
    """Findings of a robustness study.

    Attributes:
        plan: The plan of the study.
        rows: Rows of its walks.
    """

    plan: Plan
    rows: Sequence[Row]

    @cached_property
    def findings(self) -> list[Findings]:
        """Findings of each controller in each engine, in the order of the file."""
        return [self._findings(*each) for each in itertools.product(self.plan.engines, self.plan.controllers)]

    def of(self, engine: str) -> list[Findings]:
        """Findings in one engine, in the order of the file."""
        return [each for each in self.findings if each["engine"] == engine]

    def summary(self) -> dict[str, object]:
        """Summarise the study and all findings in plain types."""
        plan, limits, margins = self.plan, self.plan.limits, self.plan.margins
        return {
            "confidence": CONFIDENCE,
            "scuffing": {"reach_leg_lengths": plan.scuffing.reach, "delay_s": plan.scuffing.delay},
            "limits": {
                "share": limits.share, "phases": limits.phases, "torque_Nm": limits.torque, "basin": limits.basin,
            },
            "margins": {"share": margins.share, "ground": margins.ground, "steps": margins.steps},
            "random_ground": {"seeds": plan.seeds, "steps": plan.steps},
            "controllers": self.findings,
        }  # fmt: skip

    def survival(self, engine: str, controller: str, ground: str, *, settled: bool = False) -> Survival | None:
        """Survival of a controller's walks on a random ground; None without such walks.

        `settled` leaves out the transient, which ends `FORGETTING` steps after the ground has its full roughness.
        """
        rows = self._on(engine, controller, ground)
        if not rows:
            return None
        found = Survival(tuple(row["steps"] for row in rows), tuple(row["outcome"] not in SURVIVED for row in rows))
        length = _number(self._level(engine, controller), "mean_step_length_m")
        transient = FORGETTING + (math.ceil(rough_from(ground) / length) if length > 0.0 else 0)
        return found.after(transient) if settled else found

    @cached_property
    def _tested(self) -> Mapping[tuple[str, str, str], list[Row]]:
        """Rows by engine, controller and test."""
        groups: dict[tuple[str, str, str], list[Row]] = defaultdict(list)
        for row in self.rows:
            groups[row["engine"], row["controller"], row["test"]].append(row)
        return groups

    def _on(self, engine: str, controller: str, ground: str) -> list[Row]:
        """Rows of the walks on a random ground that no error ended, in the order of the seeds."""
        rows = self._tested[engine, controller, SURVIVAL]
        there = (row for row in rows if row["ground"] == ground and row["outcome"] != FAILED)
        return sorted(there, key=lambda row: row["case"])

    def _level(self, engine: str, controller: str) -> Row:
        """Row of the walk on level ground; empty where an error ended it."""
        return next((row for row in self._tested[engine, controller, LEVEL] if row["outcome"] != FAILED), {})

    def _findings(self, engine: str, controller: str) -> Findings:
        level, plan = self._level(engine, controller), self.plan
        mine = (row for row in self.rows if (row["engine"], row["controller"]) == (engine, controller))
        errors = dict.fromkeys(row["error"] for row in mine if row["outcome"] == FAILED)
        on_ground = {ground: self._random(engine, controller, ground) for ground in plan.grounds}
        tests = (*plan.limits.magnitudes, *plan.margins.magnitudes)
        return {
            "controller": controller,
            "engine": engine,
            "level": {name: _number(level, name) for name in ("cost_of_transport", SOLE, "speed_m_per_s")},
            "survival": {ground: found for ground, found in on_ground.items() if found is not None},
            "greatest_survived": {test: self._limit(test, self._tested[engine, controller, test]) for test in tests},
            "basin": self._basin(controller, self._tested[engine, controller, BASIN]),
            "errors": [*errors],
        }

    def _random(self, engine: str, controller: str, ground: str) -> Findings | None:
        """Findings on a random ground; None where no walk was made there."""
        survival, settled = (self.survival(engine, controller, ground, settled=each) for each in (False, True))
        if survival is None or settled is None:
            return None
        rows = [row for row in self._on(engine, controller, ground) if row["steps"]]
        distance = sum(_number(row, "distance_m") for row in rows)
        work = sum(_number(row, "cost_of_transport") * _number(row, "distance_m") for row in rows)
        soles = [_number(row, SOLE) for row in rows if row[SOLE] is not None]
        violating = sum(row[VIOLATING] for row in rows)
        first = next(iter(self.plan.controllers))
        compared = None if controller == first else self.survival(engine, first, ground, settled=True)
        return {
            "walks": len(survival.steps),
            "cost_of_transport": work / distance if distance else math.nan,
            SOLE: float(np.median(soles)) if soles else math.nan,
            "falls_after_transient": settled.falls,
            "falls": survival.falls,
            "mean_steps_to_fall": settled.mean,
            "interval": [*settled.interval],
            "second_eigenvalue": settled.eigenvalue,
            "misfit_of_kaplan_meier": settled.misfit,
            "share_of_steps_violating_contact": violating / max(sum(survival.steps), 1),
            **({} if compared is None else {"ratio_to_first": [*ratio(settled, compared)]}),
        }

    def _limit(self, test: str, rows: Iterable[Row]) -> dict[str, object]:
        """Find the greatest magnitude that a controller survives, with and without walks that violate contact."""
        kind = ALL[test]
        tried = self.plan.limits if test in DISTURBANCES else self.plan.margins
        found: list[float | None] = []
        for on_any_ground in (False, True):
            survived: dict[float, list[bool]] = defaultdict(list)
            for row in rows:
                survived[row["magnitude"]].append(_survived(row, tried.torque, on_any_ground) and kind.borne(row))
            found.append(greatest_survived(kind, survived, tried.share))
        soles = (_number(row, SOLE) for row in rows if row["magnitude"] == found[0])
        return {
            "magnitude": found[0],
            SOLE: max(soles, default=math.nan),
            "with_contact_violated": found[1],
            "unit": kind.unit,
            "beyond_what_was_tried": found[0] == tried.magnitudes[test][-1],
        }

    def _basin(self, controller: str, rows: Sequence[Row]) -> dict[str, float]:
        """Share of the first rates of the legs from which the robot walks on, and their area."""
        if not rows:
            return {"share": math.nan, "area_rad2_per_s2": math.nan}
        share = sum(_survived(row, self.plan.limits.torque) for row in rows) / len(rows)
        cells = (cell.values for cell in self.plan.study.cells)
        mine = [values for values in cells if (values["test"], values["controller"]) == (BASIN, controller)]
        tried = [[float(values[f"initial.{rate}"]) for values in mine] for rate in ("dq1", "dq2")]
        return {"share": share, "area_rad2_per_s2": share * float(np.prod(np.ptp(tried, axis=1)))}


def greatest_survived(kind: Disturbance, survived: Mapping[float, Sequence[bool]], wanted: float) -> float | None:
    """Find the hardest magnitude up to which every one is survived; None if the gentlest is not.

    A robot that survives 60 mm and 80 mm, but not 70 mm, survives 60 mm.

    Args:
        kind: The disturbance, which says in what order magnitudes become harder.
        survived: Whether each case was survived, by magnitude.
        wanted: Share of the cases that counts as survived.
    """
    greatest = None
    for magnitude in sorted(survived, reverse=kind.falls):
        if sum(survived[magnitude]) / len(survived[magnitude]) < wanted:
            break
        greatest = magnitude
    return greatest


def _survived(row: Row, torque: float | None, on_any_ground: bool = False) -> bool:
    """Whether a robot walked on within the torque allowed and, unless accepted, without violating the contact."""
    if row["outcome"] not in SURVIVED or (row[VIOLATING] and not on_any_ground):
        return False
    return torque is None or all(row[name] <= torque for name in TORQUES if row.get(name) is not None)


def _number(row: Row, name: str) -> float:
    value = row.get(name)
    return math.nan if value is None else float(value)
