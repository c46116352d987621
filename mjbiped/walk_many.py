"""`walk_many()`: many walks side by side, each the same as by itself. docs/many_walks.md says how and how fast."""

from __future__ import annotations

import os
import pickle
import threading
import traceback
from collections.abc import Callable, Collection, Hashable, Iterable, Iterator, Mapping, Sequence
from concurrent.futures import BrokenExecutor, Future, ThreadPoolExecutor
from contextlib import ExitStack, suppress
from numbers import Real
from queue import Empty, SimpleQueue
from typing import TYPE_CHECKING, Any, Literal, NamedTuple, TypeAlias, overload

import numpy as np
from tqdm.auto import tqdm

from mjbiped.compass import Compass
from mjbiped.errors import GaitError, InputError, MjbipedError
from mjbiped.laws import gives_its_law
from mjbiped.native import Functions
from mjbiped.physics import (
    DEFAULT_CONTACT_TIMESTEP,
    DEFAULT_TIMESTEP,
    exclusive,
    require_no_callbacks,
    shared_callbacks,
    walking,
)
from mjbiped.record import Walk
from mjbiped.recorder import Heed, unheeded
from mjbiped.scuffing import ScuffingRule
from mjbiped.terrain import Terrain
from mjbiped.walk import HybridRun, MujocoRun, begun, is_interrupt
from mjbiped.walk_plan import DEFAULT_SAMPLE_PERIOD, Plan, Terms, check_controller, planned
from mjbiped.workers import processes

if TYPE_CHECKING:
    from controllers.base import Controller

Result: TypeAlias = Walk | dict[str, Any]
"""What is kept of a walk: its record, or its summary."""

Initial: TypeAlias = str | Sequence[float]


class WalksStopped(MjbipedError):  # noqa: N818 (as its sisters of one walk)
    """Some of many walks were broken off by an error; the others have been walked to their ends.

    Attributes:
        walks: What is kept of each walk, in order; of a broken one the part so far, with the outcome "interrupted",
            and None where there is none.
        errors: What went wrong, by the walk's place in that list.
    """

    def __init__(self, message: str, walks: Sequence[Result | None], errors: Mapping[int, str]) -> None:
        """Keep what has been walked beside the message."""
        super().__init__(message)
        self.walks = walks
        self.errors = errors


class WalksInterrupted(KeyboardInterrupt):
    """Many walks were broken off by Ctrl-C; what was recorded is not lost.

    Attributes:
        walks: What is kept of each walk, in order; None of those that had not begun, or were under way in another
            process. A walk under way in a thread has the outcome "interrupted".
        errors: What went wrong in single walks before, as in `WalksStopped`.
    """

    def __init__(self, walks: Sequence[Result | None], errors: Mapping[int, str]) -> None:
        """Keep what has been walked."""
        super().__init__("walks interrupted")
        self.walks = walks
        self.errors = errors


@overload
def walk_many(
    controllers: Controller | Iterable[Controller],
    terrains: Terrain | Iterable[Terrain],
    *,
    engine: str = ...,
    steps: int | None = ...,
    distance: float | None = ...,
    initial: Initial | Sequence[Initial] = ...,
    robot: Compass | None = ...,
    timestep: float = ...,
    contact_timestep: float = ...,
    control_period: float | None = ...,
    sample_period: float | None = ...,
    scuffing: ScuffingRule | None = ...,
    ground: str = ...,
    summaries: Literal[False] = ...,
    workers: int | None = ...,
    progress: bool = ...,
) -> list[Walk]: ...


@overload
def walk_many(
    controllers: Controller | Iterable[Controller],
    terrains: Terrain | Iterable[Terrain],
    *,
    engine: str = ...,
    steps: int | None = ...,
    distance: float | None = ...,
    initial: Initial | Sequence[Initial] = ...,
    robot: Compass | None = ...,
    timestep: float = ...,
    contact_timestep: float = ...,
    control_period: float | None = ...,
    sample_period: float | None = ...,
    scuffing: ScuffingRule | None = ...,
    ground: str = ...,
    summaries: Literal[True],
    workers: int | None = ...,
    progress: bool = ...,
) -> list[dict[str, Any]]: ...


