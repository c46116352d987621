"""The fits to Table II: the gains that are tried, how one is chosen, and what is stored for the page."""

from __future__ import annotations

import math
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from documentation import table
from reproduction_rows import read_grounds

import mjbiped
from mjbiped.studies.reproduction import cell as cells
from mjbiped.studies.reproduction.cell import cell, measures_of
from mjbiped.studies.reproduction.reproduce import GAINS_TABLE, GROUNDS_TABLE, SEARCHED, TABLE, on_table_2
from mjbiped.studies.reproduction.results import Choice, Results, read_rows
from mjbiped.studies.reproduction.section_5 import (
    BLIND,
    BLIND_SOURCE,
    FITTED,
    GROUNDS,
    SETTLED,
    SLOPE_SOURCES,
    START_ERROR,
    TABLE_2,
    Variant,
    gains_told,
    settled,
)
from mjbiped.studies.reproduction.tables import stored_fits
from mjbiped.terrain.terrain import Terrain
from scripts.paper import gain_scan
from scripts.paper.fits import sections
from scripts.paper.gain_scan import Tried, fitted, ranked, read_tried, settings, write_tried
from scripts.paper.gain_search import blind_trials, choose

GAIT = mjbiped.find_passive_gait(mjbiped.Compass(), math.radians(2))
DOCS = Path(__file__).parents[3] / "docs"
STORED = DOCS.parent / "mjbiped" / "studies" / "reproduction" / "fits"
SHORT = Choice(0.6, "absolute", 3, ("descending", 0.9), ("down and up in turn, ±Δ/2", 1.5), 0.0)
SOME = [
    Variant("PBC", slope_source="none", gains=(("gain", 25.0),)),
    Variant("PBC", slope_source="local", gains=(("gain", 5.0),)),
    Variant("KETC", slope_source="two_point", gains=(("gain", 20.0), ("hip_weight", 0.0))),
]


@pytest.fixture(scope="module")
def tried() -> list[Tried]:
    return read_tried((DOCS / GAINS_TABLE).read_text(encoding="utf-8"))


def made_up(source: str, costs: dict[str, float], method: str = "PBC", gain: float = 1.0) -> Tried:
    ended = {ground: 4 for ground, cost in costs.items() if math.isnan(cost)}
    return Tried(Variant(method, slope_source=source, gains=(("gain", gain),)), costs, ended)


def test_every_gain_is_tried_with_every_source() -> None:
    every = settings()
    assert (
        len(set(every))
        == len(every)
        == 3 * len(gain_scan.GAINS) * (1 + len(gain_scan.RATIOS) + len(gain_scan.HIP_WEIGHTS))
    )
    assert {each.method for each in every} == set(TABLE_2) - {"adaptive"}
    for method in ("PBC", "ECC", "KETC"):
        assert {settled(method, source) for source in SLOPE_SOURCES} <= set(every), (
            "the gains that settle are among them"
        )


def test_x_where_the_papers_are_count_first_then_the_distance() -> None:
    paper = dict(TABLE_2["PBC"])
    far = {ground: 1.5 * cost for ground, cost in paper.items()}
    exact_but_walks = {**paper, "slope 2": 0.03}
    falls = dict.fromkeys(paper, math.nan)
    every = [made_up("none", exact_but_walks), made_up("local", falls), made_up("two_point", far)]
    assert [each.variant.slope_source for each in ranked(every)] == ["two_point", "none", "local"]
    first = ranked(every)[0].agreement
    assert (first.agreeing, first.asked) == (5, 5)
    assert first.distance == pytest.approx(math.log(1.5), rel=1e-12)
    assert math.isnan(every[1].agreement.distance)
    nearer = made_up("none", {ground: 1.4 * cost for ground, cost in paper.items()}, gain=2.0)
    other = made_up("none", dict.fromkeys(GROUNDS, 0.03), method="ECC")
    assert fitted([*every, other, nearer]) == {"PBC": nearer, "ECC": other}


