"""A walk as flat tables and data frames: the record's numbers, each in a column of its own."""

import sys

import pandas as pd
import pytest

import mjbiped
from controllers import AdaptiveController, PassiveController
from mjbiped.records.columns import SAMPLES, TOUCHDOWNS, flat_samples


@pytest.fixture(scope="module")
def walk(controller: AdaptiveController) -> mjbiped.Walk:
    return mjbiped.walk(controller, mjbiped.Terrain.mixed(), engine="hybrid", steps=4)


def test_the_numbers_are_those_of_the_record(walk: mjbiped.Walk) -> None:
    samples, touchdowns = walk.to_pandas()
    for frame, table, columns in ((samples, walk.samples, SAMPLES), (touchdowns, walk.touchdowns, TOUCHDOWNS)):
        for name, column in columns.items():
            flat = [f"{name}_{part}" for part in column.parts] or [name]
            assert len(flat) == column.width
            assert frame[flat].to_numpy().tobytes() == table[name].reshape(-1, column.width).tobytes()
    states = samples[["controller_state_0", "controller_state_1"]].to_numpy()
    assert states.tobytes() == walk.samples["controller_states"].tobytes()
    assert samples.torque_ankle.tolist() == walk.samples["torque"][:, 0].tolist()
    assert (samples.attrs["units"]["qpos_hip_x"], samples.attrs["units"]["qpos_left"]) == ("m", "rad")
    assert {*touchdowns.attrs["units"]} == {*touchdowns.columns}


def test_steps_join_the_two_frames(walk: mjbiped.Walk) -> None:
    samples, touchdowns = walk.to_pandas()
    assert touchdowns.step.tolist() == [1, 2, 3, 4]
    ends = samples.groupby("step").time.max()
    assert ends.index.tolist() == [1, 2, 3, 4, 5]
    # a step's last sample lies within a sample period (5 ms) of the touchdown that ends it, rounding apart
    late = touchdowns.set_index("step").time - ends.loc[1:4]
    assert (late > -1e-9).all()
    assert (late < 0.005 + 1e-9).all()
    # all samples of a step stand on the leg that the touchdown before it put down
    stances = samples[samples.step > 1].groupby("step").stance.agg(["min", "max"])
    assert (stances["min"] == stances["max"]).all()
    assert stances["min"].tolist() == touchdowns.stance.tolist()  # the walk's last sample stands on its last touchdown


def test_frames_survive_parquet_with_their_units(walk: mjbiped.Walk, tmp_path: object) -> None:
    samples = walk.to_pandas().samples
    samples.to_parquet(f"{tmp_path}/samples.parquet")
    again = pd.read_parquet(f"{tmp_path}/samples.parquet")
    pd.testing.assert_frame_equal(samples, again, check_exact=True)
    assert again.attrs == samples.attrs


def test_walks_without_samples_and_without_steps_have_empty_frames() -> None:
    walk = mjbiped.walk(
        PassiveController(), mjbiped.Terrain.incline(2.0), engine="hybrid", steps=1, initial="rest", sample_period=None
    )
    samples, touchdowns = walk.to_pandas()
    assert len(samples) == 0
    assert len(touchdowns) == walk.steps == 0
    assert "q_stance" in samples.columns
    assert "controller_state_0" not in flat_samples(walk)
    assert samples.stance.dtype == "int64"


def test_without_pandas_the_extra_is_named(walk: mjbiped.Walk, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(sys.modules, "pandas", None)
    with pytest.raises(mjbiped.InputError, match=r"to_pandas needs pandas.*pip install 'mjbiped\[data\]'"):
        walk.to_pandas()
