"""Packed values as compiled code reads them; see `mjbiped.numerics.records.Packer`."""

from __future__ import annotations

from functools import lru_cache, partial
from typing import Any

from mjbiped.numerics.jit import CALLED_WITHIN, from_source, jitted


@lru_cache(maxsize=256)
def unpacking(made: str, classes: tuple[tuple[str, type], ...]) -> Any:
    """Compile the function that reads packed values from the address of their record; see `Packer`."""
    from mjbiped.numerics import addresses

    source = f"""def parameters(record):
    p = numbers(record, {made.count("p[") + 1})
    return {made}
"""
    space = {"numbers": addresses.numbers, "array": addresses.array, **dict(classes)}
    kinds = [(kind.__module__, kind.__qualname__, getattr(kind, "_fields", ())) for _, kind in classes]
    return from_source(partial(jitted, **CALLED_WITHIN), "parameters", source, space, kinds)
