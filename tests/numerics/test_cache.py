"""Machine code on disk: damaged files, folders that cannot be written to, and two processes at once."""

import os
import subprocess
import sys
from collections.abc import Callable
from pathlib import Path

import pytest

PROGRAM = """
from mjbiped.numerics.jit import jitted

def double(x):
    return x + x

made = jitted(double)
print(made(1.25), sum(made.stats.cache_hits.values()))
"""


@pytest.fixture
def program(tmp_path: Path) -> Path:
    file = tmp_path / "program.py"
    file.write_text(PROGRAM)
    return file


def start(program: Path, **environment: str) -> subprocess.Popen[str]:
    folder = {"NUMBA_CACHE_DIR": str(program.parent / "cache"), **environment}
    return subprocess.Popen(
        [sys.executable, str(program)],
        env={**os.environ, **folder},
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
    )


def run(program: Path, **environment: str) -> tuple[str, list[str]]:
    """What a process prints, and its warnings."""
    process = start(program, **environment)
    out, err = process.communicate(timeout=120)
    assert process.returncode == 0, err
    return out.strip(), [line for line in err.splitlines() if "Warning" in line]


def files(program: Path, ending: str) -> Path:
    """The one file of the cache with this ending."""
    (found,) = (program.parent / "cache").rglob(f"*.{ending}")
    return found


def cut(data: bytes) -> bytes:
    return data[: len(data) // 2]


def flip(data: bytes) -> bytes:
    """One bit in the middle: unpickling would not notice it."""
    middle = len(data) // 2
    return data[:middle] + bytes([data[middle] ^ 1]) + data[middle + 1 :]


def slow(*case: object) -> object:
    """A case that differs little from the quick ones; each starts programs, for seconds."""
    return pytest.param(*case, marks=pytest.mark.slow)


@pytest.mark.slow
@pytest.mark.parametrize(
    ("damage", "ending"),
    [
        (cut, "nbi"),
        (flip, "nbc"),
        slow(flip, "nbi"),
        slow(cut, "nbc"),
        *(slow(lambda _, left=left: left, ending) for left in (b"", b"no machine code") for ending in ("nbi", "nbc")),
    ],
)
def test_damaged_files_cost_a_compilation_and_one_warning(
    program: Path, damage: Callable[[bytes], bytes], ending: str
) -> None:
    assert run(program) == ("2.5 0", [])
    assert run(program) == ("2.5 1", [])  # kept
    file = files(program, ending)
    file.write_bytes(damage(file.read_bytes()))
    printed, warnings = run(program)
    assert printed == "2.5 0"
    assert len(warnings) <= 1  # a flipped bit in the list of files may just name another version of Numba
    if warnings:
        assert "is damaged" in warnings[0]
        assert "compiled again" in warnings[0]
    assert bool(warnings) or (ending, damage) == ("nbi", flip)
    assert run(program) == ("2.5 1", [])  # mended


@pytest.mark.slow
def test_where_nothing_can_be_written_it_is_said_once(program: Path) -> None:
    nowhere = {"NUMBA_CACHE_DIR": "/dev/null/cache"}
    for _ in range(2):
        printed, (warning,) = run(program, **nowhere)
        assert printed == "2.5 0"
        assert "cannot be kept in /dev/null/cache" in warning
        assert "NUMBA_CACHE_DIR" in warning


@pytest.mark.slow
def test_a_file_that_cannot_be_written_is_told_of(program: Path) -> None:
    run(program)
    index = files(program, "nbi")
    index.unlink()
    index.mkdir()
    (index / "in the way").touch()
    printed, warnings = run(program)
    assert printed == "2.5 0"
    assert any("cannot be kept" in warning for warning in warnings)


@pytest.mark.slow
def test_processes_that_start_at_once_do_not_disturb_each_other(program: Path) -> None:
    started = [start(program) for _ in range(4)]
    for process in started:
        out, err = process.communicate(timeout=120)
        assert (out.split()[0], err) == ("2.5", "")
    assert run(program) == ("2.5 1", [])


@pytest.mark.slow
def test_a_home_that_is_missing_does_not_matter(program: Path) -> None:
    assert run(program, HOME="/dev/null/nobody")[0] == "2.5 0"
