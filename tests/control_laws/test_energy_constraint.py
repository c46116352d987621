"""Energy constraint control: the energy law with virtual gravity, the ratio of torques, the singular configuration."""

import math

import numpy as np
import pytest
from closed_loop import in_plain_python, memory_on, motion, power, slopes, states
from hypothesis import assume, given
from hypothesis import strategies as st

import mjbiped
from controllers import EnergyConstraintController
from mjbiped.errors import InputError
from mjbiped.robots.compass import Array, Compass
from mjbiped.terrain.terrain import Terrain

ROBOT = mjbiped.Compass()
GAIT = mjbiped.find_passive_gait(ROBOT, math.radians(2))
HEAVY = Compass(leg_mass=3.1, hip_mass=7.3, lower_length=0.37, upper_length=0.58, leg_inertia=0.123, gravity=5.0)

ratios = st.one_of(st.floats(-8.0, -0.1), st.floats(0.1, 8.0))


def centre_of_mass(robot: Compass, q: Array) -> tuple[float, Array]:
    """Its place ahead of the stance foot along the ground, m, from the masses' places, and its derivative by q."""
    length, below = robot.leg_length, robot.upper_length
    stance, hip = robot.lower_length * math.sin(q[0]), length * math.sin(q[0])
    swing = hip - below * math.sin(q[1])
    place = robot.leg_mass * (stance + swing) + robot.hip_mass * hip
    by_q = np.array(
        [
            (robot.leg_mass * (robot.lower_length + length) + robot.hip_mass * length) * math.cos(q[0]),
            -robot.leg_mass * below * math.cos(q[1]),
        ]
    )
    return place / robot.total_mass, by_q / robot.total_mass


def pull(robot: Compass, slope: float) -> float:
    """Of the torques, N: virtual gravity's along the ground less true gravity's."""
    return robot.weight * math.cos(slope) * (math.tan(GAIT.slope) - math.tan(slope))


def surplus(robot: Compass, state: Array, slope: float, tilt: float = 0.0) -> float:
    """E - E_d, J, with the true total energy about the stance foot."""
    start = GAIT.energy * math.cos(slope + tilt) / math.cos(GAIT.slope)
    wanted = start + pull(robot, slope + tilt) * centre_of_mass(robot, state[:2] - tilt)[0]
    return robot.energy(state[:2], state[2:], slope) - wanted


@given(st.sampled_from([ROBOT, HEAVY]), states, slopes, slopes, st.floats(0.1, 200.0), ratios)
def test_power_of_the_torques(
    robot: Compass, state: Array, slope: float, tilt: float, gain: float, ratio: float
) -> None:
    controller = EnergyConstraintController(
        robot, GAIT, gain=gain, ratio=ratio, initial_slope_estimate=slope, slope_source="two_point"
    )
    dq = state[2:]
    assume(abs((ratio - 1.0) * dq[0] + dq[1]) >= controller.singular_band)
    promised = pull(robot, slope + tilt) * (centre_of_mass(robot, state[:2] - tilt)[1] @ dq)
    promised -= gain * surplus(robot, state, slope, tilt)
    scale = 1.0 + robot.weight * np.abs(dq).sum() + gain * GAIT.energy
    assert power(controller, memory_on(controller, tilt), 0.0, state) == pytest.approx(promised, abs=1e-10 * scale)


@given(states, slopes, ratios)
def test_the_ratio_is_exact(state: Array, slope: float, ratio: float) -> None:
    controller = EnergyConstraintController(ROBOT, GAIT, ratio=ratio, initial_slope_estimate=slope)
    ankle, hip = controller.torque(memory_on(controller), 0.0, state[:2].tolist(), state[2:].tolist())
    assert ankle == ratio * hip


@pytest.mark.parametrize(("slope", "tilt"), [(0.0, 0.0), (0.08, 0.0), (-0.03, 0.05)])
def test_energy_along_a_step(slope: float, tilt: float) -> None:
    """E - E_d falls exponentially: that is the law, integrated."""
    controller = EnergyConstraintController(
        ROBOT, GAIT, gain=6.0, ratio=-2.0, initial_slope_estimate=slope, slope_source="two_point"
    )
    start = GAIT.start + np.array([tilt, tilt, 0.1, 0.1])
    times = np.linspace(0.0, 0.5, 26)
    path = motion(controller, memory_on(controller, tilt), slope, start, times)
    assert (np.abs(-3.0 * path[:, 2] + path[:, 3]) > controller.singular_band).all()
    surpluses = np.array([surplus(ROBOT, state, slope, tilt) for state in path])
    assert abs(surpluses[0]) > 0.2
    assert surpluses == pytest.approx(surpluses[0] * np.exp(-6.0 * times), abs=1e-9)  # integrator, of energies of 50 J


