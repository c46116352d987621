"""`mjbiped reproduce`: what it writes and prints, and how it ends."""

from __future__ import annotations

import json
import sqlite3
from contextlib import closing
from pathlib import Path

import pytest
from command_line import run

from mjbiped.plotting.style import new_figure, save_figure
from mjbiped.studies.cell import Cell
from mjbiped.studies.reproduction import cell as cells
from mjbiped.studies.reproduction import figures, section_5
from mjbiped.studies.reproduction import reproduce as whole


@pytest.fixture
def small(monkeypatch: pytest.MonkeyPatch, studies_in_threads: None) -> None:
    """A reproduction of the adaptive controller with one zeta, of the fitted methods, without MuJoCo and processes."""
    all_of_table_2 = whole.table_2
    monkeypatch.setattr(section_5, "DELAYS", (0.6,))
    monkeypatch.setattr(
        whole, "table_2", lambda: [entry for entry in all_of_table_2() if entry.values["method"] == "adaptive"]
    )
    monkeypatch.setattr(whole, "in_mujoco", lambda *_: [])
    monkeypatch.setattr(section_5, "BLIND", {"PBC": section_5.BLIND["PBC"]})
    # these take seconds to draw, and have tests of their own
    for name in ("plot_walk", "plot_figure_5", "plot_figure_6"):
        monkeypatch.setattr(figures, name, lambda _, path: save_figure(new_figure(1.0), path))


@pytest.mark.slow
@pytest.mark.usefixtures("small")
def test_page_table_and_figures_are_written(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    result = run("reproduce", "--out", tmp_path / "walks", "--report", tmp_path / "page", "--quick")
    assert result.exit_code == 0
    for name in (
        "reproduction.md",
        "tables/reproduction.md",
        "reproduction.csv",
        "reproduction_gains.csv",
        "reproduction_grounds.csv",
        "images/reproduction_fig_4_mixed_hybrid.png",
    ):
        assert (tmp_path / "page" / name).is_file()
        assert name in result.stdout.replace("\n", "")
    assert (tmp_path / "walks" / "figures" / "reproduction_table_3.pdf").stat().st_size > 5_000
    assert "0.03492" in result.stdout  # c_mt on level ground
    first = (tmp_path / "page" / "reproduction.md").read_bytes()
    monkeypatch.setattr(whole, "draw", lambda *_: [])
    printed = json.loads(run("reproduce", "--out", tmp_path / "walks", "--quick", "--json").stdout)
    assert (tmp_path / "walks" / "reproduction.md").read_bytes() == first
    assert printed["failed"] == []
    assert printed["checks"][0]["claim"] == "On level ground the adaptive controller's c_mt is 0.0350"
    assert {"claim", "source", "holds", "found", "of", "engine", "group"} == set(printed["checks"][0])


@pytest.mark.usefixtures("small")
def test_interrupted_it_says_how_to_go_on(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    begun: list[Cell] = []
    real = cells.row

    def interrupted(cell: Cell, folder: Path) -> dict[str, object]:
        begun.append(cell)
        if len(begun) > 4:
            raise KeyboardInterrupt
        return real(cell, folder)

    monkeypatch.setattr(cells, "row", interrupted)
    result = run("reproduce", "--out", tmp_path, "--workers", 1)
    assert result.exit_code == 130
    assert "the same command goes on" in result.stderr.replace("\n", " ")
    with closing(sqlite3.connect(tmp_path / "walks" / "walks.sqlite")) as database:
        assert database.execute("SELECT count(*) FROM cells").fetchone() == (4,)


@pytest.mark.parametrize(
    ("words", "message"),
    [
        (("--workers", "0"), "workers"),
        (("--out", __file__), "is a file"),
        (("--report", Path(__file__) / "page"), "cannot make the folder"),
    ],
)
@pytest.mark.usefixtures("small")
def test_bad_input_is_refused(words: tuple[object, ...], message: str, tmp_path: Path) -> None:
    where = () if "--out" in words else ("--out", tmp_path)
    result = run("reproduce", *where, *words)
    assert result.exit_code == 2
    assert message in result.stderr.replace("\n", " ")
    assert not list(tmp_path.rglob("*.sqlite"))
