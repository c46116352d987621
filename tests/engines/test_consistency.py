"""Does MuJoCo's robot obey the equations of `mjbiped.robots.compass`? The same questions put to both.

First the algebra, which must agree to rounding: masses, forces, energies and motors of the compiled scene, reduced to
the two legs of a robot whose stance foot is pinned. Then what the time-stepping makes of it, which must agree to an
error that shrinks with the timestep in the order that the scheme has: one impact, one swing, whole walks.
"""

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace
from itertools import pairwise
from typing import Any

import mujoco
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from numpy.typing import NDArray
from scipy.integrate import solve_ivp
from simulations import build_scene, make_simulation

import mjbiped
from controllers import AdaptiveController, Controller, Memory
from mjbiped.analysis.compare import torque_differences
from mjbiped.engines.mujoco.ground import FOOT_RADIUS
from mjbiped.engines.mujoco.options import DEFAULT_CONTACT_TIMESTEP
from mjbiped.engines.mujoco.scene import START_DEPTH
from mjbiped.engines.mujoco.simulation import Simulation
from mjbiped.engines.mujoco.softness import STIFFNESS
from mjbiped.records import measures
from mjbiped.records.columns import TOUCHDOWNS, split
from mjbiped.robots import compass
from mjbiped.robots.compass import Compass
from mjbiped.rules.scuffing import ScuffingRule
from mjbiped.terrain.segments import GROUND_FRICTION
from mjbiped.terrain.terrain import Terrain

Array = NDArray[np.float64]

FEET = ("left", "right")

# Rounding of MuJoCo's recursion over three bodies and of the projection: measured 7e-15 of the largest term over
# 200 robots and states.
ROUNDING = 1e-12

robots = st.builds(
    Compass,
    leg_mass=st.floats(0.1, 50.0),
    hip_mass=st.just(0.0) | st.floats(0.0, 50.0),
    lower_length=st.floats(0.05, 2.0),
    upper_length=st.floats(0.05, 2.0),
    leg_inertia=st.none() | st.just(0.0) | st.floats(0.0, 5.0),
    gravity=st.floats(1.0, 20.0),
)


def pair_of(low: float, high: float) -> st.SearchStrategy[tuple[float, float]]:
    return st.tuples(st.floats(low, high), st.floats(low, high))


# ---- algebra ---------------------------------------------------------------------------------------------------------


@dataclass(frozen=True)
class Pinned:
    """MuJoCo's robot in a state, with the stance foot pinned.

    Attributes:
        data: With everything computed by `mj_forward`.
        robot: What MuJoCo's compiler made of the robot: it refuses a body without mass or inertia, and
            `mjbiped.engines.mujoco.scene` gives it the least that is allowed (1e-5 of the robot's mass, 1e-4 kg for
            Table I). The analytic robot gets the same, so that nothing has to be forgiven.
        foot: Position of the stance foot, shape (3,), m.
        S: Velocities of hip x, hip z, left and right leg that each leg's rate brings about, stance leg first.
        S_rate: Its time derivative.
        M: MuJoCo's mass matrix, shape (4, 4).
    """

    data: mujoco.MjData
    robot: Compass
    foot: Array
    S: Array
    S_rate: Array
    M: Array


