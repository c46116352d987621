"""The prose on soles and feet is true of the tables."""

from __future__ import annotations

import math
import re

import pytest
from documentation import table, text

from mjbiped.engines.mujoco.feet import PLAUSIBLE

PROSE = " ".join(word for page in ("feet", "tables/feet", "tables/footed") for word in text(f"docs/{page}.md").split())
LAWS = table("feet", "laws hybrid")
FOOTED = table("footed", "feet with mass")
LANDED = table("footed", "touchdowns of feet")


def told(sentence: str) -> list[float]:
    """The numbers that a sentence tells where the pattern has groups."""
    found = re.search(sentence, PROSE)
    assert found, sentence
    return [float(number) for number in found.groups()]


def first(cell: str) -> float:
    """The number with which a cell begins."""
    return float(cell.partition(" ")[0])


def test_grounds_that_are_lost_on_a_foot() -> None:
    whole = {row["law"]: {sole: first(cell) for sole, cell in row.items() if sole != "law"} for row in LAWS}
    paper = whole["paper"]
    walked = told(
        r"Of (\d+) kinds of ground .* succeeds on (\d+) without a foot.* fails on (\d+) of these (\d+) grounds, with "
        r"the ankle at half the length on one"
    )
    assert walked == [22, paper["none"], paper["none"] - paper["foot 1/4"], paper["none"]]
    assert paper["none"] - paper["foot 1/2"] == 1
    kept = told(r"on ±5 cm it keeps (\d+) of (\d+) grounds, the paper's controller (\d+) of (\d+)")
    assert kept == [whole[law][sole] for law in ("LCTC", "paper") for sole in ("±5 cm", "none")]
    kept = told(r"of (\d+) grounds the reference of 8 cm keeps (\d+) with the ankle at a third")
    assert kept == [whole["knees, 8 cm"][sole] for sole in ("none", "foot 1/3")]


def test_looking_ahead_on_random_treads() -> None:
    shares = {row["law"]: first(row["2 cm"]) for row in table("feet", "random hybrid") if row["sole"] == "±8 cm"}
    assert told(r"([\d.]+) % of the walks with the paper's controller succeed, and ([\d.]+) % with") == [
        shares["paper"],
        shares["supervised"],
    ]


def test_treads_of_stairs() -> None:
    rows = {(row["sole"], row["riser"]): row for row in table("feet", "stairs by random treads hybrid")}
    counts = [first(cell) for treads, cell in rows["±12 cm", "+4 cm"].items() if "treads" in treads]
    assert [
        *told(r"(\d+) of 16 walks succeed on stairs .* and all (\d+) where treads are longer than 1.2 m"),
        16.0,
    ] == [
        counts[0],
        *counts[2:],
    ]


def test_how_the_supervised_law_was_chosen() -> None:
    rows = {(row["sole"], row["recovers by"]): row for row in table("feet", "thresholds hybrid")}
    soles = ("±12 cm", "±8 cm")
    best = told(r"The best thresholds on the training grounds, ([\d.]+) and ([\d.]+), lose")
    for sole, threshold in zip(soles, best, strict=True):
        shares = {by: float(row["training, %"]) for (on, by), row in rows.items() if on == sole and by[0] == "0"}
        assert max(shares, key=shares.__getitem__) == f"{threshold:g}"
    lost = told(r"lose (\d+) and (\d+) % of the walks on 2 cm treads, the simulation (\d+) and (\d+) %")
    by = [*(f"{threshold:g}" for threshold in best), "simulation", "simulation"]
    expected = [100.0 - first(rows[key]["treads of 2 cm, %"]) for key in zip(soles * 2, by, strict=True)]
    assert lost == pytest.approx(expected, abs=0.5)  # halves are rounded either way


def test_what_a_wrong_model_costs() -> None:
    assert "With a wrong model one walk in fifty fails on soles of ±8 cm, and none on ±12 cm" in PROSE
    rows = {row["sole"]: row for row in table("feet", "wrong hybrid") if row["law"] == "supervised"}
    assert [first(rows[sole]["wrong model, %"]) for sole in ("±12 cm", "±8 cm")] == pytest.approx([100, 98], abs=0.5)


def footed(sole: str, foot: str) -> dict[str, dict[str, str]]:
    """The rows of a foot with mass by their grounds."""
    return {row["ground"]: row for row in FOOTED if row["sole"] == sole and row["foot"].startswith(foot)}


def test_what_survives_is_the_sum_over_the_grounds() -> None:
    sums = table("footed", "survives")
    assert len(sums) == 6
    for row in sums:
        grounds = footed(row["sole"], row["foot"])
        assert (row["make all steps"], row["through"]) == (grounds["all"]["all steps"], grounds["all"]["through"])
        unseen = grounds["all, unseen phases"]
        assert (row["unseen: all steps"], row["unseen: through"]) == (unseen["all steps"], unseen["through"])
        counts = [int(first(each["all steps"])) for each in grounds.values() if each["c_mt"]]
        assert f"{sum(counts)} of {3 * len(counts)}" == row["make all steps"]


def test_what_is_said_of_pads_and_boxes() -> None:
    pads, box = footed("±12 cm", "pads"), footed("±12 cm", "box")
    assert pads["all"]["all steps"] == "39 of 39"
    assert f"{box['all']['all steps']} walks finish" in PROSE
    assert told(r"Of (\d+) walks from phases .* used, (\d+) finish") == [
        float(number) for number in reversed(box["all, unseen phases"]["all steps"].split(" of "))
    ]
    (slid,) = told(r"the landing foot on pads of ±12 cm slides by up to ([\d.]+) mm")
    assert slid == round(max(float(pads[f"stairs −{rise} cm"]["slid, mm"]) for rise in (4, 6)), 1)
    assert {pads[f"stairs −{rise} cm"]["through"] for rise in (4, 6)} == {"0 of 3"}
    assert footed("±8 cm", "pads")["stairs +4 cm"]["all steps"] == "0 of 3"
    assert all(float(row["impact map, %"]) < 0.1 for row in FOOTED if row["impact map, %"] not in ("", "–"))
    assert f"more than {math.degrees(PLAUSIBLE):.1f}°" in PROSE


def test_what_is_said_of_touchdowns() -> None:
    slaps = [
        row["slap where the slope changes, ms"].split(" to ") for row in LANDED if row["ground"] in ("3° up", "3° down")
    ]
    least, most = (choose(each, key=float) for choose, each in zip((min, max), zip(*slaps, strict=True), strict=True))
    assert f"slaps for {least} to {most} ms on a change of 3°" in PROSE
    alternating = [row for row in LANDED if row["ground"] == "changes of ±3°"]
    assert {(row["all steps"], row["through"], row["friction"]) for row in alternating} == {
        ("3 of 3", "0 of 3", "0.80")
    }
    mild = ("level", "3° up", "3° down")
    quantiles: dict[bool, list[float]] = {True: [], False: []}
    for row in LANDED:
        quantiles[row["ground"] in mild].append(float(row["quantile of 95 %, %"]))
    expected = [max(quantiles[True]), min(quantiles[False]), max(quantiles[False])]
    greatest = max(float(row["greatest, %"]) for row in LANDED)
    assert told(r"95 % is ([\d.]+) % or less .*? and ([\d.]+) to ([\d.]+) % on .*? is (\d+) %") == [*expected, greatest]
