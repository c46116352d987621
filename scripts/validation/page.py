"""Computes what others have published about passive walkers; writes docs/tables/validation/ and the figure.

A minute on one core.

    python -m scripts.validation.page --tables docs/tables/validation --image docs/images/validation.png
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from pathlib import Path

import click
import numpy as np

import mjbiped
from scripts.pages import TABLES, show_table
from scripts.validation import (
    compass_gait,
    drake_invariants,
    rimless_wheel,
    rolling_disc,
    round_feet,
    round_knees,
    simplest_walker,
)
from scripts.validation.compass_gait import GOSWAMIS
from scripts.validation.kneed_walker import HSU_CHENS
from scripts.validation.published import (
    BHOUNSULE,
    DRAKE,
    GARCIA,
    GOSWAMI,
    HSU_CHEN,
    MCGEER,
    MCGEER_KNEED,
    ROUND_FEET,
    Computations,
    Computed,
    Published,
)
from scripts.validation.round_feet import MCGEERS, ROUND_FEETS
from scripts.validation.round_knees import MCGEERS_KNEED
from scripts.validation.simplest_walker import BHOUNSULES, GARCIAS

MORE = 3
"""Digits of ours beyond the published ones, where they are known."""

RECOMPUTED = 9
"""Digits at most of a number that comes of the published calculation."""

HEADINGS = ("quantity", "published", "ours", "ours − published", "stands in", "what is wrong with it")

SOURCES: Mapping[str, tuple[str, Mapping[str, Published], Computations]] = {
    "garcia": ("Garcia et al. 1998", GARCIA, GARCIAS),
    "bhounsule": ("Bhounsule 2014", BHOUNSULE, BHOUNSULES),
    "goswami": ("Goswami et al. 1996", GOSWAMI, GOSWAMIS),
    "hsu chen": ("Hsu Chen 2007", HSU_CHEN, HSU_CHENS),
    "mcgeer": ("McGeer 1990", MCGEER, MCGEERS),
    "mcgeer kneed": ("McGeer 1990, with knees", MCGEER_KNEED, MCGEERS_KNEED),
    "round feet": ("Bhounsule 2009", ROUND_FEET, ROUND_FEETS),
}
"""By the names of their tables."""


def minus(text: str) -> str:
    """A number's text with the sign that pages have."""
    return text.replace("-", "−")


def shown(value: complex, decimals: int) -> str:
    """A number, or a pair of conjugate ones, with so many digits after the point."""
    if abs(value.imag) < 0.5 * 10.0**-decimals:
        return minus(f"{value.real:.{decimals}f}")
    return minus(f"{value.real:.{decimals}f} ± {abs(value.imag):.{decimals}f}i")


def difference(ours: complex, published: complex) -> str:
    """How far ours is from it, with its sign where that has one."""
    apart = complex(ours) - published
    return minus(f"{abs(apart):.1e}" if published.imag else f"{apart.real:+.1e}")


def cells(published: Published, computed: Computed) -> list[str]:
    """The row of a published number."""
    decimals = min(math.ceil(-math.log10(computed.error)), published.decimals + MORE)
    wrong = published.fault
    if computed.as_published is not None:
        wrong += f"; recomputed: {shown(complex(computed.as_published), min(published.decimals, RECOMPUTED))}"
    return [
        published.quantity,
        minus(published.printed.replace("+", "±")),
        shown(complex(computed.value), decimals),
        difference(computed.value, published.value),
        published.place,
        wrong,
    ]


def _write_sources(tables: Path | None) -> None:
    for place, (title, numbers, ours) in SOURCES.items():
        rows = [cells(number, ours[name]()) for name, number in numbers.items()]
        show_table(title, HEADINGS, rows, tables, place)


def _write_convergence(tables: Path | None) -> None:
    ratios = np.array([1e-2, 1e-3, 1e-4, 1e-5])
    exact = simplest_walker.long_gait()
    limit = np.array([-exact.start[0], -exact.start[2], exact.period, abs(exact.multipliers[0])])
    values = simplest_walker.convergence(ratios)
    better = simplest_walker.without_first_order(ratios, values)
    rows = [
        [f"{ratio:.0e}", *(minus(f"{apart:+.1e}") for apart in row - limit)]
        for ratio, row in zip(ratios.tolist(), values, strict=True)
    ]
    rows += [
        [f"extrapolated from {coarse:.0e} and {fine:.0e}", *(minus(f"{apart:+.1e}") for apart in row - limit)]
        for coarse, fine, row in zip(ratios[:-1].tolist(), ratios[1:].tolist(), better, strict=True)
    ]
    headings = ("leg's mass over hip's", "θ", "θ̇", "period", "modulus of the multipliers")
    show_table("distance from the limit", headings, rows, tables, "convergence")


