"""Words and signs are drawn where they should be; the chart shows the part that is asked for, its cursor the time."""

import numpy as np
import pytest

import mjbiped
from controllers import AdaptiveController
from mjbiped.records.record import Walk
from mjbiped.rendering.marks import Sign
from mjbiped.rendering.overlay import Chart, Overlay, Pixels, View
from mjbiped.terrain.terrain import Terrain


def blank(width: int = 640, height: int = 360) -> Pixels:
    return np.full((height, width, 3), 200, dtype=np.uint8)


@pytest.mark.parametrize("width", [160, 320, 640])
def test_caption_and_legend_do_not_overlap(width: int) -> None:
    caption, legend = blank(width), blank(width)
    over = Overlay(caption, 360)
    beside = over.caption(["t = 12.34 s   step 16", "slope +3.0°   estimate −2.9°"])
    over = Overlay(legend, 360)
    over.legend([Sign("#FF0000", "ankle torque", "arc", "−12.3 N m")], beside)
    assert not ((caption != 200) & (legend != 200)).any()
    rows, columns = (np.flatnonzero((caption != 200).any(axis=(axis, 2))) for axis in (1, 0))
    assert (columns.max() + 1, rows.max() + 1) == beside
    assert (legend != 200).any()
    assert (legend[..., 0].astype(int) > legend[..., 1] + 200).any()  # its red sign


@pytest.mark.parametrize("pixels_per_metre", [3.0, 50.0, 317.0, 4000.0])
def test_the_scale_is_as_long_as_it_says(pixels_per_metre: float) -> None:
    frame = blank()
    over = Overlay(frame, 360)
    text = over.scale(pixels_per_metre, 50)
    length, unit = text.split()
    assert unit == "m"
    wide = round(float(length) * pixels_per_metre)
    assert 640 / 7 / 2.6 < wide <= 640 / 7 * 1.02 + 1  # 1, 2 or 5 times a power of ten
    columns = np.flatnonzero((frame[:, :, 0] < 100).any(axis=0))
    assert np.ptp(columns) + 1 >= wide - 1


def test_labels_say_what_the_ground_is() -> None:
    terrain = Terrain.from_segments([(2.0, 0.0, 0.0), (2.0, 3.0, -0.02), (0.02, 1.0, 0.0), (5.0, -1.5, 0.006)])
    axes = np.array([[1.0, 0.0, 0.0], [0.0, 0.0, 1.0], [0.0, -1.0, 0.0]])
    view = View((640, 360), np.array([2.5, -5.0, 0.5]), axes, 1.4, orthographic=True)
    frame = blank()
    over = Overlay(frame, 360)
    labels = over.ground_labels(terrain, view, 1.0)
    # the segment of 20 mm has no room
    assert sorted(labels) == sorted(["level", "20 mm down", "3.0° down", "6 mm up", "1.5° up"])
    dark = np.flatnonzero((frame[:, :, 0] < 120).any(axis=0))
    assert dark.min() > 0
    assert dark.max() < 639
    assert np.diff(dark).max() > 5  # words stand apart


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
