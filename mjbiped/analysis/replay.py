"""The reference that a recorded walk's controller tracked: the controller rebuilt, and its plans at the touchdowns."""

from __future__ import annotations

import bisect
import math
from collections.abc import Iterator
from dataclasses import replace
from typing import Any, NamedTuple

import numpy as np

from mjbiped.control.controller import Controller
from mjbiped.control.registry import controller_from
from mjbiped.control.tracking import AdaptiveTracking, Tracking
from mjbiped.disturbances.disturbances import DEFAULT_PERIOD, Disturbances
from mjbiped.disturbances.loop import SampledController
from mjbiped.errors import InputError, MjbipedError
from mjbiped.gaits.described import gait_from
from mjbiped.gaits.gait import Gait
from mjbiped.records.record import Walk
from mjbiped.robots.compass import Array

_POINTS = 60  # on the curve of a transition


def recorded_controller(walk: Walk, named: str | None = None, kind: Any = AdaptiveTracking) -> Any:
    """Rebuild the controller of a walk from its record.

    Args:
        walk: The record.
        named: Module and name of the class, if it is the user's own; see `mjbiped.control.registry.controller_from`.
        kind: What it must be: `Tracking` if it tracks any reference, `AdaptiveTracking` if it is the paper's law.

    Raises:
        InputError: Another controller walked, or it is the user's own and not named.
        GaitError: The gait that it imitated is not found.
    """
    controller = controller_from(walk.settings["controller"], walk.settings.get("controller_source"), named)
    if not isinstance(controller, kind):
        wanted = (
            "an adaptive controller for straight legs" if kind is AdaptiveTracking else "one that tracks a reference"
        )
        raise InputError(f"this needs {wanted}, and this walk's is {type(controller).__name__}")
    return controller


class StepStart(NamedTuple):
    """The beginning of a step.

    Attributes:
        time: Time since the walk's start, s.
        slope: Slope of the ground under the stance foot, rad.
        q: Angles of the robot from the ground's normal, stance leg first, rad.
        dq: Their rates, rad/s.
    """

    time: float
    slope: float
    q: list[float]
    dq: list[float]


def replayed(walk: Walk, controller: Controller) -> Iterator[tuple[StepStart, list[float]]]:
    """Replay the controller's memory at the beginning of each step, the unfinished last one included.

    It includes what was planned at touchdowns, with the sensors' errors at the time. The integrated states are not
    carried on through a step: a caller who needs them writes those of the step's end into the memory before asking for
    the next step.

    Args:
        walk: The record.
        controller: The law that walked.
    """
    walked = _behind_its_sensors(walk, controller)
    memory = [0.0] * walked.memory_size  # the controller's own comes first
    initial: list[float] = walk.settings["initial"]
    half = len(initial) // 2
    started = StepStart(0.0, walk.terrain.slope_at(0.0), initial[:half], initial[half:])
    walked.start(memory, started.q, started.dq)
    yield started, memory
    rows = walk.touchdowns
    asks = walked.support >= 0 and "support_behind" in rows
    steps = zip(
        *(rows[name].tolist() for name in ("time", "slope", "q_before", "q", "dq")), knee_strikes(walk), strict=True
    )
    for k, (time, slope, before, q, dq, strike) in enumerate(steps):
        if strike < math.inf:
            walked.on_knee_strike(memory, strike, before, before)  # whatever the state, the knee is locked from then on
        if asks:
            memory[walked.support] = float(rows["support_behind"][k])
            memory[walked.support + 1] = float(rows["support_ahead"][k])
        walked.on_touchdown(memory, before, q, dq)
        yield StepStart(time, slope, q, dq), memory


def knee_strikes(walk: Walk) -> list[float]:
    """Time of the knee strike in each complete step, since the step's beginning, s; infinite where there was none."""
    if "knee_strike" not in walk.touchdowns:
        return [math.inf] * len(walk.touchdowns["time"])
    return [strike if math.isfinite(strike) else math.inf for strike in walk.touchdowns["knee_strike"].tolist()]


def _behind_its_sensors(walk: Walk, controller: Controller) -> Controller:
    """The controller behind disturbed sensors; nothing else of the disturbed loop matters at touchdowns."""
    disturbances = Disturbances.from_dict(walk.settings.get("disturbances", {}))
    if not disturbances.in_loop:
        return controller
    return SampledController(controller, replace(disturbances, delay=0.0, torque_limit=None), DEFAULT_PERIOD)


def transitions(walk: Walk, controller: Tracking) -> list[Array]:
    """The re-planned trajectories of a walk (section IV-B), each as far as it was walked with the swing knee free.

    Args:
        walk: The record.
        controller: The law that walked.

    Returns:
        One per step that was re-planned: the robot's angles (rad), then their rates (rad/s), shape (n, 2 angles).
    """
    ends = [*walk.touchdowns["time"].tolist(), walk.end[0]]
    found = []
    for (started, memory), end, strike in zip(
        replayed(walk, controller), ends, [*knee_strikes(walk), math.inf], strict=True
    ):
        duration = min(controller.transition_end(memory), end - started.time, strike)
        if duration > 0.0:
            time = np.linspace(0.0, duration, _POINTS).tolist()
            found.append(np.array([np.concatenate(controller.tracked(memory, t)) for t in time]))
    return found


def drawn_transitions(walk: Walk) -> list[Array]:
    """The re-planned trajectories for pictures; none where the record does not tell what was planned."""
    try:
        return transitions(walk, recorded_controller(walk, kind=Tracking))
    except (MjbipedError, ArithmeticError, ValueError):
        return []


def drawn_gait(walk: Walk) -> Gait | None:
    """The gait that a walk's controller imitated, for pictures; None where the record has none for this robot."""
    described = walk.settings["controller"].get("gait")
    try:
        gait = None if described is None else gait_from(described)
    except MjbipedError:
        return None
    return gait if isinstance(gait, Gait) and gait.robot.kind == walk.robot.kind else None


class TrackedReference:
    """The reference that a walk's controller tracked, at any time of the record."""

    def __init__(self, walk: Walk, controller: Tracking) -> None:
        """Replay all plans of a walk.

        Args:
            walk: The record.
            controller: The law that walked.
        """
        self._controller = controller
        self._nothing = (0.0,) * len(walk.robot.angles)
        self._starts: list[float] = []
        self._memories: list[list[float]] = []
        time, states = walk.samples["time"], walk.samples["controller_states"]
        ends = [*walk.touchdowns["time"].tolist(), walk.end[0]]
        for (started, memory), end in zip(replayed(walk, controller), ends, strict=True):
            self._starts.append(started.time)
            self._memories.append(list(memory))
            last = int(np.searchsorted(time, end, side="left")) - 1
            if last >= 0:  # the integrated states at the step's end, as near as samples are
                memory[: states.shape[1]] = states[last].tolist()

    def at(self, time: float, *, locked: bool = False) -> tuple[float, ...]:
        """Angles of the reference from the ground's normal, stance leg first, rad.

        Args:
            time: Time in the record, s.
            locked: Whether the swing knee is locked, if there is one.
        """
        step = max(0, bisect.bisect_right(self._starts, time + 1e-9) - 1)
        memory, t = self._memories[step], time - self._starts[step]
        if locked:
            memory = list(memory)
            self._controller.on_knee_strike(memory, t, self._nothing, self._nothing)
        return tuple(self._controller.tracked(memory, t)[0])
