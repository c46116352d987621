"""`walk()`: a controller on a terrain in an engine, and what came of it."""

from __future__ import annotations

import dataclasses
import json
import math
import platform
from collections.abc import Sequence
from contextlib import ExitStack
from importlib.metadata import version
from numbers import Real
from typing import TYPE_CHECKING, Any, Protocol

import mujoco
import numpy as np
import scipy
from numpy.typing import NDArray

from mjbiped import events
from mjbiped.compass import Compass
from mjbiped.errors import InputError, MjbipedError
from mjbiped.events import Outcome
from mjbiped.gait import find_passive_gait
from mjbiped.hybrid import HybridRecorder, HybridSimulation, simulate_hybrid
from mjbiped.law_check import LawError
from mjbiped.physics import (
    DEFAULT_CONTACT_TIMESTEP,
    DEFAULT_TIMESTEP,
    Simulation,
    exclusive,
    simulate,
    walking,
)
from mjbiped.record import Walk
from mjbiped.recorder import Recorder
from mjbiped.scuffing import ScuffingRule
from mjbiped.terrain import Terrain
from mjbiped.version import __version__

if TYPE_CHECKING:
    from controllers.base import Controller

ENGINES = ("mujoco", "hybrid")
INITIAL_STATES = ("gait", "rest")
DEFAULT_STEPS = 60


class WalkStopped(MjbipedError):  # noqa: N818 (its sister is a KeyboardInterrupt, no Error either)
    """A walk was broken off by an error in the controller; what was recorded is not lost.

    Attributes:
        walk: The walk so far, with the outcome "interrupted".
    """

    def __init__(self, message: str, walk: Walk) -> None:
        """Keep the walk beside the message."""
        super().__init__(message)
        self.walk = walk


class WalkInterrupted(KeyboardInterrupt):
    """A walk was broken off by Ctrl-C; what was recorded is not lost.

    Attributes:
        walk: The walk so far, with the outcome "interrupted".
    """

    def __init__(self, walk: Walk) -> None:
        """Keep the walk."""
        super().__init__("walk interrupted")
        self.walk = walk


