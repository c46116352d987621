"""A table on disk: whole rows, once each, of one study, for one process at a time. Damaged ones are in tests/fuzz."""

from __future__ import annotations

import csv
import math
from pathlib import Path

import pytest

from mjbiped.errors import InputError, RecordError
from mjbiped.studies.plan import plan
from mjbiped.studies.run import columns_of
from mjbiped.studies.store import opened, read_table

GAINS = [{"name": "adaptive", "gain": 5}, {"name": "passive"}]
IDENTITY = {
    "study": {"steps": 3, "robot": {"hip_mass": [5, 10]}, "controller": GAINS},
    "versions": {"numpy": "2.4"},
    "sources": "abc",
}
COLUMNS = columns_of(plan(Path("study.toml"), {"robot": {"hip_mass": [5, 10, 15]}}))


def row(cell: int, **others: object) -> dict[str, object]:
    return {"cell": cell, "robot.hip_mass": 5.0, "outcome": "finished", **others}


def test_rows_come_back_as_they_were_in_order(tmp_path: Path) -> None:
    third, folder = math.pi / 3.0, tmp_path / "new" / "folder"
    with opened(folder, "study", COLUMNS, IDENTITY) as store:
        store.save([row(2, steps=3, cost_of_transport=third), row(1, steps=8)])
        store.save([row(0, error='no, "gait"\nthere', strikes=0), row(1)])
        with pytest.raises(RecordError, match="cannot be written"):
            store.save([row(0), row(2, error=object())])  # none of both
    with opened(folder, "study", COLUMNS, IDENTITY) as store:
        rows, path = store.rows(), store.export()
    assert [each["cell"] for each in rows] == [0, 1, 2]
    assert (rows[2]["cost_of_transport"], rows[1]["steps"], rows[0]["cost_of_transport"]) == (third, None, None)
    assert type(rows[2]["steps"]) is int
    assert read_table(path.with_suffix(".sqlite")) == (rows, {"format": 1, **IDENTITY})
    with path.open(newline="", encoding="utf-8") as file:
        texts = list(csv.DictReader(file))
    assert tuple(texts[0]) == COLUMNS
    assert float(texts[2]["cost_of_transport"]) == third  # every digit
    assert (texts[0]["error"], texts[1]["cost_of_transport"]) == ('no, "gait"\nthere', "")


def test_another_identity_is_refused_in_words(tmp_path: Path) -> None:
    with opened(tmp_path, "study", COLUMNS, IDENTITY) as store:
        store.save([row(0)])
    study = {"distance": 2, "robot": {"hip_mass": [5, 12]}, "controller": GAINS}
    other = {"study": study, "versions": {"numpy": "2.5"}, "sources": "abc"}
    with pytest.raises(InputError) as refused, opened(tmp_path, "study", COLUMNS, other):
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
    assert not any(words in str(refused.value) for words in ("sources", "controller"))
    with opened(tmp_path, "study", COLUMNS, other, fresh=True) as store:
        assert store.rows() == []


def test_one_process_at_a_time(tmp_path: Path) -> None:
    with opened(tmp_path, "study", COLUMNS, IDENTITY), pytest.raises(InputError, match="another process is at it"):
        opened(tmp_path, "study", COLUMNS, IDENTITY, fresh=True).__enter__()
    (tmp_path / "file").write_text("")
    with pytest.raises(InputError, match="cannot make the folder"):
        opened(tmp_path / "file", "study", COLUMNS, IDENTITY).__enter__()
