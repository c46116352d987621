"""Figures are complete, labelled with units, and written whole; whatever became of the walk."""

import dataclasses
import io
import math
from itertools import pairwise
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from matplotlib.figure import Figure
from PIL import Image

import mjbiped
from controllers import AdaptiveController, PassiveController
from mjbiped.analysis.replay import recorded_controller, transitions
from mjbiped.errors import InputError, RenderError
from mjbiped.plotting import figure_width
from mjbiped.plotting.gait import plot_gait
from mjbiped.plotting.style import ANKLE, C_MT, ESTIMATE, HIP, HYBRID, MUJOCO, PLANNED, SWING, TRUTH, look
from mjbiped.plotting.walk import plot_walk, rows_of
from mjbiped.records import loads
from mjbiped.records.record import Walk
from mjbiped.terrain.terrain import Terrain

TWO_STEPS = Terrain.from_segments([(0.6, 0.0), (2.0, 2.0, -0.02)])


@pytest.fixture(scope="session")
def gait() -> mjbiped.PassiveGait:
    return mjbiped.find_passive_gait(mjbiped.Compass(), math.radians(2))


@pytest.fixture(scope="session")
def walk(gait: mjbiped.PassiveGait) -> Walk:
    return mjbiped.walk(AdaptiveController(mjbiped.Compass(), gait), TWO_STEPS, steps=3)


@pytest.fixture(scope="session")
def fallen() -> Walk:
    """A fall without a single touchdown, by a controller without an estimate."""
    return mjbiped.walk(PassiveController(), Terrain.level(), steps=3, initial=(-0.2, 0.2, 0.2, 0.8))


def longer(walk: Walk, times: int) -> Walk:
    """The same steps many times over, each behind the last."""
    end, way = walk.end[0], walk.distance
    shift: dict[str, Any] = {"time": end, "x": way, "qpos": np.array([way, 0.0, 0.0, 0.0])}

    def repeated(table: dict[str, np.ndarray]) -> dict[str, np.ndarray]:
        return {
            name: np.concatenate([array + k * shift[name] if name in shift else array for k in range(times)])
            for name, array in table.items()
        }

    settings = {**walk.settings, "terrain": Terrain.level().to_dict()}
    return dataclasses.replace(
        walk,
        settings=settings,
        samples=repeated(dict(walk.samples)),
        touchdowns=repeated(dict(walk.touchdowns)),
        end=(end * times, 0.0),
    )


def labels(figure: Figure) -> str:
    texts = [text.get_text() for axes in figure.axes for text in (axes.xaxis.label, axes.yaxis.label)]
    return "\n".join(texts)


def pixels(figure: Figure) -> np.ndarray:
    buffer = io.BytesIO()
    figure.savefig(buffer, format="png", dpi=60)
    return np.asarray(Image.open(buffer).convert("RGB"))


def assert_nothing_cut_off(figure: Figure) -> None:
    image = pixels(figure)
    border = np.concatenate([image[:2].reshape(-1, 3), image[-2:].reshape(-1, 3), image[:, :2].reshape(-1, 3)])
    assert (border == 255).all()
    assert (image != 255).any(axis=2).mean() > 0.02


def test_a_walk_has_all_panels_with_units(walk: Walk) -> None:
    figure = plot_walk(walk)
    for unit in ("x (m)", "z (m)", "slope (°)", "torque (N m)", "time (s)", "angle q₁ (rad)", "rate q̇₂ (rad/s)"):
        assert unit in labels(figure)
    titles = " ".join(axes.get_title(loc="left") for axes in figure.axes)
    assert all(f"({letter})" in titles for letter in "abcde")
    title = figure.get_suptitle().replace("\n", " ").replace("\u00a0", " ")
    assert "segments (2 segments)" in title
    assert "finished after 3 steps" in title
    assert f"{C_MT} {walk.cost_of_transport:.4f}" in title
    assert f"{walk.peak_torque[1]:.2f} (hip)" in title
    texts = [text.get_text() for text in figure.axes[0].texts]
    assert "−20 mm  2.0°" in texts
    assert_nothing_cut_off(figure)


def test_a_colour_means_one_thing(walk: Walk) -> None:
    looks = {
        "stance leg": look("q_stance"),
        "swing leg": SWING,
        "estimate φ̂": ESTIMATE,
        "true slope φ": TRUTH,
        "ankle τ₁": ANKLE,
        "hip τ₂": HIP,
        "re-planned reference": PLANNED,
    }
    assert len({look["color"] for look in (*looks.values(), MUJOCO, HYBRID)}) == len(looks) + 2
    drawn = [(str(line.get_label()), line.get_color()) for axes in plot_walk(walk).axes for line in axes.lines]
    assert {name for name, _ in drawn} >= set(looks)
    for name, color in drawn:
        if name in looks:
            assert color == looks[name]["color"], name


