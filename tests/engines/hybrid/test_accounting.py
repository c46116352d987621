"""The book-keeping of a step: no change of a power's sign is missed, and all that is kept is what samples say."""

import math
from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest
from hypothesis import assume, given, settings
from hypothesis import strategies as st
from simulations import hybrid_simulation

import mjbiped
from controllers import AdaptiveController
from mjbiped.dynamics.integrate import IN_ORDER, PLACES, STAGES_WITH_DENSE
from mjbiped.engines.hybrid.accounting import _total_variation, _turns
from mjbiped.engines.hybrid.forces import parabola_top
from mjbiped.engines.hybrid.motion import stance_force
from mjbiped.records.pressure import centre_of_pressure

ONE = SimpleNamespace(size=1)


def rates(power: np.polynomial.Polynomial) -> SimpleNamespace:
    """What a step leaves of a power: that of its stages, of which eight are looked at."""
    k = [[0.0] for _ in range(STAGES_WITH_DENSE)]
    for stage, place in zip(IN_ORDER, PLACES, strict=True):
        k[stage] = [float(power(place))]
    return SimpleNamespace(k=k)


@given(st.floats(0.03, 0.97), st.floats(1e-3, 0.2), st.floats(-3.0, 3.0), st.sampled_from([-1.0, 1.0]))
@settings(deadline=None, derandomize=True)
def test_two_changes_of_sign_between_two_stages_are_seen(middle: float, width: float, tilt: float, sign: float) -> None:
    first, last = middle - width / 2.0, middle + width / 2.0
    assume(first > 0.0 and last < 1.0)
    dip = np.polynomial.Polynomial.fromroots([first, last])
    shape = dip + 0.02 * tilt * dip**2
    assert _turns(ONE, rates(sign * shape), 0, 0.1)


@given(st.floats(0.3, 3.0), st.floats(-1.0, 1.0))
@settings(deadline=None, derandomize=True)
def test_a_power_far_from_zero_does_not_turn(least: float, lean: float) -> None:
    power = np.polynomial.Polynomial([least + 1.0 + abs(lean), lean, 1.0])
    assert not _turns(ONE, rates(power), 0, 0.1)


@pytest.mark.parametrize("clearance", [0.04, pytest.param(0.07, marks=pytest.mark.slow)])
def test_absolute_work_is_that_of_a_fine_quadrature(clearance: float) -> None:
    # in the first step of either an integration step of some 0.1 s holds a dip of the ankle's power that lasts 0.01 s
    robot = mjbiped.Compass()
    controller = AdaptiveController(robot, mjbiped.find_reference(robot, clearance=clearance), replanning="additive")
    walk = mjbiped.walk(controller, mjbiped.Terrain.level(), engine="hybrid", steps=1, sample_period=2e-5)
    end = walk.touchdowns["time"][0]
    time, torque, rate = (np.asarray(walk.samples[name]) for name in ("time", "torque", "dq"))
    within = time < end
    power = torque * np.column_stack([rate[:, 0], rate[:, 1] - rate[:, 0]])
    expected = 0.0
    for each in np.abs(power[within]).T:
        expected += np.trapezoid(each, time[within]) + each[-1] * (end - time[within][-1])
    # trapezia of 20 us leave 1e-8 of it, and the last piece, of less than that, 1e-8 more; a missed dip is 1e-4
    assert walk.touchdowns["work_absolute"][0] == pytest.approx(expected, rel=1e-6)


@pytest.fixture(scope="module")
def hasty(controller: AdaptiveController) -> mjbiped.Walk:
    """Down stairs of 60 mm, re-planned so quickly that the ground would have to pull in the fourth step."""
    law = replace(controller, replanning_delay=0.1)
    return mjbiped.walk(law, mjbiped.Terrain.stairs(), engine="hybrid", steps=4, sample_period=1e-4)


@pytest.mark.parametrize("step", range(4))
def test_what_is_kept_of_a_step_is_what_its_samples_say(hasty: mjbiped.Walk, step: int) -> None:
    """Work, least normal force, friction and the centre of pressure, by the robot's own force of the ground."""
    robot, samples, touched = hasty.robot, hasty.samples, hasty.touchdowns
    begin, end = np.append(0.0, touched["time"])[step : step + 2]
    within = (samples["time"] > begin - 1e-9) & (samples["time"] < end - 1e-9)
    time, q, dq, torque, slopes = (samples[name][within] for name in ("time", "q", "dq", "torque", "slope"))
    forces = np.array([robot.ground_force(*each) for each in zip(q, dq, torque, slopes, strict=True)])
    sine, cosine = math.sin(slopes[0]), math.cos(slopes[0])
    along, normal = forces @ [cosine, -sine], forces @ [sine, cosine]
    power = torque * np.column_stack([dq[:, 0], dq[:, 1] - dq[:, 0]])
    for name, each in (("absolute", np.abs(power)), ("net", power), ("positive", np.maximum(power, 0.0))):
        found = touched[f"work_{name}"][step] - (touched[f"work_{name}"][step - 1] if step else 0.0)
        # the samples end up to 0.1 ms before the step, of some 0.7 s
        assert found == pytest.approx(np.trapezoid(each, time, axis=0).sum(), rel=1e-3)
    # of some 20 integration steps, whose nodes alone are looked at where the ground bears 0.7 weights and more
    assert touched["normal_force"][step] == pytest.approx(normal.min(), abs=3e-4 * robot.weight)
    if step < 3:
        place = -torque[:, 0] / normal
        assert touched["friction"][step] == pytest.approx(np.abs(along / normal).max(), rel=2e-3)
        assert touched["pressure_ahead"][step] == pytest.approx(place.max(), rel=5e-3)
        assert touched["pressure_behind"][step] == pytest.approx(-place.min(), rel=5e-3)
    else:  # without a force of the ground the centre of pressure is as far away as can be
        assert normal.min() < 0.0
        assert touched["pressure_ahead"][step] > 2.0 * robot.leg_length


