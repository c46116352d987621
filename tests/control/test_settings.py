"""Settings of a controller's dataclass: each takes values of its type, as texts of the command line too."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Any, Literal

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from mjbiped.control.loading import REQUIRED, checked, fields_of, shown_defaults, value_of
from mjbiped.errors import InputError


@dataclass
class Made:
    needed: float
    gain: float = 1.0
    count: int = 2
    on: bool = True
    mode: str = "soft"
    delay: float | None = 0.8
    kind: Literal["a", "b"] = "a"
    table: tuple[float, ...] = (1.0,)
    anything: Any = None
    made: list[float] = field(default_factory=list)
    inner: float = field(default=0.0, init=False)


def test_fields_and_their_defaults() -> None:
    fields = fields_of(Made)
    assert "inner" not in fields
    assert fields["needed"] is REQUIRED
    assert fields["made"] == []
    assert shown_defaults({"needed": REQUIRED, "gain": 1.0}) == "needed (needed), gain=1.0"


@pytest.mark.parametrize(
    ("name", "text", "value"),
    [
        ("gain", "3", 3.0),
        ("gain", " -2e-3 ", -2e-3),
        ("count", "3", 3),
        ("on", "false", False),
        ("on", "True", True),
        ("mode", "5", "5"),
        ("mode", "none", "none"),
        ("delay", "none", None),
        ("delay", "0.5", 0.5),
        ("kind", "b", "b"),
        ("anything", "7", 7),
        ("anything", "word", "word"),
    ],
)
def test_a_text_is_read_as_its_field_has_it(name: str, text: str, value: object) -> None:
    found = value_of(Made, name, text)
    assert (type(found), found) == (type(value), value)


@pytest.mark.parametrize(
    ("name", "text", "words"),
    [
        ("gain", "much", "gain = 'much': must be a finite number, as a field of Made"),
        ("gain", "nan", "a finite number"),
        ("gain", "true", "a finite number"),
        ("gain", "none", "a finite number"),
        ("count", "2.5", "a whole number"),
        ("on", "1", "true or false"),
        ("delay", "soon", "a finite number or none"),
        ("kind", "c", "one of a, b"),
        ("table", "1", "which cannot be given here"),
    ],
)
def test_a_text_of_another_type_is_refused(name: str, text: str, words: str) -> None:
    with pytest.raises(InputError, match=words):
        value_of(Made, name, text)


@given(st.floats(allow_nan=False, allow_infinity=False))
def test_every_number_comes_through_its_text(number: float) -> None:
    assert value_of(Made, "gain", repr(number)) == number


def test_numbers_of_numpy_are_numbers() -> None:
    assert checked(Made, "gain", np.float32(0.5)) == 0.5
    assert checked(Made, "count", np.int64(3)) == 3


def test_a_number_is_no_truth_value() -> None:
    for name in ("gain", "count"):
        with pytest.raises(InputError):
            checked(Made, name, True)


def test_types_that_only_a_type_checker_knows_are_not_checked() -> None:
    class Odd:
        gain: "Unknown"  # type: ignore[name-defined]  # noqa: F821, UP037

    assert checked(Odd, "gain", "anything") == "anything"
