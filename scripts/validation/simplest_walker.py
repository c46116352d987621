"""The simplest walker of Garcia et al. by this laboratory's compass biped, whose legs have next to no mass.

Its angle θ is minus the stance leg's q1. The hybrid engine's return map finds both gaits; the long one is also found by
the boundary-value problem of `mjbiped.gaits.passive`, which is more exact.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator
from functools import cache, partial
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
from matplotlib.axes import Axes
from numpy.typing import NDArray

from mjbiped.gaits.cycle import eigenvalues
from mjbiped.gaits.passive import PassiveGait, find_passive_gait
from mjbiped.limit_cycles.bifurcation import bifurcation_diagram
from mjbiped.limit_cycles.periodic import GUARD, PeriodicGait, find_periodic_gait, first_gait, follow, zero_on_branch
from mjbiped.limit_cycles.return_map import ReturnMap
from mjbiped.plotting.panels import titled
from mjbiped.plotting.style import BLACK, BLUE, GREEN, GUIDE, ORANGE, VERMILLION, drawn, make_small, note_at
from mjbiped.robots.compass import Array, Compass
from scripts.validation.published import GARCIA, GARCIA_ROBOT, GARCIA_SLOPE, Computations, Computed
from scripts.validation.rimless_wheel import rolling_rate

ONE_SIDED = 1e-5  # width of the difference quotients that give the published multipliers
SLOPES = np.geomspace(GARCIA_SLOPE, 2e-4, 12)
"""Of the gaits that the series are fitted to, rad."""
DEGREE = 6
"""Of the polynomials in slope^(2/3)."""
LOST = np.linspace(0.0185, 0.0195, 41)
"""Slopes between which the robot no longer walks, rad."""


def with_mass(ratio: float) -> Compass:
    """A compass biped whose legs have a share of the hip's mass, at the same share of their length above the foot."""
    return Compass(ratio, 1.0, lower_length=ratio, upper_length=1.0 - ratio, leg_inertia=0.0, gravity=1.0)


def after_heelstrike(angle: float, rate: float) -> list[float]:
    """State of the robot (q1, q2, dq1, dq2) of θ and θ̇ just after the heel strike; the swing leg's rate follows."""
    return [-angle, angle, -rate, -rate * math.cos(2 * angle)]


@cache
def long_gait() -> PassiveGait:
    """The long gait by the boundary-value problem."""
    return find_passive_gait(GARCIA_ROBOT, GARCIA_SLOPE)


@cache
def gait(name: str) -> PeriodicGait:
    """The "long" or the "short" gait by the return map."""
    angle, rate = (GARCIA[f"{name} {quantity}"].value.real for quantity in ("angle", "rate"))
    return find_periodic_gait(GARCIA_ROBOT, GARCIA_SLOPE, [after_heelstrike(angle, rate)])


def branch(name: str, slopes: Array) -> list[PeriodicGait]:
    """The long or the short gaits on other slopes, rad, in an order that begins near `GARCIA_SLOPE`."""
    return list(follow(gait(name), slopes.tolist()))


def one_sided_multipliers(name: str) -> NDArray[np.complex128]:
    """Multipliers of θ and θ̇ by one-sided difference quotients at the published fixed point, the largest first."""
    point = np.array([GARCIA[f"{name} {quantity}"].value.real for quantity in ("angle", "rate")])
    steps = ReturnMap(GARCIA_ROBOT, GARCIA_SLOPE, GUARD)

    def after(start: Array) -> Array:
        state = steps.walk(after_heelstrike(float(start[0]), float(start[1])), 1).states[0]
        return np.array([-state[0], -state[2]])

    quotients = [(after(point + ONE_SIDED * unit) - after(point)) / ONE_SIDED for unit in np.eye(2)]
    return eigenvalues(np.column_stack(quotients))


def upper(multipliers: NDArray[np.complex128]) -> complex:
    """Of a pair of conjugate multipliers the one above the real axis."""
    return complex(max(multipliers.tolist(), key=lambda value: value.imag))


class Series(NamedTuple):
    """Coefficients of powers of slope^(2/3) on gentle slopes: θ and θ̇ over slope^(1/3), and the period."""

    angle: Array
    rate: Array
    period: Array