def pinned(
    robot: Compass,
    slope: float,
    side: int,
    q: Sequence[float],
    dq: Sequence[float],
    torque: Sequence[float] = (0.0, 0.0),
    hip: Sequence[float] = (0.0, 0.0),
) -> Pinned:
    """Set MuJoCo's robot into a state; q is measured from the normal of ground of that slope, the hip is anywhere.

    Angles and rates alone are ours: that the foot stands still, and how the motors are wired, is MuJoCo's business.
    """
    model = build_scene(robot, Terrain.level(), timestep=1e-4, reach=1.0).model
    data = mujoco.MjData(model)
    legs = np.array(q) + slope
    data.qpos[:] = [*hip, *(legs if side == 0 else legs[::-1])]
    mujoco.mj_kinematics(model, data)
    mujoco.mj_comPos(model, data)
    foot = data.geom(f"{FEET[side]}_foot").xpos.copy()
    body = model.body(f"{FEET[side]}_leg").id
    S = np.zeros((4, 2))
    S[2 + side, 0] = S[3 - side, 1] = 1.0
    S[:2] = -foot_jacobian(model, data, foot, body) @ S  # the slides make good what the foot would move
    data.qvel[:] = S @ dq
    ankle, hip_torque = torque
    data.ctrl[:] = (
        (0.0, ankle, -hip_torque) if side else (ankle, 0.0, hip_torque)
    )  # as mjbiped.engines.mujoco.simulation drives them
    mujoco.mj_forward(model, data)
    mujoco.mj_energyPos(model, data)
    mujoco.mj_energyVel(model, data)
    rates = np.zeros((3, 4))
    mujoco.mj_jacDot(model, data, rates, None, foot, body)
    turning = np.zeros((4, 2))
    turning[2 + side, 0] = turning[3 - side, 1] = 1.0
    S_rate = np.zeros((4, 2))
    S_rate[:2] = -rates[[0, 2]] @ turning
    compiled = replace(
        robot,
        hip_mass=float(model.body("hip").mass[0]),
        leg_inertia=float(model.body("left_leg").inertia[1]),
    )
    return Pinned(data, compiled, foot, S, S_rate, mass_of(model, data))


def foot_jacobian(model: mujoco.MjModel, data: mujoco.MjData, point: Array, body: int) -> Array:
    """Speed x, z of a point of a body for each of the four coordinates' rates."""
    jacobian = np.zeros((3, 4))
    mujoco.mj_jac(model, data, jacobian, None, point, body)
    return jacobian[[0, 2]]


def mass_of(model: mujoco.MjModel, data: mujoco.MjData) -> Array:
    M = np.zeros((4, 4))
    mujoco.mj_fullM(model, data, M)
    return M


def close(actual: object, expected: object, scale: float) -> None:
    np.testing.assert_allclose(np.asarray(actual), np.asarray(expected), rtol=0.0, atol=ROUNDING * scale)


states = {
    "robot": robots,
    "slope": st.floats(-0.6, 0.6),
    "side": st.integers(0, 1),
    "q": pair_of(-1.5, 1.5),
    "dq": pair_of(-8.0, 8.0),
}


@settings(deadline=None, derandomize=True, max_examples=60)
@given(hip=pair_of(-20.0, 20.0), torque=pair_of(-50.0, 50.0), **states)
def test_equations_of_motion(
    robot: Compass,
    slope: float,
    side: int,
    q: tuple[float, float],
    dq: tuple[float, float],
    torque: tuple[float, float],
    hip: tuple[float, float],
) -> None:
    """Mass matrix, C dq + g and B tau of eq. (1): MuJoCo's, projected on the motions that leave the stance foot still.

    M ddq + h = B tau with S' (M_mujoco (S ddq + S_rate dq) + bias) = S' actuator forces.
    """
    at = pinned(robot, slope, side, q, dq, torque, hip)
    S, M, true = at.S, at.M, at.robot
    close(S.T @ M @ S, true.mass_matrix(q), scale=true.constants[0])
    bias = S.T @ (at.data.qfrc_bias + M @ at.S_rate @ dq)
    forces = true.coriolis_matrix(q, dq) @ dq + true.gravity_vector(q, slope)
    close(bias, forces, scale=true.constants[3] + true.constants[0] * max(map(abs, dq)) ** 2)
    close(S.T @ at.data.qfrc_actuator, true.input_matrix @ torque, scale=100.0)


@settings(deadline=None, derandomize=True, max_examples=40)
@given(hip=pair_of(-20.0, 20.0), **states)
def test_energies(
    robot: Compass, slope: float, side: int, q: tuple[float, float], dq: tuple[float, float], hip: tuple[float, float]
) -> None:
    at = pinned(robot, slope, side, q, dq, hip=hip)
    potential, kinetic = at.data.energy
    close(kinetic, at.robot.kinetic_energy(q, dq), scale=at.robot.constants[0] * 8.0**2)
    about_foot = potential - at.robot.weight * at.foot[2]
    close(about_foot, at.robot.potential_energy(q, slope), scale=at.robot.weight * (20.0 + at.robot.leg_length))


# ---- one impact ------------------------------------------------------------------------------------------------------


