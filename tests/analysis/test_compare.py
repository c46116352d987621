"""Two engines side by side: what is different, where they part, and whether the cause is named rightly."""

import dataclasses
import json
import math
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import mjbiped
from controllers import AdaptiveController, Controller, PassiveController
from mjbiped.analysis import divergence
from mjbiped.analysis.compare import Comparison, torque_differences
from mjbiped.analysis.divergence import COLUMNS
from mjbiped.cli.results import as_json
from mjbiped.engines.base import Run
from mjbiped.plotting.comparison import plot_comparison
from mjbiped.records import measures
from mjbiped.records.record import Walk
from mjbiped.terrain.terrain import Terrain


@pytest.fixture(scope="session")
def agreeing(controller: AdaptiveController) -> Comparison:
    return mjbiped.compare(controller, Terrain.slopes(length=0.6, change_deg=1.0), steps=3)


def changed(walk: Walk, outcome: str | None = None, rows: int | None = None, **columns: Any) -> Walk:
    """A record with other touchdowns."""
    table = {name: column[:rows].copy() for name, column in walk.touchdowns.items()}
    table.update(columns)
    return dataclasses.replace(walk, touchdowns=table, outcome=outcome or walk.outcome)


def again(there: Walk, here: Walk, controller: Controller) -> Comparison:
    table = divergence.differences(there, here)
    return Comparison(there, here, table, divergence.find(there, here, table, controller))


def test_agreement(agreeing: Comparison) -> None:
    assert agreeing.divergence is None
    assert agreeing.verdict.startswith("The engines agree at all 3 touchdowns")
    assert agreeing.mujoco.settings["engine"] == "mujoco"
    assert agreeing.hybrid.settings["engine"] == "hybrid"
    for name in COLUMNS:
        assert (np.abs(agreeing.touchdowns[name]) <= agreeing.touchdowns[f"limit_{name}"]).all(), name
    assert agreeing.touchdowns["x"] == pytest.approx(
        agreeing.mujoco.touchdowns["x"] - agreeing.hybrid.touchdowns["x"], abs=0.0
    )


def test_measures_are_those_of_the_records(agreeing: Comparison) -> None:
    table = agreeing.measures()
    assert {name: row["mujoco"] for name, row in table.items()} == measures.summary(agreeing.mujoco)
    assert {name: row["hybrid"] for name, row in table.items()} == measures.summary(agreeing.hybrid)
    cost = table["cost_of_transport"]
    assert cost["difference"] == cost["mujoco"] - cost["hybrid"]
    assert cost["difference_percent"] == pytest.approx(100.0 * cost["difference"] / cost["hybrid"])
    assert table["outcome"]["difference"] is None
    assert table["largest_penetration_m"]["difference_percent"] is None  # the hybrid engine's is zero
    assert json.loads(as_json(agreeing.to_dict()))["verdict"] == agreeing.verdict


def test_torques_are_compared_at_equal_times_since_the_touchdown(agreeing: Comparison) -> None:
    time, difference = torque_differences(agreeing)
    assert np.array_equal(time, agreeing.mujoco.samples["time"])
    assert np.isnan(difference).mean() < 0.03  # at most two samples of some 150 per step
    # peak torques agree within 0.05 N m; at equal absolute times the jumps at touchdowns would show, of up to 2 N m
    assert np.nanmax(np.abs(difference)) < 0.15
    shifted = agreeing.hybrid.samples["torque"] + 1.0
    other = dataclasses.replace(agreeing.hybrid, samples={**agreeing.hybrid.samples, "torque": shifted})
    _, less = torque_differences(dataclasses.replace(agreeing, hybrid=other))
    assert less == pytest.approx(difference - 1.0, abs=1e-12, nan_ok=True)


@pytest.mark.slow
@pytest.mark.parametrize(
    ("terrain", "replanning", "steps", "where", "cause"),
    [
        (Terrain.stairs(rise=0.045, first=1.0, count=1), 0.8, 3, 3, "struck a riser (in MuJoCo and the hybrid engine)"),
        (Terrain.stairs(rise=-0.06), None, 4, 4, "friction: the motion asks for |Ft/Fn| = 2.0"),
        (Terrain.stairs(rise=-0.06), None, 4, 4, "slip: the stance foot slid by 14.9"),
        # the second footholds are within 0.001 mm of the edge of the step down, on either side of it
        (Terrain.from_segments([(0.7557675, 0.0), (5.0, 0.0, -0.06)]), 0.8, 2, 2, "an edge: touchdown 2"),
    ],
)
def test_named_causes(
    terrain: Terrain, replanning: float | None, steps: int, where: int, cause: str, controller: AdaptiveController
) -> None:
    walked = mjbiped.compare(dataclasses.replace(controller, replanning_delay=replanning), terrain, steps=steps)
    assert walked.divergence is not None
    assert walked.divergence.touchdown == where
    assert any(cause in named for named in walked.divergence.causes), walked.verdict
    assert cause in walked.verdict


