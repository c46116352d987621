"""Steps that land on the touchdown: errors of walks fall with the square of their length, at faces too."""

import numpy as np
import pytest

import mjbiped
from controllers import AdaptiveController

Terrain = mjbiped.Terrain


@pytest.mark.parametrize("terrain", [Terrain.level(), Terrain.stairs(rise=-0.06)], ids=["level", "stairs"])
def test_errors_fall_with_the_square_of_the_step(terrain: Terrain, controller: AdaptiveController) -> None:
    """Of the closed loop.

    What the contact step and the foot's radius leave is the same at any timestep, and is not seen here.
    """
    timesteps = (5e-4, 1e-3, 2e-3)
    walks = [mjbiped.walk(controller, terrain, steps=6, engine=mjbiped.Mujoco(timestep=h)) for h in timesteps]
    costs = np.array([walk.cost_of_transport for walk in walks])
    times = np.array([walk.touchdowns["time"][-1] for walk in walks])
    # of second order: 4. Measured: 3.7 and 4.3 on level ground, 3.4 and 3.9 on stairs; of first order: 2.0 to 2.4
    for found in (costs, times):
        ratio = (found[2] - found[1]) / (found[1] - found[0])
        assert 3.2 < ratio < 5.0
    assert np.abs(costs / costs[0] - 1.0).max() < 1.5e-4  # measured 8e-5, on stairs


def test_the_first_short_step_at_a_face_ends_a_long_one(controller: AdaptiveController) -> None:
    """Touchdown 5 is 1 mm from a riser: its rates were off by half a long step's accelerations, 2e-3 rad/s."""
    terrain = Terrain.random(seed=1007, roughness=0.002)
    walk, exact = (mjbiped.walk(controller, terrain, steps=5, engine=engine) for engine in ("mujoco", "hybrid"))
    assert walk.touchdowns["dq"] == pytest.approx(exact.touchdowns["dq"], abs=3e-4)  # measured 1e-4
