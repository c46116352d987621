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
from mjbiped import Terrain, Walk, plot_comparison
from mjbiped.analysis import divergence
from mjbiped.analysis.compare import Comparison, torque_differences
from mjbiped.analysis.divergence import COLUMNS
from mjbiped.cli.results import as_json
from mjbiped.control.registry import make_controller
from mjbiped.records import measures


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


def test_agreement_and_measures_are_those_of_the_records(agreeing: Comparison) -> None:
    there, here = agreeing.mujoco, agreeing.hybrid
    assert [walk.settings["engine"] for walk in (there, here)] == ["mujoco", "hybrid"]
    assert agreeing.divergence is None
    assert agreeing.verdict.startswith("The engines agree at all 3 touchdowns")
    for name in COLUMNS:
        assert (np.abs(agreeing.touchdowns[name]) <= agreeing.touchdowns[f"limit_{name}"]).all(), name
    np.testing.assert_array_equal(agreeing.touchdowns["x"], there.touchdowns["x"] - here.touchdowns["x"])
    table = agreeing.measures()
    for engine, walk in (("mujoco", there), ("hybrid", here)):
        assert {name: row[engine] for name, row in table.items()} == measures.summary(walk)
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


@pytest.mark.slow
@pytest.mark.parametrize(
    ("terrain", "replanning", "steps", "where", "causes"),
    [
        (Terrain.stairs(rise=0.045, first=1.0, count=1), 0.8, 3, 3, ["a riser (in MuJoCo and the hybrid engine)"]),
        (Terrain.stairs(rise=-0.06), None, 4, 4, ["the motion asks for |Ft/Fn| = 2.0", "the stance foot slid by 14.9"]),
        # the second footholds are within 0.001 mm of the edge of the step down, on either side of it
        (Terrain.from_segments([(0.7557675, 0.0), (5.0, 0.0, -0.06)]), 0.8, 2, 2, ["an edge: touchdown 2"]),
    ],
)
def test_named_causes(
    terrain: Terrain, replanning: float, steps: int, where: int, causes: list[str], controller: AdaptiveController
) -> None:
    walked = mjbiped.compare(dataclasses.replace(controller, replanning_delay=replanning), terrain, steps=steps)
    assert walked.divergence is not None
    assert walked.divergence.touchdown == where
    assert all(cause in "; ".join(walked.divergence.causes) for cause in causes)
    assert all(cause in walked.verdict for cause in causes)


def test_walks_without_touchdown() -> None:
    fallen = mjbiped.compare(PassiveController(), Terrain.level(), initial=(-0.19, 0.19, 0.3, 0.0))
    assert fallen.divergence is None
    assert fallen.verdict == "The engines agree: fell in both, without a touchdown."
    assert math.isnan(fallen.mujoco.cost_of_transport)
    plot_comparison(fallen)


def test_a_foot_that_turns() -> None:
    """In MuJoCo torsional friction has a bound."""
    law = make_controller("adaptive", mjbiped.Compass3D(), {})
    walked = mjbiped.compare(law, Terrain.level(), steps=1)
    assert walked.divergence is None
    rows = walked.mujoco.touchdowns
    yaw = np.arange(rows["qpos"].shape[1]) == mjbiped.Compass3D.places.index("yaw")
    turned = changed(walked.mujoco, qpos=rows["qpos"] + math.radians(0.2) * yaw, x=rows["x"] + 0.01)
    assert "twist: the stance foot turned by 0.2 deg in MuJoCo" in again(turned, walked.hybrid, law).verdict


def test_differences_and_their_causes(agreeing: Comparison, controller: AdaptiveController) -> None:
    """Of records changed by hand: the touchdown, the differences that are told, and the causes that are named."""
    there, here = agreeing.mujoco, agreeing.hybrid
    rows, strikes = here.touchdowns, np.array([0, 1, 0])
    row = int(np.argmax(np.abs(rows["slope_estimate"] - rows["slope_estimate_before"])))
    uncorrected = rows["slope_estimate"].copy()
    uncorrected[row] = rows["slope_estimate_before"][row]
    growing = there.touchdowns["x"] + agreeing.touchdowns["limit_x"] * [0.0, 0.6, 1.5]
    fell = [changed(walk, outcome="fell", rows=2) for walk in (there, here)]
    alone = "a face impact in the hybrid engine alone"
    for one, other, touchdown, told, cause in (
        (there, changed(here, strikes=strikes), 2, alone, "struck a riser (in the hybrid engine)"),
        (there, changed(here, slope_estimate=uncorrected), row + 1, "slope", "corrects its slope estimate"),
        (there, changed(here, x=rows["x"] + [0.0, 0.0, 0.01]), 3, "x -10 mm", ""),
        (there, changed(here, x=growing), 3, "x", "grew from step to step (foothold: 60 % of the limit"),
        (fell[0], here, 3, "finished after 3 steps in the hybrid engine", "MuJoCo fell in this step"),
        (there, fell[1], 3, "fell after 2 steps in the hybrid engine", "the hybrid engine fell in this step"),
        (there, changed(here, rows=2), 3, "finished after 2", "the distance asked for ends between their footholds"),
    ):
        found = again(one, other, controller).divergence
        assert found is not None
        assert found.touchdown == touchdown
        assert any(told in each for each in found.differences)
        assert any(cause in each for each in found.causes) if cause else not found.causes
        assert str(found).endswith(f"{'; '.join(found.causes)}." if cause else "No cause was found.")
    # the record of one engine says whether the foot struck, that of the other how often
    assert again(changed(there, strikes=strikes), changed(here, strikes=3 * strikes), controller).divergence is None


def test_figure(agreeing: Comparison, controller: AdaptiveController, tmp_path: Path) -> None:
    """What a falling robot asks for at last does not flatten the steps before, and is told."""
    figure = plot_comparison(agreeing, tmp_path / "compare.png")
    assert (tmp_path / "compare.png").stat().st_size > 10_000
    assert np.array_equal(figure.get_axes()[0].lines[1].get_ydata(), agreeing.hybrid.samples["torque"][:, 0])
    ends, pair = agreeing.mujoco.touchdowns["time"], []
    for walk in (agreeing.mujoco, agreeing.hybrid):
        torque = walk.samples["torque"].copy()
        torque[walk.samples["time"] > ends[1] + 0.5, 0] = -300.0
        fallen = dataclasses.replace(changed(walk, outcome="fell", rows=2), peak_torque=np.array([300.0, 1.0]))
        pair.append(dataclasses.replace(fallen, samples={**walk.samples, "torque": torque}))
    ankle = plot_comparison(again(pair[0], pair[1], controller)).get_axes()[0]
    steady = pair[0].samples["torque"][pair[0].samples["time"] <= ends[1]]
    low, high = ankle.get_ylim()
    assert -10.0 < low < steady[:, 0].min() < steady[:, 0].max() < high < 10.0
    assert "unfinished step: ankle to 300" in ankle.get_title("center")
