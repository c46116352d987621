"""The MuJoCo engine as a machine: its steps, forward calls between them, resuming."""

import math
from typing import Any

import pytest
from simulations import assert_resumes, started, state_of

import mjbiped
from controllers import AdaptiveController, Controller, KneedController
from mjbiped.engines.mujoco.simulation import Simulation

Terrain = mjbiped.Terrain


def test_steps_can_be_made_until_a_time(controller: AdaptiveController) -> None:
    simulation = started(controller, Terrain.level())
    assert simulation.advance(10**6, 0.1) == 100
    assert simulation.data.time == pytest.approx(0.1, abs=1e-9)
    assert simulation.advance(10**6, 0.1) == 0


KNEED = mjbiped.KneedBiped()
ONTO_BENT_KNEES = Terrain.from_segments([(0.6, 0.0, 0.0), (20.0, 0.0, 0.03)])
RESUMED: dict[str, tuple[float, dict[str, Any]]] = {
    "landing": (2.0, {}),
    "plain": (2.0, {"lands": False}),
    "knees": (3.0, {"disturbances": mjbiped.Disturbances(friction=5.0)}),
    "servo": (3.0, {"disturbances": mjbiped.Disturbances(friction=5.0), "stance_knee": "motor"}),
}


@pytest.mark.compiled
@pytest.mark.parametrize("name", RESUMED)
def test_resumes_bitwise_from_any_moment(name: str, controller: AdaptiveController) -> None:
    """Saved in mid-swing, about each strike of a knee and of a foot, straight and bent, and in the step after."""
    steps, settings = RESUMED[name]
    law: Controller = controller
    if name in ("knees", "servo"):
        law = KneedController(KNEED, mjbiped.find_kneed_gait(KNEED, math.radians(2.5)))

    def build() -> Simulation:
        return started(law, Terrain.mixed() if law is controller else ONTO_BENT_KNEES, compile=True, **settings)

    whole, saved, length, before = build(), {}, 0, ()
    while whole.state.count < steps or whole.state.time < whole.state.transfer_time + 0.1:
        u = whole.state
        now: Any = (u.noted, u.struck, u.strikes, u.count, u.locked)
        if now != before or length in (1, 300):
            saved[length] = state_of(whole)
        before, length = now, length + whole.advance(1)
    assert not whole.over
    assert len(saved) >= 6
    assert_resumes(saved, length, whole, build)


def test_lifted_leg_has_no_ankle_torque_between_ticks(controller: AdaptiveController) -> None:
    """A slow controller has not ticked yet when support is transferred: the motor of the leg in the air must be off."""
    simulation = started(controller, Terrain.mixed(), timestep=5e-4, control_period=1e-2)
    seen = 0
    while simulation.state.count < 3:
        simulation.advance(1)
        stance = int(simulation.state.stance)
        assert simulation.data.ctrl[1 - stance] == 0.0
        seen += int(simulation.state.transferred)
    assert seen > 10
