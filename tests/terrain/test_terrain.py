"""Tests of `mjbiped.terrain`, its segments and its files."""

import itertools
import json
import math
import timeit
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from mjbiped.errors import InputError
from mjbiped.terrain.profile import GROUND_FRICTION, HIGHEST_STEP, MOST_SEGMENTS, STEEPEST_SLOPE
from mjbiped.terrain.terrain import STEP_RESOLUTION, Terrain, parse_terrain

STEPS = st.one_of(st.just(0.0), st.floats(-0.5, 0.5).filter(lambda s: abs(s) > 1e-6))
SEGMENTS = st.lists(st.tuples(st.floats(0.01, 20.0), st.floats(-38.0, 38.0), STEPS), min_size=1, max_size=12)
PLACES = st.floats(-30.0, 300.0)
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


@given(SEGMENTS)
def test_stretches_part_the_segments_at_the_steps(rows: list[tuple[float, float, float]]) -> None:
    terrain = Terrain.from_segments(rows)
    stretches = list(terrain.stretches())
    assert [i for stretch in stretches for i in stretch] == list(range(len(rows)))
    assert [s.start for s in stretches[1:]] == [i for i, rise in enumerate(terrain.rises) if rise != 0.0]
    assert all(len(s) >= 1 for s in stretches)


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


def test_steps_may_be_left_out() -> None:
    assert Terrain.from_segments([(1, 2), (2, 3)]) == Terrain.from_segments([(1.0, 2.0, 0.0), [2.0, 3.0, 0]])


def test_a_step_at_the_start_is_right_continuous() -> None:
    terrain = Terrain((-1.0, 0.0), (0.0, -0.1), (0.0, 0.02))
    assert terrain.height(0.0) == -0.1
    assert terrain.slope(0.0) == 0.02
    assert terrain.rises == (0.0, -0.1)


def test_the_highest_step_is_allowed_whatever_the_rounding() -> None:
    terrain = Terrain.from_segments([(1.0, 1.25, -0.5), (1.0, 0.0, -HIGHEST_STEP)])
    assert terrain.rises[1] < -HIGHEST_STEP  # by rounding: the property test of the record found it


def test_rounding_is_no_step() -> None:
    terrain = Terrain((0.0, 1.0, 2.0), (0.0, STEP_RESOLUTION / 2, 1e-8), (0.0, 0.0, 0.0))
    assert terrain.rises[1] == 0.0
    assert terrain.rises[2] != 0.0
    assert list(terrain.stretches()) == [range(0, 2), range(2, 3)]


# ---- asking ---------------------------------------------------------------------------------------------------------


@given(SEGMENTS, st.lists(PLACES, max_size=20))
def test_scalars_and_arrays_agree_bit_by_bit(rows: list[tuple[float, float, float]], places: list[float]) -> None:
    terrain = Terrain.from_segments(rows)
    places += terrain.x
    assert bits(terrain.height(np.array(places))) == bits([terrain.height_at(x) for x in places])
    assert bits(terrain.slope(np.array(places))) == bits([terrain.slope_at(x) for x in places])
    assert bits([terrain.height(x) for x in places]) == bits([terrain.height_at(x) for x in places])
    assert bits([terrain.slope(x) for x in places]) == bits([terrain.slope_at(x) for x in places])
    assert [terrain.angle[terrain.segment_at(x)] for x in places] == [terrain.slope_at(x) for x in places]


@pytest.mark.parametrize("x", [1.0, 2, np.float64(1.0), np.float32(1.0), np.array(1.0)])
def test_a_scalar_gives_a_plain_float(x: float) -> None:
    terrain = Terrain.mixed()
    assert type(terrain.height(x)) is float
    assert type(terrain.slope(x)) is float


@pytest.mark.parametrize("shape", [(0,), (1,), (5,), (2, 3)])
def test_arrays_keep_their_shape(shape: tuple[int, ...]) -> None:
    x = np.linspace(-1.0, 9.0, math.prod(shape)).reshape(shape)
    assert Terrain.mixed().height(x).shape == shape
    assert Terrain.mixed().slope(x).shape == shape
    assert Terrain.mixed().slope(x).dtype == np.float64


def test_sequences_and_integers_are_taken_as_arrays() -> None:
    terrain = Terrain.incline(3.0)
    assert terrain.height([0.0, 1.0]).tolist() == [0.0, -math.tan(math.radians(3.0))]
    assert terrain.slope(np.arange(3)).tolist() == [math.radians(3.0)] * 3


