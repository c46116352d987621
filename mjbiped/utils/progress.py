"""When a progress bar is shown: where one was asked for and somebody can see it."""

from __future__ import annotations

import sys


def hidden(progress: bool) -> bool | None:
    """What tqdm calls `disable`.

    Args:
        progress: Whether a bar was asked for.

    Returns:
        Whether it is hidden; None where tqdm shall look whether its output is a terminal. A notebook's output is none,
        and bars are shown there all the same.
    """
    if not progress:
        return True
    return False if in_notebook() else None


def in_notebook() -> bool:
    """Whether this process is a notebook's kernel, by the sign that `tqdm.auto` goes by too."""
    ipython = sys.modules.get("IPython")
    shell = ipython.get_ipython() if ipython else None
    return shell is not None and "IPKernelApp" in shell.config
