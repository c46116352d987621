"""Where the condition (24) holds: the ranges on the page are those that its left side has."""

from __future__ import annotations

import math
import re
from dataclasses import replace

import pytest
from documentation import table

import mjbiped
from controllers import AdaptiveController
from scripts.paper.gain_study import HIGHEST_GAMMA, on_the_cycle, scaled

ROBOT = mjbiped.Compass()
PAPER = AdaptiveController(ROBOT, mjbiped.find_passive_gait(ROBOT, math.radians(2)))
LINES = [[*row.values()] for row in table("stability", "condition 24")]
AROUND = 0.005  # an end has three digits: half a unit of the last is at most 0.005 of it


def holds(scale: float, gamma: float) -> bool:
    """Whether (24) holds on the limit cycle."""
    gains = replace(scaled(PAPER, scale), adaptation_gain=gamma)
    return on_the_cycle(gains, 40).condition < 1.0


def ends(cells: list[str]) -> list[tuple[float, float]]:
    return [(float(low), float(high)) for low, high in re.findall(r"([\d.]+) to ([\d.]+)", cells[1])]


def test_ranges_of_gamma_with_the_paper_s_tracking_gains() -> None:
    """Above all the two widest, with which the paper's own gamma is not among them."""
    assert LINES[0][0] == "5, 12"
    ranges = ends(LINES[0])
    widest = sorted(sorted(ranges, key=lambda each: each[0] / each[1])[:2])
    assert widest == ranges[:2]
    for low, high in widest:
        assert not holds(1.0, low * (1.0 - AROUND))
        assert holds(1.0, low * (1.0 + AROUND))
        assert holds(1.0, high * (1.0 - AROUND))
        assert not holds(1.0, high * (1.0 + AROUND))
    assert all(low > PAPER.adaptation_gain for low, _ in ranges)
    assert not holds(1.0, PAPER.adaptation_gain)


def test_range_of_gamma_with_twice_the_tracking_gains() -> None:
    assert LINES[1][0] == "10, 24"
    ((low, high),) = ends(LINES[1])
    assert high == HIGHEST_GAMMA
    assert not holds(2.0, low * (1.0 - AROUND))
    assert holds(2.0, low * (1.0 + AROUND))


@pytest.mark.parametrize("gamma", [9.0, 20.0, 80.0])
def test_it_fails_between_the_ranges(gamma: float) -> None:
    assert not any(low <= gamma <= high for low, high in ends(LINES[0]))
    assert not holds(1.0, gamma)
