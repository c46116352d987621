"""Batches of walks: those with compiled laws run in threads, the others in processes."""

from __future__ import annotations

import pickle
import threading
import traceback
from collections.abc import Callable, Collection, Hashable, Iterator, Sequence
from concurrent.futures import BrokenExecutor, Future, ThreadPoolExecutor
from contextlib import suppress
from queue import Empty, SimpleQueue
from typing import TYPE_CHECKING, Any, NamedTuple, TypeAlias

from mjbiped.engines.plan import Plan
from mjbiped.errors import InputError, MjbipedError
from mjbiped.records.record import Walk
from mjbiped.records.recorder import Cancellation, never_cancelled
from mjbiped.rollout.walk import is_interrupt
from mjbiped.utils.parallel import processes

if TYPE_CHECKING:
    from tqdm.std import tqdm

    from mjbiped.control.controller import Controller

_DIED = (
    "its process died: of lack of memory perhaps, or because it could not import the controller's class (which must "
    'stand in a module) or the program (which needs its `if __name__ == "__main__":`); with workers=1 there are no '
    "processes"
)

Result: TypeAlias = Walk | dict[str, Any]
"""What is kept of a walk: its record, or its summary."""


class _Ended(NamedTuple):
    """The result of one walk.

    Attributes:
        result: Record or summary of the walk; None if it could not start.
        error: Message of the error that stopped it; empty if there was none.
        trace: Python's traceback of the error.
        interrupted: Whether Ctrl-C ended the walk.
    """

    result: Result | None
    error: str = ""
    trace: str = ""
    interrupted: bool = False


def _walked(plan: Plan, summarised: bool, cancellation: Cancellation = never_cancelled) -> _Ended:
    """Make one walk to its end.

    Args:
        plan: Plan of the walk.
        summarised: Whether to keep a summary instead of a record.
        cancellation: See `Engine.start`.
    """
    try:
        run = plan.terms.engine.start(plan, summarised=summarised, cancellation=cancellation)
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
        if not isinstance(error, Exception | SystemExit):
            raise
        return _Ended(keep(), run.message(error), traceback.format_exc())
    return _Ended(keep())


def _as_they_end(futures: Collection[Future[_Ended]]) -> Iterator[Future[_Ended]]:
    """Yield futures as they end, unlike `concurrent.futures.as_completed` always interruptible by Ctrl-C."""
    ended: SimpleQueue[Future[_Ended]] = SimpleQueue()
    for future in futures:
        future.add_done_callback(ended.put)
    for _ in futures:
        while True:
            with suppress(Empty):
                yield ended.get(timeout=0.2)
                break


class Batch:
    """Many walks and their results so far.

    Attributes:
        results: Record or summary of each walk; None where there is none yet.
        errors: Error messages by the walk's index.
        traces: Tracebacks of the errors, by the walk's index.
    """

    def __init__(self, plans: Sequence[Plan], summarised: bool, workers: int, bar: tqdm[Any]) -> None:
        """Prepare a batch of walks.

        Args:
            plans: Plan of each walk.
            summarised: Whether to keep summaries instead of records.
            workers: Number of walks at a time.
            bar: Progress bar, advanced by one with each walk that ends.
        """
        self._plans = plans
        self._summarised = summarised
        self._workers = workers
        self._bar = bar
        self._stop = threading.Event()
        self._apart: list[int] = []
        self._interpreted: list[int] = []
        self.results: list[Result | None] = [None] * len(plans)
        self.errors: dict[int, str] = {}
        self.traces: dict[int, str] = {}

    def run(self) -> None:
        """Compile all laws, then make the walks: those with compiled laws in threads, the others in processes.

        Where all together take a moment, laws are interpreted, one walk after another.

        Raises:
            InputError: Laws cannot be compiled, or a controller cannot be pickled.
            KeyboardInterrupt: Ctrl-C was pressed.
        """
        groups = self._groups()
        self._bar.set_description("walking")
        for group in groups:
            self._in_threads(group)
        here = self._interpreted if self._in_processes else [*self._interpreted, *self._apart]
        for index in here:
            self._take(index, _walked(self._plans[index], self._summarised))
        if not self._in_processes:
            return
        with processes(min(self._workers, len(self._apart))) as pool:
            futures = {pool.submit(_walked, self._plans[index], self._summarised): index for index in self._apart}
            for future in _as_they_end(futures):
                try:
                    ended = future.result()
                except BrokenExecutor:
                    ended = _Ended(None, _DIED)
                self._take(futures[future], ended)

    def _groups(self) -> list[list[int]]:
        """Group walks whose laws are the same compiled functions; walks in plain Python are set apart.

        Raises:
            InputError: Laws cannot be compiled, or a controller that runs in plain Python cannot be pickled.
        """
        kinds: dict[int, Hashable] = {}
        groups: dict[Hashable, list[int]] = {}
        for index, plan in enumerate(self._plans):
            if id(plan.controller) not in kinds:
                law = plan.law
                kind = None if law is None else (type(plan.controller), law[1:], tuple(plan.driver.states))
                kinds[id(plan.controller)] = kind
            groups.setdefault(kinds[id(plan.controller)], []).append(index)
        compiled = []
        for group in groups.values():
            first = self._plans[group[0]]
            if first.terms.engine.start(first).compile():
                compiled.append(group)
            elif first.law is not None:  # they take a moment
                self._interpreted += group
            else:
                self._apart += group
        if self._in_processes:
            apart = {id(plan.controller): plan.controller for plan in map(self._plans.__getitem__, self._apart)}
            for controller in apart.values():
                _check_pickles(controller)
        return compiled

    @property
    def _in_processes(self) -> bool:
        return min(self._workers, len(self._apart)) > 1

    def _in_threads(self, indices: Sequence[int]) -> None:
        """Make walks in threads."""
        with ThreadPoolExecutor(self._workers, thread_name_prefix="walk") as pool:
            futures = {
                pool.submit(_walked, self._plans[index], self._summarised, self._check_cancelled): index
                for index in indices
            }
            try:
                for future in _as_they_end(futures):
                    self._take(futures[future], future.result())
            except BaseException:
                self._stop.set()  # stops the walks under way
                pool.shutdown(cancel_futures=True)
                for future, index in futures.items():
                    if not future.cancelled() and future.exception() is None and self.results[index] is None:
                        self.results[index] = future.result().result
                raise

    def _check_cancelled(self) -> None:
        if self._stop.is_set():
            raise KeyboardInterrupt

    def _take(self, index: int, ended: _Ended) -> None:
        self.results[index] = ended.result
        if ended.interrupted:
            raise KeyboardInterrupt
        if ended.error:
            self.errors[index], self.traces[index] = ended.error, ended.trace
        self._bar.update()


def _check_pickles(controller: Controller) -> None:
    """Refuse a controller that cannot be sent to another process.

    Raises:
        InputError: The controller cannot be pickled.
    """
    try:
        pickle.dumps(controller)
    except Exception as error:  # pickling runs the attributes' own code
        raise InputError(
            f"{type(controller).__name__} runs in plain Python, its walks therefore in processes of their own, and "
            f"it cannot be sent there: {error}. Expected is a controller that can be pickled (its class at the top "
            "level of a module, its attributes plain values), one with compiled laws, or workers=1"
        ) from error
