"""Controllers by name: each has its settings with their defaults, and nothing else."""

from __future__ import annotations

import math

import pytest

import mjbiped
from controllers import AdaptiveController, LimitCycleController, PassiveController, PassivityController
from controllers.given_slope import GivenSlopeController
from controllers.names import CONTROLLERS, make_controller, settings_of
from mjbiped.errors import InputError


@pytest.mark.parametrize("name", CONTROLLERS)
def test_defaults_are_the_settings(name: str, robot: mjbiped.Compass, gait: mjbiped.Gait) -> None:
    plain = make_controller(name, robot, {}, gait)
    assert make_controller(name, robot, settings_of(name), gait).describe() == plain.describe()
    if name == "passive":
        assert plain == PassiveController()
    else:
        assert plain.gait is gait
        assert plain.robot is robot


def test_settings_arrive(robot: mjbiped.Compass) -> None:
    law = make_controller("adaptive", robot, {"imitate_slope_deg": 1.0, "position_gain": 3, "replanning_delay": None})
    assert isinstance(law, AdaptiveController)
    assert (law.gait.slope, law.position_gain, law.replanning_delay) == (math.radians(1.0), 3, None)
    given = make_controller("passivity", robot, {"gain": 2.0, "initial_slope_estimate_deg": 3, "slope_source": "none"})
    assert isinstance(given, PassivityController)
    assert (given.gain, given.initial_slope, given.slope_source) == (2.0, math.radians(3.0), "none")


def test_slope_source_has_the_default_of_its_controller(robot: mjbiped.Compass, gait: mjbiped.Gait) -> None:
    assert settings_of("passivity")["slope_source"] == PassivityController(robot, gait).slope_source == "two_point"
    limit = LimitCycleController(robot, gait)
    assert isinstance(limit, GivenSlopeController)
    assert settings_of("limit-cycle")["slope_source"] == limit.slope_source


@pytest.mark.parametrize(
    ("name", "settings", "words"),
    [
        ("pid", {}, "unknown controller 'pid': valid are adaptive, passive, passivity"),
        ("passive", {"gain": 1}, "valid are none"),
        ("adaptive", {"robot": 1}, "position_gain, velocity_gain"),
        ("passivity", {"gian": 1}, "did you mean 'gain'"),
        ("adaptive", {"imitate_slope_deg": "steep"}, "imitate_slope_deg"),
        ("kinetic-energy", {"initial_slope_estimate_deg": math.nan}, "initial_slope_estimate_deg"),
        ("adaptive", {"position_gain": -1}, "position_gain"),
    ],
)
def test_refused_in_words(name: str, settings: dict[str, object], words: str, robot: mjbiped.Compass) -> None:
    with pytest.raises(InputError, match=words):
        make_controller(name, robot, settings)
