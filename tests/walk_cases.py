"""Walks drawn from a seed (robots, grounds, controllers, starts), and what no record of a walk can be."""

import math
from collections.abc import Callable, Iterator, Sequence
from typing import Any

import numpy as np

import mjbiped
from controllers import AdaptiveController, Controller, Memory, PassiveController
from mjbiped import Compass, ScuffingRule, Terrain, Walk
from mjbiped.terrain.profile import height_of, segment_stood_on
from mjbiped.utils.domains import ANGLE

TABLE_ONE = Compass()
PACE = math.sqrt(TABLE_ONE.gravity / TABLE_ONE.leg_length)


class Rude(Controller):
    """Torques in plain Python: constant, switching, growing with the rates, swinging, or no numbers from a time on."""

    def __init__(self, kind: int, size: float, late: float) -> None:
        self.kind, self.size, self.late = kind, size, late

    def torque(self, memory: Memory, t: float, q: Sequence[float], dq: Sequence[float]) -> Sequence[float]:
        size, late = self.size, self.late
        kinds = (
            (size, -size),
            (0.0, math.copysign(size, q[1] - q[0])),
            (-size * dq[0], -size * (dq[1] - dq[0])),
            (size * math.sin(t / late), size * math.cos(t / late)),
            (math.nan if late < t < 1.01 * late else 0.0, math.inf if t > 3.0 * late else 0.0),
        )
        return kinds[self.kind]


def _between(draw: np.random.Generator, low: float, high: float) -> float:
    """Evenly in the logarithm."""
    return math.exp(draw.uniform(math.log(low), math.log(high)))


def some_robot(draw: np.random.Generator) -> Compass:
    """Table I's, or one of any proportions."""
    if draw.random() < 0.3:
        return TABLE_ONE
    return Compass(
        leg_mass=_between(draw, 0.05, 50.0),
        hip_mass=float(draw.choice([0.0, _between(draw, 0.05, 100.0)])),
        lower_length=_between(draw, 0.02, 2.0),
        upper_length=_between(draw, 0.02, 2.0),
        leg_inertia=[None, None, 0.0, _between(draw, 1e-3, 2.0)][draw.integers(4)],  # type: ignore[arg-type]  # None: a rod's
        gravity=_between(draw, 1.0, 30.0),
    )


def some_ground(draw: np.random.Generator, leg: float) -> Terrain:
    """Of any kind, its lengths in legs of the length given, m."""
    highest, seed = min(0.3 * leg, 0.5), int(draw.integers(10**6))

    def segment() -> tuple[float, float, float]:
        riser = draw.uniform(-highest, highest) * (draw.random() < 0.5)
        return leg * draw.uniform(0.02, 1.5), draw.uniform(-30.0, 30.0), riser

    def rough() -> Terrain:
        """Of up to some thousand segments."""
        spacing, steepest = leg * float(draw.choice([0.02, 0.05, 0.25])), float(draw.choice([0.01, 0.1]))
        roughness = min(steepest * spacing, 0.5)
        return Terrain.random(seed=seed, length=max(1.0, 60.0 * leg), roughness=roughness, spacing=spacing)

    ranges: dict[str, Any] = {
        "segment_length": (0.1 * leg, 2.0 * leg),
        "slope_deg": (-20.0, 20.0),
        "rise": (-highest, highest),
    }
    kinds: tuple[Callable[[], Terrain], ...] = (
        Terrain.level,
        lambda: Terrain.incline(draw.uniform(-15.0, 15.0)),
        lambda: Terrain.stairs(tread=leg * draw.uniform(0.1, 3.0), rise=draw.uniform(-highest, highest), count=40),
        lambda: Terrain.slopes(length=leg * draw.uniform(0.1, 3.0), change_deg=draw.uniform(-0.8, 0.8), count=30),
        lambda: Terrain.random(seed=seed, length=max(1.0, 25.0 * leg), **ranges),
        rough,
        lambda: Terrain.from_segments(segment() for _ in range(60)),
    )
    return kinds[draw.integers(len(kinds))]()


def some_controller(draw: np.random.Generator, robot: Compass) -> Controller:
    """None, the paper's, or a rude one.

    Raises:
        GaitError: The robot has no passive gait to imitate.
    """
    faster = math.sqrt(robot.gravity / robot.leg_length) / PACE
    kind = draw.random()
    if kind < 0.35:
        return PassiveController()
    if kind < 0.5:
        moment = robot.weight * robot.leg_length
        return Rude(int(draw.integers(5)), moment * _between(draw, 1e-3, 10.0), _between(draw, 0.01, 1.0) / faster)
    gait = mjbiped.find_passive_gait(robot, math.radians(draw.uniform(0.5, 4.0)))
    return AdaptiveController(
        robot,
        gait,
        position_gain=5.0 * faster * _between(draw, 0.3, 10.0),
        velocity_gain=12.0 * faster * _between(draw, 0.3, 10.0),
    )


