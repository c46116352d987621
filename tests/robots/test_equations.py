"""The robots' equations and impacts in random states: against those of free rigid bodies (`free_bodies`)."""

from collections.abc import Iterator
from typing import Any, NamedTuple

import numpy as np
import pytest
from engines.conformance.free_bodies import Array, FreeRobot
from engines.conformance.test_impacts import LOCKED, missed
from simulations import UNEQUAL

import mjbiped
from mjbiped.dynamics.linkage import END, Motion, ground_force, momentum, point, room, speed, stand
from mjbiped.dynamics.modes import bend_stance_knee, bent_leg, land
from mjbiped.robots import model as functions
from mjbiped.robots.compass import acceleration, legs_of, swing_foot
from mjbiped.robots.kneed import KneedLegs, stance_knee_torque
from mjbiped.robots.robot import Robot

ROBOTS: dict[str, Robot] = {
    "compass": mjbiped.Compass(),
    "heavy hip": mjbiped.Compass(hip_mass=10.0, leg_inertia=0.0),
    "moon": mjbiped.Compass(leg_mass=3.1, hip_mass=7.3, lower_length=0.37, upper_length=0.58, gravity=1.62),
    "knees": mjbiped.KneedBiped(),
    "halved rods": mjbiped.KneedBiped.halved_rods(),
    "unequal links": UNEQUAL,
    "round": mjbiped.RoundCompass(hip_mass=3.0, foot_radius=0.3),
    "round knees": mjbiped.RoundKneed(hip_mass=3.0, stop_angle=0.3, shank_offset=0.03, foot_radius=0.17),
    "wheel": mjbiped.RimlessWheel(mass=3.0, inertia=0.7, length=0.8, spokes=6, gravity=3.7),
}
SEGMENTS = {2: [0, 0, 1, 1], 3: [0, 0, 1, 2], 4: [0, 1, 2, 3]}
"""With which angle the segments of a robot with knees move, from its stance shank to its swing shank."""
ROUNDING = 1e-12
"""Of some hundred operations, of the greatest term."""
CONDITION = 1e3
"""Greatest number by which solving for rates multiplies it."""


class Standing(NamedTuple):
    """A state of a robot, and of its free bodies.

    Attributes:
        q: Angles, rad.
        dq: Rates, rad/s.
        slope: Of the ground, rad.
        bent: Flexion of the stance knee, rad.
        bodies: The free bodies.
        qpos: Their posture.
        v: Its rates.
        moves: Motions of the posture that each angle makes, shape (len(qpos), n).
        stays: Accelerations of the posture while the rates of the angles stay.
    """

    q: Array
    dq: Array
    slope: float
    bent: float
    bodies: FreeRobot
    qpos: Array
    v: Array
    moves: Array
    stays: Array

    def force(self, ddq: Array) -> Array:
        """What the posture's forces have to be, N and N m: those along x and z are the ground's."""
        a = self.moves @ ddq + self.stays
        return self.bodies.mass_matrix(self.qpos) @ a + self.bodies.bias(self.qpos, self.v)

    def on_ground(self, of: Any) -> list[float]:
        """A vector x + i z, along the ground and normal to it."""
        turned = of * np.exp(1j * self.slope)
        return [turned.real, turned.imag]


