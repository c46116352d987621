"""What the hybrid engine works on: the constants of a simulation, and the buffers of one walk.

Everything is plain numbers in flat sequences: lists and tuples in plain Python, arrays where compiled.
"""

from __future__ import annotations

from typing import Any, NamedTuple

from mjbiped.disturbances.pushes import Pushes
from mjbiped.robots.compass import Constants

# indices in the scalars `w`
(
    CLOCK,  # time of the last support transfer, s
    STANCE,  # 0 left, 1 right
    SLOPE,  # of the ground under the stance foot, rad
    SINE,
    COSINE,
    FOOT_X,  # stance foot, m
    FOOT_Z,
    CONTACT_ENABLED,  # 1: the swing foot collides
    SEGMENT,  # of the terrain, under the swing foot when last looked at: where the search begins
    FACE,  # the swing foot slides on a vertical face: 1 ahead of it, -1 behind it, 0 not
    FACE_X,  # of the last face struck in this step, m; NaN without one
    FACE_TOP,  # its upper edge, m
    FACE_SEGMENT,  # terrain segment on the foot's side of it
    LANDING,  # terrain segment of the touchdown last found
    PRESS,  # force on the face, N
    AFTER,  # the law is asked for times of [AFTER, BEFORE] only: on one side of its breaks
    BEFORE,
    ANKLE,  # torques last computed, N m
    HIP,
    STAGE_ANKLE,  # greatest magnitudes at the stages of a step
    STAGE_HIP,
    WHEN_ANKLE,  # their times since the support transfer, s
    WHEN_HIP,
    PEAK_ANKLE,  # since the start
    PEAK_HIP,
    FRICTION,  # greatest |F_t / F_n| of this step
    NORMAL_FORCE,  # least F_n of this step, N; below zero the ground would have to pull
    FACE_IMPACTS,  # 1: one in this step
    WORK_ABSOLUTE,  # since the start, J
    WORK_NET,
    WORK_POSITIVE,
    DENSE,  # 1: the dense output of the current step is there
    NEXT_STEP,  # length of the next integration step, s
    FIRST_STEP,  # so long may the first one of a gait step be, s: no longer than one that was tried in vain
    SAMPLE,  # number of the next sample
    SAMPLES,  # rows in the buffer of samples
    ROWS,  # rows in the buffer of touchdowns
    COUNT,  # touchdowns since the start
    TIME,  # now, s
    OUTCOME,
    NEXT_TICK,  # of a controller that ticks, s; infinity: it does not
    PUSH,  # force at the hip along x, N
    PUSHING,  # 1: a push is under way, be it of no force
    NEXT_PUSH,  # when it ends, or when the next one begins, s
    PUSH_IMPULSE,  # of this one, or of the next one, N s
    PUSHES,  # that have ended
    EVALUATIONS,  # of the law, since the start
    PAUSE,  # so many of them bring the engine back to Python, wherever it is
    UNDER_WAY,  # 1: it came back in the middle of a gait step
    ELAPSED,  # there: time since the support transfer, s
    LIMIT,  # there: time up to which the law is smooth, s
    STEP_STARTED,  # evaluations at the gait step's beginning
    LOOK,  # so many of them, and the gait step's progress is looked at
    LOOKED,  # time since the support transfer when it was looked at, s
) = range(54)
SCALARS = 54

ANGLES_AND_RATES = 4
WORKS = 2
"""The state y: q1, q2, dq1, dq2, the controller's integrated states, net work of ankle and hip in this gait step."""


class Laws(NamedTuple):
    """The functions of a walk: the controller's, and the integrator of states of its size.

    Attributes:
        torque: See `controllers.Law`.
        touchdown: The same.
        slope_estimate: The same.
        next_discontinuity: The same.
        tick: The same.
        begin: See `dormand_prince.Integrator`.
        step: The same.
        dense: The same.
    """

    torque: Any
    touchdown: Any
    slope_estimate: Any
    next_discontinuity: Any
    tick: Any
    begin: Any
    step: Any
    dense: Any


class SimulationConstants(NamedTuple):
    """Robot, ground, rules and limits.

    Attributes:
        robot: Lumped constants of the robot that walks.
        length: Of a leg, m.
        mass: Of the robot, kg.
        gravity: m/s^2.
        x: Starts of the terrain's segments, m.
        z: Heights there, m.
        gradient: dz/dx.
        angle: Slopes, rad.
        reach: Scuffing rule, m.
        delay: Scuffing rule, s.
        stall_time: Longest time without touchdown, s.
        end: Ground ends here, x in m.
        steps: Touchdowns after which the walk is finished.
        distance: Position of the stance foot at which it is finished, x in m.
        tolerance: Of the integrator's steps.
        longest_step: The longest of them, s.
        sample_period: s.
        control_period: Time between two ticks of a controller that ticks, s.
        pushes: At the hip.
    """

    robot: Constants
    length: float
    mass: float
    gravity: float
    x: Any
    z: Any
    gradient: Any
    angle: Any
    reach: float
    delay: float
    stall_time: float
    end: float
    steps: float
    distance: float
    tolerance: float
    longest_step: float
    sample_period: float
    control_period: float
    pushes: Pushes


class Buffers(NamedTuple):
    """Memory of one walk.

    Attributes:
        y: State at the current step's start; see `ANGLES_AND_RATES`.
        out: State at its end.
        spare: A state in between.
        k: Rates at the step's stages.
        dense: Its dense output.
        w: Scalars, at the indices above.
        memory: The controller's.
        rows: Touchdowns, one row each, in the order of `columns.TOUCHDOWNS`.
        samples: Samples, one row each: those of `columns.SAMPLES`, then the controller's states.
    """

    y: Any
    out: Any
    spare: Any
    k: Any
    dense: Any
    w: Any
    memory: Any
    rows: Any
    samples: Any
