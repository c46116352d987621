"""The folder of machine code: what was not used for longest goes first, and all of it on demand."""

import os
from pathlib import Path

import pytest
from command_line import run

from mjbiped.numerics import cache_folder


@pytest.fixture
def files(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> list[Path]:
    """Three files of 100 bytes, the first used last, in a folder of somebody who has other things in it too."""
    monkeypatch.setenv("NUMBA_CACHE_DIR", str(tmp_path))
    folder = tmp_path / "mjbiped" / "numba-0.0"
    folder.mkdir(parents=True)
    (tmp_path / "mine.nbc").write_bytes(bytes(500))
    made = [folder / name for name in ("a.nbi", "b.1.nbc", "c.2.nbc")]
    for age, file in enumerate(made):
        file.write_bytes(bytes(100))
        os.utime(file, (1e9 - age, 0.0))
    return made


def test_what_was_not_used_for_longest_is_deleted_first(files: list[Path]) -> None:
    cache_folder.note_use(str(files[2]))
    cache_folder.prune.__wrapped__(most=250)
    assert [file.exists() for file in files] == [True, False, True]
    cache_folder.prune.__wrapped__(most=250)
    assert files[0].exists()


def test_without_a_home_it_is_beside_the_package(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    monkeypatch.delenv("NUMBA_CACHE_DIR", raising=False)
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path))
    assert cache_folder.root() == tmp_path / "mjbiped" / "machine_code"
    monkeypatch.setenv("XDG_CACHE_HOME", "/dev/null/nobody")
    assert cache_folder.root().is_relative_to(Path(cache_folder.__file__).parent)


def test_the_command_clears_it_and_nothing_else(files: list[Path], tmp_path: Path) -> None:
    assert "give it alone" in run("compile", "adaptive", "--clear").stderr
    result = run("compile", "--clear")
    assert result.stdout == f"deleted 0.0 MB of machine code in {tmp_path / 'mjbiped'}\n"
    assert list(tmp_path.iterdir()) == [tmp_path / "mine.nbc"]
    assert run("compile", "--clear").exit_code == 0
