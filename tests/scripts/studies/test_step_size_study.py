"""The figure of the step sizes: names of settings that lie close together stand apart, whatever was measured."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from legible import assert_legible
from matplotlib.figure import Figure

from mjbiped.plotting import style as plot_style
from scripts.studies import step_size_study as study


@pytest.mark.slow
@pytest.mark.parametrize("seed", range(3))
def test_names_of_settings_stand_apart(seed: int, monkeypatch: pytest.MonkeyPatch) -> None:
    """Errors by contact step or step, as measured, within a few percent; speeds by step."""
    drawn: list[Figure] = []
    monkeypatch.setattr(plot_style, "save_figure", lambda figure, _: drawn.append(figure))
    random = np.random.default_rng(seed)
    found, speed = {}, {}
    for setting in study.SETTINGS:
        error = (20.0 * setting.contact_timestep if setting.lands else 30.0 * setting.timestep) * random.uniform(
            0.97, 1.03
        )
        found[setting] = {"a ground": study.Errors(error, 0.5 * error, 0.0, 0.0, "finished")}
        fast = 1.8e5 * setting.timestep * random.uniform(0.9, 1.1)
        speed[setting] = study.Speed(np.array([fast, fast, 1.1 * fast]), np.array([fast]), 1, 1.0)
    study.draw(Path("step_size.png"), found, speed)
    (figure,) = drawn
    assert_legible(figure, "page")
    assert {text.get_text() for text in figure.axes[0].texts} >= {"A", "B", "C", "D", "4 ms", "0.05 ms", "100 µs"}
