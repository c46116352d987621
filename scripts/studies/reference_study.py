"""What optimised references cost on level ground, and what they climb: tables and figure behind `docs/references.md`.

A controller climbs a rise if it goes on walking at 99 of 100 places of the step's edge between two footholds; in
brackets is what it climbs on ground that no foot has as well. Some minutes; the checks in MuJoCo take most of it.

    python -m scripts.studies.reference_study --tables docs/tables/references --plot docs/images/references.png
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import click
import numpy as np
from matplotlib.axes import Axes
from tqdm.auto import tqdm

import mjbiped
from controllers import AdaptiveController, LibraryController
from mjbiped.gaits.reference import DEGREE, bernstein, count_of_pieces, in_pieces, table_of
from mjbiped.plotting import style
from mjbiped.plotting.panels import legend_below, titled
from mjbiped.records.measures import FINISHED, VIOLATING
from mjbiped.utils import palette
from scripts.pages import TABLES, show_table

ROBOT = mjbiped.Compass()
PHASES = 100
CAME = (FINISHED, VIOLATING)
MOST_FALLS = 1  # of them
LEAD, STEPS = 3, 15  # steps before the edge, and in all
RISE = 0.005  # m, between two rises that are tried
CLEARANCES = (0.0, 0.01, 0.02, 0.03, 0.04, 0.05, 0.06, 0.07, 0.08, 0.09, 0.1, 0.105, 0.11, 0.12)
SLOPES_DEG = (1.0, 1.5, 2.0, 2.5, 2.7)
SPEEDS = (0.2, 0.25, 0.3, 0.35, 0.4, 0.45, 0.494, 0.55, 0.6, 0.65, 0.7)
FREE = (0.02, 0.04, 0.05, 0.06, 0.07, 0.077, 0.09, 0.1, 0.11, 0.12, 0.13, 0.14)
"""Clearances without retraction, m."""
CHECKED = (
    (0.04, True, 0.06, "paper"),
    (0.04, True, -0.10, "paper"),
    (0.105, True, 0.12, "paper"),
    (0.105, True, 0.12, "additive"),
    (0.077, False, 0.06, "additive"),
    (0.077, False, 0.075, "additive"),
)
"""(clearance, retraction, rise, re-planning) that MuJoCo walks, too; m."""
OPEN: dict[str, Any] = {"linestyle": ":", "markerfacecolor": "white", "linewidth": 1.0, "markersize": 4.5}
TREADS, SEEDS, LONG = (0.02, 0.03), 30, 400  # standard deviations of treads' heights (m), grounds, and steps of a walk
DROPS = (0.05, 0.10, 0.15, 0.20, 0.30)  # m


@dataclass(frozen=True)
class Climb:
    """How high a rise a controller climbs, m: on ground as there is, and on any; and what the first takes (N m, m)."""

    through: float
    survived: float
    torque: float
    sole: float

    def __str__(self) -> str:
        """Both heights, the second one in brackets where it is greater."""
        beyond = f" ({self.survived:.3f})" if self.survived > self.through else ""
        return f"{self.through:.3f}{beyond}"


@dataclass(frozen=True)
class Walks:
    """Of walks over a step at all places: how many went on, how many without asking too much of the ground.

    `torque` (N m) and `sole` (m) are the greatest of the latter, `any_torque` of the former.
    """

    survived: int
    through: int
    torque: float
    sole: float
    any_torque: float


@dataclass(frozen=True)
class Row:
    """A controller: what it imitates, its level cost, what it climbs with either re-planning, and how it steps down."""

    what: str
    cost: float
    paper: Climb
    additive: Climb
    down: Walks


def edges(controller: AdaptiveController, rise: float, phases: int = PHASES) -> list[mjbiped.Terrain]:
    """One step up or down, with its edge at places between two footholds."""
    step = controller.gait.step_length
    ahead = [(LEAD + (k + 0.5) / phases) * step for k in range(phases)]
    return [mjbiped.Terrain.from_segments([(x, 0.0, 0.0), (100.0, 0.0, rise)]) for x in ahead]


def over_step(controller: AdaptiveController, rise: float, engine: str = "hybrid", most: int = PHASES) -> Walks:
    """Walks over a step with its edge at all places; it stops after so many falls."""
    found = []
    for terrain in edges(controller, rise):
        walk = mjbiped.walk(controller, terrain, engine=engine, steps=STEPS, sample_period=None)
        found.append(walk)
        if sum(each.verdict not in CAME for each in found) > most:
            break
    on = [walk for walk in found if walk.verdict in CAME]
    through = [walk for walk in on if walk.verdict == FINISHED]
    torques = [[float(np.abs(walk.peak_torque).max()) for walk in walks] for walks in (on, through)]
    return Walks(
        len(on),
        len(through),
        max(torques[1], default=math.nan),
        max((walk.summary()["foot_length_99_percent_m"] for walk in through), default=math.nan),
        max(torques[0], default=math.nan),
    )


def highest(controller: AdaptiveController) -> Climb:
    """The highest rise that is climbed, with all lower ones."""
    best, rise, gripping = Climb(0.0, 0.0, math.nan, math.nan), 0.0, True
    while True:
        rise = round(rise + RISE, 6)
        walks = over_step(controller, rise, most=MOST_FALLS)
        if walks.survived < PHASES - MOST_FALLS:
            return best
        gripping = gripping and walks.through >= PHASES - MOST_FALLS
        best = Climb(rise, rise, walks.torque, walks.sole) if gripping else replace(best, survived=rise)


def row(what: str, gait: mjbiped.Gait, cost: float) -> Row:
    """One controller, by the paper's re-planning and by the additive one."""
    paper, additive = (AdaptiveController(ROBOT, gait, replanning=name) for name in ("paper", "additive"))
    return Row(what, cost, highest(paper), highest(additive), over_step(paper, -0.10))


