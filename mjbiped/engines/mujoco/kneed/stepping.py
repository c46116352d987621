"""Physics steps of the biped with knees in MuJoCo: they end where foot or knee strikes, and one makes the impact.

Nothing of the impact maps is used. A knee that comes to its stop is locked by an equality constraint, one contact step
long plastic, as the feet's contacts are; a foot's contact makes the heel strike. The swing foot collides from the first
step after lift-off on, wherever it is.

A step consists of MuJoCo's own stages, one after the other, so that no callback is needed: what a step's constraints
are made of (locks, what the feet can meet, damping) is decided before the position stage. Rates of now, the effective
step and the held foot are those of `mjbiped.engines.mujoco.leapfrog`.
"""

from __future__ import annotations

from collections.abc import MutableSequence, Sequence
from typing import Any

from mjbiped.engines.mujoco import contact_events as events
from mjbiped.engines.mujoco.callbacks import NOW, push
from mjbiped.engines.mujoco.contact_forces import Felt, felt
from mjbiped.engines.mujoco.kneed import feet
from mjbiped.engines.mujoco.kneed import state as at
from mjbiped.engines.mujoco.kneed.feet import write_collisions
from mjbiped.engines.mujoco.kneed.lengths import step_lengths
from mjbiped.engines.mujoco.kneed.motors import DIVERGED, take_sample, tick
from mjbiped.engines.mujoco.kneed.observation import look, observe
from mjbiped.engines.mujoco.kneed.state import (
    COORDINATES,
    KNEES,
    THIGHS,
    Buffers,
    Constants,
    Parts,
    Scene,
    X,
    Z,
    end_of_leg,
    foot_of,
    stance_of,
)
from mjbiped.engines.mujoco.leapfrog import Foot, effective_step, held, limited
from mjbiped.engines.mujoco.scene import LOCK_STIFFNESS, PUSHED_OUT
from mjbiped.engines.mujoco.step_size import SHORTEST, STIFFNESS
from mjbiped.terrain.profile import height_over_ground, segment_met

CLEAR = 1e-4  # m: a swing foot that was no higher over the ground has not left it
NOBODY = -1  # leg whose foot passes through the ground


def advance(parts: Parts, parameters: Any, constants: Constants, buffers: Buffers) -> None:
    """Make `u[STEPS]` physics steps, or fewer where the walk ends."""
    u, scene, machine = buffers.u, buffers.scene, buffers.machine
    for _ in range(int(u[at.STEPS])):
        if not look(u, scene):
            u[events.OUTCOME] = DIVERGED
            return
        observe(parts, parameters, constants, buffers)
        if u[events.OUTCOME] == DIVERGED:
            return
        if u[events.PUSHING] != 0.0 or u[events.TIME] > u[events.NEXT_PUSH] - NOW:
            push(constants.pushes, u, u[events.TIME])
            scene.qfrc_applied[X] = u[events.PUSH]
        tick(parts, parameters, constants, buffers)
        if u[events.OUTCOME] == DIVERGED:
            return
        take_sample(parts, parameters, constants, buffers)
        if u[events.OUTCOME] != 0.0:
            return
        _prepare(constants, u, scene)
        parts.position(machine)
        _show(constants, u, scene)
        parts.velocity(machine)
        for index in range(COORDINATES):
            scene.qvel[index] = u[at.QVEL + index]
        parts.forces(machine)
        for index in range(COORDINATES):
            u[at.QACC + index] = float(scene.qacc[index])
        parts.move(machine, _resolved(constants, u, scene))


def _prepare(constants: Constants, u: MutableSequence[float], scene: Scene) -> None:
    """Say what the constraints of the step to come are: how soft, and what the feet can meet."""
    profile = constants.places.profile
    _soften(constants, scene, effective_step(u[events.PLAIN], u[events.LAST_STEP], u[events.PLANNED]))
    swing = 1 - stance_of(u)
    x, z = foot_of(constants.links, at.Q, u, swing)
    u[at.CLEAR] = height_over_ground(profile, x, z)
    lifted = _lifted(constants, u, x)
    if lifted == 1 - swing:
        if u[at.LOCKED] == 0.0:
            _lock_bent(constants, u, scene)
        if constants.servo.stiffness > 0.0:
            _lock_for_impact(constants, u, scene, lifted)
    met = float(segment_met(profile, x, z))
    if met != u[at.MET] or lifted != NOBODY:
        feet.swing(constants.places, scene, swing, x, z)
        write_collisions(scene, lifted)
        u[at.MET] = met if lifted == NOBODY else -1.0


