"""Random numbers from a seed and an index: the same in Python and compiled, in any thread, in whatever order.

Each number is a hash of its seed and of the two numbers that say where it stands (which tick, which sensor), so that
there is no generator whose state would have to be kept. The hash is MurmurHash3's (A. Appleby, public domain), on words
of 32 bits: products are made in halves, for Python's whole numbers never overflow and compiled ones do.
"""

from __future__ import annotations

import math
from typing import Any, NamedTuple

_WORD = 0xFFFFFFFF
_HALF = 0xFFFF
_SPREAD = 0x9E3779B9  # an odd number without pattern: 2^32 over the golden ratio


class Seed(NamedTuple):
    """A seed as two words of 32 bits; blocks of numbers that have these two fields serve as well."""

    seed_low: int
    seed_high: int


def words_of(seed: int) -> Seed:
    """A seed from 0 to 2^64 - 1 as two words."""
    return Seed(seed & _WORD, seed >> 32)


def uniform(seed: Any, number: int, channel: int) -> float:
    """A uniformly distributed number between 0 and 1, both ends excluded.

    Args:
        seed: `Seed` of the walk.
        number: Index in the channel, from 0 on.
        channel: Numbers of different channels are independent.
    """
    found = _mixed(_mixed(_mixed(_mixed(seed.seed_low, seed.seed_high), channel), number & _WORD), number >> 32)
    return (found + 0.5) / 4294967296.0


def normal(seed: object, number: int, channel: int) -> float:
    """A normally distributed number of mean 0 and deviation 1 (Box and Muller), from two channels of `uniform`."""
    radius = math.sqrt(-2.0 * math.log(uniform(seed, number, 2 * channel)))
    return radius * math.cos(2.0 * math.pi * uniform(seed, number, 2 * channel + 1))


def _mixed(before: int, word: int) -> int:
    """Hash two words of 32 bits into one that depends on all their bits."""
    x = (before ^ word) + _SPREAD & _WORD
    x = _product(x ^ x >> 16, 0x85EBCA6B)
    x = _product(x ^ x >> 13, 0xC2B2AE35)
    return x ^ x >> 16


def _product(x: int, factor: int) -> int:
    """The low 32 bits of a product, computed without exceeding 64 bits."""
    return (x & _HALF) * factor + (((x >> 16) * factor & _HALF) << 16) & _WORD