def passive_cost(gait: mjbiped.Gait) -> float:
    """c_mt of the adaptive controller with a passive gait on level ground."""
    level = mjbiped.Terrain.level()
    return mjbiped.walk(AdaptiveController(ROBOT, gait), level, engine="hybrid", steps=40).cost_of_transport


def continued(gait: mjbiped.OptimisedGait) -> mjbiped.OptimisedGait:
    """The gait with its curves going on after the period for a third of it, in the hold's stead."""
    count = count_of_pieces(gait.period, ROBOT.leg_length, ROBOT.gravity)
    pieces = in_pieces(lambda place: bernstein(DEGREE, place / count) @ gait.control_points, range(count + count // 3))
    return replace(gait, tables=(table_of(count / gait.period, pieces),))


def _descends(controller: AdaptiveController, drop: float) -> str:
    walks = over_step(controller, -drop)
    violating = walks.survived - walks.through
    torque = f"{walks.any_torque:.0f}" + (f" ({violating} violate the contact)" if violating else "")
    return torque if walks.survived == PHASES else f"{PHASES - walks.survived} fall"


def _treads(controller: AdaptiveController, deviation: float) -> str:
    """Steps per fall on treads of 1 m whose heights are normally distributed."""
    steps = falls = 0
    for seed in range(100, 100 + SEEDS):
        heights = np.random.default_rng(seed).normal(0.0, deviation, LONG)
        rises = np.diff(heights, prepend=0.0).tolist()
        ground = mjbiped.Terrain.from_segments([(1.5, 0.0, 0.0), *((1.0, 0.0, rise) for rise in rises)])
        walk = mjbiped.walk(controller, ground, engine="hybrid", steps=LONG, sample_period=None)
        steps, falls = steps + walk.steps, falls + (walk.outcome != "finished")
    return f"{steps / falls:.0f} ({falls} falls)" if falls else f"no fall in {steps}"


def _needed(what: Climb | Walks) -> tuple[str, str]:
    """Torque in N m and sole in cm, or dashes."""
    return ("-", "-") if math.isnan(what.torque) else (f"{what.torque:.1f}", f"{100 * what.sole:.0f}")


def _name(gait: mjbiped.OptimisedGait) -> str:
    return f"clearance {gait.goal.clearance:g} m" + ("" if gait.goal.retraction else ", no retraction")


def draw(rows: Sequence[Sequence[Row]], speeds: Sequence[tuple[float, ...]], path: Path) -> None:
    """The Pareto front, and cost against speed."""
    with style.drawn(path) as figure:
        figure.set_figheight(4.6)
        front, speed = figure.subplots(1, 2)
        _front(front, *rows)
        columns = np.array(speeds).T
        speed.plot(columns[0], columns[1], "-", color=style.BLUE, label="optimised, without clearance")
        speed.plot(columns[0], columns[2], "--", color=style.BLUE, label="optimised, clearance 0.06 m")
        downhill = [mjbiped.find_passive_gait(ROBOT, math.radians(slope)) for slope in np.linspace(0.2, 4.5, 30)]
        speed.plot(
            [gait.speed for gait in downhill], [math.sin(gait.slope) for gait in downhill], **style.TRUTH,
            label="passive gaits: sine of their slope",
        )  # fmt: skip
        speed.set(xlabel="speed (m/s)", ylabel=f"{style.C_MT} on level ground", ylim=(0.0, None))
        titled(speed, "b", "Cost against speed")
        handles, labels = [], []
        for axes in (front, speed):
            found = axes.get_legend_handles_labels()
            handles += found[0]
            labels += found[1]
        legend_below(figure, handles, labels)


def _front(axes: Axes, optimised: Sequence[Row], free: Sequence[Row], passive: Sequence[Row]) -> None:
    for rows, look in (
        (optimised, {"color": style.BLUE, "marker": "o", "label": "optimised references"}),
        (free, {"color": palette.SKY, "marker": "v", "label": "the same, without retraction"}),
        (passive, {"color": style.ORANGE, "marker": "s", "label": "the paper's controller, gaits of 1° to 2.7°"}),
    ):
        drawn: dict[str, Any] = {**look, "linewidth": 1.0, "markersize": 4.5}
        cost = [each.cost for each in rows]
        axes.plot(cost, [each.paper.through for each in rows], **drawn)
        axes.plot(cost, [each.paper.survived for each in rows], **{**drawn, "label": None, **OPEN})
    axes.plot([], [], color="black", marker="o", label="open, dotted: on ground that no foot has as well", **OPEN)
    two = next(each for each in passive if each.what.startswith("passive, 2°"))
    axes.annotate("2°, the paper's", (two.cost, two.paper.through), (4, -10), textcoords="offset points")
    axes.set(xlabel=f"{style.C_MT} on level ground", ylabel="highest step up (m)")
    titled(axes, "a", "What is climbed, and what it costs")


def climbers() -> tuple[list[Row], list[Row], list[Row]]:
    """Optimised references with retraction and without, and passive gaits."""
    rows = []
    for retraction, clearances in ((True, CLEARANCES), (False, FREE)):
        gaits = [mjbiped.find_reference(ROBOT, clearance=each, retraction=retraction) for each in clearances]
        bar = tqdm(gaits, desc="references", disable=None)
        rows.append([row(_name(gait), gait, gait.cost_of_transport) for gait in bar])
    passive = []
    for slope in tqdm(SLOPES_DEG, desc="passive gaits", disable=None):
        gait = mjbiped.find_passive_gait(ROBOT, math.radians(slope))
        passive.append(row(f"passive, {slope:g}°", gait, passive_cost(gait)))
    return rows[0], rows[1], passive


def climbing(rows: Sequence[Row]) -> list[list[str]]:
    """What is climbed, and what it takes."""
    return [
        [
            each.what, f"{each.cost:.4f}", str(each.paper), str(each.additive),
            *_needed(each.paper), f"{each.down.through}", *_needed(each.down),
        ]
        for each in rows
    ]  # fmt: skip


def costs_by_speed() -> list[tuple[float, ...]]:
    """Speed, and c_mt without clearance and with 0.06 m."""
    return [
        (speed, *(mjbiped.find_reference(ROBOT, speed=speed, clearance=c).cost_of_transport for c in (0.0, 0.06)))
        for speed in tqdm(SPEEDS, desc="speeds", disable=None)
    ]


def in_both_engines() -> list[list[str]]:
    """Walks over a step in both engines, and c_mt on level ground in MuJoCo."""
    rows = []
    for clearance, retraction, rise, replanning in tqdm(CHECKED, desc="MuJoCo", disable=None):
        checked = mjbiped.find_reference(ROBOT, clearance=clearance, retraction=retraction)
        controller = AdaptiveController(ROBOT, checked, replanning=replanning)
        level = mjbiped.walk(controller, mjbiped.Terrain.level(), steps=40)
        for engine, cost in (("hybrid", ""), ("mujoco", f"{level.cost_of_transport:.4f}")):
            walks = over_step(controller, rise, engine)
            survived = f"{walks.through}" + (f" ({walks.survived})" if walks.survived > walks.through else "")
            rows.append([_name(checked), f"{rise:+.3f}", replanning, engine, survived, f"{walks.torque:.1f}", cost])
    return rows


def downwards() -> list[list[str]]:
    """What comes of drops, by what the reference does after its period."""
    held, two = mjbiped.find_reference(ROBOT, clearance=0.06), mjbiped.find_passive_gait(ROBOT, math.radians(2))
    imitated = {
        "clearance 0.06 m, hold": held,
        "the same, its curves continued": continued(held),
        "passive, 2°, continued": two,
    }
    return [
        [what, *(_descends(AdaptiveController(ROBOT, gait), drop) for drop in DROPS)] for what, gait in imitated.items()
    ]


def on_treads() -> list[list[str]]:
    """Steps per fall on random treads, by what is imitated and how it is re-planned."""
    cheap = [mjbiped.find_reference(ROBOT, clearance=c, retraction=r) for c, r in ((0.044, True), (0.077, False))]
    high = [mjbiped.find_reference(ROBOT, clearance=c) for c in (0.06, 0.105)]
    imitated: dict[str, mjbiped.Gait] = {"passive, 2°": mjbiped.find_passive_gait(ROBOT, math.radians(2))}
    imitated |= {_name(gait): gait for gait in (*cheap, *high)}
    laws: dict[tuple[str, str], AdaptiveController] = {
        (what, name): AdaptiveController(ROBOT, gait, replanning=name)
        for what, gait in imitated.items()
        for name in ("paper", "additive")
    }
    library = LibraryController(ROBOT, cheap[0], climbing_gait=high[-1])
    laws[f"{_name(cheap[0])}; {_name(high[-1])} after steps", "library"] = library
    return [
        [*names, *(_treads(law, deviation) for deviation in TREADS)]
        for names, law in tqdm(laws.items(), desc="treads", disable=None)
    ]


HEADINGS = {
    "treads": ["imitated", "re-planning", *(f"σ = {each:g} m" for each in TREADS)],
    "late": ["imitated", *(f"{drop:g} m" for drop in DROPS)],
    "climbing": [
        "imitated", "c_mt, level", "climbs (m)", "additive (m)", "torque (N m)", "sole (cm)", "of 100 down 0.10 m",
        "torque down (N m)", "sole down (cm)",
    ],
    "speeds": ["speed (m/s)", "no clearance", "0.06 m"],
    "engines": ["imitated", "rise (m)", "re-planning", "engine", "of 100", "torque (N m)", "c_mt, level, MuJoCo"],
}  # fmt: skip


@click.command()
@TABLES
@click.option("--plot", type=click.Path(path_type=Path), help="Write the figure.")
def main(tables: Path | None, plot: Path | None) -> None:
    """Print the tables; write them and the figure."""
    rows, speeds = climbers(), costs_by_speed()
    made = {
        "treads": on_treads(),
        "late": downwards(),
        "climbing": climbing([each for some in rows for each in some]),
        "speeds": [[f"{speed:g}", *(f"{cost:.4f}" for cost in costs)] for speed, *costs in speeds],
        "engines": in_both_engines(),
    }
    for name, cells in made.items():
        show_table(name, HEADINGS[name], cells, tables, name)
    if plot is not None:
        draw(rows, speeds, plot)


if __name__ == "__main__":
    main()
