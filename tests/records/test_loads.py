"""The centre of pressure, as engines keep it and again from samples, the foot for it, and the stance knee's torque."""

import math
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import example, given, settings
from hypothesis import strategies as st
from numpy.typing import NDArray

import mjbiped
from controllers import AdaptiveController, KneedController, PassiveController
from mjbiped.errors import InputError
from mjbiped.records import loads, measures
from mjbiped.records.loads import (
    BINS,
    HALF,
    WIDTH,
    bin_of,
    centre_of_pressure,
    note_pressure,
    shortest_foot,
    unknown,
)
from mjbiped.robots.kneed import stance_knee_torque

Terrain = mjbiped.Terrain
LEVEL, STAIRS = Terrain.level(), Terrain.stairs(rise=-0.06, first=0.5)


@given(st.floats(-2.0, 2.0))
def test_every_place_has_its_bin(place: float) -> None:
    index = bin_of(place)
    low, high = (index - HALF) * WIDTH, (index + 1 - HALF) * WIDTH
    assert 0 <= index < BINS
    rounding = 1e-12
    assert index == 0 or low - rounding <= place
    assert index == BINS - 1 or place < high + rounding
    assert (bin_of(-math.inf), bin_of(math.inf)) == (0, BINS - 1)


def test_a_place_that_is_no_number_is_in_the_last_bin_as_machine_code_too() -> None:
    from mjbiped.numerics.machine import compiled

    places = (math.nan, -math.inf, -0.651, -0.65, 0.0, 0.639, 0.64, math.inf)
    machine = compiled(bin_of, "int64(float64)")
    assert [bin_of(place) for place in places] == [machine(place) for place in places]
    assert bin_of(math.nan) == BINS - 1


def test_a_flat_foot_is_in_balance_about_its_ankle() -> None:
    """The leg's torque on the foot is -tau; the ground's force F_n at x makes -x F_n: both are in balance."""
    u = [0.0] * (2 + BINS)
    u[0] = u[1] = -math.inf
    note_pressure(u, torque=5.0, normal=100.0, light=1.0, leg_length=1.0, time=0.1)
    place = -u[1]
    assert -5.0 - place * 100.0 == pytest.approx(0.0)
    assert (u[0], u[1]) == (-0.05, 0.05)
    assert u[2 + bin_of(-0.05)] == 0.1
    note_pressure(u, torque=-1.0, normal=0.5, light=1.0, leg_length=1.0, time=0.2)  # no foot is long enough
    assert (u[0], u[1], u[2 + BINS - 1]) == (-0.05, 0.05, 0.2)


@pytest.mark.slow
@settings(max_examples=25, deadline=None)
@given(
    st.lists(st.tuples(st.floats(-0.6, 0.6), st.floats(0.01, 1.0)), min_size=1, max_size=12),
    st.floats(0.5, 0.999),
    st.floats(0.0, 5.0),
)
@example([(0.5, 0.5)], 0.5000000000000001, 0.5)
def test_the_foot_is_the_shortest_that_holds(stays: list[tuple[float, float]], share: float, unmoved: float) -> None:
    """Against all feet that end at tenths of bins, the time in a bin spread evenly."""
    times = np.zeros(BINS)
    for place, time in stays:
        times[bin_of(place)] += time
    total = float(times.sum()) + unmoved
    places = [place for place, _ in stays]
    length = shortest_foot(times, total, max(places), -min(places), 1.0, share)
    ends = np.arange(0, 10 * (HALF - 1) + 1) / 10.0 * WIDTH
    beyond = {
        sign: np.array([spread(times, sign, end, max(sign * np.array(places))) for end in ends]) for sign in (1, -1)
    }
    out = beyond[1][:, None] + beyond[-1][None, :] - (1.0 - share) * total
    # the length jumps where a bin is left out as a whole: it is that on one side of the jump, within rounding of times
    least, most = (
        float(np.min((ends[:, None] + ends[None, :])[out <= rounding], initial=math.inf))
        for rounding in (1e-12, -1e-12)
    )
    assert length <= most + 1e-9
    assert length >= least - 0.2 * WIDTH - 1e-9  # a tenth of a bin at either end


