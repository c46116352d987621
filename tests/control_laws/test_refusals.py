"""What no law takes is refused by name; what one takes is described in JSON."""

import math
from typing import Any

import pytest

import controllers
import mjbiped

ROBOT, KNEES = mjbiped.Compass(), mjbiped.KneedBiped()
GAIT = mjbiped.find_passive_gait(ROBOT, math.radians(2))
NEGATIVE, POSITIVE, NUMBERS = (-1e-9, math.nan), (0.0, math.nan, "3", True), (math.nan, "0")
LAWS: dict[str, dict[str, tuple[Any, ...]]] = {
    "AdaptiveController": {
        **dict.fromkeys(("position_gain", "velocity_gain", "adaptation_gain"), (*NEGATIVE, None)),
        **dict.fromkeys(("update_threshold", "replanning_threshold"), (-1e-9, "5")),
        "replanning_delay": (0.0, math.nextafter(1.0, 2.0), math.nan, True),
        "initial_slope_estimate": (math.pi / 2, math.nan, "0"),
        "estimate_update": ("no",),
        "replanning": ("other",),
    },
    "LibraryController": {
        "climbing_clearance": (-1,),
        "climbing_steps": (0,),
        "height_threshold": (math.nan,),
        "climbing_gait": ("high",),
    },
    "PassivityController": {"gain": POSITIVE},
    "EnergyConstraintController": dict.fromkeys(("gain", "ratio", "singular_band"), POSITIVE),
    "KineticEnergyController": {**dict.fromkeys(("gain", "slowest"), POSITIVE), "hip_weight": (-1.0,)},
    "LimitCycleController": dict.fromkeys(("rate_gain", "position_gain"), POSITIVE),
    "BoundedAnkleController": {"sole_share": (0.0, 1.1)},
}
KNOWN_SLOPE = [name for name in LAWS if "gain" in LAWS[name] or "rate_gain" in LAWS[name]]
CASES = [
    *((name, field, value) for name, wrong in LAWS.items() for field, values in wrong.items() for value in values),
    *((name, "initial_slope_estimate", value) for name in KNOWN_SLOPE for value in (1.6, *NUMBERS)),
    *((name, "slope_source", "two-point") for name in KNOWN_SLOPE),
]


@pytest.mark.parametrize(("name", "field", "value"), CASES)
def test_values_outside_their_domain_are_refused_by_name(name: str, field: str, value: Any) -> None:
    with pytest.raises(mjbiped.InputError, match="needs a mjbiped.*and str" if field == "climbing_gait" else field):
        getattr(controllers, name)(ROBOT, GAIT, **{field: value})


@pytest.mark.parametrize("name", [*LAWS, "KneedController"])
def test_what_is_no_robot_and_no_gait_of_it_is_refused(name: str) -> None:
    for robot, gait in ((GAIT, ROBOT), (None, GAIT), (KNEES if name == "KneedController" else ROBOT, None)):
        with pytest.raises(mjbiped.InputError, match="needs a mjbiped"):
            getattr(controllers, name)(robot, gait)
