"""Swing feet with knees: which touchdowns take the robot over; others slide, and strike faces."""

import math

import golden_numbers
import numpy as np
import pytest
from engines.conformance.free_bodies import FreeRobot
from numpy.typing import NDArray
from simulations import UNEQUAL, Plain, hybrid_run, hybrid_simulation

import mjbiped
from mjbiped import KneedBiped, RoundKneed, Terrain
from mjbiped.dynamics.modes import FREE, LOCKED, RESTING, bend_stance_knee
from mjbiped.engines.hybrid.gait_step import advance
from mjbiped.engines.hybrid.impacts import stop_swing_foot
from mjbiped.engines.hybrid.motion import enter_mode
from mjbiped.engines.hybrid.resets import lands, note_face
from mjbiped.robots.robot import Robot
from mjbiped.rules.termination import Outcome

ROBOT = KneedBiped()


def swung(ground: Terrain, start: tuple[float, ...]) -> tuple[mjbiped.Walk, NDArray[np.float64], NDArray[np.float64]]:
    """A passive step, the swing foot's way, shape (samples, 2), and its height over the ground, m."""
    walk = mjbiped.walk(Plain(), ground, robot=ROBOT, engine="hybrid", initial=start, sample_period=1e-3, steps=1)
    feet = ROBOT.limbs(walk.samples["qpos"])[:-1, 1, -1]
    return walk, feet, feet[:, 1] - [ground.height_at(x) for x in feet[:, 0]]


def test_a_foot_that_cannot_leave_the_ground_slides_until_it_is_lifted() -> None:
    """A stub behind the stance foot is no end: one impact, then contact without friction or work, then a step."""
    places, heights = (-5.0, -0.39, 5.0), (0.0, 0.0, 0.0)
    rising, falling = (Terrain(places, heights, (0.0, math.radians(angle), 0.0)) for angle in (-1.0, 1.0))
    for ground, stubs, slid in ((Terrain.level(), 1, 20), (rising, 2, 20), (falling, 1, 1)):  # slides on, or off
        walk, _, height = swung(ground, (-0.2, 0.201, 0.201, 1.0, -1.5, -1.5))
        assert walk.outcome == "finished"
        slides = np.flatnonzero(height < 1e-9)
        assert len(slides) >= slid
        assert (np.diff(slides) == 1).all()
        assert np.abs(height[slides]).max() < 1e-10  # 8th order in steps of 2 ms, which hold accelerations
        assert walk.touchdowns["stubs"][0] == stubs
        slope = ground.slope_at(0.0)
        energy = [ROBOT.energy(q, dq, slope) for q, dq in zip(walk.samples["q"], walk.samples["dq"], strict=True)]
        assert energy[slides[0]] < energy[0] - 1e-4
        if stubs == 1 and slid > 1:
            assert np.ptp(energy[slides[0] : slides[-1]]) < 1e-8


@pytest.mark.parametrize("beyond", [0.0, 1e-10])
def test_a_foot_released_at_the_base_of_a_riser_does_not_pass_through_it(beyond: float) -> None:
    """However rounding lays it about the face: it strikes the face, and rises along it before it goes on."""
    face, rise, leg = -0.3, 0.03, -0.3
    ground = Terrain((-5.0, face), (-rise, 0.0), (0.0, 0.0))
    hip = np.array([math.sin(leg), math.cos(leg)])

    way = hip - [face + beyond, -rise]
    lean, half = math.atan2(*way), math.acos(np.hypot(*way) / ROBOT.leg_length)  # of two links of equal length
    thigh, shank = lean - half, lean + half
    simulation = hybrid_simulation(ground, (leg, thigh, shank, 1.5, -2.0, -1.0), sample_period=1e-3, steps=1)
    note_face(simulation.constants, simulation.state, 0, face + beyond)  # as the transfer to the other foot does
    simulation.go()
    recorder = simulation.recorder
    feet = ROBOT.limbs(recorder.samples()["qpos"])[:-1, 1, -1]
    clear = np.flatnonzero(feet[:, 1] > 1e-8)  # over the tread
    assert feet[: clear[0], 0].max() < face + 1e-8
    assert len(clear) > 10
    assert simulation.state.face_impacts or recorder.touchdowns()["strikes"][0]


def test_a_sliding_foot_ahead_whose_knee_strikes_takes_the_robot_over() -> None:
    q = np.array([0.0, -0.3, -0.2995])
    q[0] = math.acos(0.5 * (math.cos(q[1]) + math.cos(q[2])))  # both feet are on the ground
    row = -ROBOT.chains[3].reach * np.sin(q)  # upward
    thigh = -(row[0] * -0.5 + row[2] * -1.0) / (row[1] + row[2])
    simulation = hybrid_simulation(Terrain.level(), (*q, -0.5, thigh, thigh - 1.0), steps=1)
    w = simulation.state
    w.sliding, w.slid_segment, w.pushed_z = True, 0, 1.0
    simulation.go()
    assert simulation.outcome is Outcome.FINISHED
    touched = simulation.recorder.touchdowns()
    assert 0.0 < touched["knee_strike"][0] == touched["time"][0] < 1e-3


