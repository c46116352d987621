"""Whether a progress bar is shown: only if it was requested, and on a terminal or in a notebook."""

from __future__ import annotations

import sys


def hidden(progress: bool) -> bool | None:
    """Return the value of tqdm's argument `disable`.

    Args:
        progress: Whether a bar was requested.

    Returns:
        Whether the bar is hidden; None lets tqdm check for a terminal. In a notebook bars are shown without one.
    """
    if not progress:
        return True
    return False if in_notebook() else None


def in_notebook() -> bool:
    """Whether this process is a notebook's kernel, by the test of `tqdm.auto`."""
    ipython = sys.modules.get("IPython")
    shell = ipython.get_ipython() if ipython else None
    return shell is not None and "IPKernelApp" in shell.config
