"""The estimate of a study, against the study itself."""

from __future__ import annotations

from pathlib import Path

import pytest

from mjbiped.studies.cell import Cell, Row
from mjbiped.studies.plan import plan
from mjbiped.studies.run import estimate, run

STUDY = {
    "engine": "hybrid",
    "steps": 2,
    "controller": {"name": "passive"},
    "terrain": {"name": "incline", "slope_deg": 2.0},
    "initial": {"around": "gait", "dq1": {"from": -0.01, "to": 0.01, "count": 60}},
}


@pytest.mark.slow
@pytest.mark.parametrize("trajectories", [False, True])
def test_the_size_is_that_of_the_files(trajectories: bool, tmp_path: Path, studies_in_threads: None) -> None:
    if trajectories:
        pytest.importorskip("pyarrow")
    study = plan(tmp_path / "study.toml", STUDY)
    expected = estimate(study, workers=3, trajectories=trajectories)
    assert (expected["walks"], expected["workers"], expected["tried"]) == (60, 3, 5)
    assert expected["seconds"] > 0.0
    run(study, tmp_path / "out", workers=1, trajectories=trajectories)
    made = sum(file.stat().st_size for file in (tmp_path / "out").iterdir() if file.is_file())
    # whole pages of the database, and what the joining of samples saves, are not in it
    assert 0.3 * made < expected["bytes"] < 3.0 * made
    assert [file.name for file in tmp_path.iterdir()] == ["out"]


def test_the_time_is_that_of_a_walk_by_the_number_of_walks_over_that_of_processes(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    now, real = [0.0], Cell.row

    def walked(cell: Cell, **_: object) -> Row:
        now[0] += 1.0
        return real(cell)

    monkeypatch.setattr(Cell, "row", walked)
    monkeypatch.setattr("time.perf_counter", lambda: now[0])
    study = plan(tmp_path / "study.toml", STUDY)
    assert estimate(study, workers=4)["seconds"] == 60 / 4
