"""The reproduction: its grounds, what is measured of its walks, the reading that fits, its figures, and kept walks."""

import dataclasses
import math
from itertools import product
from pathlib import Path
from typing import Any

import golden_numbers
import numpy as np
import pytest
from golden_states import numbers_in
from reproduction_rows import changed, made_row

import mjbiped
from controllers import AdaptiveController
from mjbiped.records.measures import cost_of_transport
from mjbiped.studies.cell import Cell
from mjbiped.studies.reproduction import cell as cells
from mjbiped.studies.reproduction import section_5 as paper
from mjbiped.studies.reproduction.reproduce import walked
from mjbiped.studies.reproduction.results import Results, Row

DOWN = mjbiped.Terrain.stairs(rise=-0.02)
LAW = paper.adaptive(0.8)
GROUND = mjbiped.Terrain.from_segments([(1.0, 0.0, 0.0), (3.0, 2.0, -0.02)])


# grounds, against profiles written down from the paper's sentence


STAIRS = {
    "descending": [0, -1, -2, -3], "ascending": [0, 1, 2, 3],
    "alternating, down first": [0, -1, 0, -1], "alternating, up first": [0, 1, 0, 1],
}  # fmt: skip
"""Heights of the first treads, of 6 cm."""
SLOPES: dict[str, list[float]] = {
    "accumulating downhill": [0, 1, 2, 3], "accumulating uphill": [0, -1, -2, -3],
    "level and downhill in turn": [0, 1, 0, 1], "level and uphill in turn": [0, -1, 0, -1],
    "down and up in turn, ±Δ": [1, -1, 1, -1], "up and down in turn, ±Δ": [-1, 1, -1, 1],
    "down and up in turn, ±Δ/2": [0.5, -0.5, 0.5, -0.5], "up and down in turn, ±Δ/2": [-0.5, 0.5, -0.5, 0.5],
}  # fmt: skip
"""Slopes of the first segments, by the change from one to the next."""


@pytest.mark.parametrize("first", [0.9, 1.5])
@pytest.mark.parametrize(
    ("ground", "pattern"), [*product(["stair 2"], STAIRS), *product(["slope 1", "slope 2"], SLOPES)]
)
def test_grounds(ground: str, pattern: str, first: float) -> None:
    """Treads of 1.8 m, segments of 1.5 m along the ground."""
    if ground == "stair 2":
        rows = [(1.8, 0.0, rise) for rise in 0.06 * np.diff(STAIRS[pattern], prepend=0)]
    else:
        rows = [(1.5, {"slope 1": 0.3, "slope 2": 1.0}[ground] * factor, 0.0) for factor in SLOPES[pattern]]
    expected = mjbiped.Terrain.from_segments([(first, *rows[0][1:]), *rows[1:]])
    places = np.arange(0.01, first + 4.4, 0.05)
    terrain = paper.terrain_of(paper.Place(ground, pattern, first))
    np.testing.assert_allclose(terrain.height(places), expected.height(places), atol=1e-12)


# one walk


def test_every_input_has_its_key(monkeypatch: pytest.MonkeyPatch) -> None:
    usual: dict[str, Any] = {"terrain": DOWN, "law": LAW, "engine": "hybrid", "steps": 7}
    changes: list[dict[str, Any]] = [
        *({}, {"engine": "mujoco"}, {"law": paper.adaptive(0.8, adaptation_gain=0.4)}, {"steps": 8}),
        *({"terrain": mjbiped.Terrain.stairs(rise=-0.021)}, {"initial": "rest"}, {"record": True}),
        {"distance": 3.0},
    ]
    made = [cells.cell(**{**usual, **change}) for change in changes]
    keys = [*map(cells.key, made)]
    assert len(set(keys)) == len(keys)
    assert cells.key(dataclasses.replace(made[0])) == keys[0]
    monkeypatch.setattr(cells, "machinery", lambda: {"sources": "mended"})
    assert cells.key(made[0]) != keys[0]


