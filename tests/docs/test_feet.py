"""The prose of docs/feet.md is true of its tables."""

from __future__ import annotations

import re

import pytest
from documentation import table, text

PROSE = " ".join(text("docs/feet.md").split())


def told(sentence: str) -> list[float]:
    """The numbers that a sentence of the page tells where the pattern has groups."""
    found = re.search(sentence, PROSE)
    assert found, sentence
    return [float(number) for number in found.groups()]


def whole(law: str, sole: str) -> int:
    """How many grounds are walked from all phases."""
    (row,) = [row for row in table("feet", "laws hybrid") if row["law"] == law]
    return int(row[sole].partition(" ")[0])


def test_grounds_that_are_lost_on_a_foot() -> None:
    lost, grounds = told(r"With the ankle at a quarter of the foot they lose (\d+) of (\d+) grounds, at half of it one")
    assert [lost, grounds] == [whole("paper", "none") - whole("paper", "foot 1/4"), whole("paper", "none")]
    assert whole("paper", "none") - whole("paper", "foot 1/2") == 1
    kept = told(r"On ±5 cm it keeps (\d+) of (\d+) grounds, the paper's controller (\d+) of (\d+)")
    assert kept == [whole(law, sole) for law in ("LCTC", "paper") for sole in ("±5 cm", "none")]
    kept = told(r"Of (\d+) grounds the reference of 8 cm keeps (\d+) with the ankle at a third")
    assert kept == [whole("knees, 8 cm", sole) for sole in ("none", "foot 1/3")]


def test_treads_of_stairs() -> None:
    rows = {(row["sole"], row["law"], row["riser"]): row for row in table("feet", "stairs by tread hybrid")}
    climbed = rows["±12 cm", "supervised", "+4 cm"]
    assert {name: cell for name, cell in climbed.items() if "of 8" in cell and cell != "8 of 8"} == {
        f"tread {tread} m": f"{count:.0f} of 8"
        for tread, count in zip((0.6, 0.8), told(r"\((\d) and (\d) of 8 walks\)"), strict=True)
    }
    assert all(cell == "0 of 8" for tread, cell in rows["±8 cm", "supervised", "+6 cm"].items() if "tread" in tread)
    high = rows["±12 cm", "supervised", "+6 cm"]
    assert [high[f"tread {tread} m"] == "0 of 8" for tread in (0.45, 0.6, 0.8, 1, 1.2, 1.5)] == [True] * 4 + [False] * 2
    drawn = {
        (row["sole"], row["riser"]): [*row.values()][2:] for row in table("feet", "stairs by random treads hybrid")
    }
    counts = told(
        r"(\d+) of 16 walks come through with treads of 0.45 to 0.8 m, (\d+) of 16 .*? m, and (\d+) of 16 with"
    )
    assert counts == [float(cell.partition(" ")[0]) for cell in drawn["±12 cm", "+4 cm"][:3]]
    assert drawn["±12 cm", "+4 cm"][2:] == ["16 of 16 (16)"] * 2
    short = {rows["±8 cm", "supervised", riser]["tread 0.45 m"] for riser in ("−4 cm", "−6 cm")}
    assert short <= {"0 of 8", "1 of 8"}
    assert all(cell.endswith("(16)") for cell in drawn["±12 cm", "+6 cm"][2:])
    for sole in ("±12 cm", "±8 cm"):
        assert {*drawn[sole, "−4 cm"], *drawn[sole, "−6 cm"]} == {"16 of 16 (16)"}


def test_losses_of_the_search() -> None:
    begun, chosen = (
        [float(row[grounds]) for grounds in ("training grounds", "other grounds")]
        for row in table("feet", "searched hybrid")
    )
    losses = told(r"the cost of the others, is ([\d.]+) and ([\d.]+); on other grounds it is ([\d.]+) and ([\d.]+)\.")
    assert losses == [chosen[0], begun[0], chosen[1], begun[1]]


def test_thresholds_and_recovery_alone() -> None:
    rows = {(row["sole"], row["recovers by"]): row for row in table("feet", "thresholds hybrid")}
    soles = ("±12 cm", "±8 cm")
    best = told(r"The best thresholds on the training grounds, ([\d.]+) and ([\d.]+), lose")
    for sole, threshold in zip(soles, best, strict=True):
        shares = {by: float(row["training, %"]) for (on, by), row in rows.items() if on == sole and by[0] == "0"}
        assert max(shares, key=shares.__getitem__) == f"{threshold:g}"
    lost = told(r"lose (\d+) and (\d+) % of the walks on 2 cm treads, the simulation (\d+) and (\d+) %")
    by = [*(f"{threshold:g}" for threshold in best), "simulation", "simulation"]
    expected = [100.0 - float(rows[key]["treads of 2 cm, %"].split()[0]) for key in zip(soles * 2, by, strict=True)]
    assert lost == pytest.approx(expected, abs=0.5)  # halves are rounded either way
    assert "walks eight grounds, and level ground at three times the cost" in PROSE
    for sole in soles:
        assert rows[sole, "every step"]["grounds of 22"] == "8"
        ratio = float(rows[sole, "every step"]["level cost"]) / float(rows[sole, "simulation"]["level cost"])
        assert ratio == pytest.approx(3.0, abs=0.2)


def test_what_a_wrong_model_costs() -> None:
    assert "A wrong model** costs nothing on ±12 cm, and one walk in fifty on ±8 cm" in PROSE
    rows = {row["sole"]: row for row in table("feet", "wrong hybrid") if row["law"] == "supervised"}
    shares = [float(rows[sole]["wrong model, %"].split()[0]) for sole in ("±12 cm", "±8 cm")]
    assert shares == pytest.approx([100.0, 98.0], abs=0.5)
