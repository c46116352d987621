"""Machine code on disk, made once: Numba's cache, which here tolerates damaged files.

Files are kept in `mjbiped.numerics.cache_folder.folder`, where programs and versions of this project share them: the
name of what is compiled contains a digest of it. Each is written completely before it gets its name, so that processes
may start at the same time. A file that is damaged, or cannot be read or written, costs time and a warning, no more.

This module imports Numba: import it where something is compiled, not before.
"""

from __future__ import annotations

import hashlib
import importlib
import pickle
import sys
import warnings
from functools import lru_cache
from pathlib import Path
from typing import Any

from mjbiped.numerics.cache_folder import folder, note_use, prune

caching: Any = importlib.import_module("numba.core.caching")  # Numba has no types

_DIGEST = hashlib.sha256().digest_size


class _Place:
    """What Numba asks about the place of a function's files."""

    def get_cache_path(self) -> str:
        """Return the folder."""
        return str(folder())

    def ensure_cache_path(self) -> None:
        """Make the folder; as each program begins to keep code, what is too much there is thrown away.

        Raises:
            OSError: It cannot be made.
        """
        folder().mkdir(parents=True, exist_ok=True)
        prune()

    def get_source_stamp(self) -> str:
        """Return what would tell an older source: nothing, for names contain digests."""
        return ""


class _Kind(caching.CompileResultCacheImpl):  # type: ignore[misc]  # Numba has no types
    """Numba's way to write machine code, in our folder."""

    def __init__(self, function: Any) -> None:
        """Name the files after the function."""
        self._locator = _Place()
        self._filename_base = f"{function.__name__}.py{sys.version_info[0]}{sys.version_info[1]}"


class _Files(caching.IndexDataCacheFile):  # type: ignore[misc]  # Numba has no types
    """The files of one function; a digest precedes the machine code."""

    def _load_index(self) -> Any:
        note_use(self._index_path)
        return super()._load_index()

    def _load_data(self, name: str) -> Any:
        note_use(self._data_path(name))
        stored = Path(self._data_path(name)).read_bytes()
        if hashlib.sha256(stored[_DIGEST:]).digest() != stored[:_DIGEST]:
            raise ValueError("machine code and digest differ")
        return pickle.loads(stored[_DIGEST:])

    def _save_data(self, name: str, data: Any) -> None:
        dumped = self._dump(data)
        with self._open_for_write(self._data_path(name)) as file:
            file.write(hashlib.sha256(dumped).digest() + dumped)


class MachineCodeCache(caching.FunctionCache):  # type: ignore[misc]  # Numba has no types
    """Numba's cache of a function; what it cannot read is compiled again, what it cannot write is not kept."""

    _impl_class = _Kind

    def __init__(self, function: Any) -> None:
        """Find the files."""
        super().__init__(function)
        locator, name = self._impl.locator, self._impl.filename_base
        self._cache_file = _Files(self._cache_path, name, locator.get_source_stamp())

    def load_overload(self, sig: Any, target_context: Any) -> Any:
        """Load the machine code for a signature; None if there is none."""
        try:
            return super().load_overload(sig, target_context)
        except OSError:  # there is nothing, or nothing to be read, which saving will tell
            return None
        except Exception as error:  # unpickling what is damaged may raise anything
            _warn(f"machine code kept in {self._cache_path} is damaged ({_words(error)}), and is compiled again")
            return None

    def save_overload(self, sig: Any, data: Any) -> None:
        """Write machine code to disk."""
        try:
            try:
                super().save_overload(sig, data)
            except OSError:
                raise
            except Exception:  # the index of the files is damaged
                self.flush()
                super().save_overload(sig, data)
        except OSError as error:
            _warn(
                f"machine code cannot be kept in {self._cache_path} ({_words(error)}), and each program compiles it "
                "again; name another folder by the environment variable NUMBA_CACHE_DIR"
            )


def keep(made: Any, function: Any) -> None:
    """Keep the machine code of a function on disk.

    Args:
        made: The `Dispatcher` or `CFunc` that Numba will compile.
        function: The Python function.
    """
    made._cache = MachineCodeCache(function)


@lru_cache(maxsize=16)
def _warn(sentence: str) -> None:
    """Warn once."""
    warnings.warn(sentence, stacklevel=2)


def _words(error: Exception) -> str:
    return f"{type(error).__name__}: {error}".splitlines()[0].rstrip(": ")
