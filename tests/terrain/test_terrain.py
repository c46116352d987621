"""Tests of `mjbiped.terrain`, its segments and its files."""

import itertools
import json
import math
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from mjbiped.errors import InputError
from mjbiped.terrain.profile import (
    GROUND_FRICTION,
    HIGHEST_STEP,
    MOST_SEGMENTS,
    STEEPEST_SLOPE,
    segment_near,
    segment_under,
)
from mjbiped.terrain.shape import STEP_RESOLUTION
from mjbiped.terrain.terrain import Terrain, parse_terrain

STEPS = st.one_of(st.just(0.0), st.floats(-0.5, 0.5).filter(lambda s: abs(s) > 1e-6))
SEGMENTS = st.lists(st.tuples(st.floats(0.01, 20.0), st.floats(-38.0, 38.0), STEPS), min_size=1, max_size=12)
THREE = [(1.0, 2.0, 0.0), (2.0, -1.0, 0.01), (0.5, -3.0, 0.0)]


def bits(values: Any) -> bytes:
    return np.asarray(values, dtype=np.float64).tobytes()


def ends(terrain: Terrain) -> list[float]:
    return [*terrain.x[1:], terrain.x[-1] + 5.0]


# ---- the profile ----------------------------------------------------------------------------------------------------


@given(SEGMENTS)
def test_segments_have_their_lengths_slopes_and_steps_along_the_ground(rows: list[tuple[float, float, float]]) -> None:
    terrain = Terrain.from_segments(rows)
    assert terrain.x[0] == 0.0
    assert terrain.z[0] == rows[0][2]  # the first segment's step is the datum
    assert terrain.rises[0] == 0.0
    assert terrain.end == math.inf
    for i, (length, slope, step) in enumerate(rows):
        assert terrain.angle[i] == math.radians(slope)
        if i and step == 0.0:
            assert terrain.rises[i] == 0.0
        elif i:
            assert terrain.rises[i] == pytest.approx(step, abs=1e-12)
        if i + 1 < len(rows):
            along = math.hypot(terrain.x[i + 1] - terrain.x[i], terrain.heights_before[i + 1] - terrain.z[i])
            assert along == pytest.approx(length, abs=1e-11)


@given(SEGMENTS)
def test_height_is_continuous_but_for_the_rises(rows: list[tuple[float, float, float]]) -> None:
    terrain = Terrain.from_segments(rows)
    for i, x in enumerate(terrain.x):
        before = terrain.height_at(math.nextafter(x, -math.inf))
        assert terrain.height_at(x) == terrain.z[i]
        assert terrain.z[i] - before == pytest.approx(terrain.rises[i], abs=1e-11)
        assert terrain.heights_before[i] == pytest.approx(before, abs=1e-11)


@given(SEGMENTS, st.floats(0.1, 0.9))
def test_slope_is_minus_the_gradient_of_the_height(rows: list[tuple[float, float, float]], part: float) -> None:
    terrain = Terrain.from_segments(rows)
    for start, stop in zip(terrain.x, ends(terrain), strict=True):
        x, dx = start + part * (stop - start), 0.05 * (stop - start)
        gradient = (terrain.height(x + dx) - terrain.height(x - dx)) / (2 * dx)
        assert -math.tan(terrain.slope(x)) == pytest.approx(gradient, abs=1e-9)


def test_the_first_segment_extends_backwards_and_the_last_forwards() -> None:
    terrain = Terrain.from_segments(THREE)
    assert terrain.slope(-100.0) == math.radians(2.0)
    assert terrain.height(-10.0) == pytest.approx(10.0 * math.tan(math.radians(2.0)))
    assert terrain.slope(1e4) == math.radians(-3.0)
    assert terrain.height(1e4) > terrain.height(1e3) > terrain.height(10.0)


def test_the_slope_downhill_is_positive_and_a_positive_step_goes_up() -> None:
    terrain = Terrain.from_segments([(1.0, 0.0, 0.0), (1.0, 5.0, 0.1)])
    assert terrain.height(0.999) == 0.0
    assert terrain.height(1.0) == 0.1
    assert terrain.height(2.0) < terrain.height(1.5) < 0.1
    assert terrain.slope(1.5) == math.radians(5.0)


def test_the_highest_step_is_allowed_whatever_the_rounding() -> None:
    terrain = Terrain.from_segments([(1.0, 1.25, -0.5), (1.0, 0.0, -HIGHEST_STEP)])
    assert terrain.rises[1] < -HIGHEST_STEP  # by rounding: the property test of the record found it


