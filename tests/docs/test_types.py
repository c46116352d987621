"""Every program on the pages is well typed, by what the installed package says of its own types."""

import subprocess
import sys
from pathlib import Path

import pytest
from documentation import PAGES, blocks

# what a program does with packages that have no types is not checked
UNTYPED = "[mypy]\ncheck_untyped_defs = true\nignore_missing_imports = true\nno_incremental = true\n"


@pytest.mark.slow  # the type checker reads all packages anew
def test_programs_are_well_typed(tmp_path: Path) -> None:
    (tmp_path / "mypy.ini").write_text(UNTYPED)
    names = []
    for page in PAGES:
        programs = [block for block in blocks(page) if block.language == "python" and "notest" not in block.marks]
        for block in programs:
            if block.file:
                (tmp_path / block.file).write_text(block.code, encoding="utf-8")
        if code := "\n".join(block.code for block in programs if not block.file):
            names.append(f"page_{Path(page).stem}.py")
            (tmp_path / names[-1]).write_text(code, encoding="utf-8")
    root = str(Path(__file__).parents[2])
    done = subprocess.run(
        [sys.executable, "-m", "mypy", *names],
        cwd=tmp_path,
        env={"MYPYPATH": root, "PATH": "", "PYTHONPATH": root},
        capture_output=True,
        text=True,
        check=False,
    )
    assert done.returncode == 0, done.stdout + done.stderr
