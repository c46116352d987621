"""The greatest disturbance that is survived, and what each disturbance is."""

import math

import pytest
from hypothesis import given
from hypothesis import strategies as st

from mjbiped.gaits.kneed import find_kneed_gait
from mjbiped.robots.compass import Compass
from mjbiped.robots.kneed import KneedBiped
from mjbiped.studies.cell import Cell
from mjbiped.studies.robustness_findings import greatest_survived
from mjbiped.studies.robustness_walks import DISTURBANCES, MARGINS


@given(st.lists(st.floats(0.0, 1.0), min_size=1, max_size=20), st.floats(0.5, 1.0))
def test_nothing_below_the_greatest_is_not_survived(shares: list[float], wanted: float) -> None:
    cases = 100
    survived = {float(k): [case < round(share * cases) for case in range(cases)] for k, share in enumerate(shares, 1)}
    greatest = int(greatest_survived(DISTURBANCES["step up"], survived, wanted) or 0)
    found = [sum(each) / cases for each in survived.values()]
    assert all(share >= wanted for share in found[:greatest])
    assert greatest == len(shares) or found[greatest] < wanted


def test_a_torque_limit_is_harder_the_lower_it_is() -> None:
    survived = {10.0: [True, False], 30.0: [True, True], 20.0: [True, True]}
    assert greatest_survived(MARGINS["torque limit"], survived, 0.9) == 20.0


@pytest.mark.parametrize(
    ("name", "magnitude", "rise", "slope_deg"),
    [
        ("step up", 0.04, 0.04, 0.0),
        ("step down", 0.1, -0.1, 0.0),
        ("slope down", 3.0, 0.0, 3.0),
        ("slope up", 3.0, 0.0, -3.0),
    ],
)
def test_level_ground_is_disturbed_once_and_where_it_is_said(
    name: str, magnitude: float, rise: float, slope_deg: float
) -> None:
    terrain = Cell(0, None, DISTURBANCES[name].described(magnitude, "hybrid", Compass(), 1.5)).terrain()
    assert terrain.height(1.4999) == 0.0
    assert terrain.slope(1.4999) == 0.0
    assert terrain.height(1.5) == pytest.approx(rise, abs=1e-12)
    assert terrain.slope(1.5) == pytest.approx(math.radians(slope_deg), abs=1e-12)
    assert terrain.height(9.0) == pytest.approx(rise - 7.5 * math.tan(math.radians(slope_deg)), abs=1e-9)


@pytest.mark.parametrize(
    ("name", "factors"),
    [
        ("mass too great", {"leg_mass": 1.2, "leg_inertia": 1.2}),  # heavier legs of the same shape
        ("inertia too great", {"leg_inertia": 1.2}),
        ("legs too long", {"lower_length": 1.2, "upper_length": 1.2, "leg_inertia": 1.44}),  # m l^2 / 12
    ],
)
def test_what_a_controller_believes_wrongly(name: str, factors: dict[str, float]) -> None:
    described = MARGINS[name].described(20.0, "hybrid", Compass())
    believed, usual = Compass(**Cell(0, None, described).section("model")), Compass()
    for parameter in ("leg_mass", "hip_mass", "lower_length", "upper_length", "leg_inertia", "gravity"):
        wanted = factors.get(parameter, 1.0) * getattr(usual, parameter)
        assert getattr(believed, parameter) == pytest.approx(wanted, rel=1e-12)


@pytest.mark.parametrize(
    ("name", "factors"),
    [
        # uniform rods of the same shape; the point mass at the hip is none of the legs'
        ("mass too great", dict.fromkeys(("thigh_mass", "shank_mass", "thigh_inertia", "shank_inertia"), 1.2)),
        (
            "legs too short",
            {
                **dict.fromkeys(("thigh_length", "shank_length", "thigh_centre", "shank_centre"), 0.8),
                **dict.fromkeys(("thigh_inertia", "shank_inertia"), 0.64),
            },
        ),
    ],
)
def test_what_a_controller_believes_wrongly_of_knees(name: str, factors: dict[str, float]) -> None:
    robot = KneedBiped(hip_mass=4.0)
    described = MARGINS[name].described(20.0, "hybrid", robot)
    cell = Cell(0, None, {"robot.kind": "kneed", "robot.hip_mass": 4.0, "controller.name": "adaptive", **described})
    believed = cell.controller(find_kneed_gait(KneedBiped(), math.radians(2.5))).robot
    assert cell.robot() == robot
    for parameter in KneedBiped.numbers():
        wanted = factors.get(parameter, 1.0) * getattr(robot, parameter)
        assert getattr(believed, parameter) == pytest.approx(wanted, rel=1e-12)


def test_friction_is_set_in_mujoco_and_asked_for_in_the_hybrid_engine() -> None:
    friction = MARGINS["friction"]
    assert friction.described(0.5, "mujoco", Compass()) == {"disturbances.friction": 0.5}
    assert friction.described(0.5, "hybrid", Compass()) == {}
    row = {"engine": "hybrid", "magnitude": 0.5}
    assert friction.borne({**row, "largest_stance_friction": 0.49})
    assert not friction.borne({**row, "largest_stance_friction": 0.51})
    assert not friction.borne({**row, "largest_stance_friction": None})  # without bound: the ground would have to pull
    assert friction.borne({**row, "engine": "mujoco", "largest_stance_friction": 0.51})
