"""What a study file says of a quantity: read as meant, drawn as said, or refused in words."""

import math
from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy import stats

from mjbiped.errors import InputError
from mjbiped.utils.draws import Draw, generator, read_choice


@pytest.mark.parametrize(
    ("value", "choice"),
    [
        ([0.5, "none", 1, True], (0.5, "none", 1, True)),
        ({"from": 0, "to": 4, "count": 5}, (0, 1, 2, 3, 4)),
        ({"from": 1, "to": 100, "count": 3, "scale": "log"}, (1.0, 10.0, 100.0)),
        ({"log_uniform": [0.1, 10]}, (Draw("log_uniform", 0.1, 10.0),)),
    ],
)
def test_read_as_meant(value: Any, choice: tuple[object, ...]) -> None:
    read = read_choice("x", value)
    assert read == choice
    assert [type(each) for each in read] == [type(each) for each in choice]


@pytest.mark.parametrize(
    ("value", "words"),
    [
        ([], "at least one value"),
        ([1, 2, 1], "each of them once"),
        (math.nan, "terrain.rise = nan: must be finite"),
        ({"from": 1, "to": 2, "count": 1}, "count = 1: must be a whole number from 2"),
        ({"uniform": [1, 0]}, "lower end first"),
        ({"integer": [0, 2**62 + 1]}, "greatest = .*to 9007199254740992"),
    ],
)
def test_refused_in_words(value: object, words: str) -> None:
    with pytest.raises(InputError, match=words) as refused:
        read_choice("terrain.rise", value)
    assert "terrain.rise" in str(refused.value)


@given(st.floats(1e-3, 1e3), st.floats(1.001, 1e3), st.integers(2, 40), st.sampled_from(["linear", "log"]))
def test_range_is_even_and_ends_where_it_says(first: float, ratio: float, count: int, scale: str) -> None:
    last = first * ratio
    values = read_choice("x", {"from": first, "to": last, "count": count, "scale": scale})
    assert (values[0], values[-1], len(values)) == (first, last, count)
    even = np.log(np.array(values, dtype=float)) if scale == "log" else np.array(values, dtype=float)
    # inner values are rounded to 12 digits: by half of 1e-11 of themselves at most, each
    assert np.diff(even) == pytest.approx((even[-1] - even[0]) / (count - 1), abs=1.1e-11 * max(1.0, abs(even).max()))


@pytest.mark.parametrize(
    ("draw", "expected"),
    [
        (Draw("uniform", -1.0, 3.0), stats.uniform(-1.0, 4.0)),
        (Draw("log_uniform", 0.01, 10.0), stats.loguniform(0.01, 10.0)),
        (Draw("normal", 2.0, 0.5), stats.norm(2.0, 0.5)),
    ],
)
def test_draws_have_their_distribution(draw: Draw, expected: Any) -> None:
    values = np.array([draw.value(generator(1, sample, "x")) for sample in range(2000)], dtype=float)
    # the draws are seeded: this is one number, below 0.001 once in a thousand seeds
    assert stats.kstest(values, expected.cdf).pvalue > 1e-3
    assert {Draw("integer", 2.0, 4.0).value(generator(0, sample, "x")) for sample in range(200)} == {2, 3, 4}


def test_draw_depends_on_seed_sample_and_name_alone() -> None:
    draw = Draw("uniform", 0.0, 1.0)
    values = [draw.value(generator(*key)) for key in ((0, 0, "x"), (1, 0, "x"), (0, 1, "x"), (0, 0, "y"))]
    assert len(set(values)) == 4
    assert draw.value(generator(0, 0, "x")) == values[0]
    # the same in every version of this package: old tables can be made again
    assert values[0] == 0.5453545852147507
