"""Progress of long work: a bar on a terminal and in a notebook, a line now and then elsewhere."""

from __future__ import annotations

import sys
from collections.abc import Iterable
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from tqdm.std import tqdm

EVERY = 30.0
"""Time between lines where there is no terminal, s."""

_LINE = "{desc}: {n_fmt} of {total_fmt} after {elapsed}, {rate_fmt}, {remaining} left"


def progress_bar(iterable: Iterable[object] | None = None, *, progress: bool = True, **given: Any) -> tqdm[Any]:
    """Return a progress bar on stderr; where that is no terminal, one that writes a line every half a minute.

    Args:
        iterable: What is gone through, as for tqdm.
        progress: Whether progress is shown at all.
        **given: Other arguments of tqdm.
    """
    # imported where it is used: `import mjbiped` need not wait for it
    from tqdm.auto import tqdm as shown

    if not progress or in_notebook() or sys.stderr.isatty():
        return shown(iterable, disable=not progress, **given)
    # each step looks at the clock, and the rate is that of the whole time: a line says what is so when it is written
    rare = {"delay": EVERY, "mininterval": EVERY, "miniters": 1, "smoothing": 0.0}
    lines: tqdm[Any] = _lines()(iterable, leave=False, bar_format=_LINE, **{**rare, **given})
    return lines


def _lines() -> Any:
    """The class of bars that write lines."""
    from tqdm.std import tqdm

    class Lines(tqdm):  # type: ignore[type-arg]  # generic in its stubs only
        """A bar each of whose states is a line of its own."""

        def display(self, msg: str | None = None, pos: int | None = None) -> None:
            """Write a line; none at the end, where tqdm clears its own by an empty one."""
            if msg is None:
                self.fp.write(f"{self}\n")
                self.fp.flush()

    return Lines


def in_notebook() -> bool:
    """Whether this process is a notebook's kernel, by the test of `tqdm.auto`."""
    ipython = sys.modules.get("IPython")
    shell = ipython.get_ipython() if ipython else None
    return shell is not None and "IPKernelApp" in shell.config
