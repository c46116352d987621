"""Bipeds in space against SymPy, MuJoCo's bodies, and the planar robots that they become at no hip width."""

import math

import mujoco
import numpy as np
import pytest
import sympy

import mjbiped
from mjbiped.engines.mujoco.ground import Ground
from mjbiped.engines.mujoco.scene import scene_spec
from mjbiped.robots.in_space import InSpace, pull_of
from mjbiped.robots.space import Array, joined
from mjbiped.robots.three_d import Abducting3D, Compass3D, Kneed3D

ROBOTS = (Compass3D(hip_mass=1.5, hip_width=0.17), Kneed3D(hip_width=0.12))
ABDUCTING = Abducting3D(hip_mass=1.5, hip_width=0.17, lower_length=0.6, leg_inertia=0.3)


def drawn(robot: InSpace, seed: int) -> tuple[Array, Array]:
    """Pitch angles and roll of all segments, and their rates."""
    rng, n = np.random.default_rng(seed), max(robot.in_space) + 1
    return rng.normal(0.0, 0.3, n), rng.normal(0.0, 1.0, n)


def bodies_of(robot: InSpace) -> list[tuple[float, list[tuple[int, float]], float, float, float, int]]:
    """Mass, levers by segment, lateral place, inertia across and along, and segment of each body."""
    leg, n = robot.bodies.leg, len(robot.bodies.leg)
    share = [robot.axial_inertia * segment.mass / sum(each.mass for each in leg) for segment in leg]
    made: list[tuple[float, list[tuple[int, float]], float, float, float, int]] = []
    up: list[tuple[int, float]] = []
    for k, (segment, axial) in enumerate(zip(reversed(leg), reversed(share), strict=True)):
        made.append((segment.mass, [*up, (k, segment.length - segment.centre)], 0.0, segment.inertia, axial, k))
        up.append((k, segment.length))
    pelvis = robot.hip_mass * robot.hip_width**2 / 12
    made.append((robot.hip_mass, list(up), robot.hip_width / 2, pelvis, 0.0, -1))
    down = list(up)
    for k, (segment, axial) in enumerate(zip(leg, share, strict=True)):
        made.append((segment.mass, [*down, (n + k, -segment.centre)], robot.hip_width, segment.inertia, axial, n + k))
        down.append((n + k, -segment.length))
    return made


@pytest.mark.parametrize("robot", [*ROBOTS, ABDUCTING], ids=lambda robot: robot.kind)
def test_divergent_component_is_that_of_the_centre_of_mass(robot: InSpace) -> None:
    """Its place and rate by the places of the bodies, its pace by how fast an upright robot falls to the side."""
    q, dq = (each[-len(robot.angles) :] for each in drawn(robot, 2))
    still, level = np.zeros(3), pull_of(0.0)
    left, right = (robot.in_space[2].accelerations(still, np.array([0, 0, x]), still, level) for x in (-1e-5, 1e-5))
    assert robot.falling**2 == pytest.approx((right - left)[-1] / 2e-5, rel=1e-8)

    def aside(t: float) -> float:  # from the left foot to the right
        centre = robot.centre_in_space(robot.posture((0.0, 0.0), 0, q + t * dq))
        return float(0.5 * robot.hip_width - centre[1])

    expected = aside(0.0) + (aside(1e-6) - aside(-1e-6)) / 2e-6 / robot.falling
    assert robot.divergent_component(q, dq) == pytest.approx(expected, abs=1e-8)


