"""Numbers that must come out: of the paper, of the design and of earlier programs, in both engines."""

import math

import numpy as np
import pytest

import mjbiped
from controllers import AdaptiveController, KneedController, PassiveController
from mjbiped import Terrain
from mjbiped.records import measures

BOTH = pytest.mark.parametrize("engine", ["hybrid", "mujoco"])


def test_passive_gait_on_2_degrees() -> None:
    """To the digits given, of two independent programs: half a unit of the last one, and the integrator's 1e-9."""
    walk = mjbiped.walk(PassiveController(), Terrain.incline(2.0), engine="hybrid", steps=60)
    rows, half = walk.touchdowns, 0.6e-8
    assert rows["q"][-1] == pytest.approx([-0.19008478, 0.19008478], abs=half)
    assert rows["dq"][-1] == pytest.approx([1.10317583, 0.81185710], abs=half)
    assert rows["dq_before"][-1] == pytest.approx([1.44951875, 1.51242286], abs=half)
    assert measures.step_periods(walk)[-1] == pytest.approx(0.76484357, abs=half)
    assert measures.step_lengths(walk)[-1] == pytest.approx(0.377884, abs=0.6e-6)
    assert walk.robot.kinetic_energy(rows["q_before"][-1], rows["dq_before"][-1]) == pytest.approx(3.820468, abs=0.6e-6)
    assert (walk.cost_of_transport, bool(walk.peak_torque.any())) == (0.0, False)


@BOTH
def test_passive_gait_with_knees_on_2_5_degrees(engine: str) -> None:
    """Half angle, rates, period and knee strike, of an earlier program.

    Hybrid: half a unit of the last digit. MuJoCo's contacts err by some 0.05 % of a rate in each impact.
    """
    ground, robot = Terrain.incline(2.5), mjbiped.KneedBiped()
    walk = mjbiped.walk(PassiveController(), ground, robot=robot, engine=engine, steps=15)
    rows, gait = walk.touchdowns, mjbiped.find_kneed_gait(robot, math.radians(2.5))
    period, strike = measures.step_periods(walk)[-1], rows["knee_strike"][-1]
    found = [rows["q"][-1, 1], *rows["dq"][-1, :2], period, strike, rows["flexion"][-1]]
    wanted = [0.24448, 1.08907, 0.35378, 0.61465, 0.52706, gait.greatest_flexion]
    assert (walk.outcome, walk.cost_of_transport) == ("finished", 0.0)
    assert found == pytest.approx(wanted, abs=0.6e-5 if engine == "hybrid" else 5e-4)
    assert rows["knee_dq_before"][-1] == pytest.approx(gait.knee_rates, abs=1e-7 if engine == "hybrid" else 3e-3)


# terrain, c_mt, peak torque of the ankle (N m): of the design, to three digits
CLOSED_LOOP: dict[str, tuple[Terrain, float, float]] = {
    "level": (Terrain.level(), 0.0349, 1.75),
    "down 3": (Terrain.incline(3.0), 0.0176, 1.7),
    "up 3": (Terrain.incline(-3.0), 0.0875, 5.1),
    "stairs -0.006": (Terrain.stairs(rise=-0.006), 0.0341, 3.0),
    "stairs -0.06": (Terrain.stairs(rise=-0.06), 0.0818, 33.0),
}


@pytest.mark.parametrize(
    ("name", "engine"),
    [
        pytest.param(name, engine, marks=() if engine == "hybrid" or name == "up 3" else pytest.mark.slow)
        for name in CLOSED_LOOP
        for engine in ("hybrid", "mujoco")
    ],
)
def test_closed_loop(name: str, engine: str, controller: AdaptiveController) -> None:
    terrain, cost, torque = CLOSED_LOOP[name]
    walk = mjbiped.walk(controller, terrain, engine=engine, steps=45)  # over ten treads
    assert (walk.outcome, walk.steps, bool(walk.touchdowns["strikes"].any())) == ("finished", 45, False)
    started, _ = measures.estimate_errors(walk)
    assert abs(started[-1]) < math.radians(0.1)
    # both engines agree within 0.3 % of c_mt
    assert walk.cost_of_transport == pytest.approx(cost, rel=5e-3)
    assert walk.peak_torque[0] == pytest.approx(torque, rel=0.03)


