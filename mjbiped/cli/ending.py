"""The end of a command: exit status, messages, and what Ctrl-C and SIGTERM do."""

from __future__ import annotations

import signal
import threading
from collections.abc import Iterator
from contextlib import contextmanager
from types import FrameType
from typing import NoReturn

import click

from mjbiped.errors import shortened

INTERRUPTED, TERMINATED = 130, 143
"""Exit status after Ctrl-C and after SIGTERM, as shells have it."""

LONGEST_LINE = 1000
"""Greatest number of characters in an error message."""


@contextmanager
def terminable() -> Iterator[None]:
    """Let SIGTERM act like Ctrl-C with an exit status of its own: what has been done is kept, and reported.

    A second SIGTERM ends the process at once.
    """
    if threading.current_thread() is not threading.main_thread() or signal.getsignal(signal.SIGTERM) != signal.SIG_DFL:
        yield  # the calling program handles signals
        return
    received = []

    def interrupt(number: int, _: FrameType | None) -> NoReturn:
        received.append(number)
        signal.signal(signal.SIGTERM, signal.SIG_DFL)
        raise KeyboardInterrupt

    signal.signal(signal.SIGTERM, interrupt)
    try:
        yield
    except click.exceptions.Exit as stop:
        if received:
            raise click.exceptions.Exit(TERMINATED) from stop
        raise
    finally:
        signal.signal(signal.SIGTERM, signal.SIG_DFL)


def end(status: int, *messages: str) -> NoReturn:
    """Print errors and end with an exit status."""
    for message in messages:
        click.echo(f"Error: {shortened(' '.join(message.splitlines()), LONGEST_LINE)}", err=True)
    raise click.exceptions.Exit(status)
