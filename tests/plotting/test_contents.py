"""What figures show is what the records, gaits and studies hold."""

import math
from itertools import pairwise
from typing import Any

import numpy as np
import pytest
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D

import mjbiped
from mjbiped.analysis.replay import recorded_controller, transitions
from mjbiped.analysis.stability import Stability
from mjbiped.analysis.survival import Survival
from mjbiped.limit_cycles.basin import Basin, Fate
from mjbiped.limit_cycles.bifurcation import BifurcationDiagram, Cascade
from mjbiped.plotting import figure_width
from mjbiped.plotting.comparison import plot_comparison, plot_stability, plot_survival
from mjbiped.plotting.gait import plot_gait
from mjbiped.plotting.gaits import plot_basins, plot_bifurcation
from mjbiped.plotting.style import C_MT, ESTIMATE, HYBRID, MUJOCO, PLANNED, TRUTH, look
from mjbiped.plotting.walk import plot_walk, rows_of
from mjbiped.records import loads


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


def test_no_step_is_joined_to_the_next_and_each_has_its_plan(walk: mjbiped.Walk) -> None:
    """Legs are exchanged at once: a line from one step to the next would show a motion that never was."""
    planned = transitions(walk, recorded_controller(walk))
    for leg, axes in enumerate(plot_walk(walk).axes[-2:]):
        motion = points(axes.lines[0])
        assert np.isnan(motion[:, 0]).sum() >= walk.steps - 1
        assert (np.nanmax(np.abs(np.diff(motion, axis=0)), axis=0) < (0.05, 0.4)).all()
        bands = [line for line in axes.lines if line.get_linewidth() == PLANNED["linewidth"]]
        for band, curve in zip(bands, planned, strict=True):
            np.testing.assert_array_equal(points(band), curve[:, [leg, 2 + leg]])
            assert band.get_zorder() < axes.lines[0].get_zorder()


def test_a_fall_without_a_touchdown(fallen: mjbiped.Walk) -> None:
    figure = plot_walk(fallen)
    assert "fell after 0 steps" in words(figure)
    assert f"{C_MT} none" in words(figure)
    slope = panel(figure, "(no estimate)")
    assert "estimate φ̂" not in lines(slope)
    assert not any("torque" in axes.get_title("left") for axes in figure.axes)  # of a passive walk


def test_long_walks_are_split_into_rows_that_cover_them_in_one_scale(long_walk: mjbiped.Walk) -> None:
    with figure_width("single"):
        rows = rows_of(long_walk)
        figure = plot_walk(long_walk)
    assert 2 <= len(rows) <= 6
    assert rows[0].start < 0.0 < long_walk.samples["qpos"][-1, 0] < rows[-1].stop
    assert all(before.stop == pytest.approx(after.start) for before, after in pairwise(rows))
    drawn_hips = 0
    for axes, row in zip(figure.axes, rows, strict=False):
        hips = [points(line) for line in axes.lines if line.get_marker() == "o"]
        assert all(((row.start <= each[:, 0]) & (each[:, 0] <= row.stop)).all() for each in hips)
        drawn_hips += len(hips[1])
    assert drawn_hips == long_walk.steps


def test_a_figure_has_the_panels_that_are_named(walk: mjbiped.Walk) -> None:
    figure = plot_walk(walk, panels=("phase", "angle"))
    titles = [axes.get_title("left") for axes in figure.axes]
    phases = ["Phase portrait, stance leg", "Phase portrait, swing leg"]
    assert [title[4:] for title in titles] == ["Angle from the ground's normal", *phases]
    for name in ("stance leg q₁", "swing leg q₂"):  # no line joins the legs that change roles
        assert np.isnan(points(lines(figure.axes[0])[name])[:, 1]).sum() == walk.steps


def test_a_walk_on_knees(kneed_walk: mjbiped.Walk) -> None:
    figure, q, touchdowns = plot_walk(kneed_walk), kneed_walk.samples["q"], kneed_walk.touchdowns
    flexion = lines(panel(figure, "(d) Flexion of the swing knee"))
    np.testing.assert_allclose(points(flexion["swing knee q₃ − q₂"])[:, 1], np.degrees(q[:, 2] - q[:, 1]))
    strikes = np.append(0.0, touchdowns["time"])[:-1] + touchdowns["knee_strike"]
    assert points(flexion["knee strike"])[:, 0] == pytest.approx(strikes)
    held = lines(panel(figure, "(c) Joint torque"))["stance knee"]  # ankle and swing knee have none, and no panels
    assert points(held)[:, 1] == pytest.approx(loads.knee_torque(kneed_walk))


def test_a_walk_in_space(walk_in_space: mjbiped.Walk) -> None:
    figure, samples = plot_walk(walk_in_space), walk_in_space.samples
    seen = lines(panel(figure, "from above"))
    np.testing.assert_array_equal(points(seen["middle of the hip"]), samples["qpos"][:, [0, 4]])
    stood = np.column_stack([np.append(0.0, walk_in_space.touchdowns[name]) for name in ("x", "y")])
    stood[0, 1] = 0.05  # under the left leg
    assert points(seen["stance foot"]) == pytest.approx(stood[: len(points(seen["stance foot"]))], abs=1e-3)
    np.testing.assert_array_equal(points(lines(panel(figure, "torque"))["ankle roll"])[:, 1], samples["torque"][:, 2])
    across = lines(panel(figure, "across the heading"))
    for name, column in (("estimate", "lateral_estimate"), ("true slope", "lateral_slope")):
        assert points(across[name])[:, 1] == pytest.approx(np.degrees(samples[column]))


