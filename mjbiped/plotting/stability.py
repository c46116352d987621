"""Figure of Theorem 1 along walks: Lyapunov function, errors, excitation, and the condition (24)."""

from __future__ import annotations

import math
from collections.abc import Mapping
from pathlib import Path

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from mjbiped.analysis.stability import RESOLVED, Stability
from mjbiped.errors import InputError
from mjbiped.plotting.panels import legend_below, titled
from mjbiped.plotting.style import BLACK, GUIDE, LOOKS, drawn, note_at
from mjbiped.plotting.width import width
from mjbiped.robots.compass import Array

_MOST = 4  # walks
_MOST_NAMED = 40  # greatest number of steps with labelled changes of slope


def plot_stability(walks: Mapping[str, Stability], path: str | Path | None = None) -> Figure:
    """Draw Theorem 1 along up to four walks over the same ground.

    (a) V_a (15) over time. (b) Norm of eta before each touchdown. (c) Eigenvalues of each step's Gramian.
    (d) Left side of (24), which must be below 1, the left side for the best possible constants, and the actual ratio of
    the norms of eta.

    Args:
        walks: Walks by their names in the legend.
        path: File to write as well, `.png`, `.pdf` or `.svg`.

    Returns:
        The figure.

    Raises:
        InputError: There is no walk or more than four, or the path has another suffix.
        RenderError: The file cannot be written.
    """
    if not 1 <= len(walks) <= _MOST:
        raise InputError(f"a figure shows one to {_MOST} walks, got {len(walks)}")
    with drawn(path) as figure:
        across = width().beside(2)
        figure.set_figheight(0.6 + 3.0 * (4 // across))
        over_time, errors, excitation, condition = figure.subplots(4 // across, across).flat
        for (name, found), (color, marker, line) in zip(walks.items(), LOOKS[1:], strict=False):
            steps = np.arange(1, found.steps + 1)
            look = {"color": color, "marker": marker, "markersize": 3.5, "linewidth": 0.9, "linestyle": line}
            over_time.plot(found.time, _positive(found.lyapunov, RESOLVED**2), color=color, linestyle=line)
            errors.plot(steps, _positive(np.linalg.norm(found.end, axis=1), RESOLVED), label=name, **look)
            for values in found.excitation.T:
                excitation.plot(steps, values, **look)
            named = name == next(iter(walks))
            left, apart = ("left side of (24)", "‖η‖ over its value a step before, (26)") if named else (None, None)
            condition.plot(steps, _positive(found.condition), label=left, **look)
            hollow = {**look, "linestyle": "none", "markerfacecolor": "white", "label": apart}
            condition.plot(steps, _positive(found.ratio), **hollow)
        first = next(iter(walks.values()))
        steps = np.arange(1, first.steps + 1)
        floor = "left side of (24), best possible constants"
        condition.plot(steps, first.condition_floor, color=BLACK, linewidth=0.9, label=floor)
        over_time.set(yscale="log", xlabel="time (s)", ylabel="$V_a$")
        titled(over_time, "a", "Lyapunov function (15)")
        errors.set(yscale="log", ylabel="‖η‖ (rad, rad/s, 1)")
        titled(errors, "b", "Error before each touchdown")
        excitation.set(ylabel="eigenvalue of ∫WWᵀdt (1/s³)", ylim=(0.0, None))
        titled(excitation, "c", "Excitation: sine (upper), cosine (lower)")
        condition.set(yscale="log", ylabel="factor per step")
        titled(condition, "d", "Condition (24) and what happened")
        condition.set_ylim(*_limits(walks))
        condition.axhline(1.0, color=GUIDE, linewidth=1.0)
        for axes in (errors, excitation, condition):
            axes.set_xlabel("step")
            axes.xaxis.get_major_locator().set_params(integer=True)
        _mark_slopes(excitation, first)
        legend_below(figure, *errors.get_legend_handles_labels())
        condition.legend(loc="lower left")
    return figure


def _positive(values: Array, least: float = 0.0) -> Array:
    """Replace values by NaN that are not finite or not above `least`, for a logarithmic axis."""
    return np.where(np.isfinite(values) & (values > least), values, np.nan)


def _limits(walks: Mapping[str, Stability]) -> tuple[float, float]:
    """Limits of the last axis, which a factor from a zero error does not stretch."""
    shown = np.concatenate([[1.0]] + [np.append(found.condition, found.ratio) for found in walks.values()])
    shown = shown[np.isfinite(shown) & (shown > 0.0)]
    return 10.0 ** (math.floor(math.log10(shown.min())) - 2.5), min(10.0 ** math.ceil(math.log10(shown.max())), 1e5)


def _mark_slopes(axes: Axes, found: Stability) -> None:
    """Mark each step that begins on another slope with a line and the change."""
    if found.steps > _MOST_NAMED:
        return
    for step in np.flatnonzero(np.abs(found.slope_change) > 1e-9).tolist():
        axes.axvline(step + 1, color=GUIDE, linewidth=0.7, zorder=0)
        text = f"{math.degrees(found.slope_change[step]):+.3g}°".replace("-", "−")
        note_at(axes, text, step + 1, 0.02, (2, 0), fontsize=7)
