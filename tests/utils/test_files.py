"""Files appear whole or not at all, and what is killed leaves nothing for long."""

import os
import signal
import subprocess
import sys
import time
from pathlib import Path
from typing import Any

import pytest

import mjbiped
from controllers import PassiveController
from mjbiped.utils import files as output
from mjbiped.utils.files import check_writable, remove_unfinished, saved, written_whole
from mjbiped.utils.parallel import processes

ROOT = Path(__file__).parents[2]
WRITER = """
import sys, time
from pathlib import Path
from mjbiped.utils.files import written_whole

with written_whole(Path(sys.argv[1])) as unfinished:
    unfinished.write_text("half of it")
    print("writing", flush=True)
    time.sleep(600.0)
"""


@pytest.fixture(autouse=True)
def new_process(monkeypatch: pytest.MonkeyPatch) -> None:
    """As if no folder had been written to yet."""
    monkeypatch.setattr(output, "_swept", set())


def names(folder: Path) -> list[str]:
    return sorted(path.name for path in folder.iterdir())


def made_old(path: Path, age: float = 3600.0) -> Path:
    before = time.time() - age
    os.utime(path, (before, before))
    return path


def test_file_takes_its_place_when_it_is_whole(tmp_path: Path) -> None:
    path = tmp_path / "walk.npz"
    path.write_text("old")
    with written_whole(path) as unfinished:
        assert unfinished.parent == tmp_path
        assert unfinished.suffix == ".npz"
        unfinished.write_text("new")
        assert path.read_text() == "old"
    assert path.read_text() == "new"
    assert names(tmp_path) == ["walk.npz"]


@pytest.mark.parametrize("error", [ValueError, KeyboardInterrupt, SystemExit])
def test_nothing_is_left_of_what_failed(error: type[BaseException], tmp_path: Path) -> None:
    def break_off(path: Path) -> None:
        with written_whole(path) as unfinished:
            unfinished.write_text("half")
            raise error

    path = tmp_path / "walk.npz"
    path.write_text("old")
    with pytest.raises(error):
        break_off(path)
    assert path.read_text() == "old"
    assert names(tmp_path) == ["walk.npz"]


def test_new_files_have_the_permissions_of_any_other(tmp_path: Path) -> None:
    before = os.umask(0o027)
    try:
        with written_whole(tmp_path / "a.csv"):
            pass
    finally:
        os.umask(before)
    assert (tmp_path / "a.csv").stat().st_mode & 0o777 == 0o640


