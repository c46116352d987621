"""Accuracy against speed of all ways to step a walk in MuJoCo: steps of one length, and steps that land.

Each setting walks the same grounds with the adaptive controller, and passively down 2 degrees. Impacts are compared
with the impact map, all else with the hybrid engine, whose own error is below 1e-9. Then the settings are timed in
turn. Some five minutes. The result stands in `docs/step_size.md`.

    python -m scripts.studies.step_size_study --tables docs/tables/step_size --plot docs/images/step_size.png
"""

import math
import time
from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from typing import Any
from unittest import mock

import click
import mujoco
import numpy as np
from matplotlib.axes import Axes
from matplotlib.lines import Line2D
from matplotlib.text import Text
from matplotlib.transforms import Bbox
from numpy.typing import NDArray
from tqdm.auto import tqdm

import mjbiped
from controllers import Controller, PassiveController
from mjbiped.engines.mujoco import collisions, engine
from mjbiped.engines.mujoco.options import DEFAULT_CONTACT_TIMESTEP, DEFAULT_TIMESTEP
from mjbiped.engines.mujoco.simulation import Simulation
from mjbiped.plotting import style as plot_style
from mjbiped.plotting.panels import legend_below
from mjbiped.records import measures
from scripts.benchmarks.timing import Case, Timing, interleaved, machine
from scripts.pages import TABLES, show_rows, show_table
from scripts.studies.gallery import ADAPTIVE, GAIT, ROBOT, TERRAINS

STATE = mujoco.mjtState.mjSTATE_INTEGRATION
STATES, LENGTH = 100, 40  # from which bare steps are made, and how many from each
WANTED_SPEED, WANTED_ERROR = 300.0, 0.005
NO_SAMPLES = 1e4  # s: only the last one
PASSIVE = "passive, 2° down"


@dataclass(frozen=True)
class Setting:
    """One way to step: step lengths (s), and which of MuJoCo's options are others."""

    family: str
    timestep: float = DEFAULT_TIMESTEP
    contact_timestep: float = DEFAULT_CONTACT_TIMESTEP
    lands: bool = True
    changed: str = ""

    @property
    def name(self) -> str:
        """For tables."""
        contact = f", contact {1e6 * self.contact_timestep:g} µs" if self.lands else ""
        return f"{1e3 * self.timestep:g} ms{contact}{', ' if self.changed else ''}{self.changed}"

    def change(self, model: mujoco.MjModel) -> None:
        """Set MuJoCo's options."""
        if "implicitfast" in self.changed:
            model.opt.integrator = mujoco.mjtIntegrator.mjINT_IMPLICITFAST
        if "pyramidal" in self.changed:
            model.opt.cone = mujoco.mjtCone.mjCONE_PYRAMIDAL

    @property
    def engine(self) -> mjbiped.Mujoco:
        """Its step lengths."""
        return mjbiped.Mujoco(timestep=self.timestep, contact_timestep=self.contact_timestep, lands=self.lands)

    @contextmanager
    def in_use(self) -> Iterator[None]:
        """Let `mjbiped.walk` step so: it gives no way to change what should not be changed."""
        with mock.patch.object(engine, "Simulation", partial(Stepped, self)):
            yield

    def walk(self, controller: Controller, terrain: mjbiped.Terrain, steps: int) -> mjbiped.Walk:
        """A walk without samples."""
        with self.in_use():
            return mjbiped.walk(controller, terrain, steps=steps, sample_period=NO_SAMPLES, engine=self.engine)


class Stepped(Simulation):
    """A simulation that steps as a setting says, on every window of the ground."""

    def __init__(self, setting: Setting, *arguments: Any, **settings: Any) -> None:
        """Build it, and change what the setting changes."""
        super().__init__(*arguments, **settings)
        self.setting = setting
        setting.change(self.model)

    def move_on(self) -> bool:
        """Build the next window, see `Simulation.move_on`, and change it as well."""
        moved = super().move_on()
        if moved:
            self.setting.change(self.model)
        return moved


