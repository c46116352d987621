"""Base classes of engines, and the engines by their names.

`Engine` checks and starts walks, `Run` is one walk. Your own engine derives from both.
"""

from __future__ import annotations

import math
from abc import ABC, abstractmethod
from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager, nullcontext
from functools import cache
from pkgutil import resolve_name
from typing import Any, ClassVar, TypeAlias

import numpy as np
from numpy.typing import NDArray

from mjbiped.control.functions import failure
from mjbiped.disturbances.disturbances import UNDISTURBED, Disturbances
from mjbiped.engines.compiling import Costs
from mjbiped.engines.plan import Plan
from mjbiped.errors import InputError
from mjbiped.records.columns import Cancellation, Recorder, never_cancelled
from mjbiped.records.loads import unknown
from mjbiped.records.measures import Summary
from mjbiped.records.record import Walk
from mjbiped.robots.compass import Compass
from mjbiped.robots.robot import Robot
from mjbiped.rules.termination import Outcome
from mjbiped.utils.domains import known_name
from mjbiped.utils.parallel import progress_bar

Show: TypeAlias = Callable[[int, float], None]
"""Function that takes the number of touchdowns since its last call and the stance foot's position x, m."""


class Engine(ABC):
    """A kind of physics and its settings; subclasses are frozen dataclasses, whose fields are the settings.

    Attributes:
        name: Name in records and messages.
        robots: Kinds of robots that it can simulate.
    """

    name: ClassVar[str]
    robots: ClassVar[tuple[type[Robot], ...]] = (Compass,)

    def check(self, plan: Plan) -> None:  # noqa: B027 (most engines take every plan)
        """Refuse a walk that this engine cannot make, before anything is computed.

        Raises:
            InputError: The engine cannot make this walk.
        """

    def check_disturbances(self, disturbances: Disturbances) -> None:
        """Refuse disturbances that this engine cannot apply; by default it can apply none.

        Raises:
            InputError: The disturbances do not fit.
        """
        if disturbances != UNDISTURBED:
            raise InputError(f"the engine {self.name} knows no disturbances; mujoco and hybrid do")

    def costs(self, robot: Robot) -> Costs | None:
        """What compiling and interpreting cost for a robot; None: this engine has no machine code, the default."""
        return None

    @abstractmethod
    def start(self, plan: Plan, *, summarised: bool = False, cancellation: Cancellation = never_cancelled) -> Run:
        """Start a walk: set the robot on the ground.

        Args:
            plan: The checked walk.
            summarised: Keep only what `Run.summary` needs, and no tables.
            cancellation: Called repeatedly during the walk; an exception that it raises stops the walk.

        Raises:
            MjbipedError: The walk cannot be started.
        """


