"""Diagnosis of `mjbiped.compare`: where two records of one walk part, and why."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from itertools import islice, product

import numpy as np

from mjbiped.analysis.replay import replayed
from mjbiped.control.controller import Controller
from mjbiped.engines.mujoco.options import DEFAULT_TIMESTEP
from mjbiped.records import measures
from mjbiped.records.columns import Column, Columns
from mjbiped.records.record import Walk
from mjbiped.robots.compass import Array
from mjbiped.terrain.profile import GROUND_FRICTION

COLUMNS: Columns = {
    "x": Column("m", "foothold"),
    "period": Column("s", "period of the step"),
    "angle": Column("rad", "leg angle after the impact"),
    "rate": Column("rad/s", "leg rate after the impact"),
    "slope": Column("rad", "slope under the new stance foot"),
    "slope_estimate": Column("rad", "slope estimate after its update"),
    "work": Column("J", "absolute work of the step"),
}
"""Differences MuJoCo - hybrid at each touchdown and in the step that ends with it; the greater one of both legs."""

DISPLAYED: Mapping[str, tuple[float, str]] = {
    "m": (1e3, "mm"),
    "s": (1e3, "ms"),
    "rad": (math.degrees(1.0), "deg"),
    "rad/s": (1.0, "rad/s"),
    "J": (1.0, "J"),
}
"""Factor and unit in which differences are printed, by their SI unit."""

# What the resolution of contacts and motion at the default steps explains: over five times the greatest difference seen
# on 138 rough terrains (scripts/studies/agreement_study.py; docs/tables/convergence.md has them), up to the first
# touchdown that has another cause. Period, angle and rate are wider, to hold for ten steps of the comparison
# controllers too (1.5 ms, 4.5e-4 rad, 1.5e-3 rad/s on slopes and small steps): their errors fade slowly.
# In leg lengths l, sqrt(l / g), rad, sqrt(g / l), rad, rad and weights times l; the last also in shares of the work.
_FOOTHOLD, _PERIOD, _ANGLE, _RATE, _SLOPE, _ESTIMATE, _WORK = 1e-3, 5e-3, 2.2e-3, 2.5e-3, 5e-6, 7.5e-4, 1.2e-4
_WORK_SHARE = 0.012

SLID = 1e-4  # leg lengths; ordinary steps slide by 2e-6 to 2e-5
TURNED = 1e-4  # rad; the headings of walks whose feet do not turn differ by 5e-6
EDGE = 5e-4  # m; a foot nearer to a break of the ground may meet its edge
GRAZED = 3e-3  # leg lengths; one engine lands where the other passes with no more clearance
ROUNDING = 1e-12  # rad; error of a slope that is recomputed at every touchdown
GROWN = 0.25  # share of the limit that a growing difference has reached one step before


@dataclass(frozen=True)
class Divergence:
    """The first touchdown at which two walks differ by more than the contact's resolution explains.

    Attributes:
        touchdown: Its number, from 1; where a walk ended, the number after the last common one.
        time: Its time in MuJoCo, s.
        x: Position of the stance foot in the step that ends with it, m.
        differences: The differences in words and numbers.
        causes: The causes in words; empty where none was found.
    """

    touchdown: int
    time: float
    x: float
    differences: tuple[str, ...]
    causes: tuple[str, ...]

    def __str__(self) -> str:
        """Describe the divergence in sentences."""
        where = f"The engines part at touchdown {self.touchdown} ({self.time:.3f} s, step from x = {self.x:.3f} m)"
        why = f"Cause: {'; '.join(self.causes)}." if self.causes else "No cause was found."
        return f"{where}: {', '.join(self.differences)}. {why}"


def differences(there: Walk, here: Walk) -> dict[str, Array]:
    """Compute the differences and limits at each touchdown that both walks have, for `Comparison.touchdowns`."""
    n = min(there.steps, here.steps)
    one, two = there.touchdowns, here.touchdowns

    def greater(name: str) -> Array:
        difference = one[name][:n] - two[name][:n]
        return np.take_along_axis(difference, np.abs(difference).argmax(axis=1)[:, None], axis=1)[:, 0]

    work, work_here = (np.diff(walk.touchdowns["work_absolute"], prepend=0.0)[:n] for walk in (there, here))
    length, weight = there.robot.leg_length, there.robot.weight
    pace = math.sqrt(there.robot.gravity / length)
    # what a held torque does grows with the time for which it is held; plain steps err in first order of their length
    coarse = max(1.0, (there.settings["control_period"] or there.settings["timestep"]) / DEFAULT_TIMESTEP)
    found: dict[str, tuple[Array, float | Array]] = {
        "x": (one["x"][:n] - two["x"][:n], _FOOTHOLD * length),
        "period": (measures.step_periods(there)[:n] - measures.step_periods(here)[:n], _PERIOD / pace),
        "angle": (greater("q"), _ANGLE),
        "rate": (greater("dq"), _RATE * pace),
        "slope": (one["slope"][:n] - two["slope"][:n], _SLOPE),
        "slope_estimate": (one["slope_estimate"][:n] - two["slope_estimate"][:n], _ESTIMATE),
        "work": (work - work_here, _WORK * weight * length + _WORK_SHARE * work_here),
    }
    limits = {f"limit_{name}": coarse * limit * np.ones(n) for name, (_, limit) in found.items()}
    return {name: difference for name, (difference, _) in found.items()} | limits


def find(there: Walk, here: Walk, table: Mapping[str, Array], controller: Controller) -> Divergence | None:
    """Find the divergence of two walks; None if there is none.

    Args:
        there: The walk in MuJoCo.
        here: The walk in the hybrid engine.
        table: Their differences, as `differences` finds them.
        controller: The controller of both walks.
    """
    shares = {name: np.abs(np.nan_to_num(table[name])) / table[f"limit_{name}"] for name in COLUMNS}
    beyond = np.any([share > 1.0 for share in shares.values()], axis=0)
    strikes = [walk.touchdowns["strikes"][: len(beyond)] > 0 for walk in (there, here)]
    beyond |= strikes[0] != strikes[1]
    if beyond.any():
        k = int(np.argmax(beyond))
        said = [_said(name, table[name][k]) for name in COLUMNS if shares[name][k] > 1.0]
    elif (there.steps, there.outcome) != (here.steps, here.outcome):
        k = len(beyond)
        said = [f"{walk.outcome} after {walk.steps} steps in {_engine(walk)}" for walk in (there, here)]
    else:
        return None
    if beyond.any() and strikes[0][k] != strikes[1][k]:
        said.append(f"a face impact in {_engine(there if strikes[0][k] else here)} alone")
    causes = list(explanations(there, here, k, controller))
    if not causes and 0 < k < len(beyond):
        name, grown = max(((name, share[k - 1]) for name, share in shares.items()), key=lambda pair: pair[1])
        if grown > GROWN:
            causes.append(
                f"small differences grew from step to step ({COLUMNS[name].meaning}: {100 * grown:.0f} % of the limit "
                "one touchdown before)"
            )
    longer = there if there.steps >= here.steps else here
    time = float(longer.touchdowns["time"][k]) if k < longer.steps else longer.end[0]
    x = float(longer.touchdowns["x"][k - 1]) if k else 0.0
    return Divergence(k + 1, time, x, tuple(said), tuple(causes))


def _said(name: str, difference: float) -> str:
    """Write a difference in words."""
    factor, unit = DISPLAYED[COLUMNS[name].unit]
    return f"{name.replace('_', ' ')} {factor * difference:+.3g} {unit}"


def _engine(walk: Walk) -> str:
    return {"mujoco": "MuJoCo", "hybrid": "the hybrid engine"}[walk.settings["engine"]]


def explanations(there: Walk, here: Walk, k: int, controller: Controller) -> Iterator[str]:
    """Causes in the step that ends with touchdown k (from 0) or in the one before, the likeliest first."""
    steps = [row for row in (k - 1, k) if row >= 0]

    def greatest(walk: Walk, name: str) -> float:
        return max((float(walk.touchdowns[name][row]) for row in steps if row < walk.steps), default=0.0)

    struck = [_engine(walk) for walk in (there, here) if greatest(walk, "strikes") > 0]
    if struck:
        yield f"the swing foot struck a riser (in {' and '.join(struck)})"
    asked, slid = greatest(here, "friction"), greatest(there, "slip")
    if asked >= GROUND_FRICTION:
        yield (
            f"friction: the motion asks for |Ft/Fn| = {asked:.2f} of ground with {GROUND_FRICTION:g}, "
            "which MuJoCo does not give and the hybrid engine does"
        )
    if slid > SLID * there.robot.leg_length:
        yield f"slip: the stance foot slid by {1e3 * slid:.2f} mm in MuJoCo"
    yield from _twist(there, here, steps)
    yield from _edges(there, here, steps)
    yield from _grazing(there, here, k)
    yield from _decisions(there, here, steps, controller)
    ended = [walk for walk in (there, here) if walk.steps == k and walk.outcome not in ("finished", "interrupted")]
    if len(ended) == 1:
        yield f"{_engine(ended[0])} {ended[0].outcome} in this step"
    fewer, more = sorted((there.steps, here.steps))
    if {there.outcome, here.outcome} == {"finished"} and k == fewer < more:
        yield "the distance asked for ends between their footholds"


def _twist(there: Walk, here: Walk, steps: list[int]) -> Iterator[str]:
    """A stance foot that turned in MuJoCo: the hybrid engine's feet never do."""
    if "yaw" not in there.robot.places:
        return
    yaw, n = there.robot.places.index("yaw"), min(there.steps, here.steps)
    apart = there.touchdowns["qpos"][:n, yaw] - here.touchdowns["qpos"][:n, yaw]
    turned = np.abs(np.diff(apart, prepend=0.0))[[row for row in steps if row < n]].max(initial=0.0)
    if turned > TURNED:
        yield f"twist: the stance foot turned by {math.degrees(turned):.2g} deg in MuJoCo, for all its friction"


