"""What the ground under the stance foot bears: `normal_force`, against the motion of the centre of mass."""

import dataclasses
import json
import math
from pathlib import Path

import numpy as np
import pytest
from simulations import make_simulation

import mjbiped
from controllers import AdaptiveController, PassiveController
from mjbiped.engines.mujoco import bearing
from mjbiped.engines.mujoco.run import simulate
from mjbiped.engines.mujoco.state import State
from mjbiped.records import measures
from mjbiped.records.recorder import Recorder


def borne(walk: mjbiped.Walk, step: int) -> np.ndarray:
    """Force on the feet at the samples inside a step (from 0), along and normal to the stance foot's ground, N.

    From the second difference of the centre of mass.
    """
    robot, samples = mjbiped.Compass(**walk.settings["robot"]), walk.samples
    times = np.append(0.0, walk.touchdowns["time"])
    period = walk.settings["sample_period"]
    at = np.flatnonzero((samples["time"] > times[step]) & (samples["time"] < times[step + 1]))[1:-1]
    x, z, left, right = samples["qpos"][at].T
    lever = robot.leg_mass * robot.upper_length / robot.total_mass
    centre = np.stack([x - lever * (np.sin(left) + np.sin(right)), z - lever * (np.cos(left) + np.cos(right))])
    acceleration = (centre[:, 2:] - 2.0 * centre[:, 1:-1] + centre[:, :-2]) / period**2
    force = robot.total_mass * (acceleration + np.array([[0.0], [robot.gravity]]))
    slope = samples["slope"][at[0]]
    sine, cosine = math.sin(slope), math.cos(slope)
    return np.asarray(np.array([[cosine, -sine], [sine, cosine]]) @ force)


@pytest.fixture(scope="module")
def hurried(controller: AdaptiveController) -> AdaptiveController:
    """Re-plans so quickly that the ground would have to pull."""
    return dataclasses.replace(controller, replanning_delay=0.1)


@pytest.fixture(scope="module")
def pulled(hurried: AdaptiveController) -> mjbiped.Walk:
    """Stairs of -60 mm, no faces met: steps 4 and 9 are re-planned in haste."""
    return mjbiped.walk(hurried, mjbiped.Terrain.stairs(), engine="hybrid", steps=9, sample_period=1e-4)


def test_hybrid_force_is_that_of_the_centre_of_mass(pulled: mjbiped.Walk) -> None:
    weight = pulled.robot.weight
    for step, recorded in enumerate(pulled.touchdowns["normal_force"]):
        _, inside = borne(pulled, step)
        # 0.7 weights and more are read at the integrator's nodes alone, some 20 per step
        assert recorded / weight == pytest.approx(inside.min() / weight, abs=0.02), step


def test_push_of_a_face_is_none_of_the_grounds(controller: AdaptiveController) -> None:
    """While the swing foot slides down a face: both forces from the equations of motion and differences of samples."""
    terrain = mjbiped.Terrain.from_segments([(0.6, -6.0), (5.0, -6.0, 0.05)])
    walk = mjbiped.walk(controller, terrain, engine="hybrid", steps=2, sample_period=1e-4)
    robot, samples, slope = walk.robot, walk.samples, terrain.slope_at(0.0)
    assert walk.touchdowns["strikes"].tolist() == [0, 1]
    started, ended = walk.touchdowns["time"]
    at = np.flatnonzero((samples["time"] > started) & (samples["time"] < ended))[1:-1]
    q, dq, torque = (samples[name][at] for name in ("q", "dq", "torque"))
    ddq = (q[2:] - 2.0 * q[1:-1] + q[:-2]) / 1e-4**2
    push = np.empty(len(ddq))  # of the face at the swing foot, N
    for k, (angles, rates, torques) in enumerate(zip(q[1:-1], dq[1:-1], torque[1:-1], strict=True)):
        missing = robot.mass_matrix(angles) @ ddq[k] + robot.coriolis_matrix(angles, rates) @ rates
        missing += robot.gravity_vector(angles, slope) - robot.input_matrix @ torques
        along = robot.leg_length * np.cos(angles + slope) * [1.0, -1.0]
        push[k] = missing @ along / (along @ along)
    struck = np.flatnonzero(np.abs(push) > 10.0 * robot.weight)
    assert 0 < len(struck) < 4  # differences over the face impact itself
    after = slice(struck[-1] + 1, -1)
    tangent, normal = borne(walk, 1) - push * [[math.cos(slope)], [math.sin(slope)]]
    used = np.abs(tangent / normal)[after].max()
    assert used > np.abs(tangent / normal)[: struck[0]].max() + 0.05  # the slide asks for most
    assert walk.touchdowns["friction"][1] == pytest.approx(used, rel=0.02)


