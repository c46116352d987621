"""Studies: the same table however they are walked, however often they are broken off."""

from __future__ import annotations

import os
import random
import signal
import subprocess
import sys
import time
from contextlib import nullcontext
from pathlib import Path
from typing import Any

import pytest
from dask_cluster import two_workers

import mjbiped
from mjbiped.errors import InputError, MjbipedError
from mjbiped.records import measures
from mjbiped.studies import run as running
from mjbiped.studies.cell import MEASURES, Cell, Row
from mjbiped.studies.plan import read_study
from mjbiped.studies.run import machinery, run
from mjbiped.studies.store import read_table

ROOT = Path(__file__).parents[2]
STUDY = """
engine = "hybrid"
steps = 6
samples = {samples}
[controller]
replanning_delay = [0.8, "none"]
[terrain]
name = "random"
seed = {{ integer = [0, 1000000] }}
slope_deg = {{ plus_minus = {{ uniform = [0, 6] }} }}
"""


@pytest.fixture
def file(tmp_path: Path) -> Path:
    path = tmp_path / "study.toml"
    path.write_text(STUDY.format(samples=12))
    return path


def start(folder: Path, *words: object) -> subprocess.Popen[bytes]:
    """Run a study in a process of its own, as a user does."""
    path = os.pathsep.join(filter(None, (str(ROOT), os.environ.get("PYTHONPATH"))))
    with (folder / "errors").open("wb") as errors:
        return subprocess.Popen(
            [sys.executable, "-m", "mjbiped", "sweep", folder / "study.toml", "--quiet", *map(str, words)],
            env={**os.environ, "PYTHONPATH": path},
            stderr=errors,
            start_new_session=True,
        )


@pytest.mark.usefixtures("studies_in_threads")
def test_row_is_what_the_walk_gives(file: Path, tmp_path: Path) -> None:
    study = read_study(file)
    rows, table, *_ = run(study, tmp_path / "out", workers=1)
    assert table == tmp_path / "out" / "study.csv"
    assert [row["cell"] for row in rows] == list(range(24))
    for row, cell in list(zip(rows, study.cells, strict=True))[::7]:
        done = mjbiped.walk(
            cell.controller(), cell.terrain(), engine="hybrid", steps=6, robot=mjbiped.Compass(), sample_period=1.0
        )
        summary = measures.summary(done)
        assert {name: row[name] for name in MEASURES} == {name: summary[name] for name in MEASURES}  # bit by bit
        assert {*summary} == {*MEASURES, "outcome", "verdict", "warnings"}
        assert row["outcome"] == done.outcome
        assert row["error"] is None
        assert row["sample"] == cell.index // 2
        assert row["terrain.seed"] == dict(done.terrain.parameters)["seed"]


