"""The recorder takes each row once, and none that a reader would refuse."""

import math
from pathlib import Path

import numpy as np
import pytest
from simulations import Plain

import mjbiped
from mjbiped.engines.hybrid.engine import TOLERANCE, HybridRun
from mjbiped.engines.hybrid.resets import transfer_support
from mjbiped.engines.plan import Terms, make_plan
from mjbiped.records.columns import SAMPLES, TOUCHDOWNS, index_of, width
from mjbiped.records.recorder import Recorder


def rows_at(columns: int, *times: float) -> np.ndarray:
    table = np.zeros((len(times), columns))
    table[:, 0] = times
    return table


def test_rows_are_taken_in_their_order() -> None:
    recorder = Recorder()
    for times in ((0.0, 0.1), (), (0.2,)):
        recorder.add(rows_at(width(TOUCHDOWNS), *times), rows_at(width(SAMPLES) + 1, *times))
    assert recorder.touchdowns()["time"].tolist() == [0.0, 0.1, 0.2]
    assert recorder.samples()["time"].tolist() == [0.0, 0.1, 0.2]
    assert (recorder.steps, recorder.end) == (3, (0.2, 0.0))


def test_what_was_taken_is_not_taken_again() -> None:
    """Ctrl-C between the taking and the engine's note of it doubled the last rows of the record."""
    recorder = Recorder()
    touchdowns, samples = rows_at(width(TOUCHDOWNS), 0.1, 0.4), rows_at(width(SAMPLES), 0.0, 0.1, 0.2)
    recorder.add(touchdowns, samples)
    recorder.add(touchdowns, samples)
    recorder.add(rows_at(width(TOUCHDOWNS), 0.4, 0.7), rows_at(width(SAMPLES), 0.1, 0.2, 0.3))
    assert recorder.touchdowns()["time"].tolist() == [0.1, 0.4, 0.7]
    assert recorder.samples()["time"].tolist() == [0.0, 0.1, 0.2, 0.3]


def test_a_motion_that_is_no_number_is_not_recorded() -> None:
    """Its record was refused when it was read. A torque without bounds, and a law's own state, are kept."""
    recorder = Recorder()
    touchdowns, samples = rows_at(width(TOUCHDOWNS), 0.1, 0.4), rows_at(width(SAMPLES) + 1, 0.0, 0.1, 0.2, 0.3)
    touchdowns[1, index_of(TOUCHDOWNS, "dq")] = math.nan
    samples[1, index_of(SAMPLES, "torque")] = samples[1, -1] = math.inf
    samples[2, index_of(SAMPLES, "qpos")] = math.inf
    samples[3, index_of(SAMPLES, "dq")] = math.nan
    recorder.add(touchdowns, samples)
    assert recorder.touchdowns()["time"].tolist() == [0.1]
    assert recorder.samples()["time"].tolist() == [0.0, 0.1]
    assert (recorder.steps, recorder.end) == (1, (0.1, 0.0))


@pytest.mark.parametrize("component", [0, 3])
def test_the_record_of_a_walk_that_diverged_can_be_read(component: int, tmp_path: Path) -> None:
    """Whatever led there, between impacts or in one."""
    for transfers in (False, True):
        terms = Terms(mjbiped.Hybrid(), 3, None, None, 0.005, mjbiped.ScuffingRule())
        run = HybridRun(make_plan(terms, Plain(), mjbiped.Terrain.level(), (0.2, -0.2, 1.0, 1.0)), TOLERANCE)
        run.state.y[component] = math.nan
        if transfers:
            transfer_support(run.constants, run.state)
        run.go()
        assert run.ended.words == "diverged"
        run.record().save(tmp_path / "walk.npz")
        assert mjbiped.Walk.load(tmp_path / "walk.npz").steps == 0
