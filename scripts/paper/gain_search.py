"""Search for the gains of the comparison controllers, the same for each: the procedure of docs/comparison.md."""

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

import mjbiped
from controllers import (
    Controller,
    EnergyConstraintController,
    KineticEnergyController,
    LimitCycleController,
    PassivityController,
)
from mjbiped.controllers.comparison.known_slope import KnownSlopeController
from mjbiped.plotting.style import BLUE, GREEN, ORANGE, VERMILLION
from mjbiped.robots.compass import Array

ROBOT = mjbiped.Compass()
LEVEL = mjbiped.Terrain.level()
GAIT = mjbiped.find_passive_gait(ROBOT, math.radians(2))
GAINS = [0.3, 0.5, 1.0, 2.0, 3.0, 4.0, 5.0, 6.0, 8.0, 10.0, 15.0, 20.0, 30.0, 50.0, 100.0, 200.0]
RATIOS = [-3.5, -3.0, -2.75, -2.5, -2.4, -2.3, -2.25, -2.2, -2.1, -2.0, -1.75, -1.5, -1.0, -0.5, -0.1]
RATIOS += [0.1, 0.5, 1.0, 2.0, 4.0, 10.0, 45.0, 100.0]
MAUVE = "#CC79A7"  # the last of Okabe and Ito's colours
POLES = [1.0, 2.0, 3.0, 4.0, 5.0, 6.0, 8.0, 10.0, 15.0, 20.0, 30.0, 50.0]

SMALL_STEP = 0.006  # m, up and down
CHEAPNESS = 5e-4  # how far c_mt may be from sin(phi_r)
LEAST_DIFFERENCE = 1.0  # steps: returns that differ by less are alike
WALK = 60  # steps
LIKE_THE_LAST = 1e-3  # rad and rad/s: far above an unstable gait's growth from rounding, far below a gait of period two


@dataclass(frozen=True)
class Method:
    """A controller and the gains to try.

    Attributes:
        words: What it is called in the figure.
        controller: With its default gains.
        grid: Sets of gains, each a dictionary of fields.
        axis: Label of the gain that the figure has along the axis.
        color: Of its lines.
        style: Of its lines.
    """

    words: str
    controller: KnownSlopeController
    grid: Sequence[Mapping[str, Any]]
    axis: str
    color: str
    style: str | tuple[int, tuple[int, ...]]


METHODS = {
    "PBC": Method(
        "passivity-based", PassivityController(ROBOT, GAIT), [{"gain": gain} for gain in GAINS], "k", BLUE, "-"
    ),
    "ECC": Method(
        "energy constraint",
        EnergyConstraintController(ROBOT, GAIT),
        [{"ratio": ratio, "gain": gain} for ratio in RATIOS for gain in GAINS],
        "ζ",
        ORANGE,
        "--",
    ),
    "KETC": Method(
        "kinetic energy tracking",
        KineticEnergyController(ROBOT, GAIT),
        [{"gain": gain} for gain in GAINS],
        "λ",
        VERMILLION,
        "-.",
    ),
    "KETC, w = 1": Method(
        "kinetic energy tracking, both joints",
        KineticEnergyController(ROBOT, GAIT, gain=6.0, hip_weight=1.0, slope_source="local"),
        [{"gain": gain} for gain in GAINS],
        "λ",
        MAUVE,
        (0, (3, 1, 1, 1, 1, 1)),
    ),
    "limit cycle": Method(
        "limit cycle",
        LimitCycleController(ROBOT, GAIT),
        [{"rate_gain": 2.0 * pole, "position_gain": pole * pole} for pole in POLES],
        "K₁/2 = √K₂",
        GREEN,
        ":",
    ),
}


BLIND: Mapping[str, tuple[KnownSlopeController, Sequence[Mapping[str, Any]]]] = {
    "PBC": (PassivityController(ROBOT, GAIT, slope_source="two_point"), METHODS["PBC"].grid),
    "ECC": (EnergyConstraintController(ROBOT, GAIT, slope_source="two_point"), METHODS["ECC"].grid),
    "KETC": (
        KineticEnergyController(ROBOT, GAIT, slope_source="two_point"),
        [{"gain": gain, "hip_weight": weight} for gain in GAINS for weight in (0.0, 1.0)],
    ),
}
"""The energy-based methods with the one slope source that the paper names for such a method, and their grids."""


