"""How a user's value is repeated in messages."""

from typing import Any

import pytest
from hypothesis import given
from hypothesis import strategies as st

from mjbiped.errors import LONGEST_SHOWN, shown


class NoRepr:
    def __repr__(self) -> str:
        raise RuntimeError("no repr")


def nested(depth: int) -> list[Any]:
    value: list[Any] = []
    for _ in range(depth):
        value = [value]
    return value


@given(st.none() | st.integers(-(10**30), 10**30) | st.text(max_size=20) | st.lists(st.floats(), max_size=3))
def test_short_values_are_shown_whole(value: object) -> None:
    assert shown(value) == repr(value) or len(repr(value)) > LONGEST_SHOWN


@pytest.mark.parametrize(
    ("value", "beginning", "end"),
    [
        ("begin" + "x" * 5000 + "end", "'begin", "end'"),
        (10**5000, "<a whole number of about 5001 digits>", ""),
        (nested(100_000), "[[[", "]"),
        ({str(k): "x" * 100 for k in range(100)}, "{'0': ", "}"),
        ([NoRepr()], "[<an object of type NoRepr>", "]"),
        ("\ud800" * 100, "'", "'"),
    ],
    ids=lambda value: type(value).__name__,
)
def test_anything_is_shown_on_one_short_line(value: object, beginning: str, end: str) -> None:
    text = shown(value)
    assert 0 < len(text) <= LONGEST_SHOWN
    assert text.isprintable()
    assert (text[: len(beginning)], text[len(text) - len(end) :]) == (beginning, end)
