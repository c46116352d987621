"""One table tells how every signal of a walk is drawn: whoever adds a row sees it in figures, reports and videos."""

import numpy as np
import pytest

import mjbiped
from mjbiped.records import loads, signals
from mjbiped.records.signals import values_of


def test_values_are_those_of_the_record_in_the_panels_unit(walk: mjbiped.Walk, kneed: mjbiped.Walk) -> None:
    samples, touched = kneed.samples, kneed.touchdowns
    q, torque = samples["q"], samples["torque"]
    assert values_of(kneed, "torque_knee") == pytest.approx(torque[:, 2])
    assert values_of(kneed, "slope") == pytest.approx(np.degrees(samples["slope"]))
    assert values_of(kneed, "flexion") == pytest.approx(np.degrees(q[:, 2] - q[:, 1]))
    assert values_of(kneed, "torque_stance_knee") == pytest.approx(loads.knee_torque(kneed), nan_ok=True)
    rate = samples["dq"][:, 2] - samples["dq"][:, 1]
    assert values_of(kneed, "power_knee") == pytest.approx(torque[:, 2] * rate)
    farthest = 100.0 * 0.5 * walk.robot.leg_length
    assert np.nanmax(np.abs(values_of(walk, "pressure"))) <= farthest
    assert signals.knee_strikes(kneed) == pytest.approx(np.append(0.0, touched["time"][:-1]) + touched["knee_strike"])
    assert not len(signals.knee_strikes(walk))