@pytest.mark.parametrize("robot", [*ROBOTS, ABDUCTING], ids=lambda robot: robot.kind)
def test_equations_are_lagrange_s(robot: InSpace) -> None:
    """SymPy derives them from the places of the bodies and their angular velocities, by rotation matrices."""
    q, dq = drawn(robot, 1)
    n = len(q) - 1
    angles, rates = sympy.symbols(f"q:{n + 1}"), sympy.symbols(f"v:{n + 1}")
    gx, gz, gy = sympy.symbols("gx gz gy")
    roll = sympy.rot_axis1(-angles[-1])
    pitch = [sympy.rot_axis2(-angle) for angle in robot.pitches(angles)]
    if robot.hips:  # each leg turns by half of the abduction about its own forward direction
        pitch = [leg * sympy.rot_axis1(side * angles[2] / 2) for leg, side in zip(pitch, (1, -1), strict=True)]
    upright, axle, g = sympy.Matrix([0, 0, 1]), sympy.Matrix([0, 1, 0]), robot.gravity
    kinetic = potential = sympy.Integer(0)
    for mass, levers, lateral, across, along, segment in bodies_of(robot):
        local = sum((lever * pitch[k] * upright for k, lever in levers), lateral * axle)
        place = roll * local
        velocity = place.jacobian(angles) * sympy.Matrix(rates)
        kinetic += mass * velocity.dot(velocity) / 2
        potential -= mass * g * place.dot(sympy.Matrix([gx, gy, -gz]))
        rotation = roll if segment < 0 else roll * pitch[segment]
        spin = rotation.T * sum((rotation.diff(a) * v for a, v in zip(angles, rates, strict=True)), sympy.zeros(3))
        w = sympy.Matrix([spin[2, 1], spin[0, 2], spin[1, 0]])
        inertia = (across, 0, 0) if segment < 0 else (across, across, along)
        kinetic += sum(i * each**2 for i, each in zip(inertia, w, strict=True)) / 2
    energy = sympy.lambdify([angles, rates], kinetic, cse=True)
    height = sympy.lambdify([angles, (gx, gz, gy)], potential, cse=True)
    unit, tiny = np.eye(n + 1), 1e-30  # derivatives by complex steps, exact to rounding

    def matrix(q: Array) -> np.ndarray:
        return np.array([[energy(q, a + b) - energy(q, a) - energy(q, b) for a in unit] for b in unit])

    bias = (matrix(q + 1j * tiny * dq) @ dq).imag / tiny - [energy(q + 1j * tiny * a, dq).imag / tiny for a in unit]
    pull = [[height(q + 1j * tiny * a, b).imag / tiny for b in np.eye(3)] for a in unit]
    linkage = robot.in_space[n]
    np.testing.assert_allclose(linkage.mass_matrix(q), matrix(q), rtol=0, atol=1e-12)
    np.testing.assert_allclose(linkage.coriolis_forces(q, dq), bias, rtol=0, atol=1e-11)
    np.testing.assert_allclose(linkage.gravity_forces(q), pull, rtol=0, atol=1e-11)


def floating(robot: InSpace, q: Array, dq: Array) -> tuple[mujoco.MjModel, mujoco.MjData, Array]:
    """The robot's MJCF in a state with the right foot at rest, and the map from rates of angles to MuJoCo's rates.

    The right leg stands, the left one swings: towards the swing side is +y. Joints of a leg turn against the segment
    above. Yaw rests. Both legs abduct by the same angle.
    """
    ground = Ground(mjbiped.Terrain.level(), reach=1.0)
    model = scene_spec(robot, ground, ground.pieces, timestep=1e-4).compile()
    model.body("hip").inertia[1] = 1e-15  # a rod's about its line
    data, n = mujoco.MjData(model), len(robot.bodies.leg)
    to_joints = np.zeros((model.nv, len(q)))
    for name in robot.hips:
        to_joints[model.joint(name).dofadr[0], 2] = 0.5
    to_joints[model.joint("roll").dofadr[0], -1] = 1.0
    for side, segments in (("left", range(n, 2 * n)), ("right", range(n - 1, -1, -1))):
        first = model.joint(side).dofadr[0]
        for k, segment in enumerate(segments):
            to_joints[first + k, segment] = 1.0
            if k:
                to_joints[first + k, segments[k - 1]] = -1.0
    data.qpos[:] = to_joints @ q
    mujoco.mj_kinematics(model, data)
    mujoco.mj_comPos(model, data)
    jacobian = np.zeros((3, model.nv))
    mujoco.mj_jacGeom(model, data, jacobian, None, model.geom("right_foot").id)
    to_joints[:3] = -(jacobian @ to_joints)
    data.qvel[:] = to_joints @ dq
    mujoco.mj_forward(model, data)
    return model, data, to_joints


