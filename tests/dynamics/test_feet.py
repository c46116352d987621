"""Feet that turn about an edge, and that land on one: against the equations of free rigid bodies (`free_bodies`)."""

import math
from collections.abc import Sequence
from typing import Any

import numpy as np
import pytest
from engines.conformance.free_bodies import Array, FreeRobot, Point
from hypothesis import example, given
from hypothesis import strategies as st
from simulations import hybrid_run

import mjbiped
from mjbiped.control.controller import Unpowered
from mjbiped.dynamics.linkage import BASE
from mjbiped.dynamics.modes import FLAT, HEEL, TOE
from mjbiped.engines.hybrid.impacts import lay_flat, set_down, stop_swing_foot
from mjbiped.engines.hybrid.motion import enter_mode, rates, stance_force
from mjbiped.engines.hybrid.resets import exchange_legs
from mjbiped.engines.hybrid.state import Constants, State, swing_foot
from mjbiped.rules.sole import GREATEST_ERROR
from mjbiped.terrain.profile import GROUND_FRICTION

ROBOT = mjbiped.FootedCompass(
    leg_mass=4.0, hip_mass=3.0, lower_length=0.55, upper_length=0.4, sole=(0.07, 0.15), foot_mass=0.3, ankle_height=0.06
)
EDGES = pytest.mark.parametrize("edge", [TOE, HEEL])
MODES = pytest.mark.parametrize("down", [TOE, HEEL])
STANCES = st.sampled_from([FLAT, TOE, HEEL])
ANGLES = st.tuples(*[st.floats(-0.4, 0.4)] * 3)
RATES = st.tuples(*[st.floats(-3.0, 3.0)] * 4)
TORQUES = st.tuples(st.floats(-20.0, 20.0), st.floats(-20.0, 20.0))
CHANGES, SLOPES = st.floats(0.005, 0.15), st.floats(-0.3, 0.3)
TILTS = st.tuples(*[st.floats(-0.8, 0.8)] * 3)
TURNS = st.tuples(*[st.floats(-5.0, 5.0)] * 3)
RELATIVE, CONDITION = 1e-12, 30.0
"""Rounding of some hundred operations, of the largest term; and by how much solving for rates multiplies it: the foot's
line is short (measured: 5)."""
LANDING = 1e-10
"""The same of systems of eight equations with a foot of a thousandth of the legs' inertia."""


def edge_of(bodies: FreeRobot, leg: int, edge: int) -> Point:
    """The edge of a leg's foot, or its ankle."""
    ankle, foot = bodies.ends[leg], ROBOT.foot
    if edge == FLAT:
        return ankle
    lever = complex(foot.ahead if edge == TOE else -foot.behind, -foot.height)
    return Point(np.append(ankle.levers, lever), np.vstack([ankle.angles, np.eye(6)[2 + leg] + np.eye(6)[4 + leg]]))


