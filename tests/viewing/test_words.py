"""What stands in the window: the marks are named with the colours that they have."""

from types import SimpleNamespace
from typing import Any

from mjbiped.rendering.marks import ANKLE_COLOUR, ESTIMATE_COLOUR, HIP_COLOUR
from mjbiped.terrain.terrain import Terrain
from mjbiped.utils.palette import IN_WORDS, rgb
from mjbiped.viewing.words import state


def test_marks_are_named_with_their_colours() -> None:
    """The words once stayed behind when the colours changed."""
    player: Any = SimpleNamespace(speed=1.0, paused=False, reached=1.0, source=SimpleNamespace(terrain=Terrain.level()))
    moment: Any = SimpleNamespace(time=0.0, step=0, slope=0.0, slope_estimate=0.1, torque=(1.0, 2.0), force=(0.0, 98.0))
    names, _ = state(player, moment, {"estimate", "torque", "force"})
    words = {rgb(colour): name for colour, name in IN_WORDS.items()}
    assert f"slope estimate ({words[ESTIMATE_COLOUR]} line)" in names
    assert f"ankle torque ({words[ANKLE_COLOUR]} arc)" in names
    assert f"hip torque ({words[HIP_COLOUR]} arc)" in names