def _edges(there: Walk, here: Walk, steps: list[int]) -> Iterator[str]:
    """Footholds so close to a break of the ground that the foot may meet its edge."""
    for walk, row in product((there, here), steps):
        for at in there.terrain.x[1:] if row < walk.steps else ():
            off = abs(at - float(walk.touchdowns["x"][row]))
            if off < EDGE:
                touchdown = f"touchdown {row + 1} in {_engine(walk)}"
                yield f"an edge: {touchdown} is {1e3 * off:.3f} mm from the break of the ground at x = {at:.3f} m"
                return


def _grazing(there: Walk, here: Walk, k: int) -> Iterator[str]:
    """A foothold in one engine that the swing foot passes close to the ground in the other."""
    if k >= min(there.steps, here.steps):
        return
    first, second = sorted((there, here), key=lambda walk: float(measures.step_periods(walk)[k]))
    place, length = float(first.touchdowns["x"][k]), there.robot.leg_length
    begin = float(second.touchdowns["time"][k - 1]) if k else 0.0
    time = second.samples["time"]
    inside = (time > begin) & (time < second.touchdowns["time"][k])
    qpos, stance = second.samples["qpos"][inside], second.samples["stance"][inside]
    limbs = second.robot.limbs(qpos)
    x, z = limbs[np.arange(len(qpos)), (stance + 1) % limbs.shape[1], -1].T
    clearance = np.abs(z - second.terrain.height(x))
    near = np.abs(x - place) < 0.02 * length
    elsewhere = abs(float(second.touchdowns["x"][k]) - place) > 0.02 * length
    if elsewhere and near.any() and clearance[near].min() < GRAZED * length:
        yield (
            f"grazing: {_engine(first)} lands at x = {place:.3f} m, which the swing foot in {_engine(second)} passes "
            f"with {1e3 * clearance[near].min():.1f} mm between"
        )