def test_level_ground_costs_the_sine_of_the_slope(controller: AdaptiveController) -> None:
    """Exact tracking of a gait of 2 degrees: in steady state, the estimator's first errors being forgotten."""
    walk = mjbiped.walk(controller, Terrain.level(), engine="hybrid", steps=60)
    work, distance = (np.diff(walk.touchdowns[name][[20, 59]])[0] for name in ("work_net", "x"))
    assert work / (walk.robot.weight * distance) == pytest.approx(math.sin(math.radians(2)), rel=1e-7)
    steady = walk.samples["torque"][walk.samples["time"] > walk.touchdowns["time"][20]]
    assert 1.665 < steady[:, 0].min() < steady[:, 0].max() < 1.755
    assert 0.815 < -steady[:, 1].max() < -steady[:, 1].min() < 0.865


@pytest.mark.slow
@pytest.mark.parametrize(
    ("robot", "cost"),
    [(mjbiped.KneedBiped(), 0.0410), (mjbiped.KneedBiped.halved_rods(), 0.1143)],
    ids=["light", "halved"],
)
def test_closed_loop_with_knees(robot: mjbiped.KneedBiped, cost: float) -> None:
    """On a reference of 8 cm: on level ground at the reference's own cost, and up stairs of 6 and 8 cm."""
    law = KneedController(robot, mjbiped.find_reference(robot, clearance=0.08))
    level = mjbiped.walk(law, Terrain.level(), engine="mujoco", steps=20)
    assert level.cost_of_transport == pytest.approx(cost, abs=3e-4)  # of one engine against the other
    mine, its = (mjbiped.walk(law, Terrain.stairs(rise=0.06), engine=each, steps=20) for each in ("mujoco", "hybrid"))
    assert mine.outcome == its.outcome == "finished"
    assert mine.cost_of_transport == pytest.approx(its.cost_of_transport, abs=3e-4)
    np.testing.assert_allclose(mine.peak_torque, its.peak_torque, rtol=0.02, atol=0.05)


@BOTH
@pytest.mark.parametrize("slope_deg", [-3.0, 3.0])
def test_it_starts_by_itself_from_rest(slope_deg: float, engine: str, controller: AdaptiveController) -> None:
    """The paper's X = [0, 0, 0, 0]: both legs together, at rest, the slope's estimate at zero."""
    walk = mjbiped.walk(controller, Terrain.incline(slope_deg), engine=engine, steps=6, initial="rest")
    assert (walk.outcome, walk.steps) == ("finished", 6)
    started, _ = measures.estimate_errors(walk)
    assert abs(started[-1]) < math.radians(0.1)


def test_estimates_of_a_slower_controller_are_those_of_their_own_touchdown(controller: AdaptiveController) -> None:
    """It takes notice of a touchdown some physics steps later; the rows once held the touchdown's before."""
    slow = mjbiped.Mujoco(control_period=5e-3)
    walk = mjbiped.walk(controller, Terrain.slopes(change_deg=1.5), steps=5, engine=slow, sample_period=1e-4)
    touchdowns, samples = walk.touchdowns, walk.samples
    for row, time in enumerate(touchdowns["time"]):
        last = np.flatnonzero(samples["time"] < time)[-1]
        # its estimate goes on at the rate held, for up to 5 ms; the touchdown's before would be off by a degree
        assert touchdowns["slope_estimate_before"][row] == pytest.approx(samples["slope_estimate"][last], abs=1e-6)
    change = touchdowns["q_before"][:, 0] - touchdowns["q"][:, 1]
    update = touchdowns["slope_estimate"] - touchdowns["slope_estimate_before"]
    assert np.abs(change).max() > np.radians(1)
    assert update == pytest.approx(change, abs=controller.update_threshold)  # (27) leaves out less