def _write_mujoco(tables: Path | None) -> None:
    names = ("period", "angle", "stance rate", "swing rate")
    beside = dict(zip(names, compass_gait.in_mujoco().tolist(), strict=True))
    _write_beside(tables, ("the gait on 3 degrees in MuJoCo", "mujoco"), "goswami", beside, compass_gait.MUJOCO_STEPS)
    names = ("period", "angle", "rate", "hip rate")
    beside = dict(zip(names, round_feet.in_mujoco().tolist(), strict=True))
    _write_beside(tables, ("round feet in MuJoCo", "rolling in mujoco"), "round feet", beside, round_feet.MUJOCO_STEPS)
    both = zip(round_knees.NAMES, round_knees.exact(), round_knees.in_mujoco(), strict=True)
    rows = [[name, minus(f"{exact:.6f}"), minus(f"{walked:.6f}")] for name, exact, walked in both]
    headings = ("quantity", "the model", f"MuJoCo, after {round_knees.MUJOCO_STEPS} steps")
    show_table("knees on round feet in MuJoCo", headings, rows, tables, "bending in mujoco")


def _write_beside(
    tables: Path | None, titles: tuple[str, str], source: str, found: Mapping[str, float], steps: int
) -> None:
    _, numbers, ours = SOURCES[source]
    rows = [
        [numbers[name].quantity, minus(numbers[name].printed), shown(ours[name]().value, 6), minus(f"{value:.6f}")]
        for name, value in found.items()
    ]
    title, place = titles
    show_table(title, ("quantity", "published", "the model", f"MuJoCo, after {steps} steps"), rows, tables, place)


def _write_push_off(tables: Path | None) -> None:
    robots = (rimless_wheel.LIGHT_LEGS, rimless_wheel.TABLE_ONE)
    rows = [
        [
            f"{half:g}",
            f"{rimless_wheel.closed_form(half):.6f}",
            *(f"{rimless_wheel.ratio(robot, half):.6f}" for robot in robots),
        ]
        for half in rimless_wheel.HALVES
    ]
    headings = ("half angle α, rad", "1 / (4 cos⁴ α)", "legs of 1e-9 of the hip's mass", "Table I")
    show_table("work of a push-off over that of the hip", headings, rows, tables, "push-off")


def _write_drake(tables: Path | None) -> None:
    rows = [
        [name, minus(f"{DRAKE[key]:.0e}"), minus(f"{left():.1e}")]
        for key, (name, left) in drake_invariants.INVARIANTS.items()
    ]
    for name, engine in drake_invariants.ENGINES.items():
        drift = drake_invariants.energy_drift(engine)
        rows.append(
            [f"change of the energy within a step, over the greatest kinetic energy: {name}", "", minus(f"{drift:.1e}")]
        )
    show_table("invariants", ("invariant", "Drake's tolerance", "ours"), rows, tables, "drake")


def _wheel_rows() -> Sequence[tuple[str, Callable[[], float]]]:
    expected = math.cos(2 * rimless_wheel.ALPHA)

    def engine(mass_ratio: float, engine: mjbiped.Engine) -> Callable[[], float]:
        def apart() -> float:
            found, closed = rimless_wheel.roll(mass_ratio, engine)
            return float(np.abs(found - closed).max())

        return apart

    return (
        (
            "impact map: rate after over rate before, cos 2α",
            lambda: rimless_wheel.strike_coefficients(1e-12)[0] - expected,
        ),
        ("the same of the robot with knees", lambda: rimless_wheel.strike_coefficients(1e-12)[1] - expected),
        ("rate of the long gait of Garcia's walker", lambda: simplest_walker.wheel_rate("long")),
        ("rate of the short gait", lambda: simplest_walker.wheel_rate("short")),
        ("hybrid engine, legs of 1e-12 of the hip's mass", engine(1e-12, mjbiped.Hybrid())),
        ("hybrid engine, 1e-9", engine(1e-9, mjbiped.Hybrid())),
        ("hybrid engine, 1e-6", engine(1e-6, mjbiped.Hybrid())),
        ("hybrid engine, 1e-3", engine(1e-3, mjbiped.Hybrid())),
        ("MuJoCo, 1e-3", engine(1e-3, mjbiped.Mujoco())),
    )


def _write_wheel(tables: Path | None) -> None:
    rows = [[name, minus(f"{abs(apart()):.1e}")] for name, apart in _wheel_rows()]
    show_table("the rimless wheel", ("what", "distance from the closed form"), rows, tables, "wheel")


def _write_disc(tables: Path | None) -> None:
    rows = []
    for name, k in rolling_disc.WHEELS.items():
        speeds = [rolling_disc.critical_speed(k), *(rolling_disc.found(tilt, k) for tilt in rolling_disc.PHYSICS)]
        shares = (speed**2 / (rolling_disc.GRAVITY * rolling_disc.RADIUS) for speed in speeds)
        rows.append([name, *(f"{share:.8f}" for share in shares)])
    headings = ("wheel", "v² / (g r), closed form", "rigid body that does not slip", "MuJoCo, 0.1 ms")
    show_table("the rolling disc", headings, rows, tables, "disc")


@click.command(help=__doc__)
@TABLES
@click.option("--image", type=click.Path(dir_okay=False, path_type=Path), help="PNG file for the figure.")
def main(tables: Path | None, image: Path | None) -> None:
    """Compute everything and print the tables."""
    for write in (_write_sources, _write_convergence, _write_mujoco, _write_drake):
        write(tables)
    for write in (_write_wheel, _write_push_off, _write_disc):
        write(tables)
    if image is not None:
        simplest_walker.draw(image)


if __name__ == "__main__":
    main()
