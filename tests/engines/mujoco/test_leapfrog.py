"""Steps of second order: what the controller is told, where the stance foot is held, and how errors shrink."""

import math

import mujoco
import numpy as np
import pytest
from simulations import started

import mjbiped
from controllers import AdaptiveController
from mjbiped.engines.mujoco import ground, scene, setup, step
from mjbiped.records import measures
from mjbiped.reproduction.grounds import found_terrain

Terrain = mjbiped.Terrain


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


def test_the_last_error_is_not_the_timesteps(controller: AdaptiveController) -> None:
    """Against the hybrid engine, at twice the default step."""
    for terrain in (Terrain.level(), Terrain.incline(-3.0), Terrain.stairs(rise=-0.06), Terrain.random(seed=5)):
        walk = mjbiped.walk(controller, terrain, steps=12, engine=mjbiped.Mujoco(timestep=2e-3))
        exact = mjbiped.walk(controller, terrain, steps=12, engine="hybrid")
        # measured: 1.8e-4, where it was 6e-3; 0.003 N m, where it was 0.5; 0.02 ms, where it was 0.8
        assert walk.cost_of_transport == pytest.approx(exact.cost_of_transport, rel=4e-4)
        assert walk.peak_torque == pytest.approx(exact.peak_torque, abs=0.01)
        assert walk.touchdowns["time"][-1] == pytest.approx(exact.touchdowns["time"][-1], abs=12 * 5e-5)


@pytest.mark.parametrize("terrain", [Terrain.incline(-3.0), Terrain.stairs(rise=-0.06)], ids=["up 3", "stairs"])
def test_a_standing_foot_stays(terrain: Terrain, controller: AdaptiveController) -> None:
    """At 2 ms, where it slid by 0.6 and 1.3 mm per step, and lost contact every ten physics steps."""
    simulation = started(controller, terrain, steps=6, timestep=2e-3)
    u, lost = simulation.state, 0
    while simulation.advance(1):
        lost += u.force == 0.0 and not u.noted
    walk = mjbiped.walk(controller, terrain, steps=6, engine=mjbiped.Mujoco(timestep=2e-3))
    assert lost == 0
    assert walk.touchdowns["slip"].max() < 1e-6  # measured 3e-7


def test_rates_are_those_of_the_time(controller: AdaptiveController) -> None:
    """Recorded rates against the angles about them: rates half a step old are off by 2e-2 rad/s."""
    timestep = 2e-3
    walk = mjbiped.walk(
        controller, Terrain.level(), steps=2, sample_period=1e-5, engine=mjbiped.Mujoco(timestep=timestep)
    )
    time, q, dq = (walk.samples[name] for name in ("time", "q", "dq"))
    even = np.isclose(np.diff(time), timestep)
    inner = np.flatnonzero(even[1:] & even[:-1]) + 1
    inner = inner[~np.isin(time[inner - 1], walk.touchdowns["time"])]
    slopes = (q[inner + 1] - q[inner - 1]) / (2.0 * timestep)
    assert len(inner) > 500
    assert np.abs(dq[inner] - slopes).max() < 2e-4


@pytest.mark.parametrize("control_period", [None, 1e-2], ids=["continuous", "slow"])
@pytest.mark.parametrize("lands", [True, False], ids=["landing", "plain"])
def test_work_is_the_energy_that_a_step_gains(
    lands: bool, control_period: float | None, controller: AdaptiveController
) -> None:
    """Of the motors, between two impacts, also where torques are held. MuJoCo's integrator conserves it so far."""
    terrain, robot, start = Terrain.incline(-3.0), controller.robot, controller.gait.start
    engine = mjbiped.Mujoco(timestep=2e-4 if not lands else 1e-3, control_period=control_period, lands=lands)
    walk = mjbiped.walk(controller, terrain, steps=6, engine=engine)
    rows, slope = walk.touchdowns, math.radians(-3.0)
    after = np.vstack([start, np.column_stack([rows["q"], rows["dq"]])])[:-1]
    gained = [
        robot.energy(q, dq, slope) - robot.energy(begin[:2], begin[2:], slope)
        for begin, q, dq in zip(after, rows["q_before"], rows["dq_before"], strict=True)
    ]
    work = np.diff(np.append(0.0, rows["work_net"]))
    assert np.abs(work).min() > 0.5
    # measured: 5e-4 J landing, 3e-3 with torques times the way after them; plain steps' contacts take 8e-3
    assert work == pytest.approx(np.array(gained), abs=1e-3 if lands else 2e-2)