@cache
def series(name: str, degree: int = DEGREE) -> Series:
    """The coefficients for the long or the short gaits, fitted to those on `SLOPES`."""
    gaits = [gait(name), *branch(name, SLOPES[1:])]
    roots, states = np.cbrt(SLOPES), np.array([each.states[0] for each in gaits])
    periods = np.array([each.periods[0] for each in gaits])
    columns = (-states[:, 0] / roots, -states[:, 2] / roots, periods)
    fits = (np.polynomial.Polynomial.fit(roots**2, column, degree) for column in columns)
    return Series(*(np.asarray(fit.convert().coef, dtype=np.float64) for fit in fits))


def _coefficient(name: str, of: Callable[[Series], float], as_published: complex | None = None) -> Computed:
    """A coefficient; its error is what one degree less changes."""
    value = of(series(name))
    return Computed(value, 2 * abs(value - of(series(name, DEGREE - 1))) + 1e-9, as_published)


def angle_by_the_wheel(alpha: float, c1: float) -> float:
    """Θ₁ that α and c₁ demand: the stance leg of this walker is a spoke of a rimless wheel, whose rate is known.

    θ̇ = -cot 2θ √(4 sin θ sin γ), in powers of γ^(1/3), is -√(γ/θ) (1 - 17 θ²/12), and with the series for θ and θ̇
    its first order is Θ₀^(3/2) = -1/α, its second this.
    """
    return 2 / (-3 * alpha) * (c1 + 17 / (12 * alpha))


def _doubling() -> Computed:
    ends = [first_gait(GARCIA_ROBOT, slope) for slope in (0.0149, 0.0153)]
    return Computed(zero_on_branch(ends[0], ends[1], lambda each: each.doubling).slope, 1e-9)


def _lost() -> Computed:
    diagram = bifurcation_diagram(GARCIA_ROBOT, LOST, steps=2000, keep=1, scuffing=GUARD)
    return Computed(diagram.lost, float(LOST[1] - LOST[0]))


def convergence(ratios: Array) -> Array:
    """θ, θ̇, period and modulus of the multipliers of the long gait for some mass ratios, shape (ratios, 4)."""
    gaits = [find_passive_gait(with_mass(ratio), GARCIA_SLOPE) for ratio in ratios.tolist()]
    return np.array([[-g.start[0], -g.start[2], g.period, abs(g.multipliers[0])] for g in gaits])


def without_first_order(ratios: Array, values: Array) -> Array:
    """Richardson's extrapolation to the mass ratio zero from each two neighbours, shape (ratios - 1, ...)."""
    coarse, fine = ratios[:-1, None], ratios[1:, None]
    return np.asarray((coarse * values[1:] - fine * values[:-1]) / (coarse - fine))


def wheel_rate(name: str) -> float:
    """How far θ̇ of a gait is from the rate of a rimless wheel that rolls with the same angle on the same slope."""
    state = gait(name).states[0]
    return float(state[2]) - rolling_rate(-float(state[0]), GARCIA_SLOPE, 1.0)


MAP_ERROR = 2e-12
"""Of a state or a period by the return map: what the long gait's differs by from that of the boundary-value problem."""


def _series(name: str) -> Iterator[tuple[str, Callable[[], Computed]]]:
    def alpha(found: Series) -> float:
        return float(found.rate[0] / found.angle[0])

    def c1(found: Series) -> float:
        return float(found.rate[1]) - alpha(found) * float(found.angle[1])

    wheel = None
    if name == "long":
        wheel = angle_by_the_wheel(GARCIA["long alpha"].value.real, GARCIA["long c1"].value.real)
    yield f"{name} tau0", partial(_coefficient, name, lambda found: float(found.period[0]))
    yield f"{name} tau1", partial(_coefficient, name, lambda found: float(found.period[1]))
    yield f"{name} Theta0", partial(_coefficient, name, lambda found: float(found.angle[0]))
    yield f"{name} Theta1", partial(_coefficient, name, lambda found: float(found.angle[1]), wheel)
    yield f"{name} alpha", partial(_coefficient, name, alpha)
    yield f"{name} c1", partial(_coefficient, name, c1)


GARCIAS: Computations = {
    "long angle": lambda: Computed(-long_gait().start[0], 2e-12),
    "long rate": lambda: Computed(-long_gait().start[2], 2e-12),
    "long pair": lambda: Computed(upper(long_gait().multipliers), 1e-7, upper(one_sided_multipliers("long"))),
    "short angle": lambda: Computed(-gait("short").states[0, 0], MAP_ERROR),
    "short rate": lambda: Computed(-gait("short").states[0, 2], MAP_ERROR),
    "short first": lambda: Computed(gait("short").multipliers[0], 2e-6, one_sided_multipliers("short")[0]),
    "short second": lambda: Computed(gait("short").multipliers[1], 5e-7, one_sided_multipliers("short")[1]),
    "doubling": _doubling,
    "lost": _lost,
    **dict(_series("long")),
    **dict(_series("short")),
}

