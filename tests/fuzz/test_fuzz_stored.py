"""Damaged records and tables of studies, thousands of them: each is refused in words, or is as good as any.

A case is a number, which seeds everything; `make test` tries the first few, `make test-slow` all.
"""

import contextlib
import io
import json
import math
import random
import tomllib
import zipfile
from collections.abc import Callable
from pathlib import Path
from typing import Any, TypeAlias

import numpy as np
import pytest
from time_limits import within

import mjbiped
from controllers import AdaptiveController, PassiveController
from mjbiped import InputError, MjbipedError, RecordError, Walk
from mjbiped.analysis.stability import stability
from mjbiped.plotting.walk import plot_walk
from mjbiped.records import measures
from mjbiped.reports.page import flattened
from mjbiped.studies.cell import MEASURES
from mjbiped.studies.plan import plan
from mjbiped.studies.run import columns_of
from mjbiped.studies.store import opened

Members: TypeAlias = dict[str, bytes]
"""The members of a record's archive."""

FEW, MANY = 100, 4000
LONGEST = 20.0  # s for one case, of which the slowest good one takes 1 s on a machine at rest
LONGEST_MESSAGE = 900  # characters: a path, and what is wrong

NASTY: tuple[Any, ...] = (
    None, True, False, 0, -1, 1, 2, 3.5, -0.0, 1e308, -1e308, 1e-308, math.nan, math.inf, -math.inf, 10**30, 10**400,
    "", "x", "rest", "mixed", "finished", "\ud800", "\0", "$x^2$", "a\nb", "x" * 5000, [], {}, [[]], [1.0], [0.0, 0.0],
    [1, 2, 3], [math.nan] * 2, ["a"] * 4, {"name": "x"}, {"x": 1}, [[[[[[[[[[[[]]]]]]]]]]]],
)  # fmt: skip


def change_bytes(draw: random.Random, content: bytes) -> bytes:
    """Some bytes changed, or cut out."""
    changed, action = bytearray(content), draw.randrange(3)
    first, last = sorted(draw.randrange(len(content)) for _ in range(2))
    if action == 0:
        for _ in range(draw.choice((1, 3, 10, 100))):
            changed[draw.randrange(len(changed))] = draw.randrange(256)
    elif action == 1:
        return draw.choice((content[:first], content[first:], content[:first] + content[last:]))
    else:  # where something stands, and not in what is empty
        used = [place for place, byte in enumerate(content) if byte]
        for _ in range(draw.choice((1, 1, 2, 8))):
            changed[draw.choice(used)] ^= 1 << draw.randrange(8)
    return bytes(changed)


def within_limits(what: object, do: Callable[[], bool]) -> bool:
    try:
        with within(LONGEST, what):
            return do()
    except Exception as error:
        raise AssertionError(f"case {what}: {error!r}") from error


# ---- records ---------------------------------------------------------------------------------------------------------


@pytest.fixture(scope="module")
def records(controller: AdaptiveController, tmp_path_factory: pytest.TempPathFactory) -> list[bytes]:
    """Sound records: of both engines, of walks and falls, with and without samples."""
    level, path = mjbiped.Terrain.level(), tmp_path_factory.mktemp("records") / "walk.npz"
    contents = []
    for walk in (
        mjbiped.walk(controller, mjbiped.Terrain.mixed(), steps=2, initial="rest", sample_period=0.02),
        mjbiped.walk(controller, mjbiped.Terrain.mixed(), engine="hybrid", steps=3, sample_period=0.01),
        mjbiped.walk(controller, level, engine="hybrid", steps=2, sample_period=None),
        mjbiped.walk(PassiveController(), level, initial=(-0.3, 0.3, 0.0, 0.0), sample_period=0.05),
    ):
        walk.save(path)
        contents.append(path.read_bytes())
    return contents


def members_of(content: bytes) -> Members:
    with zipfile.ZipFile(io.BytesIO(content)) as archive:
        return {name: archive.read(name) for name in archive.namelist()}


def packed(members: Members) -> bytes:
    stream = io.BytesIO()
    with zipfile.ZipFile(stream, "w", zipfile.ZIP_DEFLATED) as archive:
        for name, content in members.items():
            archive.writestr(name, content)
    return stream.getvalue()


def bytes_of(array: np.ndarray) -> bytes:
    stream = io.BytesIO()
    np.save(stream, array, allow_pickle=True)
    return stream.getvalue()


def places_of(value: Any, path: tuple[Any, ...] = ()) -> list[tuple[Any, ...]]:
    """Where something stands in nested JSON."""
    items = value.items() if isinstance(value, dict) else enumerate(value[:4]) if isinstance(value, list) else ()
    return [path, *(place for key, part in items for place in places_of(part, (*path, key)))]