def walk(
    controller: Controller,
    terrain: Terrain,
    *,
    engine: str = "mujoco",
    steps: int | None = None,
    distance: float | None = None,
    initial: str | Sequence[float] = "gait",
    robot: Compass | None = None,
    timestep: float = DEFAULT_TIMESTEP,
    contact_timestep: float = DEFAULT_CONTACT_TIMESTEP,
    control_period: float | None = None,
    sample_period: float = 0.005,
    scuffing: ScuffingRule | None = None,
    ground: str = "auto",
    progress: bool = False,
) -> Walk:
    """Let a robot walk on a terrain until it has done its steps, or cannot go on.

    A fall is a result, not an exception: see `Walk.outcome`. The same arguments give bitwise the same record.

    Args:
        controller: Drives stance ankle and hip; see `controllers.Controller`.
        terrain: The ground; the robot starts with its (left) stance foot at x = 0.
        engine: "mujoco" (rigid bodies and contacts), or "hybrid" (the paper's equations and impact map; see
            docs/hybrid.md): it has no timestep, its controller acts without pause, and it refuses `timestep`,
            `contact_timestep`, `control_period` and `ground`.
        steps: Touchdowns after which the walk is finished; 60 unless a distance is given.
        distance: Place x of the stance foot at which it is finished, m. With both, the first to be reached counts.
        initial: "gait" (on the imitated limit cycle, just after an impact), "rest" (both legs together on the ground,
            at rest), or (q1, q2, dq1, dq2) from the ground's normal under x = 0, rad and rad/s.
        robot: The robot that walks; by default the controller's own model, or Table I.
        timestep: Longest physics step, s; steps become shorter toward each touchdown, which ends one of them.
        contact_timestep: Of the step that makes an impact, s; the timestep where that is shorter.
        control_period: Time between two ticks of the controller, s, a multiple of the timestep; by default it ticks at
            every physics step.
        sample_period: Time between two samples of the record, s; in MuJoCo each is taken at the next physics step.
        scuffing: When the swing foot may touch the ground.
        ground: "auto", "heightfield" or "boxes"; see `mjbiped.scene`.
        progress: Show a progress bar (never where the output is not a terminal).

    Returns:
        The record.

    Raises:
        InputError: An argument is outside its domain, or the controller's laws cannot be compiled; nothing has been
            computed then.
        GaitError: `initial="gait"` with a controller that imitates none, on a slope that has no passive gait.
        WalkStopped: The controller raised an exception; the error carries the walk so far.
        WalkInterrupted: Ctrl-C; a `KeyboardInterrupt` that carries the walk so far.
    """
    if engine not in ENGINES:
        raise InputError(f"unknown engine {engine!r}; valid are {', '.join(ENGINES)}")
    _check_controller(controller)
    if not isinstance(terrain, Terrain):
        raise InputError(f"terrain must be a mjbiped.Terrain, got {type(terrain).__name__}")
    if steps is None and distance is None:
        steps = DEFAULT_STEPS
    _check_limits(steps, distance, sample_period)
    robot = controller.robot or Compass() if robot is None else robot
    if not isinstance(robot, Compass):
        raise InputError(f"robot must be a mjbiped.Compass, got {type(robot).__name__}")
    if scuffing is not None and not isinstance(scuffing, ScuffingRule):
        raise InputError(f"scuffing must be a mjbiped.ScuffingRule, got {type(scuffing).__name__}")
    q, dq = _initial_state(initial, controller, robot, terrain)
    rule = scuffing or ScuffingRule()
    settings = {
        "engine": engine,
        "robot": dataclasses.asdict(robot),
        "controller": controller.describe(),
        "terrain": terrain.to_dict(),
        "initial": [*q, *dq],
        "steps": steps,
        "distance": distance,
        "sample_period": sample_period,
        "scuffing": dataclasses.asdict(rule),
        "versions": versions(),
    }
    common: dict[str, Any] = {"robot": robot, "q": q, "dq": dq, "steps": steps, "distance": distance, "scuffing": rule}
    with ExitStack() as stack:
        if engine == "hybrid":
            _check_hybrid(timestep, contact_timestep, control_period, ground)
            run: _Run = _HybridRun(HybridSimulation(controller, terrain, sample_period=sample_period, **common))
        else:
            stack.enter_context(exclusive())
            if walking():
                raise MjbipedError("a walk cannot be started from inside another's controller")
            times: dict[str, Any] = {
                "timestep": timestep,
                "contact_timestep": contact_timestep,
                "control_period": control_period,
            }
            simulation = Simulation(controller, terrain, sample_period=sample_period, ground=ground, **times, **common)
            run = _MujocoRun(simulation, {**times, "ground": ground})
        settings.update(run.settings)
        try:
            outcome = run.go(progress)
        except KeyboardInterrupt as stop:
            raise WalkInterrupted(run.record(Outcome.INTERRUPTED, settings)) from stop
        except LawError:
            raise
        except Exception as error:
            if _is_interrupt(error):
                raise WalkInterrupted(run.record(Outcome.INTERRUPTED, settings)) from error
            partial = run.record(Outcome.INTERRUPTED, settings)
            place = f"at {partial.end[0]:.3f} s, after {partial.steps} steps"
            raise WalkStopped(
                f"{type(controller).__name__} failed {place}: {type(error).__name__}: {error}", partial
            ) from error
        return run.record(outcome, {**settings, **run.notes()})


class _Run(Protocol):
    """A walk in one engine: what `walk` needs to know of it."""

    settings: dict[str, Any]

    def go(self, progress: bool) -> Outcome: ...

    def notes(self) -> dict[str, Any]: ...

    def record(self, outcome: Outcome, settings: dict[str, Any]) -> Walk: ...


class _MujocoRun:
    def __init__(self, simulation: Simulation, settings: dict[str, Any]) -> None:
        self.simulation = simulation
        self.recorder = Recorder()
        self.settings = settings

    def go(self, progress: bool) -> Outcome:
        return simulate(self.simulation, self.recorder, progress=progress)

    def notes(self) -> dict[str, Any]:
        return {"warnings": dict(self.simulation.warnings)}

    def record(self, outcome: Outcome, settings: dict[str, Any]) -> Walk:
        u = self.simulation.data.userdata
        peak = np.array([u[events.PEAK_ANKLE], u[events.PEAK_HIP]])
        return _record(self.recorder, outcome, peak, settings)


class _HybridRun:
    def __init__(self, simulation: HybridSimulation) -> None:
        self.simulation = simulation
        self.recorder = HybridRecorder()
        self.settings: dict[str, Any] = {"tolerance": simulation.world.tolerance, "compiled": simulation.compiled}

    def go(self, progress: bool) -> Outcome:
        return simulate_hybrid(self.simulation, self.recorder, progress=progress)

    def notes(self) -> dict[str, Any]:
        return {}

    def record(self, outcome: Outcome, settings: dict[str, Any]) -> Walk:
        return _record(self.recorder, outcome, self.simulation.peak_torque, settings)


def _record(
    recorder: Recorder | HybridRecorder, outcome: Outcome, peak_torque: NDArray[np.float64], settings: dict[str, Any]
) -> Walk:
    """What a recorder holds, as a walk."""
    samples = recorder.samples()
    begun = len(samples["time"]) > 0
    return Walk(
        samples=samples,
        touchdowns=recorder.touchdowns(),
        outcome=outcome.words,
        end=(float(samples["time"][-1]), float(samples["qpos"][-1, 0])) if begun else (0.0, 0.0),
        peak_torque=peak_torque,
        settings=settings,
    )


