"""The work of the motors of a robot with knees, against MuJoCo's own actuators."""

import math
from dataclasses import replace
from typing import Any

import mujoco
import numpy as np
import pytest
from simulations import UNEQUAL, make_simulation

import mjbiped
from controllers import AdaptiveController
from mjbiped.control.unpowered import Unpowered
from mjbiped.engines.mujoco import motors, servo
from mjbiped.engines.mujoco.observation import see_posture
from mjbiped.engines.mujoco.simulation import Simulation


class Springs(Unpowered):
    """Torques of the angles and rates, no two alike."""

    def torque(self, memory: Any, t: float, q: Any, dq: Any) -> tuple[float, float, float]:
        return 30.0 * q[0] + dq[1], 20.0 * q[1] - 3.0 * dq[0], 4.0 * (q[2] - q[1]) + 0.1 * dq[2]

    def tick(self, memory: Any, t: float, q: Any, dq: Any) -> None:
        """Nothing but the torque is asked for."""


def simulated(**settings: Any) -> Simulation:
    return make_simulation(
        Springs().driving(UNEQUAL),
        mjbiped.Terrain.level(),
        robot=UNEQUAL,
        q=(-0.2, 0.2, 0.2),
        dq=(1.0, 0.3, 0.3),
        steps=2,
        compile=False,
        **settings,
    )


@pytest.mark.parametrize("stance", [0, 1])
@pytest.mark.parametrize("stance_knee", ["locked", "motor"])
@pytest.mark.parametrize("held", [False, True])
def test_work_is_what_mujocos_actuators_do_over_their_ways(stance: int, stance_knee: str, held: bool) -> None:
    """Of the torques' mean at both ends, or of those that a digital controller holds; a servo's is always its mean."""
    simulation = simulated(stance_knee=stance_knee)
    u, data, draw = simulation.state, simulation.data, np.random.default_rng(stance)
    constants = replace(simulation.constants, sampled=held)
    legs = constants.legs
    u.stance = u.count = stance
    begin, change = draw.uniform(-0.3, 0.3, 6), draw.uniform(-0.1, 0.1, 6)
    begin[4:] = abs(begin[4:])
    if stance_knee == "locked":
        begin[legs[stance].knee] = change[legs[stance].knee] = 0.0
    given, lengths, works = [], [], []
    for index, place in enumerate((begin, begin + change)):
        u.old_q[:], u.old_tilt, u.old_share = u.q[:], u.tilt, u.share
        u.q[:], u.rates[:] = place.tolist(), draw.uniform(-2.0, 2.0, 6).tolist()
        u.time, u.turns, u.next_sample = 1e-3 * index, float(index), 1.0
        if stance_knee == "motor":
            servo.lean_on(legs[stance], u)
        see_posture(constants, u)
        motors.control(constants, u, u.time)
        data.qpos[:] = place
        mujoco.mj_fwdPosition(simulation.model, data)
        given.append(data.ctrl.copy())
        lengths.append(data.actuator_length.copy())
        works.append([u.work_net, u.work_positive, u.work_absolute, u.work_hold])
    assert works[0] == [0.0] * 4
    ankle, hip, mine, other = (
        *(legs[stance].ankle, constants.hip),
        *(legs[stance].motor, legs[1 - stance].motor),
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


def test_peaks_are_the_greatest_torques() -> None:
    """Of a walk with a sample at each physics step but those that a touchdown cuts."""
    robot = mjbiped.Compass()
    law = AdaptiveController(robot, mjbiped.find_passive_gait(robot, math.radians(2.0)))
    walk = mjbiped.walk(law, mjbiped.Terrain.level(), robot=robot, steps=3, sample_period=1e-3)
    assert walk.peak_torque == pytest.approx(np.abs(walk.samples["torque"]).max(axis=0), rel=0.02)