@pytest.mark.parametrize("robot", [*ROBOTS, ABDUCTING], ids=lambda robot: robot.kind)
def test_mass_matrix_and_bias_are_those_of_mujoco_s_bodies(robot: InSpace) -> None:
    q, dq = drawn(robot, 2)
    linkage = robot.in_space[len(q) - 1]
    model, data, to_joints = floating(robot, q, dq)
    full = np.zeros((model.nv, model.nv))
    mujoco.mj_fullM(model, data, full)
    np.testing.assert_allclose(to_joints.T @ full @ to_joints, linkage.mass_matrix(q), rtol=0, atol=1e-11)
    # the hip's slides take up the acceleration that the foot would have by its Jacobian's rate
    foot, turning, moved = model.geom("right_foot"), np.zeros((3, model.nv)), np.zeros(model.nv)
    mujoco.mj_jacDot(model, data, turning, None, data.geom("right_foot").xpos, foot.bodyid[0])
    moved[:3] = -(turning @ data.qvel)
    bias = to_joints.T @ (data.qfrc_bias + full @ moved)
    ours = linkage.coriolis_forces(q, dq) + linkage.gravity_forces(q) @ pull_of(0.0)
    np.testing.assert_allclose(bias, ours, rtol=0, atol=1e-10)
    place = data.geom("left_foot").xpos - data.geom("right_foot").xpos
    np.testing.assert_allclose(linkage.swing_foot(q), place, rtol=0, atol=1e-12)


@pytest.mark.parametrize("robot", [*ROBOTS, ABDUCTING], ids=lambda robot: robot.kind)
@pytest.mark.parametrize("turn", [0.0, 0.3])
def test_impact_is_that_of_mujoco_s_bodies(robot: InSpace, turn: float) -> None:
    """The swing foot stops, and nothing turns about the new upright direction; then the legs have other roles."""
    q, dq = drawn(robot, 2)
    model, data, to_joints = floating(robot, q, dq)
    full, rows = np.zeros((model.nv, model.nv)), np.zeros((4, model.nv))
    mujoco.mj_fullM(model, data, full)
    mujoco.mj_jacGeom(model, data, rows[:3], None, model.geom("left_foot").id)
    roll, aside = np.cos(q[-1]), np.sin(q[-1])
    along, axle, upright = np.array([[1.0, 0.0, 0.0], [0.0, roll, aside], [0.0, -aside, roll]])
    heading, held = np.cos(turn) * along - np.sin(turn) * upright, np.cos(turn) * upright + np.sin(turn) * along
    turns = [model.joint(name).dofadr[0] for name in ("roll", "yaw")]
    rows[3, turns] = held[[0, 2]]
    if robot.hips:  # the gear
        left, right = (model.joint(name).dofadr[0] for name in robot.hips)
        rows = np.vstack([rows, np.eye(model.nv)[left] - np.eye(model.nv)[right]])
    weights = np.linalg.solve(full, rows.T)
    stopped = data.qvel - weights @ np.linalg.solve(rows @ weights, rows @ data.qvel)
    spin = np.array([stopped[turns[0]], 0.0, stopped[turns[1]]])
    rates = np.linalg.lstsq(to_joints[3:], stopped[3:] * (np.arange(3, model.nv) != turns[1]), rcond=None)[0]
    n = len(robot.pitches(q))
    rates[:n], rates[-1] = rates[:n] + spin @ axle, spin @ heading
    after, found = robot.in_space[len(q) - 1].touchdown(q, dq, turn)
    mirrored = [np.concatenate([each[:n][::-1], each[n:-1], -each[-1:]]) for each in (q, rates)]
    np.testing.assert_allclose(after, mirrored[0] - turn * (np.arange(len(q)) < n), rtol=0, atol=1e-15)
    np.testing.assert_allclose(found, mirrored[1], rtol=0, atol=1e-10)