def test_one_walk_gives_the_cost_of_every_shorter_one() -> None:
    cell = cells.cell(DOWN, LAW, steps=7, engine="hybrid")
    whole = cell.walk()
    for length in (1, 4, 7):
        shorter = mjbiped.walk(cell.controller(), DOWN, engine="hybrid", steps=length)
        for kind in ("absolute", "net", "positive"):  # the same numbers of the same steps: bit by bit
            assert cells.cost_after(whole, kind, length) == cost_of_transport(shorter, kind)
    found = cells.measures_of(whole)
    assert (found["steps"], found["place"]) == (whole.steps, whole.end[1])
    assert [found["ankle"], found["hip"]] == whole.peak_torque.tolist()
    assert math.isnan(cells.cost_after(whole, "absolute", 8))
    assert math.isnan(found["absolute_20"])
    assert (found["steps"], found["absolute_end"]) == (7, cells.cost_after(whole, "absolute"))
    golden_numbers.check("a walk downhill", {"all": numbers_in(found)})
    assert found["least_force"] == shorter.touchdowns["normal_force"].min() / (10.0 * 9.81)


# traces, on records whose numbers are put in by hand, and on walks whose truth is known


def walk_of(controller: AdaptiveController) -> mjbiped.Walk:
    return mjbiped.walk(controller, GROUND, engine="hybrid", steps=7, initial="rest")


@pytest.fixture(scope="module")
def walk(controller: AdaptiveController) -> mjbiped.Walk:
    return walk_of(controller)


def test_known_model_and_slope_leave_no_error(walk: mjbiped.Walk) -> None:
    found = cells.traced(walk)
    assert set(found) == set(cells.TRACES)
    # the integration's tolerance, 1e-8, over some steps, in degrees
    assert max(found[f"trace_{name}"] for name in ("settled", "later", "error", "z1", "z2")) < 1e-5
    assert found["trace_travel"] < 1e-6 * len(walk.samples["time"])  # a sum over all samples
    assert found["trace_off_time"] == 0.0
    assert 0.0 < found["trace_straight"] < 0.2 < found["trace_bent"]  # N m
    golden_numbers.check("lines of traces", {"all": [found["trace_straight"], found["trace_bent"]]})


def test_errors_of_the_estimate_by_hand(walk: mjbiped.Walk) -> None:
    """1° until a time, then -0.05°, which is below epsilon, and once 0.5° in between."""
    time = walk.samples["time"]
    on_other_ground = walk.touchdowns["time"][walk.touchdowns["x"] > 1.0][0]
    early, late = time < 1.0, int(np.searchsorted(time, on_other_ground + 0.2))
    error = np.where(early, 1.0, -0.05)
    error[late] = 0.5
    samples = {**walk.samples, "slope_estimate": walk.samples["slope"] + np.radians(error)}
    found = cells.traced(dataclasses.replace(walk, samples=samples))
    assert math.radians(0.05) < cells.RESOLVED_SLOPE < math.radians(0.5)
    wanted = {
        "off_time": np.diff(time)[: early.sum()].sum() + time[late + 1] - time[late],
        "settled": 0.05,
        "later": 0.5,
        "travel": 1.05 + 2 * 0.55,
        "error": math.sqrt(np.diff(time) @ error[:-1] ** 2 / (time[-1] - time[0])),
    }
    assert {name: found[f"trace_{name}"] for name in wanted} == pytest.approx(wanted, rel=1e-9)


def test_tracking_errors_are_those_at_the_touchdowns(controller: AdaptiveController) -> None:
    """Without re-planning a step begins as far off the gait as the touchdown left it."""
    walk = walk_of(dataclasses.replace(controller, replanning_delay=None))
    found, start = cells.traced(walk), controller.gait.start
    z1 = start[:2] - walk.touchdowns["q"][:-1]
    z2 = start[2:] - walk.touchdowns["dq"][:-1] + controller.position_gain * z1
    # from rest both legs are upright; the first sample is up to 5 ms later
    assert found["trace_z1"] >= 0.95 * math.degrees(max(np.abs(z1).max(), np.abs(start[:2]).max()))
    # by (9), d/dt z1 = z2 - K1 z1
    assert found["trace_z1"] <= math.degrees(found["trace_z2"] / controller.position_gain)
    assert found["trace_z2"] >= np.abs(z2).max() * 0.9
    golden_numbers.check("traces of a walk", {"all": [found[name] for name in sorted(found)]})
    assert not {"trace_straight", "trace_bent"} & set(found)  # which steps follow the gait, no plan says


