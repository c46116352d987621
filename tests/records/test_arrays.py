"""What is read of an archive that may come from anyone, and at what cost."""

import io
import os
import struct
import tracemalloc
import zipfile
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from mjbiped.errors import RecordError
from mjbiped.records import arrays as record_file
from mjbiped.records.arrays import read_arrays, write_arrays


def array_file(array: np.ndarray, header: str = "") -> bytes:
    """An .npy file, with another header where one is given."""
    stream = io.BytesIO()
    np.save(stream, array)
    if not header:
        return stream.getvalue()
    text = header.encode() + b"\n"
    return b"\x93NUMPY\x01\x00" + struct.pack("<H", len(text)) + text + array.tobytes()


def archive_of(path: Path, compression: int = zipfile.ZIP_DEFLATED, **members: bytes) -> Path:
    with zipfile.ZipFile(path, "w", compression) as archive:
        for name, content in members.items():
            archive.writestr(f"{name}.npy", content)
    return path


def header_of(descr: str, shape: str) -> str:
    return f"{{'descr': '{descr}', 'fortran_order': False, 'shape': {shape}, }}"


def test_numbers_and_texts_come_back(tmp_path: Path) -> None:
    path = tmp_path / "arrays.npz"
    given: dict[str, Any] = {
        "floats": np.arange(6.0).reshape(2, 3),
        "other_order": np.asfortranarray(np.arange(6.0).reshape(2, 3)),
        "other_end": np.arange(3.0).astype(">f8"),
        "whole": np.arange(4),
        "text": np.array("some text"),
        "none": np.empty((0, 2)),
    }
    for save in (np.savez, np.savez_compressed):
        save(path, **given)
        found = read_arrays(path)
        assert found.keys() == given.keys()
        for name, array in given.items():
            np.testing.assert_array_equal(found[name], array)
            assert found[name].dtype.isnative
            assert found[name].flags.writeable


@pytest.mark.parametrize(
    "shape", ["(962072674304,)", "(1099511627776, 8)", "(-1,)", "(5,)", f"({2**62}, 4)", f"({10**400},)"]
)
def test_claimed_shapes_are_compared_before_anything_is_allocated(shape: str, tmp_path: Path) -> None:
    """A header that claimed 7 TiB ended in a MemoryError."""
    path = archive_of(tmp_path / "huge.npz", a=array_file(np.zeros(3), header_of("<f8", shape)))
    tracemalloc.start()
    try:
        with pytest.raises(RecordError, match="no walk's record"):
            read_arrays(path)
        assert tracemalloc.get_traced_memory()[1] < 1 << 20
    finally:
        tracemalloc.stop()


def test_claimed_sizes_of_members_are_compared_with_the_file(tmp_path: Path) -> None:
    path = archive_of(tmp_path / "huge.npz", a=array_file(np.zeros(3)))
    content = bytearray(path.read_bytes())
    entry = content.rindex(b"PK\x01\x02")
    content[entry + 24 : entry + 28] = struct.pack("<I", 0xFFFFFFFE)  # the size unpacked, in the archive's directory
    path.write_bytes(content)
    with pytest.raises(RecordError, match="claims to hold 4294967294 bytes"):
        read_arrays(path)