def test_relative_paths_stay_where_they_were(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    (tmp_path / "other").mkdir()
    monkeypatch.chdir(tmp_path)
    with written_whole(Path("a.csv")) as unfinished:
        os.chdir("other")
        unfinished.write_text("a")
    assert (tmp_path / "a.csv").read_text() == "a"


def test_places_that_no_file_can_take_are_refused_first(tmp_path: Path) -> None:
    (tmp_path / "folder.npz").mkdir()
    odd = [tmp_path / "folder.npz", tmp_path / "no folder" / "a.npz", tmp_path / ("a" * 300), tmp_path / "a\0.npz"]
    for path in (*odd, tmp_path / "\ud800.npz"):
        with pytest.raises(OSError, match=r"."), written_whole(path):
            pytest.fail("entered")
        with pytest.raises(OSError, match=r"."):
            check_writable(path)
    longest = tmp_path / ("a" * 251 + ".npz")  # 255 letters, of which none is left for another name made of it
    check_writable(longest)
    with written_whole(longest):
        pass
    assert names(tmp_path) == [longest.name, "folder.npz"]


def test_records_are_refused_where_no_file_can_be(tmp_path: Path) -> None:
    ground = mjbiped.Terrain.level()
    walk = mjbiped.walk(PassiveController(), ground, engine="hybrid", initial="rest", sample_period=None)
    with pytest.raises(mjbiped.RecordError, match="cannot write"):
        walk.save(tmp_path / "a\0.npz")


@pytest.mark.parametrize("failure", [mjbiped.RecordError, mjbiped.RenderError])
def test_a_file_that_cannot_be_written_is_told_in_words(failure: type[mjbiped.MjbipedError], tmp_path: Path) -> None:
    with pytest.raises(failure, match=r"cannot write .*: No such file"), saved(tmp_path / "no folder" / "a", failure):
        pytest.fail("entered")
    with pytest.raises(failure, match=r"cannot write .*: disk full"), saved(tmp_path / "a.csv", failure):
        raise OSError("disk full")
    assert names(tmp_path) == []


# ---- what was left behind --------------------------------------------------------------------------------------------


@pytest.fixture
def left(tmp_path: Path) -> Path:
    """A file that a killed process left behind two days ago."""
    path = tmp_path / ".mjbiped-0123456789abcdef.npz"
    path.write_text("half")
    return made_old(path, 2e5)


def test_what_was_left_behind_is_removed_at_the_next_start(left: Path, tmp_path: Path) -> None:
    check_writable(tmp_path / "walk.npz")
    assert names(tmp_path) == []


def test_only_what_is_certainly_ours_is_removed(left: Path, tmp_path: Path) -> None:
    theirs = [
        ".mjbiped-notes.npz", ".mjbiped-0123456789abcdeg.npz", "mjbiped-0123456789abcdef.npz", ".walk-abcdefgh.npz",
        ".mjbiped-0123456789abcdef0.npz", ".mjbiped-0123456789abcdef.npz.bak", "walk.npz", ".mjbiped-0123456789abcdef ",
    ]  # fmt: skip
    for name in theirs:
        (tmp_path / name).write_text("mine")
        made_old(tmp_path / name, 1e7)
    (tmp_path / ".mjbiped-aaaaaaaaaaaaaaaa").mkdir()
    (tmp_path / ".mjbiped-bbbbbbbbbbbbbbbb.npz").symlink_to(tmp_path / "walk.npz")
    kept = {*names(tmp_path)} - {left.name}
    with written_whole(tmp_path / "walk.npz") as unfinished:
        unfinished.write_text("new")
    assert {*names(tmp_path)} == kept


def test_what_is_being_written_is_not_removed(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    with written_whole(tmp_path / "long.mp4") as unfinished:
        made_old(unfinished, 1e6)  # an encoder that has not written for long
        monkeypatch.setattr(output, "_swept", set())
        check_writable(tmp_path / "walk.npz")
        assert unfinished.exists()
    assert names(tmp_path) == ["long.mp4"]


def test_what_another_process_may_still_write_is_not_removed(left: Path, tmp_path: Path) -> None:
    made_old(left, 3600.0)
    check_writable(tmp_path / "walk.npz")
    assert left.exists()


def test_a_folder_is_looked_through_once(left: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    looked: list[object] = []
    scan = os.scandir

    def counted(folder: Path) -> Any:
        looked.append(folder)
        return scan(folder)

    monkeypatch.setattr(os, "scandir", counted)
    for _ in range(3):
        check_writable(tmp_path / "walk.npz")
    assert looked == [tmp_path]


# ---- processes that end ----------------------------------------------------------------------------------------------


def writer(folder: Path) -> subprocess.Popen[str]:
    """A process in the midst of writing a file."""
    path = os.pathsep.join(filter(None, (str(ROOT), os.environ.get("PYTHONPATH"))))
    process = subprocess.Popen(
        [sys.executable, "-c", WRITER, str(folder / "walk.npz")],
        env={**os.environ, "PYTHONPATH": path},
        stdout=subprocess.PIPE,
        stderr=subprocess.DEVNULL,
        text=True,
    )
    assert process.stdout is not None
    assert process.stdout.readline() == "writing\n"
    return process


@pytest.mark.slow
@pytest.mark.skipif(sys.platform == "win32", reason="signals of Unix")
def test_killed_and_interrupted_processes_leave_nothing_for_long(tmp_path: Path) -> None:
    both = [writer(tmp_path), writer(tmp_path)]
    for process, number in zip(both, (signal.SIGKILL, signal.SIGINT), strict=True):
        process.send_signal(number)
        process.communicate(timeout=60)
    assert both[0].returncode == -signal.SIGKILL
    left = list(tmp_path.iterdir())
    assert len(left) == 1  # the killed one's
    made_old(left[0], 2e5)
    check_writable(tmp_path / "walk.npz")
    assert names(tmp_path) == []


def test_what_a_second_interrupt_leaves_is_removed_when_the_process_ends(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    def interrupt(*_: object, **__: object) -> None:
        raise KeyboardInterrupt

    def interrupt_twice(patched: pytest.MonkeyPatch) -> None:
        with written_whole(tmp_path / "a.csv"):
            patched.setattr(Path, "unlink", interrupt)
            raise KeyboardInterrupt

    with monkeypatch.context() as patched, pytest.raises(KeyboardInterrupt):
        interrupt_twice(patched)
    assert len(names(tmp_path)) == 1
    remove_unfinished()
    assert names(tmp_path) == []


def write_for_long(path: Path) -> None:
    with written_whole(path) as unfinished:
        path.with_name("begun").touch()
        time.sleep(600.0)
        unfinished.write_text("never")


@pytest.mark.slow
@pytest.mark.skipif(sys.platform == "win32", reason="signals of Unix")
def test_workers_that_are_ended_leave_nothing(tmp_path: Path) -> None:
    def break_off() -> None:
        with processes(1) as pool:
            pool.submit(write_for_long, tmp_path / "walk.npz")
            end = time.monotonic() + 120.0
            while not (tmp_path / "begun").exists():
                assert time.monotonic() < end
                time.sleep(0.02)
            raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        break_off()
    assert names(tmp_path) == ["begun"]