@pytest.mark.parametrize("lands", [True, False], ids=["landing", "plain"])
def test_other_rates_are_shown_to_the_velocity_stage_alone(
    lands: bool, controller: AdaptiveController, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Steps of one length are MuJoCo's own: there they are the state's."""
    simulation = started(controller, Terrain.level(), compile=False, lands=lands)
    simulation.advance(100)
    data, seen = simulation.data, []

    def looking(name: str) -> None:
        stage = getattr(step, name)

        def looked(model: mujoco.MjModel, data: mujoco.MjData) -> None:
            seen.append(data.qvel.copy())
            stage(model, data)

        monkeypatch.setattr(step, name, looked)

    for name in ("position", "velocity", "forward_from_velocity"):
        looking(name)
    rates = data.qvel.copy()
    simulation.advance(1)
    for other in seen[::2]:
        assert other.tolist() == rates.tolist()
    assert (np.abs(seen[1] - rates).max() > 1e-4) == lands
    if not lands:
        assert simulation.state.rates[:4] == rates.tolist() == seen[1].tolist()


@pytest.mark.slow
def test_impacts_at_the_default_step(controller: AdaptiveController) -> None:
    """The contact step's own motion is all that is left: 0.04 % of a rate."""
    for terrain in (Terrain.level(), Terrain.stairs(rise=-0.06), Terrain.random(seed=0), Terrain.random(seed=3)):
        walk = mjbiped.walk(controller, terrain, steps=12)
        assert np.abs(measures.impact_errors(walk)).max() < 5e-4  # 1.1e-3 where a foot was out of contact before


def test_the_first_short_step_at_a_face_ends_a_long_one(controller: AdaptiveController) -> None:
    """Touchdown 5 is 1 mm from a riser: its rates were off by half a long step's accelerations, 2e-3 rad/s."""
    terrain = Terrain.random(seed=1007, roughness=0.002)
    walk, exact = (mjbiped.walk(controller, terrain, steps=5, engine=engine) for engine in ("mujoco", "hybrid"))
    assert walk.touchdowns["dq"] == pytest.approx(exact.touchdowns["dq"], abs=3e-4)  # measured 1e-4


@pytest.mark.slow
def test_a_foot_that_slides_makes_no_peaks_of_torque() -> None:
    """It loses the ground and finds it again: impulses, of which `qvel` holds the whole already.

    Where half of one was added to the rates that the controller is told, the peak was 155 N m at any timestep.
    """
    robot = mjbiped.Compass()
    gait = mjbiped.find_passive_gait(robot, math.radians(2.0))
    controller, terrain = AdaptiveController(robot, gait, replanning_delay=0.4), found_terrain()
    peaks = [
        mjbiped.walk(controller, terrain, steps=20, engine=engine).peak_torque
        for engine in (mjbiped.Mujoco(), mjbiped.Mujoco(timestep=1e-4, lands=False))
    ]
    # measured: 113.7 and 37.4 N m against 111.3 and 36.7, by how the foot slides in the first step after its touchdown
    np.testing.assert_allclose(peaks[0], peaks[1], rtol=0.03)


@pytest.mark.parametrize("terrain", [Terrain.level(), Terrain.incline(3.0)], ids=["level", "down"])
def test_footholds_stay_where_the_hybrid_engine_has_them(terrain: Terrain, controller: AdaptiveController) -> None:
    """A foot stands on its centre; its sphere, which rolled, took it 15 to 24 µm further in each step."""
    walks = [mjbiped.walk(controller, terrain, steps=12, engine=engine) for engine in ("mujoco", "hybrid")]
    drift = np.abs(walks[0].touchdowns["x"] - walks[1].touchdowns["x"])
    assert drift[-1] < 0.05e-3  # measured 0.02 and 0.04 mm, of which the first steps are a part; rolling made 0.2


def test_a_larger_foot_does_not_roll(controller: AdaptiveController, monkeypatch: pytest.MonkeyPatch) -> None:
    """One of 1 mm would roll by 0.38 mm a step; after an impact, which stops its lowest point, it moves by 0.02 mm."""
    exact = mjbiped.walk(controller, Terrain.level(), steps=4, engine="hybrid").touchdowns["x"]
    for module in (ground, scene, setup):
        monkeypatch.setattr(module, "FOOT_RADIUS", 1e-3)
    walk = mjbiped.walk(controller, Terrain.level(), steps=4)
    assert walk.touchdowns["x"] == pytest.approx(exact, abs=0.1e-3)
    assert walk.touchdowns["slip"].max() < 1e-6
