"""What a walk of the hybrid engine begins with: its constants and its first state."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Any

import numpy as np

from mjbiped.disturbances.pushes import following
from mjbiped.disturbances.sampled import SampledController
from mjbiped.dynamics.integrate import POWERS, STAGES_WITH_DENSE
from mjbiped.dynamics.linkage import ROOM, room
from mjbiped.dynamics.modes import FREE, LOCKED, RESTING
from mjbiped.engines.hybrid.motion import enter_mode
from mjbiped.engines.hybrid.records import POSTURE, SAMPLE, TOUCHDOWN
from mjbiped.engines.hybrid.resets import begin_gait_step
from mjbiped.engines.hybrid.state import GIVEN, Constants, State, pushes_of
from mjbiped.engines.plan import Plan
from mjbiped.records.pressure import BINS
from mjbiped.robots.robot import Robot
from mjbiped.rules.termination import STALL_TIME
from mjbiped.terrain.profile import Profile
from mjbiped.terrain.terrain import Terrain

LONGEST_STEP = 0.22  # longest integration step, in sqrt(l / g): the only limit that passive walking needs
FIRST_STEP = 0.1  # length of the first trial step, in the same units


def constants_of(
    plan: Plan,
    functions: dict[str, Any],
    *,
    states: int,
    support: int,
    tolerance: float,
    control_period: float,
    sample_period: float,
    rows: int,
    sampled_steps: int,
) -> Constants:
    """Collect robot, ground, rules and limits of a walk.

    Args:
        plan: The walk.
        functions: What the engine calls of the law, and what it passes to it.
        states: Number of the law's integrated states.
        support: Index in its memory of how far the sole bears; -1: none.
        tolerance: Of an integration step.
        control_period: Time between two ticks, s.
        sample_period: Time between two samples, s; infinity: only the last one is kept.
        rows: Touchdowns for which the buffer has room.
        sampled_steps: Longest gait steps whose samples have room.
    """
    robot, terms = plan.robot, plan.terms
    bodies, pushes, linkages = robot.bodies, plan.disturbances.schedule, list(robot.linkages)
    foot, angles, joints = bodies.foot, robot.linkages[0].angles, len(robot.joints)
    pace = math.sqrt(robot.leg_length / robot.gravity)
    behind, ahead = (robot.sole if foot is None else None) or (math.inf, math.inf)
    ground, knees = raised(plan.terrain, foot_height(robot)), linkages[0].knees
    longest = STALL_TIME * pace
    samples = 1 if math.isinf(sample_period) else 1 + sampled_steps * (int(longest / sample_period) + 3)
    return Constants(
        linkages=linkages,
        angles=angles,
        joints=joints,
        states=states,
        size=2 * angles + states + joints,
        judged=2 * angles + states,
        told=len(robot.angles),
        thigh=min(1, angles - 1),
        shank=2 if knees else min(1, angles - 1),
        foot=-1 if foot is None else angles - 1,
        upper=bodies.leg[0].length,
        lower=bodies.leg[-1].length,
        between=robot.between,
        knee_opens=robot.knee_opens,
        lands_bent=robot.lands_bent,
        support=-1 if foot is None else support,
        segments=len(ground.x),
        x=ground.x,
        z=ground.z,
        gradient=ground.gradient,
        angle=list(plan.terrain.angle),
        push_times=pushes.times.tolist(),
        push_impulses=pushes.impulses.tolist(),
        push_count=len(pushes.times),
        push_duration=pushes.duration,
        push_size=pushes.size,
        push_interval=pushes.interval,
        push_seed_low=pushes.seed[0],
        push_seed_high=pushes.seed[1],
        row_buffer=np.full((rows, TOUCHDOWN.width), np.nan),
        row_room=rows,
        sample_buffer=np.full((samples, SAMPLE.width + states), np.nan),
        sample_room=samples,
        sample_width=SAMPLE.width + states,
        length=robot.leg_length,
        behind=behind,
        ahead=ahead,
        heel=0.0 if foot is None else foot.behind,
        toe=0.0 if foot is None else foot.ahead,
        height=foot_height(robot),
        weight=robot.weight,
        legs=len(bodies.limbs),
        contact=robot.collides_from_lift_off,
        reach=terms.scuffing.reach * robot.leg_length,
        delay=float(terms.scuffing.delay),
        stall_time=longest,
        pace=pace,
        end=float(plan.terrain.end),
        steps=math.inf if terms.steps is None else float(terms.steps),
        distance=math.inf if terms.distance is None else float(terms.distance),
        tolerance=tolerance,
        longest_step=LONGEST_STEP * pace,
        sample_period=sample_period,
        control_period=control_period,
        **functions,
    )


def state_of(plan: Plan, c: Constants, memory: Sequence[float], *, ticks: bool) -> State:
    """Make the initial state, with the left foot at x = 0.

    Args:
        plan: The walk.
        c: Its constants.
        memory: The controller's, with its integrated states first.
        ticks: Whether the controller ticks.
    """
    terrain, n = plan.terrain, c.angles
    flat = [0.0] * (n - len(plan.q))
    y = [*map(float, plan.q), *flat, *map(float, plan.dq), *flat, *memory[: c.states], *[0.0] * c.joints]
    slope, segment = terrain.slope_at(0.0), int(terrain.segment_at(0.0))
    push, impulse = following(pushes_of(c), 0, 0.0)
    straight = y[c.thigh] == y[c.shank] and y[n + c.thigh] == y[n + c.shank] if n > 1 else True
    state = State(
        **room(),
        sine=math.sin(slope),
        cosine=math.cos(slope),
        y=y,
        out=[0.0] * c.size,
        spare=[0.0] * c.size,
        k=[[0.0] * c.size for _ in range(STAGES_WITH_DENSE)],
        dense=[[0.0] * c.size for _ in range(POWERS)],
        memory=list(memory),
        q=[0.0] * ROOM,
        dq=[0.0] * ROOM,
        told=[0.0] * ROOM,
        told_before=[0.0] * ROOM,
        given=[[0.0] * GIVEN for _ in range(STAGES_WITH_DENSE)],
        sampled=[0.0] * GIVEN,
        asked=[0.0] * STAGES_WITH_DENSE,
        normals=[0.0] * STAGES_WITH_DENSE,
        moments=[0.0] * STAGES_WITH_DENSE,
        margins=[math.inf] * STAGES_WITH_DENSE,
        peak_torque=[0.0] * ROOM,
        pressure=[0.0] * (2 + BINS),
        posture=[0.0] * POSTURE,
        strike_q=[0.0] * ROOM,
        strike_dq=[0.0] * ROOM,
        struck_dq=[0.0] * ROOM,
        slope=slope,
        segment=segment,
        foot_x=c.height * math.sin(slope),
        foot_z=terrain.height_at(0.0) + c.height * math.cos(slope),
        foot_segment=segment,
        next_tick=0.0 if ticks else math.inf,
        next_push=push,
        push_impulse=impulse,
        next_step=FIRST_STEP * c.pace,
        locked=LOCKED if c.thigh == c.shank else RESTING if straight else FREE,
    )
    enter_mode(c, state)
    begin_gait_step(c, state)
    return state


def ticks(controller: Any) -> bool:
    """Whether a controller ticks."""
    return isinstance(controller, SampledController)


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
    return Profile(x.tolist(), z.tolist(), np.asarray(terrain.gradients).tolist())
