"""Which touchdowns with knees take the robot over, straight or bent, against the robot's own impact."""

import math
from collections.abc import Sequence

import numpy as np
import pytest
from simulations import UNEQUAL, hybrid_simulation

import mjbiped
from controllers import Controller, Memory
from mjbiped.dynamics.modes import FREE, LOCKED, RESTING, bend_stance_knee
from mjbiped.engines.hybrid.motion import enter_mode
from mjbiped.engines.hybrid.resets import lands, strike_knee, transfer_support
from mjbiped.engines.hybrid.state import Constants, State, swing_foot
from mjbiped.robots.bent_leg import bent_leg
from mjbiped.robots.kneed import KneedBiped
from mjbiped.terrain.terrain import Terrain

H = 1e-6


def bend(c: Constants, w: State, locked: int, bent: float) -> None:
    """Let the robot stand on a leg that is bent so far, rad, with its swing knee locked or free."""
    w.locked, w.stance_flexion = locked, bent
    bend_stance_knee(w, c.upper, c.lower, bent)
    enter_mode(c, w)


def rise_of_the_old_foot(robot: KneedBiped, q: np.ndarray, dq: np.ndarray, bent: float) -> float:
    """Rate at which the foot that stood leaves the new stance foot upwards after the impact, m/s."""
    after = robot.rates_after_touchdown(q, dq, bent)  # of the leg that struck, and of the other one
    _, lean = bent_leg(robot.thigh_length, robot.shank_length, bent)
    segments = np.array([q[0] + lean, q[0] + lean - bent, q[1], q[2]])
    rates = np.array([after[1], after[1], after[0], after[0]])
    ends = [robot.swing_foot(segments + side * H * rates)[1] for side in (-1, 1)]
    return float(ends[0] - ends[1]) / (2 * H)


@pytest.mark.parametrize("robot", [KneedBiped(), UNEQUAL])
def test_a_bent_leg_takes_over_where_the_other_foot_leaves_the_ground(robot: KneedBiped) -> None:
    simulation = hybrid_simulation(Terrain.level(), (-0.1, 0.2, 0.2, 1.0, 0.0, 0.0), robot=robot)
    c, w, draw = simulation.constants, simulation.state, np.random.default_rng(1)
    w.foot_x, seen = 0.4, []
    for _ in range(400):
        # the swing leg is ahead of the other one, or behind it, and comes down at any rates
        bent, flexion = draw.choice([0.0, draw.uniform(0.05, 0.8)]), draw.choice([0.0, draw.uniform(0.05, 0.8)])
        line, thigh = draw.uniform(-0.1, 0.5), draw.uniform(-0.7, 0.2)
        q, dq = np.array([line, thigh, thigh + flexion]), draw.uniform(-3.0, 3.0, 3)
        locked = flexion == 0.0
        dq[2] = dq[1] if locked else dq[2]
        w.y[:6] = [*q, *dq]
        bend(c, w, LOCKED if locked else FREE, bent)
        length, _ = bent_leg(robot.thigh_length, robot.shank_length, bent)
        ahead = length * math.sin(line) - robot.thigh_length * math.sin(thigh) - robot.shank_length * math.sin(q[2]) > 0
        straight = locked and bent == 0.0
        takes = ahead and (straight or rise_of_the_old_foot(robot, q, dq, bent) > 0.0)
        assert lands(c, w) == takes
        seen.append((ahead, ahead and straight, takes))
    # each kind often: behind, ahead with straight legs, with bent ones that take over, and that do not
    kinds = [(False, False, False), (True, True, True), (True, False, True), (True, False, False)]
    assert min(seen.count(kind) for kind in kinds) > 30


