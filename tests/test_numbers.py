"""Sums over many numbers are what they were."""

import pytest
from golden_numbers import CASES, ELSEWHERE, check


@pytest.mark.parametrize("case", [case for case in CASES if case not in ELSEWHERE])
def test_numbers_are_what_they_were(case: str) -> None:
    check(case)