def test_nan_gives_nan_and_warns_of_nothing() -> None:
    terrain = Terrain.stairs()
    x = np.array([math.nan, 0.0, math.inf])
    assert np.isnan(terrain.height(x)).tolist() == [True, False, True]
    assert np.isnan(terrain.slope(x)).tolist() == [True, False, False]
    for ask in (terrain.height, terrain.slope, terrain.height_at, terrain.slope_at):
        assert math.isnan(ask(math.nan))


@pytest.mark.parametrize("x", ["one", "1.0", ["a"], None, True, 1j, {"x": 1}, [[1.0], [1.0, 2.0]]])
def test_places_that_are_no_numbers_are_refused(x: Any) -> None:
    for ask in (Terrain.level().height, Terrain.level().slope):
        with pytest.raises(InputError, match="must be numbers in m"):
            ask(x)


def test_the_scalar_accessors_are_fast() -> None:
    terrain = Terrain.random()
    terrain.height_at(1.0)
    assert min(timeit.repeat(lambda: terrain.height_at(12.3), number=1000, repeat=5)) / 1000 < 20e-6


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


def test_the_record_keeps_an_end_and_every_parameter() -> None:
    terrain = Terrain((0.0,), (0.0,), (0.1,), end=5.0, name="mine", parameters=(("a", (1, 2.5, None)), ("b", "text")))
    again = Terrain.from_dict(json.loads(json.dumps(terrain.to_dict())))
    assert again == terrain
    assert again.end == 5.0
    assert again.parameters == (("a", (1, 2.5, None)), ("b", "text"))


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


def test_a_terrain_cannot_be_changed() -> None:
    with pytest.raises(AttributeError):
        Terrain.level().end = 3.0  # type: ignore[misc]


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"surprise": 1}, "must be a mapping with x, z, angle, end, name, parameters, got"),
        ({"x": None}, "not a terrain's record"),
        ({"z": [0.0, 1.0]}, "as many starts"),
        ({"x": ["a"]}, "x = 'a': must be a finite number"),
        ({"end": "far"}, "end"),
        ({"name": 5}, "name = 5: must be text"),
        ({"parameters": [["alone"]]}, "not a terrain's record"),
        ({"parameters": [["a", {"b": 1}]]}, "parameter holds"),
        ({"parameters": [["a", math.nan]]}, "parameter holds"),
    ],
)
def test_a_spoilt_record_is_refused(change: dict[str, Any], message: str) -> None:
    with pytest.raises(InputError, match=message):
        Terrain.from_dict({**Terrain.level().to_dict(), **change})


def test_a_record_that_lacks_fields_or_is_none_is_refused() -> None:
    with pytest.raises(InputError, match="must be a mapping with x, z, angle"):
        Terrain.from_dict({"z": [0.0], "name": "a", "parameters": []})
    with pytest.raises(InputError, match="must be a mapping"):
        Terrain.from_dict(5)  # type: ignore[arg-type]


def test_captions_name_what_the_terrain_was_made_with() -> None:
    assert Terrain.level().caption == "level"
    assert Terrain.stairs().caption == "stairs (tread=1.8, rise=-0.06, first=0.9, count=20)"
    assert "slope_deg=-3.0..3.0" in Terrain.random().caption
    assert Terrain.from_segments(THREE).caption == "segments (3 segments)"


# ---- by name, on the command line -----------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("text", "terrain"),
    [
        ("mixed", Terrain.mixed()),
        ("  level ", Terrain.level()),
        ("stairs:tread=1.8,rise=-0.06", Terrain.stairs()),
        ("stairs: tread = 2 , count=3", Terrain.stairs(tread=2.0, count=3)),
        ("incline:slope_deg=-3", Terrain.incline(-3.0)),
        ("random:seed=3,slope_deg=-2..2", Terrain.random(seed=3, slope_deg=(-2.0, 2.0))),
        ("random:segment_length=.5..1.5,rise=-1e-2..0", Terrain.random(segment_length=(0.5, 1.5), rise=(-0.01, 0.0))),
        ("slopes:change_deg=-1,start_deg=3", Terrain.slopes(change_deg=-1.0, start_deg=3.0)),
    ],
)
def test_text_on_the_command_line(text: str, terrain: Terrain) -> None:
    assert parse_terrain(text) == terrain