def test_the_estimate_is_left_out_where_there_is_none(walk: Walk, fallen: Walk) -> None:
    def lines(figure: Figure) -> list[object]:
        return [line.get_label() for axes in figure.axes for line in axes.lines]

    assert "estimate φ̂" in lines(plot_walk(walk))
    figure = plot_walk(fallen)
    assert "estimate φ̂" not in lines(figure)
    assert any("(no estimate)" in axes.get_title(loc="left") for axes in figure.axes)


def test_a_fall_without_a_touchdown(fallen: Walk) -> None:
    assert (fallen.steps, fallen.outcome) == (0, "fell")
    figure = plot_walk(fallen)
    assert "fell after 0 steps" in figure.get_suptitle()
    assert f"{C_MT}\u00a0none" in figure.get_suptitle()
    assert "fell" in [text.get_text() for text in figure.axes[0].texts]
    assert_nothing_cut_off(figure)


@pytest.mark.slow
def test_long_walks_are_split_into_rows_that_cover_them(walk: Walk) -> None:
    long = longer(walk, 50)
    rows = rows_of(long)
    assert 2 <= len(rows) <= 6
    assert rows[0].start < 0.0
    assert rows[-1].stop > long.samples["qpos"][-1, 0]
    assert all(before.stop == pytest.approx(after.start) for before, after in pairwise(rows))
    figure = plot_walk(long)
    assert figure.get_size_inches()[1] < 20.0
    assert_nothing_cut_off(figure)


def test_x_and_z_have_one_scale(walk: Walk) -> None:
    figure = plot_walk(longer(walk, 8))
    figure.draw_without_rendering()
    axes = figure.axes[0]
    width, height = axes.get_window_extent().size
    scales = width / np.ptp(axes.get_xlim()), height / np.ptp(axes.get_ylim())
    assert scales[0] == pytest.approx(scales[1], rel=1e-3)


def test_no_step_is_joined_to_the_next_in_the_phase_portraits(walk: Walk) -> None:
    """Legs are exchanged at once: a line from one step to the next would show a motion that never was."""
    for axes in plot_walk(walk).axes[-2:]:
        q, dq = (np.asarray(data, dtype=float) for data in axes.lines[0].get_data())
        assert np.isnan(q).any()
        assert np.nanmax(np.abs(np.diff(q))) < 0.03
        shown = ~np.isnan(q)
        dq[~shown] = np.nan
        assert np.nanmax(np.abs(np.diff(dq))) < 0.2


def test_phase_portraits_have_the_re_planned_reference(walk: Walk, fallen: Walk) -> None:
    """One band per transition under the motion, each from the state at its step's start on; none without a plan."""
    planned = transitions(walk, recorded_controller(walk))
    for leg, axes in enumerate(plot_walk(walk).axes[-2:]):
        bands = [line for line in axes.lines if line.get_linewidth() == PLANNED["linewidth"]]
        assert bands[0].get_label() == "re-planned reference"
        for band, curve in zip(bands, planned, strict=True):
            q, dq = (np.asarray(data, dtype=float) for data in band.get_data())
            np.testing.assert_array_equal(np.stack([q, dq], axis=1), curve[:, [leg, 2 + leg]])
            assert band.get_zorder() < axes.lines[0].get_zorder()
    assert "re-planned reference" not in [line.get_label() for line in plot_walk(fallen).axes[-1].lines]


def test_a_figure_has_the_panels_that_are_named(walk: Walk) -> None:
    figure = plot_walk(walk, panels=("phase", "angle"))
    titles = [axes.get_title(loc="left") for axes in figure.axes]
    assert titles == [
        "(a) Angle from the ground's normal",
        "(b) Phase portrait, stance leg",
        "(c) Phase portrait, swing leg",
    ]
    for line in figure.axes[0].lines:
        if line.get_label() in ("stance leg q₁", "swing leg q₂"):  # no line joins the legs that change roles
            assert np.isnan(np.asarray(line.get_ydata(), dtype=float)).sum() == walk.steps
    with figure_width("slide"):
        assert plot_walk(walk).get_size_inches() == pytest.approx([9.6, 5.4])
    with pytest.raises(InputError, match=r"unknown panel 'torqe': valid are lapse, .*; did you mean 'torque'"):
        plot_walk(walk, panels=("torqe",))


def test_the_outline_has_both_ends_of_a_step() -> None:
    x, z = TWO_STEPS.outline(-0.5, 1.0)
    assert x == pytest.approx([-0.5, 0.6, 0.6, 1.0])
    assert z == pytest.approx([0.0, 0.0, -0.02, -0.02 - 0.4 * math.tan(math.radians(2))])


