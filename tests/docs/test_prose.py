"""Numbers in the prose of comparison.md, feet.md and stability.md are those of the tables, which studies write."""

import math
import re
from collections.abc import Callable, Iterator

import pytest
from documentation import table, text

from mjbiped.engines.mujoco.feet import PLAUSIBLE
from scripts.paper import comparison_gains as study
from scripts.paper import gain_search

PAGES = ("comparison", "feet", "tables/feet", "tables/footed", "stability", "three_dimensions")
PROSE = " ".join(word for page in PAGES for word in text(f"docs/{page}.md").split())
STAIRS, UPHILL = "stair 2, −60 mm", "slope 2, −1° each"
FEET, MADE = "feet with mass", "all steps"

Claims = Iterator[tuple[str, object]]
"""Sentences with groups where numbers stand, and the numbers by the tables."""


def column(name: str, page: str, title: str, *having: str) -> list[str]:
    """A column of a table, of the rows in which some cells stand."""
    return [row[name] for row in table(page, title) if {*having} <= {*row.values()}]


def terrain(method: str, source: str, ground: str) -> str:
    """A cell of the table of terrains, where a star marks the default source of slope."""
    (found,) = (cell for star in ("", " *") for cell in column(ground, "comparison", "terrains", method, source + star))
    return found


def first(cell: str) -> float:
    """The number with which a cell begins."""
    return float(cell.split()[0].rstrip(","))


def ends(cells: list[str]) -> list[float]:
    """The least and the greatest number of ranges, as "3.0 to 12.9"."""
    numbers = [float(number) for cell in cells for number in cell.split(" to ")]
    return [min(numbers), max(numbers)]


def steps_of(method: str, ground: str, *sources: str) -> list[int]:
    """The steps at which a method falls."""
    return [int(terrain(method, source, ground).removeprefix("✗ fell at ")) for source in sources]


def comparison() -> Claims:
    cells = terrain("limit cycle", "local", STAIRS), terrain("adaptive", "its estimate", STAIRS)
    (cost, peak), (other_cost, other_peak) = (map(float, cell.split(",")) for cell in cells)
    sentence = r"c_mt of ([\d.]+) with a peak of (\d+) N m; the adaptive controller at ([\d.]+) with (\d+) N m"
    yield sentence, [round(cost, 3), round(peak), round(other_cost, 3), round(other_peak)]
    fallen = [step for method in ("PBC", "KETC", "KETC, w = 1") for step in steps_of(method, UPHILL, "none")]
    yield r"and fall after (\d+) to (\d+) steps without a source", [min(fallen), max(fallen)]


def soles() -> Claims:
    def grounds(law: str, *names: str) -> list[float]:
        return [first(column(name, "feet", "laws hybrid", law)[0]) for name in names]

    none, half, quarter = grounds("paper", "none", "foot 1/2", "foot 1/4")
    succeeds = r"Of (\d+) kinds of ground .* succeeds on (\d+) without a foot"
    fails = r".* fails on (\d+) of these (\d+) grounds, with the ankle at half the length on (one)"
    yield succeeds + fails, [22, none, none - quarter, none, none - half]
    kept = [*grounds("LCTC", "±5 cm", "none"), *grounds("paper", "±5 cm", "none")]
    yield r"on ±5 cm it keeps (\d+) of (\d+) grounds, the paper's controller (\d+) of (\d+)", kept
    kept = grounds("knees, 8 cm", "none", "foot 1/3")
    yield r"of (\d+) grounds the reference of 8 cm keeps (\d+) with the ankle at a third", kept
    shares = [first(column("2 cm", "feet", "random hybrid", "±8 cm", law)[0]) for law in ("paper", "supervised")]
    yield r"([\d.]+) % of the walks with the paper's controller succeed, and ([\d.]+) % with", shares
    (row,) = (
        each for each in table("feet", "stairs by random treads hybrid") if {"±12 cm", "+4 cm"} <= {*each.values()}
    )
    counts = [first(row[name]) for name in row if "treads" in name]
    assert counts[2] == counts[3]
    yield r"(\d+) of 16 walks succeed on stairs .* and all (\d+) where treads are longer than 1.2 m", counts[:3:2]
    assert [first(cell) for cell in column("wrong model, %", "feet", "wrong hybrid", "supervised")] == [100.0, 97.9]
    yield "With a wrong model one walk in fifty fails on soles of ±8 cm, and none on ±12 cm", []


