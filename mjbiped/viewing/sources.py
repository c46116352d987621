"""What the viewer shows: a walk under way, simulated with the steps of `mjbiped.walk`, or a record."""

from __future__ import annotations

import copy
import math
from collections import deque
from collections.abc import Callable, Generator

import numpy as np

from mjbiped.control.compiled import LawError
from mjbiped.control.tracking import Tracking
from mjbiped.engines.mujoco.engine import Mujoco, MujocoRun, stepped
from mjbiped.engines.plan import Plan
from mjbiped.errors import InputError, MjbipedError, RenderError
from mjbiped.records.record import Walk
from mjbiped.rendering import scene
from mjbiped.rendering.marks import Scales
from mjbiped.rendering.scene import Moment, Pair, beside_posture
from mjbiped.rendering.space import moments_of, scene_of
from mjbiped.rollout.walk import WalkStopped, is_interrupt
from mjbiped.utils.mujoco import mujoco

_LEAST_SCALE = 0.02  # least torque that is drawn at full size, over weight times leg length
_NO_SEEDS = "only random ground has seeds"
_SAME = 1e-9  # times that differ by less are the same, s


class LiveWalk:
    """A walk in MuJoCo, simulated up to the viewer's time.

    The window shows a copy of the walk's model and state, so that nothing in it but a push acts on the walk. Without a
    push the walk is bitwise that of `mjbiped.walk`.

    Attributes:
        run: Run of the walk, whose recorder holds the touchdowns so far.
        model: Scene on view, which is a new object where another part of the ground has been built.
        data: State of the scene; changes to it do not change the walk.
        scales: Scales of torques and forces for `mjbiped.rendering.marks.draw_marks`.
        goes_back: Whether earlier times can be shown again.
        news: Sentence that the viewer should show; empty if there is none.
    """

    goes_back = False
    run: MujocoRun
    model: mujoco.MjModel
    data: mujoco.MjData
    scales: Scales
    news = ""

    def __init__(self, plan: Plan, next_plan: Callable[[], Plan] | None = None) -> None:
        """Begin the walk.

        Args:
            plan: Checked plan whose engine is `mjbiped.Mujoco`.
            next_plan: Function that makes the plan on the next ground, for grounds with seeds.

        Raises:
            MjbipedError: The walk cannot be started, or another one is under way.
        """
        if plan.robot.runs:
            raise InputError(
                f"the viewer walks planar robots, and a {type(plan.robot).__name__} moves in space; record its walk "
                "(mjbiped walk --out walk.npz) and view the record (mjbiped view walk.npz)"
            )
        self._plan, self._next_plan = plan, next_plan
        self._steps: Generator[int, None, None] | None = None
        self._perturbation: mujoco.MjvPerturb | None = None
        self.restart()

    def restart(self) -> None:
        """Begin the same walk again."""
        self.close()
        plan, engine = self._plan, self._plan.terms.engine
        assert isinstance(engine, Mujoco)
        self.robot, self.terrain = plan.robot, plan.terrain
        self.run = MujocoRun(plan, engine, scenery=True)
        self.run.compile()
        self._steps = stepped(self.run.simulation, self.run.recorder, most=1)
        self._impulse, self._span, self._force, self._stance = 0j, 0.0, (0.0, 0.0), 0
        self._order = [int(self.run.simulation.model.joint(name).qposadr[0]) for name in self.robot.places]
        self._ways: list[deque[tuple[float, Pair]]] = [deque() for _ in self._feet()]
        self.scales = Scales(_LEAST_SCALE * plan.robot.weight * plan.robot.leg_length, plan.robot.weight)
        self._seen: mujoco.MjModel | None = None
        self.show()

    def next_seed(self) -> None:
        """Begin again on the next ground; if that is impossible, `news` says why, and the walk goes on."""
        if self._next_plan is None:
            self.news = _NO_SEEDS
            return
        try:
            self._plan = self._next_plan()
        except MjbipedError as error:
            self.news = str(error)
            return
        self.restart()

    def close(self) -> None:
        """Remove the walk's callbacks."""
        if self._steps is not None:
            self._steps.close()

    @property
    def time(self) -> float:
        """Time of the walk, s."""
        return float(self.run.simulation.data.time)

    @property
    def ended(self) -> str:
        """Outcome, once the walk has ended."""
        simulation = self.run.simulation
        return simulation.outcome.words if simulation.over else ""

    @property
    def steps(self) -> int:
        """Touchdowns so far."""
        return int(self.run.simulation.state.count)

    def go_to(self, time: float) -> None:
        """Simulate until a time (s).

        Raises:
            WalkStopped: The controller raised an exception.
        """
        while self.time < time - _SAME and self._step():
            pass

    def touchdown_beside(self, direction: int) -> None:
        """Simulate to the next touchdown; there is no way back."""
        before = self.steps
        while direction > 0 and self.steps == before and self._step():
            pass

    def push(self, perturbation: mujoco.MjvPerturb) -> None:
        """Pull the body that the mouse has selected from now on."""
        pulled = bool(perturbation.active) and perturbation.select > 0
        self._perturbation = copy.copy(perturbation) if pulled else None

    def _step(self) -> bool:
        """Make one physics step; return False if the walk has ended."""
        simulation = self.run.simulation
        if simulation.over or self._steps is None:
            return False
        before, data = self.time, simulation.data
        data.xfrc_applied[:] = 0.0
        if self._perturbation is not None:
            mujoco.mjv_applyPerturbForce(simulation.model, data, self._perturbation)
        try:
            next(self._steps, None)
            if simulation.over:
                next(self._steps, None)  # it takes in the last touchdown, and its callbacks away
        except LawError:
            raise
        except (Exception, SystemExit) as error:
            if is_interrupt(error):
                raise
            raise WalkStopped(self.run.message(error), self.run.record()) from error
        self._note(self.time - before)
        return True

    def _note(self, duration: float) -> None:
        """Update mean force, greatest torque and paths of the feet with the last step."""
        simulation, u = self.run.simulation, self.run.simulation.state
        stance, torque, bodies = int(u.stance), max(map(abs, u.torque)), self.robot.bodies
        if stance != self._stance:
            self._stance, self._span, self._impulse = stance, 0.0, 0j
        forces = [contact_force(simulation.model, simulation.data, foot) for foot in bodies.feet(bodies.limbs[stance])]
        self._impulse, self._span = self._impulse + duration * sum(forces), self._span + duration
        if self.scales.torque < torque < math.inf:
            self.scales = self.scales._replace(torque=float(torque))
        for way, foot in zip(self._ways, self._feet(), strict=True):
            if not way or math.dist(foot, way[-1][1]) > scene.APART * self.robot.leg_length:
                way.append((self.time, foot))
            while way[0][0] < self.time - scene.TRACE:
                way.popleft()

    def _feet(self) -> list[Pair]:
        """Places of the feet, x and z in m."""
        return [(x, z) for x, z in self.robot.limbs(self.run.simulation.data.qpos[self._order])[:, -1].tolist()]

    def moment(self) -> Moment:
        """Return the present instant; the force is the mean since the last call."""
        simulation, controller, tracked = self.run.simulation, self._plan.controller, None
        u, memory, qpos = simulation.state, simulation.memory, simulation.data.qpos[self._order]
        if self._span > 0.0:
            force = self._impulse / self._span
            self._force, self._span, self._impulse = (force.real, force.imag), 0.0, 0j
        if isinstance(controller, Tracking):
            tracked, _ = controller.tracked(memory, self.time - u.transfer_time)
        feet, ground, reference = beside_posture(self.robot, self.terrain, qpos, int(u.stance), u.slope, tracked)
        return Moment(
            time=self.time,
            step=self.steps + 1,
            qpos=tuple(qpos.tolist()),
            stance=int(u.stance),
            slope=u.slope,
            slope_estimate=controller.slope_estimate(memory),
            torque=tuple(u.torque[: len(self.robot.joints)]),
            force=self._force,
            reference=reference,
            ground=ground,
            traces=tuple(
                np.array([*(point for _, point in way), foot]) for way, foot in zip(self._ways, feet, strict=True)
            ),
        )

    def show(self) -> None:
        """Copy the walk's state, contacts and forces for the window, which may change the copy."""
        simulation = self.run.simulation
        if self._seen is not simulation.model:
            self._seen = simulation.model
            self.model = copy.copy(simulation.model)
            scene.fit_cameras(self.model, self.robot.leg_length)
            self.data = mujoco.MjData(self.model)
        mujoco.mj_copyData(self.data, self.model, simulation.data)
        self.data.userdata[:] = 0.0  # so no callback takes it for a walk
        scene.place(self.model, self.data)