def test_rounding_is_no_step() -> None:
    terrain = Terrain((0.0, 1.0, 2.0), (0.0, STEP_RESOLUTION / 2, 1e-8), (0.0, 0.0, 0.0))
    assert terrain.rises[1] == 0.0
    assert terrain.rises[2] != 0.0
    assert list(terrain.stretches()) == [range(0, 2), range(2, 3)]


# ---- asking ---------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("x", [1, np.float32(1.0), np.array(1.0), [0.5, 1.0], [], np.arange(6).reshape(2, 3)])
def test_places_of_any_shape_are_asked_one_by_one(x: Any) -> None:
    terrain = Terrain.mixed()
    for ask, at in ((terrain.height, terrain.height_at), (terrain.slope, terrain.slope_at)):
        found = ask(x)
        assert np.shape(found) == np.shape(x)
        assert np.ravel(found).tolist() == [at(float(each)) for each in np.ravel(x)]
        assert isinstance(found, float if np.ndim(x) == 0 else np.ndarray)


def test_a_segment_is_found_from_any_other() -> None:
    profile = Terrain.mixed().profile
    for x in (-5.0, 0.0, 2.0, 9.1, 30.0):
        assert {segment_near(profile, x, index) for index in range(14)} == {segment_under(profile, x)}


def test_nan_gives_nan() -> None:
    for ask in (Terrain.stairs().height, Terrain.stairs().slope):
        assert np.isnan(ask([math.nan, 0.0])).tolist() == [True, False]


@pytest.mark.parametrize("x", ["one", "1.0", ["a"], None, True, 1j, {"x": 1}, [[1.0], [1.0, 2.0]]])
def test_places_that_are_no_numbers_are_refused(x: Any) -> None:
    for ask in (Terrain.level().height, Terrain.level().slope):
        with pytest.raises(InputError, match="must be numbers in m"):
            ask(x)


# ---- value, record --------------------------------------------------------------------------------------------------


@given(SEGMENTS)
def test_the_record_gives_back_the_terrain_exactly(rows: list[tuple[float, float, float]]) -> None:
    terrain = Terrain.from_segments(rows)
    again = Terrain.from_dict(json.loads(json.dumps(terrain.to_dict(), allow_nan=False)))
    assert again == terrain
    assert hash(again) == hash(terrain)
    assert [bits(f) for f in (again.x, again.z, again.angle)] == [
        bits(f) for f in (terrain.x, terrain.z, terrain.angle)
    ]


def test_lists_arrays_and_numpy_numbers_become_plain_tuples() -> None:
    terrain = Terrain(
        np.array([0.0, 1.0]),  # type: ignore[arg-type]
        [np.float64(0.0), 0],  # type: ignore[arg-type]
        (np.float32(0.0), -0.0),  # type: ignore[arg-type]
        end=np.float64(math.inf),
        parameters=[["seed", np.int64(3)]],  # type: ignore[arg-type]
    )
    assert terrain == Terrain((0.0, 1.0), (0.0, 0.0), (0.0, 0.0), parameters=(("seed", 3),))
    assert {type(v) for v in (*terrain.x, *terrain.z, *terrain.angle, terrain.end)} == {float}
    assert bits(terrain.angle) == bits([0.0, 0.0])  # no negative zero
    assert hash(terrain) == hash(Terrain((0.0, 1.0), (0.0, 0.0), (0.0, 0.0), parameters=(("seed", 3),)))


def test_terrains_of_other_ground_name_or_parameters_differ() -> None:
    terrain = Terrain.stairs()
    assert terrain != Terrain.stairs(rise=math.nextafter(-0.06, 0.0))
    assert Terrain.level() != Terrain((0.0,), (0.0,), (0.0,))
    assert Terrain.incline(0.0) != Terrain.level()


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"surprise": 1}, "must be a mapping with x, z, angle, end, name, parameters, got"),
        ({"x": None}, "x = None"),
        ({"z": [0.0, 1.0]}, "the same number of entries"),
        ({"name": 5}, "name = 5: must be text"),
        ({"parameters": [["alone"]]}, "pairs of a name and a value"),
        ({"parameters": 5}, "pairs of a name and a value"),
        ({"parameters": [["a", {"b": 1}]]}, "parameter holds"),
        ({"parameters": [["a", math.nan]]}, "parameter holds"),
    ],
)
def test_a_spoilt_record_is_refused(change: dict[str, Any], message: str) -> None:
    with pytest.raises(InputError, match=message):
        Terrain.from_dict({**Terrain.level().to_dict(), **change})


