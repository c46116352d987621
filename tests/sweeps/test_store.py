"""A table on disk: whole rows, once each, of one study, for one process at a time."""

from __future__ import annotations

import csv
import math
import sqlite3
import tomllib
from contextlib import closing
from pathlib import Path

import pytest
from time_limits import within

from mjbiped.errors import InputError, RecordError
from mjbiped.sweeps.plan import plan
from mjbiped.sweeps.run import layout_of
from mjbiped.sweeps.store import Layout, opened, read_table

IDENTITY = {"study": {"steps": 3, "robot": {"hip_mass": [5, 10]}}, "versions": {"numpy": "2.4"}, "sources": "abc"}


@pytest.fixture
def layout() -> Layout:
    return layout_of(plan(Path("study.toml"), tomllib.loads("robot = { hip_mass = [5, 10, 15] }")))


def row(cell: int, **others: object) -> dict[str, object]:
    return {"cell": cell, "robot.hip_mass": 5.0, "outcome": "finished", **others}


def test_rows_come_back_as_they_were_in_order(layout: Layout, tmp_path: Path) -> None:
    third = math.pi / 3.0
    with opened(tmp_path / "new" / "folder", layout, IDENTITY) as store:
        store.save([row(2, steps=3, cost_of_transport=third)])
        store.save([row(0, error='no, "gait"\nthere', strikes=0), row(1)])
    with opened(tmp_path / "new" / "folder", layout, IDENTITY) as store:
        rows = store.rows()
        path = store.export()
    assert [each["cell"] for each in rows] == [0, 1, 2]
    assert rows[2]["cost_of_transport"] == third
    assert type(rows[2]["steps"]) is int
    assert rows[0]["cost_of_transport"] is None
    with path.open(newline="", encoding="utf-8") as file:
        rows = list(csv.DictReader(file))
    assert tuple(rows[0]) == layout.columns
    assert float(rows[2]["cost_of_transport"]) == third  # every digit
    assert rows[0]["error"] == 'no, "gait"\nthere'
    assert rows[1]["cost_of_transport"] == ""


def test_batch_is_written_whole_or_not_at_all(layout: Layout, tmp_path: Path) -> None:
    with opened(tmp_path, layout, IDENTITY) as store:
        store.save([row(1)])
        with pytest.raises(RecordError, match="cannot write"):
            store.save([row(0), row(2, error=object())])
        assert [each["cell"] for each in store.rows()] == [1]


def test_a_row_is_found_by_its_key_and_replaced(layout: Layout, tmp_path: Path) -> None:
    with opened(tmp_path, layout, IDENTITY) as store:
        store.save([row(1, steps=3), row(0)])
        assert store.row(2) is None
        store.save([row(1, steps=4)])
        found = store.row(1)
        assert found is not None
        assert found["steps"] == 4
        assert [each["cell"] for each in store.rows()] == [0, 1]


def test_another_identity_is_refused_in_words(layout: Layout, tmp_path: Path) -> None:
    with opened(tmp_path, layout, IDENTITY) as store:
        store.save([row(0)])
    other = {"study": {"distance": 2, "robot": {"hip_mass": [5, 12]}}, "versions": {"numpy": "2.5"}, "sources": "abc"}
    with pytest.raises(InputError) as refused, opened(tmp_path, layout, other):
        pass
    for words in (
        "study.robot.hip_mass was [5, 10], is [5, 12]",
        "study.steps was 3, is nothing",
        "study.distance was nothing, is 2",
        'versions.numpy was "2.4", is "2.5"',
        "--out",
        "--fresh",
    ):
        assert words in str(refused.value)
    assert "sources" not in str(refused.value)
    with opened(tmp_path, layout, other, fresh=True) as store:
        assert store.rows() == []
    assert not (tmp_path / "study.csv").exists()


def test_one_process_at_a_time(layout: Layout, tmp_path: Path) -> None:
    with (
        opened(tmp_path, layout, IDENTITY),
        pytest.raises(InputError, match="another process is at it"),
        opened(tmp_path, layout, IDENTITY, fresh=True),
    ):
        pass
    with opened(tmp_path, layout, IDENTITY):
        pass


def test_what_is_no_table(layout: Layout, tmp_path: Path) -> None:
    (tmp_path / "study.sqlite").write_text("something else" * 100)
    with pytest.raises(RecordError, match="no table of mjbiped's"), opened(tmp_path, layout, IDENTITY):
        pass
    (tmp_path / "study.sqlite").unlink()
    other = sqlite3.connect(tmp_path / "study.sqlite")
    other.execute("CREATE TABLE letters (text)")
    other.close()
    with pytest.raises(RecordError, match="no table of mjbiped's"), opened(tmp_path, layout, IDENTITY):
        pass
    (tmp_path / "file").write_text("")
    with pytest.raises(InputError, match="cannot make the folder"), opened(tmp_path / "file", layout, IDENTITY):
        pass


ENDLESS = "WITH RECURSIVE up(n) AS (SELECT 0 UNION ALL SELECT n + 1 FROM up) SELECT n AS {}, n AS {} FROM up"


@pytest.mark.parametrize(
    "change",
    [
        f"DROP TABLE cells; CREATE VIEW cells AS {ENDLESS.format('cell', 'outcome')}",
        f"DROP TABLE identity; CREATE VIEW identity AS {ENDLESS.format('kind', 'value')}",
        "ALTER TABLE cells ADD COLUMN more AS (zeroblob(10))",
    ],
)
def test_what_is_no_plain_table_is_not_read(change: str, layout: Layout, tmp_path: Path) -> None:
    with opened(tmp_path, layout, IDENTITY) as store:
        store.save([row(0)])
    file = tmp_path / "study.sqlite"
    with closing(sqlite3.connect(file)) as database:
        database.executescript(change)
    with within(2.0, change):
        with pytest.raises(RecordError, match="its tables are others than they must be"):
            read_table(file)
        with (
            pytest.raises(RecordError, match=r"its tables are others than they must be.*--fresh"),
            opened(tmp_path, layout, IDENTITY),
        ):
            pass


def test_an_identity_that_is_nested_deeply(layout: Layout, tmp_path: Path) -> None:
    with opened(tmp_path, layout, IDENTITY):
        pass
    with closing(sqlite3.connect(tmp_path / "study.sqlite")) as database, database:
        database.execute("UPDATE identity SET value = ? WHERE kind = 'study'", ("[" * 100_000,))
    with pytest.raises(RecordError, match="no table of mjbiped's, or a damaged one"):
        read_table(tmp_path / "study.sqlite")
