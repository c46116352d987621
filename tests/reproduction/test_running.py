"""Many cells: kept when they end, not walked twice, and the same with any number of processes."""

from __future__ import annotations

import os
import signal
import subprocess
import sys
import time
from pathlib import Path

import pytest

import mjbiped
from controllers import AdaptiveController, PassiveController
from mjbiped.reproduction import running
from mjbiped.reproduction.cell import Cell, Result, measured
from mjbiped.reproduction.running import run_cells
from mjbiped.reproduction.store import Store

ROOT = Path(__file__).parents[2]
PROGRAM = """
import sys
from pathlib import Path
import mjbiped
from controllers import PassiveController
from mjbiped.reproduction.cell import Cell
from mjbiped.reproduction.running import run_cells
from mjbiped.reproduction.store import Store

if __name__ == "__main__":
    ground = mjbiped.Terrain.incline(2.0)
    cells = [Cell("mujoco", PassiveController(), ground, steps=2)]
    cells += [Cell("mujoco", PassiveController(), ground, steps=None, distance=place) for place in (1000.0, 1001.0)]
    try:
        run_cells(cells, Store(Path(sys.argv[1])), workers=1)
    except KeyboardInterrupt:
        sys.exit(130)
"""


@pytest.fixture
def cells(controller: AdaptiveController) -> list[Cell]:
    return [Cell("hybrid", controller, mjbiped.Terrain.stairs(rise=rise), steps=3) for rise in (-0.01, 0.0, 0.01)]


def test_finished_cells_are_not_walked_again(
    cells: list[Cell], tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    walked: list[Cell] = []

    def counting(cell: Cell) -> tuple[Result, mjbiped.Walk | None]:
        walked.append(cell)
        if len(walked) == 3:
            raise KeyboardInterrupt
        return measured(cell)

    monkeypatch.setattr(running, "measured", counting)
    with pytest.raises(KeyboardInterrupt):
        run_cells([*cells, cells[0]], Store(tmp_path))
    results = run_cells(cells, Store(tmp_path))
    assert walked == [*cells, cells[2]]  # the third was broken off, and only it is walked again
    again = run_cells(cells, Store(tmp_path))
    assert len(walked) == 4
    assert again == results
    assert {cell.key for cell in cells} == set(results)


def test_failed_cells_are_told_and_tried_again(cells: list[Cell], tmp_path: Path) -> None:
    uphill = Cell("hybrid", PassiveController(), mjbiped.Terrain.incline(-3.0), steps=2)
    results = run_cells([uphill, cells[0]], Store(tmp_path))
    assert results[uphill.key].outcome == "failed"
    assert results[cells[0].key].outcome == "finished"
    assert Store(tmp_path).load(uphill) is None


@pytest.mark.parametrize("text", ["", "{", '{"result": {}}', '{"result": {"outcome": "finished"}}'])
def test_unreadable_file_is_walked_again(cells: list[Cell], tmp_path: Path, text: str) -> None:
    store = Store(tmp_path)
    first = run_cells(cells[:1], store)
    (tmp_path / f"{cells[0].key}.json").write_text(text)
    assert store.load(cells[0]) is None
    assert run_cells(cells[:1], store) == first


def test_lost_record_is_walked_again(controller: AdaptiveController, tmp_path: Path) -> None:
    cell, store = Cell("hybrid", controller, mjbiped.Terrain.level(), steps=2, record=True), Store(tmp_path)
    run_cells([cell], store)
    kept = store.record(cell)
    store.record_path(cell).unlink()
    assert store.load(cell) is None
    run_cells([cell], store)
    assert store.record(cell) == kept


def test_folder_that_cannot_be_made(tmp_path: Path) -> None:
    (tmp_path / "file").write_text("")
    with pytest.raises(mjbiped.InputError, match="cannot make"):
        Store(tmp_path / "file" / "walks")


@pytest.mark.slow
def test_results_do_not_depend_on_the_number_of_processes(controller: AdaptiveController, tmp_path: Path) -> None:
    cells = [Cell("mujoco", controller, mjbiped.Terrain.stairs(rise=rise), steps=3) for rise in (-0.02, 0.0, 0.01)]
    one = run_cells(cells, Store(tmp_path / "one"), workers=1)
    assert run_cells(cells, Store(tmp_path / "two"), workers=2) == one
    here = measured(cells[0])[0]
    assert one[cells[0].key] == here


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


def _wait_for(folder: Path, count: int) -> None:
    end = time.monotonic() + 240.0
    while len(list((folder / "walks").glob("[!.]*.json"))) < count:
        assert time.monotonic() < end, "nothing was kept"
        time.sleep(0.1)


@pytest.mark.slow
@pytest.mark.parametrize("kind", [signal.SIGKILL, signal.SIGINT])
def test_nothing_that_ended_is_lost(tmp_path: Path, kind: signal.Signals) -> None:
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
    kept = Store(tmp_path / "walks").load(Cell("mujoco", PassiveController(), mjbiped.Terrain.incline(2.0), steps=2))
    assert kept is not None
    assert kept.outcome == "finished"
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