ONE_LENGTH, LANDING = "one length", "landing"
CONTACT, OPTIONS = "landing at 1 ms, contact step varied", "landing at 2 ms, otherwise"
SETTINGS = (
    *(Setting(ONE_LENGTH, h, lands=False) for h in (1e-3, 5e-4, 2e-4, 1e-4, 5e-5)),
    *(Setting(LANDING, h) for h in (4e-3, 2e-3, 1e-3, 5e-4, 2e-4, 1e-4)),
    *(Setting(CONTACT, contact_timestep=h) for h in (1e-4, 2e-5)),
    Setting(OPTIONS, 2e-3, 1e-4),
    Setting(OPTIONS, 2e-3, changed="implicitfast"),
    Setting(OPTIONS, 2e-3, changed="pyramidal"),
    Setting(OPTIONS, 2e-3, 1e-4, changed="pyramidal"),
)
ON_ALL_GROUNDS = tuple(s for s in SETTINGS if s.family == LANDING and s.timestep in (4e-3, 2e-3, 1e-3)) + SETTINGS[-1:]
STYLES: Mapping[str, Mapping[str, Any]] = {
    ONE_LENGTH: {"color": plot_style.VERMILLION, "linestyle": (0, (4, 1.2)), "marker": "o"},
    LANDING: {"color": plot_style.BLUE, "linestyle": "-", "marker": "s"},
    CONTACT: {"color": plot_style.GREEN, "linestyle": (0, (1.5, 1.2)), "marker": "^"},
    OPTIONS: {"color": plot_style.BLACK, "linestyle": "none", "marker": "x"},
}

SIDES = (
    ((7, 0), "left", "center"), ((0, -7), "center", "top"), ((0, 7), "center", "bottom"), ((-7, 0), "right", "center"),
    ((6, -6), "left", "top"), ((6, 6), "left", "bottom"), ((-6, -6), "right", "top"), ((0, -17), "center", "top"),
    ((8, 9), "left", "bottom"), ((8, -9), "left", "top"), ((-8, -9), "right", "top"), ((-8, 9), "right", "bottom"),
    ((0, 17), "center", "bottom"), ((18, 0), "left", "center"),
)  # fmt: skip
"""Where a name may stand beside its mark, points, the first that is free."""


@dataclass(frozen=True)
class Errors:
    """Of one walk: worst impact and c_mt (shares), peak torque (N m), time per step (s), and how it ended."""

    impact: float
    cost: float
    torque: float
    drift: float
    ended: str

    @classmethod
    def of(cls, walk: mjbiped.Walk, exact: mjbiped.Walk) -> "Errors":
        """Of a walk against the hybrid engine's; NaN where it did not come to its end."""
        impact = float(np.abs(measures.impact_errors(walk)).max()) if walk.steps else math.nan
        if walk.outcome != exact.outcome or walk.steps != exact.steps:
            return cls(impact, math.nan, math.nan, math.nan, f"{walk.outcome} after {walk.steps}")
        cost = walk.cost_of_transport / exact.cost_of_transport - 1.0 if exact.cost_of_transport else math.nan
        torque = float(np.abs(walk.peak_torque - exact.peak_torque).max())
        late = abs(walk.touchdowns["time"][-1] - exact.touchdowns["time"][-1])
        return cls(impact, abs(cost), torque, late / walk.steps, walk.outcome)


def grounds(count: int) -> dict[str, tuple[Controller, mjbiped.Terrain]]:
    """Controller and ground of each walk."""
    found: dict[str, tuple[Controller, mjbiped.Terrain]] = {name: (ADAPTIVE, t) for name, t in TERRAINS.items()}
    for seed in range(count):
        found[f"random {seed}"] = ADAPTIVE, mjbiped.Terrain.random(seed=seed, roughness=0.002 * (seed % 3))
    found[PASSIVE] = PassiveController(), mjbiped.Terrain.incline(2.0)
    return found


