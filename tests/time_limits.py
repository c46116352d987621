"""A time limit for what a test does."""

import signal
import threading
from collections.abc import Iterator
from contextlib import contextmanager

PATIENCE = 20.0
"""Wall-clock time over processor time at which it is given up too: the machine may be doing other things."""


class _TooLong(BaseException):
    """No `except Exception` can hold it up."""


@contextmanager
def within(seconds: float, what: object) -> Iterator[None]:
    """Break off what takes longer, as soon as Python runs again.

    Args:
        seconds: Of processor time, in all threads.
        what: Shown where it takes longer.

    Raises:
        AssertionError: It does.
    """

    def late(*_: object) -> None:
        raise _TooLong

    assert threading.current_thread() is threading.main_thread()
    timers = ((signal.ITIMER_PROF, signal.SIGPROF, seconds), (signal.ITIMER_REAL, signal.SIGALRM, PATIENCE * seconds))
    before = [signal.signal(number, late) for _, number, _ in timers]
    try:
        for timer, _, limit in timers:
            signal.setitimer(timer, limit)
        yield
    except _TooLong:
        raise AssertionError(f"longer than {seconds:g} s: {what}") from None
    finally:
        for (timer, number, _), handler in zip(timers, before, strict=True):
            signal.setitimer(timer, 0.0)
            signal.signal(number, handler)
