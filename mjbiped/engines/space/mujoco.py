"""A robot in space as MuJoCo's bodies and contacts; the controller drives it in `mjcb_control`.

Yaw is held by the torsional friction of the stance foot alone, and support is transferred where the swing foot's
contact is found. Nothing of the impact map is used. All steps are plain ones of one length; the controller is asked,
and works, loads and events are counted, at ticks.
"""

from __future__ import annotations

import math
from collections import deque
from dataclasses import asdict
from typing import Any

import numpy as np

from mjbiped.engines.mujoco import callback
from mjbiped.engines.mujoco.ground import Ground
from mjbiped.engines.mujoco.options import Options
from mjbiped.engines.mujoco.scene import scene_spec
from mjbiped.engines.plan import Plan
from mjbiped.engines.space.run import SpaceRun
from mjbiped.records.columns import Cancellation, never_cancelled
from mjbiped.robots.footing import Footing, robot_axes
from mjbiped.robots.shape import HIP
from mjbiped.robots.space import Array
from mjbiped.rules.scuffing import swing_foot_collides
from mjbiped.rules.termination import AVERAGED, SLIPPED_FOOT, Outcome
from mjbiped.utils.mujoco import mujoco

PLAIN = 2e-4
"""Longest physics step, s."""
TICK = 1e-3
"""Time between two ticks of the controller, s, unless the engine is given another."""
TORSION = 0.05
"""Torsional friction of a foot: its greatest torque about the ground's normal over the normal force, m."""
HELD = 1e6
"""Torque that holds the yaw in the step of an impact, N m: the force that bounds it is not known before the step."""
LIFTED = 1e-3
"""Height over the ground from which on the foot of a leg with a knee can touch the ground again, leg lengths."""


