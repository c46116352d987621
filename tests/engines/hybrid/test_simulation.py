"""The hybrid engine: tolerance, breaks of a law, torques that are no numbers, which event comes first, and work."""

import dataclasses
import math
from collections.abc import Sequence
from typing import Any

import numpy as np
import pytest
from simulations import Torques, hybrid_run

import mjbiped
from controllers import AdaptiveController, Controller, Memory, PassiveController
from mjbiped.engines.hybrid.accounting import parabola_top
from mjbiped.engines.hybrid.engine import TOLERANCE
from mjbiped.terrain.terrain import Terrain


def hybrid(controller: Controller, terrain: Terrain, **arguments: Any) -> mjbiped.Walk:
    return mjbiped.walk(controller, terrain, engine="hybrid", **arguments)


def test_tolerance_converges(controller: AdaptiveController) -> None:
    """Closed loop, re-planned after every step: a thousand times the accuracy changes nothing that matters."""
    coarse, fine = (
        mjbiped.walk(controller, Terrain.mixed(), engine=engine, steps=12, sample_period=None)
        for engine in (mjbiped.Hybrid(TOLERANCE), mjbiped.Hybrid(1e-13))
    )
    # issue 3's 1e-9; a walk's errors die out
    for name in ("q", "dq"):
        assert coarse.touchdowns[name] == pytest.approx(fine.touchdowns[name], abs=1e-9)
    assert coarse.touchdowns["work_absolute"] == pytest.approx(fine.touchdowns["work_absolute"], rel=1e-6)
    # a peak inside a step is that of a parabola through values a sixteenth of the step apart
    assert coarse.peak_torque == pytest.approx(fine.peak_torque, rel=2e-5)


def test_law_with_a_jump_needs_its_break() -> None:
    """No step goes across a break that the controller tells of; without it the same comes out, in more evaluations."""

    class Switch(Controller):
        def __init__(self, told: bool) -> None:
            self.told = told

        def torque(self, memory: Memory, t: float, q: Sequence[float], dq: Sequence[float]) -> Sequence[float]:
            return 0.0, (0.5 if t < 0.2 else -0.5)

        def next_discontinuity(self, memory: Memory, t: float) -> float:
            return 0.2 if self.told and t < 0.2 else math.inf

    found = []
    for switch in (Switch(True), Switch(False)):
        run = hybrid_run(switch, Terrain.incline(2.0), robot=mjbiped.Compass(), q=(-0.19, 0.19), dq=(1.1, 0.8), steps=1)
        run.go()
        found.append((run.recorder.touchdowns()["dq"][0], run.state.evaluations))
    (named, few), (unnamed, many) = found
    assert named == pytest.approx(unnamed, abs=10.0 * TOLERANCE)  # some steps near the jump, each within it
    assert few < 0.7 * many


def test_a_torque_that_is_no_number_for_a_moment_leaves_none_in_the_record() -> None:
    """Asked at the ends of integration steps it is one, and in a sample between them it is none."""

    def gap(first: float, last: float) -> Torques:
        return Torques(lambda t, *_: (math.nan if first < t < last else 0.0, 0.0))

    outcomes = set()
    for start in ((-0.19, 0.19, 1.1, 0.8), (-0.19, 0.19, 0.3, 0.0)):  # touches down, and falls
        terms: dict[str, Any] = {"steps": 1, "sample_period": 1e-3, "initial": start}
        end = hybrid(PassiveController(), Terrain.incline(2.0), **terms).end[0]
        gaps = [(first, 2e-3) for first in np.linspace(0.05, 0.6, 5)]
        for first, length in gaps + [(end - length / 2, length) for length in (1e-9, 1e-7, 1e-5, 1e-4)]:
            walk = hybrid(gap(first, first + length), Terrain.incline(2.0), **terms)
            assert np.isfinite([walk.samples["q"], walk.samples["dq"]]).all()
            outcomes.add(walk.outcome)
    assert "diverged" in outcomes


