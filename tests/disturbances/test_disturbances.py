"""What can be asked of `Disturbances`, and what is refused."""

from __future__ import annotations

import math
from typing import Any

import pytest

import mjbiped
from mjbiped.disturbances.disturbances import UNDISTURBED, Disturbances
from mjbiped.errors import InputError


@pytest.mark.parametrize(
    ("given", "said"),
    [
        ({"angle_noise": -1.0}, r"angle_noise = -1.0: must be from 0 to 1 rad"),
        ({"rate_noise": math.nan}, "rate_noise = nan: must be a finite number"),
        ({"torque_limit": "much"}, "torque_limit = 'much'"),
        ({"motor_bandwidth": 0.0}, "motor_bandwidth = 0.0"),
        ({"seed": 1.5}, "seed = 1.5: must be a whole number"),
        ({"pushes": 3.0}, "pushes, pairs of time"),
        ({"pushes": [(1.0,)]}, r"expected shape \(n, 2\)"),
        ({"pushes": [(2.0, 1.0), (1.0, 1.0)]}, "in order of time"),
        ({"pushes": [(2.0, 1.0), (2.01, 1.0)]}, "push_duration = 0.05 s apart"),
        ({"pushes": [(float(k), 1.0) for k in range(10_001)]}, "number of pushes = 10001: must be a whole number"),
        ({"push_impulse": 1.0}, "random pushes need both"),
        ({"push_interval": 1.0}, "random pushes need both"),
        ({"push_impulse": 1.0, "push_interval": 1.0, "pushes": [(1.0, 1.0)]}, "at given times or random ones"),
    ],
)
def test_what_makes_no_sense_is_refused(given: dict[str, Any], said: str) -> None:
    with pytest.raises(InputError, match=said):
        Disturbances(**given)


def test_a_delay_is_a_whole_number_of_control_periods() -> None:
    assert Disturbances(delay=0.012).delay_ticks(0.004) == 3
    with pytest.raises(InputError, match=r"delay = 0.01: must be a multiple of the control period 0.004 s"):
        Disturbances(delay=0.01).delay_ticks(0.004)
    with pytest.raises(InputError, match="at most 256 control periods"):
        Disturbances(delay=0.3).delay_ticks(0.001)


def test_one_control_period_holds() -> None:
    assert Disturbances(delay=0.01).period(None, 1e-4) == 1e-3
    assert Disturbances(delay=0.01).period(None, 4e-3) == 4e-3
    assert Disturbances(delay=0.01).period(2e-3, 1e-3) == 2e-3
    assert Disturbances(control_period=2e-3).period(2e-3, 1e-3) == 2e-3
    with pytest.raises(InputError, match=r"control_period = 0.002 of disturbances .* contradicts .* = 0.001"):
        Disturbances(control_period=2e-3).period(1e-3, 1e-3)


def test_a_record_says_what_is_not_as_usual() -> None:
    given = Disturbances(angle_noise=0.01, pushes=[(1, 2), (3.0, -4.0)], seed=2**64 - 1)
    assert given.to_dict() == {"angle_noise": 0.01, "pushes": [[1.0, 2.0], [3.0, -4.0]], "seed": 2**64 - 1}
    assert Disturbances.from_dict(given.to_dict()) == given
    assert UNDISTURBED.to_dict() == {}
    with pytest.raises(InputError, match=r"unknown disturbance 'angle_nose'.*did you mean 'angle_noise'"):
        Disturbances.from_dict({"angle_nose": 0.1})


@pytest.mark.parametrize("engine", ["mujoco", "hybrid"])
def test_a_walk_refuses_what_does_not_fit_before_it_begins(engine: str) -> None:
    from controllers import PassiveController

    ground = mjbiped.Terrain.incline(2.0)
    with pytest.raises(InputError, match=r"delay = 0.0105: must be a multiple of the control period 0.001 s"):
        mjbiped.walk(PassiveController(), ground, engine=engine, disturbances=Disturbances(delay=0.0105))
    with pytest.raises(InputError, match=r"disturbances must be a mjbiped.Disturbances, got dict"):
        mjbiped.walk(PassiveController(), ground, engine=engine, disturbances={"delay": 0.01})  # type: ignore[arg-type]


def test_a_control_period_in_mujoco_is_a_multiple_of_the_timestep() -> None:
    from controllers import PassiveController

    with pytest.raises(InputError, match=r"control_period = 0.0015: must be a multiple of the timestep 0.001 s"):
        mjbiped.walk(
            PassiveController(), mjbiped.Terrain.incline(2.0), disturbances=Disturbances(control_period=0.0015)
        )
