"""Many walks under way: which of them share threads, which need processes, and what has come of them."""

from __future__ import annotations

import pickle
import threading
import traceback
from collections.abc import Callable, Collection, Hashable, Iterable, Iterator, Sequence
from concurrent.futures import BrokenExecutor, Future, ThreadPoolExecutor
from contextlib import suppress
from queue import Empty, SimpleQueue
from typing import TYPE_CHECKING, Any, NamedTuple, TypeAlias

from mjbiped.control.compilation import compilable_law
from mjbiped.engines.base import Run
from mjbiped.engines.plan import Plan
from mjbiped.errors import InputError, MjbipedError
from mjbiped.records.record import Walk
from mjbiped.records.recorder import Cancellation, never_cancelled
from mjbiped.rollout.walk import is_interrupt
from mjbiped.utils.parallel import processes

if TYPE_CHECKING:
    from tqdm.auto import tqdm

    from mjbiped.control.controller import Controller

Result: TypeAlias = Walk | dict[str, Any]
"""What is kept of a walk: its record, or its summary."""


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


class _CannotShare(Exception):  # noqa: N818 (no error, a message)
    """A walk cannot be made in a thread beside those of its group."""


def _walked(
    plan: Plan, summarised: bool, cancellation: Cancellation = never_cancelled, first: Run | None = None
) -> _Ended:
    """Walk once.

    Args:
        plan: What is walked.
        summarised: Whether a summary is kept, and no record.
        cancellation: See `Engine.start`.
        first: Of the walks that share threads with this one; `first.sharing()` is held.

    Raises:
        _CannotShare: This one cannot.
    """
    try:
        run = plan.terms.engine.start(plan, summarised=summarised, cancellation=cancellation)
        if first is not None and not run.shares_with(first):
            raise _CannotShare
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
    """As `concurrent.futures.as_completed`, whose wait Ctrl-C does not end on every system."""
    ended: SimpleQueue[Future[_Ended]] = SimpleQueue()
    for future in futures:
        future.add_done_callback(ended.put)
    for _ in futures:
        while True:
            with suppress(Empty):
                yield ended.get(timeout=0.2)
                break


class Batch:
    """Many walks and what has come of them so far.

    Attributes:
        results: What is kept of each.
        errors: What went wrong, by the walk's index.
        traces: Where it did.
    """

    def __init__(self, plans: Sequence[Plan], summarised: bool, workers: int, bar: tqdm[Any]) -> None:
        """Gather walks that have not been started.

        Args:
            plans: What is walked.
            summarised: Whether summaries are kept, and no records.
            workers: Walks at a time.
            bar: Goes on by one with each walk that ends.
        """
        self._plans = plans
        self._summarised = summarised
        self._workers = workers
        self._bar = bar
        self._stop = threading.Event()
        self._apart: list[int] = []
        self.results: list[Result | None] = [None] * len(plans)
        self.errors: dict[int, str] = {}
        self.traces: dict[int, str] = {}

    def run(self) -> None:
        """Walk those with compiled laws in threads, then the others in processes; laws are compiled first of all.

        Raises:
            InputError: Laws cannot be compiled, or a controller cannot be pickled.
            KeyboardInterrupt: Ctrl-C.
        """
        groups = self._groups()
        self._bar.set_description("walking")
        for group in groups.values():
            self._walk_group(group)
        self._walk_apart()

    def _groups(self) -> dict[Hashable, list[int]]:
        """Walks whose laws are the same functions; those in plain Python are set apart."""
        kinds: dict[int, Hashable] = {}
        groups: dict[Hashable, list[int]] = {}
        for index, plan in enumerate(self._plans):
            controller = plan.controller
            if id(controller) not in kinds:
                kinds[id(controller)] = _kind(controller)
            groups.setdefault(kinds[id(controller)], []).append(index)
        for kind, indices in list(groups.items()):
            if not self._start(indices[0]).compile():
                self._apart += groups.pop(kind)
        if self._in_processes:
            _check_pickles({id(c): c for c in (self._plans[index].controller for index in self._apart)}.values())
        return groups

    def _start(self, index: int) -> Run:
        plan = self._plans[index]
        return plan.terms.engine.start(plan)

    def _walk_group(self, indices: Sequence[int]) -> None:
        """Walk a group in threads; those that cannot share them by and by in others, or apart."""
        left = list(indices)
        while left:
            first = self._start(left[0])
            if not first.compile():
                self._apart.append(left.pop(0))
                continue
            with first.sharing():
                left = self._in_threads(left, first)

    def _walk_apart(self) -> None:
        """Walk those whose laws are in plain Python."""
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

    def _in_threads(self, indices: Sequence[int], first: Run) -> list[int]:
        """Walk in threads; returns those that cannot share them."""
        others: list[int] = []
        with ThreadPoolExecutor(self._workers, thread_name_prefix="walk") as pool:
            futures = {
                pool.submit(_walked, self._plans[index], self._summarised, self._check_cancelled, first): index
                for index in indices
            }
            try:
                for future in _as_they_end(futures):
                    if isinstance(future.exception(), _CannotShare):
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

    def _check_cancelled(self) -> None:
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
    law = compilable_law(controller)
    return None if law is None else (type(controller), law[1:], tuple(controller.states))


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
