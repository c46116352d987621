"""How a user's value is repeated in messages."""

import fractions
from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from mjbiped.errors import LONGEST_SHOWN, shown


class NoRepr:
    def __repr__(self) -> str:
        raise RuntimeError("no repr")


class NoReprList(list[int]):
    def __repr__(self) -> str:
        raise RuntimeError("no repr")


def nested(depth: int) -> list[Any]:
    value: list[Any] = []
    for _ in range(depth):
        value = [value]
    return value


@given(st.none() | st.booleans() | st.integers(-(10**30), 10**30) | st.floats() | st.text(max_size=20))
def test_short_values_are_shown_whole(value: object) -> None:
    assert shown(value) == repr(value) or len(repr(value)) > LONGEST_SHOWN


def test_short_containers_are_shown_whole() -> None:
    for value in ((0.1, None), [1, "two"], {"slope": 2.0, "x": (0.0, 1.0)}, np.float64(0.5)):
        assert shown(value) == repr(value)


def test_long_text_keeps_both_ends() -> None:
    text = shown("begin" + "x" * 5000 + "end")
    assert text.startswith("'begin")
    assert text.endswith("end'")
    assert "..." in text


@pytest.mark.parametrize(
    "value",
    [
        10**5000,
        -(10**10**5),
        fractions.Fraction(10**5000, 3),
        "\n" * 400,
        b"\0" * 400,
        [10**200] * 200,
        nested(100_000),
        {str(k): "x" * 100 for k in range(100)},
        np.zeros((1000, 4)),
        np.array([object()] * 10, dtype=object),
        NoRepr(),
        [NoRepr()],
        NoReprList(range(5)),
        type("str", (NoRepr,), {})(),
        "\ud800" * 100,
    ],
    ids=lambda value: type(value).__name__,
)
def test_anything_is_shown_on_one_short_line(value: object) -> None:
    text = shown(value)
    assert 0 < len(text) <= LONGEST_SHOWN
    assert text.isprintable()


def test_a_number_too_long_to_write_out_is_measured() -> None:
    assert shown(10**5000) == "<a whole number of about 5001 digits>"
