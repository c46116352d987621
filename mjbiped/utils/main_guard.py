"""Check that a program can start processes, which import its main module and must not run it again."""

from __future__ import annotations

import ast
import multiprocessing
import sys
from pathlib import Path
from types import FrameType, ModuleType

from mjbiped.errors import InputError


class UnguardedError(InputError, SystemExit):
    """A program starts processes in lines that each of them would run again.

    It is also a `SystemExit`: such a program does not catch it, and ends with this one line and status 1.
    """

    def __init__(self, place: str) -> None:
        """Make the message for a place in the program."""
        super().__init__(
            f"{place}: this starts processes, which import the program, so it must stand under "
            '`if __name__ == "__main__":`, with imports and definitions above; walk_many(..., workers=1) starts none'
        )
        self.code: str | int = str(self)


def check_guarded() -> None:
    """Refuse to start processes from lines of the main program that each process would run again.

    Raises:
        UnguardedError: The main program is at such a line, or this is such a process.
    """
    main = sys.modules.get("__main__")
    file = getattr(main, "__file__", None)
    if getattr(multiprocessing.current_process(), "_inheriting", False):  # importing the parent's program
        error = UnguardedError("the program")
        error.code = 1  # no message: there are as many of these as processes, and their parent reports it
        raise error
    if main is None or file is None or not _is_imported(main):
        return
    line = _line_of_main(sys._getframe(), Path(file))
    if line is not None and not _is_guarded(Path(file), line):
        raise UnguardedError(f"{Path(file).name}, line {line}")


def _is_imported(main: ModuleType) -> bool:
    """Whether processes import the main program; `multiprocessing.spawn` does not for `python -m package`."""
    name = getattr(getattr(main, "__spec__", None), "name", "")
    return not (name == "__main__" or name.endswith(".__main__"))


def _line_of_main(frame: FrameType | None, file: Path) -> int | None:
    """The line that the main program is running; None if it did not call this, or under some profilers."""
    while frame is not None:
        code = frame.f_code
        if code.co_name == "<module>" and Path(code.co_filename).resolve() == file.resolve():
            return frame.f_lineno
        frame = frame.f_back
    return None


def _is_guarded(file: Path, line: int) -> bool:
    """Whether a guard begins at or above a line of a program; true if its source cannot be read."""
    try:
        tree = ast.parse(file.read_bytes())
    except (OSError, SyntaxError, ValueError):
        return True
    tests = [node.test for node in ast.walk(tree) if isinstance(node, ast.If) and node.lineno <= line]
    return any(isinstance(part, ast.Name) and part.id == "__name__" for test in tests for part in ast.walk(test))
