"""Many cells: kept when they end, not walked twice, and the same with any number of processes."""

from __future__ import annotations

import os
import signal
import sqlite3
import subprocess
import sys
import time
from contextlib import closing
from pathlib import Path

import pytest

import mjbiped
from mjbiped.studies.cell import Cell
from mjbiped.studies.reproduction import cell as walks
from mjbiped.studies.reproduction import reproduce as tables
from mjbiped.studies.reproduction.cell import cell, key, record_path
from mjbiped.studies.reproduction.reproduce import walked
from mjbiped.studies.reproduction.results import Row, row_of
from mjbiped.studies.reproduction.section_5 import adaptive

ROOT = Path(__file__).parents[3]
PROGRAM = """
import sys
from pathlib import Path
import mjbiped
from mjbiped.studies.reproduction.cell import cell
from mjbiped.studies.reproduction.reproduce import walked

if __name__ == "__main__":
    ground = mjbiped.Terrain.incline(2.0)
    law = {"controller.name": "passive"}
    cells = [cell(ground, law, engine="mujoco", steps=2)]
    cells += [cell(ground, law, engine="mujoco", distance=place) for place in (1000.0, 1001.0)]
    try:
        walked(cells, Path(sys.argv[1]), workers=1)
    except KeyboardInterrupt:
        sys.exit(130)
"""


@pytest.fixture
def cells() -> list[Cell]:
    return [on_stairs(rise) for rise in (-0.01, 0.0, 0.01)]


def on_stairs(rise: float, engine: str = "hybrid") -> Cell:
    return cell(mjbiped.Terrain.stairs(rise=rise), adaptive(0.8), steps=3, engine=engine)


def results(folder: Path, cells: list[Cell], workers: int = 1, *, fresh: bool = False) -> dict[str, Row]:
    return dict(zip(map(key, cells), walked(cells, folder, fresh=fresh, workers=workers), strict=True))


