"""The command line as tests run it."""

import os
import subprocess
import sys
from pathlib import Path
from typing import Any, TypeAlias

from click.testing import CliRunner, Result

from mjbiped.cli import main as cli

ROOT = Path(__file__).parents[1]
Drawings: TypeAlias = list[tuple[str, object, dict[str, Any]]]
"""Modules, what they were to draw, and how."""


def run(*words: object) -> Result:
    """Run a command line in this process; whatever is no exit is raised."""
    result = CliRunner().invoke(cli.main, [str(word) for word in words])
    if result.exception is not None and not isinstance(result.exception, SystemExit):
        raise result.exception
    return result


def run_process(*words: object, cwd: Path, **more: str) -> subprocess.CompletedProcess[str]:
    """Run a command line in a process of its own, elsewhere than in the checkout."""
    return python("-m", "mjbiped", *words, cwd=cwd, **more)


def environment(**more: str) -> dict[str, str]:
    """Of a process that imports the checkout's packages."""
    path = os.pathsep.join(filter(None, (str(ROOT), os.environ.get("PYTHONPATH"))))
    return {**os.environ, "PYTHONPATH": path, **more}


def python(*words: object, cwd: Path, **more: str) -> subprocess.CompletedProcess[str]:
    """Run Python in a process of its own, which imports the checkout's packages."""
    command, env = [sys.executable, *map(str, words)], environment(**more)
    return subprocess.run(command, cwd=cwd, env=env, capture_output=True, text=True, timeout=120, check=False)


def complaints(result: Result | subprocess.CompletedProcess[str]) -> str:
    """What is on stderr, but for the line of a first walk that waits for the compiler."""
    return "".join(line for line in result.stderr.splitlines(keepends=True) if not line.startswith("compiling "))


def ran(*words: object) -> str:
    """What a command prints that ends well and complains of nothing."""
    result = run(*words)
    assert (result.exit_code, complaints(result)) == (0, "")
    return result.stdout


def assert_refused(result: Result, reason: str) -> None:
    """Exit status 2, nothing on stdout, and an error in one line."""
    assert (result.exit_code, result.stdout) == (2, "")
    *usage, error = result.stderr.splitlines()
    assert error.startswith("Error: ")
    assert reason in error
    assert not usage or usage[0].startswith("Usage: ")