def feet() -> Claims:
    pads, box = (("footed", FEET, "±12 cm", f"{kind}, MuJoCo") for kind in ("pads", "box"))
    assert column(MADE, *pads, "all") == ["39 of 39"]
    yield r"(\d+ of \d+) walks finish", column(MADE, *box, "all")
    finished, walks = column(MADE, *box, "all, unseen phases")[0].split(" of ")
    yield r"Of (\d+) walks from phases .* used, (\d+) finish", [float(walks), float(finished)]
    stairs = [(*pads, f"stairs −{rise} cm") for rise in (4, 6)]
    slid = max(float(column("slid, mm", *each)[0]) for each in stairs)
    yield r"the landing foot on pads of ±12 cm slides by up to ([\d.]+) mm", [round(slid, 1)]
    yield r"more than ([\d.]+)° from the previous", [round(math.degrees(PLAUSIBLE), 1)]
    landed = table("footed", "touchdowns of feet")
    slaps = [row["slap where the slope changes, ms"] for row in landed if row["ground"] in ("3° up", "3° down")]
    yield r"slaps for ([\d.]+) to ([\d.]+) ms on a change of 3°", ends(slaps)


def stability() -> Claims:
    steep = [row for row in table("stability", "walks") if row["ground"] == "stairs −6 cm"]
    others = [row for row in table("stability", "walks") if row not in steep]
    sentence = r"over a step ([\d.]+) to ([\d.]+) 1/s³ on level ground, .*?, ([\d.]+) to ([\d.]+) on stairs of −6 cm"
    yield sentence, [end for rows in (others, steep) for end in ends([row["weak eigenvalue"] for row in rows])]
    sentence = r"which is ([\d.]+) or more, and ([\d.]+) or more for any .*? the other grounds ([\d.]+) and ([\d.]+)\)"
    names = ("(24), least", "its floor")
    yield sentence, [min(float(row[name]) for row in rows) for rows in (steep, others) for name in names]
    yield r"([\d.]+) to ([\d.]+) along the tables' walks", ends([row["‖Φ‖"] for row in (*steep, *others)])


def lateral() -> Claims:
    held: dict[str, float] = {}
    for row in table("three_dimensions", "lateral_basin"):
        deviation = float(row["divergent component cm"])
        if row["goes on"] == "yes":
            held[row["walker"]] = max(held.get(row["walker"], 0.0), deviation)
    yield r"all starts up to ([\d.]+) cm, .*?walks on up to ([\d.]+) cm towards the swing leg", [*held.values()]


@pytest.mark.parametrize("claims", [comparison, soles, feet, stability, lateral])
def test_sentences_are_true_of_the_tables(claims: Callable[[], Claims]) -> None:
    for sentence, expected in claims():
        found = re.search(sentence, PROSE)
        assert found, sentence
        told = [word if " " in word else float({"one": "1"}.get(word, word)) for word in found.groups()]
        assert told == expected, sentence


@pytest.mark.slow
@pytest.mark.parametrize("ground", [STAIRS, "stair 1, −6 mm"])
def test_a_cell_is_made_again(ground: str) -> None:
    """A step is given where tolerance and engine agree on it; PBC ends at one step on high stairs."""
    found = study.converged(gain_search.METHODS["PBC"].controller, study.TERRAINS[ground])
    assert found == terrain("PBC", "two_point", ground)