def some_start(draw: np.random.Generator, robot: Compass) -> str | tuple[float, float, float, float]:
    """By name, with both feet on the plane, or anyhow."""
    rate = math.sqrt(robot.gravity / robot.leg_length)
    kind = draw.random()
    if kind < 0.3:
        return "gait"
    if kind < 0.4:
        return "rest"
    lean = draw.uniform(0.0, 0.4)
    if kind < 0.7:
        return -lean, lean, rate * draw.uniform(0.0, 0.7), rate * draw.uniform(-0.3, 0.7)
    return draw.uniform(-0.6, 0.2), draw.uniform(-0.3, 0.6), rate * draw.uniform(-0.3, 1), rate * draw.uniform(-1, 1)


def some_walk(seed: int, engine: str) -> Walk | None:
    """The walk of a seed; None where it is refused."""
    draw = np.random.default_rng(seed)
    robot = some_robot(draw)
    leg, faster = robot.leg_length, math.sqrt(robot.gravity / robot.leg_length) / PACE
    more: dict[str, Any] = {}
    physics: mjbiped.Engine | str = engine
    if engine == "mujoco":
        timestep = min(2e-3, 4e-4 / faster)
        ground = str(draw.choice(["auto", "boxes", "heightfield"]))
        physics = mjbiped.Mujoco(timestep=timestep, contact_timestep=0.1 * timestep, ground=ground)
    if draw.random() < 0.2:
        more["distance"] = leg * _between(draw, 1e-3, 5.0)
    try:
        return mjbiped.walk(
            some_controller(draw, robot),
            some_ground(draw, leg),
            engine=physics,
            robot=robot,
            initial=some_start(draw, robot),
            steps=20,
            scuffing=ScuffingRule(reach=float(draw.choice([0.01, 0.1, 0.2, 0.2, 0.4])), delay=0.1 / faster),
            **more,
        )
    except (mjbiped.InputError, mjbiped.GaitError):
        return None


def energy(robot: Compass, qpos: Sequence[float], q: Sequence[float], dq: Sequence[float]) -> float:
    """Of a robot whose stance foot rests, J: q and dq of stance and swing leg, qpos as in records."""
    swung = robot.kinetic_energy(q, dq)
    height = robot.hip_mass * qpos[1]
    height += sum(robot.leg_mass * (qpos[1] - robot.upper_length * math.cos(leg)) for leg in qpos[2:])
    return swung + robot.gravity * height


def faults(walk: Walk) -> Iterator[str]:
    """What is impossible in a record, in words."""
    robot, terrain, table = Compass(**walk.settings["robot"]), walk.terrain, walk.touchdowns
    hybrid = walk.settings["engine"] == "hybrid"
    leg, scale = robot.leg_length, robot.weight * robot.leg_length
    # hybrid: a touchdown is located to 1e-8 s and polished. MuJoCo: contacts give way, to half of `events.MISSED`
    foot_limit = 1e-6 if hybrid else 0.01
    moved_limit = 1e-9 if hybrid else 0.102  # `SLIPPED_FOOT`, and the physics step in which it is passed
    stood = (0.0, terrain.height_at(0.0))
    before = None
    followed = walk.outcome not in ("diverged", "unresolved")
    for row in range(walk.steps):
        qpos, stance = table["qpos"][row], table["stance"][row]
        new, old = (qpos[3], qpos[2]) if stance else (qpos[2], qpos[3])
        x, z = qpos[0] - leg * math.sin(new), qpos[1] - leg * math.cos(new)
        height = height_of(terrain.profile, segment_stood_on(terrain.profile, x, z), x)
        if abs(z - height) > foot_limit * leg:
            yield f"step {row + 1}: a foot {z - height:.3g} m over the ground touches down"
        moved = math.hypot(qpos[0] - leg * math.sin(old) - stood[0], qpos[1] - leg * math.cos(old) - stood[1])
        if moved > moved_limit * leg:
            yield f"step {row + 1}: the stance foot moved by {moved:.3g} m"
        stood = (table["x"][row], table["z"][row])
        stands = table["slip"][row] < 1e-3 * leg and table["normal_force"][row] > 0.0 and not table["strikes"][row]
        known = np.abs(table["q_before"][row]).max() <= ANGLE.high  # a leg may turn over and over
        if (
            not followed or not known or not (hybrid or stands)
        ):  # the energy of a foot that slides or flies is not in the record
            before = None
            continue
        arrives = energy(robot, qpos, table["q_before"][row], table["dq_before"][row])
        leaves = energy(robot, qpos, table["q"][row], table["dq"][row])
        if leaves > arrives + 1e-9 * (scale + abs(arrives)) and (hybrid or leaves > arrives + 0.02 * scale):
            yield f"step {row + 1}: the impact adds {leaves - arrives:.3g} J"
        if before is not None:
            work = table["work_net"][row] - table["work_net"][row - 1]
            gained = arrives - before - work
            # integration's tolerance is 1e-8 a step; MuJoCo's feet slide, which the energy here does not know
            if gained > (1e-6 if hybrid else 0.05) * (scale + abs(before) + abs(work)):
                yield f"step {row + 1}: {gained:.3g} J more than work was done"
        before = leaves