def walk_many(
    controllers: Controller | Iterable[Controller],
    terrains: Terrain | Iterable[Terrain],
    *,
    engine: str = "mujoco",
    steps: int | None = None,
    distance: float | None = None,
    initial: Initial | Sequence[Initial] = "gait",
    robot: Compass | None = None,
    timestep: float = DEFAULT_TIMESTEP,
    contact_timestep: float = DEFAULT_CONTACT_TIMESTEP,
    control_period: float | None = None,
    sample_period: float | None = DEFAULT_SAMPLE_PERIOD,
    scuffing: ScuffingRule | None = None,
    ground: str = "auto",
    summaries: bool = False,
    workers: int | None = None,
    progress: bool = False,
) -> list[Any]:
    """Let many robots walk at once, each as `walk()` would by itself, to the last bit.

    ```python
    terrains = [Terrain.random(seed=seed) for seed in range(1000)]
    walks = mjbiped.walk_many(controller, terrains, engine="hybrid", sample_period=None)
    print(sum(walk.fell for walk in walks))
    ```

    Walks whose controllers have compiled laws share the threads of this process; those in plain Python are walked in
    processes of their own, to which their controllers must go as pickles.

    Args:
        controllers: One for all walks, or one each.
        terrains: The same. Of two sequences the first goes with the first, and so on.
        engine: As for `walk`, as all that is not told here.
        steps: See `walk`.
        distance: See `walk`.
        initial: One for all walks, or a sequence of one each.
        robot: See `walk`.
        timestep: See `walk`.
        contact_timestep: See `walk`.
        control_period: See `walk`.
        sample_period: See `walk`; None (no samples) saves most of the memory.
        scuffing: See `walk`.
        ground: See `walk`.
        summaries: Return what `measures.summary` says of each walk, and no records: a walk then takes as much memory
            with a million steps as with a thousand.
        workers: Walks at a time; by default as many as there are cores for this process. No result depends on it.
        progress: Show a progress bar (never where the output is not a terminal).

    Returns:
        A record for each walk, in order; with `summaries` a dictionary for each.

    Raises:
        InputError: An argument is outside its domain, a controller's laws cannot be compiled, or it cannot be pickled;
            nothing has been computed then.
        GaitError: As for `walk`.
        WalksStopped: Walks were broken off by an error; all others are complete, and the error carries everything.
        WalksInterrupted: Ctrl-C; a `KeyboardInterrupt` that carries what has been walked.
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
        scuffing=ScuffingRule() if scuffing is None else scuffing,
        ground=ground,
    )
    if workers is None:
        workers = cores()
    if isinstance(workers, bool) or not isinstance(workers, int | np.integer) or workers < 1:
        raise InputError(f"workers must be a whole number of at least 1, got {workers!r}")
    plans = _plans(terms, controllers, terrains, initial)
    with ExitStack() as stack:
        if engine == "mujoco":
            stack.enter_context(exclusive())
            if walking():
                raise MjbipedError("walks cannot be started from inside another's controller")
            require_no_callbacks()
        bar = stack.enter_context(
            tqdm(total=len(plans), desc="preparing", unit="walk", disable=None if progress else True)
        )
        crowd = _Crowd(plans, summaries, int(workers), bar)
        try:
            groups = crowd.groups()
            bar.set_description("walking")
            for group in groups.values():
                crowd.walk(group)
            crowd.walk_apart()
        except KeyboardInterrupt as stop:
            raise WalksInterrupted(crowd.results, crowd.errors) from stop
    if crowd.errors:
        raise _stopped(crowd)
    return crowd.results


def cores() -> int:
    """Number of cores that this process may use."""
    return len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count() or 1


def _plans(
    terms: Terms,
    controllers: Controller | Iterable[Controller],
    terrains: Terrain | Iterable[Terrain],
    initial: Initial | Sequence[Initial],
) -> list[Plan]:
    """Check everything that can be checked without a simulation.

    Raises:
        InputError: The numbers differ, or one is not what is expected; the message says which walk's.
        GaitError: A walk has no passive gait to start on.
    """
    given: dict[str, Any] = {"controllers": controllers, "terrains": terrains}
    each = {name: list(value) for name, value in given.items() if isinstance(value, Iterable)}
    if not isinstance(initial, str) and isinstance(initial, Iterable):
        starts: list[Any] = list(initial)
        if not all(isinstance(start, Real) for start in starts):
            each["initial"] = starts
    counts = {name: len(values) for name, values in each.items()}
    if len(set(counts.values())) > 1:
        got = ", ".join(f"{count} of {name}" for name, count in counts.items())
        raise InputError(f"expected one for all walks, or as many of each as there are walks; got {got}")
    count = next(iter(counts.values()), 1)
    described: dict[int, dict[str, Any]] = {}
    plans = []
    for index in range(count):
        controller, terrain, start = (
            each[name][index] if name in each else value for name, value in {**given, "initial": initial}.items()
        )
        try:
            if id(controller) not in described:
                described[id(controller)] = check_controller(controller)
            plans.append(planned(terms, controller, terrain, start, described[id(controller)]))
        except (InputError, GaitError) as error:
            raise type(error)(f"walk {index} of {count} (counted from 0): {error}") from error
    return plans


class _Ended(NamedTuple):
    """What came of a walk.

    Attributes:
        result: What is kept of it.
        error: What went wrong, empty if nothing did.
        trace: Where, as Python tells it.
        interrupted: Whether that was Ctrl-C.
    """

    result: Result | None
    error: str = ""
    trace: str = ""
    interrupted: bool = False


class _NotTheirs(Exception):  # noqa: N818 (no error, a message)
    """A walk is driven by other compiled callbacks than those that are installed."""


def _walked(plan: Plan, summarised: bool, heed: Heed = unheeded, functions: Functions | None = None) -> _Ended:
    """Walk once.

    Args:
        plan: What is walked.
        summarised: Whether a summary is kept, and no record.
        heed: See `walk.begun`.
        functions: Compiled callbacks that are installed for this walk.

    Raises:
        _NotTheirs: They are not this walk's.
    """
    try:
        run = begun(plan, summarised=summarised, heed=heed)
        if functions is not None and isinstance(run, MujocoRun) and run.simulation.functions is not functions:
            raise _NotTheirs
    except MjbipedError as error:
        return _Ended(None, str(error), traceback.format_exc())
    keep: Callable[[], Result] = run.summary if summarised else run.record
    try:
        run.go()
    except InputError as error:  # laws that cannot be compiled
        return _Ended(None, str(error), traceback.format_exc())
    except BaseException as error:
        if is_interrupt(error):
            return _Ended(keep(), interrupted=True)
        if not isinstance(error, Exception):
            raise
        return _Ended(keep(), run.told(error), traceback.format_exc())
    return _Ended(keep())


def _as_they_end(futures: Collection[Future[_Ended]]) -> Iterator[Future[_Ended]]:
    """As `concurrent.futures.as_completed`, whose wait Ctrl-C does not end on every system."""
    ended: SimpleQueue[Future[_Ended]] = SimpleQueue()
    for future in futures:
        future.add_done_callback(ended.put)
    for _ in futures:
        while True:
            with suppress(Empty):
                yield ended.get(timeout=0.2)
                break


class _Crowd:
    """Many walks and what has come of them so far.

    Attributes:
        results: What is kept of each.
        errors: What went wrong, by the walk's place.
        traces: Where it did.
    """

    def __init__(self, plans: Sequence[Plan], summarised: bool, workers: int, bar: tqdm[Any]) -> None:
        self._plans = plans
        self._summarised = summarised
        self._workers = workers
        self._bar = bar
        self._stop = threading.Event()
        self._apart: list[int] = []
        self.results: list[Result | None] = [None] * len(plans)
        self.errors: dict[int, str] = {}
        self.traces: dict[int, str] = {}

    def groups(self) -> dict[Hashable, list[int]]:
        """Walks whose laws are the same functions; those in plain Python are set apart. Compiles all laws.

        Raises:
            InputError: The engine refuses an argument, laws cannot be compiled, or a controller cannot be pickled.
        """
        kinds: dict[int, Hashable] = {}
        groups: dict[Hashable, list[int]] = {}
        for index, plan in enumerate(self._plans):
            controller = plan.controller
            if id(controller) not in kinds:
                kinds[id(controller)] = _kind(controller)
            groups.setdefault(kinds[id(controller)], []).append(index)
        for kind, indices in list(groups.items()):
            if not _compiles(self._plans[indices[0]]):
                self._apart += groups.pop(kind)
        if self._in_processes:
            _check_pickles({id(c): c for c in (self._plans[index].controller for index in self._apart)}.values())
        return groups

    def walk(self, indices: Sequence[int]) -> None:
        """Walk a group in threads.

        Raises:
            KeyboardInterrupt: Ctrl-C.
        """
        left = list(indices)
        while left:
            first = begun(self._plans[left[0]])
            if not isinstance(first, MujocoRun):
                self._in_threads(left)
                return
            functions = first.simulation.functions
            if functions is None:
                self._apart.append(left.pop(0))
                continue
            with shared_callbacks(functions):
                left = self._in_threads(left, functions)

    def walk_apart(self) -> None:
        """Walk those whose laws are in plain Python.

        Raises:
            KeyboardInterrupt: Ctrl-C.
        """
        if not self._in_processes:
            for index in self._apart:
                self._take(index, _walked(self._plans[index], self._summarised))
            return
        with processes(min(self._workers, len(self._apart))) as pool:
            futures = {pool.submit(_walked, self._plans[index], self._summarised): index for index in self._apart}
            for future in _as_they_end(futures):
                self._take_from(future, futures[future])

    @property
    def _in_processes(self) -> bool:
        return min(self._workers, len(self._apart)) > 1

    def _in_threads(self, indices: Sequence[int], functions: Functions | None = None) -> list[int]:
        """Walk in threads; returns those that the installed callbacks are not for."""
        others: list[int] = []
        with ThreadPoolExecutor(self._workers, thread_name_prefix="walk") as pool:
            futures = {
                pool.submit(_walked, self._plans[index], self._summarised, self._heed, functions): index
                for index in indices
            }
            try:
                for future in _as_they_end(futures):
                    if isinstance(future.exception(), _NotTheirs):
                        others.append(futures[future])
                    else:
                        self._take_from(future, futures[future])
            except BaseException:
                self._stop.set()  # the walks under way
                pool.shutdown(cancel_futures=True)
                for future, index in futures.items():
                    if not future.cancelled() and future.exception() is None and self.results[index] is None:
                        self.results[index] = future.result().result
                raise
        return sorted(others)

    def _heed(self) -> None:
        if self._stop.is_set():
            raise KeyboardInterrupt

    def _take_from(self, future: Future[_Ended], index: int) -> None:
        try:
            ended = future.result()
        except BrokenExecutor:
            ended = _Ended(
                None,
                "its process died: of lack of memory perhaps, or because it could not import the controller's class "
                '(which must stand in a module) or the program (which needs its `if __name__ == "__main__":`); '
                "with workers=1 there are no processes",
            )
        self._take(index, ended)

    def _take(self, index: int, ended: _Ended) -> None:
        self.results[index] = ended.result
        if ended.interrupted:
            raise KeyboardInterrupt
        if ended.error:
            self.errors[index], self.traces[index] = ended.error, ended.trace
        self._bar.update()


def _kind(controller: Controller) -> Hashable:
    """What decides which functions are compiled for a controller; None: none."""
    law = controller.law() if gives_its_law(controller) else None
    return None if law is None else (type(controller), law[1:], tuple(controller.states))


def _compiles(plan: Plan) -> bool:
    """Whether a walk runs in compiled code, which is then compiled.

    Raises:
        InputError: An argument is outside its domain, or the laws cannot be compiled.
    """
    run = begun(plan)
    if isinstance(run, HybridRun):
        run.simulation.compile()
    assert isinstance(run, HybridRun | MujocoRun)
    return run.simulation.compiled


def _check_pickles(controllers: Iterable[Controller]) -> None:
    """Refuse controllers that cannot be sent to another process.

    Raises:
        InputError: One cannot be pickled.
    """
    for controller in controllers:
        try:
            pickle.dumps(controller)
        except Exception as error:  # whatever its parts raise
            raise InputError(
                f"{type(controller).__name__} runs in plain Python, its walks therefore in processes of their own, and "
                f"it cannot be sent there: {error}. Expected is a controller that can be pickled (its class at the top "
                "level of a module, its attributes plain values), one with compiled laws, or workers=1"
            ) from error


def _stopped(crowd: _Crowd) -> WalksStopped:
    """The error that tells of the broken walks."""
    first, count = min(crowd.errors), len(crowd.results)
    others = count - len(crowd.errors)
    error = WalksStopped(
        f"{len(crowd.errors)} of {count} walks stopped, the first of them walk {first} (counted from 0): "
        f"{crowd.errors[first]}; the other {others} are complete, see `walks` and `errors` of this error",
        crowd.results,
        crowd.errors,
    )
    if crowd.traces[first]:
        error.add_note(f"walk {first}:\n{crowd.traces[first]}")
    return error
