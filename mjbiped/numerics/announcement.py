"""One line on stderr when machine code has to be made, which takes some seconds."""

from __future__ import annotations

import sys
from collections.abc import Iterator
from contextlib import contextmanager

_wanted = True
_waiting: list[str] = []  # sentences to print if something is compiled, one for each `announced`


def announce(*, wanted: bool) -> None:
    """Say whether compilations are announced from now on, as they are unless said otherwise."""
    global _wanted
    _wanted = wanted


@contextmanager
def announced(what: str, seconds: float) -> Iterator[None]:
    """Print one line on stderr if something has to be compiled within the block.

    Args:
        what: What is compiled, such as "PassiveController for the engine mujoco".
        seconds: How long it takes at most, s.
    """
    sentence = f"compiling {what}, once; it takes some {max(seconds, 1.0):.0f} s ..."
    if _wanted:
        _waiting.append(sentence)
    try:
        yield
    finally:
        if sentence in _waiting:
            _waiting.remove(sentence)


def compilation_begins() -> None:
    """Print what waits to be announced."""
    from tqdm.auto import tqdm

    while _waiting:
        # above the progress bar of a terminal; elsewhere there is none to be drawn again
        (tqdm.write if sys.stderr.isatty() else print)(_waiting.pop(0), file=sys.stderr)