@pytest.mark.parametrize("bent", [0.0, 0.3])
@pytest.mark.parametrize("flexion", [0.0, 0.5])
def test_a_transfer_leaves_the_robot_where_it_is_and_strikes_the_new_foot(bent: float, flexion: float) -> None:
    """From one slope onto another, on unequal links; the drawn robot is the same before and after."""
    ground = Terrain((-1.0, 0.2), (0.0, 0.0), (0.02, -0.03))
    simulation = hybrid_simulation(ground, (-0.1, 0.2, 0.2, 1.0, 0.0, 0.0), robot=UNEQUAL)
    c, w = simulation.constants, simulation.state
    q, dq = np.array([0.15, -0.4, -0.4 + flexion]), np.array([1.1, 0.4, 0.4 - 2.0 * (flexion > 0.0)])
    w.y[:6] = [*q, *dq]
    bend(c, w, FREE if flexion else LOCKED, bent)
    old_x, slope = w.foot_x, w.slope
    foot_x, foot_z = swing_foot(c, w, w.y)
    c.z = [0.0, foot_z - c.gradient[1] * (foot_x - c.x[1])]  # the foot is on it
    transfer_support(c, w)
    (new, swing, shank), rates = w.y[:3], w.y[3:6]
    expected = UNEQUAL.rates_after_touchdown(q, dq, bent)
    assert rates == pytest.approx(expected.tolist(), abs=1e-12)
    assert (w.stance, w.stance_flexion, shank - swing) == pytest.approx((1.0, flexion, bent), abs=1e-15)
    length, _ = bent_leg(UNEQUAL.thigh_length, UNEQUAL.shank_length, flexion)
    old_length, _ = bent_leg(UNEQUAL.thigh_length, UNEQUAL.shank_length, bent)
    line = new + w.slope
    hip = [foot_x + length * math.sin(line), foot_z + length * math.cos(line)]
    assert hip[0] == pytest.approx(old_x + old_length * math.sin(q[0] + slope), abs=1e-12)
    thigh, below = swing + w.slope, shank + w.slope
    back = hip[0] - UNEQUAL.thigh_length * math.sin(thigh) - UNEQUAL.shank_length * math.sin(below)
    assert back == pytest.approx(old_x, abs=1e-12)
    assert w.locked == (FREE if bent else RESTING)


def test_a_knee_that_strikes_locks_as_the_robots_map_has_it() -> None:
    simulation = hybrid_simulation(Terrain.incline(2.0), (-0.1, 0.2, 0.2, 1.0, 0.0, 0.0), robot=UNEQUAL)
    c, w = simulation.constants, simulation.state
    q, dq = [0.1, -0.2, -0.2 - 1e-12], [1.0, 0.8, -1.5]
    w.y[:6], w.elapsed = [*q, *dq], 0.4
    bend(c, w, FREE, 0.0)
    strike_knee(c, w)
    _, rates = UNEQUAL.knee_impact(q, dq)
    assert w.y[3:6] == pytest.approx(rates[[0, 1, 1]].tolist(), abs=1e-10)
    assert w.y[2] == w.y[1] == q[1]
    assert (w.locked, w.strike_time) == (LOCKED, 0.4)
    assert w.strike_dq[:3] == dq
    assert w.struck_dq[:3] == w.y[3:6]


class Clocks(Controller):
    """Two states that the engine integrates, one twice as fast as time."""

    states = ("once", "twice")
    memory_size = 2
    joints = KneedBiped.joints

    def torque(self, memory: Memory, t: float, q: Sequence[float], dq: Sequence[float]) -> Sequence[float]:
        del memory, t, q, dq
        return 0.0, 0.0, 0.0, 1.0, 2.0


def test_a_controllers_states_go_on_through_touchdowns() -> None:
    start = (-0.24, 0.24, 0.24, 1.10, 0.33, 0.33)
    walk = mjbiped.walk(Clocks(), Terrain.incline(2.5), robot=KneedBiped(), engine="hybrid", steps=2, initial=start)
    assert walk.outcome == "finished"
    time = walk.samples["time"]
    # the sums of some thousand integration steps, each rounded
    np.testing.assert_allclose(walk.samples["controller_states"], np.outer(time, [1.0, 2.0]), rtol=1e-12, atol=1e-12)
