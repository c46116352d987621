"""Files of numbers and texts, which are written whole or not at all and read without trust in their source.

Nothing in a file is executed, and nothing is unpacked or allocated before the sizes that it claims have been compared
with each other and with the size of the file.
"""

from __future__ import annotations

import io
import json
import sys
import zipfile
from collections.abc import Collection, Mapping
from pathlib import Path
from typing import Any

import numpy as np
from numpy.lib import format as npy
from numpy.typing import ArrayLike, NDArray

from mjbiped.errors import InputError, RecordError, shown
from mjbiped.utils.files import require_file, saved

MOST_UNPACKED, ROOM = 100, 256 << 20
"""Greatest size of an unpacked archive: this multiple of its size, plus this many bytes. Records unpack to 1.0 to 37
times their size, most where a robot stands still."""

MOST_MEMBERS = 256
"""Greatest number of arrays in an archive; a walk's record has about forty."""

NUMBERS = (np.dtype(np.float64), np.dtype(np.int64))
"""Types of the numbers in a record."""

LONGEST_HEADER, LONGEST_DESCRIPTION = 32_000_000, 3_200_000
"""Greatest numbers of characters of a record's header and of a controller's description; the longest terrain, of
100 000 segments, takes half of a header."""

_DEEPEST = 40  # levels of nested settings; the engines' own have five


def write_arrays(path: Path, arrays: Mapping[str, ArrayLike]) -> None:
    """Write numbers or texts by name as an .npz file, which appears whole or not at all.

    Raises:
        RecordError: The file cannot be written.
    """
    with saved(path) as unfinished:
        np.savez_compressed(unfinished, allow_pickle=False, **arrays)


def read_arrays(
    path: Path, what: str = "walk's record", types: Collection[np.dtype[Any]] = NUMBERS
) -> dict[str, NDArray[Any]]:
    """Read an .npz file of numbers and single texts.

    Args:
        path: The file.
        what: What the file should be, for messages.
        types: Of the numbers, in this machine's byte order; by default floats and whole numbers of 64 bits.

    Returns:
        Its arrays by name, in this machine's byte order; other members are left out.

    Raises:
        RecordError: The file is missing, damaged, not such an archive, or does not hold what it claims.
    """
    try:
        require_file(path)
        with _Bounded(path.open("rb", buffering=0)) as file, zipfile.ZipFile(file) as archive:
            file.longest = sys.maxsize  # arrays may be long
            members, size = archive.infolist(), path.stat().st_size
            if len(members) > MOST_MEMBERS:
                raise RecordError(f"it holds {len(members)} arrays; a record has at most {MOST_MEMBERS}")
            if (claimed := sum(member.file_size for member in members)) > MOST_UNPACKED * size + ROOM:
                raise RecordError(f"it claims to hold {claimed} bytes in a file of {size}")
            names = (member.filename for member in members if member.filename.endswith(".npy"))
            return {name.removesuffix(".npy"): _array(archive.read(name), types) for name in names}
    except InputError as error:
        raise RecordError(f"{path}: {error}") from error
    except RecordError as error:
        raise RecordError(f"{path} is no {what}: {error}") from error
    except OSError as error:
        raise RecordError(f"cannot read {path}: {error.strerror or error}") from error
    except MemoryError as error:
        raise RecordError(f"cannot read {path}: there is not enough memory for it") from error
    except Exception as error:  # whatever damaged bytes make the parsers of zipfile, zlib and NumPy raise
        raise RecordError(
            f"{path} is no {what}, or only a part of one ({shown(error)}); write the file again"
        ) from error


class _Bounded(io.BufferedReader):
    """A file that refuses to read a directory of very many members, which takes zipfile minutes and gigabytes.

    Attributes:
        longest: Greatest number of bytes of one read: zipfile reads the whole directory at once.
    """

    longest = 1 << 20

    def read(self, size: int | None = -1, /) -> bytes:
        """Read up to `size` bytes.

        Raises:
            RecordError: These are more than `longest`.
        """
        if size is not None and size > self.longest:
            raise RecordError(f"its directory has {size} bytes; a record has at most {MOST_MEMBERS} arrays")
        return super().read(size)


def _array(data: bytes, types: Collection[np.dtype[Any]]) -> NDArray[Any]:
    """Return the array in the content of an .npy file.

    Raises:
        RecordError: Its type is not one that records have.
        ValueError: The file is damaged, or its size is not what it claims.
    """
    stream = io.BytesIO(data)
    npy.read_magic(stream)
    shape, fortran_order, dtype = npy.read_array_header_1_0(stream)  # NumPy writes these types in no other version
    if dtype.newbyteorder("=") not in types and (dtype.kind != "U" or shape != ()):
        raise RecordError(f"an array is of type {dtype}; expected numbers of 64 bits")
    numbers = np.frombuffer(data, dtype, offset=stream.tell())
    if min(shape, default=0) < 0:
        raise ValueError(f"negative shape {shape}")
    return numbers.reshape(shape, order="F" if fortran_order else "C").astype(dtype.newbyteorder("="))


def parsed(text: str, longest: int = LONGEST_HEADER) -> Any:
    """Read a JSON text into values that are safe to compute with and to write again.

    Args:
        text: JSON text as it stands in a file.
        longest: Greatest number of characters that it may have.

    Raises:
        ValueError: The text is not JSON, too long or nested too deeply, or holds a text that cannot be written.
    """
    if len(text) > longest:
        raise ValueError(f"it is too long: {len(text)} characters; expected at most {longest}")
    try:
        value = json.loads(text)
        json.dumps(value, ensure_ascii=False).encode()
        if _depth(value) <= _DEEPEST:
            return value
    except RecursionError:
        pass
    raise ValueError(f"nested more than {_DEEPEST} times")


def _depth(value: object) -> int:
    """Count the levels of nesting of a JSON value."""
    parts = value.values() if isinstance(value, dict) else value if isinstance(value, list) else ()
    return 1 + max(map(_depth, parts), default=-1)