@pytest.mark.usefixtures("studies_in_threads")
def test_cells_are_walked_once_whoever_walks_them(file: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    study = read_study(file)
    whole = run(study, tmp_path / "whole", workers=2)[1].read_bytes()
    assert whole.count(b"\n") == 25
    walked: list[int] = []
    broken_at, real = 9, Cell.row

    def counting(cell: Cell, **settings: Any) -> Row:
        if len(walked) == broken_at:
            raise KeyboardInterrupt
        walked.append(cell.index)
        return real(cell, **settings)

    monkeypatch.setattr(Cell, "row", counting)
    with pytest.raises(KeyboardInterrupt):
        run(study, tmp_path / "out", workers=1)
    broken_at = 10**9
    assert run(study, tmp_path / "out", workers=1)[1].read_bytes() == whole
    assert sorted(walked) == list(range(24))
    run(study, tmp_path / "out", workers=1)
    assert len(walked) == 24


@pytest.mark.usefixtures("studies_in_threads")
def test_changed_study_is_refused(file: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    run(read_study(file), tmp_path / "out")
    text = file.read_text()
    file.write_text("# a remark\n" + text + '[plot]\nmeasures = ["steps"]\n')
    run(read_study(file), tmp_path / "out")  # neither is part of the study
    file.write_text(text.replace("steps = 6", "steps = 7"))
    with pytest.raises(InputError, match=r"another study: study\.steps was 6, is 7\. Name another"):
        run(read_study(file), tmp_path / "out")
    file.write_text(text)
    monkeypatch.setattr(running, "machinery", lambda: {**machinery(), "sources": "mended" * 20})
    with pytest.raises(InputError, match=r"another study: mjbiped's source files changed\."):
        run(read_study(file), tmp_path / "out")
    run(read_study(file), tmp_path / "out", fresh=True)


@pytest.mark.usefixtures("studies_in_threads")
def test_changed_terrain_file_is_refused(file: Path, tmp_path: Path) -> None:
    file.write_text('engine = "hybrid"\nsteps = 1\nterrain = { file = "trail.toml" }')
    for slope in (1, 2):
        (tmp_path / "trail.toml").write_text(f"segments = [[1, 0], [1, {slope}]]")
        with pytest.raises(InputError, match="content of a terrain file changed") if slope == 2 else nullcontext():
            run(read_study(file), tmp_path / "out")


@pytest.mark.usefixtures("studies_in_threads")
def test_failed_cells_are_rows(tmp_path: Path) -> None:
    path = tmp_path / "study.toml"
    path.write_text("""
        engine = "hybrid"
        steps = 2
        controller = [{ name = "passive" }, { imitate_slope_deg = -1 }, { replanning_delay = 0.5 }]
        terrain = { name = "incline", slope_deg = [2, -2] }
    """)
    rows, table, *_ = run(read_study(path), tmp_path / "out", workers=1)
    assert [row["outcome"] for row in rows] == ["finished", "failed", "failed", "failed", "finished", "finished"]
    assert all("no passive gait" in row["error"] for row in rows[1:4])
    assert rows[1]["steps"] is None
    assert run(read_study(path), tmp_path / "out")[1] == table  # and not tried again


@pytest.mark.usefixtures("studies_in_threads")
def test_workers_that_fail_are_told(file: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    study, real = read_study(file), Cell.row

    def failing(cell: Cell, **settings: Any) -> Row:
        if cell.index == 20:
            raise MemoryError("too much")
        return real(cell, **settings)

    monkeypatch.setattr(Cell, "row", failing)
    with pytest.raises(MjbipedError, match=r"MemoryError: too much.*the same command goes on"):
        run(study, tmp_path / "out", workers=1)
    monkeypatch.undo()
    rows, _ = read_table(tmp_path / "out" / "study.sqlite")
    assert 20 not in {row["cell"] for row in rows}


def test_worker_of_another_version_is_refused(file: Path) -> None:
    with pytest.raises(MjbipedError, match="install the same versions"):
        running.walk_one(Cell.row, read_study(file).cells[0], {"sources": "others", "versions": {}}, 1)


@pytest.mark.slow
def test_worker_that_dies_is_told(file: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Processes here, and one of them is killed from the inside, at its first walk."""
    monkeypatch.setattr(running, "walk_one", _die)
    with pytest.raises(MjbipedError, match="the same command goes on"):
        run(read_study(file), tmp_path / "out", workers=1)


def _die(*_: object) -> None:
    os.kill(os.getpid(), signal.SIGKILL)


@pytest.mark.slow
@pytest.mark.parametrize("engine", ["hybrid", "mujoco"])
def test_killed_twice_it_ends_with_the_same_table(tmp_path: Path, engine: str) -> None:
    samples, steps = (150, 40) if engine == "hybrid" else (6, 4)
    text = STUDY.format(samples=samples).replace("hybrid", engine).replace("steps = 6", f"steps = {steps}")
    (tmp_path / "study.toml").write_text(text)
    assert start(tmp_path, "--out", tmp_path / "whole", "--workers", 2).wait(timeout=300) == 0
    chance = random.Random(4)
    for _ in range(2):
        process = start(tmp_path, "--out", tmp_path / "killed", "--workers", 2)
        with pytest.raises(subprocess.TimeoutExpired):
            process.wait(chance.uniform(2.0, 4.0))  # the start takes one or two
        os.kill(process.pid, signal.SIGKILL)
        process.wait()
    assert start(tmp_path, "--out", tmp_path / "killed", "--workers", 1).wait(timeout=300) == 0
    assert (tmp_path / "killed" / "study.csv").read_bytes() == (tmp_path / "whole" / "study.csv").read_bytes()


@pytest.mark.slow
def test_on_a_cluster_with_a_worker_killed(tmp_path: Path) -> None:
    """Two worker processes of Dask; one is killed in the middle, and its work is done by the other."""
    pytest.importorskip("distributed", reason="pip install 'mjbiped[cluster]'")
    (tmp_path / "study.toml").write_text(STUDY.format(samples=100).replace("steps = 6", "steps = 40"))
    assert start(tmp_path, "--out", tmp_path / "here").wait(timeout=300) == 0
    with two_workers(tmp_path) as (address, (first, _)):
        process = start(tmp_path, "--out", tmp_path / "there", "--scheduler", address)
        table = tmp_path / "there" / "study.sqlite"
        end = time.monotonic() + 120.0
        while not table.exists() or table.stat().st_size < 30_000:  # some rows are there
            assert time.monotonic() < end
            assert process.poll() is None, "it ended before a worker was killed"
            time.sleep(0.05)
        os.kill(first, signal.SIGKILL)
        assert process.wait(timeout=300) == 0
    assert (tmp_path / "there" / "study.csv").read_bytes() == (tmp_path / "here" / "study.csv").read_bytes()
