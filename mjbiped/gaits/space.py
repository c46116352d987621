"""Passive gaits in space: one step and its mirror image are one gait."""

from __future__ import annotations
import math
from typing import Any
import numpy as np
import scipy
from mjbiped.gaits.cycle import differences, eigenvalues

Array = Any

def start_of(linkage, places):
    """(q1, s, dq1, dq2, ds) -> state with both feet on the plane."""
    q1, s, d1, d2, ds = places
    q2 = math.acos(min(1.0, math.cos(q1) + linkage.width * math.tan(s) / linkage.foot[0]))
    return np.array([q1, q2, s, d1, d2, ds])

def flow(linkage, pull, state, event, span=3.0, tol=1e-12):
    n = len(state) // 2
    zero = np.zeros(n)
    def rates(_, y): return np.concatenate([y[n:], linkage.accelerations(zero, y[:n], y[n:], pull)])
    def ev(_, y): return event(y)
    ev.terminal, ev.direction = True, -1
    sol = scipy.integrate.solve_ivp(rates, (0, span), state, "DOP853", rtol=tol, atol=tol, max_step=0.05, events=[ev], dense_output=True)
    return (sol.t_events[0][0], sol.y_events[0][0], sol) if sol.t_events[0].size else (math.nan, state * math.nan, sol)

def step(robot, pull, places):
    from mjbiped.robots.space import joined
    straight = robot.in_space[2]
    y = start_of(straight, places)
    total = 0.0
    if 3 in robot.in_space:
        free = robot.in_space[3]
        t, e, _ = flow(free, pull, y[[0, 1, 1, 2, 3, 4, 4, 5]], lambda v: v[2] - v[1])
        total += t
        E = np.array([[1,0,0],[0,1,0],[0,1,0],[0,0,1.0]])
        y = np.array([*e[[0,1,3]], *joined(free, E, e[:4], e[4:])])
    else:
        t, y, _ = flow(straight, pull, y, lambda v: v[1] - v[0])
        total += t
    t, e, _ = flow(straight, pull, y, lambda v: straight.swing_foot(v[:3])[2])
    total += t
    q, dq = straight.touchdown(e[:3], e[3:])
    return np.array([q[0], q[2], *dq]), total, e

def find(robot, slope, guess):
    from mjbiped.robots.three_d import pull_of
    pull = pull_of(slope)
    sol = scipy.optimize.root(lambda x: step(robot, pull, x)[0] - x, guess, tol=1e-12, options={"eps": 1e-10})
    x = sol.x
    J = differences(lambda d: step(robot, pull, x + d)[0], 5, 1e-5)
    return x, sol, eigenvalues(J), step(robot, pull, x)
