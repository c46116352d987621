"""Blocks of numbers for machine code: what has to live as long as a copy, and what is shared."""

from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np
import pytest

from mjbiped.numerics import blocks
from mjbiped.numerics.blocks import Floats, packed


class Part(NamedTuple):
    weight: float
    length: int
    values: Floats


def test_a_list_has_to_live_as_long_as_its_copy() -> None:
    """An array is not copied: it is what machine code writes into."""
    array = np.zeros(2)
    block, kept = packed(Part(1.0, 2, array))
    assert block["values"][0] == array.ctypes.data
    assert any(each is array for each in kept)
    with pytest.raises((TypeError, ValueError)):
        packed(Part("a", 2, []))  # type: ignore[arg-type]


def test_lists_of_floats_are_shared_as_arrays() -> None:
    @dataclass
    class Some:
        table: Any
        empty: Any
        parts: Any
        number: float

    part = Part(1.0, 2, [])
    some = Some([[1.0, 2.0]], [], [part], 3.0)
    blocks.share_arrays(some)
    assert isinstance(some.table, np.ndarray)
    assert (some.table.tolist(), some.empty, some.parts, some.number) == ([[1.0, 2.0]], [], [part], 3.0)