class Held:
    """The free bodies while the stance foot's edge, or its ankle, rests at the origin.

    Args:
        edge: On which the stance foot turns.
        w: The engine's state.
        down: Edge of the swing foot that is down; in the air that foot is parallel to the other one, without inertia.
        leg: Which leg stands.

    Attributes:
        moves: Motions of the posture by the angles of stance leg, swing leg, stance foot and swing foot, shape (6, 4).
        v: Rates of the posture.
        M: Mass matrix of the posture.
        end: Derivatives of the place of the swing foot's edge, or ankle, by those angles, shape (2, 4).
    """

    def __init__(self, edge: int, w: State, down: int = FLAT, leg: int = 0) -> None:
        self.bodies = bodies = FreeRobot(ROBOT)
        if down == FLAT:
            mass, _, ankle, turns = bodies.parts[-1]
            bodies.parts[-1] = mass, 0.0, ankle, turns
        angles, self.rates = np.array(w.y[:4]) + w.slope, np.array(w.y[4:8])
        self.qpos, self.moves = np.array([0.0, 0.0, *angles[:2], *(angles[2:] - angles[:2])]), np.zeros((6, 4))
        pivot, self.tip = edge_of(bodies, leg, edge), edge_of(bodies, 1, down)
        place = pivot.place(self.qpos)
        self.qpos[:2] = -place.real, -place.imag
        self.moves[2:] = [[1, 0, 0, 0], [0, 1, 0, 0], [-1, 0, 1, 0], [0, -1, 0, 1]]
        moved = -pivot.jacobian(self.qpos) @ self.moves
        self.moves[:2] = moved.real, moved.imag
        self.v, self.M = self.moves @ self.rates, bodies.mass_matrix(self.qpos)
        held, end = pivot.bend(self.qpos, self.v), self.tip.jacobian(self.qpos) @ self.moves
        self.stays, self.end = np.array([-held.real, -held.imag, 0.0, 0.0, 0.0, 0.0]), np.array([end.real, end.imag])

    def force(self, ddq: Array) -> Array:
        """What the posture's forces have to be, N and N m, for accelerations of the angles."""
        return np.asarray(self.M @ (self.moves @ ddq + self.stays) + self.bodies.bias(self.qpos, self.v))

    def terms(self, ddq: Array) -> Array:
        """Sizes of what these forces are made of."""
        return np.asarray(np.abs(self.M) @ np.abs(self.moves @ ddq) + np.abs(self.bodies.bias(self.qpos, self.v)))

    def after(self, before: Array, left: Array) -> Array:
        """Rates of the posture after a plastic impact that leaves these motions."""
        return np.asarray(left @ np.linalg.solve(left.T @ self.M @ left, left.T @ self.M @ before))


def state_on(ground: mjbiped.Terrain, y: Sequence[float], **more: Any) -> tuple[Constants, State]:
    """The robot in a state of legs and feet and their rates."""
    run = hybrid_run(Unpowered(), ground, robot=ROBOT, q=(0.0, 0.0), dq=(0.0, 0.0), steps=1, compile=False)
    c, w = run.constants, run.state
    w.before = math.inf
    for name, value in more.items():
        setattr(w, name, value)
    w.y[:8] = [*map(float, y)]
    enter_mode(c, w)
    return c, w


def tipped(edge: int, slope: float, q: Any, dq: Any, **more: Any) -> tuple[Constants, State]:
    """The robot on a slope and on an edge, its swing foot parallel to the other one."""
    turned = {"edge": edge, "slope": slope, "sine": math.sin(slope), "cosine": math.cos(slope)}
    return state_on(mjbiped.Terrain.level(), [*q, q[2], *dq, dq[2]], **turned, **more)


def walker(down: int, edge: int, change: float, q: Any, dq: Any) -> tuple[Constants, State]:
    """The robot whose swing foot comes down on ground that is steeper, or less steep, than that of its stance foot."""
    ground = mjbiped.Terrain.from_segments([(5.0, 1.0, 0.0), (5.0, 1.0 - down * math.degrees(change), 0.0)])
    tip, turning = (q[2], dq[2] * abs(edge)) if edge != FLAT else (0.0, 0.0)
    return state_on(ground, [*q[:2], tip, tip, *dq[:2], turning, turning], landing=1, edge=edge, down=FLAT)


def ground_of(c: Constants) -> tuple[Array, Array]:
    """Tangent and normal of the ground on which the foot lands."""
    sine, cosine = math.sin(c.angle[1]), math.cos(c.angle[1])
    return np.array([cosine, -sine]), np.array([sine, cosine])


def moved(c: Constants, w: State, torques: tuple[float, float]) -> tuple[Array, Array]:
    """Accelerations of the state under torques, and the force of the ground, forward and upward."""
    c.torque = lambda *arguments: arguments[-1].__setitem__(slice(2), torques)
    changes = [0.0] * c.size
    rates(c, w, 0.0, w.y, changes)
    return np.array(changes[4:8]), upright(w, *stance_force(c, w, w.y[:4], w.y[4:8], changes[4:8]))