def test_a_path_on_the_command_line(tmp_path: Path) -> None:
    path = tmp_path / "ground.csv"
    path.write_text("0,0\n1,0.1\n")
    assert parse_terrain(str(path)) == Terrain.from_file(path)


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("", "unknown terrain ''"),
        ("stair", "did you mean 'stairs'.*path of a terrain file"),
        ("stair:tread=1.8", "did you mean 'stairs'"),
        ("moon:x=1", "level, incline, slopes, stairs, mixed, random"),
        ("stairs:", "terrain stairs: cannot read ''"),
        ("stairs:tread", "cannot read 'tread'.*key=value"),
        ("stairs:tread=", "cannot read"),
        ("stairs:=3", "cannot read"),
        ("stairs:tread=1,", "cannot read ''"),
        ("stairs:tread=1,tread=2", "given twice"),
        ("stairs:tread=wide", "'wide' is no number"),
        ("stairs:tread=1_0", "no number"),
        ("random:slope_deg=1..", "no number"),
        ("random:slope_deg=1..2..3", "no number"),
        ("random:slope_deg=2", "range .low, high., on the command line low..high"),
        ("random:slope_deg=3..-3", "swap them"),
        ("stairs:tread=1..2", "tread = .1, 2.: must be a finite number"),
        ("stairs:tread=nan", "finite number"),
        ("stairs:tred=1", "unknown parameter of the terrain stairs 'tred'.*did you mean 'tread'"),
        ("level:slope_deg=1", "valid are none"),
        ("missing.csv", "terrain file missing.csv: there is no such file"),
        ("folder/thing", "unknown suffix ''"),
        ("ground.txt", r"unknown suffix '.txt': valid are .csv, .toml, .yaml, .yml"),
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
        (None, "must be a list"),
        ("1,2,3", "must be a list"),
        ({"length": 1}, "must be a list"),
        ([(1.0,)], "segment 1 is"),
        ([(1.0, 2.0, 0.0, 0.0)], "segment 1 is"),
        ([1.0], "segment 1 is 1.0"),
        ([(1.0, 0.0), "ab"], "segment 2 is 'ab'"),
        ([(0.0, 0.0)], r"segment 1: length = 0.0: must be from 1e-06 to 100000 m"),
        ([(1.0, 0.0), (-1.0, 0.0)], "segment 2: length"),
        ([(math.inf, 0.0)], "length = inf: "),
        ([(math.nan, 0.0)], "length = nan: "),
        ([(10**400, 0.0)], "length = 1000.*: must be a finite number"),
        ([("long", 0.0)], "length = 'long': "),
        ([(True, 0.0)], "length = True: "),
        ([(1 + 0j, 0.0)], "length"),
        ([(1.0, math.nan)], "segment 1: slope"),
        ([(1.0, 0.0), (1.0, 38.7)], r"segment 2: slope: .*steeper than the robot can stand on at friction 0.8"),
        ([(1.0, -38.7)], "expected less than 38.7 degrees"),
        ([(1.0, 89.0)], "steeper"),
        ([(1.0, 180.0)], "slope = 180.0: must be from -89.95 to 89.95 degrees"),
        ([(1.0, 0.0, 0.51)], "segment 1: step = 0.51: must be from -0.5 to 0.5 m"),
        ([(1.0, 0.0), (1.0, 0.0, -0.6)], "segment 2: step"),
        ([(1.0, 0.0), (1.0, 0.0, math.inf)], "segment 2: step"),
        ([(1.0, 0.0), (1.0, 0.0, "-")], "segment 2: step"),
        ([(9e4, 0.0), (9e4, 0.0), (1.0, 0.0)], "segment 3: x"),
        ([(1.0, 0.0), (1e-30, 0.0), (1.0, 0.0)], "segment 2: length = 1e-30: "),
    ],
)
def test_segments_outside_their_domain_are_refused(rows: Any, message: str) -> None:
    with pytest.raises(InputError, match=message):
        Terrain.from_segments(rows)


