"""`walk()`: a controller on a terrain in an engine, and what came of it."""

from __future__ import annotations

import math
from abc import ABC, abstractmethod
from collections.abc import Sequence
from contextlib import ExitStack
from typing import TYPE_CHECKING, Any

import mujoco
import numpy as np
from numpy.typing import NDArray

from mjbiped.control.check import LawError
from mjbiped.engines.hybrid.simulation import HybridRecorder, HybridSimulation, simulate_hybrid
from mjbiped.engines.mujoco import contact_events as events
from mjbiped.engines.mujoco.compiled.registry import exclusive, walking
from mjbiped.engines.mujoco.run import simulate
from mjbiped.engines.mujoco.simulation import DEFAULT_CONTACT_TIMESTEP, DEFAULT_TIMESTEP, Simulation
from mjbiped.engines.plan import DEFAULT_SAMPLE_PERIOD, Plan, Terms, planned
from mjbiped.errors import MjbipedError
from mjbiped.records.measures import Summary
from mjbiped.records.record import Walk
from mjbiped.records.recorder import Heed, Recorder, unheeded
from mjbiped.robots.compass import Compass
from mjbiped.rules.scuffing import ScuffingRule, chosen
from mjbiped.rules.termination import Outcome
from mjbiped.terrain.terrain import Terrain

if TYPE_CHECKING:
    from mjbiped.control.controller import Controller


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
    sample_period: float | None = DEFAULT_SAMPLE_PERIOD,
    scuffing: ScuffingRule | None = None,
    ground: str = "auto",
    progress: bool = False,
) -> Walk:
    """Let a robot walk on a terrain until it has done its steps, or cannot go on.

    A fall is a result, not an exception: see `Walk.outcome` and `Walk.warnings`. The same arguments give bitwise the
    same record.

    Args:
        controller: Drives stance ankle and hip; see `controllers.Controller`.
        terrain: The ground; the robot starts with its (left) stance foot at x = 0.
        engine: "mujoco" (rigid bodies and contacts), or "hybrid" (the paper's equations and impact map; see
            docs/hybrid.md): it has no timestep, its controller acts without pause, and it refuses `timestep`,
            `contact_timestep`, `control_period` and `ground`.
        steps: Touchdowns after which the walk is finished; 60 unless a distance is given.
        distance: Place x of the stance foot at which it is finished, m. With both, the first to be reached counts.
        initial: "gait" (on the imitated limit cycle, just after an impact), "rest" (both legs together on the ground,
            at rest), or (q1, q2, dq1, dq2) from the ground's normal under x = 0, rad and rad/s. Hip and swing foot are
            not under the ground, but for the hundredth of a leg length by which a straight swing leg scuffs.
        robot: The robot that walks; by default the controller's own model, or Table I.
        timestep: Longest physics step, s; steps become shorter toward each touchdown, which ends one of them.
        contact_timestep: Of the step that makes an impact, s; the timestep where that is shorter.
        control_period: Time between two ticks of the controller, s, a multiple of the timestep; by default it ticks at
            every physics step.
        sample_period: Time between two samples of the record, s; in MuJoCo each is taken at the next physics step.
            None: no samples, for long or many walks; nothing can then be drawn of them.
        scuffing: When the swing foot may touch the ground. A gait whose swing foot it would never let land, because
            the steps are shorter than the rule's reach, is refused.
        ground: "auto", "heightfield" or "boxes"; see `mjbiped.engines.mujoco.scene`.
        progress: Show a progress bar (never where the output is not a terminal), and say it on stderr, wherever that
            goes, when this kind of controller has to be compiled first.

    Returns:
        The record.

    Raises:
        InputError: An argument is outside its domain, or the controller's laws cannot be compiled; nothing has been
            computed then.
        GaitError: `initial="gait"` with a controller that imitates none, on a slope that has no passive gait.
        WalkStopped: The controller raised an exception; the error carries the walk so far.
        WalkInterrupted: Ctrl-C; a `KeyboardInterrupt` that carries the walk so far.
    """
    terms = Terms(
        engine=engine,
        steps=steps,
        distance=distance,
        robot=robot,
        timestep=timestep,
        contact_timestep=contact_timestep,
        control_period=control_period,
        sample_period=sample_period,
        scuffing=chosen(scuffing),
        ground=ground,
    )
    plan = planned(terms, controller, terrain, initial)
    with ExitStack() as stack:
        if engine == "mujoco":
            stack.enter_context(exclusive())
            if walking():
                raise MjbipedError("a walk cannot be started from inside another's controller")
        run = begun(plan)
        try:
            run.go(progress=progress)
        except LawError:
            raise
        except BaseException as error:
            if is_interrupt(error):
                raise WalkInterrupted(run.record()) from error
            if not isinstance(error, Exception):
                raise
            raise WalkStopped(run.told(error), run.record()) from error
        return run.record()


