"""A program without its `if __name__ == "__main__":` ends with one line, before any process is started."""

from __future__ import annotations

import re
import subprocess
import sys
from pathlib import Path

import pytest

from mjbiped.errors import InputError
from mjbiped.utils.parallel import UnguardedError

HEAD = "from mjbiped.utils.parallel import processes\n"
BODY = "with processes(1) as pool:\n    print(pool.submit(abs, -3).result())\n"
INDENTED = "".join(f"    {line}\n" for line in BODY.splitlines())

PROGRAMS = {
    "bare": (HEAD + BODY, 'program.py, line 2: this starts processes.*`if __name__ == "__main__":`'),
    "in a function": (HEAD + "def main():\n" + INDENTED + "main()\n", "program.py, line 5: this starts processes"),
    "above the guard": (HEAD + BODY + 'if __name__ == "__main__":\n    pass\n', "program.py, line 2"),
    "guarded": (HEAD + 'if __name__ == "__main__":\n' + INDENTED, ""),
    "behind a guard": (HEAD + "def main():\n" + INDENTED + 'if "__main__" == __name__:\n    main()\n', ""),
}


@pytest.mark.parametrize(
    ("text", "words"),
    [pytest.param(*case, id=name, marks=() if name == "bare" else pytest.mark.slow) for name, case in PROGRAMS.items()],
)
def test_a_program_without_a_guard_ends_with_one_line(text: str, words: str, tmp_path: Path) -> None:
    (tmp_path / "program.py").write_text(text)
    done = subprocess.run([sys.executable, "program.py"], cwd=tmp_path, capture_output=True, text=True)
    if not words:
        assert done.stdout == "3\n", done.stderr
        return
    assert (done.returncode, done.stdout) == (1, "")
    assert done.stderr.count("\n") == 1
    assert re.search(words, done.stderr)


@pytest.mark.slow
def test_under_a_profiler_processes_import_that(tmp_path: Path) -> None:
    (tmp_path / "program.py").write_text(HEAD + BODY)
    words = [sys.executable, "-m", "cProfile", "-o", "profile", "program.py"]
    done = subprocess.run(words, cwd=tmp_path, capture_output=True, text=True)
    assert done.stdout == "3\n", done.stderr


@pytest.mark.slow
def test_what_a_child_imports_ends_without_a_word(tmp_path: Path) -> None:
    """From another thread the program's line is not seen: each process then refuses when it imports the program."""
    thread = "import threading\ndef main():\n" + INDENTED + "work = threading.Thread(target=main)\nwork.start()\n"
    (tmp_path / "program.py").write_text(HEAD + thread + "work.join()\n")
    done = subprocess.run([sys.executable, "program.py"], cwd=tmp_path, capture_output=True, text=True, timeout=60)
    assert "bootstrapping" not in done.stderr


def test_it_can_be_caught_as_any_other_mistake() -> None:
    error = UnguardedError("program.py, line 2")
    assert isinstance(error, InputError)
    assert isinstance(error, SystemExit)
    assert error.code == str(error)
