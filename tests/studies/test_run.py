"""Studies: the same table however they are walked, however often they are broken off; tables on disk."""

import csv
import math
import os
import random
import signal
import subprocess
import sys
import time
from contextlib import nullcontext
from pathlib import Path
from typing import Any

import own_controllers
import pandas as pd
import pytest
from command_line import environment
from command_line import run as command

import controllers
import mjbiped
from mjbiped.control.loading import digest_of
from mjbiped.engines.mujoco import scene
from mjbiped.errors import InputError, MjbipedError, RecordError
from mjbiped.records import measures
from mjbiped.studies import run as running
from mjbiped.studies.cell import MEASURES, Cell, Row
from mjbiped.studies.plan import plan, read_study
from mjbiped.studies.run import columns_of, digest, machinery, run
from mjbiped.studies.store import FILE, opened, read_table

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
SLOPES = """
engine = "hybrid"
steps = 2
controller = [{ name = "passive" }, { imitate_slope_deg = -1 }, { replanning_delay = [0.8, "none"] }]
terrain = { name = "incline", slope_deg = [2, -2] }
"""
OWN = """
engine = "hybrid"
steps = 2
controller = [{ name = "laws/spread.py:HipSpread", stiffness = [0.4, 0.5] }, { name = "passive" }]
terrain = { name = "incline", slope_deg = 2 }
"""
in_threads = pytest.mark.usefixtures("studies_in_threads")


@pytest.fixture
def file(tmp_path: Path) -> Path:
    path = tmp_path / "study.toml"
    path.write_text(STUDY.format(samples=12))
    return path


