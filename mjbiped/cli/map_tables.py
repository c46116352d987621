"""Printed results of the commands of `mjbiped.cli.maps`."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Any

import numpy as np
from rich.console import RenderableType

from mjbiped.cli.tables import Told
from mjbiped.records.tables import bare_table

if TYPE_CHECKING:
    from mjbiped.limit_cycles.basin import Basin
    from mjbiped.limit_cycles.bifurcation import BifurcationDiagram, Cascade
    from mjbiped.limit_cycles.map_slices import MapSlices


def map_told(found: MapSlices) -> Told:
    """Report the fixed point of a return map, its multipliers, and where a walk from near it ends."""
    gait: Any = found.gait
    summary = {
        "slope_deg": math.degrees(gait.slope),
        "fixed_point": dict(zip(found.components, found.fixed_point.tolist(), strict=True)),
        "multipliers": [[value.real, value.imag] for value in gait.multipliers.tolist()],
        "stable": gait.stable,
        "outcome": found.outcome,
        "settled_period": 1 if found.settled is None and gait.stable else found.settled and len(found.settled.states),
    }
    table = bare_table("component", "of the gait of period one", numbers=True)
    for name, value in summary["fixed_point"].items():
        table.add_row(name, f"{value:+.6f}")
    multipliers = ", ".join(f"{value:.5f}" for value in np.abs(gait.multipliers))
    shown: list[RenderableType] = [table, f"magnitudes of the multipliers: {multipliers}"]
    if found.settled is not None:
        shown.append(f"a walk from nearby settles on a gait of period {len(found.settled.states)}")
    return summary, shown


def bifurcation_told(cascade: Cascade, diagram: BifurcationDiagram, steps: int, seconds: tuple[float, float]) -> Told:
    """Report period doublings, and the slope from which the robot falls.

    Args:
        cascade: The onsets of the doublings.
        diagram: The walks.
        steps: Steps on each slope.
        seconds: Time of the search and of the walks, s.
    """
    onsets = np.degrees(cascade.onsets).tolist()
    summary = {
        "onsets_deg": onsets,
        "ratios": cascade.ratios.tolist(),
        "accumulation_deg": math.degrees(cascade.accumulation),
        "cascade_end": cascade.end,
        "lost_deg": math.degrees(diagram.lost),
        "slopes": len(diagram.slopes),
        "steps": steps,
        "search_s": seconds[0],
        "diagram_s": seconds[1],
    }
    table = bare_table("period", "begins at", "distance from the last", "ratio of distances", numbers=True)
    ratios = ["", "", *(f"{ratio:.4f}" for ratio in summary["ratios"])]
    for number, onset in enumerate(onsets):
        distance = f"{onset - onsets[number - 1]:.5f}°" if number else ""
        table.add_row(str(2 ** (number + 1)), f"{onset:.5f}°", distance, ratios[number])
    shown: list[RenderableType] = [table]
    if cascade.end:
        shown.append(cascade.end)
    if len(onsets) > 1:
        shown.append(f"aperiodic beyond {summary['accumulation_deg']:.4f}°, if Feigenbaum's ratio holds")
    if math.isfinite(diagram.lost):
        shown.append(f"falls on {summary['lost_deg']:.3f}° and steeper")
    return summary, [*shown, f"{len(diagram.slopes) * steps} steps in {seconds[1]:.1f} s"]


def basin_told(found: Basin, seconds: float) -> Told:
    """Report the share of a basin's starts by their fate, and the duration of the computation, s."""
    from mjbiped.limit_cycles.basin import Fate

    shares = {fate.name.lower(): found.share(fate) for fate in Fate}
    summary = {
        "walker": found.walker,
        "slope_deg": math.degrees(found.slope),
        "starts": found.fates.size,
        "shares": shares,
        "mean_steps_to_settle": float(found.steps[found.fates == Fate.SETTLED].mean()) if shares["settled"] else None,
        "seconds": seconds,
    }
    table = bare_table("fate", "share of the starts", "steps, mean", numbers=True)
    for fate in Fate:
        here = found.fates == fate
        if here.any():
            table.add_row(fate.name.lower(), f"{100 * here.mean():.2f} %", f"{found.steps[here].mean():.2f}")
    return summary, [table, f"{found.fates.size} walks in {seconds:.1f} s"]