def change_array(draw: random.Random, content: bytes) -> bytes:
    members = members_of(content)
    name = draw.choice([name for name in members if name != "header.npy"])
    array = np.load(io.BytesIO(members[name]))
    if array.size and draw.random() < 0.5:
        numbers: tuple[float, ...] = (math.nan, math.inf, -math.inf, 0.0, -1.0, 1e3, 1e6, 9e9, 1e12, -1e300, 5e-324)
        for _ in range(draw.choice((1, 1, 3, 20))):
            value = draw.choice(numbers if array.dtype.kind == "f" else (-1, 2, 3, 2**40, -(2**63)))
            array.reshape(-1)[draw.randrange(array.size)] = value
    else:
        changes: list[Callable[[], Any]] = [
            lambda: array.astype(draw.choice(("f4", "i4", "i8", "c16", ">f8", "bool", "U5", object))),
            lambda: array.reshape(-1),
            lambda: array[..., None],
            lambda: array[: len(array) // 2],
            lambda: np.concatenate([array, array]),
            lambda: array * draw.choice((-1, 0, 2, 10**6, 10**12)),
        ]
        with np.errstate(all="ignore"):
            array = draw.choice(changes)()
    members[name] = bytes_of(array)
    return packed(members)


def change_header(draw: random.Random, content: bytes) -> bytes:
    members = members_of(content)
    part = header = json.loads(str(np.load(io.BytesIO(members["header.npy"]))))
    *outer, last = draw.choice(places_of(header)[1:])
    for key in outer:
        part = part[key]
    match draw.randrange(4):
        case 0:
            del part[last]
        case 1 if isinstance(part, dict):
            part[draw.choice(("extra", "name", "x", "robot"))] = draw.choice(NASTY)
        case _:
            part[last] = draw.choice(NASTY)
    text = json.dumps(draw.choice((header, header, header, draw.choice(NASTY))))
    members["header.npy"] = bytes_of(draw.choice((np.array(text), np.array(text), np.array([text]), np.array(1.0))))
    return packed(members)


DAMAGES = (change_bytes, change_array, change_array, change_header, change_header)


def is_loaded(path: Path, *, drawn: bool) -> bool:
    """Whether a file was loaded; then everything that takes a record must take this one."""
    try:
        walk = Walk.load(path)
    except RecordError as error:
        message = str(error)
        assert str(path) in message
        assert len(message) < LONGEST_MESSAGE
        assert "memory" not in message
        return False
    with np.errstate(all="ignore"):
        assert measures.summary(walk)["outcome"] == walk.outcome
    assert len(repr(walk)) < LONGEST_MESSAGE
    again = path.with_name("again.npz")
    walk.save(again)
    assert Walk.load(again) == walk
    if drawn:
        assert all(isinstance(text, str) for line in flattened(walk.settings) for text in line)
        if len(walk.samples["time"]):
            plot_walk(walk).draw_without_rendering()
        with contextlib.suppress(MjbipedError):  # a record without what it takes
            stability(walk)
    return True


@pytest.mark.filterwarnings("ignore::RuntimeWarning", "ignore:Glyph", "ignore:Reading `.npy`:UserWarning")
@pytest.mark.parametrize("cases", [range(FEW), pytest.param(range(FEW, MANY), marks=pytest.mark.slow)], ids=str)
def test_damaged_records(cases: range, records: list[bytes], tmp_path: Path) -> None:
    path, loaded = tmp_path / "walk.npz", 0
    for case in cases:
        draw = random.Random(case)
        path.write_bytes(DAMAGES[case % len(DAMAGES)](draw, draw.choice(records)))
        loaded += within_limits(case, lambda drawn=case % 17 == 0: is_loaded(path, drawn=drawn))  # type: ignore[misc]
    assert 0 < loaded < len(cases) / 2


# ---- tables of studies -----------------------------------------------------------------------------------------------

IDENTITY = {"study": {"steps": 3, "robot": {"hip_mass": [5, 10]}}, "versions": {"numpy": "2.4"}, "sources": "abc"}
COLUMNS = columns_of(plan(Path("study.toml"), tomllib.loads("robot = { hip_mass = [5, 10, 15, 20, 25, 30] }")))


@pytest.fixture(scope="module")
def table(tmp_path_factory: pytest.TempPathFactory) -> bytes:
    folder = tmp_path_factory.mktemp("study")
    rows: list[dict[str, Any]] = [
        {"cell": cell, "robot.hip_mass": 5.0 * cell, "outcome": "finished", **dict.fromkeys(MEASURES, cell / 7.0)}
        for cell in range(5)
    ]
    rows[2] |= {"outcome": "failed", "error": "ValueError: nothing", "steps": None}
    with opened(folder, "study", COLUMNS, IDENTITY) as store:
        store.save(rows)
    return (folder / "study.sqlite").read_bytes()


def is_taken(content: bytes, folder: Path) -> bool:
    """Whether a file was taken as a study's table."""
    (folder / "study.sqlite").write_bytes(content)
    try:
        with opened(folder, "study", COLUMNS, IDENTITY) as store:
            store.rows()
            store.export()
    except (RecordError, InputError) as error:
        message = str(error)
        assert len(message) < LONGEST_MESSAGE
        assert "--" in message or "delete it" in message
        return False
    return True


@pytest.mark.parametrize("cases", [range(FEW), pytest.param(range(FEW, MANY), marks=pytest.mark.slow)], ids=str)
def test_damaged_tables(cases: range, table: bytes, tmp_path: Path) -> None:
    assert is_taken(table, tmp_path)
    contents = {case: change_bytes(random.Random(case), table) for case in cases}
    taken = sum(within_limits(case, lambda: is_taken(content, tmp_path)) for case, content in contents.items())  # noqa: B023
    assert 0 < taken < len(cases)