def test_what_unpacks_to_far_more_is_refused(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Zeros, a thousand to one, beyond the room that is left to small files."""
    monkeypatch.setattr(record_file, "ROOM", 1 << 20)
    path = archive_of(tmp_path / "zeros.npz", a=array_file(np.zeros(1 << 16)))
    assert read_arrays(path)["a"].shape == (1 << 16,)
    path = archive_of(tmp_path / "bomb.npz", a=array_file(np.zeros(1 << 18)))
    assert path.stat().st_size < 4096
    with pytest.raises(RecordError, match="claims to hold"):
        read_arrays(path)


@pytest.mark.parametrize("descr", ["<f4", "|O", "<c16", "<M8[s]", "|V8", "<U3"])
def test_other_types_are_refused(descr: str, tmp_path: Path) -> None:
    path = archive_of(tmp_path / "types.npz", a=array_file(np.zeros(3), header_of(descr, "(3,)")))
    with pytest.raises(RecordError, match="expected numbers of 64 bits"):
        read_arrays(path)


def test_archives_of_many_members_are_refused(tmp_path: Path) -> None:
    """Some 20 000 arrays of one number each took longer to read than any walk."""
    one = array_file(np.zeros(1))

    def holding(count: int) -> Path:
        return archive_of(tmp_path / "many.npz", zipfile.ZIP_DEFLATED, **{f"{k:0>40}": one for k in range(count)})

    assert len(read_arrays(holding(record_file.MOST_MEMBERS))) == record_file.MOST_MEMBERS
    with pytest.raises(RecordError, match="a record has at most 256"):
        read_arrays(holding(record_file.MOST_MEMBERS + 1))


def test_a_directory_of_very_many_members_is_not_read(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    path = tmp_path / "many.npz"
    with zipfile.ZipFile(path, "w") as archive:
        for number in range(300):  # names of 4 kB fill a directory of more than 1 MiB
            archive.writestr(f"{number:04000}.npy", b"")
    monkeypatch.setattr(zipfile, "ZipInfo", None)  # what the directory's entries become
    with pytest.raises(RecordError, match=r"its directory has \d+ bytes; a record has at most 256 arrays"):
        read_arrays(path)


def test_arrays_may_be_longer_than_a_directory(tmp_path: Path) -> None:
    numbers = np.random.default_rng(0).normal(size=1 << 18)  # 2 MiB, which no packing makes shorter
    text = "".join(map(chr, np.random.default_rng(1).integers(32, 126, 1 << 20)))
    write_arrays(tmp_path / "long.npz", {"numbers": numbers, "text": text})
    found = read_arrays(tmp_path / "long.npz")
    assert found["numbers"].tobytes() == numbers.tobytes()
    assert str(found["text"]) == text


def test_devices_and_pipes_are_not_read(tmp_path: Path) -> None:
    """One gives bytes without end (23 GB were read once), the other waits for someone to write."""
    pipe = tmp_path / "walk.npz"
    os.mkfifo(pipe)
    for path in (Path("/dev/zero"), Path("/dev/null"), pipe):
        with pytest.raises(RecordError, match=f"{path}: is a device or a pipe; expected a file"):
            read_arrays(path)
    with pytest.raises(RecordError, match="is a folder"):
        read_arrays(tmp_path)


def test_pickles_are_never_opened(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    path = tmp_path / "pickled.npz"
    np.savez(path, a=np.array([{"code": 1}], dtype=object))
    monkeypatch.setattr("pickle.load", lambda *_, **__: pytest.fail("a pickle was opened"))
    with pytest.raises(RecordError, match="expected numbers of 64 bits"):
        read_arrays(path)


@pytest.mark.parametrize("header", ["{", "[" * 5000, "(" * 60 + ")" * 60, "{'descr': 3}", "x" * 20_000, "'a': 0L,"])
def test_headers_that_cannot_be_read(header: str, tmp_path: Path) -> None:
    path = archive_of(tmp_path / "header.npz", a=array_file(np.zeros(3), header))
    with pytest.raises(RecordError, match="no walk's record"):
        read_arrays(path)


def test_every_single_byte_of_the_packed_numbers_counts(tmp_path: Path) -> None:
    path = archive_of(tmp_path / "flipped.npz", a=array_file(np.random.default_rng(0).normal(size=50)))
    content = path.read_bytes()
    for place in range(200, 400, 7):
        changed = bytearray(content)
        changed[place] ^= 0x10
        path.write_bytes(changed)
        with pytest.raises(RecordError, match="no walk's record"):
            read_arrays(path)