def test_captions_name_what_the_terrain_was_made_with() -> None:
    assert Terrain.stairs().caption == "stairs (tread=1.8, rise=-0.06, first=0.9, count=20)"
    assert "slope_deg=-3.0..3.0" in Terrain.random().caption
    assert Terrain.from_segments(THREE).caption == "segments (3 segments)"


# ---- by name, on the command line -----------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("text", "terrain"),
    [
        ("  level ", Terrain.level()),
        ("stairs: tread = 2 , count=3", Terrain.stairs(tread=2.0, count=3)),
        ("random:segment_length=.5..1.5,rise=-1e-2..0", Terrain.random(segment_length=(0.5, 1.5), rise=(-0.01, 0.0))),
    ],
)
def test_text_on_the_command_line(text: str, terrain: Terrain) -> None:
    assert parse_terrain(text) == terrain


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("", "unknown terrain ''"),
        ("stair:tread=1.8", "did you mean 'stairs'.*path of a terrain file"),
        ("stairs:", "terrain stairs: cannot read ''"),
        ("stairs:tread", "cannot read 'tread'.*key=value"),
        ("stairs:=3", "cannot read"),
        ("stairs:tread=1,tread=2", "given twice"),
        ("stairs:tread=1_0", "no number"),
        ("random:slope_deg=1..2..3", "no number"),
        ("random:slope_deg=2", "range .low, high., on the command line low..high"),
        ("stairs:tread=1..2", "tread = .1, 2.: must be a finite number"),
        ("stairs:tred=1", "unknown parameter of the terrain stairs 'tred'.*did you mean 'tread'"),
        ("missing.csv", "terrain file missing.csv: there is no such file"),
        ("folder/thing", "unknown suffix ''"),
        ("ground.txt", r"unknown suffix '.txt': valid are .csv, .asc, .toml, .yaml, .yml"),
    ],
)
def test_text_that_means_no_terrain_is_refused(text: str, message: str) -> None:
    with pytest.raises(InputError, match=message):
        parse_terrain(text)


# ---- refusals -------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("rows", "message"),
    [
        ([], "there are no segments"),
        ("1,2,3", "must be a list"),
        ([(1.0, 2.0, 0.0, 0.0, 0.0)], "segment 1 is"),
        ([(1.0, 2.0, 0.0, 39.0)], "segment 1: lateral slope: .*steeper"),
        ([(1.0, 30.0, 0.0, 30.0)], "segment 1: a slope of 39.23 degrees"),
        ([(1.0, 0.0), "ab"], "segment 2 is 'ab'"),
        ([(1.0, 0.0), (-1.0, 0.0)], "segment 2: length"),
        ([(1.0, 0.0), (1.0, 38.7)], r"segment 2: slope: .*steeper than the robot can stand on at friction 0.8"),
        ([(1.0, -38.7)], "expected less than 38.7 degrees"),
        ([(1.0, 0.0), (1.0, 0.0, -0.6)], "segment 2: step = -0.6: must be from -0.5 to 0.5 m"),
        ([(9e4, 0.0), (9e4, 0.0), (1.0, 0.0)], "segment 3: x"),
    ],
)
def test_segments_outside_their_domain_are_refused(rows: Any, message: str) -> None:
    with pytest.raises(InputError, match=message):
        Terrain.from_segments(rows)


@pytest.mark.parametrize(
    ("fields", "message"),
    [
        ({"x": ()}, "at least one"),
        ({"angle": (0.0, 0.0)}, "the same number"),
        ({"z": (2e5,)}, "segment 1: z = 200000.0: must be from -100000 to 100000 m"),
        ({"angle": (STEEPEST_SLOPE,)}, "segment 1: a slope"),
        ({"angle": (-STEEPEST_SLOPE,)}, "segment 1: a slope"),
        ({"x": (1.0,)}, "starts at x = 0"),
        ({"x": (-1.0,), "end": 0.0}, "starts at x = 0"),
        ({"end": 0.0}, "length > 0"),
        ({"lateral": (0.1, 0.1)}, "an entry per segment, 1; got 2"),
        ({"lateral": 0.1}, "lateral = 0.1: must be a list"),
        ({"end": -math.inf}, "end"),
        ({"x": (0.0, 0.0), "z": (0.0, 0.0), "angle": (0.0, 0.0)}, "length > 0"),
        ({"x": (0.0, 1.0), "z": (0.0, 0.6), "angle": (0.0, 0.0)}, "segment 2: its step"),
        ({"x": tuple(range(MOST_SEGMENTS + 1)), "z": (0,) * (MOST_SEGMENTS + 1), "angle": (0,) * (MOST_SEGMENTS + 1)},
         "at most"),
    ],
)  # fmt: skip
def test_fields_outside_their_domain_are_refused(fields: dict[str, Any], message: str) -> None:
    with pytest.raises(InputError, match=message):
        Terrain(**{"x": (0.0,), "z": (0.0,), "angle": (0.0,), **fields})


