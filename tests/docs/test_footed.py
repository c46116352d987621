"""The prose of docs/footed.md is true of the tables."""

from __future__ import annotations

import math
import re

from documentation import table, text

from mjbiped.engines.mujoco.feet import PLAUSIBLE

PROSE = " ".join(text("docs/footed.md").split())
ROWS = table("footed", "feet with mass")


def rows(sole: str, foot: str) -> dict[str, dict[str, str]]:
    """The rows of a foot by their grounds."""
    return {row["ground"]: row for row in ROWS if row["sole"] == sole and row["foot"].startswith(foot)}


def share(cell: str) -> float:
    """The share that a cell of counts tells."""
    part, _, whole = cell.partition(" of ")
    return int(part) / int(whole)


def test_what_survives_is_the_sum_over_the_grounds() -> None:
    sums = {(row["sole"], row["foot"]): row for row in table("footed", "survives")}
    assert len(sums) == 6
    for (sole, foot), row in sums.items():
        grounds = rows(sole, foot)
        assert (row["make all steps"], row["through"]) == (grounds["all"]["all steps"], grounds["all"]["through"])
        unseen = grounds["all, unseen phases"]
        assert (row["unseen: all steps"], row["unseen: through"]) == (unseen["all steps"], unseen["through"])
        counts = [int(each["all steps"].partition(" ")[0]) for each in grounds.values() if each["c_mt"]]
        assert f"{sum(counts)} of {3 * len(counts)}" == row["make all steps"]


def test_what_is_said_of_pads_and_boxes() -> None:
    pads = rows("±12 cm", "pads")
    assert pads["all"]["all steps"] == "39 of 39"
    slid = re.search(r"the landing foot slides by up to ([\d.]+) mm", PROSE)
    assert slid
    assert float(slid[1]) == round(max(float(pads[f"stairs −{rise} cm"]["slid, mm"]) for rise in (4, 6)), 1)
    assert {pads[f"stairs −{rise} cm"]["through"] for rise in (4, 6)} == {"0 of 3"}
    assert rows("±8 cm", "pads")["stairs +4 cm"]["all steps"] == "0 of 3"
    box = rows("±12 cm", "box")
    assert {box[ground]["all steps"] for ground in ("level", "3° up", "5° up", "3° down", "5° down")} == {"3 of 3"}
    sums = {(row["sole"], row["foot"]): row for row in table("footed", "survives")}
    lost = sums.pop(("±12 cm", "box, MuJoCo"))
    assert f"on {lost['unseen: all steps']} walks, where it did on {lost['make all steps']}." in PROSE
    for row in sums.values():
        assert abs(share(row["unseen: all steps"]) - share(row["make all steps"])) < 0.04
    assert all(float(row["impact map, %"]) < 0.1 for row in ROWS if row["impact map, %"] not in ("", "–"))
    assert "differ from those of the impact map by less than 0.1 % in the median on the thirteen grounds" in PROSE
    assert f"more than {math.degrees(PLAUSIBLE):.1f}°" in PROSE


def test_what_is_said_of_touchdowns() -> None:
    landed = table("footed", "touchdowns of feet")
    slaps = [
        row["slap where the slope changes, ms"].split(" to ") for row in landed if row["ground"] in ("3° up", "3° down")
    ]
    least, most = (choose(each, key=float) for choose, each in zip((min, max), zip(*slaps, strict=True), strict=True))
    assert f"slaps for {least} to {most} ms on a change of 3°" in PROSE
    alternating = [row for row in landed if row["ground"] == "changes of ±3°"]
    assert [row["all steps"] for row in alternating] == ["3 of 3", "3 of 3"]
    assert {(row["through"], row["friction"]) for row in alternating} == {("0 of 3", "0.80")}
    quantiles: dict[str, list[float]] = {row["ground"]: [] for row in landed}
    for row in landed:
        quantiles[row["ground"]].append(float(row["quantile of 95 %, %"]))
    mild = ("level", "3° up", "3° down")
    found = re.search(
        r"the quantile of 95 % is ([\d.]+) % or less .*? and ([\d.]+) to ([\d.]+) % on .*? is (\d+) %", PROSE
    )
    assert found
    rough = [value for ground, values in quantiles.items() if ground not in mild for value in values]
    greatest = max(float(row["greatest, %"]) for row in landed)
    expected = [max(max(quantiles[ground]) for ground in mild), min(rough), max(rough), greatest]
    assert [float(number) for number in found.groups()] == expected
