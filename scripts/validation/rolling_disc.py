"""A wheel that rolls upright in space: from which speed on does it stay upright?

A thin wheel of mass m, radius r and inertia k m r^2 about its diameters (k = 1/4 for a uniform disc, 1/2 for a hoop)
rolls without slip on a level plane. A small tilt θ, from a start without tilt and yaw, obeys

    (1 + k) θ'' = (g/r - 2 (1 + 2 k) v^2/r^2) θ,

so that the wheel is stable from v^2 = g r / (2 + 4 k) on: g r/3, or g r/4 (Routh, Advanced Rigid Dynamics, article 244;
O'Reilly 1996, The dynamics of rolling disks and sliding disks, Nonlinear Dynamics 10, 287-305).

Robots in space hold their yaw, and this wheel steers itself by its yaw: their linkage cannot describe the wheel. So a
free rigid body stands in for the linkage, whose three rows of no slip the multiplier solve of all robots holds.
"""

from __future__ import annotations

import math
from collections.abc import Callable

import mujoco
import numpy as np
import scipy

from mjbiped.robots.compass import Array

MASS, RADIUS, GRAVITY = 2.0, 0.3, 9.81
WHEELS = {"uniform disc": 0.25, "hoop": 0.5}
"""Inertia about a diameter over m r^2."""
NUDGE, SPAN = 1e-4, 1.0
"""Rate of the tilt at the start, rad/s, and the time after which the tilt is looked at, s."""
TIMESTEP = 1e-4
SCENE = """
<mujoco>
  <option timestep="{timestep}" cone="elliptic" gravity="0 0 -{gravity}"/>
  <worldbody>
    <geom type="plane" size="0 0 1"/>
    <body pos="0 0 {radius}">
      <freejoint/>
      <inertial pos="0 0 0" mass="{mass}" diaginertia="{across} {along} {across}"/>
      <geom type="ellipsoid" size="{radius} 1e-3 {radius}" priority="1" friction="0.8 0 0" solref="-1e3 -{damping}"
        solimp="0.9999 0.9999 0.001"/>
    </body>
  </worldbody>
</mujoco>
"""
"""The wheel with the contacts of the robots' feet."""


def critical_speed(k: float) -> float:
    """From which on an upright wheel is stable, m/s; k is its inertia about a diameter over m r^2."""
    return math.sqrt(GRAVITY * RADIUS / (2.0 + 4.0 * k))


def inertia(k: float) -> Array:
    """About the wheel's axes, of which the second is its axle, kg m^2."""
    return k * MASS * RADIUS**2 * np.array([1.0, 2.0, 1.0])


def accelerations(turning: Array, axes: Array, k: float) -> Array:
    """Of the centre and of the turning, m/s^2 and rad/s^2, by the multipliers of a contact that does not slip."""
    up, axle = np.array([0.0, 0.0, 1.0]), axes[:, 1]
    moved = np.cross(turning, axle)
    high, rising = up - axle[2] * axle, -moved[2] * axle - axle[2] * moved
    size = np.linalg.norm(high)
    high /= size
    lever, running = -RADIUS * high, -RADIUS / size * (rising - (rising @ high) * high)
    rows = np.hstack([np.eye(3), -np.cross(np.eye(3), lever)])
    spread = axes * inertia(k) @ axes.T
    equations = np.zeros((9, 9))
    equations[:3, :3], equations[3:6, 3:6] = MASS * np.eye(3), spread
    equations[6:, :6], equations[:6, 6:] = rows, -rows.T
    gyroscopic = -np.cross(turning, spread @ turning)
    right = np.concatenate([-MASS * GRAVITY * up, gyroscopic, -np.cross(turning, running)])
    return np.asarray(np.linalg.solve(equations, right)[:6])


def tilt_of_body(k: float, speed: float) -> float:
    """Tilt of the rigid body after the span, rad."""

    def rates(_: float, y: Array) -> Array:
        turning, axes = y[3:6], y[6:].reshape(3, 3)
        return np.concatenate([accelerations(turning, axes, k), np.cross(turning, axes.T).T.ravel()])

    start = np.concatenate([[speed, -NUDGE * RADIUS, 0.0], [NUDGE, speed / RADIUS, 0.0], np.eye(3).ravel()])
    end = scipy.integrate.solve_ivp(rates, (0.0, SPAN), start, "DOP853", rtol=1e-11, atol=1e-12).y[:, -1]
    return math.asin(end[13])


def tilt_in_mujoco(k: float, speed: float) -> float:
    """Tilt of MuJoCo's wheel after the span, rad."""
    across, along, _ = inertia(k)
    scene = SCENE.format(
        timestep=TIMESTEP, gravity=GRAVITY, radius=RADIUS, mass=MASS, across=across, along=along, damping=1.0 / TIMESTEP
    )
    model = mujoco.MjModel.from_xml_string(scene)
    data = mujoco.MjData(model)
    data.qvel[:] = speed, -NUDGE * RADIUS, 0.0, NUDGE, speed / RADIUS, 0.0
    for _ in range(round(SPAN / TIMESTEP)):
        mujoco.mj_step(model, data)
    mujoco.mj_kinematics(model, data)
    return math.asin(data.xmat[1, 7])


PHYSICS = (tilt_of_body, tilt_in_mujoco)


def found(tilt: Callable[[float, float], float], k: float) -> float:
    """Speed at which the tilt grows in proportion to time, neither faster nor slower, m/s."""
    near = critical_speed(k)
    return float(scipy.optimize.brentq(lambda v: tilt(k, v) / (NUDGE * SPAN) - 1.0, 0.8 * near, 1.2 * near, xtol=1e-9))