class Run(ABC):
    """A walk that has been begun in one of the engines.

    Attributes:
        plan: As checked.
        outcome: "interrupted" until `go` has come to the walk's end.
    """

    def __init__(self, plan: Plan, recorder: Recorder) -> None:
        """Keep what every engine needs."""
        self.plan = plan
        self.outcome = Outcome.INTERRUPTED
        self._recorder = recorder

    def go(self, *, progress: bool = False) -> None:
        """Walk to the end; what is recorded is complete at any moment, also when this raises.

        Args:
            progress: Show a progress bar (never where the output is not a terminal).
        """
        self.outcome = self._go(progress)

    def record(self) -> Walk:
        """The record so far."""
        return Walk(
            samples=self._recorder.samples(),
            touchdowns=self._recorder.touchdowns(),
            outcome=self.outcome.words,
            end=self._recorder.end,
            peak_torque=self._peak_torque(),
            settings={**self.plan.settings(), **self._settings()},
        )

    def summary(self) -> dict[str, Any]:
        """The measures so far, of a recorder that was begun with a `measures.Summary`."""
        return self._recorder.summary().told(
            outcome=self.outcome.words,
            end=self._recorder.end,
            peak_torque=self._peak_torque(),
            warnings=self._settings().get("warnings", {}),
        )

    def told(self, error: Exception) -> str:
        """What went wrong in the controller, and when."""
        named, at = type(self.plan.controller).__name__, self._recorder
        return f"{named} failed at {at.end[0]:.3f} s, after {at.steps} steps: {type(error).__name__}: {error}"

    @abstractmethod
    def _go(self, progress: bool) -> Outcome: ...

    @abstractmethod
    def _peak_torque(self) -> NDArray[np.float64]: ...

    @abstractmethod
    def _settings(self) -> dict[str, Any]:
        """What the engine adds to the plan's settings."""


class MujocoRun(Run):
    """A walk in MuJoCo.

    Attributes:
        simulation: Model and state.
    """

    def __init__(self, plan: Plan, summarised: bool, heed: Heed) -> None:
        """Build the scene; see `begun`."""
        terms = plan.terms
        self.simulation = Simulation(
            plan.controller,
            plan.terrain,
            **plan.arguments(),
            timestep=terms.timestep,
            contact_timestep=terms.contact_timestep,
            control_period=terms.control_period,
            ground=terms.ground,
            # also where no samples are kept: the last one tells where a walk that was broken off has been
            sample_period=DEFAULT_SAMPLE_PERIOD if terms.sample_period is None else terms.sample_period,
        )
        super().__init__(
            plan,
            Recorder(
                keep_samples=terms.sample_period is not None and not summarised,
                summary=Summary(plan.robot, plan.terrain) if summarised else None,
                heed=heed,
            ),
        )

    def told(self, error: Exception) -> str:
        """What went wrong, and when: in the controller, or in MuJoCo itself."""
        if not isinstance(error, mujoco.FatalError):
            return super().told(error)
        at, reason = self._recorder, " ".join(str(error).split())
        return (
            f"MuJoCo gave up at {at.end[0]:.3f} s, after {at.steps} steps, for no fault of the controller: {reason}. "
            f"Its scene has {self.simulation.model.ngeom} geoms; a ground of fewer, longer segments needs fewer, and "
            "the hybrid engine has none"
        )

    def _go(self, progress: bool) -> Outcome:
        return simulate(self.simulation, self._recorder, progress=progress)

    def _peak_torque(self) -> NDArray[np.float64]:
        u = self.simulation.data.userdata
        return np.array([u[events.PEAK_ANKLE], u[events.PEAK_HIP]])

    def _settings(self) -> dict[str, Any]:
        terms = self.plan.terms
        return {
            "timestep": terms.timestep,
            "contact_timestep": terms.contact_timestep,
            "control_period": terms.control_period,
            "ground": terms.ground,
            "warnings": dict(self.simulation.warnings),
        }


class HybridRun(Run):
    """A walk in the hybrid model.

    Attributes:
        simulation: The model and its state.
    """

    def __init__(self, plan: Plan, summarised: bool, heed: Heed) -> None:
        """Set the robot on the ground; see `begun`."""
        terms = plan.terms
        sampled = terms.sample_period is not None and not summarised
        self.simulation = HybridSimulation(
            plan.controller,
            plan.terrain,
            **plan.arguments(),
            sample_period=terms.sample_period if terms.sample_period is not None and sampled else math.inf,
        )
        recorder = HybridRecorder(
            keep_samples=sampled, summary=Summary(plan.robot, plan.terrain) if summarised else None, heed=heed
        )
        super().__init__(plan, recorder)
        self._recorder: HybridRecorder = recorder

    def _go(self, progress: bool) -> Outcome:
        return simulate_hybrid(self.simulation, self._recorder, progress=progress)

    def _peak_torque(self) -> NDArray[np.float64]:
        return self.simulation.peak_torque

    def _settings(self) -> dict[str, Any]:
        simulation = self.simulation
        told = {"tolerance": simulation.world.tolerance, "compiled": simulation.compiled}
        return {**told, "warnings": simulation.warnings} if simulation.warnings else told


def begun(plan: Plan, *, summarised: bool = False, heed: Heed = unheeded) -> Run:
    """Begin a walk.

    Args:
        plan: As checked.
        summarised: Keep no tables, but what `Run.summary` needs.
        heed: Called now and then while it walks; what it raises breaks the walk off.

    Raises:
        InputError: A value is outside its domain.
    """
    kind = HybridRun if plan.terms.engine == "hybrid" else MujocoRun
    return kind(plan, summarised, heed)


def is_interrupt(error: BaseException | None) -> bool:
    """Whether Ctrl-C is behind an error: one that comes while MuJoCo's C code runs can surface as a SystemError."""
    while error is not None:
        if isinstance(error, KeyboardInterrupt):
            return True
        error = error.__cause__ or error.__context__
    return False
