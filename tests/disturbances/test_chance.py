"""Random numbers by their places."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy import stats

from mjbiped.disturbances import chance

COUNT = 20_000


def test_the_hash_is_murmurhash3s_of_words() -> None:
    """fmix32 as a program of another's computes it: Python's whole numbers do not overflow."""
    for x in (0, 1, 0xDEADBEEF, 0xFFFFFFFF, 12345):
        for factor in (0x85EBCA6B, 0xC2B2AE35):
            assert chance._product(x, factor) == x * factor % 2**32


@given(st.integers(0, 2**64 - 1), st.integers(0, 2**53), st.integers(0, 100))
def test_numbers_are_between_zero_and_one(seed: int, number: int, channel: int) -> None:
    assert 0.0 < chance.uniform(chance.words_of(seed), number, channel) < 1.0


@pytest.mark.parametrize("seed", [0, 1, 2**63 + 5])
def test_they_are_distributed_as_they_say(seed: int) -> None:
    """Kolmogorov and Smirnov's test, by scipy; a sound generator fails one in 10^4 of these, and none of three here."""
    words = chance.words_of(seed)
    uniform = [chance.uniform(words, number, 7) for number in range(COUNT)]
    normal = np.array([chance.normal(words, number, 3) for number in range(COUNT)])
    assert stats.kstest(uniform, "uniform").pvalue > 1e-4
    assert stats.kstest(normal, "norm").pvalue > 1e-4
    other = np.array([chance.normal(words, number, 4) for number in range(COUNT)])
    four = 4.0 / math.sqrt(COUNT)  # deviations of a correlation of independent numbers
    for a, b in ((normal[1:], normal[:-1]), (normal, other)):
        assert abs(np.corrcoef(a, b)[0, 1]) < four


def normal(low: int, high: int, number: int, channel: int) -> float:
    return chance.normal(chance.Seed(low, high), number, channel)


def test_compiled_they_are_the_same() -> None:
    from mjbiped.numerics.machine import compiled

    asked = compiled(normal, "float64(int64, int64, int64, int64)")
    for seed in (0, 2**64 - 1, 987654321987):
        for number in (0, 1, 2**31, 2**40 + 3):
            words = chance.words_of(seed)
            assert asked(*words, number, 3) == chance.normal(words, number, 3)
