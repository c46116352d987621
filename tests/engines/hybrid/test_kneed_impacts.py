"""Which touchdowns with knees take the robot over, straight or bent, against the robot's own impact."""

import math
from collections.abc import Sequence

import numpy as np
import pytest
from simulations import UNEQUAL, hybrid_simulation

import mjbiped
from controllers import Controller, Memory
from mjbiped.dynamics.modes import FREE, LOCKED, bend_stance_knee, bent_leg
from mjbiped.engines.hybrid.motion import enter_mode
from mjbiped.engines.hybrid.resets import lands
from mjbiped.engines.hybrid.state import Constants, State
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
