"""Damaged stores of studies and of the reproduction: refused in words, or as good as before."""

import contextlib
import random
import sqlite3
import tomllib
from pathlib import Path
from typing import Any

import pytest
from time_limits import within

import mjbiped
from mjbiped.errors import InputError, MjbipedError, RecordError
from mjbiped.studies.cell import MEASURES
from mjbiped.studies.plan import plan
from mjbiped.studies.reproduction.cell import cell as make_cell
from mjbiped.studies.reproduction.reproduce import walked
from mjbiped.studies.run import columns_of
from mjbiped.studies.store import opened

FEW, MANY = 120, 4000
LONGEST = 20.0  # s for one case
IDENTITY = {"study": {"steps": 3, "robot": {"hip_mass": [5, 10]}}, "versions": {"numpy": "2.4"}, "sources": "abc"}


def damaged(draw: random.Random, content: bytes) -> bytes:
    """Some bytes changed, cut out, put in or written over."""
    changed = bytearray(content)
    action = draw.randrange(5)
    if action == 0:
        for _ in range(draw.choice((1, 3, 10, 100))):
            changed[draw.randrange(len(changed))] = draw.randrange(256)
    elif action == 1:
        return content[: draw.randrange(len(content))]
    elif action == 2:
        first, last = sorted(draw.randrange(len(content)) for _ in range(2))
        return content[:first] + content[last:]
    elif action == 3:
        place = draw.randrange(len(content))
        changed[place : place + 40] = draw.choice((bytes(40), b"\xff" * 40, draw.randbytes(40)))
    else:  # where something stands, and not in what is empty
        used = [place for place, byte in enumerate(content) if byte]
        for _ in range(draw.choice((1, 1, 2, 8))):
            changed[draw.choice(used)] ^= 1 << draw.randrange(8)
    return bytes(changed)


# ---- a study's table -------------------------------------------------------------------------------------------------


@pytest.fixture(scope="module")
def columns() -> tuple[str, ...]:
    return columns_of(plan(Path("study.toml"), tomllib.loads("robot = { hip_mass = [5, 10, 15, 20, 25, 30] }")))


@pytest.fixture(scope="module")
def table(columns: tuple[str, ...], tmp_path_factory: pytest.TempPathFactory) -> bytes:
    folder = tmp_path_factory.mktemp("study")
    rows: list[dict[str, Any]] = [
        {"cell": cell, "robot.hip_mass": 5.0 * cell, "outcome": "finished", **dict.fromkeys(MEASURES, cell / 7.0)}
        for cell in range(5)
    ]
    rows[2] |= {"outcome": "failed", "error": "ValueError: nothing", "steps": None}
    with opened(folder, "study", columns, IDENTITY) as store:
        store.save(rows)
    return (folder / "study.sqlite").read_bytes()


def try_table(columns: tuple[str, ...], content: bytes, folder: Path) -> bool:
    """Whether a file was taken as a study's table."""
    (folder / "study.sqlite").write_bytes(content)
    try:
        with opened(folder, "study", columns, IDENTITY) as store:
            store.rows()
            store.export()
    except (RecordError, InputError) as error:
        message = str(error)
    else:
        return True
    assert len(message) < 900
    assert "--" in message or "delete it" in message
    return False


def try_tables(columns: tuple[str, ...], table: bytes, cases: range, folder: Path) -> int:
    taken = 0
    for case in cases:
        try:
            with within(LONGEST, case):
                taken += try_table(columns, damaged(random.Random(case), table), folder)
        except Exception as error:
            raise AssertionError(f"case {case}: {error!r}") from error
    return taken


def test_damaged_tables(columns: tuple[str, ...], table: bytes, tmp_path: Path) -> None:
    assert try_table(columns, table, tmp_path)
    assert 0 < try_tables(columns, table, range(FEW), tmp_path) < FEW


@pytest.mark.slow
def test_damaged_tables_by_the_thousand(columns: tuple[str, ...], table: bytes, tmp_path: Path) -> None:
    try_tables(columns, table, range(FEW, MANY), tmp_path)


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ("ALTER TABLE cells DROP COLUMN strikes", "its columns are others"),
        ("ALTER TABLE cells ADD COLUMN more", "its columns are others"),
        ("UPDATE identity SET value = '{' WHERE kind = 'study'", "no table of mjbiped's, or damaged"),
        (f"UPDATE identity SET value = '{'[' * 5000}' WHERE kind = 'study'", "no table of mjbiped's, or damaged"),
        ("DELETE FROM identity WHERE kind = 'format'", "format was nothing, is 1"),
        ("DROP TABLE cells", "its columns are others"),
    ],
)
def test_tables_that_others_left(
    columns: tuple[str, ...], table: bytes, tmp_path: Path, change: str, message: str
) -> None:
    (tmp_path / "study.sqlite").write_bytes(table)
    with contextlib.closing(sqlite3.connect(tmp_path / "study.sqlite")) as database, database:
        database.execute(change)
    with pytest.raises(MjbipedError, match=message) as refused, opened(tmp_path, "study", columns, IDENTITY) as store:
        store.rows()
    assert "--fresh" in str(refused.value)
    with opened(tmp_path, "study", columns, IDENTITY, fresh=True) as store:
        assert store.rows() == []


def test_a_lock_that_is_none(columns: tuple[str, ...], tmp_path: Path) -> None:
    (tmp_path / ".running").write_text("no lock of anybody's" * 100)
    with (
        pytest.raises(InputError, match=r"\.running cannot be written, or is no lock of ours: delete it"),
        opened(tmp_path, "study", columns, IDENTITY),
    ):
        pass
    (tmp_path / ".running").unlink()
    (tmp_path / ".running").mkdir()
    with pytest.raises(InputError, match="cannot be taken"), opened(tmp_path, "study", columns, IDENTITY):
        pass


# ---- the reproduction's ----------------------------------------------------------------------------------------------


@pytest.mark.slow
@pytest.mark.usefixtures("studies_in_threads")
def test_damaged_walks_are_walked_again_or_refused(tmp_path: Path) -> None:
    cell = make_cell(mjbiped.Terrain.incline(2.0), {"controller.name": "passive"}, steps=2, engine="hybrid")
    walked([cell], tmp_path)
    table = (tmp_path / "walks.sqlite").read_bytes()
    refused: list[str] = []
    for case in range(FEW):
        (tmp_path / "walks.sqlite").write_bytes(damaged(random.Random(case), table))
        with within(LONGEST, case):
            try:
                assert walked([cell], tmp_path)[0].finished
            except (RecordError, InputError) as error:
                refused.append(str(error))
    assert 0 < len(refused) < FEW
    assert all("--" in message or "delete it" in message for message in refused)
