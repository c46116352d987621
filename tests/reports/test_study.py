"""The report of a study: its rows, its figures, and folders that hold none."""

import sqlite3
from contextlib import closing
from pathlib import Path

import pytest
from report_pages import packed

from mjbiped.errors import InputError, RecordError
from mjbiped.reports.study import report_study, study_figures
from mjbiped.studies.bins import binned, values_of
from mjbiped.studies.plan import plan
from mjbiped.studies.run import run

pytestmark = pytest.mark.usefixtures("studies_in_threads")

BASE = {"engine": "hybrid", "steps": 2}
GRID = {
    **BASE,
    "controller": [{"position_gain": [3, 6]}, {"name": "passive"}],
    "terrain": {"name": "incline", "slope_deg": [2, 3, -2]},
}

LINES = {**GRID, "terrain": {"name": "incline", "slope_deg": 2}}


def made(content: dict[str, object], folder: Path) -> Path:
    run(plan(folder / "study.toml", content), folder / "out", workers=1)
    return folder / "out"


def test_the_page_holds_rows_outcomes_and_maps(tmp_path: Path) -> None:
    folder = made(GRID, tmp_path)
    report_study(folder, tmp_path / "page.html")
    page = (tmp_path / "page.html").read_text()
    assert "9 walks, 8 finished" in page  # passively it cannot walk uphill
    assert "no passive gait" in page
    assert page.count("<td>passive</td>") == 3
    assert "controller.position_gain" in page
    [figure] = packed(page)["plots"].values()
    assert [trace["type"] for trace in figure["data"]] == ["heatmap"] * 6  # the passive ones are alike for all gains


def test_a_baseline_without_the_parameter_is_a_line_of_one_height(tmp_path: Path) -> None:
    """Its line was there in the pictures alone, and empty on the page."""
    rows, *_ = run(plan(tmp_path / "study.toml", LINES), tmp_path / "out", workers=1)
    [shown] = study_figures(rows, ["controller.name", "controller.position_gain"])
    cost = {trace.name: trace.y for trace in shown.plot.data if trace.name and trace.showlegend}
    [passive] = [row["cost_of_transport"] for row in rows if row["controller.name"] == "passive"]
    assert cost["passive"].tolist() == [passive] * 2
    assert len(set(cost["adaptive"].tolist())) == 2


def test_a_map_shows_the_numbers_of_the_table(tmp_path: Path) -> None:
    content = {**GRID, "controller": {"position_gain": [3, 6]}}
    study = plan(tmp_path / "study.toml", content)
    rows, *_ = run(study, tmp_path / "out", workers=1)
    [shown] = study_figures(rows, study.varied)
    table = shown.plot.data[0].z
    gain, slope = (binned(rows, name, 3) for name in ("controller.position_gain", "terrain.slope_deg"))
    for row, value in enumerate(values_of(rows, "cost_of_transport")):
        assert table[slope.bin[row], gain.bin[row]] == value


def test_what_is_no_study_is_refused(tmp_path: Path) -> None:
    with pytest.raises(InputError, match=r"holds no study\.sqlite"):
        report_study(tmp_path, tmp_path / "page.html")
    folder = made({**BASE, "controller": {"position_gain": [1, 2]}}, tmp_path)
    for change, kind, message in (
        ("UPDATE cells SET cost_of_transport = '<b>' WHERE cell = 1", RecordError, "a measure is no number"),
        ("DELETE FROM cells", InputError, "has ended yet"),
    ):
        with closing(sqlite3.connect(folder / "study.sqlite")) as database, database:
            database.execute(change)
        with pytest.raises(kind, match=message):
            report_study(folder, tmp_path / "page.html")
    (folder / "study.sqlite").write_bytes(b"nothing of the kind")
    with pytest.raises(RecordError, match="no table of mjbiped's"):
        report_study(folder, tmp_path / "page.html")


@pytest.mark.parametrize(
    ("content", "name", "kind"),
    [
        ({"controller": {"name": ["adaptive", "passive"]}, "terrain": LINES["terrain"]}, "groups", "scatter"),
        ({"samples": 3, "terrain": {"name": "random", "seed": {"integer": [0, 99]}}}, "histograms", "histogram"),
    ],
)
def test_kinds_of_studies(content: dict[str, object], name: str, kind: str, tmp_path: Path) -> None:
    study = plan(tmp_path / "study.toml", {**BASE, **content})
    rows, *_ = run(study, tmp_path / "out", workers=1)
    [shown] = study_figures(rows, study.varied)
    assert (shown.name, shown.plot.data[0].type) == (name, kind)
