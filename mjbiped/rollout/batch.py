"""Batches of walks: those with compiled laws run in threads, the others in processes."""

from __future__ import annotations

import pickle
import threading
import traceback
from collections.abc import Callable, Hashable, Mapping, Sequence
from concurrent.futures import BrokenExecutor, Executor, Future, ThreadPoolExecutor
from contextlib import suppress
from queue import Empty, SimpleQueue
from typing import TYPE_CHECKING, Any, NamedTuple, TypeAlias

from mjbiped.engines.plan import Plan
from mjbiped.errors import InputError, MjbipedError
from mjbiped.records.columns import Cancellation, never_cancelled
from mjbiped.records.record import Walk
from mjbiped.rollout.walk import WalkInterrupted, WalkStopped, walked_out
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
        keep: Callable[[], Result] = run.summary if summarised else run.record
        return _Ended(walked_out(run, keep))
    except WalkInterrupted as stop:
        return _Ended(stop.walk, interrupted=True)
    except MjbipedError as error:
        kept = error.walk if isinstance(error, WalkStopped) else None
        return _Ended(kept, str(error), traceback.format_exc())


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
        compiled, here, apart = self._divided()
        count = min(self._workers, len(apart))
        if count > 1:
            for controller in {id(each): each for index in apart if (each := self._plans[index].controller)}.values():
                _check_pickles(controller)
        else:
            here, apart = [*here, *apart], []
        self._bar.set_description("walking")
        if compiled:
            self._in_threads(compiled)
        for index in here:
            self._take(index, _walked(self._plans[index], self._summarised))
        if apart:
            with processes(count) as pool:
                self._take_all(self._submitted(pool, apart))

    def _divided(self) -> tuple[list[int], list[int], list[int]]:
        """Compile all laws, and return the walks with compiled laws, with interpreted ones, and without any.

        Raises:
            InputError: Laws cannot be compiled.
        """
        kinds: dict[int, Hashable] = {}
        machine: dict[Hashable, bool] = {}
        compiled, interpreted, apart = list[int](), list[int](), list[int]()
        for index, plan in enumerate(self._plans):
            if id(plan.controller) not in kinds:
                law, states = plan.law, tuple(plan.driver.states)
                kinds[id(plan.controller)] = None if law is None else (type(plan.controller), law[1:], states)
            kind = kinds[id(plan.controller)]
            if kind not in machine:
                machine[kind] = plan.terms.engine.start(plan).compile()
            (compiled if machine[kind] else apart if kind is None else interpreted).append(index)
        return compiled, interpreted, apart

    def _in_threads(self, indices: Sequence[int]) -> None:
        """Make walks in threads."""
        with ThreadPoolExecutor(self._workers, thread_name_prefix="walk") as pool:
            futures = self._submitted(pool, indices, self._check_cancelled)
            try:
                self._take_all(futures)
            except BaseException:
                self._stop.set()  # stops the walks under way
                pool.shutdown(cancel_futures=True)
                for future, index in futures.items():
                    if not future.cancelled() and future.exception() is None:
                        self.results[index] = future.result().result
                raise

    def _check_cancelled(self) -> None:
        if self._stop.is_set():
            raise KeyboardInterrupt

    def _submitted(
        self, pool: Executor, indices: Sequence[int], *cancellation: Cancellation
    ) -> dict[Future[_Ended], int]:
        """Let an executor make walks, and return their indices by their futures."""
        return {pool.submit(_walked, self._plans[each], self._summarised, *cancellation): each for each in indices}

    def _take_all(self, futures: Mapping[Future[_Ended], int]) -> None:
        """Take the results as they come, unlike `concurrent.futures.as_completed` always interruptible by Ctrl-C."""
        ended: SimpleQueue[Future[_Ended]] = SimpleQueue()
        for future in futures:
            future.add_done_callback(ended.put)
        left = len(futures)
        while left:
            with suppress(Empty):
                future = ended.get(timeout=0.2)
                left -= 1
                died = isinstance(future.exception(), BrokenExecutor)
                self._take(futures[future], _Ended(None, _DIED) if died else future.result())

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
