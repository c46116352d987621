"""What the hybrid engine works on: the constants of a simulation, and the buffers of one walk.

Everything is plain numbers in flat sequences: lists and tuples in plain Python, arrays where compiled.
"""

from __future__ import annotations

from typing import Any, NamedTuple

from mjbiped.disturbances.pushes import Pushes
from mjbiped.numerics.dormand_prince import STAGES_WITH_DENSE
from mjbiped.records.pressure import BINS

_NAMED = 92
# indices in the scalars `w`
(
    CLOCK,  # time of the last support transfer, s
    STANCE,  # 0 left, 1 right
    SLOPE,  # of the ground under the stance foot, rad
    SINE,
    COSINE,
    FOOT_X,  # stance foot, m
    FOOT_Z,
    FOOT_SEGMENT,  # of the terrain, that it stands on
    CONTACT_ENABLED,  # 1: the swing foot collides
    SEGMENT,  # of the terrain, under the swing foot when last looked at: where the search begins
    FACE,  # the swing foot slides on a vertical face: 1 ahead of it, -1 behind it, 0 not
    FACE_X,  # of the last face struck in this step, or of the one that the foot stood beside before it, m; NaN: none
    FACE_TOP,  # its upper edge, m
    FACE_SEGMENT,  # terrain segment on the foot's side of it
    LANDING,  # terrain segment of the touchdown last found
    GROUND,  # 1: the swing foot, which could not take the robot over where it came down, slides on the ground
    GROUND_SEGMENT,  # of the terrain where it last did in this step; -1: nowhere
    PUSHED_X,  # direction in which the face or that ground pushes the foot
    PUSHED_Z,
    PRESS,  # force with which it does, N
    AFTER,  # the law is asked for times of [AFTER, BEFORE] only: on one side of its breaks
    BEFORE,
    ANKLE,  # torques last computed, N m: of all joints, one after the other
    HIP,
    KNEE,
    STAGE,  # stages of this integration step at which the law has been asked
    STAGE_ANKLE,  # greatest magnitudes at the stages of a step
    STAGE_HIP,
    STAGE_KNEE,
    WHEN_ANKLE,  # their times since the support transfer, s
    WHEN_HIP,
    WHEN_KNEE,
    KEPT_ANKLE,  # both, while the law is asked again for what lies within the step
    KEPT_HIP,
    KEPT_KNEE,
    KEPT_WHEN_ANKLE,
    KEPT_WHEN_HIP,
    KEPT_WHEN_KNEE,
    PEAK_ANKLE,  # since the start
    PEAK_HIP,
    PEAK_KNEE,
    FRICTION,  # greatest |F_t / F_n| of this step
    NORMAL_FORCE,  # least F_n of this step, N; below zero the ground would have to pull
    NORMAL_NOW,  # F_n when last looked at, N
    ALONG_NOW,  # F_t there
    IMPULSE_X,  # of the ground on the stance foot in the impact that has led to the state, N s
    IMPULSE_Z,
    PRESSURE_AHEAD,  # greatest distances of the centre of pressure from the ankle in this step, m
    PRESSURE_BEHIND,
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
    LOCKED,  # the swing knee: 0 free, 1 locked since it has struck its stop, 2 straight and resting on the stop
    STOP_PRESS,  # there: acceleration with which the knee would bend forwards if there were no stop, rad/s^2
    FLEXION,  # greatest of the swing knee in this step, rad
    STUBS,  # of the swing foot in this step
    TOE,  # 1: the walk ended with a foot that came down, and could not take the robot over
    STRIKE_TIME,  # of the knee strike, since the support transfer, s; NaN without one
    STRIKE_Q,  # angles and rates just before it, and rates just after it, one after the other
    STRIKE_Q2,
    STRIKE_Q3,
    STRIKE_DQ,
    STRIKE_DQ2,
    STRIKE_DQ3,
    STRUCK_DQ,
    STRUCK_DQ2,
    STRUCK_DQ3,
    STANCE_FLEXION,  # of the stance knee, at which it is locked, rad
) = range(_NAMED)
ANKLE_TORQUES = _NAMED  # of the stages of an integration step, N m: the first of them
PRESSURE_TIMES = ANKLE_TORQUES + STAGES_WITH_DENSE  # by places of the centre of pressure, s; see `records.pressure`
SCALARS = PRESSURE_TIMES + BINS