def states(robot: Robot, n: int, count: int = 20, *, struck: bool = False) -> Iterator[Standing]:
    """Random states of n angles; `struck`: the swing knee is straight."""
    bodies, draw = FreeRobot(robot), np.random.default_rng(11 + n)
    for _ in range(count):
        q, dq, slope = draw.uniform(-1.5, 1.5, n), draw.uniform(-5.0, 5.0, n), float(draw.uniform(-0.5, 0.5))
        bent = float(draw.choice([0.0, draw.uniform(0.05, 1.2)])) if robot.lands_bent else 0.0
        moving, angles = np.eye(n), q
        if isinstance(robot, KneedLegs):
            moving = np.eye(n)[SEGMENTS[n]]
            if struck:
                q[2] = q[1]
            angles = np.array([q[0], *q[-2:]] if n > 2 else q[[0, 1, 1]])
            if n == 4:
                _, lean = bent_leg(robot.thigh_length, robot.shank_length, bent)
                q[:2] = angles[0] + lean, angles[0] + lean - bent
        centre = robot.radius * q[0] * np.exp(-1j * slope)
        qpos = np.array(robot.posture((centre.real, centre.imag), 0, angles + slope, bent))
        v, moves = bodies.rates(qpos, 0, moving @ dq, slope), bodies.motions(qpos, 0, moving, slope)
        held, stays = bodies.ends[0].bend(qpos, v), np.zeros(len(qpos))
        stays[:2] = -held.real, -held.imag
        yield Standing(q, dq, slope, bent, bodies, qpos, v, moves, stays)


def motion_of(robot: Robot, at: Standing) -> Motion:
    """The motion that an engine computes with, in the state."""
    motion = Motion(free=len(at.q), sine=np.sin(at.slope), cosine=np.cos(at.slope), **room())
    if at.bent:
        bend_stance_knee(motion, robot.bodies.leg[0].length, robot.bodies.leg[1].length, at.bent)
    stand(robot.linkages[0], motion)
    return motion


def close(found: object, wanted: object, scale: float) -> None:
    """Check for equality but for rounding of numbers of this size."""
    np.testing.assert_allclose(np.asarray(found), np.asarray(wanted), rtol=0, atol=ROUNDING * scale)


@pytest.mark.parametrize(("name", "n"), [(name, n) for name, robot in ROBOTS.items() for n in robot.chains])
def test_equations_of_motion(name: str, n: int) -> None:
    robot = ROBOTS[name]
    for at in states(robot, n):
        chain, still = robot.chains_on(at.bent)[n], np.zeros_like(at.v)
        q, dq, slope = at.q, at.dq, at.slope
        M, pull = at.moves.T @ at.bodies.mass_matrix(at.qpos) @ at.moves, at.moves.T @ at.force(np.zeros(n))
        size = float(np.abs(M).sum())
        moments = robot.weight * robot.leg_length
        scale = size * (1.0 + float(dq @ dq)) + moments
        close(chain.mass_matrix(q), M, size)
        close(chain.pull(q, dq, slope), pull, scale)
        close(chain.gravity_vector(q, slope), at.moves.T @ at.bodies.bias(at.qpos, still), moments)
        ahead, behind = (chain.mass_matrix(q + h * dq) for h in (1e-5, -1e-5))
        C = chain.coriolis_matrix(q, dq)
        np.testing.assert_allclose((ahead - behind) / 2e-5, C + C.T, atol=1e-7 * scale)  # differences of 1e-5
        energy, upright = (at.bodies.energy(at.qpos, v) for v in (at.v, still))
        close(chain.kinetic_energy(q, dq), energy - upright, scale)
        close(chain.potential_energy(q, slope), upright, moments)
        foot, end = (end.place(at.qpos) for end in at.bodies.ends[:2])
        close(chain.end(q), at.on_ground(end - foot), robot.leg_length)
        ddq = np.linalg.solve(M, -pull)
        close(chain.accelerations(np.zeros(n), q, dq, slope), ddq, CONDITION * float(np.abs(ddq).max()))
        if n < 4:
            close(chain.free_motion(q.tolist(), dq.tolist(), slope), ddq, CONDITION * float(np.abs(ddq).max()))
        close(chain.ground_force(q, dq, dq[::-1], slope), at.force(dq[::-1])[:2], scale + robot.weight)