@dataclass(frozen=True)
class Landing:
    """A robot just before its swing foot meets the ground.

    Attributes:
        robot: Any.
        q: Angles from the normal of the ground under the stance foot.
        dq: Rates.
        slopes: Of the ground under the stance foot, and of that which is met.
        foot: Swing foot from the stance foot, x and z in m.
        speed: At which it approaches the ground, m/s.
    """

    robot: Compass
    q: Array
    dq: Array
    slopes: tuple[float, float]
    foot: Array
    speed: float

    def terrain(self, clearance: float) -> Terrain:
        """Ground with the new slope as far under the swing foot, and a step half-way, however high."""
        half = self.foot[0] / 2.0
        old, new = self.slopes
        return Terrain((0.0, half), (0.0, self.foot[1] - clearance / math.cos(new) + math.tan(new) * half), (old, new))

    def torque(self, scale: float) -> tuple[float, float]:
        """Ankle and hip torque of a size that a walk may ask for in the instant of an impact."""
        moment = self.robot.weight * self.robot.leg_length
        return 0.3 * scale * moment, -0.2 * scale * moment


def landing(random: np.random.Generator, same_slope: bool = False) -> Landing:
    """Draw a state that ends in an impact as the paper has it: plastic, without slip, the trailing foot leaves."""
    while True:
        masses: dict[str, Any] = {"leg_mass": random.uniform(1.0, 20.0), "hip_mass": random.uniform(0.0, 30.0)}
        lengths: dict[str, Any] = {"lower_length": random.uniform(0.2, 0.8), "upper_length": random.uniform(0.2, 0.8)}
        robot = Compass(**masses, **lengths, gravity=random.uniform(1.6, 20.0))
        old = random.uniform(-0.2, 0.2)
        new = old if same_slope else random.uniform(-0.2, 0.2)
        pace = math.sqrt(robot.gravity / robot.leg_length)
        q = np.array([random.uniform(0.05, 0.4), random.uniform(-0.4, -0.05)])
        dq = pace * np.array([random.uniform(0.1, 1.0), random.uniform(-1.0, 1.7)])
        turn = np.array([[math.cos(old), math.sin(old)], [-math.sin(old), math.cos(old)]])
        foot = turn @ robot.swing_foot(q)
        normal, along = np.array([math.sin(new), math.cos(new)]), np.array([math.cos(new), -math.sin(new)])
        speed = -float(_foot_speed(robot, q + old, dq) @ normal)
        q_plus, dq_plus = robot.impact(q, dq)
        impulse = _momentum(robot, q_plus + old, dq_plus) - _momentum(robot, q + old, dq)
        lifts = float(_foot_speed(robot, q_plus + old, dq_plus) @ np.array([math.sin(old), math.cos(old)]))
        sticks = abs(impulse @ along) < 0.9 * GROUND_FRICTION * (impulse @ normal)
        ahead = foot[0] > 0.1 * robot.leg_length and abs(foot[1]) < 0.3
        if speed > 0.05 * pace * robot.leg_length and lifts > 0.0 and sticks and ahead:
            return Landing(robot, q, dq, (old, new), foot, speed)


def _foot_speed(robot: Compass, legs: Array, rates: Array) -> Array:
    """Speed x, z of the swing foot, by angles from the vertical."""
    (one, two), (rate_one, rate_two) = legs, rates
    return robot.leg_length * np.array(
        [math.cos(one) * rate_one - math.cos(two) * rate_two, math.sin(two) * rate_two - math.sin(one) * rate_one]
    )


def _momentum(robot: Compass, legs: Array, rates: Array) -> Array:
    """Momentum x, z of the robot that pivots about its stance foot."""
    first, second = robot.constants[3] / robot.gravity, robot.constants[4] / robot.gravity
    return np.stack([np.cos(legs), -np.sin(legs)]) @ (np.array([first, -second]) * rates)


class Held(Controller):
    """Torques that never change."""

    def __init__(self, ankle: float, hip: float) -> None:
        self.torques = ankle, hip

    def torque(self, memory: Memory, t: float, q: Sequence[float], dq: Sequence[float]) -> Sequence[float]:
        return self.torques


