"""Terrain and study files that nobody would write: each is one, or is refused in words, and soon.

The damage is seeded: a case that fails is the same again. `make test-slow` tries many more.
"""

import random
import re
from collections.abc import Callable, Iterable, Iterator
from pathlib import Path

import pytest
from time_limits import within

from mjbiped import InputError, Terrain
from mjbiped.studies import plan as plans
from mjbiped.studies.plan import Study, read_study
from mjbiped.studies.run import columns_of
from mjbiped.studies.store import opened

LONGEST_MESSAGE = 1000

CSV = "x (m),z (m)\n-1.0,0.25 # behind\n0.5,0.25\n0.5,0.20\n2.0,0.15\n3.5,1e-1\n"
TOML = "# a path\nsegments = [[2.0, 0.0, 0.0], [1.5, 2.0, -0.01], {length = 3, slope_deg = -1.0, step = 0.005}]\n"
YAML = "segments:\n- [2.0, 0.0, 0.0]\n- {length: 1.5, slope_deg: 2.0, step: -0.01}\n- &last [3.0, -1.0]\n- *last\n"
ASC = "ncols 3\nnrows 2\nxllcorner -1.5\nyllcorner -1\ncellsize 1\nNODATA_value -9999\n0 0.1 0.05\n-0.1 0 0\n"
STUDY = """seed = 7
samples = 3
engine = "hybrid"
steps = [3, 6]
initial = { around = "rest", q1 = { normal = [0.0, 0.01] }, dq1 = { uniform = [-0.1, 0.1] } }
controller = { position_gain = { from = 2.0, to = 8.0, count = 3 }, replanning_delay = [0.8, "none"] }
robot = { hip_mass = { log_uniform = [0.1, 10.0] } }
[[terrain]]
name = "random"
seed = { integer = [0, 9] }
slope_deg = { plus_minus = 2.0 }
rise = "-0.02..0.005"
[[terrain]]
name = "stairs"
rise = [-0.01, 0.01]
[plot]
measures = ["steps", "cost_of_transport"]
"""

NUMBERS = (
    "nan", "inf", "-inf", ".inf", "1e308", "-1e308", "1e-320", "1e400", "0", "-0.0", "9" * 80, "-" + "9" * 5000,
    "0x" + "f" * 5000, "1_000", "18446744073709551616", "true", "null", "1979-05-27", "1979-05-27T07:32:00Z",
    "07:32:00", "'1'", '""', "[1, 2]", "{}", "{ from = 0, to = 1e308, count = 999999999 }",
    "{ uniform = [-1e308, 1e308] }", "{ normal = [0, 1e308] }", "{ log_uniform = [1e-320, 1e308] }",
    "{ integer = [-9223372036854775808, 9223372036854775807] }", "{ plus_minus = 1e308 }", '"low..high"',
    '"1..1e309"',
)  # fmt: skip
TAGS = ["bool", "int", "float", "null", "timestamp", "binary", "omap", "pairs", "set", "str", "seq", "map", "merge"]
TAGGED = (
    *(f"!!{tag} {value}" for tag in TAGS for value in ("x", "''", "[1]", "{a: 1}", "é", "")),
    "!!python/object/apply:os.getcwd []",
    "!!python/name:os.system",
    "!unknown 1",
    "!<tag:yaml.org,2002:float> x",
)


def merges_of_merges(levels: int) -> str:
    """Ten to the power of the levels keys, if they were merged."""
    lines = ["a0: &a0 {x: 1, y: 2}"]
    lines += [f"a{n}: &a{n} {{<<: [{', '.join([f'*a{n - 1}'] * 10)}]}}" for n in range(1, levels)]
    return "\n".join(lines)