# the reading of Table II, on tables whose answer is known

PAPER = paper.TABLE_2["adaptive"]


def read(ground: str, pattern: str, first: float, factor: float, delay: float | None = 0.8, **others: object) -> Row:
    """A walk whose c_mt is the paper's times a factor, of whatever kind and length."""
    return made_row(factor * PAPER[ground], ground=ground, pattern=pattern, first=first, delay=delay, **others)


@pytest.fixture
def rows() -> list[Row]:
    factors = {
        ("stair", "down"): (1.1, 1.1), ("stair", "up"): (1.3, 1.3),
        ("slope", "down"): (1.02, 1 / 1.02), ("slope", "up"): (0.9, 1.0),
    }  # fmt: skip
    return [
        read(f"{kind} {k + 1}", pattern, 0.9, pair[k], delay=delay)
        for (kind, pattern), pair in factors.items()
        for k in range(2)
        for delay in (0.8, None)
    ]


def test_nearest_choice_and_its_distance(rows: list[Row]) -> None:
    found = Results(rows).readings
    assert len(found) == 2 * 3 * len(cells.LENGTHS) * 2 * 2
    best = found[0]
    assert (best.stairs, best.slopes) == (("down", 0.9), ("down", 0.9))
    assert best.distance == pytest.approx(math.sqrt((2 * math.log(1.1) ** 2 + 2 * math.log(1.02) ** 2) / 4), rel=1e-12)
    assert [choice.distance for choice in found] == sorted(choice.distance for choice in found)
    assert (best.places[0], {ground for ground, *_ in best.places}) == (("level", "", 0.0), set(paper.GROUNDS))
    better = [changed(r, net_45=PAPER[r.ground]) if r.pattern == "up" and r.delay is None else r for r in rows]
    best = Results(better).best
    assert (best.kind, best.length, best.stairs[0], best.slopes[0], best.distance) == ("net", 45, "up", "up", 0.0)
    assert best.delay is None


# kept walks


def results(folder: Path, planned: list[Cell], workers: int = 1, *, fresh: bool = False) -> list[dict[str, object]]:
    return [vars(each) for each in walked(planned, folder, fresh=fresh, workers=workers)]


@pytest.mark.usefixtures("studies_in_threads")
def test_what_has_ended_is_not_walked_again(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """But for failed walks, and for those whose record is lost."""
    grounds = [mjbiped.Terrain.stairs(rise=-0.01), mjbiped.Terrain.incline(-3.0), mjbiped.Terrain.level()]
    laws = [LAW, {"controller.name": "passive"}, LAW]
    pairs = zip(grounds, laws, strict=True)
    planned = [cells.cell(ground, law, steps=2, engine="hybrid", record=law is LAW) for ground, law in pairs]
    begun: list[Cell] = []
    real = cells.row

    def counting(cell: Cell, folder: Path) -> dict[str, object]:
        begun.append(cell)
        if len(begun) == 3:
            raise KeyboardInterrupt
        return real(cell, folder)

    monkeypatch.setattr(cells, "row", counting)
    with pytest.raises(KeyboardInterrupt):
        results(tmp_path, [*planned, planned[0]])
    found = results(tmp_path, planned)
    assert begun == [*planned, *planned[1:]]  # the third was broken off, and the second had failed
    assert [each["outcome"] for each in found] == ["finished", "failed", "finished"]
    kept = [cells.record_path(tmp_path, planned[k]) for k in (0, 2)]
    kept[0].unlink()
    assert repr(results(tmp_path, planned)) == repr(found)
    assert begun[5:] == planned[:2]
    assert len(mjbiped.Walk.load(kept[0]).samples["time"]) > 200  # every 5 ms of 1.5 s
    results(tmp_path, [], fresh=True)
    assert not any(path.exists() for path in kept)