def upright(w: State, along: float, normal: float) -> Array:
    """A vector along the stance foot's ground and normal to it, as forward and upward."""
    return np.array([along * w.cosine + normal * w.sine, normal * w.cosine - along * w.sine])


def agree(found: Any, expected: Any, scale: Any, relative: float = RELATIVE) -> None:
    """Check for equality but for rounding of numbers as large as the scale."""
    np.testing.assert_allclose(found, expected, rtol=0.0, atol=relative * float(np.max(np.abs(scale))))


@MODES
@given(edge=STANCES, q=ANGLES, dq=RATES, change=CHANGES, torques=TORQUES)
def test_landing_is_newtons_and_coulombs(down: int, edge: int, q: Any, dq: Any, change: float, torques: Any) -> None:
    c, w = walker(down, edge, change, q, dq)
    w.down = down
    enter_mode(c, w)
    w.y[3], w.y[7] = down * change + q[2], dq[3]
    ddq, force = moved(c, w, torques)
    held, (tangent, normal) = Held(edge, w, down), ground_of(c)
    error, rate = w.y[3] - w.y[2], w.y[7] - w.y[6]
    servo = c.foot_stiffness * np.clip(error, -GREATEST_ERROR, GREATEST_ERROR) + c.foot_damping * rate
    asked = np.array([torques[0] - torques[1], torques[1] + servo, -torques[0], -servo])
    slip = float(tangent @ held.end @ held.rates)
    push = w.press * (normal - GROUND_FRICTION * slip / math.hypot(slip, 1e-3) * tangent)
    needed, terms = held.force(ddq), held.terms(ddq)
    scale = terms.max() + np.abs(asked).max() + np.abs(push).max()
    moving = [0, 1, 3] if edge == FLAT else [0, 1, 2, 3]  # a flat foot is held by a moment of the ground
    agree((held.moves.T @ needed - asked - held.end.T @ push)[moving], 0.0, scale, LANDING)
    assert edge != FLAT or abs(ddq[2]) <= LANDING * np.abs(ddq).max()
    bent = held.tip.bend(held.qpos, held.v) + held.tip.jacobian(held.qpos) @ held.stays
    agree(normal @ (held.end @ ddq + [bent.real, bent.imag]), 0.0, (np.abs(held.end) @ np.abs(ddq)).max(), LANDING)
    agree(force, needed[:2] - push, scale, LANDING)


@MODES
@given(edge=STANCES, q=ANGLES, dq=RATES, change=CHANGES)
@example(edge=HEEL, q=(-0.21, -0.19, -0.34), dq=(-1.5, 1.6, 1.2, -2.2), change=0.09)  # a heel that sticks
@example(edge=FLAT, q=(-0.11, 0.24, 0.29), dq=(-1.4, -1.8, -2.8, -2.9), change=0.09)
def test_an_edge_comes_down_as_coulombs_impact_says(down: int, edge: int, q: Any, dq: Any, change: float) -> None:
    c, w = walker(down, edge, change, q, dq)
    tilt = down * change + (q[2] if edge != FLAT else 0.0)
    if tilt * down < 0.01:
        return  # the other edge is the lower one
    foot, slope = ROBOT.foot, c.angle[1]
    reach = foot.ahead if down == TOE else foot.behind
    over = reach * math.sin(abs(tilt)) + foot.height * (math.cos(tilt) - 1.0)  # of the ankle, over a flat foot's
    ankle_x, ankle_z = swing_foot(c, w, w.y)
    w.foot_z += c.z[1] + c.gradient[1] * (ankle_x - c.x[1]) + over / math.cos(slope) - ankle_z
    w.y[3], turned = slope - w.slope + tilt, w.y[3]
    tangent, normal = ground_of(c)
    before = Held(edge, w, down)
    if normal @ before.end @ before.rates > -1e-3:
        return  # it does not come down
    w.y[3] = turned
    assert set_down(c, w)
    assert w.y[3] == pytest.approx(slope - w.slope + tilt, abs=1e-9)
    held = Held(edge, w, down)
    moving = [0, 1, 3] if edge == FLAT else [0, 1, 2, 3]
    changed = held.M @ held.moves @ (held.rates - before.rates)
    impulse, *_ = np.linalg.lstsq(held.end.T[moving], (held.moves.T @ changed)[moving], rcond=None)
    speeds = 1.0 + np.abs(held.v).max() + np.abs(before.v).max()
    scale = np.abs(held.M).max() * speeds
    agree((held.moves.T @ changed - held.end.T @ impulse)[moving], 0.0, scale, LANDING)  # of the edge alone
    speed, along = held.end @ held.rates, float(tangent @ impulse)
    assert normal @ speed == pytest.approx(0.0, abs=LANDING * speeds)
    if abs(along) < (GROUND_FRICTION - 1e-6) * abs(normal @ impulse):
        assert tangent @ speed == pytest.approx(0.0, abs=LANDING * speeds)
    else:
        assert abs(along) == pytest.approx(GROUND_FRICTION * abs(normal @ impulse), rel=1e-6, abs=LANDING * scale)
        assert along * float(tangent @ speed) <= LANDING * scale * speeds
    agree(upright(w, w.impulse_along, w.impulse_normal), changed[:2] - impulse, scale, LANDING)  # of the stance foot