def contact_force(model: mujoco.MjModel, data: mujoco.MjData, foot: str) -> complex:
    """Sum of the contact forces on a foot in the last step, forward and upward as x + iz, N."""
    geom, total, wrench = model.geom(foot).id, 0j, np.zeros(6)
    for index, pair in enumerate(data.contact.geom.tolist()):
        if geom in pair:
            mujoco.mj_contactForce(model, data, index, wrench)
            # rows of the frame are the contact's axes; the force is that of the first geom on the second
            x, _, z = (data.contact.frame[index].reshape(3, 3).T @ wrench[:3]).tolist()
            total += complex(x, z) if pair[1] == geom else -complex(x, z)
    return total


class Replay:
    """A record of either engine, in which time can run forwards and backwards; it is shown as a `LiveWalk` is."""

    goes_back = True
    news = ""

    def __init__(self, walk: Walk) -> None:
        """Build the scene about the start of the record.

        Raises:
            RenderError: The record holds no samples.
        """
        times = walk.samples["time"]
        if not len(times):
            raise RenderError("the record holds no samples: there is nothing to show")
        self.robot, self.terrain, self._walk = walk.robot, walk.terrain, walk
        self._begin, self._end = float(times[0]), float(times[-1])
        self._moments = moments_of(walk)
        self.scales = Scales(self._moments.greatest_torque(self._begin, self._end), walk.robot.weight)
        self._scene = scene_of(walk)
        self.restart()
        self.show()

    @property
    def time(self) -> float:
        """Time of the record, s."""
        return self._moment.time

    @property
    def ended(self) -> str:
        """Outcome, at the end of the record."""
        return self._walk.outcome if self.time >= self._end else ""

    def go_to(self, time: float) -> None:
        """Go to a time (s) of the record, or to its start or end if that is nearer."""
        self._moment = self._moments.at(min(max(time, self._begin), self._end))

    def touchdown_beside(self, direction: int) -> None:
        """Go to the next (1) or last (-1) touchdown, or to the end or start of the record."""
        times = self._walk.touchdowns["time"]
        after, before = times[times > self.time + _SAME], times[times < self.time - _SAME]
        self.go_to(float(after.min(initial=self._end) if direction > 0 else before.max(initial=self._begin)))

    def restart(self) -> None:
        """Go back to the start."""
        self.go_to(self._begin)

    def next_seed(self) -> None:
        """Say in `news` that there is no other ground."""
        self.news = _NO_SEEDS

    def push(self, perturbation: mujoco.MjvPerturb) -> None:
        """Say in `news` that a record cannot be pushed."""
        if perturbation.active:
            self.news = "a record cannot be pushed"

    def moment(self) -> Moment:
        """Return the present instant."""
        return self._moment

    def show(self) -> None:
        """Set the robot to the present posture, for which MuJoCo computes contacts and forces."""
        self._scene.go_to(self._moment.qpos[0])
        self._scene.pose(self._moment, forces=True)
        self.model, self.data = self._scene.model, self._scene.data

    def close(self) -> None:
        """End the replay, which needs nothing."""


Source = LiveWalk | Replay
"""A walk that can be viewed."""
