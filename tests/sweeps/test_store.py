"""A study's table on disk: whole rows, once each, of one study, for one process at a time."""

from __future__ import annotations

import csv
import math
import sqlite3
import tomllib
from pathlib import Path

import pytest

from mjbiped.errors import InputError, RecordError
from mjbiped.sweeps.plan import Study, plan
from mjbiped.sweeps.store import DATABASE, TABLE, columns_of, opened

IDENTITY = {"study": {"steps": 3, "robot": {"hip_mass": [5, 10]}}, "versions": {"numpy": "2.4"}, "sources": "abc"}


@pytest.fixture
def study() -> Study:
    return plan(Path("study.toml"), tomllib.loads("robot = { hip_mass = [5, 10, 15] }"))


def row(cell: int, **others: object) -> dict[str, object]:
    return {"cell": cell, "robot.hip_mass": 5.0, "outcome": "finished", **others}


def test_rows_come_back_as_they_were_in_order(study: Study, tmp_path: Path) -> None:
    third = math.pi / 3.0
    with opened(tmp_path / "new" / "folder", study, IDENTITY) as store:
        store.save([row(2, steps=3, cost_of_transport=third)])
        store.save([row(0, error='no, "gait"\nthere', strikes=0), row(1)])
    with opened(tmp_path / "new" / "folder", study, IDENTITY) as store:
        assert store.done() == {0, 1, 2}
        rows = store.rows()
        path = store.export()
    assert [each["cell"] for each in rows] == [0, 1, 2]
    assert rows[2]["cost_of_transport"] == third
    assert type(rows[2]["steps"]) is int
    assert rows[0]["cost_of_transport"] is None
    with path.open(newline="", encoding="utf-8") as file:
        told = list(csv.DictReader(file))
    assert tuple(told[0]) == columns_of(study)
    assert float(told[2]["cost_of_transport"]) == third  # every digit
    assert told[0]["error"] == 'no, "gait"\nthere'
    assert told[1]["cost_of_transport"] == ""


def test_batch_is_written_whole_or_not_at_all(study: Study, tmp_path: Path) -> None:
    with opened(tmp_path, study, IDENTITY) as store:
        store.save([row(1)])
        with pytest.raises(RecordError, match="UNIQUE"):
            store.save([row(0), row(1)])
        assert store.done() == {1}


def test_another_identity_is_refused_in_words(study: Study, tmp_path: Path) -> None:
    with opened(tmp_path, study, IDENTITY) as store:
        store.save([row(0)])
    other = {"study": {"distance": 2, "robot": {"hip_mass": [5, 12]}}, "versions": {"numpy": "2.5"}, "sources": "abc"}
    with pytest.raises(InputError) as refused, opened(tmp_path, study, other):
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
    with opened(tmp_path, study, other, fresh=True) as store:
        assert store.done() == set()
    assert not (tmp_path / TABLE).exists()


def test_one_process_at_a_time(study: Study, tmp_path: Path) -> None:
    with (
        opened(tmp_path, study, IDENTITY),
        pytest.raises(InputError, match="another process is at it"),
        opened(tmp_path, study, IDENTITY, fresh=True),
    ):
        pass
    with opened(tmp_path, study, IDENTITY):
        pass


def test_what_is_no_table(study: Study, tmp_path: Path) -> None:
    (tmp_path / DATABASE).write_text("something else" * 100)
    with pytest.raises(RecordError, match="no study's table"), opened(tmp_path, study, IDENTITY):
        pass
    (tmp_path / DATABASE).unlink()
    other = sqlite3.connect(tmp_path / DATABASE)
    other.execute("CREATE TABLE letters (text)")
    other.close()
    with pytest.raises(RecordError, match="no study's table"), opened(tmp_path, study, IDENTITY):
        pass
    (tmp_path / "file").write_text("")
    with pytest.raises(InputError, match="cannot make the folder"), opened(tmp_path / "file", study, IDENTITY):
        pass
