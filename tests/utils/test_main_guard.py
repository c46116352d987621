"""A program without its `if __name__ == "__main__":` ends, and is told what it needs."""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path

import pytest

HEAD = "from mjbiped.utils.parallel import processes\n"
BODY = "with processes(1) as pool:\n    print(pool.submit(abs, -3).result())\n"
INDENTED = "".join(f"    {line}\n" for line in BODY.splitlines())

PROGRAMS = {
    "bare": (HEAD + BODY, False),
    "guarded": (HEAD + 'if __name__ == "__main__":\n' + INDENTED, True),
    "behind a guard": (HEAD + "def main():\n" + INDENTED + 'if "__main__" == __name__:\n    main()\n', True),
}


@pytest.mark.parametrize(
    ("text", "runs"),
    [pytest.param(*case, id=name, marks=() if name == "bare" else pytest.mark.slow) for name, case in PROGRAMS.items()],
)
def test_a_program_without_a_guard_is_told(text: str, runs: bool, tmp_path: Path) -> None:
    (tmp_path / "program.py").write_text(text)
    done = subprocess.run([sys.executable, "program.py"], cwd=tmp_path, capture_output=True, text=True, timeout=60)
    assert done.stdout == ("3\n" if runs else ""), done.stderr
    assert (done.returncode == 0) == runs
    assert runs or "if __name__ == '__main__'" in done.stderr
