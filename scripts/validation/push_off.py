"""What a push-off just before the heel strike saves, after Kuo 2002, by the laws of impact of this laboratory.

On level ground a walk of one speed and step loses energy at its heel strikes. A hip's torque gives back all that an
unaided strike takes. An impulse along the trailing leg just before the strike, which turns the hip's velocity upward,
makes the strike take less: with massless legs the impulse's work is 1 / (4 cos^4 alpha) of the hip's, a quarter for
short steps, where 2 alpha is the angle between the legs.
"""

from __future__ import annotations

import math

import numpy as np
import scipy

from mjbiped.dynamics.linkage import END, MASS
from mjbiped.robots.round import RoundCompass

LIGHT_LEGS = RoundCompass(leg_mass=1e-9, hip_mass=1.0, lower_length=0.5, upper_length=0.5, foot_radius=0.0, gravity=1.0)
TABLE_ONE = RoundCompass(foot_radius=0.0)
HALVES = (0.05, 0.1, 0.2, 0.3)
"""Half of the angle between the legs, rad."""


def closed_form(half: float) -> float:
    """Ratio of the push-off's work to that of the hip's torque with massless legs."""
    return 0.25 / math.cos(half) ** 4


def pushed(robot: RoundCompass, half: float, rate: float, impulse: float) -> tuple[float, float]:
    """Push off along the trailing leg before the heel strike of legs that turn at one rate.

    Args:
        robot: On point feet.
        half: Half of the angle between the legs, rad.
        rate: Of both legs before it, rad/s.
        impulse: Along the trailing leg, N s.

    Returns:
        Work of the impulse, and kinetic energy after the heel strike, J.
    """
    linkage, q = robot.linkages[0], np.array([half, -half])
    moments, reach = (np.array(linkage.levers[point]) for point in (MASS, END))
    # coordinates are the stance foot's place and the angles of both legs
    free = np.zeros((4, 4))
    free[:2, :2], free[2:, 2:] = linkage.mass * np.eye(2), linkage.even * np.cos(q[:, None] - q)
    free[:2, 2:] = moments * np.cos(q), -moments * np.sin(q)
    free[2:, :2] = free[:2, 2:].T
    before = np.array([0.0, 0.0, rate, rate])
    along = np.array([math.sin(half), math.cos(half), 0.0, 0.0])  # of the trailing leg
    change = np.linalg.solve(free, impulse * along)
    work = 0.5 * impulse * float(along @ change)  # the foot stood before
    # the foot that strikes stands from now on
    stands = np.hstack([np.eye(2), [reach * np.cos(q), -reach * np.sin(q)]])
    equations = np.block([[free, -stands.T], [stands, np.zeros((2, 2))]])
    after = np.linalg.solve(equations, [*(free @ (before + change)), 0.0, 0.0])[[3, 2]]
    return work, robot.kinetic_energy(q[::-1], after)


def ratio(robot: RoundCompass, half: float) -> float:
    """Work of the push-off over that of the hip's torque, on one walk: one rate before the strike, one step."""
    rate = 1.0
    energy = robot.kinetic_energy([half, -half], [rate, rate])
    _, unaided = pushed(robot, half, rate, 0.0)
    enough = robot.total_mass * robot.leg_length * rate
    impulse = scipy.optimize.brentq(lambda p: pushed(robot, half, rate, p)[1] - energy, 0.0, enough, xtol=1e-15)
    work, _ = pushed(robot, half, rate, float(impulse))
    return work / (energy - unaided)