def test_foot_slides_over_the_top_edge_and_walks_on(controller: AdaptiveController) -> None:
    """The hip goes backwards at the start: only then a straight leg that is held at a face moves its foot upwards."""
    face, rise, start = 0.21, 0.009, (0.11, 0.11, -0.36, -2.6)
    terrain = Terrain.from_segments([(face, 0.0), (9.0, 0.0, rise)])
    walk = mjbiped.walk(controller, terrain, engine="hybrid", steps=2, initial=start, sample_period=1e-5)
    x, z = walk.robot.limbs(walk.samples["qpos"][walk.samples["time"] < walk.touchdowns["time"][0]])[:, 1, -1].T
    (held,) = np.nonzero(np.abs(x - face) < 1e-9)
    assert len(held) > 1000
    assert (np.diff(held) == 1).all()  # pressed against the face up to the edge: it is the edge that ends the slide
    assert z[held[0]] < rise - 2e-3
    assert z[held[-1]] == pytest.approx(rise, abs=1e-5)
    # pressed no more, it goes on forwards over the upper tread for a while (then the falling hip draws it back, above
    # the edge), and lands there
    assert (x[held[-1] + 1 : held[-1] + 101] > face).all()
    assert (z[held[-1] + 1 :] >= rise).all()
    assert walk.outcome == "finished"
    assert walk.touchdowns["strikes"].tolist() == [1, 0]
    assert walk.touchdowns["x"][0] > face + 0.1
    assert walk.touchdowns["z"][0] == pytest.approx(rise, abs=1e-12)


@pytest.mark.parametrize(("later", "locked"), [(1e-4, 1.0), (-1e-4, 0.0)])
def test_a_knee_strikes_in_the_step_in_which_the_hip_leaves_the_ground_if_first(later: float, locked: float) -> None:
    """The ground ends just after the place of the hip at the strike, or just before: within one integration step."""
    robot = mjbiped.KneedBiped()
    ground, gait = Terrain.incline(2.5), mjbiped.find_kneed_gait(robot, slope=math.radians(2.5))
    walk = mjbiped.walk(PassiveController(), ground, robot=robot, engine="hybrid", steps=1, sample_period=1e-4)
    assert walk.touchdowns["knee_strike"][0] == pytest.approx(gait.knee_strike, abs=1e-6)
    hip = float(np.interp(gait.knee_strike, walk.samples["time"], walk.samples["qpos"][:, 0]))
    short = dataclasses.replace(ground, end=hip + later)  # at some 1 m/s
    ended = mjbiped.walk(PassiveController(), short, robot=robot, engine="hybrid", steps=1)
    assert ended.outcome == "left the terrain"
    assert ended.end[0] == pytest.approx(gait.knee_strike, abs=2e-3)
    assert ended.samples["locked"][-1] == locked


def test_absolute_work_is_that_of_a_fine_quadrature() -> None:
    # in the first step of either an integration step of some 0.1 s holds a dip of the ankle's power that lasts 0.01 s
    robot = mjbiped.Compass()
    controller = AdaptiveController(robot, mjbiped.find_reference(robot, clearance=0.04), replanning="additive")
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


@pytest.mark.parametrize("rate", [4.0, 9.0, 17.0])
def test_the_greatest_torque_of_a_law_of_time_is_its_own(rate: float) -> None:
    """A parabola through values a sixteenth of an integration step apart is off by 3e-6, one beside it by 2e-5."""

    def torques(t: Any) -> Any:
        return 0.3 * np.cos(rate * t + 0.4) + 0.2 * np.sin(2.7 * rate * t), 0.2 * np.sin(rate * t)

    law = Torques(lambda t, *_: torques(t))
    walk = hybrid(law, Terrain.incline(2.0), robot=mjbiped.Compass(), initial=(-0.19, 0.19, 1.1, 0.8), steps=1)
    greatest = np.abs(torques(np.linspace(0.0, walk.end[0], 100_001))).max(axis=1)
    np.testing.assert_allclose(walk.peak_torque, greatest, rtol=0, atol=5e-6)


@pytest.mark.parametrize(("least", "bend"), [(0.3, 2.0), (-0.8, -1.5), (0.0, 0.7)])
def test_the_least_normal_force_between_samples_is_the_parabolas_through_three(least: float, bend: float) -> None:
    left, middle, right = (5.0 + bend * (place - least) ** 2 for place in (-1.0, 0.0, 1.0))
    assert parabola_top(left, middle, right) == pytest.approx(5.0, abs=1e-12)
    assert parabola_top(middle, right, 2.0 * right - middle) == 0.0  # a straight line has none