def about_to_land(case: Landing, timestep: float, torque: float) -> Simulation:
    """The robot one and a half steps before its foot meets the ground, in the engine as it walks."""
    return make_simulation(
        Held(*case.torque(torque)),
        case.terrain(1.5 * timestep * case.speed + START_DEPTH),  # else a slow foot would begin in the ground
        robot=case.robot,
        q=case.q.tolist(),
        dq=case.dq.tolist(),
        timestep=timestep,
        contact_timestep=timestep,
        steps=1,
        scuffing=ScuffingRule(reach=0.0, delay=0.0),
    )


def impact_error(case: Landing, timestep: float, torque: float) -> float:
    """Rates after the impact, as they are recorded, against the impact map of those before it; of the largest rate."""
    simulation = about_to_land(case, timestep, torque)
    u = simulation.state
    for _ in range(40):
        simulation.advance(1)
        if u.count:
            break
    assert u.count == 1.0
    row = split(TOUCHDOWNS, [simulation._rows[0].tolist()])
    _, mapped = case.robot.impact(row["q_before"][0], row["dq_before"][0])
    return float(np.abs(row["dq"][0] - mapped).max() / np.abs(row["dq_before"]).max())


@settings(deadline=None, derandomize=True, max_examples=60)
@given(seed=st.integers(0, 2**32 - 1), same_slope=st.booleans(), torque=st.sampled_from([0.0, 1.0]))
def test_contact_step_is_the_impact_map_of_the_rates_at_its_end(seed: int, same_slope: bool, torque: float) -> None:
    """What the contact solver does in the step of a touchdown, to the solver's own tolerance.

    Three things, and no more, part it from the impact map of the rates before: gravity, Coriolis forces and *motors*
    act for the whole step; a foot that is already d deep is pushed out at k d h (k the contact's stiffness); and the
    constraint is soft by 1e-4: `solimp` = 0.9999 divides damping and stiffness (MuJoCo's manual, "Solver parameters"),
    and lets the foot go by R times the impulse (efc_R).
    """
    case = landing(np.random.default_rng(seed), same_slope)
    h = DEFAULT_CONTACT_TIMESTEP
    simulation = about_to_land(case, h, torque)
    model, data = simulation.model, simulation.data
    for _ in range(40):
        before, legs = data.qvel.copy(), data.qpos[2:].copy()
        simulation.advance(1)
        if simulation.state.noted:
            break
    assert simulation.state.noted
    (contact,) = data.contact  # the departing foot has none
    normal = np.array([math.sin(case.slopes[1]), math.cos(case.slopes[1])])
    frame = np.stack([normal, [normal[1], -normal[0]]])
    M, body = mass_of(model, data), model.body("right_leg").id  # of the posture at the step's beginning

    def speed_of(point: Array) -> Array:
        """Jacobian of a point of the landing leg, normal to the ground and along it."""
        return frame @ foot_jacobian(model, data, point, body)

    def after(rates: Array, J: Array, target: Array, softness: Array) -> Array:
        """Rates after the impulse p along J that leaves the speed `target` - `softness` p."""
        weighted = np.linalg.solve(M, J.T)
        impulse = np.linalg.solve(J @ weighted + np.diag(softness), target - J @ rates)
        return np.asarray(rates + weighted @ impulse)

    still, size = np.zeros(2), float(np.abs(before[2:]).max())
    # with MuJoCo's masses and Jacobian, the plastic impulse at the leg's end is the impact map
    swung = np.concatenate([_hip_speed(case.robot, legs, before[2:]), before[2:]])
    mapped = after(swung, speed_of(data.geom("right_foot").xpos), still, still)
    _, expected = case.robot.impact(legs - case.slopes[0], before[2:])
    np.testing.assert_allclose(mapped[[3, 2]], expected, rtol=0.0, atol=1e-10 * size)  # condition number up to 1e2

    J = speed_of(contact.pos)
    softened = model.geom_solimp[model.geom("right_foot").id, 0]
    depth = np.array([-contact.dist, 0.0])
    target = J @ before * (1.0 - 1.0 / softened) + STIFFNESS / softened * h * depth
    smooth = before + h * np.linalg.solve(M, data.qfrc_smooth)
    resolved = after(smooth, J, target, data.efc_R[:2])
    # where Newton's solver stops: measured 7e-10
    np.testing.assert_allclose(data.qvel, resolved, rtol=0.0, atol=1e-8 * size)


