"""Momentum at impacts: it changes by impulses of the new foot and of locked knees alone."""

import numpy as np
import pytest
from engines.conformance.cases import UNDISTURBED, bodies_of, contact_step, parametrised, softness, steps_in, walk_of
from engines.conformance.free_bodies import Array, FreeRobot
from golden_walks import Case

LOCKED = np.array([[1.0, 0.0], [0.0, 1.0], [0.0, 1.0]])
"""Rates of a robot with knees whose swing knee is locked."""


def missed(bodies: FreeRobot, qpos: Array, change: Array, left: Array) -> float:
    """Greatest rate by which a change differs from a plastic impact, rad/s, that leaves these motions to the robot.

    An impulse that holds a point or locks a joint does no work on the motions that it leaves.
    """
    M = bodies.mass_matrix(qpos)
    return float(np.abs(np.linalg.solve(left.T @ M @ left, left.T @ M @ change)).max())


def allowed(case: Case) -> float:
    """Hybrid: rounding, times conditions of some 1e2. MuJoCo: a contact step of accelerations of 5 g/l, rad/s."""
    return 1e-12 if case.engine == "hybrid" else 5e1 * softness(case) * contact_step(case)


@parametrised(UNDISTURBED)
def test_touchdowns_and_knee_strikes(case: Case) -> None:
    """The swing knee locks while the stance leg stands."""
    walk, bodies = walk_of(case), bodies_of(case.robot)
    rows, robot, n, strikes = walk.touchdowns, walk.robot, len(walk.robot.angles), 0
    for step in steps_in(walk, bodies):
        stance, slope = int(rows["stance"][step.row]), float(rows["slope"][step.row])
        opens = robot.knee_opens and rows["dq"][step.row][2] > rows["dq"][step.row][1] + 1e-9
        free = LOCKED if n == 3 and not opens else np.eye(n)
        left = bodies.motions(step.end[0], stance, free, slope)
        assert missed(bodies, step.end[0], step.after[1] - step.end[1], left) < allowed(case), step.row
        if step.knee:
            qpos, before, after = step.knee
            left, strikes = bodies.motions(qpos, step.stance, LOCKED, step.slope), strikes + 1
            assert missed(bodies, qpos, after - before, left) < allowed(case), step.row
            bent = robot.flexion(qpos, 1 - step.stance)
            assert bent == pytest.approx(0.0, abs=1e-9 if case.engine == "hybrid" else 1e-5)
    assert bool(strikes) == ("kneed" in case.robot)