class Run(ABC):
    """A walk that has been started.

    Attributes:
        plan: The checked walk.
        outcome: Outcome of the walk; "interrupted" until `go` has finished.
        recorder: Samples and touchdowns so far.
    """

    def __init__(self, plan: Plan, *, summarised: bool, cancellation: Cancellation) -> None:
        """Prepare the recording; see `Engine.start`."""
        self.plan = plan
        self._summarised, self._cancellation = summarised, cancellation
        self.outcome = Outcome.INTERRUPTED
        self.sampled = plan.terms.sample_period is not None and not summarised
        self.recorder = self._new_recorder()

    def _new_recorder(self) -> Recorder:
        """A recorder that holds nothing yet."""
        plan = self.plan
        return Recorder(
            robot=type(plan.robot),
            keep_samples=self.sampled,
            summary=Summary(plan.robot, plan.terrain) if self._summarised else None,
            cancellation=self._cancellation,
        )

    @abstractmethod
    def walk(self, show: Show) -> Outcome:
        """Walk to the end, keeping the recorder complete at any moment, even if this raises.

        Args:
            show: Function to call from time to time for the progress bar.

        Raises:
            MjbipedError: The walk cannot be continued; whatever the controller raises is passed on.
        """

    @abstractmethod
    def peak_torque(self) -> NDArray[np.float64]:
        """Greatest magnitude of each joint's torque so far, N m, shape (joints,)."""

    def pressure_times(self) -> NDArray[np.float64]:
        """Time that the centre of pressure spent in each bin, s; by default unknown. See `mjbiped.records.loads`."""
        return unknown()

    @abstractmethod
    def settings(self) -> dict[str, Any]:
        """Settings that the engine adds to those of the plan in the record; "warnings" counts warnings by text."""

    def compile(self) -> bool:
        """Compile what the walk needs now, after saying so, unless the walk is interpreted.

        Returns:
            Whether the walk runs in compiled code, which threads can share.

        Raises:
            InputError: The laws cannot be compiled.
        """
        return False

    def restart_compiled(self) -> bool:
        """Begin an interpreted walk again as machine code; return False where there is none, or not of all laws.

        Where Python raises an exception in arithmetic, such as a division by zero, machine code goes on with a number
        that is infinite or none.
        """
        return False

    def go(self, *, progress: bool = False) -> None:
        """Walk to the end.

        Args:
            progress: Show a progress bar (never where the output is not a terminal).
        """
        # even a hidden bar costs as much as two gait steps of the hybrid engine
        with self._progress_bar() if progress else nullcontext(lambda *_: None) as show:
            try:
                self.outcome = self.walk(show)
            except (ArithmeticError, ValueError):
                if not self.restart_compiled():
                    raise
                self.outcome = self.walk(show)

    def record(self) -> Walk:
        """The record so far."""
        return Walk(
            samples=self.recorder.samples(),
            touchdowns=self.recorder.touchdowns(),
            outcome=self.outcome.words,
            end=self.recorder.end,
            peak_torque=self.peak_torque(),
            pressure_times=self.pressure_times(),
            settings={**self.plan.settings(), **self.settings()},
        )

    def summary(self) -> dict[str, Any]:
        """The measures so far, for a walk that was started with `summarised`."""
        assert self.recorder.summary is not None
        return self.recorder.summary.to_dict(self.record())

    def message(self, error: BaseException) -> str:
        """Describe an error in the controller, with the time of the walk and the line of its source."""
        controller, at = self.plan.controller, self.recorder
        what = failure(error, controller)
        return f"{type(controller).__name__} failed at {at.end[0]:.3f} s, after {at.steps} steps: {what}"

    @contextmanager
    def _progress_bar(self) -> Iterator[Show]:
        terms = self.plan.terms
        with progress_bar(
            total=terms.steps or round(terms.distance or 0.0, 2),
            desc="walking",
            unit="step" if terms.steps else "m",
        ) as bar:

            def show(steps: int, x: float) -> None:
                bar.update(steps if terms.steps else max(0.0, round(x, 2) - bar.n))

            yield show


def step_under_way(**felt: float) -> dict[str, Any]:
    """A record's setting of what the stance foot has felt since the last touchdown: columns of touchdowns by name.

    Empty where that is not known yet, as just after a touchdown.
    """
    known = all(map(math.isfinite, felt.values()))
    return {"unfinished_step": {name: float(value) for name, value in felt.items()}} if known else {}


DEFAULT_ENGINE = "mujoco"
ENGINES: Mapping[str, str] = {
    "mujoco": "mjbiped.engines.mujoco.engine:Mujoco",
    "hybrid": "mjbiped.engines.hybrid.engine:Hybrid",
}
"""Where the class of each engine is, as "module:name"."""


def engine_of(engine: str | Engine) -> Engine:
    """Look up an engine by its name; an engine itself is returned as it is.

    Raises:
        InputError: There is no such engine.
    """
    if isinstance(engine, Engine):
        return engine
    if isinstance(engine, type) and issubclass(engine, Engine):
        raise InputError(f"the engine {engine.__name__} is a class; give an object of it, {engine.__name__}()")
    return _with_defaults(known_name("engine", engine, ENGINES))


@cache
def _with_defaults(name: str) -> Engine:
    engine: Engine = resolve_name(ENGINES[name])()
    return engine
