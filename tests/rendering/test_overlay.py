"""Words and signs are laid where they should be, and never beyond the frame."""

from typing import Any

import numpy as np
import pytest

from mjbiped.rendering import ground_labels
from mjbiped.rendering.camera import View
from mjbiped.rendering.ground_labels import lay_ground_labels
from mjbiped.rendering.overlay import Pixels, Sign, Stamp, lay, lay_caption, lay_legend, lay_scale, text_stamp
from mjbiped.terrain.terrain import Terrain


def blank(width: int = 640, height: int = 360) -> Pixels:
    return np.full((height, width, 3), 200, dtype=np.uint8)


def test_stamps_blend_and_are_cut_off_at_the_edges() -> None:
    half = Stamp(np.full((4, 6, 3), 100 * 128, dtype=np.uint16), np.full((4, 6, 1), 127, dtype=np.uint16))
    frame = blank()
    lay(frame, half, -2, 358)
    assert (frame[358:, :4] == (200 * 127 + 100 * 128) // 255).all()
    frame[358:, :4] = 200
    assert (frame == 200).all()
    for x, y in ((-10, 0), (0, -10), (640, 0), (0, 360), (1000, 1000)):
        lay(frame, half, x, y)
    assert (frame == 200).all()


@pytest.mark.parametrize("width", [160, 320, 640])
def test_caption_and_legend_do_not_overlap(width: int) -> None:
    caption, legend = blank(width), blank(width)
    beside = lay_caption(caption, ["t = 12.34 s   step 16", "slope +3.0°   estimate −2.9°"], 360)
    lay_legend(legend, [Sign((1.0, 0.0, 0.0), "ankle torque", "−12.3 N m")], 360, beside)
    assert not ((caption != 200) & (legend != 200)).any()
    assert (legend != 200).any()


@pytest.mark.parametrize("pixels_per_metre", [3.0, 50.0, 317.0, 4000.0])
def test_the_scale_is_as_long_as_it_says(pixels_per_metre: float, monkeypatch: pytest.MonkeyPatch) -> None:
    said: list[tuple[str, int]] = []
    from mjbiped.rendering import overlay

    bar = overlay._bar

    def noted(text: str, wide: int, size: float) -> Stamp:
        said.append((text, wide))
        return bar(text, wide, size)

    monkeypatch.setattr(overlay, "_bar", noted)
    frame = blank()
    lay_scale(frame, pixels_per_metre, 50, 360)
    [(text, wide)] = said
    length, unit = text.split()
    assert unit == "m"
    assert wide == round(float(length) * pixels_per_metre)
    assert 640 / 7 / 2.6 < wide <= 640 / 7 * 1.02 + 1  # 1, 2 or 5 times a power of ten
    columns = np.flatnonzero((frame[:, :, 0] < 100).any(axis=0))
    assert np.ptp(columns) + 1 >= wide - 1


def test_labels_say_what_the_ground_is(monkeypatch: pytest.MonkeyPatch) -> None:
    terrain = Terrain.from_segments([(2.0, 0.0, 0.0), (2.0, 3.0, -0.02), (0.02, 1.0, 0.0), (5.0, -1.5, 0.006)])
    axes = np.array([[1.0, 0.0, 0.0], [0.0, 0.0, 1.0], [0.0, 1.0, 0.0]])
    view = View((640, 360), np.array([2.5, -5.0, 0.5]), axes, (0.0, 2.5, 0.0, 1.4), orthographic=True)
    labels: dict[str, tuple[float, float]] = {}

    def noted(text: str, size: float) -> Any:
        labels[text] = (size, 0.0)
        return text_stamp(text, size)

    monkeypatch.setattr(ground_labels, "text_stamp", noted)
    frame = blank()
    lay_ground_labels(frame, terrain, view, 1.0, 360)
    # the segment of 20 mm has no room
    assert set(labels) == {"level", "20 mm down", "3.0° down", "6 mm up", "1.5° up"}
    dark = np.flatnonzero((frame[:, :, 0] < 120).any(axis=0))
    assert dark.min() > 0
    assert dark.max() < 639
    assert np.diff(dark).max() > 5  # words stand apart
