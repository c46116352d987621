"""Simulations of both engines, and MuJoCo scenes, by plain keyword arguments; robots to try them with."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import fields
from typing import Any

from mjbiped.control.controller import Controller
from mjbiped.control.unpowered import Unpowered
from mjbiped.disturbances.disturbances import UNDISTURBED, Disturbances
from mjbiped.engines.hybrid.engine import Hybrid
from mjbiped.engines.hybrid.run import TOLERANCE, HybridRun
from mjbiped.engines.mujoco.engine import Mujoco
from mjbiped.engines.mujoco.ground import Ground
from mjbiped.engines.mujoco.options import Options
from mjbiped.engines.mujoco.scene import Scene, compose_scene
from mjbiped.engines.mujoco.simulation import Simulation
from mjbiped.engines.plan import Plan, Terms
from mjbiped.robots.compass import Compass
from mjbiped.robots.kneed import KneedBiped
from mjbiped.robots.robot import Robot
from mjbiped.rules.scuffing import ScuffingRule
from mjbiped.terrain.terrain import Terrain

OPTIONS = {field.name for field in fields(Options)}

UNEQUAL = KneedBiped(3.1, 1.7, 7.3, 0.37, 0.58, 0.11, 0.23, 0.05, 0.021, 1.62)
"""Links of unequal length, and no other number of the default robot's."""


class Plain(Unpowered):
    """No motors, and no machine code: as a user's own class would come, without functions to compile."""

    def law(self) -> None:  # type: ignore[override]
        return None


def hybrid_simulation(terrain: Terrain, start: Sequence[float], **settings: Any) -> HybridRun:
    """An unpowered robot in the hybrid engine in plain Python: with knees, if the state has six numbers."""
    half = len(start) // 2
    robot = KneedBiped() if half == 3 else Compass()
    return hybrid_run(
        Unpowered(), terrain, **{"robot": robot, "compile": False, **settings}, q=start[:half], dq=start[half:]
    )


def hybrid_run(
    controller: Controller,
    terrain: Terrain,
    *,
    robot: Robot,
    q: Sequence[float],
    dq: Sequence[float],
    steps: int | None = None,
    distance: float | None = None,
    sample_period: float | None = 0.005,
    scuffing: ScuffingRule = ScuffingRule(),  # noqa: B008 (frozen)
    disturbances: Disturbances = UNDISTURBED,
    tolerance: float = TOLERANCE,
    compile: bool | None = None,
) -> HybridRun:
    """A walk in the hybrid engine that nobody has checked; with neither steps nor distance it goes on for long."""
    steps = 10**6 if steps is None and distance is None else steps
    terms = Terms(Hybrid(tolerance), steps, distance, robot, sample_period, scuffing)
    plan = Plan(terms, controller, controller.driving(robot), terrain, robot, tuple(q), tuple(dq), {}, disturbances)
    return HybridRun(plan, tolerance, compile=compile)


def make_simulation(
    controller: Controller, terrain: Terrain, *, robot: Robot, q: Sequence[float], dq: Sequence[float], **settings: Any
) -> Simulation:
    """A simulation from a first state that need not be checked; settings of engine and terms stand side by side."""
    engine = Mujoco(**{name: settings.pop(name) for name in [*settings] if name in OPTIONS})
    built = {name: settings.pop(name) for name in ("compile", "scenery") if name in settings}
    disturbances = settings.pop("disturbances", UNDISTURBED)
    given = {"steps": None, "distance": None, "sample_period": 100.0, "scuffing": ScuffingRule(), **settings}
    terms = Terms(engine, robot=robot, **given)
    if settings.get("steps") is None:
        object.__setattr__(terms, "steps", None)  # without an end, where `walk` has one
    plan = Plan(terms, controller, controller.driving(robot), terrain, robot, tuple(q), tuple(dq), {}, disturbances)
    return Simulation(plan, engine, **built)


def build_scene(
    robot: Robot,
    terrain: Terrain,
    *,
    timestep: float,
    reach: float,
    ground: str = "auto",
    userdata: int = 0,
    scenery: bool = False,
) -> Scene:
    """The scene of a robot on a whole terrain; see `compose_scene`."""
    layout = Ground(terrain, reach=reach, kind=ground)
    return compose_scene(robot, layout, layout.segments, timestep=timestep, userdata=userdata, scenery=scenery)