def accuracy(walks: Mapping[str, tuple[Controller, mjbiped.Terrain]], steps: int) -> dict[Setting, dict[str, Errors]]:
    """Errors of all settings on all grounds."""
    exact = {name: mjbiped.walk(*walk, steps=steps, engine="hybrid") for name, walk in walks.items()}
    work = sum(1.0 / setting.timestep for setting in SETTINGS)
    found: dict[Setting, dict[str, Errors]] = {}
    with tqdm(total=round(work), desc="accuracy", disable=None, bar_format="{l_bar}{bar}| {elapsed}") as bar:
        for setting in SETTINGS:
            found[setting] = {name: Errors.of(setting.walk(*walks[name], steps), exact[name]) for name in walks}
            bar.update(round(1.0 / setting.timestep))
    return found


def built(setting: Setting, terrain: mjbiped.Terrain, steps: int) -> Simulation:
    """The simulation of such a walk of the adaptive controller."""
    plan = setting.engine.simulation(ADAPTIVE, terrain, steps=steps, initial=GAIT.start.tolist(), robot=ROBOT).plan
    return Stepped(setting, plan, setting.engine)


def cases(setting: Setting, terrain: mjbiped.Terrain, steps: int) -> tuple[dict[str, tuple[Case, int]], float, int]:
    """A whole walk and bare `mj_step`s to be timed, simulated time (s), and how many physics steps it takes."""
    walker, taken = built(setting, terrain, steps), 0
    states: list[NDArray[np.float64]] = []
    first = walker.model
    while not walker.over:
        if taken % 97 == 0 and len(states) < STATES and walker.model is first:  # else of another window
            states.append(np.empty(mujoco.mj_stateSize(walker.model, STATE)))
            mujoco.mj_getState(walker.model, walker.data, states[-1], STATE)
        taken += walker.advance(1)
        walker.move_on()
    bare = built(setting, terrain, steps)
    feet = [bare.model.geom(f"{side}_foot").id for side in ("left", "right")]
    bare.model.geom_solref[feet] = -collisions.STIFFNESS, -1.0 / setting.timestep

    def walk() -> float:
        started = time.thread_time()
        setting.walk(ADAPTIVE, terrain, steps)
        return time.thread_time() - started

    def step() -> float:
        spent = 0.0
        for state in states:
            mujoco.mj_setState(bare.model, bare.data, state, STATE)
            started = time.thread_time()
            mujoco.mj_step(bare.model, bare.data, nstep=LENGTH)
            spent += time.thread_time() - started
        return spent

    return {"walk": (walk, 1), "bare": (step, LENGTH * len(states))}, walker.data.time, taken


@dataclass(frozen=True)
class Speed:
    """Simulated over CPU time of a walk: repetitions; and of bare steps, as many as the walk takes."""

    walk: NDArray[np.float64]
    bare: NDArray[np.float64]
    steps: int
    time: float

    @property
    def cells(self) -> dict[str, str]:
        """Physics steps per second of walking, median, best, bare, and their ratio pair by pair."""
        return {
            "steps per s": f"{self.steps / self.time:.0f}",
            "× real time": f"{np.median(self.walk):.0f}",
            "best": f"{self.walk.max():.0f}",
            "bare `mj_step`": f"{np.median(self.bare):.0f}",
            "bare : walk": f"{np.median(self.bare / self.walk):.2f}",
        }


def speeds(
    which: Sequence[tuple[Setting, str]], steps: int, repeats: int, title: str
) -> dict[tuple[Setting, str], Speed]:
    """Of all settings and grounds given, timed in turn."""
    timed: dict[str, tuple[Case, int]] = {}
    about = {}
    for setting, name in which:
        made, simulated, taken = cases(setting, TERRAINS[name], steps)
        about[setting, name] = simulated, taken
        timed |= {f"{setting.family}/{setting.name}/{name}/{what}": case for what, case in made.items()}
    timings: dict[str, Timing] = interleaved(timed, repeats, title)
    found = {}
    for (setting, name), (simulated, taken) in about.items():
        walk, bare = (timings[f"{setting.family}/{setting.name}/{name}/{what}"] for what in ("walk", "bare"))
        found[setting, name] = Speed(
            simulated / walk.seconds, simulated / (taken * bare.seconds / bare.work), taken, simulated
        )
    return found


