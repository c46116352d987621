"""Random grounds have the statistics that their names promise."""

import math
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from numpy.typing import NDArray

from mjbiped.errors import InputError
from mjbiped.terrain.terrain import Terrain, parse_terrain


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


@pytest.fixture(scope="module")
def trail(tmp_path_factory: pytest.TempPathFactory) -> Terrain:
    """A record of 20 m that rises by 1 m, rough, with a step up of 3 cm."""
    x = np.linspace(-1.0, 19.0, 81)
    z = 0.05 * x + 0.02 * np.sin(2.0 * x) + 0.004 * np.cos(11.0 * x) + np.where(x > 8.0, 0.03, 0.0)
    rows = [f"{a:.6f},{b:.6f}" for a, b in zip(x, z, strict=True)]
    at = int(np.searchsorted(x, 8.0, side="right"))
    rows.insert(at, f"{x[at]:.6f},{z[at] - 0.03:.6f}")
    path = tmp_path_factory.mktemp("record") / "trail.csv"
    path.write_text("\n".join(rows))
    return Terrain.from_file(path)


@settings(max_examples=30, deadline=None)
@given(st.integers(0, 2**64 - 1), st.floats(2.5, 150.0))
def test_recorded_ground_is_the_record_to_and_fro_without_its_trend(trail: Terrain, seed: int, length: float) -> None:
    terrain, once = Terrain.recorded(trail, seed=seed, length=length), 20.0
    first = np.random.Generator(np.random.PCG64(seed)).uniform(0.0, 2.0 * once)
    x, z = trail.samples
    slope, offset = np.polyfit(x, z, 1)

    def expected(way: NDArray[np.float64]) -> NDArray[np.float64]:
        place = once - np.abs(once - way % (2.0 * once)) - 1.0  # a wave of triangles: there, and back
        return np.asarray(trail.height(place) - slope * place - offset)

    ahead = np.linspace(0.0, length - 2.0, 500)[1:-1]
    heights = terrain.height(2.0 + ahead)
    wanted = expected(first + ahead) - expected(np.array([first]))
    off = np.abs(heights - wanted) > 1e-9  # rounding, of angles of segments and of sums over a hundred metres
    assert off.sum() <= 2  # at a step, rounding may put a place on its other side
    assert (terrain.x[1], terrain.z[0], terrain.rises[1]) == (2.0, 0.0, 0.0)
    assert np.abs(np.array(terrain.rises)[np.array(terrain.rises) != 0.0]) == pytest.approx(0.03, abs=2e-6)


def test_seeds_take_other_stretches_in_both_directions(trail: Terrain) -> None:
    grounds = [Terrain.recorded(trail, seed=seed, length=30.0) for seed in range(40)]
    assert len(set(grounds)) == 40
    first_steps = [next(rise for rise in ground.rises if rise) for ground in grounds]
    assert 8 <= sum(rise > 0.0 for rise in first_steps) <= 32  # 20 expected; four standard errors


def test_a_path_and_what_was_read_from_it_give_one_ground(tmp_path: Path) -> None:
    path = tmp_path / "hill.csv"
    path.write_text("x,z\n0,0\n3,0.1\n7,-0.1\n")
    ground = Terrain.recorded(path, seed=2, length=20.0)
    assert ground == Terrain.recorded(Terrain.from_file(path), seed=2, length=20.0)
    assert ground == parse_terrain(f"recorded:file={path},seed=2,length=20")
    assert ground.caption == "recorded (file=hill.csv, seed=2, length=20.0)"


@pytest.mark.parametrize(
    ("rows", "parameters", "message"),
    [
        (None, {}, "recorded ground needs an elevation file"),
        ("0,0\n3,0.1\n", {}, "'x.csv' is a record of 3 m; random ground needs 5 m at least"),
        ("0,0\n9,0.1\n", {"length": 1.0}, "length = 1.0: must be from 2"),
        ("0,0\n9,0.1\n", {"seed": -1}, "seed = -1"),
        (
            "\n".join(f"{k / 10},0" for k in range(90)),
            {"length": 1e5},
            "take a shorter length, or a record with fewer samples",
        ),
        ("0,0\n", {}, "expected at least two rows"),
    ],
)
def test_no_record_is_refused_in_words(
    rows: str | None, parameters: dict[str, Any], message: str, tmp_path: Path
) -> None:
    path = tmp_path / "x.csv"
    path.write_text(rows or "")
    with pytest.raises(InputError, match=message):
        Terrain.preset("recorded", **({} if rows is None else {"file": str(path)}), **parameters)


def test_ground_without_end_is_no_record() -> None:
    with pytest.raises(InputError, match="its ground goes on without end; expected an elevation file"):
        Terrain.recorded(Terrain.level())


@settings(max_examples=20, deadline=None)
@given(st.integers(0, 2**64 - 1), st.sampled_from(["treads", "waves", "recorded"]))
def test_a_seed_gives_one_ground_bit_by_bit(trail: Terrain, seed: int, name: str) -> None:
    more = {"file": trail} if name == "recorded" else {}
    terrain, again = (Terrain.preset(name, seed=seed, length=30.0, **more) for _ in range(2))
    assert terrain == again
    assert terrain != Terrain.preset(name, seed=seed // 2 + 1, length=30.0, **more) or seed in (0, 1, 2)
    longer = Terrain.preset(name, seed=seed, length=60.0, **more)
    assert longer.z[:20] == terrain.z[:20]  # a longer ground begins as this one


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