def test_threshold_of_the_controller(controller: AdaptiveController) -> None:
    """On level ground MuJoCo's states are 7e-5 rad/s off the cycle and re-planned, the hybrid engine's are not."""
    touchy = dataclasses.replace(controller, replanning_threshold=3e-5)
    walked = mjbiped.compare(touchy, Terrain.level(), steps=2)
    causes = list(divergence.explanations(walked.mujoco, walked.hybrid, 1, touchy))
    assert any("plans the new step in one engine alone" in cause for cause in causes)
    assert not list(divergence.explanations(walked.mujoco, walked.hybrid, 1, controller))  # of which both were within


def test_strike_in_one_engine_alone(agreeing: Comparison, controller: AdaptiveController) -> None:
    strikes = np.array([0, 1, 0])
    found = again(agreeing.mujoco, changed(agreeing.hybrid, strikes=strikes), controller)
    assert found.divergence is not None
    assert found.divergence.touchdown == 2
    assert found.divergence.differences == ("a face impact in the hybrid engine alone",)
    assert "struck a riser (in the hybrid engine)" in found.verdict
    # the record of one engine says whether, that of the other how often
    both = [changed(walk, strikes=strikes * count) for count, walk in ((1, agreeing.mujoco), (3, agreeing.hybrid))]
    assert again(both[0], both[1], controller).divergence is None


def test_correction_in_one_engine_alone(agreeing: Comparison, controller: AdaptiveController) -> None:
    here = agreeing.hybrid.touchdowns
    row = int(np.argmax(np.abs(here["slope_estimate"] - here["slope_estimate_before"])))
    uncorrected = here["slope_estimate"].copy()
    uncorrected[row] = here["slope_estimate_before"][row]
    found = again(agreeing.mujoco, changed(agreeing.hybrid, slope_estimate=uncorrected), controller)
    assert found.divergence is not None
    assert found.divergence.touchdown == row + 1
    assert "corrects its slope estimate in one engine alone" in found.verdict


def test_no_cause_is_invented(agreeing: Comparison, controller: AdaptiveController) -> None:
    x = agreeing.hybrid.touchdowns["x"].copy()
    x[2] += 0.01
    found = again(agreeing.mujoco, changed(agreeing.hybrid, x=x), controller)
    assert found.divergence is not None
    assert (found.divergence.touchdown, found.divergence.causes) == (3, ())
    assert found.verdict.endswith("No cause was found.")
    assert "x -10 mm" in found.verdict


def test_growing_differences_are_told_from_sudden_ones(agreeing: Comparison, controller: AdaptiveController) -> None:
    x = agreeing.mujoco.touchdowns["x"] + agreeing.touchdowns["limit_x"] * [0.0, 0.6, 1.5]
    found = again(agreeing.mujoco, changed(agreeing.hybrid, x=x), controller)
    assert found.divergence is not None
    assert found.divergence.touchdown == 3
    assert "grew from step to step" in found.verdict


@pytest.mark.parametrize("which", [0, 1])
def test_one_engine_falls(which: int, agreeing: Comparison, controller: AdaptiveController) -> None:
    pair = [agreeing.mujoco, agreeing.hybrid]
    pair[which] = changed(pair[which], outcome="fell", rows=2)
    found = again(pair[0], pair[1], controller)
    assert found.divergence is not None
    assert found.divergence.touchdown == 3
    assert f"{('MuJoCo', 'the hybrid engine')[which]} fell in this step" in found.verdict
    assert "finished after 3 steps" in found.verdict


def test_distance_between_two_footholds(agreeing: Comparison, controller: AdaptiveController) -> None:
    found = again(agreeing.mujoco, changed(agreeing.hybrid, rows=2), controller)
    assert "the distance asked for ends between their footholds" in found.verdict


def test_grazing(controller: AdaptiveController) -> None:
    """A bump that MuJoCo's foot is told to have landed on, where the other foot passes 1 mm above it."""
    walked = mjbiped.compare(controller, Terrain.level(), steps=1)
    here, there = walked.hybrid, walked.mujoco
    qpos, stance = here.samples["qpos"], here.samples["stance"]
    swing = qpos[np.arange(len(qpos)), 3 - stance]
    x = qpos[:, 0] - np.sin(swing)
    z = qpos[:, 1] - np.cos(swing)
    ahead = np.flatnonzero((x > 0.2) & (x < 0.3))[0]
    bump = Terrain((0.0, x[ahead] - 0.01, x[ahead] + 0.01), (0.0, z[ahead] - 1e-3, 0.0), (0.0, 0.0, 0.0))
    ground = {"terrain": bump.to_dict()}
    there, here = (dataclasses.replace(w, settings={**w.settings, **ground}) for w in (there, here))
    early = changed(there, x=x[ahead : ahead + 1], time=here.samples["time"][ahead : ahead + 1])
    assert "grazing: MuJoCo lands" in again(early, here, controller).verdict


