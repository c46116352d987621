"""A study's table and the samples of its walks as Parquet files."""

from __future__ import annotations

import csv
import sys
from pathlib import Path
from typing import Any

import pandas as pd
import pytest
from command_line import run as command

from mjbiped.errors import MjbipedError
from mjbiped.studies.cell import Cell, Row
from mjbiped.studies.plan import read_study
from mjbiped.studies.run import run
from mjbiped.studies.store import FILE, write_table

STUDY = """
engine = "hybrid"
steps = 2
controller = [{ name = "passive" }, { replanning_delay = [0.8, "none"] }]
terrain = { name = "incline", slope_deg = [2, -2] }
"""

pytestmark = pytest.mark.usefixtures("studies_in_threads")


@pytest.fixture
def file(tmp_path: Path) -> Path:
    path = tmp_path / "study.toml"
    path.write_text(STUDY)
    return path


def test_the_table_is_that_of_the_csv_file(file: Path, tmp_path: Path) -> None:
    result = command("sweep", file, "--parquet")
    assert result.exit_code == 0, result.stderr
    assert "study.parquet" in result.stdout
    table = pd.read_parquet(tmp_path / "study" / "study.parquet")
    assert table.cost_of_transport.dtype == float
    with (tmp_path / "study" / "study.csv").open(newline="") as file_of_text:
        texts = list(csv.DictReader(file_of_text))
    assert list(table.columns) == list(texts[0])
    for name in table:
        for value, text in zip(table[name], (row[name] for row in texts), strict=True):
            if pd.isna(value):
                assert text == ""
            else:
                assert (text if isinstance(value, str) else float(text)) == value  # to the last bit
    before = (tmp_path / "study" / "study.parquet").read_bytes()
    assert command("sweep", file, "--parquet", "--fresh").exit_code == 0
    assert (tmp_path / "study" / "study.parquet").read_bytes() == before


def test_columns_have_one_type(tmp_path: Path) -> None:
    rows: list[Row] = [{"a": 1, "b": 0.8, "c": None}, {"a": 2.5, "b": "none", "c": None}]
    table = pd.read_parquet(write_table(tmp_path / "t.parquet", rows))
    assert table.a.tolist() == [1.0, 2.5]
    assert table.b.tolist() == ["0.8", "none"]
    assert table.c.isna().all()


def test_trajectories_are_the_samples_of_all_walks(file: Path, tmp_path: Path) -> None:
    study = read_study(file)
    plain, *_ = run(study, tmp_path / "plain", workers=1)
    rows, *_ = run(study, tmp_path / "out", workers=1, trajectories=True)
    assert rows == plain  # keeping samples changes no walk, to the last bit
    samples = pd.read_parquet(tmp_path / "out" / FILE)
    assert not (tmp_path / "out" / "trajectories").exists()
    for cell, row in zip(study.cells, rows, strict=True):
        mine = samples[samples.cell == cell.index]
        if row["outcome"] == "failed":  # no passive gait uphill
            assert mine.empty
            continue
        expected = cell.walk(0.005).to_pandas().samples
        found = mine.drop(columns="cell").reset_index(drop=True)[list(expected.columns)]
        pd.testing.assert_frame_equal(found, expected, check_exact=True)
    assert samples.cell.is_monotonic_increasing
    assert samples.attrs["units"] == expected.attrs["units"]


def test_broken_off_it_goes_on_with_what_is_missing(
    file: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    study = read_study(file)
    run(study, tmp_path / "whole", workers=1, trajectories=True)
    real = Cell.row
    walked: list[int] = []

    def counted(cell: Cell, **settings: Any) -> Row:
        if len(walked) == most:
            raise MjbipedError("a worker died")
        walked.append(cell.index)
        return real(cell, **settings)

    monkeypatch.setattr(Cell, "row", counted)
    most = 1
    with pytest.raises(MjbipedError, match="a worker died"):
        run(study, tmp_path / "out", workers=1, trajectories=True)
    assert not (tmp_path / "out" / FILE).exists()
    pieces = [piece.name for piece in (tmp_path / "out" / "trajectories").glob("*.parquet")]
    assert pieces == [f"{walked[0]}.parquet"]
    most = 10
    run(study, tmp_path / "out", workers=1, trajectories=True)
    assert sorted(walked) == [*range(6)]
    assert (tmp_path / "out" / FILE).read_bytes() == (tmp_path / "whole" / FILE).read_bytes()


@pytest.mark.parametrize("option", ["--parquet", "--trajectories"])
def test_without_pyarrow_nothing_walks(
    option: str, file: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    for name in [name for name in sys.modules if name.startswith("pyarrow")]:
        monkeypatch.delitem(sys.modules, name)
    monkeypatch.setitem(sys.modules, "pyarrow", None)
    result = command("sweep", file, option)
    assert result.exit_code == 2
    assert f"{option} needs PyArrow" in result.stderr
    assert "pip install 'mjbiped[data]'" in result.stderr
    assert not (tmp_path / "study").exists()
