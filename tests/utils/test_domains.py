"""Every number that a user can give has a domain with both ends, in which robots of all sizes walk alike."""

import inspect
import math
from collections.abc import Callable, Iterator
from decimal import Decimal
from fractions import Fraction
from itertools import product
from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from time_limits import within

import mjbiped
from controllers import (
    AdaptiveController,
    EnergyConstraintController,
    KineticEnergyController,
    LimitCycleController,
    PassiveController,
    PassivityController,
)
from mjbiped import InputError, Terrain
from mjbiped.engines.mujoco.engine import LEG
from mjbiped.terrain.presets import PRESETS
from mjbiped.utils import domains
from mjbiped.utils.domains import Domain, Interval, check_states, known_name

ROBOT = mjbiped.Compass()
GAIT = mjbiped.find_passive_gait(ROBOT, math.radians(2.0))
SOME = Domain(1e-6, 1e6, "kg")

# ---- what a domain is ------------------------------------------------------------------------------------------------


@given(st.floats(1e-6, 1e6))
def test_numbers_of_a_domain_pass_as_plain_floats(value: float) -> None:
    for given_as in (value, np.float64(value), Fraction(value)):
        found = SOME.check("leg_mass", given_as)
        assert (type(found), found) == (float, value)
    assert SOME.array("leg_masses", [value, 1], (2,)).tolist() == [value, 1.0]
    assert math.copysign(1.0, Domain(-1.0, 1.0).check("x", -0.0)) == 1.0


def refuse(check: Callable[[], object], message: str) -> None:
    with pytest.raises(InputError, match=message) as refused:
        check()
    assert len(str(refused.value)) < 200


@pytest.mark.parametrize(
    ("value", "message"),
    [
        ([[1.0], [1.0, 2.0]], r"m = .*: must be numbers from"),
        ([1.0, 10**400], r"m: inf in it: must be finite numbers from"),
        ([1.0, 0.0], r"m: 0.0 in it: must be numbers from"),
        ([[1.0, 2.0]], r"m: expected shape \(n,\), got \(1, 2\)"),
    ],
)
def test_arrays_have_a_shape_and_numbers_of_the_domain(value: object, message: str) -> None:
    refuse(lambda: SOME.array("m", value, (None,)), message)
    assert SOME.array("m", [Fraction(1, 2), 10**3], (None,)).tolist() == [0.5, 1000.0]
    assert SOME.array("m", 3, None).shape == ()


def test_the_other_checks() -> None:
    assert Interval(domains.STEP).check("rise", [0, 0.5]) == (0.0, 0.5)
    for value, ends in ((0.1, (0.1, 0.1)), ((0, 0.2), (0.0, 0.2)), ("0.1, 0.2", (0.1, 0.2))):
        assert domains.SOLE.check("sole", value) == ends
    for wrong in (-0.1, (0.1, 0.2, 0.3), "0.1,", (0.1, math.nan), (), True, {"behind": 0.1}):
        refuse(lambda wrong=wrong: domains.SOLE.check("sole", wrong), "sole = .*one distance from 0 to 1000 m, or two")  # type: ignore[misc]
    refuse(lambda: check_states("state", (3e5, 0, 0, 0), (4,)), "its angles: 300000")
    for name in ("levle", "l" * 10**6, 10**5000, ["level"], None):
        refuse(lambda name=name: known_name("terrain", name, ("level", "incline")), "valid are level, incline")  # type: ignore[misc]


LAWS = (EnergyConstraintController, KineticEnergyController, LimitCycleController, PassivityController)

# ---- nonsense is refused everywhere ----------------------------------------------------------------------------------

NONSENSE: tuple[object, ...] = (math.nan, 10**5000, Decimal("1e400"), "x", True, [[1.0, 2.0]] * 3, np.array(["a"]))
OPTIONAL = {"leg_inertia", "replanning_delay", "first", "steps", "distance", "control_period", "sample_period", "robot"}
OPTIONAL |= {"scuffing", "mujoco", "hybrid", "workers", "threads", "stance_rates", "swing_rates"}
OPTIONAL |= {"disturbances", "torque_limit", "motor_bandwidth", "push_interval", "friction", "sole", "surface"}


TOLD = {"progress", "summaries", "estimate_update", "slope_source", "replanning", "name", "parameters", "lands"}
TOLD |= {"stance_knee"}
"""Arguments that are neither numbers nor objects of ours."""