def test_on_the_level_it_is_asanos_law() -> None:
    """With a gait of virtual gravity's own strength, g / cos(phi_r), the surplus along it is nil."""
    stronger = Compass(gravity=ROBOT.gravity / math.cos(GAIT.slope))
    own = mjbiped.find_passive_gait(stronger, GAIT.slope)
    for t in np.linspace(0.0, own.period, 7):
        q, dq, _ = own.reference(t)
        assert surplus(ROBOT, np.concatenate([q, dq]), 0.0) == pytest.approx(0.0, abs=1e-9)  # the gait's own accuracy


def test_virtual_gravitys_own_ratio() -> None:
    """What the default's neighbourhood rests on: -2 for Table I where the legs make equal angles."""
    virtual = ROBOT.gravity_vector([0.2, 0.2], 0.0) - ROBOT.gravity_vector([0.2, 0.2], GAIT.slope) / math.cos(
        GAIT.slope
    )
    ankle, hip = np.linalg.solve(ROBOT.input_matrix, virtual)
    assert ankle / hip == pytest.approx(-2.0, abs=1e-12)


def test_where_on_the_gait_the_singular_configuration_lies() -> None:
    """The docstring's numbers: twice per step between two ratios, never beyond."""
    rates = np.array([GAIT.reference(t)[1] for t in np.linspace(0.0, GAIT.period, 4001)])
    limits = 1.0 - rates[:, 1] / rates[:, 0]
    assert (limits.min(), limits.max()) == (pytest.approx(-0.043, abs=1e-3), pytest.approx(42.96, abs=0.01))
    for ratio, crossings in ((-2.3, 0), (-0.1, 0), (0.5, 2), (2.0, 2), (40.0, 2), (44.0, 0)):
        bracket = (ratio - 1.0) * rates[:, 0] + rates[:, 1]
        assert np.count_nonzero(np.diff(np.sign(bracket))) == crossings


def test_torques_are_bounded_and_continuous_at_the_singular_configuration() -> None:
    controller = EnergyConstraintController(ROBOT, GAIT, ratio=-2.0, singular_band=0.2)
    memory = memory_on(controller)
    brackets = np.linspace(-0.5, 0.5, 4001)
    hips = np.array([controller.torque(memory, 0.0, (0.1, -0.1), (0.5, 1.5 + each))[1] for each in brackets])
    assert hips[2000] == pytest.approx(0.0, abs=1e-12)
    # steepest inside the band: power over its square
    steps = np.abs(np.diff(hips))
    power_there = abs(hips[1500]) * abs(brackets[1500]) if abs(brackets[1500]) >= 0.2 else abs(hips[1000]) * 0.25
    assert steps.max() < 3.0 * power_there / 0.2**2 * (brackets[1] - brackets[0])
    assert controller.torque(memory, 0.0, (0.0, 0.0), (0.0, 0.0)) == pytest.approx((0.0, 0.0), abs=1e-15)


@pytest.mark.parametrize("ratio", [0.5, 2.0, 4.0, 10.0])
def test_a_ratio_with_the_singular_configuration_on_the_gait_falls(ratio: float) -> None:
    controller = EnergyConstraintController(ROBOT, GAIT, ratio=ratio)
    walk = mjbiped.walk(in_plain_python(controller), Terrain.level(), engine="hybrid", steps=20)
    assert walk.outcome != "finished"


def test_level_walk() -> None:
    """It has a gait of its own, cheaper than the imitated one by what docs/comparison.md says."""
    walk = mjbiped.walk(
        in_plain_python(EnergyConstraintController(ROBOT, GAIT)), Terrain.level(), engine="hybrid", steps=50
    )
    assert walk.outcome == "finished"
    work, x = walk.touchdowns["work_absolute"], walk.touchdowns["x"]
    steady = (work[-1] - work[-11]) / (ROBOT.weight * (x[-1] - x[-11]))
    assert steady == pytest.approx(math.sin(GAIT.slope), abs=5e-4)
    states = np.hstack([walk.touchdowns["q"], walk.touchdowns["dq"]])
    assert states[-1] == pytest.approx(states[-2], abs=1e-8)
    assert not np.allclose(states[-1], GAIT.start, atol=1e-3)


def test_bad_gains_are_refused() -> None:
    for name in ("gain", "singular_band"):
        for value in (0.0, -1.0, math.nan, "3", True):
            with pytest.raises(InputError, match=f"{name} = .*: must be "):
                EnergyConstraintController(ROBOT, GAIT, **{name: value})  # type: ignore[arg-type]
    for ratio in (0.0, math.nan, math.inf, "2", True, None):
        with pytest.raises(InputError, match=r"ratio = .* must be "):
            EnergyConstraintController(ROBOT, GAIT, ratio=ratio)  # type: ignore[arg-type]
