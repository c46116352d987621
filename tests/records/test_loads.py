"""The centre of pressure, as engines keep it and again from samples, the foot for it, and the stance knee's torque."""

import math
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import example, given, settings
from hypothesis import strategies as st

import mjbiped
from controllers import AdaptiveController, PassiveController
from mjbiped.records import loads, measures
from mjbiped.records.loads import BINS, HALF, WIDTH, bin_of, centre_of_pressure, note_pressure, shortest_foot, unknown
from mjbiped.robots.kneed import stance_knee_torque
from mjbiped.robots.robot import Array

Terrain = mjbiped.Terrain
LEVEL, STAIRS = Terrain.level(), Terrain.stairs(rise=-0.06, first=0.5)


@given(st.floats(-2.0, 2.0))
def test_every_place_has_its_bin(place: float) -> None:
    index = bin_of(place)
    low, high = (index - HALF) * WIDTH, (index + 1 - HALF) * WIDTH
    rounding = 1e-12
    assert index == 0 or low - rounding <= place
    assert index == BINS - 1 or place < high + rounding
    assert [bin_of(place) for place in (-math.inf, math.inf, math.nan)] == [0, BINS - 1, BINS - 1]


def test_a_flat_foot_is_in_balance_about_its_ankle() -> None:
    """The leg's torque on the foot is -tau; the ground's force F_n at x makes -x F_n: both are in balance."""
    u = [0.0] * (2 + BINS)
    u[0] = u[1] = -math.inf
    note_pressure(u, torque=5.0, normal=100.0, light=1.0, leg_length=0.8, time=0.1)
    place = -u[1]
    assert -5.0 - place * 100.0 == pytest.approx(0.0)
    assert (u[0], u[1]) == (-0.05, 0.05)
    assert u[2 + bin_of(-0.05 / 0.8)] == 0.1
    note_pressure(u, torque=-1.0, normal=0.5, light=1.0, leg_length=0.8, time=0.2)  # no foot is long enough
    note_pressure(u, torque=0.0, normal=100.0, light=1.0, leg_length=0.8, time=0.4)
    assert (u[0], u[1], u[2 + BINS - 1]) == (0.0, 0.05, 0.2)
    assert sum(u[2:]) == pytest.approx(0.3)


@settings(max_examples=20)
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
    places = np.array([place for place, _ in stays])
    length = shortest_foot(times, total, max(places), -min(places), 1.0, share)
    assert shortest_foot(times, total, 0.8 * max(places), -0.8 * min(places), 0.8, share) == pytest.approx(0.8 * length)
    ends = np.arange(0, 10 * (HALF - 1) + 1) / 10.0 * WIDTH
    beyond = {sign: np.array([spread(times, sign, end, max(sign * places)) for end in ends]) for sign in (1, -1)}
    out = beyond[1][:, None] + beyond[-1][None, :] - (1.0 - share) * total
    # the length jumps where a bin is left out as a whole: it is that on one side of the jump, within rounding of times
    lengths = np.add.outer(ends, ends)
    least, most = (float(np.min(lengths[out <= near], initial=math.inf)) for near in (1e-12, -1e-12))
    assert length <= most + 1e-9
    assert length >= least - 0.2 * WIDTH - 1e-9  # a tenth of a bin at either end


def spread(times: Array, sign: int, end: float, most: float) -> float:
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
    assert shortest_foot(times[::-1], 10.0, 0.3, 0.005, 1.0) == math.inf
    assert math.isnan(shortest_foot(unknown(), 10.0, 0.1, 0.1, 1.0))


