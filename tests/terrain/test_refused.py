"""What makes no terrain is refused, by a message that names the quantity or the line."""

from collections.abc import Callable
from functools import partial
from pathlib import Path
from typing import Any

import pytest

from mjbiped.errors import InputError
from mjbiped.terrain.profile import MOST_SEGMENTS, STEEPEST_SLOPE
from mjbiped.terrain.terrain import Terrain, parse_terrain

PARAMETERS: list[tuple[str, dict[str, Any], str]] = [
    ("incline", {"slope_deg": 40}, "terrain incline: slope_deg: a slope of 40 degrees"),
    ("stairs", {"tread": 0.0}, "tread = 0.0: must be from 1e-06 to 100000 m"),
    ("slopes", {"change_deg": 3.0}, "start_deg . 16 x change_deg: a slope of 48 degrees"),
    ("random", {"length": 1e5, "segment_length": (1e-4, 2.0)}, "can be more than"),
    ("random", {"segment_length": (2.0, 1.0)}, "swap them"),
    ("random", {"roughness": 0.4}, "steeper than the robot can stand on"),
    ("treads", {"tread": 1e-3}, "segments; choose a shorter length or a longer tread"),
    ("waves", {"spacing": 0.2}, "four times spacing"),
    ("recorded", {}, "recorded ground needs an elevation file"),
    ("recorded", {"file": Terrain.level()}, "goes on without end; expected an elevation file"),
    ("recorded", {"file": Terrain((0.0,), (0.0,), (0.0,), end=3.0)}, "is a record of 3 m; at least 5 m are needed"),
]
TEXTS = [
    ("stair:tread=1.8", "did you mean 'stairs'.*path of a terrain file"),
    ("stairs:tread=1,tread=2", "given twice"),
    ("random:slope_deg=1..2..3", "no number"),
    ("random:slope_deg=2", "range .low, high., on the command line low..high"),
    ("stairs:tred=1", "unknown parameter of the terrain stairs 'tred'.*did you mean 'tread'"),
    ("missing.csv", "terrain file missing.csv: there is no such file"),
    ("ground.txt", r"unknown suffix '.txt': valid are .csv, .asc, .toml, .yaml, .yml"),
]
SEGMENTS: list[tuple[Any, str]] = [
    ([], "there are no segments"),
    ("1,2,3", "must be a list"),
    ([(1.0, 0.0), (-1.0, 0.0)], "segment 2: length"),
    ([(1.0, 0.0), (1.0, 38.7)], r"segment 2: slope: .*steeper than the robot can stand on at friction 0.8"),
    ([(1.0, 0.0), (1.0, 0.0, -0.6)], "segment 2: step = -0.6: must be from -0.5 to 0.5 m"),
    ([(9e4, 0.0), (9e4, 0.0), (1.0, 0.0)], "segment 3: x"),
]
MANY = MOST_SEGMENTS + 1
FIELDS: list[tuple[dict[str, Any], str]] = [
    ({"x": ()}, "at least one"),
    ({"z": [0.0, 1.0]}, "the same number of entries"),
    ({"z": (2e5,)}, "segment 1: z = 200000.0: must be from -100000 to 100000 m"),
    ({"angle": (STEEPEST_SLOPE,)}, "segment 1: a slope"),
    ({"angle": (-STEEPEST_SLOPE,)}, "segment 1: a slope"),
    ({"x": (1.0,)}, "starts at x = 0"),
    ({"x": (0.0, 0.0), "z": (0.0, 0.0), "angle": (0.0, 0.0)}, "length > 0"),
    ({"x": (0.0, 1.0), "z": (0.0, 0.6), "angle": (0.0, 0.0)}, "segment 2: its step"),
    ({"x": tuple(range(MANY)), "z": (0.0,) * MANY, "angle": (0.0,) * MANY}, "at most"),
    ({"name": 5}, "name = 5: must be text"),
    ({"parameters": [["alone"]]}, "pairs of a name and a value"),
    ({"parameters": [["a", {"b": 1}]]}, "parameter holds"),
]
MADE: list[tuple[Callable[[], object], str]] = [
    *((partial(Terrain.preset, name, **parameters), message) for name, parameters, message in PARAMETERS),
    *((partial(parse_terrain, text), message) for text, message in TEXTS),
    *((partial(Terrain.from_segments, rows), message) for rows, message in SEGMENTS),
    *(
        (partial(Terrain, **{"x": (0.0,), "z": (0.0,), "angle": (0.0,), **fields}), message)
        for fields, message in FIELDS
    ),
    (partial(Terrain.from_dict, {**Terrain.level().to_dict(), "more": 1}), "a mapping with x, z, angle, end, name, pa"),
    (partial(Terrain.from_file, None), "given as its path"),  # type: ignore[arg-type]
    *(
        (partial(ask, x), "must be numbers in m")
        for ask in (Terrain.level().height, Terrain.level().slope)
        for x in ("1.0", ["a"], None, True, 1j, [[1.0], [1.0, 2.0]])
    ),
]  # fmt: skip


