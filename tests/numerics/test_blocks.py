"""Blocks of numbers for machine code: what has to live as long as a copy."""

from typing import NamedTuple

import numpy as np
import pytest

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
