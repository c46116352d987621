"""Windows of the ground: on a long terrain the same walk as on the whole terrain's model, bit by bit."""

from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from simulations import assert_same, recorded, started

import mjbiped
from controllers import AdaptiveController, Controller
from mjbiped.engines.mujoco.ground import FEW_SEGMENTS, Ground
from mjbiped.engines.mujoco.options import GROUND_KINDS
from mjbiped.engines.mujoco.scene import MARGIN
from mjbiped.engines.mujoco.simulation import Simulation
from mjbiped.rules.termination import Outcome

Terrain = mjbiped.Terrain


PLACES = np.arange(201) * 0.15
HEIGHTS = 2e-3 * np.sin(1.7 * PLACES)
LONG = {
    "stairs": Terrain.stairs(tread=0.15, rise=-0.001, count=200),
    "mixed": Terrain.random(seed=4, length=30.0, segment_length=(0.1, 0.2), slope_deg=(-1.0, 2.0), rise=(-4e-3, 1e-3)),
    "trail": Terrain(tuple(PLACES[:-1]), tuple(HEIGHTS[:-1]), tuple(-np.arctan(np.diff(HEIGHTS) / 0.15))),
    "rough": Terrain.random(seed=1, length=30.0, roughness=2e-4, spacing=0.12),
}
"""Of short segments, the trail's at equal distances: a window ends after some four metres."""


def make(controller: Controller, terrain: Terrain, **parameters: Any) -> Simulation:
    return started(controller, terrain, **{"timestep": 2e-4, "sample_period": 0.01, **parameters})


@pytest.mark.parametrize(
    "name", [pytest.param(name, marks=() if name in ("mixed", "trail") else pytest.mark.slow) for name in LONG]
)
def test_same_walk_bitwise(name: str, controller: AdaptiveController, monkeypatch: pytest.MonkeyPatch) -> None:
    """No tolerance: pieces have the same numbers in every window, and MuJoCo orders contacts by geom."""
    walked, models = recorded(make(controller, LONG[name], steps=15))
    assert models >= 2
    monkeypatch.setattr(
        Ground, "window", lambda ground, *_: ground.pieces
    )  # the whole terrain's model, of the same pieces
    reference, models = recorded(make(controller, LONG[name], steps=15))
    assert models == 1
    assert len(walked["slope_estimate_before"]) == 15
    assert_same(walked, reference)


def test_leaving_the_window_is_no_fall_into_nothing(controller: AdaptiveController) -> None:
    """Who steps without `move_on` is told at the window's end."""
    simulation = make(controller, LONG["trail"])
    simulation.advance(110_000)
    assert simulation.outcome is Outcome.LEFT_TERRAIN


@settings(max_examples=60, deadline=None)
@given(
    data=st.data(),
    widths=st.lists(st.sampled_from([0.02, 0.1, 0.1, 0.1, 0.5, 3.0, 40.0]), min_size=1, max_size=150),
    ground=st.sampled_from(GROUND_KINDS),
    length=st.sampled_from([0.2, 1.0]),
)
def test_a_window_holds_what_is_in_reach(data: st.DataObject, widths: list[float], ground: str, length: float) -> None:
    """All ground within the margin, few segments beyond what that needs; and no window is left where it was made."""
    rows = [(width, 1.0 + (index % 3), -0.01 * (index % 4 == 3)) for index, width in enumerate(widths)]
    terrain = Terrain.from_segments(rows)
    layout, margin = Ground(terrain, reach=20.0, kind=ground), MARGIN * length
    first, last = layout.starts[0], layout.stops[-1]
    x = data.draw(st.floats(first - 1.0, last + 1.0))
    pieces = layout.window(x, margin, length)
    segments = range(pieces[0].segments[0], pieces[-1].segments.stop)
    start, end = layout.starts[segments[0]], layout.stops[segments[-1]]
    assert start <= max(x - margin, first)
    assert end >= min(x + margin, last)
    if len(terrain.x) <= FEW_SEGMENTS:
        assert pieces == layout.pieces
    needed = np.searchsorted(terrain.x, [x - margin - length, x + 2 * margin])
    # whole heightfields of 16 at both sides
    assert len(segments) <= max(needed[1] - needed[0], FEW_SEGMENTS + (needed[1] - needed[0])) + 2 * 16 + 1
