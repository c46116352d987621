"""Steps that land on the touchdown: where they end, how long they are, and what that does to impacts and walks."""

import math

import numpy as np
import pytest
from simulations import started

import mjbiped
from controllers import AdaptiveController
from mjbiped.engines.mujoco import step_size

Terrain = mjbiped.Terrain


@pytest.mark.parametrize(
    ("terrain", "timestep"),
    [(Terrain.stairs(rise=-0.06), 2e-4), (Terrain.random(seed=3), 2e-3)],
    ids=["stairs", "random"],
)
def test_a_step_ends_where_the_foot_meets_the_ground(
    terrain: Terrain, timestep: float, controller: AdaptiveController
) -> None:
    """An Euler step is known before it is made. The contact step that follows is as long as it should be."""
    simulation = started(controller, terrain, steps=4, timestep=timestep)
    data, u, length = simulation.data, simulation.state, simulation.constants.leg_length
    heights, lengths = [], []
    while not u.outcome:
        swing = data.qpos[3 if u.stance == 0 else 2]
        x, z = data.qpos[0] - length * math.sin(swing), data.qpos[1] - length * math.cos(swing)
        plain = u.plain
        simulation.advance(1)
        lengths.append(simulation.model.opt.timestep)
        if u.noted:
            heights.append(z - terrain.height_at(x))
            assert (lengths[-1], u.effective_step, plain) == (1e-5, 1e-5, 1.0)
    assert len(heights) == 4
    # no step is shorter than 1e-9 s, in which the foot falls by 3e-9 m at most
    assert heights == pytest.approx([-step_size.DEPTH] * 4, abs=3e-9)
    assert max(lengths) == timestep
    assert min(lengths) > 0.0


@pytest.mark.parametrize("terrain", [Terrain.level(), Terrain.stairs(rise=-0.06)], ids=["level", "stairs"])
def test_errors_of_the_closed_loop_fall_with_the_square_of_the_step(
    terrain: Terrain, controller: AdaptiveController
) -> None:
    """What the contact step and the foot's radius leave is the same at any timestep, and is not seen here."""
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
