"""Records as tables, read by pandas and PyArrow."""

from pathlib import Path

import pandas
import pyarrow.parquet

import mjbiped
from mjbiped.exchange import export_walk


def test_csv_holds_all_digits(walk: mjbiped.Walk, tmp_path: Path) -> None:
    export_walk(walk, tmp_path / "walk.csv")
    for file, expected in zip(("walk.csv", "walk_touchdowns.csv"), walk.to_pandas(), strict=True):
        # pandas' own reader of numbers errs in the last digit
        pandas.testing.assert_frame_equal(pandas.read_csv(tmp_path / file), expected, rtol=1e-15, atol=0.0)
        assert "," in (tmp_path / file).read_text(encoding="utf-8").splitlines()[0]


def test_parquet_holds_units_too(walk: mjbiped.Walk, tmp_path: Path) -> None:
    export_walk(walk, tmp_path / "walk.parquet")
    for file, expected in zip(("walk.parquet", "walk_touchdowns.parquet"), walk.to_pandas(), strict=True):
        read = pandas.read_parquet(tmp_path / file)
        pandas.testing.assert_frame_equal(read, expected, check_exact=True)
        assert read.attrs["units"] == expected.attrs["units"]
    table = pyarrow.parquet.read_table(tmp_path / "walk.parquet")
    assert table["q_stance"].to_pylist() == walk.samples["q"][:, 0].tolist()