def spread(times: NDArray[np.float64], sign: int, end: float, most: float) -> float:
    """Time beyond an end on one side, s."""
    side = times[HALF:] if sign > 0 else times[HALF - 1 :: -1]
    total = 0.0
    for k, time in enumerate(side):
        low, high = k * WIDTH, min((k + 1) * WIDTH, max(most, 0.0))
        total += time if end <= low else 0.0 if end >= high else time * (high - end) / (high - low)
    return total


def test_no_foot_is_long_enough_where_the_ground_must_pull() -> None:
    times = np.zeros(BINS)
    times[0], times[HALF] = 0.5, 9.5
    assert shortest_foot(times, 10.0, 0.005, 0.3, 1.0, 0.94) < 0.4
    assert shortest_foot(times, 10.0, 0.005, 0.3, 1.0) == math.inf
    assert math.isnan(shortest_foot(unknown(), 10.0, 0.1, 0.1, 1.0))


@pytest.mark.parametrize(("engine", "rel"), [("hybrid", 0.01), ("mujoco", 0.02)])
@pytest.mark.parametrize("terrain", [LEVEL, STAIRS], ids=["level", "stairs"])
def test_engines_keep_what_the_samples_tell(
    engine: str, rel: float, terrain: Terrain, controller: AdaptiveController
) -> None:
    """By the equations of motion: at the stages of integration steps, or from forces that are averaged over 5 ms."""
    walk = mjbiped.walk(controller, terrain, engine=engine, steps=4, sample_period=1e-3)
    sampled = centre_of_pressure(walk)
    told = walk.summary()
    span = np.ptp(np.append(sampled, 0.0))
    assert told["pressure_ahead_m"] == pytest.approx(sampled.max(), abs=rel * span)
    assert told["pressure_behind_m"] == pytest.approx(-sampled.min(), abs=rel * span)
    assert walk.pressure_times.sum() == pytest.approx(walk.end[0], rel=0.01)  # MuJoCo leaves out what is left of 5 ms
    bins = [bin_of(x / walk.robot.leg_length) for x in sampled]
    times: NDArray[np.float64] = np.bincount(bins, minlength=BINS).astype(np.float64) * 1e-3
    again = shortest_foot(times, walk.end[0], float(sampled.max()), -float(sampled.min()), walk.robot.leg_length)
    assert told["foot_length_99_percent_m"] == pytest.approx(again, abs=2.0 * rel * span)
    assert measures.foot_length(walk) == told["foot_length_99_percent_m"]


def test_level_walking_asks_for_two_centimetres(controller: AdaptiveController) -> None:
    """On the limit cycle torques cancel the reference's slope: x = -tau_1 / F_n, as by hand."""
    walk = mjbiped.walk(controller, LEVEL, engine="hybrid", steps=3, sample_period=1e-3)
    robot, samples = walk.robot, walk.samples
    half = len(samples["time"]) // 2
    q, dq, torque = (samples[name][half] for name in ("q", "dq", "torque"))
    pull = -robot.coriolis_matrix(q, dq) @ dq - robot.gravity_vector(q, 0.0) + robot.input_matrix @ torque
    ddq = np.linalg.solve(robot.mass_matrix(q), pull)
    # the centre of mass' acceleration, from second differences of its place along the motion
    h = 1e-4
    heights = [robot.centre_of_mass(posture(q + dt * dq + 0.5 * dt * dt * ddq))[1] for dt in (-h, 0.0, h)]
    normal = robot.total_mass * (robot.gravity + (heights[0] - 2.0 * heights[1] + heights[2]) / h**2)
    # differences: 1e-16 / h^2 of rounding and h^2 of the fourth derivative
    assert centre_of_pressure(walk)[half] == pytest.approx(-torque[0] / normal, rel=1e-6)
    assert (walk.summary()["pressure_ahead_m"], walk.summary()["pressure_behind_m"]) == pytest.approx(
        (-0.0164, 0.0222), abs=1e-4
    )


def posture(q: NDArray[np.float64]) -> list[float]:
    """`qpos` of the compass biped on its left foot at x = 0."""
    return [math.sin(q[0]), math.cos(q[0]), q[0], q[1]]


@pytest.mark.parametrize("engine", ["hybrid", "mujoco"])
def test_without_torque_the_force_goes_through_the_ankle(engine: str) -> None:
    told = mjbiped.walk(PassiveController(), Terrain.incline(2.0), engine=engine, steps=2).summary()
    assert (told["pressure_ahead_m"], told["pressure_behind_m"], told["foot_length_99_percent_m"]) == (0.0, 0.0, 0.0)


