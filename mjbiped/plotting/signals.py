"""The lines of a walk's signals over time, as figures and the charts in videos have them."""

from __future__ import annotations

from matplotlib.axes import Axes

from mjbiped.plotting.style import look
from mjbiped.records.signals import Lines, Values


def draw_signals(axes: Axes, time: Values, lines: Lines, part: slice = slice(None)) -> None:
    """Draw the signals of a panel over time (s), all samples or a part of them."""
    for name, signal in lines.signals.items():
        axes.plot(time[part], lines.values[name][part], label=signal.label, **look(name))
