"""Energy: a step gains what the motors put in, and impacts take some."""

import math

import numpy as np
import pytest
from engines.conformance.cases import UNDISTURBED, bodies_of, contact_step, parametrised, softness, steps_in, walk_of
from golden_walks import Case


def allowed(case: Case) -> float:
    """Energy that may be missed, J.

    Hybrid: the tolerance of an integration step, 1e-8, times dE/dy, of some 10 J. MuJoCo leaves its contact step out,
    in which the weight does W sqrt(g l) h of work at most.
    """
    robot = bodies_of(case.robot).robot
    power = robot.weight * math.sqrt(robot.gravity * robot.leg_length)
    return 1e-7 if case.engine == "hybrid" else softness(case) * power * contact_step(case)


@parametrised(UNDISTURBED)
def test_a_step_gains_what_the_motors_put_in(case: Case) -> None:
    walk, bodies = walk_of(case), bodies_of(case.robot)
    works = [0.0, *walk.touchdowns["work_net"]]
    checked, none = 0, np.zeros(walk.steps)
    touched = walk.touchdowns
    for step in steps_in(walk, bodies):
        arrives, leaves = bodies.energy(*step.end), bodies.energy(*step.after)
        assert leaves < arrives, step.row
        gained, lost = arrives - bodies.energy(*step.begin), 0.0
        if step.knee:
            struck, before, after = step.knee
            lost = bodies.energy(struck, before) - bodies.energy(struck, after)
            assert lost > 0.0, step.row
        work = works[step.row + 1] - works[step.row]
        if touched.get("tipped", none)[step.row] > 1e-3:
            continue  # the rates of a foot that has tipped are not in the record
        slapped = touched.get("slap", none)[step.row] > 1e-3
        if touched["strikes"][step.row] or touched.get("stubs", none)[step.row] or slapped:
            assert gained + lost < work - 1e-3, step.row  # a face takes some, as the ground and the servo of a foot do
            continue
        assert gained + lost == pytest.approx(work, abs=allowed(case)), step.row
        checked += 1
    assert checked >= 1
