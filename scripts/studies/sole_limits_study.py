"""Limits of walking on a sole: riser, grade, the grounds from other phases, how long a decision takes, and knees.

Five minutes on two cores. The tables stand in `docs/tables/feet.md`.

    python -m scripts.studies.sole_limits_study --tables docs/tables/feet
"""

from __future__ import annotations

import ctypes
import math
import time
from collections.abc import Callable, Iterable, Sequence
from dataclasses import replace
from functools import cached_property
from pathlib import Path

import click
import numpy as np

import mjbiped
from controllers import BoundedKneedController, KneedController, Memory, SupervisedController
from mjbiped import Terrain
from mjbiped.analysis.replay import replayed
from mjbiped.control.compiled import MachineCode
from mjbiped.controllers.room import RECOVERING
from scripts.pages import TABLES, show_table
from scripts.studies.soles_study import BEFORE, PHASES, STEP, STEPS, grounds, through, told
from scripts.studies.supervised_study import CLEARANCE

LENGTHS = (0.005, 0.05, 0.08, 0.12)  # m: soles; the first is next to none
RISERS = range(1, 10)  # cm
GRADES = range(1, 15)  # degrees
WITH_KNEES = (
    "level",
    "3° up",
    "5° up",
    "3° down",
    "stairs +2 cm",
    "stairs +3 cm",
    "stairs −2 cm",
    "stairs −6 cm",
    "mixed",
)
OFF = 1e-6  # an adaptation gain that does nothing within a walk


def law(sole: float) -> SupervisedController:
    """The supervised law on a sole that reaches as far behind the ankle as ahead of it, m."""
    robot = mjbiped.Compass(sole=(sole, sole))
    # the reference of a sole that bears it as it is; all longer ones have the same
    gait = mjbiped.find_reference(replace(robot, sole=(max(sole, 0.05),) * 2), clearance=CLEARANCE, retraction=False)
    return SupervisedController(robot, gait)


def greatest(walker: SupervisedController, made: Callable[[float, int], Terrain], sizes: Iterable[int]) -> int:
    """The greatest of ascending sizes up to which none of eight walks falls; 0 if some fall at the first."""
    last = 0
    for size in sizes:
        terrains = [made(BEFORE + STEP * (phase + 0.5) / PHASES, size) for phase in range(PHASES)]
        walks = mjbiped.walk_many(walker, terrains, engine="hybrid", steps=STEPS, summaries=True)
        if any(walk["outcome"] != "finished" for walk in walks):
            break
        last = size
    return last


def riser(first: float, rise: int) -> Terrain:
    """Level ground with one riser, in cm."""
    return Terrain.from_segments([(first, 0.0, 0.0), (60.0, 0.0, rise / 100)])


def grade(first: float, degrees: int) -> Terrain:
    """Level ground, then a grade up."""
    return Terrain.from_segments([(first, 0.0, 0.0), (60.0, -degrees, 0.0)])


def estimates(walker: SupervisedController) -> tuple[float, float]:
    """Riser, m, and grade, rad, by energy: of one step of the gait with the ground's force at the heel.

    The ankle works c m g for each radian. Over a riser that and the kinetic energy at mid-stance have to lift the
    robot, v²/2g + c 2 alpha; up a grade it has to do what level ground costs, and the rest: c/l - c_mt.
    """
    gait, robot = walker.gait, walker.robot
    assert robot.sole is not None
    heel = walker.sole_share * robot.sole[0]
    slowest = robot.leg_length * min(abs(gait.reference(t)[1][0]) for t in np.linspace(0.0, gait.period, 200))
    lifted = slowest**2 / (2.0 * robot.gravity) + heel * abs(gait.start[0] - gait.start[1])
    level = mjbiped.walk(walker, Terrain.level(), engine="hybrid", steps=STEPS).summary()["cost_of_transport"]
    return float(lifted), max(0.0, float(heel / robot.leg_length - level))


def limits(walker: SupervisedController) -> list[str]:
    """Riser and grade, estimated and walked."""
    rise, angle = estimates(walker)
    return [
        f"{100 * rise:.1f}",
        str(greatest(walker, riser, RISERS)),
        f"{np.degrees(angle):.1f}",
        str(greatest(walker, grade, GRADES)),
    ]