def test_the_centre_of_pressure_is_that_of_the_step_alone(controller: AdaptiveController) -> None:
    """The first step from rest needs 6.6 cm behind the ankle, those after it 2.2 cm."""
    walk = mjbiped.walk(
        controller, mjbiped.Terrain.level(), engine="hybrid", steps=4, initial="rest", sample_period=1e-3
    )
    begins = np.append(0.0, walk.touchdowns["time"])
    for step in range(4):
        within = (walk.samples["time"] > begins[step] + 1e-9) & (walk.samples["time"] < begins[step + 1] - 1e-9)
        place = centre_of_pressure(walk)[within]
        # samples lie up to 1 ms beside the greatest distance
        assert walk.touchdowns["pressure_ahead"][step] == pytest.approx(place.max(), abs=1e-3)
        assert walk.touchdowns["pressure_behind"][step] == pytest.approx(-place.min(), abs=1e-3)


def test_a_foot_on_its_pivot_neither_slips_nor_sinks(hasty: mjbiped.Walk) -> None:
    for name in ("slip", "penetration"):
        assert set(hasty.touchdowns[name].tolist()) == {0.0}


def test_peaks_are_those_of_the_samples(hasty: mjbiped.Walk) -> None:
    assert hasty.peak_torque == pytest.approx(np.abs(hasty.samples["torque"]).max(axis=0), rel=1e-4)
    assert (hasty.peak_torque >= np.abs(hasty.samples["torque"]).max(axis=0)).all()


def test_samples_have_the_laws_own_states(hasty: mjbiped.Walk) -> None:
    """Sine and cosine of the slope's estimate, which is a column of its own, too."""
    sine, cosine = hasty.samples["controller_states"].T
    assert sine[-1] != 0.0
    np.testing.assert_allclose(np.arctan2(sine, cosine), hasty.samples["slope_estimate"], rtol=0, atol=1e-15)


@given(*[st.floats(-10.0, 10.0)] * 3)
@settings(deadline=None, derandomize=True)
def test_the_top_of_a_parabola_is_its_extremum(bend: float, top: float, height: float) -> None:
    parabola = np.polynomial.Polynomial([height + bend * top * top, -2.0 * bend * top, bend])
    found = parabola_top(*(float(parabola(place)) for place in (-1.0, 0.0, 1.0)))
    assume(abs(bend) > 1e-3)
    assume(abs(abs(top) - 1.0) > 1e-6)
    assert found == pytest.approx(height if abs(top) < 1.0 else 0.0, abs=1e-9)


@given(st.floats(-0.3, 0.3), st.tuples(*[st.floats(-300.0, 300.0)] * 2), st.floats(-50.0, 50.0))
@settings(deadline=None, derandomize=True)
def test_a_push_is_none_of_the_grounds(slope: float, ddq: tuple[float, float], push: float) -> None:
    """The rate of the momentum is of the ground's force and of the push, which is horizontal."""
    simulation = hybrid_simulation(mjbiped.Terrain.incline(math.degrees(slope)), (-0.2, 0.2, 1.0, 0.5))
    c, w, state = simulation.constants, simulation.state, ((-0.2, 0.2), (1.0, 0.5))
    without = stance_force(c, w, *state, ddq)
    w.push = push
    pushed = push * math.cos(slope), push * math.sin(slope)
    assert stance_force(c, w, *state, ddq) == pytest.approx(np.subtract(without, pushed), abs=1e-11)


@pytest.mark.parametrize("turn", [0.03, 0.4, 0.97])
@pytest.mark.parametrize("sign", [1.0, -1.0])
def test_a_turn_counts_in_the_first_and_in_the_last_sixteenth_of_a_step_too(turn: float, sign: float) -> None:
    """The work turn^2 - (x - turn)^2 rises by turn^2, and falls by (1 - turn)^2; in Hermite's form a x + x (1 - x)."""
    a = 2.0 * turn - 1.0
    dense = [[sign * a], [sign], *[[0.0]] * 5]
    w = SimpleNamespace(y=[0.0], out=[sign * a], dense=dense)
    assert _total_variation(ONE, w, 0) == pytest.approx(turn**2 + (1.0 - turn) ** 2, rel=1e-9)
