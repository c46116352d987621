"""Symmetry: a walk that begins on the right leg is that on the left one with the legs exchanged."""

from __future__ import annotations

import math
from typing import Any

import golden_walks
import numpy as np
import pytest
from golden_walks import ROBOTS
from simulations import recorded, started

from mjbiped.control.registry import make_controller
from mjbiped.engines.mujoco.constants import stance_leg
from mjbiped.engines.mujoco.simulation import Simulation

EXCHANGED = {4: [0, 1, 3, 2], 6: [0, 1, 3, 2, 5, 4]}
"""Places of a posture with the legs exchanged."""


def begin_on_the_right(simulation: Simulation) -> None:
    """Exchange the legs before the first step."""
    c, u, data = simulation.constants, simulation.state, simulation.data
    order = np.array([int(place) for place in c.order])
    exchanged = order[EXCHANGED[len(order)]]
    for field in (data.qpos, data.qvel):
        field[order] = field[exchanged].copy()
    u.q[: len(order)], u.rates[: len(order)] = data.qpos.tolist(), data.qvel.tolist()
    u.stance = u.count = 1.0
    u.foot_angle = u.q[stance_leg(c, u).hip]
    simulation.look_again()


@pytest.mark.parametrize(
    ("robot", "law", "ground"),
    [("compass", "adaptive", "breaks"), ("kneed", "adaptive", "upstairs"), ("round", "passive", "2 down")],
)
def test_mujoco_has_no_favourite_leg(robot: str, law: str, ground: str) -> None:
    """MuJoCo eliminates the bodies in another order: rounding, which three impacts enlarge by some tens each."""
    controller: Any = make_controller(law, ROBOTS[robot], {})
    walks = []
    for right in (False, True):
        terrain = golden_walks.GROUNDS[ground]
        start = (
            controller.gait.start
            if controller.gait
            else golden_walks.stored(golden_walks.Case(robot, law, ground, "mujoco"))
        )
        given: dict[str, Any] = {}
        if not controller.gait:
            given = {"q": start["samples q"][0], "dq": start["samples dq"][0]}
        simulation = started(
            controller, terrain, robot=ROBOTS[robot], steps=3 + right, compile=False, sample_period=1.0, **given
        )
        if right:
            begin_on_the_right(simulation)
        walks.append(recorded(simulation))
    left, right_first = walks
    assert len(left["time"]) > 0
    for name in ("x", "q", "dq", "work_net", "slope_estimate", "friction", "normal_force"):
        np.testing.assert_allclose(right_first[name], left[name], rtol=1e-8, atol=1e-8, err_msg=name)
    assert not math.isclose(left["qpos"][-1][2], right_first["qpos"][-1][2], abs_tol=1e-3)
