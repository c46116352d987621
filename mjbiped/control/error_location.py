"""Where in the user's own code an error arose, in words."""

from __future__ import annotations

import inspect
import traceback
from collections.abc import Collection
from pathlib import Path

from mjbiped import errors
from mjbiped.errors import shortened

_HERE = Path(errors.__file__).parent


def place_of(error: BaseException, kind: type) -> str:
    """Where in the source of a class an error arose: file, line, function and the line's text, in brackets.

    Args:
        error: What it raised.
        kind: The class; of several places those in its file and those of its bases count, the last of them.

    Returns:
        The words, with a blank before them; empty where no place outside this package is known.
    """
    files = set()
    for each in kind.__mro__:
        try:
            files.add(inspect.getfile(each))
        except (TypeError, OSError):  # built in, or of a shell
            continue
    return place_in(error, files)


def place_in(error: BaseException, files: Collection[str]) -> str:
    """As `place_of`, of the files that are preferred."""
    frames = [frame for frame in traceback.extract_tb(error.__traceback__) if not _is_ours(frame.filename)]
    chosen = [frame for frame in frames if frame.filename in files] or frames
    if not chosen:
        return ""
    last = chosen[-1]
    text = f": {shortened(last.line, 80)}" if last.line else ""
    within = f", in {last.name}" if last.name != "<module>" else ""
    return f" ({Path(last.filename).name}, line {last.lineno}{within}{text})"


def _is_ours(file: str) -> bool:
    """Whether a file is of this package or the machinery that imports modules."""
    return file.startswith("<") or _HERE in Path(file).parents