def quantities() -> Iterator[tuple[str, Callable[[Any], object]]]:
    """Every argument that takes numbers or one of our objects, with a call that gives it a value."""
    passive, ground = PassiveController(), Terrain.incline(2.0)
    at: dict[str, Any] = {"robot": ROBOT, "slope": 0.03}
    q, dq = {"q": (0.1, 0.2)}, {"dq": (0.1, 0.2)}
    calls: list[tuple[Callable[..., object], dict[str, Any]]] = [
        *((kind, {}) for kind in (mjbiped.Compass, mjbiped.ScuffingRule, mjbiped.Mujoco, mjbiped.Hybrid)),
        (mjbiped.Disturbances, {}),
        *((kind, {"robot": ROBOT, "gait": GAIT}) for kind in (AdaptiveController, *LAWS)),
        *((getattr(Terrain, name), {}) for name in PRESETS),
        (Terrain, {"x": (0.0,), "z": (0.0,), "angle": (0.0,)}),
        *((walk, {"controller": passive, "terrain": ground}) for walk in (mjbiped.walk, mjbiped.compare)),
        (mjbiped.walk_many, {"controllers": passive, "terrains": ground}),
        (mjbiped.find_passive_gait, at),
        (mjbiped.find_periodic_gait, {**at, "states": GAIT.start[None]}),
        (mjbiped.ReturnMap, at),
        (mjbiped.ReturnMap(**at).walk, {"state": GAIT.start, "steps": 1}),
        (mjbiped.find_cascade, {"robot": ROBOT}),
        (mjbiped.bifurcation_diagram, {"robot": ROBOT, "slopes": [0.03]}),
        (mjbiped.basin_of_attraction, at),
        (mjbiped.basin_of_control, {"controller": AdaptiveController(ROBOT, GAIT)}),
        (ROBOT.mass_matrix, q),
        (ROBOT.energy, {**q, **dq, "slope": 0.0}),
        (ROBOT.impact, {**q, **dq}),
        (ROBOT.swing_foot, q),
    ]
    for call, others in calls:
        for name in [name for name in inspect.signature(call).parameters if name not in TOLD]:
            yield f"{call.__qualname__}.{name}", lambda value, at=(call, others, name): at[0](**{**at[1], at[2]: value})  # type: ignore[misc]
    yield "Terrain.x[0]", lambda value: Terrain((value,), (0.0,), (0.0,))
    yield "segments[0]", lambda value: Terrain.from_segments([(value, 0.0, 0.0)])
    yield "segments[1]", lambda value: Terrain.from_segments([(1.0, value, 0.0)])
    yield "initial[3]", lambda value: mjbiped.walk(passive, ground, initial=(0.0, 0.0, 0.0, value))
    yield "q[0]", lambda value: ROBOT.mass_matrix([value, 0.0])


QUANTITIES = dict(quantities())


@pytest.mark.usefixtures("nothing_walks")
@pytest.mark.parametrize("quantity", QUANTITIES)
def test_nonsense_is_refused_in_words(quantity: str) -> None:
    name = quantity.split(".")[-1]
    for value in (*NONSENSE, *(() if name in OPTIONAL else (None,))):
        if quantity == "Robot.swing_foot.q" and isinstance(value, list):
            continue  # three postures
        with within(2.0, value), pytest.raises(InputError) as refused:
            QUANTITIES[quantity](value)
        assert len(str(refused.value)) < 600, value


# ---- robots of all sizes walk alike ----------------------------------------------------------------------------------


ENDS = [*product(*((each.low, each.high) for each in (domains.LEG_MASS, domains.LEG, domains.GRAVITY)))]
SLOW = [pytest.param(*ENDS[k], marks=pytest.mark.slow) for k in (1, 2, 4, 7)]


# in the quick ones each end of a number meets both ends of every other
@pytest.mark.parametrize(("mass", "leg", "gravity"), [*(ENDS[k] for k in (0, 3, 5, 6)), *SLOW])
def test_gaits_at_the_ends_are_those_of_table_one(mass: float, leg: float, gravity: float) -> None:
    length = leg / 2
    robot = mjbiped.Compass(mass, 0.0, length, length, mass * (2 * length) ** 2 / 12, gravity)
    faster = math.sqrt(gravity / (2 * length)) / math.sqrt(ROBOT.gravity)
    gait = mjbiped.find_passive_gait(robot, GAIT.slope)
    np.testing.assert_allclose(gait.start / [1.0, 1.0, faster, faster], GAIT.start, rtol=1e-13)  # rounding: 2e-15
    assert gait.period * faster == pytest.approx(GAIT.period, rel=1e-13)
    assert gait.step_length / robot.leg_length == pytest.approx(GAIT.step_length, rel=1e-13)
    np.testing.assert_allclose(gait.multipliers, GAIT.multipliers, rtol=1e-6)  # of differences
    times = np.linspace(0.0, 1.2 * GAIT.period, 50)
    for order, (found, expected) in enumerate(zip(gait.reference(times / faster), GAIT.reference(times), strict=True)):
        np.testing.assert_allclose(found / faster**order, expected, atol=1e-11)


@pytest.mark.parametrize("leg", [0.99 * LEG.low, 1.01 * LEG.high])
def test_mujoco_refuses_legs_that_its_ground_is_not_made_for(leg: float) -> None:
    robot = mjbiped.Compass(lower_length=leg / 2, upper_length=leg / 2)
    with pytest.raises(InputError, match=r"leg length in MuJoCo .*must be from 0.01 to 10 m"):
        mjbiped.walk(PassiveController(), Terrain.incline(2.0), robot=robot, initial=(-0.1, 0.1, 1.0, 1.0))