@pytest.mark.parametrize("name", ROBOTS)
def test_touchdowns_are_plastic_impacts(name: str) -> None:
    """Of the struck leg, rigid as it is; of the other one, whose knee may open on round feet; and their impulse."""
    robot, n = ROBOTS[name], len(ROBOTS[name].angles)
    for at in states(robot, n):
        after = robot.rates_after_touchdown(at.q, at.dq, at.bent)
        opens = robot.knee_opens and after[2] > after[1]
        free = LOCKED if n == 3 and not opens else np.eye(n)
        change = at.bodies.rates(at.qpos, 1, after, at.slope) - at.v
        size = CONDITION * float(np.abs(np.append(after, at.dq)).max())
        close(missed(at.bodies, at.qpos, change, at.bodies.motions(at.qpos, 1, free, at.slope)), 0.0, size)
        linkage, motion = robot.linkages[0], motion_of(robot, at)
        along, normal, leaves = land(linkage, linkage, motion, [*at.q, *at.dq], not opens)
        impulse = at.on_ground(at.bodies.momentum(at.qpos, change))
        close([along, normal], impulse, robot.weight * robot.leg_length * size)
        if name != "wheel":
            left = at.on_ground(at.bodies.ends[0].jacobian(at.qpos) @ (at.v + change))
            close(leaves, left[1], robot.leg_length * size)
        if isinstance(robot, mjbiped.Compass):
            q, dq = robot.impact(at.q, at.dq)
            np.testing.assert_array_equal(q, at.q[::-1])
            close(dq, after, size)
        if not at.bent and not robot.radius:
            close(functions.rates_after_touchdown(robot.model, at.q.tolist(), at.dq.tolist()), after, size)


@pytest.mark.parametrize("name", [name for name, robot in ROBOTS.items() if isinstance(robot, KneedLegs)])
def test_a_knee_that_strikes_is_locked_by_an_impulse(name: str) -> None:
    robot = ROBOTS[name]
    assert isinstance(robot, KneedLegs)
    for at in states(robot, 3, struck=True):
        if at.bent:
            continue
        q, after = robot.knee_impact(at.q, at.dq)
        np.testing.assert_array_equal(q, at.q[:2])
        change = at.bodies.rates(at.qpos, 0, LOCKED @ after, at.slope) - at.v
        size = CONDITION * float(np.abs(at.dq).max())
        close(missed(at.bodies, at.qpos, change, at.bodies.motions(at.qpos, 0, LOCKED, at.slope)), 0.0, size)
        if not robot.radius:
            close(functions.rates_after_knee_strike(robot.model, at.q.tolist(), at.dq.tolist()), LOCKED @ after, size)


@pytest.mark.parametrize("name", ["knees", "halved rods", "unequal links"])
@pytest.mark.parametrize("locked", [False, True])
def test_what_the_ground_and_the_stance_knee_bear(name: str, locked: bool) -> None:
    """Of the torque: the thigh's that turns its shank back by as much."""
    robot, torque = ROBOTS[name], np.array([3.0, -7.0, 1.5])
    assert isinstance(robot, KneedLegs)
    for at in states(robot, 2 if locked else 3):
        q, dq = (np.append(each, each[1:]) if locked else each for each in (at.q, at.dq))
        shank, forces = at.bodies.motions(at.qpos, 0, np.eye(4)[:, :1], at.slope)[:, 0], robot.input_matrix @ torque
        M = at.moves.T @ at.bodies.mass_matrix(at.qpos) @ at.moves
        pull = (LOCKED.T @ forces if locked else forces) - at.moves.T @ at.force(np.zeros(len(at.q)))
        borne = at.force(np.linalg.solve(M, pull))
        scale = CONDITION * (1.0 + float(np.abs(borne).max()))
        options: Any = {"locked": locked, "stance_flexion": at.bent}
        close(robot.flexion(at.qpos, [0, 1]), [at.bent, q[2] - q[1]], 1.0)
        close(robot.ground_force(q, dq, torque, at.slope, **options), borne[:2], scale)
        close(stance_knee_torque(robot, q, dq, torque, at.slope, **options), torque[0] - shank @ borne, scale)


