"""The work of the motors of a robot with knees, against MuJoCo's own actuators."""

from typing import Any

import mujoco
import numpy as np
import pytest
from simulations import UNEQUAL

import mjbiped
from mjbiped.control.adapters import LAWS
from mjbiped.control.unpowered import Unpowered
from mjbiped.disturbances.pushes import NONE
from mjbiped.engines.mujoco import contact_events as events
from mjbiped.engines.mujoco.kneed import motors, servo, stages
from mjbiped.engines.mujoco.kneed import state as at
from mjbiped.engines.mujoco.kneed.simulation import KneedSimulation
from mjbiped.engines.mujoco.kneed.state import Parts

PARTS = Parts(*LAWS, *stages.STAGES)


class Springs(Unpowered):
    """Torques of the angles and rates, no two alike."""

    def torque(self, memory: Any, t: float, q: Any, dq: Any) -> tuple[float, float, float]:
        return 30.0 * q[0] + dq[1], 20.0 * q[1] - 3.0 * dq[0], 4.0 * (q[2] - q[1]) + 0.1 * dq[2]

    def tick(self, memory: Any, t: float, q: Any, dq: Any) -> None:
        """Nothing but the torque is asked for."""


def simulated(**settings: Any) -> KneedSimulation:
    return KneedSimulation(
        Springs().driving(UNEQUAL),
        mjbiped.Terrain.level(),
        robot=UNEQUAL,
        q=(-0.2, 0.2, 0.2),
        dq=(1.0, 0.3, 0.3),
        steps=2,
        distance=None,
        sample_period=1.0,
        pushes=NONE,
        friction=None,
        options=mjbiped.Mujoco(**settings),
        compile=False,
    )


@pytest.mark.parametrize("stance", [0, 1])
@pytest.mark.parametrize("stance_knee", ["locked", "motor"])
@pytest.mark.parametrize("held", [False, True])
def test_work_is_what_mujocos_actuators_do_over_their_ways(stance: int, stance_knee: str, held: bool) -> None:
    """Of the torques' mean at both ends, or of those that a digital controller holds; a servo's is always its mean."""
    simulation = simulated(stance_knee=stance_knee)
    simulation.constants = constants = simulation.constants._replace(sampled=held)
    u, buffers, draw = simulation._u, simulation.buffers, np.random.default_rng(stance)
    u[events.STANCE] = stance
    begin, change = draw.uniform(-0.3, 0.3, 6), draw.uniform(-0.1, 0.1, 6)
    begin[4:] = abs(begin[4:])
    if stance_knee == "locked":
        begin[at.KNEES[stance]] = change[at.KNEES[stance]] = 0.0
    given, lengths, works = [], [], []
    for index, place in enumerate((begin, begin + change)):
        u[at.OLD_Q : at.OLD_Q + 6] = u[at.Q : at.Q + 6]
        u[at.OLD_TILT], u[at.OLD_SHARE] = u[at.TILT], u[at.SHARE]
        u[at.Q : at.Q + 6], u[at.RATES : at.RATES + 6] = place.tolist(), draw.uniform(-2.0, 2.0, 6).tolist()
        u[events.TIME], u[at.TURNS] = 1e-3 * index, float(index)
        if stance_knee == "motor":
            servo.lean_on(constants, u, stance)
        motors.tick(PARTS, simulation.controller, constants, buffers)
        simulation.data.qpos[:] = place
        mujoco.mj_fwdPosition(simulation.model, simulation.data)
        given.append([*buffers.scene.ctrl])
        lengths.append(simulation.data.actuator_length.copy())
        works.append([u[events.WORK_NET], u[events.WORK_POSITIVE], u[events.WORK_ABSOLUTE], u[at.WORK_HOLD]])
    assert works[0] == [0.0] * 4
    ankle, hip, mine, other = (
        *(constants.motors.ankles[stance], constants.motors.hip),
        *(constants.motors.knees[stance], constants.motors.knees[1 - stance]),
    )
    ways, torques, own = np.subtract(lengths[1], lengths[0]), np.array(given), 0.0
    if stance_knee == "motor":  # the ankle's torque goes through the knee as well; what the servo adds is told apart
        own = float((torques[:, mine] - torques[:, ankle]).mean() * ways[mine])
        torques[:, mine] = torques[:, ankle]
    acted = torques[0] if held else torques.mean(axis=0)
    parts = [acted[ankle] * (ways[ankle] + ways[mine]), acted[hip] * ways[hip], acted[other] * ways[other], own]
    net, positive, absolute, hold = works[1]
    assert net == pytest.approx(sum(parts), rel=1e-12)
    assert positive == pytest.approx(np.maximum(parts, 0.0).sum(), rel=1e-12)
    assert absolute == pytest.approx(np.abs(parts).sum(), rel=1e-12)
    assert hold == pytest.approx(abs(own), rel=1e-12)
    assert (abs(own) > 1e-3) == (stance_knee == "motor")