def _hip_speed(robot: Compass, legs: Array, rates: Array) -> Array:
    return np.array([math.cos(legs[0]), -math.sin(legs[0])]) * (robot.leg_length * float(rates[0]))


@pytest.mark.parametrize("torque", [0.0, 1.0])
def test_error_of_an_impact_shrinks_with_the_timestep(torque: float) -> None:
    """Recorded impacts against the map: first order in h, for the forces and the turning of the legs in one step.

    The constant is the acceleration: torques of 0.3 and 0.2 weights times leg lengths in the instant of the impact
    make the worst error fourteen times as large.
    """
    random = np.random.default_rng(1)
    cases = [landing(random, same_slope=number % 3 == 0) for number in range(40)]
    timesteps = 2e-5 * 2.0 ** np.arange(4)  # at shorter ones what does not shrink is the greater part
    errors = np.array([[impact_error(case, h, torque) for case in cases] for h in timesteps])
    # Order 1 (measured 1.005 and 1.003), bent by what does not shrink: the constraint's softness and the foot's radius.
    assert np.polyfit(np.log(timesteps), np.log(errors.max(axis=1)), 1)[0] == pytest.approx(1.0, abs=0.05)
    # the engine's default of 2e-5 s; measured 0.00026 and 0.0041 of the largest rate: h times the accelerations at play
    assert errors[0].max() < (0.005 if torque else 0.0004)


# ---- one swing -------------------------------------------------------------------------------------------------------


@dataclass(frozen=True)
class Swing:
    """A robot on one leg, which its motors hold at constant torques, and whose other foot meets nothing."""

    robot: Compass
    slope: float
    q: Array
    dq: Array
    torque: Array

    def exact(self, time: float) -> Array:
        """q and dq after a time, by SciPy's integrator and the equations of `mjbiped.robots.compass`."""
        forces = self.robot.input_matrix @ self.torque
        sine, cosine = math.sin(self.slope), math.cos(self.slope)

        def law(_: float, y: Array) -> list[float]:
            q1, q2, dq1, dq2 = y.tolist()
            ddq = compass.acceleration(self.robot.constants, q1, q2, dq1, dq2, sine, cosine, *forces.tolist())
            return [dq1, dq2, *ddq]

        motion = solve_ivp(law, (0.0, time), [*self.q, *self.dq], "DOP853", rtol=1e-12, atol=1e-13)
        return np.asarray(motion.y[:, -1])

    def simulated(self, time: float, timestep: float, radius: float = FOOT_RADIUS) -> Array:
        """The same in MuJoCo: the stance foot is held by its contact alone."""
        model = build_scene(self.robot, Terrain.incline(math.degrees(self.slope)), timestep=timestep, reach=2.0).model
        swing, stance, ground = (model.geom(name).id for name in ("right_foot", "left_foot", "ground_0"))
        model.geom_contype[swing] = 0
        normal = np.array([math.sin(self.slope), 0.0, math.cos(self.slope)])
        model.geom_size[stance, 0] = model.geom_rbound[stance] = radius
        model.geom_pos[ground] += (FOOT_RADIUS - radius) * normal
        data = mujoco.MjData(model)
        legs = self.q + self.slope
        place = self.robot.leg_length * np.array([math.sin(legs[0]), math.cos(legs[0])]) - 1e-9 * normal[[0, 2]]
        data.qpos[:] = [*place, *legs]
        data.qvel[:] = [*_hip_speed(self.robot, legs, self.dq), *self.dq]
        data.ctrl[:] = [self.torque[0], 0.0, self.torque[1]]
        mujoco.mj_step(model, data, nstep=round(time / timestep))
        return np.concatenate([data.qpos[2:] - self.slope, data.qvel[2:]])