def test_a_gait(gait: mjbiped.PassiveGait) -> None:
    figure = plot_gait(gait)
    assert f"{gait.period:.4f}\u00a0s" in figure.get_suptitle()
    _, cycle, foot, circle = figure.axes
    assert "(rad)" in cycle.get_xlabel()
    assert np.asarray(foot.lines[0].get_xydata())[-1] == pytest.approx([gait.step_length, 0.0], abs=1e-6)
    message = circle.texts[0].get_text()
    assert "−0.43032 + 0.31560 i" in message
    assert "+0.27555" in message
    jumps = [line for line in cycle.lines if line.get_linestyle() == ":"]
    assert [list(line.get_ydata()) for line in jumps] == [  # type: ignore[arg-type]
        pytest.approx([gait.end[2], gait.start[3]]),
        pytest.approx([gait.end[3], gait.start[2]]),
    ]
    assert_nothing_cut_off(figure)


@pytest.mark.slow
@pytest.mark.parametrize(("suffix", "beginning"), [("png", b"\x89PNG"), ("pdf", b"%PDF"), ("svg", b"<?xml")])
def test_files_are_what_their_suffix_says_and_the_same_each_time(
    gait: mjbiped.PassiveGait, tmp_path: Path, suffix: str, beginning: bytes
) -> None:
    first, second = tmp_path / f"first.{suffix}", tmp_path / f"second.{suffix.upper()}"
    plot_gait(gait, first)
    plot_gait(gait, str(second))
    assert first.read_bytes().startswith(beginning)
    assert first.read_bytes() == second.read_bytes()
    assert sorted(tmp_path.iterdir()) == [first, second]


def test_refused_paths(walk: Walk, gait: mjbiped.PassiveGait, tmp_path: Path) -> None:
    for name in ("walk.jpeg", "walk", "walk.npz"):
        with pytest.raises(InputError, match=r"\.png, \.pdf, \.svg"):
            plot_walk(walk, tmp_path / name)
    with pytest.raises(RenderError, match=r"cannot write .*No such file"):
        plot_gait(gait, tmp_path / "missing" / "gait.png")
    assert not list(tmp_path.iterdir())


def test_an_empty_record_is_refused(walk: Walk) -> None:
    empty = dataclasses.replace(walk, samples={name: array[:0] for name, array in walk.samples.items()})
    with pytest.raises(RenderError, match="no samples"):
        plot_walk(empty)


def test_a_name_with_a_dollar_sign_is_no_formula(walk: Walk) -> None:
    named = {**walk.settings["terrain"], "name": "trail_$x^"}
    figure = plot_walk(dataclasses.replace(walk, settings={**walk.settings, "terrain": named}))
    assert_nothing_cut_off(figure)


class _Passive(PassiveController):
    """Without functions to compile."""

    def law(self) -> None:  # type: ignore[override]
        return None


def test_a_walk_on_knees_shows_torque_and_flexion_of_the_knee() -> None:
    robot, slope = mjbiped.KneedBiped(), Terrain.incline(2.5)
    start = (-0.24, 0.24, 0.24, 1.10, 0.33, 0.33)
    done = mjbiped.walk(_Passive(), slope, robot=robot, engine="hybrid", initial=start, steps=2)
    figure = plot_walk(done)
    titles = [axes.get_title(loc="left") for axes in figure.axes]
    for letter, words in (
        ("c", "Joint torque"),  # of the stance knee; ankle and swing knee have none, and no panels of zeros
        ("d", "Flexion of the swing knee"),
        ("f", "Phase portrait, swing thigh"),
        ("g", "Phase portrait, swing shank"),
    ):
        assert f"({letter}) {words}" in titles
    flexion = next(axes for axes in figure.axes if "Flexion" in axes.get_title(loc="left"))
    line, strikes = (line for line in flexion.get_lines() if not str(line.get_label()).startswith("_"))
    q = done.samples["q"]
    assert np.asarray(line.get_ydata()) == pytest.approx(np.degrees(q[:, 2] - q[:, 1]))
    expected = np.append(0.0, done.touchdowns["time"])[:-1] + done.touchdowns["knee_strike"]
    assert np.asarray(strikes.get_xdata()) == pytest.approx(expected)
    assert "(knee)" in "".join(text.get_text() for text in figure.texts)
    torques = next(axes for axes in figure.axes if "Joint torque" in axes.get_title(loc="left"))
    held = next(line for line in torques.get_lines() if str(line.get_label()) == "stance knee")
    assert np.asarray(held.get_ydata()) == pytest.approx(loads.knee_torque(done))
    # the knee stands out of the line from hip to foot in some posture of the time lapse
    lapse = figure.axes[0]
    widths = {len(path) for each in lapse.collections for path in getattr(each, "get_segments", list)()}
    assert 3 in widths