@pytest.mark.parametrize("wide", ROBOTS, ids=lambda robot: robot.kind)
def test_legs_that_come_together_walk_in_the_plane(wide: InSpace) -> None:
    robot, planar = wide.set_apart(1e-9), wide.planar
    rng, n, slope = np.random.default_rng(3), len(planar.angles), 0.1
    q, dq, torque = rng.normal(0.0, 0.2, n), rng.normal(0.0, 1.0, n), rng.normal(0.0, 0.3, n)
    state = np.append(q, 0.0), np.append(dq, 0.0)
    chain = planar.chains[n]
    found = robot.in_space[n].accelerations(np.zeros(n + 1), *state, pull_of(slope))
    np.testing.assert_allclose(found[:-1], chain.accelerations(np.zeros(n), q, dq, slope), rtol=0, atol=1e-9)
    np.testing.assert_allclose(robot.energy(*state, slope), planar.energy(q, dq, slope), rtol=1e-12)
    two = (np.append(q[:2], 0.0), np.append(dq[:2], 0.0))
    legs = q[[0, 1, 1][:n]], dq[[0, 1, 1][:n]]  # the knee is locked
    rates, angles = planar.rates_after_touchdown(*legs), tuple(np.append(each, 0.0) for each in legs)
    np.testing.assert_allclose(robot.impact(*two)[1][:2], rates[:2], atol=1e-9)
    assert robot.rates_after_touchdown(angles[0], angles[1]) == pytest.approx(np.append(rates, 0.0), abs=1e-6)
    force = robot.ground_force(angles[0], angles[1], np.append(torque, 0.0), slope)
    assert force == pytest.approx(planar.ground_force(*legs, torque, slope), rel=1e-6)
    if n == 3:
        groups = np.array([[1, 0, 0], [0, 1, 0], [0, 1, 0], [0, 0, 1]], dtype=float)
        straight = q[[0, 1, 1]]
        struck = joined(robot.in_space[3], groups, np.append(straight, 0.0), state[1])
        assert isinstance(planar, mjbiped.KneedBiped)
        np.testing.assert_allclose(struck[:2], planar.knee_impact(straight, dq)[1], rtol=0, atol=1e-9)


def test_legs_that_are_not_opened_are_those_that_cannot_be() -> None:
    """Also where they land on ground of another slope: points of mass against the momenta of segments."""
    opened, plain, kept = ABDUCTING.in_space[3], ABDUCTING.in_space[2], [0, 1, 3]
    rng, pull, force = np.random.default_rng(5), pull_of(0.1, 0.05), np.array([1.0, 2.0, 3.0])
    q, dq, ddq = (np.insert(rng.normal(0.0, 0.4, 3), 2, 0.0) for _ in range(3))
    three = q[kept], dq[kept]
    for found, wanted in (
        (opened.energy(q, dq, pull), plain.energy(*three, pull)),
        (opened.swing_foot(q), plain.swing_foot(three[0])),
        (opened.pushed(q, force)[kept], plain.pushed(three[0], force)),
        (opened.ground_force(q, dq, ddq, pull), plain.ground_force(*three, ddq[kept], pull)),
        (opened.moment_across(q, dq), plain.moment_across(*three)),
    ):
        np.testing.assert_allclose(found, wanted, rtol=0, atol=1e-12)
    (after, rates), (wanted_after, wanted_rates) = opened.touchdown(q, dq, 0.07), plain.touchdown(*three, 0.07)
    np.testing.assert_allclose(after[kept], wanted_after, rtol=0, atol=1e-15)
    momentum = (opened.mass_matrix(after) @ rates)[kept]
    np.testing.assert_allclose(momentum, plain.mass_matrix(wanted_after) @ wanted_rates, rtol=0, atol=1e-12)


def test_gravity_s_direction() -> None:
    np.testing.assert_allclose(pull_of(0.1), [math.sin(0.1), math.cos(0.1), 0.0], rtol=0, atol=1e-15)
    assert np.linalg.norm(pull_of(0.1, -0.2)) == pytest.approx(1.0, abs=1e-15)
    assert pull_of(0.1, -0.2)[2] < 0.0
