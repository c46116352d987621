"""Slippery ground."""

from __future__ import annotations

import math

import numpy as np
import pytest
from simulations import make_simulation

import mjbiped
from controllers import PassiveController
from mjbiped import Disturbances
from mjbiped.errors import InputError

GROUND = mjbiped.Terrain.incline(2.0)


def test_a_foot_slips_where_the_friction_is_less_than_the_walk_asks_for() -> None:
    """Passive walking asks for |F_t / F_n| of 0.2 (docs/gaits.md); on ice of 0.1 no foot exerts more."""
    free = mjbiped.walk(PassiveController(), GROUND, steps=3)
    asked = free.touchdowns["friction"].max()
    assert 0.15 < asked < 0.25
    held = mjbiped.walk(PassiveController(), GROUND, steps=3, disturbances=Disturbances(friction=1.2 * asked))
    # the solver's cone is another, and what it has computed with it is the same to its tolerance
    np.testing.assert_allclose(held.touchdowns["q"], free.touchdowns["q"], atol=1e-10)
    ice = mjbiped.walk(PassiveController(), GROUND, steps=3, disturbances=Disturbances(friction=0.1))
    assert ice.outcome in ("slipped", "fell")
    assert ice.settings["disturbances"] == {"friction": 0.1}


def test_it_goes_along_with_a_window_of_the_ground() -> None:
    """A long terrain is built piece by piece."""
    ground = mjbiped.Terrain.random(seed=1, length=200.0)
    robot = mjbiped.Compass()
    simulation = make_simulation(
        PassiveController(),
        ground,
        robot=robot,
        q=(-0.19, 0.19),
        dq=(1.1, 0.8),
        steps=3,
        disturbances=Disturbances(friction=0.3),
    )
    feet = [leg.foot for leg in simulation.constants.legs]
    assert simulation.model.geom_friction[feet, 0].tolist() == [0.3, 0.3]
    simulation.data.qpos[0] = simulation.inside[1] + 0.1 if math.isfinite(simulation.inside[1]) else 0.0
    if simulation.move_on():
        assert simulation.model.geom_friction[[leg.foot for leg in simulation.constants.legs], 0].tolist() == [
            0.3,
            0.3,
        ]


def test_the_hybrid_engine_has_no_friction() -> None:
    with pytest.raises(InputError, match=r"friction = 0.1: the hybrid engine's stance foot never slips"):
        mjbiped.walk(PassiveController(), GROUND, engine="hybrid", disturbances=Disturbances(friction=0.1))
