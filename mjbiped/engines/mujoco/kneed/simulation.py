"""The biped with knees in MuJoCo: steps that end where the foot or the knee strikes, and one step for each impact.

Nothing of the impact maps is used. A knee that comes to its stop is locked by an equality constraint, one contact step
long plastic, as the feet's contacts are; a foot's contact makes the heel strike. The swing foot collides from the first
step after lift-off on, wherever it is.

A step consists of MuJoCo's own stages, one after the other, so that no callback is needed: what a step's constraints
are made of (locks, what the feet can meet, damping) is decided before the position stage. Rates of now, the effective
step and the held foot are those of `mjbiped.engines.mujoco.leapfrog`.
"""

from __future__ import annotations

import math
from collections import Counter
from collections.abc import Callable, Sequence

import mujoco
import numpy as np

from mjbiped.control import methods
from mjbiped.control.controller import Controller
from mjbiped.engines.mujoco import contact_events as events
from mjbiped.engines.mujoco.ground_window import MARGIN, GroundWindows, places_in
from mjbiped.engines.mujoco.judged import ground_needed, limits_of
from mjbiped.engines.mujoco.kneed.feet import KNEES, PLACES, THIGHS, Array, Collisions, Felt, X, Z, felt, foot_of
from mjbiped.engines.mujoco.kneed.lengths import Lengths, approach, sooner
from mjbiped.engines.mujoco.leapfrog import effective_step, held, limited
from mjbiped.engines.mujoco.options import Options
from mjbiped.engines.mujoco.scene import LOCK_STIFFNESS
from mjbiped.engines.mujoco.simulation import START_DEPTH, WHOLE_STATE
from mjbiped.engines.mujoco.step_size import DEPTH, SHORTEST, STIFFNESS
from mjbiped.engines.mujoco.step_size import MARGIN as FACE_MARGIN
from mjbiped.records.columns import tables_of, width
from mjbiped.records.recorder import Recorder
from mjbiped.records.rows import KNEED_SAMPLED, write_kneed_sample, write_kneed_touchdown
from mjbiped.robots.kneed import KneedBiped
from mjbiped.rules.scuffing import chosen
from mjbiped.rules.termination import FALLEN_HIP, LIGHT_CONTACT, SLIPPED_FOOT, Outcome
from mjbiped.terrain.profile import (
    height_of,
    height_over,
    height_over_ground,
    segment_met,
    segment_stood_on,
    segment_under,
)
from mjbiped.terrain.terrain import Terrain

OPENED = 1e-4  # rad: a knee that bends less rests against its stop, and does not strike it
CLEAR = 1e-4  # m: a swing foot that was no higher over the ground has not left it
STOPPED = 1e-9  # beyond its stop, to which a step leads the knee, rad
TOUCHING = 4.0  # steps are so many times shorter while the swing foot drags along the ground, ...
SLIDING = 16.0  # ... or on a riser's face, before which all are contact steps
NOW = 1e-9  # times so close are the same, s
_TOUCHED = width(tables_of(KneedBiped).touchdowns)
_ANGLES = [*THIGHS, *KNEES]