KNEE_FREE, KNEE_LOCKED, KNEE_RESTING = 0.0, 1.0, 2.0
"""Values of `LOCKED`."""

ANGLES_AND_RATES = 4
"""Of the compass biped. The state y: angles, rates, the controller's integrated states, net work of each joint in this
gait step."""


class Laws(NamedTuple):
    """The functions of a walk: the controller's, the integrator of states of its size, and the robot's.

    Those of the robot stand in `mjbiped.engines.hybrid.compass` and `mjbiped.engines.hybrid.kneed`. What they call the
    pose is a tuple of sines and cosines, so that each is taken once.

    Attributes:
        torque: See `controllers.Law`.
        touchdown: The same.
        slope_estimate: The same.
        next_discontinuity: The same.
        tick: The same.
        knee_strike: The same.
        begin: See `dormand_prince.Integrator`.
        step: The same.
        dense: The same.
        rates: Of a state, for the integrator.
        asked: (torque, parameters, memory, t, state) -> torques of all joints.
        ticked: (tick, parameters, memory, t, state).
        pose: (buffers, state) -> pose.
        pose_between: (buffers, share) -> pose within the step, of its dense output.
        swing_foot: (constants, buffers, pose) -> place x, z, m.
        foot_speed: (constants, buffers, pose) -> its rates at the step's end, m/s.
        foot_rush: (constants, buffers, place in k, state) -> bound of its acceleration, m/s^2.
        hip: (constants, buffers, pose) -> place x, z, m.
        force_at: (constants, buffers, pose, state, place in k) -> force of the ground, forward and upward, N.
        force_within: (constants, buffers, pose, share, h) -> the same within the step, the state in `spare`.
        hit_face: (constants, buffers) -> impulse, N s. A vertical face stops the swing foot: rates in `y`.
        lands: (constants, buffers) -> bool. Whether a foot that has come down takes the robot over.
        stub: (constants, buffers) -> impulse, N s. It does not: the ground stops it, and it slides; NaN: it falls.
        transfer: (laws, parameters, constants, buffers, segment, x) -> None. Impact map, new roles, touchdown, row.
        write_state: (constants, buffers, row, time, state, estimate) -> None, with the torques in `w`.
        stops: (constants, buffers) -> bool. Whether the swing knee is beyond its stop at the step's end.
        stop_gap: (buffers) -> flexion and its rate at the step's end.
        stopped_within: (buffers, share) -> bool. Whether it is beyond the stop there.
        strike_stop: (laws, parameters, constants, buffers, t) -> None. The knee's impact on its stop.
        note: (laws, parameters, constants, buffers, t, h) -> None. What the robot's rows tell of an accepted step.
    """

    torque: Any
    touchdown: Any
    slope_estimate: Any
    next_discontinuity: Any
    tick: Any
    knee_strike: Any
    begin: Any
    step: Any
    dense: Any
    rates: Any
    asked: Any
    ticked: Any
    pose: Any
    pose_between: Any
    swing_foot: Any
    foot_speed: Any
    foot_rush: Any
    hip: Any
    force_at: Any
    force_within: Any
    hit_face: Any
    lands: Any
    stub: Any
    transfer: Any
    write_state: Any
    stops: Any
    stop_gap: Any
    stopped_within: Any
    strike_stop: Any
    note: Any


class SimulationConstants(NamedTuple):
    """Robot, ground, rules and limits.

    Attributes:
        robot: Constants of the robot that walks, as its functions take them.
        angles: Number of its angles.
        joints: Number of its joints with motors.
        length: Of a leg, m.
        mass: Of the robot, kg.
        gravity: m/s^2.
        x: Starts of the terrain's segments, m.
        z: Heights there, m.
        gradient: dz/dx.
        angle: Slopes, rad.
        contact: 1: the swing foot collides from the step's first moment on; 0: the scuffing rule says when.
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

    robot: Any
    angles: int
    joints: int
    length: float
    mass: float
    gravity: float
    x: Any
    z: Any
    gradient: Any
    angle: Any
    contact: float
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
        rows: Touchdowns, one row each, in the order of the robot's `columns.tables_of`.
        samples: Samples, one row each: those of the robot's columns, then the controller's states.
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
