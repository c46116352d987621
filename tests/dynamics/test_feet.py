"""Feet that turn about an edge, and that land on one: against SymPy's derivation from the places of the bodies."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from functools import cache
from typing import Any

import numpy as np
import pytest
import sympy as sp
from hypothesis import example, given
from hypothesis import strategies as st
from lagrange import lagrange
from simulations import hybrid_run

import mjbiped
from mjbiped.control.controller import Unpowered
from mjbiped.dynamics.linkage import BASE
from mjbiped.dynamics.modes import FLAT, HEEL, TOE
from mjbiped.engines.hybrid.impacts import lay_flat, set_down, stop_swing_foot
from mjbiped.engines.hybrid.motion import enter_mode, rates, stance_force
from mjbiped.engines.hybrid.resets import exchange_legs
from mjbiped.engines.hybrid.state import Constants, State, swing_foot
from mjbiped.robots.chain import Array
from mjbiped.rules.sole import GREATEST_ERROR
from mjbiped.terrain.profile import GROUND_FRICTION

ROUNDING = 1e-10
"""Of some hundred operations, and of a system of eight equations with a foot of a thousandth of the legs' inertia."""

ROBOT = mjbiped.FootedCompass(
    leg_mass=4.0, hip_mass=3.0, lower_length=0.55, upper_length=0.4, sole=(0.07, 0.15), foot_mass=0.3, ankle_height=0.06
)
MODES = pytest.mark.parametrize("down", [TOE, HEEL])
STANCES = st.sampled_from([FLAT, TOE, HEEL])
ANGLES = st.tuples(*[st.floats(-0.4, 0.4)] * 3)
RATES = st.tuples(*[st.floats(-3.0, 3.0)] * 4)
TORQUES = st.tuples(st.floats(-20.0, 20.0), st.floats(-20.0, 20.0))
CHANGES, SLOPES = st.floats(0.005, 0.15), st.floats(-0.3, 0.3)
TILTS = st.tuples(*[st.floats(-0.8, 0.8)] * 3)
TURNS = st.tuples(*[st.floats(-5.0, 5.0)] * 3)
LEVEL = mjbiped.Terrain.level()
EDGES = pytest.mark.parametrize("edge", [TOE, HEEL])
RELATIVE = 1e-12
"""Rounding of some hundred operations, of the largest term."""
CONDITION = 30.0
"""By how much solving for rates multiplies it: the foot's line is short (measured: 5)."""


@cache
def derived(edge: int, down: int) -> dict[str, Callable[..., Any]]:
    """Mass matrix, forces of gravity and rates, and the edge that is down.

    The coordinates are x, z of the point on which the stance foot stands, then the angles of stance leg, swing leg,
    stance foot and swing foot from the vertical.
    """
    x, v = sp.Matrix(sp.symbols("x:6")), sp.Matrix(sp.symbols("v:6"))
    foot, leg = ROBOT.foot, ROBOT.bodies.leg[0]

    def along(angle: sp.Expr, distance: float, beside: float = 0.0) -> sp.Matrix:
        up = sp.Matrix([sp.sin(angle), sp.cos(angle)])
        return distance * up + beside * sp.Matrix([sp.cos(angle), -sp.sin(angle)])

    beside = {TOE: foot.ahead, HEEL: -foot.behind}
    ankle = sp.Matrix(x[:2]) + (along(x[4], foot.height, -beside[edge]) if edge != FLAT else sp.zeros(2, 1))
    hip = ankle + along(x[2], leg.length)
    end = hip - along(x[3], leg.length)
    landing = end - along(x[5], foot.height, -beside[down]) if down != FLAT else end
    bodies = [
        (foot.mass, foot.inertia, v[4], ankle),
        (leg.mass, leg.inertia, v[2], hip - along(x[2], leg.centre)),
        (ROBOT.hip_mass, 0, 0, hip),
        (leg.mass, leg.inertia, v[3], hip - along(x[3], leg.centre)),
        (foot.mass, foot.inertia if down != FLAT else 0.0, v[5], end),  # in the air parallel to the other one
    ]
    laws, rows = lagrange(x, v, bodies, ROBOT.gravity), landing.jacobian(x)
    rest = laws["h"] + laws["g"]
    found = {"M": laws["M"], "rest": rest, "rows": rows, "turning": (rows * v).jacobian(x) * v, "hip": hip.jacobian(x)}
    return {name: sp.lambdify([x, v], expression, cse=True) for name, expression in found.items()}


