"""The arrays of an .npz file: written whole or not at all, and read as what may come from anyone.

Nothing in a file is executed, and nothing is unpacked or allocated before the sizes that it claims have been compared
with each other and with the size of the file.
"""

from __future__ import annotations

import math
import os
import struct
import zipfile
from collections.abc import Mapping
from pathlib import Path
from typing import IO, Any

import numpy as np
from numpy.lib import format as npy
from numpy.typing import ArrayLike, NDArray

from mjbiped.errors import InputError, RecordError, shown
from mjbiped.utils.files import saved
from mjbiped.utils.reading import require_file

MOST_UNPACKED, ROOM = 100, 256 << 20
"""An archive may unpack to so many times its size, and so many bytes more. Records do to 1.0 to 37 times, most where a
robot stands still."""

MOST_MEMBERS = 256
"""Arrays of an archive at most; a walk's record has some forty."""

_SUFFIX = ".npy"
_LONGEST_DIRECTORY = 256 * MOST_MEMBERS  # bytes; an entry has 46, a name and 20 for sizes beyond 4 GiB
_END, _END_MARK = struct.Struct("<4s4H2LH"), b"PK\5\6"  # of a directory, with its size in the middle
_LONGEST_END = _END.size + 0xFFFF  # bytes, with a comment
_LOCATOR, _LOCATOR_MARK = 20, b"PK\6\7"  # bytes before it that say where another end is, for great files
_GREAT = 1 << 32
_NUMBERS = (np.dtype(np.float64), np.dtype(np.int64))


def write_arrays(path: Path, arrays: Mapping[str, ArrayLike]) -> None:
    """Write an .npz file; it appears whole or not at all.

    Args:
        path: The file.
        arrays: Numbers or texts by their names, in arrays or in what NumPy makes one of.

    Raises:
        RecordError: The file cannot be written.
    """
    with saved(path) as unfinished:
        np.savez_compressed(unfinished, allow_pickle=False, **arrays)


def read_arrays(path: Path) -> dict[str, NDArray[Any]]:
    """Read an .npz file of floats, whole numbers of 64 bits, and single texts.

    Args:
        path: The file.

    Returns:
        Its arrays by their names, in this machine's byte order; members that are no arrays are left out.

    Raises:
        RecordError: The file is missing, damaged, no such archive, or does not hold what it claims.
    """
    try:
        require_file(path)
        with path.open("rb") as stream:
            size = stream.seek(0, os.SEEK_END)
            _check_directory(stream, size)
            with zipfile.ZipFile(stream) as archive:
                return {name: _read(archive, member) for name, member in _members(archive, size).items()}
    except InputError as error:
        raise RecordError(f"{path}: {error}") from error
    except RecordError as error:
        raise RecordError(f"{path} is no walk's record: {error}") from error
    except OSError as error:
        raise RecordError(f"cannot read {path}: {error.strerror or error}") from error
    except MemoryError as error:
        raise RecordError(f"cannot read {path}: there is not enough memory for it") from error
    except Exception as error:  # whatever damaged bytes make the parsers of zipfile, zlib and NumPy raise
        raise RecordError(f"{path} is no walk's record, or only a part of one ({shown(error)})") from error


def _check_directory(stream: IO[bytes], size: int) -> None:
    """Refuse an archive of so many bytes that lists more than any record, before zipfile reads its whole directory.

    Raises:
        RecordError: It does.
    """
    stream.seek(max(0, size - _LONGEST_END))
    last = stream.read()
    place = len(last) - _END.size
    if not (last[place:].startswith(_END_MARK) and last.endswith(b"\0\0")):  # as zipfile looks for it: with a comment
        place = last.rfind(_END_MARK)
    if not 0 <= place <= len(last) - _END.size:
        return  # zipfile says so
    if _END.unpack_from(last, place)[5] > _LONGEST_DIRECTORY:
        raise RecordError(f"it lists more than the {MOST_MEMBERS} arrays that a record has at most")
    if size < _GREAT and last[:place][-_LOCATOR:].startswith(_LOCATOR_MARK):  # another place for the directory's length
        raise RecordError("it is packed as a file of more than 4 GiB, and is none")


def _members(archive: zipfile.ZipFile, size: int) -> dict[str, zipfile.ZipInfo]:
    """The members of an archive of so many bytes that are arrays, by the arrays' names.

    Raises:
        RecordError: There are two of one name, they are packed in a way that no record is, or claim to be too large.
    """
    members: dict[str, zipfile.ZipInfo] = {}
    if len(archive.infolist()) > MOST_MEMBERS:
        raise RecordError(f"it holds {len(archive.infolist())} arrays; a record has at most {MOST_MEMBERS}")
    for member in archive.infolist():
        if not member.filename.endswith(_SUFFIX):
            continue
        name = member.filename.removesuffix(_SUFFIX)
        if name in members:
            raise RecordError(f"it holds {shown(name)} twice")
        if member.flag_bits & 1 or member.compress_type not in (zipfile.ZIP_STORED, zipfile.ZIP_DEFLATED):
            raise RecordError(f"{shown(name)} is encrypted, or compressed by another method than deflate")
        members[name] = member
    claimed = sum(member.file_size for member in members.values())
    if claimed > MOST_UNPACKED * size + ROOM:
        raise RecordError(f"it claims to hold {claimed} bytes in a file of {size}")
    return members


def _read(archive: zipfile.ZipFile, member: zipfile.ZipInfo) -> NDArray[Any]:
    """Read one array.

    Raises:
        RecordError: It is not of a kind that records have, or its size is not what it claims.
    """
    with archive.open(member) as stream:
        shape, dtype = _header(stream)
        text = dtype.kind == "U" and shape == ()
        if not text and dtype.newbyteorder("=") not in _NUMBERS:
            raise RecordError(f"{shown(member.filename)} is of type {dtype}; expected numbers of 64 bits")
        if min(shape, default=0) < 0 or stream.tell() + math.prod(shape) * dtype.itemsize != member.file_size:
            raise RecordError(f"{shown(member.filename)} claims the shape {shown(shape)}, which is not its size")
        stream.seek(0)
        array: NDArray[Any] = npy.read_array(stream, allow_pickle=False)
        if stream.read(1):  # the end is where zipfile compares checksums
            raise RecordError(f"{shown(member.filename)} is longer than it claims")
    return array.astype(dtype.newbyteorder("="), copy=False)


def _header(stream: IO[bytes]) -> tuple[tuple[int, ...], np.dtype[Any]]:
    """Shape and type of the array in a stream, which then stands at its first number.

    Raises:
        RecordError: It is in a format in which NumPy writes no such array.
    """
    version = npy.read_magic(stream)
    if version != (1, 0):
        raise RecordError(f"an array is in the format {version} of NumPy; expected (1, 0)")
    shape, _, dtype = npy.read_array_header_1_0(stream)
    return shape, dtype
