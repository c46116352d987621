"""A robot in space as MuJoCo's bodies and contacts; the controller drives it in `mjcb_control`.

Yaw is held by the torsional friction of the stance foot alone, and support is transferred where the swing foot's
contact is found. Nothing of the impact map is used.
"""

from __future__ import annotations

import math
from dataclasses import asdict
from typing import Any

import numpy as np

from mjbiped.engines.mujoco import callback
from mjbiped.engines.mujoco.options import Options
from mjbiped.engines.plan import Plan
from mjbiped.robots.footing import Footing, first_footing, robot_axes
from mjbiped.engines.space.run import SpaceRun
from mjbiped.records.columns import Cancellation, never_cancelled
from mjbiped.robots.space import Array
from mjbiped.robots.three_d import InSpace
from mjbiped.rules.scuffing import swing_foot_collides
from mjbiped.rules.termination import SLIPPED_FOOT, Outcome
from mjbiped.terrain.terrain import Terrain
from mjbiped.utils.mujoco import mujoco

PLAIN = 2e-4
"""Length of a physics step, s: all steps are of one length."""
TICK = 1e-3
"""Time between two ticks of the controller, s, unless the engine is given another."""
RADIUS = 5e-5  # of a foot, m
TORSION = 0.05  # torsional friction of a foot, m
_X, _Y, _Z, _YAW, _ROLL, _LEGS = 0, 1, 2, 3, 4, 5


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
        self.model = mujoco.MjModel.from_xml_string(scene_of(self.robot, plan.terrain, self.timestep))
        self.data = mujoco.MjData(self.model)
        self.feet = [self.model.geom(name).id for name in ("left_foot", "right_foot")]
        self.torque, self.next_tick, self.next_sample, self.began = np.zeros(len(self.robot.joints)), 0.0, 0.0, 0.0
        self.enabled = False
        self._place()
        callback.register(self.data._address, self, 0)

    def on_control(self) -> None:
        """Write the torques that are held, for `mjcb_control`."""
        stance, ctrl = self.footing.stance, self.data.ctrl
        ctrl[:] = 0.0
        ctrl[stance], ctrl[2] = self.torque[0], (self.torque[1] if stance == 0 else -self.torque[1])
        ctrl[3] = self.footing.to_left * self.torque[-1]

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

    def _physics_step(self) -> Outcome | None:
        """Make one step; an outcome where a touchdown or the walk's end came in it."""
        model, data, swing = self.model, self.data, 1 - self.footing.stance
        self._enable()
        mujoco.mj_step1(model, data)
        landed = self.enabled and bool(data.ncon) and bool((data.contact.geom == self.feet[swing]).any())
        if landed:  # the departing foot leaves the ground freely
            model.geom_contype[self.feet[self.footing.stance]] = 0
            mujoco.mj_step1(model, data)
        q, dq = self.seen()
        since = data.time - self.began
        if data.time >= self.next_tick - 1e-9:
            self._tick(since, q, dq)
        mujoco.mj_step2(model, data)
        self._count(q, dq)
        if landed:
            return self._transfer(q, dq)
        hip = data.qpos[[_X, _Y, _Z]]
        outcome = self.judged(hip, since)
        stood = data.geom_xpos[self.feet[self.footing.stance]]
        self.slip = max(self.slip, float(np.linalg.norm((stood - self.footing.place)[:2])))
        if outcome is Outcome.WALKING and self.slip > SLIPPED_FOOT * self.robot.leg_length:
            outcome = Outcome.SLIPPED
        if outcome is Outcome.WALKING and data.warning.number.any():
            outcome = Outcome.DIVERGED
        self.time = data.time
        return None if outcome is Outcome.WALKING else outcome

    def _tick(self, since: float, q: Array, dq: Array) -> None:
        """Ask the controller, and move its states on."""
        joints, states = len(self.robot.joints), len(self.law.states)
        if self.sampled and data_due(self.next_sample, self.data.time):
            self.sample(self.data.time, q, dq, self.torque)
            self.next_sample += self.plan.terms.sample_period or math.inf
        out = np.array(self.law.torque(self.memory, since, tuple(q), tuple(dq)))
        self.torque = out[:joints]
        np.maximum(self.peak, np.abs(self.torque), out=self.peak)
        for state in range(states):
            self.memory[state] += self.period * float(out[joints + state])
        self.next_tick += self.period

    def _count(self, q: Array, dq: Array) -> None:
        """Count the work and the load of a step."""
        power = self.torque * self.robot.joint_rates(dq)
        self.work += self.timestep * np.array([np.abs(power).sum(), power.sum(), np.maximum(power, 0.0).sum()])
        force, stance = np.zeros(6), self.feet[self.footing.stance]
        total = np.zeros(3)
        for index in range(self.data.ncon):
            contact = self.data.contact[index]
            if stance in contact.geom:
                mujoco.mj_contactForce(self.model, self.data, index, force)
                sign = 1.0 if contact.geom[1] == stance else -1.0
                total += sign * (contact.frame.reshape(3, 3).T @ force[:3])
                self.depth = max(self.depth, -float(contact.dist))
        if total.any():
            footing = self.footing
            self.note_load(
                float(self.torque[0]),
                np.array([total @ footing.forward, total @ footing.aside, total @ footing.normal]),
                self.timestep,
            )

    def _enable(self) -> None:
        """Let the swing foot collide once the scuffing rule says so."""
        if self.enabled:
            return
        terrain, terms, swing = self.plan.terrain, self.plan.terms, 1 - self.footing.stance
        place, stood = self.data.geom_xpos[self.feet[swing]], self.data.geom_xpos[self.feet[self.footing.stance]]
        ahead = float((place - stood) @ self.footing.forward)
        gap = float(place[2] - terrain.height_at(place[0], place[1]))
        reach = terms.scuffing.reach * self.robot.leg_length
        if swing_foot_collides(reach, terms.scuffing.delay, self.data.time - self.began, ahead, gap):
            self.enabled = True
            self.model.geom_contype[self.feet[swing]] = 1 + swing

    def _transfer(self, q: Array, dq: Array) -> Outcome:
        """Exchange the legs."""
        mujoco.mj_kinematics(self.model, self.data)
        self.time = self.began = self.next_tick = float(self.data.time)
        before, _ = self.seen()
        place = self.data.geom_xpos[self.feet[1 - self.footing.stance]].copy()
        new, _ = self.footing.next(place, self.plan.terrain.normal_at(place[0], place[1]), before[-1])
        old, self.footing, self.enabled = self.footing, new, False
        after = self.seen()
        self.footing = old
        self.touchdown(new, (before, dq), after)
        return self.finished()

    def seen(self) -> tuple[Array, Array]:
        """Angles and rates as the controller senses them: from the ground's normal under the stance foot."""
        qpos, qvel, footing = self.data.qpos, self.data.qvel, self.footing
        ahead, over = robot_axes(float(qpos[_YAW]), float(qpos[_ROLL]))
        left = np.cross(over, ahead)
        turning = np.array([0.0, 0.0, qvel[_YAW]]) + qvel[_ROLL] * ahead
        axle = footing.to_left * left
        roll = footing.roll_of(axle)
        rolling = float(np.cross(turning, axle) @ footing.normal) / math.cos(roll)
        a, b = float(footing.normal @ ahead), float(footing.normal @ over)
        da = float(footing.normal @ np.cross(turning, ahead))
        db = float(footing.normal @ np.cross(turning, over))
        lean, leaning = math.atan2(a, b), (b * da - a * db) / (a * a + b * b)
        legs = [_LEGS + footing.stance, _LEGS + 1 - footing.stance]
        return np.append(qpos[legs] - lean, roll), np.append(qvel[legs] - leaning, rolling)

    def _place(self) -> None:
        """Set the robot on its first stance foot, at rest there, in the first state of the plan."""
        data, footing, robot = self.data, self.footing, self.robot
        posture = dict(zip(robot.places, footing.posture(robot, self.q), strict=True))
        names = ("hip_x", "hip_y", "hip_z", "yaw", "roll", "left", "right")
        data.qpos[:] = [posture[name] for name in names]
        step = 1e-6  # of the time in which the posture changes by its rates: differences are exact to 1e-9
        moved = [footing.posture(robot, self.q + sign * step * self.dq) for sign in (1.0, -1.0)]
        rates = dict(zip(robot.places, (moved[0] - moved[1]) / (2.0 * step), strict=True))
        data.qvel[:] = [rates[name] for name in names]
        mujoco.mj_kinematics(self.model, data)
        data.qpos[:3] += footing.place - data.geom_xpos[self.feet[0]] + 0.8 * RADIUS * footing.normal
        self.model.geom_contype[self.feet[1]] = 0

    def settings(self) -> dict[str, Any]:
        """The engine's settings, and MuJoCo's warnings."""
        return {**asdict(self.options), "timestep": self.timestep, "control_period": self.period, "warnings": {}}