def tipped(edge: int, slope: float, y: Sequence[float], **more: Any) -> tuple[Constants, State]:
    """The robot on a slope and on an edge, in a state."""
    run = hybrid_run(Unpowered(), LEVEL, robot=ROBOT, q=(0.0, 0.0), dq=(0.0, 0.0), steps=1, compile=False)
    c, w = run.constants, run.state
    w.edge, w.slope, w.sine, w.cosine, w.before = edge, slope, math.sin(slope), math.cos(slope), math.inf
    for name, value in more.items():
        setattr(w, name, value)
    w.y[:8] = [*map(float, y[:3]), y[2], *map(float, y[3:]), y[5]]
    enter_mode(c, w)
    return c, w


def walker(down: int, edge: int, change: float, q: Any, dq: Any) -> tuple[Constants, State]:
    """The robot whose swing foot comes down on ground that is steeper, or less steep, than that of its stance foot."""
    ground = mjbiped.Terrain.from_segments([(5.0, 1.0, 0.0), (5.0, 1.0 - down * math.degrees(change), 0.0)])
    run = hybrid_run(Unpowered(), ground, robot=ROBOT, q=(0.0, 0.0), dq=(0.0, 0.0), steps=1, compile=False)
    c, w = run.constants, run.state
    w.landing, w.edge, w.down, w.before = 1, edge, FLAT, math.inf
    tip = q[2] if edge != FLAT else 0.0
    w.y[:8] = [q[0], q[1], tip, tip, dq[0], dq[1], dq[2] * abs(edge), dq[2] * abs(edge)]
    enter_mode(c, w)
    return c, w


def coordinates(c: Constants, w: State) -> tuple[Array, Array]:
    """Those of `derived`, with the stance foot at rest."""
    angles = np.array(w.y[:4]) + w.slope
    return np.array([0.0, 0.0, *angles]), np.array([0.0, 0.0, *w.y[4:8]])


def ground(c: Constants, w: State) -> tuple[Array, Array]:
    """Tangent and normal of the ground on which the foot lands."""
    slope = c.angle[1]
    return np.array([math.cos(slope), -math.sin(slope)]), np.array([math.sin(slope), math.cos(slope)])