@pytest.mark.parametrize(("make", "message"), MADE)
def test_what_is_outside_its_domain_is_refused(make: Callable[[], object], message: str) -> None:
    with pytest.raises(InputError, match=message):
        make()


@pytest.mark.parametrize(
    ("suffix", "text", "message"),
    [
        (".csv", " \n\n", "the file is empty"),
        (".csv", "0,0\n1,0,0\n", r"line 2: 3 column\(s\) in '1,0,0'"),
        (".csv", "0,0\n\n# c\n1,high\n", "line 4: z = 'high': must be a finite number"),
        (".csv", "z,x\n0,0\n1,0\n", "line 1: the header reads z, x.*swap the columns"),
        (".csv", "0,0\n2,0\n1,0\n", "line 3: x = 1 m comes after 2 m; sort"),
        (".csv", "0,0\n1,0\n1,0\n2,0\n", "line 3: repeats the sample of line 2"),
        (".csv", "0,0\n0,0.1\n1,0\n", "line 2: a vertical step at an end.*drop line 1"),
        (".csv", "0,0\n1,0\n1,0.1\n1,0.2\n2,0\n", "line 4: .*three rows"),
        (".csv", "0,0\n1,0\n1,0.6\n2,0.6\n", "lines 2 to 3: the step = 0.(6|5999+): must be from -0.5 to 0.5 m"),
        (".csv", "0,0\n1,0\n2,0.9\n", "lines 2 to 3: a slope of -41.99 degrees is steeper"),
        (".csv", "5,0\n6,0\n", "from x = 5 to 6 m, but the robot starts at x = 0; subtract"),
        (".csv", "0,0\n1,\udcff\n", "line 2: not UTF-8"),
        (".toml", "0,0\n1,0\n\0\n", "line 3: binary"),
        (".toml", "segments = [[1, 0],\n[1, 0 0]]", "not readable as TOML: .*line 2"),
        (".toml", "# nothing", "'segments' is missing; expected segments = "),
        (".toml", "segmets = []", "unknown key 'segmets': valid are segments; did you mean 'segments'"),
        (".yaml", "segments: [[1, 0]\nfoo", "not readable as YAML: .*line 2"),
        (".yaml", "!!python/object/apply:os.getcwd []", "holds no table"),
        (".yaml", "segments: [&a [1, *a]]", "not readable as YAML: .*recursive"),
    ],
)
def test_files_with_an_error_are_refused(tmp_path: Path, suffix: str, text: str, message: str) -> None:
    path = tmp_path / f"bad{suffix}"
    path.write_bytes(text.encode(errors="surrogateescape"))
    with pytest.raises(InputError, match=f"terrain file .*bad{suffix}: .*{message}"):
        Terrain.from_file(path)


def test_paths_that_hold_no_file_are_refused(tmp_path: Path) -> None:
    (tmp_path / "folder.csv").mkdir()
    (tmp_path / "loop.csv").symlink_to(tmp_path / "loop.csv")
    for name, message in (("folder.csv", "is a folder"), ("loop.csv", "cannot be read"), ("\0.csv", "cannot be read")):
        with pytest.raises(InputError, match=message):
            Terrain.from_file(tmp_path / name)
