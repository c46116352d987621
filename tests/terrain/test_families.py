"""Random grounds have the statistics that their names promise."""

import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from mjbiped.errors import InputError
from mjbiped.terrain.terrain import Terrain


def test_treads_have_the_named_depth_steps_and_slopes() -> None:
    deviation, count = 0.03, 2000
    terrain = Terrain.treads(seed=3, length=2.0 + 1.5 * count, tread=1.5, deviation=deviation, slope_deg=(-5.0, 3.0))
    slopes = np.degrees(terrain.angle)
    assert np.diff(terrain.x)[1:] == pytest.approx(1.5 * np.cos(terrain.angle[1:-1]))
    assert (terrain.x[1], slopes[0], terrain.z[:1]) == (2.0, 0.0, (0.0,))
    rises = np.array(terrain.rises[1:])
    assert rises.std() == pytest.approx(deviation, rel=4 / math.sqrt(2 * count))  # four standard errors
    assert abs(rises.mean()) < 4 * deviation / math.sqrt(count)
    assert (slopes[1:].min(), slopes[1:].max()) == pytest.approx((-5.0, 3.0), abs=8 * 10 / count)
    assert (np.abs(slopes[1:] + 1.0) <= 4.0).all()


def test_treads_without_deviation_are_slopes_that_meet() -> None:
    assert set(Terrain.treads(deviation=0.0, slope_deg=(-5.0, 5.0)).rises) == {0.0}


def test_waves_have_the_named_deviation_and_no_other_lengths() -> None:
    deviation, spacing = 0.01, 0.05
    terrain = Terrain.waves(seed=5, length=2000.0, deviation=deviation, shortest=0.8, longest=4.0, spacing=spacing)
    heights = np.array(terrain.z[1:])[1000:]
    assert heights.std() == pytest.approx(deviation, rel=0.03)  # the mean over 490 of the longest waves
    power = np.abs(np.fft.rfft(heights * np.hanning(heights.size))) ** 2
    numbers = np.fft.rfftfreq(heights.size, spacing)
    inside = (numbers > 0.95 / 4.0) & (numbers < 1.05 / 0.8)
    assert power[inside].sum() / power.sum() > 0.999
    assert max(map(abs, terrain.rises)) == 0.0
    assert np.abs(np.array(terrain.z[:3])).max() < 0.02 * deviation  # it begins level and without a step


@settings(max_examples=20, deadline=None)
@given(st.integers(0, 2**64 - 1), st.sampled_from(["treads", "waves"]))
def test_a_seed_gives_one_ground_bit_by_bit(seed: int, name: str) -> None:
    terrain, again = (Terrain.preset(name, seed=seed, length=30.0) for _ in range(2))
    assert terrain == again
    assert terrain != Terrain.preset(name, seed=seed // 2 + 1, length=30.0) or seed in (0, 1, 2)
    assert Terrain.preset(name, seed=seed, length=60.0).z[:20] == terrain.z[:20]  # a longer ground begins as this one


@pytest.mark.parametrize(
    ("name", "parameters", "message"),
    [
        ("treads", {"length": 1.0}, "length = 1.0: must be from 2"),
        ("treads", {"deviation": 0.2}, "deviation = 0.2: must be from 0 to 0.1 m"),
        ("treads", {"tread": 1e-3}, "take a shorter length or a longer tread"),
        ("treads", {"slope_deg": (-40.0, 0.0)}, "steeper than the robot can stand on"),
        ("waves", {"spacing": 0.2}, "at least four times spacing"),
        ("waves", {"shortest": 6.0}, "less than longest"),
        ("waves", {"deviation": 0.1, "shortest": 0.2}, "steeper than the robot can stand on"),
        ("waves", {"length": 1e5}, "take a shorter length or a longer spacing"),
    ],
)
def test_parameters_outside_their_domain_are_refused(name: str, parameters: dict[str, object], message: str) -> None:
    with pytest.raises(InputError, match=message):
        Terrain.preset(name, **parameters)
