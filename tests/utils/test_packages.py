"""Packages of extras that are missing, and a user's own `controllers.py` that hides ours, are named with a remedy."""

from __future__ import annotations

import math
import os
import subprocess
import sys
from pathlib import Path

import pytest

import mjbiped
from mjbiped.errors import InputError
from mjbiped.utils.packages import hidden_laws, needed

ROOT = str(Path(mjbiped.__file__).parents[1])


def run(folder: Path, *words: str) -> subprocess.CompletedProcess[str]:
    """Python in a folder, with this checkout behind it."""
    environment = {**os.environ, "PYTHONPATH": ROOT}
    return subprocess.run([sys.executable, *words], cwd=folder, env=environment, capture_output=True, text=True)


def test_nothing_hides_it_here() -> None:
    assert hidden_laws() == ""


def test_a_file_in_the_working_directory_is_told_of(tmp_path: Path) -> None:
    """By the command line, which ends, and to a program that imports mjbiped."""
    (tmp_path / "controllers.py").write_text("from controllers import Controller\n")
    (tmp_path / "program.py").write_text("import mjbiped\nfrom controllers import Controller\n")
    done = run(tmp_path, "-m", "mjbiped", "walk")
    assert (done.returncode, done.stdout) == (2, "")
    assert done.stderr.startswith(f"Error: the file {tmp_path}/controllers.py hides mjbiped's own package")
    assert done.stderr.count("\n") == 1
    done = run(tmp_path, "program.py")
    assert done.returncode == 1
    first, *_, last = done.stderr.splitlines()
    assert f"program.py:1: UserWarning: the file {tmp_path}/controllers.py hides" in first
    assert last.startswith("ImportError")


def test_what_is_there_is_imported() -> None:
    assert needed("math", "data", "this") is math


def test_what_is_missing_is_named_with_its_extra() -> None:
    with pytest.raises(InputError, match=r"^a flight needs wings_of_wax, .*pip install 'mjbiped\[fly\]'$"):
        needed("wings_of_wax.left", "fly", "a flight")