@pytest.mark.parametrize(
    ("fields", "message"),
    [
        ({"x": ()}, "at least one"),
        ({"x": (0.0, 1.0)}, "as many"),
        ({"angle": (0.0, 0.0)}, "as many"),
        ({"x": (math.nan,)}, "segment 1: x"),
        ({"z": (2e5,)}, "segment 1: z = 200000.0: must be from -100000 to 100000 m"),
        ({"angle": ("flat",)}, "segment 1: angle"),
        ({"angle": (STEEPEST_SLOPE,)}, "segment 1: a slope"),
        ({"angle": (-STEEPEST_SLOPE,)}, "segment 1: a slope"),
        ({"angle": (math.pi,)}, "segment 1: a slope"),
        ({"x": (1.0,)}, "starts at x = 0"),
        ({"end": 0.0}, "length > 0"),
        ({"x": (-1.0,), "end": 0.0}, "starts at x = 0"),
        ({"end": math.nan}, "end"),
        ({"end": -math.inf}, "end"),
        ({"x": (0.0, 0.0), "z": (0.0, 0.0), "angle": (0.0, 0.0)}, "length > 0"),
        ({"x": (0.0, -1.0), "z": (0.0, 0.0), "angle": (0.0, 0.0)}, "length > 0"),
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
    assert math.degrees(STEEPEST_SLOPE) == pytest.approx(38.66, abs=0.01)
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
    assert terrain.end == rows[-1][0]
    assert terrain.name == "ground.csv"
    breaks = dict(rows[:-1])  # the later sample of a step counts
    assert dict(zip(terrain.x, terrain.z, strict=True)) == breaks
    assert terrain.height(rows[-1][0]) == pytest.approx(rows[-1][1], abs=1e-12)
    steps = [there[1] - here[1] for here, there in itertools.pairwise(rows) if there[0] == here[0]]
    assert [r for r in terrain.rises if r] == pytest.approx(steps, abs=1e-12)
    assert Terrain.from_dict(json.loads(json.dumps(terrain.to_dict()))) == terrain


CSV = """# a survey
distance (m), elevation (m)

-1.0, 0.25   # behind the start
 0.5, 0.25
 0.5, 0.20
"2.0", 0.15
"""


@pytest.mark.parametrize(
    "encode", [str.encode, lambda t: t.encode("utf-8-sig"), lambda t: t.replace("\n", "\r\n").encode()]
)
def test_an_elevation_file(tmp_path: Path, encode: Any) -> None:
    path = tmp_path / "survey.CSV"
    path.write_bytes(encode(CSV))
    terrain = Terrain.from_file(str(path))
    assert terrain.x == (-1.0, 0.5)
    assert terrain.z == (0.25, 0.20)
    assert terrain.rises == pytest.approx((0.0, -0.05))
    assert terrain.angle == pytest.approx((0.0, math.atan2(0.05, 1.5)))
    assert terrain.end == 2.0
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
    terrain = Terrain.from_file(path)
    assert terrain == Terrain.from_segments(THREE, name=f"mine{suffix}")


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("", "the file is empty"),
        (" \n\n", "the file is empty"),
        ("x,z\n", "0 elevation sample"),
        ("# nothing\n", "0 elevation sample"),
        ("0,0\n", "1 elevation sample"),
        ("0,0\n1,0,0\n", r"line 2: 3 column\(s\) in '1,0,0'"),
        ("0;0\n", r"line 1: 1 column\(s\)"),
        ("0,0\n\n# c\n1,high\n", "line 4: z = 'high': must be a finite number"),
        ("0,0\nx,z\n1,1\n", "line 2: x = "),
        ("x,z\nx,z\n0,0\n1,0\n", "line 2: x = "),
        ("zero,0\n1,0\n", "line 1: x = "),
        ("0,\n1,0\n", "line 1: z = '': must be a finite number"),
        ("z,x\n0,0\n1,0\n", "line 1: the header reads 'z,x'.*swap the columns"),
        ("0,0\n1,nan\n", "line 2: z = nan: must be a finite number"),
        ("0,0\ninf,0\n", "line 2: x = "),
        ("0,0\n1_0,0\n", "line 2: x = '1_0': "),
        ("0,0\n2,0\n1,0\n", "line 3: x = 1 m comes after 2 m; sort"),
        ("0,0\n1,0\n1,0\n2,0\n", "line 3: repeats the sample of line 2"),
        ("0,0\n0,0.1\n1,0\n", "line 2: a vertical step at the first sample.*drop line 1"),
        ("0,0\n1,0\n1,0.1\n", "line 3: a vertical step at the last sample"),
        ("0,0\n1,0\n1,0.1\n1,0.2\n2,0\n", "line 4: .*three times"),
        ("0,0\n1,0\n1,0.6\n2,0.6\n", "lines 2 to 3: the step = 0.(6|5999+): must be from -0.5 to 0.5 m"),
        ("0,0\n1,0\n2,0.9\n", "lines 2 to 3: a slope of -41.99 degrees is steeper"),
        ("5,0\n6,0\n", "reach from x = 5 m to 6 m, but the robot starts at x = 0.*subtract"),
        ("-5,0\n0,0\n", "the robot starts at x = 0"),
        ("0,0\n2e5,0\n", "line 2: x = 200000.0: "),
        ("0,3e5\n1,3e5\n", "line 1: z = 300000.0: "),
    ],
)
def test_elevation_files_with_an_error_are_refused(tmp_path: Path, text: str, message: str) -> None:
    path = tmp_path / "bad.csv"
    path.write_text(text)
    with pytest.raises(InputError, match=f"terrain file .*bad.csv: .*{message}"):
        Terrain.from_file(path)