def _soften(constants: Constants, scene: Scene, effective: float) -> None:
    """Contacts, stops and locks are plastic within the step to come."""
    motors, damping = constants.motors, -1.0 / effective
    for index in range(len(scene.risers)):  # they decide about their contacts
        riser = scene.risers[index]
        scene.geom_solref[riser, 0], scene.geom_solref[riser, 1] = PUSHED_OUT * damping, damping
    for leg in range(2):
        foot, joint, lock = constants.places.feet[leg], motors.joints[leg], motors.locks[leg]
        scene.geom_solref[foot, 0], scene.geom_solref[foot, 1] = -STIFFNESS, damping
        scene.jnt_solref[joint, 0], scene.jnt_solref[joint, 1] = -LOCK_STIFFNESS, damping
        scene.eq_solref[lock, 0], scene.eq_solref[lock, 1] = -LOCK_STIFFNESS, damping


def _may_land(u: Sequence[float], x: float) -> bool:
    """Whether a swing foot at x takes the robot over if it comes down in the step to come.

    It does ahead of the stance foot, with its leg straight, or bent if it has been off the ground: a foot that drags
    along with its knee bent goes on so.
    """
    return bool(x > u[events.FOOT_X] and (u[at.LOCKED] != 0.0 or u[at.TOUCHING] == 0.0))


def _lock_bent(constants: Constants, u: MutableSequence[float], scene: Scene) -> None:
    """Lock the swing knee as it is: with the touchdown, the leg becomes one body."""
    swing = 1 - stance_of(u)
    lock, flexion = constants.motors.locks[swing], u[at.Q + KNEES[swing]]
    u[at.LOCKED], u[at.BENT], u[at.BEND] = 1.0, 1.0, flexion
    scene.eq_data[lock, 0], scene.eq_active[lock] = flexion, True


def _lock_for_impact(constants: Constants, u: Sequence[float], scene: Scene, leg: int) -> None:
    """Lock the stance knee, which a servo holds, as it is: for the heel strike alone."""
    lock = constants.motors.locks[leg]
    scene.eq_data[lock, 0], scene.eq_active[lock] = u[at.Q + KNEES[leg]], True


def _let_go(constants: Constants, u: MutableSequence[float], scene: Scene) -> None:
    """Free it again: the foot has not come down."""
    lock = constants.motors.locks[1 - stance_of(u)]
    u[at.LOCKED] = u[at.BENT] = 0.0
    scene.eq_data[lock, 0], scene.eq_active[lock] = 0.0, False


def _lifted(constants: Constants, u: Sequence[float], x: float) -> int:
    """The leg whose foot leaves the ground in the step to come, and does not collide.

    The ground cannot pull, but a solver with a convex friction cone drags a foot that leaves it obliquely: the
    stance foot in the heel strike, and a swing foot that touches the ground and moves away from it.

    Args:
        constants: The walk's.
        u: Its memory, with the height of the swing foot.
        x: Place of the swing foot, m.
    """
    stance, height = stance_of(u), u[at.CLEAR]
    if not -constants.deepest < height < 0.0:
        return NOBODY
    thigh, knee = THIGHS[1 - stance], KNEES[1 - stance]
    later_x, later_z = end_of_leg(constants.links, _later(u, X), _later(u, Z), _later(u, thigh), _later(u, knee))
    if height_over_ground(constants.places.profile, later_x, later_z) > height:
        return 1 - stance
    return stance if _may_land(u, x) else NOBODY


def _later(u: Sequence[float], index: int) -> float:
    return u[at.Q + index] + SHORTEST * u[at.RATES + index]


