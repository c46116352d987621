"""One line on stderr when machine code has to be made, which takes some seconds."""

from __future__ import annotations

import sys
from collections.abc import Iterator
from contextlib import contextmanager

_quiet = False
_waiting: list[list[str]] = []  # sentences to print if something is compiled, one for each `announced`


def announce(*, wanted: bool) -> None:
    """Say whether compilations are announced from now on, as they are unless said otherwise."""
    global _quiet
    _quiet = not wanted


@contextmanager
def announced(what: str, seconds: float) -> Iterator[None]:
    """Print one line on stderr if something has to be compiled within the block.

    Args:
        what: What is compiled, such as "PassiveController for the engine mujoco".
        seconds: How long it takes at most, s.
    """
    sentence = [] if _quiet else [f"compiling {what}, once; it takes some {max(seconds, 1.0):.0f} s ..."]
    _waiting.append(sentence)
    try:
        yield
    finally:
        _waiting[:] = [other for other in _waiting if other is not sentence]


def compilation_begins() -> None:
    """Print what waits to be announced."""
    from tqdm.auto import tqdm

    for sentence in _waiting:
        while sentence:
            # above the progress bar of a terminal; elsewhere there is none to be drawn again
            (tqdm.write if sys.stderr.isatty() else print)(sentence.pop(), file=sys.stderr)