@pytest.mark.parametrize(
    ("suffix", "text", "message"),
    [
        (".toml", "", "empty"),
        (".toml", "segments = [[1, 0],\n[1, 0 0]]", "not readable as TOML: .*line 2"),
        (".yaml", "segments: [[1, 0]\nfoo", "not readable as YAML: .*line 2"),
        (".yaml", "!!python/object/apply:os.getcwd []", "holds no table"),
        (".yaml", "- [1, 0]", "holds no table; expected segments: "),
        (".yaml", "# nothing", "holds no table"),
        (".toml", "# nothing", "'segments' is missing; expected segments = "),
        (".toml", "segmets = []", "unknown key 'segmets': valid are segments; did you mean 'segments'"),
        (".yaml", "3: 4", "unknown key '3': valid are segments"),
        (".toml", "segments = 3", "'segments' is 3"),
        (".toml", "segments = []", "there are no segments"),
        (".toml", "segments = [3]", "segment 1 is 3"),
        (".toml", "segments = [[1]]", "segment 1 is"),
        (".toml", "segments = [[1, 0], [1, 0, 0, 0]]", "segment 2 is"),
        (".toml", "segments = [[1, 0], [0, 0]]", "segment 2: length"),
        (".toml", "segments = [[1, 0], [1, nan]]", "segment 2: slope"),
        (".toml", "segments = [[1, 45]]", "segment 1: slope: .*steeper"),
        (".toml", 'segments = [["1", 0]]', "segment 1: length"),
        (".yaml", "segments: [[yes, 0]]", "segment 1: length"),
        (".yaml", "segments: [[2020-01-01, 0]]", "segment 1: length"),
        (".yaml", "segments: [&a [1, *a]]", "not readable as YAML: .*recursive"),
        (".toml", "segments = [{length = 1, slope = 2}]",
         "segment 1: unknown key 'slope': valid are length, slope_deg, step; did you mean 'slope_deg'"),
        (".toml", "segments = [{length = 1}]", "segment 1: 'slope_deg' is missing"),
        (".toml", "segments = [{slope_deg = 1}]", "segment 1: 'length' is missing"),
        (".toml", "segments = " + "[" * 3000 + "]" * 3000, "not readable as TOML"),
    ],
)  # fmt: skip
def test_segment_files_with_an_error_are_refused(tmp_path: Path, suffix: str, text: str, message: str) -> None:
    path = tmp_path / f"bad{suffix}"
    path.write_text(text)
    with pytest.raises(InputError, match=f"terrain file .*bad{suffix}: .*{message}"):
        Terrain.from_file(path)


@pytest.mark.parametrize("suffix", [".csv", ".toml", ".yaml"])
@pytest.mark.parametrize(
    ("data", "message"), [(b"0,0\n1,\xff\n", "line 2: not UTF-8"), (b"0,0\n1,0\n\0\n", "line 3: binary")]
)
def test_binary_files_are_refused(tmp_path: Path, suffix: str, data: bytes, message: str) -> None:
    path = tmp_path / f"bad{suffix}"
    path.write_bytes(data)
    with pytest.raises(InputError, match=message):
        Terrain.from_file(path)


def test_paths_that_hold_no_terrain_are_refused(tmp_path: Path) -> None:
    (tmp_path / "folder.csv").mkdir()
    (tmp_path / "loop.csv").symlink_to(tmp_path / "loop.csv")
    (tmp_path / "ground.xyz").write_text("0,0\n1,0\n")
    for name, message in (
        ("missing.toml", "no such file"),
        ("folder.csv", "is a folder"),
        ("loop.csv", "cannot be read"),
        ("ground.xyz", "unknown suffix '.xyz'"),
        ("ground", "unknown suffix ''"),
        ("\0.csv", "cannot be read"),
    ):
        with pytest.raises(InputError, match=message):
            Terrain.from_file(tmp_path / name)
    with pytest.raises(InputError, match="given as its path"):
        Terrain.from_file(None)  # type: ignore[arg-type]
