"""The prose of docs/footed.md is true of the tables."""

from __future__ import annotations

import math
import re

from documentation import table, text

from mjbiped.engines.mujoco.feet import PLAUSIBLE

PROSE = " ".join(text("docs/footed.md").split())
ROWS = table(text("docs/tables/footed.md"), "feet with mass")


def rows(sole: str, foot: str) -> dict[str, dict[str, str]]:
    """The rows of a foot by their grounds."""
    return {row["ground"]: row for row in ROWS if row["sole"] == sole and row["foot"].startswith(foot)}


def test_what_survives_is_the_sum_over_the_grounds() -> None:
    sums = {(row["sole"], row["foot"]): row for row in table(text("docs/footed.md"), "survives")}
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
    sums = {(row["sole"], row["foot"]): row for row in table(text("docs/footed.md"), "survives")}
    assert f"±12 cm, {sums['±12 cm', 'box, MuJoCo']['unseen: all steps']}" in PROSE
    assert all(float(row["impact map, %"]) < 0.1 for row in ROWS if row["impact map, %"] not in ("", "–"))
    assert f"more than {math.degrees(PLAUSIBLE):.1f}°" in PROSE
