"""Setup of a walk in the hybrid engine: its constants and its first state."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Any, TypeAlias

import numpy as np

from mjbiped.control.controller import ROOM as SPARE
from mjbiped.control.controller import Controller, Law
from mjbiped.control.functions import in_python
from mjbiped.disturbances.chance import following
from mjbiped.disturbances.loop import SampledController
from mjbiped.dynamics.integrate import POWERS, STAGES_WITH_DENSE
from mjbiped.dynamics.linkage import ROOM, room
from mjbiped.dynamics.modes import FREE, LOCKED, RESTING
from mjbiped.engines.hybrid.motion import enter_mode
from mjbiped.engines.hybrid.resets import POSTURE, SAMPLE, TOUCHDOWN, begin_gait_step
from mjbiped.engines.hybrid.state import Constants, State, pushes_at
from mjbiped.engines.plan import Plan
from mjbiped.records.loads import BINS
from mjbiped.robots.robot import Robot
from mjbiped.rules.scuffing import ScuffingRule
from mjbiped.rules.sole import servo_gains
from mjbiped.rules.termination import STALL_TIME
from mjbiped.terrain.profile import Profile
from mjbiped.terrain.terrain import Terrain

LONGEST_STEP = 0.22  # longest integration step, in sqrt(l / g): the only limit that passive walking needs
FIRST_STEP = 0.1  # length of the first trial step, in the same units
ROWS = 1024  # touchdowns between updates of the progress bar, some 20 ms
_STALLS = 10  # number of longest gait steps whose samples fit in the buffer

Place: TypeAlias = tuple[float, float, int]
"""Of a stance foot: x and z, m, and the terrain's segment."""


def robot_constants(robot: Robot) -> dict[str, Any]:
    """The fields of `Constants` that say what a robot is."""
    bodies, linkages = robot.bodies, list(robot.linkages)
    foot, angles, joints = bodies.foot, linkages[0].angles, len(robot.joints)
    pace = math.sqrt(robot.leg_length / robot.gravity)
    behind, ahead = (robot.sole if foot is None else None) or (math.inf, math.inf)
    stiffness, damping = servo_gains(foot.inertia if foot else 0.0, robot.leg_length, robot.gravity)
    return {
        "linkages": linkages,
        "angles": angles,
        "joints": joints,
        "told": len(robot.angles),
        "thigh": min(1, angles - 1),
        "shank": 2 if linkages[0].knees else min(1, angles - 1),
        "foot": -1 if foot is None else angles - 2,
        "upper": bodies.leg[0].length,
        "lower": bodies.leg[-1].length,
        "between": robot.between,
        "knee_opens": robot.knee_opens,
        "lands_bent": robot.lands_bent,
        "length": robot.leg_length,
        "behind": behind,
        "ahead": ahead,
        "heel": 0.0 if foot is None else foot.behind,
        "toe": 0.0 if foot is None else foot.ahead,
        "height": foot_height(robot),
        "foot_stiffness": stiffness,
        "foot_damping": damping,
        "weight": robot.weight,
        "legs": len(bodies.limbs),
        "contact": robot.collides_from_lift_off,
        "pace": pace,
        "stall_time": STALL_TIME * pace,
        "longest_step": LONGEST_STEP * pace,
    }


def law_constants(functions: Law, robot: Robot, states: int, support: int) -> dict[str, object]:
    """The fields that say what the engine calls, and how large a state of motion is.

    Args:
        functions: What the engine calls of the law, and what it passes to it.
        robot: The robot.
        states: Number of the law's integrated states.
        support: Index in its memory of how far the sole bears; -1: none.
    """
    angles, joints = robot.linkages[0].angles, len(robot.joints)
    judged = 2 * angles + states
    told = -1 if robot.bodies.foot is None else support
    sizes = {"states": states, "size": judged + joints, "judged": judged, "given": joints + states + SPARE}
    return {**functions._asdict(), **sizes, "support": told}


def ground_constants(ground: Profile, slopes: Sequence[float], end: float) -> dict[str, object]:
    """The fields that say what the ground is: its profile as the feet meet it, its slopes (rad), and its end (m)."""
    profile = {name: list(getattr(ground, name)) for name in ("x", "z", "gradient")}
    return {**profile, "segments": len(ground.x), "angle": list(slopes), "end": float(end)}


def buffer_constants(rows: int, samples: int, states: int, period: float) -> dict[str, object]:
    """The fields of the record: buffers for so many touchdowns and samples, and the time between two of these, s."""
    width = SAMPLE.width + states
    return {
        "row_buffer": np.full((rows, TOUCHDOWN.width), np.nan),
        "row_room": rows,
        "sample_buffer": np.full((samples, width), np.nan),
        "sample_room": samples,
        "sample_width": width,
        "sample_period": period,
    }


def rule_constants(robot: Robot, rule: ScuffingRule, steps: float | None, distance: float | None) -> dict[str, object]:
    """The fields that say when the swing foot collides, and after how many steps, or where (m), the walk ends."""
    return {
        "reach": rule.reach * robot.leg_length,
        "delay": float(rule.delay),
        "steps": math.inf if steps is None else float(steps),
        "distance": math.inf if distance is None else float(distance),
    }