def swing(random: np.random.Generator) -> Swing:
    """Draw one near a walk's, so that the stance foot stays pressed to the ground."""
    robot = Compass(
        leg_mass=random.uniform(2.0, 10.0),
        hip_mass=random.uniform(0.0, 10.0),
        lower_length=random.uniform(0.3, 0.6),
        upper_length=random.uniform(0.3, 0.6),
    )
    pace, moment = math.sqrt(robot.gravity / robot.leg_length), robot.weight * robot.leg_length
    return Swing(
        robot,
        random.uniform(-0.1, 0.1),
        np.array([random.uniform(-0.25, -0.1), random.uniform(0.1, 0.25)]),
        pace * np.array([random.uniform(0.25, 0.4), random.uniform(0.0, 0.3)]),
        moment * np.array([random.uniform(-0.03, 0.03), random.uniform(-0.02, 0.02)]),
    )


@pytest.mark.slow
def test_swing_converges_to_the_equations_of_motion() -> None:
    """First order in h; and what is left at h = 0 is the foot's rolling, first order in its radius."""
    random = np.random.default_rng(5)
    time, timesteps = 0.4, (1e-4, 5e-5, 2.5e-5)
    for _ in range(6):
        case = swing(random)
        exact, left = case.exact(time), []
        for radius in (FOOT_RADIUS, FOOT_RADIUS / 10.0):
            ends = [case.simulated(time, h, radius) for h in timesteps]
            # angles only: in one step of some hundred MuJoCo finds no stance contact, and a rate is off by g h / l
            coarse, fine = (there[:2] - here[:2] for here, there in pairwise(ends))
            # halving h halves the error: 2 + O(h); measured 1.994 to 2.001
            assert np.abs(coarse).max() / np.abs(fine).max() == pytest.approx(2.0, abs=0.02)
            left.append(2.0 * ends[2][:2] - ends[1][:2] - exact[:2])
        # the stance foot rolls by its radius times the leg's turn, 0.4 rad, and instability doubles what it changes
        assert np.abs(left[0]).max() < 2.0 * FOOT_RADIUS / case.robot.leg_length
        # extrapolated to h = 0 with an error of some 1e-7 rad
        assert left[1] == pytest.approx(left[0] / 10.0, rel=0.05, abs=2e-7)


# ---- whole walks -----------------------------------------------------------------------------------------------------

PRESETS = {
    "level": Terrain.level(),
    "down 3": Terrain.incline(3.0),
    "up 3": Terrain.incline(-3.0),
    "slopes +0.3": Terrain.slopes(change_deg=0.3),
    "slopes -1": Terrain.slopes(change_deg=-1.0),
    "stairs -0.006": Terrain.stairs(rise=-0.006),
    "stairs +0.006": Terrain.stairs(rise=0.006),
    "stairs -0.06": Terrain.stairs(rise=-0.06),
    "mixed": Terrain.mixed(),
}


def assert_agreement(walked: mjbiped.Comparison) -> None:
    """What the issue asks of both engines: the same touchdowns, c_mt, torques and distance, to its limits."""
    there, here = walked.mujoco, walked.hybrid
    assert (there.outcome, there.steps) == (here.outcome, here.steps)
    segments = [[w.terrain.segment_at(x) for x in w.touchdowns["x"]] for w in (there, here)]
    assert segments[0] == segments[1]
    assert np.array_equal(there.touchdowns["stance"], here.touchdowns["stance"])
    assert there.cost_of_transport == pytest.approx(here.cost_of_transport, rel=0.005)
    assert there.distance == pytest.approx(here.distance, abs=5e-3)
    limits = np.maximum(0.15, 0.02 * here.peak_torque)
    assert (np.abs(there.peak_torque - here.peak_torque) < limits).all()


def assert_same_steps(walked: mjbiped.Comparison) -> None:
    """Step for step: what the default steps leave, by the measurement in docs/convergence.md."""
    there, here = walked.mujoco, walked.hybrid
    assert walked.divergence is None, walked.verdict
    lengths = [measures.step_lengths(w) for w in (there, here)]
    assert lengths[0] == pytest.approx(lengths[1], abs=1e-4)  # measured 0.03 mm
    estimates = [w.touchdowns["slope_estimate"] for w in (there, here)]
    assert estimates[0] == pytest.approx(estimates[1], abs=3e-4)  # rad; measured 1.5e-4
    _, torque = torque_differences(walked)
    # Every some ten steps the stance foot loses contact for one physics step and falls by g h²: a rate off by g h / l =
    # 2e-3 rad/s, which K2 and the inertia make a torque of some 0.2 N m, 0.6 N m where the legs stand wide (stairs)
    assert np.nanmax(np.abs(torque)) < max(0.3, 0.02 * here.peak_torque.max())
    # MuJoCo reads the contact force that lasts for half a millisecond, the hybrid engine the motion at the integrator's
    # nodes and the impulses; measured 3.2e-3
    assert there.touchdowns["friction"].max() == pytest.approx(here.touchdowns["friction"].max(), abs=0.01)