def test_a_passive_gait(gait: mjbiped.PassiveGait) -> None:
    figure = plot_gait(gait)
    assert f"{gait.period:.4f} s" in words(figure)
    postures, cycle, foot, circle = figure.axes
    assert len(postures.texts) == 8
    assert points(foot.lines[0])[-1] == pytest.approx([gait.step_length, 0.0], abs=1e-6)
    message = circle.texts[0].get_text()
    assert "−0.43032 + 0.31560 i" in message
    np.testing.assert_array_equal(points(circle.lines[-1]).T, (gait.multipliers.real, gait.multipliers.imag))
    jumps = [points(line) for line in cycle.lines if line.get_linestyle() == ":"]
    end, start = gait.end, gait.start
    expected = [[(end[0], end[2]), (start[1], start[3])], [(end[1], end[3]), (start[0], start[2])]]
    assert np.array(jumps) == pytest.approx(np.array(expected))


def test_bifurcation(diagram: BifurcationDiagram, cascade: Cascade) -> None:
    figure, onset = plot_bifurcation(diagram, cascade), cascade.branches[0].doubling
    assert onset is not None
    for text in ("slope (°)", "step length (m)", "period 2: 2.7284°", "period 4: 3.2986°", "first fall on 3."):
        assert text in words(figure)
    # every step kept, on its slope: those of periodic walking, and behind them the others
    others, periodic = (points(line) for line in figure.axes[0].lines[:2])
    assert len(periodic) == np.count_nonzero(diagram.counts()) * diagram.step_lengths.shape[1]
    slopes = np.repeat(np.degrees(diagram.slopes), diagram.step_lengths.shape[1])
    kept = np.column_stack([slopes, diagram.step_lengths.ravel()])
    np.testing.assert_array_equal(np.sort(np.concatenate([others, periodic]), axis=0), np.sort(kept, axis=0))
    # the unstable gait of period one begins at its onset, and goes on beyond both ends of the magnified panel
    unstable = [points(axes.lines[2]) for axes in figure.axes]
    assert all(line[0].tolist() == [math.degrees(onset.slope), onset.step_lengths[0]] for line in unstable)
    low, high = figure.axes[1].get_xlim()
    assert unstable[1][0, 0] < low < high < unstable[1][-1, 0]


def test_basins(maps: list[Basin]) -> None:
    small, _ = maps
    shown = words(plot_basins(maps)).replace("\n", " ")
    for text in ("(rad/s)", "passive on 2° down", f"{100 * small.share(Fate.SETTLED):.1f} % of the window settle"):
        assert text in shown
    frame = points(plot_basins(maps).axes[1].lines[-1])
    assert (frame.min(axis=0).tolist(), frame.max(axis=0).tolist()) == ([0.9, -0.5], [1.3, 1.5])
    figure = plot_basins([small])
    assert "steps until settled" in words(figure)
    meshes: list[Any] = [*figure.axes[0].collections]
    falls, _, settled = (mesh.get_array().reshape(small.fates.shape) for mesh in meshes)
    assert (falls.mask == (small.fates != Fate.FELL)).all()
    assert settled.compressed().tolist() == small.steps[small.fates == Fate.SETTLED].tolist()
    # what settles is darker than what falls in grey print, by Rec. 601
    colours = [meshes[k].cmap(np.linspace(0.0, 1.0, 256)) for k in (0, 2)]
    light, dark = (each[:, :3] @ (0.299, 0.587, 0.114) for each in colours)
    assert light.min() > dark.max() + 0.1


def test_stability_and_survival(evaluated: dict[str, Stability]) -> None:
    found, figure = evaluated["a walk"], plot_stability(evaluated)
    over_time, errors, excitation, condition = figure.axes
    np.testing.assert_array_equal(over_time.lines[0].get_ydata(), found.lyapunov)
    np.testing.assert_array_equal(errors.lines[0].get_ydata(), np.linalg.norm(found.end, axis=1))
    np.testing.assert_array_equal([line.get_ydata() for line in excitation.lines[:2]], found.excitation.T)
    np.testing.assert_array_equal([line.get_ydata() for line in condition.lines[:2]], (found.condition, found.ratio))
    np.testing.assert_array_equal(condition.lines[4].get_ydata(), found.condition_floor)
    assert np.isnan(np.asarray(errors.lines[1].get_ydata(), dtype=float)).all()  # without any error
    change: Any = excitation.texts[0]
    assert (change.get_text(), change.xy[0]) == ("−1.5°", 1 + np.flatnonzero(found.slope_change)[0])
    survivals = {"often": Survival((5, 9, 40, 100), (True, True, True, False)), "never": Survival((50,), (False,))}
    (axes,) = plot_survival(survivals).axes
    for line, survival in zip(axes.lines, survivals.values(), strict=True):
        np.testing.assert_array_equal(points(line), np.transpose(survival.curve()[:2]))
    assert [*lines(axes)] == ["often: a fall in 51.3 steps", "never: no fall"]  # 154 steps, 3 falls


def test_comparisons_leave_out_panels_in_which_nothing_happens(
    compared: mjbiped.Comparison, compared_falls: mjbiped.Comparison
) -> None:
    titles = ["(a) Joint torque", "(b) Step length", "(c) Slope estimate at touchdown, and slope of the ground"]
    assert [title for axes in plot_comparison(compared).axes if (title := axes.get_title("left"))] == titles
    (alone,) = plot_comparison(compared_falls).axes
    assert [text.get_text() for text in alone.texts] == ["both fell"]
