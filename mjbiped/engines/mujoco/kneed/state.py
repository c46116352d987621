"""What a walk with knees in MuJoCo remembers from one physics step to the next, and what its functions work on.

The memory's first indices are those of the compass biped, `mjbiped.engines.mujoco.contact_events`, where they mean the
same; what knees add stands behind. All of it is plain numbers and arrays: one source runs as Python and compiled.
"""

from __future__ import annotations

import math
from collections.abc import MutableSequence, Sequence
from typing import Any, NamedTuple

from mjbiped.disturbances.pushes import Pushes
from mjbiped.engines.mujoco import contact_events as events
from mjbiped.engines.mujoco.callbacks import Places
from mjbiped.rules.termination import Limits

COORDINATES, ANGLES, JOINTS = 6, 3, 3
X, Z = 0, 1
THIGHS, KNEES = (2, 4), (3, 5)  # of the left and the right leg, in qpos and qvel

_FIRST = events.LAST_TOUCHDOWN  # the compass biped's last row stands from here on
(
    STEPS,  # to be made in one call
    CLOCK,  # now, s
    FOLLOWING,  # length of the next step as planned, s
    KNEE,  # torque of the swing knee that is held, N m
    PEAK_KNEE,  # since the start, N m
    LOCKED,  # 1: the swing knee is
    OPENED,  # 1: it has been bent in this step
    STRIKES_NEXT,  # 1: it strikes its stop in the step to come
    STRUCK,  # 1: it did in the step last resolved
    FLEXION,  # greatest in this step, rad
    TOUCHING,  # 1: the swing foot has not left the ground since it last touched it
    CLEAR,  # its height over the ground, m
    STUBS,  # in this step
    MET,  # segment for which it is written what the swing foot meets; -1: not yet
    BENT,  # 1: the swing knee is locked as it is, for a touchdown in the step to come
    BEND,  # flexion at which it is, rad
    TILT,  # of the line from stance foot to hip, from the stance thigh, rad: 0 where that knee is straight
    REACH,  # length of that line, m
    SHARE,  # of the stance knee's rate in the rate of that line, beside the thigh's: 0 where the knee is locked
    OLD_TILT,  # the same at the observation before
    OLD_SHARE,
    REST,  # flexion at which a servo holds the stance knee, rad
    HOLD,  # its torque, N m
    PEAK_HOLD,  # the greatest in this step, N m
    WORK_HOLD,  # its absolute work since the start, J
    TURNS,  # 1: the joints have turned by motors' work since the last observation
) = range(_FIRST, _FIRST + 26)

(
    Q,  # qpos at the last observation
    RATES,  # their rates then, those of now
    OLD_Q,  # the same at the observation before
    OLD_RATES,
    QVEL,  # `qvel` at the last observation
    QACC,  # accelerations in the step last resolved
    ACCELERATION,  # those of the step before it, where `events.SMOOTH` says so
    LAG,  # what `qvel` lacks to be the rates of now; see `leapfrog`
) = range(TURNS + 1, TURNS + 1 + 8 * COORDINATES, COORDINATES)
"""Each the first of six."""

STRIKE_TIME = LAG + COORDINATES  # of the knee strike, from the support transfer on, s; NaN: there was none
(
    STRIKE_Q,  # angles from the ground's normal just before it, rad
    STRIKE_RATES,  # their rates, rad/s
    STRUCK_RATES,  # and after it
) = range(STRIKE_TIME + 1, STRIKE_TIME + 1 + 3 * ANGLES, ANGLES)
"""Each the first of three."""

SCALARS = STRUCK_RATES + ANGLES


class Links(NamedTuple):
    """A leg's.

    Attributes:
        thigh_length: m.
        shank_length: m.
    """

    thigh_length: float
    shank_length: float


class Motors(NamedTuple):
    """Places in the model, each of the left and of the right leg.

    Attributes:
        ankles: Actuators.
        hip: Actuator.
        knees: Actuators.
        joints: Of the knees.
        locks: Equality constraints.
    """

    ankles: tuple[int, int]
    hip: int
    knees: tuple[int, int]
    joints: tuple[int, int]
    locks: tuple[int, int]


class Constants(NamedTuple):
    """What does not change in a walk while its scene is the same.

    Attributes:
        limits: What the walk is judged by.
        places: In the scene.
        links: Of the robot.
        motors: In the scene.
        gravity: m/s².
        stepped: Whether there are steps in the ground.
        deepest: No foot is deeper in the ground than this in the first step of a contact, m.
        timestep: Longest physics step, s.
        contact_timestep: Of the step that makes an impact, s.
        lands: Whether steps end at strikes; else they all are of one length, and MuJoCo's own.
        control_period: Time between two ticks of the controller, s; 0: it ticks at every physics step.
        sample_period: Time between samples, s.
        states: Number of the controller's integrated states.
        sampled: Whether its law has a tick.
        pushes: At the hip.
        servo: At the stance knee; without stiffness the knee is locked.
    """

    limits: Limits
    places: Places
    links: Links
    motors: Motors
    gravity: float
    stepped: bool
    deepest: float
    timestep: float
    contact_timestep: float
    lands: bool
    control_period: float
    sample_period: float
    states: int
    sampled: bool
    pushes: Pushes
    servo: Any  # `servo.Servo`


