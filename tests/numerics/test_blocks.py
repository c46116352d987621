"""Blocks of numbers: machine code sees what Python sees."""

import ctypes
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np
import pytest

from mjbiped.numerics import blocks
from mjbiped.numerics.blocks import Floats, numbers, octets, packed, reader, whole_numbers


class Part(NamedTuple):
    weight: float
    length: int
    values: Floats


class Memory(ctypes.Structure):
    first: float
    pair: Any


Memory._fields_ = [("first", ctypes.c_double), ("pair", ctypes.c_double * 2)]


@dataclass(slots=True)
class Whole:
    factor: float
    number: int
    yes: bool
    no: bool
    values: Floats
    shared: Any
    integers: Any
    bytes: Any
    parts: Sequence[Part]
    part_count: int
    memory: Any


whole_at, part_at, memory_at = reader(Whole), reader(Part), reader(Memory)


def seen(c: Any, out: Any) -> None:
    """Write all that a block tells, and change what is shared."""
    m = memory_at(c.memory, 0)
    out[0], out[1] = c.factor, float(c.number)
    out[2], out[3] = 1.0 if c.yes else 0.0, 1.0 if c.no else 0.0
    out[4], out[5] = numbers(c.values, 3)[2], m.first + m.pair[1]
    out[6], out[7] = float(whole_numbers(c.integers, 2)[1]), float(octets(c.bytes, 2)[1])
    at = 8
    for index in range(c.part_count):
        part = part_at(c.parts, index)
        out[at], at = part.weight, at + 1
        for each in range(part.length):
            out[at], at = numbers(part.values, part.length)[each], at + 1
    shared = numbers(c.shared, 2)
    shared[0], shared[1] = shared[1], shared[0] + 0.5
    m.pair[0] = m.first - 1.0


def seen_by_address(block: int, out: int) -> None:
    seen(whole_at(block, 0), numbers(out, 16))


def test_machine_code_sees_the_same_numbers_and_shares_arrays() -> None:
    from mjbiped.numerics import machine

    found = []
    for compiled in (False, True):
        memory: Any = np.array([0.1, 0.0, 1 / 3])
        whole = Whole(
            factor=-0.1,
            number=-(1 << 40),
            yes=True,
            no=False,
            values=[1.5, 2.5, 1e300],
            shared=np.array([1.0, 2.0]),
            integers=np.array([7, -8], dtype=np.int32),
            bytes=np.array([0, 255], dtype=np.uint8),
            parts=[Part(0.5, 2, [1.0, 2.0]), Part(1 / 3, 3, np.array([3.0, 4.0, 5.0]).tolist()), Part(9.0, 0, [])],
            part_count=3,
            memory=[Memory.from_buffer(memory)],
        )
        out = np.full(16, np.nan)
        if compiled:
            whole.memory = memory
            block, kept = packed(whole)
            assert kept
            run = machine.compiled(seen_by_address, "void(int64, int64)")
            run(block.ctypes.data, out.ctypes.data)
        else:
            seen(whole, out)
        found.append((out.tobytes(), whole.shared.tolist(), memory.tolist()))
    assert found[0] == found[1]
    assert found[0][1:] == ([2.0, 1.5], [0.1, -0.9, 1 / 3])


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