def _show(constants: Constants, u: Sequence[float], scene: Scene) -> None:
    """Let the velocity stage see rates of now, and the stance foot's velocity in the mean of the step."""
    if u[events.PLAIN] != 0.0:
        return
    stance = stance_of(u)
    index, knee, share = THIGHS[stance], KNEES[stance], u[at.SHARE]
    leg = u[at.Q + index] + u[at.TILT]
    rate, lag = u[at.QVEL + index] + share * u[at.QVEL + knee], u[at.LAG + index] + share * u[at.LAG + knee]
    foot = Foot(u[at.REACH], constants.limits.foot_radius, u[events.SLOPE])
    shown_x, shown_z = held(foot, leg, rate, lag, u[events.PLANNED], u[events.LAST_STEP])
    for place in range(COORDINATES):
        scene.qvel[place] = u[at.QVEL + place] + u[at.LAG + place]
    scene.qvel[X] += shown_x
    scene.qvel[Z] += shown_z


def _resolved(constants: Constants, u: MutableSequence[float], scene: Scene) -> float:
    """Take in what the step's forces are; returns its length, s, for which its accelerations are made to act."""
    stance = stance_of(u)
    u[at.STRUCK], u[at.STRIKES_NEXT] = u[at.STRIKES_NEXT], 0.0
    slots, contacts = constants.places.slots, constants.places.contacts
    toe = felt(scene.sensordata, contacts[1 - stance], slots)
    x, _ = foot_of(constants.links, at.Q, u, 1 - stance)
    _feel(
        constants, u, felt(scene.sensordata, contacts[stance], slots), toe, u[at.LOCKED] != 0.0 and x > u[events.FOOT_X]
    )
    if u[events.NOTED] == 0.0:
        if u[at.BENT] != 0.0:
            _let_go(constants, u, scene)
        if constants.servo.stiffness > 0.0:
            scene.eq_active[constants.motors.locks[stance]] = False
    lengths = step_lengths(constants, u, toe)
    length = lengths.length
    effective = effective_step(u[events.PLAIN], u[events.LAST_STEP], length)
    u[events.EFFECTIVE_STEP] = effective
    _note_lag(constants, u, length)
    for index in range(COORDINATES):
        scene.qacc[index] *= effective / length
    u[events.PLANNED], u[events.PLAIN] = lengths.following, 1.0 if lengths.reached else 0.0
    u[at.CLOCK] += length
    if u[at.STRIKES_NEXT] != 0.0:
        scene.eq_active[constants.motors.locks[1 - stance]] = True
        u[at.LOCKED] = 1.0
    return length


def _feel(constants: Constants, u: MutableSequence[float], stance: Felt, toe: Felt, may_land: bool) -> None:
    """Take in what the feet feel in the step just resolved."""
    landed = may_land and toe.ground
    u[events.NOTED] = 1.0 if landed else 0.0
    if u[at.CLEAR] > CLEAR:
        u[at.TOUCHING] = 0.0
    if toe.face:
        u[events.FACE_IMPACTS] = 1.0
    if landed:
        u[events.PENETRATION] = max(u[events.PENETRATION], toe.depth)
    elif toe.ground and u[at.TOUCHING] == 0.0:
        u[at.STUBS] += 1.0
        u[at.TOUCHING] = 1.0
    events.feel_stance(u, constants.limits, stance, landed)


def _note_lag(constants: Constants, u: MutableSequence[float], length: float) -> None:
    """What the rates will lack, after this step, to be those of its end."""
    impact = u[events.NOTED] != 0.0 or u[at.STRUCK] != 0.0 or u[events.PLAIN] != 0.0
    least = constants.gravity / constants.limits.leg_length
    for index in range(COORDINATES):
        value = u[at.QACC + index]
        if u[events.SMOOTH] != 0.0:
            value = limited(value, u[at.ACCELERATION + index], least)
        u[at.LAG + index] = 0.0 if impact or index < 2 else 0.5 * length * value  # the hip's is not shown
        u[at.ACCELERATION + index] = u[at.QACC + index]
    u[events.SMOOTH] = 0.0 if impact else 1.0
    if constants.servo.stiffness > 0.0:
        # a stop that is shown a rate of now leaves a knee that lies against it swinging, and off it now and then
        u[at.LAG + KNEES[stance_of(u)]] = 0.0
