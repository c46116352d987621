"""Words for the ground's slopes and steps, in a line along the lower edge of a picture that is seen from the side."""

from __future__ import annotations

import math

from mjbiped.engines.mujoco.scenery import CUT
from mjbiped.rendering.camera import View
from mjbiped.rendering.overlay import Pixels, lay, letter_size, text_stamp, text_width
from mjbiped.terrain.terrain import Terrain

_LEAST_STEP = 5e-4  # a step of less is not told of, m
_LEAST_SLOPE = math.radians(0.05)  # a slope of less is told of as level
_APART = 0.8  # of two labels, in letters


def lay_ground_labels(frame: Pixels, terrain: Terrain, view: View, leg_length: float, height: int) -> None:
    """Write under the ground how steep each segment is and how high each step, as far as there is room.

    Args:
        frame: RGB, to be changed.
        terrain: The ground.
        view: Of the frame, by a camera that looks across the walking direction.
        leg_length: Of the robot, m.
        height: Of the whole picture, pixels; the font's size follows it.
    """
    size = round(0.8 * letter_size(height), 1)
    here = float(view.place[0])
    cut = -CUT * leg_length
    origin, pitch = view.pixel(here, cut, 0.0)[0], view.pixel(here + 1.0, cut, 0.0)[0]
    pitch -= origin
    width = frame.shape[1]
    first, last = (terrain.segment_at(here + (edge - origin) / pitch) for edge in (0.0, float(width)))
    taken: list[tuple[float, float]] = []
    row = frame.shape[0] - 1.5 * size

    def write(text: str, middle: float, low: float, high: float) -> None:
        """A label about a column between two others, if there is room."""
        half = 0.5 * text_width(text, size) + 0.5 * _APART * size
        if low + half > high - half:
            return
        middle = min(max(middle, low + half), high - half)
        if all(middle + half < start or middle - half > stop for start, stop in taken):
            taken.append((middle - half, middle + half))
            lay(frame, text_stamp(text, size), middle - half + 0.5 * _APART * size, row)

    columns = [origin + pitch * (x - here) for x in terrain.x[first : last + 1]]
    for index, column in zip(range(first, last + 1), columns, strict=True):
        rise = terrain.rises[index]
        if abs(rise) >= _LEAST_STEP and 0.0 < column < width:
            write(f"{abs(rise) * 1e3:.3g} mm {'up' if rise > 0.0 else 'down'}", column, 0.0, width)
    for index, column in zip(range(first, last + 1), columns, strict=True):
        start = 0.0 if index == first else column
        stop = float(width) if index == last else columns[index - first + 1]
        slope = terrain.angle[index]
        words = f"{math.degrees(abs(slope)):.1f}° {'down' if slope > 0.0 else 'up'}"
        write(words if abs(slope) >= _LEAST_SLOPE else "level", 0.5 * (start + stop), start, stop)
