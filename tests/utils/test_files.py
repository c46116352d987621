"""Files appear whole or not at all."""

import os
from contextlib import nullcontext
from pathlib import Path

import pytest

import mjbiped
from mjbiped.utils import files
from mjbiped.utils.files import check_writable, read_bytes, saved, written_whole


def names(folder: Path) -> list[str]:
    return sorted(path.name for path in folder.iterdir())


@pytest.mark.parametrize("error", [None, ValueError, KeyboardInterrupt])
def test_a_file_is_whole_or_as_it_was(error: type[BaseException] | None, tmp_path: Path) -> None:
    path = tmp_path / "walk.npz"
    path.write_text("old")
    with pytest.raises(error) if error else nullcontext(), written_whole(path) as unfinished:
        assert (unfinished.parent, unfinished.suffix) == (tmp_path, ".npz")
        unfinished.write_text("new")
        assert path.read_text() == "old"
        if error:
            raise error
    assert path.read_text() == ("old" if error else "new")
    assert names(tmp_path) == ["walk.npz"]


def test_new_files_have_the_permissions_of_any_other(tmp_path: Path) -> None:
    before = os.umask(0o027)
    try:
        with written_whole(tmp_path / "a.csv"):
            pass
    finally:
        os.umask(before)
    assert (tmp_path / "a.csv").stat().st_mode & 0o777 == 0o640


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