@MODES
@given(edge=STANCES, q=ANGLES, dq=RATES, change=CHANGES, torques=TORQUES)
def test_a_landing_foot_moves_as_lagrange_and_coulomb_say(
    down: int, edge: int, q: Any, dq: Any, change: float, torques: Any
) -> None:
    c, w = walker(down, edge, change, q, dq)
    w.down = down
    enter_mode(c, w)
    w.y[3], w.y[7] = down * change + q[2], dq[3]
    c.torque = lambda *arguments: arguments[-1].__setitem__(slice(2), torques)
    changes = [0.0] * c.size
    rates(c, w, 0.0, w.y, changes)
    x, v = coordinates(c, w)
    laws, (tangent, normal) = derived(edge, down), ground(c, w)
    M, rest, rows = np.array(laws["M"](x, v)), np.array(laws["rest"](x, v))[:, 0], np.array(laws["rows"](x, v))
    error, rate = w.y[3] - w.y[2], w.y[7] - w.y[6]
    servo = c.foot_stiffness * np.clip(error, -GREATEST_ERROR, GREATEST_ERROR) + c.foot_damping * rate
    asked = np.array([0.0, 0.0, torques[0] - torques[1], torques[1] + servo, -torques[0], -servo])
    slip = float(tangent @ rows @ v)
    push = w.press * (normal - GROUND_FRICTION * slip / math.hypot(slip, 1e-3) * tangent)
    accelerations = np.array([0.0, 0.0, *changes[4:8]])
    terms = np.abs(M) @ np.abs(accelerations) + np.abs(rest) + np.abs(rows.T) @ np.abs(push) + np.abs(asked)
    residual = M @ accelerations + rest - asked - rows.T @ push
    held = [] if edge != FLAT else [4]  # a flat foot is held by a moment of the ground
    moving = [i for i in (2, 3, 4, 5) if i not in held]
    np.testing.assert_allclose(residual[moving], 0.0, atol=ROUNDING * terms.max())
    np.testing.assert_allclose(accelerations[held], 0.0, atol=ROUNDING * np.abs(accelerations).max())
    edge_rate = normal @ (rows @ accelerations + np.array(laws["turning"](x, v))[:, 0])
    np.testing.assert_allclose(edge_rate, 0.0, atol=ROUNDING * (np.abs(rows) @ np.abs(accelerations)).max())
    along, up = stance_force(c, w, w.y[:4], w.y[4:8], changes[4:8])
    force = [along * w.cosine + up * w.sine, up * w.cosine - along * w.sine]
    np.testing.assert_allclose(force, residual[:2], atol=ROUNDING * terms.max())


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
    before = coordinates(c, w)[1]
    w.y[3] = slope - w.slope + tilt
    x, v = coordinates(c, w)
    if ground(c, w)[1] @ np.array(derived(edge, down)["rows"](x, v)) @ v > -1e-3:
        return  # it does not come down
    assert set_down(c, w)
    assert w.y[3] == pytest.approx(slope - w.slope + tilt, abs=1e-9)
    x, v = coordinates(c, w)
    laws, (tangent, normal) = derived(edge, down), ground(c, w)
    M, rows = np.array(laws["M"](x, v)), np.array(laws["rows"](x, v))
    change_of = M @ (v - before)
    moving = [2, 3, 5] if edge == FLAT else [2, 3, 4, 5]
    impulse, *_ = np.linalg.lstsq(rows.T[moving], change_of[moving], rcond=None)
    scale = np.abs(M).max() * (1.0 + np.abs(v).max() + np.abs(before).max())
    np.testing.assert_allclose(rows.T[moving] @ impulse, change_of[moving], atol=ROUNDING * scale)  # of the edge alone
    speed, along = rows @ v, float(tangent @ impulse)
    speeds = 1.0 + np.abs(v).max() + np.abs(before).max()
    assert normal @ speed == pytest.approx(0.0, abs=ROUNDING * speeds)
    if abs(along) < (GROUND_FRICTION - 1e-6) * abs(normal @ impulse):
        assert tangent @ speed == pytest.approx(0.0, abs=ROUNDING * speeds)
    else:
        assert abs(along) == pytest.approx(GROUND_FRICTION * abs(normal @ impulse), rel=1e-6, abs=ROUNDING * scale)
    stance = change_of[:2] - impulse  # what the stance foot has given
    found = [
        w.impulse_along * w.cosine + w.impulse_normal * w.sine,
        w.impulse_normal * w.cosine - w.impulse_along * w.sine,
    ]
    np.testing.assert_allclose(found, stance, atol=ROUNDING * scale)


def moved(c: Constants, w: State, torques: tuple[float, float]) -> tuple[Array, Array]:
    """Accelerations of the state under torques, and the force of the ground, forward and upward."""
    c.torque = lambda *arguments: arguments[-1].__setitem__(slice(2), torques)
    changes = [0.0] * c.size
    rates(c, w, 0.0, w.y, changes)
    along, normal = stance_force(c, w, w.y[:4], w.y[4:8], changes[4:8])
    return np.array(changes[4:7]), np.array([along * w.cosine + normal * w.sine, normal * w.cosine - along * w.sine])


def free(q: Any, dq: Any, slope: float) -> tuple[Array, Array]:
    """The coordinates of `derived`, with the edge at rest; a swing foot in the air is parallel to the other one."""
    return np.array([0.0, 0.0, *(np.array(q) + slope), 0.0]), np.array([0.0, 0.0, *dq, 0.0])


