"""Files appear whole or not at all."""

import os
from pathlib import Path

import pytest

import mjbiped
from mjbiped.utils import files
from mjbiped.utils.files import check_writable, read_bytes, saved, written_whole


def names(folder: Path) -> list[str]:
    return sorted(path.name for path in folder.iterdir())


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


@pytest.mark.parametrize("error", [ValueError, KeyboardInterrupt])
def test_nothing_is_left_of_what_failed(error: type[BaseException], tmp_path: Path) -> None:
    path = tmp_path / "walk.npz"
    path.write_text("old")
    with pytest.raises(error), written_whole(path) as unfinished:  # noqa: PT012 (what fails is in the block)
        unfinished.write_text("half")
        raise error
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


def test_a_file_that_cannot_be_written_is_told_in_words(tmp_path: Path) -> None:
    with pytest.raises(mjbiped.RenderError, match=r"cannot write .*: disk full"):  # noqa: SIM117
        with saved(tmp_path / "a.csv", mjbiped.RenderError):
            raise OSError("disk full")
    assert names(tmp_path) == []


def test_a_file_is_read_up_to_a_size(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(files, "LONGEST", 4)
    (tmp_path / "short").write_bytes(b"1234")
    (tmp_path / "long").write_bytes(b"12345")
    assert read_bytes(tmp_path / "short") == b"1234"
    with pytest.raises(mjbiped.InputError, match="is longer than"):
        read_bytes(tmp_path / "long")