@pytest.mark.slow
@pytest.mark.parametrize("engine", ["hybrid", "mujoco"])
def test_with_knees_too(engine: str) -> None:
    robot = mjbiped.KneedBiped()
    controller = KneedController(robot, mjbiped.find_kneed_gait(robot, math.radians(2.5)))
    walk = mjbiped.walk(controller, Terrain.stairs(rise=-0.02), engine=engine, steps=4, sample_period=1e-3)
    sampled, told = centre_of_pressure(walk), walk.summary()
    assert told["pressure_ahead_m"] == pytest.approx(np.nanmax(sampled), abs=0.02 * np.ptp(sampled))
    assert told["pressure_behind_m"] == pytest.approx(-np.nanmin(sampled), abs=0.02 * np.ptp(sampled))


def test_a_damaged_slope_has_none(controller: AdaptiveController) -> None:
    """Records may hold any finite number; those that are no angle are left out, as states of a diverged walk are."""
    walk = mjbiped.walk(controller, LEVEL, engine="hybrid", steps=1)
    walk.samples["slope"][3] = 1e12
    places = centre_of_pressure(walk)
    assert np.isnan(places[3])
    assert np.isfinite(np.delete(places, 3)).all()


ROBOT = mjbiped.KneedBiped()
KEY = "peak_stance_knee_torque_Nm"


@pytest.fixture(scope="module")
def walk() -> mjbiped.Walk:
    law = KneedController(ROBOT, mjbiped.find_kneed_gait(ROBOT, math.radians(2.5)))
    ground = mjbiped.Terrain.from_segments([(0.7, -2.0), (9.0, 5.0)])
    return mjbiped.walk(law, ground, engine="hybrid", steps=3)


def test_it_is_the_robots_at_each_sample(walk: mjbiped.Walk) -> None:
    found, samples = loads.knee_torque(walk), walk.samples
    assert found.shape == samples["time"].shape
    for index in (0, 50, len(found) - 1):
        q, dq, torque, slope = (samples[name][index] for name in ("q", "dq", "torque", "slope"))
        locked = bool(samples["locked"][index])
        assert found[index] == stance_knee_torque(ROBOT, q, dq, torque, slope, locked=locked)
    assert not loads.flexion(walk).any()


def test_the_greatest_is_of_those_that_a_motor_must_give(walk: mjbiped.Walk) -> None:
    found = loads.knee_torque(walk)
    assert found.min() < 0.0 < found.max()
    assert loads.peak_knee_torque(walk) == found.max()
    samples = dict(walk.samples)
    # a bent knee has no stop to lie against: what straightens it is the motor's as well
    samples["qpos"] = samples["qpos"] + np.array([0, 0, 0, 0, 0.3, 0.3])
    bent = replace(walk, samples=samples)
    assert loads.flexion(bent) == pytest.approx(0.3)
    assert loads.peak_knee_torque(bent) == np.abs(loads.knee_torque(bent)).max() > found.max()


def test_the_summary_has_it_where_there_are_samples(walk: mjbiped.Walk) -> None:
    assert measures.summary(walk)[KEY] == loads.peak_knee_torque(walk)
    rows = {label: value for label, value, _ in walk.summary().rows}
    assert rows["peak torque, stance knee"] == f"{loads.peak_knee_torque(walk):.2f}"
    bare = replace(walk, samples={name: column[:0] for name, column in walk.samples.items()})
    assert measures.summary(bare)[KEY] is None


def test_a_walk_that_diverged_is_measured_as_far_as_it_goes(walk: mjbiped.Walk) -> None:
    samples = {name: column.copy() for name, column in walk.samples.items()}
    samples["torque"][-1] = math.nan
    samples["q"][-2] = 1e6
    found = loads.knee_torque(broken := replace(walk, samples=samples))
    assert np.isnan(found[-2:]).all()
    assert np.isfinite(found[:-2]).all()
    assert loads.peak_knee_torque(broken) > 0.0


def test_straight_legs_have_none() -> None:
    ground = mjbiped.Terrain.incline(2.0)
    straight = mjbiped.walk(PassiveController(), ground, engine="hybrid", steps=1)
    assert KEY not in measures.summary(straight)
    with pytest.raises(InputError, match="a compass biped and has no knees"):
        loads.knee_torque(straight)