def error_cells(found: Mapping[str, Errors]) -> dict[str, str]:
    """Worst impact, worst and median c_mt, worst torque and drift, and which walks did not come to their end."""
    values = np.array([[e.impact, e.cost, e.torque, e.drift] for e in found.values()])
    impact, cost, torque, drift = np.nanmax(values, axis=0)
    lost = [f"{name}: {e.ended}" for name, e in found.items() if e.ended != "finished"]
    return {
        "impact, worst %": f"{100 * impact:.2g}",
        "c_mt, worst %": f"{100 * cost:.2g}",
        "c_mt, median %": f"{100 * np.nanmedian(values[:, 1]):.2g}",
        "peak torque N m": f"{torque:.2g}",
        "time per step ms": f"{1e3 * drift:.2g}",
        **({"lost": "; ".join(lost)} if lost else {}),
    }


def cells_of(errors: Errors) -> dict[str, str]:
    """Worst impact and c_mt (%), and peak torque (N m) of one walk."""
    return {
        "impact, worst %": f"{100 * errors.impact:.2g}",
        "c_mt %": f"{100 * errors.cost:.2g}",
        "peak torque N m": f"{errors.torque:.2g}",
    }


def draw(path: Path, found: Mapping[Setting, Mapping[str, Errors]], speed: Mapping[Setting, Speed]) -> None:
    """Speed on level ground against the worst errors of all grounds."""
    with plot_style.drawn(path) as figure:
        figure.set_figheight(5.0)
        left, right = figure.subplots(1, 2, sharey=True)
        left.axvline(100.0 * WANTED_ERROR, color=plot_style.GUIDE, linewidth=0.9)
        text = f"wanted: {100.0 * WANTED_ERROR:g} %"
        plot_style.note_at(left, text, 100.0 * WANTED_ERROR, 0.02, (3, 0), color=plot_style.SHADE)
        for axes, attribute, label in (
            (left, "impact", "worst error of an impact (%)"),
            (right, "cost", f"worst error of {plot_style.C_MT} (%)"),
        ):
            worst = {s: 100.0 * np.nanmax([getattr(e, attribute) for e in found[s].values()]) for s in SETTINGS}
            draw_panel(axes, worst, speed)
            axes.set(xlabel=label)
        left.set(ylabel="× real time on one core, level ground\n(median; thin lines up to the best repetition)")
        left.set_title("(a) Impacts against the impact map")
        right.set_title("(b) Cost of transport against the hybrid engine")
        legend_below(figure, *left.get_legend_handles_labels())


def draw_panel(axes: Axes, worst: Mapping[Setting, float], speed: Mapping[Setting, Speed]) -> None:
    """One error, a line per family, each setting with its step length (of the contact step, where that is varied)."""
    notes: list[tuple[float, float, str, str]] = []
    for family, style in STYLES.items():
        members = [s for s in SETTINGS if s.family == family]
        if family == CONTACT:
            default = next(s for s in SETTINGS if s.family == LANDING and s.timestep == DEFAULT_TIMESTEP)
            members = sorted([*members, default], key=lambda s: s.contact_timestep)
        x, y = [worst[s] for s in members], [float(np.median(speed[s].walk)) for s in members]
        label = family
        if family == OPTIONS:
            label = "; ".join(
                (f"{family}:", *(f"{letter} {other(s)}" for letter, s in zip("ABCD", members, strict=True)))
            )
        axes.vlines(x, y, [speed[s].walk.max() for s in members], color=style["color"], linewidth=0.7)
        axes.loglog(x, y, label=label.replace(":;", ":"), markersize=5.0, linewidth=1.1, **style)
        for setting, place in zip(members, zip(x, y, strict=True), strict=True):
            if family == CONTACT and setting.family == LANDING:
                continue
            if family == CONTACT:
                notes.append((*place, f"{1e6 * setting.contact_timestep:g} µs", style["color"]))
            elif family == OPTIONS:
                notes.append((*place, "ABCD"[members.index(setting)], style["color"]))
            else:
                notes.append((*place, f"{1e3 * setting.timestep:g} ms", style["color"]))
    axes.axhline(WANTED_SPEED, color=plot_style.GUIDE, linewidth=0.9)
    wanted = {"color": plot_style.SHADE, "ha": "right", "xycoords": ("axes fraction", "data")}
    plot_style.note_at(axes, f"wanted: {WANTED_SPEED:g} ×", 0.87, WANTED_SPEED, (0, 3), **wanted)
    axes.set_ylim(6.0, 1000.0)
    axes.margins(x=0.12)
    write_apart(axes, notes)