def constrained(edge: int, x: Array, v: Array, rows: Array) -> Array:
    """Rates after a plastic impact that brings rows . v to zero, by Lagrange's multipliers."""
    M, k = np.array(derived(edge, FLAT)["M"](x, v))[:5, :5], len(rows)
    whole = np.block([[M, rows[:, :5].T], [rows[:, :5], np.zeros((k, k))]])
    return np.linalg.solve(whole, np.concatenate([M @ v[:5], np.zeros(k)]))[:5]


def agree(found: Any, expected: Any, scale: Any) -> None:
    """Check for equality but for rounding of numbers as large as the scale."""
    np.testing.assert_allclose(found, expected, rtol=0.0, atol=RELATIVE * float(np.max(np.abs(scale))))


@EDGES
@given(q=TILTS, dq=TURNS, slope=SLOPES, torques=TORQUES, push=st.floats(-9, 9))
def test_accelerations_and_the_force_of_the_ground_are_lagranges(
    edge: int, q: Any, dq: Any, slope: float, torques: tuple[float, float], push: float
) -> None:
    c, w = tipped(edge, slope, [*q, *dq], push=push)
    ddq, force = moved(c, w, torques)
    x, v = free(q, dq, slope)
    laws = derived(edge, FLAT)
    M, rest = np.array(laws["M"](x, v)), np.array(laws["rest"](x, v))[:, 0]
    forces = push * np.array(laws["hip"](x, v))[0] + [0.0, 0.0, torques[0] - torques[1], torques[1], -torques[0], 0.0]
    residual = M @ [0.0, 0.0, *ddq, 0.0] + rest - forces
    terms = np.abs(M) @ [0.0, 0.0, *np.abs(ddq), 0.0] + np.abs(rest)
    agree(residual[2:], 0.0, terms)  # the equations of motion, with the edge held
    agree(force, residual[:2], terms)  # what holds the edge


@EDGES
@given(q=TILTS, dq=TURNS, slope=SLOPES)
def test_a_foot_comes_down_flat_as_multipliers_say(edge: int, q: Any, dq: Any, slope: float) -> None:
    q = np.array([q[0], q[1], 0.0])
    c, w = tipped(edge, slope, [*q, *dq])
    lay_flat(c, w)
    x, v = free(q, dq, slope)
    after = constrained(edge, x, v, np.eye(6)[[0, 1, 4]])
    agree(w.y[4:6], after[2:4], CONDITION * (1.0 + np.abs(dq)))
    assert (w.y[2], w.y[6], w.edge, w.levers[BASE][2], w.levers[BASE + 1][2]) == (0.0, 0.0, FLAT, 0.0, 0.0)


@EDGES
@given(q=TILTS, dq=TURNS, slope=SLOPES, new=SLOPES)
def test_the_other_foot_lands_while_this_one_has_tipped(edge: int, q: Any, dq: Any, slope: float, new: float) -> None:
    c, w = tipped(edge, slope, [*q, *dq])
    exchange_legs(c, w, new)
    x, v = free(q, dq, slope)
    after = constrained(edge, x, v, np.array(derived(edge, FLAT)["rows"](x, v)))
    speeds = CONDITION * (1.0 + np.abs(dq))
    agree([w.y[5], w.y[4]], after[2:4], speeds)
    agree(np.array(w.y[:3]) + new, [q[1] + slope, q[0] + slope, new], 1.0)
    assert w.edge == FLAT


@EDGES
@given(q=TILTS, dq=TURNS, slope=SLOPES)
def test_a_face_stops_the_swing_foot_along_its_normal(edge: int, q: Any, dq: Any, slope: float) -> None:
    c, w = tipped(edge, slope, [*q, *dq], pushed_x=-1.0, pushed_z=0.0)
    stop_swing_foot(c, w)
    impulse = w.right[w.size]
    x, v = free(q, dq, slope)
    end = np.array(derived(edge, FLAT)["rows"](x, v))
    after = constrained(edge, x, v, np.vstack([np.eye(6)[:2], end[:1]]))
    speeds = CONDITION * (1.0 + np.abs(dq))
    agree(w.y[4:7], after[2:], speeds)
    M = np.array(derived(edge, FLAT)["M"](x, v))[:5, :5]
    agree((M @ (after - v[:5]))[2:], -impulse * end[0, 2:5], np.abs(M) * speeds.max())