class Scene(NamedTuple):
    """MuJoCo's own numbers, as arrays that show its memory, and what is written of the feet's collisions.

    Attributes:
        qpos: Hip x and z, left thigh and knee, right thigh and knee.
        qvel: Their rates.
        qacc: Accelerations.
        ctrl: Torques of the motors.
        qfrc_applied: Forces from outside.
        sensordata: The feet's contacts.
        eq_active: Which knees are locked.
        eq_data: Of the locks, the flexion first at which they hold.
        eq_solref: Softness of the locks.
        jnt_solref: Of the stops.
        geom_solref: Of the feet and of the risers.
        geom_conaffinity: Bits of the feet that a geom can meet.
        ground: The geoms of the ground, ...
        risers: ... and those of them that are risers.
        bits: For each foot and each of these whether they can meet, shape (2, geoms).
    """

    qpos: Any
    qvel: Any
    qacc: Any
    ctrl: Any
    qfrc_applied: Any
    sensordata: Any
    eq_active: Any
    eq_data: Any
    eq_solref: Any
    jnt_solref: Any
    geom_solref: Any
    geom_conaffinity: Any
    ground: Any
    risers: Any
    bits: Any


class Buffers(NamedTuple):
    """What a walk's functions change.

    Attributes:
        u: The memory; see above.
        memory: The controller's.
        rates: Held, of its integrated states.
        samples: To be filled, shape (room, columns and states).
        rows: Of touchdowns, shape (room, columns).
        scene: MuJoCo's arrays.
        machine: What the stages of a step are called with.
    """

    u: MutableSequence[float]
    memory: MutableSequence[float]
    rates: MutableSequence[float]
    samples: Any
    rows: Any
    scene: Scene
    machine: Any


class Parts(NamedTuple):
    """A controller's functions, as `mjbiped.control.adapters.LAWS` has them, and the stages of a step.

    Attributes:
        torque: See `controllers.Law`.
        touchdown: The same.
        slope_estimate: The same.
        next_discontinuity: The same.
        tick: The same.
        knee_strike: The same.
        position: (machine) -> None. Contacts and constraints are made.
        velocity: (machine) -> None. What depends on rates.
        forces: (machine) -> None. Motors, accelerations, constraint forces, and the sensors that show them.
        move: (machine, length) -> None. The state goes on by a time in s.
    """

    torque: Any
    touchdown: Any
    slope_estimate: Any
    next_discontinuity: Any
    tick: Any
    knee_strike: Any
    position: Any
    velocity: Any
    forces: Any
    move: Any


def stance_of(u: Sequence[float]) -> int:
    """The leg that stands: 0 left, 1 right."""
    return 1 if u[events.STANCE] != 0.0 else 0


def angles_of(u: Sequence[float], first: int, stance: int, slope: float) -> tuple[float, float, float]:
    """Stance leg, swing thigh and swing shank, of six coordinates from an index on, from a slope's normal, rad.

    A stance leg whose knee is bent has the angle of the line from its foot to the hip.
    """
    thigh, knee = THIGHS[1 - stance], KNEES[1 - stance]
    leg = u[first + THIGHS[stance]] + (u[OLD_TILT] if first == OLD_Q else u[TILT])
    return leg - slope, u[first + thigh] - slope, u[first + thigh] + u[first + knee] - slope


def rates_of(u: Sequence[float], first: int, stance: int) -> tuple[float, float, float]:
    """Their rates, of six from an index on, rad/s; a leg turns as its thigh does while its knee is locked."""
    thigh, knee = THIGHS[1 - stance], KNEES[1 - stance]
    share = u[OLD_SHARE] if first == OLD_RATES else u[SHARE]
    leg = u[first + THIGHS[stance]] + share * u[first + KNEES[stance]]
    return leg, u[first + thigh], u[first + thigh] + u[first + knee]


def foot_of(links: Any, first: int, q: Any, leg: int) -> tuple[float, float]:
    """Place of a foot, x and z in m, of six coordinates in `q` from an index on; `links` has the lengths."""
    x, z, thigh, knee = q[first + X], q[first + Z], q[first + THIGHS[leg]], q[first + KNEES[leg]]
    return end_of_leg(links, x, z, thigh, knee)


def end_of_leg(links: Any, x: float, z: float, thigh: float, knee: float) -> tuple[float, float]:
    """Place of a foot, x and z in m, of the hip's, the thigh's angle and the knee's flexion."""
    shank = thigh + knee
    return (
        x - links.thigh_length * math.sin(thigh) - links.shank_length * math.sin(shank),
        z - links.thigh_length * math.cos(thigh) - links.shank_length * math.cos(shank),
    )
