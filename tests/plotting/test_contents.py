"""What figures show is what the records, gaits and studies hold."""

from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D

import mjbiped
from mjbiped.plotting.style import C_MT, ESTIMATE, HYBRID, MUJOCO, PLANNED, TRUTH, look
from mjbiped.plotting.walk import plot_walk


def words(figure: Figure) -> str:
    """All that is written beside numbers at ticks."""
    axes = figure.get_axes()
    titles = "\n".join(one.get_xlabel() + one.get_ylabel() + one.get_title("left") for one in axes)
    notes = "\n".join(text.get_text() for one in axes for text in one.texts)
    return f"{figure.get_suptitle()}\n{titles}\n{notes}".replace("\u00a0", " ")


def panel(figure: Figure, title: str) -> Axes:
    return next(axes for axes in figure.axes if title in axes.get_title("left").replace("\n", " "))


def lines(axes: Axes) -> dict[str, Line2D]:
    """Those with a label."""
    return {str(line.get_label()): line for line in axes.lines if not str(line.get_label()).startswith("_")}


def points(line: Line2D) -> np.ndarray:
    return np.asarray(line.get_xydata(), dtype=float)


def test_a_walk(walk: mjbiped.Walk) -> None:
    figure = plot_walk(walk)
    shown = words(figure)
    for text in (
        *("x (m)", "z (m)", "slope (°)", "torque (N m)", "time (s)", "angle q₁ (rad)", "rate q̇₂ (rad/s)"),
        *("(a) Time lapse", "(e) Phase portrait", "segments (3 segments)", "finished after 5 steps", "−20 mm  2.0°"),
        *(f"{C_MT} {walk.cost_of_transport:.4f}", f"{walk.peak_torque[1]:.2f} (hip)"),
    ):
        assert text in shown.replace("\n", " "), text
    looks: dict[str, Any] = {"estimate φ̂": ESTIMATE, "true slope φ": TRUTH, "re-planned reference": PLANNED}
    signals = {"stance leg": "q_stance", "swing leg": "q_swing", "ankle τ₁": "torque_ankle", "hip τ₂": "torque_hip"}
    looks |= {name: look(signal) for name, signal in signals.items()}
    assert len({style["color"] for style in (*looks.values(), MUJOCO, HYBRID)}) == len(looks) + 2
    found = {name: line.get_color() for axes in figure.axes for name, line in lines(axes).items()}
    assert {name: found[name] for name in looks} == {name: style["color"] for name, style in looks.items()}
    hip = lines(panel(figure, "torque"))["hip τ₂"]
    np.testing.assert_array_equal(points(hip).T, (walk.samples["time"], walk.samples["torque"][:, 1]))


def test_a_figure_has_the_panels_that_are_named(walk: mjbiped.Walk) -> None:
    figure = plot_walk(walk, panels=("phase", "angle"))
    titles = [axes.get_title("left") for axes in figure.axes]
    phases = ["Phase portrait, stance leg", "Phase portrait, swing leg"]
    assert [title[4:] for title in titles] == ["Angle from the ground's normal", *phases]
    for name in ("stance leg q₁", "swing leg q₂"):  # no line joins the legs that change roles
        assert np.isnan(points(lines(figure.axes[0])[name])[:, 1]).sum() == walk.steps
