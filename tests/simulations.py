"""Simulations of both engines, and MuJoCo scenes, by plain keyword arguments; robots to try them with."""

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import fields
from typing import Any

import mujoco
import numpy as np

from mjbiped import Compass, KneedBiped, ScuffingRule, Terrain
from mjbiped.control.controller import Controller, Memory, Unpowered
from mjbiped.disturbances.disturbances import UNDISTURBED, Disturbances
from mjbiped.engines.hybrid.engine import TOLERANCE, Hybrid, HybridRun
from mjbiped.engines.mujoco.engine import Mujoco, stepped
from mjbiped.engines.mujoco.ground import Ground
from mjbiped.engines.mujoco.options import Options
from mjbiped.engines.mujoco.scene import GroundWindows, Scene
from mjbiped.engines.mujoco.simulation import WHOLE_STATE, Simulation
from mjbiped.engines.plan import Plan, Terms
from mjbiped.records.columns import Recorder
from mjbiped.robots.robot import Robot

OPTIONS = {field.name for field in fields(Options)}

UNEQUAL = KneedBiped(3.1, 1.7, 7.3, 0.37, 0.58, 0.11, 0.23, 0.05, 0.021, 1.62)
"""Links of unequal length, and no other number of the default robot's."""


class Plain(Unpowered):
    """No motors, and no machine code: as a user's own class would come, without functions to compile."""

    def law(self) -> None:  # type: ignore[override]
        return None


class Torques(Controller):
    """Torques by a function of time, angles and rates, in plain Python."""

    def __init__(self, law: Callable[[float, Sequence[float], Sequence[float]], Sequence[float]]) -> None:
        self.law_of = law

    def torque(self, memory: Memory, t: float, q: Sequence[float], dq: Sequence[float]) -> Sequence[float]:
        return self.law_of(t, q, dq)


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


def started(controller: Controller, terrain: Terrain, **settings: Any) -> Simulation:
    """A simulation from the start of the controller's gait, or from rest; of 60 steps unless told otherwise."""
    robot = settings.pop("robot", None) or controller.robot or Compass()
    size = len(robot.angles)
    start = controller.gait.start.tolist() if controller.gait else [0.0] * 2 * size
    given = {"robot": robot, "q": start[:size], "dq": start[size:], "steps": 60, **settings}
    return make_simulation(controller, terrain, **given)


def state_of(simulation: Simulation) -> bytes:
    """The whole state."""
    state = np.zeros(mujoco.mj_stateSize(simulation.model, WHOLE_STATE))
    mujoco.mj_getState(simulation.model, simulation.data, state, WHOLE_STATE)
    return state.tobytes()


def put(simulation: Simulation, state: bytes) -> None:
    """Set a simulation to a state of another one."""
    mujoco.mj_setState(simulation.model, simulation.data, np.frombuffer(state).copy(), WHOLE_STATE)


def recorded(simulation: Simulation) -> tuple[dict[str, Any], int]:
    """Walk to the end: all that is recorded, and the final state; and how many models it took."""
    recorder, models = Recorder(robot=type(simulation.plan.robot)), [simulation.model]
    for _ in stepped(simulation, recorder):
        if simulation.model is not models[-1]:
            models.append(simulation.model)
    state = {"state": np.frombuffer(state_of(simulation))}
    return {**recorder.samples(), **recorder.touchdowns(), **state}, len(models)


def assert_same(one: Mapping[str, Any], other: Mapping[str, Any]) -> None:
    """Bit by bit."""
    assert one.keys() == other.keys()
    for name, values in one.items():
        assert values.tobytes() == other[name].tobytes(), name


def assert_resumes(saved: Mapping[int, bytes], length: int, whole: Simulation, build: Callable[[], Simulation]) -> None:
    """States of a walk, by the number of steps made, lead to where it is after so many steps, bit by bit."""
    for step, state in saved.items():
        resumed = build()
        put(resumed, state)
        assert resumed.advance(length - step) == length - step
        assert state_of(resumed) == state_of(whole), f"saved at step {step}"


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
    """The scene of a robot on a whole terrain."""
    layout = Ground(terrain, reach=reach, kind=ground)
    return GroundWindows(robot, layout, timestep, math.inf, userdata, scenery).about(0.0)
