"""The command `lateral-basin`: walks of bipeds in space from another roll than their gait's."""

from __future__ import annotations

import math
import time
from typing import Annotated

import numpy as np

from mjbiped.cli import options
from mjbiped.cli.commands import Choice, Given, command, filled, span
from mjbiped.cli.maps import Computed, Ends
from mjbiped.cli.walkers import controller_of, robot_of
from mjbiped.control.loading import FORMS
from mjbiped.utils import domains


@command("lateral-basin")
@filled(forms=FORMS)
def lateral_basin(
    *,
    slope_deg: Annotated[float, domains.SLOPE_DEG] = 0.0,
    controller: Annotated[str, Choice("NAME")] = "adaptive",
    rolls_deg: Annotated[Ends | None, span(domains.ROLL_DEG)] = None,
    roll_rates: Annotated[Ends | None, span(domains.RATE)] = None,
    grid: Annotated[int, domains.GRID] = 13,
    limit: Annotated[int, domains.LIMIT] = 10,
    law: Annotated[Given, [*options.MAP_LAW, *options.ROBOT]],
    results: Computed,
) -> None:
    """Map from which rolls and roll rates a controlled biped in space walks on.

    Each start stands just after an impact, both feet on the plane, as in the imitated gait but for the roll and its
    rate. Lines in the figure show by how much the divergent component of motion is off the gait's. A step takes a third
    of a second.

    Map:
        slope_deg: Slope of the plane, positive downhill.
        controller: A controller that imitates a gait; your own by its class: {forms}.
        rolls_deg: Rolls of the starts, less the gait's, degrees; 8 to either side if left out.
        roll_rates: Roll rates of the starts, less the gait's, rad/s; 0.6 to either side if left out.
        grid: Number of starts along each side.
        limit: Number of steps after which a walk is ended.

    \b
    Examples:
      mjbiped lateral-basin --robot compass3d --grid 7 --plot free.png
      mjbiped lateral-basin --robot compass3d --sole 0.12 --sole-width 0.08 --controller bounded-ankle --plot sole.png
    """  # noqa: D301 (click reads the backspace)
    from mjbiped.limit_cycles import lateral
    from mjbiped.limit_cycles.basin import BasinInterrupted, BasinStopped

    robot = robot_of(law)
    driver, began = controller_of(robot, law, controller), time.perf_counter()
    low, high = np.radians(rolls_deg) if rolls_deg else (-lateral.ROLL, lateral.ROLL)
    slowest, fastest = roll_rates or (-lateral.ROLL_RATE, lateral.ROLL_RATE)
    try:
        found = lateral.lateral_basin(
            driver,
            math.radians(slope_deg),
            robot=robot,
            rolls=np.linspace(low, high, grid),
            roll_rates=np.linspace(slowest, fastest, grid),
            limit=limit,
            progress=not results.quiet,
        )
    except (BasinInterrupted, BasinStopped) as stop:
        found = stop.basin
        results.stopped(stop, "; what was not computed has -1 steps")
    results.keep(found, "slope", "rolls", "roll_rates", "deviations", "steps", "fallen", "limit")
    results.draw("lateral:plot_lateral_basins", [found])
    told = {"walker": found.walker, "slope_deg": slope_deg, "starts": found.steps.size, "limit": limit}
    results.end({**told, "share_that_walks_on": found.share, "seconds": time.perf_counter() - began})