def data_due(due: float, now: float) -> bool:
    """Whether a sample is due."""
    return due <= now + 1e-9


def scene_of(robot: InSpace, terrain: Terrain, timestep: float) -> str:
    """The MJCF of a robot on its ground; its stiff contacts make a plastic impact within one step."""
    (leg,), width = robot.bodies.leg, robot.hip_width
    pelvis = max(robot.hip_mass * width * width / 12, 1e-8)
    legs = "".join(
        f'<body name="{name}" pos="0 {y} 0"><joint name="{name}" type="hinge" axis="0 1 0"/>'
        f'<inertial pos="0 0 {-leg.centre}" mass="{leg.mass}" diaginertia="{leg.inertia} {leg.inertia} {robot.axial_inertia}"/>'
        f'<geom name="{name}_foot" type="sphere" size="{RADIUS}" pos="0 0 {-leg.length}" mass="0" contype="{bit}" '
        f'conaffinity="0" condim="4" priority="1" friction="0.8 {TORSION} 0" solref="-1e3 {-1 / timestep}" '
        f'solimp="0.9999 0.9999 0.001"/></body>'
        for name, y, bit in (("left", width / 2, 1), ("right", -width / 2, 2))
    )
    slides = "".join(f'<joint type="slide" axis="{axis}"/>' for axis in ("1 0 0", "0 1 0", "0 0 1"))
    return (
        f'<mujoco><compiler angle="radian"/><option timestep="{timestep}" integrator="Euler" cone="elliptic" '
        f'gravity="0 0 {-robot.gravity}"><flag eulerdamp="disable" island="disable"/></option><worldbody>'
        f"{''.join(ground_of(terrain))}<body>{slides}"
        f'<joint type="hinge" axis="0 0 1"/><joint type="hinge" axis="1 0 0" name="roll"/>'
        f'<inertial pos="0 0 0" mass="{max(robot.hip_mass, 1e-4)}" diaginertia="{pelvis} {pelvis} {pelvis}"/>{legs}'
        f'</body></worldbody><tendon><fixed name="hip"><joint joint="right" coef="1"/><joint joint="left" '
        f'coef="-1"/></fixed></tendon><actuator><motor joint="left"/><motor joint="right"/><motor tendon="hip"/>'
        f'<motor joint="roll"/></actuator></mujoco>'
    )


def ground_of(terrain: Terrain) -> list[str]:
    """A box for each segment of the ground, whose upper face is the segment."""
    pieces, ends = [], [*terrain.x[1:], terrain.x[-1] + 200.0]
    for k, (start, end) in enumerate(zip([terrain.x[0] - 10.0, *terrain.x[1:]], ends, strict=True)):
        middle = 0.5 * (max(start, -1e3) + end)
        normal = terrain.normal_at(middle, 0.0)
        half = 0.5 * (end - start) / normal[2]
        height = terrain.z[k] + terrain.gradients[k] * (middle - terrain.x[k])
        x, y, z = np.array([middle, 0.0, height]) - normal
        forward = np.array([normal[2], 0.0, -normal[0]]) / math.hypot(normal[2], normal[0])
        aside = np.cross(normal, forward)
        axes = " ".join(str(each) for each in (*forward, *aside))
        pieces.append(
            f'<geom type="box" pos="{x} {y} {z}" xyaxes="{axes}" size="{half} 20 1" contype="0" conaffinity="3"/>'
        )
    return pieces