@EDGES
@given(q=TILTS, dq=TURNS, slope=SLOPES, torques=TORQUES, push=st.floats(-9, 9))
def test_accelerations_and_the_force_of_the_ground_are_newtons(
    edge: int, q: Any, dq: Any, slope: float, torques: tuple[float, float], push: float
) -> None:
    c, w = tipped(edge, slope, q, dq, push=push)
    ddq, force = moved(c, w, torques)
    held = Held(edge, w)
    needed, terms = held.force(ddq), held.terms(ddq)
    moves = held.moves @ np.eye(3)[[0, 1, 2, 2]]  # both feet are parallel
    asked = np.array([torques[0] - torques[1], torques[1], -torques[0]]) + push * moves[0]
    agree(moves.T @ needed, asked, terms)  # the equations of motion, with the edge held
    agree(force, needed[:2] - [push, 0.0], terms)  # what holds the edge


@EDGES
@given(q=TILTS, dq=TURNS, slope=SLOPES, new=SLOPES)
def test_impacts_of_a_tipped_robot_are_plastic(edge: int, q: Any, dq: Any, slope: float, new: float) -> None:
    """Its foot comes down flat; the other foot lands; a face stops the swing foot along its normal."""
    speeds = CONDITION * (1.0 + np.abs(dq))
    c, w = tipped(edge, slope, [*q[:2], 0.0], dq)
    held = Held(edge, w)
    lay_flat(c, w)
    agree(w.y[4:6], held.after(held.v, held.moves[:, :2])[2:4], speeds)
    assert (w.y[2], w.y[6], w.edge, w.levers[BASE][2], w.levers[BASE + 1][2]) == (0.0, 0.0, FLAT, 0.0, 0.0)

    c, w = tipped(edge, slope, q, dq)
    held, other = Held(edge, w), Held(FLAT, w, leg=1)
    exchange_legs(c, w, new)
    agree([w.y[5], w.y[4]], held.after(held.v, other.moves[:, :3])[2:4], speeds)
    agree(np.array(w.y[:3]) + new, [q[1] + slope, q[0] + slope, new], 1.0)
    assert w.edge == FLAT

    c, w = tipped(edge, slope, q, dq, pushed_x=-1.0, pushed_z=0.0)
    held = Held(edge, w)
    stop_swing_foot(c, w)
    moves, end = held.moves[:, :3], held.end[0, :3]
    left = np.linalg.svd(end[None])[2][1:].T  # what does not move the foot along the normal
    after = held.after(held.v, moves @ left)
    agree(w.y[4:7], [after[2], after[3], after[2] + after[4]], speeds)
    scale = np.abs(held.M) * speeds.max()
    agree(moves.T @ held.M @ (after - held.v), -w.right[w.size] * end, scale)