def state_of(c: Constants, y: Sequence[float], memory: Sequence[float], place: Place, next_tick: float) -> State:
    """Make the first state of a walk.

    Args:
        c: Its constants.
        y: Angles, rad, and rates, rad/s.
        memory: The controller's, with its integrated states first.
        place: Of the stance foot: x and z, m, and the terrain's segment.
        next_tick: Time of the controller's first tick, s; infinity where it does not tick.
    """
    n, slope = c.angles, c.angle[place[2]]
    push, impulse = following(pushes_at(c.pushes, 0), 0, 0.0)
    straight = y[c.thigh] == y[c.shank] and y[n + c.thigh] == y[n + c.shank]
    rooms: dict[str, Any] = {
        **room(),
        **{name: [0.0] * c.size for name in ("out", "spare")},
        **{name: [0.0] * STAGES_WITH_DENSE for name in ("asked", "normals", "moments")},
        **{name: [0.0] * ROOM for name in ("q", "dq", "peak_torque", "strike_q", "strike_dq", "struck_dq")},
        **{name: [0.0] * c.told for name in ("told", "told_rates", "told_before")},
    }
    state = State(
        **rooms,
        sine=math.sin(slope),
        cosine=math.cos(slope),
        y=[*y, *memory[: c.states], *[0.0] * c.joints],
        k=[[0.0] * c.size for _ in range(STAGES_WITH_DENSE)],
        dense=[[0.0] * c.size for _ in range(POWERS)],
        memory=list(memory),
        given=[[0.0] * c.given for _ in range(STAGES_WITH_DENSE)],
        sampled=[0.0] * c.given,
        margins=[math.inf] * STAGES_WITH_DENSE,
        pressure=[0.0] * (2 + BINS),
        posture=[0.0] * POSTURE,
        slope=slope,
        foot_x=place[0],
        foot_z=place[1],
        segment=place[2],
        foot_segment=place[2],
        next_tick=next_tick,
        next_push=push,
        push_impulse=impulse,
        next_step=FIRST_STEP * c.pace,
        locked=LOCKED if c.thigh == c.shank else RESTING if straight else FREE,
    )
    enter_mode(c, state)
    begin_gait_step(c, state)
    return state


def walk_of(
    plan: Plan, controller: Controller, tolerance: float, sampled: bool, compiled: bool
) -> tuple[Constants, State]:
    """Constants and first state of a walk, with the left foot at x = 0.

    Args:
        plan: The walk.
        controller: The controller that the engine calls, whose methods are the law of the constants.
        tolerance: Of an integration step.
        sampled: Whether samples are kept.
        compiled: Whether the buffers are for machine code, which returns to Python seldom.
    """
    robot, terms, terrain, states = plan.robot, plan.terms, plan.terrain, len(controller.states)
    ground, height = raised(terrain, foot_height(robot)), foot_height(robot)
    own = robot_constants(robot)
    period = math.inf if terms.sample_period is None or not sampled else float(terms.sample_period)
    longest = 0 if math.isinf(period) else int(own["stall_time"] / period) + 3
    constants = Constants(
        **own,
        **law_constants(in_python(controller), robot, states, controller.support),
        **ground_constants(ground, terrain.angle, terrain.end),
        pushes=[plan.disturbances.schedule],
        **buffer_constants(ROWS if compiled else 1, 1 + (_STALLS if compiled else 2) * longest, states, period),
        **rule_constants(robot, terms.scuffing, terms.steps, terms.distance),
        tolerance=float(tolerance),
        control_period=plan.disturbances.period(None, 0.0),
    )
    q, dq = (tuple(map(float, each)) for each in (plan.q, plan.dq))
    memory = [0.0] * controller.memory_size
    controller.start(memory, q, dq)
    flat, slope = [0.0] * (constants.angles - len(q)), terrain.slope_at(0.0)
    place = height * math.sin(slope), terrain.height_at(0.0) + height * math.cos(slope), int(terrain.segment_at(0.0))
    ticks = isinstance(controller, SampledController)
    return constants, state_of(constants, [*q, *flat, *dq, *flat], memory, place, 0.0 if ticks else math.inf)


def foot_height(robot: Robot) -> float:
    """Height over the ground of what moves as a point foot does, m: a round foot's centre, or the ankle of a foot."""
    foot = robot.bodies.foot
    return robot.radius if foot is None else foot.height


def raised(terrain: Terrain, height: float) -> Profile:
    """The ground as points meet it that are so far from it, m: each segment is moved along its normal.

    Where two segments meet at an angle, and not at a riser, so do they afterwards.
    """
    slant = np.hypot(1.0, terrain.gradients)
    x, z = np.array(terrain.x), terrain.z + height * slant
    if height > 0.0:
        change = np.diff(terrain.gradients)
        meets = (np.array(terrain.rises[1:]) == 0.0) & (change != 0.0)
        x[1:][meets] -= height * (np.diff(slant)[meets] / change[meets])
        z += terrain.gradients * (x - terrain.x)
    return Profile(x.tolist(), z.tolist(), np.asarray(terrain.gradients).tolist(), len(x))
