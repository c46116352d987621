"""The strip chart shows the part of the walk that is asked for, and its cursor the time."""

import dataclasses
import math

import numpy as np
import pytest

import mjbiped
from controllers import AdaptiveController
from mjbiped.records.record import Walk
from mjbiped.rendering.overlay import Chart, Pixels
from mjbiped.terrain.terrain import Terrain

CURSOR = (200, 30, 30)
SIZE = (640, 100)


@pytest.fixture(scope="module")
def walk(controller: AdaptiveController) -> Walk:
    return mjbiped.walk(controller, Terrain.incline(1.0), engine="hybrid", steps=40)


def drawn(chart: Chart, time: float) -> Pixels:
    frame = np.zeros((SIZE[1], SIZE[0], 3), dtype=np.uint8)
    chart.draw(frame, time)
    return frame


def cursor(frame: Pixels) -> float:
    """Column of the cursor's middle."""
    return float(np.flatnonzero((frame == CURSOR).all(axis=2).any(axis=0)).mean())


def test_the_cursor_goes_with_time_and_the_rest_stands(walk: Walk) -> None:
    chart = Chart(walk, 2.0, 12.0, *SIZE)
    frames = [drawn(chart, time) for time in (2.0, 4.5, 7.0, 12.0)]
    columns = [cursor(frame) for frame in frames]
    # even distances but for whole pixels
    assert columns[1] - columns[0] == pytest.approx(0.25 * (columns[3] - columns[0]), abs=1.0)
    assert columns[2] - columns[0] == pytest.approx(0.5 * (columns[3] - columns[0]), abs=1.0)
    changed = (frames[0] != frames[2]).any(axis=2).any(axis=0)
    assert changed.sum() <= 2  # a column each


def test_long_walks_have_pages(walk: Walk) -> None:
    end = float(walk.samples["time"][-1])
    assert 20.0 < end < 40.0
    chart = Chart(walk, 0.0, end, *SIZE)
    columns = [cursor(drawn(chart, time)) for time in (0.0, 0.49 * end, 0.51 * end, end)]
    assert columns[0] < columns[2] < columns[0] + 20
    assert columns[3] - 20 < columns[1] < columns[3]
    assert (drawn(chart, 0.0) != drawn(chart, end)).any(axis=2).sum() > 500


def test_what_is_no_number_is_left_out(walk: Walk) -> None:
    nothing = np.full_like(walk.samples["slope"], math.nan)
    bare = dataclasses.replace(walk, samples={**walk.samples, "slope_estimate": nothing})
    estimate = drawn(Chart(walk, 0.0, 10.0, *SIZE), 5.0)
    none = drawn(Chart(bare, 0.0, 10.0, *SIZE), 5.0)
    green = [(f[..., 1] > f[..., 0].astype(int) + 100).sum() for f in (estimate, none)]  # as nothing else is
    assert green[0] > 100
    assert green[1] == 0
    torques = np.full_like(walk.samples["torque"], math.inf)
    drawn(Chart(dataclasses.replace(walk, samples={**walk.samples, "torque": torques}), 0.0, 10.0, *SIZE), 5.0)


def test_a_moment_has_a_chart(walk: Walk) -> None:
    assert cursor(drawn(Chart(walk, 3.0, 3.0, *SIZE), 3.0)) > 0