def other(setting: Setting) -> str:
    """What a setting has beside its timestep that the default has not."""
    contact = f"contact step {1e6 * setting.contact_timestep:g} µs"
    return " and ".join(
        filter(None, (setting.changed, contact if setting.contact_timestep != DEFAULT_CONTACT_TIMESTEP else ""))
    )


def write_apart(axes: Axes, notes: Sequence[tuple[float, float, str, str]]) -> None:
    """Name places on logarithmic axes: (x, y, name, colour) each, where it covers least of marks, names and lines."""
    figure: Any = axes.figure
    figure.draw_without_rendering()
    places = [axes.transData.transform(note[:2]) for note in notes]
    marks = [Bbox([place - 5.0, place + 5.0]) for place in places]
    taken = [*marks, *(text.get_window_extent() for text in axes.texts)]
    lines = np.concatenate([along(line) for line in axes.lines if line.get_linestyle() != "None"])
    for x, y, name, color in notes:
        tried: list[tuple[int, int, Text, Bbox]] = []
        for offset, ha, va in SIDES:
            plot_style.note_at(axes, name, x, y, offset, xycoords="data", color=color, ha=ha, va=va)
            box = axes.texts[-1].get_window_extent().padded(1.5)
            covered = 100 * sum(box.overlaps(other) for other in taken) + box.count_contains(lines)
            tried.append((covered, len(tried), axes.texts[-1], box))
        best = min(tried, key=lambda each: each[:2])
        for each in tried:
            if each is not best:
                each[2].remove()
        taken.append(best[3])


def along(line: Line2D) -> NDArray[np.float64]:
    """Points of a line, pixel by pixel or so."""
    ends = line.get_transform().transform(line.get_xydata())
    steps = np.linspace(0.0, 1.0, 200)[:, None, None]
    return np.reshape(ends[:-1] * (1.0 - steps) + ends[1:] * steps, (-1, 2))


@click.command(help=__doc__)
@click.option("--steps", default=12, show_default=True, type=click.IntRange(min=2), help="Of the walks for accuracy.")
@click.option("--random", "count", default=4, show_default=True, type=click.IntRange(min=0), help="Random grounds.")
@click.option(
    "--timed-steps", default=40, show_default=True, type=click.IntRange(min=2), help="Of the walks for speed."
)
@click.option("--repeats", default=5, show_default=True, type=click.IntRange(min=1), help="Repetitions of timings.")
@click.option("--plot", type=click.Path(path_type=Path), help="Figure to write.")
@TABLES
def main(steps: int, count: int, timed_steps: int, repeats: int, plot: Path | None, tables: Path | None) -> None:
    """Walk, time, tabulate and draw."""
    found = accuracy(grounds(count), steps)
    level = speeds([(s, "level") for s in SETTINGS], timed_steps, repeats, "speed, level ground")
    speed = {setting: level[setting, "level"] for setting in SETTINGS}
    rows = [{"step": s.name, "family": s.family, **error_cells(found[s]), **speed[s].cells} for s in SETTINGS]
    show_rows("settings", rows, tables, "settings")
    pairs = [(s, name) for s in ON_ALL_GROUNDS for name in TERRAINS]
    everywhere = speeds(pairs, timed_steps, repeats, "speed, all grounds")
    rows = [
        {"step": s.name, "ground": name, **cells_of(found[s][name]), **everywhere[s, name].cells} for s, name in pairs
    ]
    show_rows("grounds", rows, tables, "grounds")
    show_table("machine", ("machine", "value"), machine(), tables, "machine")
    if plot is not None:
        draw(plot, found, speed)


if __name__ == "__main__":
    main()