def test_steps_that_pull_are_marked(pulled: mjbiped.Walk) -> None:
    marked = measures.pulls(pulled.touchdowns)
    assert np.flatnonzero(marked).tolist() == [3, 8]
    assert (measures.friction_asked(pulled.touchdowns) == np.where(marked, np.inf, pulled.touchdowns["friction"])).all()
    summary = measures.summary(pulled)
    assert summary["steps_that_pull"] == 2
    assert summary["least_normal_force_weights"] == pulled.touchdowns["normal_force"].min() / pulled.robot.weight < -0.5
    assert summary["largest_stance_friction"] == math.inf
    shown = [list(column.cells) for column in pulled.summary().__rich__().columns]
    assert dict(zip(*(map(str, cells) for cells in shown[:2]), strict=True))["stance friction used, largest"] == (
        "unbounded"
    )


@pytest.mark.slow
@pytest.mark.parametrize(("timestep", "tolerance"), [(2e-4, 0.02), (2e-3, 0.06)])  # of the weight; docs/physics.md
def test_engines_bear_the_same(timestep: float, tolerance: float, controller: AdaptiveController) -> None:
    """No foot slides on mixed ground: MuJoCo's averages are the paper's force, though contacts open and close."""
    terrain = mjbiped.Terrain.mixed()
    there = mjbiped.walk(controller, terrain, steps=14, engine=mjbiped.Mujoco(timestep=timestep))
    here = mjbiped.walk(controller, terrain, steps=14, engine="hybrid")
    difference = (there.touchdowns["normal_force"] - here.touchdowns["normal_force"]) / there.robot.weight
    assert np.abs(difference).max() < tolerance


def test_a_foot_that_leaves_the_ground_bears_nothing(hurried: AdaptiveController) -> None:
    """What the hybrid engine's ground pulls at lifts off in MuJoCo: in the same step, where the walk comes so far."""
    terrain = mjbiped.Terrain.random(seed=1)
    there, here = (mjbiped.walk(hurried, terrain, steps=18, engine=engine) for engine in ("mujoco", "hybrid"))
    lifted, pulls = (np.flatnonzero(measures.pulls(walk.touchdowns)) for walk in (there, here))
    assert pulls.tolist() == [17]
    assert 17 in lifted
    assert (there.touchdowns["normal_force"][lifted] == 0.0).all()
    assert measures.summary(there)["least_normal_force_weights"] == 0.0
    assert math.isfinite(measures.summary(there)["largest_stance_friction"])


def test_a_hop_is_told_from_a_lost_contact(robot: mjbiped.Compass) -> None:
    """The averages themselves: a force of w, lost for single steps and made up for, is w; 20 ms without, nothing."""
    simulation = make_simulation(PassiveController(), mjbiped.Terrain.level(), robot=robot, q=(0.0, 0.0), dq=(0.0, 0.0))
    c, h = simulation.constants, 2e-4
    for gap, expected in ((0, 1.0), (1, 1.0), (5, 1.0), (60, 1.0), (96, 0.0)):  # 60 steps: a hop of 12 ms
        u = State()
        u.normal_force, u.effective_step = math.inf, h
        for _ in range(10):
            for force in [1.0] * 40 + [0.0] * gap + [1.0 + gap]:
                u.force = force
                bearing.weigh(c, u, u.torque[0])
        assert u.normal_force == pytest.approx(expected, abs=1e-12), gap


def test_records_of_version_1_have_no_force(pulled: mjbiped.Walk, tmp_path: Path) -> None:
    """They load; what they do not tell is NaN in the table, and no measure."""
    path = tmp_path / "old.npz"
    pulled.save(path)
    with np.load(path) as file:
        arrays = {name: file[name] for name in file.files if name != "touchdowns/normal_force"}
    arrays["header"] = np.array(json.dumps({**json.loads(str(arrays["header"])), "version": 1}))
    np.savez(path, **arrays)
    old = mjbiped.Walk.load(path)
    assert np.isnan(old.touchdowns["normal_force"]).all()
    assert old.touchdowns["normal_force"].shape == old.touchdowns["time"].shape
    summary = measures.summary(old)
    assert summary["steps_that_pull"] is None
    assert summary["least_normal_force_weights"] is None
    assert summary["largest_stance_friction"] == pulled.touchdowns["friction"].max()


def test_force_without_landing_steps(controller: AdaptiveController, gait: mjbiped.Gait) -> None:
    """Steps of one length have an effective step, too; contacts then open for so long that more is lost."""
    simulation = make_simulation(
        controller,
        mjbiped.Terrain.level(),
        robot=controller.robot,
        q=gait.start[:2].tolist(),
        dq=gait.start[2:].tolist(),
        steps=2,
        timestep=2e-4,
        lands=False,
    )
    recorder = Recorder()
    simulate(simulation, recorder)
    level = mjbiped.walk(controller, mjbiped.Terrain.level(), engine="hybrid", steps=2)
    found, expected = recorder.touchdowns()["normal_force"], level.touchdowns["normal_force"]
    assert found == pytest.approx(expected, abs=0.03 * controller.robot.weight)