def test_walks_without_touchdown_or_estimate() -> None:
    start = (-0.19, 0.19, 0.3, 0.0)
    fallen = mjbiped.compare(PassiveController(), Terrain.level(), initial=start)
    assert (fallen.mujoco.outcome, fallen.hybrid.outcome) == ("fell", "fell")
    assert fallen.divergence is None
    assert fallen.verdict == "The engines agree: fell in both, without a touchdown."
    assert math.isnan(fallen.mujoco.cost_of_transport)
    plot_comparison(fallen)


@pytest.mark.parametrize(
    "bad", [{"mujoco": "fast"}, {"hybrid": mjbiped.Mujoco()}, {"steps": 0}, {"initial": "jump"}, {"sample_period": 0.0}]
)
def test_bad_input_is_refused_before_anything_is_computed(
    bad: dict[str, Any], controller: AdaptiveController, monkeypatch: pytest.MonkeyPatch
) -> None:
    def simulate(*_: object, **__: object) -> None:
        raise AssertionError("a walk was computed")

    monkeypatch.setattr(Run, "go", simulate)
    with pytest.raises(mjbiped.InputError, match=next(iter(bad)).split("_")[0]):
        mjbiped.compare(controller, Terrain.level(), **bad)


def test_figure(agreeing: Comparison, controller: AdaptiveController, tmp_path: Path) -> None:
    figure = plot_comparison(agreeing, tmp_path / "compare.png")
    assert (tmp_path / "compare.png").stat().st_size > 10_000
    axes = figure.get_axes()
    assert len(axes) == 7
    assert all("(" in panel.get_ylabel() for panel in axes)  # a unit
    drawn = [line.get_ydata() for line in axes[0].lines]
    assert np.array_equal(drawn[0], agreeing.mujoco.samples["torque"][:, 0])
    assert np.array_equal(drawn[1], agreeing.hybrid.samples["torque"][:, 0])
    assert axes[4].lines[0].get_ydata() == pytest.approx(  # steps on a slope: mm of the way along it
        1e3 * (measures.step_lengths(agreeing.mujoco) - measures.step_lengths(agreeing.hybrid))
    )
    assert "they part" not in {text.get_text() for text in axes[0].texts}
    x = agreeing.hybrid.touchdowns["x"] + [0.0, 0.0, 0.02]
    parted = plot_comparison(again(agreeing.mujoco, changed(agreeing.hybrid, x=x), controller))
    assert "they part" in {text.get_text() for text in parted.get_axes()[0].texts}
    with pytest.raises(mjbiped.InputError, match="png"):
        plot_comparison(agreeing, tmp_path / "compare.gif")


def test_figure_of_a_fall(agreeing: Comparison, controller: AdaptiveController) -> None:
    """What a falling robot asks for at last does not flatten the steps before, and is told."""
    ends = agreeing.mujoco.touchdowns["time"]
    pair = []
    for walk in (agreeing.mujoco, agreeing.hybrid):
        torque = walk.samples["torque"].copy()
        torque[walk.samples["time"] > ends[1] + 0.5, 0] = -300.0
        fallen = dataclasses.replace(changed(walk, outcome="fell", rows=2), peak_torque=np.array([300.0, 1.0]))
        pair.append(dataclasses.replace(fallen, samples={**walk.samples, "torque": torque}))
    both = again(pair[0], pair[1], controller)
    ankle, hip, difference, lengths, *_ = plot_comparison(both).get_axes()
    steady = both.mujoco.samples["torque"][both.mujoco.samples["time"] <= ends[1]]
    low, high = ankle.get_ylim()
    assert low < steady[:, 0].min() < steady[:, 0].max() < high < 10.0
    assert low > -10.0
    assert "unfinished step: ankle to 300" in ankle.get_title("center")
    assert {text.get_text() for text in hip.texts} == {"both fell"}
    for axes in (ankle, hip, difference):
        assert [line.get_xdata()[0] for line in axes.lines[-2:]] == [walk.end[0] for walk in pair]  # type: ignore[index]
    low, high = lengths.get_ylim()
    assert high - low >= 0.0099 * measures.step_lengths(both.mujoco).max()
    one = plot_comparison(again(pair[0], agreeing.hybrid, controller)).get_axes()
    assert {text.get_text() for text in one[1].texts} == {"MuJoCo fell"}
    whole = plot_comparison(agreeing).get_axes()
    assert whole[0].get_title("center") == ""
    assert not whole[1].texts