NASTY_YAML = (
    *(f"segments: [[{value}, 0]]" for value in (*NUMBERS, *TAGGED)),
    merges_of_merges(12),
    "segments: " + "[" * 100_000,
    "segments: &s [*s]",
    "segments: [[1, 0]]\n---\nsegments: [[1, 0]]",
    "\x07",
)
NASTY_TOML = (
    *(f"segments = [[{value}, 0]]" for value in NUMBERS),
    "segments = " + "[" * 100_000,
    "segments" + ".a" * 5000 + " = 1",
    "[segments]\nlength = 1",
)
NASTY_ASC = (
    *(ASC.replace(old, f"{old.split()[0]} {value}") for old in ASC.splitlines()[:6] for value in NUMBERS),
    ASC.replace("0.05", "0 " * 1_000_000),
    "\n" * 100_000 + "0 0",
)
NASTY_CSV = (
    *(f"0,0\n1,{value}\n" for value in NUMBERS),
    "0,0\n" * 2000,
    "," * 100_000,
    "\n" * 100_000 + "0,0",
    "0,0\n5e-324,0\n1,0\n",
)
KEYS = ("seed", "samples", "steps", "distance", "timestep", "engine", "initial", "terrain", "plot")
NASTY_STUDIES = (
    *(f"{key} = {value}" for key in KEYS for value in NUMBERS),
    *(f"controller = {{ position_gain = {value} }}" for value in NUMBERS),
    *(f"robot = {{ upper_length = {value} }}" for value in NUMBERS),
    *(f"samples = 2\nterrain = {{ name = 'random', rise = {value} }}" for value in NUMBERS),
    *(f"terrain = {{ file = {value} }}" for value in NUMBERS),
    *(f"initial = {{ around = 'rest', q1 = {value} }}" for value in NUMBERS),
    "terrain = { file = '/' }",
    "terrain = { file = '\\u0000.csv' }",
    "controller = { " + ", ".join(f"{name} = {{ from = 1, to = 2, count = 100000 }}"
                                  for name in ("position_gain", "velocity_gain", "adaptation_gain")) + " }",
    "terrain = " + "[" * 100_000,
)  # fmt: skip


def damaged(text: str, tokens: tuple[str, ...], chance: random.Random) -> str:
    """A text with one to four things done to it."""
    for _ in range(chance.randint(1, 4)):
        at, to = sorted(chance.randrange(len(text) + 1) for _ in range(2))
        numbers = [*re.finditer(r"-?\d+(\.\d+)?(e-?\d+)?", text)]
        match chance.randrange(6):
            case 0:
                text = text[:at] + text[to:]
            case 1:
                text = text[:at] + chance.choice(" \n\t,;:[]{}=#\"'&*!|>%@`.-_\0\x7f\u2028é") + text[at:]
            case 2 if numbers:
                number = chance.choice(numbers)
                text = text[: number.start()] + chance.choice(tokens) + text[number.end() :]
            case 3:
                text = text[:at] + text[at:to] * chance.randint(2, 9) + text[to:]
            case 4:
                lines = text.splitlines(keepends=True)
                chance.shuffle(lines)
                text = "".join(lines)
            case _:
                text = text[:at] + chance.choice(tokens) + text[at:]
    return text


def cases(suffix: str, count: int) -> Iterator[str]:
    """The nasty texts of a kind of file, and damaged ones of a seed."""
    text, nasty, tokens = {
        ".csv": (CSV, NASTY_CSV, NUMBERS),
        ".asc": (ASC, NASTY_ASC, NUMBERS),
        ".toml": (TOML, NASTY_TOML, NUMBERS),
        ".yaml": (YAML, NASTY_YAML, (*NUMBERS, *TAGGED)),
        "study": (STUDY, NASTY_STUDIES, NUMBERS),
    }[suffix]
    yield text
    yield from nasty
    chance = random.Random(f"{suffix} {count}")
    for _ in range(count):
        yield damaged(text, tokens, chance)


def read_all(texts: Iterable[str], path: Path, read: Callable[[Path], Terrain | Study]) -> None:
    """Read each text from a file, the first of which is a good one; all others may be refused in words."""
    for number, text in enumerate(texts):
        path.write_text(text, encoding="utf-8")
        message = path.name
        try:
            with within(5.0, text[:300]):
                assert isinstance(read(path), Terrain | Study)
        except InputError as refused:
            message = str(refused)
        except Exception as error:
            raise AssertionError(f"{type(error).__name__}: {error} of {text[:300]!r}") from error
        assert number > 0 or message == path.name
        assert path.name in message, text[:300]  # which file it is
        assert len(message) < LONGEST_MESSAGE, text[:300]


@pytest.mark.slow
@pytest.mark.parametrize("count", [100, 5000])
@pytest.mark.parametrize("suffix", [".csv", ".asc", ".toml", ".yaml"])
def test_terrain_files(suffix: str, count: int, tmp_path: Path) -> None:
    read_all(cases(suffix, count), tmp_path / f"ground{suffix}", Terrain.from_file)


@pytest.mark.slow
@pytest.mark.parametrize("count", [100, 3000])
def test_study_files(count: int, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(plans, "MOST_CELLS", 500)  # what takes long is many walks, and those are not to be checked here
    (tmp_path / "study.toml").write_text(STUDY)
    with opened(tmp_path / "table", "study", columns_of(read_study(tmp_path / "study.toml")), {}) as store:
        assert store.rows() == []  # it takes no column twice
    read_all(cases("study", count), tmp_path / "study.toml", read_study)
