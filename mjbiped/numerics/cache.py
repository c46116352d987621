"""Machine code on disk, made once: Numba's cache, which here tolerates damaged files.

Files are kept beside this one if its folder is writable, otherwise in the user's cache, or in the folder that the
environment variable NUMBA_CACHE_DIR names. Each is written completely before it gets its name, so that processes may
start at the same time. A file that is damaged, or cannot be read or written, costs time and a warning, no more.

This module imports Numba: import it where something is compiled, not before.
"""

from __future__ import annotations

import hashlib
import importlib
import pickle
import warnings
from functools import lru_cache
from pathlib import Path
from types import FunctionType
from typing import Any

caching: Any = importlib.import_module("numba.core.caching")  # Numba has no types

_DIGEST = hashlib.sha256().digest_size


class _Files(caching.IndexDataCacheFile):  # type: ignore[misc]  # Numba has no types
    """The files of one function; a digest precedes the machine code."""

    def _load_data(self, name: str) -> Any:
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

    def __init__(self, function: Any) -> None:
        """Find the folder, always from this module's place.

        Raises:
            RuntimeError: No folder is writable.
        """
        here = function.__code__.replace(co_filename=__file__)
        super().__init__(FunctionType(here, {"__name__": __name__}, function.__name__, None, function.__closure__))
        locator, name = self._impl.locator, self._impl.filename_base
        self._cache_file = _Files(self._cache_path, name, locator.get_source_stamp())

    def load_overload(self, sig: Any, target_context: Any) -> Any:
        """Load the machine code for a signature; None if there is none."""
        try:
            return super().load_overload(sig, target_context)
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
            _warn(f"machine code cannot be kept in {self._cache_path} ({_words(error)}), and will be compiled again")


def keep(made: Any, function: Any) -> None:
    """Keep the machine code of a function on disk.

    Args:
        made: The `Dispatcher` or `CFunc` that Numba will compile.
        function: The Python function.
    """
    try:
        made._cache = MachineCodeCache(function)
    except RuntimeError:
        _warn(
            "machine code cannot be kept, for no folder can be written to, and each program compiles it again; name a "
            "folder by the environment variable NUMBA_CACHE_DIR"
        )


@lru_cache(maxsize=16)
def _warn(sentence: str) -> None:
    """Warn once."""
    warnings.warn(sentence, stacklevel=2)


def _words(error: Exception) -> str:
    return f"{type(error).__name__}: {error}".splitlines()[0].rstrip(": ")