def test_the_limits_are_what_the_messages_say() -> None:
    assert math.tan(STEEPEST_SLOPE) == pytest.approx(GROUND_FRICTION)
    Terrain.from_segments([(1.0, 38.6, 0.0), (1.0, -38.6, HIGHEST_STEP)])


# ---- files ----------------------------------------------------------------------------------------------------------


PROFILES = st.lists(
    st.tuples(st.floats(0.05, 3.0), st.floats(-0.03, 0.03), st.none() | st.floats(0.001, 0.4)), min_size=1, max_size=15
)


@settings(deadline=None)
@given(PROFILES, st.floats(0.0, 0.99), st.floats(-100, 100))
def test_sampled_profiles_are_kept_as_sampled(
    tmp_path_factory: pytest.TempPathFactory,
    pieces: list[tuple[float, float, float | None]],
    start: float,
    datum: float,
) -> None:
    rows = [(-start * pieces[0][0], datum)]
    for k, (dx, dz, step) in enumerate(pieces):
        rows.append((rows[-1][0] + dx, rows[-1][1] + dz))
        if step is not None and k < len(pieces) - 1:
            rows.append((rows[-1][0], rows[-1][1] - step))
    path = tmp_path_factory.mktemp("profile") / "ground.csv"
    path.write_text("".join(f"{x!r},{z!r}\n" for x, z in rows))
    terrain = Terrain.from_file(path)
    assert (terrain.end, terrain.name) == (rows[-1][0], "ground.csv")
    breaks = dict(rows[:-1])  # the later sample of a step counts
    assert dict(zip(terrain.x, terrain.z, strict=True)) == breaks
    assert terrain.height(rows[-1][0]) == pytest.approx(rows[-1][1], abs=1e-12)
    steps = [there[1] - here[1] for here, there in itertools.pairwise(rows) if there[0] == here[0]]
    assert [r for r in terrain.rises if r] == pytest.approx(steps, abs=1e-12)
    assert Terrain.from_dict(json.loads(json.dumps(terrain.to_dict()))) == terrain
    assert parse_terrain(str(path)) == terrain


CSV = """# a survey
distance (m), elevation (m)

-1.0, 0.25   # behind the start
 0.5, 0.25
 0.5, 0.20
"2.0", 0.15
"""


@pytest.mark.parametrize("encode", [lambda t: t.encode("utf-8-sig"), lambda t: t.replace("\n", "\r\n").encode()])
def test_an_elevation_file(tmp_path: Path, encode: Any) -> None:
    path = tmp_path / "survey.CSV"
    path.write_bytes(encode(CSV))
    terrain = Terrain.from_file(str(path))
    assert (terrain.x, terrain.z, terrain.end) == ((-1.0, 0.5), (0.25, 0.20), 2.0)
    assert terrain.rises == pytest.approx((0.0, -0.05))
    assert terrain.angle == pytest.approx((0.0, math.atan2(0.05, 1.5)))
    assert terrain.height(5.0) < 0.15  # continued; the engines end the walk


@pytest.mark.parametrize(
    ("suffix", "text"),
    [
        (".toml", "segments = [[1, 2.0, 0], [2.0, -1.0, 0.01], [0.5, -3]]"),
        (".toml", "[[segments]]\nlength=1\nslope_deg=2\n[[segments]]\nlength=2\nslope_deg=-1\nstep=0.01\n"
                  "[[segments]]\nlength=0.5\nslope_deg=-3\n"),
        (".yaml", "segments: [[1, 2.0, 0], [2.0, -1.0, 1e-2], [0.5, -3]]"),
        (".yml", "segments:\n- {length: 1, slope_deg: 2}\n- {step: 0.01, slope_deg: -1, length: 2}\n- [0.5, -3]\n"),
    ],
)  # fmt: skip
def test_segment_files(tmp_path: Path, suffix: str, text: str) -> None:
    path = tmp_path / f"mine{suffix}"
    path.write_text(text)
    assert Terrain.from_file(path) == Terrain.from_segments(THREE, name=f"mine{suffix}")


