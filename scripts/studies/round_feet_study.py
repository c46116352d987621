"""What the radius of the feet does: period, step, multipliers and basin of the passive gait of Table I's compass biped.

The basin is that share of the starts which settle; it is counted in one window of rates for all radii, so that the
shares can be compared. Five minutes on two cores.

    python -m scripts.studies.round_feet_study --tables docs/tables/validation --image docs/images/round_feet.png
"""

from __future__ import annotations

import math
from pathlib import Path
from typing import NamedTuple

import click
import numpy as np
from tqdm.auto import tqdm

import mjbiped
from mjbiped.limit_cycles.basin import Fate
from mjbiped.plotting.style import BLUE, GUIDE, ORANGE, drawn, make_small
from scripts.pages import TABLES, show_rows

SLOPES_DEG = (1.0, 2.0)
RADII = (0.0, 0.1, 0.2, 0.3, 0.4, 0.5, 0.6, 0.65, 0.75)
"""In leg lengths. From 0.75 on the stance leg does not topple: the arc's centre is as high as the mass on it."""
STANCE_RATES, SWING_RATES = np.linspace(0.0, 3.0, 41), np.linspace(-1.0, 4.0, 41)
"""Of the starts, rad/s; their angles are those of the gait."""


class Found(NamedTuple):
    """A gait and its basin.

    Attributes:
        gait: The passive gait; None: there is none.
        share: Of the starts that settle.
    """

    gait: mjbiped.PassiveGait | None
    share: float

    @property
    def greatest(self) -> float:
        """Modulus of the greatest multiplier; NaN without a gait."""
        return math.nan if self.gait is None else float(abs(self.gait.multipliers).max())


def found(radius: float, slope_deg: float) -> Found:
    """Find the gait on feet of a radius, in leg lengths, and its basin."""
    robot, slope = mjbiped.RoundCompass(foot_radius=radius), math.radians(slope_deg)
    try:
        gait = mjbiped.find_passive_gait(robot, slope)
    except mjbiped.GaitError:
        return Found(None, 0.0)
    basin = mjbiped.basin_of_attraction(robot, slope, stance_rates=STANCE_RATES, swing_rates=SWING_RATES)
    return Found(gait, basin.share(Fate.SETTLED))


def row(radius: float, slope_deg: float, one: Found) -> dict[str, str]:
    """A row of the table."""
    gait, place = one.gait, {"slope, °": f"{slope_deg:g}", "radius, leg lengths": f"{radius:g}"}
    if gait is None:
        return place | {"period, s": "none"}
    return place | {
        "period, s": f"{gait.period:.4f}",
        "step, m": f"{gait.step_length:.4f}",
        "speed, m/s": f"{gait.speed:.4f}",
        "greatest multiplier": f"{one.greatest:.4f}",
        "basin, %": f"{100 * one.share:.1f}",
    }


def draw(image: Path, studied: dict[tuple[float, float], Found]) -> None:
    """Draw the greatest multiplier and the basin over the radius."""
    with drawn(image) as figure:
        figure.set_figheight(3.4)
        left, right = figure.subplots(1, 2)
        for slope, colour, mark in zip(SLOPES_DEG, (BLUE, ORANGE), "os", strict=True):
            walked = [(radius, one) for (at, radius), one in studied.items() if at == slope and one.gait is not None]
            radii = [radius for radius, _ in walked]
            left.plot(radii, [one.greatest for _, one in walked], mark + "-", color=colour, label=f"slope {slope:g}°")
            right.plot(radii, [100 * one.share for _, one in walked], mark + "-", color=colour)
        for axes, words in ((left, "greatest multiplier, modulus"), (right, "starts that settle (%)")):
            axes.axvline(RADII[-1], color=GUIDE, linestyle=":", label="no gait from here on")
            axes.set(xlabel="radius of the feet (leg lengths)", ylabel=words, ylim=(0.0, None))
        left.legend()
    make_small(image)


@click.command()
@TABLES
@click.option("--image", type=click.Path(path_type=Path), help="Write the figure.")
def main(tables: Path | None, image: Path | None) -> None:
    """Sweep the radius."""
    places = [(slope, radius) for slope in SLOPES_DEG for radius in RADII]
    studied = {(slope, radius): found(radius, slope) for slope, radius in tqdm(places, unit="gait")}
    rows = [row(radius, slope, one) for (slope, radius), one in studied.items()]
    show_rows("the radius of the feet", rows, tables, "radius")
    if image is not None:
        draw(image, studied)


if __name__ == "__main__":
    main()