@pytest.fixture
def own(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """A study whose controller's file is looked for beside it, not in the working directory."""
    monkeypatch.setattr(sys, "path", [*sys.path])
    own_controllers.write(tmp_path, "laws/spread.py", own_controllers.SPREAD)
    return own_controllers.write(tmp_path, "study.toml", OWN)


def start(folder: Path, *words: object) -> subprocess.Popen[bytes]:
    """Run a study in a process of its own, as a user does."""
    program = [sys.executable, "-m", "mjbiped", "sweep", *map(str, (folder / "study.toml", "--quiet", *words))]
    return subprocess.Popen(program, env=environment(), start_new_session=True)


@in_threads
def test_row_is_what_the_walk_gives(file: Path, tmp_path: Path) -> None:
    study = read_study(file)
    rows, table, *_ = run(study, tmp_path / "out", workers=1)
    assert table == tmp_path / "out" / "study.csv"
    assert [row["cell"] for row in rows] == list(range(24))
    for row, cell in [*zip(rows, study.cells, strict=True)][::7]:
        done = mjbiped.walk(cell.controller(), cell.terrain(), engine="hybrid", steps=6, sample_period=1.0)
        summary = measures.summary(done)
        assert {name: row[name] for name in MEASURES} == {name: summary[name] for name in MEASURES}  # bit by bit
        assert {*summary} == {*MEASURES, "outcome", "verdict", "warnings"}
        assert (row["outcome"], row["error"], row["sample"]) == (done.outcome, None, cell.index // 2)
        assert row["terrain.seed"] == dict(done.terrain.parameters)["seed"]


@in_threads
@pytest.mark.parametrize("trajectories", [False, True])
def test_broken_off(file: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, trajectories: bool) -> None:
    """A study that is broken off goes on where it was, and walks no cell twice."""
    study, name = read_study(file), FILE if trajectories else "study.csv"
    run(study, tmp_path / "whole", workers=2, trajectories=trajectories)
    walked: list[int] = []
    broken_at, real = 9, Cell.row

    def counting(cell: Cell, **settings: Any) -> Row:
        if len(walked) == broken_at:
            raise KeyboardInterrupt
        walked.append(cell.index)
        return real(cell, **settings)

    monkeypatch.setattr(Cell, "row", counting)
    with pytest.raises(KeyboardInterrupt):
        run(study, tmp_path / "out", workers=1, trajectories=trajectories)
    broken_at = 10**9
    run(study, tmp_path / "out", workers=1, trajectories=trajectories)
    assert (tmp_path / "out" / name).read_bytes() == (tmp_path / "whole" / name).read_bytes()
    assert sorted(walked) == list(range(24))
    run(study, tmp_path / "out", workers=1, trajectories=trajectories)
    assert len(walked) == 24


@in_threads
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
    with pytest.raises(MjbipedError, match="install the same versions"):
        running.walk_one(Cell.row, read_study(file).cells[0], {"sources": "others", "versions": {}}, 1)
    run(read_study(file), tmp_path / "out", fresh=True)
    file.write_text('engine = "hybrid"\nsteps = 1\nterrain = { file = "trail.toml" }')
    for slope in (1, 2):
        (tmp_path / "trail.toml").write_text(f"segments = [[1, 0], [1, {slope}]]")
        with pytest.raises(InputError, match="content of a terrain file changed") if slope == 2 else nullcontext():
            run(read_study(file), tmp_path / "trail")


@in_threads
def test_rows_belong_to_a_controllers_file_as_it_was(own: Path, tmp_path: Path) -> None:
    before = read_study(own)
    first, table, *_ = run(before, tmp_path / "out", workers=1)
    kept, laws = table.read_bytes(), {name: digest_of(place) for name, place in before.laws.items()}
    law = own_controllers.SPREAD.replace("self.spread)", "self.spread) * 2")
    own_controllers.write(tmp_path, "laws/spread.py", law)
    with pytest.raises(InputError, match=r"the source of the controller laws/spread\.py:HipSpread changed\. .*--fresh"):
        run(read_study(own), tmp_path / "out", workers=1)
    with pytest.raises(MjbipedError, match=r"source of the controller laws/spread\.py:HipSpread is another one"):
        before.cells[0].row(laws=laws)
    assert table.read_bytes() == kept
    again, *_ = run(read_study(own), tmp_path / "out", workers=1, fresh=True)
    costs = [[row["cost_of_transport"] for row in rows[:2]] for rows in (first, again)]
    assert len({*costs[0], *costs[1]}) == 4, "walked again, with the edited law"


@in_threads
def test_failed_cells_are_rows_and_a_table_is_the_same_as_parquet(file: Path, tmp_path: Path) -> None:
    file.write_text(SLOPES)
    study = read_study(file)
    rows, table, *_ = run(study, tmp_path / "out", workers=1)
    failed = [row["cell"] for row in rows if row["outcome"] == "failed"]
    assert failed == [1, 2, 3]  # no passive gait uphill, nor to imitate
    assert all("no passive gait" in rows[cell]["error"] and rows[cell]["steps"] is None for cell in failed)
    kept, *_ = run(study, tmp_path / "samples", workers=1, trajectories=True)
    assert kept == rows  # keeping samples changes no walk, to the last bit
    samples = pd.read_parquet(tmp_path / "samples" / FILE)
    assert samples.cell.is_monotonic_increasing
    assert {*samples.cell} == {*range(8)} - {*failed}
    expected = study.cells[4].walk(0.005).to_pandas().samples
    mine = samples[samples.cell == 4][list(expected.columns)].reset_index(drop=True)
    pd.testing.assert_frame_equal(mine, expected, check_exact=True)
    assert samples.attrs["units"] == expected.attrs["units"]
    assert command("sweep", file, "--parquet", "--out", tmp_path / "out").exit_code == 0
    texts, made = pd.read_csv(table), pd.read_parquet(table.with_suffix(".parquet"))
    assert made.cost_of_transport.dtype == float
    assert made["controller.replanning_delay"].dropna().tolist() == ["0.8", "0.8", "none", "none"]
    pd.testing.assert_frame_equal(texts, made, check_exact=True, check_dtype=False, check_like=False)


@pytest.mark.slow
@pytest.mark.parametrize("engine", ["hybrid", "mujoco"])
def test_killed_twice_it_ends_with_the_same_table(file: Path, tmp_path: Path, engine: str) -> None:
    samples, steps = (150, 40) if engine == "hybrid" else (24, 4)  # more than are walked in 4 s
    file.write_text(STUDY.format(samples=samples).replace("hybrid", engine).replace("steps = 6", f"steps = {steps}"))
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
def test_on_a_cluster_with_a_worker_killed(file: Path, tmp_path: Path) -> None:
    """Two worker processes of Dask; one is killed in the middle, and its work is done by the other."""
    distributed = pytest.importorskip("distributed", reason="pip install 'mjbiped[cluster]'")
    file.write_text(STUDY.format(samples=100).replace("steps = 6", "steps = 40"))
    assert start(tmp_path, "--out", tmp_path / "here").wait(timeout=300) == 0
    with distributed.LocalCluster(n_workers=2, threads_per_worker=2, dashboard_address=None) as cluster:
        process = start(tmp_path, "--out", tmp_path / "there", "--scheduler", cluster.scheduler_address)
        table = tmp_path / "there" / "study.sqlite"
        end = time.monotonic() + 120.0
        while not table.exists() or table.stat().st_size < 30_000:  # some rows are there
            assert time.monotonic() < end
            assert process.poll() is None, "it ended before a worker was killed"
            time.sleep(0.05)
        os.kill(cluster.workers[0].process.pid, signal.SIGKILL)
        assert process.wait(timeout=300) == 0
    assert (tmp_path / "there" / "study.csv").read_bytes() == (tmp_path / "here" / "study.csv").read_bytes()


COUNTED = ("engines/a.py", "studies/reproduction/cell.py", "studies/cell.py", "../laws/sub/a.py", "../models/a.xml")
LEFT_OUT = ("cli/a.py", "plotting/a.py", "studies/reproduction/tables.py", "a.txt")


@pytest.mark.parametrize("place", [*COUNTED, "../own.py", *LEFT_OUT])
def test_every_file_that_a_number_depends_on_is_in_the_digest(place: str, tmp_path: Path) -> None:
    package = tmp_path / "mjbiped"
    for each in (*COUNTED, "../own.py", *LEFT_OUT):
        (package / each).parent.mkdir(parents=True, exist_ok=True)
        (package / each).write_text("1\n")
    parts = package, [tmp_path / "laws", tmp_path / "own.py"], tmp_path / "models"
    first, changed = digest(*parts), package / place
    changed.write_text("2\n")
    second = digest(*parts)
    if place in COUNTED:
        changed.rename(changed.with_stem("moved"))
    assert len({first, second, digest(*parts)}) == (3 if place in COUNTED else 1 if place in LEFT_OUT else 2)
    house, laws = Path(mjbiped.__file__).parent, Path(controllers.__file__).parent
    assert machinery()["sources"] == digest(house, [laws], scene.models_folder())


IDENTITY = {"study": {"steps": 3, "robot": {"hip_mass": [5, 10]}}, "versions": {"numpy": "2.4"}, "sources": "abc"}
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


def test_one_process_at_a_time(tmp_path: Path) -> None:
    with opened(tmp_path, "study", COLUMNS, IDENTITY), pytest.raises(InputError, match="another process is at it"):
        opened(tmp_path, "study", COLUMNS, IDENTITY, fresh=True).__enter__()
    (tmp_path / "file").write_text("")
    with pytest.raises(InputError, match="cannot make the folder"):
        opened(tmp_path / "file", "study", COLUMNS, IDENTITY).__enter__()


@pytest.mark.slow
def test_worker_processes_load_a_controllers_file(own: Path, tmp_path: Path) -> None:
    rows, *_ = run(read_study(own), tmp_path / "out", workers=1)
    assert [row["outcome"] for row in rows] == ["finished"] * 3
    law = own_controllers.SPREAD.replace("        return", "        assert t < 0.3, 'too late'\n        return")
    own_controllers.write(tmp_path, "laws/spread.py", law)
    rows, *_ = run(read_study(own), tmp_path / "again", workers=1)
    assert rows[0]["outcome"] == "failed"
    assert "AssertionError: too late (spread.py, line 12, in torque: assert t < 0.3" in rows[0]["error"]