@pytest.mark.parametrize(("engine", "rel"), [("hybrid", 0.01), ("mujoco", 0.02)])
@pytest.mark.parametrize("terrain", [LEVEL, STAIRS], ids=["level", "stairs"])
def test_engines_tell_the_same(engine: str, rel: float, terrain: Terrain, controller: AdaptiveController) -> None:
    """By the equations of motion: at the stages of integration steps, or from forces that are averaged over 5 ms."""
    walk = mjbiped.walk(controller, terrain, engine=engine, steps=4, sample_period=1e-3)
    sampled = centre_of_pressure(walk)
    told = walk.summary()
    span = np.ptp(np.append(sampled, 0.0))
    assert told["pressure_ahead_m"] == pytest.approx(sampled.max(), abs=rel * span)
    assert told["pressure_behind_m"] == pytest.approx(-sampled.min(), abs=rel * span)
    assert walk.pressure_times.sum() == pytest.approx(walk.end[0], rel=0.01)  # MuJoCo leaves out what is left of 5 ms
    bins = [bin_of(x / walk.robot.leg_length) for x in sampled]
    times = np.bincount(bins, minlength=BINS).astype(np.float64) * 1e-3
    again = shortest_foot(times, walk.end[0], float(sampled.max()), -float(sampled.min()), walk.robot.leg_length)
    assert told["foot_length_99_percent_m"] == pytest.approx(again, abs=2.0 * rel * span)


@pytest.mark.parametrize("engine", ["hybrid", "mujoco"])
def test_without_torque_the_force_goes_through_the_ankle(engine: str) -> None:
    told = mjbiped.walk(PassiveController(), Terrain.incline(2.0), engine=engine, steps=2).summary()
    assert (told["pressure_ahead_m"], told["pressure_behind_m"], told["foot_length_99_percent_m"]) == (0.0, 0.0, 0.0)


# ---- the stance knee -------------------------------------------------------------------------------------------------


def test_its_torque_is_the_robots_at_each_sample(kneed: mjbiped.Walk) -> None:
    found, samples, robot = loads.knee_torque(kneed), kneed.samples, mjbiped.KneedBiped()
    assert found.shape == samples["time"].shape
    for index in (0, 50, len(found) - 1):
        q, dq, torque, slope = (samples[name][index] for name in ("q", "dq", "torque", "slope"))
        locked = bool(samples["locked"][index])
        assert found[index] == stance_knee_torque(robot, q, dq, torque, slope, locked=locked)
    sampled, told = centre_of_pressure(kneed), kneed.summary()
    assert told["pressure_ahead_m"] == pytest.approx(np.nanmax(sampled), abs=0.02 * np.ptp(sampled))


def test_the_greatest_is_of_those_that_a_motor_must_give(kneed: mjbiped.Walk) -> None:
    found = loads.knee_torque(kneed)
    assert found.min() < 0.0 < found.max()
    assert loads.peak_knee_torque(kneed) == found.max() == kneed.summary()["peak_stance_knee_torque_Nm"]
    # a bent knee has no stop to lie against: what straightens it is the motor's as well
    bent = replace(kneed, samples={**kneed.samples, "qpos": kneed.samples["qpos"] + np.array([0, 0, 0, 0, 0.3, 0.3])})
    held = loads.knee_torque(bent)
    assert loads.flexion(bent) == pytest.approx(0.3)
    assert loads.peak_knee_torque(bent) == np.abs(loads.knee_torque(bent)).max() > found.max()
    pulled = replace(bent, samples={name: column[held < 0.0] for name, column in bent.samples.items()})
    assert loads.peak_knee_torque(pulled) == -held.min()
    bare = replace(kneed, samples={name: column[:0] for name, column in kneed.samples.items()})
    assert measures.summary(bare)["peak_stance_knee_torque_Nm"] is None


def test_a_walk_that_diverged_is_measured_as_far_as_it_goes(kneed: mjbiped.Walk) -> None:
    """Records may hold any finite number; those that are no angle are left out."""
    samples = {name: column.copy() for name, column in kneed.samples.items()}
    samples["torque"][-1] = math.nan
    samples["q"][-2] = 1e6
    samples["slope"][3] = 1e12
    broken = replace(kneed, samples=samples)
    for found in (loads.knee_torque(broken), centre_of_pressure(broken)):
        assert np.flatnonzero(np.isnan(found)).tolist() == [3, len(found) - 2, len(found) - 1]
    assert loads.peak_knee_torque(broken) > 0.0