def between_phases(walker: SupervisedController) -> str:
    """Grounds that are not random on which not all come through from phases half-way between those of the tables."""
    missed = []
    for name, made in grounds(BEFORE + 0.5 * STEP / PHASES):
        cell = told(*through(walker, made, "hybrid")) if not name.startswith("treads") else ""
        if "of" in cell or cell == "–":
            missed.append(f"{name}: {cell}")
    return ", ".join(missed) or "none"


class Timed(SupervisedController):
    """The law, whose decisions machine code makes when it is replayed; `times` has the CPU time of each, s."""

    @cached_property
    def times(self) -> list[float]:
        """Of the decisions so far."""
        return []

    @cached_property
    def _code(self) -> MachineCode:
        return MachineCode(self, self.law())

    @cached_property
    def _decide(self) -> Callable[..., None]:
        return ctypes.CFUNCTYPE(None, *[ctypes.c_int64] * 5)(self._code.law.touchdown)

    def on_touchdown(self, memory: Memory, q_before: Sequence[float], q: Sequence[float], dq: Sequence[float]) -> None:
        """Decide on the next step."""
        decide, held = self._decide, np.array(memory)
        told = [np.array(each, dtype=np.float64) for each in (q_before, q, dq)]
        begun = time.thread_time()
        decide(self._code.law.parameters, held.ctypes.data, *(each.ctypes.data for each in told))
        self.times.append(time.thread_time() - begun)
        memory[:] = held.tolist()


def decisions(walker: SupervisedController, made: Callable[[int], Terrain]) -> tuple[list[float], list[float]]:
    """CPU times of the decisions on a ground from all phases, s: for the gait, and for a recovery step."""
    timed = Timed(walker.robot, walker.gait)
    kept: list[float] = []
    searched: list[float] = []
    for phase in range(PHASES):
        walk = mjbiped.walk(walker, made(phase), engine="hybrid", steps=STEPS)
        ends = [*walk.touchdowns["time"], math.inf]
        for end, (_, memory) in zip(ends, replayed(walk, timed), strict=True):
            if timed.times:
                (searched if memory[RECOVERING] else kept).append(timed.times.pop())
            last = np.searchsorted(walk.samples["time"], end) - 1
            memory[: len(timed.states)] = walk.samples["controller_states"][last].tolist()
    return kept, searched


def told_decisions(walker: SupervisedController) -> str:
    """How long a decision takes, in a sentence: medians on stairs that need recovery steps on a short sole."""
    kept, searched = (1e3 * np.median(times) for times in decisions(walker, dict(grounds())["stairs +3 cm"]))
    return f"A decision takes {kept:.1f} ms on one core, with the search {searched:.0f} ms."


@click.command()
@TABLES
def main(tables: Path | None) -> None:
    """Walk, print, and write what was asked for."""
    laws = {f"±{100 * sole:g} cm": law(sole) for sole in LENGTHS}
    rows = [[sole, *limits(each)] for sole, each in laws.items()]
    heads = ["sole", "riser by energy, cm", "walked, cm", "grade by the ankle, deg", "walked, deg"]
    show_table("hybrid: limits", heads, rows, tables, "limits hybrid")
    rows = [[sole, between_phases(each)] for sole, each in list(laws.items())[-2:]]
    show_table("hybrid: other phases", ["sole", "not walked whole"], rows, tables, "phases hybrid")
    click.echo(told_decisions(laws["±8 cm"]))
    robot, made = mjbiped.KneedBiped(sole=(0.12, 0.12)), dict(grounds())
    gait = mjbiped.find_reference(robot, clearance=0.08)
    kneed = {
        "KneedController": KneedController(robot, gait),
        "its adaptive law off": KneedController(robot, gait, adaptation_gain=OFF),
        "BoundedKneedController": BoundedKneedController(robot, gait),
    }
    rows = [
        [engine, name, *(told(*through(each, made[ground], engine)) for ground in WITH_KNEES)]
        for engine in ("hybrid", "mujoco")
        for name, each in kneed.items()
    ]
    show_table("knees, ±12 cm", ["engine", "law", *WITH_KNEES], rows, tables, "knees on soles")


if __name__ == "__main__":
    main()