def _decisions(there: Walk, here: Walk, steps: list[int], controller: Controller) -> Iterator[str]:
    """Touchdowns at which the controller decided differently, because its states lie on both sides of a threshold.

    Its decisions are repeated with the recorded states: the law's next discontinuity (re-planned steps have one that
    others lack), and whether it corrected its slope estimate.
    """
    breaks = [_next_breaks(walk, controller, steps[-1]) for walk in (there, here)]
    corrected = [
        np.abs(walk.touchdowns["slope_estimate"] - walk.touchdowns["slope_estimate_before"]) > ROUNDING
        for walk in (there, here)
    ]
    for row in steps:
        if row >= min(there.steps, here.steps):
            return
        if not math.isclose(breaks[0][row], breaks[1][row], rel_tol=1e-9):
            yield f"a threshold: at touchdown {row + 1} the controller plans the new step in one engine alone"
        if bool(corrected[0][row]) != bool(corrected[1][row]):
            yield f"a threshold: at touchdown {row + 1} the controller corrects its slope estimate in one engine alone"


def _next_breaks(walk: Walk, controller: Controller, last: int) -> list[float]:
    """Time of the law's next discontinuity just after each touchdown up to `last`, s."""
    own, found = len(controller.states), []
    for number, (_, memory) in enumerate(islice(replayed(walk, controller), last + 2)):
        if number:
            found.append(float(controller.next_discontinuity(memory, 0.0)))
        if number < walk.steps:
            end = np.searchsorted(walk.samples["time"], walk.touchdowns["time"][number])
            memory[:own] = walk.samples["controller_states"][max(int(end) - 1, 0)].tolist()
    return found