@pytest.mark.parametrize("name", ROBOTS)
def test_places_speeds_and_the_force_of_the_ground(name: str) -> None:
    robot = ROBOTS[name]
    for at in states(robot, len(robot.angles)):
        ends = np.array([end.place(at.qpos) for end in at.bodies.ends])
        close(robot.leg_ends(at.qpos), np.stack([ends.real, ends.imag], axis=-1), robot.leg_length)
        assert robot.total_mass == pytest.approx(sum(mass for mass, *_ in at.bodies.parts), rel=1e-15)
        centre = sum(mass * centre.place(at.qpos) for mass, _, centre, _ in at.bodies.parts) / robot.total_mass
        close(robot.centre_of_mass(at.qpos), [centre.real, centre.imag], robot.leg_length)
        linkage, motion, state = robot.linkages[0], motion_of(robot, at), (at.q.tolist(), at.dq.tolist())
        close(point(linkage, motion, state[0], END), at.on_ground(complex(ends[1] - ends[0])), robot.leg_length)
        size, moved = 1.0 + float(at.dq @ at.dq), at.bodies.ends[1].jacobian(at.qpos) @ at.v
        close(speed(linkage, motion, *state, END), at.on_ground(moved), robot.leg_length * size)
        close(momentum(linkage, motion, *state), at.on_ground(at.bodies.momentum(at.qpos, at.v)), robot.weight * size)
        along, upward = at.force(at.dq)[:2]
        found = ground_force(linkage, motion, *state, state[1])
        close(found, at.on_ground(complex(along, upward)), robot.weight * size)


@pytest.mark.parametrize("name", [name for name, robot in ROBOTS.items() if not robot.radius])
def test_functions_for_laws_are_the_robots_methods(name: str) -> None:
    robot = ROBOTS[name]
    for at in states(robot, len(robot.angles)):
        q, dq, model = at.q.tolist(), at.dq.tolist(), robot.model
        size, weight = float(np.abs(model.weights).max()), float(np.abs(model.moments).max())
        close(functions.mass_matrix(model, q), robot.mass_matrix(q), size)
        close(functions.coriolis_matrix(model, q, dq), robot.coriolis_matrix(q, dq), 8.0 * size)
        close(functions.gravity_vector(model, q, at.slope), robot.gravity_vector(q, at.slope), weight)
        if isinstance(robot, mjbiped.Compass):
            force = np.array([3.0, -2.0])
            found = acceleration(robot.constants, *(*q, *dq, np.sin(at.slope), np.cos(at.slope), *force))
            wanted = robot.chains[2].accelerations(force, at.q, at.dq, at.slope)
            close(found, wanted, 30.0 * float(np.abs(wanted).max()))
            close(swing_foot(robot.leg_length, legs_of(*q)), robot.swing_foot(q), robot.leg_length)


def test_bodies_are_those_of_the_parameters() -> None:
    """Mass, length, way down to the centre of mass, inertia, turn and offset of each segment, numbers by hand."""
    told = {
        "moon": [(3.1, 0.95, 0.58, 3.1 * 0.95**2 / 12, 0.0, 0.0)],
        "unequal links": [(3.1, 0.37, 0.11, 0.05, 0.0, 0.0), (1.7, 0.58, 0.23, 0.021, 0.0, 0.0)],
        "halved rods": [(2.5, 0.5, 0.25, 2.5 / 48, 0.0, 0.0)] * 2,
        "wheel": [(3.0, 0.8, 0.0, 0.7, 0.0, 0.0)],
    }
    for name, segments in told.items():
        found = [segment[1:7] for segment in ROBOTS[name].bodies.leg]
        np.testing.assert_allclose(found, segments, rtol=1e-15)
    assert [ROBOTS[name].bodies.hip_mass for name in told] == [7.3, 7.3, 0.0, 0.0]
    thigh, shank = ROBOTS["round knees"].bodies.leg
    # of equal angles of both legs' lines, from the hip to the arc's centre, which is level with the other one
    assert thigh.turn - shank.turn == pytest.approx(0.3)
    line = thigh.length * np.exp(1j * thigh.turn) + (shank.length - 0.17) * np.exp(1j * shank.turn)
    assert line == pytest.approx(ROBOTS["round knees"].leg_length - 0.17, abs=1e-15)
