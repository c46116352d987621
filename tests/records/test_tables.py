"""Tables of a walk: the recorder takes each row once, and flat tables have the record's numbers."""

import math

import numpy as np

import mjbiped
from mjbiped.records.columns import SAMPLES, TOUCHDOWNS, Recorder, index_of, tables_of, width


def rows_at(columns: int, *times: float) -> np.ndarray:
    table = np.zeros((len(times), columns))
    table[:, 0] = times
    return table


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


def test_frames_hold_the_numbers_of_the_record(walk: mjbiped.Walk) -> None:
    samples, touchdowns = walk.to_pandas()
    for frame, table, columns in ((samples, walk.samples, SAMPLES), (touchdowns, walk.touchdowns, TOUCHDOWNS)):
        for name, column in columns.items():
            flat = [f"{name}_{part}" for part in column.parts] or [name]
            assert frame[flat].to_numpy().tobytes() == table[name].reshape(-1, column.width).tobytes()
        assert {*frame.attrs["units"]} == {name for name in frame.columns if "controller_state" not in name}
    states = samples[["controller_state_0", "controller_state_1"]].to_numpy()
    assert states.tobytes() == walk.samples["controller_states"].tobytes()
    assert (samples.attrs["units"]["qpos_hip_x"], samples.attrs["units"]["qpos_left"]) == ("m", "rad")
    assert tables_of(mjbiped.Compass3D).samples["qpos"].unit == "m, m, rad, rad, m, rad, rad"


def test_steps_join_the_two_frames(walk: mjbiped.Walk) -> None:
    samples, touchdowns = walk.to_pandas()
    assert touchdowns.step.tolist() == [1, 2, 3, 4, 5, 6]
    ends = samples.groupby("step").time.max()
    assert ends.index.tolist() == [1, 2, 3, 4, 5, 6, 7]
    # a step's last sample lies within a sample period (5 ms) of the touchdown that ends it, rounding apart
    late = touchdowns.set_index("step").time - ends.loc[1:6]
    assert late.between(-1e-9, 0.005 + 1e-9).all()
    # all samples of a step stand on the leg that the touchdown before it put down
    stances = samples[samples.step > 1].groupby("step").stance.agg(["min", "max"])
    assert stances["min"].tolist() == stances["max"].tolist() == touchdowns.stance.tolist()
