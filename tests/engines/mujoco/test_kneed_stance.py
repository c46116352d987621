"""The stance knee in MuJoCo: what its lock bears, by the robot's equations and by MuJoCo's own constraint forces."""

import math
from typing import Any

import mujoco
import numpy as np

import mjbiped
from controllers import KneedController
from mjbiped.disturbances.pushes import NONE
from mjbiped.engines.mujoco import contact_events as events
from mjbiped.engines.mujoco.kneed import state as at
from mjbiped.engines.mujoco.kneed.simulation import KneedSimulation
from mjbiped.robots.stance_knee import stance_knee_torque
from mjbiped.rules.termination import Outcome

ROBOT = mjbiped.KneedBiped()
LAW = KneedController(ROBOT, mjbiped.find_kneed_gait(ROBOT, math.radians(2.5)))
ONTO_BENT_KNEES = mjbiped.Terrain.from_segments([(0.6, 0.0, 0.0), (20.0, 0.0, 0.03)])


def simulated(ground: mjbiped.Terrain, steps: int, **settings: Any) -> KneedSimulation:
    """A walk to be stepped, on feet that hold."""
    assert LAW.gait is not None
    start = LAW.gait.start
    return KneedSimulation(
        LAW,
        ground,
        robot=ROBOT,
        q=start[:3],
        dq=start[3:],
        steps=steps,
        distance=None,
        sample_period=1.0,
        pushes=NONE,
        friction=5.0,
        options=mjbiped.Mujoco(**settings),
    )


def borne(simulation: KneedSimulation, leg: int) -> float:
    """What MuJoCo's lock and stop of a leg's knee give against its flexion in the step last made, N m."""
    model, data, motors = simulation.model, simulation.data, simulation.constants.motors
    joint = motors.joints[leg]
    jacobian = data.efc_J.reshape(-1, model.nv)[:, model.jnt_dofadr[joint]]
    mine = (data.efc_type == mujoco.mjtConstraint.mjCNSTR_EQUALITY) & (data.efc_id == motors.locks[leg])
    mine |= (data.efc_type == mujoco.mjtConstraint.mjCNSTR_LIMIT_JOINT) & (data.efc_id == joint)
    return -float(jacobian[mine] @ data.efc_force[mine])


def test_the_torque_of_the_lock_is_mujocos_constraint_force() -> None:
    """Of straight and of bent stance knees, at every 37th physics step.

    MuJoCo's ankle acts on the thigh, through the hip's slides; so its lock does not bear the ankle's torque as well.
    """
    simulation, found = simulated(ONTO_BENT_KNEES, 3, timestep=2e-4), []
    u = simulation._u
    while simulation.outcome is Outcome.WALKING:
        simulation.block(37)
        simulation.buffers.u[events.ROWS] = simulation.buffers.u[events.SAMPLES] = 0.0
        if u[events.LAST_STEP] == 0.0 or u[events.PLAIN] != 0.0 or u[events.FORCE] == 0.0:
            continue  # an impact, or a single step without contact
        stance, slope = at.stance_of(u), u[events.SLOPE]
        ankle, bent = u[events.ANKLE], u[at.Q + at.KNEES[stance]]
        torque = stance_knee_torque(
            ROBOT,
            at.angles_of(u, at.Q, stance, slope),
            at.rates_of(u, at.RATES, stance),
            (ankle, u[events.HIP], u[at.KNEE]),
            slope,
            locked=u[at.LOCKED] != 0.0,
            stance_flexion=bent,
        )
        found.append((bent, ankle, float(torque), borne(simulation, stance) + ankle))
    bends, ankles, expected, measured = np.array(found).T
    assert simulation.outcome is Outcome.FINISHED
    assert np.sum(bends > 0.4) > 50
    assert np.ptp(ankles) > 20.0
    assert np.ptp(expected) > 20.0
    # the lock gives by 1e-6 rad, which it takes back at its own time, and steps are of a second order
    np.testing.assert_allclose(measured, expected, rtol=0, atol=0.05)  # measured 0.03
