"""The recorder takes each row once."""

import numpy as np

from mjbiped.records.columns import SAMPLES, TOUCHDOWNS, width
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