@dataclass(frozen=True)
class Trial:
    """What the search sees of a set of gains.

    Attributes:
        gains: The fields tried.
        survived: Whether it walked on the level and over each small step.
        cost: c_mt of its steady walk on the level.
        multiplier: Largest magnitude of the return map's multipliers there; NaN where no step is like the one before.
        peak: Greatest torque over the small steps, N m.
    """

    gains: Mapping[str, Any]
    survived: bool
    cost: float
    multiplier: float
    peak: float

    @property
    def settles(self) -> bool:
        """Whether it walks, cheaply, at every step the same."""
        return self.survived and self.multiplier < 1.0 and abs(self.cost - math.sin(GAIT.slope)) <= CHEAPNESS

    @property
    def steps_back(self) -> float:
        """Steps after which a tenth of a small disturbance is left."""
        return math.log(0.1) / math.log(self.multiplier) if 0.0 < self.multiplier < 1.0 else math.inf


def trial(controller: KnownSlopeController, gains: Mapping[str, Any]) -> Trial:
    """Walk on the level, then over one small step up or down, met at an odd and at an even step."""
    level = walk(controller, LEVEL, 3 * WALK)
    if level.outcome != "finished":
        return Trial(gains, False, math.nan, math.nan, math.nan)
    states = np.hstack([level.touchdowns["q"], level.touchdowns["dq"]])
    repeats = np.abs(states[-1] - states[-2]).max() < LIKE_THE_LAST
    work, x = level.touchdowns["work_absolute"], level.touchdowns["x"]
    over = [
        walk(controller, mjbiped.Terrain.from_segments([(steps * GAIT.step_length, 0, 0), (99, 0, rise)]), WALK)
        for rise in (-SMALL_STEP, SMALL_STEP)
        for steps in (6.5, 7.5)
    ]
    return Trial(
        gains,
        all(each.outcome == "finished" for each in over),
        float((work[-1] - work[-21]) / (ROBOT.weight * (x[-1] - x[-21]))),
        float(multipliers(controller, states[-1]).max()) if repeats else math.nan,
        float(max(each.peak_torque.max() for each in over)),
    )


def multipliers(controller: Controller, state: Array, change: float = 1e-6) -> Array:
    """Magnitudes of the eigenvalues of the map from one step's first state to the next one's on the level.

    By central differences. The integration's 1e-10 over the change leaves an error of 1e-4.
    """

    def after(start: Array) -> Array:
        done = mjbiped.walk(controller, LEVEL, engine="hybrid", steps=1, sample_period=0.05, initial=tuple(start))
        return np.append(done.touchdowns["q"][0, 0], done.touchdowns["dq"][0])

    directions = change * np.array([[1.0, -1.0, 0.0, 0.0], [0.0, 0.0, 1.0, 0.0], [0.0, 0.0, 0.0, 1.0]])
    columns = [(after(state + each) - after(state - each)) / (2.0 * change) for each in directions]
    return np.asarray(np.abs(np.linalg.eigvals(np.array(columns).T)), dtype=np.float64)


def choose(trials: Sequence[Trial]) -> Trial:
    """Of the gains that settle those of the fastest return, and of these the gentlest."""
    settled = [each for each in trials if each.settles]
    fastest = min(each.steps_back for each in settled)
    return min((each for each in settled if each.steps_back <= fastest + LEAST_DIFFERENCE), key=lambda each: each.peak)


def blind_trials(name: str) -> list[Trial]:
    """A method's grid with the source of slope that all have."""
    controller, grid = BLIND[name]
    return [trial(replace(controller, **gains), gains) for gains in grid]


def walk(
    controller: Controller, terrain: mjbiped.Terrain, steps: int = WALK, engine: mjbiped.Engine | str = "hybrid"
) -> mjbiped.Walk:
    """A walk from the imitated gait, in the hybrid engine unless another is given."""
    return mjbiped.walk(controller, terrain, engine=engine, steps=steps, sample_period=0.05)
