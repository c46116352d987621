"""Machine code on disk: damaged files, folders that cannot be written to, processes at once, and its size."""

import os
import zlib
from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

import pytest
from command_line import python
from command_line import run as command

from mjbiped.numerics import cache

PROGRAM = """
from mjbiped.numerics.cache import announced
from mjbiped.numerics.machine import compiled

def double(x):
    return x + x

with announced("it", 1.0):
    print(compiled(double, "float64(float64)")(1.25))
"""


@pytest.fixture
def program(tmp_path: Path) -> Path:
    file = tmp_path / "program.py"
    file.write_text(PROGRAM)
    return file


def run(program: Path, cache: str = "") -> tuple[bool, list[str]]:
    """Whether a process has compiled the function, and its warnings."""
    done = python(program, cwd=program.parent, NUMBA_CACHE_DIR=cache or str(program.parent / "cache"))
    assert (done.returncode, done.stdout) == (0, "2.5\n"), done.stderr
    return "compiling it" in done.stderr, [line for line in done.stderr.splitlines() if "Warning" in line]


def flip(data: bytes) -> bytes:
    """One bit in the middle, which only a digest tells."""
    middle = len(data) // 2
    return data[:middle] + bytes([data[middle] ^ 1]) + data[middle + 1 :]


@pytest.mark.slow
@pytest.mark.parametrize("damage", [flip, lambda data: data[: len(data) // 2], lambda _: b"no machine code"])
def test_damaged_files_cost_a_compilation(program: Path, damage: Callable[[bytes], bytes]) -> None:
    assert run(program) == (True, [])
    assert run(program) == (False, [])  # kept
    (file,) = (program.parent / "cache").rglob("*.nb?")
    file.write_bytes(damage(file.read_bytes()))
    assert run(program) == (True, [])
    assert run(program) == (False, [])  # mended


@pytest.mark.slow
def test_where_nothing_can_be_written_it_is_said_once(program: Path) -> None:
    for _ in range(2):
        compiled, (warning,) = run(program, "/dev/null/cache")
        assert compiled
        assert "cannot be kept in /dev/null/cache" in warning
        assert "NUMBA_CACHE_DIR" in warning


@pytest.mark.slow
def test_processes_that_start_at_once_do_not_disturb_each_other(program: Path) -> None:
    with ThreadPoolExecutor(4) as pool:
        assert [warnings for _, warnings in pool.map(run, [program] * 4)] == [[]] * 4
    assert run(program) == (False, [])


@pytest.fixture
def files(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> list[Path]:
    """Three files of 100 bytes, the first used last, in a folder of somebody who has other things in it too."""
    monkeypatch.setenv("NUMBA_CACHE_DIR", str(tmp_path))
    folder = tmp_path / "mjbiped" / "numba-0.0"
    monkeypatch.setattr(cache, "_folder", lambda: folder)
    folder.mkdir(parents=True)
    (tmp_path / "mine.nbc").write_bytes(bytes(500))
    made = [folder / name for name in ("a.nbc", "b.nbc", "c.nbc")]
    for age, file in enumerate(made):
        file.write_bytes(bytes(100))
        os.utime(file, (1e9, 1e9 - age))
    return made


def test_what_was_not_used_for_longest_is_deleted_first(files: list[Path]) -> None:
    files[2].write_bytes(zlib.compress(b"used"))
    os.utime(files[2], (0.0, 0.0))
    assert cache.load("c") == b"used"
    cache.prune.__wrapped__(most=150)
    assert [file.exists() for file in files] == [True, False, True]
    cache.prune.__wrapped__(most=150)
    assert files[0].exists()


def test_without_a_home_it_is_beside_the_package(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    monkeypatch.delenv("NUMBA_CACHE_DIR", raising=False)
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path))
    for _ in range(2):  # made, and found
        assert cache.root() == tmp_path / "mjbiped" / "machine_code"
    monkeypatch.setenv("XDG_CACHE_HOME", "/dev/null/nobody")
    assert cache.root().is_relative_to(Path(cache.__file__).parent)


@pytest.mark.usefixtures("files")
def test_the_command_clears_it_and_nothing_else(tmp_path: Path) -> None:
    assert "give it alone" in command("compile", "adaptive", "--clear").stderr
    result = command("compile", "--clear")
    assert result.stdout == f"deleted 0.0 MB of machine code in {tmp_path / 'mjbiped'}\n"
    assert list(tmp_path.iterdir()) == [tmp_path / "mine.nbc"]
    assert command("compile", "--clear").exit_code == 0
