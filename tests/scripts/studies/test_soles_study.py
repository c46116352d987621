"""The study of soles: its grounds come at eight phases, and a cell counts the walks that come through."""

from __future__ import annotations

import math

import numpy as np
import pytest

import mjbiped
from controllers import AdaptiveController
from mjbiped import Terrain
from scripts.studies import soles_study as study


def test_each_ground_changes_later_with_each_phase() -> None:
    for name, ground in study.grounds():
        first = [ground(phase).x[1:2] for phase in range(study.PHASES)]
        assert name == "level" or name.startswith("treads") or len(set(first)) == study.PHASES
    mixed = dict(study.grounds())["mixed"](0)
    assert mixed.rises == pytest.approx(Terrain.mixed().rises, abs=1e-12)  # sums of a dozen heights of centimetres


@pytest.mark.slow
def test_a_cell_counts_the_walks_that_come_through() -> None:
    robot = mjbiped.Compass(sole=(0.12, 0.12))
    law = AdaptiveController(robot, mjbiped.find_passive_gait(robot, slope=np.deg2rad(2)))
    grounds = dict(study.grounds())
    share, cost = study.through(law, grounds["level"], "hybrid")
    assert (share, round(cost, 4)) == (1.0, 0.0349)
    share, cost = study.through(law, grounds["stairs +6 cm"], "hybrid")
    assert share == 0.0
    assert math.isnan(cost)
    assert [study.told(1.0, 0.0349), study.told(0.25, math.nan), study.told(0.0, math.nan)] == ["0.035", "2 of 8", "–"]