BHOUNSULES: Computations = {
    "long angle": GARCIAS["long angle"],
    "long rate": GARCIAS["long rate"],
    "long period": lambda: Computed(long_gait().period, 2e-12),
    "long modulus": lambda: Computed(abs(long_gait().multipliers[0]), 1e-7),
    "short angle": GARCIAS["short angle"],
    "short rate": GARCIAS["short rate"],
    "short period": lambda: Computed(gait("short").periods[0], 4e-12),
}


STEEPEST = 0.018  # rad
TICKS = (0.0, 0.001, 0.003, 0.006, 0.009, 0.012, 0.015, 0.018)
RATIOS = 10.0 ** -np.arange(2.0, 6.1, 0.5)
LOOKS = {"long": (BLUE, "-"), "short": (ORANGE, (0, (5, 1.5)))}


def _draw_gaits(axes: Axes) -> None:
    for name, (colour, line) in LOOKS.items():
        slopes = np.concatenate([np.geomspace(GARCIA_SLOPE, 2e-5, 40), np.linspace(GARCIA_SLOPE, STEEPEST, 30)])
        half = 40
        gaits = [*branch(name, slopes[:half])[::-1], *branch(name, slopes[half:])]
        found = np.array([each.slope for each in gaits])
        angles = np.array([-each.states[0, 0] for each in gaits])
        axes.plot(found, angles / np.cbrt(found), color=colour, linestyle=line, label=f"{name} gaits, ours")
        first, second = (GARCIA[f"{name} {term}"].value.real for term in ("Theta0", "Theta1"))
        ends = np.linspace(0.0, STEEPEST, 100)
        look: Any = {"color": VERMILLION if name == "long" else GREEN, "linestyle": (0, (1, 1.2)), "linewidth": 1.8}
        axes.plot(ends, first + second * ends ** (2 / 3), label=f"{name} gaits, series as published", **look)
        point = GARCIA[f"{name} angle"].value.real / np.cbrt(GARCIA_SLOPE)
        label = "gaits on 0.009, as published" if name == "long" else None
        axes.plot(GARCIA_SLOPE, point, "o", color=BLACK, markerfacecolor="white", label=label)
    onset = GARCIAS["doubling"]().value.real
    axes.axvline(onset, color=GUIDE, linewidth=0.8)
    note_at(axes, "period doubles", onset, 0.97, (-4, 0), ha="right", va="top")
    axes.set_xscale(
        "function", functions=(lambda x: np.maximum(x, 0.0) ** (2 / 3), lambda x: np.maximum(x, 0.0) ** 1.5)
    )
    axes.set(xlim=(0.0, STEEPEST), ylim=(0.908, None), xticks=TICKS, ylabel=r"$\theta\,/\,\gamma^{1/3}$")
    axes.set_xlabel("slope γ, rad (spaced as its power 2/3)")
    axes.legend(loc="lower left")
    titled(axes, "a", "angle of the simplest walker after the heel strike")


def _draw_convergence(axes: Axes) -> None:
    exact = long_gait()
    limit = np.array([-exact.start[0], -exact.start[2], exact.period, abs(exact.multipliers[0])])
    distance = np.abs(convergence(RATIOS) - limit)
    marks = (
        (BLUE, "o", "θ"),
        (ORANGE, "s", "θ̇"),
        (GREEN, "^", "period"),
        (VERMILLION, "D", "modulus of the multipliers"),
    )
    for column, (colour, mark, label) in zip(distance.T, marks, strict=True):
        axes.loglog(RATIOS, column, color=colour, marker=mark, markersize=4, linewidth=0.8, label=label)
    axes.loglog(RATIOS, 0.7 * RATIOS, color=GUIDE, linestyle=(0, (3, 1.5)), label="first order")
    axes.set(xlabel="mass of a leg over that of the hip", ylabel="distance from the limit")
    axes.legend(loc="lower right")
    titled(axes, "b", "compass with light legs")


def draw(path: Path) -> None:
    """Draw both panels.

    Args:
        path: A PNG file.
    """
    with drawn(path) as figure:
        figure.set_figheight(4.2)
        panels: Any = figure.subplots(1, 2, width_ratios=(3, 2))
        _draw_gaits(panels[0])
        _draw_convergence(panels[1])
    make_small(path)