class KneedSimulation:
    """A biped with knees, a controller and a terrain in MuJoCo.

    Attributes:
        model: The compiled scene; see `models/kneed.xml`.
        data: Its state.
        outcome: How the walk ended, or `Outcome.WALKING`.
        peak_torque: Greatest magnitudes of ankle, hip and swing knee so far, N m.
        warnings: What went wrong, and how often.
    """

    def __init__(
        self,
        controller: Controller,
        terrain: Terrain,
        *,
        robot: KneedBiped,
        q: Sequence[float],
        dq: Sequence[float],
        steps: int | None,
        distance: float | None,
        sample_period: float,
        friction: float | None,
        options: Options,
    ) -> None:
        """Build the scene and set the robot on it, on its left leg.

        Args:
            controller: See `controllers.Controller`.
            terrain: The ground.
            robot: The robot that walks.
            q: Stance leg, swing thigh and swing shank at the start, from the ground's normal under x = 0, rad.
            dq: Their rates, rad/s.
            steps: Touchdowns after which the walk is finished.
            distance: Place at which it is, m.
            sample_period: Time between samples, s.
            friction: Of the feet; None: as in the file.
            options: The engine's settings.
        """
        self.controller, self.robot, self._terrain, self._options = controller, robot, terrain, options
        self._usual, self._friction = options.timestep, friction
        self._shortest = min(options.contact_timestep, options.timestep)
        self._windows = GroundWindows(
            robot,
            terrain,
            timestep=self._shortest,
            reach=ground_needed(robot, steps, distance),
            ground=options.ground,
            margin=MARGIN * robot.leg_length,
        )
        self.limits = limits_of(
            robot, chosen(None), options.timestep, (self._windows.start, self._windows.end), steps, distance
        )
        self._stepped = any(terrain.rises)
        self.outcome = Outcome.WALKING
        self.warnings: Counter[str] = Counter()
        self.peak_torque = np.zeros(3)
        self._sample_period = sample_period
        self._rows: list[Array] = []
        self._samples: list[Array] = []
        self.model: mujoco.MjModel
        self.data: mujoco.MjData
        self._build(0.0, None)
        self._start(q, dq)

    # --- the scene ------------------------------------------------------------------------------------------------

    def _build(self, x: float, before: mujoco.MjData | None) -> None:
        """Build the ground about the robot at x (m), and take over its state."""
        scene = self._windows.about(x)
        state = None
        if before is not None:
            state = np.empty(mujoco.mj_stateSize(self.model, WHOLE_STATE))
            mujoco.mj_getState(self.model, before, state, WHOLE_STATE)
        self.model, self.data = scene.model, mujoco.MjData(scene.model)
        if state is not None:
            mujoco.mj_setState(self.model, self.data, state, WHOLE_STATE)
        self.limits = self.limits._replace(start=scene.start, end=scene.end)
        self._places = places_in(scene, self._terrain)
        self._inside = self._windows.inside(scene)
        self._collisions = Collisions(self.model, self._places)
        self._met = -1  # segment under the swing foot, as last written
        self._actuators = [
            [self.model.actuator(f"{side}_{joint}").id for joint in ("ankle", "knee")] for side in ("left", "right")
        ]
        self._hip_motor = self.model.actuator("hip").id
        self._knee_joints = [self.model.joint(f"{side}_knee").id for side in ("left", "right")]
        self._locks = [self.model.equality(f"{side}_lock").id for side in ("left", "right")]
        if self._friction is not None:
            self.model.geom_friction[list(self._places.feet), 0] = self._friction

    def _move_on(self) -> None:
        """Build the ground further on where the robot comes near the end of what is built."""
        low, high = self._inside
        x = float(self.data.qpos[X])
        if math.isfinite(x) and not low < x < high:
            self._build(x, self.data)
            self._stand()

    def _start(self, q: Sequence[float], dq: Sequence[float]) -> None:
        terrain, data, length = self._terrain, self.data, self.limits.leg_length
        self._slope = slope = terrain.slope_at(0.0)
        self._foot = (0.0, terrain.height_at(0.0))
        leg, thigh, shank = (angle + slope for angle in q)
        data.qpos[:] = [
            *(length * math.sin(leg), self._foot[1] + length * math.cos(leg) - START_DEPTH),
            *(leg, 0.0, thigh, shank - thigh),
        ]
        data.qvel[:] = [
            *(length * math.cos(leg) * dq[0], -length * math.sin(leg) * dq[0]),
            *(dq[0], 0.0, dq[1], dq[2] - dq[1]),
        ]
        data.eq_active[self._locks] = [1, 0]
        self._memory = [0.0] * self.controller.memory_size
        self._state_rates = [0.0] * len(self.controller.states)
        self.controller.start(self._memory, tuple(q), tuple(dq))
        self._u = [0.0] * events.CONTROLLER_MEMORY  # what `contact_events.weigh` averages the ground's force with
        self._time, self._transfer_time, self._stance, self._count = -1.0, 0.0, 0, 0
        self._next_sample = self._next_control = 0.0
        self._planned, self._plain, self._before = self._usual, False, 0.0
        self._lag, self._acceleration = np.zeros(6), None
        self._torque = (0.0, 0.0, 0.0)
        self._work = np.zeros(3)  # absolute, net, positive
        self._strikes_next = self._struck = self._landed = False
        self._qpos, self._rates = data.qpos.copy(), data.qvel.copy()
        self._foot_angle = leg
        self._begin_step()
        self._opened = shank - thigh > OPENED

    def _begin_step(self) -> None:
        """Forget what is told of one step alone."""
        self._opened, self._touching = False, True  # the foot leaves the ground
        self._clear = 0.0
        self._slip = self._penetration = self._used = self._faces = self._flexion = 0.0
        self._stubs = 0
        self._strike: tuple[float, Array, Array, Array] | None = None
        for index in (events.IMPULSE, events.STRETCH, events.WITHOUT_CONTACT):
            self._u[index] = 0.0
        self._u[events.NORMAL_FORCE] = math.inf
        self._stand()

    def _stand(self) -> None:
        """What the stance foot meets, where it stands."""
        self._collisions.stand(self._stance, *foot_of(self.robot, self.data.qpos, self._stance))
        self._met = -1

    # --- a step ---------------------------------------------------------------------------------------------------

    def advance(self) -> None:
        """Make one physics step, or end the walk."""
        model, data = self.model, self.data
        if not (np.isfinite(data.qpos).all() and np.isfinite(data.qvel).all()):
            self._end(Outcome.DIVERGED)
            return
        self._observe()
        if self.outcome is Outcome.DIVERGED:
            return
        self._tick()
        self._sample()
        if self.outcome is not Outcome.WALKING:
            return
        stance, swing = self._stance, 1 - self._stance
        self._softness(effective_step(self._plain, self._before, self._planned))
        x, z = foot_of(self.robot, data.qpos, swing)
        self._clear = height_over_ground(self._places.profile, x, z)
        lifted = self._lifted(x, z)
        met = segment_met(self._places.profile, x, z)
        if met != self._met or lifted is not None:
            self._collisions.swing(swing, x, z)
            self._collisions.write(lifted=lifted)
            self._met = met if lifted is None else -1
        mujoco.mj_fwdPosition(model, data)
        rates = data.qvel.copy()
        self._show()
        mujoco.mj_fwdVelocity(model, data)
        data.qvel[:] = rates
        mujoco.mj_fwdActuation(model, data)
        mujoco.mj_fwdAcceleration(model, data)
        mujoco.mj_fwdConstraint(model, data)
        self._struck, self._strikes_next = self._strikes_next, False
        toe = felt(model, data, self._places.feet[swing])
        self._feel(felt(model, data, self._places.feet[stance]), toe, self._may_land(x))
        lengths = self._lengths(toe)
        effective = effective_step(self._plain, self._before, lengths.length)
        self._u[events.EFFECTIVE_STEP] = effective
        self._note_lag(lengths.length)
        data.qacc *= effective / lengths.length
        model.opt.timestep = lengths.length
        mujoco.mj_Euler(model, data)
        self._planned, self._plain = lengths.following, lengths.reached
        if self._strikes_next:
            data.eq_active[self._locks[swing]] = 1

    @property
    def _deepest(self) -> float:
        return 2.0 * self._usual * math.sqrt(2.0 * self.robot.gravity * self.limits.leg_length)

    @property
    def _locked(self) -> bool:
        """Whether the swing knee is locked."""
        return bool(self.data.eq_active[self._locks[1 - self._stance]])

    def _may_land(self, x: float) -> bool:
        """Whether a swing foot at x takes the robot over if it comes down: its leg is straight, and ahead."""
        return self._locked and x > self._foot[0]

    def _lifted(self, x: float, z: float) -> int | None:
        """The leg whose foot leaves the ground in the step to come, and does not collide.

        The ground cannot pull, but a solver with a convex friction cone drags a foot that leaves it obliquely: the
        stance foot in the heel strike, and a swing foot that touches the ground and moves away from it.

        Args:
            x: Place of the swing foot, m.
            z: Its height, m.
        """
        profile, swing = self._places.profile, 1 - self._stance
        height = height_over_ground(profile, x, z)
        if not -self._deepest < height < 0.0:
            return None
        later = self._qpos + SHORTEST * self._rates
        if height_over_ground(profile, *foot_of(self.robot, later.tolist(), swing)) > height:
            return swing
        return self._stance if self._may_land(x) else None

    def _softness(self, effective: float) -> None:
        """Contacts, stops and locks are plastic within the step to come."""
        model, damping = self.model, -1.0 / effective
        model.geom_solref[list(self._places.feet)] = (-STIFFNESS, damping)
        model.jnt_solref[self._knee_joints] = (-LOCK_STIFFNESS, damping)
        model.eq_solref[self._locks, :2] = (-LOCK_STIFFNESS, damping)

    def _show(self) -> None:
        """Let the velocity stage see rates of now, and the stance foot's velocity in the mean of the step."""
        if self._plain:
            return
        data, index = self.data, THIGHS[self._stance]
        leg, rate, lag = float(data.qpos[index]), float(data.qvel[index]), float(self._lag[index])
        shown_x, shown_z = held(self.limits.leg_length, leg, rate, lag, self._planned, self._before)
        data.qvel[:] += self._lag
        data.qvel[X] += shown_x
        data.qvel[Z] += shown_z

    def _note_lag(self, length: float) -> None:
        """What the rates will lack, after this step, to be those of its end."""
        now = self.data.qacc.copy()
        impact = self._landed or self._struck or self._plain
        self._lag[:] = 0.0
        if not impact:
            least, before = self.robot.gravity / self.limits.leg_length, self._acceleration
            for index in _ANGLES:
                value = float(now[index])
                if before is not None:
                    value = limited(value, float(before[index]), least)
                self._lag[index] = 0.5 * length * value
        self._acceleration = None if impact else now

    def _lengths(self, toe: Felt) -> Lengths:
        """How long this step and the next one are."""
        planned, data = self._planned, self.data
        if self._landed or self._struck:
            return Lengths(planned, self._usual)
        swing, profile = 1 - self._stance, self._places.profile
        qpos, qvel, qacc = data.qpos.copy(), data.qvel.copy(), data.qacc.copy()

        def after(t: float) -> Array:
            return np.asarray(qpos + t * (qvel + effective_step(self._plain, self._before, t) * qacc))

        def height(t: float) -> float:
            return height_over_ground(profile, *foot_of(self.robot, after(t).tolist(), swing))

        if height(0.0) > 0.0:
            found = approach(lambda t: height(t) + DEPTH, planned, self._shortest, self._usual)
        elif toe.ground:
            found = Lengths(planned, max(self._usual / TOUCHING, self._shortest))
        elif height(planned) > height(0.0):  # it has left the ground
            found = Lengths(planned, self._usual)
        else:
            found = Lengths(planned, self._shortest, True)
        if self._opened and not self._locked:
            knee = KNEES[swing]
            if qpos[knee] > 0.0:
                stop = approach(lambda t: float(after(t)[knee]) + STOPPED, planned, self._shortest, self._usual)
            else:
                stop = Lengths(planned, self._shortest, True)
            self._strikes_next = stop.reached and stop.length <= found.length
            found = sooner(found, stop)
        if self._options.control_period is not None:
            due = self._next_control - data.time
            if due < found.length - SHORTEST:
                self._strikes_next = False
                found = Lengths(due, planned)
        if self._stepped and not found.reached and self._near_face(after, found.length, swing):
            if toe.face:
                found = found._replace(following=max(self._usual / SLIDING, self._shortest))
            else:
                found = found._replace(following=self._shortest, reached=found.length <= self._shortest)
        return found

    def _near_face(self, after: Callable[[float], Array], t: float, swing: int) -> bool:
        """Whether the swing foot could touch a riser in the step after this one, which is of length t."""
        x, z = foot_of(self.robot, after(t).tolist(), swing)
        further, _ = foot_of(self.robot, after(t + 2.0 * self._usual).tolist(), swing)
        margin = FACE_MARGIN + abs(further - x)
        profile, rises = self._places.profile, self._places.rises
        segment = segment_under(profile, x)
        for index in range(segment, min(segment + 2, len(profile.x))):
            rise, top = rises[index], profile.z[index]
            if rise != 0.0 and abs(x - profile.x[index]) < margin and z < max(top, top - rise) + margin:
                return True
        return False

    def _feel(self, stance: Felt, toe: Felt, may_land: bool) -> None:
        """Take in what the feet feel in the step just resolved."""
        self._landed = may_land and toe.ground
        if self._clear > CLEAR:
            self._touching = False
        if toe.face:
            self._faces = 1.0
        if self._landed:
            self._penetration = max(self._penetration, toe.depth)
        elif toe.ground and not self._touching:
            self._stubs += 1
            self._touching = True
        self._u[events.FORCE] = stance.force
        if stance.ground and not self._landed:
            self._penetration = max(self._penetration, stance.depth)
            if stance.bearing > LIGHT_CONTACT * self.limits.weight:
                self._used = max(self._used, stance.tangential / stance.bearing)

    # --- what is told -----------------------------------------------------------------------------------------------

    def _angles(self, qpos: Array, slope: float) -> Array:
        """Stance leg, swing thigh and swing shank from a slope's normal, rad; of rates with a slope of 0."""
        stance, swing = self._stance, 1 - self._stance
        thigh = float(qpos[THIGHS[swing]])
        return np.array([float(qpos[THIGHS[stance]]), thigh, thigh + float(qpos[KNEES[swing]])]) - slope

    def _observe(self) -> None:
        """Take in the state at a new time: impacts that were made, work, slip, and whether the walk is over."""
        data, limits = self.data, self.limits
        time, qpos = float(data.time), data.qpos.copy()
        rates = data.qvel + self._lag
        step = time - self._time
        if self._time >= 0.0:
            for index, rate in enumerate(self._state_rates):
                self._memory[index] += step * rate
        self._turned = None if self._landed or self._struck else (self._qpos, self._torque)
        self._before = 0.0 if self._landed or self._struck or self._time < 0.0 else step
        before, old = self._rates, self._qpos
        self._time, self._qpos, self._rates = time, qpos, rates
        swing = 1 - self._stance
        if self._struck:
            self._note_strike(old, before)
            events.weigh(self._u, limits)
        elif not self._landed:
            events.weigh(self._u, limits)
        self._flexion = max(self._flexion, float(qpos[KNEES[swing]]))
        if qpos[KNEES[swing]] > OPENED and not self._locked:
            self._opened = True
        if self._landed:
            self._transfer(time, old, before)
            if self.outcome is Outcome.DIVERGED:
                return
        stance_angle, slope = float(qpos[THIGHS[self._stance]]), self._slope
        x, z = foot_of(self.robot, qpos, self._stance)
        dx, dz = x - self._foot[0], z - self._foot[1]
        distance = dx * math.cos(slope) - dz * math.sin(slope)
        slip = abs(distance - limits.foot_radius * (stance_angle - self._foot_angle))
        up = dx * math.sin(slope) + dz * math.cos(slope)
        self._slip = max(self._slip, slip)
        profile, hip_x, hip_z = self._places.profile, float(qpos[X]), float(qpos[Z])
        if (hip_z - height_over(profile, hip_x)) * math.cos(slope) < FALLEN_HIP * limits.leg_length:
            self._end(Outcome.FELL)
        elif time - self._transfer_time > limits.stall_time:
            self._end(Outcome.STALLED)
        elif max(slip, abs(up)) > SLIPPED_FOOT * limits.leg_length:
            self._end(Outcome.SLIPPED)
        elif not limits.start < hip_x < limits.end:
            self._end(Outcome.LEFT_TERRAIN)

    def _end(self, outcome: Outcome) -> None:
        if self.outcome is Outcome.WALKING:
            self.outcome = outcome

    def _note_strike(self, old: Array, before: Array) -> None:
        """The knee has struck its stop in the step before: it is locked, and the controller is told."""
        q, t = self._angles(self._qpos, self._slope), self._time - self._transfer_time
        dq = self._angles(self._rates, 0.0)
        self._strike = (t, self._angles(old, self._slope), self._angles(before, 0.0), dq)
        self.controller.on_knee_strike(self._memory, t, tuple(q.tolist()), tuple(dq.tolist()))

    def _transfer(self, time: float, old: Array, before: Array) -> None:
        """Exchange the legs' roles; the knee of the new swing leg is free, and the controller is told."""
        profile, limits, qpos = self._places.profile, self.limits, self._qpos
        q_before, dq_before = self._angles(old, self._slope), self._angles(before, 0.0)
        leg = 1 - self._stance
        x, z = foot_of(self.robot, qpos, leg)
        segment = segment_stood_on(profile, x, z)
        if not abs(z - height_of(profile, segment, x)) <= events.MISSED * limits.leg_length:
            self._end(Outcome.DIVERGED)
            return
        told = [self._slip, self._penetration, self._used, self._faces, events.least_normal_force(self._u)]
        flexion, stubs, strike = self._flexion, float(self._stubs), self._strike
        self._stance, self._foot, self._foot_angle = leg, (x, z), float(qpos[THIGHS[leg]])
        self._slope = -math.atan(profile.gradient[segment])
        self._transfer_time = time
        self._count += 1
        self.data.eq_active[self._locks[1 - leg]] = 0
        self._begin_step()
        q, dq = self._angles(qpos, self._slope), self._angles(self._rates, 0.0)
        estimate = self.controller.slope_estimate(self._memory)
        self.controller.on_touchdown(self._memory, tuple(q_before.tolist()), tuple(q.tolist()), tuple(dq.tolist()))
        row, none = np.zeros(_TOUCHED), np.full(3, math.nan)
        knee = strike if strike is not None else (math.nan, none, none, none)
        write_kneed_touchdown(
            row,
            0,
            time=time,
            qpos=qpos[PLACES],
            x=x,
            z=z,
            stance=float(leg),
            slope=self._slope,
            q_before=q_before,
            dq_before=dq_before,
            q=q,
            dq=dq,
            work_absolute=self._work[0],
            work_net=self._work[1],
            work_positive=self._work[2],
            slip=told[0],
            penetration=told[1],
            friction=told[2],
            strikes=told[3],
            slope_estimate_before=estimate,
            slope_estimate=self.controller.slope_estimate(self._memory),
            normal_force=told[4],
            knee_strike=knee[0],
            knee_q=knee[1],
            knee_dq_before=knee[2],
            knee_dq=knee[3],
            flexion=flexion,
            stubs=stubs,
        )
        self._rows.append(row)
        if self._count >= limits.steps or x >= limits.distance:
            self._end(Outcome.FINISHED)
        elif x >= limits.end:
            self._end(Outcome.LEFT_TERRAIN)

    def _tick(self) -> None:
        """The controller's tick; its torques are held until the next one. And the work of the step before."""
        data, stance = self.data, self._stance
        swing = 1 - stance
        if data.time > self._next_control - NOW:
            self._next_control += self._options.control_period or 0.0
            q, dq = self._angles(self._qpos, self._slope).tolist(), self._angles(self._rates, 0.0).tolist()
            t = self._time - self._transfer_time
            values = methods.knees_torque(self.controller, self._memory, t, *q, *dq)
            self._state_rates[:] = values[3:]
            ankle, hip, knee = (float(value) for value in values[:3])
            self._torque = (ankle, hip, 0.0 if self._locked else knee)
            if self.outcome is Outcome.WALKING:
                self.peak_torque = np.maximum(self.peak_torque, np.abs(self._torque))
        ankle, hip, knee = self._torque
        data.ctrl[:] = 0.0
        data.ctrl[self._actuators[stance][0]] = ankle
        data.ctrl[self._hip_motor] = hip if stance == 0 else -hip
        data.ctrl[self._actuators[swing][1]] = knee
        if self._turned is not None:
            old, torque = self._turned
            turned = self._angles(self._qpos, 0.0) - self._angles(old, 0.0)
            turned[1:] -= turned[:-1].copy()
            work = 0.5 * (np.array(torque) + self._torque) * turned
            self._work += [np.abs(work).sum(), work.sum(), np.maximum(work, 0.0).sum()]

    def _sample(self) -> None:
        """Write the state down, where it is time to."""
        if not (self._time > self._next_sample - NOW or self.outcome is not Outcome.WALKING):
            return
        self._next_sample = (math.floor(self._time / self._sample_period + NOW) + 1.0) * self._sample_period
        states = len(self.controller.states)
        row = np.zeros(KNEED_SAMPLED + states)
        write_kneed_sample(
            row,
            0,
            time=self._time,
            q=self._angles(self._qpos, self._slope),
            dq=self._angles(self._rates, 0.0),
            torque=self._torque,
            slope=self._slope,
            slope_estimate=self.controller.slope_estimate(self._memory),
            stance=float(self._stance),
            qpos=self._qpos[PLACES],
            locked=float(self._locked),
        )
        row[KNEED_SAMPLED:] = self._memory[:states]
        self._samples.append(row)

    def block(self, steps: int) -> None:
        """Make so many steps at most."""
        self._move_on()
        for _ in range(steps):
            if self.outcome is not Outcome.WALKING:
                return
            self.advance()

    def warn(self, message: str) -> None:
        """`mju_user_warning`: the first line says what it is."""
        self.warnings[message.partition(" at ")[0].strip()] += 1

    def take(self, recorder: Recorder) -> int:
        """Hand what was recorded on; returns the number of touchdowns."""
        count, size = len(self._rows), KNEED_SAMPLED + len(self.controller.states)
        recorder.add(
            np.array(self._rows).reshape(count, _TOUCHED), np.array(self._samples).reshape(len(self._samples), size)
        )
        self._rows.clear()
        self._samples.clear()
        return count

    @property
    def place(self) -> float:
        """Of the stance foot, x in m."""
        return self._foot[0]