@pytest.mark.usefixtures("studies_in_threads")
def test_scan_is_that_of_single_walks_and_repeats_itself(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    found = gain_scan.scan(SHORT, tmp_path, SOME)
    assert [each.variant for each in found] == SOME
    for each in found[:2]:
        for entry in on_table_2("fitted", "hybrid", SHORT.places, [each.variant], SHORT.length):
            walk, cost = entry.walk(), each.cost[str(entry.values["ground"])]
            if walk.outcome == "finished":
                # six digits are kept
                assert cost == pytest.approx(measures_of(walk)["absolute_end"], rel=1e-5)
            else:
                assert math.isnan(cost)
                assert each.ended[str(entry.values["ground"])] == walk.steps + 1
    text = write_tried(found)
    assert write_tried(read_tried(text)) == text
    monkeypatch.setattr(cells, "row", lambda *_, **__: pytest.fail("what was walked is walked again"))
    assert write_tried(gain_scan.scan(SHORT, tmp_path, SOME)) == text


@pytest.mark.slow
@pytest.mark.usefixtures("studies_in_threads")
def test_committed_table_is_of_the_settings_and_can_be_walked_again(tried: list[Tried], tmp_path: Path) -> None:
    """The chosen settings and a few others on the reading of the committed report."""
    assert [each.variant for each in tried] == settings()
    assert write_tried(tried) == (DOCS / GAINS_TABLE).read_text(encoding="utf-8")
    best = Results(read_rows((DOCS / TABLE).read_text(encoding="utf-8"))).best
    known = {each.variant: each for each in tried}
    subset = [*(each.variant for each in fitted(tried).values()), *settings()[::397]]
    found = gain_scan.scan(best, tmp_path, subset)
    for fresh in found:
        assert fresh.ended == known[fresh.variant].ended
        # six digits are kept; the rest is for other processors' arithmetic, which 20 steps do not magnify
        assert fresh.cost == pytest.approx(known[fresh.variant].cost, rel=2e-5, nan_ok=True)


def test_stored_results_are_those_of_the_committed_walks(tried: list[Tried]) -> None:
    results = Results(read_rows((DOCS / TABLE).read_text(encoding="utf-8")))
    grounds = read_grounds((DOCS / GROUNDS_TABLE).read_text(encoding="utf-8"))
    assert stored_fits() == sections(results, tried, grounds)
    assert {method: each.variant for method, each in fitted(tried).items()} == FITTED
    for name in SEARCHED:
        assert (STORED / name).read_bytes() == (DOCS / name).read_bytes()


def test_fitted_walks_of_the_report_are_the_chosen_ones(tried: list[Tried]) -> None:
    results = Results(read_rows((DOCS / TABLE).read_text(encoding="utf-8")))
    best = results.best
    for method, each in fitted(tried).items():
        message = gains_told(dict(each.variant.gains))
        for engine in ("hybrid", "mujoco"):
            mine = [row for row in results.rows if (row.part, row.method, row.engine) == ("fitted", method, engine)]
            assert [row.ground for row in mine] == list(GROUNDS)
            assert all((row.gains, row.slope_source) == (message, each.variant.slope_source) for row in mine)
            if engine == "hybrid":
                costs = {row.ground: best.cost(row) for row in mine}
                assert costs == pytest.approx(each.cost, rel=2e-5, nan_ok=True)


@pytest.mark.slow
def test_prose_is_true_of_the_numbers(tried: list[Tried]) -> None:
    """The sentences of the template about Table II that no number carries."""
    results = Results(read_rows((DOCS / TABLE).read_text(encoding="utf-8")))
    best = results.best
    for engine in ("hybrid", "mujoco"):

        def cost(ground: str, method: str, gains: str = "fitted", engine: str = engine) -> float:
            settings = results.sources[0] if gains == "settled" else gains
            return best.cost(results.walks(method, settings, engine)[GROUNDS.index(ground)])

        for method in ("PBC", "ECC", "KETC"):
            assert cost("stair 1", method) > cost("level", method)
            assert cost("stair 1", method) > cost("stair 1", "adaptive")
            for gains in ("blind", "settled"):
                assert cost("stair 1", method, gains) < cost("level", method, gains)
                assert cost("stair 1", method, gains) < cost("stair 1", "adaptive")
            assert math.isfinite(cost("slope 2", method, "blind")), "all walk slope 2"
            assert math.isnan(cost("stair 2", method, "blind")), "stair 2 remains"
        assert math.isfinite(cost("stair 2", "adaptive"))
        found = results.agreement(engine, "fitted")
        assert (found.agreeing, found.asked) == (15, 15), "all cells agree in kind"
        assert found.met < found.numbers, "but not in value"
    for each in fitted(tried).values():
        if each.variant.method in ("PBC", "KETC"):
            law = cell(Terrain.level(), each.variant.law(Terrain.level()), engine="hybrid").controller()
            start = (*GAIT.start[:3], GAIT.start[3] + 0.01)
            walk = mjbiped.walk(law, Terrain.level(), engine="hybrid", steps=80, sample_period=None, initial=start)
            steps = np.diff(walk.touchdowns["x"])
            assert abs(steps[-1] - steps[-2]) > 0.01, "long and short steps in turn"
            assert steps[-1] == pytest.approx(steps[-3], abs=1e-4)


@pytest.mark.slow
def test_blind_gains_are_those_that_the_rule_finds() -> None:
    for method, variant in BLIND.items():
        assert dict(choose(blind_trials(method)).gains) == dict(variant.gains)


def test_blind_gains_are_those_of_the_page_and_owe_nothing_to_the_table() -> None:
    """One source for all of them, and not that with which they agree best."""
    found = {row["method"]: row["gains found"] for row in table("comparison", "blind")}
    assert found == {method: gains_told(dict(variant.gains)) for method, variant in BLIND.items()}
    results = Results(read_rows((DOCS / TABLE).read_text(encoding="utf-8")))
    assert {variant.slope_source for variant in BLIND.values()} == {BLIND_SOURCE}
    assert results.sources[0] != BLIND_SOURCE


def test_a_slope_told_wrong_at_the_start_is_the_ground_s_and_the_error() -> None:
    ground = Terrain.incline(2.0)
    for wrong in (0.0, START_ERROR, -START_ERROR):
        law = replace(BLIND["PBC"], start_error=wrong).law(ground)
        assert law["controller.initial_slope_estimate_deg"] == pytest.approx(2.0 + wrong, rel=1e-12)


def test_gains_that_settle_are_those_found() -> None:
    """They are pinned, for the classes' defaults are chosen for other ends."""
    assert {method: dict(variant.gains) for method, variant in SETTLED.items()} == {
        "PBC": {"gain": 5.0},
        "ECC": {"ratio": -2.3, "gain": 5.0},
        "KETC": {"gain": 6.0, "hip_weight": 1.0},
        "LCTC": {"rate_gain": 10.0, "position_gain": 25.0},
    }
