"""Sums over many numbers are what they were."""

import pytest
from golden_numbers import CASES, ELSEWHERE, check

LONG = ("placed feet in space in hybrid", "hybrid within kneed on soles bounded-ankle mixed")
"""Seconds each, of what others have parts of."""


@pytest.mark.parametrize(
    "case",
    [pytest.param(case, marks=pytest.mark.slow if case in LONG else ()) for case in CASES if case not in ELSEWHERE],
)
def test_numbers_are_what_they_were(case: str) -> None:
    check(case)