@pytest.mark.parametrize("robot", [KneedBiped(), UNEQUAL])
def test_a_bent_leg_takes_over_where_the_other_foot_leaves_the_ground(robot: KneedBiped) -> None:
    simulation = hybrid_simulation(Terrain.level(), (-0.1, 0.2, 0.2, 1.0, 0.0, 0.0), robot=robot)
    c, w, draw = simulation.constants, simulation.state, np.random.default_rng(1)
    bodies, seen = FreeRobot(robot), []
    for _ in range(400):
        # the swing leg is ahead of the other one, or behind it, and comes down at any rates
        bent, flexion = draw.choice([0.0, draw.uniform(0.05, 0.8)]), draw.choice([0.0, draw.uniform(0.05, 0.8)])
        q, dq = draw.uniform([-0.1, -0.7, 0.0], [0.5, 0.2, 0.0]), draw.uniform(-3.0, 3.0, 3)
        q[2] = q[1] + flexion
        locked = flexion == 0.0
        dq[2] = dq[1] if locked else dq[2]
        w.y[:6] = [*q, *dq]
        w.locked, w.stance_flexion = LOCKED if locked else FREE, bent
        bend_stance_knee(w, c.upper, c.lower, bent)
        enter_mode(c, w)
        qpos = np.array(robot.posture((0.0, 0.0), 0, q, bent))
        ahead, straight = bodies.ends[1].place(qpos).real > 0.0, locked and bent == 0.0
        after = bodies.rates(qpos, 1, robot.rates_after_touchdown(q, dq, bent), 0.0)
        takes = ahead and (straight or (bodies.ends[0].jacobian(qpos) @ after).imag > 0.0)
        assert lands(c, w) == takes
        seen.append((ahead, ahead and straight, takes))
    # each kind often: behind, ahead with straight legs, with bent ones that take over, and that do not
    kinds = [(False, False, False), (True, True, True), (True, False, True), (True, False, False)]
    assert min(seen.count(kind) for kind in kinds) > 30


def test_an_impact_opens_a_knee_that_rests_on_its_stop_or_presses_it_on() -> None:
    simulation = hybrid_simulation(Terrain.level(), (-0.1, 0.2, 0.2, 1.0, 0.0, 0.0))
    c, w, draw, found = simulation.constants, simulation.state, np.random.default_rng(1), []
    for _ in range(20):
        leg, rates, push = draw.uniform(-0.5, 0.5, 2), draw.normal(0.0, 1.0, 2), draw.uniform(-1.5, 1.5)
        w.y[:6] = [*leg[[0, 1, 1]], *rates[[0, 1, 1]]]
        w.locked, w.pushed_x, w.pushed_z = RESTING, math.sin(push), math.cos(push)
        enter_mode(c, w)
        stop_swing_foot(c, w)
        found.append([w.locked, *w.y[:6]])
        assert w.locked == RESTING or w.y[5] > w.y[4]
    assert {each[0] for each in found} == {FREE, RESTING}
    golden_numbers.check("impacts on a knee that rests", {"all": found})


EDGE = -0.45
BACKWARDS = (-0.2, 0.201, 0.201, -2.0, 1.0, 1.0)
"""The swing foot, 0.4 m behind the other one and barely above level ground, comes down and goes backwards."""


@pytest.mark.parametrize(("rise", "degrees"), [(0.02, 0.0), (0.0, -1.0), (0.0, 1.0)], ids=["down", "falling", "rising"])
def test_a_foot_that_slides_backwards_over_an_edge_is_on_what_lies_behind_it(rise: float, degrees: float) -> None:
    slope = math.radians(degrees)
    ground = Terrain((-5.0, EDGE), (math.tan(slope) * (5.0 + EDGE) - rise, 0.0), (slope, 0.0))
    _, feet, above = swung(ground, BACKWARDS)
    assert above.min() > -1e-7  # ground that a foot slides on is met again at 1e-8 m below it
    before = np.flatnonzero((feet[:, 0] > EDGE) & (above < 1e-9))
    beyond = np.flatnonzero(feet[:, 0] < EDGE)
    assert len(before) > 5
    assert beyond[0] == before[-1] + 1  # it slid up to the edge
    assert above[beyond[0]] == pytest.approx(rise, abs=1e-3)


@pytest.mark.parametrize("robot", [KneedBiped(gravity=400.0), KneedBiped(gravity=400.0, sole=(0.05, 0.15))])
def test_knees_stand_where_nothing_moves_them(robot: Robot) -> None:
    """The ground stopped a foot that no motion of the legs could move along the ground's normal: 0 / 0."""
    walk = mjbiped.walk(Plain(), Terrain.random(seed=1), robot=robot, engine="hybrid", initial="rest", steps=3)
    assert (walk.outcome, walk.steps) == ("stalled", 0)
    assert not walk.samples["q"].any()
    assert not walk.samples["dq"].any()


def test_a_foot_beside_the_other_one_has_not_struck_the_ground_ahead() -> None:
    """On round feet it was ahead by rounding, and the robot was said to have fallen at once."""
    run = hybrid_run(Plain(), Terrain.incline(-3.0), robot=RoundKneed(), q=(0.0,) * 3, dq=(0.0,) * 3)
    run.state.pause = 500
    advance(run.constants, run.state)
    assert run.ended is Outcome.WALKING
    assert -0.1 < run.state.y[0] < -1e-4  # it begins to fall backwards