def _is_interrupt(error: BaseException | None) -> bool:
    """Whether Ctrl-C is behind an error: one that comes while MuJoCo's C code runs can surface as a SystemError."""
    while error is not None:
        if isinstance(error, KeyboardInterrupt):
            return True
        error = error.__cause__ or error.__context__
    return False


def _check_hybrid(timestep: float, contact_timestep: float, control_period: float | None, ground: str) -> None:
    """Refuse what only a time-stepping engine can do.

    Raises:
        InputError: An argument was given that the hybrid engine does not have.
    """
    for name, given in (
        ("timestep", timestep != DEFAULT_TIMESTEP),
        ("contact_timestep", contact_timestep != DEFAULT_CONTACT_TIMESTEP),
        ("control_period", control_period is not None),
        ("ground", ground != "auto"),
    ):
        if given:
            raise InputError(f"{name} is for the engine mujoco; the hybrid engine integrates without a fixed step")


def _check_controller(controller: object) -> None:
    """Refuse what lacks a controller's parts.

    Raises:
        InputError: A part is missing; the message names them all.
    """
    parts = ("states", "memory_size", "robot", "gait", "start", "on_touchdown", "torque", "slope_estimate", "describe")
    missing = [part for part in parts if not hasattr(controller, part)]
    if isinstance(controller, type) or missing:
        what = "is a class, not an object of it" if isinstance(controller, type) else f"lacks {', '.join(missing)}"
        raise InputError(f"the controller {controller!r} {what}; derive your class from controllers.Controller")
    named = type(controller).__name__
    states: Any = controller.states  # type: ignore[attr-defined]
    size: Any = controller.memory_size  # type: ignore[attr-defined]
    if isinstance(states, str) or not all(isinstance(state, str) for state in states):
        raise InputError(f"{named}.states must be a tuple of names, got {states!r}")
    if not isinstance(size, int) or size < len(states):
        raise InputError(
            f"{named}.memory_size must be a whole number of at least its {len(states)} states, got {size!r}"
        )
    try:
        json.dumps(controller.describe())  # type: ignore[attr-defined]
    except (TypeError, ValueError) as error:
        raise InputError(f"{named}.describe() must give plain JSON types, for the record: {error}") from error


def _check_limits(steps: int | None, distance: float | None, sample_period: float) -> None:
    """Refuse limits that no walk can have.

    Raises:
        InputError: One is not a number above zero.
    """
    if steps is not None and (isinstance(steps, bool) or not isinstance(steps, int | np.integer) or steps < 1):
        raise InputError(f"steps must be a whole number of at least 1, got {steps!r}")
    for name, value in (("distance", distance), ("sample_period", sample_period)):
        if value is None and name == "distance":
            continue
        if not (isinstance(value, Real) and math.isfinite(value) and value > 0.0):
            raise InputError(f"{name} must be a finite number above zero, got {value!r}")


def _initial_state(
    initial: str | Sequence[float], controller: Controller, robot: Compass, terrain: Terrain
) -> tuple[tuple[float, float], tuple[float, float]]:
    """Angles from the ground's normal (rad) and rates (rad/s) at the start, stance leg first.

    Raises:
        InputError: The name is unknown, or the numbers are not four finite ones.
        GaitError: No passive gait exists on the slope under x = 0.
    """
    if isinstance(initial, str):
        if initial == "rest":
            return (0.0, 0.0), (0.0, 0.0)
        if initial == "gait":
            gait = controller.gait or find_passive_gait(robot, terrain.slope_at(0.0))
            q1, q2, dq1, dq2 = (float(value) for value in gait.start)
            return (q1, q2), (dq1, dq2)
        raise InputError(
            f"unknown initial state {initial!r}; valid are {', '.join(INITIAL_STATES)}, "
            "or four numbers q1, q2, dq1, dq2"
        )
    try:
        values = [float(value) for value in initial]
    except (TypeError, ValueError):
        values = []
    if len(values) != 4 or not all(map(math.isfinite, values)):
        raise InputError(f"an initial state is four finite numbers q1, q2, dq1, dq2; got {initial!r}")
    return (values[0], values[1]), (values[2], values[3])


def versions() -> dict[str, str]:
    """Versions of everything that a walk's numbers depend on."""
    return {
        "mjbiped": __version__,
        "mujoco": mujoco.__version__,
        "numba": version("numba"),
        "numpy": np.__version__,
        "scipy": scipy.__version__,
        "python": platform.python_version(),
        "machine": platform.machine(),
    }