class MujocoSpaceRun(SpaceRun):
    """A walk by MuJoCo's plain steps.

    Attributes:
        model: The scene.
        data: Its state.
    """

    def __init__(
        self,
        plan: Plan,
        options: Options,
        *,
        summarised: bool = False,
        cancellation: Cancellation = never_cancelled,
    ) -> None:
        """Build the scene and set the robot on the ground; see `Engine.start`."""
        super().__init__(plan, summarised=summarised, cancellation=cancellation)
        self.options, self.timestep = options, min(options.timestep, PLAIN)
        self.period = options.control_period or TICK
        self.model = self._scene()
        if plan.disturbances.friction is not None:
            for name in ("left_foot", "right_foot"):
                self.model.geom(name).friction[0] = plan.disturbances.friction
        self.data = mujoco.MjData(self.model)
        self.feet = [self.model.geom(name).id for name in ("left_foot", "right_foot")]
        self.motors = self._motors()
        at = {name: self.model.joint(name).qposadr[0] for name in self.robot.places}
        self.hip = [at[name] for name in HIP]
        self.heading = self.model.tendon("heading").id
        first = self.model.joint("hip_x").dofadr[0]
        self.slides = slice(first, first + 3)
        self.model.tendon_solref_fri[self.heading] = -1.0, -1.0 / self.timestep
        self.order, self.turns = list(at.values()), [at["yaw"], at["roll"]]
        self.legs = [[at[f"{side}"], *([at[f"{side}_knee"]] if self.knees else [])] for side in ("left", "right")]
        self.hips = [at[name] for name in self.robot.hips]
        self.locks = [self.model.equality(f"{side}_lock").id for side in ("left", "right")] if self.knees else []
        self.asked = self.torque = np.zeros(len(self.robot.joints))
        self.commands = np.zeros(self.model.nu)
        self.enabled, self.began, self.next_tick, self.force = False, 0.0, 0.0, self.robot.weight
        self.impulse = np.zeros(3)
        self.struck: tuple[float, Array, Array] | None = None
        self.recent: deque[Array] = deque(maxlen=max(1, round(AVERAGED * self.pendulum / self.period)))
        self._place()
        self.ended = self.dq
        callback.register(self.data._address, self, 0)

    def _scene(self) -> mujoco.MjModel:
        """The scene on all of the ground that the walk can reach."""
        terms, length = self.plan.terms, self.robot.leg_length
        reach = terms.distance if terms.distance is not None else float(terms.steps or 0) * length
        ground = Ground(self.plan.terrain, reach=reach + 10.0 * length, half_width=reach + 2.0 * length)
        with callback.python_removed():
            return scene_spec(self.robot, ground, ground.pieces, timestep=self.timestep).compile()

    def _motors(self) -> list[list[int]]:
        """Indices of the motors by the number of the stance leg, in the order of the robot's joints."""
        found = []
        for stance, swing in (("left", "right"), ("right", "left")):
            names = {"ankle": f"{stance}_ankle", "knee": f"{swing}_knee"}
            found.append([self.model.actuator(names.get(joint, joint)).id for joint in self.robot.joints])
        return found

    def on_control(self) -> None:
        """Write the torques that are held, for `mjcb_control`."""
        self.data.ctrl[:] = self.commands

    def _command(self) -> None:
        """Hold the torques, at the motors of the legs in their roles, from this physics step on."""
        held, left = np.zeros(self.model.nu), self.footing.to_left
        held[self.motors[self.footing.stance]] = self.torque
        held[self.motors[0][1]] *= -left  # the hip's motor turns the right leg, and the roll's the robot to the right
        held[self.motors[0][-1]] *= left
        self.data.ctrl[:] = self.commands = held

    def step(self) -> Outcome:
        """Step to the next touchdown; see `SpaceRun.step`."""
        callback.enter(None)
        try:
            while True:
                outcome = self._physics_step()
                if outcome is not None:
                    return outcome
        finally:
            callback.leave(None)

    def advance(self, until: float) -> Outcome:
        """Walk on until a time, s, or to the end of the walk; see `SpaceRun.step`."""
        callback.enter(None)
        try:
            while self.data.time < until - 1e-9:
                outcome = self._physics_step()
                if outcome not in (None, Outcome.WALKING):
                    return outcome
        finally:
            callback.leave(None)
        return Outcome.WALKING

    def _physics_step(self) -> Outcome | None:
        """Make one step; an outcome where a touchdown or the walk's end came in it."""
        model, data, outcome = self.model, self.data, None
        stance, swing = self.feet[self.footing.stance], self.feet[1 - self.footing.stance]
        mujoco.mj_step1(model, data)
        landed = self.enabled and not self.free and data.ncon > 0 and bool((data.contact.geom == swing).any())
        if landed:  # the departing foot leaves the ground freely
            before = self.seen()
            model.geom_contype[stance] = 0
            self._hold(self._next(), HELD)  # as the force of the impact is not known yet
            mujoco.mj_step1(model, data)
        if data.time >= self.next_tick - 1e-9:
            outcome = self._tick()
        mujoco.mj_step2(model, data)
        # nothing but the ground holds the hip's slides
        self.impulse += self.timestep * data.qfrc_constraint[self.slides]
        if landed:
            return self._transfer(before)
        if self.free:
            self._look_at_knee()
        return outcome

    def _tick(self) -> Outcome | None:
        """Ask the controller, move its states on, and tell whether the walk ends here."""
        data, joints = self.data, len(self.robot.joints)
        q, dq = self.seen()
        self.time = float(data.time)
        since = self.time - self.began
        if since > 0.0:
            self._count()
        self.work += self.period * self.powers(self.torque, 0.5 * (self.ended + dq)) * (since > 0.0)
        self.ended = dq
        if self.pushing.change <= self.time + 1e-9:
            self.pushing.advance(self.time)
            data.body("hip").xfrc_applied[:3] = self.pushing.force
        out = np.array(self.law.torque(self.memory, since, tuple(q), tuple(dq)))
        self.asked = out[:joints]
        self.torque = self.transmitted(self.asked, self.force) if self.on_sole else self.asked
        if self.sample_due(self.time):
            self.sample(q, dq, self.asked, self.torque)
        for state in range(len(self.law.states)):
            self.memory[state] += self.period * float(out[joints + state])
        self.next_tick += self.period
        self.note_flexion(q)
        self._enable(since)
        self._command()
        outcome = self.judged(data.qpos[self.hip], since)
        stood = data.geom_xpos[self.feet[self.footing.stance]]
        self.slip = max(self.slip, float(np.linalg.norm((stood - self.footing.place)[:2])))
        if outcome is Outcome.WALKING and self.slip > SLIPPED_FOOT * self.robot.leg_length:
            outcome = Outcome.SLIPPED
        if outcome is Outcome.WALKING and data.warning.number.any():
            outcome = Outcome.DIVERGED
        return None if outcome is Outcome.WALKING else outcome

    def _count(self) -> None:
        """Note the load on the stance foot, a mean over the window: a contact can be lost for some steps."""
        self.recent.append(self.footing.turned(self.impulse) / self.period)
        self.impulse = np.zeros(3)
        along = np.mean(self.recent, axis=0)
        self.force = float(along[2])
        self._hold(self.footing, TORSION * max(self.force, 0.0))
        self.bound_time += self.period * bool((self.torque != self.asked).any())
        if self.data.ncon:
            self.depth = max(self.depth, -float(self.data.contact.dist.min()))
        if len(self.recent) == self.recent.maxlen:
            self.note_load(self.torque, along, self.period)

    def _hold(self, footing: Footing, torque: float) -> None:
        """Let a foot's friction, up to a torque, hold what turns the robot about neither its heading nor its axle."""
        (cy, sy, cr, sr), (x, y, z) = self._turned(), footing.forward.tolist()
        begin = self.model.tendon_adr[self.heading]
        # what is held is square to the forward direction and to the axle: its components upward and ahead
        self.model.wrap_prm[begin : begin + 2] = cr * (x * cy + y * sy), sr * (y * cy - x * sy) - cr * z
        self.model.tendon_frictionloss[self.heading] = torque

    def _next(self) -> Footing:
        """The footing on the swing foot."""
        old, place = self.footing, self.data.geom_xpos[self.feet[1 - self.footing.stance]].copy()
        _, left, over = robot_axes(*self.data.qpos[self.turns])
        return old.next(place, self.plan.terrain.normal_at(place[0], place[1]), old.to_left * left, over)[0]

    def _look_at_knee(self) -> None:
        """Lock the swing knee where it has struck its stop, and tell so a physics step later, when it has stopped."""
        data, swing, since = self.data, 1 - self.footing.stance, float(self.data.time) - self.began
        if self.struck is not None:
            self.knee_strikes(*self.struck, self.seen()[1])
            self.struck = None
        elif since > 1e-2 and data.qpos[self.legs[swing][1]] <= 0.0:
            data.eq_active[self.locks[swing]] = 1
            self.struck = since, *self.seen()

    def _enable(self, since: float) -> None:
        """Let the swing foot collide once the scuffing rule says so; with knees, once it has left the ground."""
        if self.enabled:
            return
        terrain, rule, length = self.plan.terrain, self.plan.terms.scuffing, self.robot.leg_length
        place = self.data.geom_xpos[self.feet[1 - self.footing.stance]]
        gap = float(place[2] - terrain.height_at(place[0], place[1]))
        ahead = float((place - self.data.geom_xpos[self.feet[self.footing.stance]]) @ self.footing.forward)
        if self.robot.collides_from_lift_off:
            self.enabled = gap > LIFTED * length
        else:
            self.enabled = swing_foot_collides(rule.reach * length, rule.delay, since, ahead, gap)
        if self.enabled:
            self.model.geom_contype[self.feet[1 - self.footing.stance]] = 1

    def _transfer(self, before: tuple[Array, Array]) -> Outcome:
        """Exchange the legs, from angles and rates just before the impact."""
        model, data, old = self.model, self.data, self.footing
        mujoco.mj_kinematics(model, data)
        left = float(data.time) - (self.next_tick - self.period)  # since the last tick
        self.work += left * self.powers(self.torque, 0.5 * (self.ended + before[1]))
        self.time = self.began = self.next_tick = float(data.time)
        angles = self.seen()[0]
        self.footing = new = self._next()
        if self.knees:
            data.eq_active[self.locks] = [1, 0] if new.stance == 0 else [0, 1]
        after = self.seen()
        self.footing, self.enabled, self.ended, self.force = old, False, after[1], self.robot.weight
        self._hold(new, TORSION * self.force)
        self.recent.clear()
        self.impulse = np.zeros(3)
        return self.touchdown(new, (angles, before[1]), after)

    def posture(self, q: Array) -> Array:
        """MuJoCo's own."""
        return np.array(self.data.qpos[self.order])

    def seen(self) -> tuple[Array, Array]:
        """Angles and rates as the controller senses them: from the ground's normal under the stance foot.

        The normal's components ahead, to the left and upright in the robot, and their rates, tell lean and roll.
        """
        qpos, qvel, to_left = self.data.qpos, self.data.qvel, self.footing.to_left
        (yawing, turning), (x, y, z) = qvel[self.turns].tolist(), self.footing.normal.tolist()
        cy, sy, cr, sr = self._turned()
        ahead, across = x * cy + y * sy, y * cy - x * sy
        left, over = z * sr + across * cr, z * cr - across * sr
        sinking, rising = yawing * across, yawing * sr * ahead - turning * left
        lean, size = math.atan2(ahead, over), ahead * ahead + over * over
        leaning = (over * sinking - ahead * rising) / size
        roll = math.asin(min(1.0, max(-1.0, to_left * left)))
        rolling = to_left * (turning * over - yawing * cr * ahead) / math.cos(roll)
        stance, swing = self.legs[self.footing.stance], self.legs[1 - self.footing.stance]
        places = [stance[0], swing[0]]
        q, dq = qpos[places] - lean, qvel[places] - leaning
        bent, bending = ([q[1] + qpos[swing[1]]], [dq[1] + qvel[swing[1]]]) if self.knees else ([], [])
        if self.hips:
            bent, bending = [float(qpos[self.hips].sum())], [float(qvel[self.hips].sum())]
        return np.array([*q, *bent, roll]), np.array([*dq, *bending, rolling])

    def _turned(self) -> tuple[float, float, float, float]:
        """Cosine and sine of the yaw, and of the roll."""
        yaw, roll = self.data.qpos[self.turns].tolist()
        return math.cos(yaw), math.sin(yaw), math.cos(roll), math.sin(roll)

    def _place(self) -> None:
        """Set the robot on its first stance foot, at rest there, in the first state of the plan."""
        model, data, footing, robot = self.model, self.data, self.footing, self.robot
        rates = footing.rates(robot, self.q, self.dq)
        for name, value, rate in zip(robot.places, footing.posture(robot, self.q), rates, strict=True):
            data.joint(name).qpos[:], data.joint(name).qvel[:] = value, rate
        mujoco.mj_kinematics(model, data)
        data.qpos[self.hip] += footing.place - data.geom_xpos[self.feet[0]] - 1e-5 * footing.normal
        model.geom_contype[self.feet[1]] = 0
        self._hold(footing, TORSION * self.force)
        if self.knees:
            data.eq_active[self.locks] = [1, 0]

    def settings(self) -> dict[str, Any]:
        """The engine's settings, and MuJoCo's warnings."""
        return {**asdict(self.options), "timestep": self.timestep, "control_period": self.period, "warnings": {}}
