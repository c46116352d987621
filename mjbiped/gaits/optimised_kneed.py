"""Optimised references of the biped with knees: two branches, one with the swing knee bent and one with it straight.

A controller follows the branch of the knee that the robot has at the moment, whenever its knee strikes: both branches
reach over the whole step and beyond.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from mjbiped.gaits.bezier import NODES, curve, in_pieces, powers_through
from mjbiped.gaits.branches import Branched
from mjbiped.gaits.found import Found
from mjbiped.gaits.hold import acceleration_decays, hold, pieces_of
from mjbiped.gaits.kneed_step import KNEE_STRIKE, KneedStep, flexion_points
from mjbiped.gaits.optimisation import Goal, Motion, Solution
from mjbiped.robots.chain import Array
from mjbiped.robots.kneed import KneedBiped

_STEP, _BENT = 25, 22  # pieces of a step, and those of them before the knee strike: KNEE_STRIKE of them


@dataclass(frozen=True, eq=False, repr=False)
class OptimisedKneedGait(Found, Branched):
    """An optimised gait with knees on level ground, made by `find_reference`.

    States are the angles of stance leg, swing thigh and swing shank, rad, then their rates, rad/s.

    Beyond the knee strike the branch of the bent knee drives on past the stop, as fast as the knee has closed. Before
    it, the branch of the straight knee is that of the legs with the change of rates that the strike makes. Beyond the
    period the swing leg comes to rest, and the stance leg goes on at an even rate, until it has fallen 60 degrees.

    Attributes:
        robot: Whose gait it is.
        goal: What was asked for: speed (m/s), clearance (m), retraction, torque_limit (N m) and friction.
        slope: Of the ground, 0.
        start: State just after a heel strike, both knees straight, shape (6,).
        end: State just before the next heel strike, shape (6,); the robot's heel impact leads from it to `start`.
        period: Time between heel strikes, s.
        step_length: Distance between the feet then, m.
        knee_strike: Time at which the swing knee strikes its stop, s.
        knee_state: State just before that, shape (6,).
        knee_flexion: Numbers that the flexion's Bézier curve is made of, rad, shape (5,).
        clearance_phase: Phase of the step, 0 to 1, until which the swing foot has its clearance, and from which on with
            retraction it goes no further forward.
        control_points: Of the Bézier curves of stance leg and swing thigh, rad, shape (8, 2).
        rate: Pieces of the branches per second.
        bent: The branch of the bent knee, polynomials of degree 9 in each piece's own coordinate from 0 to 1, lowest
            power first: shape (pieces, 10, 3), rad.
        straight: The branch of the straight knee, stance and swing leg: shape (pieces, 10, 2).
    """

    robot: KneedBiped
    goal: Goal
    slope: float
    start: Array
    end: Array
    period: float
    step_length: float
    knee_strike: float
    knee_state: Array
    knee_flexion: Array
    clearance_phase: float
    control_points: Array
    rate: float
    bent: Array
    straight: Array

    @property
    def model(self) -> KneedStep:
        """The robot's step as the optimiser takes it."""
        return KneedStep(self.robot)

    @property
    def own(self) -> Array:
        """The flexion's numbers."""
        return self.knee_flexion


def kneed_gait(robot: KneedBiped, goal: Goal, solution: Solution) -> OptimisedKneedGait:
    """A solution of the optimiser as a gait, its branches cut into pieces."""
    model, points, period = KneedStep(robot), solution.points, solution.period
    motion = Motion(np.array(solution.half), points, solution.own, np.array(period))
    groups = math.ceil(pieces_of(period, robot.leg_length, robot.gravity) / _STEP)
    count, until = _STEP * groups, _BENT * groups
    width, strike = period / count, KNEE_STRIKE * period
    (q0, q1), (dq0, dq1), (_, ddq1) = curve(points, np.array([0.0, 1.0]), period)
    (knee_q,), (knee_dq,), (knee_ddq,) = model.bent(motion, np.array([KNEE_STRIKE]))
    legs = in_pieces(points, count)

    flexion = in_pieces(flexion_points(solution.own), until)[..., 0]
    closing, slowing = knee_dq[2] - knee_dq[1], knee_ddq[2] - knee_ddq[1]
    base = np.concatenate([legs, hold(q1, dq1, ddq1, width, count)])
    beyond = [width * (k + NODES) for k in range(len(base) - until)]
    driven = [powers_through(closing * t + slowing * acceleration_decays(t, width)) for t in beyond]
    shank = base[..., 1] + np.concatenate([flexion, driven])

    change = model.knee_strike(motion)
    early = [change * (width * (k + NODES) - strike)[:, None] for k in range(until)]
    phases = [(k + NODES) / count for k in range(until, count)]
    locked = np.stack([powers_through(model.straight(motion, each).q) for each in phases])
    (q,), (dq,), (ddq,) = model.straight(motion, np.array([1.0]))
    made = OptimisedKneedGait(
        robot=robot,
        goal=goal,
        slope=0.0,
        start=np.concatenate([q0, q0[1:], dq0, dq0[1:]]),
        end=np.concatenate([q, q[1:], dq, dq[1:]]),
        period=period,
        step_length=float(model.step_length(np.array(solution.half))),
        knee_strike=strike,
        knee_state=np.concatenate([knee_q, knee_dq]),
        knee_flexion=solution.own,
        clearance_phase=solution.clearance_phase,
        control_points=points,
        rate=count / period,
        bent=np.concatenate([base, shank[..., None]], axis=-1),
        straight=np.concatenate(
            [legs[:until] + np.stack([powers_through(each) for each in early]), locked, hold(q, dq, ddq, width, count)]
        ),
    )
    for array in (made.start, made.end, made.knee_state, made.knee_flexion, points, made.bent, made.straight):
        array.flags.writeable = False
    return made
