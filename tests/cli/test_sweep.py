"""`mjbiped sweep`: what it writes and prints, and how it ends."""

from __future__ import annotations

import csv
import json
import re
import sys
from pathlib import Path

import pytest
from command_line import run

from mjbiped.studies import run as running
from mjbiped.utils import parallel as workers

STUDY = """
engine = "hybrid"
steps = 3
controller = [{ name = "passive" }, { position_gain = [3, 6] }]
terrain = { name = "incline", slope_deg = [2, -2] }
"""


@pytest.fixture
def study(tmp_path: Path, studies_in_threads: None) -> Path:
    path = tmp_path / "slopes.toml"
    path.write_text(STUDY)
    return path


@pytest.mark.slow
def test_table_figures_and_summary(study: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.delenv("COLUMNS", raising=False)
    result = run("sweep", study)
    assert result.exit_code == 0, result.stderr
    folder = tmp_path / "slopes"
    assert len((folder / "study.csv").read_text().splitlines()) == 7
    assert list(folder.glob("*.png"))
    assert "finished" in result.stdout
    assert "cost of transport, absolute" in result.stdout
    assert "no passive gait" in result.stdout.replace("\n", " ")
    assert "controller position gain (1/s)" in result.stdout
    assert "best: passive, slope deg 2 (100 % of 1 finished" in result.stdout
    assert "6 walks in " in result.stdout
    assert " walks/s" in result.stdout
    printed = json.loads(run("sweep", study, "--json").stdout)
    assert printed["walks"] == 6
    assert printed["outcomes"] == {"finished": 5, "failed": 1}
    assert printed["errors"][0]["first_cell"] == 1
    assert str(folder / "study.csv") in printed["files"]
    assert run("sweep", study, "--quiet").stdout == ""


def test_a_dry_run_tells_what_it_takes_and_leaves_nothing(study: Path, tmp_path: Path) -> None:
    result = run("sweep", study, "--dry-run", "--workers", 1)
    assert result.exit_code == 0, result.stderr
    assert re.match(r"6 walks: about \d+ s in 1 process ", result.stdout)
    assert list(tmp_path.iterdir()) == [study]
    assert json.loads(run("sweep", study, "--dry-run", "--json").stdout)["walks"] == 6


def test_interrupted_it_says_how_to_go_on(study: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    def interrupted(*_: object, **__: object) -> None:
        raise KeyboardInterrupt

    monkeypatch.setattr(running, "walk_cells", interrupted)
    result = run("sweep", study, "--out", tmp_path / "out")
    assert result.exit_code == 130
    assert "the same command goes on" in result.stderr


@pytest.mark.slow
def test_bad_input_is_refused(study: Path, tmp_path: Path) -> None:
    missing = run("sweep", tmp_path / "none.toml")
    assert missing.exit_code == 2
    assert "there is no such file" in missing.stderr
    study.write_text(STUDY.replace("position_gain", "position_gian"))
    misspelt = run("sweep", study)
    assert misspelt.exit_code == 2
    assert "did you mean 'position_gain'" in misspelt.stderr
    assert not (tmp_path / "slopes").exists()
    study.write_text(STUDY)
    both = run("sweep", study, "--workers", 1, "--scheduler", "tcp://x")
    assert both.exit_code == 2
    assert "--workers is for this machine" in both.stderr
    assert run("sweep", study).exit_code == 0
    study.write_text(STUDY.replace("steps = 3", "steps = 4"))
    changed = run("sweep", study)
    assert changed.exit_code == 2
    assert "study.steps was 3, is 4" in changed.stderr
    assert run("sweep", study, "--fresh").exit_code == 0


def test_scheduler_without_dask(study: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(sys.modules, "distributed", None)
    result = run("sweep", study, "--scheduler", "tcp://127.0.0.1:1")
    assert result.exit_code == 2
    assert "pip install 'mjbiped[cluster]'" in result.stderr


@pytest.mark.slow
def test_scheduler_that_is_not_there(study: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    pytest.importorskip("distributed", reason="pip install 'mjbiped[cluster]'")
    monkeypatch.setattr(workers, "_PATIENCE", 1.0)
    result = run("sweep", study, "--scheduler", "tcp://127.0.0.1:1")
    assert result.exit_code == 2
    assert "no Dask scheduler answers" in result.stderr


@pytest.mark.slow
@pytest.mark.usefixtures("studies_in_threads")
def test_a_sweep_over_the_limits_of_a_walk_has_columns_for_both(tmp_path: Path) -> None:
    """What is asked for, and the measure of the same name."""
    study = tmp_path / "limits.toml"
    study.write_text('engine = "hybrid"\nsteps = [2, 3]\ndistance = [0.5, 9]\nterrain = { name = "level" }\n')
    result = run("sweep", study)
    assert result.exit_code == 0, result.stderr
    rows = list(csv.DictReader((tmp_path / "limits" / "study.csv").read_text().splitlines()))
    found = [(row["limit.steps"], row["limit.distance"], row["steps"]) for row in rows]
    assert found == [("2", "0.5", "2"), ("2", "9", "2"), ("3", "0.5", "2"), ("3", "9", "3")]
    assert run("report", tmp_path / "limits").exit_code == 0