@pytest.mark.parametrize(("name", "steps"), [("stairs -0.06", 5), ("mixed", 7)])
def test_closed_loop_walks_agree(name: str, steps: int, controller: AdaptiveController) -> None:
    walked = mjbiped.compare(controller, PRESETS[name], steps=steps)
    assert_agreement(walked)
    assert_same_steps(walked)


@pytest.mark.slow
@pytest.mark.parametrize("name", PRESETS)
def test_closed_loop_walks_agree_on_every_preset(name: str, controller: AdaptiveController) -> None:
    walked = mjbiped.compare(controller, PRESETS[name], steps=30)
    assert walked.hybrid.outcome == "finished"
    assert_agreement(walked)
    assert_same_steps(walked)


@pytest.mark.slow
@pytest.mark.parametrize("seed", range(30))
def test_closed_loop_walks_agree_on_random_ground(seed: int, controller: AdaptiveController) -> None:
    """A third of it smooth between its breaks, the rest rough. Where they part there must be a cause."""
    walked = mjbiped.compare(controller, Terrain.random(seed=seed, roughness=0.002 * (seed % 3)), steps=20)
    if walked.divergence is not None:
        assert walked.divergence.causes, walked.verdict
    assert_agreement(walked)


@pytest.mark.slow
@pytest.mark.parametrize("name", ["level", "stairs"])
def test_plain_steps_agree_as_well(name: str, controller: AdaptiveController) -> None:
    """Step length, softness and qacc MuJoCo's own: "With plain steps" of docs/convergence.md, in short."""
    terrain = {"level": Terrain.level(), "stairs": Terrain.stairs(rise=-0.06, count=3)}[name]
    plain = mjbiped.Mujoco(timestep=1e-4, lands=False)
    there = mjbiped.walk(controller, terrain, steps=5, engine=plain, sample_period=None)
    here = mjbiped.walk(controller, terrain, steps=5, engine="hybrid", sample_period=None)
    assert there.outcome == here.outcome == "finished"
    # a touchdown is felt up to a step of 0.1 ms late; 0.16 ms a step was the most on any ground, 0.03 mm, 0.31 %
    np.testing.assert_allclose(measures.step_periods(there), measures.step_periods(here), rtol=0, atol=3e-4)
    np.testing.assert_allclose(measures.step_lengths(there), measures.step_lengths(here), rtol=0, atol=1e-4)
    assert np.abs(measures.impact_errors(there)).max() < 5e-3
    # 0.28 % and 0.05 N m on the worst ground of the page; 0.11 % and 0.04 N m here
    assert there.cost_of_transport == pytest.approx(here.cost_of_transport, rel=4e-3)
    np.testing.assert_allclose(there.peak_torque, here.peak_torque, rtol=0, atol=0.1)


@pytest.mark.slow
def test_a_threshold_of_the_law_parts_walks_that_agree_without_it(controller: AdaptiveController) -> None:
    """The greatest difference of c_mt found on rough ground, 1 %: a step that begins 0.01 off the cycle, or nearly."""
    terrain = Terrain.random(seed=1260, roughness=0.001)
    parted = mjbiped.compare(controller, terrain, steps=12)
    assert parted.divergence is not None
    assert "at touchdown 8 the controller plans the new step in one engine alone" in parted.verdict
    assert parted.mujoco.cost_of_transport < 0.995 * parted.hybrid.cost_of_transport
    walked = mjbiped.compare(replace(controller, replanning_threshold=0.009), terrain, steps=12)
    assert_same_steps(walked)
    assert walked.mujoco.cost_of_transport == pytest.approx(walked.hybrid.cost_of_transport, rel=0.002)