@pytest.mark.usefixtures("studies_in_threads")
def test_finished_cells_are_not_walked_again(
    cells: list[Cell], tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    begun: list[Cell] = []
    real = walks.row

    def counting(cell: Cell, folder: Path) -> dict[str, object]:
        begun.append(cell)
        if len(begun) == 3:
            raise KeyboardInterrupt
        return real(cell, folder)

    monkeypatch.setattr(tables, "row", counting)
    with pytest.raises(KeyboardInterrupt):
        results(tmp_path, [*cells, cells[0]])
    found = results(tmp_path, cells)
    assert begun == [*cells, cells[2]]  # the third was broken off, and only it is walked again
    assert repr(results(tmp_path, cells)) == repr(found)
    assert len(begun) == 4
    assert repr(results(tmp_path, cells, fresh=True)) == repr(found)
    assert len(begun) == 7


@pytest.mark.usefixtures("studies_in_threads")
def test_failed_cells_are_told_and_tried_again(
    cells: list[Cell], tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    uphill = cell(mjbiped.Terrain.incline(-3.0), {"controller.name": "passive"}, steps=2, engine="hybrid")
    found = results(tmp_path, [uphill, cells[0]])
    assert found[key(uphill)].outcome == "failed"
    assert found[key(uphill)].error
    assert found[key(cells[0])].finished
    monkeypatch.setattr(tables, "row", lambda cell, **_: {"key": key(cell), "outcome": "finished"})
    again = results(tmp_path, [uphill, cells[0]])
    assert again[key(uphill)].finished
    assert repr(again[key(cells[0])]) == repr(found[key(cells[0])])


@pytest.mark.usefixtures("studies_in_threads")
def test_lost_record_is_walked_again(tmp_path: Path) -> None:
    kept = cell(mjbiped.Terrain.level(), adaptive(0.8), steps=2, engine="hybrid", record=True)
    results(tmp_path, [kept])
    first = mjbiped.Walk.load(record_path(tmp_path, kept))
    record_path(tmp_path, kept).unlink()
    results(tmp_path, [kept])
    assert mjbiped.Walk.load(record_path(tmp_path, kept)) == first
    results(tmp_path, [], fresh=True)
    assert not record_path(tmp_path, kept).exists()


def test_folder_that_cannot_be_taken(tmp_path: Path) -> None:
    (tmp_path / "file").write_text("")
    with pytest.raises(mjbiped.InputError, match="cannot make"):
        walked([], tmp_path / "file" / "walks")
    walked([], tmp_path / "walks")
    (tmp_path / "walks" / "walks.sqlite").write_text("something else" * 100)
    with pytest.raises(mjbiped.RecordError, match=r"no table of mjbiped's.*--fresh"):
        walked([], tmp_path / "walks")


@pytest.mark.slow
def test_results_do_not_depend_on_the_number_of_processes(tmp_path: Path) -> None:
    cells = [on_stairs(rise, "mujoco") for rise in (-0.02, 0.0, 0.01)]
    one = results(tmp_path / "one", cells)
    assert repr(results(tmp_path / "two", cells, workers=2)) == repr(one)
    assert repr(one[key(cells[0])]) == repr(row_of(walks.row(cells[0])))


def _begin(folder: Path) -> subprocess.Popen[bytes]:
    """Start a process that walks a short cell, then two that take an hour."""
    program = folder / "program.py"
    program.write_text(PROGRAM)
    path = os.pathsep.join(filter(None, (str(ROOT), os.environ.get("PYTHONPATH"))))
    with (folder / "errors").open("wb") as errors:
        return subprocess.Popen(
            [sys.executable, str(program), str(folder / "walks")],
            env={**os.environ, "PYTHONPATH": path},
            stderr=errors,
            start_new_session=True,
        )


def _count(table: Path) -> int:
    """Rows of a table that another process writes; none where there is no table yet."""
    try:
        with closing(sqlite3.connect(f"file:{table}?mode=ro", uri=True)) as database:
            return int(database.execute("SELECT count(*) FROM cells").fetchone()[0])
    except sqlite3.OperationalError:
        return 0


def _wait_for(folder: Path, count: int) -> None:
    end = time.monotonic() + 240.0
    while _count(folder / "walks" / "walks.sqlite") < count:
        assert time.monotonic() < end, "nothing was kept"
        time.sleep(0.1)


@pytest.mark.slow
@pytest.mark.parametrize("kind", [signal.SIGKILL, signal.SIGINT])
def test_nothing_that_ended_is_lost(tmp_path: Path, kind: signal.Signals, monkeypatch: pytest.MonkeyPatch) -> None:
    """Killed or interrupted after the first walk, the finished one stays and no process is left."""
    process = _begin(tmp_path)
    _wait_for(tmp_path, 1)
    os.kill(process.pid, kind)
    status = process.wait(timeout=60)
    assert status == (130 if kind == signal.SIGINT else -signal.SIGKILL)
    end = time.monotonic() + 30.0
    while _alive(process.pid):  # the session's other processes, the workers
        assert time.monotonic() < end, "a worker outlived its parent"
        time.sleep(0.1)
    if kind == signal.SIGINT:
        assert (tmp_path / "errors").read_text() == ""  # no traceback, nothing left behind
    first = cell(mjbiped.Terrain.incline(2.0), {"controller.name": "passive"}, steps=2, engine="mujoco")
    monkeypatch.setattr(tables, "walk_cells", lambda _, todo, *__, **___: pytest.fail("walked again") if todo else None)
    kept = results(tmp_path / "walks", [first])[key(first)]
    assert kept.finished
    assert kept.steps == 2


def _alive(session: int) -> bool:
    """Whether a process of a session is left."""
    for stat in Path("/proc").glob("[0-9]*/stat"):
        try:
            fields = stat.read_text().rpartition(")")[2].split()
        except OSError:
            continue
        if int(fields[3]) == session and fields[0] != "Z":
            return True
    return False