@pytest.mark.parametrize(
    ("suffix", "text", "message"),
    [
        (".csv", " \n\n", "the file is empty"),
        (".csv", "x,z\n", "0 elevation sample"),
        (".csv", "0,0\n1,0,0\n", r"line 2: 3 column\(s\) in '1,0,0'"),
        (".csv", "0,0\n\n# c\n1,high\n", "line 4: z = 'high': must be a finite number"),
        (".csv", "x,z\nx,z\n0,0\n1,0\n", "line 2: x = "),
        (".csv", "zero,0\n1,0\n", "line 1: x = "),
        (".csv", "z,x\n0,0\n1,0\n", "line 1: the header reads z, x.*swap the columns"),
        (".csv", "0,0\n2,0\n1,0\n", "line 3: x = 1 m comes after 2 m; sort"),
        (".csv", "0,0\n1,0\n1,0\n2,0\n", "line 3: repeats the sample of line 2"),
        (".csv", "0,0\n0,0.1\n1,0\n", "line 2: a vertical step at an end.*drop line 1"),
        (".csv", "0,0\n1,0\n1,0.1\n", "line 3: a vertical step at an end"),
        (".csv", "0,0\n1,0\n1,0.1\n1,0.2\n2,0\n", "line 4: .*three rows"),
        (".csv", "0,0\n1,0\n1,0.6\n2,0.6\n", "lines 2 to 3: the step = 0.(6|5999+): must be from -0.5 to 0.5 m"),
        (".csv", "0,0\n1,0\n2,0.9\n", "lines 2 to 3: a slope of -41.99 degrees is steeper"),
        (".csv", "5,0\n6,0\n", "from x = 5 to 6 m, but the robot starts at x = 0; subtract"),
        (".csv", "0,0\n2e5,0\n", "line 2: x = 200000.0: "),
        (".toml", "segments = [[1, 0],\n[1, 0 0]]", "not readable as TOML: .*line 2"),
        (".toml", "segments = " + "[" * 3000 + "]" * 3000, "not readable as TOML"),
        (".yaml", "segments: [[1, 0]\nfoo", "not readable as YAML: .*line 2"),
        (".yaml", "!!python/object/apply:os.getcwd []", "holds no table"),
        (".yaml", "segments: [&a [1, *a]]", "not readable as YAML: .*recursive"),
        (".toml", "# nothing", "'segments' is missing; expected segments = "),
        (".toml", "segmets = []", "unknown key 'segmets': valid are segments; did you mean 'segments'"),
        (".toml", "segments = [3]", "segment 1 is 3"),
        (".toml", "segments = [[1, 0], [1, nan]]", "segment 2: slope"),
        (".yaml", "segments: [[yes, 0]]", "segment 1: length"),
        (".toml", "segments = [{length = 1, slope = 2}]", "segment 1 has .length, slope.; expected"),
        (".toml", "segments = [{length = 1, slope_deg = 2, high = 3}]", "has .length, slope_deg, high."),
        (".csv", "0,0\n1,\udcff\n", "line 2: not UTF-8"),
        (".toml", "0,0\n1,0\n\0\n", "line 3: binary"),
    ],
)  # fmt: skip
def test_files_with_an_error_are_refused(tmp_path: Path, suffix: str, text: str, message: str) -> None:
    path = tmp_path / f"bad{suffix}"
    path.write_bytes(text.encode(errors="surrogateescape"))
    with pytest.raises(InputError, match=f"terrain file .*bad{suffix}: .*{message}"):
        Terrain.from_file(path)


def test_paths_that_hold_no_terrain_are_refused(tmp_path: Path) -> None:
    (tmp_path / "folder.csv").mkdir()
    (tmp_path / "loop.csv").symlink_to(tmp_path / "loop.csv")
    for name, message in (
        ("missing.toml", "no such file"),
        ("folder.csv", "is a folder"),
        ("loop.csv", "cannot be read"),
        ("ground", "unknown suffix ''"),
        ("\0.csv", "cannot be read"),
    ):
        with pytest.raises(InputError, match=message):
            Terrain.from_file(tmp_path / name)
    with pytest.raises(InputError, match="given as its path"):
        Terrain.from_file(None)  # type: ignore[arg-type]
