"""What stands in the window: the marks are named with the colours that they have."""

from types import SimpleNamespace
from typing import Any

import mjbiped
from mjbiped.records.signals import SIGNALS
from mjbiped.utils.palette import IN_WORDS
from mjbiped.viewing.window import state


def test_marks_are_named_with_their_colours() -> None:
    """The words once stayed behind when the colours changed."""
    source = SimpleNamespace(terrain=mjbiped.Terrain.level(), robot=mjbiped.KneedBiped())
    player: Any = SimpleNamespace(speed=1.0, paused=False, reached=1.0, source=source)
    instant = {"time": 0.0, "step": 0, "slope": 0.0, "slope_estimate": 0.1, "force": (0.0, 98.0), "reference": None}
    moment: Any = SimpleNamespace(**instant, torque=(1.0, 2.0, 0.5))
    names, _ = state(player, moment, {"estimate", "torque", "force"})
    words = {name: IN_WORDS[signal.colour] for name, signal in SIGNALS.items()}
    assert f"slope estimate ({words['slope_estimate']} line)" in names
    assert f"ankle torque ({words['torque_ankle']} arc)" in names
    assert f"hip torque ({words['torque_hip']} arc)" in names
    assert f"swing knee torque ({words['torque_knee']} arc)" in names
